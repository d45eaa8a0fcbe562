"""Surveys from arrays: taken, or refused in one sentence that names the argument."""

from __future__ import annotations

import dataclasses
import pathlib
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import boresight as bs


def same(pool: bs.Survey, **changed: Any) -> bs.Survey:
    """The survey again, from its arrays."""
    parts: dict[str, Any] = {n: getattr(pool, n) for n in ("trajectory", "laser", "soundings", "target", "pose")}
    parts |= {"scanner": pool.scanner, "sonar": pool.sonar, "sound_speed": pool.sound_speed}
    parts["config"] = {k: pool.config[k] for k in ("sequential", "joint", "verdict")}
    return bs.Survey(**(parts | changed))


def trajectory(pool: bs.Survey, **changed: Any) -> bs.Trajectory:
    """The survey's trajectory with other columns."""
    fields = {f.name: getattr(pool.trajectory, f.name) for f in dataclasses.fields(bs.Trajectory)}
    return bs.Trajectory(**(fields | changed))


def without_source(result: bs.Result) -> dict[str, Any]:
    return {k: v for k, v in result.to_dict().items() if k not in ("inputs", "configuration")}


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_arrays_give_the_result_of_the_files(seed: int, pool: bs.Survey) -> None:
    from conftest import THIN

    survey = pool if seed == 1 else bs.simulate(THIN["pool"], seed=seed).survey
    survey._truth = None
    assert without_source(bs.calibrate(same(survey))) == without_source(bs.calibrate(survey))


def test_travel_times_with_a_profile_give_the_result_of_the_files() -> None:
    from conftest import THIN

    text = THIN["pool"].read_text().replace("[multibeam]", '[multibeam]\nrecords = "travel_time"')
    survey = bs.simulate(text + "\n[sound_speed]\nprofile = [[0.0, 1490.0], [3.0, 1485.0], [12.0, 1480.0]]\n").survey
    survey._truth = None
    assert survey.soundings.travel_time_s is not None and isinstance(survey.sound_speed, bs.SoundSpeed)
    assert without_source(bs.calibrate(same(survey))) == without_source(bs.calibrate(survey))
    with pytest.raises(bs.InputError, match="sound_speed: whole argument: found nothing, expected a speed or a profile"):
        same(survey, sound_speed=None)
    with pytest.raises(bs.InputError, match="sound_speed: whole argument: found 3.0, expected 1000 to 2000|found 3, expected"):
        same(survey, sound_speed=3.0)
    with pytest.raises(bs.InputError, match="sound_speed: depth_m: found depths that do not rise"):
        same(survey, sound_speed=bs.SoundSpeed([5.0, 0.0], [1480.0, 1481.0]))


TAKEN: dict[str, Callable[[Any], Any]] = {
    "list": lambda a: a.tolist(),
    "tuple": lambda a: tuple(a.tolist()),
    "strided": lambda a: np.repeat(a, 2)[::2],
    "reversed view": lambda a: a[::-1].copy()[::-1],
    "big-endian": lambda a: a.astype(">f8"),
    "read-only": lambda a: np.array(a),
    "masked without a mask": lambda a: np.ma.masked_array(a),
    "float32": lambda a: a.astype(np.float32),
}


@pytest.mark.parametrize("kind", TAKEN)
def test_what_holds_numbers_is_taken(kind: str, pool: bs.Survey) -> None:
    pitch = np.round(np.asarray(pool.trajectory.pitch_rad) * 1024) / 1024
    made = trajectory(pool, pitch_rad=TAKEN[kind](pitch)).pitch_rad
    assert made.dtype == np.float64 and made.flags.c_contiguous and not made.flags.writeable
    assert (made == pitch).all()


def test_tables_and_labelled_arrays_are_taken(pool: bs.Survey) -> None:
    pandas, xarray = pytest.importorskip("pandas"), pytest.importorskip("xarray")
    roll = pool.trajectory.roll_rad
    for given in (pandas.Series(roll), xarray.DataArray(roll, dims="time")):
        assert (trajectory(pool, roll_rad=given).roll_rad == roll).all()
    with pytest.raises(bs.InputError, match="trajectory: roll_rad: found"):
        trajectory(pool, roll_rad=pandas.Series([1, None] * 3, dtype="Int64"))
    with pytest.raises(bs.InputError, match="time_s: found datetime64.*expected seconds as floats"):
        trajectory(pool, time_s=pandas.to_datetime(pool.trajectory.time_s, unit="s"))


REFUSED: dict[str, tuple[Any, str]] = {
    "wrong length": (np.zeros(5), r"found 5 rows, expected \d+ rows, as many as time_s"),
    "0-d": (np.float64(1.0), "found a single number, expected one dimension of floats"),
    "a number": (3.0, "found a single number"),
    "2-d": (np.zeros((4, 3)), r"found shape \(4, 3\), expected one dimension of floats"),
    "Fortran": (np.zeros((3, 4), order="F"), r"found shape \(3, 4\)"),
    "empty": (np.zeros(0), "found an empty array, expected at least one row"),
    "NaN": (np.array([0.0, np.nan]), "found nan in row 1, expected numbers"),
    "infinite": (np.array([np.inf, 0.0]), "found inf in row 0, expected numbers"),
    "masked": (np.ma.masked_array([1.0, 2.0], [True, False]), "found a masked array with 1 values masked"),
    "booleans": (np.array([True, False]), "found booleans"),
    "complex": (np.array([1j]), "found ndarray of complex128"),
    "texts": (["a", "b"], "found list of <U1"),
    "objects": (np.array([{}, 1], dtype=object), "found ndarray of object"),
    "ragged": ([[1.0], [1.0, 2.0]], "found a list that is no array"),
    "times": (np.array(["2026-01-01"], dtype="datetime64[s]"), r"found datetime64\[s\], expected seconds as floats"),
    "long floats": (np.zeros(3, dtype=np.longdouble), "found ndarray of float128"),
    "nothing": (None, "found nothing, expected one dimension of floats"),
    "large integers": (np.array([2**60]), "found whole numbers too large for floats"),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_what_does_not_is_refused_by_its_name(kind: str, pool: bs.Survey) -> None:
    value, said = REFUSED[kind]
    with pytest.raises(bs.InputError, match=f"^trajectory: heading_rad: {said}") as caught:
        trajectory(pool, heading_rad=value)
    assert len(str(caught.value).splitlines()) == 1 and caught.value.faults[0].place == "heading_rad"


def test_all_columns_faults_come_at_once(pool: bs.Survey) -> None:
    with pytest.raises(bs.InputError) as caught:
        trajectory(pool, roll_rad=np.zeros(3), pitch_rad=1.0, velocity_m_s=np.zeros(4))
    assert [f.place for f in caught.value.faults] == ["pitch_rad", "velocity_m_s", "roll_rad"]


def test_points_and_beams_have_their_shapes(pool: bs.Survey) -> None:
    laser, s = pool.laser, pool.soundings
    rows = bs.LaserScan(laser.time_s, laser.xyz_m, noise=laser.noise)
    assert (rows.xyz_m == laser.xyz_m).all()
    fortran = bs.LaserScan(laser.time_s, np.asfortranarray(laser.xyz_m))
    assert (fortran.xyz_m == laser.xyz_m).all()
    for given, said in [
        ({"xyz_m": laser.xyz_m.T}, r"laser: xyz_m: found shape \(3, \d+\), expected shape \(n, 3\)"),
        ({"x_m": laser.time_s}, "laser: y_m: found nothing"),
        ({"xyz_m": laser.xyz_m, "z_m": laser.time_s}, "laser: z_m: found it beside xyz_m"),
        ({"xyz_m": laser.xyz_m, "frame": "boat"}, "laser: frame: found 'boat', expected \"sensor\""),
    ]:
        with pytest.raises(bs.InputError, match=said):
            bs.LaserScan(laser.time_s, **given)  # type: ignore[arg-type]
    for given, said in [
        ({}, "range_m and travel_time_s: found neither"),
        ({"range_m": s.range_m, "travel_time_s": s.range_m}, "range_m and travel_time_s: found both"),
        ({"range_m": s.range_m, "ping": s.time_s}, "soundings: ping: found float64, expected one dimension of whole"),
        ({"range_m": s.range_m, "beam": -np.ones(len(s), dtype=int)}, "soundings: beam: found -1 to -1"),
    ]:
        with pytest.raises(bs.InputError, match=said):
            bs.Soundings(s.time_s, s.across_rad, **given)  # type: ignore[arg-type]


def test_rows_of_one_time_are_one_ping() -> None:
    made = bs.Soundings([1.0, 1.0, 1.5, 1.5, 1.5, 2.0], np.zeros(6), range_m=np.ones(6))
    assert made.ping.tolist() == [0, 0, 1, 1, 1, 2] and made.beam.tolist() == [0, 1, 0, 1, 2, 0]
    assert made.along_rad.tolist() == [0.0] * 6


def test_values_that_cannot_be_are_named_with_their_row(pool: bs.Survey) -> None:
    times = np.array(pool.trajectory.time_s)
    times[4] = times[3]
    degrees = np.degrees(pool.trajectory.latitude_rad)
    with pytest.raises(bs.InputError) as caught:
        same(pool, trajectory=trajectory(pool, time_s=times, latitude_rad=degrees))
    said = [str(f) for f in caught.value.faults]
    assert any(s.startswith("trajectory: time_s, row 4: found") and "a time after" in s for s in said), said
    assert any(s.startswith("trajectory: latitude_rad, row 0: found") and "are they degrees?" in s for s in said), said
    later = trajectory(pool, time_s=pool.trajectory.time_s + 1e5)
    with pytest.raises(bs.InputError, match="soundings: times: found"):
        same(pool, trajectory=later)


def test_configuration_and_arguments_are_checked_as_in_a_file(pool: bs.Survey) -> None:
    with pytest.raises(bs.InputError, match=r"survey: \[joint\] latncy: found .*latency"):
        same(pool, config={"joint": {"latncy": True}})
    with pytest.raises(bs.InputError, match="config: trajectory: found a section that has an argument"):
        same(pool, config={"trajectory": {}})
    with pytest.raises(bs.InputError, match="Survey: sonar: found a Pose, expected a Mounting"):
        same(pool, sonar=pool.pose)
    with pytest.raises(bs.InputError, match="Survey: scanner: found nothing"):
        same(pool, scanner=None)
    with pytest.raises(bs.InputError, match="target.*wall_length_m"):
        same(pool, target=bs.Target({**pool.target.keys, "wall_length_m": -1.0}))
    with pytest.raises(bs.InputError, match="SonarNoise: range_m: found 0.0, expected a number above 0"):
        bs.SonarNoise(range_m=0)
    with pytest.raises(bs.InputError, match="Mounting: lever_arm_m: found shape"):
        bs.Mounting(lever_arm_m=(1.0, 2.0))  # type: ignore[arg-type]
    found = bs.calibrate(same(pool, config={"joint": {"latency": True}}))
    assert found.parameters["latency"].determined and found.to_dict()["configuration"]["joint"]["latency"] is True


def test_a_target_of_faces_and_one_from_a_file(pool: bs.Survey, surveys: Callable[[str], pathlib.Path]) -> None:
    assert bs.Target.read(surveys("pool").parent / "target.toml") == pool.target
    keys = {k.removeprefix("wall_"): v for k, v in pool.target.keys.items() if k != "kind"}
    assert bs.Target.wall(**keys).keys == pool.target.keys
    square = [[0.0, -1.0, -1.0], [0.0, 1.0, -1.0], [0.0, 1.0, 1.0], [0.0, -1.0, 1.0]]
    made = bs.Target.faces([bs.Face("front", "P1", square)])
    assert same(pool, target=made).target.keys["face"][0]["name"] == "front"
    with pytest.raises(bs.InputError, match=r"target: faces\[0\].vertices_m: found shape \(4,\)"):
        bs.Target.faces([bs.Face("front", "P1", [1.0, 2.0, 3.0, 4.0])])


def test_arrays_given_are_copied(pool: bs.Survey) -> None:
    roll = np.array(pool.trajectory.roll_rad)
    made = trajectory(pool, roll_rad=roll)
    roll[:] = 7.0
    assert (made.roll_rad == pool.trajectory.roll_rad).all()
    with pytest.raises(ValueError, match="read-only"):
        made.roll_rad[0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        made.roll_rad = roll  # type: ignore[misc]


def test_georeferenced_points_are_those_of_apply(
    pool: bs.Survey, result: bs.Result, surveys: Callable[[str], pathlib.Path], tmp_path: pathlib.Path
) -> None:
    everything = bs.georeference(pool, result)
    assert everything.shape == (len(pool.soundings), 3)
    assert (bs.georeference(pool, result, rows=slice(100, 900, 7)) == everything[100:900:7]).all()
    assert bs.georeference(pool, result, rows=slice(5, 5)).shape == (0, 3)
    nominal = bs.georeference(pool)
    assert (nominal == bs.georeference(pool, pool.sonar)).all() and np.abs(nominal - everything).max() > 0.01
    laser = bs.georeference(pool, sensor="laser")
    assert laser.shape == (len(pool.laser), 3)
    cloud = bs.cloud(pool, result)
    assert cloud.sources == ("laser", "multibeam") and len(cloud) == len(laser) + len(everything)
    # a rigid motion leads from the target frame to the geocentric one
    ours = np.concatenate([laser, everything])
    theirs = np.concatenate([cloud.xyz_m[cloud.source == 1], cloud.xyz_m[cloud.source == 2]])
    a, b = ours - ours.mean(axis=0), theirs - theirs.mean(axis=0)
    u, _, v = np.linalg.svd(a.T @ b)
    assert np.abs(a @ (u @ v) - b).max() < 1e-6
    with pytest.raises(bs.InputError, match="georeference: rows: found a step of -1"):
        bs.georeference(pool, rows=slice(None, None, -1))
    with pytest.raises(bs.InputError, match="georeference: sensor: found 'beams'"):
        bs.georeference(pool, sensor="beams")  # type: ignore[arg-type]


def test_residuals_are_those_of_the_result(pool: bs.Survey, result: bs.Result) -> None:
    soundings, laser = bs.residuals(pool), bs.residuals(pool, sensor="laser")
    for sensor, found, n, key in [("soundings", soundings, len(pool.soundings), "soundings"), ("laser", laser, len(pool.laser), "returns")]:
        used = found.face >= 0
        assert len(found) == n
        assert used.sum() == result.counts[key]["used"] and np.isfinite(found.residual_m[used]).all()
        assert np.isnan(found.residual_m[~used]).all() and found.face.max() < len(found.faces)
        assert ((found.reason == 0) == used).all() and found.reasons[0] == "used"
        counted = np.bincount(found.reason, minlength=len(found.reasons))
        why = {name: int(n) for name, n in zip(found.reasons[1:], counted[1:], strict=True) if n}
        assert why == result.counts[key]["rejected"]
        if sensor == "soundings":
            rms = np.sqrt(np.mean(found.residual_m[used] ** 2))
            assert rms == pytest.approx(result.to_dict()["residual_rms_m"]["joint"], rel=1e-9)
    with pytest.raises(bs.InputError, match="expected a pool survey"):
        bs.residuals(bs.simulate(bs.demo("usbl")).survey)


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_georeferencing_needs_memory_for_its_output_alone(pool: bs.Survey) -> None:
    s = pool.soundings
    times = 3_000_000 // len(s) + 1
    order = np.argsort(np.tile(s.time_s, times), kind="stable")

    def tiled(column: Any) -> Any:
        return np.tile(column, times)[order]

    ranges = {"range_m": tiled(s.range_m)}
    many = bs.Soundings(tiled(s.time_s), tiled(s.across_rad), tiled(s.along_rad), **ranges)
    survey = same(pool, soundings=many)
    bs.georeference(survey, rows=slice(0, 10))

    def peak() -> int:
        lines = pathlib.Path("/proc/self/status").read_text().splitlines()
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM"))

    def now() -> int:
        lines = pathlib.Path("/proc/self/status").read_text().splitlines()
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmRSS"))

    pathlib.Path("/proc/self/clear_refs").write_text("5")
    before = now()
    found = bs.georeference(survey)
    # the output, and what the scene keeps for the trajectory: a tenth
    assert peak() - before < 1.1 * found.nbytes + 60e6, (peak() - before, found.nbytes)


def test_figures_of_every_observation(pool: bs.Survey, result: bs.Result) -> None:
    """Redundancy numbers sum to the redundancy, normalised residuals scatter by one, and the joint path's own are the same."""
    beams, laser = (bs.residuals(pool, sensor=sensor, method="joint") for sensor in ("soundings", "laser"))
    used = beams.face >= 0
    assert np.isnan(beams.redundancy[~used]).all() and np.isfinite(beams.redundancy[used]).all()
    assert result.joint is not None
    groups = {g["name"]: g for g in (result.joint.quality or {})["groups"]}
    for one, name in ((beams, "multibeam range and angles"), (laser, "laser range and angle")):
        figures = groups[name]
        assert np.nansum(one.redundancy) == pytest.approx(figures["redundancy"], rel=1e-3)
        # normal but for the kernel's tails: the mean square of n of them scatters by sqrt(2 / n)
        count = int((one.face >= 0).sum())
        assert abs(np.nanmean(one.normalised**2) - 1.0) < 6.0 * np.sqrt(2.0 / count) + 0.02
    # the sign is the distance's but for the trajectory's errors; by chance a half of 3391 would agree, to 0.01
    agree = np.sign(beams.normalised[used]) == np.sign(beams.residual_m[used])
    assert agree.mean() > 0.7
    alone = bs.residuals(pool, method="reference")
    assert np.isnan(alone.redundancy).all() and (alone.face >= 0).sum() > 1000
