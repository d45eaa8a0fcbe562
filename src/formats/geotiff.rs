//! A gridded surface as GeoTIFF: mean, count and standard deviation of the heights in each cell, three bands of 32-bit floats.
//!
//! TIFF 6.0 with the keys of OGC 19-008 (GeoTIFF 1.1), GDAL's tag for cells without a value, and its names of the bands.

use std::io::{Seek, Write};
use std::path::Path;

use tiff::TiffResult;
use tiff::decoder::Decoder;
use tiff::encoder::colortype::ColorType;
use tiff::encoder::{Compression, DeflateLevel, DirectoryEncoder, TiffEncoder, TiffKindStandard};
use tiff::tags::{PhotometricInterpretation, SampleFormat, Tag};

use super::error::FormatError;
use crate::files::write_whole;
use crate::geometry::Ellipsoid;

/// What the file says of its making; a file that says so may be replaced.
pub const WRITTEN_BY: &str = "boresight apply";

/// The bands in their order.
const BANDS: [&str; 3] = [
    "mean height, m",
    "soundings",
    "standard deviation of the heights, m",
];

/// A surface in a zone of UTM.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Ellipsoid of the heights and of the zone.
    pub ellipsoid: Ellipsoid,
    /// The zone, negative in the south.
    pub zone: i8,
    /// Easting and northing of the north-western corner, metres.
    pub corner_m: [f64; 2],
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// Three floats of a cell: one image, not a colour.
struct Cells;

impl ColorType for Cells {
    type Inner = f32;
    const TIFF_VALUE: PhotometricInterpretation = PhotometricInterpretation::BlackIsZero;
    const BITS_PER_SAMPLE: &'static [u16] = &[32; 3];
    const SAMPLE_FORMAT: &'static [SampleFormat] = &[SampleFormat::IEEEFP; 3];

    fn horizontal_predict(_: &[f32], _: &mut Vec<f32>) {}
}

/// Cells that a surface may have: they are held in memory while they are written.
pub const MOST_CELLS: u64 = 50_000_000;

/// Writes a surface, whole or not at all. `cells` are row by row, the northernmost first, three values of each cell: mean, count and
/// standard deviation, NaN where there is none.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write(path: &Path, raster: &Raster, cells: &[f32]) -> Result<(), FormatError> {
    let written = write_whole(path, |file| {
        let file = file.get_mut();
        filled(&mut **file, raster, cells).map_err(std::io::Error::other)
    });
    written.map_err(|e| FormatError::unwritable(path, &e.source))
}

fn filled(file: impl Write + Seek, raster: &Raster, cells: &[f32]) -> TiffResult<()> {
    let deflated = Compression::Deflate(DeflateLevel::Balanced);
    let mut encoder = TiffEncoder::new(file)?.with_compression(deflated);
    let mut image = encoder.new_image::<Cells>(raster.width, raster.height)?;
    tags(raster, image.encoder())?;
    image.write_data(cells)
}

fn tags<W: Write + Seek>(
    raster: &Raster,
    directory: &mut DirectoryEncoder<'_, W, TiffKindStandard>,
) -> TiffResult<()> {
    let [east_m, north_m] = raster.corner_m;
    let scale = [raster.cell_m, raster.cell_m, 0.0];
    let tie = [0.0, 0.0, 0.0, east_m, north_m, 0.0];
    let citation = citation(raster);
    let keys = keys(raster, citation.len());
    directory.write_tag(Tag::ExtraSamples, &[0u16, 0][..])?;
    directory.write_tag(Tag::Software, WRITTEN_BY)?;
    directory.write_tag(Tag::ModelPixelScaleTag, &scale[..])?;
    directory.write_tag(Tag::ModelTiepointTag, &tie[..])?;
    directory.write_tag(Tag::GeoKeyDirectoryTag, &keys[..])?;
    directory.write_tag(Tag::GeoAsciiParamsTag, citation.as_str())?;
    directory.write_tag(Tag::GdalNodata, "nan")?;
    directory.write_tag(Tag::Unknown(GDAL_METADATA), bands().as_str())
}

const GDAL_METADATA: u16 = 42112;

/// Name of the system; each text of the ASCII parameters ends with a bar.
fn citation(raster: &Raster) -> String {
    let letter = if raster.zone < 0 { 'S' } else { 'N' };
    let datum = match raster.ellipsoid {
        Ellipsoid::Wgs84 => "WGS 84",
        Ellipsoid::Cgcs2000 => "CGCS2000",
    };
    let zone = raster.zone.unsigned_abs();
    format!("{datum} / UTM zone {zone}{letter}, heights above the ellipsoid|")
}

/// The key directory (OGC 19-008, 7.1.2): version, then key, where its value is, how many, value.
fn keys(raster: &Raster, citation: usize) -> Vec<u16> {
    const PARAMETERS: u16 = 34737;
    let number = u16::from(raster.zone.unsigned_abs());
    let south = raster.zone < 0;
    let mut keys: Vec<[u16; 4]> = vec![
        [1024, 0, 1, 1],                        // GTModelType: projected
        [1025, 0, 1, 1],                        // GTRasterType: a value is of the whole cell
        [1026, PARAMETERS, citation as u16, 0], // GTCitation
    ];
    match raster.ellipsoid {
        Ellipsoid::Wgs84 => {
            let code = if south { 32700 } else { 32600 } + number;
            keys.push([3072, 0, 1, code]); // ProjectedCRS: EPSG
        }
        Ellipsoid::Cgcs2000 => {
            let projection = if south { 16100 } else { 16000 } + number;
            keys.push([2048, 0, 1, 4490]); // GeodeticCRS: China Geodetic Coordinate System 2000
            keys.push([3072, 0, 1, 32767]); // ProjectedCRS: none of the registry
            keys.push([3074, 0, 1, projection]); // Projection: UTM zone
        }
    }
    keys.push([3076, 0, 1, 9001]); // ProjLinearUnits: metres
    let head = [1, 1, 1, keys.len() as u16];
    std::iter::once(head).chain(keys).flatten().collect()
}

fn bands() -> String {
    let item = |(k, name): (usize, &&str)| {
        format!("<Item name=\"DESCRIPTION\" sample=\"{k}\" role=\"description\">{name}</Item>")
    };
    let items: String = BANDS.iter().enumerate().map(item).collect();
    format!("<GDALMetadata>{items}</GDALMetadata>")
}

/// Whether this program's `apply` wrote a file.
#[must_use]
pub fn is_ours(path: &Path) -> bool {
    let Ok(file) = std::fs::File::open(path) else {
        return false;
    };
    let Ok(mut decoder) = Decoder::new(std::io::BufReader::new(file)) else {
        return false;
    };
    let software = decoder.get_tag_ascii_string(Tag::Software);
    software.is_ok_and(|said| said == WRITTEN_BY)
}
