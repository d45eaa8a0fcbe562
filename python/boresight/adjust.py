"""The adjustment engine on your own conditions: iterated Gauss-Helmert least squares with robust kernels, reliability and covariance.

A set of conditions is an object with ``columns`` (names of the unknowns that it sees), ``__len__`` and
``linearise(x, rows) -> misclosure, variance, derivatives`` for a slice of at most 4096 rows: all arrays, no loop over rows. A line through
points:

>>> import numpy as np
>>> class Line:
...     columns = ("offset", "slope")
...     def __init__(self, t, y, sigma): self.t, self.y, self.variance = t, y, np.full(len(t), sigma**2)
...     def __len__(self): return len(self.t)
...     def linearise(self, x, rows):
...         t = self.t[rows]
...         misclosure = x["offset"] + t * x["slope"] - self.y[rows]
...         return misclosure, self.variance[rows], np.column_stack([np.ones_like(t), t])
>>> t = np.arange(5.0)
>>> found = solve([Line(t, 1.0 + 2.0 * t, 0.1)], {"offset": 0.0, "slope": 0.0})
>>> found.status, round(found.x["slope"], 6), round(found.sigma["slope"], 4), found.redundancy
('converged', 2.0, 0.0316, 3.0)

The misclosure of a condition is what its observation contradicts the unknowns by, with the sign of (model minus observation); its variance
is that of the observation. Where a condition holds several observations, misclosure and derivatives belong to the adjusted ones. Python
evaluates on one thread at a time; the bytes are those of your numpy.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from . import _core
from ._arrays import numbers_of
from ._errors import AdjustmentError, Fault, InputError
from ._progress import ProgressCallback, told

__all__ = ["Conditions", "Iteration", "Kernel", "Solution", "Unknown", "Worst", "solve"]

Array = npt.NDArray[np.float64]
Kernel = Literal["least_squares", "huber", "cauchy", "tukey", "geman_mcclure"]
"""What a residual costs; the robust ones bend where they keep 95 % efficiency on normal residuals, or where ``width`` says."""

_WIDTHS: dict[str, float] = {"least_squares": 0.0, "huber": 1.345, "cauchy": 2.385, "tukey": 4.685, "geman_mcclure": 2.5}
_MOST_COLUMNS = 32


class Conditions(Protocol):
    """A set of conditions of one kind."""

    @property
    def columns(self) -> Sequence[str]:
        """Names of the unknowns that it sees, in the order of the derivatives; one of several numbers takes as many columns."""

    def __len__(self) -> int: ...

    def linearise(self, x: Mapping[str, Any], rows: slice) -> tuple[npt.ArrayLike, npt.ArrayLike, npt.ArrayLike]:
        """Misclosures (n,), variances (n,) or one number, derivatives (n, columns) of some rows. ``x`` holds a float an unknown, or an
        array where it was given as one."""


@dataclass(frozen=True)
class Unknown:
    """An unknown of one number or several: where it starts, what is known of it, whether it is held."""

    value: npt.ArrayLike
    prior_sigma: npt.ArrayLike | None = None
    """One sigma about the value; nothing where nothing is known."""
    held: bool = False


class Iteration(NamedTuple):
    """One step of the adjustment."""

    cost: float
    """Half the weighted sum of squares at the end of the step."""
    damping: float
    """Levenberg-Marquardt damping."""
    step_sigmas: float
    """Largest step of an unknown, in its own sigma."""
    accepted: bool
    """Whether it was taken."""


class Worst(NamedTuple):
    """A condition with a large normalised residual."""

    set: int
    """Place of its set in ``conditions``."""
    row: int
    """Its row."""
    residual: float
    """What is left of it, in its own unit."""
    sigma: float
    """Its standard deviation, in its own unit."""
    redundancy: float
    """From 0 (nothing controls it) to 1 (it controls nothing)."""
    normalised: float
    """Residual over its own standard deviation."""


@dataclass(frozen=True, eq=False)
class Solution:
    """What an adjustment ended with."""

    x: Mapping[str, Any]
    """The unknowns by name: a float each, or an array where it was given as one."""
    covariance: Array
    """Covariance of all numbers in the order of ``names``, from the stated variances; zero for held ones."""
    names: tuple[str, ...]
    """Name of every number: that of its unknown, with a place where that has several."""
    status: str
    """``converged``, ``stalled``, ``rank_deficient`` or ``out_of_iterations``."""
    undetermined: tuple[Array, ...]
    """Directions that the conditions leave undetermined, each column scaled to unit information."""
    redundancy: float
    """Conditions and priors less unknowns."""
    variance_factor: float
    """Weighted sum of squares over redundancy: near 1 if model and variances are true."""
    interval: tuple[float, float]
    """Where the variance factor lies with 95 % if they are."""
    critical: float
    """A normalised residual beyond this is a gross error with 95 %, all conditions considered."""
    worst: tuple[Worst, ...]
    """Conditions with the largest normalised residuals, the largest first."""
    iterations: tuple[Iteration, ...]
    """Every step."""

    @property
    def converged(self) -> bool:
        """Whether the unknowns may be used."""
        return self.status == "converged"

    @property
    def sigma(self) -> Mapping[str, float]:
        """One sigma of every number by its name."""
        sigmas = np.sqrt(np.diag(self.covariance))
        return MappingProxyType({name: float(sigma) for name, sigma in zip(self.names, sigmas, strict=True)})

    def require(self) -> Solution:
        """Itself, or :exc:`AdjustmentError` where it did not converge."""
        if not self.converged:
            raise AdjustmentError(f"the adjustment ended {self.status} after {len(self.iterations)} steps")
        return self

    def __repr__(self) -> str:
        return f"<Solution {self.status}, {len(self.names)} numbers, variance factor {self.variance_factor:.3f}>"


class _Block(NamedTuple):
    name: str
    value: Array
    scalar: bool
    prior_sigma: list[float] | None
    held: bool


def solve(
    conditions: Sequence[Conditions],
    parameters: Mapping[str, npt.ArrayLike | Unknown],
    *,
    kernel: Kernel = "least_squares",
    width: float | None = None,
    max_iterations: int = 50,
    step_tolerance_sigmas: float = 1e-3,
    unknown_noise: bool = False,
    worst: int = 20,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
) -> Solution:
    """Adjusts unknowns to conditions.

    ``parameters`` gives the start of every unknown: a number, an array, or :class:`Unknown` with a prior. ``width`` is the kernel's bend
    in sigmas. ``unknown_noise`` measures steps with the noise that the residuals show, for variances that are guesses; the covariance
    is that of the stated variances in any case (multiply it by ``variance_factor`` where they were guesses). How it ended is no error: see ``Solution.status``. What
    ``linearise`` raises comes through; arrays of a wrong shape and conditions that are no numbers are an :exc:`InputError`.
    """
    faults: list[Fault] = []
    blocks = [_block(name, given, faults) for name, given in parameters.items()]
    if kernel not in _WIDTHS:
        faults.append(Fault("solve", "kernel", repr(kernel), ", ".join(map(repr, _WIDTHS))))
    bend = _WIDTHS.get(kernel, 0.0) if width is None else float(width)
    if kernel != "least_squares" and not bend > 0.0:
        faults.append(Fault("solve", "width", str(bend), "a positive number of sigmas"))
    if not parameters:
        faults.append(Fault("solve", "parameters", "nothing", "at least one unknown"))
    sizes = {block.name: len(block.value) for block in blocks}
    for k, one in enumerate(conditions):
        faults += _strange(f"conditions[{k}]", one, sizes)
    if faults:
        raise InputError.of(faults)
    scalars = {block.name for block in blocks if block.scalar}
    sets = [(_batch(f"conditions[{k}]", one, sizes, scalars), len(one), list(one.columns)) for k, one in enumerate(conditions)]
    given = [(b.name, b.value.tolist(), b.prior_sigma, [b.held] * len(b.value)) for b in blocks]
    found = _core.adjust(
        sets,
        given,
        kernel,
        bend,
        max_iterations,
        step_tolerance_sigmas,
        unknown_noise,
        worst,
        threads=threads,
        progress=told(progress),
    )
    return _solution(found, blocks)


def _solution(found: dict[str, Any], blocks: Sequence[_Block]) -> Solution:
    x: dict[str, Any] = {}
    names: list[str] = []
    first = 0
    for block in blocks:
        last = first + len(block.value)
        x[block.name] = float(found["x"][first]) if block.scalar else found["x"][first:last]
        names += [block.name] if block.scalar else [f"{block.name} {k}" for k in range(len(block.value))]
        first = last
    return Solution(
        x=MappingProxyType(x),
        covariance=found["covariance"],
        names=tuple(names),
        status=found["status"],
        undetermined=tuple(np.array(axis) for axis in found["undetermined"]),
        redundancy=found["redundancy"],
        variance_factor=found["variance_factor"],
        interval=found["interval"],
        critical=found["critical"],
        worst=tuple(Worst(*one) for one in found["worst"]),
        iterations=tuple(Iteration(*one) for one in found["iterations"]),
    )


def _block(name: str, given: npt.ArrayLike | Unknown, faults: list[Fault]) -> _Block:
    unknown = given if isinstance(given, Unknown) else Unknown(given)
    value = numbers_of("parameters", name, unknown.value, faults)
    scalar = value.ndim == 0
    flat = value.reshape(-1)
    prior = None
    if unknown.prior_sigma is not None:
        sigma = numbers_of("parameters", f"{name}.prior_sigma", unknown.prior_sigma, faults)
        if sigma.ndim and sigma.shape != flat.shape:
            faults.append(Fault("parameters", f"{name}.prior_sigma", f"shape {sigma.shape}", f"one number, or {len(flat)}"))
        elif not bool((sigma > 0.0).all()):
            faults.append(Fault("parameters", f"{name}.prior_sigma", str(sigma), "positive numbers"))
        else:
            prior = np.broadcast_to(sigma, flat.shape).tolist()
    return _Block(name, flat, scalar, prior, bool(unknown.held))


def _strange(of: str, one: object, sizes: Mapping[str, int]) -> list[Fault]:
    """What is wrong with a set of conditions before it is asked for a row."""
    missing = [name for name in ("columns", "__len__", "linearise") if not hasattr(one, name)]
    if missing:
        return [Fault(of, "whole argument", f"a {type(one).__name__} without {', '.join(missing)}", "an object with all three")]
    columns = list(one.columns)  # type: ignore[attr-defined]
    unknown = [name for name in columns if name not in sizes]
    if unknown:
        return [Fault(of, "columns", ", ".join(map(repr, unknown)), f"names among {', '.join(map(repr, sizes))}")]
    width = sum(sizes[name] for name in columns)
    if not 0 < width <= _MOST_COLUMNS or len(set(columns)) < len(columns):
        return [Fault(of, "columns", f"{width} columns of {columns}", f"each unknown once, 1 to {_MOST_COLUMNS} columns")]
    return []


def _batch(of: str, one: Conditions, sizes: Mapping[str, int], scalars: set[str]) -> Any:
    """What evaluates rows ``first`` to ``last`` and leaves arrays as the library takes them."""
    width = sum(sizes[name] for name in one.columns)

    def evaluate(first: int, last: int, seen: dict[str, Array]) -> tuple[Array, Array, Array]:
        x = {name: float(value[0]) if name in scalars else value for name, value in seen.items()}
        found = one.linearise(x, slice(first, last))
        if not isinstance(found, tuple) or len(found) != 3:
            raise InputError.of([Fault(of, "linearise", f"a {type(found).__name__}", "misclosure, variance and derivatives")])
        count = last - first
        shapes = {"misclosure": (count,), "variance": (count,), "derivatives": (count, width)}
        arrays: list[Array] = []
        for (name, shape), value in zip(shapes.items(), found, strict=True):
            try:
                array = np.asarray(value, dtype=np.float64)
            except (TypeError, ValueError) as error:
                raise InputError.of([Fault(of, name, f"a {type(value).__name__} ({error})", "floats")]) from None
            if name == "variance" and array.ndim == 0:
                array = np.full(count, float(array))
            if array.shape != shape:
                raise InputError.of([Fault(of, name, f"shape {array.shape} for rows {first} to {last}", f"shape {shape}")])
            arrays.append(np.ascontiguousarray(array))
        return arrays[0], arrays[1], arrays[2]

    return evaluate
