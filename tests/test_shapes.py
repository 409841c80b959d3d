"""Arrays are as annotations of the package say: a part of what `python -m pytest -p shapes` looks at."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
FILES = ("linear/test_linearize.py", "mechanics/test_temperature.py", "motion/test_sudden.py")


@pytest.mark.slow
def test_arrays_are_as_annotations_say():
    given = ["-p", "shapes", "--slow=out", *[str(HERE / name) for name in FILES]]
    said = subprocess.run([sys.executable, "-m", "pytest", *given], cwd=HERE.parent, capture_output=True, text=True)
    assert said.returncode == 0, said.stdout
    # One that looks at nothing finds nothing.
    assert int(re.search(r"Annotations of (\d+) functions", said.stdout)[1]) > 100
