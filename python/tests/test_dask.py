"""Campaigns on a Dask cluster: bytes that do not depend on it, workers and coordinators that die."""

from __future__ import annotations

import os
import pathlib
import random
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from conftest import THIN, command
from test_campaign import VARY, ledgers

import boresight as bs

distributed = pytest.importorskip("distributed")


@contextmanager
def cluster(workers: int, threads: int) -> Iterator[Any]:
    """Processes on this machine."""
    with distributed.LocalCluster(
        n_workers=workers, threads_per_worker=threads, processes=True, dashboard_address=None
    ) as local:
        with distributed.Client(local) as client:
            yield client


@pytest.fixture(scope="module")
def by_command(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    folder = tmp_path_factory.mktemp("command")
    command("budget", THIN["usbl"], "--trials", 16, "--single", 2, *vary_words(), "--out", folder)
    return folder / "trials"


def vary_words() -> list[str]:
    return [w for k, v in VARY.items() for w in ("--vary", f"{k}={','.join(map(str, v))}")]


def campaign() -> bs.Campaign:
    return bs.Campaign(THIN["usbl"], 16, single=2, vary=VARY)


@pytest.mark.parametrize(("workers", "threads", "chunk"), [(1, 2, 7), (2, 1, 3)])
def test_the_ledgers_are_the_command_s(
    workers: int, threads: int, chunk: int, by_command: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    seen: list[int] = []
    with cluster(workers, threads) as client:
        campaign().run(tmp_path, client=client, chunk=chunk, progress=lambda p: seen.append(p.done))
    assert ledgers(tmp_path) == ledgers(by_command) != {}
    assert seen == sorted(seen) and seen[-1] == sum(campaign().cells.values())


@pytest.mark.parametrize("allowed", [3, 0])
def test_a_killed_worker_leaves_no_trace(allowed: int, by_command: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """Also where the scheduler gives up tasks whose worker died."""
    import dask

    chance = random.Random()
    with dask.config.set({"distributed.scheduler.allowed-failures": allowed}), cluster(2, 1) as client:
        pids = list(client.run(os.getpid).values())
        killed = threading.Event()
        at = chance.randrange(5, sum(campaign().cells.values()) // 2)

        def kill(progress: bs.Progress) -> None:
            if progress.done >= at and not killed.is_set():
                os.kill(chance.choice(pids), signal.SIGKILL)
                killed.set()

        campaign().run(tmp_path, client=client, chunk=4, progress=kill)
        assert killed.is_set()
        assert ledgers(tmp_path) == ledgers(by_command), f"killed after {at} trials"
    # nothing is left running
    deadline = time.monotonic() + 10
    while any(pathlib.Path(f"/proc/{pid}").exists() for pid in pids) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert not [pid for pid in pids if pathlib.Path(f"/proc/{pid}").exists()]


def test_a_killed_coordinator_is_gone_on_with(by_command: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """Client, scheduler and workers are gone; the folder goes on, on threads and on another cluster."""
    text = textwrap.dedent(
        f"""
        import sys
        import boresight as bs
        from distributed import Client, LocalCluster
        if __name__ == "__main__":
            with LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None) as local:
                with Client(local) as client:
                    c = bs.Campaign({str(THIN['usbl'])!r}, 16, single=2, vary={VARY!r})
                    c.run(sys.argv[1], client=client, chunk=2, progress=lambda p: print(p.done, flush=True))
        """
    )
    running = subprocess.Popen([sys.executable, "-c", text, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    assert running.stdout is not None
    for line in running.stdout:
        if int(line) >= 10:
            break
    running.kill()
    running.wait()
    whole = ledgers(by_command)
    kept = ledgers(tmp_path)
    assert kept and all(whole[name].startswith(b) for name, b in kept.items()) and kept != whole
    half = bs.Campaign(THIN["usbl"], 16, single=2, vary=VARY)

    def enough(progress: bs.Progress) -> None:
        if progress.done > 60:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        half.run(tmp_path, progress=enough)
    with cluster(1, 1) as client:
        half.run(tmp_path, client=client)
    assert ledgers(tmp_path) == whole


def test_a_mixture_of_arithmetics_is_refused(tmp_path: pathlib.Path) -> None:
    def other() -> None:
        from boresight import _dask

        setattr(_dask, "fingerprint", lambda: "version 0.0.1, numerics 00")

    with cluster(1, 1) as client:
        client.run(other)
        # functions travel by their names: the worker calls its own
        with pytest.raises(bs.BoresightError, match="has another boresight than this process: found version 0.0.1"):
            campaign().run(tmp_path, client=client)
    assert bs.read_trials(tmp_path)["together"].errors.shape[0] == 0
