"""Coefficients of the Rosenbrock method against its order conditions."""

import numpy as np
from cases.tolerances import approx

from flexmb.motion.stages import RODAS5P


def test_order_conditions_of_the_coefficients():
    # Hairer, Wanner (1996), Solving Ordinary Differential Equations II, table IV.7.1, in the form with full gammas: all
    # of order one to four, and those of order five without the Jacobian. In the form of the code the weights are those
    # of the stages times the inverse of (1/gamma - c).
    gamma = np.linalg.inv(np.eye(8) / RODAS5P.gamma - RODAS5P.c)
    alpha, weights = RODAS5P.a @ gamma, RODAS5P.m @ gamma
    both = alpha + gamma
    place, total = alpha.sum(axis=1), both.sum(axis=1)
    conditions = {
        "1": (weights.sum(), 1),
        "2": (weights @ total, 1 / 2),
        "3a": (weights @ place**2, 1 / 3),
        "3b": (weights @ both @ total, 1 / 6),
        "4a": (weights @ place**3, 1 / 4),
        "4b": (weights @ (place * (alpha @ total)), 1 / 8),
        "4c": (weights @ both @ place**2, 1 / 12),
        "4d": (weights @ both @ both @ total, 1 / 24),
        "5a": (weights @ place**4, 1 / 5),
        "5b": (weights @ both @ place**3, 1 / 20),
    }
    for name, (found, expected) in conditions.items():
        # Coefficients of sixteen digits, whose sums have terms up to a hundred.
        assert found == approx(expected, abs=1e-11), name
    # The last stage is the solution, so that constraints hold at the end of a step.
    np.testing.assert_allclose(both[-1], weights, rtol=0, atol=1e-12)
