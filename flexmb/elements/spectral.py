"""Spectral beams: geometrically exact beams whose strains are Legendre series along a whole leaf spring.

The inner coordinates of a spectral beam are the coefficients of its strains. They are also its elastic deformations.
The pose of end q follows from the pose of end p by quadrature of the kinematics. The closure is the difference from
node q; these deformations stay FIXED. The closure comes first, then the strain fields with ``order`` coefficients each.
The error falls exponentially with the order (benchmarks/large_deflection.py).

Section resultants at a place follow from statics: from force and moment at q, and from the loads beyond the place.

This module has the common parts of the beam in the plane (``spectral_planar``) and in space (``spectral_spatial``). p
and q are the ends, ``rot_p`` and ``rot_q`` their rotations, c the coefficients.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_floats, holds, is_concrete, library_of
from ..compilation.compile import traced_once
from ..math.quadrature import gauss, integration_matrix, legendre_integrals, legendre_values
from .curves import CurvedLine, arc_length, curve_length, faults_of_curve
from .nodes import Reference
from .profile import NODES, Profile, rigidity_at
from .section import Damping, Rigidity, Section

# Largest number of coefficients of a strain field: more take minutes to compile and only add round-off.
LARGEST_ORDER = 40


def fields_after(closure: int, count: int, order: int) -> tuple[tuple[int, ...], ...]:
    """Return the numbers (from 1) of the deformations of each strain field.

    Raises ValueError: The order is below 1, or beyond the largest.
    """
    if not 1 <= order <= LARGEST_ORDER:
        raise ValueError(f"order must be at least 1 and at most {LARGEST_ORDER}, but is {order}.")
    firsts = range(closure + 1, closure + count * order + 1, order)
    return tuple(tuple(range(first, first + order)) for first in firsts)


class BeamPieces(NamedTuple):
    """Smooth pieces of a beam, from its first end to a place.

    Attributes:
        starts: First place of each piece, (m,) [-].
        sizes: Size of each piece, (m,) [-]; zero for pieces beyond the place.
    """

    starts: Any
    sizes: Any

    def spread(self, nodes: np.ndarray) -> Float[Array, "m n"]:
        """Return the places of nodes on [0, 1] in each piece, (m, n)."""
        return self.starts[:, None] + self.sizes[:, None] * nodes

    def integrals(self, nodes: np.ndarray, weights: np.ndarray) -> Float[Array, "places places"]:
        """Return the matrix that integrates values at all nodes from 0 to each node, (m n, m n)."""
        m, n = self.sizes.shape[0], len(nodes)
        within = np.einsum("ij,ab->iajb", np.eye(m), integration_matrix(nodes))
        before = np.einsum("ij,b->ijb", np.tri(m, k=-1), weights)[:, None]
        return ((within + before) * self.sizes[:, None]).reshape(m * n, m * n)

    def beyond(self, coefficients: np.ndarray, loads: Float[Array, "m n k"], place: Float[Array, ""]):
        """Return the integral of loads at nodes from a place to the end, (k,)."""
        reached = (place - self.starts) / jnp.where(self.sizes > 0, self.sizes, 1.0)
        n = coefficients.shape[0]
        remaining = np.eye(n)[0] - legendre_integrals(n, jnp.clip(reached, 0.0, 1.0))
        return jnp.einsum("i,in,nm,imk->k", self.sizes, remaining, coefficients, loads)


WHOLE = BeamPieces(np.zeros(1), np.ones(1))


def pieces_of(section: Section | None, length: Float[Array, ""], end: Float[Array, ""] | None = None) -> BeamPieces:
    """Return the smooth pieces of a beam."""
    breaks = () if section is None else section.breaks_at(length)
    if not breaks and end is None:
        return WHOLE
    ends = jnp.stack([jnp.clip(place, 0.0, 1.0) for place in breaks] + [jnp.ones(())])
    ends = ends if end is None else jnp.minimum(ends, end)
    starts = jnp.concatenate([jnp.zeros(1), ends[:-1]])
    return BeamPieces(starts, ends - starts)


def rigidities(section: Section, places: Float[Array, "n"], length: Float[Array, ""], names: Sequence[str]):
    """Return rigidities and masses at places, (n, names).

    Args:
        names: Attributes of :class:`flexmb.Rigidity`; "GAy" and "GAz" are shear rigidities.
    """
    rigidity = _along(section, jnp.asarray(places), length) if section.varies else section.at(0.0, length).rigidity()
    columns = [jnp.broadcast_to(jnp.asarray(rigidity_of(rigidity, name), float), places.shape) for name in names]
    return jnp.stack(columns, axis=1)


@traced_once
def _along(section: Section, places: Float[Array, "n"], length: Float[Array, ""]) -> Rigidity:
    """Rigidities of a varying section at places, each (n,)."""
    return jax.vmap(lambda place: rigidity_at(section, place, length))(places)


def rigidity_of(s: Any, name: str):
    """Return an attribute of rigidities or damping; zero without this attribute."""
    if isinstance(s, Rigidity) and name.startswith("GA"):
        return s.EIz / s.shear_y if name == "GAy" else s.EIy / s.shear_z
    return getattr(s, name, 0.0)


def constant_rigidities(of: Section | Damping, names: Sequence[str]) -> Float[Array, "names"]:
    """Return rigidities of a section that does not vary, or damping rigidities."""
    constant = of.rigidity() if isinstance(of, Section) else of
    return jnp.stack([jnp.asarray(rigidity_of(constant, name), float) for name in names])


def strains(order: int, section: Section | None, places: Any, length: Float[Array, ""], names: Sequence[str]) -> Any:
    """Return strains times length at places, by each coefficient of each field.

    The strains of a section that does not vary are polynomials. In a section that varies, the stress resultants are
    polynomials, and the strains are polynomials times the local compliance over its mean. Returns (n, fields, order)
    [-]. Source: THEORY.md 2, eq. (2.11) and (2.21).
    """
    polynomials = legendre_values(order, places)
    if section is None or not section.varies:
        library: Any = jnp if isinstance(places, jax.Array) else np
        return library.broadcast_to(polynomials[:, None], (len(places), len(names), order))
    if isinstance(section, Profile):
        return relative(section, places, length, names)[:, :, None] * polynomials[:, None]
    return section.relative(places, length, names)[:, :, None] * polynomials[:, None]


def relative(
    section: Section, places: Float[Array, "n"], length: Float[Array, ""], names: Sequence[str]
) -> Float[Array, "n fields"]:
    """Return compliances at places over their means."""
    nodes, weights = gauss(NODES)
    pieces = pieces_of(section, length)
    mean = (pieces.sizes[:, None] * weights).ravel() @ _compliance(section, pieces.spread(nodes).ravel(), length, names)
    return _compliance(section, places, length, names) / mean


def _compliance(
    section: Section, places: Float[Array, "n"], length: Float[Array, ""], names: Sequence[str]
) -> Float[Array, "n fields"]:
    # A field without rigidity has strains without stress.
    stiff = rigidities(section, places, length, names)
    return 1.0 / jnp.where(stiff > 0, stiff, 1.0)


def series_matrix(
    of: Section | Damping,
    section: Section | None,
    order: int,
    length: Float[Array, ""],
    closure: int,
    names: Sequence[str],
) -> Array:
    """Return the stiffness or damping matrix between the coefficients.

    Args:
        of: The section for stiffness, or damping rigidities, which are constant along the beam.

    Returns:
        (n_e, n_e). The matrix of a section that does not vary is diagonal: the integral of a squared polynomial P_k is
        1/(2k + 1).
    """
    if section is None or not section.varies:
        blocks = constant_rigidities(of, names)[:, None] / length / (2.0 * np.arange(order) + 1)
        return jnp.diag(jnp.concatenate([jnp.zeros(closure), blocks.ravel()]))
    nodes, weights = gauss(NODES)
    pieces = pieces_of(section, length)
    places = pieces.spread(nodes).ravel()
    elastic = isinstance(of, Section)
    stiff = rigidities(of, places, length, names) if elastic else constant_rigidities(of, names)
    shapes = strains(order, section, places, length, names)
    weighted = (pieces.sizes[:, None] * weights).ravel()[:, None] * stiff / length
    blocks = jnp.einsum("nf,nfj,nfk->fjk", weighted, shapes, shapes)
    full = jnp.einsum("fjk,fg->fjgk", blocks, np.eye(len(names))).reshape(2 * (blocks.shape[0] * order,))
    return jnp.pad(full, (closure, 0))


def thermal_series(
    change: Float[Array, "2"],
    bends: dict[str, Any],
    section: Section,
    order: int,
    length: Float[Array, ""],
    closure: int,
    names: Sequence[str],
) -> Float[Array, "n_e"]:
    """Return the deformations of a free beam by temperature: the series fit the strains with the least elastic energy.

    For constant strains, and for linear strains with at least two coefficients, the pose of the last end is exact to
    first order, for every section. Returns (n_e,) [m, rad]. Source: THEORY.md 2, eq. (2.31) and (2.33).

    Args:
        bends: Curvature over the coefficient of thermal expansion, by the name of its rigidity, () [K/m].
    """
    pieces = pieces_of(section, length)
    nodes, weights = gauss(NODES if isinstance(section, Profile) else order + 1)
    places = pieces.spread(nodes).ravel()
    shapes, weights = strains(order, section, places, length, names), (pieces.sizes[:, None] * weights).ravel()
    along = {"EA": change[0] + places * (change[1] - change[0]), **bends}
    by_field = jnp.stack([jnp.broadcast_to(along.get(name, 0.0), places.shape) for name in names], axis=1)
    wanted = length * rigidities(section, places, length, ("alpha",)) * by_field
    if not isinstance(section, Profile):
        coefficients = (2.0 * np.arange(order) + 1)[:, None] * ((weights[:, None] * shapes[:, 0]).T @ wanted)
        return jnp.concatenate([jnp.zeros(closure), coefficients.T.ravel()])
    weighted = (weights[:, None] / _compliance(section, places, length, names))[:, :, None] * shapes
    matrix, right = (jnp.einsum("nfj,nf...->fj...", weighted, values) for values in (shapes, wanted))
    return jnp.concatenate([jnp.zeros(closure), jnp.linalg.solve(matrix, right[:, :, None]).ravel()])


def check_curvature(ref: Reference, curvature: Any, y: Any = None) -> list[str]:
    """Return the faults of an initial curvature, which is None for a straight beam."""
    if curvature is None:
        return []
    if isinstance(curvature, CurvedLine):
        return faults_of_curve(ref, curvature, y)
    curvature = as_floats(curvature)
    size = abs(curvature) if curvature.ndim < ref.q.ndim else library_of(curvature).linalg.norm(curvature, axis=-1)
    if curvature.ndim == ref.q.ndim and not holds(curvature[..., 0] == 0):
        return ["has an initial twist, the first of its three numbers: give curvature_along a function with this twist"]
    half = size * _chord(ref) / 2
    if not holds((half > 0) & (half <= 1)):
        return ["has an initial curvature that no arc between its ends has: it must not be zero, nor above 2/chord"]
    return []


def section_rigidities(section: Section, ref: Reference, curvature: Any) -> Rigidity:
    """Return the rigidities of a section; at places along the beam if it varies."""
    if not isinstance(section, Profile):
        return section.rigidity()
    length = _length(ref, curvature)
    known = is_concrete((section, length))
    return section.along(length).rigidity if known else section.sections_along(length).rigidity()


def check_section(section: Section | None, ref: Reference, curvature: Any, count: int = NODES) -> list[str]:
    """Return the faults of a varying section along the beam.

    Args:
        count: Least number of Gauss nodes of the beam in each smooth piece.
    """
    return section.faults_along(_length(ref, curvature), count) if isinstance(section, Profile) else []


def check_shear(counted: bool, *stated: Any) -> list[str]:
    """Return the faults of a section whose shear the beam does not count, or that lacks the shear compliance."""
    if counted and not all(holds(as_floats(number) > 0) for number in stated):
        return ["counts shear, but its section has none: give the section shear=True"]
    if not counted and not all(holds(as_floats(number) <= 0) for number in stated):
        return ["does not count shear, but its section has it: make the element with shear=True"]
    return []


def _chord(ref: Reference) -> Any:
    across = as_floats(ref.q) - as_floats(ref.p)
    return library_of(across).linalg.norm(across, axis=-1)


def _length(ref: Reference, curvature: Any) -> Any:
    chord = _chord(ref)
    if curvature is None:
        return chord
    if isinstance(curvature, CurvedLine):
        length: Any = curve_length
        for _ in range(np.ndim(chord)):
            length = jax.vmap(length)
        return as_floats(length(chord, curvature))
    curvature = as_floats(curvature)
    size = abs(curvature) if np.ndim(curvature) == chord.ndim else library_of(curvature).linalg.norm(curvature, axis=-1)
    return as_floats(arc_length(jnp.asarray(chord), jnp.asarray(size * chord / 2)))
