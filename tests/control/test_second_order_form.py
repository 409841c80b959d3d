"""Motions of what is held as inputs, constraint forces as outputs, sensors and actuators, in second-order form."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import flexmb as fm
from flexmb import planar, spatial

STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0)
FORCE = np.array([20.0, 3.0, 0.5])
COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")


def shaken_mass(stiffness=90.0, damping=1.2, mass=0.4, length=0.3):
    """A mass on a damped spring on a wall."""
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("mass", (length, 0))
    section, lossy = fm.Rigidity(EA=stiffness * length), fm.Damping(EA=damping * length)
    b.add(planar.truss, "wall", "mass", name="s", section=section, damping=lossy)
    b.fix("wall")
    b.fix("mass", "y")
    b.dof("mass", "x")
    b.mass("mass", mass)
    return b


def test_every_kind_of_signal_of_a_mass_on_a_wall_that_shakes():
    """m x'' = c (p' - x') + k (p - x) + F - S: the wall carries the stress k (x - p) + c (x' - p') + S."""
    k, c, m, w = 90.0, 1.2, 0.4, 0.25
    b = shaken_mass(k, c, m)
    b.input("wall", "x", "velocity")
    b.actuator("push", {"mass.x": 2.0, "s.1": w})
    b.output("mass", "x", "acceleration")
    b.output("wall", "x", "reaction")
    b.output("s", 1, "stress")
    b.sensor("gap", {"mass.x": w, "velocity wall.x": -2.0, "reaction wall.x": 1.0})
    found = fm.control.second_order(fm.linearize(b.build()))
    expected = {
        "M": [[m]],
        "C": [[c]],
        "K": [[k]],
        "B0": [[k, 2 - w]],
        "B1": [[c, 0]],
        "B2": [[0, 0]],
        "C0": [[0], [-k], [k], [w - k]],
        "C1": [[0], [-c], [c], [-c]],
        "C2": [[1], [0], [0], [0]],
        "D0": [[0, 0], [k, -w], [-k, w], [k, -w]],
        "D1": [[0, 0], [c, 0], [-c, 0], [c - 2, 0]],
        "D2": np.zeros((4, 2)),
        "orders": [1, 0],
        "moves": [True, False],
    }
    for name, value in expected.items():
        np.testing.assert_allclose(getattr(found, name), value, rtol=1e-12, atol=1e-14, err_msg=name)


def bent_leaf():
    """A leaf spring that cannot stretch, well away from where it was under the force and moment at its end c."""
    b = fm.Builder()
    b.node("a", (0, 0, 0))
    b.node("c", (0.1, 0, 0))
    leaf = fm.Rectangle(0.018, 0.5e-3, STEEL)
    b.add(spatial.beam, "a", "c", name="leaf", section=leaf, y=(0, 1, 0), released=(2, 3, 4, 5, 6))
    b.dof("leaf", 2, 3, 4, 5, 6)
    b.force("c", FORCE)
    b.moment("c", (0.2, 0.05, 0.0))
    return b


@pytest.mark.filterwarnings("ignore::flexmb.BeamTheoryWarning")
def test_a_loaded_leaf_spring_on_a_floor_that_moves():
    """At rest: against nonlinear equilibria with the floor moved, and the moments in balance about it."""
    b = bent_leaf()
    b.fix("a")
    for component in COMPONENTS:
        b.input("a", component, "displacement")
        b.output("c", component)
    b.input("c", "y")
    b.input("c", "rx")
    b.input("leaf", 1, "displacement")
    for component in COMPONENTS:
        b.output("a", component, "reaction")
    b.output("leaf", 1, "stress")
    model = b.build()
    lin = fm.linearize(model)
    found = fm.control.second_order(lin)
    gain = np.asarray(found.D0 + found.C0 @ np.linalg.solve(found.K, found.B0))
    # A unit of base motion x, y, z, rx, ry, rz, of force y and moment rx at c, and of elongation.
    arm = np.asarray(lin.position("c") - lin.position("a"))
    turning = -np.cross((gain[:3] - np.eye(3, 9)).T, FORCE).T
    turning[:, 6] -= np.cross(arm, [0, 1, 0])
    turning[:, 7] -= [1, 0, 0]
    pushed = np.zeros((3, 9))
    pushed[1, 6] = -1
    # Round-off of 1 N and of 2 N m by the condition number of the stiffness, 6e3.
    np.testing.assert_allclose(gain[6:9], pushed, atol=1e-11)
    np.testing.assert_allclose(gain[9:12], turning, atol=1e-11)
    step = 1e-4
    for column, axis in ((3, 0), (5, 2)):
        ends = []
        for sign in (1, -1):
            b = bent_leaf()
            b.fix("a", "position")
            b.prescribe("a", "rotation", sign * step, axis=np.eye(3)[axis])
            ends.append(fm.equilibrium(b.build()))
        turned = [Rotation.from_quat(np.asarray(end.at("c.rotation")), scalar_first=True) for end in ends]
        moved = (ends[0].position("c") - ends[1].position("c")) / (2 * step)
        stress = (ends[0].stress_resultant("leaf", 1) - ends[1].stress_resultant("leaf", 1)) / (2 * step)
        # Truncation of the difference, the square of its step.
        np.testing.assert_allclose(gain[:3, column], moved, atol=1e-7)
        np.testing.assert_allclose(gain[3:6, column], (turned[0] * turned[1].inv()).as_rotvec() / (2 * step), atol=1e-7)
        assert gain[12, column] == pytest.approx(float(stress), rel=1e-7)
