"""Joints between bodies in space: hinge, slider, prismatic joint, screw and gears.

Names: body p has the reference point p and the triad ``rot_p``; likewise body q. An axis is given in the undeformed
mechanism and turns with body p.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_floats, holds
from ..math.rotation import initial_frame, nearest_turn, polar_angle, relative_turn, turned
from . import beams
from .element import Element
from .nodes import Point3, Reference, Rotation3
from .shared_laws import mesh_damping, mesh_stiffness, uncoupled


def _frame(axis: Float[Array, "3"]) -> Float[Array, "3 3"]:
    return initial_frame(jnp.zeros(3), axis, None)


# Twice y and z rotated by an angle, from the products of (cosine, sine) with (y, z) in this order.
TURNED_TWICE = 2.0 * np.array([[1.0, 0], [0, 1], [0, 1], [-1, 0]])


def turn_and_tilt(
    rot_p: Rotation3, rot_q: Rotation3, ref_p: Rotation3, ref_q: Rotation3, near: Array, axis: Float[Array, "3"]
) -> Float[Array, "3"]:
    """Rotation of body q about an axis of body p, counted past full turns, and the two tilts of the axis.

    The relative Euler parameters of a pure rotation a are (cos a/2, sin a/2 along the axis). They determine a/2 up to
    full turns, and ``near`` selects the turn. Returns (3,) [rad]; a tilt is twice the sine of half the angle of the
    axis, seen from body p. Source: A rotation is a turn about the axis, then one about a line across it: THEORY.md 2,
    eq. (2.17).
    """
    rel = relative_turn(rot_p, rot_q, ref_p, ref_q, _frame(axis))
    half, across = rel[:2], rel[2:]
    # Euler parameters across the axis rotate by half the turn.
    direction = half / jnp.sqrt(half @ half)
    tilts = (direction[:, None] * across).reshape(4) @ TURNED_TWICE
    return jnp.append(nearest_turn(2 * polar_angle(half), near, 4 * jnp.pi), tilts)


def _hinge(
    rot_p: Rotation3, rot_q: Rotation3, *, ref: Reference, near: Float[Array, "n_e"], axis: Float[Array, "3"]
) -> Float[Array, "3"]:
    """Rotation about the hinge axis, and the two tilts of the axis [rad]."""
    return turn_and_tilt(rot_p, rot_q, ref.rot_p, ref.rot_q, near[0], axis)


hinge = Element(_hinge, **uncoupled(3), check=beams.check_axis, released=(1,), names=("angle", "tilt_y", "tilt_z"))
"""Hinge: e1 rotation about the axis, e2 and e3 tilt of the axis (FIXED) [rad].

Properties: axis (global, undeformed state), stiffness and damping (one value for all released deformations, or one
value each).
"""


def _offset(p: Point3, rot_p: Rotation3, q: Point3, ref: Reference, axis: Float[Array, "3"]) -> Float[Array, "3"]:
    """Displacement of q relative to body p, along the axis and across it."""
    frame = _frame(axis)
    return turned(rot_p, ref.rot_p, frame).T @ (q - p) - frame.T @ (ref.q - ref.p)


def _slider(p: Point3, rot_p: Rotation3, q: Point3, *, ref: Reference, axis: Float[Array, "3"]) -> Float[Array, "3"]:
    """Displacement of q along a line of body p, and off it [m]."""
    return _offset(p, rot_p, q, ref, axis)


slider = Element(
    _slider, **uncoupled(3), check=beams.check_axis, released=(1,), names=("along", "across_y", "across_z")
)
"""Point q that slides on a straight line of body p: e1 displacement along the line, e2 and e3 across the line (FIXED)
[m]. The line passes through the undeformed place of q.

Properties: axis (direction of the line; global, undeformed state), stiffness and damping (one value for all released
deformations, or one value each).
"""


def _prismatic(
    p: Point3, rot_p: Rotation3, q: Point3, rot_q: Rotation3, *, ref: Reference, axis: Float[Array, "3"]
) -> Float[Array, "6"]:
    """Displacement along a line of body p, off it [m], and rotation of body q relative to it [rad]."""
    rotation = 2 * relative_turn(rot_p, rot_q, ref.rot_p, ref.rot_q, _frame(axis))[1:]
    return jnp.concatenate([_offset(p, rot_p, q, ref, axis), rotation])


prismatic = Element(
    _prismatic,
    **uncoupled(6),
    shape=beams.straight_shape,
    check=beams.check_axis,
    released=(1,),
    names=(*slider.names, "tilt_x", "tilt_y", "tilt_z"),
)
"""Body q that slides along a straight line of body p: e1 displacement along the line [m]; e2 and e3 displacement across
the line [m] and e4 to e6 rotation [rad], FIXED.

Properties: axis (direction of the line; global, undeformed state), stiffness and damping (one value for all released
deformations, or one value each).
"""


def _screw(
    p: Point3,
    rot_p: Rotation3,
    q: Point3,
    rot_q: Rotation3,
    *,
    ref: Reference,
    near: Float[Array, "n_e"],
    axis: Float[Array, "3"],
    pitch: float,
) -> Float[Array, "6"]:
    """Displacement along the axis minus pitch times turn, turn, displacement across the axis, tilt of the axis."""
    along, off_y, off_z = _offset(p, rot_p, q, ref, axis)
    turn, tilt_y, tilt_z = turn_and_tilt(rot_p, rot_q, ref.rot_p, ref.rot_q, near[1], axis)
    return jnp.stack([along - pitch * turn, turn, off_y, off_z, tilt_y, tilt_z])


screw = Element(
    _screw,
    shape=beams.straight_shape,
    check=beams.check_axis,
    released=(2,),
    names=("mismatch", "angle", "across_y", "across_z", "tilt_y", "tilt_z"),
)
"""Screw of body q in body p, about an axis through q.

Deformations:
    e1: displacement along the axis minus pitch times turn [m], FIXED.
    e2: turn [rad], counted past full turns.
    e3, e4: displacements across the axis [m], FIXED.
    e5, e6: tilts of the axis [rad], FIXED.

Properties: axis (global, undeformed state), pitch (displacement per radian [m/rad]).
"""


def _gear(
    carrier: Rotation3,
    rot_p: Rotation3,
    rot_q: Rotation3,
    *,
    ref: Reference,
    near: Float[Array, "n_e"],
    axis_p: Float[Array, "3"],
    axis_q: Float[Array, "3"],
    ratio: float,
) -> Float[Array, "2"]:
    """Rotation mismatch of two gears on a carrier, seen at gear p, and turn of gear p relative to the carrier."""
    turn_p = turn_and_tilt(carrier, rot_p, ref.carrier, ref.rot_p, near[1], axis_p)[0]
    near_q = (near[0] - near[1]) / ratio
    turn_q = turn_and_tilt(carrier, rot_q, ref.carrier, ref.rot_q, near_q, axis_q)[0]
    return jnp.stack([turn_p + ratio * turn_q, turn_p])


def _check_gear(*, ref, axis_p, axis_q, ratio) -> list[str]:
    faults = beams.check_axis(ref=ref, axis=axis_p) or beams.check_axis(ref=ref, axis=axis_q)
    return faults if holds(as_floats(ratio) != 0) else [*faults, "has a ratio of zero"]


gear = Element(
    _gear, stiffness=mesh_stiffness, damping=mesh_damping, check=_check_gear, measured=(2,), names=("mismatch", "turn")
)
"""Two gears with hinges on one carrier, also bevel gears: e1 mismatch of rotation at gear p [rad], FIXED unless the
mesh has a stiffness; e2 turn of gear p relative to the carrier [rad], measured.

Properties: axis_p and axis_q (of the hinges; global, undeformed state), ratio (teeth of q over teeth of p; positive
where the gears turn in opposite senses about these axes), stiffness and damping of the mesh [N m/rad, N m s/rad].
"""
