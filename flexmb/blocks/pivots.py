"""Pivots: leaf springs whose lines meet in an axis, about which the stage turns.

The line of a leaf spring meets the axis at the fraction lambda of its length, measured from either end; the axis may
lie beyond the ends. The rotational stiffness is 4 EI/L (1 - 3 lambda + 3 lambda^2) by beam theory: THEORY.md 13, eq.
(13.3). The clamps make the leaf spring stiffer, eq. (13.10): by 1 to 6 % if the width is a fifth of the length.
"""

from typing import Any

import jax.numpy as jnp
import numpy as np

from ..arguments import check_number, holds, is_concrete, nan_if_refused
from ..build.builder import Builder
from ..elements.sections import Scalar, Section
from ..errors import ModelError
from .site import Site, Vector


def cross_pivot(
    b: Builder,
    base: str,
    stage: str,
    *,
    length: Scalar,
    section: Section,
    ratio: Scalar = 0.5,
    half_angle: Scalar = np.pi / 4,
    apart: Scalar | None = None,
    name: str = "pivot",
    at: Vector | None = None,
    along: Vector | None = None,
    y: Vector | None = None,
    element: Any = None,
) -> str:
    """Two crossed leaf springs.

    Rotational stiffness 8 EI/length (1 - 3 ratio + 3 ratio^2) by beam theory: 2 EI/length for a crossing in the middle.
    The axis shifts least for a ratio of 0.1273 or 0.8727.

    Args:
        b: Builder of the mechanism.
        base: Name of the node whose body the block stands on.
        stage: Name of the node whose body the block carries; made in the middle of the tops.
        length: Length of the leaf springs, () [m].
        section: Section of one leaf spring.
        ratio: Place of the crossing as a fraction of their length from the base, () [-].
        half_angle: Angle between a leaf spring and ``along``, () [rad].
        apart: Distance between the leaf springs along their width, in space only, () [m]. By default both lie in one
            plane. This also models a pivot of three leaf springs: two parallel leaf springs of half the width, and one
            between them that crosses both.
        name: See :func:`flexmb.blocks.parallel_guide`, also for at, along, y and element.
        at, along, y, element: The same.

    Returns:
        Name of the stage. Nodes: "<name> foot 1", "<name> top 1" and the same for leaf 2, and "<name> axis", the point
        of the stage on the axis; elements "<name> leaf 1" and 2.

    Raises:
        ModelError: See :func:`flexmb.blocks.parallel_guide`; ``apart`` is given in the plane; the length is not
            positive, or the angle is not between 0 and a right angle.

    Source:
        THEORY.md 13, eq. (13.3), (13.4), (13.10).
    """
    s = Site(b, base, stage, name, at, along, y, element, length=length)
    check_number("ratio", ratio, fault=ModelError)
    if apart is not None:
        check_number("apart", apart, fault=ModelError)
        if s.y is None:
            raise ModelError(f"Argument `apart` of block '{name}' is for mechanisms in space.")
    cos, sin = _cos_and_sin(half_angle)
    height, axis = length * cos, ratio * length * cos
    s.body(s.stage, height)
    for label, side in (("1", -1.0), ("2", 1.0)):
        width = () if apart is None else (side * apart / 2,)
        foot, top = side * ratio * length * sin, -side * (1 - ratio) * length * sin
        s.leaf(label, (s.base, (0.0, foot, *width)), (s.stage, (height, top, *width)), section)
    s.clamp("axis", (s.stage, (axis,)))
    return s.stage


def butterfly_pivot(
    b: Builder,
    base: str,
    stage: str,
    *,
    length: Scalar,
    radius: Scalar,
    section: Section,
    half_angle: Scalar = np.pi / 4,
    name: str = "pivot",
    at: Vector | None = None,
    along: Vector | None = None,
    y: Vector | None = None,
    element: Any = None,
) -> str:
    """Two pivots in series about one axis, each of two leaf springs, with opposite shifts of the axis.

    Rotational stiffness 4 EI/length (1 + 3 n + 3 n^2) by beam theory, with n = radius/length. The lower leaf springs
    stand on the base and carry a middle body near the axis. This body reaches around the upper leaf springs, which come
    back from their far ends towards the axis and carry the stage there. Each pivot turns by half of the angle.

    Args:
        b: Builder of the mechanism.
        base: Name of the node whose body the block stands on.
        stage: Name of the node whose body the block carries; made between the inner ends of the upper leaf springs.
        length: Length of the leaf springs, () [m].
        radius: Distance of their inner ends from the axis, () [m].
        section: Section of one leaf spring.
        half_angle: Angle between a leaf spring and ``along``, () [rad].
        name: See :func:`flexmb.blocks.parallel_guide`, also for at, along, y and element.
        at, along, y, element: The same.

    Returns:
        Name of the stage. Nodes: "<name> middle", a body that may get a mass; "<name> foot 1" and "<name> top 1" to 4,
        the ends of the leaf springs, 1 and 2 the lower ones; "<name> axis", the point of the stage on the axis;
        elements "<name> leaf 1" to 4.

    Raises:
        ModelError: See :func:`flexmb.blocks.parallel_guide`; a size that is not positive, an angle that is not between
            0 and a right angle.

    Source:
        THEORY.md 13, eq. (13.3), (13.5), (13.10).
    """
    s = Site(b, base, stage, name, at, along, y, element, length=length, radius=radius)
    cos, sin = _cos_and_sin(half_angle)
    axis = (radius + length) * cos

    def end(direction: float, side: float, far: bool) -> tuple[Scalar, Scalar]:
        distance = radius + length if far else radius
        return axis + direction * distance * cos, side * distance * sin

    middle = s.inner("middle", axis - radius * cos)
    s.body(s.stage, axis + radius * cos)
    for number, side in enumerate((-1.0, 1.0), 1):
        s.leaf(f"{number}", (s.base, end(-1, side, far=True)), (middle, end(-1, side, far=False)), section)
        s.leaf(f"{number + 2}", (middle, end(1, side, far=True)), (s.stage, end(1, side, far=False)), section)
    s.clamp("axis", (s.stage, (axis,)))
    return s.stage


def cartwheel(
    b: Builder,
    base: str,
    stage: str,
    *,
    length: Scalar,
    section: Section,
    half_angle: Scalar = np.pi / 4,
    name: str = "pivot",
    at: Vector | None = None,
    along: Vector | None = None,
    y: Vector | None = None,
    element: Any = None,
) -> str:
    """Two crossed leaf springs in one piece: four spokes that meet in a hub.

    Rotational stiffness 8 EI/length by beam theory, four times the stiffness of separate crossed leaf springs, since
    each spoke bends as if clamped at the axis.

    Args:
        b: Builder of the mechanism.
        base: Name of the node whose body the block stands on.
        stage: Name of the node whose body the block carries; made in the middle of the tops.
        length: Length from foot to top, twice the length of a spoke, () [m].
        section: Section of one spoke.
        half_angle: Angle between a spoke and ``along``, () [rad].
        name: See :func:`flexmb.blocks.parallel_guide`, also for at, along, y and element.
        at, along, y, element: The same.

    Returns:
        Name of the stage. Nodes: "<name> hub"; "<name> foot 1" and "<name> top 1" to 4, the ends of the spokes, 1 and 2
        the lower ones; "<name> axis", the point of the stage on the axis; elements "<name> leaf 1" to 4.

    Raises:
        ModelError: See :func:`flexmb.blocks.parallel_guide`; a length that is not positive, an angle that is not
            between 0 and a right angle.

    Source:
        THEORY.md 13, eq. (13.3), (13.5), (13.10).
    """
    s = Site(b, base, stage, name, at, along, y, element, length=length)
    cos, sin = _cos_and_sin(half_angle)
    axis, reach = length / 2 * cos, length / 2 * sin
    hub = s.inner("hub", axis)
    s.body(s.stage, 2 * axis)
    for number, side in enumerate((-reach, reach), 1):
        s.leaf(f"{number}", (s.base, (0.0, side)), (hub, (axis,)), section)
        s.leaf(f"{number + 2}", (hub, (axis,)), (s.stage, (2 * axis, side)), section)
    s.clamp("axis", (s.stage, (axis,)))
    return s.stage


def _cos_and_sin(half_angle: Scalar) -> tuple[Any, Any]:
    with nan_if_refused() as marked:
        check_number("half_angle", half_angle, above=0, fault=ModelError)
        if not holds(half_angle < np.pi / 2):
            raise ModelError(f"Argument `half_angle` must be smaller than a right angle, but is {half_angle:g} rad.")
        half_angle = marked(half_angle)
    xp: Any = np if is_concrete(half_angle) else jnp
    return xp.cos(half_angle), xp.sin(half_angle)
