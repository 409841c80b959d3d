"""What joints and springs in space measure of a turn about their axis and of a tilt across it."""

import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx
from jax.tree_util import Partial
from scipy.spatial.transform import Rotation

import flexmb as fm
from flexmb import spatial
from flexmb.mechanics.deformation import deformations, zero_strain

AXIS = np.array([1.0, 2.0, 2.0]) / 3
ACROSS = np.array([2.0, 1.0, -2.0]) / 3


def torque(e, ed, *, k):
    return k * e


@pytest.mark.parametrize("kind", ["hinge", "spring"])
@pytest.mark.parametrize("angle", [0.3, -2.0])
def test_a_turn_about_the_axis_and_a_tilt_across_it(kind, angle):
    """Both bodies turned and the second one relative to the first, about the axis as the first has carried it."""
    b = fm.Builder()
    b.node("o", (0, 0, 0))
    b.rotation("p")
    b.rotation("q")
    if kind == "hinge":
        b.add(spatial.hinge, "p", "q", name="joint", axis=AXIS)
    else:
        b.add(spatial.rotary_spring_damper(torque), "p", "q", name="joint", axis=AXIS, k=2.0)
    model = b.build(check=False)
    places = [i for i, entry in enumerate(model.labels.e) if entry.of == "joint"]
    carried = Rotation.from_rotvec([0.4, -0.2, 0.5])
    for axis, expected in ((AXIS, angle), (ACROSS, 0.0)):
        x = np.array(model.parameters.reference)
        x[model.labels.known("p")] = carried.as_quat(scalar_first=True)
        x[model.labels.known("q")] = (carried * Rotation.from_rotvec(angle * axis)).as_quat(scalar_first=True)
        e = np.asarray(deformations(model.topology, model.parameters, x, zero_strain(model.topology)))[places]
        assert e[0] == approx(expected, abs=1e-12)
        if kind == "hinge":
            # Twice the sine of half the angle.
            tilt = 0.0 if axis is AXIS else 2 * np.sin(abs(angle) / 2)
            assert np.linalg.norm(e[1:]) == approx(tilt, abs=1e-12)


def test_tilts_are_those_of_the_axis_in_the_first_body_however_far_it_turns():
    """A turn about the axis, then a tilt about a line across it that the first body carries: by hand."""
    b = fm.Builder()
    b.node("o", (0, 0, 0))
    b.rotation("p")
    b.rotation("q")
    b.add(spatial.hinge, "p", "q", name="joint", axis=(1, 0, 0))
    model = b.build(check=False)
    places = [i for i, entry in enumerate(model.labels.e) if entry.of == "joint"]
    carried = Rotation.from_rotvec([0.4, -0.2, 0.5])
    found = []
    for turn in (0.0, 1.0, 3.0):
        x = np.array(model.parameters.reference)
        tilted = Rotation.from_rotvec([0.0, 0.12, -0.16]) * Rotation.from_rotvec([turn, 0.0, 0.0])
        x[model.labels.known("p")] = carried.as_quat(scalar_first=True)
        x[model.labels.known("q")] = (carried * tilted).as_quat(scalar_first=True)
        e = np.asarray(deformations(model.topology, model.parameters, x, zero_strain(model.topology)))[places]
        assert e[0] == approx(turn, abs=1e-12)
        found.append(e[1:])
    # The angle is 0.2, about an axis across in the share 3 to -4; which two lines across are measured, the first tells.
    assert np.linalg.norm(found[0]) == approx(2 * np.sin(0.1), rel=1e-12)
    np.testing.assert_allclose(found[1:], [found[0]] * 2, rtol=0, atol=1e-12)


def spring(e, ed, *, k):
    return k * e


def turned(t, *, speed):
    return speed * t


@pytest.mark.slow
def test_whirl_of_a_rotor_whose_spin_is_prescribed_and_whose_tilts_are_free():
    """About its centre, on springs across an arm a: J w^2 - Jp Omega w - k a^2 = 0."""
    inertia, polar, a, k, speed = 0.05, 0.08, 0.2, 5e4, 200.0

    def rotor(other):
        b = fm.Builder()
        b.node("o", (0, 0, 0))
        b.fix("o", "x", "y", "z")
        b.node("l", (0, 0, a))
        b.add(spatial.rigid_beam, "o", "l", name="arm")
        for i, way in enumerate(np.eye(3)[:2]):
            b.node(f"far{i}", 100 * way + [0, 0, a])
            b.fix(f"far{i}")
            b.add(spatial.spring_damper(spring), "l", f"far{i}", k=k)
        b.body("o", 0.1, inertia=np.diag([inertia, other, polar]))
        b.prescribe("o", "rotation", 0.0, axis=(0, 0, 1), tilt="free")
        b.dof("turn of o", 2, 3)
        return b.build()

    drive = {"o.rotation": Partial(turned, speed=jnp.array(speed))}
    found = np.sort(np.abs(np.imag(fm.poles(fm.motion.steady_motion(rotor(inertia), drive)))))[::2]
    expected = np.sort(np.abs(np.roots([inertia, -polar * speed, -k * a**2])))
    # The springs are 100 long: they turn by 1e-3 of what they lengthen.
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    # A body of unequal inertias spins beside these tilts.
    with pytest.warns(fm.FlexmbWarning, match="are not constant in this motion"):
        fm.motion.steady_motion(rotor(1.3 * inertia), drive)
