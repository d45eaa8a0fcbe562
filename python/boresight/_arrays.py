"""Arrays as they are given: taken as columns of floats, or refused in one sentence that names the argument."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ._errors import Fault

Column: TypeAlias = npt.NDArray[np.float64]
"""A read-only, contiguous array of floats."""
Numbers: TypeAlias = npt.NDArray[np.uint32]
"""A read-only, contiguous array of numbers."""

_EXACT = 2**53


class _Refused(Exception):
    def __init__(self, found: str, expected: str) -> None:
        super().__init__(found, expected)
        self.found, self.expected = found, expected


def _plain(value: object, wanted: str) -> npt.NDArray[Any]:
    """The value as an array of numbers, of any shape."""
    if value is None:
        raise _Refused("nothing", wanted)
    if isinstance(value, np.ma.MaskedArray):
        masked = int(np.ma.count_masked(value))
        if masked:
            raise _Refused(f"a masked array with {masked} values masked", "values everywhere")
        value = value.data
    try:
        array = np.asarray(value)
    except (TypeError, ValueError) as error:
        raise _Refused(f"a {type(value).__name__} that is no array ({error})", wanted) from None
    kind = array.dtype.kind
    if kind in "mM":
        raise _Refused(f"{array.dtype}", "seconds as floats")
    if kind == "b":
        raise _Refused("booleans", wanted)
    if kind not in "iuf" or array.dtype.itemsize > 8:
        raise _Refused(f"{type(value).__name__} of {array.dtype}", wanted)
    return array


def _frozen(array: npt.NDArray[Any]) -> Column:
    copy = np.array(array, dtype=np.float64, order="C", copy=True)
    copy.flags.writeable = False
    return copy


def _finite(array: Column) -> None:
    wrong = ~np.isfinite(array)
    if wrong.any():
        row = int(np.argwhere(wrong)[0][0])
        raise _Refused(f"{array[row]} in row {row}", "numbers")


def _column(value: object, *, holes: bool = False) -> Column:
    wanted = "one dimension of floats"
    array = _plain(value, wanted)
    if array.ndim == 0:
        raise _Refused("a single number", wanted)
    if array.ndim != 1:
        raise _Refused(f"shape {array.shape}", wanted)
    if array.size == 0:
        raise _Refused("an empty array", "at least one row")
    if array.dtype.kind in "iu" and array.dtype.itemsize == 8 and bool((np.abs(array.astype(np.float64)) > _EXACT).any()):
        raise _Refused("whole numbers too large for floats", "floats")
    column = _frozen(array)
    _finite(np.where(np.isnan(column), 0.0, column) if holes else column)
    return column


def column(of: str, name: str, value: object, faults: list[Fault], *, holes: bool = False) -> Column:
    """A column of finite floats, with ``holes`` also of NaN; what is wrong with it goes onto the list."""
    try:
        return _column(value, holes=holes)
    except _Refused as refused:
        faults.append(Fault(of, name, refused.found, refused.expected))
        return np.zeros(0)


def rows(of: str, name: str, value: object, faults: list[Fault]) -> Column:
    """Rows of three finite floats, shape (n, 3)."""
    wanted = "shape (n, 3) of floats"
    try:
        array = _plain(value, wanted)
        if array.ndim != 2 or array.shape[1] != 3:
            raise _Refused(f"shape {array.shape}", wanted)
        if array.size == 0:
            raise _Refused("an empty array", "at least one row")
        found = _frozen(array)
        _finite(found)
        return found
    except _Refused as refused:
        faults.append(Fault(of, name, refused.found, refused.expected))
        return np.zeros((0, 3))


def numbers(of: str, name: str, value: object, faults: list[Fault]) -> Numbers:
    """A column of whole numbers from 0 to 2**32 - 1."""
    wanted = "one dimension of whole numbers from 0 to 4294967295"
    try:
        array = _plain(value, wanted)
        if array.dtype.kind == "f":
            raise _Refused(f"{array.dtype}", wanted)
        if array.ndim != 1:
            raise _Refused("a single number" if array.ndim == 0 else f"shape {array.shape}", wanted)
        if array.size and (int(array.min()) < 0 or int(array.max()) > 0xFFFF_FFFF):
            raise _Refused(f"{int(array.min())} to {int(array.max())}", wanted)
        found = np.array(array, dtype=np.uint32, order="C", copy=True)
        found.flags.writeable = False
        return found
    except _Refused as refused:
        faults.append(Fault(of, name, refused.found, refused.expected))
        return np.zeros(0, dtype=np.uint32)


def same_length(of: str, columns: dict[str, Column | Numbers], faults: list[Fault]) -> None:
    """Columns of another length than the first one, where both were taken."""
    first, *others = columns.items()
    for name, values in others:
        if len(values) and len(first[1]) and len(values) != len(first[1]):
            faults.append(Fault(of, name, f"{len(values)} rows", f"{len(first[1])} rows, as many as {first[0]}"))


def triple(of: str, name: str, value: object, faults: list[Fault]) -> tuple[float, float, float]:
    """Three finite floats."""
    wanted = "three numbers"
    try:
        array = _plain(value, wanted)
        if array.shape != (3,):
            raise _Refused("a single number" if array.ndim == 0 else f"shape {array.shape}", wanted)
        found = array.astype(np.float64)
        _finite(found)
        return float(found[0]), float(found[1]), float(found[2])
    except _Refused as refused:
        faults.append(Fault(of, name, refused.found, refused.expected))
        return 0.0, 0.0, 0.0


def number(of: str, name: str, value: object, faults: list[Fault]) -> float:
    """One finite float."""
    try:
        array = _plain(value, "a number")
        if array.ndim:
            raise _Refused(f"shape {array.shape}", "a number")
        if not np.isfinite(array):
            raise _Refused(str(float(array)), "a number")
        return float(array)
    except _Refused as refused:
        faults.append(Fault(of, name, refused.found, refused.expected))
        return 0.0


def numbers_of(of: str, name: str, value: object, faults: list[Fault]) -> Column:
    """A finite float, or one dimension of them; an array of no or one dimension."""
    wanted = "a number, or one dimension of floats"
    try:
        array = _plain(value, wanted)
        if array.ndim > 1 or array.size == 0:
            raise _Refused("an empty array" if array.size == 0 else f"shape {array.shape}", wanted)
        found = _frozen(array)
        _finite(found.reshape(-1))
        return found
    except _Refused as refused:
        faults.append(Fault(of, name, refused.found, refused.expected))
        return np.zeros(())
