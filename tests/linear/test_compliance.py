"""Compliance of a node that has turned, against differences of nonlinear equilibria."""

import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import flexmb as fm
from flexmb import planar, spatial

# Of the difference: its truncation goes with the square, its round-off with 1e-13 over it.
STEP = 1e-5


def arm(dimension, more=None) -> fm.Model:
    """A cantilever that a force and a moment have bent by some tenths of a radian, and some more of both."""
    b = fm.Builder()
    b.node("foot", np.zeros(dimension))
    b.node("tip", np.eye(dimension)[0])
    section = fm.Rigidity(EA=1e3, GIt=2.0, EIy=3.0, EIz=1.0)
    if dimension == 2:
        b.add(planar.beam, "foot", "tip", name="arm", section=section)
        load = np.array([0.5, 0.8, 0.4])
    else:
        b.add(spatial.beam, "foot", "tip", name="arm", section=section, y=(0, 1, 0))
        load = np.array([0.5, 0.3, -0.6, 0.4, 0.3, 0.2])
    load = load if more is None else load + more
    b.fix("foot")
    b.force("tip", load[:dimension])
    if dimension == 2:
        b.force("tip.rotation", load[2:])
    else:
        b.moment("tip", load[3:])
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize("dimension", [2, 3])
def test_compliance_of_a_turned_node(dimension):
    model, size = arm(dimension), 3 * (dimension - 1)
    columns = []
    for one in np.eye(size):
        ends = [fm.equilibrium(arm(dimension, sign * STEP * one)) for sign in (1, -1)]
        moved = np.asarray(ends[0].at("tip") - ends[1].at("tip"))
        turned = [np.asarray(end.at("tip.rotation")) for end in ends]
        if dimension == 2:
            turn = turned[0] - turned[1]
        else:
            after, before = (Rotation.from_quat(q, scalar_first=True) for q in turned)
            turn = (after * before.inv()).as_rotvec()
        columns.append(np.concatenate([moved, turn]) / (2 * STEP))
    expected = np.array(columns).T
    lin = fm.linearize(model)
    np.testing.assert_allclose(fm.compliance(lin, "tip"), expected, rtol=1e-6, atol=1e-7)
    # In axes that turn along, forces and displacements alike.
    here = np.asarray(lin.x[model.labels.known("tip.rotation")])
    if dimension == 2:
        axes = np.eye(3)
        axes[:2, :2] = Rotation.from_rotvec([0, 0, here[0]]).as_matrix()[:2, :2]
        assert abs(here[0]) > 0.2
    else:
        axes = np.kron(np.eye(2), Rotation.from_quat(here, scalar_first=True).as_matrix())
        assert np.linalg.norm(here[1:]) > 0.1
    found = np.asarray(fm.compliance(lin, "tip", local=True))
    np.testing.assert_allclose(found, axes.T @ expected @ axes, rtol=1e-6, atol=1e-6)
    # A unit force along each axis by itself.
    each = fm.linear.directional_compliance(lin)
    np.testing.assert_allclose(each["tip"], np.diag(expected)[:dimension], rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(each["tip.rotation"], np.diag(expected)[dimension:], rtol=1e-6, atol=1e-7)


def test_a_state_that_is_not_stable_is_told():
    """A column under more than pi^2 EI/(4 L^2) that stands upright, and one under less."""
    for force, told in ((-9.0, True), (-6.0, False)):
        model = arm(2, np.array([force, 0.0, 0.0]) - np.array([0.5, 0.8, 0.4]))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            found = fm.compliance(model, "tip")
        assert any("negative work" in str(one.message) for one in caught) == told == (found[1, 1] < 0)


def test_round_off_of_a_held_direction_is_no_instability():
    # A rigid body holds the node along its line: 1e-47 m/N of either sign is left there, against 1e-3 across it.
    from flexmb.linear.compliance import _warn_of_instability

    found = np.diag([-1e-47, 1e-3, 5e-2])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        _warn_of_instability(found, "tip", 2)
    with pytest.warns(fm.FlexmbWarning, match="negative work"):
        _warn_of_instability(np.diag([-1e-9, 1e-3, 5e-2]), "tip", 2)
