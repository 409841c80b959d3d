"""The command line: exit status, JSON keys, one line a fault, nothing written by half."""

import json
import os
import re
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from cases.commands import command as call
from cases.disk import full, not_regular
from cases.files import arrays_of
from cases.tolerances import approx

import flexmb as fm
from flexmb import cli
from flexmb.answers import answers
from flexmb.answers.mode import ModeResult
from flexmb.errors import warn
from flexmb.files import check_writable, write_whole
from flexmb.mechanisms import mechanism_path, mechanisms

ALWAYS = {"model", "mode", "flexmb", "status", "message", "warnings", "nx", "ne", "nxo", "neo", "ndof", "dofs"}
STATE = {"x", "e", "sig", "reactions", "m0", "c0", "d0", "k0", "n0", "g0", "stable"}
MOTION = {"x", "time", "trajectory", "velocities", "energy"}
SECOND_ORDER = {"m0", "c0", "d0", "k0", "n0", "g0"}
KEYS = {
    0: {"overconstraints", "underconstraints", "mobility"},
    1: MOTION,
    4: MOTION | {"inputs", "outputs", "steps", "u0", "y0"},
    10: {"x", "e", "sig", "reactions", "stable", "path", "critical_points"},
    7: STATE | {"eigenvalues", "frequencies_hz", "massless", "modes"},
    8: STATE | {"load_multipliers", "modes", "compliance"},
    2: {"x", "time", "trajectory", "velocities", "inputs", "outputs", "u0", "y0"},
    9: STATE | {"A", "B", "C", "D", "inputs", "outputs", "poles"},
}


INSIDE = {
    ("steps", 4): {"time", "frequencies_hz", "A", "B", "C", "D"} | SECOND_ORDER,
    ("path", 10): (STATE | {"load_factor", "eigenvalues", "frequencies_hz", "load_multipliers", "compliance"}),
}


def program(*arguments, **options):
    """The program as a process of its own."""
    options = {"capture_output": True, "check": False, "timeout": 200, **options}
    return subprocess.run([sys.executable, "-m", "flexmb", *map(str, arguments)], **options)


def answer(name, mode, *options):
    result = call("run", mechanism_path(name), "--mode", mode, "--json", "-", *options)
    return result, json.loads(result.stdout)


@pytest.mark.slow("7", "8", "9", "10")
@pytest.mark.parametrize("mode", [0, 7, 8, 9, 10])
def test_json_has_the_keys_of_the_contract(mode):
    result, data = answer("pf2db", mode)
    assert result.exit_code == 0
    assert set(data) >= ALWAYS | KEYS[mode]
    assert data["status"] == "ok"
    assert data["dofs"] == [{"kind": "x", "of": 3, "component": 1}]
    assert (data["nx"], data["nxo"], data["neo"], data["ndof"]) == (12, 6, 5, 1)
    for step in data.get("path", ()):
        assert set(step) >= INSIDE["path", 10]


# A mass on a spring with damper, 945 N/m, 0.0365 N s/m and 0.206 kg + 0.01413 kg/3, let go at 10 mm.
SWING = """TIMESTEP 0.02 4
STARTDX 2 1 0.11
END
HALT
INPUTF 1 2 1"""


@pytest.fixture
def swing(tmp_path, monkeypatch):
    """Writes the file, with other lines where asked; all its motions are one structure and end after 50 steps."""
    monkeypatch.setattr("flexmb.answers.mode_1_simulate.simulate", partial(fm.simulate, max_steps=50))

    def write(**lines):
        text = mechanism_path("pf1dtrx").read_text().replace("XF 2 1\n", "")
        text = re.sub("END\nHALT\n+INPUTF 1 2 1", SWING, text)
        for keyword, line in lines.items():
            text, count = re.subn(f"(?m)^{keyword} .*$", f"{keyword} {line}", text)
            assert count == 1
        path = tmp_path / "swing.dat"
        path.write_text(text)
        return path

    return write


@pytest.mark.slow
@pytest.mark.parametrize("mode", [1, 4])
def test_json_of_a_motion(mode, swing):
    path = swing()
    result = call("run", path, "--mode", mode, "--json", "-")
    data = json.loads(result.stdout)
    assert (result.exit_code, data["status"], data["warnings"]) == (0, "ok", [])
    assert set(data) >= ALWAYS | KEYS[mode]
    m, d, k = 0.206 + 0.01413 / 3, 0.0365, 945.0
    w, a, t = np.sqrt(k / m - (d / m / 2) ** 2), d / m / 2, np.array(data["time"])
    expected = 0.1 + 0.01 * np.exp(-a * t) * (np.cos(w * t) + a / w * np.sin(w * t))
    # Ten times the default relative tolerance, 1e-5 of the displacement.
    np.testing.assert_allclose([x for x, _ in data["trajectory"]["2"]], expected, atol=1e-6)
    for step in data.get("steps", ()):
        assert set(step) >= INSIDE["steps", 4]
        np.testing.assert_allclose(step["A"], [[0, 1], [-k / m, -d / m]], rtol=1e-5, atol=1e-12)
        np.testing.assert_allclose(step["B"], [[0], [1 / m]], rtol=1e-5)
        assert (step["C"], step["D"]) == ([[1, 0]], [[0]])
        np.testing.assert_allclose(step["frequencies_hz"], [np.sqrt(k / m) / (2 * np.pi)], rtol=1e-5)
        np.testing.assert_allclose((step["m0"], step["d0"], step["k0"]), [[[m]], [[d]], [[k]]], rtol=1e-5)
    velocity = -0.01 * k / m / w * np.exp(-a * t) * np.sin(w * t)
    # The rate is as accurate as the displacement, times the frequency.
    np.testing.assert_allclose([v for v, _ in data["velocities"]["2"]], velocity, atol=1e-6 * w)
    x, energy = expected - 0.1, {name: np.array(e) for name, e in data["energy"].items()}
    np.testing.assert_allclose(energy["elastic"], k * x**2 / 2, atol=k * 0.01 * 1e-6)
    np.testing.assert_allclose(energy["kinetic"], m * velocity**2 / 2, atol=m * 0.01 * w * 1e-6 * w)
    # What the terminal shows is the same to six digits, sign and all.
    lines = call("run", path, "--mode", mode).stdout.splitlines()
    assert "motion from 0 to 0.02 s, 5 output times; at the end:" in lines
    (end,) = (line.split()[2:] for line in lines if line.startswith("  node 2 "))
    np.testing.assert_allclose([float(word) for word in end], [expected[-1], 0], atol=2e-6)
    (total,) = (line for line in lines if line.startswith("energy [J] at start and end: "))
    start, end = (float(word) for word in total.rpartition(": ")[2].split(", "))
    assert start == approx(k * 0.01**2 / 2, rel=1e-5, abs=0)
    assert end == approx((k * x[-1] ** 2 + m * velocity[-1] ** 2) / 2, rel=2e-4, abs=0)
    hertz = [line.rpartition(": ")[2] for line in lines if line.startswith("frequencies [Hz] at ")]
    np.testing.assert_allclose([float(word) for word in hertz], [10.6584] * (2 if mode == 4 else 0), atol=5e-5)
    if mode == 4:
        assert (data["inputs"], data["outputs"], len(data["steps"])) == (["force 2.1"], ["position 2.1"], 5)
        assert (data["u0"], data["y0"]) == ([[0.0]] * 5, [[x] for x, _ in data["trajectory"]["2"]])


@pytest.mark.slow
def test_json_of_a_trajectory(tmp_path):
    """Of mode 2; what modes 3, 5 and 6 have beside that stands in tests/answers."""
    path, saved, picture = tmp_path / "arm.dat", tmp_path / "arm.npz", tmp_path / "arm.png"
    path.write_text(mechanism_path("manipulator").read_text().replace("TIMESTEP 1 100", "TIMESTEP 1 40"))
    result = call("run", path, "--mode", "2", "--json", "-", "--save", saved, "--plot", picture)
    data = json.loads(result.stdout)
    assert (result.exit_code, data["status"], data["warnings"]) == (0, "ok", [])
    assert set(data) >= ALWAYS | KEYS[2]
    assert {key: np.shape(data[key]) for key in ("time", "u0", "y0")} == {"time": (41,), "u0": (41, 2), "y0": (41, 4)}
    with np.load(saved) as arrays:
        np.testing.assert_array_equal(arrays["u0"], data["u0"])
    assert picture.stat().st_size > 5000


# Model, key and what the tutorial prints; tolerance half a unit of the last printed digit.
PRINTED = [
    ("pf1dtrx", "frequencies_hz", [10.6584], 5e-5),
    ("pf1dtre", "frequencies_hz", [10.6584], 5e-5),
    ("pf2d", "frequencies_hz", [10.6448], 5e-5),
    ("pf2db", "load_multipliers", [78.75], 5e-5),
    ("pf2d3dof", "frequencies_hz", [10.6, 2129.0], 0.05),
    ("pf3d", "frequencies_hz", [10.6464], 5e-5),
    # Modes 2, 3 and 5 went into a fit of the cut's place, mode 4 is a true test (T6).
    ("pf3d19dof", "frequencies_hz", [None, 148.5680, 252.1481, 270.9347, 619.9492], 5e-5 * 252),
]


@pytest.mark.slow(
    "pf1dtrx-frequencies_hz-values0-5e-05",
    "pf1dtre-frequencies_hz-values1-5e-05",
    "pf2d-frequencies_hz-values2-5e-05",
    "pf2d3dof-frequencies_hz-values4-0.05",
    "pf3d-frequencies_hz-values5-5e-05",
    "pf3d19dof-frequencies_hz-values6-0.0126",
    "pf2db-load_multipliers-values3-5e-05",
)
@pytest.mark.parametrize(("name", "key", "values", "tolerance"), PRINTED)
def test_printed_numbers(name, key, values, tolerance):
    _, data = answer(name, 8 if key == "load_multipliers" else 7)
    for found, printed in zip(data[key], values, strict=False):
        if printed is not None:
            assert found == approx(printed, abs=tolerance, rel=5e-5 if name == "pf3d19dof" else 0)


# Rows of A and B that the tutorial prints, half a unit of the last digit.
STATE_SPACE = [
    ("pf1dtrx", (-4485, 0.5), (-0.1732, 5e-5), (4.746, 5e-4), [[1, 0]]),
    ("pf1dtre", (-4485, 0.5), (-0.1732, 5e-5), (4.746, 5e-4), [[1, 0]]),
    ("pf2d", (-4473, 0.5), (-0.6021, 5e-5), (4.734, 5e-4), [[1, 0], [0, 0], [1, 0], [0, 0], [0, 0], [0, 0]]),
    ("pf3d", (-4475, 0.5), (-0.6023, 5e-5), (4.735, 5e-4), [[0, 0], [1, 0], [0, 0], [0, 0], [1, 0], [0, 0]]),
]


@pytest.mark.slow("pf1dtre-a211-a221-b21-c1", "pf2d-a212-a222-b22-c2", "pf3d-a213-a223-b23-c3")
@pytest.mark.parametrize(("name", "a21", "a22", "b2", "c"), STATE_SPACE)
def test_printed_state_space(name, a21, a22, b2, c):
    _, data = answer(name, 9)
    assert data["A"][1][0] == approx(a21[0], abs=a21[1])
    assert data["A"][1][1] == approx(a22[0], abs=a22[1])
    assert abs(data["B"][1][0]) == approx(b2[0], abs=b2[1])
    np.testing.assert_allclose(data["C"], c, atol=1e-9)
    np.testing.assert_allclose(data["D"], np.zeros((len(c), 1)), atol=1e-12)
    # One oscillator: the poles follow from A.
    assert np.hypot(*data["poles"][0]) ** 2 == approx(-data["A"][1][0], rel=1e-9)
    # It is damped, so that frequencies come with poles too.
    np.testing.assert_allclose(answer(name, 7)[1]["poles"], data["poles"], rtol=1e-9)


def test_overconstrained_guide_is_reported_refused_and_released_on_request(tmp_path):
    result, data = answer("pf3dover", 0)
    assert (result.exit_code, data["status"], data["overconstraints"]) == (0, "overconstrained", 1)
    involved = {d["element"] for d in data["mobility"][0]["deformations"]}
    assert {1, 3} <= involved
    result, data = answer("pf3dover", 7)
    assert (result.exit_code, data["status"]) == (1, "overconstrained")
    assert result.stderr.count("\n") == 1
    advice = re.search("release deformation . of element '.': (RLSE . .)$", data["message"], re.MULTILINE)
    assert advice is not None
    result, data = answer("pf3dover", 7, "--release", "auto")
    assert result.exit_code == 0
    assert data["frequencies_hz"][0] == approx(10.6464, abs=5e-5)
    # The advice is a line that the file takes.
    path = tmp_path / "released.dat"
    path.write_text(mechanism_path("pf3dover").read_text().replace("\nDYNX", f"\n{advice[1]}\nDYNX", 1))
    assert json.loads(call("check", path, "--json", "-").stdout)["status"] == "ok"


def test_load_up_buckles_the_other_way(tmp_path):
    text = mechanism_path("pf2db").read_text()
    path = tmp_path / "up.dat"
    path.write_text(re.sub(r"(?m)^XF 3 .*$", "XF 3 0 1", text))
    result = call("run", path, "--mode", "8", "--json", "-")
    assert json.loads(result.stdout)["load_multipliers"][0] == approx(-78.75, abs=5e-5)


TRUSS = """PLTRUSS 1 1 2
X 1 0 0
X 2 0.1 0
{kinematics}
RLSE 1 1
END
HALT
XM 2 0.206
ESTIFF 1 94.5
END
END
"""


def written(tmp_path, kinematics):
    path = tmp_path / "truss.dat"
    path.write_text(TRUSS.replace("{kinematics}", kinematics))
    return path


def test_right_count_but_a_degree_of_freedom_without_stiffness(tmp_path):
    # Tutorial 2.1: y of node 2 as degree of freedom, its x held: counts agree, nothing holds y.
    path = written(tmp_path, "FIX 1\nFIX 2 1\nDYNX 2 2")
    result = call("run", path, "--mode", "7", "--json", "-")
    data = json.loads(result.stdout)
    assert result.exit_code == 0
    assert data["stable"] is False
    assert any("2.y" in warning for warning in data["warnings"])
    assert data["eigenvalues"][0] == approx(0, abs=1e-9)


@pytest.mark.parametrize(
    ("kinematics", "code", "words"),
    [
        ("FIX 1\nFIX 2 2", "underconstrained", "NDOF = 1, but 0"),
        ("FIX 1\nDYNX 2 1", "underconstrained", "NDOF = 2, but 1"),
    ],
)
def test_wrong_counts(tmp_path, kinematics, code, words):
    result = call("run", written(tmp_path, kinematics), "--mode", "7", "--json", "-")
    data = json.loads(result.stdout)
    assert (result.exit_code, data["status"]) == (1, code)
    assert words in data["message"]
    assert result.stderr.startswith(f"truss.dat: {code}")
    assert "Traceback" not in result.stderr


@pytest.mark.slow
def test_files_appear_whole_or_not_at_all(tmp_path):
    out, saved, log = tmp_path / "a.json", tmp_path / "a.npz", tmp_path / "a.log"
    result = call("run", mechanism_path("pf2d"), "--mode", "7", "--json", out, "--save", saved, "--log", log)
    assert result.exit_code == 0
    data = json.loads(out.read_text())
    arrays = arrays_of(saved)
    np.testing.assert_allclose(arrays["frequencies_hz"], data["frequencies_hz"])
    np.testing.assert_allclose(arrays["x_3"], data["x"]["3"])
    text = log.read_text()
    for heading in ("INPUT", "ELEMENTS", "NODES", "DEGREES OF FREEDOM", "NXO", "TOTAL MASS", "TRANSFER FUNCTIONS"):
        assert heading in text
    mat = tmp_path / "a.mat"
    picture = tmp_path / "a.pdf"
    assert call("run", mechanism_path("pf2d"), "--mode", "9", "--save", mat, "--plot", picture).exit_code == 0
    assert mat.stat().st_size > 0
    assert picture.read_bytes().startswith(b"%PDF")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.json", "a.log", "a.mat", "a.npz", "a.pdf"]
    refused = call("run", mechanism_path("pf2d"), "--mode", "7", "--json", tmp_path / "none" / "b.json")
    assert refused.exit_code == 2
    assert "does not exist" in refused.stderr


# What is wrong with a call, and what its one line on standard error says. Files are made by `workplace`.
MISUSED = {
    "": "flexmb: Give a command (flexmb --help).",
    "sweet": "flexmb: No such command 'sweet'. Did you mean 'sweep'? (flexmb --help).",
    "--nope": "flexmb: No such option: --nope (flexmb --help).",
    "edit none.dat --no-browser": "flexmb edit: cannot read 'none.dat': No such file or directory.",
    "fmu guide.dat": "flexmb fmu: Missing option '--to' (flexmb fmu --help).",
    "fmu guide.dat --to guide.zip": "flexmb fmu: --to writes .fmu, not 'guide.zip'.",
    "fmu guide.dat --to none/guide.fmu": "the folder of 'none/guide.fmu' does not exist",
    "fmu guide.dat --to guide.fmu --fmi 1": "flexmb fmu: --fmi takes 3 or 2, not '1'.",
    "fmu guide.dat --to guide.fmu --mode 7": "there is no unit of mode '7'. Available: 9 (linear)",
    "fmu guide.dat --to guide.fmu --mode 4": "guide.dat: TIMESTEP: modes 1 and 4 need it",
    "fmu thick.dat --to guide.fmu": "{m}",
    "verdict guide.dat": "flexmb verdict: Missing option '--stroke' (flexmb verdict --help).",
    "verdict guide.dat --stroke wide": "flexmb: --stroke takes [NAME=]NUMBER, such as 3.x=5e-3",
    "verdict guide.dat --stroke 1e-3 --limit force": "flexmb: --limit takes NAME=NUMBER, such as force=2",
    "verdict guide.dat --stroke 1e-3 --limit force=4 --limit force=100": "--limit gives 'force' twice; give it once",
    "verdict guide.dat --stroke 3.x=-1": "Argument `stroke` must be positive",
    "verdict guide.dat --stroke 99.x=1e-3": "There is no coordinate or deformation '99.x' to drive",
    "verdict guide.dat --stroke 3.q=1e-3": "There is no coordinate or deformation '3.q' to drive. Did you mean '3.",
    "verdict guide.dat --stroke 1.x=1e-3": "Stroke '1.x' is fixed in this model",
    "verdict guide.dat --stroke 1e-3 --limit farce=1": "Limit of 'farce': there is no such curve. There are: force",
    "verdict guide.dat --stroke 1e-3 --plot page.gif": "--plot writes .png, .svg or .pdf, not 'page.gif'.",
    "run": "flexmb run: Missing argument 'MODEL.dat' (flexmb run --help).",
    "run guide.dat": "give one of --mode and --analysis",
    "run guide.dat --mode": "Option '--mode' requires an argument",
    "run guide.dat --mode 7 --nope": "No such option: --nope",
    "run guide.dat guide.dat --mode 7": "Got unexpected extra argument(s) (guide.dat)",
    "run guide.dat --mode 7 --analysis buckling": "give one of --mode and --analysis",
    "run guide.dat --mode 7 --mode 7": "--mode is given twice; give it once",
    "run guide.dat --mode 7 --json a.json --json b.json": "--json is given twice; give it once",
    "run guide.dat --mode 77": "there is no mode '77'. Available: 0 (mobility), 1 (simulate)",
    "run guide.dat --mode --7": "there is no mode '--7'",
    "run guide.dat --mode \u00b2": "there is no mode '\u00b2'",
    "run guide.dat --mode 7.0": "there is no mode '7.0'",
    "run guide.dat --mode seven\x1b[31m": r"there is no mode 'seven\x1b[31m'",
    "run guide.dat --mode 2": "guide.dat: TRAJX: mode 2 needs a trajectory: TRAJX node coordinate start end value",
    "run guide.dat --analysis superposition": "guide.dat: TRAJX: mode 6 needs a trajectory",
    "run nowhere.dat --mode 7": "flexmb: cannot read 'nowhere.dat': No such file or directory.",
    "run folder.dat --mode 7": "flexmb: cannot read 'folder.dat': Is a directory.",
    "run guide.dat/x --mode 7": "flexmb: cannot read 'guide.dat/x': Not a directory.",
    "run empty.dat --mode 7": "empty.dat:1: file is empty",
    "run utf16.dat --mode 7": "utf16.dat:1: the file is in UTF-16; save it as UTF-8",
    "run guide.dat --mode 7 --release all": "--release takes auto or none, not 'all'",
    "run guide.dat --mode 7 --save a.txt": "--save writes .npz or .mat, not 'a.txt'",
    "run guide.dat --mode 7 --plot a.eps": "--plot writes .png, .svg, .pdf or .html, not 'a.eps'",
    "run guide.dat --mode 10 --max-steps 0": "Invalid value for '--max-steps'",
    "run guide.dat --mode 10 --max-steps 1e3": "Invalid value for '--max-steps'",
    "run guide.dat --mode 10 --max-steps 999999999": "Input should be less than or equal to 100000",
    "run guide.dat --mode 7 --json none/a.json": "the folder of 'none/a.json' does not exist",
    "run guide.dat --mode 7 --json folder.dat": "flexmb: cannot write 'folder.dat': Is a directory.",
    "run guide.dat --mode 7 --json guide.dat": "--json would write over the input file: 'guide.dat'",
    "run guide.dat --mode 7 --log link.dat": "--log would write over the input file: 'link.dat'",
    "run guide.dat --mode 7 --log a.json --json ./a.json": "--log would write over --json: 'a.json'",
    "run guide.dat --mode 7 --log -": "--log writes a file, not '-'",
    "run guide.dat --mode 7 --json /proc/a.json": "cannot write '/proc/a.json'",
    "run guide.dat --mode 7 --json /dev/full": "cannot write '/dev/full': No space left on device.",
    "run guide.dat --mode 7 --log /dev/full": "cannot write '/dev/full': No space left on device.",
    "run guide.dat --mode 7 --save full.npz": "cannot write 'full.npz': No space left on device.",
    "run guide.dat --mode 7 --plot full.svg": "cannot write 'full.svg': No space left on device.",
    "run guide.dat --mode 7 --set": "Option '--set' requires an argument",
    "run guide.dat --mode 7 --set t=1": "--set t: guide.dat has no {t}; it has: none.",
    "run thick.dat --mode 7": "thick.dat:25: XM: node 3: '{m}' asks for 'm', but there is no parameter 'm'",
    "run thick.dat --mode 7 --set m": "--set takes NAME=NUMBER, such as t=0.5e-3, not 'm'",
    "run thick.dat --mode 7 --set =1": "--set takes NAME=NUMBER, such as t=0.5e-3, not '=1'",
    "run thick.dat --mode 7 --set m=": "--set m: value must be a number, but is ''",
    "run thick.dat --mode 7 --set m=abc": "--set m: value must be a number, but is 'abc'",
    "run thick.dat --mode 7 --set m=1_0": "--set m: value must be a number, but is '1_0'",
    "run thick.dat --mode 7 --set m=nan": "--set m: value must be a finite number, but is 'nan'",
    "run thick.dat --mode 7 --set m=1e999": "--set m: value must be a finite number, but '1e999' is too large",
    "run thick.dat --mode 7 --set m=1 --set m=2": "--set gives 'm' twice; give it once",
    "run thick.dat --mode 7 --set m=1 --set q=2": "--set q: thick.dat has no {q}; it has: {m}.",
    "run round.dat --mode 7 --set t=1": "--set t: round.dat has no {t}; it has: none.",
    "run round.dat --mode 7 --set pi=3": "--set pi: {pi} is 3.14159.. in every file; give the parameter another name.",
    "run guide.dat --mode 1": "guide.dat: TIMESTEP: modes 1 and 4 need it",
    "run endless.dat --mode 1": "endless.dat:26: TIMESTEP: 999999999 steps of 46 numbers take 1.38e+13 bytes",
    "check guide.dat --mode 7": "No such option: --mode",
    "check nowhere.dat": "cannot read 'nowhere.dat'",
    "demo nothing": "no mechanism 'nothing'. Shipped: elevator",
    "demo pf3d pf2d": "Got unexpected extra argument(s) (pf2d)",
    "demo --list pf3d": "--list takes neither a mechanism nor --to",
    "demo --to nowhere": "the folder 'nowhere' does not exist",
    "demo --to guide.dat": "the folder 'guide.dat' does not exist",
    "demo pf3d --to taken": "'taken/pf3d.dat' is there already and differs; move it away first",
}


@pytest.fixture
def workplace(tmp_path, monkeypatch):
    """A folder with what the calls of MISUSED name."""
    text = mechanism_path("pf2d").read_text()
    (tmp_path / "guide.dat").write_text(text)
    (tmp_path / "link.dat").symlink_to("guide.dat")
    (tmp_path / "empty.dat").write_text("")
    (tmp_path / "utf16.dat").write_text(text, encoding="utf-16")
    (tmp_path / "thick.dat").write_text(re.sub("(?m)^XM 3 .*$", "XM 3 {m}", text))
    (tmp_path / "round.dat").write_text(re.sub("(?m)^XM 3 .*$", "XM 3 {pi/30}", text))
    (tmp_path / "endless.dat").write_text(re.sub("(?m)^(XM 3 .*)$", r"\1\nTIMESTEP 1 999999999", text))
    (tmp_path / "folder.dat").mkdir()
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "pf3d.dat").write_text("% mine\n")
    for name in ("full.npz", "full.svg"):
        (tmp_path / name).symlink_to("/dev/full")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow("verdict guide.dat --stroke 1e-3 --limit farce=1")
@pytest.mark.parametrize("line", MISUSED)
def test_a_wrong_call_is_one_line(line, workplace):
    before = {path: path.read_bytes() for path in sorted(workplace.rglob("*")) if path.is_file()}
    result = call(*line.split(" ")) if line else call()
    assert result.exit_code == 2
    assert MISUSED[line] in result.stderr
    assert result.stderr.endswith("\n")
    assert result.stderr[:-1].isprintable()
    # Without a command the help is shown.
    assert bool(result.stdout) is (not line)
    assert {path: path.read_bytes() for path in sorted(workplace.rglob("*")) if path.is_file()} == before


@pytest.mark.parametrize("command", ["", "run", "check", "verdict", "demo", "sweep", "tune", "robustness", "fit"])
@pytest.mark.parametrize("option", ["-h", "--help"])
def test_help(command, option):
    result = call(*command.split(), option)
    assert (result.exit_code, result.stderr) == (0, "")
    assert "Usage: flexmb" in result.stdout


@pytest.mark.slow
def test_a_verdict_is_that_of_the_package(tmp_path):
    text, path = mechanism_path("pf2db").read_text(), tmp_path / "guide.dat"
    path.write_text(text.replace("0.039375", "{EI}"))
    more = ("--stroke", "3.x=1e-3", "--limit", "force=0.5", "--set", "EI=0.039375")
    result = call("verdict", path, *more, "--json", "-", "--plot", tmp_path / "page.svg")
    assert (result.exit_code, result.stderr) == (0, "")
    data = json.loads(result.stdout)
    # 24 EI/L^3 less what the load of 1 N takes, 6/5 of it over the length.
    stiffness = 24 * 0.039375 / 0.1**3 - 1.2 / 0.1
    assert data["curves"]["drive stiffness"][4] == approx(stiffness, rel=1e-6)
    assert data["limits"][0]["name"] == "force"
    assert abs(data["limits"][0]["stroke"]) == approx(0.5 / stiffness, rel=1e-4)
    assert data["sensitivities"]["force"]["EI"] == approx(945 / stiffness, rel=1e-4)
    assert (data["status"], data["good"]) == ("ok", False)
    assert "stress" in data["unanswered"]
    assert (tmp_path / "page.svg").read_text().startswith("<?xml")
    told = call("verdict", path, "--stroke", "1e-3", "--limit", "frequency 1=11", "--set", "EI=0.039375").stdout
    assert told.startswith("Verdict on 3.x, -1 mm to 1 mm: frequency 1 limits it to 0 m\n")
    # Half of what the stiffness grows by.
    assert "larger EI (+0.506): percent of frequency 1 for one percent" in told


def test_a_coordinate_by_its_number_is_shown_by_its_name(tmp_path):
    path = tmp_path / "guide.dat"
    path.write_text(mechanism_path("pf2db").read_text())
    result = call("verdict", path, "--stroke", "3.1=1e-3")
    assert result.exit_code == 2
    assert "no coordinate or deformation '3.1' to drive. Did you mean '3.x'?" in result.stderr
    for none in ("3.9", "3.\u00b2"):
        assert "to drive. " in call("verdict", path, "--stroke", f"{none}=1e-3").stderr


def test_a_verdict_that_cannot_be_has_a_status():
    result = call("verdict", mechanism_path("pf3dover"), "--stroke", "1e-3", "--json", "-")
    assert (result.exit_code, json.loads(result.stdout)["status"]) == (1, "overconstrained")
    result = call("verdict", mechanism_path("pf2db"), "--stroke", "3.y=1e-3")
    assert (result.exit_code, result.stdout) == (1, "")
    assert "no motion of the undeformed mechanism moves it. These move: 3.x, 5.x." in result.stderr


def test_version():
    result = call("--version")
    assert (result.exit_code, result.stdout) == (0, f"flexmb {fm.__version__}\n")
    code = "import sys\nfrom flexmb.cli import app\ntry: app(['--version'])\nfinally: print('jax' in sys.modules)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.split("\n")[1] == "False"


@pytest.mark.slow
def test_a_path_of_too_few_steps_says_so():
    result, data = answer("pf2db", 10, "--max-steps", "1")
    assert (result.exit_code, data["status"]) == (1, "max_steps")
    assert 0 < data["path"][-1]["load_factor"] < 1


def test_steps_that_belong_to_no_path_are_told_to_do_nothing():
    assert answer("pf2db", 0, "--max-steps", "1")[1]["warnings"] == [
        "The largest number of steps (1) applies to a path, mode 10: it has no effect here."
    ]


def test_numbers_of_parameters(workplace):
    told = call("run", "thick.dat", "--mode", "7", "--set", "m=0.103", "--json", "-")
    plain = call("run", "guide.dat", "--mode", "7", "--json", "-")
    assert told.exit_code == plain.exit_code == 0
    assert json.loads(told.stdout)["eigenvalues"] == json.loads(plain.stdout)["eigenvalues"]
    assert call("check", "thick.dat", "--set", "m=1D-1").exit_code == 0
    assert call("check", "thick.dat").exit_code == 2


def test_the_demo_is_copied_again(tmp_path):
    assert [call("demo", "pf3d", "--to", tmp_path).exit_code for _ in range(2)] == [0, 0]
    assert [path.name for path in tmp_path.iterdir()] == ["pf3d.dat"]


def test_an_interrupt_is_one_line(monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(answers, "answer", interrupted)
    result, told = call("run", mechanism_path("pf2d"), "--mode", "7"), "flexmb: interrupted from the keyboard; "
    assert (result.exit_code, result.stdout, result.stderr) == (130, "", told + "nothing is kept.\n")


def test_an_interrupted_call_says_what_it_keeps(monkeypatch, tmp_path, workplace):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    # Of a run, what is written before; of a sweep, its checkpoint.
    with monkeypatch.context() as late:
        late.setattr("flexmb.answers.tables.log", interrupted)
        result = call("run", "guide.dat", "--mode", "0", "--json", "a.json", "--log", "a.log")
    assert (result.exit_code, result.stderr) == (130, "flexmb: interrupted from the keyboard; 'a.json' is written.\n")
    assert not Path("a.log").exists()
    study = (
        'model = "thick.dat"\n[answers]\nf = { frequency = 1 }\n[parameters]\nm = { value = 1, lower = 1, upper = 2 }\n'
    )
    Path("study.toml").write_text(study, encoding="utf-8")
    monkeypatch.setattr("flexmb.design.study.Study.sweep", interrupted)
    for more, told in (
        ((), "nothing is kept: --checkpoint FILE keeps the designs that are done"),
        (("--checkpoint", "c"), "'c' keeps the designs that are done; the same command goes on from them"),
    ):
        result = call("sweep", "study.toml", *more)
        assert (result.exit_code, result.stderr) == (130, f"flexmb: interrupted from the keyboard; {told}.\n")


def test_a_fault_nobody_foresaw_is_one_line(monkeypatch):
    def surprised(*_, **__):
        raise RuntimeError("\x1b[31m\nand more")

    monkeypatch.setattr(answers, "answer", surprised)
    result = call("run", mechanism_path("pf2d"), "--mode", "7")
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr == "flexmb: RuntimeError: \\x1b[31m (--debug shows where)\n"


@pytest.mark.parametrize(
    ("words", "number"),
    [
        ("--mode 7", 7),
        ("--mode -10", 10),
        ("--mode buckling", 8),
        ("--analysis path", 10),
        ("--analysis simulate-linearise", 4),
        ("--analysis mobility", 0),
    ],
)
def test_modes_by_number_and_by_name(words, number, monkeypatch):
    def asked(builder, name, mode, *_, **__):
        raise RuntimeError(f"mode {mode}")

    monkeypatch.setattr(answers, "answer", asked)
    result = call("run", mechanism_path("pf2d"), *words.split())
    assert result.stderr == f"flexmb: RuntimeError: mode {number} (--debug shows where)\n"


@pytest.mark.parametrize("command", ["check", "demo", "sweep", "tune", "robustness", "fit"])
def test_the_same_of_every_command(command, monkeypatch, tmp_path):
    def surprised(*_, **__):
        raise RuntimeError("surprise")

    monkeypatch.setattr(answers, "answer", surprised)
    monkeypatch.setattr("flexmb.design.study_file.read_study", surprised)
    monkeypatch.setattr("flexmb.identification.fit_study.read_fit_study", surprised)
    monkeypatch.chdir(tmp_path)
    given = {"check": [mechanism_path("pf2d")], "demo": ["pf2d"]}.get(command, [tmp_path / "study.toml"])
    result = call(command, *given)
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr == "flexmb: RuntimeError: surprise (--debug shows where)\n"
    with pytest.raises(RuntimeError, match="surprise"):
        call(command, *given, "--debug", catch_exceptions=False)


@pytest.mark.parametrize(
    ("name", "status"), [("pf3d", "ok"), ("pf3dover", "overconstrained"), ("loose", "underconstrained")]
)
def test_check_is_mode_0(name, status, tmp_path):
    """WA 1239 (2012), 4.3: two whole leaf springs in space hold one rotation twice."""
    path = tmp_path / "loose.dat"
    path.write_text(mechanism_path("pf2d").read_text().replace("FIX 7\n", ""))
    path = path if name == "loose" else mechanism_path(name)
    result = call("check", path, "--json", "-")
    data = json.loads(result.stdout)
    assert (result.exit_code, data["mode"], data["status"]) == (0, 0, status)
    assert data == json.loads(call("run", path, "--mode", "0", "--json", "-").stdout)
    assert data["overconstraints"] == (name == "pf3dover")
    assert (data["underconstraints"] > 0) == (name == "loose")
    assert call("check", path).stdout.startswith(f"{path.name}  mode 0  status {status}\n")


@pytest.mark.slow
@pytest.mark.parametrize("mode", [1, 4])
def test_a_motion_that_ends_early_is_no_answer(mode, swing):
    # A hundred times as long.
    result = call("run", swing(TIMESTEP="2 4"), "--mode", mode, "--json", "-")
    data = json.loads(result.stdout)
    assert (result.exit_code, data["status"]) == (1, "motion_unfinished")
    assert result.stderr.startswith("swing.dat: motion_unfinished: ")
    assert 1 <= len(data["time"]) < 5


def test_an_answer_that_is_not_finite_is_none(monkeypatch):
    data = {"x": {"1": [0.0, np.nan]}, "stable": True}
    other = answers.mode_of(7)._replace(run=lambda _: ModeResult(data))
    monkeypatch.setattr(answers, "mode_of", lambda number: other)
    result, data = answer("pf2d", 7)
    assert (result.exit_code, data["status"]) == (1, "not_finite")
    assert data["message"].endswith("(x)")
    assert "x" not in data
    assert result.stderr.startswith("pf2d.dat: not_finite: A matrix of the analysis is not finite.")


def test_warnings_of_the_package_are_in_the_answer(monkeypatch):
    monkeypatch.setattr("flexmb.answers.mode.linearize", warned_by_the_package)
    result, data = answer("pf2d", 7)
    assert (result.exit_code, data["warnings"], result.stderr) == (0, ["Not what you may think."], "")


def warned_by_the_package(model, **given):
    for _ in range(2):
        warn("Not what you may think.")
    return fm.linearize(model, **given)


@pytest.mark.slow("7", "9")
@pytest.mark.parametrize("mode", [0, 7, 9])
def test_incremental_loads_that_do_not_act_are_told(mode, tmp_path):
    path = tmp_path / "more.dat"
    path.write_text(mechanism_path("pf1dtrx").read_text().replace("XM 2", "DELXF 2 1\nXM 2"))
    data = json.loads(call("run", path, "--mode", mode, "--json", "-").stdout)
    told = [f"Incremental loads (DELXF, DELESIG, DELINPX, DELINPE) act in modes 8 and 10: mode {mode} answers without"]
    assert [w[: len(told[0])] for w in data["warnings"]] == (told if mode else [])


# -- streams and files ----------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("redirected", "status", "words"),
    [
        ("> /dev/full", 2, "flexmb: cannot write to standard output: No space left on device.\n"),
        (">&-", 2, "flexmb: cannot write to standard output: it is closed.\n"),
        ("2>&-", 0, ""),
        ("| true; exit ${PIPESTATUS[0]}", 141, ""),
    ],
)
def test_streams_that_take_nothing(redirected, status, words):
    # The list of the shipped mechanisms may fit into a pipe that is not read yet, so it waits until nobody can.
    script = f"(sleep 0.5; {sys.executable} -m flexmb demo --list) {redirected}"
    found = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=False, timeout=60)
    assert (found.returncode, found.stderr) == (status, words)


@pytest.mark.slow
def test_every_name_and_comment_in_every_locale(tmp_path):
    """Comments in Latin-1 and a name in UTF-8 or in none, where neither files nor streams know more than ASCII."""
    ascii_only = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": "ascii"}
    text = "% Führung, 5 µm\n" + mechanism_path("pf1dtrx").read_text()
    for raw, model in ((b"F\xc3\xbchrung.dat", "Führung.dat"), (b"F\xfchrung.dat", r"F\xfchrung.dat")):
        name = os.fsdecode(raw)
        (tmp_path / name).write_bytes(text.encode("latin-1"))
        options = ["--json", name + ".json", "--save", name + ".mat", "--log", name + ".log", "--plot", name + ".svg"]
        found = program("run", name, "--mode", "7", *options, env={**os.environ, **ascii_only}, cwd=tmp_path)
        assert (found.returncode, found.stderr) == (0, b"")
        assert b"10.65844" in found.stdout
        assert json.loads((tmp_path / (name + ".json")).read_bytes())["model"] == model
        assert scipy.io.loadmat(tmp_path / (name + ".mat"))["frequencies_hz"] == approx(10.65844, rel=1e-6)
        assert b"NDOF 1" in (tmp_path / (name + ".log")).read_bytes()
        assert (tmp_path / (name + ".svg")).read_bytes().startswith(b"<?xml")


@pytest.mark.slow
def test_a_file_from_a_pipe(tmp_path):
    found = program("check", "/dev/stdin", input=mechanism_path("pf1dtrx").read_bytes())
    assert (found.returncode, found.stderr) == (0, b"")
    assert found.stdout.startswith(b"stdin  mode 0  status ok")


@pytest.mark.timeout(60)
def test_what_is_no_regular_file_is_refused_at_once(tmp_path):
    """A pipe would wait for its writer, and /dev/zero has no end."""
    target = tmp_path / "pf3d.dat"
    os.mkfifo(target)
    for path in (*not_regular(tmp_path, ".dat"), target):
        for calls in (["check", path], ["run", path, "--mode", "7"], ["demo", "pf3d", "--to", tmp_path]):
            result = call(*calls)
            assert result.exit_code == 2
            assert "is there already" in result.stderr or result.stderr.endswith("': it is no regular file.\n")
    with pytest.raises(IsADirectoryError):
        fm.read_spacar(tmp_path)


def test_a_disk_that_is_full_leaves_nothing(tmp_path):
    path = tmp_path / "a.json"
    path.write_bytes(b"old")
    # The limit has no name, and the file that it stops another one.
    with full(), pytest.raises(OSError, match=r"too large: '.*/a.json'"):
        write_whole(path, b"x" * 10**5)
    assert [(p.name, p.read_bytes()) for p in tmp_path.iterdir()] == [("a.json", b"old")]


def test_what_is_no_file_and_what_is_a_link_stay_what_they_are(tmp_path):
    (tmp_path / "real.json").write_text("old")
    (tmp_path / "link.json").symlink_to("real.json")
    (tmp_path / "later.json").symlink_to("made.json")
    (tmp_path / ("long" * 62 + ".json")).write_text("old")
    for path in tmp_path.iterdir():
        write_whole(path, b"new")
    assert {p.name: p.read_text() for p in tmp_path.iterdir() if not p.is_symlink()} == {
        "real.json": "new",
        "made.json": "new",
        "long" * 62 + ".json": "new",
    }
    assert sorted(p.name for p in tmp_path.iterdir() if p.is_symlink()) == ["later.json", "link.json"]
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_whole(pipe, b"through")
    assert os.read(reader, 100) == b"through"
    os.close(reader)


def test_a_folder_that_is_not_there_is_named(tmp_path):
    for tried in (check_writable, lambda path: write_whole(path, b"new")):
        with pytest.raises(FileNotFoundError, match=r"There is no such folder: '.*/none'"):
            tried(tmp_path / "none" / "a.fmu")


def test_bad_file_names_line_and_keyword(tmp_path):
    path = tmp_path / "bad.dat"
    path.write_text("PLBEAM 1 1 2 3\nTURBINE 2 3\n")
    result = call("run", path, "--mode", "7", "--json", "-")
    assert result.exit_code == 2
    assert result.stdout == ""
    lines = result.stderr.splitlines()
    assert any(line.startswith("bad.dat:1:") and "PLBEAM" in line for line in lines)
    assert any(line.startswith("bad.dat:2:") and "TURBINE" in line for line in lines)


def test_demo_lists_and_copies(tmp_path):
    listing = call("demo", "--list")
    assert {line.split()[0] for line in listing.stdout.splitlines()} == set(mechanisms())
    assert call("demo", "pf3d", "--to", tmp_path).exit_code == 0
    assert (tmp_path / "pf3d.dat").read_text() == mechanism_path("pf3d").read_text()


def test_help_imports_nothing_heavy():
    code = "import sys, flexmb.cli; sys.exit(any(m in sys.modules for m in ('jax', 'numpy', 'control', 'scipy')))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_file_that_nobody_may_read_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "guide.dat"
    path.write_text("END\n")
    monkeypatch.setattr(os, "access", lambda *_, **__: False)
    result = call("check", path)
    assert result.exit_code == 2
    assert "is not readable" in result.stderr


def test_the_module_is_the_program():
    result = subprocess.run([sys.executable, "-m", "flexmb", "--help"], capture_output=True, text=True, check=True)
    assert "run" in result.stdout
    assert "demo" in result.stdout


TURNED = """BEAM 1 1 2 3 4
X 1 0 0 0
X 3 1 0 0
FIX 1
FIX 2
RLSE 1 1 2 3 4 5 6
DYNX 3 1 2 3
DYNX 4 2 3 4
END
HALT
ESTIFF 1 1e5 1 1 1
EM 1 1 0.1 0.1 0.1
XF 4 0 0 0.1
END
END
"""


@pytest.mark.slow
def test_a_motion_that_cannot_begin_has_no_states(swing):
    result = call("run", swing(XM="2 0", EM="1 0"), "--mode", "1", "--json", "-")
    data = json.loads(result.stdout)
    assert (result.exit_code, data["status"]) == (1, "singular_mass")
    assert not {"time", "trajectory", "x", "energy"} & set(data)


@pytest.mark.slow
def test_poles_stand_where_there_are_no_frequencies(tmp_path):
    path = tmp_path / "turned.dat"
    path.write_text(TURNED)
    data = json.loads(call("run", path, "--mode", "7", "--json", "-").stdout)
    assert data["warnings"][0].startswith("The stiffness is unsymmetric")
    assert len(data["poles"]) == 12
    # Keys of the answer stand in it all the same.
    assert [data[key] for key in ("eigenvalues", "frequencies_hz", "modes")] == [None] * 3
    shown = call("run", path, "--mode", "7").stdout
    assert f"   12  {data['poles'][11][0]:.7g} {data['poles'][11][1]:+.7g}j" in shown


@pytest.mark.slow
def test_an_output_that_cannot_be_given_has_a_status(tmp_path):
    path = tmp_path / "held.dat"
    path.write_text(mechanism_path("pf2d").read_text().replace("OUTX 1 3 1", "OUTXDP 1 3 1\nINX 2 1 1"))
    result = call("run", path, "--mode", "9", "--json", "-")
    data = json.loads(result.stdout)
    assert (result.exit_code, data["status"]) == (1, "not_valid")
    assert result.stderr.startswith("held.dat: not_valid: Output 'acceleration 3.1' needs the ")


# A wheel on a torsion spring.
WHEEL = "PLTOR 1 1 2\nFIX 1\nRLSE 1 1\nDYNX 2 1\nEND\nHALT\nXM 2 -0.01\nESTIFF 1 1\nTIMESTEP 0.02 4\nEND\nEND\n"


@pytest.mark.slow
@pytest.mark.parametrize("mode", [1, 7, 8, 9])
def test_a_negative_mass_is_refused_in_every_mode(mode, tmp_path):
    path = tmp_path / "negative.dat"
    guide = re.sub("(?m)^XM 4 .*$", "XM 4 -0.01", mechanism_path("pf2d3dof").read_text())
    path.write_text(WHEEL if mode == 1 else guide)
    result = call("run", path, "--mode", mode, "--json", "-")
    assert (result.exit_code, json.loads(result.stdout)["status"]) == (1, "singular_mass")
    assert result.stderr.startswith("negative.dat: singular_mass: The mass matrix is singular")


CRANK = """PLTOR 1 1 3
PLRBEAM 2 2 3 4
PLRBEAM 3 4 5 6
X 2 0 0
X 4 0.06 0.08
X 6 0.3 0
FIX 1
FIX 2
FIX 6 2
INPUTE 1 1
END
HALT
XM 6 1.0
XM 4 0.3
END
HALT
INE 1 1 1
OUTX 1 6 1
OUTXDP 2 6 1
END
END
"""


@pytest.mark.slow
def test_a_state_space_of_what_is_driven_throughout(tmp_path):
    # By how much the slider follows the crank, which turns rod and crank about their common pin.
    follows = -0.08 - 0.08 * 0.06 / 0.24
    path = tmp_path / "crank.dat"
    path.write_text(CRANK.replace("OUTXDP 2 6 1\n", ""))
    data = json.loads(call("run", path, "--mode", "9", "--json", "-").stdout)
    assert (data["status"], data["A"], data["B"], data["C"], data["states"]) == ("ok", [], [], [[]], [])
    np.testing.assert_allclose(data["D"], [[follows]], rtol=1e-12)
    assert "A: empty" in call("run", path, "--mode", "9", "--plot", tmp_path / "a.svg").stdout
    result = call("fmu", path, "--to", tmp_path / "a.fmu")
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert "an FMU of mode 9 needs a degree of freedom" in result.stderr
    # An acceleration as input brings both of its integrals.
    path.write_text(CRANK.replace("INE ", "INEDP "))
    data = json.loads(call("run", path, "--mode", "9", "--json", "-").stdout)
    assert data["states"] == ["moved by acceleration 1.1", "d moved by acceleration 1.1"]
    assert (data["A"], data["B"]) == ([[0, 1], [0, 0]], [[0], [1]])
    np.testing.assert_allclose(data["C"], [[follows, 0], [0, 0]], rtol=1e-12)
    np.testing.assert_allclose(data["D"], [[0], [follows]], rtol=1e-12)


@pytest.mark.parametrize("given", [None, "2"])
def test_no_thread_of_linear_algebra_waits_for_work(monkeypatch, given):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", given or "")
    if given is None:
        monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    monkeypatch.setattr(cli, "app", lambda: None)
    cli.main()
    assert os.environ["OPENBLAS_NUM_THREADS"] == (given or "1")
