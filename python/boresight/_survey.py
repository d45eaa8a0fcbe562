"""Surveys, and what can be done with one."""

from __future__ import annotations

import json
import math
import os
import pathlib
import shutil
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core
from ._arrays import column
from ._errors import BoresightError, Fault, InputError
from ._observe import (
    Extra,
    LaserNoise,
    LaserScan,
    Mounting,
    Pose,
    SonarNoise,
    Soundings,
    Target,
    Trajectory,
    TrajectoryNoise,
    Utm,
)
from ._progress import ProgressCallback, told
from ._result import FoundMounting, Result, Solution

if TYPE_CHECKING:
    from distributed import Client

    from ._dask_blocks import Blocks

Path = str | PathLike[str]
Method = Literal["both", "joint", "reference"]


class SoundSpeed(NamedTuple):
    """A sound-speed profile: depths below the water level, ascending (m), and the speed at each (m/s)."""

    depth_m: npt.ArrayLike
    speed_m_s: npt.ArrayLike


class Survey:
    """Everything that was observed, and how the sensors are believed to sit.

    :func:`read_survey` reads one of any procedure from files. This constructor makes one of the procedure ``pool`` from arrays: a
    multibeam against a target that a laser scanner sees too.

    ``config`` holds the sections ``sequential``, ``joint``, ``verdict`` and ``large`` of a survey file. Everything that is wrong comes in one
    :exc:`InputError`.
    """

    _handle: _core.Survey
    _truth: str | None
    _file: str | None

    def __init__(
        self,
        trajectory: Trajectory,
        laser: LaserScan,
        soundings: Soundings,
        target: Target,
        pose: Pose,
        *,
        scanner: Mounting | None = None,
        sonar: Mounting,
        sound_speed: float | SoundSpeed | None = None,
        name: str = "arrays",
        config: Mapping[str, Any] | None = None,
        max_gap_s: float = 1.0,
        outside: Literal["error", "drop"] = "error",
    ) -> None:
        keys = _keys(trajectory, laser, soundings, pose, scanner, sonar)
        keys["name"] = name
        keys["trajectory"] |= {"max_gap_s": float(max_gap_s), "outside": outside}
        for section, values in (config or {}).items():
            if section in keys:
                known = "sequential, joint, verdict or large"
                raise InputError.of([Fault("config", section, "a section that has an argument of its own", known)])
            keys[section] = values
        columns = _columns(trajectory, laser, soundings) | _speed(sound_speed)
        try:
            made = _core.Survey.from_arrays(json.dumps(keys), json.dumps(dict(target.keys)), columns)
        except InputError as error:
            raise _of_arguments(error) from None
        self._handle, self._truth, self._file = made, None, None

    @classmethod
    def _of(cls, core: _core.Survey, truth: str | None = None, file: str | None = None) -> Survey:
        made = cls.__new__(cls)
        made._handle, made._truth, made._file = core, truth, file
        return made

    @property
    def name(self) -> str:
        """Its name."""
        return self._handle.name

    @property
    def procedure(self) -> str:
        """``pool``, ``usbl``, ``rail`` or ``seabed``."""
        return self._handle.procedure

    @property
    def inputs(self) -> dict[str, str]:
        """SHA-256 of every file that was read, the survey file first; empty for a survey from arrays."""
        return dict(self._handle.inputs)

    @cached_property
    def config(self) -> dict[str, Any]:
        """The survey file with every default filled in."""
        found: dict[str, Any] = json.loads(self._handle.configuration())
        return found

    @cached_property
    def _arrays(self) -> dict[str, Any]:
        found = self._handle.columns()
        if found is None:
            raise BoresightError(f"a {self.procedure} survey shows no arrays; those of a pool survey can be had")
        for value in found.values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False
        return found

    @cached_property
    def trajectory(self) -> Trajectory:
        """The INS trajectory of a pool survey."""
        a = self._arrays
        names = ("time_s", "latitude_rad", "longitude_rad", "height_m", "roll_rad", "pitch_rad", "heading_rad")
        columns = [a[f"trajectory.{n}"] for n in names]
        noise = TrajectoryNoise(*a["trajectory.noise"])
        return Trajectory(*columns, velocity_m_s=a["trajectory.velocity_m_s"], noise=noise)

    @cached_property
    def laser(self) -> LaserScan:
        """The laser returns of a pool survey; UTM coordinates have become geocentric ones."""
        a = self._arrays
        range_m, angle_rad, point_m = a["laser.noise"]
        usual = LaserNoise()
        # a survey file names those of its own frame only
        noise = LaserNoise(range_m or usual.range_m, angle_rad, point_m or usual.point_m)
        x, y, z = (a[f"laser.{n}"] for n in ("x_m", "y_m", "z_m"))
        return LaserScan(a["laser.time_s"], x_m=x, y_m=y, z_m=z, frame=a["laser.frame"], noise=noise)

    @cached_property
    def soundings(self) -> Soundings:
        """The soundings of a pool survey."""
        a = self._arrays
        ranges = {a["soundings.kind"]: a["soundings.range"]}
        along = a["soundings.along_rad"]
        numbers = {n: a[f"soundings.{n}"] for n in ("ping", "beam")}
        noise = SonarNoise(*a["soundings.noise"])
        return Soundings(a["soundings.time_s"], a["soundings.across_rad"], along, **ranges, **numbers, noise=noise)

    @property
    def sound_speed(self) -> float | SoundSpeed | None:
        """The sound speed of a pool survey, or its profile."""
        depth, speed = self._arrays["sound_speed.depth_m"], self._arrays["sound_speed.speed_m_s"]
        if len(depth):
            return SoundSpeed(depth, speed)
        return float(speed[0]) if len(speed) else None

    @cached_property
    def target(self) -> Target:
        """The target of a pool survey."""
        text = self._handle.target()
        if text is None:
            raise BoresightError(f"a {self.procedure} survey shows no target; that of a pool survey can be had")
        return Target(json.loads(text))

    @property
    def pose(self) -> Pose:
        """Where the target of a pool survey is believed to stand."""
        _ = self.target
        keys = self.config["target"]
        return Pose(
            **keys["origin"],
            azimuth_deg=keys["azimuth_deg"],
            water_level_m=keys["water_level_m"],
            ellipsoid=keys["ellipsoid"],
        )

    @property
    def scanner(self) -> Mounting:
        """The scanner's calibrated mounting in a pool survey."""
        _ = self.target
        keys = self.config["lidar"]
        return _mounting(keys, keys.get("mounting_sigma_deg"), keys.get("lever_arm_sigma_m"))

    @property
    def sonar(self) -> Mounting:
        """The nominal mounting in a pool survey: what is to be corrected."""
        _ = self.target
        return _mounting(self.config["multibeam"], None, None)

    def __repr__(self) -> str:
        return f"<Survey {self.name!r}, procedure {self.procedure}>"


def _mounting(keys: Mapping[str, Any], sigma: Any, arm_sigma: Any) -> Mounting:
    angles = keys["mounting_deg"]
    return Mounting(angles["roll"], angles["pitch"], angles["heading"], keys["lever_arm_m"], sigma, arm_sigma)


def _keys(
    trajectory: Trajectory,
    laser: LaserScan,
    soundings: Soundings,
    pose: Pose,
    scanner: Mounting | None,
    sonar: Mounting,
) -> dict[str, Any]:
    """The arguments as the keys of a survey file."""
    wanted = {
        "trajectory": (trajectory, Trajectory),
        "laser": (laser, LaserScan),
        "soundings": (soundings, Soundings),
        "pose": (pose, Pose),
        "scanner": (scanner or Mounting(), Mounting),
        "sonar": (sonar, Mounting),
    }
    faults = [
        Fault("Survey", name, f"a {type(value).__name__}", f"a {kind.__name__}")
        for name, (value, kind) in wanted.items()
        if not isinstance(value, kind)
    ]
    if scanner is None and isinstance(laser, LaserScan) and laser.frame == "sensor":
        faults.append(Fault("Survey", "scanner", "nothing", "a Mounting, as the laser points are in the scanner's frame"))
    if faults:
        raise InputError.of(faults)
    t, n = trajectory.noise, soundings.noise
    origin = {"latitude_deg": pose.latitude_deg, "longitude_deg": pose.longitude_deg, "height_m": pose.height_m}
    return {
        "procedure": "pool",
        "target": {
            "model": "arrays",
            "ellipsoid": pose.ellipsoid,
            "origin": origin,
            "azimuth_deg": pose.azimuth_deg,
            "water_level_m": pose.water_level_m,
        },
        "trajectory": {
            "path": "arrays",
            "position_sigma_m": t.position_m,
            "position_drift_sigma_m": t.position_drift_m,
            "drift_correlation_time_s": t.drift_correlation_time_s,
            "roll_pitch_sigma_deg": math.degrees(t.roll_pitch_rad),
            "heading_sigma_deg": math.degrees(t.heading_rad),
            "heading_drift_sigma_deg": math.degrees(t.heading_drift_rad),
        },
        "lidar": _lidar(laser, scanner),
        "multibeam": {
            "path": "arrays",
            **_angles(sonar),
            "range_sigma_m": n.range_m,
            "angle_sigma_deg": math.degrees(n.across_rad),
            "along_angle_sigma_deg": math.degrees(n.along_rad),
        },
    }


def _angles(mounting: Mounting) -> dict[str, Any]:
    angles = {"roll": mounting.roll_deg, "pitch": mounting.pitch_deg, "heading": mounting.heading_deg}
    return {"lever_arm_m": list(mounting.lever_arm_m), "mounting_deg": angles}


def _lidar(laser: LaserScan, scanner: Mounting | None) -> dict[str, Any]:
    keys: dict[str, Any] = {"path": "arrays"}
    if isinstance(laser.frame, Utm):
        keys |= {"coordinates": "utm", "utm_zone": laser.frame.zone}
    else:
        keys["coordinates"] = laser.frame
    if scanner is not None:
        keys |= _angles(scanner)
        if scanner.sigma_deg is not None and scanner.lever_arm_sigma_m is not None:
            keys["mounting_sigma_deg"] = list(scanner.sigma_deg)
            keys["lever_arm_sigma_m"] = list(scanner.lever_arm_sigma_m)
    if laser.frame == "sensor":
        return keys | {"range_sigma_m": laser.noise.range_m, "angle_sigma_deg": math.degrees(laser.noise.angle_rad)}
    return keys | {"point_sigma_m": laser.noise.point_m}


def _columns(t: Trajectory, laser: LaserScan, s: Soundings) -> dict[str, Any]:
    names = ("time_s", "latitude_rad", "longitude_rad", "height_m", "roll_rad", "pitch_rad", "heading_rad")
    columns: dict[str, Any] = {f"trajectory.{name}": getattr(t, name) for name in names}
    columns["trajectory.velocity_m_s"] = t.velocity_m_s
    n = t.noise
    columns["trajectory.noise"] = [
        n.position_m,
        n.position_drift_m,
        n.drift_correlation_time_s,
        n.roll_pitch_rad,
        n.heading_rad,
        n.heading_drift_rad,
    ]
    columns["laser.time_s"] = laser.time_s
    for k, name in enumerate(("x_m", "y_m", "z_m")):
        columns[f"laser.{name}"] = np.ascontiguousarray(laser.xyz_m[:, k])
    # a georeferenced point has no range and no angle, one of the scanner's frame no noise of its own
    own = laser.frame == "sensor"
    noise = laser.noise
    columns["laser.noise"] = [noise.range_m, noise.angle_rad, 0.0] if own else [0.0, 0.0, noise.point_m]
    columns |= {f"soundings.{name}": getattr(s, name) for name in ("time_s", "across_rad", "along_rad", "ping", "beam")}
    columns["soundings.range"] = s.range_m if s.travel_time_s is None else s.travel_time_s
    columns["soundings.kind"] = "range_m" if s.travel_time_s is None else "travel_time_s"
    columns["soundings.noise"] = [s.noise.range_m, s.noise.across_rad, s.noise.along_rad]
    return columns


def _speed(sound_speed: float | SoundSpeed | None) -> dict[str, Any]:
    faults: list[Fault] = []
    depth, speed = np.zeros(0), np.zeros(0)
    if isinstance(sound_speed, SoundSpeed):
        depth = column("sound_speed", "depth_m", sound_speed.depth_m, faults)
        speed = column("sound_speed", "speed_m_s", sound_speed.speed_m_s, faults)
    elif sound_speed is not None:
        speed = column("sound_speed", "speed_m_s", [sound_speed], faults)
    if faults:
        raise InputError.of(faults)
    return {"sound_speed.depth_m": depth, "sound_speed.speed_m_s": speed}


def _of_arguments(error: InputError) -> InputError:
    """Faults by the argument that they are of: there is no survey file whose lines could be named."""
    faults = []
    for fault in error.faults:
        line, _, rest = fault.place.partition(", ")
        faults.append(fault._replace(place=rest) if line.startswith("line ") else fault)
    return InputError.of(faults) if faults else error


def read_survey(path: Path, *, progress: ProgressCallback | None = None) -> Survey:
    """Reads a survey file and every file that it names, of whichever procedure it names.

    :exc:`InputError` with everything that is wrong with all of them; nothing is repaired.
    """
    return Survey._of(_core.Survey.read(fspath(path), progress=told(progress)), file=os.path.abspath(fspath(path)))


@dataclass(frozen=True)
class Preview:
    """What a survey holds and what its geometry can and cannot determine."""

    text: str
    """In words."""
    keys: Mapping[str, Any]
    """The same for programs, as ``boresight check --json`` prints it."""
    determined: bool
    """Whether the geometry determines everything that is sought."""

    @property
    def advice(self) -> tuple[str, ...]:
        """What would help; empty where nothing is to be advised."""
        return tuple(self.keys.get("advice", ()))

    def __str__(self) -> str:
        return self.text


def check(
    survey: Survey | Path,
    *,
    seed: int | None = None,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
) -> Preview:
    """Says what a survey holds and what its geometry determines; solves nothing."""
    text, keys, determined = _read(survey)._handle.check(seed=seed, threads=threads, progress=told(progress))
    return Preview(text, json.loads(keys), determined)


def calibrate(
    survey: Survey | Path,
    *,
    method: Method = "both",
    seed: int | None = None,
    simple: bool = False,
    extra: Sequence[Extra] = (),
    threads: int | None = None,
    client: Client | None = None,
    progress: ProgressCallback | None = None,
) -> Result:
    """Calibrates a survey by both paths; the same bytes as ``boresight calibrate`` writes.

    ``simple`` solves the simple joint model too. ``extra`` are unknowns of your own (:class:`Extra`), which the joint path of a pool or seabed
    survey solves for, with one derivative for each sounding of the survey in the order of its file; what it found stands in
    ``Result.extra``. ``threads`` changes no result; without it, one per processor. A calibration that ends
    without a usable result is no error: see ``Result.usable``. :exc:`InputError` for input that no calibration can work with, and for
    a setting that the procedure has no use for.

    With a Dask ``client`` (``boresight[dask]``) the adjustments of a pool survey of more than ``[large] block_records`` records are worked
    on block by block by its workers, which read the survey's files themselves; the bytes are the same.
    """
    read = _read(survey)
    given = _extras(extra)
    workers = None if client is None else _blocks(read, given, seed, client, progress)
    found = read._handle.calibrate(
        method,
        seed=seed,
        simple=simple,
        extra=given,
        truth=read._truth,
        threads=threads,
        progress=told(progress),
        workers=workers,
    )
    return Result(found)


def _blocks(
    survey: Survey, extra: _ExtraColumns, seed: int | None, client: Client, progress: ProgressCallback | None
) -> Blocks:
    """The workers of a client, for a survey that they can read."""
    faults = []
    if survey.procedure != "pool":
        faults.append(Fault("calibrate", "client", f"a {survey.procedure} survey", "a pool survey, whose blocks can be handed out"))
    if survey._file is None:
        faults.append(Fault("calibrate", "client", "a survey in memory", "one of read_survey, whose files the workers can read"))
    if extra:
        faults.append(Fault("calibrate", "client", "extra unknowns", "none, as the workers do not have their arrays"))
    if faults or survey._file is None:
        raise InputError.of(faults)
    from ._dask_blocks import Blocks

    return Blocks(client, (survey._file, seed, tuple(survey.inputs.values())), progress)


_ExtraColumns = list[tuple[str, str, str, Any, float | None]]


def _extras(extra: Sequence[Extra]) -> _ExtraColumns:
    """Own unknowns as the library takes them."""
    listed = list(extra) if isinstance(extra, Sequence) else [extra]
    for value in listed:
        if not isinstance(value, Extra):
            raise InputError.of([Fault("extra", "whole argument", f"a {type(value).__name__}", "a list of Extra")])
    return [(e.name, e.unit, e.acts_on, e.derivative, e.prior_sigma) for e in listed]


def _read(survey: Survey | Path) -> Survey:
    return survey if isinstance(survey, Survey) else read_survey(survey)


@dataclass(frozen=True, eq=False)
class Simulated:
    """A simulated survey and the answer to it."""

    survey: Survey
    """As a calibration gets it; its result compares itself with the truth."""
    truth: Mapping[str, Any]
    """The content of ``truth.json``."""
    counts: Mapping[str, int]
    """How many observations of each kind were simulated."""


def demo(procedure: str = "pool") -> str:
    """The text of a procedure's built-in scenario, in TOML.

    >>> "procedure" in demo("usbl")
    True
    """
    return _core.demo_scenario(procedure)


def simulate(
    scenario: Path,
    folder: Path | None = None,
    *,
    seed: int | None = None,
    progress: ProgressCallback | None = None,
) -> Simulated:
    """Simulates a scenario (its file, or its text) and reads the survey that comes of it.

    The survey's files are written into ``folder``, which must be new or empty; without one they are gone when the survey is in memory.
    ``seed`` is the scenario's own unless it is given. :exc:`InputError` with everything that is wrong with the scenario.
    """
    file, text = scenario_file(scenario)
    if folder is None:
        with tempfile.TemporaryDirectory(prefix="boresight-", ignore_cleanup_errors=True) as made:
            return _simulated(file, text, pathlib.Path(made), seed, progress)
    wanted = pathlib.Path(fspath(folder))
    if wanted.exists() and not (wanted.is_dir() and not any(wanted.iterdir())):
        raise InputError.of([Fault("simulate", "folder", f"{wanted} with something in it", "an empty or a new one")])
    # all files or none: they become the folder when the last one is there
    wanted.parent.mkdir(parents=True, exist_ok=True)
    beside = pathlib.Path(tempfile.mkdtemp(prefix=".boresight-", suffix=".tmp", dir=wanted.parent))
    try:
        simulated = _simulated(file, text, beside / "survey", seed, progress)
        if wanted.exists():
            wanted.rmdir()
        (beside / "survey").rename(wanted)
        return simulated
    finally:
        _discard(beside)


def _discard(folder: pathlib.Path) -> None:
    """Removes a folder into which a stopped simulation may still be writing."""
    for _ in range(20):
        shutil.rmtree(folder, ignore_errors=True)
        if not folder.exists():
            return
        time.sleep(0.05)


def _simulated(
    file: str, text: str | None, folder: pathlib.Path, seed: int | None, progress: ProgressCallback | None
) -> Simulated:
    truth, counts = _core.simulate(file, text, os.fspath(folder), seed=seed, progress=told(progress))
    survey = _core.Survey.read(os.fspath(folder / "survey.toml"), progress=told(progress))
    return Simulated(Survey._of(survey, truth), json.loads(truth), dict(counts))


def scenario_file(scenario: Path) -> tuple[str, str | None]:
    """A scenario as its file, or as the name that messages give it and its text."""
    given = fspath(scenario)
    return ("scenario", given) if "\n" in given else (given, None)


def georeference(
    survey: Survey,
    result: Result | Solution | FoundMounting | Mounting | None = None,
    *,
    sensor: Literal["soundings", "laser"] = "soundings",
    rows: slice = slice(None),
    threads: int | None = None,
) -> npt.NDArray[np.float64]:
    """Observations of a pool survey in the target frame as the calibration refines it: (n, 3) float64, metres.

    ``result`` says how the multibeam sits: a result (with the latency and range scale that it determined), a mounting, or nothing for
    the nominal mounting. ``rows`` chooses observations in the order of the survey. NaN where the trajectory gives no position.
    """
    if sensor not in ("soundings", "laser"):
        raise InputError.of([Fault("georeference", "sensor", repr(sensor), '"soundings" or "laser"')])
    chosen = range(len(survey.soundings if sensor == "soundings" else survey.laser))[rows]
    if len(chosen) and chosen.step < 0:
        raise InputError.of([Fault("georeference", "rows", f"a step of {chosen.step}", "a step of 1 or more")])
    model = None if result is None else _model(result)
    return survey._handle.georeference(sensor, model, chosen.start, chosen.step, len(chosen), threads=threads)


@dataclass(frozen=True, eq=False)
class Residuals:
    """Where the observations of one sensor of a pool survey lie, one row per observation in the survey's order."""

    face: npt.NDArray[np.int16]
    """Place of the face in ``faces``; -1 for an observation that the adjustment did not use."""
    reason: npt.NDArray[np.uint8]
    """Why it was not used: place in ``reasons``; 0 for one that was used."""
    residual_m: npt.NDArray[np.float64]
    """Distance from the adjusted face, positive outwards, metres; NaN for one that was not used."""
    sigma_m: npt.NDArray[np.float64]
    """Standard deviation of the observation along the face's normal as it is stated, metres; without a joint path NaN, as the next two."""
    redundancy: npt.NDArray[np.float64]
    """From 0 (nothing controls it) to 1 (it controls nothing)."""
    normalised: npt.NDArray[np.float64]
    """Residual of the adjustment over its own standard deviation, positive outwards; the trajectory's estimated errors are applied."""
    faces: tuple[str, ...]
    """Names of the target's faces."""
    reasons: tuple[str, ...]
    """What the numbers of ``reason`` mean, as in ``result.counts``."""

    def __len__(self) -> int:
        return len(self.face)


def residuals(
    survey: Survey,
    *,
    sensor: Literal["soundings", "laser"] = "soundings",
    method: Method = "both",
    seed: int | None = None,
    extra: Sequence[Extra] = (),
    threads: int | None = None,
    progress: ProgressCallback | None = None,
) -> Residuals:
    """Faces and residuals of a pool survey's observations under the solution that decides.

    A result does not hold its observations: this calibrates the survey (again), with the same settings to the same end.
    """
    if sensor not in ("soundings", "laser"):
        raise InputError.of([Fault("residuals", "sensor", repr(sensor), '"soundings" or "laser"')])
    given = _extras(extra)
    found = survey._handle.residuals(method, seed=seed, extra=given, threads=threads, progress=told(progress))
    names = ("residual_m", "sigma_m", "redundancy", "normalised")
    figures = {name: found[f"{sensor}.{name}"] for name in names}
    face, reason = found[f"{sensor}.face"], found[f"{sensor}.reason"]
    return Residuals(face=face, reason=reason, faces=tuple(found["faces"]), reasons=tuple(found["reasons"]), **figures)


@dataclass(frozen=True, eq=False)
class Cloud:
    """All points of a survey, in order of time within each source."""

    xyz_m: npt.NDArray[np.float64]
    """Earth-centred, earth-fixed, (n, 3), metres."""
    time_s: npt.NDArray[np.float64]
    """Their stamps, seconds."""
    source: npt.NDArray[np.uint16]
    """What each comes from, counted from 1."""
    row: npt.NDArray[np.uint32]
    """Its number in the file that it was read from, counted from 0."""
    sources: tuple[str, ...]
    """Names of the sources, a sensor or a line."""

    def __len__(self) -> int:
        return len(self.time_s)


def cloud(
    survey: Survey,
    result: Result | Solution | FoundMounting | Mounting,
    *,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
) -> Cloud:
    """All points of a pool or seabed survey under a calibration; those without a position are left out.

    Of a whole result, what it found of heave and heights of lines is applied too (seabed). :exc:`InputError` for a survey whose sensors
    give no points. :func:`apply` writes the same points as LAS or LAZ.
    """
    of = (result._finished, result.require().solution.name) if isinstance(result, Result) else None
    found = survey._handle.cloud(_model(result), of, threads=threads, progress=told(progress))
    if found is None:
        expected = "a pool or seabed survey"
        raise InputError.of([Fault("cloud", "survey", f"a {survey.procedure} survey, whose sensors give no points", expected)])
    return Cloud(found["xyz_m"], found["time_s"], found["source"], found["row"], tuple(found["sources"]))


def _model(result: Result | Solution | FoundMounting | Mounting) -> list[float]:
    """Rotation by rows, lever arm, latency, range scale."""
    solution = result.require().solution if isinstance(result, Result) else result
    mounting = solution.mounting if isinstance(solution, Solution) else solution
    if not isinstance(mounting, (FoundMounting, Mounting)):
        expected = "a Result, a Solution or a Mounting"
        raise InputError.of([Fault("result", "whole argument", f"a {type(result).__name__}", expected)])
    arm = mounting.lever_arm_m
    if arm is None:
        raise InputError.of([Fault("result", "lever_arm_m", "nothing", "a mounting with a lever arm")])
    values = [0.0, 0.0]
    if isinstance(solution, Solution):
        for k, name in enumerate(("latency", "range_scale")):
            p = solution.parameters.get(name)
            values[k] = p.value if p is not None and p.determined and p.value is not None else 0.0
    return [*mounting.rotation.ravel().tolist(), *(float(v) for v in arm), *values]
