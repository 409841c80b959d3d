"""Solvers of the linear equations of a mechanism: both against NumPy's answers, and how one is asked for."""

import dataclasses

import jax
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar
from flexmb.math.linear_solver import DENSE, SPARSE, LinearSolver
from flexmb.statics.solver_choice import asked_solver
from flexmb.statics.sparse import undeformed_elements

STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0)


def elements(fixed=True):
    """Two beams with a rigid body between them and an elongation that is held."""
    b = fm.Builder()
    for i, place in enumerate([(0, 0), (0.1, 0), (0.12, 0.03), (0.2, 0.1)]):
        b.node(f"n{i}", place)
    section = fm.Rectangle(0.01, 1e-3, STEEL)
    b.add(planar.beam, "n0", "n1", section=section, released=(2, 3))
    b.add(planar.rigid_body, "n1", "n2")
    b.add(planar.beam, "n2", "n3", section=section)
    if fixed:
        b.fix("n0")
    model = b.build(check=False)
    return jax.tree.map(np.asarray, undeformed_elements(model.topology, model.parameters))


@pytest.mark.parametrize("solver", [SPARSE, DENSE])
def test_solutions_are_those_of_the_whole_matrix(solver):
    given = elements()
    equations, whole = solver.factored(given), SPARSE.factored(given).matrix.toarray()
    assert isinstance(solver, LinearSolver)
    assert equations.regular
    right = np.random.default_rng(0).standard_normal((len(whole), 2)) * np.array([1.0, 1e-3])
    for transposed, matrix in ((False, whole), (True, whole.T)):
        exact = np.linalg.solve(matrix, right)
        size = np.max(np.abs(exact), axis=0)
        # Round-off of stiffnesses of 1e7 beside constraints of one.
        np.testing.assert_allclose(equations.solve(right, transposed) / size, exact / size, atol=1e-8)
    np.testing.assert_allclose(equations.solve(right[:, 0]), equations.solve(right)[:, 0], rtol=1e-8)


@pytest.mark.parametrize("solver", [SPARSE, DENSE])
def test_what_is_singular_or_negative_is_found(solver):
    assert not solver.factored(elements(fixed=False)).regular
    given = elements()
    assert solver.factored(given).negative() == 0
    # Without constraints and curvature a negative stiffness has as many negative eigenvalues as coordinates move.
    softened = given._replace(structural=[(r, c, -own) for r, c, own in given.structural])
    n, h = given.unknowns
    assert solver.factored(softened).negative() == n - h


def test_a_solver_is_asked_for_by_name_object_or_flag():
    assert asked_solver(None, None) is None
    for given in (dict(sparse=True, solver=None), dict(sparse=None, solver="sparse"), dict(sparse=True, solver=SPARSE)):
        assert asked_solver(**given) == SPARSE
    for given in (dict(sparse=False, solver=None), dict(sparse=False, solver="dense")):
        assert asked_solver(**given) == DENSE
    with pytest.raises(ValueError, match="contradict"):
        asked_solver(True, "dense")
    with pytest.raises(ValueError, match='"sparse" or "dense"'):
        asked_solver(None, "skyline")
    with pytest.raises(TypeError, match="LinearSolver"):
        asked_solver(None, 3)


@dataclasses.dataclass(frozen=True)
class Own:
    """A solver of someone else."""

    def factored(self, elements, mass=0.0, damping=0.0):
        return DENSE.factored(elements, mass, damping)


@pytest.mark.slow
def test_an_equilibrium_takes_a_solver_of_ones_own():
    b = fm.Builder()
    b.node("a", (0, 0))
    b.node("b", (0.1, 0))
    b.add(planar.beam, "a", "b", section=fm.Rectangle(0.01, 1e-3, STEEL), released=(2, 3))
    b.fix("a")
    b.force("b", (0, 1.0))
    model = b.build(check=False)
    own, sparse = (fm.equilibrium(model, solver=solver) for solver in (Own(), "sparse"))
    # Both iterate to 1e-9 of the extent, beyond which the error is its square.
    np.testing.assert_allclose(own.x, sparse.x, atol=1e-12)
    np.testing.assert_allclose(own.sigma, sparse.sigma, atol=1e-8)
    with pytest.raises(TypeError, match="here"):
        fm.limit_load(model, solver=Own())
