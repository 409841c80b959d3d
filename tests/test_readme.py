"""README's Python runs as written, and says what it prints."""

import re
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest

README = (Path(__file__).parents[1] / "README.md").read_text()


@pytest.mark.timeout(300)
def test_the_example_runs(capsys, tmp_path, monkeypatch):
    # Pictures are drawn without a screen, and left in a folder of this test.
    mpl.use("Agg")
    monkeypatch.chdir(tmp_path)
    code = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    scope: dict = {}
    for block in code:
        exec(compile(block, "README.md", "exec"), scope)  # the one place where text is run
    printed = capsys.readouterr().out
    # Mass of the stage 0.2 kg instead of the tutorial's 0.206: 945 N/m less 12 N/m under the load of 1 N.
    mass = 0.2 + 26 / 35 * 7850 * 0.018 * 0.0005 * 0.1
    expected = ((945 - 12) / mass) ** 0.5 / (2 * 3.141592653589793)
    assert float(scope["fm"].frequencies(scope["model"])[0]) == pytest.approx(expected, rel=1e-6)
    assert "78.75" in printed
    assert "force C x" in printed
    # A strut under 1.235 times its buckling load, pushed aside by a millinewton: between two rows of A2.
    tip, load = scope["path"].at("tip")[-1], 12.0 / (2.4674011003 * 0.039375 / 0.1**2)
    assert 1.1517 < load < 1.2939
    assert 0.593 < tip[0] / 0.1 < 0.72
    assert 0.559 < tip[1] / 0.1 < 0.741
    # Driven from -5 to 5 mm: the support stiffness is largest in between, near that of two leaf springs in tension.
    stiffness = 1 / scope["out"].node(3).CMglob[1, 1]
    assert stiffness.argmax() == 0
    assert stiffness[0] == pytest.approx(210e9 * 50e-3 * 0.5e-3 / 0.1, rel=0.01)
    assert scope["out"].load_factors.shape == (2, 7)
    assert "NDOF = NX - NXO - NEO = 12 - 6 - 5 = 1" in printed
    assert (tmp_path / "modes.png").stat().st_size > 1000
    plt.close("all")


def test_links_and_pictures_exist():
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert target.startswith("http") or (Path(__file__).parents[1] / target).exists(), target
