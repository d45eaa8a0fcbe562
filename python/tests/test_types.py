"""The stubs say what the module has, and everything is typed."""

from __future__ import annotations

import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

import boresight as bs

PYTHON = pathlib.Path(__file__).parents[1]
if importlib.util.find_spec("mypy") is None:
    pytest.skip("mypy is not installed", allow_module_level=True)


def run(*words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", *words],
        cwd=PYTHON / "tests",
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=300,
    )


@pytest.mark.parametrize("what", ["package", "tests and examples"])
def test_everything_is_strictly_typed(what: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    cache = tmp_path_factory.getbasetemp() / "mypy"
    strict = ["mypy", "--strict", "--config-file", str(PYTHON / "pyproject.toml"), "--cache-dir", str(cache)]
    files = [*sorted((PYTHON / "tests").glob("*.py")), *sorted((PYTHON / "examples").glob("*.py"))]
    ended = run(*strict, *(["--package", "boresight"] if what == "package" else map(str, files)))
    assert ended.returncode == 0, ended.stdout + ended.stderr


def test_the_stubs_are_those_of_the_module() -> None:
    ended = run("mypy.stubtest", "boresight._core")
    assert ended.returncode == 0, ended.stdout + ended.stderr


def test_stubs_that_lie_are_found(tmp_path: pathlib.Path) -> None:
    shutil.copytree(pathlib.Path(bs.__file__).parent, tmp_path / "boresight")
    stub = tmp_path / "boresight" / "_core.pyi"
    lie = stub.read_text().replace("def read_target(path:", "def read_target(file:")
    assert lie != stub.read_text()
    stub.write_text(lie)
    ended = run("mypy.stubtest", "boresight._core", PYTHONPATH=str(tmp_path), MYPYPATH=str(tmp_path))
    assert ended.returncode != 0 and "read_target" in ended.stdout
