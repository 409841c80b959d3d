"""Functional mock-up units: read by fmpy, run, and compared with SciPy and python-control."""

import ctypes
import itertools
import re
import subprocess
import zipfile
from pathlib import Path
from typing import Any

import control
import fmpy
import numpy as np
import pytest
import scipy.linalg
from cases.commands import command
from cases.motions import height_behind_the_stop, sprung_mass, thrown_at_a_stop
from cases.tolerances import approx
from cases.units import opened, simulated
from fmpy.validation import validate_fmu
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import flexmb as fm
from flexmb import planar
from flexmb.errors import FlexmbWarning
from flexmb.fmu import plant as plants
from flexmb.fmu.plant import Plant, Variable
from flexmb.fmu.save import compiler_command, shared_library
from flexmb.mechanisms import mechanism_path
from flexmb.trajectory import TimeVarying

needs_compiler = pytest.mark.skipif(
    compiler_command() is None, reason="there is no C compiler: install gcc, or set $CC"
)
HEADERS = Path(fmpy.__file__).parent / "c-code"


def oscillators(hertz, damping=0.01, through=0.0) -> Any:
    """Masses of 1 kg, driven by one force and by what else acts on the first; the sum of positions, and one rate."""
    w = 2 * np.pi * np.asarray(hertz)
    n = len(w)
    a = np.block([[np.zeros((n, n)), np.eye(n)], [-np.diag(w**2), -2 * damping * np.diag(w)]])
    b = np.zeros((2 * n, 2))
    b[n:, 0], b[n, 1] = 1.0, 0.3
    c = np.zeros((2, 2 * n))
    c[0, :n], c[1, n] = 1.0, 1.0
    d = np.array([[through, 0.0], [0.0, -through]])
    states = [f"q{i}" for i in range(n)] + [f"d q{i}" for i in range(n)]
    return control.StateSpace(a, b, c, d, inputs=["force", "push"], outputs=["place", "rate"], states=states)


def swaying(n_t=9):
    """A system whose matrices are no polynomials, with nominal inputs and outputs."""
    t = np.array([0.0, 0.11, 0.2, 0.33, 0.41, 0.55, 0.68, 0.8, 1.0])[:n_t]
    a = np.array([[[0, 1], [-90 - 40 * np.sin(4 * s), -0.4 - 0.2 * s]] for s in t])
    b = np.array([[[0.0], [1.5 + np.cos(3 * s)]] for s in t])
    c = np.array([[[1 + 0.3 * np.sin(s), 0.1 * s]] for s in t])
    d = np.array([[[0.02 * np.cos(5 * s)]] for s in t])
    u0, y0 = np.array([[np.sin(2 * s)] for s in t]), np.array([[0.5 * s**3] for s in t])
    m = np.ones((n_t, 1, 1))
    names = {"state_labels": ("q", "d q"), "input_labels": ("torque",), "output_labels": ("angle",)}
    return TimeVarying(t, a, b, c, d, m, u0, y0, np.zeros(2), np.zeros((n_t, 0)), None, None, None, **names)


def sprung_stage():
    b = fm.Builder()
    b.node("ground", (0, 0))
    b.node("stage", (0.1, 0))
    b.add(planar.truss, "ground", "stage", name="s", section=fm.Rigidity(EA=90.0 * 0.1))
    b.fix("ground")
    b.fix("stage", "y")
    b.dof("stage", "x")
    b.mass("stage", 0.4)
    b.input("stage", "x")
    b.input("stage", "x", name="stage.x")
    for quantity in ("position", "velocity", "acceleration"):
        b.output("stage", "x", quantity)
    b.output("stage", "x", name="stage.x")
    b.output("s", 1, "stress")
    return b.build()


@pytest.mark.slow("3")
@needs_compiler
@pytest.mark.parametrize("fmi", [2, 3])
def test_units_are_valid_and_say_what_their_signals_are(fmi, tmp_path):
    path = tmp_path / "stage.fmu"
    found = fm.save_fmu(sprung_stage(), path, fmi=fmi, start={"stage.x": 1e-3})
    assert validate_fmu(str(path)) == []
    told = fmpy.read_model_description(str(path))
    units = {v.name: v.unit for v in told.modelVariables}
    expected = {
        # What an input and an output share is told apart.
        **{"time": "s", "force stage.x": "N", "input stage.x": "N", "output stage.x": "m", "position stage.x": "m"},
        **{"velocity stage.x": "m/s", "acceleration stage.x": "m/s2", "stress s.1": None, "state stage.x": "m"},
        **{"absolute position stage.x": "m"},
        **{"state d stage.x": "m/s", "der(state stage.x)": "m/s", "der(state d stage.x)": "m/s2"},
    }
    assert {name: units[name] for name in expected} == expected
    starts = {v.name: v.start for v in told.modelVariables}
    assert starts["state stage.x"] == "0.001"
    own = [starts["A[2,1]"]] if fmi == 2 else str(starts["A"]).split()[2:3]
    np.testing.assert_allclose(float(*own), -90.0 / 0.4, rtol=1e-12)
    # Displacements have absolute positions beside them.
    descriptions = {v.name: v.description for v in told.modelVariables}
    for name in ("output stage.x", "position stage.x", "state stage.x"):
        assert descriptions[name] == "Displacement from the static equilibrium"
    assert descriptions["absolute position stage.x"] == "'position stage.x' plus 0.1 m"
    assert not any(name.startswith("absolute velocity") for name in descriptions)
    # Without a D outputs wait for the states, so that importers see no loop.
    fm.save_fmu(oscillators([1.0]), path, fmi=fmi)
    outputs = fmpy.read_model_description(str(path)).outputs
    assert [v.name for v in outputs[0].dependencies or ()] == ["state q0", "state d q0"]
    assert found.binary
    assert "binaries/" in str(found)


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("through", [0.0, 0.7])
def test_co_simulation_of_a_linear_plant_is_exact(fmi, through, tmp_path):
    """Modes from 12 Hz to 25 kHz in steps of a millisecond, against SciPy's exponential of the modes one by one."""
    system = oscillators([12.0, 800.0, 25e3], through=through)
    path, inputs = tmp_path / "stiff.fmu", {"force": 2.0, "push": -1.0}
    fm.save_fmu(system, path, fmi=fmi, start=[1e-3, 0, 0, 0, 0.2, 0])
    found = simulated(path, "cs", 0.2, 1e-3, inputs)
    u = np.repeat([[2.0], [-1.0]], 201, axis=1)
    x, states = np.array([1e-3, 0, 0, 0, 0.2, 0]), []
    # Each mode on its own: x(t) = e^(A t) (x0 - xs) + xs about its deflection at rest.
    rest = -np.linalg.solve(system.A, system.B @ u[:, 0])
    for t in np.linspace(0, 0.2, 201):
        moved = np.zeros(6)
        for i in range(3):
            own = [i, i + 3]
            moved[own] = scipy.linalg.expm(system.A[np.ix_(own, own)] * t) @ (x - rest)[own] + rest[own]
        states.append(moved)
    y = np.array(states) @ system.C.T + u.T @ system.D.T
    # Of its largest value; 200 steps, of a matrix that is balanced before it is squared.
    for name, own in zip(("place", "rate"), y.T, strict=True):
        np.testing.assert_allclose(found[name], own, atol=1e-9 * np.max(np.abs(own)))


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("fmi", [2, 3])
def test_model_exchange_of_a_linear_plant(fmi, tmp_path):
    """By fmpy's CVode against python-control, and rates at drawn states against the matrices."""
    system = oscillators([1.5, 4.0], damping=0.05, through=0.3)
    path = tmp_path / "soft.fmu"
    fm.save_fmu(system, path, fmi=fmi, start={"q0": 0.02})
    found = simulated(path, "me", 1.0, 0.02, {"force": 1.0, "push": 0.5}, relative_tolerance=1e-13)
    u = np.repeat([[1.0], [0.5]], 51, axis=1)
    expected = control.forced_response(system, np.linspace(0, 1, 51), u, initial_state=[0.02, 0, 0, 0]).outputs
    # CVode's own error, of a tolerance of 1e-13 a step.
    for name, own in zip(("place", "rate"), expected, strict=True):
        np.testing.assert_allclose(found[name], own, atol=1e-9 * np.max(np.abs(own)))
    rng = np.random.default_rng(3)
    x, u = rng.normal(size=4), rng.normal(size=2)
    with opened(path, tmp_path / "me", "me") as unit:
        for name, value in zip(("q0", "q1", "d q0", "d q1"), x, strict=True):
            unit.set(f"state {name}", value)
        unit.set("force", u[0])
        unit.set("push", u[1])
        rates = [unit.get(f"der(state {name})")[0] for name in ("q0", "q1", "d q0", "d q1")]
        np.testing.assert_allclose(rates, system.A @ x + system.B @ u, rtol=1e-14)
        # Of rates and outputs by a state, an input and an entry of a matrix: 2 x 1 x 1 columns, each exact.
        by_state = unit.derivative(["der(state d q1)", "place"], ["state q1", "push"], [1.0, 2.0])
        expected = system.A[3, 1] + 2 * system.B[3, 1], system.C[0, 1] + 2 * system.D[0, 1]
        np.testing.assert_allclose(by_state, expected, rtol=1e-14)
        if fmi == 2:
            by_entry = unit.derivative(["der(state d q1)"], ["A[4,2]"], [1.0])
            np.testing.assert_allclose(by_entry, [x[1]], rtol=1e-14)


def integrated(system, times, u, start, rtol=1e-13):
    """The time-varying system by SciPy's splines and its integration of order eight, from knot to knot."""
    splines = {name: CubicSpline(system.t, getattr(system, name)) for name in ("A", "B", "C", "D", "u0", "y0")}

    def rates(t, x):
        return splines["A"](t) @ x + splines["B"](t) @ (u - splines["u0"](t))

    states, x = [], np.asarray(start, float)
    knots = np.unique([*times, *np.asarray(system.t)])
    found = {knots[0]: x}
    for a, b in itertools.pairwise(knots):
        x = solve_ivp(rates, (a, b), x, "DOP853", rtol=rtol, atol=1e-15).y[:, -1]
        found[b] = x
    states = np.array([found[t] for t in times])
    y = [
        splines["y0"](t) + splines["C"](t) @ x + splines["D"](t) @ (u - splines["u0"](t))
        for t, x in zip(times, states, strict=True)
    ]
    return states, np.array(y)


@pytest.mark.slow("3")
@needs_compiler
@pytest.mark.parametrize("fmi", [2, 3])
def test_time_varying_plant_agrees_with_an_independent_integration(fmi, tmp_path):
    """1e-9 with short substeps, sixteen times less error where they are halved; rates and outputs at drawn states."""
    system, path = swaying(), tmp_path / "ltv.fmu"
    saved = fm.save_fmu(system, path, fmi=fmi, start={"q": 0.1}, units={"torque": "N.m", "angle": "rad"})
    assert validate_fmu(str(path)) == []
    assert [v.name for v in saved.outputs] == ["angle", "nominal torque", "nominal angle"]
    times = np.linspace(0, 1, 8)
    states, y = integrated(system, times, np.array([0.7]), [0.1, 0.0])
    last = {}
    for count in (20, 40, 640):
        options = {"start_values": {"substep": 1 / count}, "output": ["angle", "state q", "nominal angle"]}
        found = simulated(path, "cs", 1.0, 1 / 7, {"torque": 0.7}, **options)
        last[count] = np.max(np.abs(found["state q"] - states[:, 0]))
        if count == 640:
            np.testing.assert_allclose(found["angle"], y[:, 0], atol=1e-9)
            expected = CubicSpline(system.t, system.y0)(times)[:, 0]
            np.testing.assert_allclose(found["nominal angle"], expected, atol=1e-14)
    assert last[640] < 1e-9
    # Substeps are cut at knots, so that their number is not quite doubled.
    assert 11 < last[20] / last[40] < 23
    with opened(path, tmp_path / "me", "me") as unit:
        for t in (0.0, 0.157, 0.9, 1.0):
            unit.own.setTime(t)
            unit.set("torque", -0.3)
            unit.set("state d q", 0.4)
            m = {name: CubicSpline(system.t, getattr(system, name))(t) for name in ("A", "B", "C", "D", "u0", "y0")}
            x, u = np.array([0.1, 0.4]), -0.3 - m["u0"]
            np.testing.assert_allclose(unit.get("der(state d q)"), (m["A"] @ x + m["B"] @ u)[1:], rtol=1e-13)
            np.testing.assert_allclose(unit.get("angle"), m["y0"] + m["C"] @ x + m["D"] @ u, rtol=1e-13)
        # Of a rate by a state, the input and an entry of B at a knot, and of what is nominal by its entry in the table.
        unit.own.setTime(0.33)
        entry = ["B[4,2,1]"] if fmi == 2 else []
        found = unit.derivative(["der(state d q)"], ["state q", "torque", *entry], [1.0, 2.0, *([3.0] * len(entry))])
        expected = system.A[3, 1, 0] + 2 * system.B[3, 1, 0] + 3 * len(entry) * (-0.3 - system.u0[3, 0])
        np.testing.assert_allclose(found, [expected], rtol=1e-13)
        if fmi == 2:
            found = unit.derivative(["nominal angle", "angle", "der(state d q)"], ["y0[4,1]", "u0[4,1]"], [1.0, 2.0])
            expected = [1.0, 1 - 2 * system.D[3, 0, 0], -2 * system.B[3, 1, 0]]
            np.testing.assert_allclose(found, expected, rtol=1e-13)
        # Beyond the last knot all stays as it is there.
        unit.own.setTime(7.0)
        np.testing.assert_allclose(unit.get("nominal angle"), system.y0[-1], rtol=1e-15)


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("n_t", [2, 3, 4])
def test_splines_through_few_knots(n_t, tmp_path):
    """Where SciPy takes a line, a parabola and one cubic."""
    system, path = swaying(n_t), tmp_path / "few.fmu"
    fm.save_fmu(system, path)
    with opened(path, tmp_path / "me", "me") as unit:
        for t in np.linspace(0, system.t[-1], 5):
            unit.own.setTime(t)
            np.testing.assert_allclose(
                unit.get("nominal torque"), CubicSpline(system.t, system.u0)(t), rtol=1e-12, atol=1e-15
            )


@pytest.mark.slow("3")
@needs_compiler
@pytest.mark.parametrize("fmi", [2, 3])
def test_matrices_can_be_set_and_a_state_kept(fmi, tmp_path):
    system, path = oscillators([3.0]), tmp_path / "one.fmu"
    fm.save_fmu(system, path, fmi=fmi, start=[0.1, 0.0])
    # Stiffer, as A[2,1]; between two steps, so that the exponential kept for the first is of no use.
    stiffer = np.array(system.A)
    stiffer[1, 0] *= 4
    with opened(path, tmp_path / "cs") as unit:
        unit.own.doStep(0.0, 0.01)
        kept = unit.own.getFMUState()
        before = unit.get("state q0")
        if fmi == 2:
            unit.set("A[2,1]", stiffer[1, 0])
        else:
            np.testing.assert_array_equal(unit.get("A", 4), np.ravel(system.A))
            unit.set("A", *np.ravel(stiffer))
        unit.own.doStep(0.01, 0.01)
        x = scipy.linalg.expm(stiffer * 0.01) @ scipy.linalg.expm(system.A * 0.01) @ [0.1, 0.0]
        np.testing.assert_allclose(unit.get("state q0"), x[:1], rtol=1e-13)
        # Back to where it was, matrices too, also by way of bytes.
        bytes_of = unit.own.serializeFMUState(kept)
        unit.own.setFMUState(unit.own.deserializeFMUState(bytes_of))
        np.testing.assert_array_equal(unit.get("state q0"), before)
        unit.own.doStep(0.01, 0.01)
        x = scipy.linalg.expm(system.A * 0.02) @ [0.1, 0.0]
        np.testing.assert_allclose(unit.get("state q0"), x[:1], rtol=1e-13)
        unit.own.freeFMUState(kept)
        unit.own.reset()
        np.testing.assert_array_equal(unit.get("state q0"), [0.1])


@pytest.mark.slow("3")
@needs_compiler
@pytest.mark.parametrize("fmi", [2, 3])
def test_large_matrices_lie_in_a_file_beside(fmi, tmp_path, monkeypatch):
    """In a folder whose name an address has to write otherwise."""
    monkeypatch.setattr("flexmb.fmu.save.MOST_SETTABLE", {2: 10, 3: 10})
    system, path = oscillators([3.0, 5.0]), tmp_path / "large.fmu"
    saved = fm.save_fmu(system, path, fmi=fmi, start=[0.1, 0, 0, 0])
    assert saved.parameters == ()
    assert validate_fmu(str(path)) == []
    with opened(path, tmp_path / "a b%ü") as unit:
        unit.own.doStep(0.0, 0.01)
        x = scipy.linalg.expm(system.A * 0.01) @ [0.1, 0, 0, 0]
        np.testing.assert_allclose(unit.get("state q0"), x[:1], rtol=1e-13)
        (tmp_path / "a b%ü" / "resources" / "matrices.bin").unlink()
        with pytest.raises(Exception, match=r"nstantiat"):
            unit.own.instantiate()


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("fmi", [2, 3])
def test_sources_compile_alone_and_export_all_functions_of_the_standard(fmi, tmp_path, monkeypatch):
    system, path = swaying(), tmp_path / "twice.fmu"
    fm.save_fmu(system, path, fmi=fmi)
    once = path.read_bytes()
    fm.save_fmu(system, path, fmi=fmi)
    assert path.read_bytes() == once
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path / "out")
        (binary,) = [name for name in archive.namelist() if name.startswith("binaries/")]
    sources = tmp_path / "out" / "sources"
    header = (HEADERS / f"fmi{fmi}Functions.h").read_text()
    functions = set(re.findall(rf"^ *FMI{fmi}_Export fmi\w+TYPE +(fmi{fmi}\w+);", header, re.MULTILINE))
    assert len(functions) == {2: 44, 3: 75}[fmi]
    strict = "-std=c99 -Wall -Wextra -Wpedantic -Werror -fPIC -shared".split()
    for kept in ({}, {"SETTABLE": 0}, {"N_T": 1}):
        text = (sources / "data.h").read_text()
        for name, value in kept.items():
            text = re.sub(rf"(#define {name}) \d+", rf"\1 {value}", text)
        # Of a linear plant no times are written.
        text = text.partition("static const double TIMES")[0] if kept.get("N_T") == 1 else text
        (tmp_path / "data.h").write_text(text)
        for file in sources.glob("*.c"):
            (tmp_path / file.name).write_bytes(file.read_bytes())
        call = [*(compiler_command() or []), *strict, "-o", "all.so", f"fmi{fmi}.c", "-lm"]
        run = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert run.returncode == 0, run.stderr
    listed = subprocess.run(["nm", "-D", "--defined-only", tmp_path / "all.so"], capture_output=True, text=True)
    assert functions <= set(listed.stdout.split())
    # What a reader of the sources compiles computes the same.
    found = simulated(path, "cs", 1.0, 0.1, {"torque": 0.7})
    library, _ = shared_library({file.name: file.read_bytes() for file in sources.iterdir()}, f"fmi{fmi}.c")
    assert library == (tmp_path / "out" / binary).read_bytes()
    assert np.ptp(found["angle"]) > 0


@needs_compiler
@pytest.mark.parametrize("fmi", [2, 3])
def test_what_an_importer_does_wrong_is_told(fmi, tmp_path):
    path = tmp_path / "one.fmu"
    fm.save_fmu(oscillators([3.0]), path, fmi=fmi)
    with opened(path, tmp_path / "cs") as unit:
        for wrong in (
            lambda: unit.own.doStep(0.5, 0.1),
            lambda: unit.own.doStep(0.0, -0.1),
            lambda: unit.set("place", 1.0),
            lambda: unit.derivative(["place"], ["rate"], [1.0]),
        ):
            with pytest.raises(Exception, match=f"fmi{fmi}"):
                wrong()
        if fmi == 3:
            assert unit.said[0] == "A step must go forward, from the time at which the last one ended."
            assert unit.said[2].startswith("Inputs, states and parameters alone can be set")
        unit.own.guid = "{00000000-0000-0000-0000-000000000000}"
        with pytest.raises(Exception, match=r"nstantiat"):
            unit.own.instantiate()


def test_without_a_compiler_a_unit_holds_sources_and_says_so(tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "/no/such/cc")
    path = tmp_path / "bare.fmu"
    with pytest.warns(
        FlexmbWarning, match=r"'bare' contains only its sources, since there is no C compiler '/no/such/cc'"
    ):
        saved = fm.save_fmu(oscillators([1.0]), path)
    assert saved.binary is None
    assert validate_fmu(str(path)) == []
    names = zipfile.ZipFile(path).namelist()
    assert names[0] == "modelDescription.xml"
    assert {"sources/core.c", "sources/fmi3.c", "sources/data.h", "sources/buildDescription.xml"} <= set(names)
    assert not any(name.startswith("binaries") for name in names)


def test_a_compiler_that_refuses_is_quoted(tmp_path, monkeypatch):
    program = tmp_path / "cc"
    program.write_text("#!/bin/sh\necho 'in file: data.h' >&2; echo 'data.h:1: error: no' >&2; touch library; exit 1\n")
    program.chmod(0o755)
    monkeypatch.setenv("CC", str(program))
    with pytest.warns(FlexmbWarning, match=r"since .*cc refused them: data\.h:1: error: no\. Simulink"):
        assert fm.save_fmu(oscillators([1.0]), tmp_path / "bare.fmu").binary is None


PENDULUM = """
static int plant(const double *p, double t, const double *x, const double *u, double *xdot, double *y,
                 double *memory, double *work) {
    (void)t, (void)work;
    memory[0] += 1;
    xdot[0] = x[1];
    xdot[1] = -p[0] * sin(x[0]) - 0.1 * x[1] + u[0] + 0.3 * cos(2 * t) - 1e6 * (x[2] - x[0]) * 0;
    xdot[2] = -1e6 * (x[2] - cos(x[0]));
    y[0] = x[0] + 2 * u[0];
    y[1] = memory[0];
    return fabs(x[0]) > 100;
}
"""


@pytest.mark.slow("3")
@needs_compiler
@pytest.mark.parametrize("fmi", [2, 3])
def test_a_nonlinear_plant_by_its_own_integrator(fmi, tmp_path):
    """A pendulum with a state that follows it within a microsecond, against SciPy's Radau."""
    states = (Variable("q", start=2.0), Variable("d q"), Variable("fast", start=np.cos(2.0)))
    plant = Plant(
        (Variable("torque", "N.m"),),
        (Variable("angle", "rad"), Variable("calls")),
        states,
        parameters=(Variable("stiffness", start=30.0),),
        source=PENDULUM,
        memory=(0.0,),
        work=4,
    )
    path = tmp_path / "pendulum.fmu"
    fm.save_fmu(plant, path, fmi=fmi)
    assert validate_fmu(str(path)) == []

    def rates(t, x):
        swing = -20.0 * np.sin(x[0]) - 0.1 * x[1] + 0.5 + 0.3 * np.cos(2 * t)
        return [x[1], swing, -1e6 * (x[2] - np.cos(x[0]))]

    times = np.linspace(0, 2, 21)
    expected = solve_ivp(rates, (0, 2), [2.0, 0.0, np.cos(2.0)], "Radau", times, rtol=1e-10, atol=1e-12).y
    options = {"start_values": {"stiffness": 20.0}, "relative_tolerance": 1e-9}
    found = simulated(path, "cs", 2.0, 0.1, {"torque": 0.5}, output=["angle", "calls", "state fast"], **options)
    # A hundred times the tolerance, over two swings.
    np.testing.assert_allclose(found["angle"], expected[0] + 1.0, atol=1e-7)
    np.testing.assert_allclose(found["state fast"], expected[2], atol=1e-7)
    # Some 250 steps of as many evaluations as there are stages, states and times; a wrong Jacobian takes far more.
    assert found["calls"][-1] < 6000
    with opened(path, tmp_path / "me", "me") as unit:
        np.testing.assert_allclose(unit.derivative(["angle"], ["state q", "torque"], [1.0, 1.0]), [3.0], rtol=1e-9)


@pytest.mark.slow
@needs_compiler
def test_a_nonlinear_mechanism_moves_as_newton_says(tmp_path):
    """A mass on a spring that swings about its foot, under a force across: m r'' = -k (1 - L/|r|) r + F."""
    stiffness, length, mass = 90.0, 0.1, 0.4
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("mass", (length, 0))
    b.add(planar.truss, "foot", "mass", name="s", section=fm.Rigidity(EA=stiffness * length))
    b.fix("foot")
    b.mass("mass", mass)
    for axis, rate in (("x", 0.0), ("y", 0.3)):
        b.dof("mass", axis)
        b.start("mass", axis, 0.01, rate)
        b.input("mass", axis)
        b.output("mass", axis)
    path = tmp_path / "swing.fmu"
    saved = fm.save_fmu(b.build(), path, nonlinear=True, start={"mass.x": 0.02})
    assert validate_fmu(str(path)) == []
    assert [(v.name, v.unit, v.start) for v in saved.states] == [
        ("state mass.x", "m", 0.02),
        ("state mass.y", "m", 0.01),
        ("state d mass.x", "m/s", 0.0),
        ("state d mass.y", "m/s", 0.3),
    ]
    force = np.array([0.5, -2.0])

    def rates(t, x):
        r = np.add(x[:2], (length, 0))
        return [*x[2:], *((force - stiffness * (1 - length / np.hypot(*r)) * r) / mass)]

    x = np.array([0.05, -0.3, 0.2, 1.1])
    with opened(path, tmp_path / "me", "me") as unit:
        unit.own.setContinuousStates((ctypes.c_double * 4)(*x), 4)
        for name, value in zip("xy", force, strict=True):
            unit.set(f"force mass.{name}", value)
        found = [unit.get(f"der(state d mass.{name})")[0] for name in "xy"]
        np.testing.assert_allclose(found, rates(0, x)[2:], rtol=1e-12)
    times = np.linspace(0, 0.5, 6)
    expected = solve_ivp(rates, (0, 0.5), [0.02, 0.01, 0, 0.3], "DOP853", times, rtol=1e-12, atol=1e-14).y
    inputs = dict(zip(("force mass.x", "force mass.y"), force, strict=True))
    found = simulated(path, "cs", 0.5, 0.1, inputs, relative_tolerance=1e-8)
    # A hundred times the tolerance, of a swing of 0.1 m.
    np.testing.assert_allclose(found["position mass.y"], expected[1], atol=1e-7)
    with pytest.raises(ValueError, match=r"a Model as it is\. Leave out `modes`\.$"):
        fm.save_fmu(b.build(), path, nonlinear=True, modes=1)
    with pytest.raises(ValueError, match=r"for a Model, not a Linearization\..* damp the elements"):
        fm.save_fmu(fm.damped(b.build(), ratio=0.01), path, nonlinear=True)
    with pytest.raises(ValueError, match="give nonlinear=True"):
        fm.save_fmu(b.build(), path, loads={"mass.x": np.sin})


@pytest.mark.slow
@needs_compiler
def test_a_stop_that_is_met_and_left_within_one_step_of_co_simulation_throws_back(tmp_path):
    """Of a free flight any step is exact, so that its error tells nothing of a stop within it."""
    b = thrown_at_a_stop(0.44)
    b.input("mass", "y", name="push")
    b.output("mass", "y", name="height")
    b.force("mass", (0.0, 5.0), increment=True)
    path = tmp_path / "thrown.fmu"
    with pytest.warns(FlexmbWarning, match=r"fm\.save_fmu leaves out the incremental loads .* Build them without"):
        fm.save_fmu(b.build(), path, nonlinear=True)
    # It is looked for every 62 ms, and would be passed for 89 ms.
    found = simulated(path, "cs", 2.0, 1.0, {"push": 0.0}, relative_tolerance=1e-8)
    # The tolerance of a state of a metre, of a contact that turns a speed of 0.4 m/s within 10 ms, over two seconds.
    assert found["height"][-1] == approx(float(height_behind_the_stop(0.44)), abs=1e-3)


def carried_stage():
    """A mass of 0.4 kg on a spring of 90 N/m, 0.3 m above its foot, that its weight presses down; seen at its top."""
    b = fm.Builder()
    b.node("foot", (0.2, 0))
    b.node("top", (0.2, 0.3))
    b.add(planar.truss, "foot", "top", name="s", section=fm.Rigidity(EA=90.0 * 0.3))
    b.fix("foot")
    b.fix("top", "x")
    b.dof("top", "y")
    b.mass("top", 0.4)
    b.force("top", (0.0, -0.4 * 9.81))
    b.input("top", "y", name="push")
    b.output("top", "y", "velocity", name="rate")
    b.output("top", "y", name="height")
    return b


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("kind", ["linear", "along", "nonlinear"])
def test_absolute_positions_are_what_displacements_count_from_and_these(kind, fmi, tmp_path):
    """The weight presses the spring by 0.4 9.81/90 m; a linear unit begins there, the others undeformed."""
    b, path, fallen = carried_stage(), tmp_path / "carried.fmu", 0.4 * 9.81 / 90
    if kind == "along":
        start = fm.simulate(b.build(), np.linspace(0, 0.1, 5), initial=fm.equilibrium(b.build()))
        fm.save_fmu(fm.trajectory.time_varying(start), path, fmi=fmi)
    else:
        fm.save_fmu(b.build(), path, fmi=fmi, nonlinear=kind == "nonlinear")
    assert validate_fmu(str(path)) == []
    told = {v.name: v for v in fmpy.read_model_description(str(path)).modelVariables}
    whence = "static equilibrium" if kind == "linear" else "undeformed mechanism"
    assert told["height"].description == f"Displacement from the {whence}"
    assert (told["absolute height"].unit, told["height"].unit) == ("m", "m")
    assert "absolute rate" not in told
    with opened(path, tmp_path / "me", "me") as unit:
        unit.set("push", 0.3)
        unit.set("state top.y", 0.01)
        begun = {"linear": 0.3 - fallen, "along": 0.3, "nonlinear": 0.3}[kind]
        moved = 0.01 - (fallen if kind == "along" else 0.0)
        # The simulated motion that matrices stand along rests but for its tolerance.
        atol = 1e-6 if kind == "along" else 1e-12
        np.testing.assert_allclose(unit.get("height"), [moved], atol=atol)
        np.testing.assert_allclose(unit.get("absolute height") - unit.get("height"), [begun], atol=1e-12)
        own, absolute = unit.derivative(["height", "absolute height"], ["state top.y"], [1.0])
        np.testing.assert_allclose([own, absolute], [1.0, 1.0], rtol=1e-9)


def renamed(inputs=("u",), outputs=("y",), states=("q",)):
    one = np.ones((1, 1))
    return plants.linear_plant(-one, one, one, 0 * one, *(tuple(map(Variable, of)) for of in (inputs, outputs, states)))


@pytest.mark.parametrize(
    ("system", "options", "message"),
    [
        (renamed(inputs=("a\tb",)), {}, r"input 'a\\tb' has a name that FMI forbids"),
        (renamed(outputs=("",)), {}, "output '' has a name that FMI forbids"),
        (renamed(outputs=("time",)), {}, "output 'time' shares its name with the unit's time"),
        (renamed(inputs=("A",), outputs=("A", "B")), {}, "output 'B' shares its name with the unit's parameter"),
        (renamed(inputs=("A[1,1]",)), {}, r"'A\[1,1\]' shares .* Rename the input, by `name` of Builder\.input, or"),
        (renamed(outputs=("C[1,1]",)), {"fmi": 2}, r"output 'C\[1,1\]' shares its name with the unit's parameter"),
        (renamed(inputs=("der(state q)",)), {"fmi": 2}, r"input 'der\(state q\)' shares its name with the unit's rate"),
        (renamed(outputs=("state q",)), {}, "output 'state q' shares its name with the unit's state"),
        (renamed(outputs=("y", "y")), {}, "output 'y' shares its name with the unit's output"),
        (renamed(states=("q", "q")), {}, "'state q' shares .* Rename the state, by `states` of control"),
        (control.StateSpace([[0.5]], [[1]], [[1]], [[0]], 1e-3), {}, r"sampled \(dt = 0.001 s\)"),
        (control.StateSpace([], [], [], [[1]]), {}, "has no inputs, no outputs or no states"),
        (
            control.StateSpace([[np.nan]], [[1]], [[1]], [[0]], remove_useless_states=False),
            {},
            r"A\[1, 1\] is no finite",
        ),
        (renamed(), {"fmi": 1}, "`fmi` must be 3 or 2"),
        (renamed(), {"start": {"p": 1.0}}, "`start` names 'p', which is no state: there are q"),
        (renamed(), {"start": [1.0, 2.0]}, "1 finite numbers"),
        (renamed(), {"units": {"p": "m"}}, "`units` names 'p'"),
        (renamed(), {"modes": 2}, "for a Model or a Linearization"),
        (renamed(), {"substep": 0.1}, "for a time-varying system"),
        (swaying(), {"substep": 0.0}, "`substep` must be positive"),
        (swaying(1), {}, "two ascending times"),
    ],
)
def test_what_is_refused_is_named(system, options, message, tmp_path):
    with pytest.raises(ValueError, match=message):
        fm.save_fmu(system, tmp_path / "no.fmu", **options)
    assert not list(tmp_path.iterdir())


def test_a_nonlinear_mechanism_that_would_start_stressed_is_told(tmp_path, monkeypatch):
    """Unless it is said where it starts; what is translated is another test's."""

    def refused(*_):
        raise RuntimeError("translated")

    monkeypatch.setattr("flexmb.fmu.plant.nonlinear", refused)
    b = sprung_mass(stiffness=90.0, damping=0.5, mass=0.4)
    b.strain("s", 1e-3)
    model = b.build()
    with pytest.warns(fm.FlexmbWarning, match="Give values of states"), pytest.raises(RuntimeError):
        fm.save_fmu(model, tmp_path / "mass.fmu", nonlinear=True)
    with pytest.raises(RuntimeError, match="translated"):
        fm.save_fmu(model, tmp_path / "mass.fmu", nonlinear=True, start=[0.0, 0.0])


def test_wrong_files_and_things(tmp_path):
    with pytest.raises(ValueError, match=r"ends in \.fmu, not '.*guide\.zip'"):
        fm.save_fmu(renamed(), tmp_path / "guide.zip")
    with pytest.raises(TypeError, match="not Builder"):
        fm.save_fmu(fm.Builder(), tmp_path / "guide.fmu")
    with pytest.raises(FileNotFoundError):
        fm.save_fmu(renamed(), tmp_path / "none" / "guide.fmu")


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("mode", [9, 4, 1])
def test_command(mode, tmp_path):
    """A shipped mass on a spring about its equilibrium, along the motion that a load makes, and with all its motion."""
    source, path = tmp_path / "mass.dat", tmp_path / "mass.fmu"
    text = mechanism_path("pf1dtrx").read_text()
    source.write_text(re.sub("END\nHALT\n+INPUTF", "TIMESTEP 0.02 4\nEND\nHALT\nINPUTF", text))
    result = command("fmu", source, "--to", path, "--mode", mode, "--fmi", 2)
    assert result.exit_code == 0, result.output
    assert "FMI 2.0, binaries/" in result.stdout
    assert validate_fmu(str(path)) == []
    names = {v.name: v.unit for v in fmpy.read_model_description(str(path)).modelVariables}
    units = {"force 2.1": "N", "position 2.1": "m", "der(state 2.x)": "m/s"}
    assert {name: names.get(name) for name in units} == units
    assert ("nominal force 2.1" in names) == (mode == 4)


@pytest.mark.slow
def test_command_says_what_is_wrong(tmp_path):
    source, path = tmp_path / "mass.dat", tmp_path / "mass.fmu"
    text = mechanism_path("pf1dtrx").read_text()
    source.write_text(re.sub("(?m)^INPUTF .*$", "", text))
    result = command("fmu", source, "--to", path)
    assert result.exit_code == 2
    assert result.stderr.startswith("mass.dat: INPUTF: an FMU needs an input and an output: INPUTF or INPUTS, and OUTX")
    source.write_text(re.sub("(?m)^FIX .*$", "", text))
    result = command("fmu", source, "--to", path)
    assert result.exit_code == 1
    assert result.stderr.startswith("mass.dat: underconstrained: ")
    assert not path.exists()
