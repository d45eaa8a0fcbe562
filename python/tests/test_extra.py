"""Unknowns of your own: found, named in the result, refused in one sentence."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from conftest import THIN

import boresight as bs

PUT_IN_M = 0.02


def since(survey: bs.Survey) -> npt.NDArray[np.float64]:
    """From -1 at the first sounding to 1 at the last."""
    t = survey.soundings.time_s
    part: npt.NDArray[np.float64] = 2.0 * (t - t[0]) / (t[-1] - t[0]) - 1.0
    return part


def spoilt(pool: bs.Survey) -> bs.Survey:
    """The survey with ranges that shorten from pass to pass."""
    from test_arrays import same

    s = pool.soundings
    assert s.range_m is not None
    ranges = s.range_m - PUT_IN_M * since(pool)
    soundings = bs.Soundings(s.time_s, s.across_rad, s.along_rad, range_m=ranges, ping=s.ping, beam=s.beam, noise=s.noise)
    return same(pool, soundings=soundings)


def test_what_is_put_in_is_found(pool: bs.Survey) -> None:
    survey = spoilt(pool)
    clock = bs.Extra("slow clock", since(survey), unit="m", acts_on="range")
    assert not bs.calibrate(survey, method="joint").usable
    result = bs.calibrate(survey, extra=[clock])
    assert result.usable
    found = result.extra["slow clock"]
    assert found.unit == "m" and found.value is not None and found.sigma is not None
    assert abs(found.value - PUT_IN_M) < 4.0 * found.sigma < 0.02
    assert pickle.loads(pickle.dumps(result)).extra == result.extra
    assert "slow clock" in result._repr_html_()
    # what the adjustment leaves knows nothing of the clock any more: of n residuals a correlation scatters by 1 / sqrt(n)
    off = bs.residuals(survey, method="joint", extra=[clock])
    used = off.face >= 0
    left = np.corrcoef(off.normalised[used], since(survey)[used])[0, 1]
    assert used.sum() > 1000 and abs(left) < 5.0 / np.sqrt(used.sum()), left


def test_a_prior_of_its_own_holds_it(pool: bs.Survey) -> None:
    survey = spoilt(pool)
    clock = bs.Extra("slow clock", since(survey), acts_on="range", prior_sigma=1e-6)
    found = bs.calibrate(survey, method="joint", extra=[clock])
    assert not found.usable


def test_without_there_is_none(result: bs.Result) -> None:
    assert dict(result.extra) == {}


def test_one_that_cannot_be_used_is_refused(pool: bs.Survey) -> None:
    with pytest.raises(bs.InputError, match='Extra: acts_on: found \'sideways\', expected "up", "range"'):
        bs.Extra("squat", [1.0], acts_on="sideways")  # type: ignore[arg-type]
    with pytest.raises(bs.InputError, match="Extra: derivative: found inf in row 0"):
        bs.Extra("squat", [np.inf, 1.0])
    with pytest.raises(bs.InputError, match="extra: whole argument: found a float"):
        bs.calibrate(pool, extra=[1.0])  # type: ignore[list-item]
    with pytest.raises(bs.BoresightError, match=f"extra squat: found 2 rows, expected {len(pool.soundings)} rows"):
        bs.calibrate(pool, extra=[bs.Extra("squat", [1.0, np.nan])])


@pytest.mark.parametrize("procedure", ["usbl", "rail"])
def test_a_procedure_without_soundings_takes_none(procedure: str) -> None:
    survey = bs.simulate(bs.demo(procedure)).survey
    with pytest.raises(bs.BoresightError, match="extra: .* no soundings are there"):
        bs.calibrate(survey, extra=[bs.Extra("squat", [1.0])])


def test_a_seabed_survey_takes_one_number_a_row_of_its_file(tmp_path: Path) -> None:
    bs.simulate(THIN["seabed"], tmp_path)
    file = tmp_path / "multibeam.csv"
    names, *lines = file.read_text().splitlines()
    rows = [line.split(",") for line in lines]
    column = names.split(",").index
    starboard = np.array([float(row[column("across_angle_deg")]) > 0.0 for row in rows])
    time_s = column("two_way_travel_time_s")
    for row, short in zip(rows, starboard, strict=True):
        row[time_s] = repr(float(row[time_s]) - float(short) * 2.0 * 0.06 / 1500.0)
    file.write_text("\n".join([names, *(",".join(row) for row in rows)]) + "\n")
    survey = bs.read_survey(tmp_path / "survey.toml")
    short = bs.Extra("short", np.where(starboard, 1.0, np.nan), unit="m", acts_on="range")
    result = bs.calibrate(survey, extra=[short])
    found = result.extra["short"]
    assert found.unit == "m" and found.value is not None and found.sigma is not None
    assert abs(found.value - 0.06) < 4.0 * found.sigma < 0.06
    assert result.counts["multibeam"]["read"] == len(rows)
    assert "short" in result._repr_html_()
    with pytest.raises(bs.BoresightError, match=f"extra squat: found 2 rows, expected {len(rows)} rows"):
        bs.calibrate(survey, extra=[bs.Extra("squat", [1.0, np.nan])])
