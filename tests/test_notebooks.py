"""The notebooks run from top to bottom, and the committed .ipynb files have the cells of their sources."""

import os
import runpy
import subprocess
import sys
from pathlib import Path

import jupytext
import matplotlib.pyplot as plt
import pytest

from flexmb.setup import cache_folder

ROOT = Path(__file__).parents[1]
SOURCES = sorted((ROOT / "notebooks").glob("[0-9][0-9]_*.py"))


@pytest.mark.slow
@pytest.mark.timeout(290)
@pytest.mark.filterwarnings("error::flexmb.errors.BeamTheoryWarning", "error::flexmb.errors.CoarseWarning")
@pytest.mark.parametrize("source", SOURCES[1:], ids=lambda s: s.stem)
def test_notebook_runs(source, tmp_path, monkeypatch):
    # The last cell asserts the number that it claims. In this process, which has imported everything and shares what is
    # compiled; it draws without a screen, and the cache that the notebook switches on is that of the tests.
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("FLEXMB_CACHE", str(cache_folder() / "tests"))
    plt.switch_backend("Agg")
    runpy.run_path(str(source), run_name="__main__")
    plt.close("all")


def test_first_notebook_runs_in_a_fresh_process(tmp_path):
    # One notebook shows that a process without any setting of the tests can start like this.
    path = os.pathsep.join(p for p in (str(ROOT), os.environ.get("PYTHONPATH")) if p)
    environment = os.environ | {
        "PYTHONPATH": path,
        "MPLBACKEND": "Agg",
        "FLEXMB_CACHE": str(cache_folder() / "tests"),
    }
    run = subprocess.run(
        [sys.executable, str(SOURCES[0])], env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert run.returncode == 0, run.stderr[-3000:]


@pytest.mark.slow("23_shape_lattice")
@pytest.mark.parametrize("source", SOURCES, ids=lambda s: s.stem)
def test_rendered_notebook_is_that_of_its_source(source):
    rendered = jupytext.read(source.with_suffix(".ipynb"))
    written = jupytext.read(source, fmt="py:percent")
    cells = [[(cell.cell_type, cell.source) for cell in notebook.cells] for notebook in (rendered, written)]
    assert cells[0] == cells[1], f"run: python notebooks/render.py {source.name[:2]}"
    code = [cell for cell in rendered.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))
    # The tests have double precision from the beginning; a notebook has to switch it on before it computes anything.
    assert "\nfm.enable_x64()\n" in code[0].source
    assert "assert" in code[-1].source
