"""Recorders' files of a writer that does not know this program, calibrated to the mounting that was put in."""

from __future__ import annotations

import pathlib
import subprocess
import sys

import numpy as np
import pytest
from conftest import THIN

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


def test_two_arrays_have_a_mounting_each(tmp_path: pathlib.Path, result: bs.Result) -> None:
    own = "receiver_mounting_deg = { roll = -43.5, pitch = -0.4, heading = 0.6 }, receiver_offset_m = [0.1, -0.25, 0.02], sectors = 3"
    text = THIN["pool"].read_text()
    text = text.replace("mounting_deg = { roll = -45.0 }", f"mounting_deg = {{ roll = -45.0 }}\narrays = {{ {own} }}")
    scenario = tmp_path / "scenario.toml"
    scenario.write_text(text.replace("[truth]", "[sound_speed]\nspeed_m_s = 1480.0\n\n[truth]"))
    bs.simulate(scenario, tmp_path / "survey")
    mounting = bs.calibrate(tmp_path / "survey" / "survey.toml", method="joint").mounting
    transmitter, receiver = mounting.arrays
    # both were moved by the one correction
    for array in (transmitter, receiver):
        np.testing.assert_allclose(array.rotation @ array.nominal_rotation.T, mounting.rotation @ mounting.nominal_rotation.T, atol=1e-12)
    assert receiver.nominal_lever_arm_m is not None and transmitter.nominal_lever_arm_m is not None
    apart = receiver.nominal_lever_arm_m - transmitter.nominal_lever_arm_m
    np.testing.assert_allclose(apart, [0.1, -0.25, 0.02], atol=1e-9)
    assert result.mounting.arrays == ()
