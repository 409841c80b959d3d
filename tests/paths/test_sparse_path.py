"""Paths by sparse factors: those of the dense path with all their critical points, and a closed form."""

import numpy as np
import pytest
import scipy.sparse.linalg
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.results import RESULTS


def arch(beams=8, load=(0.0, -160.0), rise=0.1, sparse=False, preload=None, follower=False, travel=None, **options):
    """A shallow sine arch between hinges, pressed in its middle: it bends aside before it snaps through.

    Where it is given a travel, that is prescribed in place of a load.
    """
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(f"n{i}", (i / beams, rise * np.sin(np.pi * i / beams)))
    section = fm.Rigidity(EA=1e4, EIy=1.0, mass=1.0)
    for i in range(beams):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"b{i}", section=section, **options)
    b.fix("n0", "position")
    b.fix(f"n{beams}", "position")
    if travel is None:
        b.force(f"n{beams // 2}", load, increment=preload is not None, follower=follower)
    else:
        b.prescribe(f"n{beams // 2}", "y", travel)
    if preload is not None:
        b.force(f"n{beams // 2}", preload)
    return b.build(check=not sparse)


# A force that turns with the middle of the arch has no potential: its tangent is not symmetric.
FOLLOWING = {"follower": True, "load": (4.0, -160.0)}
ASIDE = {"follower": True}
# An element's stiffness couples what is released with what is held: half a beam's bending.
HALF = {"beams": 4, "released": (1, 2)}
# The state follows what is prescribed, and the force that does so falls and turns its sign.
DRIVEN = {"beams": 4, "travel": -0.18}


@pytest.mark.slow
@pytest.mark.parametrize(
    "case", [{}, {"released": (2, 3), "rise": 0.05}, {"preload": (0.5, -1.0)}, HALF, ASIDE, FOLLOWING, DRIVEN]
)
def test_a_path_by_sparse_factors_is_that_of_dense_matrices(case):
    # Both are Newton's method to round-off; a state between two others is known to half the digits at bifurcations.
    dense, sparse = fm.path(arch(**case)), fm.path(arch(**case, sparse=True), sparse=True)
    # Whether a step is taken again may hang on round-off, after the first ones.
    for i in (*range(10), -1):
        np.testing.assert_allclose(sparse.load_factor[i], dense.load_factor[i], rtol=1e-9, atol=1e-10)
        np.testing.assert_allclose(sparse.x[i], dense.x[i], atol=1e-10)
        np.testing.assert_allclose(sparse.e[i], dense.e[i], atol=1e-10)
        np.testing.assert_allclose(sparse.sigma[i], dense.sigma[i], rtol=1e-7, atol=1e-6)
        assert sparse.stable[i] == dense.stable[i]
    assert len(dense.critical_points) > 1 or case
    have_the_same_critical_points(sparse, dense)
    if case is HALF:
        have_the_same_poles_at_them(sparse, dense)


def have_the_same_critical_points(sparse, dense):
    assert [p.kind for p in sparse.critical_points] == [p.kind for p in dense.critical_points]
    for one, other in zip(sparse.critical_points, dense.critical_points, strict=True):
        assert one.load_factor == approx(other.load_factor, rel=1e-9)
        np.testing.assert_allclose(one.phi, other.phi, atol=1e-6)


def have_the_same_poles_at_them(sparse, dense):
    # There a pole is zero but for the root of round-off, which must not hide the others.
    for i in range(len(sparse.critical_points)):
        wanted, found = (fm.poles(of.model, count=4, at=of.at_critical_points(), step=i) for of in (dense, sparse))
        np.testing.assert_allclose(np.sort(np.abs(found)), np.sort(np.abs(wanted)), rtol=1e-7, atol=1e-3)


@pytest.mark.slow
def test_what_is_driven_and_half_held_goes_through_the_same_critical_points():
    """Steps hang on round-off, where they go and where they end does not."""
    dense, sparse = (fm.path(arch(**{**HALF, **DRIVEN}, sparse=of), sparse=of) for of in (False, True))
    assert len(dense.critical_points) > 1
    have_the_same_critical_points(sparse, dense)
    have_the_same_poles_at_them(sparse, dense)
    np.testing.assert_allclose(sparse.x[-1], dense.x[-1], atol=1e-10)
    np.testing.assert_allclose(sparse.sigma[-1], dense.sigma[-1], rtol=1e-7, atol=1e-6)


def frame(bays, floors, load, sparse, **options):
    """Storeys of columns and beams, pressed from above: columns sway together and against each other."""
    b = fm.Builder()
    section = fm.Rigidity(EA=1e4, EIy=(10 / floors) ** 2, mass=1.0)
    for i in range(bays + 1):
        for j in range(floors + 1):
            b.node(f"n{i}_{j}", (i / floors, j / floors))
    for i in range(bays + 1):
        for j in range(floors):
            b.add(planar.beam, f"n{i}_{j}", f"n{i}_{j + 1}", section=section, **options)
            if i < bays:
                b.add(planar.beam, f"n{i}_{j + 1}", f"n{i + 1}_{j + 1}", section=section)
        b.fix(f"n{i}_0")
        b.force(f"n{i}_{floors}", (0.0, -load))
    return b.build(check=not sparse)


@pytest.mark.slow
@pytest.mark.parametrize("options", [{}, {"released": (2, 3)}])
def test_a_frame_loses_its_stiffness_again_and_again(options):
    # More negative values than the path tells. Their number is that of the pivots; where columns cannot be shortened,
    # and rows of their constraints change places, of those of a congruent matrix.
    dense = fm.path(frame(3, 5, 1000.0, False, **options))
    sparse = fm.path(frame(3, 5, 1000.0, True, **options), sparse=True)
    assert len(dense.critical_points) > 4
    assert [p.kind for p in sparse.critical_points] == [p.kind for p in dense.critical_points]
    for one, other in zip(sparse.critical_points, dense.critical_points, strict=True):
        assert one.load_factor == approx(other.load_factor, rel=1e-9)
    negative = [np.sum(np.linalg.eigvalsh(k) < 0) for k in np.asarray(dense.K0 + dense.N0 + dense.G0)]
    np.testing.assert_array_equal(sparse.negative, negative)
    np.testing.assert_array_equal(sparse.stable, np.array(negative) == 0)


@pytest.mark.slow
def test_an_arch_begins_bent_and_without_stress():
    # Beams that cannot be shortened, whatever the size of the mode.
    how: dict = {"imperfection": {1: -0.02}, "stop": {"load_factor": 0.02}}
    path = fm.path(arch(beams=4, released=(2, 3), rise=0.05, sparse=True), sparse=True, **how)
    moved = np.asarray(path.x[0]) - np.asarray(path.model.parameters.reference)
    assert np.max(np.abs(moved)) > 0.015
    np.testing.assert_allclose(np.asarray(path.e[0])[np.asarray(path.model.topology.e.held)], 0, atol=1e-12)
    # Round-off of elongations, 1e-16, times EA.
    assert np.max(np.abs(path.sigma[0])) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(("imperfection", "at", "atol"), [({1: -0.05}, 0, 0.05**2), ({1: 1e-6, 2: -1e-6}, -1, 1e-10)])
def test_a_frame_begins_bent_as_by_dense_matrices(imperfection, at, atol):
    # Which of the states next to the moved one is taken makes a difference of the square of the motion.
    how: dict = {"imperfection": imperfection, "stop": {"load_factor": 0.05}}
    dense, sparse = (fm.path(frame(1, 2, 1000.0, of, released=(2, 3)), sparse=of, **how) for of in (False, True))
    assert type(sparse).__name__ == "SparsePath"
    np.testing.assert_allclose(sparse.x[at], dense.x[at], atol=atol)


@pytest.mark.slow
@pytest.mark.parametrize("side", [1, -1])
def test_post_buckling(side):
    # A2, closed form, at a turn of the tip of 40 degrees; cubic beams converge with order two, 1e-2 (1/n)^2 measured.
    ratio, x, y = 1.0636632664, 0.8812035117, 0.4222403401
    errors = []
    for beams in (16, 32):
        b = fm.Builder()
        for i in range(beams + 1):
            b.node(f"n{i}", (i / beams, 0.0))
        for i in range(beams):
            b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e6, EIy=1.0), released=(2, 3))
        b.fix("n0")
        b.force(f"n{beams}", (-ratio * np.pi**2 / 4, 0.0))
        path = fm.path(b.build(check=False), sparse=True, switch=side)
        (critical,) = path.critical_points
        assert critical.kind == "bifurcation"
        assert ratio * critical.load_factor == approx(1, rel=1e-4)
        assert path.stable[-1]
        errors.append(np.max(np.abs(path.at(f"n{beams}")[-1] - np.array([x, side * y]))))
    assert errors[0] / errors[1] == approx(4, rel=0.2)
    assert errors[1] < 2e-3


@pytest.mark.slow
def test_where_a_sparse_path_ends():
    model = arch(sparse=True)
    path = fm.path(model, sparse=True, stop={"n4.y": -0.05})
    assert path.stopped_by == "n4.y"
    assert float(path.at("n4")[-1, 1]) == approx(0.1 - 0.05, abs=1e-12)
    with pytest.raises(fm.AnalysisError, match="allowed number of steps") as caught:
        fm.path(model, sparse=True, max_steps=3)
    assert len(caught.value.path.load_factor) == 4
    assert "bifurcation at 0.10299" in repr(caught.value.path)


@pytest.mark.slow
def test_what_a_sparse_path_refuses():
    with pytest.raises(fm.ModelError, match="without a shape, and has no stress"):
        fm.path(arch(sparse=True), sparse=True, stop={"stress": 1e6})
    b = fm.Builder()
    b.node("ceiling", (0.0, 0.0))
    b.node("bob", (0.0, -1.0))
    b.add(planar.truss, "ceiling", "bob", section=fm.Rigidity(EA=1e3))
    b.fix("ceiling")
    b.force("bob", (1.0, -1.0))
    # Without stress it has no stiffness across.
    with pytest.raises(fm.AnalysisError, match="has no stiffness"):
        fm.path(b.build(check=False), sparse=True)


@pytest.mark.slow
def test_multipliers_about_a_path_without_a_potential_are_refused_by_name():
    path = fm.path(arch(beams=4, sparse=True, follower=True), sparse=True, stop={"load_factor": 0.05})
    with pytest.raises(fm.ModelError, match="loads that follow a body"):
        fm.buckling_loads(path.model, count=2, at=path, step=-1)


@pytest.mark.slow
def test_iterations_that_find_no_critical_values_are_named(monkeypatch):
    calls, eigsh = [], scipy.sparse.linalg.eigsh

    def lost(*given, **how):
        calls.append(how)
        if len(calls) < 3:
            return eigsh(*given, **how)
        raise scipy.sparse.linalg.ArpackNoConvergence("No convergence (240 iterations).", np.zeros(0), np.zeros((0, 0)))

    monkeypatch.setattr("scipy.sparse.linalg.eigsh", lost)
    model = arch(beams=12, sparse=True)
    with pytest.raises(fm.AnalysisError, match=r"Take other steps.*sparse=False") as caught:
        fm.path(model, sparse=True)
    assert caught.value.code == "not_converged"
    assert len(caught.value.path.load_factor) == 2
    calls.clear()
    found = fm.path(model, sparse=True, throw=False)
    assert int(found.result) == RESULTS.not_converged
    np.testing.assert_allclose(found.load_factor, caught.value.path.load_factor, rtol=1e-12)


def strut(load, moment, sparse, beams=4):
    """A column with a moment about a fixed axis at its end."""
    section = fm.Rigidity(EA=1e6, EIy=1.0, EIz=100.0, GIt=1.0, mass=1.0, Jx=0.1)
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(f"n{i}", (i / beams, 0, 0))
    for i in range(beams):
        b.add(spatial.beam, f"n{i}", f"n{i + 1}", section=section, y=(0, 1, 0))
    b.fix("n0")
    b.force(f"n{beams}", (-load, 0, 0))
    b.moment(f"n{beams}", (0, 0, moment))
    return b.build(check=not sparse)


@pytest.mark.slow
@pytest.mark.parametrize(("load", "moment"), [(0.3 * np.pi**2, 0.0), (0.0, 4.0)])
def test_divergence_and_flutter_are_those_of_dense_matrices(load, moment):
    """Weak axis at pi^2 EI/4 by the sign of the determinant; a pair that turns complex, which that does not tell."""
    dense = fm.path(strut(load, moment, False), sparse=False)
    found = fm.path(strut(load, moment, True), sparse=True)
    np.testing.assert_allclose(found.x, dense.x, atol=1e-9)
    np.testing.assert_array_equal(found.stable, dense.stable)
    assert found.stable[0]
    assert not found.stable[-1]
    assert [p.kind for p in found.critical_points] == [p.kind for p in dense.critical_points]
    for one, other in zip(found.critical_points, dense.critical_points, strict=True):
        assert one.load_factor == approx(other.load_factor, rel=1e-9)
    if load:
        (critical,) = found.critical_points
        assert 1.2 * critical.load_factor == approx(1, rel=1e-4)
    else:
        assert set(found.negative.tolist()) == {0}
