"""Spatial elements: beams, joints, springs, lumped mass and rotary inertia; moments about fixed axes.

``help(spatial.beam)`` lists the deformations of an element in order, with units, and its properties and options.

- Flexible: truss, beam, warping_beam, spectral_beam, leaf_spring.
- Rigid: rigid_beam (pinned at its second end; pin_body is the same), rigid_body (clamped at both).
- Joints: hinge, slider, prismatic, screw. Transmissions: gear.
- Springs and dampers with a law of your own: spring_damper, rotary_spring_damper. Drag against the ground: drag (of a
  point), beam_drag (by length).
- Mass and loads: mass, inertia, body, moment (about fixed axes), follower_force, follower_moment.

Names: p and q are the ends, ``rot_p`` and ``rot_q`` the Euler parameters of their triads.
"""

import dataclasses
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_floats, holds, library_of
from ..lazy import only
from ..math.rotation import CROSS, initial_frame, lbar, relative_turn, turned
from ..numerical_limits import NEGLIGIBLE
from . import beams, joints, leaf_spatial, spectral_spatial
from .element import Element
from .nodes import Point3, Reference, Rotation3, Static, Warping
from .sections import Damping, Rigidity, Section
from .shared_laws import characteristic


def _truss(p: Point3, q: Point3, *, ref: Reference) -> Float[Array, "1"]:
    """Elongation, tutorial (2.8)."""
    return beams.truss(p, q, ref=ref)


truss = Element(
    _truss,
    stiffness=beams.truss_stiffness,
    damping=beams.truss_damping,
    inertia=beams.line_inertia,
    resultants=beams.truss_resultants,
    thermal=beams.truss_thermal,
    check=beams.check_length,
    names=("elongation",),
)
"""Bar that carries axial force only: e1 elongation [m]. Properties: section (EA, mass), damping."""


def _triads(rot_p: Rotation3, rot_q: Rotation3, ref: Reference, y: Float[Array, "3"] | None) -> Float[Array, "2 3 3"]:
    """Local axes at both ends as columns. One batched product serves both ends."""
    frame = initial_frame(ref.p, ref.q, y)
    rotations, references = jnp.stack([rot_p, rot_q]), jnp.stack([ref.rot_p, ref.rot_q])
    return jax.vmap(turned, (0, 0, None))(rotations, references, frame)


def _beam(
    p: Point3,
    rot_p: Rotation3,
    q: Point3,
    rot_q: Rotation3,
    *,
    ref: Reference,
    y: Float[Array, "3"] | None = None,
    second_order: Static[bool] = True,
) -> Float[Array, "6"]:
    """Elongation, torsion and four bendings of a spatial beam.

    Tutorial (4.1)-(4.6) with the second-order terms of THEORY.md 2, eq. (2.5): the shortening by bending, and the
    coupling of torsion with bending in two planes.
    """
    l0 = beams.beam_length(ref)
    triads = _triads(rot_p, rot_q, ref, y)
    chord = q - p
    # Local z and y at the ends, (planes, ends), and below the components of the chord along them.
    across = triads[:, :, :0:-1]
    twist = 0.5 * l0 * jnp.sum(across[0] * across[1, :, ::-1] * -SIGN)
    bending = -SIGN[:, None] * SIGN * jnp.sum(chord[:, None] * across, axis=1).T
    elongation = beams.length(chord) - l0
    if second_order:
        elongation = elongation + jnp.sum(beams.bending_shortening(bending, l0))
        coupled = jnp.sum(bending[0] * bending[1, ::-1] * SIGN) / l0
        ends = jnp.sum(bending, axis=1)[::-1] * SIGN
        bending = bending + twist / (6 * l0) * ends[:, None] * SIGN
        twist = twist + coupled
    return jnp.concatenate([jnp.stack([elongation, twist]), bending.reshape(-1)])


# Signs of the ends p and q in the bendings along local z. The bendings along local y have the opposite signs.
SIGN = np.array([-1.0, 1.0])


# Places of EA/l0, GIt/l0^3 and, for each bending plane, of the two coefficients of beams.bending_coefficients.
STIFFNESS = np.zeros((6, 6, 6))
STIFFNESS[0, 0, 0] = STIFFNESS[1, 1, 1] = 1.0
for _k, _at in ((2, slice(2, 4)), (4, slice(4, 6))):
    STIFFNESS[_k : _k + 2, _at, _at] = beams.BENDING


def _beam_stiffness(*, ref: Reference, section: Section) -> Float[Array, "6 6"]:
    s, l0 = section.rigidity(), beams.beam_length(ref)
    bending_y = beams.bending_coefficients(s.EIy, l0, s.shear_z)
    bending_z = beams.bending_coefficients(s.EIz, l0, s.shear_y)
    return beams.combine([s.EA / l0, s.GIt / l0**3, *bending_y, *bending_z], STIFFNESS)


def _beam_damping(*, ref, damping: Damping, section: Section | None = None) -> Float[Array, "6 6"]:
    d, l0, s = damping, beams.beam_length(ref), Rigidity() if section is None else section.rigidity()
    bending_y = beams.bending_damping(d.EIy, d.GAz, l0, s.shear_z)
    bending_z = beams.bending_damping(d.EIz, d.GAy, l0, s.shear_y)
    return beams.combine([d.EA / l0, d.GIt / l0**3, *bending_y, *bending_z], STIFFNESS)


# Mass per length and rotary inertias Jx, Jy, Jz, Jyz per length among the vectors (p, q, triad p, triad q). The cubic
# mass has slopes times length: CUBIC[k] goes with l0^k.
_PLACES = np.array([0, 2, 1, 5])  # p, x axis at p, q, x axis at q
CUBIC = np.zeros((3, 8, 8))
for _i in range(4):
    for _j in range(4):
        CUBIC[(_i % 2) + (_j % 2), _PLACES[_i], _PLACES[_j]] = beams.CUBIC_MASS[_i, _j]
ROTARY = np.zeros((4, 8, 8))
for _k in range(4):
    ROTARY[_k, 2:, 2:] = np.kron(beams.LINEAR_MASS, beams.SECOND_MOMENTS[_k])
INERTIA = np.concatenate([CUBIC, ROTARY])


def _beam_inertia(*nodes: Array, ref, section, y=None):
    """Cubic interpolation of the position along the beam, linear interpolation of the section's triad."""
    p, rot_p, q, rot_q = nodes
    s, l0 = section.rigidity(), beams.beam_length(ref)
    axes = jnp.swapaxes(_triads(rot_p, rot_q, ref, y), 1, 2).reshape(6, 3)
    vectors = jnp.concatenate([jnp.stack([p, q]), axes])
    mass = [s.mass, s.mass * l0, s.mass * l0**2]
    return vectors, l0 * beams.combine([*mass, s.Jx, s.Jy, s.Jz, s.Jyz], INERTIA)


def _beam_resultants(*nodes: Array, ref, place, sigma, section, second_order, fall=None, y=None) -> Float[Array, "6"]:
    """Nodal forces of the stress resultants less the nodal forces of distributed loads, in axes of the end sections.

    A force f dual to Euler parameters is the moment Lbar f / 2.
    """
    p, rot_p, q, rot_q = nodes
    triads = _triads(rot_p, rot_q, ref, y)
    deformation = partial(_beam, ref=ref, y=y, second_order=second_order)
    inertia = partial(_beam_inertia, ref=ref, section=section, y=y)
    force_p, dual_p, force_q, dual_q = beams.nodal_forces(deformation, inertia, nodes, sigma, fall)
    moments = jnp.stack([-lbar(rot_p) @ dual_p, lbar(rot_q) @ dual_q]) / 2
    vectors = jnp.stack([jnp.stack([-force_p, force_q]), moments], axis=1)
    resultants = beams.resultants_between_ends(vectors @ triads, place)
    if fall is not None:
        l0 = beams.beam_length(ref)
        # Slopes by place are axes times length.
        at_ends = fall[_PLACES] * jnp.stack([jnp.ones_like(l0), l0, jnp.ones_like(l0), l0])[:, None]
        force, lever = beams.distributed(beams.CUBIC_SHAPES, at_ends, place)
        inside = jnp.stack([force, (CROSS @ lever) @ (q - p)])
        resultants = resultants + section.rigidity().mass * l0 * inside @ beams.resultants_between_ends(triads, place)
    return resultants.ravel()


def _check_beam(*, ref, y=None) -> list[str]:
    return beams.check_length(ref=ref) or beams.check_across(ref=ref, y=y)


def _beam_thermal(change: Array, gradient: Array, *, ref, section) -> Float[Array, "6"]:
    """Elongation, and in both planes the bendings of an arc whose warmer side is longer."""
    l0, alpha = beams.beam_length(ref), beams.expansion_of(section)
    elongation = beams.thermal_elongation(change, l0, alpha)
    bent = alpha * l0**2 / 2 * gradient
    return jnp.stack([elongation, jnp.zeros_like(elongation), bent[1], bent[1], -bent[0], -bent[0]])


beam = Element(
    _beam,
    stiffness=_beam_stiffness,
    damping=_beam_damping,
    inertia=_beam_inertia,
    resultants=_beam_resultants,
    thermal=_beam_thermal,
    check=_check_beam,
    angles=(2, 3, 4, 5, 6),
    names=("elongation", "torsion", "bending_z_p", "bending_z_q", "bending_y_p", "bending_y_q"),
)
"""Flexible beam with cubic deflections between its ends.

Deformations:
    e1: elongation [m].
    e2: torsion [m]: angle of the end q relative to p about local x, times length.
    e3, e4: bending along local z at p and at q [m]: angle of the axis from the chord, times length. At p a rotation
        about local y counts as negative, at q as positive. In an arc e3 = e4.
    e5, e6: bending along local y at p and at q [m], with the same signs for rotations about local z.

Properties:
    section: Without a section the beam is rigid and has no mass.
    damping: Viscous damping of the section.
    y: Vector, (3,), that determines the local axes. Local x points from p to q. Local y is the direction of the
        component of y perpendicular to the beam, along the width of a rectangle. Local z is along the thickness, so
        that e3 and e4 are the soft bending of a leaf spring. Default: the global axis most nearly perpendicular to the
        beam.

Options: second_order (default True), whether the deformations include the second-order terms of bending and torsion.

Limits: A beam stretched by a strain bends with EI (1 + strain)^2 instead of EI, whatever the number of beams. Use a
spectral beam for strains beyond 1 %. The beam includes shear and restrained warping if its section does. ``build``
warns if neglected shear or warping would change a stiffness by more than 1 %. ``spatial.leaf_spring`` includes both,
and bending as a plate near clamps.
"""


def _warping_beam(
    p: Point3,
    rot_p: Rotation3,
    warp_p: Warping,
    q: Point3,
    rot_q: Rotation3,
    warp_q: Warping,
    *,
    ref: Reference,
    y: Float[Array, "3"] | None = None,
    second_order: Static[bool] = True,
) -> Float[Array, "8"]:
    """Deformations of ``spatial.beam``, then the twist rates of both ends times length."""
    deformations = _beam(p, rot_p, q, rot_q, ref=ref, y=y, second_order=second_order)
    return jnp.concatenate([deformations, beams.beam_length(ref) * jnp.concatenate([warp_p, warp_q])])


# Places of the coefficients of beams.restrained_torsion: the twist is e2/l0, the warpings are e7 and e8.
TORSION = np.zeros((4, 8, 8))
TORSION[0, 1, 1] = TORSION[2, 6, 6] = TORSION[2, 7, 7] = 1.0
TORSION[1, 1, 6:] = TORSION[1, 6:, 1] = TORSION[3, 6, 7] = TORSION[3, 7, 6] = 1.0


def _warping_stiffness(*, ref: Reference, section: Section) -> Float[Array, "8 8"]:
    """Stiffness of ``spatial.beam`` with restrained torsion."""
    s, l0 = section.rigidity(), beams.beam_length(ref)
    plain = _beam_stiffness(ref=ref, section=dataclasses.replace(s, GIt=0.0))
    twist, coupling, *warping = beams.restrained_torsion(s.GIt, s.EIw, l0)
    return jnp.pad(plain, (0, 2)) + beams.combine([twist / l0**2, coupling / l0, *warping], TORSION)


def _warping_damping(*, ref, damping: Damping, section: Section | None = None) -> Float[Array, "8 8"]:
    """Damping of ``spatial.beam``: warping has no damping."""
    return jnp.pad(_beam_damping(ref=ref, damping=damping, section=section), (0, 2))


def _warping_inertia(*nodes: Array, ref, section, y=None):
    """Inertia of ``spatial.beam``, and of the motion along the axis by warping, which is interpolated linearly."""
    p, rot_p, warp_p, q, rot_q, warp_q = nodes
    vectors, h = _beam_inertia(p, rot_p, q, rot_q, ref=ref, section=section, y=y)
    along = jnp.concatenate([warp_p, warp_q])[:, None] * np.eye(3)[:1]
    warping_mass = section.rigidity().Jw * beams.beam_length(ref) * beams.LINEAR_MASS
    n = h.shape[0]
    return jnp.concatenate([vectors, along]), jnp.pad(h, (0, 2)) + jnp.pad(warping_mass, (n, 0))


def _warping_resultants(
    *nodes: Array, ref, place, sigma, section, second_order, fall=None, y=None
) -> Float[Array, "6"]:
    """Resultants of ``spatial.beam``: a bimoment has no resultant."""
    p, rot_p, _, q, rot_q, _ = nodes
    options = {"section": section, "second_order": second_order, "y": y}
    fall = None if fall is None else fall[:-2]
    return _beam_resultants(p, rot_p, q, rot_q, ref=ref, place=place, sigma=sigma[:6], fall=fall, **options)


def _warping_thermal(change: Array, gradient: Array, *, ref, section) -> Float[Array, "8"]:
    """Thermal deformations of ``spatial.beam``."""
    return jnp.pad(_beam_thermal(change, gradient, ref=ref, section=section), (0, 2))


def _check_warping(*, ref, section=None, y=None, clamped: tuple[bool, bool] | bool | None = None) -> list[str]:
    faults = _check_beam(ref=ref, y=y)
    if section is None or faults:
        return faults
    if getattr(section, "warping_length", None) is not None:
        return ["has a section with warping_length, but it counts restrained warping itself: leave it out"]
    s = section.rigidity()
    if holds((as_floats(s.GIt) <= 0) | (as_floats(s.EIw) > 0)):
        return []
    return ["has a section without warping rigidity EIw, so that nothing resists its warping: give EIw, or use a beam"]


warping_beam = Element(
    _warping_beam,
    stiffness=_warping_stiffness,
    damping=_warping_damping,
    inertia=_warping_inertia,
    resultants=_warping_resultants,
    thermal=_warping_thermal,
    check=_check_warping,
    measured=(7, 8),
    angles=(2, 3, 4, 5, 6),
    names=(*beam.names, "warping_p", "warping_q"),
)
"""Flexible beam with a warping coordinate at each end: e1 to e6 as in ``spatial.beam``, e7 and e8 twist rates of the
ends times length [rad]. Warping beams and leaf springs that meet in a node share its warping coordinate.

Warping is zero at a clamped end and free elsewhere. An end is clamped if its rotation is FIXED or PRESCRIBED. A rigid
part, a hinge, a body or a part at least three times as thick clamps it too. The builder finds the clamped ends, as for
``spatial.leaf_spring``. Torsion is exact for a constant torque, so that one warping beam is enough for a leaf
spring that is only twisted. Do not use the element for strains beyond 1 %: see ``spatial.beam``.

Properties: section (with EIw: a :class:`flexmb.Rectangle` or a :class:`flexmb.Rigidity`), damping, y (vector that fixes
local y), clamped (whether warping is restrained at the first end and at the last, such as (True, False); by default
the builder finds the clamped ends).

Options: second_order, see ``spatial.beam``.

Source: THEORY.md 2, eq. (2.34).
"""


spectral_beam = spectral_spatial.spectral_beam
leaf_spring = leaf_spatial.leaf_spring


def _rigid_beam(p: Point3, rot_p: Rotation3, q: Point3, *, ref: Reference) -> Float[Array, "3"]:
    """Offset of q from its place on the body of p, in axes of the body at the undeformed state [m]."""
    return turned(rot_p, ref.rot_p, jnp.eye(3)).T @ (q - p) - (ref.q - ref.p)


def _rigid_thermal(
    change: Array, gradient: Array, *, ref, alpha: float | None = None, section=None, y=None
) -> Float[Array, "3"]:
    """Expansion of the offset, and the deflection of an arc whose direction at p is unchanged."""
    offset, expansion = ref.q - ref.p, beams.expansion_of(section, alpha)
    square = offset @ offset
    # A pinned body, whose ends lie in one place, has no axes.
    along = jnp.where(square > 0, offset, np.array([1.0, 0, 0]))
    across = square * initial_frame(jnp.zeros(3), along, y)[:, 1:] @ gradient
    return expansion * ((change[0] + change[1]) / 2 * offset - across / 2)


def _rigid_inertia(p: Array, rot_p: Array, q: Array, *_: Array, ref, section: Section, y=None):
    """Mass along the line, and rotary inertia of its sections on the axes of the body."""
    offset, s = ref.q - ref.p, section.rigidity()
    along = jnp.where(offset @ offset > 0, offset, np.array([1.0, 0, 0]))
    axes = turned(rot_p, ref.rot_p, initial_frame(jnp.zeros(3), along, y)).T
    rotary = [s.Jx, s.Jy, s.Jz, s.Jyz]
    return beams.rigid_inertia(p, q, axes, rotary, beams.SECOND_MOMENTS, ref=ref, section=section)


rigid_beam = Element(
    _rigid_beam,
    inertia=_rigid_inertia,
    thermal=_rigid_thermal,
    check=beams.check_across,
    released=(),
    names=("offset_x", "offset_y", "offset_z"),
)
"""Point q rigidly attached to the body at p: e1 to e3 displacement of q from its place on the body, in body axes [m],
FIXED. The rotation at q is free. ``spatial.rigid_body`` is clamped at both ends.

Properties: section (mass and rotary inertia), alpha (coefficient of thermal expansion [1/K]; default: the value of the
section's material), y (vector that fixes local y, for a temperature gradient and the section).
"""


pin_body = rigid_beam
"""Another name of ``rigid_beam``, after PINBODY of SPACAR. Its two ends may be at the same point."""


def _rigid_body(p: Point3, rot_p: Rotation3, q: Point3, rot_q: Rotation3, *, ref: Reference) -> Float[Array, "6"]:
    """Offset of q from its place on the body of p [m], and rotation of q relative to it [rad], in axes of the body."""
    turn = 2 * relative_turn(rot_p, rot_q, ref.rot_p, ref.rot_q, jnp.eye(3))[1:]
    return jnp.concatenate([_rigid_beam(p, rot_p, q, ref=ref), turn])


def _rigid_body_thermal(
    change: Array, gradient: Array, *, ref, alpha: float | None = None, section=None, y=None
) -> Float[Array, "6"]:
    """Offset of a rigid beam, and the rotation of the arc, which bends away from its warmer side."""
    offset = _rigid_thermal(change, gradient, ref=ref, alpha=alpha, section=section, y=y)
    along = jnp.where(beams.length_or_zero(ref) > 0, ref.q - ref.p, np.array([1.0, 0, 0]))
    arc = beams.expansion_of(section, alpha) * beams.length_or_zero(ref) * gradient
    turn = initial_frame(jnp.zeros(3), along, y)[:, 1:] @ jnp.stack([arc[1], -arc[0]])
    return jnp.concatenate([offset, turn])


rigid_body = Element(
    _rigid_body,
    inertia=_rigid_inertia,
    thermal=_rigid_body_thermal,
    shape=beams.straight_shape,
    check=beams.check_across,
    released=(),
    names=(*rigid_beam.names, "tilt_x", "tilt_y", "tilt_z"),
)
"""Rigid body from p to q, clamped at both: e1 to e3 offset of q in body axes [m], e4 to e6 rotation of q relative to p
[rad], FIXED. Its two ends may lie in one place.

Properties: section (mass and rotary inertia), alpha (coefficient of thermal expansion [1/K]; default: the value of the
section's material), y (vector that fixes local y, for a temperature gradient and the section).
"""


hinge = joints.hinge
prismatic = joints.prismatic
screw = joints.screw
slider = joints.slider
gear = joints.gear


def _spring_damper(p: Point3, q: Point3, *, ref: Reference) -> Float[Array, "1"]:
    """Change of the distance between two points [m]."""
    return beams.truss(p, q, ref=ref)


spring_damper = Element(_spring_damper, law=characteristic, check=beams.check_length, names=("elongation",))
"""Spring, damper or actuator between two points with a force law of your own: e1 change of the distance [m]. A positive
force pulls the points together. The element constrains nothing. Its properties are the keyword-only parameters of the
law.

Options: law, a function ``f(e, ed, **properties) -> ()`` of e1 and its rate [N]. ``spring_damper(law)`` makes a new
element type for each function object, so define the function once and use it for all such springs.
"""


def _rotary_spring_damper(
    rot_p: Rotation3, rot_q: Rotation3, *, ref: Reference, near: Float[Array, "n_e"], axis: Float[Array, "3"]
) -> Float[Array, "1"]:
    """Rotation of the body q about an axis of the body p, counted past full turns [rad]."""
    return joints.turn_and_tilt(rot_p, rot_q, ref.rot_p, ref.rot_q, near[0], axis)[:1]


rotary_spring_damper = Element(_rotary_spring_damper, law=characteristic, check=beams.check_axis, names=("angle",))
"""Spring, damper or actuator between two bodies with a moment law of your own [N m]: e1 rotation of body q relative to
body p about the axis, counted past full turns [rad]. The moment acts on body p. Properties: axis (global, undeformed
state) and the keyword-only parameters of the law. Option law: see ``spatial.spring_damper``.
"""


def _nothing_at(p: Point3, *, ref: Reference) -> Float[Array, "0"]:
    return jnp.zeros(0)


mass = Element(_nothing_at, inertia=beams.point_inertia, check=beams.check_mass)
"""Point mass. Properties: mass [kg]."""


def _drag(p: Point3, *, ref: Reference) -> Float[Array, "3"]:
    """Displacement of p. Returns (3,) [m]. Source: Definition."""
    return p - ref.p


drag = Element(_drag, **beams.drag_laws("xyz", by_length=False))
"""Drag of a point in a fluid at rest: force -damping times the velocity. Properties: damping [N s/m].

Deformations: e1 to e3: displacement along x, y, z [m].
"""


def _beam_drag(p: Point3, rot_p: Rotation3, q: Point3, rot_q: Rotation3, *, ref: Reference) -> Float[Array, "12"]:
    """Displacements of the ends, and length times change of the axis there. Returns (12,) [m]. Source: Definition."""
    slopes, start = _triads(rot_p, rot_q, ref, None)[:, :, 0], _triads(ref.rot_p, ref.rot_q, ref, None)[:, :, 0]
    return beams.displacements(p, q, slopes, start, ref)


beam_drag = Element(_beam_drag, **beams.drag_laws("xyz", by_length=True))
"""Distributed drag along a beam: force per length -damping times the velocity. Properties: damping [N s/m^2].

Deformations: e1 to e6: displacement of p, and length times change of the axis there [m]; e7 to e12: the same at q.

The velocity between the ends is a cubic polynomial, as in ``spatial.beam``, for every type of beam. The rotation of the
beam about its axis has no drag. A damping of alpha times the mass per length is the mass-proportional damping alpha M0
of Rayleigh, and also applies to large motions.
"""


def _nothing_on(rot: Rotation3, *, ref: Reference) -> Float[Array, "0"]:
    return jnp.zeros(0)


# Index of each component of an inertia tensor among its six numbers.
TENSOR = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])


def _inertia_inertia(rot: Rotation3, *, ref: Reference, inertia: Float[Array, "6"]):
    """Axes that turn with the body, and the second moments of its mass."""
    tensor = inertia[TENSOR]
    return turned(rot, ref.rot, jnp.eye(3)).T, jnp.trace(tensor) / 2 * jnp.eye(3) - tensor


inertia = Element(_nothing_on, inertia=_inertia_inertia)
"""Lumped rotary inertia. Properties: inertia (Ixx, Ixy, Ixz, Iyy, Iyz, Izz) about global axes, undeformed state
[kg m^2].
"""


def _moment(rot: Rotation3, *, ref: Reference, moment: Float[Array, "3"]) -> Float[Array, "4"]:
    """Force dual to Euler parameters of a moment about fixed axes: 2 Lbar^T M."""
    return 2 * lbar(rot).T @ moment


moment = Element(_nothing_on, force=_moment)
"""Moment about fixed axes. It has no potential, so that the tangent stiffness is not symmetric.

Properties: moment (global) [N m].
"""


def _nothing_between(p: Point3, rot: Rotation3, *, ref: Reference) -> Float[Array, "0"]:
    return jnp.zeros(0)


def _follower_force(p: Point3, rot: Rotation3, *, ref: Reference, force: Float[Array, "3"]) -> Float[Array, "7"]:
    return jnp.concatenate([turned(rot, ref.rot, jnp.eye(3)) @ force, jnp.zeros(4)])


follower_force = Element(_nothing_between, force=_follower_force)
"""Force that turns with the body at p. Properties: force (global, undeformed state) [N]."""


def _follower_moment(rot: Rotation3, *, ref: Reference, moment: Float[Array, "3"]) -> Float[Array, "4"]:
    return _moment(rot, ref=ref, moment=turned(rot, ref.rot, jnp.eye(3)) @ moment)


follower_moment = Element(_nothing_on, force=_follower_moment)
"""Moment that turns with its body. Properties: moment (global, undeformed state) [N m]."""


def _body(p: Point3, rot: Rotation3, *, ref: Reference) -> Float[Array, "0"]:
    return jnp.zeros(0)


def _body_inertia(
    p: Point3, rot: Rotation3, *, ref: Reference, mass: float, center: Float[Array, "3"], inertia: Float[Array, "6"]
):
    """Centre of mass, and axes that turn with the body."""
    axes, moments = _inertia_inertia(rot, ref=ref, inertia=inertia)
    h = jnp.zeros((4, 4)).at[0, 0].set(mass).at[1:, 1:].set(moments)
    return jnp.concatenate([(p + center @ axes)[None], axes]), h


def _check_body(*, ref: Reference, mass: float, inertia: Float[Array, "6"]) -> list[str]:
    faults, tensor = beams.check_body_mass(mass), as_floats(inertia)
    xp = library_of(tensor)
    if not holds(xp.isfinite(tensor)):
        return faults
    moments = xp.linalg.eigvalsh(tensor[..., TENSOR])
    # A needle has one zero moment and two equal ones; in a plate one moment is the sum of the others.
    slack = NEGLIGIBLE * moments[..., 2]
    if not holds((moments[..., 0] >= -slack) & (moments[..., 0] + moments[..., 1] >= moments[..., 2] - slack)):
        listed = ", ".join(f"{moment:.6g}" for moment in moments.reshape(-1, 3)[0])
        faults.append(
            f"has the principal moments of inertia {listed}, which no body has: none is negative, and none is more than"
            " the sum of the others"
        )
    return faults


body = Element(_body, inertia=_body_inertia, check=_check_body)
"""Body fixed to the node at p. Properties: mass [kg], center (centre of mass relative to the node, undeformed state)
[m], inertia ((Ixx, Ixy, Ixz, Iyy, Iyz, Izz) about the centre, global axes, undeformed state) [kg m^2].
"""


__all__, __dir__ = only(globals(), lambda value: isinstance(value, Element))
