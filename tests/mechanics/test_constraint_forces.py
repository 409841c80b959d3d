"""Loads carried by rigid parts: the stiffness of constraint forces (reference problems P1, P2) and straight columns."""

import jax
import numpy as np
import pytest
from cases.tolerances import approx
from scipy.optimize import brentq

import flexmb as fm
from flexmb import planar, spatial

# P1: m = 1, J = 0.1, a = 1, g = 9.81; sqrt(m g a/(J + m a^2))/2 pi.
PENDULUM = np.sqrt(9.81 / 1.1) / (2 * np.pi)


def planar_pendulum(gravity, joint="shared"):
    """Body 1 m below a revolute joint, by a shared position or by a beam whose hinge is held."""
    b = fm.Builder()
    b.node("joint", (0, 0))
    b.node("body", (0, -1))
    if joint == "shared":
        b.add(planar.rigid_beam, "body", "joint")
    else:
        b.add(planar.beam, "joint", "body", name="rod")
        b.rotation("ground")
        b.add(planar.hinge, "ground", "joint.rotation", name="hinge")
        b.fix("ground")
    b.fix("joint", "position")
    b.mass("body", 1.0, inertia=0.1)
    b.gravity((0, gravity))
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize("joint", ["shared", "hinge"])
def test_hanging_pendulum_in_the_plane(joint):
    model = planar_pendulum(-9.81, joint)
    assert fm.frequencies(model)[0] == approx(PENDULUM, rel=1e-10)
    lin = fm.linearize(model)
    # At rest without any auxiliary spring; there is no elastic stiffness at all.
    np.testing.assert_allclose(lin.x, model.parameters.reference, atol=1e-12)
    assert float(lin.K0[0, 0]) == 0.0
    joint_force = fm.equilibrium(model).reactions[np.array(model.labels.coordinates("joint"))]
    np.testing.assert_allclose(joint_force, [0, 9.81], atol=1e-12)


@pytest.mark.slow
def test_inverted_pendulum_is_reported_unstable():
    model = planar_pendulum(9.81)
    found = fm.modes(model)
    assert found.eigenvalues[0] == approx(-9.81 / 1.1, rel=1e-10)
    assert not found.stable
    assert found.frequencies[0] == approx(-PENDULUM, rel=1e-10)


@pytest.mark.slow
def test_hanging_pendulum_in_space():
    b = fm.Builder()
    b.node("joint", (0, 0, 0))
    b.node("body", (0, 0, -1))
    b.add(spatial.rigid_beam, "body", "joint")
    b.rotation("ground")
    b.add(spatial.hinge, "ground", "body", axis=(0, 1, 0), name="hinge")
    b.fix("ground")
    # The hinge holds two rotations; the joint's position the translations.
    b.fix("joint", "position")
    b.mass("body", 1.0, inertia=(0.1, 0, 0, 0.1, 0, 0.1))
    b.gravity((0, 0, -9.81))
    model = b.build()
    assert model.counts()["ndof"] == 1
    assert fm.frequencies(model)[0] == approx(PENDULUM, rel=1e-10)


def column(beams, length=0.1, extension=0.0, force=(0.0, -1.0), held="free", section=None):
    """Clamped column along y with a rigid extension; unit load down at its end."""
    section = section or fm.Rectangle(0.018, 0.0005, fm.Material(210e9, 80e9, 7850.0))
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(str(i), (0, length * i / beams))
    for i in range(beams):
        b.add(planar.beam, str(i), str(i + 1), name=f"beam {i}", section=section)
    b.fix("0", *(("position",) if held == "pinned" else ()))
    top = str(beams)
    if extension:
        b.node("end", (0, length + extension))
        b.add(planar.rigid_beam, top, "end")
    if held in ("pinned", "propped"):
        b.fix(top, "x")
    if held in ("guided", "clamped"):
        b.fix(top, "phi")
    if held == "clamped":
        b.fix(top, "x")
    b.force("end" if extension else top, force)
    b.mass(top, 0.1)
    return b


@pytest.mark.slow
def test_rigid_extension_buckles_at_the_right_load():
    # P2: k l tan(k l) = l/e, P = 2.91443467 N; without the stiffness of constraint forces 9.7154 would come out.
    loads = [float(fm.buckling_loads(column(n, extension=0.1).build())[0]) for n in (2, 4, 8)]
    errors = np.abs(np.array(loads) / 2.91443467 - 1)
    assert errors[1] < 0.005
    # Axial strain P/EA = 1.5e-6 is what the closed form leaves out.
    assert errors[2] < 1e-5
    assert np.log2(errors[0] / errors[1]) > 3.5


@pytest.mark.slow
def test_rigid_extension_changes_sign_of_stability_at_its_load():
    stable = [
        bool(fm.modes(column(4, extension=0.1, force=(0, -p)).build()).stable) for p in (2.90, 2.93)
    ]  # 0.5 % around 2.9144
    assert stable == [True, False]


@pytest.mark.slow
@pytest.mark.parametrize("element", ["cubic", "spectral"])
def test_lowest_eigenvalue_is_zero_at_the_load_of_linear_buckling(element):
    # P2 by mode 7 and by mode 8: two questions, one load.
    if element == "cubic":
        b = column(4, extension=0.1)
    else:
        b = fm.Builder()
        for name, y in (("foot", 0.0), ("tip", 0.1), ("end", 0.2)):
            b.node(name, (0, y))
        leaf = fm.Rectangle(0.018, 0.0005, fm.Material(210e9, 80e9, 7850.0))
        b.add(planar.spectral_beam(6), "foot", "tip", name="leaf", section=leaf)
        b.add(planar.rigid_beam, "tip", "end")
        b.fix("foot")
        b.force("end", (0, -1.0))
        b.mass("tip", 0.1)
    model = b.build()

    def lowest(load):
        return float(fm.modes(fm.linearize(model, load_factor=load)).eigenvalues[0])

    critical = brentq(lowest, 2.8, 3.0, xtol=1e-9)
    # Multipliers are counted at the strain of 1 N, the eigenvalue is zero at that of 2.9 N: P/EA = 1.5e-6.
    assert fm.buckling_loads(model)[0] == approx(critical, rel=3e-6)
    if element == "spectral":
        assert critical == approx(2.91443467, rel=3e-6)


@pytest.mark.slow
def test_side_load_grows_towards_the_buckling_load():
    def displacement(p):
        return float(fm.equilibrium(column(8, extension=0.1, force=(1e-3, -p)).build()).at("end")[0])

    # As 1/(1 - P/P_cr): 12.4-fold between 1.5 and 2.8 N (P2; two digits given).
    assert displacement(2.8) / displacement(1.5) == approx(12.4, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("held", "value"),
    [
        ("free", 2.4674011003),
        ("pinned", 9.8696044011),
        ("propped", 20.1907285564),
        ("clamped", 39.4784176044),
        ("guided", 9.8696044011),
    ],
)
def test_euler_columns(held, value):
    """A11: P L^2/EI, inextensible; by four cubic beams."""
    section = fm.Rigidity(EA=1e6, EIy=1.0, mass=1.0)
    load = float(fm.buckling_loads(column(4, 1.0, held=held, section=section).build())[0])
    # A cubic in place of the sine of wave number k over an element of length h: (k h)^4/720 of the load. The axial
    # strain P/EA, up to 4e-5, shifts the load by as much.
    assert abs(load / value - 1) < 2 * (value / 4**2) ** 2 / 720 + 2 * value / 1e6


@pytest.mark.slow
def test_euler_column_scales_with_thickness_and_length():
    def load(t, length):
        b = column(4, length, section=fm.Rectangle(0.018, t, fm.Material(210e9, 80e9, 7850.0)))
        for i in range(4):
            b.dof(f"beam {i}", 1, 2, 3)
        return fm.buckling_loads(b.build())[0]

    value, (by_t, by_l) = fm.jit(jax.value_and_grad(load, argnums=(0, 1)))(5e-4, 0.1)
    # Exact for the inextensible column; the strain P/EA = 5e-6 is left.
    assert by_t * 5e-4 / value == approx(3, abs=5e-5)
    assert by_l * 0.1 / value == approx(-2, abs=5e-5)


@pytest.mark.slow
@pytest.mark.parametrize("dofs", [("a.x", "b.x"), ("a.x", "bar.1")], ids=["places", "elongation"])
def test_free_masses_have_a_frequency_besides_their_common_motion(dofs):
    b = fm.Builder()
    b.node("a", (0, 0))
    b.node("b", (1, 0))
    b.add(planar.truss, "a", "b", name="bar", section=fm.Rigidity(EA=100.0))
    for node, mass in (("a", 0.37), ("b", 2.0)):
        b.fix(node, "y")
        b.mass(node, mass)
    for of, component in (dof.split(".") for dof in dofs):
        b.dof(of, component)
    found = fm.frequencies(b.build())
    # Round-off of zero under the root; the other has lost the digits by which the shift exceeds it.
    assert abs(found[0]) < 1e-6
    assert found[1] == approx(np.sqrt(100 * (1 / 0.37 + 1 / 2.0)) / (2 * np.pi), rel=1e-7)
