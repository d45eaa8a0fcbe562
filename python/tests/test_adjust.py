"""The engine on conditions of Python: certified values, refusals, stops."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

import boresight as bs
from boresight.adjust import Unknown, solve

# NIST/ITL StRD, Misra1a (Misra 1978, dental research in monomolecular adsorption), https://www.itl.nist.gov/div898/strd/
PRESSURE = [77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0]
VOLUME = [10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78]
CERTIFIED = {"b1": (2.3894212918e02, 2.7070075241e00), "b2": (5.5015643181e-04, 7.2668688436e-06)}
CERTIFIED_DEVIATION = 1.0187876330e-01


class Misra:
    """``y = b1 (1 - exp(-b2 x))``."""

    columns = ("b1", "b2")

    def __init__(self) -> None:
        self.x, self.y = np.array(PRESSURE), np.array(VOLUME)

    def __len__(self) -> int:
        return len(self.x)

    def linearise(self, x: Mapping[str, Any], rows: slice) -> tuple[Any, Any, Any]:
        t, y = self.x[rows], self.y[rows]
        gone = np.exp(-x["b2"] * t)
        return x["b1"] * (1.0 - gone) - y, 1.0, np.column_stack([1.0 - gone, x["b1"] * t * gone])


@pytest.mark.parametrize("start", [{"b1": 500.0, "b2": 1e-4}, {"b1": 250.0, "b2": 5e-4}])
def test_certified_values(start: dict[str, float]) -> None:
    """Both of the certificate's starts, to nine digits; its deviations are scaled by the residuals."""
    found = solve([Misra()], start, unknown_noise=True, step_tolerance_sigmas=1e-6).require()
    deviation = np.sqrt(found.variance_factor)
    assert deviation == pytest.approx(CERTIFIED_DEVIATION, rel=1e-9)
    for name, (value, sigma) in CERTIFIED.items():
        assert found.x[name] == pytest.approx(value, rel=1e-9)
        assert found.sigma[name] * deviation == pytest.approx(sigma, rel=1e-7)
    assert found.redundancy == 12.0


class Plane:
    """``z = a + s . (x, y)``, many rows, some of them gross errors."""

    columns = ("a", "s")

    def __init__(self, rows: int, gross: int = 0, seed: int = 1) -> None:
        draws = np.random.default_rng(seed)
        self.xy = draws.uniform(-1.0, 1.0, (rows, 2))
        self.z = 3.0 + self.xy @ [0.5, -0.25] + draws.normal(0.0, 0.01, rows)
        self.z[:gross] += 1.0
        self.calls: list[tuple[int, int]] = []

    def __len__(self) -> int:
        return len(self.z)

    def linearise(self, x: Mapping[str, Any], rows: slice) -> tuple[Any, Any, Any]:
        self.calls.append((rows.start, rows.stop))
        xy = self.xy[rows]
        return x["a"] + xy @ x["s"] - self.z[rows], 1e-4, np.column_stack([np.ones(len(xy)), xy])


def test_many_rows_come_in_batches_and_as_least_squares_says() -> None:
    plane = Plane(10_000)
    found = solve([plane], {"a": 0.0, "s": [0.0, 0.0]}, step_tolerance_sigmas=1e-7).require()
    matrix = np.column_stack([np.ones(10_000), plane.xy])
    known, *_ = np.linalg.lstsq(matrix, plane.z, rcond=None)
    assert np.allclose(np.concatenate([[found.x["a"]], found.x["s"]]), known, rtol=0, atol=1e-10)
    assert np.allclose(found.covariance, np.linalg.inv(matrix.T @ matrix) * 1e-4, rtol=1e-9)
    assert found.names == ("a", "s 0", "s 1")
    # a variance factor of 9997 degrees of freedom scatters by 0.014
    assert abs(found.variance_factor - 1.0) < 0.06
    assert set(plane.calls) == {(0, 4096), (4096, 8192), (8192, 10_000)}
    # the start, at most two steps, and nothing twice
    assert len(plane.calls) <= 3 * (len(found.iterations) + 1)


def test_a_kernel_leaves_gross_errors_aside_and_they_are_named() -> None:
    plane = Plane(500, gross=5)
    start: dict[str, Any] = {"a": 0.0, "s": [0.0, 0.0]}
    plain, robust = solve([plane], start), solve([plane], start, kernel="huber", width=2.0)
    # one of a hundred by one metre, without a kernel
    assert abs(plain.x["a"] - 3.0) == pytest.approx(0.01, abs=0.003)
    # Huber's own bias: 1 % gross, each pulling with two sigmas of 0.01 m
    assert abs(robust.x["a"] - 3.0) < 0.002
    assert sorted(w.row for w in robust.worst[:5]) == [0, 1, 2, 3, 4]
    assert all(abs(w.normalised) > robust.critical for w in robust.worst[:5])
    assert abs(robust.worst[5].normalised) < robust.critical


def test_threads_change_no_bytes() -> None:
    found = [solve([Plane(30_000)], {"a": 0.0, "s": [0.0, 0.0]}, threads=n) for n in (1, 2)]
    assert found[0].x["a"] == found[1].x["a"] and (found[0].covariance == found[1].covariance).all()


def test_priors_and_held_unknowns() -> None:
    plane = Plane(100)
    tied = solve([plane], {"a": Unknown(2.0, prior_sigma=1e-6), "s": Unknown([0.5, -0.25], held=True)})
    assert tied.x["a"] == pytest.approx(2.0, abs=1e-4) and tied.sigma["s 0"] == 0.0
    assert tied.x["s"].tolist() == [0.5, -0.25]


class Blind(Plane):
    """Sees the sum of two unknowns alone."""

    def linearise(self, x: Mapping[str, Any], rows: slice) -> tuple[Any, Any, Any]:
        first = self.xy[rows, 0]
        misclosure = x["a"] + first * x["s"].sum() - self.z[rows]
        return misclosure, 1.0, np.column_stack([np.ones_like(first), first, first])


def test_what_is_not_determined_is_said() -> None:
    found = solve([Blind(50)], {"a": 0.0, "s": [0.0, 0.0]})
    assert found.status == "rank_deficient" and not found.converged
    (axis,) = found.undetermined
    assert abs(axis[0]) < 1e-6 and axis[1] == pytest.approx(-axis[2])
    with pytest.raises(bs.AdjustmentError, match="rank_deficient"):
        found.require()


def test_wrong_arguments_are_named() -> None:
    plane = Plane(10)
    with pytest.raises(bs.InputError, match=r"conditions\[0\]: columns: found 'a', 's', expected names among 'b'"):
        solve([plane], {"b": 0.0})
    with pytest.raises(bs.InputError, match="solve: kernel: found 'hubert'"):
        solve([plane], {"a": 0.0, "s": [0.0, 0.0]}, kernel="hubert")  # type: ignore[arg-type]
    with pytest.raises(bs.InputError, match="parameters: a: found nan"):
        solve([plane], {"a": np.nan, "s": [0.0, 0.0]})
    with pytest.raises(bs.InputError, match="a.prior_sigma: found 0.0, expected positive"):
        solve([plane], {"a": Unknown(0.0, prior_sigma=0.0), "s": [0.0, 0.0]})
    with pytest.raises(bs.InputError, match=r"conditions\[0\]: whole argument: found a float without columns"):
        solve([1.0], {"a": 0.0})  # type: ignore[list-item]
    with pytest.raises(bs.InputError, match="conditions"):
        solve([Plane(2)], {"a": 0.0, "s": [0.0, 0.0]})


class Broken(Plane):
    """Does something wrong."""

    def __init__(self, how: str) -> None:
        super().__init__(100)
        self.how = how

    def linearise(self, x: Mapping[str, Any], rows: slice) -> tuple[Any, Any, Any]:
        misclosure, variance, derivatives = super().linearise(x, rows)
        if self.how == "raises":
            raise KeyError("mine")
        if self.how == "shape":
            return misclosure, variance, derivatives[:, :2]
        if self.how == "nan":
            misclosure[7] = np.nan
        return (misclosure, variance) if self.how == "two" else (misclosure, variance, derivatives)  # type: ignore[return-value]


def test_what_a_condition_does_wrong_comes_through() -> None:
    start: dict[str, Any] = {"a": 0.0, "s": [0.0, 0.0]}
    with pytest.raises(KeyError, match="mine"):
        solve([Broken("raises")], start)
    shape = r"conditions\[0\]: derivatives: found shape \(100, 2\) for rows 0 to 100, expected shape \(100, 3\)"
    with pytest.raises(bs.InputError, match=shape):
        solve([Broken("shape")], start)
    with pytest.raises(bs.InputError, match="found a tuple, expected misclosure, variance and derivatives"):
        solve([Broken("two")], start)
    with pytest.raises(bs.InputError, match="condition 7 of set 0: misclosure is NaN"):
        solve([Broken("nan")], start)
    # and the next call works
    assert solve([Plane(100)], start).converged


def test_two_threads_of_python_may_adjust() -> None:
    start: dict[str, Any] = {"a": 0.0, "s": [0.0, 0.0]}
    found: list[float] = []
    threads = [threading.Thread(target=lambda: found.append(solve([Plane(20_000)], start).x["a"])) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=60)
    assert len(found) == 2 and found[0] == found[1]
