"""An equilibrium that is not stable is told: beyond Euler's loads, on its head, and by a determinant."""

import warnings

import jax
import numpy as np
import pytest
from cases.motions import pendulum

import flexmb as fm
from flexmb import planar, spatial
from flexmb.math.element_matrices import ElementMatrices
from flexmb.statics.stable import has_negative_motion, unstable_motions

# Euler's load of a clamped column whose other end is free, EI = L = 1; its next is nine times that.
EULER = np.pi**2 / 4
# Which columns are solved by dense matrices, in the order of a chain, and by sparse factors: bars join their tips, so
# that they sway together, each in its own shape. Where all are joined to one, a level has more unknowns than a chain's.
WAYS = {
    "dense": {"count": 6},
    "chain": {"count": 45},
    "chain without stretch": {"count": 45, "released": (2, 3)},
    "chain with rigid pieces": {"count": 45, "rigid": (43, 44)},
    "chain of columns": {"count": 3, "columns": 9},
    "sparse": {"count": 3, "columns": 9, "star": True},
}


def columns(count, load, columns=1, star=False, released=None, rigid=()):
    b = fm.Builder()
    section = fm.Rigidity(EA=1e6, EIy=1.0)
    for k in range(columns):
        for i in range(count + 1):
            b.node(f"{k}.{i}", (i / count, k))
        for i in range(count):
            free = () if i in rigid else released
            b.add(planar.beam, f"{k}.{i}", f"{k}.{i + 1}", section=section, released=free)
        b.fix(f"{k}.0")
        b.force(f"{k}.{count}", (-load, 0.0))
        if k:
            b.add(planar.truss, f"{0 if star else k - 1}.{count}", f"{k}.{count}", section=section)
    return b.build(check=columns == 1)


def pulled(check, load=0.1):
    """Springs of 100 and of -30 N/m in a row, of which the second pushes whatever pulls at it."""
    b = fm.Builder()
    for i in range(3):
        b.node(f"n{i}", (0.1 * i, 0.0))
    b.fix("n0")
    for i, stiffness in ((1, 100.0), (2, -30.0)):
        b.fix(f"n{i}", "y")
        b.add(planar.spring_damper(lambda e, ed, *, k: k * e), f"n{i - 1}", f"n{i}", k=stiffness)
    b.force("n2", (load, 0.0))
    return b.build(check=check)


@pytest.mark.parametrize("sparse", [False, True])
def test_a_stiffness_of_an_elements_own_that_is_negative(sparse):
    with pytest.warns(fm.FlexmbWarning, match="not stable"):
        found = fm.equilibrium(pulled(not sparse), sparse=sparse)
    # By each spring's own law.
    np.testing.assert_allclose(found.at("n2")[0] - 0.2, 0.1 / 100 - 0.1 / 30, rtol=1e-12)


def column(count, load, elements=planar, **rigidity):
    b = fm.Builder()
    across = (0.0,) * (1 if elements is planar else 2)
    for i in range(count + 1):
        b.node(f"n{i}", (i / count, *across))
    for i in range(count):
        b.add(elements.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e6, **rigidity))
    b.fix("n0")
    b.fix("n0.rotation")
    b.force(f"n{count}", (-load, *across))
    return b.build()


def told(model, **how):
    """Warnings of an equilibrium."""
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        found = fm.equilibrium(model, **how)
    assert found.result == fm.RESULTS.successful
    return [str(w.message) for w in heard]


@pytest.mark.slow(
    "0.99-False-dense",
    "0.99-False-chain",
    "0.99-False-chain without stretch",
    "0.99-False-chain with rigid pieces",
    "0.99-False-chain of columns",
    "0.99-False-sparse",
    "-5.0-False-dense",
    "-5.0-False-chain without stretch",
    "-5.0-False-chain with rigid pieces",
    "-5.0-False-chain of columns",
    "-5.0-False-sparse",
    "1.01-True-dense",
    "1.01-True-chain without stretch",
    "1.01-True-chain with rigid pieces",
    "1.01-True-chain of columns",
    "1.01-True-sparse",
    "2.0-True-dense",
    "2.0-True-chain without stretch",
    "2.0-True-chain with rigid pieces",
    "2.0-True-chain of columns",
    "8.0-True-dense",
    "8.0-True-chain with rigid pieces",
    "8.0-True-chain of columns",
    "2.0-True-sparse",
    "8.0-True-chain without stretch",
)
@pytest.mark.parametrize("way", WAYS)
# Columns of three cubic beams buckle 3e-4 late; at twice the first load no motion is soft.
@pytest.mark.parametrize(("share", "unstable"), [(0.99, False), (-5.0, False), (1.01, True), (2.0, True), (8.0, True)])
def test_straight_columns(way, share, unstable):
    model = columns(load=share * EULER, **WAYS[way])
    found = told(model, sparse=way != "dense")
    assert len(found) == unstable
    assert all("The equilibrium is not stable: its stiffness is negative" in text for text in found)


@pytest.mark.slow
@pytest.mark.parametrize("count", [8, 60])
@pytest.mark.parametrize(("share", "unstable"), [(0.99, False), (3.0, True)])
def test_a_leaf_spring_that_is_warmed_between_walls(count, share, unstable):
    """Nothing moves, up to 4 pi^2 EI/L^2 = EA alpha dT; of beams from whose first turn nothing was known of stress."""
    b = fm.Builder()
    material = fm.Material(E=200e9, G=80e9, rho=7850.0, alpha=1e-5)
    for i in range(count + 1):
        b.node(f"n{i}", (0.25 * i / count, 0.0))
    for i in range(count):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"b{i}", section=fm.Rectangle(0.02, 1e-3, material))
        b.temperature(f"b{i}", share * 4 * np.pi**2 * (1e-6 / 12) / 0.25**2 / 1e-5)
    b.fix("n0")
    b.fix(f"n{count}")
    heard = told(b.build(), sparse=True)
    assert any("not stable" in text for text in heard) == unstable


@pytest.mark.slow
def test_no_pivot_is_lost_where_metres_and_radians_differ_much():
    """A girder of 200 m that is pulled along itself; in space rotations are four numbers of the order of one."""
    b = fm.Builder()
    section = fm.Rectangle(2.0, 0.5, fm.Material(E=210e9, G=80e9, rho=7850.0))
    for i in range(5):
        b.node(f"n{i}", (50.0 * i, 0, 0))
    for i in range(4):
        b.add(spatial.beam, f"n{i}", f"n{i + 1}", section=section, y=(0, 1, 0))
    b.fix("n0")
    b.force("n4", (1e4, 0, 0))
    assert not [text for text in told(b.build(check=False), sparse=True) if "not stable" in text]


@pytest.mark.parametrize(("stiffness", "negative"), [(1.0, False), (-1e-3, True), (-1e-9, False)])
def test_a_motion_is_looked_for_beside_a_stiff_one(stiffness, negative):
    """Two elements of one coordinate each, a stiffness of a million beside one that is softened to what is given."""
    at, one = np.array([[0], [1]]), np.ones((2, 1, 1))
    none = np.zeros(0, int)
    elastic = np.array([1e6, 1.0]).reshape(2, 1, 1)
    elements = ElementMatrices(
        structural=[(at, at, elastic)],
        curved=[(at, at, np.array([0.0, stiffness - 1.0]).reshape(2, 1, 1))],
        damping=[],
        mass=[],
        loss=[],
        constraints=[(at, at, one)],
        elastic=[(at, at, elastic)],
        viscous=[],
        lossy=[],
        free=np.arange(2),
        held=none,
        sizes=np.ones(2),
        kept=np.ones(2),
    )
    assert has_negative_motion(elements) == negative


def test_motions_are_counted_and_named():
    (planar_one,) = told(column(6, 1.1 * EULER, EIy=1.0))
    assert "in 1 motion (n6.rotation.phi, " in planar_one
    assert "in 2 motions (" in told(column(6, 9.1 * EULER, EIy=1.0))[0]


@pytest.mark.slow
def test_a_column_that_buckles_both_ways_at_once_is_told():
    """An even number of negative ones, which no determinant shows."""
    square = column(4, 1.1 * EULER, spatial, EIy=1.0, EIz=1.0, GIt=1.0)
    assert "in 2 motions (" in told(square)[0]
    assert len(told(square, sparse=True)) == 1


@pytest.mark.slow
@pytest.mark.parametrize(("height", "unstable"), [(1.0, True), (-1.0, False)])
def test_a_body_on_its_head(height, unstable):
    assert len(told(pendulum((0, height)).build())) == unstable


def test_equilibria_that_follow_one_another():
    with pytest.warns(fm.FlexmbWarning, match="Of 4 equilibria, 2 are not stable, number 2 first: "):
        fm.equilibria(column(6, EULER, EIy=1.0), load_factor=[0.5, 0.99, 1.01, 1.5])


def test_where_numbers_are_traced_nothing_is_told():
    tip = jax.jit(lambda load: fm.equilibrium(column(6, load, EIy=1.0)).at("n6"))(1.5 * EULER)
    # Straight, shorter by P/EA.
    np.testing.assert_allclose(tip, [1 - 1.5e-6 * EULER, 0], rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    ("stiffness", "structural", "symmetric", "count"),
    [
        ([[2.0, 0.0], [0.0, -1.0]], 1.0, True, 1),
        # Of a force that follows, as Beck's: negative in some motion is the symmetric part, not the determinant.
        ([[1.0, 4.0], [0.0, 1.0]], 1.0, False, 0),
        ([[1.0, 4.0], [1.0, 1.0]], 1.0, False, 1),
        # Beside the structural stiffness it is a critical state; and beside the largest, round-off.
        ([[1.0, 1.0 + 1e-8], [1.0 + 1e-8, 1.0]], 1.0, True, 0),
        ([[1.0, 1.0 + 1e-8], [1.0 + 1e-8, 1.0]], 0.0, True, 1),
        ([[1.0, 1.0 + 1e-12], [1.0 + 1e-12, 1.0]], 0.0, True, 0),
    ],
)
def test_signs_of_a_stiffness(stiffness, structural, symmetric, count):
    found = unstable_motions(np.array(stiffness), structural * np.eye(2), symmetric)
    assert found.shape == (2, count)
    if count:
        k = np.array(stiffness)
        assert found[:, 0] @ k @ found[:, 0] < 0


@pytest.mark.slow("80.0-80.0", "60.0--40.0")
@pytest.mark.parametrize(("first", "second"), [(80.0, 80.0), (60.0, -40.0)])
def test_a_double_pendulum_hangs_down_from_wherever_it_is_drawn(first, second):
    """Nothing is elastic, so that no smaller load leads there by smaller steps; two equal masses, sqrt(2 -+ sqrt 2)."""
    b = fm.Builder()
    place = np.zeros(2)
    b.node("n0", place)
    b.fix("n0")
    for i, angle in enumerate(np.deg2rad([first, second])):
        place = place + np.array([np.sin(angle), -np.cos(angle)])
        b.node(f"n{i + 1}", place)
        b.rotation(f"r{i}")
        b.add(planar.rigid_beam, f"n{i}", f"r{i}", f"n{i + 1}", name=f"rod{i}")
        b.dof(f"r{i}", "phi")
        b.mass(f"n{i + 1}", 1.0)
    b.gravity((0.0, -9.81))
    model = b.build()
    np.testing.assert_allclose(fm.equilibrium(model).at("n2"), [0.0, -2.0], atol=1e-9)
    wanted = np.sqrt((2 + np.array([-1, 1]) * np.sqrt(2)) * 9.81) / (2 * np.pi)
    np.testing.assert_allclose(fm.frequencies(model), wanted, rtol=1e-9)


def test_both_triangles_of_an_unsymmetric_stiffness_tell():
    """By hand: the lower one alone has a Cholesky factor, the whole has the determinant -1/2."""
    stiffness, structural = np.array([[1.0, 3.0], [0.5, 1.0]]), np.eye(2)
    assert unstable_motions(stiffness, structural, symmetric=False).shape[1] == 1
    assert unstable_motions((stiffness + stiffness.T) / 2, structural, symmetric=True).shape[1] == 1
    assert unstable_motions(np.diag([1.0, 2.0]), structural, symmetric=True).shape[1] == 0
