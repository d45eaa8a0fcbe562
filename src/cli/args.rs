//! What the user types.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand, ValueEnum, ValueHint};

use crate::calibrate::choices::Method;
use crate::calibrate::vary::Vary;
use crate::procedures;
use crate::report::Export;

const ABOUT: &str = "Boresight angles and lever arms of survey sensors by least-squares adjustment, with standard deviations that hold";

/// What the program is for, with one line for each procedure.
fn long_about() -> String {
    let procedures: Vec<String> = procedures::ALL
        .iter()
        .map(|p| format!("  {:8} {}", p.name(), p.about()))
        .collect();
    format!(
        "{ABOUT}.\n\n\
        How is the sensor really mounted? Each procedure answers by two paths that are compared: the reference path of its source \
        document, step after step, and one joint adjustment of everything, which also states standard deviations, correlations and \
        what the data do not determine. The survey file says which procedure it is for.\n\nPROCEDURES\n{}",
        procedures.join("\n")
    )
}

const AFTER: &str = "\
EXAMPLES
  boresight demo                   simulate, calibrate, report: no input needed
  boresight template pool          a survey file to fill in
  boresight check survey.toml      is it readable, and what will it determine?
  boresight calibrate survey.toml  calibrate your own data by both paths
  boresight calibrate survey.toml --export sis
                                   and a card of the values for Kongsberg SIS
  boresight apply survey.toml --calibration result.json --out cloud.laz
  boresight budget demo            which error source costs how much?
  boresight plan survey.toml --wanted yaw=0.01
                                   which pass to sail next, how many are needed?

FILES
  survey.toml    the procedure, the files of the observations, their noise;
                 paths are relative to it
  target.toml    the target in its own frame
  result.json    everything that was found, units in the names; the same input
                 and seed give the same bytes
  report.html    the same with pictures; one file, opens offline
  parameters.csv the numbers to enter, with their standard deviations

EXIT CODES
  0   a usable result
  1   no usable result; result.json and report.html say why (usable: false)
  2   bad usage or bad input; nothing was written
  130 stopped by Ctrl-C: nothing is left half written, and budget keeps its
      trials";

const BUDGET_AFTER: &str = "\
EXAMPLES
  Errors of both paths, and are the reported sigmas right? 1000 surveys:
    boresight budget models/scenarios/single-pass-thin.toml --trials 1000

  The same, and what each source does alone (200 surveys each):
    boresight budget models/scenarios/single-pass-thin.toml \\
      --trials 1000 --single 200

  What the errors claimed in a survey file do to its own calibration:
    boresight budget survey.toml

  Is a drift of 5 mm small enough for 0.05 deg of yaw? By propagation, in
  seconds; the answer stands first:
    boresight budget demo --wanted yaw=0.05 \\
      --vary trajectory.position_drift_sigma_m=0.001,0.002,0.005,0.01

  A scenario whose procedure has no propagation runs 200 trials of all sources
  and 50 of each alone unless you say otherwise:
    boresight budget models/scenarios/usbl.toml

  Which tilt of the multibeam is best? 30 to 60 degrees in steps of 5:
    boresight budget scenario.toml --trials 200 \\
      --vary multibeam.tilt_deg=30:60:5

  INS drift against distance, a table of pairs:
    boresight budget scenario.toml --trials 100 \\
      --vary trajectory.position_drift_sigma_m=0.001,0.005,0.02 \\
      --vary 'pass.*.distance_m=5:9:2'

  A long run, stopped with Ctrl-C and continued later, also with more trials or
  on another number of threads:
    boresight budget scenario.toml --trials 10000 --out big
    boresight budget scenario.toml --trials 10000 --out big --resume

  On a cluster, 20 parts of 500 trials as an array job of Slurm (no seed twice):
    #SBATCH --array=0-19
    ID=$SLURM_ARRAY_TASK_ID
    boresight budget scenario.toml --trials 500 --seed $((1 + 500 * ID)) \\
      --only-trials --out part-$ID
  and then, on any one machine, what a single run of 10000 would have given:
    boresight budget scenario.toml --join part-* --out all
  Say the same --vary for the parts and for the joining; --single is as large
  as --trials in every part, or given only in the part of the first seeds.

KEYS OF --vary
  A dotted path in the scenario file, in its units:
    trajectory.position_drift_sigma_m, multibeam.beams,
    multibeam.mounting_deg.roll
    sources.gross_errors             a factor
    pass.0.distance_m                of the first pass; pass.*.distance_m of all
    lidar.mounting_sigma_deg.2       the third of a list
    multibeam.tilt_deg               stands for -multibeam.mounting_deg.roll

FILES WRITTEN
  OUT/report.html   pictures first; one file, opens offline
  OUT/result.json   every figure, with units in the names
  OUT/budget.csv    one row per path, source and parameter
  OUT/sweep.csv     one row per point, path and parameter, with --vary
  OUT/trials/       the ledgers: one line per trial with its errors and
                    covariance, for research of your own

EXIT CODES
  0 done, 1 done but no trial had a usable joint result, 2 bad input (nothing
  written), 130 stopped by Ctrl-C: running trials were finished, all are kept,
  continue with --resume (a second Ctrl-C ends at once)";

const PLAN_AFTER: &str = "\
HOW IT WORKS
  Every candidate is simulated without errors and linearised once. That gives
  what it would tell of angles, lever arm, planes and scanner. The information
  of the passes is added up; what is known before is counted once. So the
  standard deviations after any set of passes follow without a single
  observation. The next pass is always the one that makes the criterion
  smallest.

  Unless candidates are named, it tries half the nearest distance to twice the
  farthest, the speeds of the passes and half of them, 10 deg more and less of
  heading, and both ways. Where one more pass is enough, it takes the one that
  is sailed quickest.

EXAMPLES
  How many more passes for a yaw of 0.01 deg, and which?
    boresight plan survey.toml --wanted yaw=0.01

  With the built-in scenario, and only at these distances:
    boresight plan demo --distance 4,6,8,12

  A survey from scratch, both ways and with a crab angle, to 0.02 deg and 5 mm:
    boresight plan scenario.toml --from-scratch --distance 5,9 \\
      --crab -10,0,10 --both-directions \\
      --wanted pitch=0.02,roll=0.02,yaw=0.02,lx=5,ly=5,lz=5

  Which tilt of the multibeam, which blocks on the wall? Values that one survey
  cannot mix are compared, not combined:
    boresight plan scenario.toml --vary multibeam.tilt_deg=20:60:5
    boresight plan scenario.toml --vary target.model.block_leg_m=0.5:2:0.25 \\
      --vary target.model.block_height_m=0.3,0.6,1

FILES WRITTEN
  OUT/plan.html   pictures: what each pass gains, candidates compared, the
                  courses from above; one file, opens offline
  OUT/plan.json   every figure, with units in the names
  OUT/plan.csv    one row per candidate, chosen pass and value
  OUT/plan.kml, OUT/plan.gpx, OUT/plan.geojson
                  the passes sailed and to be sailed, for plotters and maps

EXIT CODES
  0 planned, also where no number of passes reaches what is wanted (the plan
  says which parameter, and its limit), 2 bad input (nothing written)";

/// The command line.
#[derive(Debug, Parser)]
#[command(name = "boresight", version, about = ABOUT, long_about = long_about(), after_long_help = AFTER)]
#[command(
    after_help = "Exit codes: 0 usable result, 1 no usable result, 2 bad usage or input. More with --help."
)]
#[command(
    arg_required_else_help = true,
    propagate_version = true,
    max_term_width = 110
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// How to talk.
    #[command(flatten)]
    pub common: Common,
}

/// Options of every command.
#[derive(Clone, Copy, Debug, Args)]
pub struct Common {
    /// Threads to use (default: one per processor); changes no result
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print nothing but errors
    #[arg(long, short, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Name every step on standard error, with its time
    #[arg(long, short, global = true)]
    pub verbose: bool,
    /// Print the result as JSON on standard output instead of a summary
    #[arg(long, global = true)]
    pub json: bool,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simulate a survey, calibrate it by both paths and write the report: the main job with no input
    #[command(
        long_about = "Simulate the built-in survey of a procedure, calibrate it by both paths, compare with the truth and write the report.\n\n\
        The survey's files are written too, so that you can look at the formats and run `boresight calibrate` on them."
    )]
    #[command(
        after_long_help = "FILES WRITTEN\n  OUT/result.json, OUT/report.html\n  OUT/survey/            the simulated survey with truth.json\n\n\
        EXAMPLE\n  boresight demo --out demo --seed 7\n  boresight demo usbl"
    )]
    Demo(Demo),
    /// Calibrate a survey
    #[command(
        long_about = "Run the calibration that the survey file names and write result.json, report.html and parameters.csv, all of which begin with the values to enter.\n\n\
        With --method both (the default) the joint path decides whether the result is usable; the reference path is compared with it."
    )]
    #[command(
        after_long_help = "EXAMPLES\n  boresight calibrate survey.toml\n  boresight calibrate survey.toml --method joint --out run1\n  boresight calibrate survey.toml --export sis,latex\n\n\
        EXIT CODES\n  0 usable, 1 no usable result (written with usable: false), 2 bad input (nothing written)"
    )]
    Calibrate(Calibrate),
    /// Simulate a scenario: a complete survey with its truth
    #[command(
        long_about = "Simulate a scenario file: a whole survey, every file in the documented formats, and truth.json with the answer.\n\nEvery error source has its own random stream: switching one off under [sources] \
        leaves the numbers of the others as they were."
    )]
    #[command(
        after_long_help = "EXAMPLE\n  boresight simulate demo --out sim\n  boresight calibrate sim/survey.toml"
    )]
    Simulate(Simulate),
    /// Georeference a survey's soundings and returns with a calibration
    #[command(
        long_about = "Georeference all soundings and laser returns of a survey with the mounting of a result.json and write them as \
        one LAS or LAZ file: GPS time kept, point source id 1 for the laser scanner, 2 for the multibeam."
    )]
    #[command(
        override_usage = "boresight apply [OPTIONS] <SURVEY.toml> --calibration <RESULT.json>\n         --out <FILE.laz>",
        after_long_help = "EXAMPLE\n  boresight apply survey.toml --calibration result.json --out cloud.laz --coordinates utm"
    )]
    Apply(Apply),
    /// Has the mounting changed between two calibrations?
    #[command(
        long_about = "Compare the mountings of two calibrations, parameter by parameter and all together, with the covariances of both. The \
        angles are the turn between the two mountings in the body frame. The calibrations may be of different procedures, but must not \
        share observations."
    )]
    #[command(
        after_long_help = "EXAMPLE\n  boresight compare spring/result.json autumn/result.json\n\n\
        EXIT CODES\n  0 no significant change, 1 changed, 2 results that cannot be compared"
    )]
    Compare(Compare),
    /// Read and validate a survey, and say what its geometry can and cannot determine
    #[command(
        long_about = "Read and validate everything that a survey names: counts, times, what lies on the target, the standard \
        deviations to expect, and advice on what would make them smaller. Writes nothing."
    )]
    Check(Check),
    /// What recorder files hold: device, streams, times, installation, and what is missing for a calibration
    #[command(
        long_about = "Read files of recorders (Kongsberg .all and .kmall, Teledyne .s7k, XTF, GSF, NovAtel logs, POS MV groups, SBET) and say \
        what they hold: device, streams with counts and time spans, the installation record in this program's axes, what the recorder \
        has already applied, what was lost to damage, and what a calibration would still need."
    )]
    #[command(
        after_long_help = "EXAMPLES\n  boresight info line-0001.all\n  boresight info --own-solution line-0001.all\n  boresight info *.kmall --json | jq '.[].missing'\n\n\
        EXIT CODES\n  0 read, also where much was lost (it is counted), 2 a file that cannot be read or is of no known format"
    )]
    Info(Info),
    /// Find out how much each error source costs each parameter, by either path
    #[command(
        long_about = "Without --trials: propagate every error source of a scenario through the derivatives of both paths: bias, \
        standard deviation and share of variance of each parameter, the Cramer-Rao bound and each path's efficiency. \
        Takes seconds.\n\n\
        With --trials: also simulate the scenario many times, calibrate every survey by both paths and compare with the truth and \
        with the propagation: bias and standard deviation by the joint path, the reference path and its projected variant; each \
        source alone (--single); whether the reported sigmas are right; how all of that changes with one or two scenario \
        values (--vary).\n\n\
        Trials are independent, use all cores and keep one line each in a ledger. All sets of trials use the same seeds, so that \
        differences between them are not noise. No trial is left out: one without a usable result is counted with \
        its reason.",
        after_long_help = BUDGET_AFTER
    )]
    Budget(Budget),
    /// Find out which pass to sail next, and how many are needed
    #[command(
        long_about = "Predict the standard deviations of angles and lever arm after candidate passes, choose which to sail next, and say \
        how many are needed for a wanted accuracy, or that no number is enough. From a scenario without any data, or from a \
        survey that was sailed.",
        after_long_help = PLAN_AFTER
    )]
    Plan(Plan),
    /// Print a complete commented file to fill in
    #[command(
        after_help = "EXAMPLES\n  boresight template pool > survey.toml\n  boresight template scenario usbl > scenario.toml\n  boresight template target > target.toml"
    )]
    Template(Template),
    /// Print a completion script for a shell
    Completions {
        /// Which shell
        shell: clap_complete::Shell,
    },
}

/// `template`.
#[derive(Debug, Args)]
pub struct Template {
    /// A procedure's survey file, or scenario or target
    #[arg(value_name = "PROCEDURE|scenario|target", value_parser = PossibleValuesParser::new(procedures::names().into_iter().chain(["scenario", "target"])))]
    pub what: String,
    /// Whose scenario or target; the first of all when none is named
    #[arg(value_name = "PROCEDURE", value_parser = PossibleValuesParser::new(procedures::names()))]
    pub procedure: Option<String>,
    /// Make the survey file from these recorder files
    #[arg(long, value_name = "FILE", num_args = 1.., value_hint = ValueHint::FilePath)]
    pub from: Vec<PathBuf>,
}

/// `demo`.
#[derive(Debug, Args)]
pub struct Demo {
    /// Which procedure to show [default: the first]
    #[arg(value_name = "PROCEDURE", value_parser = PossibleValuesParser::new(procedures::names()))]
    pub procedure: Option<String>,
    /// Folder to write into [default: boresight-demo-PROCEDURE, without a procedure boresight-demo]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub out: Option<PathBuf>,
    /// Seed of the simulation, and of the calibration's random samples
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

/// `calibrate`.
#[derive(Debug, Args)]
pub struct Calibrate {
    /// Survey file
    #[arg(value_name = "SURVEY.toml", value_hint = ValueHint::FilePath)]
    pub survey: PathBuf,
    /// Which paths run
    #[arg(long, value_enum, default_value_t = MethodName::Both)]
    pub method: MethodName,
    /// Solve the simple joint model too (scanner's planes fixed, no drift), as a third column
    #[arg(long)]
    pub simple: bool,
    /// Folder to write into [default: named after the survey]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub out: Option<PathBuf>,
    /// Also write the values to enter in these forms, separated by commas
    #[arg(long, value_enum, value_name = "FORM,...", value_delimiter = ',')]
    pub export: Vec<ExportName>,
    /// Seed of the calibration's random samples, where it draws any [default: 1]
    #[arg(long)]
    pub seed: Option<u64>,
}

/// Forms of the values to enter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExportName {
    /// table.tex, a table for a paper
    Latex,
    /// card.csv, the values to enter and nothing else
    Csv,
    /// card-hvf.txt, for a CARIS vessel file
    #[value(aliases = ["caris", "hvf"])]
    HvfCard,
    /// card-qimera.txt, for QPS Qinsy and Qimera
    #[value(aliases = ["qinsy", "qps"])]
    Qimera,
    /// card-sis.txt, for Kongsberg SIS
    #[value(alias = "kongsberg")]
    Sis,
    /// card-applanix.txt, for an Applanix POS MV
    #[value(aliases = ["pos-mv", "posmv"])]
    Applanix,
    /// card-novatel.txt, for NovAtel SPAN and Inertial Explorer
    #[value(alias = "span")]
    Novatel,
    /// Every form
    All,
}

impl ExportName {
    /// The forms it stands for.
    pub fn forms(self) -> Vec<Export> {
        let one = match self {
            Self::Latex => Export::Latex,
            Self::Csv => Export::Csv,
            Self::HvfCard => Export::Hvf,
            Self::Qimera => Export::Qimera,
            Self::Sis => Export::Sis,
            Self::Applanix => Export::Applanix,
            Self::Novatel => Export::Novatel,
            Self::All => return Export::ALL.to_vec(),
        };
        vec![one]
    }
}

/// `compare`.
#[derive(Debug, Args)]
pub struct Compare {
    /// Result of the earlier calibration
    #[arg(value_name = "BEFORE.json", value_hint = ValueHint::FilePath)]
    pub before: PathBuf,
    /// Result of the later one
    #[arg(value_name = "AFTER.json", value_hint = ValueHint::FilePath)]
    pub after: PathBuf,
    /// Probability of calling a mounting changed that has not, above 0 and up to 0.5
    #[arg(long, value_name = "P", default_value = "0.01", value_parser = significance)]
    pub significance: f64,
}

fn significance(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    if value > 0.0 && value <= 0.5 {
        return Ok(value);
    }
    Err("expected a probability above 0 and up to 0.5".to_owned())
}

/// Which paths run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MethodName {
    /// The source document's, step after step
    #[value(alias = "sequential")]
    Reference,
    /// One adjustment of everything
    Joint,
    /// Both, compared
    Both,
}

impl From<MethodName> for Method {
    fn from(name: MethodName) -> Self {
        match name {
            MethodName::Reference => Self::Reference,
            MethodName::Joint => Self::Joint,
            MethodName::Both => Self::Both,
        }
    }
}

/// `simulate`.
#[derive(Debug, Args)]
pub struct Simulate {
    /// Scenario file; demo, demo-usbl, demo-rail, demo-seabed: the built-in one, written beside OUT as scenario.toml for you to change
    #[arg(value_name = "SCENARIO.toml", value_hint = ValueHint::FilePath)]
    pub scenario: PathBuf,
    /// Folder to write into
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub out: PathBuf,
    /// Seed [default: the scenario's]
    #[arg(long)]
    pub seed: Option<u64>,
    /// Replace what this program wrote before (never a file that it did not write)
    #[arg(long)]
    pub force: bool,
}

/// `apply`.
#[derive(Debug, Args)]
pub struct Apply {
    /// Survey file
    #[arg(value_name = "SURVEY.toml", value_hint = ValueHint::FilePath)]
    pub survey: PathBuf,
    /// Result of a calibration
    #[arg(long, value_name = "RESULT.json", value_hint = ValueHint::FilePath)]
    pub calibration: PathBuf,
    /// File to write, .laz or .las
    #[arg(long, value_name = "FILE.laz", value_hint = ValueHint::FilePath)]
    pub out: PathBuf,
    /// Which of its solutions
    #[arg(long, value_enum, default_value_t = SolutionName::Joint)]
    pub solution: SolutionName,
    /// Coordinates to write
    #[arg(long, value_enum, default_value_t = CoordinatesName::Utm)]
    pub coordinates: CoordinatesName,
    /// Also write the soundings' surface: a GeoTIFF of mean, count and standard deviation in each cell (UTM only; gross errors left out)
    #[arg(long, value_name = "FILE.tif", value_hint = ValueHint::FilePath)]
    pub surface: Option<PathBuf>,
    /// Side of its cells, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0, requires = "surface", value_parser = cell)]
    pub cell: f64,
    /// Replace what this program wrote before (never a file that it did not write)
    #[arg(long)]
    pub force: bool,
}

/// A solution of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SolutionName {
    /// The rigorous joint adjustment
    Joint,
    /// The reference path
    #[value(alias = "sequential")]
    Reference,
    /// The simple joint model
    JointSimple,
}

/// Coordinates of georeferenced points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CoordinatesName {
    /// Earth-centred, earth-fixed
    Geocentric,
    /// UTM easting and northing with ellipsoidal heights, zone of the target
    Utm,
}

/// `check`.
#[derive(Debug, Args)]
pub struct Check {
    /// Survey file
    #[arg(value_name = "SURVEY.toml", value_hint = ValueHint::FilePath)]
    pub survey: PathBuf,
    /// Seed of the calibration's random samples, where it draws any [default: 1]
    #[arg(long)]
    pub seed: Option<u64>,
}

/// `info`.
#[derive(Debug, Args)]
pub struct Info {
    /// Files of recorders, or folders that hold some
    #[arg(value_name = "FILE", required = true, value_hint = ValueHint::FilePath)]
    pub files: Vec<PathBuf>,
    /// Georeference with the installation values and compare with the sounder's own points (keeps the file in memory)
    #[arg(long)]
    pub own_solution: bool,
}

/// `budget`.
#[derive(Clone, Debug, Args)]
pub struct Budget {
    /// Scenario file, or demo; or a survey file: then what its claimed errors do to its own calibration, without trials
    #[arg(value_name = "SCENARIO-or-SURVEY.toml", value_hint = ValueHint::FilePath)]
    pub scenario: PathBuf,
    /// Simulated surveys with all error sources together
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub trials: Option<u64>,
    /// Simulated surveys of each error source alone
    #[arg(long, value_name = "M", requires = "trials", value_parser = clap::value_parser!(u64).range(2..=1_000_000_000))]
    pub single: Option<u64>,
    /// First seed; the others follow it
    #[arg(long, value_name = "FIRST", default_value_t = 1, conflicts_with = "join", value_parser = clap::value_parser!(u64).range(0..=(1 << 62)))]
    pub seed: u64,
    /// A scenario value over a range, KEY=from:to:step or KEY=a,b,c; with N trials at each, without --trials by propagation; once or
    /// twice
    #[arg(long, value_name = "KEY=VALUES")]
    pub vary: Vec<Vary>,
    /// Errors that are good enough, in the units of the tables (deg, mm, ms, ppm): the answer says whether they are reached, and with --vary
    /// at which values
    #[arg(long, value_name = "NAME=VALUE,...", value_delimiter = ',', value_parser = goal, conflicts_with = "only_trials")]
    pub wanted: Vec<(String, f64)>,
    /// Depths below the sonar at which uncertainty across the swath is shown, metres
    #[arg(long, value_name = "M,...", value_delimiter = ',', value_parser = positive, default_values_t = crate::budget::DEPTHS_M, conflicts_with = "only_trials")]
    pub depth: Vec<f64>,
    /// Continue with the trials that are in the folder
    #[arg(long, requires = "trials", conflicts_with = "join")]
    pub resume: bool,
    /// Run the trials of these seeds and keep them in OUT/trials, without tables and report: one part of many
    #[arg(long, requires = "trials", conflicts_with = "join")]
    pub only_trials: bool,
    /// Join the trials of such parts: the ledgers, tables and report of one run; --trials and --single check how many there are
    #[arg(long, value_name = "PART", num_args = 1.., value_hint = ValueHint::DirPath)]
    pub join: Vec<PathBuf>,
    /// Folder to write into [default: named after the scenario, with -budget]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub out: Option<PathBuf>,
}

/// `plan`.
#[derive(Debug, Args)]
pub struct Plan {
    /// Scenario or survey file, its passes count as sailed; or demo
    #[arg(value_name = "SCENARIO-or-SURVEY.toml", value_hint = ValueHint::FilePath)]
    pub scenario: PathBuf,
    /// Distances of candidate passes from the wall, metres
    #[arg(long, value_name = "M,...", value_delimiter = ',', value_parser = positive)]
    pub distance: Vec<f64>,
    /// Speeds of candidate passes, m/s
    #[arg(long, value_name = "M/S,...", value_delimiter = ',', value_parser = positive)]
    pub speed: Vec<f64>,
    /// Heading minus course of candidate passes, degrees
    #[arg(long, value_name = "DEG,...", value_delimiter = ',', value_parser = below_a_right_angle, allow_hyphen_values = true)]
    pub crab: Vec<f64>,
    /// Sail every candidate the other way as well
    #[arg(long)]
    pub both_directions: bool,
    /// Nothing is sailed yet: the scenario's passes are only the pattern of candidates
    #[arg(long)]
    pub from_scratch: bool,
    /// What the next pass should make smallest
    #[arg(long, value_enum, default_value_t = CriterionName::D)]
    pub criterion: CriterionName,
    /// Standard deviations wanted, degrees and millimetres; those not named keep their default
    /// [default: pitch=0.015,roll=0.015,yaw=0.015,lx=1.2,ly=1.2,lz=1.2, the best published]
    #[arg(long, value_name = "NAME=VALUE,...", value_delimiter = ',', value_parser = goal)]
    pub wanted: Vec<(String, f64)>,
    /// Most passes to add
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub most: u16,
    /// A scenario value over a range, KEY=from:to:step or KEY=a,b,c, as in budget: its passes' prediction at each; once or twice
    #[arg(long, value_name = "KEY=VALUES")]
    pub vary: Vec<Vary>,
    /// Folder to write into [default: named after the scenario, with -plan]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub out: Option<PathBuf>,
}

/// What the next pass should make smallest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CriterionName {
    /// The volume of the error ellipsoid
    D,
    /// The sum of the variances in units of what is wanted
    A,
}

/// A number above 0.
fn positive(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0, "a number above 0")
}

/// `yaw=0.01`.
fn goal(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE,...")?;
    Ok((name.trim().to_owned(), positive(value)?))
}

/// `--wanted` as it was typed; nothing where it was not.
pub fn wanted_words(wanted: &[(String, f64)]) -> Option<String> {
    let each = wanted.iter().map(|(name, value)| format!("{name}={value}"));
    let each: Vec<String> = each.collect();
    (!each.is_empty()).then(|| format!("--wanted {}", each.join(",")))
}

/// `--cell`.
fn cell(text: &str) -> Result<f64, String> {
    let fit = |v| (0.01..=1000.0).contains(&v);
    number(text, fit, "metres from 0.01 to 1000")
}

fn below_a_right_angle(text: &str) -> Result<f64, String> {
    number(text, |v| v.abs() < 90.0, "degrees between -90 and 90")
}

fn number(text: &str, good: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() && good(value) => Ok(value),
        _ => Err(format!("expected {expected}")),
    }
}
