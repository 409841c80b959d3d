"""What joints and springs in space measure of a turn about their axis and of a tilt across it."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import flexmb as fm
from flexmb import spatial
from flexmb.mechanics.deformation import deformations, zero_near

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
        e = np.asarray(deformations(model.topology, model.parameters, x, zero_near(model.topology)))[places]
        assert e[0] == pytest.approx(expected, abs=1e-12)
        if kind == "hinge":
            # Twice the Euler parameters across the axis.
            tilt = 0.0 if axis is AXIS else 2 * np.sin(abs(angle) / 2)
            assert np.linalg.norm(e[1:]) == pytest.approx(tilt, abs=1e-12)
