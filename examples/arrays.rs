//! A pool calibration from arrays, without any file.
//!
//! `cargo run --release --example arrays`
//!
//! The arrays come from the simulator here, so that the answer is known; yours come from wherever your data are.

use boresight::prelude::*;
use boresight::simulate::{DEMO, Scenario, simulate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scenario = Scenario::from_toml(DEMO)?;
    (scenario.multibeam.beams, scenario.lidar.points_per_line) = (64, 100); // thinned, to be quick
    let survey = simulate(&scenario, 1)?;
    let campaign = from_arrays(&survey.campaign);
    let found = boresight::calibrate_arrays(&campaign, &survey.target, &survey.prior)?;
    if let Some(refusal) = &found.refusal {
        return Err(refusal.to_string().into());
    }
    let joint = found.joint.ok_or("the joint path did not run")?;
    let truth = survey.truth.lever_arm();
    println!("lever arm      right  forward       up, metres");
    for (name, arm) in [
        ("nominal", campaign.sonar.lever_arm_m),
        ("found", joint.mounting.lever_arm_m),
        ("true", truth),
    ] {
        println!("{name:8} {:>11.4} {:>8.4} {:>8.4}", arm.x, arm.y, arm.z);
    }
    let sigma = joint.covariance.diagonal().map(f64::sqrt);
    println!(
        "{:8} {:>11.4} {:>8.4} {:>8.4}",
        "sigma", sigma[3], sigma[4], sigma[5]
    );
    Ok(())
}

/// The same observations, built from nothing but columns of numbers.
fn from_arrays(given: &Campaign) -> Campaign {
    let (t, l, s) = (&given.trajectory, &given.laser, &given.soundings);
    let three = |a: &[f64], b: &[f64], c: &[f64]| -> Vec<[f64; 3]> {
        a.iter()
            .zip(b)
            .zip(c)
            .map(|((a, b), c)| [*a, *b, *c])
            .collect()
    };
    let trajectory = GeodeticTrajectory::from_arrays(
        t.time_s.clone(),
        three(&t.latitude_rad, &t.longitude_rad, &t.height_m),
        three(&t.roll_rad, &t.pitch_rad, &t.heading_rad),
    );
    let laser = LaserScan::from_arrays(l.time_s.clone(), three(&l.x_m, &l.y_m, &l.z_m));
    let range_m = s.range.values().to_vec();
    let soundings = Soundings::from_arrays(s.time_s.clone(), s.across_rad.clone(), range_m);
    Campaign {
        scanner_sigma: given.scanner_sigma, // how well the scanner's mounting is known
        ..Campaign::new(trajectory, (given.scanner, laser), (given.sonar, soundings))
    }
}
