"""Which designs no other design is better than in everything that is asked."""

import numpy as np
from jaxtyping import Bool, Float

# Designs that are compared with the front at a time: some MiB of comparisons.
BLOCK = 512


def nondominated(costs: Float[np.ndarray, "n k"]) -> Bool[np.ndarray, "n"]:
    """Designs that no other one dominates: one that is no worse in any cost and better in at least one.

    Equal designs dominate one another not, so that all of them stay.

    Source:
        Definition. Sorted by one cost after the other, a design is dominated by earlier ones alone; if by any, by one
        of the front so far, since whoever dominates that one dominates it too. So n times the size of the front pairs
        are compared.
    """
    different, places = np.unique(costs, axis=0, return_inverse=True)
    front = different[:0]
    good = np.zeros(len(different), bool)
    for first in range(0, len(different), BLOCK):
        block = different[first : first + BLOCK]
        # Sorted and without equals: whoever comes earlier and is no worse in anything is better in something.
        open_ = ~_no_worse(front, block).any(axis=0)
        candidates = np.flatnonzero(open_)
        own = _no_worse(block[candidates], block[candidates])
        np.fill_diagonal(own, val=False)
        kept = candidates[~own.any(axis=0)]
        good[first + kept] = True
        front = np.concatenate([front, block[kept]])
    return good[places.ravel()]


def _no_worse(some: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Whether each of some is in nothing worse than each of the others, (some, others)."""
    found = np.ones((len(some), len(others)), bool)
    for a, b in zip(some.T, others.T, strict=True):
        found &= a[:, None] <= b
    return found
