"""README's Python runs as written, and says what it prints."""

import re
from pathlib import Path

import pytest

README = (Path(__file__).parents[1] / "README.md").read_text()


def test_the_example_runs(capsys):
    code = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    assert len(code) == 1
    scope: dict = {}
    exec(compile(code[0], "README.md", "exec"), scope)  # the one place where text is run
    printed = capsys.readouterr().out
    # Mass of the stage 0.2 kg instead of the tutorial's 0.206: 945 N/m less 12 N/m under the load of 1 N.
    mass = 0.2 + 26 / 35 * 7850 * 0.018 * 0.0005 * 0.1
    expected = ((945 - 12) / mass) ** 0.5 / (2 * 3.141592653589793)
    assert float(scope["fm"].frequencies(scope["model"])[0]) == pytest.approx(expected, rel=1e-6)
    assert "78.75" in printed
    assert "force C x" in printed
    assert "NDOF = NX - NXO - NEO = 12 - 6 - 5 = 1" in printed


def test_links_and_pictures_exist():
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert target.startswith("http") or (Path(__file__).parents[1] / target).exists(), target
