"""Where statics has no answer, or a tempting wrong one: a right answer or a named result."""

import contextlib
import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx
from scipy.optimize import brentq

import flexmb as fm
from flexmb import planar


def truss(load, base=10.0, height=1.0):
    """A7: two bars of EA = 1e4, feet held, apex free to move up and down."""
    b = fm.Builder()
    section = fm.Rigidity(EA=1e4, mass=1.0)
    b.node("left", (-base, 0))
    b.node("right", (base, 0))
    b.node("apex", (0, height))
    b.add(planar.truss, "left", "apex", name="1", section=section)
    b.add(planar.truss, "right", "apex", name="2", section=section)
    b.fix("left")
    b.fix("right")
    b.fix("apex", "x")
    b.force("apex", (0, -load))
    return b.build()


LIMIT = 3.8108719042


@pytest.mark.slow
@pytest.mark.parametrize("share", [1.0001, 1.01, 1.5, 4.0, 100.0])
def test_beyond_a_limit_load_there_is_a_refusal_and_no_jump(share):
    # The snapped side carries any of these loads: an iteration that leaves the path would find it.
    with pytest.raises(fm.AnalysisError, match="limit load"):
        fm.equilibrium(truss(share * LIMIT))


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.0, 1e-6, 0.5, 0.99, 0.9999])
def test_below_it_the_branch_is_the_one_that_starts_unloaded(share):
    drop = 1 - float(fm.equilibrium(truss(share * LIMIT)).at("apex")[1])
    # Closed form of the bars' engineering strain, A7.
    bar = np.hypot(10, 1 - drop)
    assert 2e4 * (1 / bar - 1 / np.hypot(10, 1)) * (1 - drop) == approx(share * LIMIT, rel=1e-8, abs=1e-9)
    assert drop < 0.4236074652


def named(found):
    return fm.RESULTS(int(found.result))


def apex(load):
    """Height of the apex and code of the result, for derivatives by the load."""
    found = fm.equilibrium(truss(load), throw=False)
    return found.at("apex")[1], found.result


# Printed to eleven digits; closed form, A7.
CLOSED_LIMIT = 2e4 * (1 - (10 / np.hypot(10, 1)) ** (2 / 3)) ** 1.5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("below", "result"),
    [
        (1e-4, fm.RESULTS.successful),
        (1e-8, fm.RESULTS.successful),
        (1e-9, fm.RESULTS.critical_state),
        (1e-10, fm.RESULTS.critical_state),
        (3e-11, fm.RESULTS.critical_state),
        (0.0, fm.RESULTS.not_converged),
        (-1e-11, fm.RESULTS.not_converged),
    ],
)
def test_a_derivative_near_a_limit_load_comes_with_its_code(below, result):
    load = CLOSED_LIMIT * (1 - below)
    (height, code), (slope, _) = jax.jvp(apex, (load,), (1.0,))
    assert fm.RESULTS(int(code)) is result
    found = fm.equilibrium(truss(load), throw=False)
    assert named(found) is result
    bar = np.hypot(10, height)
    if result is not fm.RESULTS.not_converged:
        # The state is right, so that it is not refused; its place is known to the root of round-off.
        assert fm.equilibrium(truss(load)).at("apex")[1] == approx(float(height), abs=1e-7)
        assert 2e4 * (1 / bar - 1 / np.hypot(10, 1)) * height == approx(load, rel=1e-12)
    if result is fm.RESULTS.successful:
        # dP/dw = 2 EA (1/L0 - b^2/l^3), closed form; next to zero it knows as many digits as K does.
        stiffness = 2e4 * (1 / np.hypot(10, 1) - 100 / bar**3)
        assert -slope == approx(1 / stiffness, rel=1e-7)


@pytest.mark.slow
def test_the_derivative_of_the_limit_load_itself_exists():
    # 3.8108719042 is rounded up: nothing carries it.
    with pytest.raises(fm.AnalysisError, match="limit load"):
        fm.equilibrium(truss(LIMIT))
    assert LIMIT * fm.limit_load(truss(LIMIT)) == approx(CLOSED_LIMIT, rel=1e-12)


@pytest.mark.slow
def test_a_batch_tells_its_critical_states_apart():
    loads = CLOSED_LIMIT * jnp.array([0.5, 1 - 1e-10, 1.5])
    codes = jax.vmap(lambda load: apex(load)[1])(loads)
    assert [fm.RESULTS(int(c)).name for c in codes] == ["successful", "critical_state", "not_converged"]


def column(load, aside=0.0, **options):
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (1, 0))
    b.add(planar.spectral_beam(6), "foot", "tip", name="leaf", section=fm.Rigidity(EA=1e6, EIy=1.0, mass=1.0))
    b.fix("foot")
    b.force("tip", (-load, aside), **options)
    return b.build()


@pytest.mark.slow
def test_a_straight_column_beyond_its_buckling_load_is_called_unstable():
    model = column(3.0)
    with pytest.warns(fm.FlexmbWarning, match="The equilibrium is not stable"):
        assert fm.equilibrium(model).at("tip")[1] == approx(0, abs=1e-12)
    assert fm.frequencies(model)[0] < 0
    # All loads scale: the multiplier counts from none.
    assert fm.buckling_loads(model)[0] == approx(2.4674011003 / 3, rel=1e-5)


@pytest.mark.slow
def test_at_a_bifurcation_the_state_is_found_and_called_critical():
    model = column(3.0, aside=0.0)

    def modes_at(load_factor):
        return fm.modes(fm.linearize(model, load_factor=load_factor))

    critical: Any = brentq(lambda factor: float(modes_at(factor).eigenvalues[0]), 0.8, 0.85, xtol=1e-14)
    # Euler's load, closed form; strain P/EA.
    assert 3 * critical == approx(2.4674011003, rel=5e-6)
    codes = {}
    for off in (-1e-2, -1e-3, -1e-6, 0.0, 1e-6, 1e-3, 1e-2):
        beyond = pytest.warns(fm.FlexmbWarning, match="not stable: its stiffness is negative in 1 motion")
        # Nearer to it a state is critical, and says that.
        with beyond if off > 1e-4 else contextlib.nullcontext():
            found = fm.equilibrium(model, load_factor=critical * (1 + off))
        codes[off] = named(found)
        # Straight, shortened by P/EA.
        np.testing.assert_allclose(found.at("tip"), [1 - 3 * critical * (1 + off) / 1e6, 0], rtol=0, atol=1e-12)
        # What is asked about the stiffness has an answer: its lowest eigenvalue passes zero.
        modes = modes_at(critical * (1 + off))
        if off:
            assert modes.stable == (off < 0)
            assert np.sign(modes.eigenvalues[0]) == -np.sign(off)
        else:
            assert abs(modes.eigenvalues[0]) < 1e-9 * modes.eigenvalues[1]
    near = {off for off, code in codes.items() if code is fm.RESULTS.critical_state}
    assert near == {-1e-6, 0.0, 1e-6}
    assert {code for off, code in codes.items() if off not in near} == {fm.RESULTS.successful}


@pytest.mark.slow
@pytest.mark.parametrize("slenderness", [1e5, 1e7, 1e9])
def test_a_slender_beam_is_not_critical_whatever_the_degrees_of_freedom(slenderness):
    # EA L^2/EI, and coordinates in which stretching and bending mix.
    b = fm.Builder()
    for i in range(5):
        b.node(str(i), (0.25 * i * np.cos(0.7), 0.25 * i * np.sin(0.7)))
    for i in range(4):
        b.add(planar.beam, str(i), str(i + 1), section=fm.Rigidity(EA=slenderness, EIy=1.0))
        b.dof(str(i + 1), "x", "y", "phi")
    b.fix("0")
    b.force("4", (0, 1.0))
    assert named(fm.equilibrium(b.build())) is fm.RESULTS.successful


@pytest.mark.slow
def test_what_has_no_elastic_stiffness_is_not_critical():
    b = fm.Builder()
    b.node("joint", (0, 0))
    b.node("body", (0, -1))
    b.add(planar.rigid_beam, "joint", "body")
    b.fix("joint", "position")
    b.force("body", (0, -2.0))
    assert named(fm.equilibrium(b.build())) is fm.RESULTS.successful


@pytest.mark.slow
def test_a_force_that_follows_its_column_has_no_static_buckling_load():
    # Beck's column flutters: statics finds no load, from the straight state or below any load.
    model = column(1.0, follower=True)
    with pytest.warns(fm.FlexmbWarning, match="complex: before it buckles"):
        found = np.asarray(fm.buckling_loads(model))
    assert not np.any(np.isfinite(found))
    assert np.all(np.abs(np.real(fm.poles(model))) < 1e-6)
    # Flutter at 20.05 EI/L^2 (closed form, Beck 1952): pairs of poles leave the axis.
    assert np.max(np.real(fm.poles(column(19.9, follower=True)))) < 1e-3
    assert np.max(np.real(fm.poles(column(20.2, follower=True)))) > 0.1


@pytest.mark.slow
def test_a_load_on_a_support_moves_nothing():
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (1, 0))
    b.add(planar.spectral_beam(3), "foot", "tip", name="leaf", section=fm.Rigidity(EA=1e3, EIy=1.0))
    b.fix("foot")
    b.force("foot", (5.0, -7.0))
    found = fm.equilibrium(b.build())
    np.testing.assert_allclose(found.e, 0, atol=1e-12)
    np.testing.assert_allclose(found.reactions[:2], [-5.0, 7.0], rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("load", [1e3, 1e5])
def test_a_huge_first_step_ends_on_the_branch(load):
    # The tip hangs ever more along the force; elongation P/EA.
    found = fm.equilibrium(column(0.0, aside=load), throw=False)
    if int(found.result) == fm.RESULTS.successful:
        x, y = np.asarray(found.at("tip"))
        assert 0 < x < 0.1
        assert 0.9 < y - load / 1e6 < 1.0
    else:
        assert fm.RESULTS(int(found.result)) is fm.RESULTS.not_converged


@pytest.mark.slow
def test_a_foil_of_one_ten_thousandth_of_its_length():
    # A1 at P L^2/EI = 1: EA L^2/EI = 12e8.
    material = fm.Material(E=210e9, G=80e9)
    foil = fm.Rectangle(0.01, 1e-5, material)
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (0.1, 0))
    b.add(planar.spectral_beam(6), "foot", "tip", name="foil", section=foil)
    b.fix("foot")
    b.force("tip", (0, float(foil.rigidity().EIy) / 0.01))
    found = fm.equilibrium(b.build())
    np.testing.assert_allclose(found.at("tip"), [0.1 * (1 - 0.0564332363), 0.1 * 0.3017207738], rtol=2e-8)
    assert named(found) is fm.RESULTS.successful


@pytest.mark.slow
@pytest.mark.parametrize("load", [1e-3, 1.0, 10.0])
def test_two_bars_in_line_have_no_stiffness_across_until_they_are_stretched(load):
    flat = truss(load, height=0.0)
    with pytest.raises(fm.AnalysisError) as info:
        fm.equilibrium(flat)
    assert info.value.code == "singular_stiffness"
    # Once a coordinate is held at a height, or with prestress N, closed form: 2 (EA (l/b - 1) + N) w/l = P.
    b = fm.Builder()
    for name, x in (("left", -10), ("right", 10), ("apex", 0)):
        b.node(name, (x, 0))
    for foot in ("left", "right"):
        b.add(planar.truss, foot, "apex", name=foot, section=fm.Rigidity(EA=1e4))
        b.prestress(foot, 100.0)
        b.fix(foot)
    b.fix("apex", "x")
    b.force("apex", (0, -load))
    drop = brentq(lambda w: 2 * (1e4 * (np.hypot(10, w) / 10 - 1) + 100) * w / np.hypot(10, w) - load, 0, 2)
    assert -fm.equilibrium(b.build()).at("apex")[1] == approx(drop, rel=1e-10)


def test_rigid_bars_in_line_are_refused_by_name():
    b = fm.Builder()
    for i, name in enumerate("ABDC"):
        b.node(name, (float(i), 0))
    for p, q in ("AB", "BC", "DC"):
        b.add(planar.truss, p, q, name=p + q)
    b.fix("A")
    b.fix("D")
    b.dof("B", "y")
    b.force("B", (0, -1.0))
    with pytest.raises(fm.MechanismError, match=r"free motion 1: C\.y") as info:
        b.build()
    assert info.value.code == "overconstrained"


def crank(dof, force):
    """A crank of length 1 at -45 degrees with a spring of 1 N m/rad in its joint; force up at its end."""
    b = fm.Builder()
    b.node("joint", (0, 0))
    b.node("body", (np.cos(np.pi / 4), -np.sin(np.pi / 4)))
    b.rotation("ground")
    b.add(planar.rigid_beam, "joint", "body")
    b.add(planar.hinge, "ground", "joint", stiffness=1.0)
    b.fix("joint", "position")
    b.fix("ground", "rotation")
    b.dof(*dof)
    b.force("body", (0, force))
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize("dof", [("joint", "phi"), ("body", "x")])
@pytest.mark.parametrize("force", [0.5, np.pi / 4, 0.9, 1.2, 3.0])
def test_a_degree_of_freedom_that_comes_to_a_dead_point(dof, force):
    # x of the end is stationary where the crank lies level, F = pi/4. Closed form: angle + pi/4 = F cos(angle).
    angle = brentq(lambda a: a + np.pi / 4 - force * np.cos(a), -np.pi / 4, np.pi / 2)
    found = fm.equilibrium(crank(dof, force), throw=False)
    if named(found) is fm.RESULTS.successful:
        np.testing.assert_allclose(found.at("body"), [np.cos(angle), np.sin(angle)], rtol=0, atol=1e-10)
    else:
        assert dof == ("body", "x")
        assert force >= np.pi / 4
        assert named(found) in (fm.RESULTS.not_converged, fm.RESULTS.singular_configuration)


LEAF = fm.Rectangle(0.018, 5e-4, fm.Material(210e9, 80e9, 7850.0))


def three_leaf_guide(lean, released=None):
    """Three upright leaf springs to one rigid bar, the third leaning by an angle: all but over-constrained."""
    b = fm.Builder()
    b.node("stage", (0.05, 0.1))
    for i in range(3):
        foot = 0.05 * i - 0.1 * np.tan(lean) * (i == 2)
        b.node(f"foot {i}", (foot, 0))
        top = "stage" if i == 1 else b.node(f"top {i}", (0.05 * i, 0.1))
        b.add(planar.beam, f"foot {i}", top, name=f"leaf {i}", section=LEAF, released=released)
        b.fix(f"foot {i}")
        if i != 1:
            b.add(planar.beam, "stage", top, name=f"bar {i}")
    return b


@pytest.mark.slow
@pytest.mark.parametrize("lean", [0.0, 1e-9, 1e-6, 1e-3])
def test_a_third_leaf_spring_that_is_almost_parallel(lean):
    # Stiffness of the stage, assembled by hand from beams of length l: EA/l, 12, 6, 4 EI/l^3, /l^2, /l.
    r, total = LEAF.rigidity(), np.zeros((3, 3))
    for i in range(3):
        tilt = lean * (i == 2)
        l0, arm = 0.1 / np.cos(tilt), 0.05 * (i - 1)
        own = np.diag([r.EA / l0, 12 * r.EIy / l0**3, 4 * r.EIy / l0])
        own[1, 2] = own[2, 1] = -6 * r.EIy / l0**2
        along, across = [np.sin(tilt), np.cos(tilt)], [-np.cos(tilt), np.sin(tilt)]
        # Displacement of the top: u + phi x arm, arm along x.
        motion = np.array([[*along, along[1] * arm], [*across, across[1] * arm], [0, 0, 1]])
        total += motion.T @ own @ motion
    found = np.asarray(fm.compliance(three_leaf_guide(lean).build(), "stage"))
    expected = np.linalg.inv(total)
    # EA l^2/EI = 5e5 of round-off.
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-9 * np.max(np.abs(expected)))


@pytest.mark.parametrize(
    ("lean", "code", "words"),
    [
        (0.0, "overconstrained", "release deformation 1 of element 'leaf"),
        (1e-9, "overconstrained", "release deformation 1 of element 'leaf"),
        # Beyond the tolerance of rank the leaning leaf spring, which cannot stretch, holds the stage.
        (1e-6, "dof", "stage.x cannot move"),
        (1e-3, "dof", "stage.x cannot move"),
    ],
)
def test_a_third_leaf_spring_that_cannot_stretch_is_refused_by_name(lean, code, words):
    b = three_leaf_guide(lean, released=(2, 3))
    b.dof("stage", "x")
    with pytest.raises(fm.MechanismError, match=words) as info:
        b.build()
    assert info.value.code == code


@pytest.mark.slow
def test_modes_under_a_trace():
    with pytest.raises(TypeError, match="frequencies"):
        jax.grad(lambda load: fm.modes(side_loaded(1, load, lengthwise=-1.0)).frequencies[0])(1.0)


def side_loaded(beams, load, released=None, lengthwise=0.0):
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(f"{i}", (0.1 * i / beams, 0))
    for i in range(beams):
        b.add(planar.beam, f"{i}", f"{i + 1}", section=LEAF, released=released)
    b.fix("0")
    b.force(f"{beams}", (lengthwise, load))
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize("released", [None, (2, 3)])
@pytest.mark.parametrize("load", [1e-6, 1e-3, 0.1])
def test_what_round_off_would_buckle_is_unbounded(released, load):
    # A cubic beam under a side load has no geometric stiffness in its axial force, which is zero: nothing buckles.
    model = side_loaded(1, load, released)
    assert not np.any(np.isfinite(fm.buckling_loads(model)))
    assert len(fm.buckling(model).multipliers) == 0
    if released is None:
        assert not np.any(np.isfinite(fm.path(model).multipliers[1:]))


@pytest.mark.slow
@pytest.mark.parametrize("load", [1e-5, 1e-3, 1.0])
def test_a_lengthwise_load_buckles_at_any_scale(load):
    # Smaller and larger root of det(K0 + P G0) = 0 of one cubic beam, P L^2/EI = 2.486 and 32.18 (textbooks).
    found = np.asarray(fm.buckling_loads(side_loaded(1, 0.0, lengthwise=-load)))
    first, second = (float(LEAF.rigidity().EIy) / 0.1**2 * np.array([2.486, 32.181])).tolist()
    # Printed to four digits.
    np.testing.assert_allclose(found[:2] * load, [first, second], rtol=3e-4)
    assert not np.isfinite(found[2])


@pytest.mark.slow
def test_buckling_loads_keep_their_derivative_beside_unbounded_ones():
    def first(thickness):
        b = fm.Builder()
        b.node("0", (0, 0))
        b.node("1", (0.1, 0))
        b.add(planar.beam, "0", "1", section=fm.Rectangle(0.018, thickness, LEAF.material))
        b.fix("0")
        b.force("1", (-1.0, 0))
        b.dof("1", "x", "y", "phi")
        return fm.buckling_loads(b.build())

    loads, found = jax.jvp(first, (5e-4,), (1.0,))
    # With the cube of the thickness, but for the strain P/EA.
    np.testing.assert_allclose(found[:2], 3 * loads[:2] / 5e-4, rtol=1e-6)
    assert np.all(np.isfinite(found[:2]))


@pytest.mark.slow
@pytest.mark.parametrize(
    "ask",
    [fm.equilibrium, fm.frequencies, fm.linearize, fm.buckling_loads, functools.partial(fm.linearize, sparse=True)],
)
def test_a_motion_without_stiffness_is_named_where_no_equilibrium_is_found(ask):
    """A pinned body between two nodes in one place is a hinge, about which the loaded beam turns."""
    b = fm.Builder()
    section = fm.Rigidity(EA=1e4, EIy=1.0, mass=1.0)
    for name, x in {"A": 0.0, "B": 0.1, "C": 0.1, "D": 0.2}.items():
        b.node(name, (x, 0))
    b.add(planar.beam, "A", "B", section=section)
    b.add(planar.rigid_beam, "B", "C")
    b.add(planar.beam, "C", "D", section=section)
    b.fix("A")
    b.force("D", (0, -0.1))
    with pytest.raises(fm.AnalysisError, match=r"nothing elastic resists C\.rotation\.phi .* pinned"):
        ask(b.build(check=not isinstance(ask, functools.partial)))


@pytest.mark.slow("-90.0", "120.0")
@pytest.mark.parametrize("turn", [120.0, 240.0, -90.0])
def test_a_crank_that_is_driven_beyond_its_reach_is_refused(turn):
    """A rigid four-bar of ground 1, crank 1, coupler 0.8, rocker 0.5, the crank drawn at 60 degrees.

    Coupler and rocker reach as far as 1.3 between tip and ground, and no nearer than 0.3: angles of 2 arcsin of half
    of these over one, 17 to 81 degrees.
    """
    crank = np.deg2rad(60.0)
    b_at = np.array([np.cos(crank), np.sin(crank)])
    # Tip and far ground are one apart: by the law of cosines from the ground along to the tip.
    along = (1.0 + 0.5**2 - 0.8**2) / 2
    toward = b_at - [1.0, 0.0]
    c_at = [1.0, 0.0] + along * toward + np.sqrt(0.5**2 - along**2) * np.array([toward[1], -toward[0]])
    b = fm.Builder()
    for name, place in {"A": (0.0, 0.0), "B": b_at, "C": c_at, "D": (1.0, 0.0)}.items():
        b.node(name, place)
    for i in range(3):
        b.rotation(f"r{i}")
    for i, (p, q) in enumerate(("AB", "BC", "CD")):
        b.add(planar.rigid_beam, p, f"r{i}", q, name=f"bar{i}")
    b.fix("A")
    b.fix("D")
    b.prescribe("r0", "phi", np.deg2rad(turn))
    b.mass("C", 1.0)
    with pytest.raises(fm.AnalysisError):
        fm.equilibrium(b.build())
