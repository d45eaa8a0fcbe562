//! Points of formats 0 to 5, compressed one after the other into one stream (versions 1 and 2 of their items).
//!
//! Only coordinates and times are kept. Everything else is decoded as far as the stream needs it: values that choose a model are
//! followed, others are passed over.

use super::coder::{Bytes, Decoder, Model, Models};
use super::integer::Integer;
use super::returns::{Median, after, level, map};
use super::time::{OldTimes, Times};
use super::{Fault, Item, Kind, RawPoint};

/// The state of one chunk.
pub struct Chunk {
    decoder: Decoder,
    parts: Vec<Part>,
    point: RawPoint,
}

/// The models of one item.
enum Part {
    Point(Box<PointModels>),
    OldPoint(Box<OldPointModels>),
    Times(Box<Times>),
    OldTimes(Box<OldTimes>),
    Colour(Box<Colour>),
    OldColour(Box<OldColour>),
    Wave(Box<Wave>),
    Extra(Models, usize),
}

impl Chunk {
    /// Reads the first point and begins; the first point comes with it.
    pub fn begin(items: &[Item], bytes: &mut impl Bytes) -> Result<(Self, RawPoint), Fault> {
        let mut point = RawPoint::default();
        let mut parts = Vec::new();
        for item in items {
            let mut raw = Vec::new();
            for _ in 0..item.bytes {
                raw.push(bytes.byte()?);
            }
            parts.push(part(item, &raw, &mut point));
        }
        let decoder = Decoder::begin(bytes)?;
        let chunk = Self {
            decoder,
            parts,
            point,
        };
        Ok((chunk, point))
    }

    /// The next point.
    pub fn next(&mut self, bytes: &mut impl Bytes) -> Result<RawPoint, Fault> {
        let Self {
            decoder,
            parts,
            point,
        } = self;
        for part in parts {
            match part {
                Part::Point(models) => models.next(&mut point.xyz, decoder, bytes)?,
                Part::OldPoint(models) => models.next(&mut point.xyz, decoder, bytes)?,
                Part::Times(times) => point.time = times.next(decoder, bytes)?,
                Part::OldTimes(times) => point.time = times.next(decoder, bytes)?,
                Part::Colour(colour) => colour.pass(decoder, bytes)?,
                Part::OldColour(colour) => colour.pass(decoder, bytes)?,
                Part::Wave(wave) => wave.pass(decoder, bytes)?,
                Part::Extra(models, count) => {
                    for k in 0..*count {
                        decoder.symbol(models.of(k), bytes)?;
                    }
                }
            }
        }
        Ok(*point)
    }
}

/// The models of an item, from its first value.
fn part(item: &Item, raw: &[u8], point: &mut RawPoint) -> Part {
    match (item.kind, item.version) {
        (Kind::Point10, 1) => {
            point.xyz = RawPoint::of(raw, None).xyz;
            Part::OldPoint(Box::new(OldPointModels::new(raw)))
        }
        (Kind::Point10, _) => {
            point.xyz = RawPoint::of(raw, None).xyz;
            Part::Point(Box::new(PointModels::new(raw)))
        }
        (Kind::Time11, version) => {
            let mut bits = [0; 8];
            bits.copy_from_slice(&raw[..8]);
            point.time = i64::from_le_bytes(bits);
            match version {
                1 => Part::OldTimes(Box::new(OldTimes::new(point.time))),
                _ => Part::Times(Box::new(Times::pointwise(point.time))),
            }
        }
        (Kind::Colour12, 1) => Part::OldColour(Box::default()),
        (Kind::Colour12, _) => Part::Colour(Box::default()),
        (Kind::Wave13, _) => Part::Wave(Box::default()),
        _ => Part::Extra(Models::new(raw.len(), 256), raw.len()),
    }
}

/// Fields besides the coordinates that choose a model.
struct Fields {
    /// Return number, number of returns, scan direction, edge.
    bits: usize,
    classification: usize,
    user_data: usize,
    bit_models: Models,
    classifications: Models,
    users: Models,
}

impl Fields {
    fn new(raw: &[u8]) -> Self {
        Self {
            bits: raw[14].into(),
            classification: raw[15].into(),
            user_data: raw[17].into(),
            bit_models: Models::new(256, 256),
            classifications: Models::new(256, 256),
            users: Models::new(256, 256),
        }
    }
}

/// Version 2.
struct PointModels {
    fields: Fields,
    changes: Model,
    angles: Models,
    intensity: Integer,
    source: Integer,
    x: Integer,
    y: Integer,
    z: Integer,
    x_medians: [Median; 16],
    y_medians: [Median; 16],
    heights: [i32; 8],
}

impl PointModels {
    fn new(raw: &[u8]) -> Self {
        Self {
            fields: Fields::new(raw),
            changes: Model::new(64),
            angles: Models::new(2, 256),
            intensity: Integer::new(16, 4),
            source: Integer::new(16, 1),
            x: Integer::new(32, 2),
            y: Integer::new(32, 22),
            z: Integer::new(32, 20),
            x_medians: Default::default(),
            y_medians: Default::default(),
            heights: [0; 8],
        }
    }

    fn next(
        &mut self,
        xyz: &mut [i32; 3],
        decoder: &mut Decoder,
        bytes: &mut impl Bytes,
    ) -> Result<(), Fault> {
        let changed = decoder.symbol(&mut self.changes, bytes)?;
        self.fields(changed, decoder, bytes)?;
        let (n, r) = (self.fields.bits >> 3 & 7, self.fields.bits & 7);
        let (m, single) = (map(n, r), n == 1);
        let predicted = self.x_medians[m].get();
        let x = self.x.next(predicted, single.into(), decoder, bytes)?;
        self.x_medians[m].add(x);
        xyz[0] = xyz[0].wrapping_add(x);
        let (predicted, context) = (self.y_medians[m].get(), after(self.x.k, 20, single));
        let y = self.y.next(predicted, context, decoder, bytes)?;
        self.y_medians[m].add(y);
        xyz[1] = xyz[1].wrapping_add(y);
        let height = &mut self.heights[level(n, r)];
        let context = after(self.x.k.midpoint(self.y.k), 18, single);
        *height = self.z.next(*height, context, decoder, bytes)?;
        xyz[2] = *height;
        Ok(())
    }

    fn fields(
        &mut self,
        changed: usize,
        decoder: &mut Decoder,
        bytes: &mut impl Bytes,
    ) -> Result<(), Fault> {
        let f = &mut self.fields;
        if changed & 32 != 0 {
            f.bits = decoder.symbol(f.bit_models.of(f.bits), bytes)?;
        }
        if changed & 16 != 0 {
            let m = map(f.bits >> 3 & 7, f.bits & 7);
            self.intensity.next(0, m.min(3), decoder, bytes)?;
        }
        if changed & 8 != 0 {
            f.classification = decoder.symbol(f.classifications.of(f.classification), bytes)?;
        }
        if changed & 4 != 0 {
            decoder.symbol(self.angles.of(f.bits >> 6 & 1), bytes)?;
        }
        if changed & 2 != 0 {
            f.user_data = decoder.symbol(f.users.of(f.user_data), bytes)?;
        }
        if changed & 1 != 0 {
            self.source.next(0, 0, decoder, bytes)?;
        }
        Ok(())
    }
}

/// Version 1.
struct OldPointModels {
    fields: Fields,
    changes: Model,
    angle: Integer,
    intensity: Integer,
    source: Integer,
    x: Integer,
    y: Integer,
    z: Integer,
    x_differences: [i32; 3],
    y_differences: [i32; 3],
    turn: usize,
}

impl OldPointModels {
    fn new(raw: &[u8]) -> Self {
        Self {
            fields: Fields::new(raw),
            changes: Model::new(64),
            angle: Integer::new(8, 2),
            intensity: Integer::new(16, 1),
            source: Integer::new(16, 1),
            x: Integer::new(32, 1),
            y: Integer::new(32, 20),
            z: Integer::new(32, 20),
            x_differences: [0; 3],
            y_differences: [0; 3],
            turn: 0,
        }
    }

    fn next(
        &mut self,
        xyz: &mut [i32; 3],
        decoder: &mut Decoder,
        bytes: &mut impl Bytes,
    ) -> Result<(), Fault> {
        let x = self.x.next(middle(self.x_differences), 0, decoder, bytes)?;
        xyz[0] = xyz[0].wrapping_add(x);
        let predicted = middle(self.y_differences);
        let y = self.y.next(predicted, self.x.k.min(19), decoder, bytes)?;
        xyz[1] = xyz[1].wrapping_add(y);
        let k = self.x.k.midpoint(self.y.k);
        xyz[2] = self.z.next(xyz[2], k.min(19), decoder, bytes)?;
        self.fields(k, decoder, bytes)?;
        self.x_differences[self.turn] = x;
        self.y_differences[self.turn] = y;
        self.turn = (self.turn + 1) % 3;
        Ok(())
    }

    fn fields(
        &mut self,
        k: usize,
        decoder: &mut Decoder,
        bytes: &mut impl Bytes,
    ) -> Result<(), Fault> {
        let changed = decoder.symbol(&mut self.changes, bytes)?;
        let f = &mut self.fields;
        if changed & 32 != 0 {
            self.intensity.next(0, 0, decoder, bytes)?;
        }
        if changed & 16 != 0 {
            f.bits = decoder.symbol(f.bit_models.of(f.bits), bytes)?;
        }
        if changed & 8 != 0 {
            f.classification = decoder.symbol(f.classifications.of(f.classification), bytes)?;
        }
        if changed & 4 != 0 {
            self.angle.next(0, usize::from(k < 3), decoder, bytes)?;
        }
        if changed & 2 != 0 {
            f.user_data = decoder.symbol(f.users.of(f.user_data), bytes)?;
        }
        if changed & 1 != 0 {
            self.source.next(0, 0, decoder, bytes)?;
        }
        Ok(())
    }
}

fn middle([a, b, c]: [i32; 3]) -> i32 {
    a.min(b).max(a.max(b).min(c))
}

/// Colours of version 2: they choose no model, but whether green and blue follow is in the first symbol.
struct Colour {
    used: Model,
    parts: Models,
}

impl Default for Colour {
    fn default() -> Self {
        Self {
            used: Model::new(128),
            parts: Models::new(6, 256),
        }
    }
}

impl Colour {
    fn pass(&mut self, decoder: &mut Decoder, bytes: &mut impl Bytes) -> Result<(), Fault> {
        let used = decoder.symbol(&mut self.used, bytes)?;
        let grey = used & 64 == 0;
        // red low and high, then green low, blue low, green high, blue high
        for part in [0, 1, 2, 4, 3, 5] {
            if used >> part & 1 != 0 && !(grey && part > 1) {
                decoder.symbol(self.parts.of(part), bytes)?;
            }
        }
        Ok(())
    }
}

/// Colours of version 1.
struct OldColour {
    used: Model,
    parts: Integer,
}

impl Default for OldColour {
    fn default() -> Self {
        Self {
            used: Model::new(64),
            parts: Integer::new(8, 6),
        }
    }
}

impl OldColour {
    fn pass(&mut self, decoder: &mut Decoder, bytes: &mut impl Bytes) -> Result<(), Fault> {
        let used = decoder.symbol(&mut self.used, bytes)?;
        for part in (0..6).filter(|part| used >> part & 1 != 0) {
            self.parts.next(0, part, decoder, bytes)?;
        }
        Ok(())
    }
}

/// Wave packets.
struct Wave {
    indices: Model,
    offsets: Models,
    last: usize,
    offset: Integer,
    size: Integer,
    place: Integer,
    xyz: Integer,
}

impl Default for Wave {
    fn default() -> Self {
        Self {
            indices: Model::new(256),
            offsets: Models::new(4, 4),
            last: 0,
            offset: Integer::new(32, 1),
            size: Integer::new(32, 1),
            place: Integer::new(32, 1),
            xyz: Integer::new(32, 3),
        }
    }
}

impl Wave {
    fn pass(&mut self, decoder: &mut Decoder, bytes: &mut impl Bytes) -> Result<(), Fault> {
        decoder.symbol(&mut self.indices, bytes)?;
        self.last = decoder.symbol(self.offsets.of(self.last), bytes)?;
        match self.last {
            2 => drop(self.offset.next(0, 0, decoder, bytes)?),
            3 => drop(decoder.long(bytes)?),
            _ => {}
        }
        self.size.next(0, 0, decoder, bytes)?;
        self.place.next(0, 0, decoder, bytes)?;
        for axis in 0..3 {
            self.xyz.next(0, axis, decoder, bytes)?;
        }
        Ok(())
    }
}
