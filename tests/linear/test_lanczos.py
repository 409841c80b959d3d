"""What iterations answer is checked: motions that are none are not handed on."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

import flexmb as fm
from flexmb.linear.sparse_spectrum import Constrained, change_by_iteration, check_converged
from flexmb.math.sparse import SparseFactors


def test_modes_that_are_none_are_refused():
    check_converged(np.array([1e-5]), "frequencies")
    for wrong in (1e-2, np.nan):
        with pytest.raises(fm.AnalysisError, match="The frequencies were not found by sparse factors"):
            check_converged(np.array([1e-5, wrong]), "frequencies")


def test_change_is_measured_beside_the_motion_itself():
    found = change_by_iteration(
        np.array([[0.0, 2.0], [1.0, 0.0]]), np.array([[3.0, 1.0], [0.0, 0.0]]), np.diag([4.0, 9.0])
    )
    np.testing.assert_allclose(found, [3 / 6, 4 / 2], rtol=1e-15)


def test_motions_that_constraints_leave_and_their_values():
    """Against the pencil in a null space by SciPy."""
    rng = np.random.default_rng(1)
    root, rows = rng.standard_normal((7, 7)), rng.standard_normal((2, 7))
    stiffness, other = root @ root.T + np.eye(7), np.diag(np.arange(-3.0, 4.0))
    tangent = scipy.sparse.csc_array(np.block([[stiffness, rows.T], [rows, np.zeros((2, 2))]]))
    values, motions = Constrained(tangent, 7, SparseFactors(tangent)).all_of_few(scipy.sparse.csc_array(other), 3)
    free = scipy.linalg.null_space(rows)
    exact = scipy.linalg.eigh(free.T @ other @ free, free.T @ stiffness @ free, eigvals_only=True)
    # Round-off of a condition of 1e2.
    np.testing.assert_allclose(values, exact[np.argsort(-np.abs(exact))][:3], rtol=1e-10)
    np.testing.assert_allclose(rows @ motions, 0.0, atol=1e-10)
    np.testing.assert_allclose(motions.T @ stiffness @ motions, np.eye(3), atol=1e-10)


@pytest.mark.parametrize(("count", "advice"), [(1, "Ask for more"), (3, "Ask for fewer")])
def test_a_search_that_does_not_converge_says_why_and_what_to_try(count, advice):
    stiffness = scipy.sparse.diags_array(np.linspace(1.0, 2.0, 60)).tocsc()
    at = Constrained(stiffness, 60, SparseFactors(stiffness))
    mass = scipy.sparse.eye_array(60).tocsc()
    with pytest.raises(fm.AnalysisError, match=rf"did not converge. .* {advice}, or give sparse=False") as fault:
        at.searched(mass, count, None, np.ones(60), which="LA", ncv=count + 2, maxiter=1, tol=1e-14)
    assert fault.value.code == "not_converged"
