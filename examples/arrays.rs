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
    let joint = found.solutions.joint.filter(|joint| joint.usable);
    let joint = joint.ok_or(found.reason.unwrap_or_default())?;
    println!("{:8} {:>12} {:>12} {:>10}", "", "before", "after", "sigma");
    for p in &joint.parameters {
        let shown = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.5}"));
        let (before, after, sigma) = (shown(p.nominal), shown(p.value), shown(p.sigma));
        println!(
            "{:8} {before:>12} {after:>12} {sigma:>10} {}",
            p.name, p.unit
        );
    }
    let arm = survey.truth.lever_arm();
    println!("true lever arm {:.4} {:.4} {:.4} m", arm.x, arm.y, arm.z);
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
        &three(&t.latitude_rad, &t.longitude_rad, &t.height_m),
        &three(&t.roll_rad, &t.pitch_rad, &t.heading_rad),
    );
    let laser = LaserScan::from_arrays(l.time_s.clone(), &three(&l.x_m, &l.y_m, &l.z_m));
    let range_m = s.range.values().to_vec();
    let soundings = Soundings::from_arrays(s.time_s.clone(), s.across_rad.clone(), range_m);
    Campaign {
        scanner_sigma: given.scanner_sigma, // how well the scanner's mounting is known
        ..Campaign::new(trajectory, (given.scanner, laser), (given.sonar, soundings))
    }
}
