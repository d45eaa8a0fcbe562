//! The parameters that a survey has: a list made of its heads.
//!
//! The first head's own and what all heads share come first, in one fixed order; behind them stand the own parameters of each further head.
//! Latency, range scale, heave and the profile are common: they belong to the INS, the sounder's clock and the water. The first head's
//! lever arm upwards is inseparable from the heights of the lines and is no parameter; that of a further head is its height relative to the
//! first one's, which both see on the same seabed. Unknowns of the caller's own come last.

use std::sync::Arc;

use crate::observe::Extra;

/// What a parameter is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Turn of a head about the body's x axis, radians.
    Pitch,
    /// Turn of a head about the body's y axis, radians.
    Roll,
    /// Turn of a head about the body's z axis, radians.
    Yaw,
    /// Stamps of the soundings are late by this, seconds.
    Latency,
    /// True range over measured range, minus 1.
    RangeScale,
    /// True heave over measured heave, minus 1.
    HeaveScale,
    /// The heave channel is late by this, seconds.
    HeaveLag,
    /// Lever arm of a head to the right, metres.
    ArmRight,
    /// Lever arm of a head forward, metres.
    ArmForward,
    /// Lever arm of a further head upwards, relative to the first one's, metres.
    ArmUp,
    /// Relative error of the sound-speed profile at the reference depth.
    DeepSoundSpeed,
    /// An unknown of the caller's own, in its own unit.
    Own,
}

/// How many kinds there are that every survey has: all but [`Kind::Own`].
pub const KINDS: usize = 11;

impl Kind {
    /// Name and unit; an own unknown brings its own.
    const fn named(self) -> (&'static str, &'static str) {
        match self {
            Self::Pitch => ("pitch", "rad"),
            Self::Roll => ("roll", "rad"),
            Self::Yaw => ("yaw", "rad"),
            Self::Latency => ("latency", "s"),
            Self::RangeScale => ("range_scale", "1"),
            Self::HeaveScale => ("heave_scale", "1"),
            Self::HeaveLag => ("heave_lag", "s"),
            Self::ArmRight => ("lever_arm_x", "m"),
            Self::ArmForward => ("lever_arm_y", "m"),
            Self::ArmUp => ("lever_arm_z", "m"),
            Self::DeepSoundSpeed => ("deep_sound_speed", "1"),
            Self::Own => ("own", "1"),
        }
    }

    /// Whether it is one of a head's three angles.
    #[must_use]
    pub const fn is_angle(self) -> bool {
        matches!(self, Self::Pitch | Self::Roll | Self::Yaw)
    }

    /// Whether it may be reported as determined: a range scale, heave scale, heave lag, lever arm or profile error is one of the things
    /// that are held within a prior, estimated, never reported as determined.
    #[must_use]
    pub const fn is_reported(self) -> bool {
        self.is_angle() || matches!(self, Self::Latency)
    }

    /// Which axis of the body a lever arm's component lies along.
    #[must_use]
    pub const fn arm(self) -> Option<usize> {
        match self {
            Self::ArmRight => Some(0),
            Self::ArmForward => Some(1),
            Self::ArmUp => Some(2),
            _ => None,
        }
    }
}

/// One parameter of a survey.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// What it is.
    pub kind: Kind,
    /// Index of the head that it belongs to; `None` for what all heads share.
    pub head: Option<u8>,
    /// Number of that head in words, where a survey has several.
    number: Option<u32>,
    /// Of an unknown of the caller's own.
    own: Option<Own>,
}

/// What an unknown of the caller's own is.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Own {
    /// Which of the survey's.
    place: usize,
    name: Arc<str>,
    unit: Arc<str>,
}

impl Parameter {
    /// Such as `pitch`, or `head 102 pitch` where there are several heads.
    #[must_use]
    pub fn name(&self) -> String {
        let base = self.base();
        self.number
            .map_or_else(|| base.to_owned(), |n| format!("head {n} {base}"))
    }

    /// The head that it belongs to, such as `head 102`; empty where a survey has one.
    #[must_use]
    pub fn head_in_words(&self) -> String {
        self.number
            .map_or_else(String::new, |n| format!("head {n}"))
    }

    /// The name without the head.
    #[must_use]
    pub fn base(&self) -> &str {
        let own = self.own.as_ref();
        own.map_or(self.kind.named().0, |own| &own.name)
    }

    /// `rad`, `s`, `m` or `1`; of an own unknown what the caller says.
    #[must_use]
    pub fn unit(&self) -> &str {
        let own = self.own.as_ref();
        own.map_or(self.kind.named().1, |own| &own.unit)
    }

    /// Which of the survey's own unknowns it is, if it is one.
    #[must_use]
    pub fn own(&self) -> Option<usize> {
        Some(self.own.as_ref()?.place)
    }

    /// Whether it moves the soundings of a head.
    #[must_use]
    pub fn acts_on(&self, head: u8) -> bool {
        self.head.is_none_or(|own| own == head)
    }
}

/// The parameters of the first head and those of all, in their order; whether each is the head's own.
const FIRST: [(Kind, bool); 10] = [
    (Kind::Pitch, true),
    (Kind::Roll, true),
    (Kind::Yaw, true),
    (Kind::Latency, false),
    (Kind::RangeScale, false),
    (Kind::HeaveScale, false),
    (Kind::HeaveLag, false),
    (Kind::ArmRight, true),
    (Kind::ArmForward, true),
    (Kind::DeepSoundSpeed, false),
];
/// The parameters of every further head.
const FURTHER: [Kind; 6] = [
    Kind::Pitch,
    Kind::Roll,
    Kind::Yaw,
    Kind::ArmRight,
    Kind::ArmForward,
    Kind::ArmUp,
];

/// Places of the parameters that all heads share.
pub const LATENCY: usize = 3;
/// See [`LATENCY`].
pub const RANGE_SCALE: usize = 4;
/// See [`LATENCY`].
pub const HEAVE_SCALE: usize = 5;
/// See [`LATENCY`].
pub const HEAVE_LAG: usize = 6;
/// See [`LATENCY`].
pub const DEEP_SOUND_SPEED: usize = 9;

/// How many parameters a survey of so many heads has.
#[must_use]
pub const fn count(heads: usize) -> usize {
    FIRST.len() + FURTHER.len() * heads.saturating_sub(1)
}

/// Where a head's own parameters stand: pitch, roll, yaw; lever arm to the right, forward, up.
#[must_use]
pub fn own(head: usize) -> ([usize; 3], [Option<usize>; 3]) {
    match head.checked_sub(1) {
        None => ([0, 1, 2], [Some(7), Some(8), None]),
        Some(further) => {
            let first = count(further + 1);
            let arm = [3, 4, 5].map(|k| Some(first + k));
            ([first, first + 1, first + 2], arm)
        }
    }
}

/// The parameters of a survey whose heads have these numbers.
#[must_use]
pub fn list(numbers: &[u32]) -> Vec<Parameter> {
    let several = numbers.len() > 1;
    let own = |kind: Kind, head: usize| Parameter {
        kind,
        head: Some(head as u8),
        number: numbers.get(head).copied().filter(|_| several),
        own: None,
    };
    let common = |kind: Kind| Parameter {
        kind,
        head: None,
        number: None,
        own: None,
    };
    let first = FIRST.iter().map(|(kind, of_head)| match of_head {
        true => own(*kind, 0),
        false => common(*kind),
    });
    let further = (1..numbers.len()).flat_map(|head| FURTHER.map(|kind| own(kind, head)));
    first.chain(further).collect()
}

/// The parameters that the caller's own unknowns are; they stand behind those of [`list`].
pub fn of_extras(extras: &[Extra]) -> impl Iterator<Item = Parameter> {
    extras.iter().enumerate().map(|(place, extra)| Parameter {
        kind: Kind::Own,
        head: None,
        number: None,
        own: Some(Own {
            place,
            name: extra.name.as_str().into(),
            unit: extra.unit.as_str().into(),
        }),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_those_of_the_list() {
        let all = list(&[101, 102, 107]);
        assert_eq!(all.len(), count(3));
        for (place, kind) in [
            (LATENCY, Kind::Latency),
            (RANGE_SCALE, Kind::RangeScale),
            (HEAVE_SCALE, Kind::HeaveScale),
            (HEAVE_LAG, Kind::HeaveLag),
            (DEEP_SOUND_SPEED, Kind::DeepSoundSpeed),
        ] {
            assert_eq!((all[place].kind, all[place].head), (kind, None));
        }
        for head in 0..3u8 {
            let (angles, arm) = own(usize::from(head));
            for (place, kind) in angles.iter().zip([Kind::Pitch, Kind::Roll, Kind::Yaw]) {
                assert_eq!((all[*place].kind, all[*place].head), (kind, Some(head)));
            }
            for (axis, place) in arm.iter().enumerate() {
                let found = place.map(|k| (all[k].kind.arm(), all[k].head));
                let due = (head > 0 || axis < 2).then_some((Some(axis), Some(head)));
                assert_eq!(found, due);
            }
        }
        assert_eq!(all[count(2)].name(), "head 107 pitch");
        assert_eq!(all[LATENCY].name(), "latency");
        assert_eq!(list(&[101])[0].name(), "pitch");
    }
}
