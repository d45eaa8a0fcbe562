"""What a calibration found."""

from __future__ import annotations

import json
import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape
from os import PathLike, fspath
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._errors import AdjustmentError

Array = npt.NDArray[np.float64]


def _array(value: Any) -> Array | None:
    if value is None:
        return None
    array = np.array(value, dtype=np.float64)
    array.flags.writeable = False
    return array


@dataclass(frozen=True)
class Parameter:
    """One parameter of a solution; angles in degrees, lengths in metres, times in seconds, scales without a unit."""

    name: str
    """Such as ``roll``."""
    unit: str
    """``deg``, ``m``, ``s`` or ``1``."""
    positive: str
    """What a positive value means; empty where that says nothing."""
    value: float | None
    """Estimate; ``None`` when it is not determined or not sought."""
    nominal: float | None
    """The same before the calibration."""
    correction: float | None
    """What the calibration changes; of pitch, roll and yaw the components of ``log(R R_nominal^T)`` in the body frame."""
    sigma: float | None
    """One sigma of the correction; ``None`` when held, or of a path that has none."""
    determined: bool
    """Whether the path determined it."""
    note: str
    """What the reader should know; mostly empty."""


@dataclass(frozen=True, eq=False)
class FoundMounting:
    """Where a sensor sits: rotation from the sensor frame to the body frame (3, 3), lever arm (3,) in the body frame, metres."""

    name: str
    rotation: Array
    lever_arm_m: Array | None
    """``None`` where the procedure seeks none."""
    roll_deg: float
    pitch_deg: float
    heading_deg: float
    nominal_rotation: Array
    nominal_lever_arm_m: Array | None
    lever_arm_sigma_m: Array | None
    arrays: tuple[FoundMounting, ...] = ()
    """Of a sounder whose two arrays stand each on its own: the transmit and the receive array. The mounting stands for both and is neither's record."""


@dataclass(frozen=True)
class Finding:
    """One thing that speaks against a result."""

    code: str
    """Short name, the same in every procedure: what ``[verdict] accept`` lists."""
    severity: str
    """``finding``, ``withdraws`` or ``refuses``."""
    seen: str
    """What was seen."""
    threshold: str
    """What it was held against."""
    advice: str
    """What to try."""
    accepted: bool
    """The survey file accepts it."""


class Solution:
    """What one path found."""

    def __init__(self, name: str, keys: Mapping[str, Any]) -> None:
        self.name = name
        """``joint``, ``reference`` or ``joint_simple``."""
        self._keys = keys

    @property
    def usable(self) -> bool:
        """Whether the numbers may be used."""
        return bool(self._keys["usable"])

    @property
    def status(self) -> str:
        """How it ended: ``converged``, ``stalled``, ``rank_deficient``, ``out_of_iterations`` or ``refused``."""
        return str(self._keys["status"])

    @property
    def message(self) -> str:
        """The end in words; mostly empty."""
        return str(self._keys["message"])

    @cached_property
    def parameters(self) -> Mapping[str, Parameter]:
        """The parameters sought by name, in order; empty for a refused one."""
        optional = ("positive", "note")
        fields = tuple(Parameter.__dataclass_fields__)
        found = {
            p["name"]: Parameter(**{f: p.get(f, "") if f in optional else p.get(f) for f in fields})
            for p in self._keys["parameters"]
        }
        return MappingProxyType(found)

    @cached_property
    def covariance(self) -> Array | None:
        """Covariance of the corrections in the order of ``parameters``: rad, m, s, 1; ``None`` for a path that has none."""
        return _array(self._keys["covariance"])

    @cached_property
    def sigma(self) -> Array | None:
        """Standard deviations of the corrections in the order of ``parameters``: rad, m, s, 1; 0 for one that was held."""
        covariance = self.covariance
        return None if covariance is None else _array(np.sqrt(np.diag(covariance)))

    @cached_property
    def correlation(self) -> Array | None:
        """Correlations in the order of ``parameters``."""
        return _array(self._keys["correlation"])

    @cached_property
    def mountings(self) -> Mapping[str, FoundMounting]:
        """The mountings that were sought by the names of their sensors."""
        return MappingProxyType({m["name"]: _mounting(m) for m in self._keys["mountings"]})

    @property
    def mounting(self) -> FoundMounting:
        """The mounting, where there is one; :exc:`AdjustmentError` where the path found none, and a choice where it found several."""
        found = tuple(self.mountings.values())
        if not found:
            raise AdjustmentError(f"the {self.name} path found no mounting: {self.message or self.status}")
        if len(found) > 1:
            raise AttributeError(f"there are several mountings: take mountings[name] with one of {', '.join(self.mountings)}")
        return found[0]

    @property
    def quality(self) -> Mapping[str, Any] | None:
        """Tests, reliability and what the data determine, as in ``result.json``."""
        found: Mapping[str, Any] | None = self._keys["quality"]
        return found

    def __repr__(self) -> str:
        return f"<Solution {self.name}: {self.status}, {'usable' if self.usable else 'not usable'}>"


def _mounting(m: Mapping[str, Any]) -> FoundMounting:
    angles = m["mounting_deg"]
    rotation, nominal = _array(m["rotation_matrix"]), _array(m["nominal_rotation_matrix"])
    assert rotation is not None and nominal is not None
    return FoundMounting(
        name=m["name"],
        rotation=rotation,
        lever_arm_m=_array(m["lever_arm_m"]),
        roll_deg=angles["roll"],
        pitch_deg=angles["pitch"],
        heading_deg=angles["heading"],
        nominal_rotation=nominal,
        nominal_lever_arm_m=_array(m["nominal_lever_arm_m"]),
        lever_arm_sigma_m=_array(m["lever_arm_sigma_m"]),
        arrays=tuple(_mounting(array) for array in m.get("arrays", ())),
    )


class Result:
    """The result of a calibration: ``result.json`` and what the report shows beside it.

    Results are equal when their bytes are. A pickled result, and one that was read from a file, holds the bytes alone: its report then
    has no pictures of the observations.
    """

    def __init__(self, finished: _core.Finished) -> None:
        self._finished = finished
        self._bytes = finished.to_json()

    @classmethod
    def from_json(cls, data: bytes) -> Result:
        """From the bytes of ``result.json``; :exc:`InputError` for anything else."""
        return cls(_core.Finished.from_json(data))

    def to_json(self) -> bytes:
        """The bytes of ``result.json``, the same as the command writes."""
        return self._bytes

    def to_dict(self) -> dict[str, Any]:
        """``result.json`` as plain Python, a copy."""
        found: dict[str, Any] = json.loads(self._bytes)
        return found

    @cached_property
    def _keys(self) -> dict[str, Any]:
        return self.to_dict()

    @property
    def procedure(self) -> str:
        """``pool``, ``usbl``, ``rail`` or ``seabed``."""
        return str(self._keys["procedure"])

    @property
    def usable(self) -> bool:
        """Whether the deciding solution may be used."""
        return bool(self._keys["usable"])

    @property
    def reason(self) -> str | None:
        """Why the result is not usable; ``None`` when it is."""
        found: str | None = self._keys["reason"]
        return found

    def require(self) -> Result:
        """The result itself when it is usable; :exc:`AdjustmentError` with the reason when not."""
        if not self.usable:
            raise AdjustmentError(self.reason or "no usable result")
        return self

    @property
    def verdict(self) -> str:
        """``usable``, ``usable with findings``, ``does not fit`` or ``not determined``."""
        return str(self._keys["verdict"]["state"])

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """What speaks against the result, gravest first."""
        names = ("code", "severity", "seen", "threshold", "advice")
        listed = self._keys["verdict"]["findings"]
        return tuple(Finding(**{n: f[n] for n in names}, accepted=f.get("accepted", False)) for f in listed)

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences that the reader should know."""
        return tuple(self._keys["notes"])

    @property
    def counts(self) -> Mapping[str, Any]:
        """Observations read, used and rejected by reason, by sensor."""
        found: Mapping[str, Any] = self._keys["counts"]
        return found

    @cached_property
    def solutions(self) -> Mapping[str, Solution]:
        """The solution of every path that ran, by name."""
        return MappingProxyType({name: Solution(name, keys) for name, keys in self._keys["solutions"].items()})

    @property
    def joint(self) -> Solution | None:
        """The joint solution; ``None`` where it did not run."""
        return self.solutions.get("joint")

    @property
    def reference(self) -> Solution | None:
        """The solution of the source document's path; ``None`` where it did not run."""
        return self.solutions.get("reference")

    @property
    def extra(self) -> Mapping[str, Parameter]:
        """Your own unknowns by name, in their own units; empty where there were none, or where the joint path found nothing."""
        joint = self.joint
        names = (joint._keys.get("details") or {}).get("extra", []) if joint else []
        return MappingProxyType({name: joint.parameters[name] for name in names if joint})

    @property
    def solution(self) -> Solution:
        """The solution that decides: the joint one where it ran, else the reference one."""
        found = self.joint or self.reference
        if found is None:
            raise AdjustmentError("no path ran")
        return found

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """Those of the deciding solution, by name."""
        return self.solution.parameters

    @property
    def mounting(self) -> FoundMounting:
        """The mounting of the deciding solution."""
        return self.solution.mounting

    @property
    def mountings(self) -> Mapping[str, FoundMounting]:
        """The mountings of the deciding solution, by sensor."""
        return self.solution.mountings

    @property
    def covariance(self) -> Array | None:
        """That of the deciding solution: rad, m, s, 1."""
        return self.solution.covariance

    @property
    def sigma(self) -> Array | None:
        """Standard deviations of the deciding solution: rad, m, s, 1."""
        return self.solution.sigma

    @property
    def text(self) -> str:
        """What the command prints."""
        return self._finished.text()

    def html(self) -> str:
        """The page of ``report.html``: one file that needs no network."""
        return self._finished.html()

    def report(self, path: str | PathLike[str]) -> pathlib.Path:
        """Writes the page of ``report.html``; its path."""
        file = pathlib.Path(fspath(path))
        file.write_text(self.html(), encoding="utf-8")
        return file

    def write(self, folder: str | PathLike[str], exports: Sequence[str] = ()) -> None:
        """Writes what the command writes, together or not at all: ``result.json``, ``report.html``, ``parameters.csv``, and the values to enter
        in other forms (``latex``, ``csv``, ``hvf-card``, ``qimera``, ``sis``, ``applanix``, ``novatel``)."""
        self._finished.write(fspath(folder), list(exports))

    def __eq__(self, other: object) -> bool:
        return self._bytes == other._bytes if isinstance(other, Result) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._bytes)

    def __reduce__(self) -> tuple[Any, tuple[bytes]]:
        return Result.from_json, (self._bytes,)

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return f"<Result of a {self.procedure} calibration: {self.verdict}>"

    def _repr_html_(self) -> str:
        return _table(self)


def read_result(path: str | PathLike[str]) -> Result:
    """Reads a ``result.json``; :exc:`InputError` for anything else."""
    return Result.from_json(pathlib.Path(fspath(path)).read_bytes())


def _table(result: Result) -> str:
    """The values to enter, and the other path's beside them."""
    heading = f"{escape(result.procedure)}: {escape(result.verdict)}"
    reason = "" if result.reason is None else f"<p>{escape(result.reason)}</p>"
    solution = result.solution
    other = result.reference if solution.name == "joint" else None
    head = ["", "before", "after", "sigma"] + ([] if other is None else ["reference path"]) + ["positive"]
    rows = []
    for p in solution.parameters.values():
        sigma = p.sigma
        name = p.name if p.unit in ("", "1") else f"{p.name}, {p.unit}"
        cells = [name, _shown(p.nominal, sigma), _shown(p.value, sigma), "" if sigma is None else f"{sigma:.2g}"]
        if other is not None:
            same = other.parameters.get(p.name)
            cells.append("" if same is None else _shown(same.value, sigma))
        rows.append([*cells, p.positive])
    listed = "".join(
        f"<li>{escape(f.code)}: {escape(f.seen)}{'; ' + escape(f.advice) if f.advice else ''}</li>" for f in result.findings
    )
    th = "".join(f"<th>{escape(h)}</th>" for h in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(c)}</td>" for c in row) + "</tr>" for row in rows)
    table = f"<table><thead><tr>{th}</tr></thead><tbody>{body}</tbody></table>" if rows else ""
    return f"<div><strong>{heading}</strong>{reason}{table}{f'<ul>{listed}</ul>' if listed else ''}</div>"


def _shown(value: float | None, sigma: float | None) -> str:
    """With two digits of its sigma."""
    if value is None:
        return "not determined"
    if not sigma:
        return f"{value:.6g}"
    decimals = max(0, 1 - int(np.floor(np.log10(sigma))))
    return f"{value:.{min(decimals, 12)}f}"
