"""Recorders' files of a writer that does not know this program, calibrated to the mounting that was put in."""

from __future__ import annotations

import pathlib
import subprocess
import sys

import pytest

import boresight as bs

RECIPE = pathlib.Path(__file__).parents[2] / "tests" / "recipes" / "recorder_survey.py"
#: corrections about the body's axes that the recipe puts in, degrees
TRUTH_DEG = {"pitch": 0.9, "roll": -0.5, "yaw": 1.1}


@pytest.mark.parametrize(("recorder", "navigation"), [("all-big", "novatel-ascii"), ("kmall", "own"), ("s7k", "pos-mv-102"), ("xtf", "smrmsg")])
def test_what_was_put_in_comes_out(recorder: str, navigation: str, tmp_path: pathlib.Path) -> None:
    subprocess.run([sys.executable, str(RECIPE), "1", str(tmp_path), recorder, navigation], check=True, timeout=300)
    result = bs.calibrate(tmp_path / "survey.toml", method="joint")
    assert result.usable
    mounting = result.to_dict()["solutions"]["joint"]["mountings"][0]
    for name, truth_deg in TRUTH_DEG.items():
        sigma_deg = result.parameters[name].sigma
        assert sigma_deg is not None
        pull = (mounting["correction_deg"][name] - truth_deg) / sigma_deg
        assert abs(pull) < 3, (name, pull)
