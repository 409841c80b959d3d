"""Fits in a file: the same numbers as in Python, three sources of data, and one line for each fault."""

import contextlib
import json
from typing import Any

import numpy as np
import pytest
from cases.commands import command as call
from cases.files import arrays_of
from cases.guide_file import GUIDE_WITH_PORTS as GUIDE

import flexmb as fm
from flexmb.identification.fit_study import read_fit_study

STUDY = """model = "guide.dat"
[parameters]
t = { value = 0.45e-3, lower = 0.1e-3, upper = 2e-3 }
m = { value = 0.12, lower = 0.01, upper = 1.0, prior = [0.1, 0.05] }
w = 0.018
[data.first]
modes = true
values = [10.9]
deviation = 0.05
[data.drive]
answer = "stiffness 3.x"
values = 940.0
deviation = 9.4
[fit]
starts = 2
level = 0.9
"""
MODULE = """import flexmb as fm
def guide(t, m):
    return fm.read_spacar('guide.dat', numbers={'t': t, 'm': m, 'w': 0.018}).builder.build()
def curve(model, offset):
    import jax.numpy as jnp
    return fm.stiffness(model, '3', 'x') * jnp.array([1e-3, 2e-3, 3e-3]) + offset
"""


@pytest.fixture
def study(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "guide.dat").write_text(GUIDE)
    (tmp_path / "lab.py").write_text(MODULE)
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    return path


def guide(t, m):
    return fm.read_spacar(GUIDE, numbers={"t": t, "m": m, "w": 0.018}).builder.build()


def stiffness(t):
    return 2 * 12 * 210e9 * 0.018 * t**3 / 12 / 0.1**3


@pytest.mark.slow
def test_the_command_fits_as_python_does(study, tmp_path):
    result = call(
        "fit", study, "--json", tmp_path / "a.json", "--save", tmp_path / "a.npz", "--plot", tmp_path / "a.png"
    )
    assert result.exit_code == 0, result.stderr
    data = json.loads((tmp_path / "a.json").read_text())
    given = [fm.measured_modes([10.9], 0.05, name="first"), fm.measured("stiffness 3.x", 940.0, 9.4, name="drive")]
    start, bounds = {"t": 0.45e-3, "m": 0.12}, {"t": (0.1e-3, 2e-3), "m": (0.01, 1.0)}
    expected = fm.fit(guide, given, start, bounds, priors={"m": (0.1, 0.05)}, starts=2)
    assert data["status"] == "ok"
    for name in start:
        assert data["parameters"][name] == pytest.approx(expected.parameters[name], rel=1e-7)
        assert data["deviation"][name] == pytest.approx(expected.deviation[name], rel=1e-6)
        assert data["intervals"][name] == pytest.approx(expected.interval(name, 0.9), rel=1e-6)
    # The stiffness of two clamped-guided leaf springs without extension determines the thickness.
    assert data["parameters"]["t"] == pytest.approx((940 / stiffness(1.0)) ** (1 / 3), rel=2e-3)
    assert (data["freedom"], data["labels"], data["level"]) == (1, ["t", "m"], 0.9)
    assert data["data"]["drive"]["measured"] == [940.0]
    assert data["undetermined"] == []
    saved = arrays_of(tmp_path / "a.npz")
    assert saved["covariance"] == pytest.approx(np.array(data["covariance"]))
    assert saved["deviation_t"] == pytest.approx(data["deviation"]["t"])
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert "t: 0.000" in result.stdout


@pytest.mark.slow
def test_what_is_not_determined_is_null_and_named(study):
    study.write_text(
        STUDY.replace(", prior = [0.1, 0.05]", "")
        .replace("[data.drive]\nanswer", "[data.drive]\nanswer")
        .replace('"stiffness 3.x"', '"frequency 1"')
        .replace("940.0", "10.9")
        .replace("9.4", "0.05")
    )
    result = call("fit", study, "--json", "-")
    assert result.exit_code == 0, result.stderr
    data = json.loads(result.stdout)
    assert data["undetermined"][0]["parameters"] == ["t", "m"]
    assert data["deviation"] == {"t": None, "m": None}
    assert data["intervals"]["t"] == [0.0, None]
    assert "do not determine" in data["warnings"][0]


@pytest.mark.slow
def test_a_model_that_does_not_fit_is_exit_1(study):
    study.write_text(STUDY.replace("prior = [0.1, 0.05]", "prior = [0.01, 1e-4]"))
    result = call("fit", study, "--json", "-")
    assert result.exit_code == 1
    assert json.loads(result.stdout)["status"] == "poor_fit"
    assert result.stderr.startswith("study.toml: poor_fit")


def of_data(text):
    """The study with other measurements."""
    return STUDY[: STUDY.index("[data.first]")] + text


def test_a_table_a_response_and_a_function(study, tmp_path):
    hertz = np.linspace(5.0, 15.0, 6)
    response: Any = np.asarray(fm.frequency_response(guide(0.5e-3, 0.1), hertz, loss_factor=0.02).of())
    rows = "\n".join(f"{f!r};{h.real!r};{h.imag!r}" for f, h in zip(hertz.tolist(), response.tolist(), strict=True))
    (tmp_path / "frf.csv").write_text(f"# measured on Monday\nHz;re;im\n{rows}\n")
    (tmp_path / "curve.csv").write_text("1e-3, 1.0\n2e-3, 2.0\n3e-3, 3.0\n")
    text = """
[data.frf]
response = true
file = "frf.csv"
columns = { hertz = "Hz", real = "re", imaginary = "im" }
relative_deviation = 0.02
loss_factor = "loss"
gain = "gain"
[data.curve]
answer = "lab:curve"
file = "curve.csv"
columns = { over = 1, values = 2 }
deviation = [0.01, 0.01, 0.02]
label = "stroke [m]"
"""
    more = "loss = { value = 0.01, lower = 1e-3, upper = 0.1 }\ngain = 1.5\noffset = 0.1\n"
    for model in ("guide.dat", "lab:guide"):
        start = STUDY[: STUDY.index("[data.first]")].replace("guide.dat", model)
        start = start.replace("w = 0.018\n", "" if ":" in model else "w = 0.018\n") + more
        study.write_text(start + text)
        read = read_fit_study(study)
        frf, curve = read.data
        assert frf.parameters == ("loss",)
        assert curve.parameters == ()
        np.testing.assert_allclose(frf.values, np.concatenate([response.real, response.imag]))
        np.testing.assert_allclose(frf.deviation, np.tile(0.02 * np.abs(response), 2))
        np.testing.assert_allclose(curve.values, [1, 2, 3])
        np.testing.assert_allclose(curve.over, [1e-3, 2e-3, 3e-3])
        made = read.build(t=0.5e-3, m=0.1)
        np.testing.assert_allclose(frf.answer(made, loss=0.02), 1.5 * np.asarray(frf.values), rtol=1e-9)
        expected = stiffness(0.5e-3) * np.array([1e-3, 2e-3, 3e-3]) + 0.1
        np.testing.assert_allclose(curve.answer(made), expected, rtol=1e-3)


def test_columns_by_number_of_a_table_with_words(study, tmp_path):
    (tmp_path / "words.csv").write_text("1e-3,1.0,up\n2e-3,2.0,up\n3e-3,3.0,down\n")
    text = "[data.c]\nanswer = 'lab:curve'\nfile = 'words.csv'\ncolumns = { values = 2 }\ndeviation = 0.1\n"
    study.write_text(of_data(text).replace("w = 0.018\n", "w = 0.018\noffset = 0.0\n"))
    (curve,) = read_fit_study(study).data
    np.testing.assert_array_equal(curve.values, [1.0, 2.0, 3.0])


TWO = "hertz,real a by f,imaginary a by f,real b by f,imaginary b by f\n5.0,1,2,3,4\n6.0,5,6,7,8\n"


@pytest.mark.parametrize(
    "choice",
    [
        "output = 'b'\ninput = 'f'",
        "output = 'b'",
        "columns = { real = 'real b by f', imaginary = 'imaginary b by f' }",
        "columns = { hertz = 1, real = 4, imaginary = 5 }",
    ],
)
def test_one_response_of_a_table_with_several(study, tmp_path, choice):
    (tmp_path / "two.csv").write_text(TWO)
    study.write_text(of_data(f"[data.r]\nresponse = true\nfile = 'two.csv'\nrelative_deviation = 0.1\n{choice}\n"))
    (response,) = read_fit_study(study).data
    np.testing.assert_array_equal(response.values, [3, 7, 4, 8])


def test_columns_override_only_what_they_name(study, tmp_path):
    (tmp_path / "both.csv").write_text("hertz,real,imaginary,m,p,deviation\n5.0,1,0,2,0.5,0.5\n6.0,1,0,3,0.5,0.5\n")
    text = "[data.r]\nresponse = true\nfile = 'both.csv'\ncolumns = { magnitude = 'm', phase = 'p' }\n"
    study.write_text(of_data(text))
    (response,) = read_fit_study(study).data
    np.testing.assert_allclose(response.values, np.outer([np.cos(0.5), np.sin(0.5)], [2, 3]).ravel(), rtol=1e-15)
    np.testing.assert_array_equal(response.deviation, 0.5)
    # A number in the study replaces a column.
    study.write_text(of_data(text + "relative_deviation = 0.1\n"))
    np.testing.assert_allclose(read_fit_study(study).data[0].deviation, [0.2, 0.3] * 2)


def test_the_quantity_of_a_universal_file_is_that_of_the_model(study, tmp_path):
    pyuff = pytest.importorskip("pyuff")
    hertz = np.linspace(5.0, 15.0, 11)
    values = -((2 * np.pi * hertz) ** 2) * np.asarray(fm.frequency_response(guide(0.5e-3, 0.1), hertz).of())
    one = pyuff.prepare_58(
        func_type=4, rsp_node=3, rsp_dir=1, ref_node=3, ref_dir=1, data=values, x=hertz, id1="hammer",
        rsp_ent_name="NONE", ref_ent_name="NONE", abscissa_spacing=1, binary=0, ordinate_spec_data_type=12,
        abscissa_spec_data_type=18, orddenom_spec_data_type=13,
    )  # fmt: skip
    pyuff.UFF(str(tmp_path / "hammer.uff")).write_sets([one], "overwrite")
    text = "[data.frf]\nresponse = true\nfile = 'hammer.uff'\nrelative_deviation = 0.01\n"
    study.write_text(of_data(text).replace(", prior = [0.1, 0.05]", ""))
    result = call("fit", study)
    assert result.exit_code == 2
    assert "has the acceleration of an output, but the output of the model is of the quantity position" in result.stderr


@pytest.mark.parametrize(
    ("rsp_dir", "ref_dir", "kind"), [(-1, 1, "output along"), (1, -1, "input along"), (-1, -1, "")]
)
def test_a_universal_file_against_an_axis_is_refused(study, tmp_path, rsp_dir, ref_dir, kind):
    """The sign of the response would be wrong; two signs cancel."""
    pyuff = pytest.importorskip("pyuff")
    hertz = np.linspace(5.0, 15.0, 11)
    one = pyuff.prepare_58(
        func_type=4, rsp_node=3, rsp_dir=rsp_dir, ref_node=3, ref_dir=ref_dir, data=hertz + 1j, x=hertz, id1="hammer",
        rsp_ent_name="NONE", ref_ent_name="NONE", abscissa_spacing=1, binary=0, ordinate_spec_data_type=8,
        abscissa_spec_data_type=18, orddenom_spec_data_type=13,
    )  # fmt: skip
    pyuff.UFF(str(tmp_path / "turned.uff")).write_sets([one], "overwrite")
    study.write_text(of_data("[data.frf]\nresponse = true\nfile = 'turned.uff'\ndeviation = 0.01\n"))
    (frf,) = read_fit_study(study).data
    refused = pytest.raises(ValueError, match=f"{kind} -x") if kind else contextlib.nullcontext()
    with refused:
        frf.check(guide(0.5e-3, 0.1))


@pytest.mark.slow
def test_a_universal_file(study, tmp_path):
    pytest.importorskip("pyuff")
    hertz = np.linspace(5.0, 15.0, 11)
    found = fm.frequency_response(guide(0.5e-3, 0.1), hertz, loss_factor=0.02)
    found.save(tmp_path / "frf.uff")
    text = "[data.frf]\nresponse = true\nfile = 'frf.uff'\nrelative_deviation = 0.01\n"
    text += "loss_factor = 0.02\nlogarithmic = true\n"
    study.write_text(of_data(text).replace(", prior = [0.1, 0.05]", ""))
    data = json.loads(call("fit", study, "--json", "-").stdout)
    assert data["status"] == "ok"
    assert data["parameters"] == pytest.approx({"t": 0.5e-3, "m": 0.1}, rel=1e-6)


def test_one_kind_of_magnitude_and_phase(study):
    values = "hertz = [5.0, 6.0]\nmagnitude = [1e-3, 2e-3]\nphase = [0.0, -1.5]\n"
    study.write_text(of_data(f"[data.frf]\nresponse = true\n{values}deviation = 1e-5\nlogarithmic = true\n"))
    (frf,) = read_fit_study(study).data
    np.testing.assert_allclose(frf.deviation, [1e-2, 5e-3] * 2)


# The measurements, and what the one line says. The first five are faults of data that a laboratory makes.
CURVE = "[data.drive]\nanswer = 'stiffness 3.x'\n"
FAULTS = [
    (CURVE + "values = 0.94\ndeviation = 0.01", "'drive' are about 0.0014 times the values"),
    (
        "[data.f]\nmodes = true\nvalues = [10.9]\ndeviation = 0.1\nshapes = [[1.0], [-1.0]]\nat = ['3.x', '5.x']",
        "Mode 1 of measurement 'f', 10.9 Hz, has no partner",
    ),
    ("[data.c]\nanswer = 'lab:curve'\nfile = 'nan.csv'\ndeviation = 0.1", "'nan.csv', line 3: values is 'nan'"),
    ("[data.c]\nanswer = 'lab:curve'\nvalues = [1.0, nan, 2.0]\ndeviation = 0.1", "values must be a finite number"),
    (CURVE + "values = 940.0\ndeviation = 9.0", "2 parameters cannot be fitted to 1 values"),
    (CURVE + "values = 940.0\ndeviation = -9.0", "'drive' has a deviation of -9"),
    (CURVE + "values = 940.0\ncovariance = [[-81.0]]", "covariance that is not positive definite"),
    (CURVE + "deviation = 9.0", "[data] drive: give values"),
    (CURVE + "values = 940.0\nscatter = 9.0", "[data] drive: there is no 'scatter'"),
    ("[data.drive]\nvalues = 940.0", "[data] drive must be a table with one of answer, modes, response"),
    ("[data.drive]\nanswer = 'stifness 3.x'\nvalues = 940.0\ndeviation = 1.0", "[data] drive: "),
    (CURVE + "values = 940.0\nrelative_deviation = 0.1\ndeviation = 9.0", "deviation and relative_deviation"),
    (CURVE + "file = 'absent.csv'", "cannot read"),
    (
        CURVE + "file = 'nan.csv'\ncolumns = { values = 'force' }",
        "has no column 'force'. Its columns are: over, values",
    ),
    (CURVE + "file = 'nan.csv'\ncolumns = { forces = 'force' }", "there is no 'forces' in columns"),
    (CURVE + "values = 1.0\nfile = 'short.csv'", "'short.csv' has no column values or deviation"),
    (CURVE + "file = 'short.csv'\ncolumns = { values = 3 }", "'short.csv', line 1: there is no column 3 for values"),
    (CURVE + "values = 940.0\ncolumns = { values = 1 }", "columns belong to a file"),
    ("[data.r]\nresponse = true\nhertz = [1.0]\nreal = [1.0]", "[data] r: give imaginary"),
    ("[data.r]\nresponse = true\nfile = 'short.uff'", "short.uff"),
    (CURVE + "file = 'short.uff'", "a universal file has frequency responses"),
    (
        "[data.c]\nanswer = 'lab:curve'\nfile = 'gap.csv'\ncolumns = { values = 2 }\ndeviation = 0.1",
        "'gap.csv', line 1: values is empty",
    ),
    (
        "[data.c]\nanswer = 'lab:curve'\nfile = 'head.csv'\ncolumns = { values = 1 }",
        "'head.csv' has no line of numbers",
    ),
    (
        "[data.r]\nresponse = true\nhertz = [5.0]\nmagnitude = [-60.0]\nphase = [0.0]\ndeviation = 1.0",
        "a magnitude is -60, but cannot be negative",
    ),
    (
        "[data.r]\nresponse = true\nhertz = [5.0]\nmagnitude = [1.0]\nphase = [-178.0]\ndeviation = 1.0",
        "a phase is -178, more than two turns. Phases are in radians",
    ),
    ("[data.f]\nmodes = true\nvalues = [40.0, 10.9]\ndeviation = 0.1", "has 40 Hz for mode 1 and"),
    # Decimal commas, and units that the name of a column states.
    (CURVE + "file = 'commas.csv'", "'commas.csv', line 2 has 4 cells for 2 columns. Numbers need a decimal point"),
    (CURVE + "file = 'german.csv'", "'german.csv', line 2: values is '940,0', which is no finite number. Numbers need"),
    (
        "[data.r]\nresponse = true\nfile = 'degrees.csv'\n"
        "columns = { hertz = 'f', magnitude = 'm', phase = 'p [deg]' }",
        "'degrees.csv': column 'p [deg]' has another unit. Convert phase to rad",
    ),
    (CURVE + "file = 'degrees.csv'", "has no column values or deviation or over. Its columns are: f, m, p [deg]."),
    ("[data.r]\nresponse = true\nfile = 'two.csv'", "'two.csv' has the responses a by f, b by f. Choose one by output"),
    ("[data.r]\nresponse = true\nfile = 'two.csv'\noutput = 'c'", "has the responses a by f, b by f. Choose one"),
    (
        "[data.r]\nresponse = true\nfile = 'degrees.csv'\ncolumns = { magnitude = 'm' }",
        "give hertz, or a file with this column. The columns of the file are: f, m, p [deg].",
    ),
    (
        "[data.r]\nresponse = true\nfile = 'two.csv'\noutput = 'b'\nrelative_deviation = 0.1\nloss_factor = 'lossy'",
        "[data] r: there is no parameter 'lossy' (t, m, w).",
    ),
    (CURVE + "values = 940.0\n[fit]\nlevel = 95.0", "[fit] level must be below 1"),
    (CURVE + "values = 940.0\n[fit]\nloss = 'l1'", "[fit] loss must be"),
]


@pytest.mark.parametrize(("text", "words"), FAULTS)
def test_each_fault_is_one_line(study, tmp_path, text, words):
    (tmp_path / "nan.csv").write_text("over,values\n1e-3,1.0\n2e-3,nan\n3e-3,3.0\n")
    (tmp_path / "short.csv").write_text("1.0,2.0\n3.0\n")
    (tmp_path / "short.uff").write_text("")
    (tmp_path / "gap.csv").write_text("1e-3,,a\n2e-3,2.0,b\n3e-3,3.0,c\n4e-3,4.0,d\n")
    (tmp_path / "head.csv").write_text("over,values\n")
    (tmp_path / "commas.csv").write_text("values,deviation\n940,0,9,4\n")
    (tmp_path / "german.csv").write_text("values;deviation\n940,0;9,4\n")
    (tmp_path / "two.csv").write_text(TWO)
    (tmp_path / "degrees.csv").write_text("f,m,p [deg]\n5.0,1.0,-2.5\n")
    given = of_data(text)
    if "curve" in text:
        given = given.replace("w = 0.018\n", "w = 0.018\noffset = 0.0\n")
    if "cannot be fitted" in words:
        given = given.replace(", prior = [0.1, 0.05]", "")
    study.write_text(given)
    result = call("fit", study)
    assert result.exit_code == 2, result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert result.stderr.startswith("flexmb: study.toml: ")
    assert words in result.stderr


PARAMETERS = [
    ("w = 0.018", "w = 0.018\nx = { value = 1.0, lower = 0.5, upper = 2.0 }", "[parameters] x: 'guide.dat' has no {x}"),
    ("prior = [0.1, 0.05]", "prior = [0.1, -0.05]", "[parameters] m: prior must be positive"),
    ("prior = [0.1, 0.05]", "prior = 0.1", "list of mean and standard deviation"),
    ("w = 0.018", "w = { value = 0.018, prior = [0.018, 1e-4] }", "[parameters] w: a prior needs lower and upper"),
    ("[data.first]", "[choices]\nw = [0.018]\n[data.first]", "[choices]: a fit has no choices"),
    ("value = 0.45e-3", "value = 4.5", "is outside its bounds"),
]


@pytest.mark.parametrize(("old", "new", "words"), PARAMETERS)
def test_wrong_parameters_are_one_line(study, old, new, words):
    study.write_text(STUDY.replace(old, new))
    result = call("fit", study)
    assert result.exit_code == 2, result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert words in result.stderr


def test_a_file_may_hold_a_design_study_too(study):
    from flexmb.design.study_file import read_study

    study.write_text(STUDY + "[answers]\nf = { frequency = 1 }\n[sweep]\npoints = 2\n")
    assert list(read_study(study).answers) == ["f"]
    assert [item.name for item in read_fit_study(study).data] == ["first", "drive"]
