//! `boresight apply`: all points of a survey georeferenced with a calibration.

use std::path::Path;

use indicatif::ProgressBar;

use super::Ending;
use super::args::{Apply, CoordinatesName, SolutionName};
use super::error::CliError;
use super::out::{free_for_cloud, free_for_surface};
use super::result_file::read_result;
use super::talk::Talk;
use crate::calibrate::cloud::{Calibrated, Cloud, Placed};
use crate::calibrate::grid::Grid;
use crate::formats::FormatError;
use crate::formats::geotiff::{self, MOST_CELLS, Raster};
use crate::formats::las::stream::{self, CloudPoint, Layout, NOTHING};
use crate::formats::las::wkt;
use crate::geometry::Ellipsoid;
use crate::geometry::utm::Utm;
use crate::procedures;
use crate::results::{Calibration, InputFile, Solution};

/// Runs the command.
pub fn run(args: &Apply, talk: &Talk) -> Result<Ending, CliError> {
    refuse_extension(&args.out, &["laz", "las"], ".laz or .las")?;
    if let Some(surface) = &args.surface {
        refuse_extension(surface, &["tif", "tiff"], ".tif or .tiff")?;
    }
    talk.step(&format!("reading {}", args.survey.display()));
    let procedure = procedures::of_file(&args.survey)?;
    let survey = procedure.read(&args.survey)?;
    free_for_cloud(
        &args.out,
        &args.survey,
        survey.inputs(),
        &args.calibration,
        args.force,
    )?;
    if let Some(surface) = &args.surface {
        free_for_surface(
            surface,
            &args.out,
            &args.survey,
            survey.inputs(),
            &args.calibration,
        )?;
    }
    talk.step(&format!("reading {}", args.calibration.display()));
    let result = read_result(&args.calibration)?;
    let mut calibrated = calibrated(&args.calibration, &result, procedure.name(), args.solution)?;
    let others = calibrated.without_heights_of_others(&result, survey.inputs());
    let Some(cloud) = survey.cloud(&calibrated)? else {
        let (file, procedure) = (args.survey.clone(), procedure.name());
        return Err(CliError::NoPoints { file, procedure });
    };
    let mut notes = survey.notes().to_vec();
    notes.extend(other_files(&result, survey.inputs()));
    notes.extend(others.then(|| OTHERS_HEIGHTS.to_owned()));
    written(args, cloud, &notes, talk)
}

fn written(
    args: &Apply,
    cloud: Cloud<'_>,
    notes: &[String],
    talk: &Talk,
) -> Result<Ending, CliError> {
    let system = System::new(args.coordinates, &cloud)?;
    let mut surface = Surface::asked(args, &system)?;
    let bar = talk.bar("georeferencing", cloud.total as u64);
    let layout = system.layout(&cloud);
    let chunks = cloud
        .chunks
        .map(|chunk| counted(&bar, system.points(&chunk?)))
        .inspect(|points| {
            if let (Some(surface), Ok(points)) = (&mut surface, points) {
                surface.add(points);
            }
        });
    let count = stream::write(&args.out, &layout, chunks)?;
    bar.finish_and_clear();
    let cells = surface.map(Surface::written).transpose()?;
    let sources = cloud.sources.iter().enumerate();
    let sources: Vec<String> = sources.map(|(k, s)| format!("{} {s}", k + 1)).collect();
    let mut text = format!(
        "Wrote {count} of {} points to {}\n{}; point source id: {}\n",
        cloud.total,
        args.out.display(),
        system.name(),
        sources.join(", ")
    );
    if let (Some(file), Some(cells)) = (&args.surface, cells) {
        text += &format!(
            "Wrote the surface, {cells} cells of {} m, to {}\n",
            args.cell,
            file.display()
        );
    }
    for note in notes {
        text += &format!("note: {note}\n");
    }
    let json = serde_json::json!({
        "file": args.out,
        "points": count,
        "read": cloud.total,
        "coordinates": system.name(),
        "sources": cloud.sources,
        "surface": args.surface,
        "notes": notes,
    });
    talk.result(&text, format!("{json:#}\n").as_bytes())?;
    Ok(Ending::Usable)
}

fn counted(
    bar: &ProgressBar,
    chunk: Result<Vec<CloudPoint>, CliError>,
) -> Result<Vec<CloudPoint>, CliError> {
    bar.inc(chunk.as_ref().map_or(0, Vec::len) as u64);
    chunk
}

/// Says so where the survey's files are not those of the calibration: right for another survey with the same mounting, and a surprise
/// for whoever means the same one.
fn other_files(result: &Calibration, inputs: &[InputFile]) -> Vec<String> {
    let then = &result.provenance.inputs;
    let known = |input: &&InputFile| then.iter().any(|i| i.sha256 == input.sha256);
    let changed = |input: &&InputFile| !known(input) && then.iter().any(|i| i.path == input.path);
    if !inputs.iter().any(|i| known(&i)) {
        return vec!["the calibration was made from other files than this survey's".to_owned()];
    }
    let changed = inputs.iter().filter(changed);
    changed
        .map(|i| format!("{} has changed since the calibration", i.path))
        .collect()
}

/// What is said where heights of lines are left out.
const OTHERS_HEIGHTS: &str =
    "the heights of lines that the calibration found are of other files and are not applied";

fn refuse_extension(path: &Path, good: &[&str], expected: &str) -> Result<(), CliError> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    if extension.is_some_and(|e| good.contains(&e.as_str())) {
        return Ok(());
    }
    Err(FormatError::unknown_extension(path, expected).into())
}

/// What one solution of a result file changes.
fn calibrated(
    path: &Path,
    result: &Calibration,
    procedure: &str,
    solution: SolutionName,
) -> Result<Calibrated, CliError> {
    let (name, found) = chosen(result, solution);
    let refused = |found: &str| CliError::NoSolution {
        file: path.to_owned(),
        name,
        found: found.to_owned(),
    };
    if result.procedure != procedure {
        let theirs = &result.procedure;
        return Err(refused(&format!(
            "a result of procedure {theirs} for a {procedure} survey"
        )));
    }
    let found = found.ok_or_else(|| refused("nothing"))?;
    if !found.usable {
        let message = &found.message;
        return Err(refused(&format!("one that is not usable ({message})")));
    }
    Calibrated::of(result, found).ok_or_else(|| refused("one without a mounting and a lever arm"))
}

fn chosen(result: &Calibration, name: SolutionName) -> (&'static str, Option<&Solution>) {
    let solutions = &result.solutions;
    match name {
        SolutionName::Reference => ("reference", solutions.reference.as_ref()),
        SolutionName::Joint => ("joint", solutions.joint.as_ref()),
        SolutionName::JointSimple => ("joint_simple", solutions.joint_simple.as_ref()),
    }
}

/// The coordinate system of the written points.
struct System {
    ellipsoid: Ellipsoid,
    utm: Option<Utm>,
}

impl System {
    fn new(name: CoordinatesName, cloud: &Cloud<'_>) -> Result<Self, CliError> {
        let ellipsoid = cloud.ellipsoid;
        let utm = match name {
            CoordinatesName::Geocentric => None,
            CoordinatesName::Utm => Some(Utm::new(ellipsoid, Utm::zone_of(&cloud.middle))?),
        };
        Ok(Self { ellipsoid, utm })
    }

    fn name(&self) -> String {
        let Some(utm) = &self.utm else {
            return "geocentric".to_owned();
        };
        let zone = utm.zone();
        format!(
            "UTM zone {}{}, ellipsoidal heights",
            zone.unsigned_abs(),
            if zone < 0 { 'S' } else { 'N' }
        )
    }

    fn layout(&self, cloud: &Cloud<'_>) -> Layout {
        let (origin, standard_time) = (&cloud.middle, cloud.standard_time);
        let geocentric = self.ellipsoid.to_geocentric(origin).coordinates;
        let plane = self
            .utm
            .as_ref()
            .and_then(|utm| Some((utm, utm.from_geodetic(origin).ok()?)));
        match plane {
            Some((utm, (easting, northing))) => Layout {
                middle_m: [easting, northing, origin.height_m],
                wkt: wkt::utm(self.ellipsoid, utm.zone()),
                standard_time,
            },
            None => Layout {
                middle_m: geocentric.into(),
                wkt: wkt::geocentric(self.ellipsoid),
                standard_time,
            },
        }
    }

    fn points(&self, points: &[Placed]) -> Result<Vec<CloudPoint>, CliError> {
        let Some(utm) = &self.utm else {
            return Ok(points
                .iter()
                .map(|p| cloud_point(p, p.position.coordinates.into()))
                .collect());
        };
        let geodetic: Vec<_> = points
            .iter()
            .map(|p| self.ellipsoid.to_geodetic(&p.position))
            .collect();
        let mut first: Vec<f64> = geodetic.iter().map(|g| g.longitude_rad).collect();
        let mut second: Vec<f64> = geodetic.iter().map(|g| g.latitude_rad).collect();
        utm.from_geodetic_in_place(&mut first, &mut second)?;
        let place = |k: usize| [first[k], second[k], geodetic[k].height_m];
        Ok(points
            .iter()
            .enumerate()
            .map(|(k, p)| cloud_point(p, place(k)))
            .collect())
    }
}

/// The surface that is gathered while the cloud is written.
struct Surface<'a> {
    file: &'a Path,
    grid: Grid,
    cell_m: f64,
    ellipsoid: Ellipsoid,
    zone: i8,
}

impl<'a> Surface<'a> {
    /// Where one is asked for.
    fn asked(args: &'a Apply, system: &System) -> Result<Option<Self>, CliError> {
        let Some(file) = &args.surface else {
            return Ok(None);
        };
        let utm = system.utm.as_ref().ok_or(CliError::NoPlane)?;
        Ok(Some(Self {
            file,
            grid: Grid::new(args.cell),
            cell_m: args.cell,
            ellipsoid: system.ellipsoid,
            zone: utm.zone(),
        }))
    }

    fn add(&mut self, points: &[CloudPoint]) {
        for point in points.iter().filter(|p| p.on_surface) {
            self.grid.add(point.position_m);
        }
    }

    /// Writes it; the number of its cells.
    fn written(self) -> Result<u64, CliError> {
        let refused = |found: String, expected: &str| CliError::Surface {
            file: self.file.to_owned(),
            found,
            expected: expected.to_owned(),
        };
        let Some(extent) = self.grid.extent() else {
            return Err(refused("no soundings on it".to_owned(), "some"));
        };
        let [width, height] = extent.size;
        if width.saturating_mul(height) > MOST_CELLS {
            let found = format!("{width} by {height} cells");
            let expected = format!("at most {MOST_CELLS}: wider ones by --cell");
            return Err(refused(found, &expected));
        }
        let raster = Raster {
            ellipsoid: self.ellipsoid,
            zone: self.zone,
            corner_m: self.grid.corner_m(&extent),
            cell_m: self.cell_m,
            width: width as u32,
            height: height as u32,
        };
        geotiff::write(self.file, &raster, &self.grid.bands(&extent))?;
        Ok(width * height)
    }
}

fn cloud_point(point: &Placed, position_m: [f64; 3]) -> CloudPoint {
    let beam = point.beam;
    CloudPoint {
        time_s: point.time_s,
        position_m,
        source: point.source,
        sounding: point.sounding,
        on_surface: point.on_surface,
        extra: [
            point.row,
            beam.map_or(NOTHING, |b| b.ping),
            beam.map_or(NOTHING, |b| b.beam),
        ],
    }
}
