//! The same mounting in the senses of other software.
//!
//! Ours: body x right, y forward, z up; `R = Rz(-heading) Rx(pitch) Ry(roll)`; roll positive starboard down, pitch bow up, heading
//! clockwise. In forward-right-down axes the same three numbers are `Rz(heading) Ry(pitch) Rx(roll)`, which is why most tables below
//! repeat them. Every entry names the public document that settles it; what none settles is left out and said to be.

use crate::math;
use crate::results::{
    Convention, ConventionField as Field, MountingAngles, MountingResult, Solutions,
};

/// The deciding solution's mountings in other programs' senses, where they may be used.
#[must_use]
pub fn deciding(solutions: &Solutions, usable: bool) -> Vec<Convention> {
    let deciding = solutions.deciding().filter(|_| usable);
    let mountings = deciding.map_or(&[][..], |s| &s.mountings);
    mountings.iter().flat_map(conventions).collect()
}

/// What two arrays' records have and one mounting has not.
const EACH_ARRAY: &str = "Two records, one for each array, both moved by the one correction that was found: a transmit array's roll and a \
                          receive array's pitch are carried along and move no sounding.";

/// The mounting in the senses of the five makers' programs, of two arrays each of them; empty without a lever arm.
#[must_use]
pub fn conventions(mounting: &MountingResult) -> Vec<Convention> {
    if mounting.arrays.is_empty() {
        return of_one(mounting);
    }
    let each = |array: &MountingResult| {
        let named = |entry: Convention| Convention {
            mounting: format!("{}, {}", mounting.name, array.name),
            remark: format!("{} {EACH_ARRAY}", entry.remark),
            ..entry
        };
        of_one(array).into_iter().map(named).collect::<Vec<_>>()
    };
    mounting.arrays.iter().flat_map(each).collect()
}

fn of_one(mounting: &MountingResult) -> Vec<Convention> {
    let (angles, Some(lever)) = (mounting.mounting_deg, mounting.lever_arm_m) else {
        return Vec::new();
    };
    let tables = [
        caris(lever),
        qps(angles, lever),
        kongsberg(angles, lever),
        applanix(angles, lever),
        novatel(angles, lever),
    ];
    let owned = |t: Table| t.of(&mounting.name);
    tables.into_iter().map(owned).collect()
}

/// One program's table as it is written down here.
struct Table {
    software: &'static str,
    axes: &'static str,
    lever_arm_m: [Field; 3],
    angles_deg: [Field; 3],
    remark: &'static str,
    sources: &'static [&'static str],
}

impl Table {
    fn of(self, mounting: &str) -> Convention {
        Convention {
            mounting: mounting.to_owned(),
            software: self.software.to_owned(),
            axes: self.axes.to_owned(),
            lever_arm_m: self.lever_arm_m.into(),
            angles_deg: self.angles_deg.into(),
            remark: self.remark.to_owned(),
            sources: self.sources.iter().map(|s| (*s).to_owned()).collect(),
        }
    }
}

fn field(name: &str, value: f64, positive: &str) -> Field {
    Field {
        name: name.to_owned(),
        value: Some(value),
        positive: positive.to_owned(),
    }
}

fn unsettled(name: &str, positive: &str) -> Field {
    Field {
        name: name.to_owned(),
        value: None,
        positive: positive.to_owned(),
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

fn caris([x, y, z]: [f64; 3]) -> Table {
    Table {
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

fn qps(m: MountingAngles, lever: [f64; 3]) -> Table {
    Table {
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
fn kongsberg(m: MountingAngles, lever: [f64; 3]) -> Table {
    let slope =
        math::asin(math::sin(m.roll.to_radians()) * math::cos(m.pitch.to_radians())).to_degrees();
    let roll = if m.roll.abs() <= 90.0 {
        field("Roll", slope, "starboard lower")
    } else {
        unsettled("Roll", "starboard lower")
    };
    Table {
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

fn applanix(m: MountingAngles, lever: [f64; 3]) -> Table {
    Table {
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

fn novatel(m: MountingAngles, lever: [f64; 3]) -> Table {
    Table {
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
        let angles = [TILTED.roll, TILTED.pitch, TILTED.heading].map(f64::to_radians);
        let found = crate::geometry::rotation::from_attitude(angles[0], angles[1], angles[2]);
        let mounted = crate::calibrate::solution::Mounted {
            name: "multibeam",
            rotation: (&found, &Matrix3::identity()),
            lever_arm_m: Some((LEVER.into(), Vector3::zeros())),
            covariance: None,
            arrays: None,
        };
        conventions(&mounted.result())
    }

    fn about(axis: Vector3<f64>, angle_deg: f64) -> Matrix3<f64> {
        *Rotation3::new(axis * angle_deg.to_radians()).matrix()
    }

    fn ours() -> Matrix3<f64> {
        about(Vector3::z(), -TILTED.heading)
            * about(Vector3::x(), TILTED.pitch)
            * about(Vector3::y(), TILTED.roll)
    }

    fn values(fields: &[Field]) -> [f64; 3] {
        std::array::from_fn(|i| fields[i].value.unwrap())
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
            (-right.z - math::sin(roll)).abs() < 1e-14,
            "starboard end lower is positive"
        );
        assert!(
            (forward.z - math::sin(pitch)).abs() < 1e-14,
            "forward end up is positive"
        );
        assert!(
            (math::atan2(forward.x, forward.y) - heading).abs() < 1e-14,
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
