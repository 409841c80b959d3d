"""Where the entries of a mechanism's sparse matrices lie, found once for mechanisms whose elements join alike."""

import functools
import hashlib
from collections import OrderedDict
from typing import Any

import jax
import numpy as np

from ..arguments import check_flag
from ..math.sparse import LARGE, SparseFactors, SparsePattern
from ..model.model import Model
from ..model.topology import Topology

# Patterns of so many structures are kept.
MOST = 8


def by_sparse(model: Model, sparse: bool | None) -> bool:
    """Whether a model is solved by sparse factors: as is asked, or, where nothing is, as it is large.

    Args:
        sparse: What a public function was given.

    Raises:
        TypeError: It is neither a truth value nor None.
    """
    if sparse is None:
        return model.topology.n_x >= LARGE
    check_flag("sparse", sparse)
    return bool(sparse)


class Structure:
    """Patterns of the matrices of a mechanism, each found when first asked for.

    Attributes:
        free: Coordinates that move, ascending, (n,).
        fast: Coordinates that do not, (n_fast,).
        held: Deformations that are held, (h,).
    """

    def __init__(self, topology: Topology, falls: bool):
        """Prepare the patterns.

        Args:
            falls: Whether there is gravity, whose weight is part of the stiffness.
        """
        topology = jax.tree.map(np.asarray, topology)
        self.free, self.fast, self.held = np.sort(topology.x.free), topology.x.held, topology.e.held
        self._deforming = [(b.x, b.e) for b in topology.blocks if "deformation" in b.companions and b.e.shape[1]]
        self._heavy = [b.x for b in topology.blocks if "inertia" in b.companions]
        pulling = [b.x for b in topology.blocks if "force" in b.companions]
        self._stiff = [x for x, _ in self._deforming] + (self._heavy if falls else []) + pulling
        self._n_x, self._n_e = topology.n_x, topology.n_e
        self._at_free, self._at_fast = np.full(self._n_x, -1), np.full(self._n_x, -1)
        self._at_free[self.free], self._at_fast[self.fast] = np.arange(len(self.free)), np.arange(len(self.fast))
        self._at_held = np.full(self._n_e, -1)
        self._at_held[self.held] = len(self.free) + np.arange(len(self.held))

    @functools.cached_property
    def tangent(self) -> SparsePattern:
        """Of [[K, D^T], [D, 0]], by coordinates that move and multipliers: stiffness, D and D^T."""
        stiff = [(self._at_free[x], self._at_free[x]) for x in self._stiff]
        rows = [(self._at_held[e], self._at_free[x]) for x, e in self._deforming]
        n = len(self.free) + len(self.held)
        return SparsePattern((n, n), [*stiff, *rows, *((c, r) for r, c in rows)])

    @functools.cached_property
    def coupling(self) -> SparsePattern:
        """Of the same by the coordinates that do not move: stiffness and D."""
        stiff = [(self._at_free[x], self._at_fast[x]) for x in self._stiff]
        rows = [(self._at_held[e], self._at_fast[x]) for x, e in self._deforming]
        return SparsePattern((len(self.free) + len(self.held), len(self.fast)), [*stiff, *rows])

    @functools.cached_property
    def stiff(self) -> SparsePattern:
        """Of K alone."""
        n = len(self.free)
        return SparsePattern((n, n), [(self._at_free[x], self._at_free[x]) for x in self._stiff])

    @functools.cached_property
    def mass(self) -> SparsePattern:
        """Of the mass of the coordinates that move."""
        n = len(self.free)
        return SparsePattern((n, n), [(self._at_free[x], self._at_free[x]) for x in self._heavy])

    @functools.cached_property
    def jacobian(self) -> SparsePattern:
        """Of D_x, (n_e, n_x)."""
        return SparsePattern((self._n_e, self._n_x), [(e, x) for x, e in self._deforming])

    def bordered(self, stiff: Any, rows: Any) -> Any:
        """[[K, D^T], [D, 0]] of the elements' stiffnesses and of D, as :class:`Pieces` has them."""
        rows = [np.asarray(d) for d in rows]
        return self.tangent.matrix([*stiff, *rows, *(np.swapaxes(d, 1, 2) for d in rows)])

    def elastic_between(self, rows: Any, own: Any, left: Any, right: Any) -> Any:
        """Elastic stiffness between motions of the coordinates that move, (k, m): by their deformations.

        Args:
            rows: D of each block that deforms.
            own: Stress resultants by deformations of each.
            left: Motions, one a column, (n, k).
            right: Others, (n, m).
        """
        found, whole = np.zeros((left.shape[1], right.shape[1])), []
        for motions in (left, right):
            whole.append(np.zeros((self._n_x, motions.shape[1])))
            whole[-1][self.free] = motions
        for (x, _), d, stiffness in zip(self._deforming, rows, own, strict=True):
            before, behind = (np.asarray(d) @ motions[x] for motions in whole)
            found += np.tensordot(before, np.asarray(stiffness) @ behind, ((0, 1), (0, 1)))
        return found

    def elastic_forces(self, rows: Any, own: Any, motions: Any) -> Any:
        """Elastic forces on the coordinates that move, of motions of them, (n, k), by deformations.

        Args:
            rows, own: As of :meth:`elastic_between`.
            motions: One a column, (n, k).
        """
        whole, found = np.zeros((2, self._n_x, motions.shape[1]))
        whole[self.free] = motions
        for (x, _), d, stiffness in zip(self._deforming, rows, own, strict=True):
            d = np.asarray(d)
            np.add.at(found, x, np.swapaxes(d, 1, 2) @ (np.asarray(stiffness) @ (d @ whole[x])))
        return found[self.free]

    def independent(self, rows: Any) -> bool:
        """Whether the held deformations constrain independently, so that the multipliers are determined."""
        import scipy.sparse

        n = len(self.free)
        each = [np.zeros((*x.shape, x.shape[1])) for x in self._stiff]
        matrix = self.bordered(each, rows) + scipy.sparse.diags_array((np.arange(n + len(self.held)) < n).astype(float))
        return SparseFactors(matrix).regular


_known: OrderedDict[bytes, Structure] = OrderedDict()


def structure_of(topology: Topology, falls: bool) -> Structure:
    """Patterns of a mechanism, kept for others whose elements join the same nodes in the same roles.

    Args:
        falls: Whether there is gravity.
    """
    told = hashlib.blake2b(digest_size=16)
    told.update(repr((falls, *((b.companions, b.x.shape, b.e.shape) for b in topology.blocks))).encode())
    for leaf in jax.tree.leaves(topology):
        told.update(repr(leaf.shape).encode())
        told.update(np.asarray(leaf).tobytes())
    key = told.digest()
    structure = _known.pop(key, None) or Structure(topology, falls)
    _known[key] = structure
    if len(_known) > MOST:
        _known.popitem(last=False)
    return structure
