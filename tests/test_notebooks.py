"""The notebooks run from top to bottom, and the committed .ipynb files have the cells of their sources."""

import os
import subprocess
import sys
from pathlib import Path

import jupytext
import pytest

from flexmb.setup import cache_folder

ROOT = Path(__file__).parents[1]
SOURCES = sorted((ROOT / "notebooks").glob("[0-9][0-9]_*.py"))


@pytest.mark.timeout(150)
@pytest.mark.parametrize("source", SOURCES, ids=lambda s: s.stem)
def test_notebook_runs(source, tmp_path):
    # A fresh process each, since a notebook sets up JAX itself; the last cell asserts the number that it claims.
    path = os.pathsep.join(p for p in (str(ROOT), os.environ.get("PYTHONPATH")) if p)
    environment = os.environ | {
        "PYTHONPATH": path,
        "MPLBACKEND": "Agg",
        "FLEXMB_CACHE": str(cache_folder() / "tests"),
    }
    run = subprocess.run(
        [sys.executable, str(source)], env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert run.returncode == 0, run.stderr[-3000:]


@pytest.mark.parametrize("source", SOURCES, ids=lambda s: s.stem)
def test_rendered_notebook_is_that_of_its_source(source):
    rendered = jupytext.read(source.with_suffix(".ipynb"))
    written = jupytext.read(source, fmt="py:percent")
    cells = [[(cell.cell_type, cell.source) for cell in notebook.cells] for notebook in (rendered, written)]
    assert cells[0] == cells[1], f"run: python notebooks/render.py {source.name[:2]}"
    code = [cell for cell in rendered.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))
    assert "assert" in code[-1].source
