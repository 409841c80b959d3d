"""Studies in a file: placeholders, the two commands, the same numbers as in Python, one line a fault."""

import json
import os

import jax
import numpy as np
import pytest
from cases.commands import command as call
from cases.disk import not_regular
from cases.files import arrays_of
from cases.guide_file import GUIDE
from cases.tolerances import approx

import flexmb as fm
from flexmb.design.study import sweep_answer
from flexmb.design.study_file import read_study
from flexmb.design.swept import Sweep
from flexmb.errors import printable

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
        "def raising(**numbers):\n    return numbers['thickness']\n"
        "def nothing(**numbers):\n    return None\n"
        "def word(model):\n    return 'stiff'\n"
        "def complex_one(model):\n    return 1j\n"
        "def formatted(model):\n    return float(f'{fm.frequencies(model)[0]:.5e}')\n"
        "NUMBER = 1\n"
    )
    (tmp_path / "faulty.py").write_text("1 / 0\n")
    (tmp_path / "leaving.py").write_text("raise SystemExit\n")
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    return path


def frequency(t):
    return fm.frequencies(fm.read_spacar(GUIDE, numbers={"t": t, "w": 0.018, "l": 0.1}).builder.build())[0]


@pytest.mark.slow
def test_placeholders_may_be_traced():
    # E1; the derivative by the length goes through the geometry.
    assert frequency(0.5e-3) == approx(10.64484738, abs=5e-9)
    assert fm.jit(jax.grad(frequency))(0.5e-3) == approx(31670.0798802, rel=1e-8)


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


def test_a_sweep_is_even_in_the_logarithm_where_a_scale_says_so(study):
    def designs(plan):
        text = STUDY.replace("upper = 2e-3", "upper = 1e-1, scale = 'log'").replace("points = 3", plan)
        study.write_text(text.replace("l = 0.1", "l = { value = 0.1, lower = 0.0, upper = 1.0 }"))
        return read_study(study).designs()

    found = designs("points = 4")
    np.testing.assert_allclose(found.axes["t"], [1e-4, 1e-3, 1e-2, 1e-1], rtol=1e-12)
    np.testing.assert_allclose(found.axes["l"], np.linspace(0, 1, 4))
    for kind in ("latin-hypercube", "monte-carlo"):
        found = designs(f"kind = '{kind}'\nsamples = 300")
        # A third of them in each decade, and of the others in each third: of 300 drawn, four standard deviations.
        for n, ends in (("t", [1e-4, 1e-3, 1e-2, 1e-1]), ("l", np.linspace(0, 1, 4))):
            np.testing.assert_allclose(np.histogram(found[n], ends)[0], 100, atol=1 if "latin" in kind else 33)


@pytest.mark.slow
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
    np.testing.assert_allclose(arrays_of(tmp_path / "a.npz")["f"], expected, rtol=1e-10)
    assert (tmp_path / "c.npz").exists()
    assert "<svg" in (tmp_path / "a.svg").read_text()
    assert call("sweep", study, "--plot", tmp_path / "a.html").exit_code == 2


@pytest.mark.slow
def test_tune_is_that_of_python(study, tmp_path):
    result = call(
        "tune", study, "--json", tmp_path / "a.json", "--save", tmp_path / "a.mat", "--plot", tmp_path / "a.png"
    )
    assert result.exit_code == 0, result.stderr
    data = json.loads((tmp_path / "a.json").read_text())
    assert data["status"] == "ok"
    assert data["parameters"]["t"] == approx(0.764636213e-3, rel=5e-6)  # E1, from inside by the tolerance
    assert data["answers"]["f"] >= 20
    assert data["active"] == ["f (lower limit 20) is reached"]
    assert "f (lower limit 20) is reached" in result.stdout
    assert len(data["history"]["t"]) == data["evaluations"]
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_what_cannot_be_kept_is_exit_1(study):
    study.write_text(STUDY.replace("lower = 20.0", "lower = 200.0"))
    result = call("tune", study, "--json", "-")
    assert result.exit_code == 1
    data = json.loads(result.stdout)
    assert data["status"] == "infeasible"
    assert "by 58.9 %" in data["reason"]
    assert result.stderr.startswith("study.toml: infeasible")


def test_a_missed_target_is_exit_1(study):
    wanted = STUDY.replace("[limits]\nf = { lower = 20.0 }", "[targets]\nf = 200.0").replace('minimize = "m"', "")
    study.write_text(wanted)
    result = call("tune", study, "--json", "-")
    assert result.exit_code == 1
    data = json.loads(result.stdout)
    assert (data["status"], data["active"]) == ("target_missed", ["t is at its upper bound 0.002"])
    assert result.stderr.startswith("study.toml: target_missed")


# What is replaced in the study by what, and what the one line says.
WRONG = [
    ("[answers]", "[answer]", "there is no key 'answer'. Did you mean 'answers'?"),
    ("frequency = 1", "frequency = 0", "[answers] f: frequency must be a whole number"),
    ("frequency = 1", "frequenzy = 1", "[answers] f must be"),
    ("mass = true", "stiffness = '3'", "[answers] m: stiffness needs axis"),
    ("own:double", "own:triple", "[answers] double: 'own:triple' cannot be imported: AttributeError"),
    ("guide.dat", "guard.dat", "model: there is no file"),
    ("lower = 0.1e-3, upper = 2e-3", "lower = 0.1e-3", "[parameters] t: give value"),
    ("lower = 0.1e-3, upper = 2e-3", "lower = 1e-3, upper = 2e-3", "is outside its bounds"),
    ("lower = 0.1e-3, upper = 2e-3", "lower = 2e-3, upper = 1e-3", "[parameters] t: lower 0.002 is not below"),
    ("lower = 0.1e-3, upper = 2e-3", "min = 1e-3", "[parameters] t: there is no 'min'"),
    ('minimize = "m"', 'minimise = "m"', "[tune]: there is no 'minimise'"),
    ('minimize = "m"', 'minimize = "n"', "[tune] minimize: There is no answer 'n'"),
    ('minimize = "m"', "", "Give an objective"),
    ("w = 0.018", "", "there is no parameter 'w'"),
    ("w = 0.018", "w = 0.018\nq = { value = 1, lower = 0, upper = 2 }", "[parameters] q: 'guide.dat' has no {q}"),
    ("l = 0.1\n", "l = \n", "study.toml: Invalid value"),
    # Indices that would clamp or wrap.
    ("frequency = 1", "frequency = 99", "[answers] f: frequency: no frequency '99': they are numbered 1 to 1"),
    ("frequency = 1", "frequency = -1", "[answers] f: frequency must be a whole number from 1"),
    ("frequency = 1", "frequency = true", "[answers] f: frequency must be a whole number"),
    ("frequency = 1", "frequency = 1.0", "[answers] f: frequency must be a whole number"),
    ("frequency = 1", "load_multiplier = 7", "[answers] f: multiplier: no multiplier '7': they are numbered 1 to 1"),
    ("frequency = 1", "coordinate = 3, component = 0", "[answers] f: component must be a whole number"),
    ("frequency = 1", "coordinate = 3, component = -5", "[answers] f: component must be a whole number"),
    ("frequency = 1", "coordinate = 3, component = 1.5", "[answers] f: component must be a whole number"),
    ("frequency = 1", "coordinate = 3, component = true", "[answers] f: component must be a whole number"),
    (
        "frequency = 1",
        "coordinate = 3, component = 3",
        "[answers] f: coordinate: component = 3, but node '3' has coordinates 1 to 2",
    ),
    (
        "frequency = 1",
        "coordinate = 99, component = 1",
        "[answers] f: coordinate: there is no node '99'; there are 1, 2",
    ),
    ("frequency = 1", "coordinate = '', component = 1", "there is no node ''"),
    ("frequency = 1", "coordinate = true, component = 1", "[answers] f: coordinate must be the name of a node"),
    ("frequency = 1", "coordinate = 3.0, component = 1", "[answers] f: coordinate must be the name of a node"),
    ("frequency = 1", "stiffness = 99, axis = 'x'", "[answers] f: stiffness: no node '99'"),
    ("frequency = 1", "stiffness = 3, axis = 'w'", "[answers] f: stiffness: Node '3' has no axis 'w'"),
    ("frequency = 1", "stiffness = 3, axis = 1", "[answers] f: axis must be a text"),
    ("frequency = 1", "stress = true", "[answers] f: stress"),
    # False is not true.
    ("mass = true", "mass = false", "[answers] m: mass must be true"),
    ("mass = true", "mass = 1", "[answers] m: mass must be true"),
    ("mass = true", "mass = 'yes'", "[answers] m: mass must be true"),
    ("mass = true", "stress = false", "[answers] m: stress must be true"),
    ("mass = true", "mass = true, frequency = 1", "[answers] m: frequency does not take mass"),
    # Models, functions and their modules.
    ('model = "guide.dat"', "model = 3", "model must be a text"),
    ('model = "guide.dat"', "model = ['guide.dat']", "model must be a text"),
    ('model = "guide.dat"', "model = ''", "'model' is missing"),
    ('model = "guide.dat"', "", "'model' is missing"),
    ('model = "guide.dat"', "model = '.'", "model: cannot read"),
    ('model = "guide.dat"', "model = 'guide.dat/x'", "model: there is no file"),
    ('model = "guide.dat"', "model = '" + "x" * 5000 + "'", "model: cannot read"),
    ('model = "guide.dat"', 'model = "a\\u0000b"', "model must be a text of printable letters"),
    ('model = "guide.dat"', "model = ':guide'", "model must be module:function"),
    ('model = "guide.dat"', "model = 'own:'", "model must be module:function"),
    ('model = "guide.dat"', "model = '..own:guide'", "model must be module:function"),
    ('model = "guide.dat"', "model = 'none:guide'", "model: 'none:guide' cannot be imported: ModuleNotFoundError"),
    ('model = "guide.dat"', "model = 'faulty:guide'", "model: 'faulty:guide' cannot be imported: ZeroDivisionError"),
    ('model = "guide.dat"', "model = 'leaving:guide'", "model: 'leaving:guide' cannot be imported: SystemExit"),
    ('model = "guide.dat"', "model = 'own:NUMBER'", "model: 'own:NUMBER' is of type int. It must be a function"),
    ('model = "guide.dat"', "model = 'own:guide'", "[parameters]: Dimension 'l' is not one of guide(t)"),
    ('model = "guide.dat"', "model = 'own:raising'", "model: 'own:raising' raised KeyError: 'thickness'"),
    ('model = "guide.dat"', "model = 'own:nothing'", "needs a Model, but `model` returns NoneType"),
    ('model = "guide.dat"', "model = 'own:nothing'\nrelease = 'auto'", "release is for a model in a file"),
    ('model = "guide.dat"', "model = 'guide.dat'\nrelease = true", "release must be a text"),
    ('model = "guide.dat"', "model = 'guide.dat'\nrelease = 'all'", "release must be none or auto"),
    ("own:double", "own:raising", "[answers] double: 'own:raising' raised TypeError"),
    ("own:double", "own:word", "[answers] double: 'own:word' returned something"),
    ("own:double", "own:complex_one", "[answers] double: 'own:complex_one' returned something"),
    ("own:double", "double", "[answers] double must be module:function"),
    ("own:double", "", "[answers] double must be module:function"),
    # Tables, kinds and ranges of values.
    (
        '[answers]\nf = { frequency = 1 }\nm = { mass = true }\ndouble = "own:double"',
        "[answers]",
        "'answers' is missing",
    ),
    ("f = { frequency = 1 }", "f = {}", "[answers] f must be"),
    ("f = { frequency = 1 }", "f = 1", "[answers] f must be"),
    ("f = { frequency = 1 }", "f = []", "[answers] f must be"),
    ("f = { frequency = 1 }", "t = { frequency = 1 }", "Answer 't' has the name of a dimension"),
    ("f = { frequency = 1 }", '"" = { frequency = 1 }', "must have a name of printable letters"),
    ("f = { frequency = 1 }", '"a\\u001b[31m" = { frequency = 1 }', r"'a\x1b[31m'"),
    ("m = { mass = true }", "objective = { mass = true }\nm = { mass = true }", "Answer 'objective' must have another"),
    ("t = { value = 0.5e-3, lower = 0.1e-3, upper = 2e-3 }", "t = []", "[parameters] t: value must be a number"),
    ("t = { value = 0.5e-3, lower = 0.1e-3, upper = 2e-3 }", "t = {}", "[parameters] t: give value"),
    ("t = { value = 0.5e-3, lower = 0.1e-3, upper = 2e-3 }", "t = 1", "[parameters]: give at least one lower"),
    ("value = 0.5e-3", "value = nan", "[parameters] t: value must be a finite number"),
    ("value = 0.5e-3", "value = inf", "[parameters] t: value must be a finite number"),
    ("value = 0.5e-3", "value = 1" + 400 * "0", "[parameters] t: value must be a finite number"),
    ("value = 0.5e-3", "value = true", "[parameters] t: value must be a number"),
    ("value = 0.5e-3", "value = 1979-05-27", "[parameters] t: value must be a number"),
    ("value = 0.5e-3,", "value = 0.5e-3, scale = 'square',", "[parameters] t: scale must be log or linear"),
    ("w = 0.018", "w = { value = 0.018, scale = 'log' }", "[parameters] w: a scale needs lower and upper"),
    ("lower = 0.1e-3", "scale = 'log', lower = 0.0", "[parameters] t: scale cannot be log, since lower 0 is not"),
    ("w = 0.018", '"a b" = 1', "[parameters] a b: a parameter's name"),
    ("w = 0.018", "pi = 3", "[parameters] pi: a parameter's name"),
    ("w = 0.018", "w = 'thin'", "[parameters] w: value must be a number"),
    ("[parameters]", "[[parameters]]", "[parameters] must be a table"),
    ("[limits]\nf", "[limits]\ng", "[limits]: There is no answer 'g'"),
    ("{ lower = 20.0 }", "20.0", "[limits] f must be a table with lower, upper or both"),
    ("{ lower = 20.0 }", "{}", "[limits] f must be a table"),
    ("{ lower = 20.0 }", "{ low = 20.0 }", "[limits] f: there is no 'low'"),
    ("{ lower = 20.0 }", "{ lower = true }", "[limits] f: lower must be a number"),
    ("{ lower = 20.0 }", "{ lower = [1, 2] }", "The lower limit of 'f' must be a number"),
    ("{ lower = 20.0 }", "{ lower = [[1], [1, 2]] }", "[limits] f: lower has lists of different lengths"),
    ("{ lower = 20.0 }", "{ lower = 20.0, upper = 10.0 }", "[limits] f: lower 20.0 is not below upper 10.0"),
    ("[tune]", "[targets]\nf = 'high'\n[tune]", "[targets] f must be a number"),
    ("[tune]", "[targets]\nf = nan\n[tune]", "[targets] f must be a finite number"),
    ("[tune]", "[equal]\ng = 1\n[tune]", "[equal]: There is no answer 'g'"),
    ("[tune]", "[tune]\nmaximize = 'f'", "Give either `minimize` or `maximize`"),
    ("[tune]", "[tune]\nmaximize = 1", "[tune] maximize must be a text"),
    ("[tune]", "[tune]\nstarts = 0", "[tune] starts must be a whole number from 1"),
    ("[tune]", "[tune]\nstarts = 1.5", "[tune] starts must be a whole number"),
    ("[tune]", "[tune]\nstarts = 10000000000", "[tune] starts must be a whole number from 1 to"),
    ("[tune]", "[tune]\nseed = -1", "[tune] seed must be a whole number from 0"),
    ("[tune]", "[tune]\nseed = 'x'", "[tune] seed must be a whole number"),
    ("[tune]", "[tune]\ntolerance = 0", "[tune] tolerance must be positive"),
    ("[tune]", "[tune]\ntolerance = inf", "[tune] tolerance must be a finite number"),
    ("[tune]", "[tune]\ntolerance = true", "[tune] tolerance must be a number"),
    ("[tune]", "[tune]\nmax_evaluations = 0", "[tune] max_evaluations must be a whole number"),
    ("points = 3", "points = {}", "[sweep] points: 't' is missing"),
    ("points = 3", "points = { w = 3 }", "[sweep] points: there is no 'w'"),
    ("points = 3", "points = { t = 0 }", "[sweep] points: t must be a whole number from 1"),
    ("points = 3", "points = 1e11", "[sweep] points must be a whole number from 1 to 1e+07"),
    ("points = 3", "points = 100000000000", "[sweep] points must be a whole number from 1 to 1e+07"),
    ("points = 3", "points = 2.9", "[sweep] points must be a whole number"),
    ("points = 3", "points = true", "[sweep] points must be a whole number"),
    ("points = 3", "points = [3]", "[sweep] points must be a whole number"),
    ("points = 3", "kind = 'random'", "[sweep] kind must be grid, latin-hypercube or monte-carlo"),
    ("points = 3", "kind = 3", "[sweep] kind must be a text"),
    ("points = 3", "samples = 3", "[sweep] samples has no meaning if kind is grid. Give points."),
    ("points = 3", "kind = 'monte-carlo'\npoints = 3", "[sweep] points has no meaning"),
    ("points = 3", "kind = 'monte-carlo'\nsamples = 0", "[sweep] samples must be a whole number from 1"),
    ("points = 3", "kind = 'monte-carlo'\nsamples = 1e11", "[sweep] samples must be a whole number from 1 to"),
    ("points = 3", "kind = 'monte-carlo'\nseed = -1", "[sweep] seed must be a whole number from 0"),
    ("points = 3", "chunk = 0", "[sweep] chunk must be a whole number from 1"),
    ("points = 3", "chunk = 2.5", "[sweep] chunk must be a whole number"),
    # What TOML itself refuses.
    ("points = 3", "points = " + "[" * 100_000, "study.toml: "),
    ("points = 3", "points = " + "9" * 5000, "study.toml: "),
    ("points = 3", "points = 3\x1b[31m", "study.toml: "),
]


@pytest.mark.slow
@pytest.mark.parametrize(("old", "new", "words"), WRONG, ids=[f"{i}" for i in range(len(WRONG))])
def test_wrong_studies_are_one_line(study, old, new, words):
    assert old in STUDY
    study.write_text(STUDY.replace(old, new))
    for command in ("tune", "sweep"):
        # What only a search asks for is no fault of a sweep.
        if command == "tune" or not any(of_tune in words for of_tune in OF_TUNE):
            assert_one_line(call(command, study), words)


OF_TUNE = (
    "is outside its",
    "Give an objective",
    "Give either",
    "Answer 'objective'",
    "imits of 'f'",
    "imit of 'f'",
)


def assert_one_line(result, words):
    assert result.exit_code == 2, result.output
    assert words in result.stderr
    lines = result.stderr.splitlines()
    # Of an input file each fault has its line.
    assert lines[0].startswith("guide.dat:") or (len(lines) == 1 and lines[0].startswith("flexmb: study.toml: "))
    assert all(line.isprintable() and len(line) < 500 for line in lines)
    assert result.stdout == ""


def test_what_a_study_asks_of_too_many_designs_is_refused(study):
    more = "".join(f"p{i} = {{ value = 1, lower = 1, upper = 2 }}\n" for i in range(9))
    study.write_text(STUDY.replace("l = 0.1\n", "l = 0.1\n" + more).replace("points = 3", "points = 10"))
    assert_one_line(call("sweep", study), "[sweep] points: there are 1e+10 designs, at most 1e+07")


@pytest.mark.slow
def test_impossible_designs_have_their_code(study):
    study.write_text(STUDY.replace("lower = 0.1e-3, upper = 2e-3", "lower = -2e-3, upper = 2e-3"))
    result = call("sweep", study, "--json", "-")
    data = json.loads(result.stdout)
    assert result.exit_code == 0
    assert data["results"] == ["impossible_design", data["results"][1], "successful"]
    assert data["message"].startswith("1 designs: impossible_design") or "impossible_design" in data["message"]
    assert data["answers"]["f"][0] is None
    assert data["answers"]["m"][0] is None
    assert "impossible_design" in call("sweep", study).stdout


@pytest.mark.slow
def test_what_cannot_be_traced_is_computed_one_by_one(study, tmp_path):
    study.write_text(STUDY.replace("own:double", "own:formatted"))
    found = [call("sweep", study, "--json", "-", "--checkpoint", tmp_path / "c") for _ in range(2)]
    data = [json.loads(result.stdout) for result in found]
    assert data[0] == data[1]
    np.testing.assert_allclose(data[0]["answers"]["double"], data[0]["answers"]["f"], rtol=1e-5)  # five digits of text
    assert_one_line(call("tune", study), "raised TypeError")


@pytest.mark.slow
def test_warnings_of_the_input_file_are_passed_on(study):
    study.with_name("guide.dat").write_text(GUIDE + "VISUALIZATION\n")
    assert any("VISUALIZATION" in text for text in json.loads(call("sweep", study, "--json", "-").stdout)["warnings"])


def test_modules_of_one_name_are_told_apart(tmp_path):
    found = []
    for factor in (2, 3):
        folder = tmp_path / f"{factor}"
        folder.mkdir()
        (folder / "made.py").write_text(f"def build(a):\n    return {factor} * a\ndef same(made):\n    return made\n")
        text = (
            'model = "made:build"\n[parameters]\na = { value = 1, lower = 1, upper = 2 }\n[answers]\nb = "made:same"\n'
        )
        (folder / "study.toml").write_text(text + "[sweep]\npoints = 1\n")
        found.append(json.loads(call("sweep", folder / "study.toml", "--json", "-").stdout)["answers"]["b"])
    assert found == [[2.0], [3.0]]


@pytest.mark.parametrize("command", ["sweep", "tune"])
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--plot", "a.html"), "--plot writes .png, .svg or .pdf, not 'a.html'"),
        (("--plot", "a.gif"), "--plot writes .png, .svg or .pdf, not 'a.gif'"),
        (("--save", "a.csv"), "--save writes .npz or .mat"),
        (("--json", "none/a.json"), "the folder of 'none/a.json' does not exist"),
        (("--save", "none/a.npz"), "the folder of 'none/a.npz' does not exist"),
        (("--plot", "none/a.svg"), "the folder of 'none/a.svg' does not exist"),
        (("--json", "folder"), "cannot write 'folder'"),
        (("--json", "study.toml"), "--json would write over the input file"),
        (("--json", "a.npz", "--save", "a.npz"), "--save would write over --json"),
        (("--json", "\x1b[31m/a"), r"'\x1b[31m/a' does not exist"),
    ],
)
def test_what_cannot_be_written_is_refused_before_the_work(study, monkeypatch, command, options, words):
    monkeypatch.chdir(study.parent)
    (study.parent / "folder").mkdir()
    # Nothing is asked of the model, which raises.
    study.write_text(STUDY.replace("guide.dat", "own:raising"))
    before = sorted(path.name for path in study.parent.iterdir())
    result = call(command, "study.toml", *options)
    assert result.exit_code == 2
    assert words in result.stderr
    assert result.stderr.count("\n") == 1
    assert result.stdout == ""
    assert sorted(path.name for path in study.parent.iterdir()) == before


def test_a_checkpoint_has_a_file_of_its_own(study):
    for place in (study, study.with_name("a.npz")):
        result = call("sweep", study, "--save", study.with_name("a.npz"), "--checkpoint", place)
        assert result.exit_code == 2
        assert "--checkpoint needs a file of its own" in result.stderr
    result = call("sweep", study, "--checkpoint", study.parent / "none" / "c")
    assert result.exit_code == 2
    assert "cannot read or write" in result.stderr
    study.with_name("c").write_text("mine")
    result = call("sweep", study, "--checkpoint", study.with_name("c"))
    assert_one_line(result, "is no checkpoint of a sweep")
    assert study.with_name("c").read_text() == "mine"


@pytest.mark.timeout(60)
def test_what_is_no_regular_file_is_refused_at_once(study):
    for path in not_regular(study.parent, ".toml"):
        result = call("sweep", path)
        assert result.exit_code == 2
        assert result.stderr == f"flexmb: cannot read or write '{printable(path)}': it is no regular file.\n"
    for path in not_regular(study.parent, ".dat"):
        study.write_text(STUDY.replace("guide.dat", path.name))
        assert_one_line(call("sweep", study), f"cannot read '{printable(path)}': it is no regular file.")


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a disk that is full, of Linux")
@pytest.mark.parametrize("command", ["sweep", "tune"])
def test_a_full_disk_is_one_line(study, command):
    result = call(command, study, "--json", "/dev/full")
    assert result.exit_code == 2
    assert result.stderr == "flexmb: cannot write '/dev/full': No space left on device.\n"


def test_a_picture_needs_two_designs(study):
    study.write_text(STUDY.replace("points = 3", "points = 1"))
    result = call("sweep", study, "--plot", study.with_name("a.svg"))
    assert result.exit_code == 2
    assert "needs two designs" in result.stderr


def test_names_that_meet_in_a_file_are_refused_before_the_work(study):
    text = STUDY.replace('double = "own:double"', 'history_f = "own:raising"\nabout = "own:raising"')
    study.write_text(text)
    result = call("tune", study, "--save", study.with_name("a.npz"))
    assert result.exit_code == 2
    assert "is a name that --save uses for another array" in result.stderr
    study.write_text(STUDY.replace("double =", "codes ="))
    assert_one_line(call("sweep", study), "Answer 'codes' must have another name")


def test_what_has_no_answer_says_so_as_json(study):
    study.write_text(STUDY.replace("0.5e-3, lower = 0.1e-3, upper = 2e-3", "-2e-3, lower = -2e-3, upper = -1e-3"))
    for command in ("sweep", "tune"):
        result = call(command, study, "--json", "-")
        assert result.exit_code == 2
        assert "EM" in result.stderr
    # A mechanism that is not valid, whatever the numbers.
    study.with_name("guide.dat").write_text(GUIDE.replace("FIX 8\n", ""))
    study.write_text(STUDY)
    for command in ("sweep", "tune"):
        result = call(command, study, "--json", "-")
        assert result.exit_code == 1
        data = json.loads(result.stdout)
        assert (data["status"], data["warnings"]) == ("underconstrained", [])
        assert result.stderr.startswith("study.toml: underconstrained: ")
        assert result.stderr.count("\n") == 1


@pytest.mark.parametrize(("fallen", "status"), [((), "ok"), ((1,), "ok"), ((0, 1, 2), "failed")])
def test_a_failed_sweep_is_one_without_any_answer(fallen, status, study):
    read = read_study(study)
    codes = np.array([int(fm.RESULTS.not_converged if i in fallen else fm.RESULTS.successful) for i in range(3)])
    found = Sweep(read.designs(), {"f": np.where(codes == 0, 10.0, np.nan)}, codes, {})
    data = sweep_answer(read, found, "1.0")
    assert data["status"] == status
    assert data["message"] == (f"{len(fallen)} designs: not_converged" if fallen else "")
    assert [name == "successful" for name in data["results"]] == [i not in fallen for i in range(3)]


def test_a_failed_sweep_is_exit_1(study, monkeypatch):
    def none_converges(read, **_):
        codes = np.full(3, int(fm.RESULTS.not_converged))
        return Sweep(read.designs(), {"f": np.full(3, np.nan)}, codes, {})

    monkeypatch.setattr("flexmb.design.study.Study.sweep", none_converges)
    result = call("sweep", study, "--json", "-")
    assert result.exit_code == 1
    assert json.loads(result.stdout)["status"] == "failed"
    assert result.stderr == "study.toml: failed: 3 designs: not_converged\n"


CHOICES = STUDY.replace("w = 0.018\n", "").replace("[answers]", "[choices]\nw = [0.018, 0.009]\n[answers]")


@pytest.mark.slow
def test_choices_of_a_study(study):
    """The lightest guide of 20 Hz, of two widths."""
    # E1 for 20 Hz at a width of 18 mm. A leaf spring's mass goes as w t, and t as w^(-1/3): the narrower is lighter.
    study.write_text(CHOICES.replace('double = "own:double"\n', ""))
    found = read_study(study).tune()
    wide, narrow = found.combinations
    assert (found.choices, wide.labels) == ({"w": 0.009}, {"w": "0.018"})
    assert wide.tuned.dimensions["t"] == approx(0.764636213e-3, rel=5e-6)
    assert narrow.tuned.dimensions["t"] == approx(0.764636213e-3 * 2 ** (1 / 3), rel=5e-3)
    data = json.loads(call("tune", study, "--json", "-").stdout)
    assert data["choices"] == {"w": 0.009}
    assert [one["status"] for one in data["combinations"]] == ["successful"] * 2
    with pytest.raises(fm.errors.StudyError, match=r"\[choices\]: a sweep has no choices"):
        read_study(study).sweep()


@pytest.mark.slow("line6-101 combinations")
@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("w = 0.018", "must be a list of values"),
        ("w = []", "must be a list of values"),
        ("w = ['wide']", "must be a number"),
        ("t = [1e-3]", "it is a parameter too"),
        ("'1w' = [1.0]", "letters, digits"),
        ("w = [0.018]\nv = [1.0]", "has no {v}"),
        ("w = [" + "0.1, " * 101 + "]", "101 combinations"),
    ],
)
def test_wrong_choices_are_named(study, line, words):
    study.write_text(CHOICES.replace("w = [0.018, 0.009]", line))
    with pytest.raises(fm.errors.StudyError, match=words):
        read_study(study).tune()


@pytest.mark.slow("tune")
@pytest.mark.parametrize("command", ["sweep", "tune"])
def test_warnings_stand_before_the_answer(command, study):
    study.write_text(STUDY.replace("w = 0.018\n", "w = 0.018\nq = 1\n"))
    result = call(command, study)
    assert result.exit_code == 0
    assert result.stdout.splitlines()[0] == "warning: guide.dat: parameter 'q' does not occur in the file"


COLUMN = """PLBEAM 1 1 2 3 4
PLBEAM 2 3 4 5 6
X 1 0 0
X 3 0 0.5
X 5 0 1
FIX 1
FIX 2
RLSE 1 1 2 3
RLSE 2 1 2 3
END
HALT
ESTIFF 1 1e4 {EI}
ESTIFF 2 1e4 {EI}
EM 1 {EI}
EM 2 {EI}
XF 5 0 -1
END
END
"""


@pytest.mark.slow("tune-The design is at an equilibrium that is not stable")
@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("sweep", "Of 2 designs 1 are at an equilibrium that is not stable"),
        ("tune", "The design is at an equilibrium that is not stable"),
    ],
)
def test_warnings_of_the_work_are_in_the_answer(command, words, tmp_path):
    # It bears its load of 1 from EI = 4/pi^2 = 0.405 on.
    (tmp_path / "column.dat").write_text(COLUMN)
    (tmp_path / "own.py").write_text(
        "import flexmb as fm\ndef height(model):\n    return fm.equilibrium(model).at('5')[1]\n"
    )
    study = tmp_path / "study.toml"
    study.write_text(
        "model = 'column.dat'\n[parameters]\nEI = { value = 2, lower = 0.36, upper = 4 }\n"
        "[answers]\nm = { mass = true }\nheight = 'own:height'\n[tune]\nminimize = 'm'\n[sweep]\npoints = 2\n"
    )
    result = call(command, study, "--json", study.with_suffix(".json"))
    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout.startswith(f"warning: {words}")
    assert [text.startswith(words) for text in json.loads(study.with_suffix(".json").read_text())["warnings"]] == [True]


def test_an_incomplete_checkpoint_is_a_warning_of_the_answer(study, tmp_path):
    call("sweep", study, "--checkpoint", tmp_path / "c")
    with (tmp_path / "c").open("ab") as file:
        file.write(b"half")
    result = call("sweep", study, "--checkpoint", tmp_path / "c", "--json", "-")
    assert (result.exit_code, result.stderr) == (0, "")
    assert json.loads(result.stdout)["warnings"][0].startswith("The last record of checkpoint")
