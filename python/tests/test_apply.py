"""Clouds as files, by the command underneath."""

from __future__ import annotations

import pathlib
from collections.abc import Callable

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
    with pytest.raises(bs.InputError, match=r"a\.xyz.*expected \.laz or \.las"):
        bs.apply(pool, result, tmp_path / "a.xyz")
    theirs = tmp_path / "theirs.laz"
    theirs.write_bytes(b"mine")
    with pytest.raises(bs.InputError, match=r"theirs\.laz"):
        bs.apply(pool, result, theirs, force=True)
    assert theirs.read_bytes() == b"mine"
    with pytest.raises(bs.InputError, match=r"no\.toml"):
        bs.apply(tmp_path / "no.toml", result, tmp_path / "a.laz")
    assert not (tmp_path / "a.laz").exists()
