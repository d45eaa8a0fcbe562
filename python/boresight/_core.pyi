"""What Python calls of the library; the package's own functions are the public ones."""

from collections.abc import Callable, Sequence
from os import PathLike
from typing import Any, Final, final

import numpy as np
import numpy.typing as npt

__all__ = [
    "BlockWorker",
    "Campaign",
    "Finished",
    "Survey",
    "VERSION",
    "adjust",
    "budget",
    "cli",
    "demo_scenario",
    "numerics",
    "panic_for_tests",
    "plan",
    "read_target",
    "simulate",
]

_Progress = Callable[[str, int, int], object]
_Extra = tuple[str, str, str, npt.NDArray[np.float64], float | None]

VERSION: Final[str]

def adjust(
    sets: Sequence[tuple[Callable[[int, int, dict[str, Any]], tuple[Any, Any, Any]], int, Sequence[str]]],
    blocks: Sequence[tuple[str, Sequence[float], Sequence[float] | None, Sequence[bool]]],
    kernel: str,
    width: float,
    max_iterations: int,
    step_tolerance_sigmas: float,
    unknown_noise: bool,
    worst: int,
    threads: int | None = None,
    progress: _Progress | None = None,
) -> dict[str, Any]: ...
def cli(arguments: Sequence[str]) -> int: ...
def numerics() -> str: ...
def demo_scenario(procedure: str) -> str: ...
def read_target(path: str | PathLike[str]) -> str: ...
def panic_for_tests(message: str) -> None: ...
def simulate(
    file: str | PathLike[str],
    text: str | None,
    folder: str | PathLike[str],
    seed: int | None = None,
    progress: _Progress | None = None,
) -> tuple[str, list[tuple[str, int]]]: ...
def budget(
    file: str | PathLike[str],
    text: str | None,
    survey: Survey | None,
    depths_m: Sequence[float] | None,
    seed: int,
    progress: _Progress | None = None,
) -> bytes: ...
def plan(
    file: str | PathLike[str],
    text: str | None,
    wanted: Sequence[tuple[str, float]],
    distances_m: Sequence[float],
    speeds_m_s: Sequence[float],
    crabs_deg: Sequence[float],
    both_directions: bool,
    from_scratch: bool,
    smallest: str,
    most: int,
    progress: _Progress | None = None,
) -> bytes: ...
@final
class BlockWorker:
    def __new__(cls, path: str | PathLike[str], seed: int | None = None, threads: int | None = None) -> BlockWorker: ...
    @property
    def inputs(self) -> list[tuple[str, str]]: ...
    def answer(self, packet: bytes, question: bytes) -> bytes: ...
@final
class Survey:
    @staticmethod
    def read(path: str | PathLike[str], progress: _Progress | None = None) -> Survey: ...
    @staticmethod
    def from_arrays(survey: str, target: str, columns: dict[str, Any]) -> Survey: ...
    @property
    def procedure(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def inputs(self) -> list[tuple[str, str]]: ...
    def configuration(self) -> str: ...
    def target(self) -> str | None: ...
    def columns(self) -> dict[str, Any] | None: ...
    def check(
        self, seed: int | None = None, threads: int | None = None, progress: _Progress | None = None
    ) -> tuple[str, str, bool]: ...
    def calibrate(
        self,
        method: str,
        seed: int | None = None,
        simple: bool = False,
        extra: Sequence[_Extra] = ...,
        truth: str | None = None,
        threads: int | None = None,
        progress: _Progress | None = None,
        workers: Callable[[int, list[bytes] | None, list[bytes]], list[bytes]] | None = None,
    ) -> Finished: ...
    def georeference(
        self,
        sensor: str,
        model: Sequence[float] | None,
        first: int,
        step: int,
        count: int,
        threads: int | None = None,
    ) -> npt.NDArray[np.float64]: ...
    def residuals(
        self,
        method: str,
        seed: int | None = None,
        extra: Sequence[_Extra] = ...,
        threads: int | None = None,
        progress: _Progress | None = None,
    ) -> dict[str, Any]: ...
    def cloud(
        self,
        model: Sequence[float],
        of: tuple[Finished, str] | None = None,
        threads: int | None = None,
        progress: _Progress | None = None,
    ) -> dict[str, Any] | None: ...

@final
class Finished:
    @staticmethod
    def from_json(bytes: bytes) -> Finished: ...
    def to_json(self) -> bytes: ...
    def html(self) -> str: ...
    def text(self) -> str: ...
    def write(self, folder: str | PathLike[str], exports: Sequence[str]) -> None: ...

@final
class Campaign:
    def __new__(
        cls,
        file: str | PathLike[str],
        text: str | None,
        trials: int,
        single: int,
        vary: Sequence[tuple[str, Sequence[float | bool | str]]],
        seed: int,
    ) -> Campaign: ...
    @property
    def scenario(self) -> str: ...
    def cells(self) -> list[tuple[str, str, int, str]]: ...
    def prepare(self, folder: str | PathLike[str], resume: bool) -> list[int]: ...
    def run(
        self,
        folder: str | PathLike[str],
        done: Sequence[int],
        threads: int | None = None,
        progress: _Progress | None = None,
    ) -> bool: ...
    def records(self, cell: int, first: int, count: int, threads: int | None = None) -> bytes: ...
    def summed(
        self,
        folder: str | PathLike[str],
        depths_m: Sequence[float] | None,
        command: str,
        out: str | PathLike[str] | None = None,
        progress: _Progress | None = None,
    ) -> bytes: ...
