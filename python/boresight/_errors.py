"""What ends a call that cannot be carried out."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple


class Fault(NamedTuple):
    """One thing that is wrong with what was given."""

    file: str
    """The file, or the argument."""
    place: str
    """The place in it: line and key, row, column; empty where ``found`` says it."""
    found: str
    """What was found there."""
    expected: str
    """What was expected there; empty where ``found`` says it."""

    def __str__(self) -> str:
        if not self.expected:
            return f"{self.file}: {self.found}"
        place = f"{self.place}: " if self.place else ""
        return f"{self.file}: {place}found {self.found}, expected {self.expected}"


class BoresightError(Exception):
    """Whatever ends a call of this package."""


class InputError(BoresightError, ValueError):
    """What was given cannot be worked with; nothing was written.

    ``faults`` lists everything that is wrong, of every file and column at once, as far as it can be told apart.
    """

    faults: tuple[Fault, ...]

    def __init__(self, message: str, faults: Iterable[tuple[str, str, str, str]] = ()) -> None:
        super().__init__(message)
        self.faults = tuple(Fault(*fault) for fault in faults)

    @classmethod
    def of(cls, faults: Iterable[Fault]) -> InputError:
        """From faults alone, one line each."""
        listed = tuple(faults)
        return cls("\n".join(str(fault) for fault in listed), listed)

    def __reduce__(self) -> tuple[type[InputError], tuple[str, tuple[Fault, ...]]]:
        return type(self), (str(self), self.faults)


class LedgerError(BoresightError):
    """Files of trials that are there already, are of something else, or are damaged."""


class AdjustmentError(BoresightError):
    """A calibration ended without a usable result, and one was required."""


class InternalError(BoresightError):
    """A fault of the program: please report it with what led to it."""
