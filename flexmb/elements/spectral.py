"""Spectral beams: geometrically exact beams whose strains are Legendre series along a whole leaf spring.

The coordinates that such a beam owns are the coefficients of its strains; they are its elastic deformations too. The
pose of end q follows from that of end p by quadrature of the kinematics, and its difference from node q, the closure,
is the part of the deformations that stays FIXED; the closure comes first, then one strain field after the other. The
error falls exponentially with the order (benchmarks/large_deflection.py).

Section resultants at a place are those of statics: force and moment at q and what acts on the mass beyond the place.

Names: p and q are the ends, ``rot_p`` and ``rot_q`` their rotations, c the coefficients.
"""

import dataclasses
import functools

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_flag, check_whole
from ..math.linear import multiplied
from ..math.quadrature import (
    gauss,
    integration_matrix,
    legendre_coefficients,
    legendre_integrals,
    legendre_integrals_at,
    legendre_values,
    legendre_values_at,
    lobatto,
)
from ..math.rigid import exponential, product, products, screws
from ..math.rotation import CROSS, initial_frame, rotation_matrix, rotation_plane
from . import beams
from .element import Element
from .nodes import Angle, Internal, Point2, Point3, Rotation3
from .sections import Damping, Section

# Coefficients of a strain field, at most: beyond it compiling takes minutes, and round-off is reached long before.
LARGEST_ORDER = 40


@dataclasses.dataclass(frozen=True)
class _Layout:
    """Order of a spectral beam's deformations: the closure, then ``order`` coefficients of each strain field.

    Coordinates have the order of the fields.
    """

    closure: int
    fields: int
    order: int

    def __post_init__(self):
        if not 1 <= self.order <= LARGEST_ORDER:
            raise ValueError(f"order must be at least 1 and at most {LARGEST_ORDER}, but is {self.order}.")

    @property
    def size(self) -> int:
        """Number of coefficients."""
        return self.fields * self.order

    @property
    def numbers(self) -> tuple[tuple[int, ...], ...]:
        """Numbers (from 1) of each field's deformations."""
        firsts = range(self.closure + 1, self.closure + self.size + 1, self.order)
        return tuple(tuple(range(first, first + self.order)) for first in firsts)

    @property
    def released(self) -> tuple[int, ...]:
        """Numbers of all fields' deformations."""
        return tuple(n for field in self.numbers for n in field)

    def deformations(self, closure, c):
        """Deformations of closure and coefficients."""
        return jnp.concatenate([closure, c])

    def diagonal(self, rigidities, length):
        """Matrix of constant rigidities by length; the integral of a squared polynomial P_k is 1/(2k + 1)."""
        own = jnp.stack([jnp.asarray(r, float) for r in rigidities])[:, None] / length
        own = own / (2.0 * np.arange(self.order) + 1)
        return jnp.diag(jnp.concatenate([jnp.zeros(self.closure), own.ravel()]))


def _closure_of(sigma, count: int):
    """Force and moment at q among the stress resultants."""
    return sigma[:count]


def _beyond(coefficients: np.ndarray, loads, place):
    """Integral from a place to the end of loads per length that are known at nodes, by their Legendre coefficients."""
    n = coefficients.shape[0]
    to_the_end = np.eye(n)[0] - legendre_integrals_at(n, place)
    return to_the_end @ (coefficients @ loads)


def _turn(lever, force):
    """Moment of forces in the plane, counter-clockwise."""
    return lever[..., 0] * force[..., 1] - lever[..., 1] * force[..., 0]


# Fields of the planar beam, in the order of its coefficients.
ELONGATION, CURVATURE = 0, 1


def _arc_length(chord, half):
    """Length of an arc over a chord; ``half`` is half the curvature times the chord."""
    return chord * jnp.arcsin(half) / half


def _check_planar(*, ref, curvature: float | None = None) -> list[str]:
    return beams.check_length(ref=ref) or _check_curvature(ref, None if curvature is None else np.abs(curvature))


def _check_curvature(ref, size) -> list[str]:
    if size is None:
        return []
    half = np.asarray(size) * np.linalg.norm(np.asarray(ref.q) - np.asarray(ref.p), axis=-1) / 2
    if not np.all((half > 0) & (half <= 1)):
        return ["has an initial curvature that no arc between its ends has: it must not be zero, nor above 2/chord"]
    return []


def planar_beam(order: int = 5) -> Element:
    """Planar geometrically exact beam, one for a whole leaf spring, without shear deformation.

    Deformations: 1 to 3 the closure at q, FIXED: two displacements in axes of end p [m] and the angle [rad]; then
    ``order`` coefficients of each strain, times length: elongation [m], curvature [rad], the first of which is the
    angle between the ends. Stress resultants of the closure are the force and moment at q.
    Properties: section (EA, EIy, mass, Jy), damping, curvature (initial, of an arc from p to q [1/m], positive
    counter-clockwise).

    Args:
        order: Number of coefficients of each strain; 2 bends as a cubic beam does, 5 gives six digits for a leaf
            spring at a large stroke.

    Source:
        Strains of the extensible elastica; theta(s) = integral of the curvature, r' = (1 + eps)(cos theta, sin theta).
    """
    return _planar_beam(check_whole("order", order))


# The defaults are filled in before: one element for all ways to ask for it, so that its blocks and code are shared.
@functools.cache
def _planar_beam(order: int) -> Element:
    layout = _Layout(closure=3, fields=2, order=order)
    nodes, weights = gauss(2 * order + 8)
    values, angles = legendre_values(order, nodes), legendre_integrals(order, nodes)
    along, coefficients = integration_matrix(nodes), legendre_coefficients(nodes)

    def line(rot_p, c, ref, curvature):
        """Length, axes of end p as columns, directions and stretched directions at the nodes in those axes."""
        length, tilt = _length(ref, curvature), 0.0
        if curvature is not None:
            tilt = curvature * length / 2
        x = rotation_plane(rot_p[0] - ref.rot_p[0] - tilt) @ ((ref.q - ref.p) / beams.beam_length(ref))
        axes = jnp.stack([x, jnp.stack([-x[1], x[0]])], axis=1)
        directions = bent(c, length, curvature, nodes, angles)
        return length, axes, directions, (length + values @ c.reshape(2, order)[ELONGATION])[:, None] * directions

    def bent(c, length, curvature, s, integrals):
        """Directions at places s, in axes of end p, (n, 2)."""
        angle = integrals @ c.reshape(2, order)[CURVATURE]
        if curvature is not None:
            angle = angle + curvature * length * s
        return jnp.stack([jnp.cos(angle), jnp.sin(angle)], axis=-1)

    def to_place(c, length, curvature, place):
        """Directions and stretches at the nodes of the quadrature from p to a place, and at the place itself."""
        on_the_way = place * np.append(nodes, 1.0)
        directions = bent(c, length, curvature, on_the_way, legendre_integrals_at(order, on_the_way))
        return directions, length + legendre_values_at(order, on_the_way) @ c.reshape(2, order)[ELONGATION]

    def _spectral_beam(
        p: Point2,
        rot_p: Angle,
        q: Point2,
        rot_q: Angle,
        c: Internal(layout.size, 2),  # pyright: ignore[reportInvalidTypeForm]
        *,
        ref,
        curvature: float | None = None,
    ) -> Float[Array, "n_e"]:
        _, axes, _, stretched = line(rot_p, c, ref, curvature)
        displacement = axes.T @ (q - p) - weights @ stretched
        turn = (rot_q - ref.rot_q) - (rot_p - ref.rot_p) - c[order : order + 1]
        return layout.deformations(jnp.concatenate([displacement, turn]), c)

    def _length(ref, curvature):
        chord = beams.beam_length(ref)
        return chord if curvature is None else _arc_length(chord, curvature * chord / 2)

    def _stiffness(*, ref, section: Section, curvature: float | None = None):
        s = section.rigidity()
        return layout.diagonal([s.EA, s.EIy], _length(ref, curvature))

    def _damping(*, ref, damping: Damping, curvature: float | None = None):
        return layout.diagonal([damping.EA, damping.EIy], _length(ref, curvature))

    def _inertia(
        p: Point2,
        rot_p: Angle,
        q: Point2,
        rot_q: Angle,
        c: Internal(layout.size, 2),  # pyright: ignore[reportInvalidTypeForm]
        *,
        ref,
        section: Section,
        curvature: float | None = None,
    ):
        s = section.rigidity()
        length, axes, directions, stretched = line(rot_p, c, ref, curvature)
        positions = p + along @ stretched @ axes.T
        masses = jnp.concatenate([s.mass * length * weights, s.Jy * length * weights])
        return jnp.concatenate([positions, directions @ axes.T]), jnp.diag(masses)

    def _resultants(
        p: Point2,
        rot_p: Angle,
        q: Point2,
        rot_q: Angle,
        c: Internal(layout.size, 2),  # pyright: ignore[reportInvalidTypeForm]
        *,
        ref,
        place,
        sigma,
        section: Section,
        fall=None,
        curvature: float | None = None,
    ) -> Float[Array, "6"]:
        length, axes, _, _ = line(rot_p, c, ref, curvature)
        directions, stretched = to_place(c, length, curvature, place)
        reached = place * (weights * stretched[:-1]) @ directions[:-1]
        # Force, and moment about p, of all that is beyond the place; counter-clockwise, in axes of end p.
        force, moment = jnp.split(_closure_of(sigma, 3), (2,))
        wrench = jnp.append(force, moment + _turn(axes.T @ (q - p), force))
        if fall is not None:
            vectors, h = _inertia(p, rot_p, q, rot_q, c, ref=ref, section=section, curvature=curvature)
            pulls, turning = jnp.split(h @ fall @ axes, 2)
            positions, normals = jnp.split(vectors @ axes, 2)
            moments = _turn(positions - axes.T @ p, pulls) + _turn(normals, turning)
            loads = jnp.concatenate([pulls, moments[:, None]], axis=1) / weights[:, None]
            wrench = wrench + _beyond(coefficients, loads, place)
        (x, y), bending = wrench[:2], wrench[2] - _turn(reached, wrench[:2])
        cosine, sine = directions[-1]
        # The section's own y axis points into the plane: a moment about it turns clockwise.
        zero = jnp.zeros_like(x)
        return jnp.stack([cosine * x + sine * y, zero, cosine * y - sine * x, zero, -bending, zero])

    def _shape(
        p: Point2,
        rot_p: Angle,
        q: Point2,
        rot_q: Angle,
        c: Internal(layout.size, 2),  # pyright: ignore[reportInvalidTypeForm]
        *,
        ref,
        place,
        curvature: float | None = None,
    ) -> Float[Array, "2"]:
        length, axes, _, _ = line(rot_p, c, ref, curvature)
        directions, stretched = to_place(c, length, curvature, place)
        return p + axes @ (place * (weights * stretched[:-1]) @ directions[:-1])

    return Element(
        _spectral_beam,
        stiffness=_stiffness,
        damping=_damping,
        inertia=_inertia,
        resultants=_resultants,
        shape=_shape,
        check=_check_planar,
        released=layout.released,
        fields=layout.numbers,
    )


def _check_spatial(*, ref, y: Float[Array, "3"] | None = None, curvature: Float[Array, "3"] | None = None) -> list[str]:
    size = None if curvature is None else np.linalg.norm(np.asarray(curvature), axis=-1)
    faults = beams.check_length(ref=ref) or beams.check_across(ref, y) or _check_curvature(ref, size)
    if not faults and curvature is not None and np.any(np.asarray(curvature)[..., 0] != 0):
        return ["has an initial twist, the first component of its curvature: only plane arcs are provided for"]
    return faults


def spatial_beam(order: int = 5, shear: bool = False) -> Element:
    """Spatial geometrically exact beam, one for a whole leaf spring.

    Deformations: 1 to 6 the closure at q, FIXED: three displacements [m] and three tilts [rad] in axes of end p and of
    end q; then ``order`` coefficients of each strain, times length: elongation [m], twist, curvature about local y,
    curvature about local z [rad], with ``shear`` also the shears along y and along z [m]. Stress resultants of the
    closure are the force and moment at q.
    Properties: section, damping, y (vector that fixes local y), curvature (initial, (0, about y, about z) in local
    axes, of an arc from p to q [1/m]).

    Args:
        order: Number of coefficients of each strain.
        shear: Whether shear deformation is counted; the section must then have a shear compliance.

    Source:
        Strains of Simo (1985) and Reissner: r' = R (1 + eps, gamma_y, gamma_z), R' = R hat(kappa); poses by the
        exponentials of :mod:`flexmb.math.rigid`.
    """
    check_flag("shear", shear)
    return _spatial_beam(check_whole("order", order), bool(shear))


@functools.cache
def _spatial_beam(order: int, shear: bool) -> Element:
    layout = _Layout(closure=6, fields=6 if shear else 4, order=order)
    steps = 8 * 2 ** max(0, int(np.ceil(np.log2(order / 6))))
    ends, weights = lobatto(steps + 1)
    coefficients = legendre_coefficients(ends)
    lengths = np.diff(ends)
    inner = ends[:-1, None] + lengths[:, None] * gauss(3)[0]
    # Six-vectors (twist, curvatures, stretch, shears) of the fields, and the rigidity that each works against.
    places = np.eye(6)[[3, 0, 1, 2, 4, 5][: layout.fields]]
    whole = np.einsum("pk,fs->psfk", legendre_values(order, inner.ravel()), places)

    def strains(c, length, curvature, place=1.0, basis=whole):
        """Screw motions of the steps from end p to a place, with the polynomials on the way to it."""
        own = (basis.reshape(-1, layout.size) @ c).reshape(-1, 6) / length + np.array([0.0, 0, 0, 1, 0, 0])
        if curvature is not None:
            own = own + jnp.concatenate([curvature, jnp.zeros(3)])
        return exponential(screws(own.reshape(steps, 3, 6) * (length * place), lengths))

    def on_the_way(place):
        """The polynomials at the nodes on the way to a place, as strains, (nodes, 6, fields, order)."""
        return jnp.einsum("pk,fs->psfk", legendre_values_at(order, place * inner.ravel()), places)

    def _length(ref, curvature):
        chord = beams.beam_length(ref)
        if curvature is None:
            return chord
        return _arc_length(chord, beams.length(curvature) * chord / 2)

    def frames(rot_p, rot_q, ref, y, curvature, length):
        """Section axes at both ends as columns."""
        frame = initial_frame(ref.p, ref.q, y)
        at_p = multiplied(rotation_matrix(rot_p), rotation_matrix(ref.rot_p).T @ frame)
        at_q = multiplied(rotation_matrix(rot_q), rotation_matrix(ref.rot_q).T @ frame)
        if curvature is None:
            return at_p, at_q
        half = exponential(jnp.concatenate([curvature * length / 2, jnp.zeros(3)])[None])[0, :3, :3]
        return at_p @ half.T, at_q @ half

    def _spectral_beam(
        p: Point3,
        rot_p: Rotation3,
        q: Point3,
        rot_q: Rotation3,
        c: Internal(layout.size, 3),  # pyright: ignore[reportInvalidTypeForm]
        *,
        ref,
        y: Float[Array, "3"] | None = None,
        curvature: Float[Array, "3"] | None = None,
    ) -> Float[Array, "n_e"]:
        length = _length(ref, curvature)
        at_p, at_q = frames(rot_p, rot_q, ref, y, curvature, length)
        pose = product(strains(c, length, curvature))
        displacement = jnp.sum(at_p * (q - p)[:, None], axis=0) - pose[:3, 3]
        between = multiplied(multiplied(at_p, pose[:3, :3]).T, at_q)
        tilt = 0.5 * jnp.sum(CROSS * between.T, axis=(1, 2))
        return layout.deformations(jnp.concatenate([displacement, tilt]), c)

    def _stiffness(*, ref, section: Section, curvature: Float[Array, "3"] | None = None):
        s = section.rigidity()
        rigidities = [s.EA, s.GIt, s.EIy, s.EIz]
        if shear:
            rigidities += [s.EIz / s.shear_y, s.EIy / s.shear_z]
        return layout.diagonal(rigidities, _length(ref, curvature))

    def _damping(*, ref, damping: Damping, curvature: Float[Array, "3"] | None = None):
        d = damping
        return layout.diagonal([d.EA, d.GIt, d.EIy, d.EIz] + [0.0] * (layout.fields - 4), _length(ref, curvature))

    def _inertia(
        p: Point3,
        rot_p: Rotation3,
        q: Point3,
        rot_q: Rotation3,
        c: Internal(layout.size, 3),  # pyright: ignore[reportInvalidTypeForm]
        *,
        ref,
        section: Section,
        y: Float[Array, "3"] | None = None,
        curvature: Float[Array, "3"] | None = None,
    ):
        s, length = section.rigidity(), _length(ref, curvature)
        at_p, _ = frames(rot_p, rot_q, ref, y, curvature, length)
        poses = jnp.concatenate([jnp.eye(4)[None], products(strains(c, length, curvature))])
        turned = multiplied(at_p, poses[:, :3])
        vectors = jnp.concatenate([p + turned[:, :, 3], jnp.swapaxes(turned[:, :, :3], 1, 2).reshape(-1, 3)])
        moments = beams.combine([s.Jx, s.Jy, s.Jz, s.Jyz], beams.SECOND_MOMENTS)
        n = steps + 1
        h = jnp.zeros((4 * n, 4 * n)).at[:n, :n].set(s.mass * np.diag(weights))
        return vectors, length * h.at[n:, n:].set(jnp.kron(np.diag(weights), moments))

    def _resultants(
        p: Point3,
        rot_p: Rotation3,
        q: Point3,
        rot_q: Rotation3,
        c: Internal(layout.size, 3),  # pyright: ignore[reportInvalidTypeForm]
        *,
        ref,
        place,
        sigma,
        section: Section,
        fall=None,
        y: Float[Array, "3"] | None = None,
        curvature: Float[Array, "3"] | None = None,
    ) -> Float[Array, "6"]:
        length = _length(ref, curvature)
        at_p, at_q = frames(rot_p, rot_q, ref, y, curvature, length)
        pose = product(strains(c, length, curvature, place, on_the_way(place)))
        # Force, and moment about p, of all that is beyond the place, in axes of end p.
        force, moment = jnp.split(_closure_of(sigma, 6), 2)
        moment = at_p.T @ (at_q @ moment) + jnp.cross(at_p.T @ (q - p), force)
        if fall is not None:
            vectors, h = _inertia(p, rot_p, q, rot_q, c, ref=ref, section=section, y=y, curvature=curvature)
            pulls = h @ fall @ at_p
            levers = jnp.concatenate([vectors[: steps + 1] - p, vectors[steps + 1 :]]) @ at_p
            moments = jnp.cross(levers, pulls)
            moments = moments[: steps + 1] + jnp.sum(moments[steps + 1 :].reshape(-1, 3, 3), axis=1)
            loads = jnp.concatenate([pulls[: steps + 1], moments], axis=1) / weights[:, None]
            force, moment = jnp.stack([force, moment]) + _beyond(coefficients, loads, place).reshape(2, 3)
        moment = moment - jnp.cross(pose[:3, 3], force)
        return (jnp.stack([force, moment]) @ pose[:3, :3]).ravel()

    def _shape(
        p: Point3,
        rot_p: Rotation3,
        q: Point3,
        rot_q: Rotation3,
        c: Internal(layout.size, 3),  # pyright: ignore[reportInvalidTypeForm]
        *,
        ref,
        place,
        y: Float[Array, "3"] | None = None,
        curvature: Float[Array, "3"] | None = None,
    ) -> Float[Array, "3"]:
        length = _length(ref, curvature)
        at_p, _ = frames(rot_p, rot_q, ref, y, curvature, length)
        pose = product(strains(c, length, curvature, place, on_the_way(place)))
        return p + at_p @ pose[:3, 3]

    def _check(
        *,
        ref,
        section: Section | None = None,
        y: Float[Array, "3"] | None = None,
        curvature: Float[Array, "3"] | None = None,
    ) -> list[str]:
        faults = _check_spatial(ref=ref, y=y, curvature=curvature)
        if section is None:
            return faults
        s = section.rigidity()
        compliant = [np.asarray(number) > 0 for number in (s.shear_y, s.shear_z)]
        if shear and not np.all(compliant):
            faults.append("counts shear, but its section has none: give the section shear=True")
        if not shear and np.any(compliant):
            faults.append("does not count shear, but its section has it: make the element with shear=True")
        return faults

    return Element(
        _spectral_beam,
        stiffness=_stiffness,
        damping=_damping,
        inertia=_inertia,
        resultants=_resultants,
        shape=_shape,
        check=_check,
        released=layout.released,
        fields=layout.numbers,
    )
