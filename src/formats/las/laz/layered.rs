//! Points of formats 6 to 10, compressed in layers (versions 3 and 4 of their items): every field has a stream of its own, so that
//! only those of the coordinates and of the time are read.

use super::coder::{Bytes, Decoder, Model, Models};
use super::integer::Integer;
use super::returns::{Median, after, level, map_of_six};
use super::time::Times;
use super::{Fault, RawPoint};

/// The bytes of a layer.
#[derive(Clone, Debug, Default)]
pub struct Layer {
    bytes: Vec<u8>,
    at: usize,
}

impl Layer {
    /// A layer of these bytes.
    pub fn new(bytes: Vec<u8>) -> Self {
        Self { bytes, at: 0 }
    }
}

impl Bytes for Layer {
    fn byte(&mut self) -> Result<u8, Fault> {
        let byte = self.bytes.get(self.at).ok_or(Fault::End)?;
        self.at += 1;
        Ok(*byte)
    }
}

/// A layer and its decoder; none where the field never changes in the chunk.
struct Stream(Option<(Decoder, Layer)>);

impl Stream {
    fn begin(mut layer: Layer) -> Result<Self, Fault> {
        if layer.bytes.is_empty() {
            return Ok(Self(None));
        }
        Ok(Self(Some((Decoder::begin(&mut layer)?, layer))))
    }
}

/// The state of one chunk.
pub struct Chunk {
    coordinates: (Decoder, Layer),
    heights: Stream,
    times: Stream,
    channels: [Option<Box<Channel>>; 4],
    channel: usize,
}

/// What is known of the points of one scanner channel.
struct Channel {
    point: RawPoint,
    returns: usize,
    number: usize,
    time_changed: bool,
    heights: [i32; 8],
    x_medians: [Median; 12],
    y_medians: [Median; 12],
    changes: Models,
    scanner: Model,
    returns_models: Models,
    number_models: Models,
    number_same_time: Model,
    x: Integer,
    y: Integer,
    z: Integer,
    times: Times,
}

impl Channel {
    fn new(point: RawPoint, returns: usize, number: usize) -> Box<Self> {
        Box::new(Self {
            point,
            returns,
            number,
            time_changed: false,
            heights: [point.xyz[2]; 8],
            x_medians: Default::default(),
            y_medians: Default::default(),
            changes: Models::new(8, 128),
            scanner: Model::new(3),
            returns_models: Models::new(16, 16),
            number_models: Models::new(16, 16),
            number_same_time: Model::new(13),
            x: Integer::new(32, 2),
            y: Integer::new(32, 22),
            z: Integer::new(32, 20),
            times: Times::layered(point.time),
        })
    }

    /// Context of what changes: single, first, last or middle return, and whether the time changed before.
    fn context(&self) -> usize {
        usize::from(self.number == 1)
            + 2 * usize::from(self.number >= self.returns)
            + 4 * usize::from(self.time_changed)
    }

    /// The number of returns and the return number, where they change.
    fn returns(
        &mut self,
        changed: usize,
        decoder: &mut Decoder,
        layer: &mut Layer,
    ) -> Result<(), Fault> {
        if changed & 4 != 0 {
            self.returns = decoder.symbol(self.returns_models.of(self.returns), layer)?;
        }
        self.number = match changed & 3 {
            0 => self.number,
            1 => (self.number + 1) % 16,
            2 => (self.number + 15) % 16,
            _ if changed & 16 != 0 => decoder.symbol(self.number_models.of(self.number), layer)?,
            _ => (self.number + decoder.symbol(&mut self.number_same_time, layer)? + 2) % 16,
        };
        Ok(())
    }

    /// The coordinates in the plane.
    fn plane(&mut self, decoder: &mut Decoder, layer: &mut Layer) -> Result<(), Fault> {
        let single = self.returns == 1;
        let m = map_of_six(self.returns, self.number) << 1 | usize::from(self.time_changed);
        let predicted = self.x_medians[m].get();
        let x = self.x.next(predicted, single.into(), decoder, layer)?;
        self.x_medians[m].add(x);
        let (predicted, context) = (self.y_medians[m].get(), after(self.x.k, 20, single));
        let y = self.y.next(predicted, context, decoder, layer)?;
        self.y_medians[m].add(y);
        let [px, py, _] = &mut self.point.xyz;
        (*px, *py) = (px.wrapping_add(x), py.wrapping_add(y));
        Ok(())
    }

    fn height(&mut self, stream: &mut Stream) -> Result<(), Fault> {
        let Some((decoder, layer)) = &mut stream.0 else {
            return Ok(());
        };
        let context = after(self.x.k.midpoint(self.y.k), 18, self.returns == 1);
        let last = &mut self.heights[level(self.returns, self.number)];
        *last = self.z.next(*last, context, decoder, layer)?;
        self.point.xyz[2] = *last;
        Ok(())
    }

    fn time(&mut self, stream: &mut Stream) -> Result<(), Fault> {
        if let (true, Some((decoder, layer))) = (self.time_changed, &mut stream.0) {
            self.point.time = self.times.next(decoder, layer)?;
        }
        Ok(())
    }
}

impl Chunk {
    /// Begins with the first point as it stands and the layers of the coordinates, heights and times.
    pub fn begin(raw: &[u8], layers: [Layer; 3]) -> Result<(Self, RawPoint), Fault> {
        let point = RawPoint::of(raw, Some(22));
        let (returns, number) = (usize::from(raw[14] >> 4), usize::from(raw[14] & 15));
        let channel = usize::from(raw[15] >> 4 & 3);
        let [mut coordinates, heights, times] = layers;
        let mut channels: [Option<Box<Channel>>; 4] = Default::default();
        channels[channel] = Some(Channel::new(point, returns, number));
        // a chunk of one point may have no layers at all
        let decoder = match coordinates.bytes.is_empty() {
            true => Decoder::begin(&mut Layer::new(vec![0; 4]))?,
            false => Decoder::begin(&mut coordinates)?,
        };
        let chunk = Self {
            coordinates: (decoder, coordinates),
            heights: Stream::begin(heights)?,
            times: Stream::begin(times)?,
            channels,
            channel,
        };
        Ok((chunk, point))
    }

    /// The next point.
    pub fn point(&mut self) -> Result<RawPoint, Fault> {
        let (decoder, layer) = &mut self.coordinates;
        let before = self.channels[self.channel].as_mut().ok_or(Fault::Damaged)?;
        let context = before.context();
        let changed = decoder.symbol(before.changes.of(context), layer)?;
        if changed & 64 != 0 {
            let step = decoder.symbol(&mut before.scanner, layer)?;
            let (point, returns, number) = (before.point, before.returns, before.number);
            self.channel = (self.channel + step + 1) % 4;
            self.channels[self.channel].get_or_insert_with(|| Channel::new(point, returns, number));
        }
        let channel = self.channels[self.channel].as_mut().ok_or(Fault::Damaged)?;
        channel.time_changed = changed & 16 != 0;
        channel.returns(changed, decoder, layer)?;
        channel.plane(decoder, layer)?;
        channel.height(&mut self.heights)?;
        channel.time(&mut self.times)?;
        Ok(channel.point)
    }
}
