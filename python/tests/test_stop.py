"""Long calls: Ctrl-C, progress that raises or calls again, other threads, processes made by fork and spawn."""

from __future__ import annotations

import multiprocessing
import os
import pathlib
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest
from conftest import THIN

import boresight as bs

LONG = textwrap.dedent(
    """
    import pathlib, sys, time
    import boresight as bs
    scenario = pathlib.Path({scenario!r}).read_text()
    out = pathlib.Path(sys.argv[1])
    text = scenario.replace("beams = 77", "beams = 1024").replace("ping_rate_hz = 4.0", "ping_rate_hz = 16.0")
    assert text != scenario
    """
)

CALLS = {
    "calibrate": "survey = bs.simulate(text).survey; call = lambda: [bs.calibrate(survey) for _ in range(1000)]",
    "simulate": "big = text.replace('ping_rate_hz = 16.0', 'ping_rate_hz = 100.0'); call = lambda: bs.simulate(big, out / 's')",
    "campaign": "c = bs.Campaign(scenario, 10_000); call = lambda: c.run(out / 'c')",
    "budget": "call = lambda: [bs.budget(scenario) for _ in range(1000)]",
    "check": "survey = bs.simulate(text).survey; call = lambda: [bs.check(survey) for _ in range(1000)]",
}

BODY = """
try:
    print("begun", flush=True)
    call()
except KeyboardInterrupt:
    print("interrupted", time.time(), flush=True)
    found = bs.calibrate(bs.simulate(bs.demo("usbl")).survey)
    print("next call", found.usable, flush=True)
else:
    print("ended", flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="sends SIGINT")
@pytest.mark.parametrize("call", CALLS)
def test_ctrl_c_ends_a_long_call_within_a_second(call: str, tmp_path: pathlib.Path) -> None:
    text = LONG.format(scenario=str(THIN["pool"])) + CALLS[call] + BODY
    running = subprocess.Popen([sys.executable, "-c", text, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    assert running.stdout is not None
    assert running.stdout.readline() == "begun\n"
    time.sleep(0.7)
    sent = time.time()
    running.send_signal(signal.SIGINT)
    word, at = running.stdout.readline().split()
    assert word == "interrupted"
    assert float(at) - sent < 1.0, f"{float(at) - sent:.2f} s"
    assert running.stdout.readline() == "next call True\n"
    assert running.wait(60) == 0
    # nothing half written: no temporary files, whole ledgers
    assert [p.name for p in tmp_path.iterdir()] == (["c"] if call == "campaign" else [])
    if call == "campaign":
        done = len(bs.read_trials(tmp_path / "c")["together"])
        assert done > 0
        assert (tmp_path / "c" / "together.csv").read_bytes().endswith(b"\n")


@pytest.mark.skipif(sys.platform == "win32", reason="sends SIGINT")
def test_ctrl_c_ends_the_command_as_it_ends_the_program(tmp_path: pathlib.Path) -> None:
    program = pathlib.Path(sys.executable).parent / "boresight"
    words = [str(program), "budget", str(THIN["pool"]), "--trials", "100000", "--threads", "1", "--out", str(tmp_path / "out")]
    running = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
    ledger = tmp_path / "out" / "trials" / "together.csv"
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline and not (ledger.exists() and ledger.read_bytes().count(b"\n") > 3):
        time.sleep(0.05)
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=30)
    assert running.returncode == 130, said
    assert "--resume" in said and ledger.read_bytes().endswith(b"\n")


def test_progress_that_raises_stops_the_call(pool: bs.Survey) -> None:
    class Enough(Exception):
        pass

    steps: list[str] = []

    def enough(progress: bs.Progress) -> None:
        steps.append(progress.step)
        if len(steps) == 3:
            raise Enough

    with pytest.raises(Enough):
        bs.calibrate(pool, progress=enough)
    assert len(steps) == 3 and all(steps)
    assert bs.calibrate(pool).usable


def test_nothing_is_written_any_more_when_a_campaign_was_stopped(tmp_path: pathlib.Path) -> None:
    def enough(progress: bs.Progress) -> None:
        raise InterruptedError

    campaign = bs.Campaign(bs.demo("pool"), 6)
    with pytest.raises(InterruptedError):
        campaign.run(tmp_path, progress=enough)
    kept = (tmp_path / "together.csv").read_bytes()
    # longer than a trial takes
    time.sleep(4)
    assert (tmp_path / "together.csv").read_bytes() == kept


def test_progress_may_call_boresight_again(pool: bs.Survey, result: bs.Result) -> None:
    found: list[bs.Result] = []

    def again(progress: bs.Progress) -> None:
        if not found:
            found.append(bs.calibrate(pool))

    assert bs.calibrate(pool, progress=again) == result == found[0]


def test_progress_is_told_on_the_caller_s_thread(pool: bs.Survey) -> None:
    threads: set[int] = set()
    bs.calibrate(pool, progress=lambda p: threads.add(threading.get_ident()))
    assert threads == {threading.get_ident()}


def test_other_threads_run_meanwhile(pool: bs.Survey) -> None:
    """Pauses of a thread that ticks every 5 ms while others calibrate: the interpreter is not held."""
    stop, longest, last = threading.Event(), 0.0, time.perf_counter()

    def tick() -> None:
        nonlocal longest, last
        last = time.perf_counter()
        while not stop.is_set():
            time.sleep(0.005)
            now = time.perf_counter()
            longest = max(longest, now - last)
            last = now

    ticking = threading.Thread(target=tick)
    ticking.start()
    begun = time.perf_counter()
    for _ in range(3):
        bs.calibrate(pool)
    took = time.perf_counter() - begun
    stop.set()
    ticking.join()
    # one call that held the interpreter would be a pause of a third; on a busy machine 50 ms are too little
    assert longest < max(0.1, took / 6), (longest, took)


def test_two_threads_calibrate_at_once(pool: bs.Survey, result: bs.Result) -> None:
    found: list[bs.Result] = []
    both = [threading.Thread(target=lambda: found.append(bs.calibrate(pool, threads=1))) for _ in range(2)]
    for thread in both:
        thread.start()
    for thread in both:
        thread.join()
    assert found == [result, result]


def usable(survey: str) -> bytes:
    return bs.calibrate(survey).to_json()


@pytest.mark.parametrize("method", ["spawn", "fork"])
def test_child_processes_work(method: str, result: bs.Result, surveys: Callable[[str], pathlib.Path]) -> None:
    """Also one that was forked after a run: it has none of its parent's threads."""
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"no {method} here")
    context: Any = multiprocessing.get_context(method)
    with context.Pool(1) as children:
        found = children.apply_async(usable, (os.fspath(surveys("pool")),)).get(60)
    assert found == result.to_json()
