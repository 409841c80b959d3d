"""Planar transmissions: gears on a turning arm, and belts from a pulley to another or to a point.

The state of a belt or a gear mesh depends on the turn of each wheel relative to the line between the centres. The turn
counts past full turns. No function of the coordinates alone can count, so the turn is a measured deformation, which is
always DEPENDENT.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_floats, holds
from ..math.rotation import angle_between, nearest_turn, rotation_plane
from . import beams
from .element import Element
from .nodes import Angle, Point2, Reference
from .sections import Damping, Scalar, Section
from .shared_laws import mesh_damping, mesh_stiffness


def _gear(
    p: Point2, rot_p: Angle, q: Point2, rot_q: Angle, *, ref: Reference, near: Float[Array, "n_e"], ratio: float
) -> Float[Array, "2"]:
    """Rotation mismatch of two meshing gears, seen at gear p, and turn of gear p relative to the line of centres."""
    turn = rot_p[0] - ref.rot_p[0]
    turn_p = nearest_turn(turn - angle_between(ref.q - ref.p, q - p), near[1])
    turn_q = turn_p + (rot_q[0] - ref.rot_q[0]) - turn
    return jnp.stack([turn_p + ratio * turn_q, turn_p])


def _check_centres(*, ref: Reference) -> list[str]:
    return ["has its two centres in one place"] if beams.check_length(ref=ref) else []


def _check_gear(*, ref, ratio) -> list[str]:
    return _check_centres(ref=ref) + ([] if holds(as_floats(ratio) != 0) else ["has a ratio of zero"])


def _around(centre: Float[Array, "2"], start: Float[Array, "2"], turns: Float[Array, ""]) -> Float[Array, "2"]:
    """Point of a circle, a number of turns after the start."""
    return centre + rotation_plane(2 * np.pi * jnp.clip(turns, 0.0, 1.0)) @ (start - centre)


def _gear_shape(p: Array, rot_p: Array, q: Array, rot_q: Array, *, ref, place, ratio) -> Float[Array, "2"]:
    """Both pitch circles, from their common point."""
    meeting = p + (q - p) / (1 + ratio)
    return jnp.where(place < 0.5, _around(p, meeting, 2 * place), _around(q, meeting, 2 * place - 1))


gear = Element(
    _gear,
    stiffness=mesh_stiffness,
    damping=mesh_damping,
    shape=_gear_shape,
    check=_check_gear,
    measured=(2,),
    names=("mismatch", "turn"),
)
"""Two meshing gears with centres p and q: e1 mismatch of rotation at gear p [rad], FIXED unless the mesh has a
stiffness; e2 turn of gear p relative to the line of centres [rad], measured. The line of centres may turn.

Properties: ratio (radius of q over radius of p, negative where one gear runs inside the other), stiffness and damping
of the mesh [N m/rad, N m s/rad].
"""


def _span(d: Float[Array, "2"], radius_p: Scalar, radius_q: Scalar):
    """Length of the tangent from pulley p to pulley q, and its angle from the line of centres d.

    A positive radius lies to the left of the way from p to q: with t along the belt and n to its left, the tangent is
    d + (r_q - r_p) n.
    """
    offset = radius_q - radius_p
    tangent = jnp.sqrt(d @ d - offset**2)
    return tangent, jnp.arctan2(offset, tangent)


def _turns(
    p: Point2, rot_p: Angle, q: Point2, *, ref: Reference, near: Float[Array, ""], radius_p: Scalar, radius_q: Scalar
):
    """Elongation of the straight part, and turn of pulley p relative to it."""
    length_before, angle_before = _span(ref.q - ref.p, radius_p, radius_q)
    length, angle = _span(q - p, radius_p, radius_q)
    turned = angle_between(ref.q - ref.p, q - p) + angle - angle_before
    return length - length_before, nearest_turn(rot_p[0] - ref.rot_p[0] - turned, near)


def _belt(
    p: Point2,
    rot_p: Angle,
    q: Point2,
    rot_q: Angle,
    *,
    ref: Reference,
    near: Float[Array, "n_e"],
    radius_p: float,
    radius_q: float,
) -> Float[Array, "3"]:
    """Elongation, including the belt rolled onto each pulley, and turns of both pulleys relative to the belt."""
    stretch, turn_p = _turns(p, rot_p, q, ref=ref, near=near[1], radius_p=radius_p, radius_q=radius_q)
    turn_q = turn_p + (rot_q[0] - ref.rot_q[0]) - (rot_p[0] - ref.rot_p[0])
    return jnp.stack([stretch + radius_p * turn_p - radius_q * turn_q, turn_p, turn_q])


def _free_length(e: Float[Array, "3"], ref: Reference, radius_p: Scalar, radius_q: Scalar):
    """Length without tension of the part between the tangent points."""
    start, _ = _span(ref.q - ref.p, radius_p, radius_q)
    return start - radius_p * e[1] + radius_q * e[2]


def _belt_energy(e: Array, *, ref, section: Section, radius_p, radius_q) -> Float[Array, ""]:
    """EA e1^2/(2 L) with the free length L: the belt on the pulleys has no tension."""
    return section.rigidity().EA * e[0] ** 2 / (2 * _free_length(e, ref, radius_p, radius_q))


def _belt_dissipation(e: Array, ed: Array, *, ref, damping: Damping, radius_p, radius_q) -> Float[Array, ""]:
    return damping.EA * ed[0] ** 2 / (2 * _free_length(e, ref, radius_p, radius_q))


def _check_belt(*, ref, radius_p, radius_q, section=None) -> list[str]:
    faults = _check_centres(ref=ref)
    distance = as_floats(ref.q) - as_floats(ref.p)
    if not faults and not holds((as_floats(radius_q) - as_floats(radius_p)) ** 2 < (distance**2).sum(axis=-1)):
        faults = ["has pulleys that overlap: no straight part of the belt is left between them"]
    if section is not None and not holds(as_floats(section.rigidity().mass) == 0):
        faults = [*faults, "has a section with mass, but no mass is counted here: put it on the nodes"]
    return faults


def _belt_shape(p: Array, rot_p: Array, q: Array, rot_q: Array, *, ref, place, radius_p, radius_q) -> Float[Array, "2"]:
    """Pulley p, the straight part and pulley q, a third of the places each."""
    d = q - p
    _, angle = _span(d, radius_p, radius_q)
    tangent = rotation_plane(angle) @ (d / jnp.sqrt(d @ d))
    normal = jnp.stack([-tangent[1], tangent[0]])
    leaving, arriving = p + radius_p * normal, q + radius_q * normal
    along = leaving + jnp.clip(3 * place - 1, 0.0, 1.0) * (arriving - leaving)
    after = jnp.where(place > 2 / 3, _around(q, arriving, 3 * place - 2), along)
    return jnp.where(place < 1 / 3, _around(p, leaving, 3 * place), after)


belt = Element(
    _belt,
    energy=_belt_energy,
    dissipation=_belt_dissipation,
    shape=_belt_shape,
    check=_check_belt,
    measured=(2, 3),
    names=("elongation", "turn_p", "turn_q"),
)
"""Belt between two pulleys: e1 elongation of the part between them [m]; e2 and e3 turns of the pulleys relative to the
belt [rad], measured. The stiffness EA/L and the damping EdA/L follow the free length L, which changes as the pulleys
turn.

Properties: radius_p and radius_q (positive if the belt, on its way from p to q, passes to the left of the centre,
negative if to the right), section (EA), damping (EA). Without a section the belt does not stretch.
"""


def _belt_to_point(
    p: Point2, rot_p: Angle, q: Point2, *, ref: Reference, near: Float[Array, "n_e"], radius_p: float
) -> Float[Array, "2"]:
    """Elongation, and turn of the pulley relative to the belt."""
    stretch, turn_p = _turns(p, rot_p, q, ref=ref, near=near[1], radius_p=radius_p, radius_q=0.0)
    return jnp.stack([stretch + radius_p * turn_p, turn_p])


def _with_point(e: Float[Array, "2"]) -> Float[Array, "3"]:
    return jnp.concatenate([e, jnp.zeros(1)])


def _point_energy(e: Array, *, ref, section: Section, radius_p) -> Float[Array, ""]:
    return _belt_energy(_with_point(e), ref=ref, section=section, radius_p=radius_p, radius_q=0.0)


def _point_dissipation(e: Array, ed: Array, *, ref, damping: Damping, radius_p) -> Float[Array, ""]:
    return _belt_dissipation(_with_point(e), _with_point(ed), ref=ref, damping=damping, radius_p=radius_p, radius_q=0.0)


def _check_point(*, ref, radius_p, section=None) -> list[str]:
    return _check_belt(ref=ref, radius_p=radius_p, radius_q=0.0, section=section)


def _point_shape(p: Array, rot_p: Array, q: Array, *, ref, place, radius_p) -> Float[Array, "2"]:
    return _belt_shape(p, rot_p, q, rot_p, ref=ref, place=place, radius_p=radius_p, radius_q=0.0)


belt_to_point = Element(
    _belt_to_point,
    energy=_point_energy,
    dissipation=_point_dissipation,
    shape=_point_shape,
    check=_check_point,
    measured=(2,),
    names=("elongation", "turn"),
)
"""Belt or rope from a pulley at p to the point q: e1 elongation [m]; e2 turn of the pulley relative to the belt [rad],
measured. Properties: see ``planar.belt``, with radius_p alone.
"""
