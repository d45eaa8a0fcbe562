"""A campaign on the workers of a Dask cluster.

A task is (cell, first seed, count) to the bytes of ledger lines, a function of nothing else: a task that is lost with its worker is run
again. Lines are written by the process that called ``run``, in the order of seeds, and are on disk before the next task of their cell
counts as done.
"""

from __future__ import annotations

import os
import pathlib
from collections import deque
from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from distributed import KilledWorker

from . import _core
from ._campaign import Recipe, make
from ._errors import BoresightError
from ._progress import Progress, ProgressCallback

if TYPE_CHECKING:
    from distributed import Client

#: tasks in flight for each thread of the workers; more would pile up behind a slow one
AHEAD = 4
#: the scheduler gives a task up when this many workers died that it was assigned to (three unless configured); that often it is asked again
AGAIN = 20


@lru_cache(maxsize=4)
def _made(recipe: Recipe) -> _core.Campaign:
    return make(recipe)


def records(recipe: Recipe, cell: int, first: int, count: int) -> bytes:
    """What a worker does: the lines of a cell's ledger for some seeds."""
    return _made(recipe).records(cell, first, count, threads=1)


def fingerprint() -> str:
    """What must be the same on all machines for the numbers to be the same."""
    return f"version {_core.VERSION}, numerics {_core.numerics()}"


def _agreed(client: Client) -> None:
    """Refuses a mixture of versions, which would make a mixture of numbers."""
    own = fingerprint()
    others: dict[str, str] = client.run(fingerprint)
    for worker, found in others.items():
        if found != own:
            raise BoresightError(
                f"worker {worker} has another boresight than this process: found {found}, expected {own}; "
                "install one version everywhere"
            )


def _tasks(cells: list[tuple[str, str, int, str]], done: list[int], chunk: int) -> Iterator[tuple[int, int, int]]:
    for cell, (_, _, trials, _) in enumerate(cells):
        for first in range(done[cell], trials, chunk):
            yield cell, first, min(chunk, trials - first)


def run(
    campaign: _core.Campaign,
    recipe: Recipe,
    folder: pathlib.Path,
    done: list[int],
    client: Client,
    chunk: int,
    progress: ProgressCallback | None,
) -> None:
    """Runs what is missing and appends it to the ledgers, which are prepared."""
    if chunk < 1:
        raise ValueError(f"chunk: found {chunk}, expected 1 or more")
    _agreed(client)
    cells = campaign.cells()
    of, finished = sum(trials for _, _, trials, _ in cells), sum(done)
    tasks = _tasks(cells, done, chunk)
    flight: deque[tuple[tuple[int, int, int], Any]] = deque()

    def submitted(task: tuple[int, int, int], time: int = 0) -> Any:
        cell, first, count = task
        # the same task under the same name: who asks for it twice gets it once
        key = f"boresight-{cells[cell][3]}-{recipe[5]}-{first}-{count}" + (f"-{time}" if time else "")
        return client.submit(records, recipe, cell, first, count, key=key, pure=True)

    def lines_of(task: tuple[int, int, int], future: Any) -> bytes:
        for time in range(1, AGAIN + 1):
            try:
                return bytes(future.result())
            except KilledWorker:
                future = submitted(task, time)
        return bytes(future.result())

    def begin() -> None:
        threads = sum(client.nthreads().values()) or 1
        while len(flight) < AHEAD * threads:
            task = next(tasks, None)
            if task is None:
                return
            flight.append((task, submitted(task)))

    try:
        begin()
        while flight:
            task, future = flight.popleft()
            cell, _, count = task
            _append(folder / cells[cell][1], lines_of(task, future))
            finished += count
            if progress is not None:
                progress(Progress("trials", finished, of))
            begin()
    finally:
        for _, future in flight:
            future.cancel()


def _append(file: pathlib.Path, lines: bytes) -> None:
    with file.open("ab") as out:
        out.write(lines)
        out.flush()
        os.fsync(out.fileno())
