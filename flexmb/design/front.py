"""Pareto front: designs that no other design beats in all criteria."""

import numpy as np
from jaxtyping import Bool, Float

# Number of designs compared with the front at once: some MiB.
BLOCK = 512


def nondominated(costs: Float[np.ndarray, "n k"]) -> Bool[np.ndarray, "n"]:
    """Designs that no other design dominates: that is, none is as good in all costs and better in one cost.

    Sorted by the costs, a design can be dominated only by earlier designs. If it is dominated, a design of the front so
    far dominates it. The number of compared pairs is therefore n times the size of the front. Equal designs all stay.
    """
    different, places = np.unique(costs, axis=0, return_inverse=True)
    front = different[:0]
    good = np.zeros(len(different), bool)
    for first in range(0, len(different), BLOCK):
        block = different[first : first + BLOCK]
        # In this order without equals an earlier design that is no worse is better in one cost.
        open_ = ~_no_worse(front, block).any(axis=0)
        candidates = np.flatnonzero(open_)
        worse = _no_worse(block[candidates], block[candidates])
        np.fill_diagonal(worse, val=False)
        undominated = candidates[~worse.any(axis=0)]
        good[first + undominated] = True
        front = np.concatenate([front, block[undominated]])
    return good[places.ravel()]


def _no_worse(some: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Whether each of some is no worse in all costs than each of the others, (some, others)."""
    no_worse = np.ones((len(some), len(others)), bool)
    for a, b in zip(some.T, others.T, strict=True):
        no_worse &= a[:, None] <= b
    return no_worse
