"""Trials of a scenario: error budgets by simulation."""

from __future__ import annotations

import json
import pathlib
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any

from . import _core
from ._errors import Fault, InputError
from ._progress import ProgressCallback, told
from ._survey import scenario_file
from ._trials import Trials, read_trials

if TYPE_CHECKING:
    from distributed import Client

Path = str | PathLike[str]
Value = float | bool | str


class Campaign:
    """Trials of a scenario (its file, or its text), each a simulated survey that is calibrated by every path and compared with its truth.

    ``trials`` of all error sources together, ``single`` of each source alone, and ``trials`` at every point of ``vary``: one or two keys
    of the scenario with their values, as in ``boresight budget --vary``. All cells use the seeds from ``seed`` on.
    :exc:`InputError` for a scenario that cannot be tried, at any point of the sweep.
    """

    def __init__(
        self,
        scenario: Path,
        trials: int,
        *,
        single: int = 0,
        vary: Mapping[str, Iterable[Value]] | None = None,
        seed: int = 1,
    ) -> None:
        file, text = scenario_file(scenario)
        self.trials, self.single, self.seed = int(trials), int(single), int(seed)
        self.vary: dict[str, list[Value]] = {key: list(values) for key, values in (vary or {}).items()}
        """The varied keys with their values."""
        faults = []
        if self.trials < 1:
            faults.append(Fault("Campaign", "trials", str(trials), "1 or more"))
        if self.single < 0 or self.single == 1:
            faults.append(Fault("Campaign", "single", str(single), "0 for none, or 2 and more"))
        if not 0 <= self.seed <= 1 << 62:
            faults.append(Fault("Campaign", "seed", str(seed), "0 to 4611686018427387904"))
        if len(self.vary) > 2:
            faults.append(Fault("Campaign", "vary", f"{len(self.vary)} keys", "at most 2"))
        faults += [Fault("Campaign", f"vary[{k!r}]", "no values", "at least one") for k, v in self.vary.items() if not v]
        if faults:
            raise InputError.of(faults)
        #: what another process makes the same campaign from
        self._recipe = (file, text, self.trials, self.single, tuple((k, tuple(v)) for k, v in self.vary.items()), self.seed)
        self._handle = make(self._recipe)

    @property
    def scenario(self) -> str:
        """The scenario's name."""
        return self._handle.scenario

    @property
    def cells(self) -> dict[str, int]:
        """Names of the cells with their numbers of trials."""
        return {name: trials for name, _, trials, _ in self._handle.cells()}

    def run(
        self,
        folder: Path,
        *,
        resume: bool = True,
        threads: int | None = None,
        client: Client | None = None,
        progress: ProgressCallback | None = None,
        chunk: int = 25,
    ) -> Trials:
        """Runs what is missing in a folder of ledgers and reads them: the files of ``boresight budget``, byte by byte.

        On the threads of this process, or with a Dask ``client`` (``boresight[dask]``) on its workers, ``chunk`` trials a task; how,
        where and in how many pieces a campaign was run leaves no trace. Ctrl-C ends it when the trials that run
        are finished; an interrupted run, so or otherwise, goes on where it ended; with ``resume=False`` an old one is refused. :exc:`LedgerError` for ledgers of anything else.
        """
        where = pathlib.Path(fspath(folder))
        done = self._handle.prepare(fspath(where), resume)
        if client is None:
            self._handle.run(fspath(where), done, threads=threads, progress=told(progress))
        else:
            from ._dask import run

            run(self._handle, self._recipe, where, done, client, chunk, progress)
        return read_trials(where)

    def summary(
        self,
        folder: Path,
        *,
        out: Path | None = None,
        depths_m: Sequence[float] | None = None,
        progress: ProgressCallback | None = None,
    ) -> dict[str, Any]:
        """The error budget that the ledgers in ``folder`` make, as ``boresight budget`` states it: its ``result.json`` as plain Python.

        With ``out`` its ``result.json``, ``report.html`` and tables are written there.
        """
        depths = None if depths_m is None else [float(d) for d in depths_m]
        into = None if out is None else fspath(out)
        found = self._handle.summed(fspath(folder), depths, self._command(), out=into, progress=told(progress))
        keys: dict[str, Any] = json.loads(found)
        return keys

    def _command(self) -> str:
        """The command that makes the same budget."""
        words = ["boresight", "budget", pathlib.Path(self._recipe[0]).name, "--trials", str(self.trials)]
        words += ["--single", str(self.single)] if self.single else []
        words += ["--seed", str(self.seed)] if self.seed != 1 else []
        for key, values in self.vary.items():
            words += ["--vary", f"'{key}={','.join(_word(v) for v in values)}'"]
        return " ".join(words)

    def __repr__(self) -> str:
        return f"<Campaign of {self.scenario!r}: {sum(self.cells.values())} trials in {len(self.cells)} cells>"

    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]:
        file, text, trials, single, vary, seed = self._recipe
        return _again, (text or file, trials, single, {k: list(v) for k, v in vary}, seed)


def _again(scenario: str, trials: int, single: int, vary: dict[str, list[Value]], seed: int) -> Campaign:
    return Campaign(scenario, trials, single=single, vary=vary, seed=seed)


def _word(value: Value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return value
    return str(int(value)) if float(value).is_integer() else str(float(value))


Recipe = tuple[str, str | None, int, int, tuple[tuple[str, tuple[Value, ...]], ...], int]


def make(recipe: Recipe) -> _core.Campaign:
    """The campaign of a recipe."""
    file, text, trials, single, vary, seed = recipe
    return _core.Campaign(file, text, trials, single, [(k, list(v)) for k, v in vary], seed)
