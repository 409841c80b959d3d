"""Tangent of the equations in all coordinates and one multiplier a constraint, sparse: its pattern, found once.

Element matrices are multiplied element by element where they are computed, so that the host only adds up.
"""

import functools
import hashlib
from collections import OrderedDict
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import jit
from ..math.indices import accumulate
from ..math.sparse import SparseFactors, SparsePattern
from ..mechanics.blocks import scatter_vector
from ..mechanics.deformation import curvature_pieces, jacobian_pieces
from ..mechanics.inertia import mass_pieces, weight_pieces
from ..mechanics.loads import LoadFactors, nodal_forces, scaled_loads
from ..mechanics.stress_resultants import stiffness_pieces, strain_of, stress_of_strain
from ..model.parameters import Parameters
from ..model.topology import Topology

# Patterns of so many structures are kept.
MOST = 8


def unknowns(topology: Topology) -> tuple[Array, Array, Array]:
    """Coordinates that move, coordinates that do not, and deformations that are held."""
    return jnp.sort(topology.x.free), topology.x.held, topology.e.held


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
        self.free, self.fast, self.held = (np.asarray(i) for i in unknowns(topology))
        deforming = [(b.x, b.e) for b in topology.blocks if "deformation" in b.companions and b.e.shape[1]]
        self._deforming = [(np.asarray(x), np.asarray(e)) for x, e in deforming]
        self._heavy = [np.asarray(b.x) for b in topology.blocks if "inertia" in b.companions]
        self._stiff = [x for x, _ in self._deforming] + (self._heavy if falls else [])
        self._n_x, self._n_e = topology.n_x, topology.n_e
        self._at_free, self._at_fast = np.full(self._n_x, -1), np.full(self._n_x, -1)
        self._at_free[self.free], self._at_fast[self.fast] = np.arange(len(self.free)), np.arange(len(self.fast))
        self._at_held = np.full(self._n_e, -1)
        self._at_held[self.held] = len(self.free) + np.arange(len(self.held))

    def _pairs(self, across: np.ndarray, coordinates: list[np.ndarray]) -> list[tuple[np.ndarray, np.ndarray]]:
        """Places of matrices of coordinates: by those that move, and by those of which ``across`` tells the place."""
        return [(self._at_free[x], across[x]) for x in coordinates]

    @functools.cached_property
    def tangent(self) -> SparsePattern:
        """Of [[K, D^T], [D, 0]], by coordinates that move and multipliers: stiffness, weight, D and D^T."""
        rows = [(self._at_held[e], self._at_free[x]) for x, e in self._deforming]
        of_k = self._pairs(self._at_free, self._stiff)
        n = len(self.free) + len(self.held)
        return SparsePattern((n, n), [*of_k, *rows, *((c, r) for r, c in rows)])

    @functools.cached_property
    def coupling(self) -> SparsePattern:
        """Of the same by the coordinates that do not move: stiffness, weight and D."""
        rows = [(self._at_held[e], self._at_fast[x]) for x, e in self._deforming]
        of_k = self._pairs(self._at_fast, self._stiff)
        return SparsePattern((len(self.free) + len(self.held), len(self.fast)), [*of_k, *rows])

    @functools.cached_property
    def geometric(self) -> SparsePattern:
        """Of the part of K that stress resultants and weight have."""
        n = len(self.free)
        return SparsePattern((n, n), self._pairs(self._at_free, self._stiff))

    @functools.cached_property
    def mass(self) -> SparsePattern:
        """Of the mass of the coordinates that move."""
        return SparsePattern((len(self.free), len(self.free)), self._pairs(self._at_free, self._heavy))

    @functools.cached_property
    def jacobian(self) -> SparsePattern:
        """Of D_x, (n_e, n_x)."""
        return SparsePattern((self._n_e, self._n_x), [(e, x) for x, e in self._deforming])


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
        told.update(np.ascontiguousarray(leaf))
    key = told.digest()
    structure = _known.pop(key, None) or Structure(topology, falls)
    _known[key] = structure
    if len(_known) > MOST:
        _known.popitem(last=False)
    return structure


@jit
def elastic_stress(topology: Topology, parameters: Parameters, factors: LoadFactors, e: Float[Array, "n_e"]):
    """Stress resultants of linear elements, without the multipliers of held deformations."""
    loads = scaled_loads(parameters, factors)
    sigma = stress_of_strain(topology, parameters, strain_of(topology, parameters, loads, e))
    return sigma if loads.prestress is None else sigma + loads.prestress


def stiffness_rows(topology: Topology, parameters: Parameters) -> Float[Array, "n_e widest"]:
    """Rows of the elements' stiffnesses, those of held deformations zero.

    Elements whose companions lie in another block than their deformation are found by the numbers of their
    deformations, which are in the same order there.
    """
    widest = max([b.e.shape[1] for b in topology.blocks], default=0)
    keep = jnp.ones(topology.n_e).at[topology.e.held].set(0.0)
    rows = jnp.zeros((topology.n_e, widest))
    for at, columns, matrices in stiffness_pieces(topology, parameters):
        matrices = matrices * keep[at][:, :, None] * keep[columns][:, None, :]
        rows = accumulate(rows, at, jnp.pad(matrices, ((0, 0), (0, 0), (0, widest - matrices.shape[2]))))
    return rows


@jit
def _pieces(topology: Topology, parameters: Parameters, factors: LoadFactors, x, near, sigma, *, mass: bool = False):
    """Element matrices for the host, with nodal forces and the stress that deformations have there."""
    values, jacobian = jacobian_pieces(topology, parameters, x, near)
    e = scatter_vector(topology.n_e, values)
    gravity = scaled_loads(parameters, factors).gravity
    rows = stiffness_rows(topology, parameters)
    geometric = [matrices for _, _, matrices in curvature_pieces(topology, parameters, x, near, sigma)]
    elastic = []
    for at, _, d in jacobian:
        s = rows[at][:, :, : at.shape[1]]
        elastic.append(jnp.einsum("eki,ekl,elj->eij", d, s, d))
    falling = [] if gravity is None else weight_pieces(topology, parameters, x, gravity)
    falling = [-matrices for _, _, matrices in falling]
    masses = [matrices for _, _, matrices in mass_pieces(topology, parameters, x)] if mass else None
    force = nodal_forces(topology, parameters, factors, x)
    stress = elastic_stress(topology, parameters, factors, e).at[topology.e.held].set(0.0)
    return [d for _, _, d in jacobian], elastic, geometric, falling, masses, e, stress, force


class Assembled:
    """Tangent of the equilibrium, and what belongs to it; each matrix is put together when first asked for.

    Attributes:
        structure: Patterns of the matrices.
        e: Deformations, (n_e,) [m, rad].
        sigma: Stress resultants without the multipliers, (n_e,) [N, N m].
        force: Nodal forces of the loads, (n_x,) [N, N m].
    """

    def __init__(self, structure: Structure, found: tuple):
        self.structure = structure
        self._rows, self._elastic, self._geometric, self._falling, self._masses, *rest = found
        self.e, self.sigma, self.force = (np.asarray(v) for v in rest)

    def _bordered(self, stiff: list[Any]) -> Any:
        """[[K, D^T], [D, 0]] of the elements' stiffnesses."""
        transposed = [np.swapaxes(np.asarray(d), 1, 2) for d in self._rows]
        return self.structure.tangent.matrix([*stiff, *self._rows, *transposed])

    @functools.cached_property
    def _stiff(self) -> list[Any]:
        pairs = zip(self._elastic, self._geometric, strict=True)
        return [np.asarray(elastic) + np.asarray(geometric) for elastic, geometric in pairs] + self._falling

    @functools.cached_property
    def tangent(self) -> Any:
        """Derivative by the coordinates that move and the multipliers, symmetric."""
        return self._bordered(self._stiff)

    @functools.cached_property
    def structural(self) -> Any:
        """The same without stress resultants and weight."""
        return self._bordered([*self._elastic, *(np.zeros_like(weight) for weight in self._falling)])

    def factors(self) -> SparseFactors:
        """Factors of the tangent, in an order of elimination that is found once for the mechanism."""
        return self.structure.tangent.factors(self.tangent)

    @functools.cached_property
    def coupling(self) -> Any:
        """Derivative by the coordinates that do not move."""
        return self.structure.coupling.matrix([*self._stiff, *self._rows])

    @functools.cached_property
    def geometric(self) -> Any:
        """Part of the tangent that stress resultants and weight have, of the coordinates that move."""
        return self.structure.geometric.matrix([*self._geometric, *self._falling])

    @functools.cached_property
    def mass(self) -> Any:
        """Mass of the coordinates that move, or None."""
        return None if self._masses is None else self.structure.mass.matrix(self._masses)

    @functools.cached_property
    def jacobian(self) -> Any:
        """D_x, (n_e, n_x)."""
        return self.structure.jacobian.matrix(self._rows)


def assemble(topology, parameters, factors, x, near, sigma, mass: bool = False) -> Assembled:
    """Tangent of the equilibrium at a state with stress resultants ``sigma``, on the host; with its mass if asked."""
    found = _pieces(topology, parameters, factors, *(jnp.asarray(v) for v in (x, near, sigma)), mass=mass)
    return Assembled(structure_of(topology, scaled_loads(parameters, factors).gravity is not None), found)
