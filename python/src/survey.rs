//! Surveys from files and from arrays, and what can be done with them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use boresight::adjust::Figures;
use boresight::calibrate::choices::Method;
use boresight::calibrate::cloud::{Calibrated, SensorModel};
use boresight::nalgebra::{Matrix3, Vector3};
use boresight::observe::{
    Acts, Extra, GeodeticTrajectory, LaserCoordinates, LaserNoise, LaserScan, Mounting, Outside,
    SonarNoise, SoundSpeed, SoundSpeedProfile, SoundingRange, Soundings, TrajectoryNoise,
};
use boresight::procedures::pool::influence::observations;
use boresight::procedures::pool::procedure::input;
use boresight::procedures::pool::summary::residuals::{Residuals, sounding_point};
use boresight::procedures::pool::survey::{Arrays, LoadedSurvey, load, parse_target};
use boresight::procedures::pool::ties::{PlacedBy, Reason, Tie, TieSet};
use boresight::procedures::pool::{PoolInput, Scene, calibrate};
use boresight::procedures::{of_file, scenario, scenario_text};
use boresight::results::InputFile;
use boresight::watch::Watch;
use boresight::{InputError, Loaded, Settings};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;

use super::arrays::{Given, rows};
use super::errors::Failure;
use super::finished::Finished;
use super::work::{Caller, run, run_with};

/// The procedure whose observations can be had as arrays.
const POOL: &str = "pool";

/// What was read. Every procedure is worked with through [`Loaded`]; one of them can also show its columns.
enum Observed {
    Pool(Box<LoadedSurvey>),
    Other(Box<dyn Loaded>),
}

impl Observed {
    fn loaded(&self) -> &dyn Loaded {
        match self {
            Self::Pool(survey) => &**survey,
            Self::Other(survey) => &**survey,
        }
    }
}

/// A survey in memory.
#[pyclass(frozen, module = "boresight._core")]
pub struct Survey {
    /// Its procedure's name.
    #[pyo3(get)]
    procedure: String,
    observed: Arc<Observed>,
}

impl Survey {
    /// The same survey for another thread.
    pub fn shared(&self) -> SharedSurvey {
        SharedSurvey(Arc::clone(&self.observed))
    }
}

/// A survey for another thread.
pub struct SharedSurvey(Arc<Observed>);

impl SharedSurvey {
    /// It behind the seam.
    pub fn loaded(&self) -> &dyn Loaded {
        self.0.loaded()
    }
}

#[pymethods]
impl Survey {
    /// Reads a survey file and every file that it names.
    #[staticmethod]
    #[pyo3(signature = (path, progress=None))]
    fn read(py: Python<'_>, path: PathBuf, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let (procedure, observed) = run(py, None, progress, move |caller| {
            caller.step("reading");
            let procedure = of_file(&path)?;
            let observed = if procedure.name() == POOL {
                Observed::Pool(Box::new(load(&path)?))
            } else {
                Observed::Other(procedure.read(&path)?)
            };
            Ok((procedure.name(), observed))
        })?;
        Ok(Self {
            procedure: procedure.to_owned(),
            observed: Arc::new(observed),
        })
    }

    /// A pool survey from the keys of a survey file and a target file as JSON, and columns in memory.
    #[staticmethod]
    fn from_arrays(
        py: Python<'_>,
        survey: &str,
        target: &str,
        columns: &Bound<'_, PyDict>,
    ) -> PyResult<Self> {
        let texts = toml_text(survey).and_then(|s| Ok((s, toml_text(target)?)));
        let (text, target) = texts.map_err(|failure| failure.raise(py))?;
        let arrays = arrays(&Given(columns), target)?;
        let survey = run(py, None, None, move |_| {
            Ok(LoadedSurvey::from_arrays(&text, arrays)?)
        })?;
        Ok(Self {
            procedure: POOL.to_owned(),
            observed: Arc::new(Observed::Pool(Box::new(survey))),
        })
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        self.observed.loaded().name()
    }

    /// Path and SHA-256 of every file that was read.
    #[getter]
    fn inputs(&self) -> Vec<(String, String)> {
        let all = self.observed.loaded().inputs().iter();
        all.map(|i| (i.path.clone(), i.sha256.clone())).collect()
    }

    /// The survey file with every default filled in, as JSON.
    fn configuration(&self, py: Python<'_>) -> PyResult<String> {
        let configuration = self.observed.loaded().configuration();
        let configuration = configuration.map_err(|e| Failure::from(e).raise(py))?;
        Ok(configuration.to_string())
    }

    /// The target file as JSON; `None` but of a pool survey.
    fn target(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let Observed::Pool(survey) = &*self.observed else {
            return Ok(None);
        };
        let text = serde_json::to_string(&survey.target_model);
        text.map(Some).map_err(|e| Failure::from(e).raise(py))
    }

    /// The columns of a pool survey by name, copied, and its noise; `None` of another.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        match &*self.observed {
            Observed::Pool(survey) => columns(py, survey).map(Some),
            Observed::Other(_) => Ok(None),
        }
    }

    /// What was read and what the geometry determines: in words, as JSON, and whether everything that is sought is determined.
    #[pyo3(signature = (seed=None, threads=None, progress=None))]
    fn check(
        &self,
        py: Python<'_>,
        seed: Option<u64>,
        threads: Option<usize>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(String, String, bool)> {
        let (survey, procedure) = (self.shared(), self.procedure.clone());
        run(py, threads, progress, move |caller| {
            let settings = settings("both", seed, false, Arc::default(), &procedure)?;
            let found = survey.loaded().check(&settings, caller)?;
            Ok((found.text, found.json.to_string(), found.determined))
        })
    }

    /// Calibrates it; `truth` is the content of a simulated survey's `truth.json`. `workers` asks other processes about the blocks of a
    /// long trajectory, which answer by [`super::blocks::BlockWorker`].
    #[pyo3(signature = (method, seed=None, simple=false, extra=vec![], truth=None, threads=None, progress=None, workers=None))]
    #[expect(clippy::too_many_arguments, reason = "the package gives them by name")]
    fn calibrate(
        &self,
        py: Python<'_>,
        method: &str,
        seed: Option<u64>,
        simple: bool,
        extra: Vec<OwnUnknown<'_>>,
        truth: Option<String>,
        threads: Option<usize>,
        progress: Option<&Bound<'_, PyAny>>,
        workers: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Finished> {
        let (survey, procedure) = (self.shared(), self.procedure.clone());
        let (method, extras) = (method.to_owned(), extras(extra)?);
        let found = run_with(py, threads, progress, workers, move |caller| {
            let settings = settings(&method, seed, simple, extras, &procedure)?;
            let truth = truth.map(|text| serde_json::from_str(&text)).transpose()?;
            Ok(survey
                .loaded()
                .calibrate(&settings, truth.as_ref(), caller)?)
        })?;
        Ok(Finished(found))
    }

    /// Rows `first`, `first + step`, ... of a pool survey's soundings or returns in the refined target frame, metres, shape (n, 3);
    /// NaN where an observation has no position. `model` is rotation by rows, lever arm, latency and range scale; without one the
    /// nominal mounting.
    #[pyo3(signature = (sensor, model, first, step, count, threads=None))]
    #[expect(clippy::too_many_arguments, reason = "the package gives them by name")]
    fn georeference<'py>(
        &self,
        py: Python<'py>,
        sensor: &str,
        model: Option<[f64; 14]>,
        first: usize,
        step: usize,
        count: usize,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (survey, soundings) = (self.shared(), sensor == "soundings");
        let flat = run(py, threads, None, move |_| {
            let Observed::Pool(survey) = &*survey.0 else {
                let text =
                    "georeference: found a survey of another procedure, expected a pool survey";
                return Err(Failure::Refused(text.to_owned()));
            };
            let nominal = SensorModel::plain(survey.campaign.sonar);
            let model = PlacedBy::from(model.map_or(nominal, |m| sensor_model(&m)));
            let scene = Scene::prepare(&survey.campaign, &survey.target, &survey.pose)
                .map_err(InputError::unworkable)?;
            let place = |k: usize| -> [f64; 3] {
                let row = first + k * step;
                let point = if soundings {
                    sounding_point(&scene, row, &model)
                } else {
                    scene.laser_point(row).map(|point| point.0)
                };
                point.map_or([f64::NAN; 3], Into::into)
            };
            let mut flat = vec![0.0; 3 * count];
            let placed = flat.par_chunks_exact_mut(3).enumerate();
            placed
                .with_min_len(4096)
                .for_each(|(k, row)| row.copy_from_slice(&place(k)));
            Ok(flat)
        })?;
        rows(py, flat)
    }

    /// Calibrates a pool survey and says of every sounding and return on which face it lies (-1: on none), how far from it, outwards,
    /// metres (NaN: nowhere), and how well it is controlled; and the names of the faces.
    #[pyo3(signature = (method, seed=None, extra=vec![], threads=None, progress=None))]
    fn residuals<'py>(
        &self,
        py: Python<'py>,
        method: &str,
        seed: Option<u64>,
        extra: Vec<OwnUnknown<'_>>,
        threads: Option<usize>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (survey, procedure) = (self.shared(), self.procedure.clone());
        let (method, extras) = (method.to_owned(), extras(extra)?);
        let (names, soundings, returns) = run(py, threads, progress, move |caller| {
            let settings = settings(&method, seed, false, extras, &procedure)?;
            let Observed::Pool(survey) = &*survey.0 else {
                let text = "residuals: found a survey of another procedure, expected a pool survey";
                return Err(Failure::Refused(text.to_owned()));
            };
            on_faces(survey, &settings, caller)
        })?;
        let all = PyDict::new(py);
        all.set_item("faces", names)?;
        all.set_item("reasons", Reason::ALL.map(Reason::name))?;
        soundings.put(py, "soundings", &all)?;
        returns.put(py, "laser", &all)?;
        Ok(all)
    }

    /// All points of a survey under a model, in order of time: geocentric metres (n, 3), seconds, source counted from 1, row in its
    /// file; and the names of the sources. `None` where the procedure's sensors give no points. `of` is the result whose solution of
    /// that name the model is: what it found of heave and heights of lines is applied too.
    #[pyo3(signature = (model, of=None, threads=None, progress=None))]
    fn cloud<'py>(
        &self,
        py: Python<'py>,
        model: [f64; 14],
        of: Option<(Py<Finished>, String)>,
        threads: Option<usize>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let survey = self.shared();
        let found = run(py, threads, progress, move |caller| {
            let inputs = survey.loaded().inputs();
            let calibrated = calibrated(sensor_model(&model), of.as_ref(), inputs);
            let Some(cloud) = survey.loaded().cloud(&calibrated)? else {
                return Ok(None);
            };
            let (total, sources) = (cloud.total, cloud.sources);
            let mut points = Points::default();
            for chunk in cloud.chunks {
                caller.count("georeferencing", points.time_s.len() as u64, total as u64);
                if caller.stopped() {
                    return Err(Failure::Stopped);
                }
                points.add(&chunk?);
            }
            Ok(Some((points, sources)))
        })?;
        let Some((points, sources)) = found else {
            return Ok(None);
        };
        let all = PyDict::new(py);
        all.set_item("xyz_m", rows(py, points.xyz_m)?)?;
        all.set_item("time_s", PyArray1::from_vec(py, points.time_s))?;
        all.set_item("source", PyArray1::from_vec(py, points.source))?;
        all.set_item("row", PyArray1::from_vec(py, points.row))?;
        all.set_item("sources", sources)?;
        Ok(Some(all))
    }
}

/// Every observation of one sensor, by column; NaN where it was not used.
struct OnFaces {
    face: Vec<i16>,
    reason: Vec<u8>,
    residual_m: Vec<f64>,
    sigma_m: Vec<f64>,
    redundancy: Vec<f64>,
    normalised: Vec<f64>,
}

impl OnFaces {
    fn put(self, py: Python<'_>, sensor: &str, all: &Bound<'_, PyDict>) -> PyResult<()> {
        all.set_item(format!("{sensor}.face"), PyArray1::from_vec(py, self.face))?;
        all.set_item(
            format!("{sensor}.reason"),
            PyArray1::from_vec(py, self.reason),
        )?;
        let put =
            |name, values| all.set_item(format!("{sensor}.{name}"), PyArray1::from_vec(py, values));
        put("residual_m", self.residual_m)?;
        put("sigma_m", self.sigma_m)?;
        put("redundancy", self.redundancy)?;
        put("normalised", self.normalised)
    }
}

/// Names of the faces; soundings and returns on them under the solution that decides.
fn on_faces(
    survey: &LoadedSurvey,
    settings: &Settings,
    caller: &Caller<'_>,
) -> Result<(Vec<String>, OnFaces, OnFaces), Failure> {
    let input = PoolInput {
        extras: &settings.extras,
        ..input(survey, settings)
    };
    let outcome = calibrate(&input, caller).map_err(InputError::unworkable)?;
    let residuals = Residuals::of(&outcome);
    let model = residuals.models.joint.or(residuals.models.reference);
    let of_sounding = |tie: &Tie| residuals.distance_m(&outcome, tie, model.as_ref()?);
    let of_return = |tie: &Tie| {
        let plane = residuals.faces[usize::from(tie.face)]?;
        Some(plane.distance_m(&outcome.scene.laser_point(tie.row as usize)?.0))
    };
    let joint = outcome.joint.as_ref();
    caller.step("judging every observation");
    let figures = joint.map(|joint| observations(&outcome.scene, joint, input.joint));
    let figures = figures.transpose();
    let mut figures = figures.map_err(InputError::unworkable)?.unwrap_or_default();
    figures.resize(2, vec![]);
    let soundings = (&residuals.ties, &figures[0][..]);
    let soundings = tied(survey, survey.counts.soundings, soundings, &of_sounding);
    let returns = joint.map_or(&outcome.returns, |joint| &joint.returns);
    let returns = (returns, &figures[1][..]);
    let returns = tied(survey, survey.counts.laser, returns, &of_return);
    let names = survey.target.faces.iter().map(|face| face.name.clone());
    Ok((names.collect(), soundings, returns))
}

/// Figures are there where the joint path ran, one a tie; their signs become those of distances outwards.
fn tied(
    survey: &LoadedSurvey,
    rows: usize,
    (ties, figures): (&TieSet, &[Figures]),
    distance_m: &dyn Fn(&Tie) -> Option<f64>,
) -> OnFaces {
    let nothing = || vec![f64::NAN; rows];
    let mut all = OnFaces {
        face: vec![-1; rows],
        reason: (0..rows).map(|row| ties.reason(row) as u8).collect(),
        residual_m: nothing(),
        sigma_m: nothing(),
        redundancy: nothing(),
        normalised: nothing(),
    };
    for (k, tie) in ties.iter().enumerate() {
        let row = tie.row as usize;
        all.face[row] = i16::try_from(tie.face).unwrap_or(i16::MAX);
        all.residual_m[row] = distance_m(&tie).unwrap_or(f64::NAN);
        if let Some(one) = figures.get(k) {
            all.sigma_m[row] = one.sigma;
            all.redundancy[row] = one.redundancy;
            let outwards = survey.target.faces[usize::from(tie.face)].facing.signum();
            all.normalised[row] = outwards * one.normalised;
        }
    }
    all
}

/// Points by column.
#[derive(Default)]
struct Points {
    xyz_m: Vec<f64>,
    time_s: Vec<f64>,
    source: Vec<u16>,
    row: Vec<u32>,
}

impl Points {
    fn add(&mut self, chunk: &[boresight::calibrate::cloud::Placed]) {
        for point in chunk {
            self.xyz_m.extend(point.position.coordinates.iter());
            self.time_s.push(point.time_s);
            self.source.push(point.source);
            self.row.push(point.row);
        }
    }
}

/// An unknown of the caller's own: name, unit, what it acts on, derivatives, prior sigma.
type OwnUnknown<'py> = (
    String,
    String,
    String,
    PyReadonlyArray1<'py, f64>,
    Option<f64>,
);

fn extras(given: Vec<OwnUnknown<'_>>) -> PyResult<Arc<[Extra]>> {
    let one = |(name, unit, acts, derivative, prior_sigma): OwnUnknown<'_>| {
        Ok(Extra {
            name,
            unit,
            acts: match acts.as_str() {
                "range" => Acts::Range,
                "across" => Acts::Across,
                "along" => Acts::Along,
                _ => Acts::Up,
            },
            derivative: derivative.as_slice()?.to_vec(),
            prior_sigma,
        })
    };
    given.into_iter().map(one).collect()
}

/// Settings that the procedure has a use for.
pub fn settings(
    method: &str,
    seed: Option<u64>,
    simple: bool,
    extras: Arc<[Extra]>,
    procedure: &str,
) -> Result<Settings, Failure> {
    let method = match method {
        "both" => Method::Both,
        "joint" => Method::Joint,
        "reference" => Method::Reference,
        other => {
            let text =
                format!("method: found \"{other}\", expected \"both\", \"joint\" or \"reference\"");
            return Err(Failure::Refused(text));
        }
    };
    let settings = Settings {
        method,
        seed,
        simple,
        extras,
    };
    match boresight::procedures::find(procedure).map(|procedure| settings.fit(procedure)) {
        // the command's option is the package's argument
        Some(Err(error)) => Err(Failure::Refused(error.to_string().replacen("--", "", 1))),
        _ => Ok(settings),
    }
}

fn sensor_model(m: &[f64; 14]) -> SensorModel {
    SensorModel {
        mounting: Mounting {
            rotation: Matrix3::from_row_slice(&m[..9]),
            lever_arm_m: Vector3::new(m[9], m[10], m[11]),
        },
        latency_s: m[12],
        range_scale: m[13],
    }
}

/// What a solution of a result changes of a survey with these inputs, by a sensor model that is its own; the sensor alone without one.
fn calibrated(
    sensor: SensorModel,
    of: Option<&(Py<Finished>, String)>,
    inputs: &[InputFile],
) -> Calibrated {
    let found = of.and_then(|(finished, name)| {
        let result = &finished.get().0.result;
        let mut named = result.solutions.named();
        let (_, solution) = named.find(|(known, _)| known == name)?;
        let mut found = Calibrated::of(result, solution)?;
        found.without_heights_of_others(result, inputs);
        Some(found)
    });
    let plain = Calibrated::from(sensor);
    found.map_or(plain, |found| Calibrated { sensor, ..found })
}

/// A table of keys given as JSON, as TOML.
fn toml_text(json: &str) -> Result<String, Failure> {
    let value: serde_json::Value = serde_json::from_str(json)?;
    toml::to_string(&value).map_err(|e| Failure::Refused(format!("config: {e}")))
}

fn arrays(given: &Given<'_, '_>, target: String) -> PyResult<Arrays> {
    Ok(Arrays {
        trajectory: trajectory(given)?,
        laser: laser(given)?,
        soundings: soundings(given)?,
        sound_speed: sound_speed(given)?,
        target,
    })
}

fn trajectory(given: &Given<'_, '_>) -> PyResult<GeodeticTrajectory> {
    let column = |name: &str| given.column(&format!("trajectory.{name}"));
    let [
        position_m,
        position_drift_m,
        drift_correlation_time_s,
        roll_pitch_rad,
        heading_rad,
        heading_drift_rad,
    ] = given.figures("trajectory.noise")?;
    Ok(GeodeticTrajectory {
        ellipsoid: boresight::geometry::Ellipsoid::Wgs84,
        time_s: column("time_s")?,
        latitude_rad: column("latitude_rad")?,
        longitude_rad: column("longitude_rad")?,
        height_m: column("height_m")?,
        roll_rad: column("roll_rad")?,
        pitch_rad: column("pitch_rad")?,
        heading_rad: column("heading_rad")?,
        velocity_m_s: given.triples("trajectory.velocity_m_s")?,
        noise: TrajectoryNoise {
            position_m,
            position_drift_m,
            drift_correlation_time_s,
            roll_pitch_rad,
            heading_rad,
            heading_drift_rad,
        },
        // these two stand in the survey's keys
        max_gap_s: 1.0,
        outside: Outside::Error,
    })
}

fn laser(given: &Given<'_, '_>) -> PyResult<LaserScan> {
    let column = |name: &str| given.column(&format!("laser.{name}"));
    let [range_m, angle_rad, point_m] = given.figures("laser.noise")?;
    Ok(LaserScan {
        time_s: column("time_s")?,
        x_m: column("x_m")?,
        y_m: column("y_m")?,
        z_m: column("z_m")?,
        // the frame stands in the survey's keys
        coordinates: LaserCoordinates::Sensor,
        noise: LaserNoise {
            range_m,
            angle_rad,
            point_m,
        },
    })
}

fn soundings(given: &Given<'_, '_>) -> PyResult<Soundings> {
    let column = |name: &str| given.column(&format!("soundings.{name}"));
    let [range_m, across_rad, along_rad] = given.figures("soundings.noise")?;
    let range = column("range")?;
    let travel_time = given.text("soundings.kind")? == "travel_time_s";
    Ok(Soundings {
        time_s: column("time_s")?,
        ping: given.numbers("soundings.ping")?,
        beam: given.numbers("soundings.beam")?,
        across_rad: column("across_rad")?,
        along_rad: column("along_rad")?,
        range: if travel_time {
            SoundingRange::TwoWayTravelTime(range)
        } else {
            SoundingRange::Metres(range)
        },
        noise: SonarNoise {
            range_m,
            across_rad,
            along_rad,
        },
        arrays: None,
        file: None,
    })
}

/// No depths and no speed: none; no depths and one speed: that everywhere; else a profile.
fn sound_speed(given: &Given<'_, '_>) -> PyResult<Option<SoundSpeed>> {
    let (depth_m, speed_m_s) = (
        given.column("sound_speed.depth_m")?,
        given.column("sound_speed.speed_m_s")?,
    );
    Ok(match (depth_m.is_empty(), speed_m_s.as_slice()) {
        (true, []) => None,
        (true, [speed]) => Some(SoundSpeed::Constant(*speed)),
        _ => Some(SoundSpeed::Profile(SoundSpeedProfile {
            depth_m,
            speed_m_s,
        })),
    })
}

/// The columns of a survey by the names that [`arrays`] takes.
fn columns<'py>(py: Python<'py>, survey: &LoadedSurvey) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    let put = |name: &str, values: &[f64]| all.set_item(name, PyArray1::from_slice(py, values));
    let (t, l, s) = (
        &survey.campaign.trajectory,
        &survey.campaign.laser,
        &survey.campaign.soundings,
    );
    put("trajectory.time_s", &t.time_s)?;
    put("trajectory.latitude_rad", &t.latitude_rad)?;
    put("trajectory.longitude_rad", &t.longitude_rad)?;
    put("trajectory.height_m", &t.height_m)?;
    put("trajectory.roll_rad", &t.roll_rad)?;
    put("trajectory.pitch_rad", &t.pitch_rad)?;
    put("trajectory.heading_rad", &t.heading_rad)?;
    let velocity = t.velocity_m_s.as_ref();
    let velocity = velocity.map(|v| rows(py, v.as_flattened().to_vec()));
    all.set_item("trajectory.velocity_m_s", velocity.transpose()?)?;
    let n = &t.noise;
    let noise = [
        n.position_m,
        n.position_drift_m,
        n.drift_correlation_time_s,
        n.roll_pitch_rad,
        n.heading_rad,
        n.heading_drift_rad,
    ];
    all.set_item("trajectory.noise", noise)?;
    put("laser.time_s", &l.time_s)?;
    put("laser.x_m", &l.x_m)?;
    put("laser.y_m", &l.y_m)?;
    put("laser.z_m", &l.z_m)?;
    let n = &l.noise;
    all.set_item("laser.noise", [n.range_m, n.angle_rad, n.point_m])?;
    let frame = match l.coordinates {
        LaserCoordinates::Sensor => "sensor",
        LaserCoordinates::Target => "target",
        LaserCoordinates::Geocentric => "geocentric",
    };
    all.set_item("laser.frame", frame)?;
    let s = &s.every(1);
    put("soundings.time_s", &s.time_s)?;
    put("soundings.across_rad", &s.across_rad)?;
    put("soundings.along_rad", &s.along_rad)?;
    put("soundings.range", s.range.values())?;
    all.set_item("soundings.ping", PyArray1::from_slice(py, &s.ping))?;
    all.set_item("soundings.beam", PyArray1::from_slice(py, &s.beam))?;
    let kind = match s.range {
        SoundingRange::Metres(_) => "range_m",
        SoundingRange::TwoWayTravelTime(_) => "travel_time_s",
    };
    all.set_item("soundings.kind", kind)?;
    let n = &s.noise;
    all.set_item("soundings.noise", [n.range_m, n.across_rad, n.along_rad])?;
    let (depth_m, speed_m_s): (&[f64], &[f64]) = match &survey.campaign.sound_speed {
        None => (&[], &[]),
        Some(SoundSpeed::Constant(speed)) => (&[], std::slice::from_ref(speed)),
        Some(SoundSpeed::Profile(p)) => (&p.depth_m, &p.speed_m_s),
    };
    put("sound_speed.depth_m", depth_m)?;
    put("sound_speed.speed_m_s", speed_m_s)?;
    Ok(all)
}

/// Simulates a scenario and writes a complete survey into a folder; the content of `truth.json`, and how much was written.
#[pyfunction]
#[pyo3(signature = (file, text, folder, seed=None, progress=None))]
pub fn simulate(
    py: Python<'_>,
    file: PathBuf,
    text: Option<String>,
    folder: PathBuf,
    seed: Option<u64>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(String, Vec<(String, usize)>)> {
    run(py, None, progress, move |caller| {
        let run = scenario_of(&file, text.as_deref())?;
        let made = run.write(seed.unwrap_or(run.seed()), &folder, caller)?;
        let counts = made.counts.iter().map(|c| (c.key.to_owned(), c.count));
        Ok((made.truth.to_string(), counts.collect()))
    })
}

/// The target file at a path, checked, as JSON.
#[pyfunction]
pub fn read_target(py: Python<'_>, path: PathBuf) -> PyResult<String> {
    let read = || -> Result<String, Failure> {
        let text = boresight::formats::error::read_text(&path).map_err(InputError::from)?;
        let (model, _) = parse_target(&path, &text)?;
        Ok(serde_json::to_string(&model)?)
    };
    read().map_err(|failure| failure.raise(py))
}

/// A scenario from its text, or from its file.
pub fn scenario_of(
    file: &Path,
    text: Option<&str>,
) -> Result<Box<dyn boresight::ScenarioRun>, Failure> {
    Ok(match text {
        Some(text) => scenario_text(file, text)?,
        None => scenario(file)?,
    })
}
