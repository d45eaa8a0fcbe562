//! What a reader says of a whole file: device, counts, time scale, what was lost.

use std::collections::BTreeMap;

/// Most kinds of records that are told apart.
const MOST_KINDS: usize = 400;

/// What a file's times are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TimeScale {
    /// Seconds since 1970 of UTC.
    #[default]
    Utc,
    /// Seconds since 1970 counted on the GPS scale: ahead of UTC by the leap seconds.
    Gps,
    /// Seconds of the week; the file says neither the week nor whether they are GPS or UTC.
    SecondsOfWeek,
}

impl TimeScale {
    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Utc => "UTC",
            Self::Gps => "GPS time, ahead of UTC by the leap seconds",
            Self::SecondsOfWeek => "seconds of the week, GPS or UTC; the file names neither",
        }
    }
}

/// What was lost or odd in a file. Every byte of a file is in a record that was read, or is counted here.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// Bytes that belong to no record, passed over to find the next one.
    pub skipped_bytes: u64,
    /// Places where that happened.
    pub skipped_places: u64,
    /// Bytes of a record that the end of the file cuts off.
    pub truncated_bytes: u64,
    /// Records whose checksum is wrong; they are not used.
    pub bad_checksums: u64,
    /// Records with a checksum of zero, taken as not written; they are used.
    pub zero_checksums: u64,
    /// Records whose content contradicts itself or is too short for it; they are not used.
    pub malformed: u64,
    /// Single values that cannot be (a time, an angle or a depth out of any range); they are not used.
    pub impossible: u64,
    /// Parts of a record whose other parts are missing.
    pub incomplete: u64,
    /// Records that the instrument itself marks as not good; they are not used.
    pub not_good: u64,
    /// Pings that the next streams do not complete (a ping without its second half).
    pub unpaired: u64,
}

impl Losses {
    /// Names and counts of all that is not zero, for a table.
    #[must_use]
    pub fn lines(&self) -> Vec<(&'static str, u64)> {
        [
            ("bytes skipped between records", self.skipped_bytes),
            ("places where bytes were skipped", self.skipped_places),
            ("bytes of a record cut off at the end", self.truncated_bytes),
            (
                "records with a wrong checksum, not used",
                self.bad_checksums,
            ),
            ("records with a checksum of zero, used", self.zero_checksums),
            ("malformed records, not used", self.malformed),
            ("impossible values, not used", self.impossible),
            ("parts of incomplete records, not used", self.incomplete),
            (
                "records marked as not good by the instrument, not used",
                self.not_good,
            ),
            (
                "halves of a ping without the other, not used",
                self.unpaired,
            ),
        ]
        .into_iter()
        .filter(|(_, count)| *count > 0)
        .collect()
    }

    /// Whether anything was lost.
    #[must_use]
    pub fn any(&self) -> bool {
        let Self {
            zero_checksums: _, ..
        } = self;
        *self
            != Self {
                zero_checksums: self.zero_checksums,
                ..Self::default()
            }
    }
}

/// A file as a whole.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// The format's name.
    pub format: &'static str,
    /// The device as the file names it.
    pub device: String,
    /// Serial numbers or indices of the heads.
    pub heads: Vec<u32>,
    /// What the times are.
    pub time: TimeScale,
    /// Records by the file's own name of their kind.
    pub records: BTreeMap<String, u64>,
    /// What was lost.
    pub losses: Losses,
    /// What the recorder has already applied to the data.
    pub applied: Vec<String>,
    /// What else a reader should know.
    pub notes: Vec<String>,
    /// Why a calibration cannot use the soundings, if so.
    pub refusal: Option<String>,
}

impl Summary {
    /// Of a format, nothing read yet.
    #[must_use]
    pub fn of(format: &'static str) -> Self {
        Self {
            format,
            ..Self::default()
        }
    }

    /// Counts a record of a kind.
    pub fn count(&mut self, kind: &str) {
        if let Some(count) = self.records.get_mut(kind) {
            *count += 1;
            return;
        }
        let kept = if self.records.len() < MOST_KINDS {
            kind
        } else {
            "other"
        };
        *self.records.entry(kept.to_owned()).or_default() += 1;
    }

    /// Says something once.
    pub fn note(&mut self, sentence: impl Into<String>) {
        let sentence = sentence.into();
        if self.notes.len() < 50 && !self.notes.contains(&sentence) {
            self.notes.push(sentence);
        }
    }

    /// Says once what was already applied.
    pub fn applied(&mut self, sentence: &str) {
        if !self.applied.iter().any(|s| s == sentence) {
            self.applied.push(sentence.to_owned());
        }
    }

    /// Remembers a head.
    pub fn head(&mut self, head: u32) {
        if !self.heads.contains(&head) && self.heads.len() < 16 {
            self.heads.push(head);
        }
    }
}
