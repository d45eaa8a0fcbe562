//! `boresight apply`: all points of a survey georeferenced with a calibration.

use std::path::Path;

use indicatif::ProgressBar;
use nalgebra::{Matrix3, Vector3};

use super::Ending;
use super::args::{Apply, CoordinatesName, SolutionName};
use super::error::CliError;
use super::out::free_for_cloud;
use super::result_file::read_result;
use super::talk::Talk;
use crate::formats::FormatError;

use crate::formats::las::stream::{self, CloudPoint, Layout, is_standard_time};
use crate::formats::las::wkt;
use crate::geometry::Ellipsoid;
use crate::geometry::utm::Utm;
use crate::observe::Mounting;
use crate::procedures;
use crate::procedures::pool::apply::{Georeferenced, Sensor, points};
use crate::procedures::pool::summary::residuals::Model;
use crate::procedures::pool::survey;
use crate::procedures::pool::{PoolError, Scene};
use crate::results::{Calibration, Solution};

/// Runs the command.
pub fn run(args: &Apply, talk: &Talk) -> Result<Ending, CliError> {
    refuse_extension(&args.out)?;
    talk.step(&format!("reading {}", args.survey.display()));
    procedures::of_file(&args.survey)?;
    let survey = survey::load(&args.survey)?;
    free_for_cloud(
        &args.out,
        &args.survey,
        &survey.inputs,
        &args.calibration,
        args.force,
    )?;
    talk.step(&format!("reading {}", args.calibration.display()));
    let model = model(&args.calibration, args.solution)?;
    let scene =
        Scene::prepare(&survey.campaign, &survey.target, &survey.pose).map_err(PoolError::from)?;
    let system = System::new(args.coordinates, &scene)?;
    let total = survey.campaign.laser.len() + survey.campaign.soundings.len();
    let bar = talk.bar("georeferencing", total as u64);
    let chunks = points(&scene, model).map(|chunk| counted(&bar, system.cloud(&chunk)));
    let written = stream::write(&args.out, &system.layout(&scene), chunks)?;
    bar.finish_and_clear();
    let text = format!(
        "Wrote {written} of {total} points to {} ({}; point source id 1 laser, 2 multibeam).\n",
        args.out.display(),
        system.name()
    );
    let json = serde_json::json!({ "file": args.out, "points": written, "read": total, "coordinates": system.name() });
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

fn refuse_extension(path: &Path) -> Result<(), CliError> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    if matches!(extension.as_deref(), Some("las" | "laz")) {
        return Ok(());
    }
    Err(FormatError::unknown_extension(path, ".laz or .las").into())
}

/// The sensor model of one solution of a result file.
fn model(path: &Path, solution: SolutionName) -> Result<Model, CliError> {
    let result = read_result(path)?;
    let (name, found) = chosen(&result, solution);
    let refused = |found: &str| CliError::NoSolution {
        file: path.to_owned(),
        name,
        found: found.to_owned(),
    };
    if result.procedure != "pool" {
        return Err(refused(&format!(
            "a result of procedure {}",
            result.procedure
        )));
    }
    let found = found.ok_or_else(|| refused("nothing"))?;
    if !found.usable {
        return Err(refused(&format!(
            "one that is not usable ({})",
            found.message
        )));
    }
    of_solution(found).ok_or_else(|| refused("one without matrices"))
}

fn chosen(result: &Calibration, name: SolutionName) -> (&'static str, Option<&Solution>) {
    let solutions = &result.solutions;
    match name {
        SolutionName::Reference => ("reference", solutions.reference.as_ref()),
        SolutionName::Joint => ("joint", solutions.joint.as_ref()),
        SolutionName::JointSimple => ("joint_simple", solutions.joint_simple.as_ref()),
    }
}

fn of_solution(solution: &Solution) -> Option<Model> {
    let value = |name: &str| solution.parameter(name).and_then(|p| p.value);
    let mounting = solution.mountings.first()?;
    let rotation = mounting.rotation_matrix.into_iter().flatten();
    Some(Model {
        mounting: Mounting {
            rotation: Matrix3::from_row_iterator(rotation),
            lever_arm_m: Vector3::from(mounting.lever_arm_m?),
        },
        latency_s: value("latency").unwrap_or(0.0),
        range_scale: value("range_scale").unwrap_or(0.0),
    })
}

/// The coordinate system of the written points.
struct System {
    ellipsoid: Ellipsoid,
    utm: Option<Utm>,
}

impl System {
    fn new(name: CoordinatesName, scene: &Scene) -> Result<Self, CliError> {
        let ellipsoid = scene.pose.ellipsoid;
        let utm = match name {
            CoordinatesName::Geocentric => None,
            CoordinatesName::Utm => Some(Utm::new(ellipsoid, Utm::zone_of(&scene.pose.origin))?),
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

    /// The target's origin is the middle.
    fn layout(&self, scene: &Scene) -> Layout {
        let origin = &scene.pose.origin;
        let standard_time = is_standard_time(&scene.campaign.soundings.time_s);
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

    fn cloud(&self, points: &[Georeferenced]) -> Result<Vec<CloudPoint>, CliError> {
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

fn cloud_point(point: &Georeferenced, position_m: [f64; 3]) -> CloudPoint {
    let source = match point.sensor {
        Sensor::Laser => 1,
        Sensor::Multibeam => 2,
    };
    CloudPoint {
        time_s: point.time_s,
        position_m,
        source,
    }
}
