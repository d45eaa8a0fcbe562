"""What is documented runs as it stands."""

from __future__ import annotations

import doctest
import importlib
import os
import pathlib
import pkgutil
import re
import subprocess
import sys

import pytest

import boresight as bs

PYTHON = pathlib.Path(__file__).parents[1]
PAGES = [PYTHON.parent / "README.md", PYTHON / "README.md", *sorted((PYTHON / "docs").glob("*.md"))]
EXAMPLES = sorted((PYTHON / "examples").glob("*.py"))
MODULES = ["boresight", *(f"boresight.{m.name}" for m in pkgutil.iter_modules(bs.__path__) if m.name not in ("_core", "__main__"))]


@pytest.mark.parametrize("name", MODULES)
def test_docstrings(name: str) -> None:
    if name.startswith("boresight._dask"):
        pytest.importorskip("distributed")
    failed, _ = doctest.testmod(importlib.import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE)
    assert failed == 0


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(PYTHON.parent)))
def test_python_blocks(page: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks of a page run one after another, in one namespace, in a folder of their own."""
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S)
    assert blocks, "no python block on this page"
    text = "\n".join(blocks)
    if ">>>" not in text:
        exec(compile(text, str(page), "exec"), {})
        return
    test = doctest.DocTestParser().get_doctest(text, {}, page.name, str(page), 0)
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS)
    runner.run(test)
    assert runner.summarize(verbose=False).failed == 0 and test.examples


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda p: p.name)
def test_examples(example: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """Each is a program and, cell by cell, a notebook: run as the latter where Jupyter is there."""
    for module in re.findall(r"^(?:import|from) (matplotlib|xarray|pandas|distributed)", example.read_text(), re.M):
        pytest.importorskip(module)
    try:
        import ipykernel  # noqa: F401
        import jupytext  # type: ignore[import-untyped]
        import nbclient
    except ImportError:
        as_program(example, tmp_path)
        return
    notebook = jupytext.read(example, fmt="py:percent")
    assert sum(cell.cell_type == "code" for cell in notebook.cells) >= 2, "a notebook of several cells"
    client = nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}})
    client.execute()
    said = [out for cell in notebook.cells for out in cell.get("outputs", []) if out.get("name") != "stderr"]
    assert said, "a notebook says something"


def as_program(example: pathlib.Path, tmp_path: pathlib.Path) -> None:
    environment = {**os.environ, "MPLBACKEND": "agg"}
    ended = subprocess.run(
        [sys.executable, str(example)], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.strip(), "an example says something"


def test_every_public_name_is_documented() -> None:
    for name in bs.__all__:
        found = getattr(bs, name)
        if name != "__version__":
            assert (found.__doc__ or "").strip(), name
    pages = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    functions = [n for n in bs.__all__ if n[0].islower() and n not in ("__version__", "adjust")]
    missing = [n for n in functions if f"{n}(" not in pages]
    assert not missing, f"not on any page: {missing}"
