"""Prescribed rotations, the angle itself, past half and full turns (A4, B3)."""

import contextlib
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from cases import mechanisms
from cases.tolerances import approx
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


@pytest.mark.slow
@pytest.mark.parametrize("angle", [1.0, np.pi, 2 * np.pi, 2.5 * np.pi, -7 * np.pi])
def test_a_body_turned_at_its_clamp_moves_rigidly(angle):
    model = cantilever("A", SKEW, angle, "fixed")
    found = fm.equilibrium(model)
    turned = Rotation.from_rotvec(angle * SKEW).apply([LENGTH, 0, 0])
    # Round-off of a hundred load steps.
    np.testing.assert_allclose(found.at("B"), turned, atol=1e-13)
    # Euler parameters change sign with every turn, so that they tell 2.5 pi from pi/2.
    expected = np.r_[np.cos(angle / 2), np.sin(angle / 2) * SKEW]
    np.testing.assert_allclose(found.at("B.rotation"), expected, atol=1e-13)
    own = [e.of in ("AM", "MB") for e in model.labels.e]
    np.testing.assert_allclose(found.e[np.array(own)], 0, atol=1e-13)
    assert deformation(model, found.e, "turn of A.e1") == approx(angle, abs=1e-12)


@pytest.mark.slow
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
    assert moment == approx(SECTION.EIy * angle / LENGTH, rel=1e-9)


@pytest.mark.slow
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
    assert found.at("B.rotation")[0] == approx(angle, rel=1e-12)
    assert found.reactions[b.build().labels.known("B.rotation")[0]] == approx(angle / LENGTH, rel=1e-9)


@pytest.mark.slow
def test_a_free_tilt_takes_no_moment():
    # Linear unsymmetric bending: principal axes at 0.5 rad from the axis turned about.
    alpha, small = 0.5, 1e-4
    y = (0.0, -np.sin(alpha), np.cos(alpha))
    # EIz resists bending that displaces along y, EIy along z: rotation vectors of those are along z and y.
    about_local_y, about_local_z = np.cos(alpha) ** 2, np.sin(alpha) ** 2
    soft = LENGTH * (about_local_y / SECTION.EIy + about_local_z / SECTION.EIz)
    stiff = (about_local_y * SECTION.EIy + about_local_z * SECTION.EIz) / LENGTH
    for tilt, expected in (("free", 1 / soft), (None, 1 / soft), ("fixed", stiff)):
        model = cantilever("B", (0, 0, 1), small, tilt, y=y)
        moment = fm.equilibrium(model).reaction("B", "rz")
        # The position of the tip is free, so that the curvature is constant; what is left is of the angle's square.
        assert moment / small == approx(expected, rel=1e-6), tilt


@pytest.mark.slow
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
    assert reaction == approx(SECTION.EIy * 1e-3 / LENGTH, rel=1e-5)


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
    b.prescribe("body", "rotation", angle, axis=(0, 0, 1), tilt="fixed")
    return b.build()


@pytest.mark.slow
def test_cross_pivot_in_space():
    for degrees, stiffness, shift in ((5, 2.00253510, 8.96862e-4), (10, 2.01010020, 3.579963e-3)):
        angle = np.radians(degrees)
        model = cross_pivot_in_space(angle)
        found = fm.equilibrium(model)
        moment = -deformation(model, found.sigma, "turn of body.e1")
        assert moment / angle == approx(stiffness, rel=1e-6)
        assert np.linalg.norm(found.at("body")) == approx(shift, rel=1e-5)
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


@pytest.mark.slow
def test_derivative_by_the_angle():
    model = cantilever("B", SKEW, 2.0, "fixed")

    def moment(angle):
        loads = replace(model.parameters.loads, e=angle[None])
        found = fm.equilibrium(replace(model, parameters=replace(model.parameters, loads=loads)))
        return deformation(model, found.sigma, "turn of B.e1")

    step = 1e-4
    difference = float(moment(jnp.array(2.0 + step)) - moment(jnp.array(2.0 - step))) / (2 * step)
    # Truncation, the square of the step; round-off of x, 1e-16 times the ratio 1e9 of the stiffnesses, over it.
    assert fm.jit(jax.grad(moment))(jnp.array(2.0)) == approx(difference, rel=1e-6)


@pytest.mark.slow
def test_initial_and_incremental_angles_add_up():
    found = fm.equilibrium(cantilever("A", SKEW, -np.pi, "fixed", increment=5 * np.pi), increment=0.7)
    np.testing.assert_allclose(found.at("A.rotation"), np.r_[np.cos(1.25 * np.pi), np.sin(1.25 * np.pi) * SKEW])


@pytest.mark.slow
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
    for other in ({"axis": (0, 1, 0)}, {"axis": (0, 0, 1), "tilt": "fixed"}):
        with pytest.raises(fm.ModelError, match="Rotation of node 'B': it is prescribed already, with another axis or"):
            b.prescribe("B", "rotation", 1.0, increment=True, **other)


SHAFT = fm.Rigidity(EA=1e6, EIy=4.0, EIz=5.0, GIt=8.0, mass=1.0)


LABELS = ["B.x", "B.y", "B.z", "B.rx", "B.ry", "B.rz"]


def shaft(beam=spatial.beam):
    """A shaft of 1 m along x with GI_t 8 N m^2, held at A, and a body at B."""
    b = fm.Builder()
    b.node("A", (0, 0, 0))
    b.node("B", (1, 0, 0))
    b.add(beam, "A", "B", name="shaft", section=SHAFT)
    b.fix("A")
    b.body("B", 1.0, inertia=(2.0, 0, 0, 3.0, 0, 4.0))
    return b


def turned_by_axis(b, angle, **options):
    b.prescribe("B", "rotation", angle, axis=(1, 0, 0), **options)


def turned_by_name(b, angle, **options):
    b.prescribe("B", "rx", angle, **options)


# Half of GI_t sin^2 of the angle is the energy of a cubic beam that is twisted alone.
MOMENT = SHAFT.GIt * np.sin(0.2) * np.cos(0.2)


@pytest.mark.slow
@pytest.mark.parametrize("turn", [turned_by_axis, turned_by_name])
def test_the_moment_that_turns_a_shaft(turn):
    """It acts on the node whose rotation is prescribed, and its opposite on the clamp."""
    b = shaft()
    turn(b, 0.2)
    found = fm.equilibrium(b.build())
    for ask in (found.reaction, found.force_needed):
        # Round-off.
        np.testing.assert_allclose(ask("B"), [0, 0, 0, MOMENT, 0, 0], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(ask("B.rotation", "rx"), MOMENT, rtol=1e-9)
    np.testing.assert_allclose(found.reaction("A", "rx"), -MOMENT, rtol=1e-9)


@pytest.mark.slow
def test_the_moment_that_turns_a_shaft_in_other_results():
    """Of a linearisation, a path and a stroke; GI_t times the angle over the length of a beam that is exact."""
    exact = shaft(spatial.spectral_beam(2))
    turned_by_name(exact, 0.2)
    assert fm.equilibrium(exact.build()).reaction("B", "rx") == approx(1.6, rel=1e-9)
    b = shaft()
    turned_by_axis(b, 0.2, increment=True)
    model = b.build()
    path, strokes = fm.path(model), fm.equilibria(model, increment=[0.5, 1.0])
    for found in (fm.linearize(model, increment=1.0), path, strokes):
        for ask in (found.reaction, found.force_needed):
            np.testing.assert_allclose(np.ravel(ask("B", "rx"))[-1], MOMENT, rtol=1e-9)
    for text in ("reaction B.rx", "moment B.rx"):
        assert path.along(text).values[-1] == approx(MOMENT, rel=1e-9)


@pytest.mark.slow
def test_the_moment_that_turns_a_shaft_in_motion():
    """The acceleration of the law times the inertia, and the moment of the shaft."""
    b = shaft()
    b.prescribe("B", "rx")
    model = b.build()
    times = np.linspace(0, 0.5, 6)
    found = fm.simulate(model, times, motion={"B.rx": lambda t: 0.4 * t**2})
    angle = 0.4 * times**2
    expected = 2.0 * 0.8 + SHAFT.GIt * np.sin(angle) * np.cos(angle)
    np.testing.assert_allclose(found.rotation("B", "rx"), angle, atol=1e-12)
    for moment in (found.reaction("B", "rx"), found.force_needed("B", "rx")):
        np.testing.assert_allclose(moment, expected, rtol=1e-9)


@pytest.mark.slow
def test_what_is_turned_is_moved_by_an_input_of_its_axis():
    """The moment of a drive by the acceleration that it gives: inertia, and stiffness over the square of s."""
    for name, prescribed in (("rx", {}), ("rotation", {"axis": (1, 0, 0)})):
        b = shaft()
        b.prescribe("B", name, **prescribed)
        b.input("B", "rx", "acceleration")
        b.output("B", "rx", "reaction")
        response = fm.to_statespace(fm.linearize(b.build()))(3j)
        np.testing.assert_allclose(response, 2.0 - SHAFT.GIt / 9.0, rtol=1e-9)
        refused = shaft()
        refused.prescribe("B", name, **prescribed)
        refused.input("B", "rx")
        if name == "rx":
            with pytest.raises(fm.ModelError, match="acts on a rotation that is prescribed, so it has no effect"):
                refused.build()


@pytest.mark.slow
def test_a_prescribed_rotation_leaves_the_other_two():
    """Frequencies are those of the mechanism projected onto motions that do not turn the node about the axis."""
    frequencies = {}
    for tilt in (None, "free", "fixed"):
        b = shaft()
        b.prescribe("B", "rotation", 0.0, axis=(0, 0, 1), tilt=tilt)
        frequencies[tilt] = np.asarray(fm.frequencies(b.build()))
    lin = fm.linearize(shaft().build())
    names = [str(entry) for entry in lin.labels.x]
    kept = scipy.linalg.null_space(np.asarray(lin.DFx)[[names.index("B.rotation.l3")]])
    k, m = (kept.T @ np.asarray(matrix) @ kept for matrix in (lin.K, lin.M0))
    expected = np.sqrt(scipy.linalg.eigh(k, m, eigvals_only=True)) / (2 * np.pi)
    # Round-off by the ratio of the stiffnesses, 1e6.
    np.testing.assert_allclose(frequencies[None], expected, rtol=1e-9)
    np.testing.assert_allclose(frequencies["free"], expected, rtol=1e-9)
    assert len(frequencies["fixed"]) == len(expected) - 2


@pytest.mark.slow
def test_a_rotation_is_held_about_global_axes():
    """A cantilever whose tip may not turn about z: 12 EI/L^3 along y and 3 EI/L^3 along z."""
    b = shaft()
    b.fix("B", "rz")
    compliance = np.diag(np.asarray(fm.compliance(b.build(), "B")))
    np.testing.assert_allclose(1 / compliance[1:3], [12 * SHAFT.EIz, 3 * SHAFT.EIy], rtol=1e-9)
    assert compliance[5] == approx(0, abs=1e-15)
    # The moment that holds it, half of the force times the length.
    b.force("B", (0, 1e-6, 0))
    np.testing.assert_allclose(fm.equilibrium(b.build()).reaction("B")[3:], [0, 0, -0.5e-6], atol=1e-15)
    # About all axes it is held as a whole, whether at once or one after the other.
    for calls in (("rx", "ry", "rz"),), (("rx",), ("ry",), ("rz",)), (("rz",), ("rotation",)), (("rotation",), ("rx",)):
        b = shaft()
        for components in calls:
            b.fix("B", *components)
        model = b.build()
        assert model.labels.coordinates("B.rotation")[0] in np.asarray(model.topology.x.fixed), calls
    b = shaft()
    b.fix("B", "rx")
    with pytest.raises(fm.ModelError, match=r"The rotation 'B\.rx' is fixed already and cannot be prescribed too"):
        b.prescribe("B", "rx", 0.1)
    with pytest.raises(fm.ModelError, match=r"'B\.rx': only component \"rotation\" takes an axis"):
        b.prescribe("B", "rx", 0.1, axis=(1, 0, 0))


@pytest.mark.slow
def test_an_angle_about_a_global_axis_is_a_degree_of_freedom():
    """A body on a shaft that is turned and let go, or pushed by a moment, moves as one degree of freedom."""
    b = fm.Builder()
    b.node("B", (0, 0, 0))
    b.rotation("ground")
    b.fix("ground")
    b.add(spatial.hinge, "ground", "B.rotation", axis=(1, 0, 0), stiffness=8.0, released=(1,))
    b.fix("B", "position")
    b.inertia("B", (2.0, 0, 0, 3.0, 0, 4.0))
    b.start("B", "rx", 0.1)
    model = b.build()
    assert model.q_labels == ["turn of B.rx.e1"]
    assert b.build(dofs=["B.rx"]).q_labels == model.q_labels
    assert shaft().build(dofs=(found := shaft().build(dofs=LABELS)).q_labels).q_labels == found.q_labels
    times, rate = np.linspace(0, 2.0, 5), 2.0
    found = fm.simulate(model, times, rtol=1e-8)
    # Ten times the tolerance, over tens of steps.
    np.testing.assert_allclose(found.rotation("B", "rx"), 0.1 * np.cos(rate * times), atol=1e-6)
    pushed = fm.simulate(model, times, loads={"B.rx": lambda t: 0.4}, rtol=1e-8)
    still = 0.4 / 8.0
    np.testing.assert_allclose(pushed.rotation("B", "rx"), still + (0.1 - still) * np.cos(rate * times), atol=1e-6)


def crank(*calls) -> fm.Builder:
    """A bar of 1 m along y, which may turn about x alone."""
    b = fm.Builder()
    b.node("A", (0, 0, 0))
    b.node("B", (0, 1.0, 0))
    b.add(spatial.rigid_beam, "A", "B", name="bar")
    for call, *given in calls:
        getattr(b, call)("A", *given)
    b.mass("B", 1.0)
    return b


ABOUT_X = {
    "released": (("fix",), ("release", "rx")),
    "fixed": (("fix", "position"), ("fix", "ry"), ("fix", "rz")),
    "prescribed": (("fix", "position"), ("prescribe", "rx", 4.0), ("fix", "ry", "rz")),
}


@pytest.mark.parametrize("how", ABOUT_X)
def test_what_may_turn_about_one_axis_turns_as_far_as_it_likes(how):
    """Beyond half a turn too, where its angles about both other axes are not determined."""
    b = crank(*ABOUT_X[how])
    model = b.build()
    if how == "prescribed":
        b.force("B", (1.0, 0, 0))
        state = fm.equilibrium(b.build())
        moment = -np.cross(state.position("B"), (1.0, 0, 0))
        np.testing.assert_allclose(state.reaction("A")[3:], moment, atol=1e-9)
    else:
        assert model.q_labels == ["turn of A.rx.e1"]
        state = fm.configuration(model, [4.0])
    # Newton's method ends at 1e-10.
    np.testing.assert_allclose(state.position("B"), [0, np.cos(4.0), np.sin(4.0)], atol=1e-9)


def test_a_support_about_one_axis_is_released_about_another():
    """Releases act one after the other, in any order; a proposal names the support, whose release builds."""
    b = crank(*ABOUT_X["released"])
    b.release("A", "ry")
    assert b.build().topology.n_q == 2
    b.fix("A", "ry")
    assert b.build().q_labels == ["turn of A.rx.e1"]
    b.fix("B", "x")
    found = fm.mobility(b.build(check=False))
    assert {one[:2] for one in found.candidates[0]} == {("A", "rz"), ("A", "x"), ("B", "x")}
    released = b.build(release="auto")
    assert released.topology.n_q == 1
    np.testing.assert_allclose(
        fm.configuration(released, [4.0]).position("B"), [0, np.cos(4.0), np.sin(4.0)], atol=1e-9
    )


def test_moments_on_what_is_held_about_two_axes_are_refused():
    b = crank(*ABOUT_X["fixed"])
    with pytest.raises(fm.ModelError, match=r"Load 'A\.rz' acts on a FIXED coordinate or deformation"):
        fm.simulate(b.build(), [0.0, 0.1], loads={"A.rz": jnp.cos})
    b.input("A", "rz")
    with pytest.raises(fm.ModelError, match=r"acts on a rotation that is fixed, so it has no effect"):
        b.build()


@pytest.mark.slow
def test_a_support_that_an_input_turns_is_held_by_angles():
    """The ground turns about z: its acceleration pushes the bar along x by the reaction of its mass."""
    b = crank(*ABOUT_X["fixed"])
    b.input("A", "rz", "acceleration")
    b.output("A", "rz", "reaction")
    model = b.build()
    response = fm.to_statespace(fm.linearize(model))(3j)
    np.testing.assert_allclose(response, 1.0, rtol=1e-9)
