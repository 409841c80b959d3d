"""Functions that planar and spatial beams share: length, bending stiffness, mass of the cubic interpolation."""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from numpy.polynomial import polynomial

from ..arguments import as_floats, holds, library_of
from ..math.derivative import root_or_zero
from ..numerical_limits import PARALLEL, SHORTEST_ELEMENT
from .nodes import Reference, length
from .sections import Damping, Scalar, Section

# Mass of cubics in the end positions and end slopes times length, over m l / 420 (REFERENCES.md T4: axially too).
CUBIC_MASS = np.array([[156.0, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420
LINEAR_MASS = np.array([[2.0, 1], [1, 2]]) / 6
# Second moments tr(J)/2 I - J of an inertia tensor, for each of Jx, Jy, Jz, Jyz.
SECOND_MOMENTS = np.array([np.eye(3) / 2 - np.diag(np.arange(3) == k) for k in range(3)] + [np.zeros((3, 3))])
SECOND_MOMENTS[3, 1, 2] = SECOND_MOMENTS[3, 2, 1] = -1.0


# [[4 + Phi, -2 + Phi], [-2 + Phi, 4 + Phi]] = BENDING[0] + Phi BENDING[1]
BENDING = np.array([[[4.0, -2.0], [-2.0, 4.0]], [[1.0, 1.0], [1.0, 1.0]]])


def bending_coefficients(ei: Scalar, l0: Float[Array, ""], shear: Scalar) -> tuple:
    """Coefficients of :data:`BENDING` in the stiffness of one bending plane.

    S = EI/(l0^3 (1 + Phi)) [[4 + Phi, -2 + Phi], [-2 + Phi, 4 + Phi]], Phi = 12 EI/(GAk l0^2).

    Returns the two coefficients, () [N/m]. Source: Tutorial WA 1239 (2012), eq. (3.7), with Timoshenko's factor;
    THEORY.md 2, eq. (2.6) and (2.7).
    """
    phi = 12 * shear / l0**2
    first = ei / (l0**3 * (1 + phi))
    return first, first * phi


def bending_damping(eid: Scalar, gad: Scalar, l0: Float[Array, ""], shear: Scalar) -> tuple:
    """Coefficients of :data:`BENDING` in the damping of one bending plane, of which shear takes a share.

    Args:
        eid, gad: Damping rigidities of bending [N m^2 s] and of shear [N s].
        shear: EI/(GAk) [m^2].

    Returns the two coefficients, () [N s/m]. Source: THEORY.md 2, eq. (2.76).
    """
    phi = shear * 12 / l0**2
    first = (eid + phi * shear * gad) / (l0**3 * (1 + phi) ** 2)
    return first, eid / l0**3 - first


def combine(coefficients: Sequence[Scalar], matrices: np.ndarray) -> Float[Array, "n n"]:
    """Linear combination of constant matrices."""
    return jnp.tensordot(jnp.stack([jnp.asarray(c, float) for c in coefficients]), matrices, 1)


# Coefficients of (1 - tanh(u)/u)/u^2 in powers of u^2.
_TANH = np.array([1 / 3, -2 / 15, 17 / 315, -62 / 2835, 1382 / 155925, -21844 / 6081075, 929569 / 638512875])
# Up to this u^2 the series is exact to round-off and loses fewer digits than the quotient.
_SMALL = 0.03


def restrained_torsion(git: Scalar, eiw: Scalar, l0: Float[Array, ""]) -> tuple:
    """Torsional stiffness of a beam under constant torque with given warping of its ends.

    With u = (l0/2) sqrt(GIt/EIw) and t = tanh(u)/u, for the angle of twist and the twist rates of both ends times
    length:

    S = GIt/(l0 (1 - t)) [[1, -t/2, -t/2], [., a, b], [., ., a]],  a + b = t/2,  a - b = (1 - t)/(2 u^2 t).

    Returns the four coefficients, () [N m]: angle, angle and a warping, one warping, both warpings.

    Args:
        eiw: Warping rigidity, () [N m^4]. Zero means torsion without warping.

    Source:
        THEORY.md 2, eq. (2.34): the energy of the solution of GIt k - EIw k'' = constant for the twist rate k. A short
        beam has the energy of a cubic twist.
    """
    warps = jnp.asarray(eiw) > 0
    z = jnp.where(warps, git * l0**2 / (4 * jnp.where(warps, eiw, 1.0)), 1.0)
    small = z < _SMALL
    u = jnp.sqrt(jnp.where(small, 1.0, z))
    quotient = jnp.where(small, polynomial.polyval(jnp.where(small, z, 0.0), _TANH), (1 - jnp.tanh(u) / u) / u**2)
    t = 1 - z * quotient
    bimoment = eiw / l0**3
    twist = jnp.where(warps, 4 * bimoment / quotient, git / l0)
    # Zero without warping rigidity, like the stiffness of warping itself.
    coupling = jnp.where(warps, t / 2 * twist, 0.0)
    even, odd = coupling, 2 * bimoment / t
    return twist, -coupling, (even + odd) / 2, (even - odd) / 2


def bending_shortening(ends: Float[Array | np.ndarray, "*planes 2"], l0: Float[Array, ""]) -> Float[Array, "*planes"]:
    """Shortening of the chord by bending in one plane, second order: (2 ep^2 + ep eq + 2 eq^2)/(30 l0).

    Returns (*planes,) [m]. Source: Integral of half the squared slope of the cubic deflection with end slopes ep/l0 and
    -eq/l0.
    """
    return (3 * jnp.sum(ends**2, axis=-1) + jnp.sum(ends, axis=-1) ** 2) / (60 * l0)


def beam_length(ref: Reference) -> Float[Array, ""]:
    """Undeformed length of an element with end positions ``ref.p`` and ``ref.q``. Returns () [m]."""
    return length(ref.q - ref.p)


def truss(p: Float[Array, "d"], q: Float[Array, "d"], *, ref: Reference):
    """Elongation l - l0, (1,) [m]. Source: Tutorial WA 1239 (2012), eq. (2.8)."""
    return (length(q - p) - beam_length(ref))[None]


def truss_stiffness(*, ref: Reference, section: Section) -> Float[Array, "1 1"]:
    """Axial stiffness EA/l0, (1, 1) [N/m]; tutorial (2.11)."""
    return (section.rigidity().EA / beam_length(ref)).reshape(1, 1)


def truss_damping(*, ref: Reference, damping: Damping) -> Float[Array, "1 1"]:
    """Axial damping EdA/l0, (1, 1) [N s/m]; tutorial (2.12)."""
    return (damping.EA / beam_length(ref)).reshape(1, 1)


def thermal_elongation(change: Float[Array, "2"], length: Float[Array, ""], alpha: Scalar) -> Float[Array, ""]:
    """Elongation of a free bar by temperature, () [m]. Source: THEORY.md 2, eq. (2.32)."""
    return alpha * length * (change[0] + change[1]) / 2


def truss_thermal(change: Float[Array, "2"], *, ref: Reference, section: Section) -> Float[Array, "1"]:
    """Elongation by temperature, (1,) [m]."""
    return thermal_elongation(change, beam_length(ref), expansion_of(section))[None]


def expansion_of(section: Section | None, alpha: Scalar | None = None) -> Scalar:
    """Coefficient of thermal expansion, () [1/K]: of a section, unless the element states its own."""
    stated = alpha if alpha is not None or section is None else section.rigidity().alpha
    return 0.0 if stated is None else stated


def line_inertia(p: Float[Array, "d"], q: Float[Array, "d"], *, ref: Reference, section: Section):
    """Distributed mass with linear interpolation of the position, exact for a straight rigid line.

    Source: Integral of the linear shape functions: m l/6 [[2, 1], [1, 2]].
    """
    return jnp.stack([p, q]), section.rigidity().mass * length_or_zero(ref) * LINEAR_MASS


def point_drag(*, ref: Reference, damping: float) -> Array:
    """Drag of a point: one coefficient for all axes of space."""
    return jnp.diag(jnp.broadcast_to(damping, ref.p.shape))


def displacements(p: Array, q: Array, slopes: Array, start: Array, ref: Reference) -> Array:
    """Displacement and length times change of the axis at p, then at q: coordinates of the cubic along a beam."""
    # Equal operations on both, so that they are exactly zero in the undeformed mechanism.
    turned = beam_length(ref) * (slopes - start)
    return jnp.concatenate([p - ref.p, turned[0], q - ref.q, turned[1]])


def drag_by_length(*, ref: Reference, damping: float) -> Array:
    """Drag of a beam whose deflection is a cubic, consistent with its mass."""
    return jnp.kron(damping * beam_length(ref) * CUBIC_MASS, np.eye(ref.p.shape[0]))


def drag_laws(axes: str, by_length: bool) -> dict[str, Any]:
    """Companion, names and options of a drag, of a point or by length, along axes "xy" or "xyz"."""
    names = tuple(f"{what}{axis}_{end}" for end in "pq" for what in ("", "axis_") for axis in axes)
    own = {"damping": drag_by_length, "check": check_length} if by_length else {"damping": point_drag}
    names = names if by_length else tuple(axes)
    return {**own, "measured": tuple(range(1, len(names) + 1)), "grounded": True, "names": names}


def rigid_inertia(
    p: Array, q: Array, axes: Array, rotary: Sequence[Scalar], moments: np.ndarray, *, ref, section: Section
) -> tuple[Array, Array]:
    """Distributed mass of a rigid line from p to q, and rotary inertia of its sections.

    Args:
        axes: Axes of the body, one a row.
        rotary: Rotary inertias per length.
        moments: Their matrices between the axes.
    """
    line, h = line_inertia(p, q, ref=ref, section=section)
    turning = length_or_zero(ref) * combine(rotary, moments)
    return jnp.concatenate([line, axes]), jnp.pad(h, (0, len(axes))) + jnp.pad(turning, (2, 0))


def check_axis(*, ref: Reference, axis: Float[Array, "d"]) -> list[str]:
    """Faults of an axis."""
    return [] if holds((as_floats(axis) != 0).any(axis=-1)) else ["has an axis of zero length"]


def length_or_zero(ref: Reference) -> Float[Array, ""]:
    """Length of an element whose ends may lie in one place, with derivative zero there.

    Returns () [m].
    """
    return root_or_zero((ref.q - ref.p) @ (ref.q - ref.p))


def truss_resultants(p: Array, q: Array, *, ref, place, sigma, section, fall=None) -> Float[Array, "6"]:
    """Section resultants of a truss: normal force alone, (6,) [N, N m]."""
    normal = sigma[0]
    if fall is not None:
        mass = section.rigidity().mass * beam_length(ref)
        ends = (LINEAR_MASS @ fall) @ ((q - p) / length(q - p)) * np.array([1.0, -1.0])
        between, _ = distributed(LINEAR_SHAPES, fall, place)
        normal = normal + mass * (resultants_between_ends(ends, place) + between @ ((q - p) / length(q - p)))
    return jnp.concatenate([normal[None], jnp.zeros(5)])


# Shape functions as polynomials in the place, one row each, lowest power first. Linear: positions p and q. Cubic:
# position and slope at p, then at q.
LINEAR_SHAPES = np.array([[1.0, -1.0], [0.0, 1.0]])
CUBIC_SHAPES = np.array([[1.0, 0, -3, 2], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1]])


def distributed(
    shapes: np.ndarray, fall: Float[Array, "k d"], place: Float[Array, ""]
) -> tuple[Float[Array, "d"], Float[Array, "d"]]:
    """Force and moment that a distributed load adds to the linear interpolation between the ends of a straight beam.

    Returns:
        The force in the section, (d,), and a vector, (d,), both divided by the mass [m/s^2] and zero at both ends. The
        cross product of the chord q - p with that vector is the moment.

    Source:
        Balance of a piece: n' = -w, m'' = (q - p) x w for the place as variable. A uniform load on a bar of mass m
        gives the parabola of its fixed-end moments, place (place - 1)/2 m (q - p) x fall.
    """

    def inside(integrals: Any):
        """Polynomials that begin at zero minus the straight lines between their ends."""
        integrals[:, 1] -= np.sum(integrals, axis=1)
        return polynomial.polyval(place, integrals.T)

    once, twice = (polynomial.polyint(shapes, m, axis=1) for m in (1, 2))
    return -inside(once) @ fall, inside(twice) @ fall


def nodal_forces(deformation: Any, inertia: Any, nodes: Sequence[Array], sigma: Array, fall: Array | None) -> Any:
    """Nodal forces of the stress resultants less the nodal forces of distributed loads, by node."""
    pulls = jax.vjp(deformation, *nodes)[1](sigma)
    if fall is None:
        return pulls
    _, weight, h = jax.vjp(inertia, *nodes, has_aux=True)
    return jax.tree.map(jnp.subtract, pulls, weight(h @ fall))


def resultants_between_ends(ends: Float[Array | np.ndarray, "2 ..."], place: Float[Array, ""]) -> Float[Array, "..."]:
    """Section resultants between the two ends of a beam that carries no load in between.

    It is the equilibrium to first order in the deflection within one element: bending moments are linear, the other
    resultants constant. The values at the ends are exact. Returns (...) [N, N m].

    Args:
        ends: Resultants at the two ends, in axes of the section there, (2, ...) [N, N m].
    """
    return (1 - place) * ends[0] + place * ends[1]


def check_length(*, ref: Reference) -> list[str]:
    """Faults of an element with two end positions."""
    p, q = as_floats(ref.p), as_floats(ref.q)
    xp = library_of((p, q))
    # Equal positions computed in two ways, such as 3 * 0.05 and 0.15, differ by round-off.
    shortest = SHORTEST_ELEMENT * xp.max(xp.maximum(xp.abs(p), xp.abs(q)), axis=-1)
    if holds(xp.linalg.norm(q - p, axis=-1) > shortest):
        return []
    return ["has zero length: its two ends have the same position"]


def straight_shape(p: Array, rot_p: Array, q: Array, rot_q: Array, *, ref, place) -> Float[Array, "d"]:
    """Companion ``shape`` of a joint between two bodies: the straight line between its points."""
    return p + place * (q - p)


def point_inertia(p: Float[Array, "d"], *, ref: Reference, mass: float):
    """Companion ``inertia`` of a point mass."""
    return p[None], jnp.reshape(mass, (1, 1))


def check_mass(*, ref: Reference, mass: float) -> list[str]:
    """Faults of a point mass."""
    return [] if holds(as_floats(mass) >= 0) else [f"has a mass of {mass}, but it cannot be negative"]


def check_body_mass(mass: float) -> list[str]:
    """Faults of the mass of one body or of many."""
    return [] if holds(as_floats(mass) > 0) else [f"has a mass of {mass}, but it must be positive"]


def check_across(*, ref: Reference, y: Float[Array, "3"] | None = None) -> list[str]:
    """Faults of the vector that fixes the local y axis of an element with end positions ``ref.p`` and ``ref.q``."""
    if y is None:
        return []
    axis, across = as_floats(ref.q) - as_floats(ref.p), as_floats(y)
    xp = library_of((axis, across))
    size = xp.linalg.norm(across, axis=-1) * xp.linalg.norm(axis, axis=-1)
    if holds(xp.linalg.norm(xp.cross(axis, across), axis=-1) > PARALLEL * size):
        return []
    return ["has a local y vector that is zero or parallel to its axis: give one across it"]
