"""State-space matrices of masses on springs, written down by hand."""

import numpy as np
import pytest
from cases.motions import sprung_mass

import flexmb as fm
from flexmb import planar


def test_every_kind_of_output_of_an_oscillator():
    """m x'' + c x' + k x = F - S, where S adds to the spring's stress k x + c x'."""
    k, c, m = 90.0, 1.2, 0.4
    b = sprung_mass(stiffness=k, damping=c, mass=m)
    b.input("mass", "x")
    b.input("s", 1)
    for quantity in ("position", "velocity", "acceleration"):
        b.output("mass", "x", quantity)
    for quantity in ("deformation", "deformation rate", "deformation acceleration", "stress"):
        b.output("s", 1, quantity)
    model = b.build()
    found, names = fm.control.state_matrices(model)
    assert names == ["mass.x", "d mass.x"]
    # Roots of m s^2 + c s + k, which decays.
    root = -c / (2 * m) + 1j * np.sqrt(k / m - (c / (2 * m)) ** 2)
    np.testing.assert_allclose(sorted(fm.poles(model), key=np.imag), [root.conjugate(), root], rtol=1e-12)
    second = [-k / m, -c / m]
    np.testing.assert_allclose(found.A, [[0, 1], second], rtol=1e-12)
    np.testing.assert_allclose(found.B, [[0, 0], [1 / m, -1 / m]], rtol=1e-12)
    np.testing.assert_allclose(found.C, [[1, 0], [0, 1], second, [1, 0], [0, 1], second, [k, c]], rtol=1e-12)
    direct, none = [1 / m, -1 / m], [0, 0]
    np.testing.assert_allclose(found.D, [none, none, direct, none, none, direct, [0, 1]], rtol=1e-12)


def test_what_has_no_mass_follows_at_once():
    """A force F on a joint without mass between two springs, wall k1 joint k2 mass: x_j = (k2 x + F)/(k1 + k2)."""
    k1, k2, m = 30.0, 60.0, 0.5
    b = fm.Builder()
    for name, x in (("wall", 0.0), ("joint", 0.3), ("mass", 0.8)):
        b.node(name, (x, 0))
    b.add(planar.truss, "wall", "joint", name="first", section=fm.Rigidity(EA=k1 * 0.3))
    b.add(planar.truss, "joint", "mass", name="second", section=fm.Rigidity(EA=k2 * 0.5))
    b.fix("wall")
    for name in ("joint", "mass"):
        b.fix(name, "y")
        b.dof(name, "x")
    b.mass("mass", m)
    b.input("joint", "x")
    b.input("mass", "x")
    for name in ("joint", "mass"):
        b.output(name, "x")
    b.output("mass", "x", "acceleration")
    b.output("first", 1, "stress")
    found, names = fm.control.state_matrices(b.build())
    assert names == ["mass.x", "d mass.x"]
    share, k, soft = k2 / (k1 + k2), k1 * k2 / (k1 + k2), 1 / (k1 + k2)
    np.testing.assert_allclose(found.A, [[0, 1], [-k / m, 0]], rtol=1e-12)
    np.testing.assert_allclose(found.B, [[0, 0], [share / m, 1 / m]], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(found.C, [[share, 0], [1, 0], [-k / m, 0], [k1 * share, 0]], rtol=1e-12)
    expected = [[soft, 0], [0, 0], [share / m, 1 / m], [k1 * soft, 0]]
    np.testing.assert_allclose(found.D, expected, rtol=1e-12, atol=1e-15)


def test_damping_without_mass_is_not_left_out_without_a_word():
    """A damper between a spring and a mass: m lambda^2 + c k/(c + k/lambda) is no pair of a position and its rate."""
    b = fm.Builder()
    for i in range(3):
        b.node(f"n{i}", (0.1 * i, 0))
    b.add(planar.truss, "n0", "n1", section=fm.Rigidity(EA=9.0))
    b.add(planar.truss, "n1", "n2", section=fm.Rigidity(EA=0.1), damping=fm.Damping(EA=0.5))
    b.fix("n0")
    for node in ("n1", "n2"):
        b.fix(node, "y")
        b.dof(node, "x")
    b.mass("n2", 0.3)
    b.input("n2", "x", name="push")
    b.output("n2", "x")
    model = b.build()
    with pytest.warns(fm.FlexmbWarning, match=r"motion of n1\.x carries no mass but is damped.*wrong by up to"):
        fm.to_statespace(model)
    with pytest.warns(
        fm.FlexmbWarning, match=r"n1\.x carries no mass but is damped\. The exact integral neglects this damping"
    ):
        fm.control.noise_budget(model, sources={"push": 1.0})
