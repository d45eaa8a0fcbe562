"""Clouds as files, by the command underneath."""

from __future__ import annotations

import pathlib
from collections.abc import Callable

import numpy as np
import pytest

import boresight as bs
from conftest import command


def test_the_bytes_are_the_command_s(surveys: Callable[[str], pathlib.Path], result: bs.Result, tmp_path: pathlib.Path) -> None:
    survey = surveys("pool")
    written = bs.apply(bs.read_survey(survey), result, tmp_path / "a.laz", coordinates="geocentric")
    (tmp_path / "result.json").write_bytes(result.to_json())
    words = ("apply", survey, "--calibration", tmp_path / "result.json", "--out", tmp_path / "b.laz", "--coordinates", "geocentric")
    command(*words)
    assert (tmp_path / "a.laz").read_bytes() == (tmp_path / "b.laz").read_bytes()
    assert written.points == len(bs.cloud(bs.read_survey(survey), result)) and written.sources == ("laser", "multibeam")
    assert written.file == tmp_path / "a.laz" and written.coordinates == "geocentric" and written.surface is None
    again = bs.apply(survey, tmp_path / "result.json", tmp_path / "a.laz", solution="reference")
    assert again.coordinates.startswith("UTM zone")


def test_what_is_wrong_is_said(pool: bs.Survey, result: bs.Result, tmp_path: pathlib.Path) -> None:
    from test_arrays import same

    with pytest.raises(bs.InputError, match="found a survey that is in memory alone, expected one from files"):
        bs.apply(same(pool), result, tmp_path / "a.laz")
    with pytest.raises(bs.InputError, match=r"a\.xyz.*expected one of \.laz or \.las"):
        bs.apply(pool, result, tmp_path / "a.xyz")
    theirs = tmp_path / "theirs.laz"
    theirs.write_bytes(b"mine")
    with pytest.raises(bs.InputError, match=r"theirs\.laz"):
        bs.apply(pool, result, theirs, force=True)
    assert theirs.read_bytes() == b"mine"
    with pytest.raises(bs.InputError, match=r"no\.toml"):
        bs.apply(tmp_path / "no.toml", result, tmp_path / "a.laz")
    assert not (tmp_path / "a.laz").exists()


def test_heights_of_lines_are_applied_to_their_own_survey(surveys: Callable[[str], pathlib.Path], tmp_path: pathlib.Path) -> None:
    """A whole result moves a line by what it was off; the mounting alone does not."""
    survey = bs.read_survey(surveys("seabed"))
    result = bs.calibrate(survey, method="joint")
    if not result.usable:
        pytest.skip("this thin survey is not usable")
    whole, alone = bs.cloud(survey, result), bs.cloud(survey, result.mounting)
    lifted = np.unique(np.round(np.linalg.norm(whole.xyz_m - alone.xyz_m, axis=1), 4))
    assert lifted.max() > 0.001
    written = bs.apply(survey, result, tmp_path / "a.laz", surface=tmp_path / "bed.tif", cell_m=2.0)
    assert written.points == len(whole) and (tmp_path / "bed.tif").stat().st_size > 1000
