"""Motion where the last ends of spectral beams are computed: the same as in all coordinates, without their closures."""

import dataclasses

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar, spatial
from flexmb.math.rigid import compose_turns
from flexmb.math.rotation import rotation_matrix, rotation_plane
from flexmb.mechanics.tree import tree_of
from flexmb.motion.coordinates_form import coordinates_form
from flexmb.motion.drives_by_name import acted_on
from flexmb.motion.protocol import MotionState
from flexmb.motion.tree_form import tree_form

TIMES = [0.0, 0.01, 0.02]


def planar_frame(force=2.0):
    """Beams that branch, two of them walked from their last end, and a rigid bar that closes a loop."""
    section = fm.Rigidity(EA=1e3, EIy=1.0, mass=1.0, Jy=0.01)
    b = fm.Builder()
    for name, place in {"a": (0, 0), "b": (1, 0.2), "c": (2, 0), "d": (1, 1), "e": (2, 1)}.items():
        b.node(name, place)
    for p, q in ("ba", "bc", "db", "de"):
        b.add(planar.spectral_beam(2), p, q, section=section, name=p + q)
    b.add(planar.beam, "c", "e", section=section, released=(), name="ce")
    b.fix("a")
    b.mass("c", 1.0)
    b.force("e", (1.0, force))
    b.gravity((0, -9.81))
    return b.build()


def spatial_frame():
    """Beams that branch in space, out of one plane; one of them is walked from its last end."""
    section = fm.Rigidity(EA=1e3, EIy=1.0, EIz=1.3, GIt=0.8, mass=1.0, Jx=0.01, Jy=0.005, Jz=0.006)
    b = fm.Builder()
    places = {"a": (0, 0, 0), "b": (1, 0.2, 0.1), "c": (2, 0, 0.5), "d": (1, 1, -0.3)}
    for name, place in places.items():
        b.node(name, place)
    for p, q in ("ba", "bc", "bd"):
        b.add(spatial.spectral_beam(2), p, q, section=section, name=p + q, y=(0, 0, 1))
    b.fix("a")
    b.mass("c", 1.0, inertia=np.diag([0.02, 0.03, 0.04]))
    b.force("d", (1.0, 0.5, 2.0))
    b.gravity((0, -9.81, 0))
    return b.build()


def unit(values):
    return np.asarray(values) / np.linalg.norm(values)


@pytest.mark.slow
@pytest.mark.parametrize("curved", [False, True])
@pytest.mark.parametrize("space", [False, True])
def test_the_pose_that_a_beam_gives_closes_it(space, curved):
    random = np.random.default_rng(3)
    p, q, at = np.eye(3) + random.standard_normal((3, 3))
    element = spatial.spectral_beam(2, shear=True) if space else planar.spectral_beam(3)
    own = {"order": 2, "shear": True}
    c = 0.3 * random.standard_normal(12 if space else 6)
    if space:
        turns = [unit(random.standard_normal(4)) for _ in range(3)]
        curvature = {"curvature": np.array([0.0, 0.2, -0.1])} if curved else {}
    else:
        p, q, at = p[:2], q[:2], at[:2]
        turns = [random.standard_normal(1) for _ in range(3)]
        curvature = {"curvature": 0.2} if curved else {}

    @jax.jit
    def closure():
        ref = element.reference((p, turns[0], q, turns[1], np.zeros_like(c)))
        assert element.passage is not None
        way, turn = element.passage(p, turns[0], q, turns[1], c, ref=ref, **own, **curvature)
        if space:
            ends = at + rotation_matrix(jnp.asarray(turns[2])) @ way, compose_turns(turns[2], turn)
        else:
            ends = at + rotation_plane(turns[2][0]) @ way, turns[2] + turn
        return element.deformation(at, turns[2], *ends, c, ref=ref, **own, **curvature)

    found = np.asarray(closure())
    np.testing.assert_allclose(found[: -len(c)], 0, atol=1e-13)
    np.testing.assert_allclose(found[-len(c) :], c, atol=1e-15)


@pytest.mark.slow
def test_a_tree_moves_as_all_coordinates_do():
    model = planar_frame()
    tree = tree_of(model.topology)
    assert tree is not None
    assert tree.held_places.shape == (3,)
    assert model.topology.x.free.shape[0] - tree.kept.shape[0] == 12
    other, found = (fm.simulate(model, TIMES, form=form, rtol=1e-9, atol=1e-12) for form in ("coordinates", None))
    assert (other.form, found.form) == ("coordinates", "tree")
    np.testing.assert_allclose(found.x, other.x, atol=1e-9)
    np.testing.assert_allclose(found.xd, other.xd, atol=1e-6)
    np.testing.assert_allclose(found.near, other.near, atol=1e-9)


@pytest.mark.slow
def test_a_tree_in_space_is_accelerated_as_all_coordinates_are():
    """Somewhere, at some rates: its poses close all beams, whose constraints have multipliers there and none here."""
    model = spatial_frame()
    tree = tree_of(model.topology)
    assert tree is not None
    # Three poses of seven numbers are computed, and no deformation but norms is held by itself.
    assert model.topology.x.free.shape[0] - tree.kept.shape[0] == 21

    @fm.jit
    def both(u, w):
        every = coordinates_form(model.topology, model.parameters)
        form = tree_form(every, tree)
        t, state = jnp.zeros(()), MotionState(u, w, jnp.zeros(0))
        motion = form.whole_motion(t, state)
        same = every.state_of(motion.x, motion.xd, None)
        own = form.acceleration(t, state)[0]
        return motion.x, every.gap(t, same), form.residual(t, state, own), own, every.acceleration(t, same)[0]

    x, gap, left, found, other = both(*0.3 * np.random.default_rng(8).standard_normal((2, len(tree.kept))))
    assert np.linalg.norm(x - model.parameters.reference) > 0.3
    np.testing.assert_allclose(gap, 0, atol=1e-13)
    # Forces of some 1e2 N out of balance by round-off.
    np.testing.assert_allclose(left, 0, atol=1e-10)
    other = np.asarray(other)[tree.kept_places]
    np.testing.assert_allclose(found, other, rtol=0, atol=1e-9 * np.max(np.abs(other)))


@pytest.mark.slow
def test_a_tree_in_space_moves_as_all_coordinates_do():
    model = spatial_frame()
    other, found = (fm.simulate(model, TIMES, form=form, rtol=1e-9, atol=1e-12) for form in ("coordinates", "tree"))
    # What both integrate is the same motion to some ten steps' tolerance; rates are some hundred times as large.
    np.testing.assert_allclose(found.x, other.x, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.xd, other.xd, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found.near, other.near, rtol=0, atol=1e-9)
    assert np.max(np.abs(found.x[-1] - found.x[0])) > 1e-3


@pytest.mark.slow
def test_derivative_by_a_load():
    def place(force):
        return fm.simulate(planar_frame(force), TIMES[:2], rtol=1e-8, adjoint=diffrax.ForwardMode()).x[-1]

    def place_of_the_frame_above(force):
        """By the program that the test above has compiled."""
        return fm.simulate(planar_frame(force), TIMES, rtol=1e-9, atol=1e-12).x[1]

    step = 0.1
    difference = (place_of_the_frame_above(2.0 + step) - place_of_the_frame_above(2.0 - step)) / (2 * step)
    np.testing.assert_allclose(jax.jacfwd(place)(2.0), difference, atol=1e-9)


@pytest.mark.slow
def test_inertia_of_a_users_own_that_refers_to_a_traced_number():
    """Its program is of all coordinates together, of which none are seen to follow from the coefficients alone."""

    def place(density, load, form="tree"):
        def inertia(p, rot_p, q, rot_q, c, *, ref, section, order):
            found = planar.spectral_beam.inertia(p, rot_p, q, rot_q, c, ref=ref, section=section, order=order)
            return found[0], density * found[1]

        element = dataclasses.replace(planar.spectral_beam, inertia=inertia)
        b = fm.Builder()
        b.node("a", (0, 0))
        b.node("b", (1, 0))
        b.add(element(2), "a", "b", section=fm.Rigidity(EA=1e3, EIy=1.0, mass=1.0, Jy=0.01))
        b.fix("a")
        b.force("b", (0, load))
        return fm.simulate(b.build(), TIMES[:2], form=form, rtol=1e-9).x[-1, 3:].sum()

    value, slope = jax.value_and_grad(place)(1.3, 1.0)
    other, expected = jax.value_and_grad(place)(1.3, 1.0, "coordinates")
    np.testing.assert_allclose((value, slope), (other, expected), rtol=1e-7)
    assert abs(slope) > 1e-3


def test_what_needs_all_coordinates_gets_them():
    b = fm.Builder()
    b.node("a", (0, 0))
    b.node("b", (1, 0))
    b.add(planar.beam, "a", "b", section=fm.Rigidity(EA=1e3, EIy=1.0, mass=1.0))
    b.fix("a")
    model = b.build()
    assert tree_of(model.topology) is None
    with pytest.raises(fm.ModelError, match="spectral beam with FIXED closure"):
        fm.simulate(model, TIMES, form="tree")
    with pytest.raises(ValueError, match='controller needs form="coordinates"'):
        fm.simulate(model, TIMES, form="tree", control=abs)


def rod(places="c", moment=0.0, **held):
    """A rod in space out of spectral beams, with a force on the last end of the first."""
    section = fm.Rigidity(EA=1e3, EIy=1.0, EIz=1.3, GIt=0.8, mass=1.0, Jx=0.01, Jy=0.005, Jz=0.006)
    b = fm.Builder()
    b.node("a", (0, 0, 0))
    for number, (p, q) in enumerate(zip(("a", *places), places, strict=False)):
        b.node(q, (1.0 + number, 0.1, 0.2 * number))
        b.add(spatial.spectral_beam(2), p, q, section=section, y=(0, 0, 1), **held)
    b.fix("a")
    b.force(places[0], (0.3, 0.5, 1.0))
    if moment:
        b.moment(places[0], (moment, 0.1, 0.0))
    return b.build()


@pytest.mark.parametrize(
    ("places", "moment", "computed"),
    [
        # Nothing depends on how the last end is turned.
        ("c", 0.0, (1, 0)),
        ("c", 0.2, (1, 4)),
        # The second beam depends on the first, and has no force on its last end.
        ("cd", 0.0, (2, 4)),
    ],
)
def test_of_last_ends_as_much_is_computed_as_is_asked_for(places, moment, computed):
    model = rod(places, moment)
    tree = tree_of(model.topology, acted_on(model, ()))
    assert tree is not None
    assert tree.felt is not None
    assert tree.felt.turns.shape == computed


@pytest.mark.slow
def test_strains_that_are_held_have_multipliers():
    """A rod that does not stretch; its coefficients are coordinates, of which some are held as deformations.

    Of its last end the position alone is computed.
    """
    model = rod(released=tuple(range(9, 15)))
    tree = tree_of(model.topology)
    assert tree is not None
    assert tree.held_places.shape == (2,)
    other, found = (fm.simulate(model, TIMES, form=form, rtol=1e-9, atol=1e-12) for form in ("coordinates", "tree"))
    # As for the frames above.
    np.testing.assert_allclose(found.x, other.x, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.xd, other.xd, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found.near[:, 6:8], 0, atol=1e-14)
    assert np.max(np.abs(found.x[-1] - found.x[0])) > 1e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    "model",
    [planar_frame(), spatial_frame(), rod(released=tuple(range(9, 15)))],
    ids=["planar", "spatial", "held"],
)
def test_tangent_is_the_derivative_of_the_residual(model):
    """By everything that moves, its rates, accelerations and multipliers, somewhere."""
    tree = tree_of(model.topology, acted_on(model, ()))

    @fm.jit
    def both(u, w, z):
        form = tree_form(coordinates_form(model.topology, model.parameters), tree)
        t, memory = jnp.zeros(()), jnp.zeros(0)

        def left(u, w, z):
            return form.residual(t, MotionState(u, w, memory), z)

        found = form.tangent(t, MotionState(u, w, memory), z)
        return (found.by_u, found.by_w, found.by_z), jax.jacfwd(left, (0, 1, 2))(u, w, z)

    n, m = len(tree.kept), len(tree.held_places)
    random = np.random.default_rng(5)
    found, expected = both(*0.3 * random.standard_normal((2, n)), 0.3 * random.standard_normal(n + m))
    # A small corner keeps constraints solvable that may be redundant, of which the residual has none.
    found = [*found[:2], found[2].at[n:, n:].set(0.0)]
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-10 * np.max(np.abs(other)))
