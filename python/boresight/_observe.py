"""Observations and mountings: what a survey is made of when it is not read from files.

Columns are copied when an object is made and are read-only afterwards. SI units and radians in arrays; degrees only where a name ends
in ``_deg``. Frames and signs are those of the library (``docs/conventions.md``).
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _core
from ._arrays import Column, Numbers, column, number, numbers, rows, same_length, triple
from ._errors import Fault, InputError


def _raise(faults: list[Fault]) -> None:
    if faults:
        raise InputError.of(faults)


def _figures(of: str, values: Mapping[str, object], positive: Sequence[str] = ()) -> dict[str, float]:
    """Standard deviations: numbers, not below 0, some above it."""
    faults: list[Fault] = []
    found = {name: number(of, name, value, faults) for name, value in values.items()}
    for name, value in found.items():
        if value < 0 or (value == 0 and name in positive):
            expected = "a number above 0" if name in positive else "0 or more"
            if not any(fault.place == name for fault in faults):
                faults.append(Fault(of, name, str(value), expected))
    _raise(faults)
    return found


def _freeze(target: object, values: Mapping[str, object]) -> None:
    for name, value in values.items():
        object.__setattr__(target, name, value)


@dataclass(frozen=True)
class TrajectoryNoise:
    """Claimed noise of a trajectory, one sigma. By default a tactical-grade INS, post-processed."""

    position_m: float = 0.002
    """White, per record and axis, metres."""
    position_drift_m: float = 0.01
    """First-order Gauss-Markov drift per axis, metres."""
    drift_correlation_time_s: float = 60.0
    """Its correlation time, seconds."""
    roll_pitch_rad: float = 0.003 * (math.pi / 180)
    """White roll and pitch noise per record, radians."""
    heading_rad: float = 0.005 * (math.pi / 180)
    """White heading noise per record, radians."""
    heading_drift_rad: float = 0.0
    """Slow (Gauss-Markov) heading error, radians."""

    def __post_init__(self) -> None:
        _freeze(self, _figures("TrajectoryNoise", self.__dict__, ["drift_correlation_time_s"]))


@dataclass(frozen=True)
class LaserNoise:
    """Claimed noise of a laser scan, one sigma. By default a surveying scanner in line-scan mode."""

    range_m: float = 0.005
    """Range, metres."""
    angle_rad: float = 0.002 * (math.pi / 180)
    """Angle in the scanner's plane, radians."""
    point_m: float = 0.01
    """Per axis, metres: of points that are georeferenced already."""

    def __post_init__(self) -> None:
        _freeze(self, _figures("LaserNoise", self.__dict__, ["range_m", "point_m"]))


@dataclass(frozen=True)
class SonarNoise:
    """Claimed noise of soundings, one sigma. By default a shallow-water multibeam of half a degree beam width."""

    range_m: float = 0.01
    """Range, metres."""
    across_rad: float = 0.06 * (math.pi / 180)
    """Across-track angle, radians."""
    along_rad: float = 0.0
    """Along-track angle, radians."""

    def __post_init__(self) -> None:
        _freeze(self, _figures("SonarNoise", self.__dict__, ["range_m", "across_rad"]))


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """An INS trajectory: columns of one length n.

    ``time_s`` ascends strictly; latitude and longitude are geodetic; roll is positive starboard down, pitch bow up, heading true and
    clockwise from north. ``velocity_m_s`` (n, 3) is east, north, up, where the source gives it.
    """

    time_s: Column
    latitude_rad: Column
    longitude_rad: Column
    height_m: Column
    roll_rad: Column
    pitch_rad: Column
    heading_rad: Column
    velocity_m_s: Column | None
    noise: TrajectoryNoise

    def __init__(
        self,
        time_s: npt.ArrayLike,
        latitude_rad: npt.ArrayLike,
        longitude_rad: npt.ArrayLike,
        height_m: npt.ArrayLike,
        roll_rad: npt.ArrayLike,
        pitch_rad: npt.ArrayLike,
        heading_rad: npt.ArrayLike,
        *,
        velocity_m_s: npt.ArrayLike | None = None,
        noise: TrajectoryNoise | None = None,
    ) -> None:
        given = {
            "time_s": time_s,
            "latitude_rad": latitude_rad,
            "longitude_rad": longitude_rad,
            "height_m": height_m,
            "roll_rad": roll_rad,
            "pitch_rad": pitch_rad,
            "heading_rad": heading_rad,
        }
        faults: list[Fault] = []
        found: dict[str, Column | Numbers] = {k: column("trajectory", k, v, faults) for k, v in given.items()}
        velocity = None if velocity_m_s is None else rows("trajectory", "velocity_m_s", velocity_m_s, faults)
        same_length("trajectory", found if velocity is None else {**found, "velocity_m_s": velocity}, faults)
        _raise(faults)
        _freeze(self, {**found, "velocity_m_s": velocity, "noise": noise or TrajectoryNoise()})

    def __len__(self) -> int:
        return len(self.time_s)

    def __repr__(self) -> str:
        return f"<Trajectory of {len(self)} records, {self.time_s[0]:.3f} to {self.time_s[-1]:.3f} s>"


@dataclass(frozen=True)
class Utm:
    """Coordinates in a UTM zone with ellipsoidal heights, such as ``Utm("50N")``."""

    zone: str


Frame = Literal["sensor", "target", "geocentric"]
"""Frame of laser points: the scanner's own, the target's, or earth-centred."""


@dataclass(frozen=True, eq=False, repr=False)
class LaserScan:
    """Laser returns: times and points (n, 3) in metres, given as rows or as three columns.

    In the frame ``"sensor"`` they are georeferenced with trajectory and scanner's mounting; in the others they are taken as they are.
    """

    time_s: Column
    xyz_m: Column
    frame: Frame | Utm
    noise: LaserNoise

    def __init__(
        self,
        time_s: npt.ArrayLike,
        xyz_m: npt.ArrayLike | None = None,
        *,
        x_m: npt.ArrayLike | None = None,
        y_m: npt.ArrayLike | None = None,
        z_m: npt.ArrayLike | None = None,
        frame: Frame | Utm = "sensor",
        noise: LaserNoise | None = None,
    ) -> None:
        faults: list[Fault] = []
        time = column("laser", "time_s", time_s, faults)
        columns = {"x_m": x_m, "y_m": y_m, "z_m": z_m}
        if xyz_m is not None:
            for name in (name for name, value in columns.items() if value is not None):
                faults.append(Fault("laser", name, "it beside xyz_m", "either xyz_m or x_m, y_m and z_m"))
            points = rows("laser", "xyz_m", xyz_m, faults)
            same_length("laser", {"time_s": time, "xyz_m": points}, faults)
        else:
            found = {name: column("laser", name, value, faults) for name, value in columns.items()}
            same_length("laser", {"time_s": time, **found}, faults)
            _raise(faults)
            points = np.column_stack(list(found.values()))
            points.flags.writeable = False
        if not isinstance(frame, Utm) and frame not in ("sensor", "target", "geocentric"):
            expected = '"sensor", "target", "geocentric" or Utm(zone)'
            faults.append(Fault("laser", "frame", repr(frame), expected))
        _raise(faults)
        _freeze(self, {"time_s": time, "xyz_m": points, "frame": frame, "noise": noise or LaserNoise()})

    def __len__(self) -> int:
        return len(self.time_s)

    def __repr__(self) -> str:
        return f"<LaserScan of {len(self)} returns, frame {self.frame!r}>"


@dataclass(frozen=True, eq=False, repr=False)
class Soundings:
    """Soundings of a multibeam: one row per beam, columns of one length n, times not descending.

    ``across_rad`` is positive to starboard, ``along_rad`` is the elevation out of the across plane, positive forward. Either slant
    ranges ``range_m`` or two-way travel times ``travel_time_s``, which need a sound speed. Without ``ping`` and ``beam``, rows of one
    time are one ping.
    """

    time_s: Column
    across_rad: Column
    along_rad: Column
    range_m: Column | None
    travel_time_s: Column | None
    ping: Numbers
    beam: Numbers
    noise: SonarNoise

    def __init__(
        self,
        time_s: npt.ArrayLike,
        across_rad: npt.ArrayLike,
        along_rad: npt.ArrayLike | None = None,
        *,
        range_m: npt.ArrayLike | None = None,
        travel_time_s: npt.ArrayLike | None = None,
        ping: npt.ArrayLike | None = None,
        beam: npt.ArrayLike | None = None,
        noise: SonarNoise | None = None,
    ) -> None:
        faults: list[Fault] = []
        found: dict[str, Column | Numbers] = {
            "time_s": column("soundings", "time_s", time_s, faults),
            "across_rad": column("soundings", "across_rad", across_rad, faults),
        }
        if along_rad is not None:
            found["along_rad"] = column("soundings", "along_rad", along_rad, faults)
        ranges = {"range_m": range_m, "travel_time_s": travel_time_s}
        given = {name: value for name, value in ranges.items() if value is not None}
        if len(given) != 1:
            what = "both" if given else "neither"
            faults.append(Fault("soundings", "range_m and travel_time_s", what, "one of them"))
        for name, value in given.items():
            found[name] = column("soundings", name, value, faults)
        for name, counted in {"ping": ping, "beam": beam}.items():
            if counted is not None:
                found[name] = numbers("soundings", name, counted, faults)
        same_length("soundings", found, faults)
        _raise(faults)
        own_ping, own_beam = _numbered(np.asarray(found["time_s"], dtype=np.float64))
        zeros = np.zeros(len(found["time_s"]))
        zeros.flags.writeable = False
        defaults = {"along_rad": zeros, "ping": own_ping, "beam": own_beam, "range_m": None, "travel_time_s": None}
        _freeze(self, {**defaults, **found, "noise": noise or SonarNoise()})

    def __len__(self) -> int:
        return len(self.time_s)

    def __repr__(self) -> str:
        kind = "ranges" if self.travel_time_s is None else "travel times"
        return f"<Soundings: {len(self)} {kind} of {len(np.unique(self.ping))} pings>"


Acts = Literal["up", "range", "across", "along"]
"""What an unknown of your own changes: a sounding's height (m), its range (m), its across-track or along-track angle (rad)."""


@dataclass(frozen=True, eq=False, repr=False)
class Extra:
    """An unknown of your own: what it changes of every sounding, as one array of derivatives.

    ``derivative[k] * value`` is added to the height, range or angle of sounding ``k`` (``acts_on``): metres or radians per ``unit``; NaN
    where it does not act. ``prior_sigma`` is what is known of the value beforehand, about zero. Squat, a slow range clock, a tide:

    >>> import numpy as np
    >>> Extra("squat", np.array([0.0, 1.2, 4.8]), unit="s2/m", prior_sigma=0.05)
    <Extra 'squat', acts on up, 3 soundings>

    A derivative that is a noisy measurement itself (the measured range) biases its unknown; smooth it first.
    """

    name: str
    derivative: Column
    unit: str
    acts_on: Acts
    prior_sigma: float | None

    def __init__(
        self,
        name: str,
        derivative: npt.ArrayLike,
        *,
        unit: str = "1",
        acts_on: Acts = "up",
        prior_sigma: float | None = None,
    ) -> None:
        faults: list[Fault] = []
        found = column("Extra", "derivative", derivative, faults, holes=True)
        if acts_on not in ("up", "range", "across", "along"):
            faults.append(Fault("Extra", "acts_on", repr(acts_on), '"up", "range", "across" or "along"'))
        prior = None if prior_sigma is None else number("Extra", "prior_sigma", prior_sigma, faults)
        for what, text in {"name": name, "unit": unit}.items():
            if not isinstance(text, str):
                faults.append(Fault("Extra", what, f"a {type(text).__name__}", "a text"))
        _raise(faults)
        fields = {"name": name, "derivative": found, "unit": unit, "acts_on": acts_on, "prior_sigma": prior}
        _freeze(self, fields)

    def __repr__(self) -> str:
        return f"<Extra {self.name!r}, acts on {self.acts_on}, {len(self.derivative)} soundings>"


def _numbered(time_s: Column) -> tuple[Numbers, Numbers]:
    """Ping and beam numbers of rows in order of time."""
    begins = np.concatenate([[True], np.diff(time_s) != 0])
    ping = np.cumsum(begins) - 1
    beam = np.arange(len(time_s)) - np.flatnonzero(begins)[ping]
    both = ping.astype(np.uint32), beam.astype(np.uint32)
    for array in both:
        array.flags.writeable = False
    return both


@dataclass(frozen=True)
class Mounting:
    """How a sensor is believed to sit: roll (starboard down), pitch (bow up), heading (clockwise) in degrees, and the lever arm in the
    body frame (right, forward, up) in metres; for a scanner also how well that is known (about x, y, z: pitch, roll, yaw)."""

    roll_deg: float = 0.0
    pitch_deg: float = 0.0
    heading_deg: float = 0.0
    lever_arm_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    sigma_deg: tuple[float, float, float] | None = None
    lever_arm_sigma_m: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        faults: list[Fault] = []
        angles = ("roll_deg", "pitch_deg", "heading_deg")
        found: dict[str, object] = {name: number("Mounting", name, getattr(self, name), faults) for name in angles}
        found["lever_arm_m"] = triple("Mounting", "lever_arm_m", self.lever_arm_m, faults)
        for name in ("sigma_deg", "lever_arm_sigma_m"):
            if getattr(self, name) is not None:
                found[name] = triple("Mounting", name, getattr(self, name), faults)
        if (self.sigma_deg is None) != (self.lever_arm_sigma_m is None):
            missing = "sigma_deg" if self.sigma_deg is None else "lever_arm_sigma_m"
            faults.append(Fault("Mounting", missing, "nothing", "both sigmas or none"))
        _raise(faults)
        _freeze(self, found)

    @property
    def rotation(self) -> npt.NDArray[np.float64]:
        """Sensor frame to body frame, (3, 3): ``Rz(-heading) Rx(pitch) Ry(roll)``."""
        r, p, h = (math.radians(a) for a in (self.roll_deg, self.pitch_deg, self.heading_deg))
        about_z = np.array([[math.cos(h), math.sin(h), 0.0], [-math.sin(h), math.cos(h), 0.0], [0.0, 0.0, 1.0]])
        about_x = np.array([[1.0, 0.0, 0.0], [0.0, math.cos(p), -math.sin(p)], [0.0, math.sin(p), math.cos(p)]])
        about_y = np.array([[math.cos(r), 0.0, math.sin(r)], [0.0, 1.0, 0.0], [-math.sin(r), 0.0, math.cos(r)]])
        turned: npt.NDArray[np.float64] = about_z @ about_x @ about_y
        return turned


@dataclass(frozen=True)
class Pose:
    """Where a target is believed to stand: geodetic position of its origin and azimuth of its +Y axis (degrees, metres), and the height
    of the water level in its frame."""

    latitude_deg: float
    longitude_deg: float
    height_m: float
    azimuth_deg: float
    water_level_m: float = 0.0
    ellipsoid: str = "WGS84"

    def __post_init__(self) -> None:
        faults: list[Fault] = []
        names = ("latitude_deg", "longitude_deg", "height_m", "azimuth_deg", "water_level_m")
        found = {name: number("Pose", name, getattr(self, name), faults) for name in names}
        _raise(faults)
        _freeze(self, found)


@dataclass(frozen=True)
class Face:
    """A plane piece of a free-form target: its role (``P1``, ``P2``, ``P3``, ``horizontal``, ``other``, ``obstacle``) and vertices in the target frame,
    metres, counter-clockwise seen from the sensors. Faces of one ``plane`` lie in one plane exactly."""

    name: str
    role: str
    vertices_m: npt.ArrayLike
    plane: str | None = None
    offset_sigma_m: float = 0.0


@dataclass(frozen=True)
class Target:
    """A calibration target at design dimensions: the keys of a target file."""

    keys: Mapping[str, Any]

    @classmethod
    def wall(
        cls,
        *,
        length_m: float,
        height_m: float,
        block_leg_m: float,
        block_height_m: float,
        first_block_minus_y_m: float,
        first_block_plus_y_m: float,
        coplanarity_sigma_m: float = 0.0,
        height_sigma_m: float = 0.0,
    ) -> Target:
        """The patent's wall with two staggered columns of triangular blocks: free length and height of the wall, short sides and height
        of the blocks, undersides of the lowest block of either column; all metres."""
        return cls(
            {
                "kind": "pool-wall",
                "wall_length_m": float(length_m),
                "wall_height_m": float(height_m),
                "block_leg_m": float(block_leg_m),
                "block_height_m": float(block_height_m),
                "first_block_minus_y_m": float(first_block_minus_y_m),
                "first_block_plus_y_m": float(first_block_plus_y_m),
                "coplanarity_sigma_m": float(coplanarity_sigma_m),
                "height_sigma_m": float(height_sigma_m),
            }
        )

    @classmethod
    def faces(cls, faces: Sequence[Face]) -> Target:
        """Free-form faces."""
        faults: list[Fault] = []
        listed: list[dict[str, object]] = []
        for k, face in enumerate(faces):
            vertices = rows("target", f"faces[{k}].vertices_m", face.vertices_m, faults)
            one: dict[str, object] = {
                "name": face.name,
                "role": face.role,
                "vertices_m": vertices.tolist(),
                "offset_sigma_m": float(face.offset_sigma_m),
            }
            listed.append(one if face.plane is None else {**one, "plane": face.plane})
        _raise(faults)
        return cls({"kind": "faces", "face": listed})

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Target:
        """From a target file."""
        return cls(json.loads(_core.read_target(fspath(path))))
