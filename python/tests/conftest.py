"""What several tests share."""

from __future__ import annotations

import pathlib
import subprocess
import sys
from collections.abc import Callable

import pytest

import boresight as bs

SCENARIOS = pathlib.Path(__file__).parents[2] / "models" / "scenarios"
PROCEDURES = ("pool", "usbl", "rail", "seabed")
#: a scenario of each that takes about a second
THIN = {p: SCENARIOS / f"{'three-pass' if p == 'pool' else p}-thin.toml" for p in PROCEDURES}


def command(*words: object, check: bool = True) -> subprocess.CompletedProcess[str]:
    """The command that the package brought."""
    program = pathlib.Path(sys.executable).parent / "boresight"
    return subprocess.run([str(program), *map(str, words)], check=check, capture_output=True, text=True, timeout=300)


@pytest.fixture(scope="session")
def surveys(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], pathlib.Path]:
    """The survey file of a thin simulated survey of a procedure; the same one for every test."""
    made: dict[str, pathlib.Path] = {}

    def survey(procedure: str) -> pathlib.Path:
        if procedure not in made:
            folder = tmp_path_factory.mktemp(procedure) / "survey"
            bs.simulate(THIN[procedure], folder)
            made[procedure] = folder / "survey.toml"
        return made[procedure]

    return survey


@pytest.fixture(scope="session")
def pool(surveys: Callable[[str], pathlib.Path]) -> bs.Survey:
    """A thin pool survey in memory."""
    return bs.read_survey(surveys("pool"))


@pytest.fixture(scope="session")
def result(pool: bs.Survey) -> bs.Result:
    """Its calibration."""
    return bs.calibrate(pool)
