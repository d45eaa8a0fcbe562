"""Blocks of one long survey on the workers of a Dask cluster.

A task is (survey, what its block's conditions are, a question) to the bytes of an answer, a function of nothing else: a task that is lost
with its worker is run again by another, which reads and prepares the survey first. The process that called ``calibrate`` puts the answers
together in the order of the blocks, whenever they came.
"""

from __future__ import annotations

import hashlib
import threading
from typing import TYPE_CHECKING, Any

import dask
from distributed import KilledWorker, get_worker

from . import _core
from ._dask import AGAIN, _agreed
from ._errors import Fault, InputError
from ._progress import Progress, ProgressCallback

if TYPE_CHECKING:
    from distributed import Client, Future

#: survey file, seed, SHA-256 of every file that was read
Recipe = tuple[str, int | None, tuple[str, ...]]

#: the survey that this process has prepared last
_prepared: dict[Recipe, _core.BlockWorker] = {}
_preparing = threading.Lock()


def _worker(recipe: Recipe) -> _core.BlockWorker:
    with _preparing:
        if recipe not in _prepared:
            _prepared.clear()
            path, seed, digests = recipe
            made = _core.BlockWorker(path, seed, threads=get_worker().state.nthreads)
            found = tuple(digest for _, digest in made.inputs)
            if found != digests:
                text = "another content than where the calibration was called"
                raise InputError.of([Fault(path, "the survey's files", text, "the same files for all workers")])
            _prepared[recipe] = made
        return _prepared[recipe]


def same(packet: bytes) -> bytes:
    """What every question about a block needs besides, sent once and made again where it is lost."""
    return packet


def answer(recipe: Recipe, packet: bytes, question: bytes) -> tuple[str, bytes]:
    """What a worker does: its address, which now holds the block, and the answer."""
    return get_worker().address, _worker(recipe).answer(packet, question)


class Blocks:
    """Asks the workers of a client; called by the library with the number of the packets, the packets where they are new, and a question
    about each block."""

    def __init__(self, client: Client, recipe: Recipe, progress: ProgressCallback | None) -> None:
        _agreed(client)
        self._client, self._recipe, self._progress = client, recipe, progress
        self._packets: list[bytes] = []
        self._sent: dict[str, Future[bytes]] = {}
        #: who holds a block
        self._places: dict[int, str] = {}

    def __call__(self, _number: int, packets: list[bytes] | None, questions: list[bytes]) -> list[bytes]:
        if packets is not None:
            self._packets, self._sent = packets, {}
        flight = [self._submitted(block, question) for block, question in enumerate(questions)]
        answers = []
        try:
            for block, question in enumerate(questions):
                answers.append(self._answered(block, question, flight[block]))
                if self._progress is not None:
                    self._progress(Progress("joint path: blocks of the trajectory", len(answers), len(questions)))
        except BaseException:
            for future in flight:
                future.cancel()
            raise
        return answers

    def _submitted(self, block: int, question: bytes, time: int = 0) -> Any:
        packet = self._packets[block]
        name = hashlib.sha256(repr(self._recipe).encode() + packet).hexdigest()[:32] + (f"-{time}" if time else "")
        # the same question under the same name: who asks it twice gets one answer
        asked = f"{name}-{hashlib.sha256(question).hexdigest()[:32]}"
        place = self._places.get(block)
        with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 TB"}):
            if name not in self._sent:
                self._sent[name] = self._client.submit(same, packet, key=f"boresight-ties-{name}", pure=True)
            return self._client.submit(
                answer,
                self._recipe,
                self._sent[name],
                question,
                key=f"boresight-block-{asked}",
                pure=True,
                workers=place,
                allow_other_workers=place is not None,
            )

    def _answered(self, block: int, question: bytes, future: Any) -> bytes:
        for time in range(1, AGAIN + 1):
            try:
                self._places[block], found = future.result()
                return bytes(found)
            except KilledWorker:
                future = self._submitted(block, question, time)
        self._places[block], found = future.result()
        return bytes(found)
