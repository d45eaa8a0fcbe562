"""Campaigns: the ledgers of the command, byte by byte, however they were made."""

from __future__ import annotations

import pathlib
import pickle
import random
import signal
import subprocess
import sys

import numpy as np
import pytest
from conftest import THIN, command

import boresight as bs

#: a sweep of the quickest procedure
VARY = {"fixes.range_sigma_m": [0.02, 0.05]}


def ledgers(folder: pathlib.Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in sorted(folder.glob("*.csv"))}


@pytest.fixture(scope="module")
def by_command(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    """What the command makes: 12 trials, 2 of each source alone, at two values of a key."""
    folder = tmp_path_factory.mktemp("command")
    vary = [w for k, v in VARY.items() for w in ("--vary", f"{k}={','.join(map(str, v))}")]
    command("budget", THIN["usbl"], "--trials", 12, "--single", 2, "--seed", 5, *vary, "--out", folder)
    return folder


def campaign() -> bs.Campaign:
    return bs.Campaign(THIN["usbl"], 12, single=2, seed=5, vary=VARY)


@pytest.mark.parametrize("threads", [1, 2, None])
def test_the_ledgers_are_the_command_s(threads: int | None, by_command: pathlib.Path, tmp_path: pathlib.Path) -> None:
    seen: list[bs.Progress] = []
    trials = campaign().run(tmp_path / "run", threads=threads, progress=seen.append)
    assert ledgers(tmp_path / "run") == ledgers(by_command / "trials") != {}
    assert seen[-1] == bs.Progress("trials", len(trials), len(trials)) and len(trials) == sum(campaign().cells.values())
    assert sorted(p.done for p in seen) == sorted({p.done for p in seen})


def test_the_budget_of_the_ledgers_is_the_command_s(by_command: pathlib.Path, tmp_path: pathlib.Path) -> None:
    found = campaign().summary(by_command / "trials", out=tmp_path)
    assert found["trials"] == 12
    for file in ("result.json", "budget.csv", "sweep.csv", "report.html"):
        assert (tmp_path / file).read_bytes() == (by_command / file).read_bytes(), file


def test_a_pool_s_ledgers_are_the_command_s(tmp_path: pathlib.Path) -> None:
    command("budget", THIN["pool"], "--trials", 4, "--out", tmp_path / "command")
    bs.Campaign(THIN["pool"].read_text(), 4).run(tmp_path / "run")
    assert ledgers(tmp_path / "run") == ledgers(tmp_path / "command" / "trials") != {}


@pytest.mark.parametrize("chunk", [1, 4, 7, 100])
def test_records_of_seeds_make_the_same_ledger(chunk: int, by_command: pathlib.Path) -> None:
    core = campaign()._handle
    for cell, (_, file, count, _) in enumerate(core.cells()):
        if file not in ("together.csv", "nothing.csv"):
            continue
        lines = [core.records(cell, k, min(chunk, count - k)) for k in range(0, count, chunk)]
        whole = (by_command / "trials" / file).read_bytes()
        assert whole.endswith(b"".join(lines)) and b"".join(lines).count(b"\n") == count


def test_a_run_goes_on_where_it_ended(by_command: pathlib.Path, tmp_path: pathlib.Path) -> None:
    folder = tmp_path / "run"

    def enough(progress: bs.Progress) -> None:
        if progress.done == 13:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        campaign().run(folder, progress=enough, threads=2)
    kept = ledgers(folder)
    assert 0 < sum(bytes(b).count(b"\n") for b in kept.values()) < sum(b.count(b"\n") for b in ledgers(by_command / "trials").values())
    with pytest.raises(bs.LedgerError, match="continue them with resume=True, or choose another folder"):
        campaign().run(folder, resume=False)
    assert ledgers(folder) == kept
    # a record torn in the middle of a write
    (folder / "together.csv").write_bytes(kept["together.csv"][:-9])
    campaign().run(folder)
    assert ledgers(folder) == ledgers(by_command / "trials")
    # fewer trials than there are: nothing is run, nothing is lost
    assert bs.Campaign(THIN["usbl"], 3, single=2, seed=5, vary=VARY).run(folder).cells.keys() == bs.read_trials(folder).cells.keys()
    assert ledgers(folder) == ledgers(by_command / "trials")


def test_trials_of_something_else_are_refused(by_command: pathlib.Path) -> None:
    before = ledgers(by_command / "trials")
    with pytest.raises(bs.LedgerError, match="trials are of another first seed: found 5, expected 6"):
        bs.Campaign(THIN["usbl"], 12, seed=6).run(by_command / "trials")
    text = THIN["usbl"].read_text()
    other = text.replace('name = "', 'name = "other ')
    with pytest.raises(bs.LedgerError, match="another scenario"):
        bs.Campaign(other, 12, seed=5).run(by_command / "trials")
    assert ledgers(by_command / "trials") == before


def test_trials_of_another_arithmetic_are_refused(by_command: pathlib.Path, tmp_path: pathlib.Path) -> None:
    text = (by_command / "trials" / "together.csv").read_text()
    own = bs._core.numerics()
    assert own in text
    (tmp_path / "together.csv").write_text(text.replace(own, "0" * 64))
    with pytest.raises(bs.LedgerError, match=r"the last digits come out otherwise \(numerics 000000000000, here " + own[:12]):
        bs.Campaign(THIN["usbl"], 40, seed=5).run(tmp_path)


def test_impossible_campaigns_are_refused() -> None:
    for words, said in [
        ({"trials": 0}, "Campaign: trials: found 0, expected 1 or more"),
        ({"trials": 3, "single": 1}, "Campaign: single: found 1"),
        ({"trials": 3, "vary": {"a": [1], "b": [1], "c": [1]}}, "vary: found 3 keys, expected at most 2"),
        ({"trials": 3, "vary": {"seed": []}}, r"vary\['seed'\]: found no values"),
        ({"trials": 3, "vary": {"nowhere.to_be": [1]}}, "nowhere"),
    ]:
        with pytest.raises(bs.InputError, match=said):
            bs.Campaign(THIN["usbl"], **words)  # type: ignore[arg-type]
    with pytest.raises(bs.InputError, match="no such file"):
        bs.Campaign("none.toml", 3)


def test_trials_are_tables(by_command: pathlib.Path) -> None:
    trials = bs.read_trials(by_command)
    together = trials["together"]
    assert len(together) == 12 and together.seeds.tolist() == list(range(5, 17))
    assert trials.paths[0] == "joint" and together.errors.shape == (12, len(trials.paths), len(trials.parameters))
    # against the budget that the library makes of the same ledgers
    joint = next(p for p in campaign().summary(by_command / "trials")["paths"] if p["path"] == "joint")["together"]
    mine = trials.summary()["joint"]
    for k, (name, unit) in enumerate(zip(trials.parameters, trials.units, strict=True)):
        to_shown = 180 / np.pi if unit == "rad" else 1.0
        assert mine[name]["usable"] == joint["usable"]
        assert mine[name]["standard_deviation"] * to_shown == pytest.approx(joint["standard_deviation"][k], rel=1e-9)
        assert mine[name]["pull_rms"] == pytest.approx(joint["reported"]["pull_rms"][k], rel=1e-9)
    assert np.allclose(together.covariance, together.covariance.transpose(0, 2, 1), equal_nan=True)
    with pytest.raises(bs.LedgerError, match="no files of trials"):
        bs.read_trials(by_command.parent / "nowhere")


def test_a_sweep_is_a_grid(by_command: pathlib.Path) -> None:
    pytest.importorskip("xarray")
    trials = bs.read_trials(by_command)
    [(key, values)] = VARY.items()
    grid = trials.to_xarray()
    assert grid["error"].dims == (key, "seed", "path", "parameter") and grid[key].values.tolist() == values
    for value in values:
        cell = trials[f"vary-{key}={value}"]
        assert np.array_equal(grid["error"].sel({key: value}).values, cell.errors, equal_nan=True)
    rms = (grid["error"].sel(path="joint") ** 2).mean("seed") ** 0.5
    assert bool((rms.isel({key: 1}) > rms.isel({key: 0})).any())
    alone = trials.to_xarray("together")
    assert alone["error"].dims == ("seed", "path", "parameter")
    table = trials.to_pandas()
    assert len(table) == len(trials) * len(trials.paths) * len(trials.parameters)
    assert table.loc[("together", 5, "joint", "roll"), "error"] == trials["together"].errors[0, 0, trials.parameters.index("roll")]


def test_a_campaign_survives_pickling() -> None:
    one = campaign()
    again = pickle.loads(pickle.dumps(one))
    assert again.cells == one.cells and again._handle.cells() == one._handle.cells()


@pytest.mark.skipif(sys.platform == "win32", reason="kills processes")
def test_a_killed_run_loses_no_whole_trial(by_command: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """The process that runs a campaign is killed at random moments, again and again."""
    text = (
        "import boresight as bs, sys\n"
        f"bs.Campaign({str(THIN['usbl'])!r}, 12, single=2, seed=5, vary={VARY!r}).run(sys.argv[1], threads=1)\n"
    )
    chance = random.Random(16)
    before, kills = 0, 0
    for _ in range(60):
        running = subprocess.Popen([sys.executable, "-c", text, str(tmp_path)])
        try:
            running.wait(chance.uniform(0.6, 1.4))
            assert running.returncode == 0
            break
        except subprocess.TimeoutExpired:
            running.send_signal(signal.SIGKILL)
            running.wait()
            kills += 1
        done = sum(b.count(b"\n") for b in ledgers(tmp_path).values())
        assert done >= before
        before = done
    else:
        pytest.fail("sixty runs did not bring it to an end")
    assert ledgers(tmp_path) == ledgers(by_command / "trials")
