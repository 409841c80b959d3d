"""Studies in a file: placeholders, the two commands, the same numbers as in Python, one line a fault."""

import json

import jax
import numpy as np
import pytest
from typer.testing import CliRunner

import flexmb as fm
from flexmb.cli import app

GUIDE = """PLBEAM 1 1 2 3 4
PLBEAM 2 3 4 5 6
PLBEAM 3 5 6 7 8
X 1 0 0
X 3 0 {l}
X 5 0.1 {l}
X 7 {+l/2+0.05-(l-0.1)/2} 0
FIX 1
FIX 2
FIX 7
FIX 8
RLSE 1 2 3
RLSE 3 2 3
DYNX 3 1
END
HALT
XM 3 0.103
XM 5 0.103
EM 1 {7850*w*t}
EM 3 {7850*w*t}
ESTIFF 1 {210e9*w*t} {210e9*w*t**3/12}
ESTIFF 3 {210e9*w*t} {210e9*w*t**3/12}
END
END
"""
STUDY = """model = "guide.dat"
[parameters]
t = { value = 0.5e-3, lower = 0.1e-3, upper = 2e-3 }
l = 0.1
w = 0.018
[answers]
f = { frequency = 1 }
m = { mass = true }
double = "own:double"
[limits]
f = { lower = 20.0 }
[tune]
minimize = "m"
[sweep]
points = 3
"""


@pytest.fixture
def study(tmp_path):
    (tmp_path / "guide.dat").write_text(GUIDE)
    (tmp_path / "own.py").write_text(
        "import flexmb as fm\ndef double(model):\n    return 2 * fm.frequencies(model)[0]\n"
        "def guide(t):\n    return fm.read_spacar('guide.dat', numbers={'t': t})\n"
    )
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    return path


def call(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments])


def frequency(t):
    return fm.frequencies(fm.read_spacar(GUIDE, numbers={"t": t, "w": 0.018, "l": 0.1}).builder.build())[0]


def test_placeholders_may_be_traced():
    # E1; the derivative by the length goes through the geometry.
    assert frequency(0.5e-3) == pytest.approx(10.64484738, abs=5e-9)
    assert fm.jit(jax.grad(frequency))(0.5e-3) == pytest.approx(31670.0798802, rel=1e-8)


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        ("{x}", r"text:19: EM: element 1: '\{x\}' asks for 'x', but there is no parameter 'x' \(t, w, l\)"),
        ("{t+}", "is no arithmetic"),
        ("{t.real}", "numbers, parameters, pi"),
        ("{1/0}", "has no value"),
        ("{(-t)**0.5}", "must be a real number"),
        ("{__import__('os')}", "no parameter '__import__'"),
        ("{-t}", "must not be negative|negative"),
        ("2{t}", "must be a number"),
    ],
)
def test_wrong_placeholders_are_named(words, fault):
    text = GUIDE.replace("EM 1 {7850*w*t}", f"EM 1 {words}")
    with pytest.raises(fm.SpacarError, match=fault):
        fm.read_spacar(text, numbers={"t": 0.5e-3, "w": 0.018, "l": 0.1})


def test_sweep_is_that_of_python(study, tmp_path):
    result = call(
        "sweep",
        study,
        "--json",
        "-",
        "--save",
        tmp_path / "a.npz",
        "--checkpoint",
        tmp_path / "c.npz",
        "--plot",
        tmp_path / "a.svg",
    )
    assert result.exit_code == 0, result.stderr
    data = json.loads(result.stdout)
    assert data["status"] == "ok"
    assert data["results"] == ["successful"] * 3
    np.testing.assert_allclose(data["parameters"]["t"], np.linspace(0.1e-3, 2e-3, 3), rtol=1e-15)
    expected = [float(frequency(t)) for t in data["parameters"]["t"]]
    np.testing.assert_allclose(data["answers"]["f"], expected, rtol=1e-10)
    np.testing.assert_allclose(data["answers"]["double"], 2 * np.array(expected), rtol=1e-10)
    np.testing.assert_allclose(np.load(tmp_path / "a.npz")["f"], expected, rtol=1e-10)
    assert (tmp_path / "c.npz").exists()
    assert "<svg" in (tmp_path / "a.svg").read_text()
    assert call("sweep", study, "--plot", tmp_path / "a.html").exit_code == 2


def test_tune_is_that_of_python(study, tmp_path):
    result = call(
        "tune", study, "--json", tmp_path / "a.json", "--save", tmp_path / "a.mat", "--plot", tmp_path / "a.png"
    )
    assert result.exit_code == 0, result.stderr
    data = json.loads((tmp_path / "a.json").read_text())
    assert data["status"] == "ok"
    assert data["parameters"]["t"] == pytest.approx(0.764636213e-3, rel=5e-6)  # E1, from inside by the tolerance
    assert data["answers"]["f"] >= 20
    assert data["active"] == ["f (lower limit 20) is reached"]
    assert "f (lower limit 20) is reached" in result.stdout
    assert len(data["history"]["t"]) == data["evaluations"]
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_what_cannot_be_kept_is_exit_1(study):
    study.write_text(STUDY.replace("lower = 20.0", "lower = 200.0"))
    result = call("tune", study, "--json", "-")
    assert result.exit_code == 1
    data = json.loads(result.stdout)
    assert data["status"] == "infeasible"
    assert "by 58.9 %" in data["reason"]
    assert result.stderr.startswith("study.toml: infeasible")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[answers]", "[answer]", "there is no key 'answer'. Did you mean 'answers'?"),
        ("frequency = 1", "frequency = 0", "[answers] f: frequency must be a whole number"),
        ("frequency = 1", "frequenzy = 1", "[answers] f must be"),
        ("mass = true", "stiffness = '3'", "[answers] m: stiffness needs axis"),
        ("own:double", "own:triple", "cannot take 'own:triple'"),
        ("guide.dat", "guard.dat", "there is no file"),
        ("lower = 0.1e-3, upper = 2e-3", "lower = 0.1e-3", "[parameters] t: give value"),
        ("lower = 0.1e-3, upper = 2e-3", "lower = 1e-3, upper = 2e-3", "is outside its bounds"),
        ("lower = 0.1e-3, upper = 2e-3", "min = 1e-3", "there is no 'min'"),
        ('minimize = "m"', 'minimise = "m"', "there is no 'minimise'"),
        ('minimize = "m"', 'minimize = "n"', "There is no answer 'n'"),
        ("w = 0.018", "", "there is no parameter 'w'"),
        ("l = 0.1\n", "l = \n", "study.toml"),
    ],
)
def test_wrong_studies_are_one_line(study, old, new, words):
    assert old in STUDY
    study.write_text(STUDY.replace(old, new))
    result = call("tune", study)
    assert result.exit_code == 2, result.stdout
    assert words in result.stderr
    assert "Traceback" not in result.stderr
    assert result.stdout == ""
