//! The same mounting in the senses of other software.
//!
//! Ours: body x right, y forward, z up; `R = Rz(-heading) Rx(pitch) Ry(roll)`; roll positive starboard down, pitch bow up, heading
//! clockwise. In forward-right-down axes the same three numbers are `Rz(heading) Ry(pitch) Rx(roll)`, which is why most tables below
//! repeat them. Every entry names the public document that settles it; what none settles is left out and said to be.

use crate::results::{Estimate, MountingAngles};
use serde::Serialize;

/// One program's table entry.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Convention {
    /// Program and the place where the numbers go.
    pub software: &'static str,
    /// Its axes.
    pub axes: &'static str,
    /// Lever arm from the INS centre to the sonar, metres, by the program's field names.
    pub lever_arm_m: [Field; 3],
    /// Mounting angles, degrees, by the program's field names and in its order.
    pub angles_deg: [Field; 3],
    /// Signs and order of rotations, and what is left out.
    pub remark: &'static str,
    /// Public documents that settle it.
    pub sources: &'static [&'static str],
}

/// A number to type.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Field {
    /// The field's name in the program.
    pub name: &'static str,
    /// The number; `None` where no public document settles it.
    pub value: Option<f64>,
    /// Meaning of a positive value.
    pub positive: &'static str,
}

/// The mounting in the senses of the five makers' programs; empty without a mounting.
#[must_use]
pub fn conventions(estimate: &Estimate) -> Vec<Convention> {
    let (Some(mounting), Some(lever)) = (estimate.mounting_deg, estimate.lever_arm_m) else {
        return Vec::new();
    };
    vec![
        caris(lever),
        qps(mounting, lever),
        kongsberg(mounting, lever),
        applanix(mounting, lever),
        novatel(mounting, lever),
    ]
}

fn field(name: &'static str, value: f64, positive: &'static str) -> Field {
    Field {
        name,
        value: Some(value),
        positive,
    }
}

fn unsettled(name: &'static str, positive: &'static str) -> Field {
    Field {
        name,
        value: None,
        positive,
    }
}

fn right_forward_up([x, y, z]: [f64; 3]) -> [Field; 3] {
    [
        field("X", x, "starboard"),
        field("Y", y, "forward"),
        field("Z", z, "up"),
    ]
}

fn forward_right_down([x, y, z]: [f64; 3]) -> [Field; 3] {
    [
        field("X", y, "forward"),
        field("Y", x, "starboard"),
        field("Z", -z, "down"),
    ]
}

fn caris([x, y, z]: [f64; 3]) -> Convention {
    Convention {
        software: "Teledyne CARIS HIPS, vessel file (HVF), Swath/Transducer",
        axes: "X starboard, Y forward, Z down",
        lever_arm_m: [
            field("X", x, "starboard"),
            field("Y", y, "bow"),
            field("Z", -z, "into the water"),
        ],
        angles_deg: [
            unsettled("Pitch", "bow up"),
            unsettled("Roll", "starboard down"),
            unsettled("Yaw", "clockwise"),
        ],
        remark: "Signs of the three mounting angles as in this report (the signs of HIPS's recorded vessel roll and pitch are the opposite ones). \
                 Values left out: no public document found states the order of the rotations, and for a tilted head the order matters.",
        sources: &[
            "CARIS Vessel Editor 4.4.8 help, 'Transducer' (docs.caris.cloud)",
            "CARIS HIPS and SIPS 7.2 help, 'Vessel Coordinate System' and 'Transmitter, Receiver, and XYZ' (docs.caris.cloud)",
        ],
    }
}

fn qps(m: MountingAngles, lever: [f64; 3]) -> Convention {
    Convention {
        software: "QPS Qinsy / Qimera, multibeam system",
        axes: "X starboard, Y forward, Z up",
        lever_arm_m: right_forward_up(lever),
        angles_deg: [
            field("Heading", m.heading, "to starboard"),
            field("Pitch", m.pitch, "bow up"),
            field("Roll", m.roll, "heeling to starboard"),
        ],
        remark: "x' = H P R x: heading about Z, then pitch about the turned X, then roll about the turned Y, as in this report.",
        sources: &[
            "QPS, 'How-to Qinsy Sign Conventions' and 'How-to Qinsy Rotation Matrices' (confluence.qps.nl)",
            "QPS Qinsy, 'Nodes': X Offset, Y Offset (qpssoftware.scrollhelp.site)",
        ],
    }
}

/// Kongsberg measures roll as the slope of the array's own y axis, `sin(slope) = sin(roll) cos(pitch)`, not as the turn about the pitched
/// x axis.
fn kongsberg(m: MountingAngles, lever: [f64; 3]) -> Convention {
    let slope = (m.roll.to_radians().sin() * m.pitch.to_radians().cos())
        .asin()
        .to_degrees();
    let roll = if m.roll.abs() <= 90.0 {
        field("Roll", slope, "starboard lower")
    } else {
        unsettled("Roll", "starboard lower")
    };
    Convention {
        software: "Kongsberg SIS, installation parameters",
        axes: "X forward, Y starboard, Z down",
        lever_arm_m: forward_right_down(lever),
        angles_deg: [
            roll,
            field("Pitch", m.pitch, "forward end up"),
            field("Heading", m.heading, "clockwise"),
        ],
        remark: "Roll and pitch are the slopes of the array's own axes against the vessel's horizontal plane (EM 710 manual, 8.4.2), heading is \
                 that of its long side; with a pitch of zero roll is the same number as in this report. Left out when the head hangs over 90 deg.",
        sources: &[
            "Kongsberg EM datagrams on *.kmall format 410224, 'Coordinate systems' (kongsbergdiscovery.online)",
            "Kongsberg EM 710 installation manual 164851, 8.2 and 8.4",
        ],
    }
}

fn applanix(m: MountingAngles, lever: [f64; 3]) -> Convention {
    Convention {
        software: "Applanix POS MV, sensor 1 with respect to the reference frame",
        axes: "X forward, Y starboard, Z down",
        lever_arm_m: forward_right_down(lever),
        angles_deg: [
            field("X", m.roll, "port side higher"),
            field("Y", m.pitch, "bow higher"),
            field("Z", m.heading, "clockwise"),
        ],
        remark: "Tait-Bryan sequence: about z, then the turned y, then the twice turned x.",
        sources: &[
            "Applanix POS MV V4 User Guide, 2-40, 2-44, 2-49, 2-50; POS MV V5 Installation and Operation Guide, 2-27",
            "Applanix LVX User Manual (2021), 4.6.11, for the sequence",
        ],
    }
}

fn novatel(m: MountingAngles, lever: [f64; 3]) -> Convention {
    Convention {
        software: "NovAtel SPAN / Inertial Explorer, rotation from the INS body frame to the sonar",
        axes: "X right, Y forward, Z up",
        lever_arm_m: right_forward_up(lever),
        angles_deg: [
            field("X", m.pitch, "bow up"),
            field("Y", m.roll, "starboard down"),
            field("Z", -m.heading, "counter-clockwise"),
        ],
        remark: "Right-handed, applied in the order Z, X, Y from the body axes until they match the sonar's; written in the order X, Y, Z. SPAN's \
                 axes are those of this report.",
        sources: &[
            "NovAtel, 'Determining Rotations in SPAN & Inertial Explorer' (docs.novatel.com) and APN-065",
            "NovAtel SMART7 Installation and Operation User Manual, 4.2.3 and 4.3.2",
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Rotation3, Vector3};

    const TILTED: MountingAngles = MountingAngles {
        roll: -45.9,
        pitch: 7.0,
        heading: -12.0,
    };
    const LEVER: [f64; 3] = [0.58, -0.32, -1.55];

    fn table() -> Vec<Convention> {
        conventions(&Estimate {
            mounting_deg: Some(TILTED),
            lever_arm_m: Some(LEVER),
            ..Estimate::default()
        })
    }

    fn about(axis: Vector3<f64>, angle_deg: f64) -> Matrix3<f64> {
        *Rotation3::new(axis * angle_deg.to_radians()).matrix()
    }

    fn ours() -> Matrix3<f64> {
        about(Vector3::z(), -TILTED.heading)
            * about(Vector3::x(), TILTED.pitch)
            * about(Vector3::y(), TILTED.roll)
    }

    fn values(fields: &[Field; 3]) -> [f64; 3] {
        fields.map(|field| field.value.unwrap())
    }

    /// Forward-right-down from right-forward-up, its own inverse.
    fn swap() -> Matrix3<f64> {
        Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0)
    }

    #[test]
    fn applanix_angles_in_their_sequence_are_the_same_rotation() {
        let [x, y, z] = values(&table()[3].angles_deg);
        let theirs = about(Vector3::z(), z) * about(Vector3::y(), y) * about(Vector3::x(), x);
        assert!((swap() * theirs * swap() - ours()).norm() < 1e-14);
        assert_eq!(
            swap() * Vector3::from(values(&table()[3].lever_arm_m)),
            Vector3::from(LEVER)
        );
    }

    #[test]
    fn novatel_angles_in_their_sequence_are_the_same_rotation() {
        let [x, y, z] = values(&table()[4].angles_deg);
        assert!(
            (about(Vector3::z(), z) * about(Vector3::x(), x) * about(Vector3::y(), y) - ours())
                .norm()
                < 1e-14
        );
    }

    #[test]
    fn kongsberg_angles_are_the_slopes_of_the_axes() {
        let [roll, pitch, heading] = values(&table()[2].angles_deg).map(f64::to_radians);
        let (right, forward) = (ours().column(0).into_owned(), ours().column(1).into_owned());
        assert!(
            (-right.z - roll.sin()).abs() < 1e-14,
            "starboard end lower is positive"
        );
        assert!(
            (forward.z - pitch.sin()).abs() < 1e-14,
            "forward end up is positive"
        );
        assert!(
            (forward.x.atan2(forward.y) - heading).abs() < 1e-14,
            "clockwise from forward"
        );
    }

    #[test]
    fn what_no_document_settles_is_left_out() {
        assert!(
            table()[0]
                .angles_deg
                .iter()
                .all(|field| field.value.is_none())
        );
        assert!(table().iter().all(|entry| !entry.sources.is_empty()));
    }
}
