"""Point clouds as files: the command ``boresight apply``, called from here."""

from __future__ import annotations

import contextlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from os import PathLike, fspath
from typing import Literal

from ._errors import BoresightError, Fault, InputError, InternalError
from ._result import Result
from ._survey import Survey

Path = str | PathLike[str]


@dataclass(frozen=True)
class Applied:
    """What was written."""

    file: pathlib.Path
    """The cloud."""
    points: int
    """Points in it."""
    read: int
    """Observations of the survey; those without a position are not written."""
    coordinates: str
    """The coordinate system in words."""
    sources: tuple[str, ...]
    """What the points come from; the point source id counts from 1."""
    notes: tuple[str, ...]
    """What the reader should know."""
    surface: pathlib.Path | None
    """The surface, where one was asked for."""


def apply(
    survey: Survey | Path,
    calibration: Result | Path,
    out: Path,
    *,
    solution: Literal["joint", "reference", "joint-simple"] = "joint",
    coordinates: Literal["utm", "geocentric"] = "utm",
    surface: Path | None = None,
    cell_m: float = 1.0,
    force: bool = False,
) -> Applied:
    """Writes all points of a survey under a calibration as LAS or LAZ, by the name of ``out``; the same bytes as ``boresight apply``.

    ``survey`` is a survey file, or a survey that was read from one; points of one from arrays are had with :func:`cloud`. ``surface``
    also writes the soundings' surface, a GeoTIFF of mean, count and standard deviation in cells of ``cell_m``. A file that this program
    did not write is never replaced, one of its own from another command only with ``force``. :exc:`InputError` says what is wrong.
    """
    words = ["apply", fspath(_file(survey)), "--out", fspath(out), "--solution", solution, "--coordinates", coordinates, "--json"]
    if surface is not None:
        words += ["--surface", fspath(surface), "--cell", repr(float(cell_m))]
    if force:
        words.append("--force")
    with _result(calibration) as file:
        found = json.loads(_command([*words, "--calibration", file]))
    return Applied(
        file=pathlib.Path(found["file"]),
        points=found["points"],
        read=found["read"],
        coordinates=found["coordinates"],
        sources=tuple(found["sources"]),
        notes=tuple(found["notes"]),
        surface=None if surface is None else pathlib.Path(fspath(surface)),
    )


def _file(survey: Survey | Path) -> Path:
    if not isinstance(survey, Survey):
        return survey
    if survey._file is None:
        raise InputError.of([Fault("apply", "survey", "a survey that is in memory alone", "one from files, or cloud(survey, result)")])
    return survey._file


@contextlib.contextmanager
def _result(calibration: Result | Path) -> Iterator[str]:
    """The calibration as a file."""
    if not isinstance(calibration, Result):
        yield fspath(calibration)
        return
    with tempfile.TemporaryDirectory(prefix="boresight-", ignore_cleanup_errors=True) as folder:
        file = pathlib.Path(folder) / "result.json"
        file.write_bytes(calibration.to_json())
        yield os.fspath(file)


def _command(words: list[str]) -> str:
    """What the command says on standard output; it runs in a process of its own, so that Ctrl-C ends it as on a terminal."""
    ended = subprocess.run([sys.executable, "-m", "boresight._command", *words], capture_output=True, text=True, check=False)
    if ended.returncode == 0:
        return ended.stdout
    said = ended.stderr.strip().removeprefix("boresight: ")
    if ended.returncode == 2:
        raise InputError(said)
    if ended.returncode == 130:
        raise KeyboardInterrupt
    raise (InternalError if ended.returncode < 0 else BoresightError)(said or f"apply ended with {ended.returncode}")
