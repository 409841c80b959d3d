"""Planar elements: beams, joints, springs, transmissions, lumped mass and rotary inertia.

``help(planar.beam)`` lists the deformations of an element in order, with units, and its properties and options.

- Flexible: truss, beam, spectral_beam, leaf_spring.
- Rigid: rigid_beam (pinned at its second end; pin_body is the same), rigid_body (clamped at both).
- Joints: hinge, slider, prismatic. Transmissions: gear, belt, belt_to_point.
- Springs and dampers with a law of your own: spring_damper, rotary_spring_damper. Drag against the ground: drag (of a
  point), beam_drag (by length).
- Mass and loads: mass, inertia, body, follower_force.

Names: p and q are the ends, ``rot_p`` and ``rot_q`` their rotations.
"""

from functools import partial

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_floats, holds
from ..lazy import only
from ..math.rotation import QUARTER, cosine_and_sine, rotation_plane
from . import beams, leaf_planar, spectral_planar, transmission
from .element import ALL, Element
from .nodes import Angle, Point2, Reference, Static
from .sections import Damping, Section
from .shared_laws import characteristic, uncoupled


def _truss(p: Point2, q: Point2, *, ref: Reference) -> Float[Array, "1"]:
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


def _axes(rot_p: Angle, rot_q: Angle, ref: Reference) -> Float[Array, "2 2 2"]:
    """Local x and y axes at both ends, as rows, of triads that lay along the undeformed element."""
    x0 = (ref.q - ref.p) / beams.beam_length(ref)
    frame = jnp.stack([x0, jnp.stack([-x0[1], x0[0]])])
    angles = jnp.concatenate([rot_p - ref.rot_p, rot_q - ref.rot_q])
    c, s = cosine_and_sine(angles)
    return c[:, None, None] * frame + s[:, None, None] * (QUARTER @ frame)


def _beam(
    p: Point2, rot_p: Angle, q: Point2, rot_q: Angle, *, ref: Reference, second_order: Static[bool] = True
) -> Float[Array, "3"]:
    """Elongation and two bendings of a planar beam, tutorial (3.3)-(3.5) with the shortening by bending.

    Without the shortening a guide of two leaf springs buckles at 94.5 N; 78.75 N is right (REFERENCES.md T3).
    """
    l0, chord = beams.beam_length(ref), q - p
    across = np.array([-1.0, 1.0]) * jnp.sum(_axes(rot_p, rot_q, ref)[:, 1] * chord, axis=1)
    elongation = beams.length(chord) - l0
    if second_order:
        elongation = elongation + beams.bending_shortening(across, l0)
    return jnp.concatenate([elongation[None], across])


# Places of EA/l0 and of the two coefficients of beams.bending_coefficients.
STIFFNESS = np.zeros((3, 3, 3))
STIFFNESS[0, 0, 0] = 1.0
STIFFNESS[1:, 1:, 1:] = beams.BENDING


def _beam_stiffness(*, ref: Reference, section: Section) -> Float[Array, "3 3"]:
    s, l0 = section.rigidity(), beams.beam_length(ref)
    return beams.combine([s.EA / l0, *beams.bending_coefficients(s.EIy, l0, s.shear_z)], STIFFNESS)


def _beam_damping(*, ref, damping: Damping, section: Section | None = None) -> Float[Array, "3 3"]:
    l0, shear = beams.beam_length(ref), 0.0 if section is None else section.rigidity().shear_z
    return beams.combine([damping.EA / l0, *beams.bending_damping(damping.EIy, damping.GAz, l0, shear)], STIFFNESS)


# Places of the mass per length and of the rotary inertia per length, times l0, among the vectors
# (p, q, l0 x_p, l0 x_q, y_p, y_q).
INERTIA = np.zeros((2, 6, 6))
INERTIA[0, :4, :4] = beams.CUBIC_MASS[np.ix_([0, 2, 1, 3], [0, 2, 1, 3])]
INERTIA[1, 4:, 4:] = beams.LINEAR_MASS


def _beam_inertia(*nodes: Array, ref, section):
    """Cubic interpolation of the position along the beam, linear interpolation of the section's normal."""
    p, rot_p, q, rot_q = nodes
    s, l0 = section.rigidity(), beams.beam_length(ref)
    axes = _axes(rot_p, rot_q, ref)
    vectors = jnp.concatenate([jnp.stack([p, q]), l0 * axes[:, 0], axes[:, 1]])
    return vectors, l0 * beams.combine([s.mass, s.Jy], INERTIA)


def _beam_resultants(*nodes: Array, ref, place, sigma, section, second_order, fall=None) -> Float[Array, "6"]:
    """Nodal forces of the stress resultants less the nodal forces of distributed loads, in axes of the end sections.

    Local z of the section is the beam's local y. Local y of the section points into the plane, so that a positive
    bending moment about it turns clockwise.
    """
    p, rot_p, q, rot_q = nodes
    axes, chord = _axes(rot_p, rot_q, ref), q - p
    deformation = partial(_beam, ref=ref, second_order=second_order)
    inertia = partial(_beam_inertia, ref=ref, section=section)
    force_p, moment_p, force_q, moment_q = beams.nodal_forces(deformation, inertia, nodes, sigma, fall)
    normal, across = jnp.einsum("eax,ex->ae", axes, jnp.stack([-force_p, force_q]))
    resultants = beams.resultants_between_ends(
        jnp.stack([normal, across, jnp.concatenate([moment_p, -moment_q])], axis=1), place
    )
    if fall is not None:
        force, lever = beams.distributed(beams.CUBIC_SHAPES, fall[np.array([0, 2, 1, 3])], place)
        moment = chord[1] * lever[0] - chord[0] * lever[1]
        mass = section.rigidity().mass * beams.beam_length(ref)
        resultants = resultants + mass * jnp.append(beams.resultants_between_ends(axes, place) @ force, moment)
    zero = jnp.array(0.0)
    return jnp.stack([resultants[0], zero, resultants[1], zero, resultants[2], zero])


def _beam_thermal(change: Array, gradient: Array, *, ref, section) -> Float[Array, "3"]:
    """Elongation, and the bendings of an arc whose warmer side is longer."""
    l0, alpha = beams.beam_length(ref), beams.expansion_of(section)
    elongation = beams.thermal_elongation(change, l0, alpha)
    return jnp.concatenate([elongation[None], jnp.broadcast_to(alpha * gradient * l0**2 / 2, (2,))])


beam = Element(
    _beam,
    stiffness=_beam_stiffness,
    damping=_beam_damping,
    inertia=_beam_inertia,
    resultants=_beam_resultants,
    thermal=_beam_thermal,
    check=beams.check_length,
    angles=(2, 3),
    names=("elongation", "bending_p", "bending_q"),
)
"""Flexible beam with a cubic deflection between its ends.

Deformations:
    e1: elongation [m].
    e2: bending at p [m]: angle of the axis at p from the chord, counter-clockwise, times length.
    e3: bending at q [m]: angle of the axis at q from the chord, clockwise, times length. In an arc e2 = e3.

Properties: section (without a section the beam is rigid and has no mass), damping.

Options: second_order (default True), whether the elongation includes the shortening by bending.

Limits: A beam stretched by a strain bends with EI (1 + strain)^2 instead of EI, whatever the number of beams. Use a
spectral beam for strains beyond 1 %. The beam includes shear if its section has a shear stiffness. ``build`` warns if
neglected shear would change a stiffness by more than 1 %.
"""


spectral_beam = spectral_planar.spectral_beam
leaf_spring = leaf_planar.leaf_spring


def _rigid_beam(p: Point2, rot_p: Angle, q: Point2, *, ref: Reference) -> Float[Array, "2"]:
    """Offset of q from its place on the body of p, in axes of the body [m]."""
    turned = rotation_plane(rot_p[0] - ref.rot_p[0])
    return turned.T @ (q - p) - (ref.q - ref.p)


def _rigid_thermal(
    change: Array, gradient: Array, *, ref, alpha: float | None = None, section=None
) -> Float[Array, "2"]:
    """Expansion of the offset, and the deflection of an arc whose direction at p is unchanged."""
    offset, expansion = ref.q - ref.p, beams.expansion_of(section, alpha)
    across = beams.length_or_zero(ref) * jnp.stack([-offset[1], offset[0]])
    return expansion * ((change[0] + change[1]) / 2 * offset - gradient[0] / 2 * across)


def _rigid_inertia(p: Array, rot_p: Array, q: Array, *_: Array, ref, section: Section):
    """Mass along the line, and rotary inertia on an axis that turns with the body."""
    axis, one = rotation_plane(rot_p[0] - ref.rot_p[0])[:, :1].T, np.ones((1, 1, 1))
    return beams.rigid_inertia(p, q, axis, [section.rigidity().Jy], one, ref=ref, section=section)


rigid_beam = Element(
    _rigid_beam, inertia=_rigid_inertia, thermal=_rigid_thermal, released=(), names=("offset_x", "offset_y")
)
"""Point q rigidly attached to the body at p: e1, e2 displacement of q from its place on the body, in body axes [m],
FIXED. The rotation at q is free: q is a hinge. ``planar.rigid_body`` is clamped at both ends.

Properties: section (mass and rotary inertia), alpha (coefficient of thermal expansion [1/K]; default: the value of the
section's material).
"""


pin_body = rigid_beam
"""Another name of ``rigid_beam``, after PINBODY of SPACAR. Its two ends may be at the same point."""


def _hinge(rot_p: Angle, rot_q: Angle, *, ref: Reference) -> Float[Array, "1"]:
    """Relative rotation of two bodies [rad]."""
    return (rot_q - ref.rot_q) - (rot_p - ref.rot_p)


hinge = Element(_hinge, **uncoupled(1), released=ALL, names=("angle",))
"""Hinge: e1 relative rotation [rad]. Properties: stiffness [N m/rad], damping [N m s/rad]."""


def _rigid_body(p: Point2, rot_p: Angle, q: Point2, rot_q: Angle, *, ref: Reference) -> Float[Array, "3"]:
    """Offset of q from its place on the body of p, in axes of the body [m], and rotation of q relative to it [rad]."""
    return jnp.concatenate([_rigid_beam(p, rot_p, q, ref=ref), _hinge(rot_p, rot_q, ref=ref)])


def _rigid_body_thermal(
    change: Array, gradient: Array, *, ref, alpha: float | None = None, section=None
) -> Float[Array, "3"]:
    """Offset of a rigid beam, and the rotation of the arc, which bends away from its warmer side."""
    offset = _rigid_thermal(change, gradient, ref=ref, alpha=alpha, section=section)
    return jnp.append(offset, -beams.expansion_of(section, alpha) * gradient[0] * beams.length_or_zero(ref))


rigid_body = Element(
    _rigid_body,
    inertia=_rigid_inertia,
    thermal=_rigid_body_thermal,
    shape=beams.straight_shape,
    released=(),
    names=("offset_x", "offset_y", "tilt"),
)
"""Rigid body from p to q, clamped at both: e1, e2 offset of q in body axes [m], e3 rotation of q relative to p [rad],
FIXED. Its two ends may lie in one place.

Properties: section (mass and rotary inertia), alpha (coefficient of thermal expansion [1/K]; default: the value of the
section's material).
"""


def _slider(p: Point2, rot_p: Angle, q: Point2, *, ref: Reference, axis: Float[Array, "2"]) -> Float[Array, "2"]:
    """Displacement of q along a line of body p, and off it to the left [m]."""
    along = axis / jnp.sqrt(axis @ axis)
    return jnp.stack([along, jnp.stack([-along[1], along[0]])]) @ _rigid_beam(p, rot_p, q, ref=ref)


slider = Element(_slider, **uncoupled(2), check=beams.check_axis, released=(1,), names=("along", "across"))
"""Point q that slides on a straight line of body p: e1 displacement along the line, e2 across the line (FIXED) [m]. The
line passes through the undeformed place of q.

Properties: axis (direction of the line; global, undeformed state), stiffness and damping (one value for all released
deformations, or one value each).
"""


def _prismatic(
    p: Point2, rot_p: Angle, q: Point2, rot_q: Angle, *, ref: Reference, axis: Float[Array, "2"]
) -> Float[Array, "3"]:
    """Displacement along a line of body p, off it [m], and rotation of body q relative to it [rad]."""
    turn = (rot_q - ref.rot_q) - (rot_p - ref.rot_p)
    return jnp.concatenate([_slider(p, rot_p, q, ref=ref, axis=axis), turn])


prismatic = Element(
    _prismatic,
    **uncoupled(3),
    shape=beams.straight_shape,
    check=beams.check_axis,
    released=(1,),
    names=("along", "across", "tilt"),
)
"""Body q that slides along a straight line of body p: e1 displacement along the line [m]; e2 displacement across the
line [m] and e3 rotation [rad], both FIXED.

Properties: axis (direction of the line; global, undeformed state), stiffness and damping (one value for all released
deformations, or one value each).
"""


def _spring_damper(p: Point2, q: Point2, *, ref: Reference) -> Float[Array, "1"]:
    """Change of the distance between two points [m]."""
    return beams.truss(p, q, ref=ref)


spring_damper = Element(_spring_damper, law=characteristic, check=beams.check_length, names=("elongation",))
"""Spring, damper or actuator between two points with a force law of your own: e1 change of the distance [m]. A positive
force pulls the points together. The element constrains nothing. Its properties are the keyword-only parameters of the
law.

Options: law, a function ``f(e, ed, **properties) -> ()`` of e1 and its rate [N]. ``spring_damper(law)`` makes a new
element type for each function object, so define the function once and use it for all such springs.
"""


def _rotary_spring_damper(rot_p: Angle, rot_q: Angle, *, ref: Reference) -> Float[Array, "1"]:
    """Relative rotation of two bodies [rad]."""
    return _hinge(rot_p, rot_q, ref=ref)


rotary_spring_damper = Element(_rotary_spring_damper, law=characteristic, names=("angle",))
"""Spring, damper or actuator between two bodies with a moment law of your own [N m]: e1 rotation of body q relative to
body p [rad]. The moment acts on body p. Properties and option law: see ``planar.spring_damper``.
"""


gear = transmission.gear
belt = transmission.belt
belt_to_point = transmission.belt_to_point


def _nothing_at(p: Point2, *, ref: Reference) -> Float[Array, "0"]:
    return jnp.zeros(0)


mass = Element(_nothing_at, inertia=beams.point_inertia, check=beams.check_mass)
"""Point mass. Properties: mass [kg]."""


def _drag(p: Point2, *, ref: Reference) -> Float[Array, "2"]:
    """Displacement of p. Returns (2,) [m]. Source: Definition."""
    return p - ref.p


drag = Element(_drag, **beams.drag_laws("xy", by_length=False))
"""Drag of a point in a fluid at rest: force -damping times the velocity. Properties: damping [N s/m].

Deformations: e1 to e2: displacement along x, y [m].
"""


def _beam_drag(p: Point2, rot_p: Angle, q: Point2, rot_q: Angle, *, ref: Reference) -> Float[Array, "8"]:
    """Displacements of the ends, and length times change of the axis there. Returns (8,) [m]. Source: Definition."""
    slopes, start = _axes(rot_p, rot_q, ref)[:, 0], _axes(ref.rot_p, ref.rot_q, ref)[:, 0]
    return beams.displacements(p, q, slopes, start, ref)


beam_drag = Element(_beam_drag, **beams.drag_laws("xy", by_length=True))
"""Distributed drag along a beam: force per length -damping times the velocity. Properties: damping [N s/m^2].

Deformations: e1 to e4: displacement of p, and length times change of the axis there [m]; e5 to e8: the same at q.

The velocity between the ends is a cubic polynomial, as in ``planar.beam``, for every type of beam. A damping of alpha
times the mass per length is the mass-proportional damping alpha M0 of Rayleigh, and also applies to large motions.
"""


def _nothing_on(rot: Angle, *, ref: Reference) -> Float[Array, "0"]:
    return jnp.zeros(0)


def _inertia_inertia(rot: Angle, *, ref: Reference, inertia: float):
    return rot[None], jnp.reshape(inertia, (1, 1))


inertia = Element(_nothing_on, inertia=_inertia_inertia)
"""Lumped rotary inertia, of either sign. Properties: inertia [kg m^2]."""


def _nothing_between(p: Point2, rot: Angle, *, ref: Reference) -> Float[Array, "0"]:
    return jnp.zeros(0)


def _follower_force(p: Point2, rot: Angle, *, ref: Reference, force: Float[Array, "2"]) -> Float[Array, "3"]:
    return jnp.concatenate([rotation_plane(rot[0] - ref.rot[0]) @ force, jnp.zeros(1)])


follower_force = Element(_nothing_between, force=_follower_force)
"""Force that turns with the body at p. Properties: force (global, undeformed state) [N]."""


def _body(p: Point2, rot: Angle, *, ref: Reference) -> Float[Array, "0"]:
    return jnp.zeros(0)


def _body_inertia(p: Point2, rot: Angle, *, ref: Reference, mass: float, center: Float[Array, "2"], inertia: float):
    """Centre of mass, and an axis that turns with the body at the rate of the rotation."""
    axes = rotation_plane(rot[0] - ref.rot[0])
    return jnp.stack([p + axes @ center, axes[:, 0]]), jnp.diag(jnp.stack([jnp.asarray(mass), jnp.asarray(inertia)]))


def _check_body(*, ref: Reference, mass: float, inertia: float) -> list[str]:
    faults = [] if holds(as_floats(inertia) >= 0) else [f"has an inertia of {inertia}, but it cannot be negative"]
    return beams.check_body_mass(mass) + faults


body = Element(_body, inertia=_body_inertia, check=_check_body)
"""Body fixed to the node at p. Properties: mass [kg], center (centre of mass relative to the node, undeformed state)
[m], inertia (about the centre) [kg m^2].
"""


__all__, __dir__ = only(globals(), lambda value: isinstance(value, Element))
