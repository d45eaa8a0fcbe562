//! Soundings of a transmit and a receive array: cast from where the sound is sent, heard where the boat is by then.

use nalgebra::{Matrix3, Vector3};

use super::super::scene::Line;
use super::super::survey::{SeabedScenario, TwoArrays};
use super::bed::Seabed;
use super::{Beams, Boat, OfHead, Shot, normal, spoil, strike};
use crate::math;
use crate::observe::ArrayMountings;
use crate::stats::stream;

/// What a beam is: whose line, when it is sent, where it looks.
struct Sent<'a> {
    number: usize,
    line: &'a Line,
    time_s: f64,
    tilt_rad: f64,
    across_rad: f64,
}

/// All soundings of a head.
pub(super) fn shots(
    scenario: &SeabedScenario,
    (boat, lines): (&Boat<'_>, &[Line]),
    (two, arrays, of_head): (&TwoArrays, &ArrayMountings, &OfHead),
    beams: &mut Beams<'_>,
    seed: u64,
) -> Vec<Shot> {
    let m = &scenario.multibeam;
    let mut draws = stream(seed, of_head.draws);
    let sectors = two.sectors();
    let (mut all, mut ping) = (vec![], 0);
    for (number, line) in lines.iter().enumerate() {
        let count = ((line.end_s - line.start_s) * m.ping_rate_hz) as u32;
        for k in 0..count {
            // pings drift against the INS's records; recorders write milliseconds
            let time_s = line.start_s + (f64::from(k) + 0.37) / m.ping_rate_hz * 0.9999;
            let time_s = (1e3 * time_s).round() / 1e3;
            for beam in 0..m.beams {
                let part = f64::from(beam) / f64::from((m.beams - 1).max(1));
                let sector = sectors.of_beam(part);
                let (tilt_rad, delay_s) = sectors.sector(sector);
                let sent = Sent {
                    number,
                    line,
                    time_s: time_s + delay_s,
                    tilt_rad,
                    across_rad: (2.0 * part - 1.0) * m.half_swath_deg.to_radians(),
                };
                let way = |bed: &Seabed| heard(scenario, boat, bed, arrays, &sent);
                let Some((angle_rad, length_m)) = beams.next(way) else {
                    continue;
                };
                let outward = sent.across_rad.abs() / 60f64.to_radians();
                let sigma =
                    m.angle_sigma_deg.to_radians() * (1.0 + m.angle_sigma_growth * outward.powi(3));
                let measured_m = length_m / (1.0 + scenario.errors.range_scale)
                    + 2.0 * normal(&mut draws, m.range_sigma_m);
                all.push(Shot {
                    time_s: time_s + of_head.latency_s,
                    ping,
                    beam,
                    head: of_head.head,
                    across_rad: angle_rad + normal(&mut draws, sigma),
                    tilt_rad,
                    delay_s,
                    sector,
                    two_way_s: measured_m / scenario.sound_speed_m_s,
                    gross: false,
                });
            }
            ping += 1;
        }
    }
    spoil(&mut all, scenario.errors.gross, m.beams, &mut draws);
    all
}

/// Angle against the receive array and length of the way there and back; `None` where the sound meets no bed.
fn heard(
    scenario: &SeabedScenario,
    boat: &Boat<'_>,
    bed: &Seabed,
    arrays: &ArrayMountings,
    sent: &Sent<'_>,
) -> Option<(f64, f64)> {
    let place = |time_s: f64, mounting: &crate::observe::Mounting| {
        let (position, attitude): (Vector3<f64>, Matrix3<f64>) =
            boat.pose(sent.number, sent.line, time_s);
        (
            position + attitude * mounting.lever_arm_m,
            attitude * mounting.rotation,
        )
    };
    let (from, sender) = place(sent.time_s, &arrays.transmitter);
    let ((sine, cosine), (across, down)) =
        (math::sin_cos(sent.tilt_rad), math::sin_cos(sent.across_rad));
    let direction = sender * Vector3::new(cosine * across, sine, -cosine * down);
    let out_m = strike(bed, &from, &direction)?;
    let point = from + direction * out_m;
    let mut length_m = 2.0 * out_m;
    let mut arrival = Vector3::zeros();
    for _ in 0..4 {
        let time_s = sent.time_s + length_m / scenario.sound_speed_m_s;
        let (to, receiver) = place(time_s, &arrays.receiver);
        let back = point - to;
        length_m = out_m + back.norm();
        arrival = receiver.tr_mul(&back.normalize());
    }
    Some((math::asin(arrival.x), length_m))
}

#[cfg(test)]
mod tests {
    use super::super::super::model::{Locator, Values};
    use super::super::super::states::States;
    use super::super::super::survey::{parse_scenario, write};
    use super::super::{Acts, simulate};
    use super::*;

    const ARRAYS: &str = "mounting_deg = { roll = -0.8, pitch = 1.1, heading = 0.3 }
arrays = { receiver_mounting_deg = { roll = 1.5, pitch = -0.4, heading = 0.6 }, receiver_offset_m = [0.1, -0.25, 0.02], sectors = 3, sector_tilt_deg = 1.5, sector_delay_s = 0.004 }";

    fn scenario() -> SeabedScenario {
        let thin = include_str!("../../../../models/scenarios/seabed-thin.toml");
        let text = thin.replace(
            "mounting_deg = { roll = 0.0, pitch = 0.0, heading = 0.0 }",
            ARRAYS,
        );
        parse_scenario(std::path::Path::new("s.toml"), &text).expect("a scenario")
    }

    /// The calibration's equation puts the simulator's soundings on the bed at the true mounting, and off it at the nominal one.
    #[test]
    fn at_the_true_mounting_the_soundings_lie_on_the_bed() {
        let scenario = scenario();
        let survey = simulate(&scenario, 3, Acts::NONE);
        let file = write::survey_file(&scenario, &survey);
        let scene = write::scene(&file, &scenario, &survey);
        let states = States::new(&scene.lines, &scene.ins, &scene.drift);
        let bed = Seabed::of(&scenario, 3);
        let off_m = |values: &Values| {
            let locator = Locator::new(&scene, &states, values).expect("a profile");
            let numbers = (0..scene.soundings.len()).step_by(37);
            let points = numbers.filter_map(|k| Some(locator.locate(k)?.point_m));
            let off = points.map(|p| (p.z - bed.height_m(&p.xy())).abs());
            off.fold(0.0, f64::max)
        };
        let nominal = Values::nominal(&scene, &states);
        let truth = &survey.truth.rotation_matrix;
        let mut right = nominal.clone();
        right.mountings[0].rotation = Matrix3::from_fn(|i, j| truth[i][j]);
        right.latency_s = survey.truth.latency_s;
        let (true_m, nominal_m) = (off_m(&right), off_m(&nominal));
        assert!(true_m < 0.004 && nominal_m > 0.1, "{true_m} {nominal_m}");
    }
}
