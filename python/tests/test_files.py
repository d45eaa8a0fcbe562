"""Surveys from files: the package and the command say the same."""

from __future__ import annotations

import copy
import json
import math
import pathlib
import pickle
from collections.abc import Callable

import numpy as np
import pytest
from conftest import PROCEDURES, THIN, command

import boresight as bs

Surveys = Callable[[str], pathlib.Path]


@pytest.mark.parametrize("procedure", PROCEDURES)
def test_the_bytes_are_those_of_the_command(procedure: str, surveys: Surveys, tmp_path: pathlib.Path) -> None:
    survey = surveys(procedure)
    ended = command("calibrate", survey, "--out", tmp_path / "out", check=False)
    result = bs.calibrate(survey, threads=2)
    assert ended.returncode == (0 if result.usable else 1), ended.stderr
    assert result.to_json() == (tmp_path / "out" / "result.json").read_bytes()
    result.write(tmp_path / "own", ["sis"])
    own = {p.name: p.read_bytes() for p in (tmp_path / "own").iterdir()}
    assert set(own) == {"result.json", "report.html", "parameters.csv", "card-sis.txt"}
    for name in ("result.json", "report.html", "parameters.csv"):
        assert own[name] == (tmp_path / "out" / name).read_bytes(), name


def test_seed_method_and_threads_are_the_command_s(surveys: Surveys, tmp_path: pathlib.Path) -> None:
    survey = surveys("pool")
    words = ("--method", "joint", "--seed", "7", "--simple")
    command("calibrate", survey, *words, "--out", tmp_path, check=False)
    found = {bs.calibrate(survey, method="joint", seed=7, simple=True, threads=n).to_json() for n in (1, 2, None)}
    assert found == {(tmp_path / "result.json").read_bytes()}


def test_a_setting_without_use_is_refused(surveys: Surveys) -> None:
    with pytest.raises(bs.InputError, match="seed: found with a usbl calibration"):
        bs.calibrate(surveys("usbl"), seed=3)
    with pytest.raises(bs.InputError, match='method: found "fast", expected "both"'):
        bs.calibrate(surveys("usbl"), method="fast")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="threads: found 0"):
        bs.calibrate(surveys("usbl"), threads=0)


@pytest.mark.parametrize("procedure", PROCEDURES)
def test_check_says_what_the_command_says(procedure: str, surveys: Surveys) -> None:
    survey = surveys(procedure)
    found = bs.check(survey)
    said = command("check", survey, "--json", check=False)
    assert json.loads(said.stdout) == found.keys
    assert (said.returncode == 0) == found.determined
    assert str(found).strip()


def test_every_fault_of_a_survey_comes_at_once(surveys: Surveys, tmp_path: pathlib.Path) -> None:
    text = surveys("pool").read_text()
    wrong = text.replace("[multibeam]", "[multibeam]\nrange_sigmam = 1.0").replace('"trajectory.csv"', '"none.csv"')
    file = tmp_path / "survey.toml"
    file.write_text(wrong)
    with pytest.raises(bs.InputError) as caught:
        bs.read_survey(file)
    faults = caught.value.faults
    assert len(faults) >= 2 and all(f.file == str(file) or "none.csv" in f.file + f.found for f in faults), faults
    assert any("range_sigmam" in f.place + f.found and "range_sigma_m" in f.expected for f in faults), faults
    assert str(caught.value).splitlines() == [str(f) for f in faults]
    again = pickle.loads(pickle.dumps(caught.value))
    assert again.faults == faults and str(again) == str(caught.value)
    with pytest.raises(bs.InputError, match="no such file"):
        bs.read_survey(tmp_path / "nowhere.toml")
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, bs.BoresightError)


def test_a_result_shows_itself(result: bs.Result, tmp_path: pathlib.Path) -> None:
    keys = json.loads(result.to_json())
    assert result.usable and result.reason is None and result.require() is result
    joint = keys["solutions"]["joint"]
    assert [p.value for p in result.parameters.values()] == [p["value"] for p in joint["parameters"]]
    covariance, sigma = result.covariance, result.sigma
    assert covariance is not None and sigma is not None
    assert covariance.tolist() == joint["covariance"] and not covariance.flags.writeable
    for k, p in enumerate(result.parameters.values()):
        in_si = math.radians(p.sigma or 0.0) if p.unit == "deg" else p.sigma
        assert sigma[k] == pytest.approx(in_si, rel=1e-12)
    rotation = result.mounting.rotation
    assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
    shown = bs.Mounting(result.mounting.roll_deg, result.mounting.pitch_deg, result.mounting.heading_deg)
    assert np.allclose(shown.rotation, rotation, atol=1e-14)
    html = result._repr_html_()
    assert html.count("<tr>") == 7 and "roll, deg" in html and "usable" in html
    page = result.report(tmp_path / "report.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>") or page.startswith("<!doctype html>")
    assert "Enter these values" in str(result)


def test_results_are_equal_by_their_bytes_and_survive_pickling(result: bs.Result, pool: bs.Survey) -> None:
    again = pickle.loads(pickle.dumps(result))
    assert again == result and hash(again) == hash(result) and copy.deepcopy(result) == result
    assert again.to_json() == result.to_json() and again.mounting.roll_deg == result.mounting.roll_deg
    assert bs.Result.from_json(result.to_json()) == result
    other = bs.calibrate(pool, method="reference")
    assert other != result and result != "result"
    # no pictures, all figures
    assert len(again.html()) < len(result.html()) and "Enter these values" in str(again)
    with pytest.raises(bs.InputError, match="expected a result.json"):
        bs.Result.from_json(b"{}")


def test_a_result_that_is_not_usable_is_no_exception_until_required(tmp_path: pathlib.Path) -> None:
    text = THIN["pool"].read_text() + "\n[joint]\nmax_sigma_m = 1e-6\n"
    # the scenario has a section of its own already, or not
    if THIN["pool"].read_text().count("[joint]"):
        text = THIN["pool"].read_text().replace("[joint]", "[joint]\nmax_sigma_m = 1e-6")
    found = bs.calibrate(bs.simulate(text).survey)
    assert not found.usable and found.reason
    assert found.verdict in ("not determined", "does not fit") and "<strong>pool" in found._repr_html_()
    with pytest.raises(bs.AdjustmentError, match=found.reason[:20].replace("(", ".")):
        found.require()


@pytest.mark.parametrize("procedure", PROCEDURES)
def test_a_simulation_is_the_command_s(procedure: str, surveys: Surveys, tmp_path: pathlib.Path) -> None:
    command("simulate", THIN[procedure], "--out", tmp_path / "sim")
    own = surveys(procedure).parent
    for file in own.iterdir():
        if not file.name.startswith("."):
            assert file.read_bytes() == (tmp_path / "sim" / file.name).read_bytes(), file.name


def test_a_simulation_writes_over_nothing(tmp_path: pathlib.Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(bs.InputError, match="with something in it, expected an empty or a new one"):
        bs.simulate(THIN["usbl"], tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["mine.txt"]


def test_a_simulated_survey_is_compared_with_its_truth() -> None:
    simulated = bs.simulate(bs.demo("usbl"), seed=4)
    assert simulated.counts["fixes"] > 0 and "rotation_matrix" in json.dumps(dict(simulated.truth))
    assert "error against the truth" in str(bs.calibrate(simulated.survey))
    with pytest.raises(bs.InputError, match='procedure: found "boat", expected one of pool'):
        bs.demo("boat")
    with pytest.raises(bs.InputError, match="trailing|unknown|expected"):
        bs.simulate(bs.demo("usbl") + "\nrubbish = 1\n")


def test_a_panic_arrives_as_an_exception() -> None:
    with pytest.raises(bs.InternalError, match="failed inside: out of luck; this is a fault of the program"):
        bs._core.panic_for_tests("out of luck")
    assert not issubclass(bs.InternalError, bs.InputError) and issubclass(bs.InternalError, Exception)


def test_other_procedures_say_that_they_show_no_arrays(surveys: Surveys) -> None:
    survey = bs.read_survey(surveys("usbl"))
    assert survey.config["procedure"] == "usbl" and survey.inputs
    with pytest.raises(bs.BoresightError, match="a usbl survey shows no arrays"):
        _ = survey.trajectory
    with pytest.raises(bs.InputError, match="whose sensors give no points"):
        bs.cloud(survey, bs.Mounting())


def test_budget_and_plan_are_the_command_s(tmp_path: pathlib.Path) -> None:
    def without_command(data: bytes) -> dict[str, object]:
        keys: dict[str, object] = json.loads(data)
        return {k: v for k, v in keys.items() if k != "command"}

    command("budget", THIN["pool"], "--out", tmp_path / "budget")
    found = bs.budget(THIN["pool"])
    assert without_command(found.to_json()) == without_command((tmp_path / "budget" / "result.json").read_bytes())
    assert found.parameters == ("pitch", "roll", "yaw", "lx", "ly", "lz")
    assert found.sigma["joint"].shape == (6,) and (found.sigma["joint"] > 0).all()
    assert set(found.shares["joint"]) >= set(found.sources) - {"nothing"}
    command("plan", THIN["pool"], "--distance", "5,8", "--wanted", "yaw=0.05,lx=5", "--out", tmp_path / "plan")
    plan = bs.plan(THIN["pool"], distances_m=[5, 8], wanted={"yaw": 0.05, "lx": 0.005})
    assert without_command(plan.to_json()) == without_command((tmp_path / "plan" / "plan.json").read_bytes())
    with pytest.raises(bs.InputError, match="no derivatives to propagate; run a Campaign"):
        bs.budget(THIN["usbl"])
    with pytest.raises(bs.InputError, match="found a usbl scenario, expected a pool scenario"):
        bs.plan(THIN["usbl"])
    with pytest.raises(bs.InputError, match=r"wanted\['jaw'\]: found no such parameter"):
        bs.plan(THIN["pool"], wanted={"jaw": 1.0})


def test_a_survey_s_budget_is_the_command_s(surveys: Surveys, tmp_path: pathlib.Path) -> None:
    command("budget", surveys("pool"), "--out", tmp_path)
    found = bs.budget(bs.read_survey(surveys("pool")))
    said = json.loads((tmp_path / "result.json").read_bytes())
    assert {**said, "command": ""} == {**found.to_dict(), "command": ""}
