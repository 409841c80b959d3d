"""What a path tells of each of its states: a shallow truss in closed form."""

import numpy as np
import pytest

import flexmb as fm
from flexmb import planar

BASE, HEIGHT, EA, MASS = 10.0, 1.0, 1e4, 2.0
LENGTH = np.hypot(BASE, HEIGHT)


@pytest.fixture(scope="module")
def snap():
    """Two bars to an apex that is pushed down, beyond its limit load."""
    b = fm.Builder()
    for name, position in {"left": (-BASE, 0), "right": (BASE, 0), "apex": (0, HEIGHT)}.items():
        b.node(name, position)
    E = EA / (np.pi * 0.005**2)
    section = fm.Circle(0.01, fm.Material(E=E, G=E / 2.6, rho=0.0))
    b.add(planar.truss, "left", "apex", name="bar", section=section)
    b.add(planar.truss, "apex", "right", section=section)
    b.fix("left")
    b.fix("right")
    b.fix("apex", "x")
    b.mass("apex", MASS)
    b.force("apex", (0, -5.0))
    return fm.path(b.build())


def load_at(y):
    return -2 * EA * (1 / np.hypot(BASE, y) - 1 / LENGTH) * y


@pytest.mark.slow
def test_a_path_tells_what_its_closed_form_does(snap):
    y = snap.along("apex.y").values
    np.testing.assert_allclose(snap.along("displacement apex.y").values, y - HEIGHT, atol=1e-15)
    # Round-off of the forces of the bars, 1e-16 EA.
    np.testing.assert_allclose(snap.along("force apex.y").values, load_at(y), atol=1e-9)
    stretched = np.hypot(BASE, y) - LENGTH
    np.testing.assert_allclose(snap.along("deformation bar.1").values, stretched, atol=1e-13)
    np.testing.assert_allclose(snap.along("stress resultant bar.e1").values, EA * stretched / LENGTH, atol=1e-9)
    # Left of the apex a bar that is pushed pushes its foot to the left; the foot holds it.
    pull = EA * stretched / LENGTH
    np.testing.assert_allclose(snap.along("reaction left.x").values, -pull * BASE / np.hypot(BASE, y), atol=1e-9)
    stress = np.abs(pull) / (np.pi * 0.005**2)
    np.testing.assert_allclose(snap.along("stress").values, stress, rtol=1e-9, atol=1e-3)
    np.testing.assert_allclose(snap.along("stress bar").values, stress, rtol=1e-9, atol=1e-3)
    # Slope of the closed form by central differences: the error of their step.
    step = 1e-4
    slope = (load_at(y + step) - load_at(y - step)) / (2 * step)
    np.testing.assert_allclose(snap.along("stiffness apex.y").values, slope, atol=1e-5)
    hertz = np.sign(slope) * np.sqrt(np.abs(slope) / MASS) / (2 * np.pi)
    np.testing.assert_allclose(snap.along("frequency 1").values, hertz, rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(snap.along("displacement").values, HEIGHT - y, atol=1e-15)
    np.testing.assert_array_equal(snap.along("mass").values, np.full(len(y), MASS))
    assert snap.along("load factor").values[-1] == 1.0
    assert (snap.along("frequency 1").axis, snap.along("stiffness apex.y").unit) == ("frequency 1 [Hz]", "N/m")


@pytest.mark.slow
def test_critical_points_are_states_too(snap):
    found = snap.at_critical_points()
    # A7, closed form: where l^3 = L0 b^2.
    limit = 2 * EA * (1 - (BASE / LENGTH) ** (2 / 3)) ** 1.5
    np.testing.assert_allclose(found.along("force apex.y").values, [-limit, limit], rtol=1e-9)
    # Stiffness of the mechanism is gone: beside its 20 N/m at rest.
    np.testing.assert_allclose(found.along("stiffness apex.y").values, 0.0, atol=1e-5)


@pytest.mark.slow("velocity apex.x-has no velocities")
@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("apex.z", r"there is apex\.x, apex\.y"),
        ("nothing", r"such as tip\.y, or ask for load factor, acceleration, deformation"),
        ("force top.y", "no node 'top'"),
        ("stiffness apex.phi", "has no component 'phi' here; it has x, y"),
        ("frequency 2", "numbered 1 to 1"),
        ("stress foot", "no stress of an element 'foot'"),
        ("deformation bar.x", "has deformations 1 to 1, not 'x'"),
        ("velocity apex.x", "has no velocities"),
    ],
)
def test_what_is_not_there(snap, text, words):
    with pytest.raises((KeyError, AttributeError), match=words):
        snap.along(text)
