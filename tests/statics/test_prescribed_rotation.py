"""Prescribed rotations, the angle itself, past half and full turns (A4, B3)."""

import contextlib
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import mechanisms
from scipy.spatial.transform import Rotation

import flexmb as fm
from flexmb import planar, spatial

SKEW = np.array([1.0, 2.0, -2.0]) / 3
LENGTH = 1.0
SECTION = fm.Rigidity(EA=1e9, EIy=1.0, EIz=2.0, GIt=0.7, mass=1.0)


def cantilever(
    turned, axis, angle, tilt=None, along=(1.0, 0.0, 0.0), y=(0.0, 0.0, 1.0), increment=0.0, beam=spatial.beam
):
    """Two beams along a direction, held at the foot A; the foot or the tip is turned."""
    b = fm.Builder()
    for i, name in enumerate(("A", "M", "B")):
        b.node(name, np.array(along) * LENGTH * i / 2)
    for ends in (("A", "M"), ("M", "B")):
        b.add(beam, *ends, name="".join(ends), section=SECTION, y=y)
    b.fix("A", *(("position",) if turned == "A" else ()))
    b.prescribe(turned, "rotation", angle, axis=axis, tilt=tilt)
    if increment:
        b.prescribe(turned, "rotation", increment, axis=axis, increment=True)
    return b.build()


def deformation(model, values, name):
    return values[[str(entry) for entry in model.labels.e].index(name)]


@pytest.mark.parametrize("angle", [1.0, np.pi, 2 * np.pi, 2.5 * np.pi, -7 * np.pi])
def test_a_body_turned_at_its_clamp_moves_rigidly(angle):
    model = cantilever("A", SKEW, angle)
    found = fm.equilibrium(model)
    turned = Rotation.from_rotvec(angle * SKEW).apply([LENGTH, 0, 0])
    # Round-off of a hundred load steps.
    np.testing.assert_allclose(found.at("B"), turned, atol=1e-13)
    # Euler parameters change sign with every turn, so that they tell 2.5 pi from pi/2.
    expected = np.r_[np.cos(angle / 2), np.sin(angle / 2) * SKEW]
    np.testing.assert_allclose(found.at("B.rotation"), expected, atol=1e-13)
    own = [e.of in ("AM", "MB") for e in model.labels.e]
    np.testing.assert_allclose(found.e[np.array(own)], 0, atol=1e-13)
    assert deformation(model, found.e, "turn of A.e1") == pytest.approx(angle, abs=1e-12)


@pytest.mark.parametrize("angle", [2 * np.pi, 2.5 * np.pi])
def test_roll_up_by_the_angle_of_the_tip_in_space(angle):
    # A4: constant curvature theta/L; leaf along a skew direction, turned about an axis across it.
    along, axis = np.array([2.0, 1.0, 2.0]) / 3, np.array([2.0, -2.0, -1.0]) / 3
    model = cantilever("B", axis, angle, along=along, y=axis, beam=spatial.spectral_beam(3))
    # Rolled so far it gives way sideways, as lowest frequencies below zero tell too.
    with pytest.warns(fm.FlexmbWarning, match="The equilibrium is not stable"):
        found = fm.equilibrium(model)
    assert fm.frequencies(model, count=1)[0] < 0
    across = np.cross(axis, along)
    tip = LENGTH / angle * (np.sin(angle) * along + (1 - np.cos(angle)) * across)
    np.testing.assert_allclose(found.at("B"), tip, atol=1e-9)
    # The multiplier is the stress in the hinge: what it puts on the tip is the opposite.
    moment = -deformation(model, found.sigma, "turn of B.e1")
    assert moment == pytest.approx(SECTION.EIy * angle / LENGTH, rel=1e-9)


@pytest.mark.parametrize("angle", [2 * np.pi, 2.5 * np.pi])
def test_roll_up_by_the_angle_of_the_tip_in_the_plane(angle):
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (LENGTH, 0))
    b.add(planar.spectral_beam(3), "A", "B", name="leaf", section=SECTION)
    b.fix("A")
    b.prescribe("B", "rotation", angle)
    found = fm.equilibrium(b.build())
    tip = LENGTH / angle * np.array([np.sin(angle), 1 - np.cos(angle)])
    np.testing.assert_allclose(found.at("B"), tip, atol=1e-9)
    assert found.at("B.rotation")[0] == pytest.approx(angle, rel=1e-12)
    assert found.reactions[b.build().labels.known("B.rotation")[0]] == pytest.approx(angle / LENGTH, rel=1e-9)


def test_a_free_tilt_takes_no_moment():
    # Linear unsymmetric bending: principal axes at 0.5 rad from the axis turned about.
    alpha, small = 0.5, 1e-4
    y = (0.0, -np.sin(alpha), np.cos(alpha))
    # EIz resists bending that displaces along y, EIy along z: rotation vectors of those are along z and y.
    about_local_y, about_local_z = np.cos(alpha) ** 2, np.sin(alpha) ** 2
    soft = LENGTH * (about_local_y / SECTION.EIy + about_local_z / SECTION.EIz)
    stiff = (about_local_y * SECTION.EIy + about_local_z * SECTION.EIz) / LENGTH
    for tilt, expected in (("free", 1 / soft), ("fixed", stiff)):
        model = cantilever("B", (0, 0, 1), small, tilt, y=y)
        moment = -deformation(model, fm.equilibrium(model).sigma, "turn of B.e1")
        # The position of the tip is free, so that the curvature is constant; what is left is of the angle's square.
        assert moment / small == pytest.approx(expected, rel=1e-6), tilt


def test_the_opposite_of_the_stress_resultant_put_on_the_node_turns_it_as_far():
    """As Builder.prescribe says: what is prescribed by an angle, and the same held there by a moment."""
    axis, angle = np.array([0.0, 0.0, 1.0]), 0.3
    prescribed = cantilever("B", axis, angle, "free")
    found = fm.equilibrium(prescribed)
    moment = -deformation(prescribed, found.sigma, "turn of B.e1")
    assert moment > 0
    b = fm.Builder()
    for i, name in enumerate(("A", "M", "B")):
        b.node(name, (LENGTH * i / 2, 0, 0))
    for ends in (("A", "M"), ("M", "B")):
        b.add(spatial.beam, *ends, name="".join(ends), section=SECTION, y=(0, 0, 1))
    b.fix("A")
    b.moment("B", moment * axis)
    turned = Rotation.from_quat(np.asarray(fm.equilibrium(b.build()).at("B.rotation")), scalar_first=True)
    # Round-off times EA L^2/EI = 1e9.
    np.testing.assert_allclose(turned.as_rotvec(), angle * axis, atol=1e-6)
    # In the plane the reaction is what is put on the node.
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (LENGTH, 0))
    b.add(planar.beam, "A", "B", name="leaf", section=SECTION)
    b.fix("A")
    b.prescribe("B", "rotation", 1e-3)
    model = b.build()
    reaction = fm.equilibrium(model).reactions[model.labels.known("B.rotation")[0]]
    assert reaction == pytest.approx(SECTION.EIy * 1e-3 / LENGTH, rel=1e-5)


def cross_pivot_in_space(angle):
    """B3 with its leaf springs in two parallel planes; a hinge of the other kind turns the body."""
    b = fm.Builder()
    section = fm.Rigidity(EA=1e9, EIy=1.0, EIz=1e4, GIt=1.0)
    d = np.array([1.0, 1.0, 0.0]) / np.sqrt(2)
    b.node("body", (0, 0, 0))
    for name, along, height in (("a", d, 0.2), ("b", d * [-1, 1, 0], -0.2)):
        b.node(f"{name} foot", -0.5 * along + [0, 0, height])
        b.node(f"{name} top", 0.5 * along + [0, 0, height])
        ends = f"{name} foot", f"{name} top"
        b.add(spatial.spectral_beam(6), *ends, name=name, section=section, y=(0, 0, 1))
        b.fix(f"{name} foot")
        b.add(spatial.beam, "body", f"{name} top", name=f"arm {name}")
    b.prescribe("body", "rotation", angle, axis=(0, 0, 1))
    return b.build()


def test_cross_pivot_in_space():
    for degrees, stiffness, shift in ((5, 2.00253510, 8.96862e-4), (10, 2.01010020, 3.579963e-3)):
        angle = np.radians(degrees)
        model = cross_pivot_in_space(angle)
        found = fm.equilibrium(model)
        moment = -deformation(model, found.sigma, "turn of body.e1")
        assert moment / angle == pytest.approx(stiffness, rel=1e-6)
        assert np.linalg.norm(found.at("body")) == pytest.approx(shift, rel=1e-5)
    for degrees in (225, 270):
        # Past half a turn, against the planar mechanism, whose angle is a coordinate.
        angle = np.radians(degrees)
        # In the end its leaf springs give way sideways.
        gives_way = pytest.warns(fm.FlexmbWarning, match="The equilibrium is not stable")
        with gives_way if degrees == 270 else contextlib.nullcontext():
            found = fm.equilibrium(cross_pivot_in_space(angle)).at("body")
        plane = fm.equilibrium(mechanisms.cross_pivot(0.5, angle).build()).at("body")
        # Error of six coefficients a strain in leaf springs that bend by most of a turn.
        np.testing.assert_allclose(found, np.r_[plane, 0.0], atol=5e-5)
        np.testing.assert_allclose(found[2], 0, atol=1e-12)


def test_derivative_by_the_angle():
    model = cantilever("B", SKEW, 2.0)

    def moment(angle):
        loads = replace(model.parameters.loads, e=angle[None])
        found = fm.equilibrium(replace(model, parameters=replace(model.parameters, loads=loads)))
        return deformation(model, found.sigma, "turn of B.e1")

    step = 1e-4
    difference = float(moment(jnp.array(2.0 + step)) - moment(jnp.array(2.0 - step))) / (2 * step)
    # Truncation, the square of the step; round-off of x, 1e-16 times the ratio 1e9 of the stiffnesses, over it.
    assert fm.jit(jax.grad(moment))(jnp.array(2.0)) == pytest.approx(difference, rel=1e-6)


def test_initial_and_incremental_angles_add_up():
    found = fm.equilibrium(cantilever("A", SKEW, -np.pi, increment=5 * np.pi), increment=0.7)
    np.testing.assert_allclose(found.at("A.rotation"), np.r_[np.cos(1.25 * np.pi), np.sin(1.25 * np.pi) * SKEW])


def test_wrong_descriptions():
    def started():
        b = fm.Builder()
        b.node("A", (0, 0, 0))
        b.node("B", (1, 0, 0))
        b.add(spatial.beam, "A", "B", name="leaf", section=SECTION)
        return b

    with pytest.raises(fm.ModelError, match=r"Rotation of node 'B': in space it needs an axis"):
        started().prescribe("B", "rotation", 1.0)
    with pytest.raises(fm.ModelError, match=r"Rotation of node 'B': tilt must be 'fixed' or 'free', not 'loose'"):
        started().prescribe("B", "rotation", 1.0, axis=(0, 0, 1), tilt="loose")
    with pytest.raises(fm.ModelError, match=r"'B.x': only component \"rotation\" takes an axis"):
        started().prescribe("B", "x", 1.0, axis=(0, 0, 1))
    with pytest.raises(fm.ModelError, match=r"'turn of B' has an axis of zero length"):
        started().prescribe("B", "rotation", 1.0, axis=(0, 0, 0))
    b = started()
    b.fix("A")
    with pytest.raises(fm.ModelError, match="The rotation of node 'A' is fixed already"):
        b.prescribe("A", "rotation", 1.0, axis=(0, 0, 1))
    b.prescribe("B", "rotation", 1.0, axis=(0, 0, 1))
    for other in ({"axis": (0, 1, 0)}, {"axis": (0, 0, 1), "tilt": "free"}):
        with pytest.raises(fm.ModelError, match="Rotation of node 'B': it is prescribed already, with another axis or"):
            b.prescribe("B", "rotation", 1.0, increment=True, **other)
