"""What the options of the tests do."""

import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent


@pytest.mark.slow
def test_tests_that_are_too_late_are_named_and_the_order_follows_from_a_text():
    """Tests of two files: none begins, none is red, and with another text the first file would be the first."""
    files = [str(HERE / name) for name in ("test_errors.py", "test_results.py")]
    call = [sys.executable, "-m", "pytest", "--until=0", "--order=b", *files]
    found = subprocess.run(call, capture_output=True, text=True, timeout=120, cwd=HERE.parent)
    assert found.returncode == 0, found.stdout
    _, words, rest = found.stdout.partition("Left out, since it was too late to begin them: ")
    assert words
    count, *names = rest.splitlines()
    assert names[int(count)].startswith(f"{count} skipped in ")
    told = list(dict.fromkeys(name.partition("::")[0] for name in names[: int(count)]))
    assert told == ["tests/test_results.py", "tests/test_errors.py"]
