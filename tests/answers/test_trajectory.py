"""Modes along a trajectory, against a rigid arm of two links by hand and against independent integrations."""

import dataclasses
import functools
import re
import zipfile

import jax
import numpy as np
import pytest
import scipy.integrate
from cases.commands import command

import flexmb as fm
from flexmb import planar
from flexmb.answers.answer_files import save
from flexmb.answers.answers import answer, mode_of
from flexmb.answers.mode_1_simulate import _state_spaces
from flexmb.linear.linearize import Linearization
from flexmb.mechanisms import mechanism_path
from flexmb.results import RESULTS
from flexmb.spacar.actions import RATES_IDLE
from flexmb.spacar.reading import Leg
from flexmb.spacar.trajectories import law_of

fm.enable_x64()


def asked(text, mode):
    """Answer of a mode about a text or a shipped mechanism."""
    read = fm.read_spacar(text)
    return answer(read.builder, "arm.dat", mode, read.warnings, settings=read.settings)


@functools.cache
def linearised():
    found = asked(mechanism_path("manipulator"), 3)
    assert (found.exit_status, found.data["status"], found.data["warnings"]) == (0, "ok", [])
    return found.data


def table(data):
    """Lines of the terminal."""
    return mode_of(6).table(data)


# -- laws ---------------------------------------------------------------------------------------------------------


def rise(law, s):
    """Value and two derivatives of a move by one in a time of one."""
    if law == "quintic":
        return 10 * s**3 - 15 * s**4 + 6 * s**5, 30 * s**2 * (1 - s) ** 2, 60 * s * (1 - s) * (1 - 2 * s)
    value = 35 * s**4 - 84 * s**5 + 70 * s**6 - 20 * s**7
    return value, 140 * s**3 * (1 - s) ** 3, 420 * s**2 * (1 - s) ** 2 * (1 - 2 * s)


def way(t, *legs):
    """Value, velocity and acceleration of ways (start, end, from, to, law) that follow each other."""
    value, rate, second = np.full_like(t, legs[0][2]), np.zeros_like(t), np.zeros_like(t)
    for start, end, at, to, law in legs:
        duration = end - start
        s = np.clip((t - start) / duration, 0, 1)
        shape = rise(law, s)
        value += (to - at) * shape[0]
        rate += (to - at) * shape[1] / duration
        second += (to - at) * shape[2] / duration**2
    return value, rate, second


def test_ways_follow_each_other():
    legs = [Leg(1, 1, 1.0, 3.0, 2.5, "quintic", 1), Leg(1, 1, 4.0, 5.0, 0.5, "septic", 2)]
    t = np.linspace(0, 6, 61)
    # The coordinate is 0.5 in the undeformed mechanism, and 0.2 more where it begins.
    expected, *_ = way(t, (1.0, 3.0, 0.2, 2.0, "quintic"), (4.0, 5.0, 2.0, 0.0, "septic"))
    law = law_of(legs, 0.2, 0.5)
    np.testing.assert_allclose([law(ti) for ti in t], expected, atol=1e-12)
    # The one begins where the other ends, without a rest.
    law = law_of([legs[0], legs[1]._replace(start=3.0)], 0.2, 0.5)
    assert law.breaks.tolist() == [1.0, 3.0, 5.0]


def test_an_s_curve_goes_by_thirds():
    """Speeding up to 1.5 in a third of the time covers a quarter of the way; in a ninth the jerk j covers j t^3/6."""
    law = law_of([Leg(1, 1, 0.0, 9.0, -2.0, "scurve", 1)], 0.0)
    np.testing.assert_allclose(law(1.0), -2 * 60.75 / 9**3 / 6, rtol=1e-12)
    np.testing.assert_allclose([law(t) for t in (3.0, 4.5, 9.0)], [-0.5, -1.0, -2.0], rtol=1e-12)
    still = law_of([Leg(1, 1, 0.0, 1.0, 0.3, "scurve", 1)], 0.3)
    assert [float(still(t)) for t in (0.0, 0.4, 2.0)] == [0.3] * 3


# -- modes 2 and 3 ------------------------------------------------------------------------------------------------

# Lengths, mass per length, masses of elbow and load.
L1, L2, RHO, ELBOW, LOAD = 0.5, 0.4, 0.432, 0.5, 0.2


def arm(q, v, a):
    """Torques of the joints of two slender rods with two point masses, in absolute angles: Lagrange's equations."""
    inertia1 = RHO * L1**3 / 3 + (ELBOW + RHO * L2 + LOAD) * L1**2
    inertia2, coupling = RHO * L2**3 / 3 + LOAD * L2**2, (RHO * L2**2 / 2 + LOAD * L2) * L1
    (p1, p2), (w1, w2), (a1, a2) = ((u[0], u[0] + u[1]) for u in (q, v, a))
    c, s = coupling * np.cos(p2 - p1), coupling * np.sin(p2 - p1)
    upper = inertia1 * a1 + c * a2 - s * w2**2
    lower = inertia2 * a2 + c * a1 + s * w1**2
    mass = np.array([[inertia1 + 2 * c + inertia2, inertia2 + c], [inertia2 + c, inertia2 + 0 * c]])
    # What the torques of the joints do, by their own angles.
    return np.stack([upper + lower, lower], 1), np.moveaxis(mass, 2, 0), s


def joints(t):
    both = [way(t, (0, 0.6, 0, 1, "quintic")), way(t, (0.1, 0.5, 0, -1.2, "quintic"), (0.5, 0.8, -1.2, -0.6, "septic"))]
    return [np.stack(parts) for parts in zip(*both, strict=True)]


@pytest.mark.slow
def test_torques_of_the_joints_are_those_of_rigid_links():
    data = linearised()
    t = np.array(data["time"])
    q, v, a = joints(t)
    torques, *_ = arm(q, v, a)
    # A positive stress resultant of a joint turns it back.
    np.testing.assert_allclose(data["u0"], -torques, atol=1e-9 * np.abs(torques).max())
    tip = [L1 * np.cos(q[0]) + L2 * np.cos(q[0] + q[1]), L1 * np.sin(q[0]) + L2 * np.sin(q[0] + q[1])]
    np.testing.assert_allclose(data["y0"], np.stack([*q, *tip], 1), atol=1e-12)
    np.testing.assert_allclose(np.array(data["trajectory"]["6"]).T, tip, atol=1e-12)
    np.testing.assert_allclose(np.array(data["velocities"]["5"])[:, 0], v[0] + v[1], atol=1e-10)
    assert data["inputs"] == ["stress 1.1", "stress 2.1"]
    assert data["outputs"] == ["deformation 1.1", "deformation 2.1", "position 6.1", "position 6.2"]
    assert [(d["kind"], d["of"], d["component"]) for d in data["dofs"]][:2] == [("e", 1, 1), ("e", 2, 1)]


@pytest.mark.slow
def test_a_unit_has_the_nominal_inputs(tmp_path):
    """A unit of mode 3 bears the torques of the rigid links at all times."""
    to = tmp_path / "arm.fmu"
    result = command("fmu", mechanism_path("manipulator"), "--to", to, "--mode", "3")
    assert result.exit_code == 0
    text = zipfile.ZipFile(to).read("modelDescription.xml").decode()
    start = re.search(r'name="u0"[^>]*start="([^"]*)"', text)
    values = np.array(start.group(1).split(), float).reshape(-1, 2)
    torques, *_ = arm(*joints(np.array(linearised()["time"])))
    np.testing.assert_allclose(values, -torques, atol=1e-9 * np.abs(torques).max())


@pytest.mark.slow
def test_linearised_equations_of_the_joints():
    """Mass and velocity matrix of the rigid links are the joints' part of those of the flexible arm."""
    data = linearised()
    t = np.array(data["time"])
    q, v, a = joints(t)
    _, mass, s = arm(q, v, a)
    steps = data["steps"]
    assert [step["time"] for step in steps] == data["time"].tolist()
    np.testing.assert_allclose([step["m0"][:2, :2] for step in steps], mass, rtol=1e-9)
    # Derivatives by the rates of the joints' angles of what is quadratic in them.
    w1, w2 = v
    expected = np.stack([[-2 * s * w2, -2 * s * (w1 + w2)], [2 * s * w1, 0 * s]])
    np.testing.assert_allclose(
        [step["c0"][:2, :2] for step in steps], np.moveaxis(expected, 2, 0), atol=1e-9 * np.abs(expected).max()
    )
    for step in steps[::20]:
        np.testing.assert_allclose(step["A"][6:, 6:], -np.linalg.solve(step["m0"], step["c0"] + step["d0"]), atol=1e-6)
        np.testing.assert_allclose(step["m0"] @ step["B"][6:], -np.eye(6)[:, :2], atol=1e-9)
        np.testing.assert_allclose(step["C"][:2], np.eye(12)[:2], atol=1e-12)


def test_state_spaces_of_times_that_differ():
    """Each time as by itself: where there are no matrices, no state space; where a motion has no mass, fewer states."""

    def matrices(mass):
        b = fm.Builder()
        for place, node in enumerate("abc"):
            b.node(node, (0.1 * place, 0))
            b.fix(node, *("xy" if node == "a" else "y"))
        for ends, stiffness in (("ab", 1e3), ("bc", 2e3)):
            b.add(planar.truss, *ends, name=ends, section=fm.Rigidity(EA=stiffness * 0.1))
            b.dof(ends, 1, kind="element")
        b.mass("b", mass)
        b.mass("c", 0.5)
        b.input("c", "x")
        b.output("b", "x")
        lin = fm.linearize(b.build())
        return jax.tree.map(np.asarray, lin.matrices), lin.model

    (heavy, model), (light, _) = matrices(1.0), matrices(0.0)
    lost = dataclasses.replace(heavy, result=np.array(RESULTS.singular_configuration), M0=np.nan * heavy.M0)
    found = _state_spaces(jax.tree.map(lambda *a: np.stack(a), light, heavy, lost, light), model)
    assert list(map(int, sorted(found))) == [0, 1, 3]
    for i, m in ((0, light), (1, heavy), (3, light)):
        expected, _ = fm.control.state_matrices(Linearization(m, model))
        for name, value in expected._asdict().items():
            np.testing.assert_allclose(found[i][name], value, rtol=1e-12)
    assert [found[i]["A"].shape for i in (0, 1)] == [(2, 2), (4, 4)]


@pytest.mark.slow
def test_steps_are_saved_as_arrays(tmp_path):
    data = linearised()
    save(data, tmp_path / "arm.npz")
    with np.load(tmp_path / "arm.npz") as found:
        np.testing.assert_array_equal(found["steps_A"][7], data["steps"][7]["A"])
        np.testing.assert_array_equal(found["u0"], data["u0"])
        assert found["trajectory_6"].shape == (101, 2)
    lost = {"time": 2.0, "frequencies_hz": [], "m0": None}
    save({"steps": [{"time": 1.0, "frequencies_hz": [3.0], "m0": np.eye(2), "A": np.eye(2)}, lost]}, tmp_path / "b.npz")
    with np.load(tmp_path / "b.npz") as found:
        assert np.isnan(found["steps_m0"][1]).all()
        assert np.isnan(found["steps_A"][1]).all()
        np.testing.assert_array_equal(found["steps_frequencies_hz"], [[3.0], [np.nan]])


# -- modes 5 and 6, and prescribed motion in mode 1 -----------------------------------------------------------------

# A mass on a spring of 1000 N/m with a damper of 2 N s/m, on a heavy base that is led.
BASE = """PLTRUSS 1 1 2
X 1 0 0
X 2 0.1 0
FIX 1 2
FIX 2 2
INPUTX 1 1
DYNE 1 1
END
HALT
XM 1 2
XM 2 0.5
ESTIFF 1 100
EDAMP 1 0.2
INPUTX 1 1 0.05
TIMESTEP 0.5 250
ERROR 1e-9 1e-9
{lines}
END
HALT
TRAJX 1 1 0.1 0.3 0.15 septic
TRAJX 1 1 0.35 0.45 0.1 septic
{signals}
END
END
"""
MASS, HEAVY, STIFFNESS, DAMPING = 0.5, 2.0, 1000.0, 2.0


def base(t):
    return way(np.atleast_1d(t), (0.1, 0.3, 0.05, 0.15, "septic"), (0.35, 0.45, 0.15, 0.1, "septic"))


def stretched(velocity):
    """Elongation of the spring over time, integrated by itself."""
    t = np.linspace(0, 0.5, 251)

    def rate(ti, y):
        return [y[1], -base(ti)[2][0] - (DAMPING * y[1] + STIFFNESS * y[0]) / MASS]

    # Steps end where the acceleration has a kink.
    found = scipy.integrate.solve_ivp(
        rate, (0, 0.5), [0.0, velocity], t_eval=t, rtol=1e-10, atol=1e-13, max_step=0.0025, method="DOP853"
    )
    return t, found.y[0]


@pytest.mark.slow
def test_vibrations_on_a_base_that_moves():
    """What is linear is the same by the perturbation method, by the nonlinear motion and by hand."""
    text = BASE.format(lines="STARTDE 1 1 0 0.1", signals="REFX 1 2 1\nREFXDP 2 2 1")
    found = asked(text, 6)
    data = found.data
    assert (found.exit_status, data["warnings"]) == (0, [])
    t, e = stretched(0.1)
    x, _, a = base(t)
    amplitude = np.abs(e).max()
    # The force is a cubic spline through values 2 ms apart, whose second derivative jumps.
    np.testing.assert_allclose(np.array(data["dq"])[:, 0], e, atol=5e-6 * amplitude)
    np.testing.assert_allclose(np.array(data["trajectory"]["2"])[:, 0], 0.1 + x + e, atol=5e-6 * amplitude)
    np.testing.assert_allclose([step["f0"][0] for step in data["steps"]], -MASS * a, atol=1e-9)
    np.testing.assert_allclose(data["y0"], np.stack([0.1 + x, a], 1), atol=1e-9)
    assert np.shape(data["u0"]) == (251, 0)
    assert set(data) >= {"x", "time", "trajectory", "velocities", "inputs", "outputs", "u0", "y0", "dq", "steps"}
    assert set(data["steps"][0]) == {"time", "frequencies_hz", "f0", "m0", "c0", "d0", "k0", "n0", "g0"}
    assert table(data)[-1].startswith("  vibration e 1.1: -0.0")
    assert (table(data)[1], table(data)[3]) == ("  node 1       0.1  0", "  output position 2.1: 0.15 to 0.25")
    moved = asked(text.replace("STARTDE 1 1 0 0.1", ""), 1)
    assert moved.data["warnings"] == []
    t, e = stretched(0.0)
    np.testing.assert_allclose(np.array(moved.data["trajectory"]["2"])[:, 0], 0.1 + x + e, atol=1e-6)


@pytest.mark.slow
def test_what_is_let_go_in_mode_5():
    """The same with a force that drives the base: what is prescribed in the file has become a degree of freedom."""
    text = BASE.format(lines="STARTDE 1 1 0 0.1", signals="NOMF 1 1 1\nREFX 1 2 1")
    found = asked(text, 5)
    data = found.data
    (warning,) = data["warnings"]
    assert warning.startswith("The start velocity of element 1, 1, has no effect")
    *_, a = base(np.array(data["time"]))
    assert [(d["kind"], d["of"]) for d in data["dofs"]] == [("x", 1), ("e", 1)]
    np.testing.assert_allclose(np.array(data["u0"])[:, 0], (MASS + HEAVY) * a, atol=1e-9)
    np.testing.assert_allclose([step["f0"] for step in data["steps"]], np.stack([0 * a, -MASS * a], 1), atol=1e-9)
    np.testing.assert_allclose(data["steps"][7]["m0"], MASS * np.ones((2, 2)) + np.diag([HEAVY, 0]), rtol=1e-12)
    # A force on the mass drives the base through the spring that is held.
    other = asked(text.replace("NOMF 1 1 1", "NOMF 1 2 1"), 2)
    np.testing.assert_allclose(np.array(other.data["u0"])[:, 0], (MASS + HEAVY) * a, atol=1e-9)


@pytest.mark.slow
def test_what_cannot_vibrate():
    text = BASE.replace("DYNE 1 1\n", "").replace("ESTIFF 1 100\nEDAMP 1 0.2\n", "").replace("0.5 250", "0.5 4")
    data = asked(text.format(lines="", signals="REFX 1 2 1"), 6).data
    assert (data["status"], np.shape(data["dq"])) == ("ok", (5, 0))
    np.testing.assert_allclose(np.array(data["y0"])[:, 0], 0.1 + base(np.array(data["time"]))[0], atol=1e-12)


WRONG = [
    (
        "REFX 1 2 1",
        {"TRAJX": ""},
        3,
        "arm.dat:22: REFX: mode 3 needs a trajectory: TRAJX node coordinate start end value",
    ),
    ("", {"TRAJX": ""}, 2, "arm.dat: TRAJX: mode 2 needs a trajectory: TRAJX node coordinate start end value"),
    ("", {"TIMESTEP": ""}, 6, "arm.dat:20: TRAJX: needs TIMESTEP in the dynamics block: TIMESTEP end steps, such as"),
    (
        "NOMF 1 1 1\nNOMF 2 2 1\nREFX 1 2 1",
        {},
        2,
        "arm.dat:23: NOMF: input 2: 2 nominal inputs drive as many coordinates and deformations along trajectories",
    ),
    ("TRAJE 1 1 0 1 0.1", {}, 2, "arm.dat:22: TRAJE: element 1: nothing drives it along its trajectory: there are 0"),
]


@pytest.mark.parametrize(("signals", "without", "mode", "expected"), WRONG)
def test_what_a_trajectory_lacks(signals, without, mode, expected):
    text = BASE.format(lines="", signals=signals)
    for keyword in without:
        text = re.sub(rf"(?m)^{keyword} .*$", "", text)
    with pytest.raises(fm.SpacarError) as info:
        asked(text, mode)
    assert str(info.value).startswith(expected)
    assert "\n" not in str(info.value)


def test_what_is_not_used_is_told(monkeypatch):
    def inverse_dynamics(model, laws, times):
        # What is led begins where it is.
        assert list(laws) == ["1.x", "1.e1"]
        ends = [[law(0.0), law(9.0)] for law in laws.values()]
        np.testing.assert_allclose(ends, [[0.05, 0.1], [-2e-3, 1e-3]], rtol=1e-12)
        raise fm.AnalysisError("seen", "")

    monkeypatch.setattr("flexmb.answers.mode_2_inverse.inverse_dynamics", inverse_dynamics)
    text = BASE.format(lines="TRAJE 1 1 0 0.6 1e-3\nSTARTDE 1 1 -2e-3 0.1", signals="NOMS 1 1 1\nREFX 1 2 1")
    found = asked(text, 2)
    velocity, late = found.data["warnings"]
    assert velocity.startswith("The start velocity of element 1, 1, has no effect")
    assert (found.data["status"], found.exit_status) == ("seen", 1)
    assert late == "TRAJE on line 17 goes on until 0.6 s, but TIMESTEP ends at 0.5 s."


def test_rates_are_idle_where_nothing_goes_through_time():
    """Of a deformation that INPUTE prescribes with a velocity; what else is wrong with the mechanism is told first."""
    text = BASE.replace("INPUTX 1 1\n", "INPUTX 1 1\nPLTRUSS 2 1 3\nX 3 0 0.1\nINPUTE 2 1\n").replace("FIX 2 2\n", "")
    text = text.replace("XM 1 2\n", "XM 1 2\nINPUTE 2 1 0.01 0.3 0.5\n").format(lines="", signals="REFX 1 2 1")
    said = {}
    for mode in range(1, 11):
        found = asked(text, mode)
        assert found.data["status"] == "underconstrained"
        said[mode] = [warning for warning in found.data["warnings"] if warning.endswith(RATES_IDLE)]
    assert [mode for mode, warnings in said.items() if warnings] == [7, 8, 9, 10]
    assert said[7][0].startswith("text:13: INPUTE: velocity and acceleration are for modes 1 to 6")
