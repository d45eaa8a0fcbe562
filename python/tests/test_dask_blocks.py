"""One long survey on other processes: bytes that do not depend on how many they are, when they answer and which of them die."""

from __future__ import annotations

import json
import os
import pathlib
import random
import shutil
import signal
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from conftest import THIN, command
from test_dask import cluster

import boresight as bs
from boresight import _core

distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def long(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    """A survey whose trajectory is cut into several blocks."""
    folder = tmp_path_factory.mktemp("long") / "survey"
    bs.simulate(THIN["pool"], folder)
    file = folder / "survey.toml"
    file.write_text(file.read_text() + "\n[large]\nblock_records = 200\n")
    return file


@pytest.fixture(scope="module")
def by_command(long: pathlib.Path, tmp_path_factory: pytest.TempPathFactory) -> bytes:
    out = tmp_path_factory.mktemp("command") / "out"
    command("calibrate", long, "--out", out, "--method", "joint")
    return (out / "result.json").read_bytes()


def asked(survey: bs.Survey, workers: Any) -> bytes:
    return survey._handle.calibrate("joint", truth=survey._truth, workers=workers).to_json()


def in_process(path: pathlib.Path) -> tuple[Callable[..., list[bytes]], list[list[bytes]]]:
    """A worker of this process, and the packets of every call."""
    worker = _core.BlockWorker(path, threads=1)
    asks: list[list[bytes]] = []

    def answers(_: int, packets: list[bytes] | None, questions: list[bytes]) -> list[bytes]:
        asks.append(packets or asks[-1])
        return [worker.answer(p, q) for p, q in zip(asks[-1], questions, strict=True)]

    return answers, asks


@pytest.mark.parametrize(("workers", "threads"), [(1, 2), (2, 1)])
def test_the_result_is_the_command_s(workers: int, threads: int, long: pathlib.Path, by_command: bytes) -> None:
    seen: list[bs.Progress] = []
    with cluster(workers, threads) as client:
        found = bs.calibrate(long, method="joint", client=client, progress=seen.append)

        def prepared() -> int:
            from boresight import _dask_blocks

            return len(_dask_blocks._prepared)

        assert set(client.run(prepared).values()) == {1}
    assert found.to_json() == by_command
    blocks = [p for p in seen if p.step == "joint path: blocks of the trajectory"]
    # reduced and stepped, at least twice in each of two rounds
    assert len(blocks) >= 8 * blocks[0].of and blocks[0].of > 3


def late() -> None:
    """Has a worker take its time: functions travel by their names, so it calls its own."""
    import random
    import time

    from boresight import _dask_blocks

    prompt = _dask_blocks.answer

    def answer(*given: Any) -> Any:
        time.sleep(0.05 * random.random())
        return prompt(*given)

    setattr(_dask_blocks, "answer", answer)


def test_the_order_of_arrival_leaves_no_trace(long: pathlib.Path, by_command: bytes) -> None:
    with cluster(2, 2) as client:
        client.run(late)
        assert bs.calibrate(long, method="joint", client=client).to_json() == by_command


@pytest.mark.parametrize("allowed", [3, 0])
def test_a_killed_worker_leaves_no_trace(allowed: int, long: pathlib.Path, by_command: bytes) -> None:
    """Also where the scheduler gives up tasks whose worker died."""
    import dask

    chance = random.Random()
    with dask.config.set({"distributed.scheduler.allowed-failures": allowed}), cluster(2, 1) as client:
        pids = list(client.run(os.getpid).values())
        client.run(late)  # so that it dies at work
        killed = threading.Event()
        left = chance.randrange(1, 40)

        def kill(progress: bs.Progress) -> None:
            nonlocal left
            left -= progress.step == "joint path: blocks of the trajectory"
            if left <= 0 and not killed.is_set():
                os.kill(chance.choice(pids), signal.SIGKILL)
                killed.set()

        found = bs.calibrate(long, method="joint", client=client, progress=kill)
        assert killed.is_set()
        assert found.to_json() == by_command, f"{left} left"


def test_a_missing_and_a_double_answer_are_refused(long: pathlib.Path, by_command: bytes) -> None:
    survey = bs.read_survey(long)
    worker = _core.BlockWorker(long, threads=1)
    assert dict(worker.inputs) == survey.inputs
    answers, asks = in_process(long)
    assert asked(survey, answers) == by_command
    with pytest.raises(bs.InputError, match="block 2 of .* of the trajectory chain is missing"):
        asked(survey, lambda *a: answers(*a)[:2])
    with pytest.raises(bs.InputError, match="block 1 of the trajectory chain came twice"):
        asked(survey, lambda *a: [answers(*a)[k] for k in (0, 1, 1)])
    def second(*a: Any) -> list[bytes]:
        """Right when it reduces, wrong when it steps."""
        found = answers(*a)
        return found if a[2][0][0] == 1 else found[::-1]

    with pytest.raises(bs.InputError, match="of the trajectory chain came twice"):
        asked(survey, second)
    with pytest.raises(bs.InputError, match="block 2 of .* is missing"):
        asked(survey, lambda *a: answers(*a)[: len(a[2]) if a[2][0][0] == 1 else 2])
    with pytest.raises(bs.InputError, match="is one boresight installed everywhere"):
        asked(survey, lambda *a: [one[:-1] for one in answers(*a)])
    with pytest.raises(bs.InputError, match="cannot be read"):
        worker.answer(asks[-1][0], b"")
    with pytest.raises(bs.InputError, match="another survey than the one that asks"):
        worker.answer(b"\x20" + bytes(32), b"")


def test_what_a_worker_raises_ends_the_call(long: pathlib.Path) -> None:
    def fails(*_: Any) -> list[bytes]:
        raise KeyError("the network")

    survey = bs.read_survey(long)
    with pytest.raises(KeyError, match="the network"):
        asked(survey, fails)


def test_workers_that_read_other_files_are_refused(long: pathlib.Path, tmp_path: pathlib.Path) -> None:
    folder = tmp_path / "survey"
    folder.mkdir()
    for file in long.parent.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    file = folder / "survey.toml"
    survey = bs.read_survey(file)
    file.write_text(file.read_text() + "# changed\n")
    with cluster(1, 1) as client, pytest.raises(bs.InputError, match="another content than where the calibration was called"):
        bs.calibrate(survey, client=client)


def test_surveys_that_workers_cannot_read_are_refused(pool: bs.Survey, long: pathlib.Path) -> None:
    made = bs.simulate(THIN["usbl"]).survey
    nobody: Any = None
    with pytest.raises(bs.InputError) as refused:
        bs.calibrate(made, client=object())  # type: ignore[arg-type]
    assert [f.found for f in refused.value.faults] == ["a usbl survey", "a survey in memory"]
    extra = bs.Extra("squat", unit="m", derivative=[0.0])
    with pytest.raises(bs.InputError, match="extra unknowns"):
        bs.calibrate(long, extra=[extra], client=object())  # type: ignore[arg-type]
    assert bs.calibrate(long, method="joint", client=nobody).usable


def test_every_unknown_and_returns_without_trajectory_travel(long: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """Latency, range scale, variance components; and laser points that came georeferenced, whose conditions see no trajectory."""
    shutil.copytree(long.parent, tmp_path / "a")
    file = tmp_path / "a" / "survey.toml"
    unknowns = "\n[joint]\nlatency = true\nrange_scale = true\nvariance_components = true\n"
    file.write_text(file.read_text() + unknowns)
    other = shutil.copytree(tmp_path / "a", tmp_path / "b") / "survey.toml"
    survey = bs.read_survey(long)
    cloud = bs.cloud(survey, bs.calibrate(survey, method="joint"))
    rows = np.column_stack([cloud.time_s, cloud.xyz_m])[cloud.source == 1]
    np.savetxt(other.parent / "lidar.csv", rows, "%.6f", ",", header="time_s,x_m,y_m,z_m", comments="")
    before, rest = other.read_text().split("[lidar]")
    behind = rest[rest.index("[multibeam]") :]
    lidar = '[lidar]\npath = "lidar.csv"\ncoordinates = "geocentric"\npoint_sigma_m = 0.0072\n\n'
    other.write_text(before + lidar + behind)
    for path in (file, other):
        survey = bs.read_survey(path)
        answers, asks = in_process(path)
        here = survey._handle.calibrate("joint").to_json()
        assert asked(survey, answers) == here
        solved = json.loads(here)["solutions"]["joint"]["parameters"]
        assert {"latency", "range_scale"} <= {p["name"] for p in solved}
        assert len(asks) > 10
