"""Files of trials as tables."""

from __future__ import annotations

import csv
import json
import pathlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._errors import LedgerError

if TYPE_CHECKING:
    import pandas
    import xarray

_MARK = "# boresight trials "
_UNITS = ("rad", "m", "s", "1")

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Cell:
    """The trials of one cell, one row per seed, NaN where a path refused. Errors are estimate minus truth; rad, m, s, 1."""

    name: str
    """``together``, ``nothing``, ``only-SOURCE``, ``true-ties`` or ``vary-KEY=VALUE``."""
    seeds: npt.NDArray[np.uint64]
    """(n,)"""
    errors: Array
    """(n, path, parameter)"""
    covariance: Array
    """Of the joint path, (n, parameter, parameter)."""
    variance_factor: Array
    """Of the joint path, (n,); NaN where it was not judged."""
    refusals: npt.NDArray[np.str_]
    """(n, path): one word, empty for a path that gave a result."""
    reasons: npt.NDArray[np.str_]
    """(n, path): the same in words."""
    header: Mapping[str, Any]
    """What the trials are of, as it stands in the ledger."""

    def __len__(self) -> int:
        return len(self.seeds)

    @property
    def variance(self) -> Array:
        """Of the joint path, (n, parameter)."""
        return np.diagonal(self.covariance, axis1=1, axis2=2)


class Trials:
    """The trials of a folder: cells by name, a sweep as one grid."""

    def __init__(self, cells: Mapping[str, Cell], vary: Mapping[str, list[Any]]) -> None:
        if not cells:
            raise LedgerError("no files of trials are there")
        self.cells = dict(cells)
        self.vary = dict(vary)
        """Varied keys with their values, the first varying slowest; empty without a sweep."""
        first = next(iter(self.cells.values()))
        self.paths: tuple[str, ...] = tuple(first.header["paths"])
        """Such as ``joint``, ``reference``, ``projected``; the first one reports a covariance."""
        listed = [_named(p) for p in first.header["parameters"]]
        self.parameters: tuple[str, ...] = tuple(name for name, _ in listed)
        """Such as ``pitch``."""
        self.units: tuple[str, ...] = tuple(unit for _, unit in listed)
        """Units of the parameters' errors: rad, m, s or 1."""

    def __getitem__(self, cell: str) -> Cell:
        return self.cells[cell]

    def __iter__(self) -> Iterator[str]:
        return iter(self.cells)

    def __len__(self) -> int:
        return sum(len(cell) for cell in self.cells.values())

    def __repr__(self) -> str:
        return f"<Trials: {len(self)} in {len(self.cells)} cells>"

    @property
    def refusals(self) -> dict[str, dict[str, dict[str, int]]]:
        """How often each path of each cell refused, by reason."""
        found: dict[str, dict[str, dict[str, int]]] = {}
        for name, cell in self.cells.items():
            for k, path in enumerate(self.paths):
                words, counts = np.unique(cell.refusals[:, k], return_counts=True)
                reasons = {str(w): int(c) for w, c in zip(words, counts, strict=True) if w}
                if reasons:
                    found.setdefault(name, {})[path] = reasons
        return found

    def summary(self, cell: str | None = None) -> dict[str, dict[str, dict[str, float]]]:
        """By path and parameter of a cell (all sources together unless another is named): number of usable trials, mean error, standard
        deviation, RMS error and, of the joint path, the RMS of error over its reported sigma (``pull_rms``, 1 where sigmas are right).
        """
        of = self.cells[cell or next(iter(self.cells))]
        found: dict[str, dict[str, dict[str, float]]] = {}
        for k, path in enumerate(self.paths):
            for j, parameter in enumerate(self.parameters):
                errors = of.errors[:, k, j]
                usable = np.isfinite(errors)
                errors = errors[usable]
                n = len(errors)
                figures = {
                    "usable": float(n),
                    "mean": float(errors.mean()) if n else float("nan"),
                    "standard_deviation": float(errors.std(ddof=1)) if n > 1 else float("nan"),
                    "rms": float(np.sqrt(np.mean(errors**2))) if n else float("nan"),
                }
                if k == 0:
                    variance = of.variance[usable, j]
                    held = bool((variance == 0).all())
                    known = n and not held
                    figures["pull_rms"] = float(np.sqrt(np.mean(errors**2 / variance))) if known else float("nan")
                found.setdefault(path, {})[parameter] = figures
        return found

    def to_pandas(self) -> pandas.DataFrame:
        """One row per cell, seed, path and parameter: error, variance of the joint path, refusal. Needs ``boresight[tables]``."""
        import pandas

        frames = []
        for name, cell in self.cells.items():
            n, paths, parameters = cell.errors.shape
            index = pandas.MultiIndex.from_product(
                [[name], cell.seeds, self.paths, self.parameters], names=["cell", "seed", "path", "parameter"]
            )
            variance = np.full(cell.errors.shape, np.nan)
            variance[:, 0, :] = cell.variance
            refusal = np.broadcast_to(cell.refusals[:, :, None], (n, paths, parameters))
            values = {"error": cell.errors.ravel(), "variance": variance.ravel(), "refusal": refusal.ravel()}
            frames.append(pandas.DataFrame(values, index=index))
        return pandas.concat(frames)

    def to_xarray(self, cell: str | None = None) -> xarray.Dataset:
        """The trials of a sweep as a grid with a dimension per varied key; without a sweep, or of a named cell, its trials alone.

        Dimensions: the varied keys, ``seed``, ``path``, ``parameter``; variables ``error``, ``covariance`` (joint path), ``variance_factor``,
        ``refusal``. Refused trials are NaN and stay. Needs ``boresight[tables]``.
        """
        import xarray

        names = [n for n in self.cells if n.startswith("vary-")] if cell is None else []
        keys = list(self.vary) if names else []
        chosen = [self.cells[n] for n in names] or [self.cells[cell or next(iter(self.cells))]]
        shape = tuple(len(self.vary[k]) for k in keys)
        if names and int(np.prod(shape)) != len(names):
            raise LedgerError("the sweep's files of trials are no whole grid")
        trials = min(len(c) for c in chosen)

        def grid(values: list[Any]) -> Any:
            stacked = np.stack([v[:trials] for v in values])
            return stacked.reshape(shape + stacked.shape[1:])

        both = ("parameter", "parameter_")
        data = {
            "error": ((*keys, "seed", "path", "parameter"), grid([c.errors for c in chosen])),
            "covariance": ((*keys, "seed", *both), grid([c.covariance for c in chosen])),
            "variance": ((*keys, "seed", "parameter"), grid([c.variance for c in chosen])),
            "variance_factor": ((*keys, "seed"), grid([c.variance_factor for c in chosen])),
            "refusal": ((*keys, "seed", "path"), grid([c.refusals for c in chosen])),
        }
        coords: dict[str, Any] = {
            **{k: self.vary[k] for k in keys},
            "seed": chosen[0].seeds[:trials],
            "path": list(self.paths),
            "parameter": list(self.parameters),
            "parameter_": list(self.parameters),
        }
        units = {"units": dict(zip(self.parameters, self.units, strict=True)).__repr__()}
        made = xarray.Dataset(data, coords=coords)
        made["error"].attrs.update(units)
        made.attrs.update({k: str(chosen[0].header[k]) for k in ("scenario", "procedure", "version", "first_seed")})
        return made


def _named(column: str) -> tuple[str, str]:
    """A parameter's name and unit from its column's name."""
    name, _, unit = column.rpartition("_")
    return (name, unit) if unit in _UNITS and name else (column, "1")


def read_trials(folder: str | PathLike[str]) -> Trials:
    """Reads the files of trials of ``Campaign.run`` or ``boresight budget --trials`` (the folder, or its subfolder ``trials``).

    A record torn by a crash at a file's end is left out. :exc:`LedgerError` for files that are no such files or damaged otherwise.
    """
    where = pathlib.Path(fspath(folder))
    if not list(where.glob("*.csv")) or (where / "trials").is_dir():
        where = where / "trials"
    files = sorted(where.glob("*.csv"), key=_order)
    if not files:
        raise LedgerError(f"{fspath(folder)}: no files of trials are there")
    cells = {file.stem: _cell(file) for file in files}
    vary = _grid([name for name in cells if name.startswith("vary-")])
    points = sorted((n for n in cells if n.startswith("vary-")), key=lambda n: _place(n, vary))
    others = [n for n in cells if not n.startswith("vary-")]
    return Trials({n: cells[n] for n in [*others, *points]}, vary)


def _order(file: pathlib.Path) -> tuple[int, str]:
    known = ("together", "nothing")
    name = file.stem
    return (known.index(name) if name in known else len(known), name)


def _point(name: str) -> dict[str, Any]:
    """Keys and values of a sweep's point from its name."""
    parts: dict[str, Any] = {}
    for part in name.removeprefix("vary-").split(","):
        key, _, value = part.partition("=")
        try:
            parts[key] = float(value)
        except ValueError:
            parts[key] = {"true": True, "false": False}.get(value, value)
    return parts


def _grid(names: list[str]) -> dict[str, list[Any]]:
    values: dict[str, list[Any]] = {}
    for name in names:
        for key, value in _point(name).items():
            if value not in values.setdefault(key, []):
                values[key].append(value)
    return {key: sorted(found, key=lambda v: (str(type(v)), v)) for key, found in values.items()}


def _place(name: str, vary: Mapping[str, list[Any]]) -> tuple[int, ...]:
    point = _point(name)
    return tuple(vary[key].index(point[key]) for key in vary)


def _cell(file: pathlib.Path) -> Cell:
    with file.open(encoding="utf-8", newline="") as lines:
        first = lines.readline()
        if not first.startswith(_MARK) or not first.endswith("\n"):
            raise LedgerError(f"{file}: line 1: found {first[:60].strip()!r}, expected the header of a boresight file of trials")
        header = json.loads(first.removeprefix(_MARK))
        lines.readline()
        text = lines.read()
    whole, _, torn = text.rpartition("\n")
    records = list(csv.reader(whole.splitlines())) if whole else []
    n, p, paths = len(records), len(header["parameters"]), len(header["paths"])
    joint = p + p * (p + 1) // 2 + 1
    width = 1 + joint + 2 + (paths - 1) * (p + 2)
    seeds = np.zeros(n, dtype=np.uint64)
    errors = np.full((n, paths, p), np.nan)
    covariance = np.full((n, p, p), np.nan)
    factor = np.full(n, np.nan)
    refusals = [[""] * paths for _ in range(n)]
    reasons = [[""] * paths for _ in range(n)]
    lower = np.tril_indices(p)
    for k, fields in enumerate(records):
        if len(fields) != width:
            raise LedgerError(f"{file}: line {k + 3}: found {len(fields)} fields, expected {width}")
        seeds[k] = int(fields[0])
        at = 1
        for path in range(paths):
            figures = joint if path == 0 else p
            values = [float(v) if v else np.nan for v in fields[at : at + figures]]
            errors[k, path] = values[:p]
            if path == 0:
                covariance[k][lower] = values[p:-1]
                factor[k] = values[-1]
            refusals[k][path], reasons[k][path] = fields[at + figures], fields[at + figures + 1]
            at += figures + 2
    covariance = np.where(np.isnan(covariance), covariance.transpose(0, 2, 1), covariance)
    shaped = (n, paths)
    return Cell(
        name=str(header["acting"]),
        seeds=seeds,
        errors=errors,
        covariance=covariance,
        variance_factor=factor,
        refusals=np.array(refusals, dtype=np.str_).reshape(shaped),
        reasons=np.array(reasons, dtype=np.str_).reshape(shaped),
        header=header,
    )
