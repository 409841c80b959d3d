"""Load multipliers: under a preload, and by sparse factors."""

import contextlib
from typing import Any

import jax
import numpy as np
import pytest
import scipy.linalg
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.arguments import as_floats
from flexmb.linear.buckling import multipliers_about, multipliers_of
from flexmb.math.element_matrices import AssembledEquations
from flexmb.mechanics.deformation import deformations, zero_strain
from flexmb.mechanics.loads import LoadFactors
from flexmb.statics.sparse import balanced
from flexmb.statics.tangent import at_state, elastic_stress


@pytest.mark.slow
@pytest.mark.parametrize("preload", [(0.0, 0.5), (0.3, 1.0)])
@pytest.mark.filterwarnings("ignore:At the load multiplier")
def test_multipliers_under_a_preload_are_those_of_the_balance(preload):
    # What the increment adds to all stresses is the derivative of the balance by its factor, here by differences
    # of equilibria in all coordinates (1e-5: truncation 1e-9), and no choice of degrees of freedom changes it.
    def bent(dofs):
        b = fm.Builder()
        for i in range(5):
            b.node(f"n{i}", (i / 4, 0.0))
        for i in range(4):
            section = fm.Rigidity(EA=1e4, EIy=1.0)
            b.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"b{i}", section=section, released=(2, 3))
        b.fix("n0")
        b.force("n4", preload)
        b.force("n4", (-1.0, 0.1), increment=True)
        return b.build(dofs=dofs)

    model = bent([f"b{i}.e{j}" for i in range(4) for j in (2, 3)])
    other = bent([f"n{i}.{name}" for i in range(1, 5) for name in ("y", "rotation.phi")])
    topology, parameters = model.topology, model.parameters
    held = np.asarray(topology.e.held)

    def balance(factor):
        factors = LoadFactors(1.0, factor)
        at = balanced(topology, parameters, factors)
        near = deformations(topology, parameters, at.x, zero_strain(topology))
        sigma = np.array(elastic_stress(topology, parameters, factors, near))
        sigma[held] = at.multipliers
        return at.x, near, sigma

    x, near, sigma = balance(0.0)
    added = (balance(1e-5)[2] - balance(-1e-5)[2]) / 2e-5
    stays, scaled = (
        AssembledEquations(jax.device_get(at_state(topology, parameters, LoadFactors(1.0, 0.0), x, near, s)[0]))
        .at()
        .toarray()
        for s in (sigma, sigma + added)
    )
    n = len(topology.x.free)
    motions = scipy.linalg.null_space(stays[n:, :n])
    found: Any = scipy.linalg.eigvals(
        -motions.T @ (scaled - stays)[:n, :n] @ motions, motions.T @ stays[:n, :n] @ motions
    )
    inverse = found.real
    wanted = 1 / inverse[np.argsort(-np.abs(inverse))][:3]
    np.testing.assert_allclose(fm.buckling_loads(model)[:3], wanted, rtol=1e-7)
    np.testing.assert_allclose(fm.buckling_loads(other)[:3], wanted, rtol=1e-7)


def column(beams, load=(-1.0, 0.0), preload=None, bending=1.0, gravity=None, sparse=False, **options):
    """Cantilever of unit length; with a preload the load is the increment."""
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(f"n{i}", (i / beams, 0.0))
    section = fm.Rigidity(EA=1e6, EIy=bending, mass=1.0)
    for i in range(beams):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"b{i}", section=section, **options)
    b.fix("n0")
    b.force(f"n{beams}", load, increment=preload is not None)
    if preload is not None:
        b.force(f"n{beams}", preload)
    if gravity is not None:
        b.gravity(gravity)
    return b.build(check=not sparse)


@pytest.mark.slow
@pytest.mark.parametrize(
    "case",
    [
        {},
        {"released": (2, 3), "load": (-0.5, 0.3)},
        {"load": (-1.0, 0.1), "preload": (0.3, 1.0), "gravity": (0.0, -0.5)},
    ],
    ids=["pressed", "bent, of held elongation", "with a preload"],
)
@pytest.mark.filterwarnings("ignore:At the load multiplier")
def test_modes_by_sparse_factors_are_those_of_dense_matrices(case):
    # Round-off of a stiffness ratio of 1e6 in the dense path.
    wanted = fm.buckling(column(10, **case), count=4)
    found = fm.buckling(column(10, sparse=True, **case), count=4, sparse=True)
    assert len(wanted.multipliers) == 4
    np.testing.assert_allclose(found.multipliers, wanted.multipliers, rtol=1e-9)
    # Where two entries are alike the largest is either.
    signs = np.sign(np.sum(found.shapes * wanted.shapes, axis=0))
    np.testing.assert_allclose(found.shapes * signs, wanted.shapes, atol=1e-7)
    np.testing.assert_allclose(found.position("n10"), wanted.position("n10"), atol=1e-9)
    assert "load multiplier" in repr(found)


@pytest.mark.slow
def test_modes_of_a_thousand_beams():
    # Euler: (2 n - 1)^2 pi^2/4 and 1 - cos; what is left is the axial strain P/EA.
    model = column(1000, sparse=True)
    found = fm.buckling(model, count=5, sparse=True)
    odd = np.pi / 2 * (2 * np.arange(1, 6) - 1)
    np.testing.assert_allclose(found.multipliers, odd**2, rtol=1e-5)
    for i in (250, 1000):
        moved = np.abs(found.shape(f"n{i}", "y") / found.shape("n1000", "phi"))
        # Slopes of the tip are k times deflections.
        np.testing.assert_allclose(moved, (1 - np.cos(odd * i / 1000)) / odd, rtol=1e-4)
    np.testing.assert_array_equal(found.multipliers, fm.buckling_loads(model, count=5, sparse=True))


@pytest.mark.slow
@pytest.mark.parametrize(
    "case",
    [{"load": (-0.5, 0.3)}, {"load": (-1.0, 0.1), "preload": (0.3, 1.0), "released": (2, 3)}],
    ids=["all loads", "increment"],
)
@pytest.mark.filterwarnings("ignore:At the load multiplier")
def test_derivative_of_a_multiplier_by_sparse_factors(case):
    @fm.jit
    @jax.value_and_grad
    def second(bending):
        model = column(4, bending=bending, gravity=(0.0, -0.2), sparse=True, **case)
        return fm.buckling_loads(model, count=2, sparse=True)[1]

    (value, slope), h = second(1.0), 1e-2
    near = {i: float(second(1.0 + i * h)[0]) for i in (-2, -1, 1, 2)}
    difference = (8 * (near[1] - near[-1]) - (near[2] - near[-2])) / (12 * h)
    dense = column(4, gravity=(0.0, -0.2), **case)
    assert float(value) == approx(float(fm.buckling_loads(dense, count=2)[1]), rel=1e-9)
    # Truncation h^4, and round-off of the multiplier over h, 1e-8 measured.
    assert float(slope) == approx(difference, rel=1e-7)


@pytest.mark.slow
def test_what_sparse_multipliers_refuse():
    with pytest.raises(fm.AnalysisError, match="not positive definite"):
        fm.buckling_loads(column(6, (1.0, 0.0), (-3.0, 0.0), sparse=True), count=2, sparse=True)
    assert not np.any(np.isfinite(fm.buckling_loads(column(6, (0.0, 0.0), sparse=True), count=2, sparse=True)))
    with pytest.raises(ValueError, match="`count`"):
        fm.buckling_loads(column(4, sparse=True), sparse=True)
    with pytest.raises(fm.ModelError, match="few of the 3000 load"):
        fm.buckling_loads(column(1000, sparse=True), sparse=True, count=1000)


@pytest.mark.slow
@pytest.mark.parametrize("load", [1000.0, 2500.0])
def test_a_load_that_follows_a_column_has_no_multiplier(load):
    """A12, Beck's column: it flutters and never buckles, so that what eigenvalues there are round-off makes."""
    b = fm.Builder()
    for i in range(3):
        b.node(f"n{i}", (0.05 * i, 0))
    for i in range(2):
        section = fm.Rigidity(EA=1e6, EIy=1.0, mass=1.0)
        b.add(planar.spectral_beam(order=5), f"n{i}", f"n{i + 1}", section=section)
    b.fix("n0")
    b.force("n2", (-load, 0.0), follower=True)
    model = b.build()
    with pytest.warns(fm.FlexmbWarning, match=r"complex: before it buckles .*fm\.poles"):
        assert not np.any(np.isfinite(fm.buckling_loads(model)))
    with pytest.warns(fm.FlexmbWarning, match="complex"):
        assert len(fm.buckling(model).multipliers) == 0
    lin = fm.linearize(model)
    assert not np.any(np.isfinite(multipliers_of(lin.K0, lin.G0, as_floats(0.0), unsymmetric=True)))


@pytest.mark.slow
def test_derivative_of_a_multiplier_of_an_unsymmetric_stiffness():
    """A column under a dead load, and a small one that follows: by central differences."""

    def multiplier(bending):
        b = fm.Builder()
        for i in range(3):
            b.node(f"n{i}", (0.5 * i, 0.0))
        for i in range(2):
            b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e6, EIy=bending * (1 + i)))
        b.fix("n0")
        b.force("n2", (-1.0, 0.0))
        b.force("n1", (-0.2, 0.0), follower=True)
        return fm.buckling_loads(b.build())[0]

    @fm.jit
    def both(bending):
        (value, reverse), forward = jax.value_and_grad(multiplier)(bending), jax.jacfwd(multiplier)(bending)
        return value, reverse, forward

    step = 1e-4
    wanted = (both(1.0 + step)[0] - both(1.0 - step)[0]) / (2 * step)
    # Multipliers are good to 1e-9 or so, over the step.
    np.testing.assert_allclose(both(1.0)[1:], [wanted, wanted], rtol=1e-4)


def of_two_beams(force, increment):
    """Euler's column of length 1 along x, a force on its end."""
    b = fm.Builder()
    for i in range(3):
        b.node(f"n{i}", (0.5 * i, 0.0))
    for i in range(2):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e5, EIy=1.0))
    b.fix("n0")
    b.force("n2", force, increment=increment)
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize(("increment", "moves"), [(False, True), (True, True), (True, False), (False, False)])
def test_loads_that_move_a_mechanism_far_before_it_buckles_are_told(increment, moves):
    """A force across a column bends it long before it buckles, one along it does not."""
    model = of_two_beams((-0.1, 0.1 * moves), increment)
    with pytest.warns(fm.FlexmbWarning, match="Linear buckling neglects") if moves else contextlib.nullcontext():
        loads = fm.buckling_loads(model)
    for function in (fm.buckling_loads, fm.buckling):
        with pytest.warns(fm.FlexmbWarning, match="Linear buckling neglects") if moves else contextlib.nullcontext():
            function(model, count=1, sparse=True)
    # Euler's column of length 1, by two beams; the force across it bends it at first already.
    assert 0.1 * float(loads[0]) == approx(np.pi**2 / 4, rel=0.04)


@pytest.mark.slow("True")
@pytest.mark.parametrize("increment", [False, True])
def test_loads_that_bend_a_mechanism_as_they_are_are_told(increment):
    """Multipliers of all loads are about the state under them, those of increments about the mechanism without."""
    model = of_two_beams((-1.8, 0.06), increment)
    for options in ({}, {"count": 1, "sparse": True}):
        with contextlib.nullcontext() if increment else pytest.warns(fm.FlexmbWarning, match="At load factor 1, these"):
            fm.buckling_loads(model, **options)


@pytest.mark.slow
def test_a_state_of_a_path_is_asked_about_as_it_lies():
    model = of_two_beams((-1.8, 0.06), False)
    path = fm.path(model, step=0.5)
    # It bears more than it has; no warning, which would be an error here.
    assert float(fm.buckling_loads(model, at=path, step=-1)[0]) > 1


def bars(count, length, increment=False):
    """In a row along x, pulled."""
    b = fm.Builder()
    b.node("n0", (0.0, 0.0))
    for i in range(count):
        b.node(f"n{i + 1}", (length * (i + 1), 0.0))
        b.add(planar.truss, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=94.5))
        b.fix(f"n{i + 1}", "y")
    b.fix("n0")
    b.force(f"n{count}", (1.0, 0.0), increment=increment)
    return b.build()


LENGTHS = [0.3, 1.1, 0.123, 1 / 7]


@pytest.mark.slow
@pytest.mark.parametrize("length", LENGTHS)
@pytest.mark.parametrize("count", [1, 3])
def test_bars_along_their_own_axis_have_no_multiplier(length, count):
    """Their curvature along the axis is the difference of two equal numbers, and what is left of it is round-off."""
    model = bars(count, length)
    assert np.all(np.isinf(fm.buckling_loads(model)))
    assert len(fm.buckling(model).multipliers) == 0
    about = multipliers_about(model.topology, model.parameters, fm.linearize(model).matrices)
    assert np.all(np.isinf(about))
    assert np.all(np.isinf(fm.buckling_loads(model, count=1, sparse=True)))


@pytest.mark.slow
@pytest.mark.parametrize("length", LENGTHS)
@pytest.mark.parametrize("count", [1, 3])
def test_bars_have_no_multiplier_of_an_increment_and_over_a_stroke(length, count):
    assert np.all(np.isinf(fm.buckling_loads(bars(count, length, increment=True))))
    curves = fm.verdict(bars(count, length), {f"n{count}.x": length / 10}, steps=1).curves
    assert np.all(np.isinf(curves["buckling"]))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Prestress of element")
@pytest.mark.parametrize("along", [0.0, 900.0])
def test_an_increment_of_prestress_that_is_held_has_no_multiplier(along):
    """What is added to the stress of an elongation that is held moves nothing."""
    section = fm.Rigidity(EA=1e6, EIy=0.03)
    b = fm.Builder()
    for i in range(3):
        b.node(f"n{i}", (0.05 * i, 0.0))
    for i in range(2):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"l{i}", section=section, released=(2, 3))
        b.prestress(f"l{i}", elongation=-100.0, increment=True)
    b.fix("n0")
    b.fix("n2", "y")
    b.mass("n1", 0.05)
    b.gravity((along, -9.81))
    model = b.build()
    assert np.all(np.isinf(fm.buckling_loads(model)))
    assert np.all(np.isinf(fm.buckling_loads(model, count=1, sparse=True)))
