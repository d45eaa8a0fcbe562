"""Error budgets by propagation, and which pass to sail next."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _core
from ._errors import Fault, InputError
from ._progress import ProgressCallback, told
from ._survey import Survey, scenario_file

Path = str | PathLike[str]

_SIX = ("pitch", "roll", "yaw", "lx", "ly", "lz")


class _Written:
    """A JSON file of the command's."""

    def __init__(self, data: bytes) -> None:
        self._bytes = data
        self._keys: dict[str, Any] = json.loads(data)

    def to_json(self) -> bytes:
        """As the command writes it, but for the command."""
        return self._bytes

    def to_dict(self) -> dict[str, Any]:
        """The same as plain Python, a copy."""
        found: dict[str, Any] = json.loads(self._bytes)
        return found


class Budget(_Written):
    """What each error source costs, by propagation; angles in degrees, lengths in metres."""

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(p["name"] for p in self._keys["parameters"])

    @property
    def units(self) -> tuple[str, ...]:
        """Their units: deg, m, s or 1."""
        return tuple(p["unit"] for p in self._keys["parameters"])

    @property
    def sources(self) -> dict[str, str]:
        """The error sources that act, each with its title."""
        return {s["source"]: s["title"] for s in self._keys["sources"]}

    @property
    def sigma(self) -> dict[str, npt.NDArray[np.float64]]:
        """Standard deviation of every parameter (n,) by path; a path without derivatives is missing."""
        found = {p["path"]: (p.get("predicted") or {}).get("standard_deviation") for p in self._keys["paths"]}
        return {path: np.array(values, dtype=np.float64) for path, values in found.items() if values is not None}

    @property
    def shares(self) -> dict[str, dict[str, npt.NDArray[np.float64]]]:
        """Share of each source in the variance of every parameter (n,), by path and source; NaN where it cannot be said."""
        found: dict[str, dict[str, npt.NDArray[np.float64]]] = {}
        for path in self._keys["paths"]:
            for share in path["shares"]:
                if share.get("share") is not None:
                    found.setdefault(path["path"], {})[share["source"]] = np.array(share["share"], dtype=np.float64)
        return found

    @property
    def swath(self) -> Mapping[str, Any] | None:
        """What each path's calibration means for soundings across the swath; ``None`` where the procedure takes none."""
        swath: Mapping[str, Any] | None = self._keys.get("swath")
        return swath

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences that the reader should know."""
        return tuple(self._keys["notes"])

    def __repr__(self) -> str:
        return f"<Budget of {self._keys['scenario']!r}: {len(self.sources)} sources>"


def budget(
    what: Path | Survey,
    *,
    depths_m: Sequence[float] | None = None,
    seed: int = 1,
    progress: ProgressCallback | None = None,
) -> Budget:
    """The error budget by propagation of a scenario (file or text), or of a survey as it claims its instruments to err.

    :exc:`InputError` where nothing can be propagated: of the procedures ``pool`` alone has derivatives, of the others run a
    :class:`Campaign`.
    """
    survey = what if isinstance(what, Survey) else None
    file, text = ("survey", None) if isinstance(what, Survey) else scenario_file(what)
    depths = None if depths_m is None else [float(d) for d in depths_m]
    core = None if survey is None else survey._handle
    return Budget(_core.budget(file, text, core, depths, seed, progress=told(progress)))


class Plan(_Written):
    """Which passes to sail next; angles in degrees, lengths in metres."""

    @property
    def passes_needed(self) -> int | None:
        """How many more passes reach what is wanted; ``None`` where no number of them does."""
        found: int | None = self._keys["passes_needed"]
        return found

    @property
    def chosen(self) -> tuple[Mapping[str, Any], ...]:
        """The next passes in order, each with the standard deviations after it."""
        return tuple(self._keys["chosen"])

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences that the reader should know."""
        return tuple(self._keys["notes"])

    def __repr__(self) -> str:
        needed = self.passes_needed
        return f"<Plan for {self._keys['scenario']!r}: {'out of reach' if needed is None else f'{needed} more passes'}>"


def plan(
    scenario: Path,
    *,
    wanted: Mapping[str, float] | None = None,
    distances_m: Sequence[float] = (),
    speeds_m_s: Sequence[float] = (),
    crabs_deg: Sequence[float] = (),
    both_directions: bool = False,
    from_scratch: bool = False,
    smallest: Literal["volume", "variances"] = "volume",
    most: int = 30,
    progress: ProgressCallback | None = None,
) -> Plan:
    """Which pass of a pool scenario to sail next, and how many are needed.

    ``wanted`` are standard deviations of any of pitch, roll, yaw (degrees), lx, ly, lz (metres); those not named are the best that
    are published. The scenario's passes count as sailed unless it is ``from_scratch``. Candidates are all combinations of what is given,
    or a wide choice where nothing is.
    """
    file, text = scenario_file(scenario)
    faults = []
    goals = []
    for name, value in (wanted or {}).items():
        if name not in _SIX:
            faults.append(Fault("plan", f"wanted[{name!r}]", "no such parameter", f"one of {', '.join(_SIX)}"))
        elif not (math.isfinite(value) and value > 0):
            faults.append(Fault("plan", f"wanted[{name!r}]", str(value), "a number above 0"))
        else:
            goals.append((name, float(value) if name in _SIX[:3] else 1e3 * float(value)))
    for name, numbers, between, expected in (
        ("distances_m", distances_m, (0.0, math.inf), "numbers above 0"),
        ("speeds_m_s", speeds_m_s, (0.0, math.inf), "numbers above 0"),
        ("crabs_deg", crabs_deg, (-90.0, 90.0), "degrees between -90 and 90"),
    ):
        wrong = [v for v in numbers if not between[0] < v < between[1]]
        if wrong:
            faults.append(Fault("plan", name, str(wrong[0]), expected))
    if smallest not in ("volume", "variances"):
        faults.append(Fault("plan", "smallest", repr(smallest), '"volume" or "variances"'))
    if not 1 <= most <= 1000:
        faults.append(Fault("plan", "most", str(most), "1 to 1000"))
    if faults:
        raise InputError.of(faults)
    found = _core.plan(
        file,
        text,
        goals,
        [float(v) for v in distances_m],
        [float(v) for v in speeds_m_s],
        [float(v) for v in crabs_deg],
        both_directions,
        from_scratch,
        smallest,
        most,
        progress=told(progress),
    )
    return Plan(found)
