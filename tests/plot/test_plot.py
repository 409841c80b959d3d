"""What pictures show, by the numbers in them: coordinates, colours, labels, titles."""

import dataclasses
import itertools
from types import SimpleNamespace

import control
import matplotlib as mpl
import numpy as np
import pytest
from cases.commands import command
from cases.mechanisms import LENGTH, cart_on_rod, leaf, planar_guide, spatial_guide
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, plot, spatial
from flexmb.answers.answers import Answer
from flexmb.elements.nodes import Angle, Point2, Point3
from flexmb.mechanisms import mechanism_path
from flexmb.plot.answer import image
from flexmb.plot.geometry import lines
from flexmb.plot.modes import factor_of
from flexmb.plot.sections import across_of, shapes_of, strips

mpl.use("Agg")
import matplotlib.pyplot as plt


@pytest.fixture(autouse=True)
def _figures_are_closed():
    yield
    plt.close("all")


def at_two_states(model):
    return np.zeros((2, model.topology.n_x))


def undeformed(model):
    return {line.element: line for line in lines(model, np.asarray(model.parameters.reference))}


def at(model, state):
    return {line.element: line for line in lines(model, np.asarray(state.x))}


def collection(ax, label):
    return next(c for c in ax.collections if c.get_label() == label)


def labels_of(ax):
    return {artist.get_label() for artist in (*ax.collections, *ax.lines) if not artist.get_label().startswith("_")}


def texts_of(ax):
    return {text.get_text().strip() for text in ax.texts if text.get_text()}


def cantilever(element, *, force=(0.0, 0.0), moment=0.0):
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (LENGTH, 0))
    b.add(element, "foot", "tip", name="leaf", section=leaf())
    b.fix("foot")
    if np.any(force):
        b.force("tip", force)
    if moment:
        b.moment("tip", moment)
    return b.build()


@pytest.fixture(scope="module")
def guide():
    return planar_guide(force=(0, -1.0)).build()


@pytest.fixture(scope="module")
def rolled():
    """A leaf spring bent to a quarter of a circle by a moment, one spectral beam."""
    model = cantilever(planar.spectral_beam(4), moment=leaf().rigidity().EIy * np.pi / 2 / LENGTH)
    return model, fm.equilibrium(model)


# Lines.


@pytest.mark.slow
def test_beam_is_the_cubic_of_a_cantilever_with_a_force_at_its_tip():
    model = cantilever(planar.beam, force=(0, 1e-4))
    points = at(model, fm.equilibrium(model))["leaf"].points
    # w = F x^2 (3 L - x)/(6 EI); nonlinear terms are of the order of the squared slope, 1e-9.
    s = np.linspace(0, LENGTH, len(points))
    exact = 1e-4 * s**2 * (3 * LENGTH - s) / (6 * leaf().rigidity().EIy)
    np.testing.assert_allclose(points[:, 1], exact, atol=1e-7 * exact[-1])


@pytest.mark.slow
def test_spatial_beam_is_the_same_cubic():
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (0, LENGTH, 0))
    b.add(spatial.beam, "foot", "tip", name="leaf", section=leaf(), y=(1, 0, 0))
    b.fix("foot")
    b.force("tip", (0, 0, 1e-4))
    model = b.build()
    points = at(model, fm.equilibrium(model))["leaf"].points
    s = np.linspace(0, LENGTH, len(points))
    exact = 1e-4 * s**2 * (3 * LENGTH - s) / (6 * leaf().rigidity().EIy)
    np.testing.assert_allclose(points[:, 2], exact, atol=1e-7 * exact[-1])


@pytest.mark.slow
def test_spectral_beam_is_an_arc_under_a_moment(rolled):
    model, found = rolled
    points = at(model, found)["leaf"].points
    # A quarter of a circle with its centre above the foot.
    radius = LENGTH / (np.pi / 2)
    np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1] - radius), radius, rtol=1e-9)
    np.testing.assert_allclose(points[-1], [radius, radius], rtol=1e-8)


@pytest.mark.slow
def test_spatial_spectral_beam_ends_at_its_nodes():
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (0, 0, LENGTH))
    b.add(spatial.spectral_beam(2), "foot", "tip", name="leaf", section=leaf(), y=(1, 0, 0), curvature=(0, 0, 4.0))
    b.fix("foot")
    b.force("tip", (0.01, 0.2, 0))
    model = b.build()
    found = fm.equilibrium(model)
    points = at(model, found)["leaf"].points
    np.testing.assert_allclose(points[[0, -1]], [[0, 0, 0], found.at("tip")], atol=1e-12)
    # Undeformed it is the arc of its initial curvature.
    arc = undeformed(model)["leaf"].points
    chord = LENGTH / 2
    sagitta = 1 / 4.0 - np.sqrt(1 / 4.0**2 - chord**2)
    assert np.max(np.linalg.norm(arc[:, :2], axis=1)) == approx(sagitta, rel=1e-6)


@pytest.mark.slow
def test_the_width_of_a_twisted_strip_turns_along_it():
    """By 40 degrees before any load; the section's local y at the first end is the given vector."""
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (LENGTH, 0, 0))
    turn = np.radians(40)
    twisted = fm.sections.curvature_along(lambda s: (turn / LENGTH, 0.0, 0.0))
    b.add(spatial.spectral_beam(2), "foot", "tip", name="leaf", section=leaf(), y=(0, 1, 0), curvature=twisted)
    b.fix("foot")
    model = b.build()
    drawn = lines(model, np.asarray(model.parameters.reference))
    across = across_of(model, np.asarray(model.parameters.reference), drawn, shapes_of(model))["leaf"]
    angles = np.linspace(0, turn, len(across))
    expected = np.stack([np.zeros(len(across)), np.cos(angles), np.sin(angles)], axis=1)
    np.testing.assert_allclose(across, expected, atol=1e-9)


def test_kinds_of_elements_come_from_nodes_and_companions():
    def law(e, ed, *, k):
        return k * e

    b = fm.Builder()
    for name, place in {"a": (0, 0), "b": (1, 0), "c": (1, 1), "d": (2, 0)}.items():
        b.node(name, place)
    b.rotation("free")
    b.add(planar.beam, "a", "b", name="flexible", section=leaf())
    b.add(planar.beam, "b", "c", name="stiff")
    b.add(planar.truss, "a", "c", name="truss", section=fm.Rigidity(EA=1.0))
    b.add(planar.spring_damper(law), "c", "d", name="spring", k=1.0)
    b.add(planar.hinge, "b.rotation", "free", name="pivot")
    b.add(planar.rigid_beam, "b", "free", "d", name="arm")
    b.add(planar.slider, "b", "d", name="slide", axis=(1, 0))
    found = undeformed(b.build(check=False))
    kinds = {name: line.kind for name, line in found.items()}
    assert kinds == {
        "flexible": "beam",
        "stiff": "rigid",
        "truss": "bar",
        "spring": "spring",
        "pivot": "hinge",
        "arm": "rigid",
        "slide": "joint",
    }
    np.testing.assert_allclose(found["pivot"].points, [[1, 0]])
    np.testing.assert_allclose(found["spring"].points[[0, -1]], [[1, 1], [2, 0]])


def test_an_element_of_ones_own_draws_by_its_points_and_rotations():
    def hook(p: Point2, a: Angle, q: Point2, b: Angle, *, ref):
        return (q - ref.q) - (p - ref.p)

    def tripod(p: Point3, q: Point3, r: Point3, *, ref):
        return (p - ref.p) + (q - ref.q) + (r - ref.r)

    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (1, 0))
    b.add(hook, "A", "B", name="hook")
    model = b.build(check=False)
    x = np.asarray(model.parameters.reference).copy()
    x[model.labels.known("A.rotation")] = 0.3
    (line,) = lines(model, x)
    start = line.points[1] - line.points[0]
    assert np.arctan2(start[1], start[0]) == approx(0.3, abs=0.01)
    b = fm.Builder()
    corners = [(0, 0, 0), (1, 0, 0), (1, 2, 0)]
    for name, place in zip("pqr", corners, strict=True):
        b.node(name, place)
    b.add(tripod, "p", "q", "r", name="tripod")
    points = undeformed(b.build(check=False))["tripod"].points
    np.testing.assert_allclose(points[[0, 48, 96]], corners, atol=1e-12)


def test_belt_goes_round_its_pulleys_and_gears_meet():
    b = fm.Builder()
    b.node("a", (0, 0))
    b.node("b", (1, 0))
    b.add(planar.belt, "a", "b", name="belt", radius_p=0.2, radius_q=0.4)
    b.add(planar.gear, "a", "b", name="gear", ratio=3.0)
    found = undeformed(b.build(check=False))
    belt = found["belt"].points
    np.testing.assert_allclose(np.linalg.norm(belt[:33], axis=1), 0.2, rtol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(belt[64:] - [1, 0], axis=1), 0.4, rtol=1e-9)
    along = belt[64] - belt[32]
    # A tangent stands upright on both radii.
    np.testing.assert_allclose([along @ belt[32], along @ (belt[64] - [1, 0])], 0, atol=1e-12)
    gear = found["gear"].points
    np.testing.assert_allclose(np.linalg.norm(gear[:48], axis=1), 0.25, rtol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(gear[48:] - [1, 0], axis=1), 0.75, rtol=1e-9)


# The mechanism.


def test_mechanism_shows_supports_dofs_loads_and_names(guide):
    ax = plot.mechanism(guide, names=True)
    assert labels_of(ax) >= {"beam", "rigid", "mass", "clamped", "dof left1.x", "force left1"}
    assert "undeformed" not in labels_of(ax)
    assert texts_of(ax) >= {"left0", "left1", "right1", "left 1", "bar", "left1.x", "1 N"}
    clamped = next(line for line in ax.lines if line.get_label() == "clamped")
    np.testing.assert_allclose(clamped.get_xydata(), [[0, 0], [0.1, 0]])
    arrow = collection(ax, "force left1")
    assert (float(arrow.U[0]), float(arrow.V[0])) == approx((0, -0.015))
    # Lengths count in what the extent suggests; what is drawn stays in metres.
    assert ax.get_xlabel() == "x [mm]"
    assert ax.xaxis.get_major_formatter()(0.1) == "100"
    without = plot.mechanism(guide, supports=False, dofs=False, loads=False)
    assert labels_of(without) == {"beam", "rigid", "mass", "section"}
    assert not texts_of(without)


def test_deformed_shape_over_a_ghost_with_a_factor(rolled):
    model, found = rolled
    ax = plot.mechanism(model, at=found, ax=plt.figure().add_subplot())
    ghost, beam = (collection(ax, label).get_segments()[0] for label in ("undeformed", "beam"))
    np.testing.assert_allclose(ghost[-1], [LENGTH, 0], atol=1e-12)
    np.testing.assert_allclose(beam[-1], found.at("tip"), atol=1e-12)
    halved, half_way = plot.mechanism(model, at=found, scale=0.5), (np.array([LENGTH, 0]) + found.at("tip")) / 2
    np.testing.assert_allclose(collection(halved, "beam").get_segments()[0][-1], half_way, atol=1e-12)
    # The moment is drawn at its node.
    turned = next(text for text in halved.texts if "N m" in text.get_text())
    np.testing.assert_allclose(turned.get_position(), half_way, atol=1e-12)
    assert "↺ 0.6185 N m" in texts_of(ax)


@pytest.mark.slow
def test_moment_in_space_is_an_arrow_along_its_axis():
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (LENGTH, 0, 0))
    b.add(spatial.beam, "foot", "tip", section=leaf())
    b.fix("foot")
    b.moment("tip", (0, 0.3, 0.4))
    ax = plot.mechanism(b.build())
    assert "0.5 N m" in texts_of(ax)
    shaft = np.asarray(collection(ax, "moment tip.rotation")._segments3d[0])
    # matplotlib keeps an arrow from its head to its tail.
    np.testing.assert_allclose(shaft[[-1, 0]], [[0.1, 0, 0], [0.1, 0.009, 0.012]], atol=1e-9)
    assert ax.name == "3d"


def test_ticks_of_a_small_mechanism_lie_beside_each_other():
    """A beam of 200 µm counts in µm, in space too."""
    for element, place in ((planar.beam, (2e-4, 5e-5)), (spatial.beam, (2e-4, 5e-5, 1e-4))):
        b = fm.Builder()
        b.node("foot", (0.0,) * len(place))
        b.node("tip", place)
        b.add(element, "foot", "tip", section=fm.Rectangle(2e-5, 2e-6, leaf().material))
        b.force("tip", (2e-6, *np.zeros(len(place) - 1)))
        ax = plot.mechanism(b.build(check=False))
        assert ax.get_xlabel() == "x [µm]"
        assert "2 µN" in texts_of(ax)
        ax.figure.draw_without_rendering()
        low, high = ax.get_xlim()
        boxes = [t.label1.get_window_extent() for t in ax.xaxis.majorTicks if low <= t.get_loc() <= high]
        assert 2 <= len(boxes) <= 8
        assert not any(a.overlaps(b) for a, b in itertools.combinations(boxes, 2))


# Results.


@pytest.mark.slow
def test_modes_have_their_frequency_in_the_title(guide):
    found = fm.modes(guide)
    figure = plot.modes(found, amplitude=0.2)
    (ax,) = figure.axes
    assert ax.get_title() == f"mode 1: {float(found.frequencies[0]):.5g} Hz"
    moved = np.concatenate([s for label in ("beam", "rigid") for s in collection(ax, label).get_segments()])
    still = np.concatenate(collection(ax, "undeformed").get_segments())
    # The stage sways by the amplitude times the extent; both leaf springs are cubics with their middle at half of it.
    assert np.max(np.abs(moved[:, 0] - still[:, 0])) == approx(0.2 * LENGTH, rel=1e-3)
    leaf_spring = collection(ax, "beam").get_segments()[0]
    assert abs(leaf_spring[48, 0]) == approx(0.1 * LENGTH, rel=1e-3)


@pytest.mark.slow
def test_buckling_and_unstable_modes_say_so(guide):
    assert plot.modes(fm.buckling(guide)).axes[0].get_title() == "buckling mode 1: λ = 78.75"
    pressed = planar_guide(force=(0, -100.0)).build()
    assert plot.modes(fm.modes(pressed)).axes[0].get_title().startswith("mode 1: unstable, ω² = -")


@pytest.fixture(scope="module", params=[planar.spectral_beam(4), spatial.spectral_beam(2)], ids=["plane", "space"])
def tailed(request):
    """A leaf spring, one spectral beam, with a rigid tail, pushed; and its modes."""
    space = len(request.param.nodes["p"].start) == 3
    b = fm.Builder()
    for i, name in enumerate(("foot", "tip", "end")):
        b.node(name, (i * LENGTH, 0, 0) if space else (i * LENGTH, 0))
    axes = {"y": (0, 1, 0)} if space else {}
    b.add(request.param, "foot", "tip", name="leaf", section=leaf(), **axes)
    b.add(spatial.beam if space else planar.beam, "tip", "end", name="tail", **axes)
    b.fix("foot")
    b.mass("end", 0.01)
    b.force("end", (-0.1, 0, 0.1) if space else (-0.1, 0.1))
    return fm.modes(b.build())


def ends_of(ax, label):
    """First and last point of the one line of a kind."""
    found = collection(ax, label)
    (points,) = found._segments3d if ax.name == "3d" else found.get_segments()
    return np.asarray(points)[[0, -1]]


@pytest.mark.slow
@pytest.mark.parametrize("amplitude", [plot.modes.__kwdefaults__["amplitude"], 0.5])
def test_spectral_beams_stay_on_their_bodies_in_a_mode(tailed, amplitude):
    """Displacements are as many times those of the mode at the end of a beam as at its node."""
    lin, shapes = tailed.lin, np.asarray(tailed.shapes)
    nodes = [lin.labels.known(name) for name in ("foot", "tip", "end")]
    for mode, ax in enumerate(plot.modes(tailed, amplitude=amplitude).axes):
        x = np.asarray(lin.x) + factor_of(lin.model, np.asarray(lin.x), shapes[:, mode], amplitude) * shapes[:, mode]
        foot, tip, end = (x[index] for index in nodes)
        # The difference that the displacements are taken by is 1e-6 of a coordinate.
        np.testing.assert_allclose(ends_of(ax, "beam"), [foot, tip], atol=1e-6 * LENGTH)
        np.testing.assert_allclose(ends_of(ax, "rigid"), [tip, end], atol=1e-6 * LENGTH)


@pytest.mark.slow
def test_a_mode_moves_every_point_in_proportion(tailed):
    small, large = (plot.modes(tailed, which=3, amplitude=share).axes[0] for share in (0.1, 0.4))
    still, little, much = (
        np.asarray(own._segments3d[0] if ax.name == "3d" else own.get_segments()[0])
        for ax, own in (
            (ax, collection(ax, label)) for ax, label in ((small, "undeformed"), (small, "beam"), (large, "beam"))
        )
    )
    np.testing.assert_allclose(much - still, 4 * (little - still), atol=1e-6 * LENGTH)


@pytest.mark.slow
def test_a_mode_of_torsion_is_not_blown_up(tailed):
    """The axis of a beam that twists stays where it is: what turns limits the amplitude, to a radian at the default."""
    view = fm.view(tailed)
    for displacement, turn in zip(view.lines.states, view.lines.across_states, strict=True):
        moved, turned = (view.amplitude * np.max(np.linalg.norm(of, axis=1), initial=0) for of in (displacement, turn))
        # By one-sided differences of 1e-6, and not too little either.
        assert moved <= view.amplitude * 2 * LENGTH * (1 + 1e-4)
        assert turned <= 1 + 1e-4
        assert moved > 0.999 * view.amplitude * 2 * LENGTH or turned > 0.999


@pytest.mark.slow
def test_spectral_beams_stay_on_their_bodies_in_a_scaled_state(tailed):
    lin = tailed.lin
    model, reference = lin.model, np.asarray(lin.model.parameters.reference)
    x = reference + 5 * (np.asarray(lin.x) - reference)
    foot, tip, end = (x[lin.labels.known(name)] for name in ("foot", "tip", "end"))
    for ax in (plot.mechanism(lin, scale=5.0), plot.stress(fm.stress(model, at=lin), lin, scale=5.0)):
        np.testing.assert_allclose(ends_of(ax, "rigid"), [tip, end], atol=1e-9 * LENGTH)
    np.testing.assert_allclose(ends_of(plot.mechanism(lin, scale=5.0), "beam"), [foot, tip], atol=1e-9 * LENGTH)
    if ax.name == "3d":
        # Its width, in colours of the same scale, ends where the tip has gone.
        drawn = collection(ax, "section")
        assert drawn.get_clim() == collection(ax, "von Mises stress [MPa]").get_clim()
        last = np.asarray(drawn._faces)[-1]
        np.testing.assert_allclose(np.mean(last[[1, 2]], axis=0), tip, atol=1e-6 * LENGTH)
    coloured = collection(ax, "von Mises stress [MPa]")
    pieces = np.asarray(coloured._segments3d if ax.name == "3d" else coloured.get_segments())
    np.testing.assert_allclose([pieces[0, 0], pieces[-1, -1]], [foot, tip], atol=1e-9 * LENGTH)


def test_stress_has_the_colours_of_a_cantilever():
    model = cantilever(planar.beam, force=(0, 0.01))
    lin = fm.linearize(model)
    ax = plot.stress(fm.stress(model, at=lin), lin)
    drawn = collection(ax, "von Mises stress [MPa]")
    clamp = 6 * 0.01 * LENGTH / (0.018 * 0.0005**2) / 1e6
    assert drawn.get_clim() == approx((0, clamp), rel=1e-4)
    # Linear along the leaf spring, from its clamp to nothing at the tip.
    colours = np.asarray(drawn.get_array())
    # Shear of 3 F/(2 A) adds to it at the tip, 0.003 MPa.
    np.testing.assert_allclose(colours, clamp * (1 - (np.arange(96) + 0.5) / 96), atol=3e-3)
    assert ax.figure.axes[1].get_ylabel() == "von Mises stress [MPa]"
    # The largest is marked at the clamp, with its value and its place.
    ring = next(line for line in ax.lines if line.get_label() == "largest")
    np.testing.assert_allclose(ring.get_xydata(), [[0, 0]], atol=1e-12)
    assert texts_of(ax) == {f"{clamp:.4g} MPa, 'leaf' at foot"}
    signed = plot.stress(fm.linear.section_resultants(model, at=lin), lin)
    drawn = collection(signed, "bending moment y [N m]")
    assert drawn.get_clim() == approx((-1e-3, 1e-3), rel=1e-4)
    drawn = collection(plot.stress(fm.stress(model, at=lin), lin, "shear force z"), "shear force z [N]")
    np.testing.assert_allclose(np.abs(np.asarray(drawn.get_array())), 0.01, rtol=1e-3)


def test_self_stress_colours_who_takes_part_and_says_what_to_release():
    found = fm.mobility(spatial_guide().build(check=False))
    ax = plot.self_stress(found)
    assert found.release[0] is not None
    element, number = found.release[0]
    assert ax.get_title() == f"self-stress 1 of 1: release e{number} of '{element}' to remove it"
    drawn = collection(ax, "self-stress")
    part = {s.of: 0.0 for s in found.stresses()}
    for share in found.stresses():
        part[share.of] = max(part[share.of], abs(share.share))
    assert drawn.get_clim() == (0, 1)
    np.testing.assert_allclose(np.sort(np.asarray(drawn.get_array())), np.sort(list(part.values())))
    # Of shares that only round-off tells apart the first is 1.
    assert any(text.startswith("left 1: e5 1") for text in texts_of(ax))


def test_labels_of_many_self_stresses_lie_beside_each_other():
    """Four leaf springs that carry one body are over-constrained six times, and seven elements take part in each."""
    b = fm.Builder()
    for i, (x, y) in enumerate([(0.05, 0), (0, 0.05), (-0.05, 0), (0, -0.05)]):
        b.node(f"foot{i}", (x, y, 0))
        b.node(f"top{i}", (x, y, LENGTH))
        b.add(spatial.beam, f"foot{i}", f"top{i}", name=f"leaf {i}", section=leaf(), released=(2, 3, 4), y=(-y, x, 0))
        b.fix(f"foot{i}")
        if i:
            b.add(spatial.beam, "top0", f"top{i}", name=f"arm {i}")
    ax = plot.self_stress(fm.mobility(b.build(check=False)))
    assert len(ax.texts) == 7
    bar = ax.figure.axes[1].get_tightbbox()
    # Where a text in space is on paper is known while it is drawn.
    boxes = {}
    for text in ax.texts:
        text.get_bbox_patch().draw = lambda _, text=text: boxes.update({text: text.get_window_extent()})
    ax.figure.draw_without_rendering()
    assert len(boxes) == 7
    assert not any(a.overlaps(b) for a, b in itertools.combinations([*boxes.values(), bar], 2))


@pytest.fixture(scope="module")
def snapping():
    """A shallow truss pressed through: stable, unstable, stable."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("top", (1, 0.2))
    b.add(planar.truss, "foot", "top", section=fm.Rigidity(EA=1000.0))
    b.fix("foot")
    b.fix("top", "x")
    b.mass("top", 1.0)
    b.force("top", (0, -5.0))
    return fm.path(b.build())


@pytest.mark.slow
def test_path_is_dashed_where_it_is_unstable(snapping):
    ax = plot.path(snapping)
    stable, unstable = (next(x for x in ax.lines if x.get_label() == name) for name in ("stable", "unstable"))
    assert (stable.get_linestyle(), unstable.get_linestyle()) == ("-", "--")
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("top.y [mm]", "load factor [-]")
    limits = np.array([[p.x[3], p.load_factor] for p in snapping.critical_points if p.kind == "limit"])
    drawn = next(x for x in ax.lines if x.get_label() == "limit point").get_xydata()
    np.testing.assert_allclose(drawn, limits)
    # The unstable part goes from one limit point to the other and nowhere beyond.
    heights = unstable.get_xdata()[np.isfinite(unstable.get_xdata())]
    np.testing.assert_allclose([heights.max(), heights.min()], np.sort(limits[:, 0])[::-1], rtol=1e-12)
    shown = labels_of(plot.mechanism(snapping, step=0))
    assert "supported" in shown
    assert "clamped" not in shown
    along = plot.frequencies(snapping, "top.y")
    assert along.get_legend().get_title().get_text() == ""
    np.testing.assert_allclose(along.lines[0].get_ydata(), snapping.frequencies[:, 0])
    assert np.min(along.lines[0].get_ydata()) < 0
    # Of many the lowest, and said so: a legend of all of them would leave no room for the curves.
    many = dataclasses.replace(snapping, eigenvalues=snapping.eigenvalues + np.arange(30) ** 2 * 1e3)
    few = plot.frequencies(many)
    assert len(few.lines) == 6
    np.testing.assert_allclose(few.lines[5].get_ydata(), many.frequencies[:, 5])
    assert few.get_legend().get_title().get_text() == "and 24 higher"
    assert len(plot.frequencies(many, count=30).lines) == 30


@pytest.fixture(scope="module")
def swinging():
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("cart", (1, 0))
    b.add(planar.truss, "wall", "cart", section=fm.Rigidity(EA=100.0))
    b.fix("wall")
    b.fix("cart", "y")
    b.mass("cart", 4.0)
    b.start("cart", "x", 0.01)
    return fm.simulate(b.build(), np.linspace(0, 1, 11), rtol=1e-8)


@pytest.mark.slow
def test_time_history_energies_and_frequency_of_a_motion(swinging):
    ax = plot.history(swinging, "cart.x")
    # 100 N/m and 4 kg: 5 rad/s.
    np.testing.assert_allclose(ax.lines[0].get_ydata(), 1 + 0.01 * np.cos(5 * np.linspace(0, 1, 11)), atol=1e-7)
    assert (ax.lines[0].get_label(), ax.get_xlabel(), ax.get_ylabel()) == ("cart.x", "time [s]", "coordinate [m]")
    ax = plot.history(swinging, velocity=True)
    assert ax.lines[0].get_label() == "d/dt cart.x [m/s]"
    np.testing.assert_allclose(ax.lines[0].get_ydata(), -0.05 * np.sin(5 * np.linspace(0, 1, 11)), atol=1e-6)
    energies = {line.get_label(): line.get_ydata() for line in plot.history(swinging, ["kinetic", "energy"]).lines}
    np.testing.assert_allclose(energies["energy"], 0.005, rtol=1e-5)
    hertz = plot.frequencies(swinging).lines[0].get_ydata()
    np.testing.assert_allclose(hertz, 5 / (2 * np.pi), rtol=1e-6)
    beam = collection(plot.mechanism(swinging, time=0.5), "bar").get_segments()[0]
    assert beam[-1, 0] == approx(1 + 0.01 * np.cos(2.5), abs=1e-7)


@pytest.mark.slow
def test_any_two_quantities_of_a_path_or_a_motion(snapping, swinging):
    ax = plot.path(snapping, x="displacement top.y", y="force top.y")
    assert ax.get_xlabel() == "displacement top.y [mm]"
    assert ax.get_ylabel() == "force top.y [N]"
    labels = [line.get_label() for line in ax.lines]
    assert "slope at the start" in labels
    # The limit points are the extremes of the force, and lie where the load factor has them.
    limits = ax.lines[labels.index("limit point")].get_ydata()
    applied = float(snapping.force_needed("top", "y")[-1])
    np.testing.assert_allclose(limits, applied * np.array([p.load_factor for p in snapping.critical_points]), rtol=1e-9)
    # EA (h / l)^2 / l at rest, by a polynomial through four steps of a tenth of the way to the limit.
    slope = ax.lines[labels.index("slope at the start")]
    rise = np.diff(slope.get_ydata()) / np.diff(slope.get_xdata())
    assert 1e3 * float(rise[0]) == approx(1000 * 0.2**2 / 1.04**1.5, rel=0.02)
    ax = plot.history(swinging, x="displacement cart.x", y="acceleration cart.x")
    # 100 N/m and 4 kg; ten times the tolerance of the integration.
    x, y = (np.asarray(v) for v in ax.lines[0].get_data())
    np.testing.assert_allclose(y, -25.0 * x, atol=1e-3)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("displacement cart.x [mm]", "acceleration cart.x [mm/s²]")
    drawn = plot.history(swinging, ["reaction wall.x", "force cart.x"])
    assert drawn.get_ylabel() == "reaction and force [N]"
    np.testing.assert_allclose(drawn.lines[0].get_ydata(), -0.1 * x, atol=1e-12)
    with pytest.raises(ValueError, match="draw two pictures"):
        plot.history(swinging, ["reaction wall.x", "frequency 1"])
    with pytest.raises(ValueError, match="give only `x`"):
        plot.path(snapping, "top.x", x="top.y")


def test_bode_plot_has_its_resonance_and_only_outputs_that_respond():
    model = planar_guide(ratio=0.005).build()
    figure = plot.bode(model)
    magnitudes = [ax for ax in figure.axes if ax.get_yscale() == "log"]
    # Only the sways of both ends respond to first order.
    assert len(magnitudes) == 2
    hertz, size = (np.asarray(values) for values in magnitudes[0].lines[0].get_data())
    assert hertz[np.argmax(size)] == approx(float(fm.frequencies(fm.linearize(model))[0]), rel=1e-3)
    assert size[0] == approx(1 / 945, rel=0.02)
    assert [ax.get_title() for ax in magnitudes] == [
        f"force right1 x → position {end} x" for end in ("left1", "right1")
    ]
    # What has no panel is told.
    assert "no response: position left1 y, position right1 y" in figure.get_supxlabel()


def test_bode_plot_of_several_inputs_says_what_does_not_respond():
    """1/s^3 begins at +90 degrees (-270); 1/(s (s^2 + 1)), without damping, turns from -90 to -270 at 1 rad/s."""
    system = control.append(*(control.tf2ss(control.tf(*of)) for of in (([1], [1, 0, 0, 0]), ([1], [1, 0, 1, 0]))))
    system = control.ss(system, inputs=["force", "moment"], outputs=["position", "angle"])
    figure = plot.bode(system, hertz=np.logspace(-2, 1, 61))
    assert len(figure.axes) == 6
    assert [ax.get_title() for ax in figure.axes if ax.get_title()] == ["force → position", "moment → angle"]
    said = {text.replace("\n", " ") for ax in figure.axes for text in texts_of(ax)}
    assert said == {"position does not respond to moment", "angle does not respond to force"}
    phases = [np.asarray(ax.lines[0].get_ydata()) for ax in figure.axes if ax.get_ylabel().startswith("phase")]
    np.testing.assert_allclose(phases[0], 90, atol=1e-3)
    np.testing.assert_allclose(phases[1][[0, -1]], [-90, -270], atol=1e-3)


def test_bode_plot_of_many_poles_agrees_with_python_control(monkeypatch):
    """Sixty oscillators from 1 to 1e5 rad/s in a row of sums: poles of every size, mixed by a random basis."""
    rng = np.random.default_rng(1)
    omega, n = np.logspace(0, 5, 60), 120
    a = np.zeros((n, n))
    a[:60, 60:], a[60:, :60], a[60:, 60:] = np.eye(60), -np.diag(omega**2), -np.diag(0.02 * omega)
    basis = np.kron(np.eye(2), np.linalg.qr(rng.standard_normal((60, 60)))[0])
    b, c = np.zeros((n, 1)), np.zeros((1, n))
    b[60:, 0], c[0, :60] = 1.0, 1.0
    system = control.ss(basis @ a @ basis.T, basis @ b, c @ basis.T, 0.0)
    hertz = np.logspace(-1, 4, 31)
    # The oscillators by themselves: sum of 1/(w_k^2 - w^2 + 0.02 i w_k w).
    w = 2 * np.pi * hertz[:, None]
    exact = np.abs(np.sum(1 / (omega**2 - w**2 + 0.02j * omega * w), axis=1))
    np.testing.assert_allclose(np.abs(system(1j * w[:, 0])), exact, rtol=1e-4)  # round-off of the mixed matrix
    # Many dense solutions, one for each frequency, take a minute for a stage of 84 degrees of freedom.
    monkeypatch.setattr(control.StateSpace, "__call__", None)
    figure = plot.bode(system, hertz=hertz)
    drawn, size = (np.asarray(values) for values in figure.axes[0].lines[0].get_data())
    np.testing.assert_allclose(size[np.searchsorted(drawn, hertz)], exact, rtol=2e-4)  # DECAY over 0.01 of damping


# Refusals.


@pytest.mark.slow("<lambda>-ValueError-must be one of")
@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda m: plot.mechanism(3), TypeError, "not a int"),
        (lambda m: plot.mechanism(m, at=3), TypeError, "state of the model"),
        (lambda m: plot.mechanism(m, at=fm.configuration(cart_on_rod(1.0, 1.0).build())), ValueError, "another model"),
        (lambda m: plot.mechanism(m, at=SimpleNamespace(x=at_two_states(m))), ValueError, r"but its x has shape \(2,"),
        (lambda m: plot.mechanism(m, step=1), ValueError, "needs a Path"),
        (lambda m: plot.mechanism(m, time=1.0), ValueError, "needs a Motion"),
        (lambda m: plot.mechanism(m, scale=np.nan), ValueError, "finite"),
        (lambda m: plot.mechanism(m, ax=plt.figure().add_subplot(projection="3d")), ValueError, "2 dimensions"),
        (lambda m: plot.modes(m), TypeError, "fm.modes"),
        (lambda m: plot.modes(fm.modes(m), 7), ValueError, "no mode 7"),
        (lambda m: plot.modes(fm.modes(m), amplitude=np.nan), ValueError, "`amplitude` must be finite"),
        (lambda m: plot.stress(m, m), TypeError, "fm.stress"),
        (lambda m: plot.stress(fm.linear.section_resultants(m), m, "von Mises"), ValueError, "must be one of"),
        (lambda m: plot.self_stress(fm.mobility(m)), ValueError, "there are 0"),
        (lambda m: plot.path(m), TypeError, "fm.path"),
        (lambda m: plot.history(m), TypeError, "fm.simulate"),
        (lambda m: plot.frequencies(m), TypeError, "Path or a Motion"),
        (lambda m: plot.bode(m, "nothing"), ValueError, "no output 'nothing'"),
        (lambda m: plot.bode(m, hertz=[0.0, 1.0]), ValueError, "frequencies above zero"),
        (lambda m: plot.bode(3), TypeError, "StateSpace"),
        (lambda m: plot.bode(control.ss(-1.0, 1.0, 1.0, 0.0, 0.1)), ValueError, "sampled every 0.1 s"),
    ],
)
def test_bad_calls(guide, call, kind, words):
    with pytest.raises(kind, match=words):
        call(guide)


@pytest.mark.slow
def test_coordinates_and_times_that_are_not_there(snapping, swinging):
    with pytest.raises(KeyError, match=r"no coordinate 'top\.z' in this model; there is top\.x, top\.y"):
        plot.path(snapping, "top.z")
    with pytest.raises(ValueError, match="must be from 0 to 1 s, but is 2"):
        plot.mechanism(swinging, time=2.0)
    with pytest.raises(ValueError, match="different units"):
        plot.history(swinging, ["cart.x", "energy"])
    with pytest.raises(ValueError, match="`velocity` is for coordinates, and 'kinetic' is an energy"):
        plot.history(swinging, "kinetic", velocity=True)
    with pytest.raises(ValueError, match="`count` must be at least 1"):
        plot.frequencies(swinging, count=-1)
    with pytest.raises(ValueError, match="below 11"):
        plot.mechanism(swinging, step=11)


# The command line.


@pytest.mark.slow("pf1dtrx-9-png-None")
@pytest.mark.parametrize(
    ("name", "mode", "suffix", "words"),
    [
        ("pf3dover", 0, "svg", "self-stress 1 of 1"),
        ("pf1dtrx", 7, "svg", "mode 1: 10.658 Hz"),
        ("pf1dtrx", 9, "png", None),
        ("pf1dtrx", 9, "svg", "magnitude"),
    ],
)
def test_plot_on_the_command_line(tmp_path, name, mode, suffix, words):
    target = tmp_path / f"picture.{suffix}"
    # Text stays text in the file, so that it can be read here.
    with mpl.rc_context({"svg.fonttype": "none"}):
        result = command("run", mechanism_path(name), "--mode", mode, "--plot", target)
    assert result.exit_code == 0, result.output
    content = target.read_bytes()
    assert words is None or words in content.decode()
    assert suffix == "svg" or content.startswith(b"\x89PNG")


@pytest.mark.slow
def test_path_and_motion_are_drawn_beside_where_they_end(snapping, swinging):
    for found, words in ((snapping, "load factor [-]"), (swinging, "time [s]")):
        answer = Answer({}, 0, found.model, found=found)
        with mpl.rc_context({"svg.fonttype": "none"}):
            text = image(answer, "svg").decode()
        assert words in text
        assert "x [" in text
        # The same answer gives the same file.
        with mpl.rc_context({"svg.fonttype": "none"}):
            assert image(answer, "svg").decode() == text


def test_demo_leaves_a_picture_and_says_where(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = command("demo", "pf1dtrx")
    assert result.exit_code == 0, result.output
    assert f"picture: {tmp_path / 'pf1dtrx.png'}" in result.stdout
    assert (tmp_path / "pf1dtrx.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
@pytest.mark.parametrize("target", ["picture.gif", "nowhere/picture.png"])
def test_plot_refuses_before_anything_is_computed(tmp_path, monkeypatch, target):
    monkeypatch.chdir(tmp_path)
    result = command("run", mechanism_path("pf1dtrx"), "--mode", 7, "--plot", target)
    assert result.exit_code == 2
    assert target in result.stderr
    assert result.stderr.count("\n") == 1


@pytest.mark.slow
def test_sections_are_drawn_as_wide_as_they_are():
    """In space the width along local y, turned with a tip that turns by 60 degrees; in the plane the thickness."""
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (LENGTH, 0, 0))
    b.add(spatial.beam, "foot", "tip", section=fm.Rectangle(0.02, 0.001, leaf().material), y=(0, 1, 0))
    b.fix("foot")
    b.force("tip", (0, 0, 1e-4))
    model = b.build()
    x = np.array(model.parameters.reference)
    x[model.labels.known("tip.rotation")] = np.cos(np.pi / 6), np.sin(np.pi / 6), 0, 0
    ax = plot.mechanism(model, at=fm.equilibrium(model), dofs=False)
    (quads,) = strips(model, x, lines(model, x)).values()
    np.testing.assert_allclose(quads[0, 0] - quads[0, 3], (0, 0.02, 0), atol=1e-12)
    turned = quads[-1, 1] - quads[-1, 2]
    np.testing.assert_allclose(turned, 0.02 * np.array([0, 0.5, np.sqrt(3) / 2]), atol=1e-12)
    drawn = collection(ax, "section")
    assert len(drawn.get_facecolor()) >= 1
    assert "section" not in labels_of(plot.mechanism(model, sections=False))
    flat = cantilever(planar.beam)
    drawn = collection(plot.mechanism(flat, at=fm.configuration(flat)), "section")
    heights = [np.ptp(path.vertices[:, 1]) for path in drawn.get_paths()]
    np.testing.assert_allclose(heights, leaf().thickness)
