"""Guides: stages on parallel leaf springs that move along one line or two.

Drive stiffnesses follow from clamped beams in sway, in parallel and in series: THEORY.md 13, eq. (13.1). Near its
clamps a leaf spring acts as a plate. This multiplies its stiffness by a factor, eq. (13.9): 1.04 if the width is a
fifth of the length.
"""

from typing import Any

from ..build.builder import Builder
from ..elements.sections import Scalar, Section
from .site import Site, Vector


def parallel_guide(
    b: Builder,
    base: str,
    stage: str,
    *,
    length: Scalar,
    spacing: Scalar,
    section: Section,
    name: str = "guide",
    at: Vector | None = None,
    along: Vector | None = None,
    y: Vector | None = None,
    element: Any = None,
) -> str:
    """Two parallel leaf springs: the stage moves across them.

    By beam theory, the drive stiffness is 24 EI/length^3 and the stiffness along the leaf springs is 2 EA/length, with
    EI and EA of one leaf spring. At a stroke d the stage sinks by 3/5 d^2/length.

        stage ___________
               |       |
               |       |    along, length
        base __|_______|__
               spacing

    Args:
        b: Builder of the mechanism.
        base: Name of the node whose body the block stands on. The node must exist.
        stage: Name of the node whose body the block carries. If it does not exist, it is made in the middle of the
            tops.
        length: Length of the leaf springs, () [m].
        spacing: Distance between the leaf springs, () [m].
        section: Section of one leaf spring, such as ``fm.Rectangle(width, thickness, material)``.
        name: Name of the block. The names of its nodes and elements begin with this name.
        at: Middle between the feet, (d,) [m]; by default the place of ``base``. Base and stage are rigid bodies and may
            be anywhere.
        along: Direction of the leaf springs from base to stage, (d,) [-]; by default (0, 1) or (0, 1, 0).
        y: Direction of their width, in space only, (3,) [-]; by default (0, 0, 1). The stage moves along
            ``along`` × ``y``.
        element: Type of the flexible elements, such as ``spatial.beam``. By default ``leaf_spring`` for a rectangle
            that is uniform or varies smoothly, else a spectral beam.

    Returns:
        Name of the stage. Nodes: "<name> foot 1", "<name> top 1" and the same for leaf 2, rigidly attached to base and
        stage; elements "<name> leaf 1" and 2.

    Raises:
        ModelError: The base does not exist, a name exists already, a direction is invalid, or a size is not positive.

    Source:
        THEORY.md 13, eq. (13.1), (13.2), (13.9).
    """
    s = Site(b, base, stage, name, at, along, y, element, length=length, spacing=spacing)
    s.body(s.stage, length)
    for label, across in (("1", -spacing / 2), ("2", spacing / 2)):
        s.leaf(label, (s.base, (0.0, across)), (s.stage, (length, across)), section)
    return s.stage


def double_parallel_guide(
    b: Builder,
    base: str,
    stage: str,
    *,
    length: Scalar,
    spacing: Scalar,
    inner: Scalar,
    section: Section,
    name: str = "guide",
    at: Vector | None = None,
    along: Vector | None = None,
    y: Vector | None = None,
    element: Any = None,
) -> str:
    """Folded guide: a parallel guide that hangs in another parallel guide. The stage moves on a straighter line.

    Drive stiffness 12 EI/length^3 by beam theory: two parallel guides in series. One guide sinks as far as the other
    rises. Only the leaf springs hold the middle body along the line of motion.

    Args:
        b: Builder of the mechanism.
        base: Name of the node whose body carries the outer leaf springs.
        stage: Name of the node whose body the inner leaf springs carry. If it does not exist, it is made in the middle
            between the ends of the inner leaf springs, level with the feet of the outer leaf springs.
        length: Length of the leaf springs, () [m].
        spacing: Distance between the outer leaf springs, on the base, () [m].
        inner: Distance between the inner leaf springs, which carry the stage, () [m]; it may be larger.
        section: Section of one leaf spring.
        name: See :func:`parallel_guide`, also for at, along, y and element.
        at, along, y, element: The same.

    Returns:
        Name of the stage. Nodes and elements are those of two parallel guides, "<name> outer" and "<name> inner", and
        the body "<name> middle", which may get a mass.

    Raises:
        ModelError: See :func:`parallel_guide`; a size that is not positive.

    Source:
        THEORY.md 13, eq. (13.1), (13.2).
    """
    s = Site(b, base, stage, name, at, along, y, element, length=length, spacing=spacing, inner=inner)
    shared: dict[str, Any] = {"length": length, "section": section, "y": y, "element": element}
    middle = parallel_guide(
        b, s.base, s.inner("middle", length), spacing=spacing, name=f"{name} outer", at=s.origin, along=along, **shared
    )
    s.body(s.stage)
    return parallel_guide(
        b, middle, s.stage, spacing=inner, name=f"{name} inner", at=s.place(length), along=-s.axes[0], **shared
    )


def straight_line_stage(
    b: Builder,
    base: str,
    stage: str,
    *,
    length: Scalar,
    spacing: Scalar,
    inner: Scalar,
    height: Scalar,
    section: Section,
    name: str = "stage",
    at: Vector | None = None,
    along: Vector | None = None,
    y: Vector | None = None,
    element: Any = None,
) -> str:
    """Two folded guides, mirror images of each other: the stage moves on a straight line and does not turn.

    Drive stiffness 24 EI/length^3 by beam theory: four leaf springs in parallel, twice in series. By symmetry the stage
    neither sinks nor turns, at any stroke.

    Args:
        b: Builder of the mechanism.
        base: Name of the node whose body the block stands on.
        stage: Name of the node whose body the block carries; made in the middle of the block.
        length: Length of the leaf springs, () [m].
        spacing: Distance between the outer leaf springs of each side, on the base, () [m].
        inner: Distance between the inner leaf springs of each side, which carry the stage, () [m].
        height: Distance between the feet of the two sides, () [m].
        section: Section of one leaf spring.
        name: See :func:`parallel_guide`, also for at, along, y and element; ``at`` is the middle of the block.
        at, along, y, element: The same.

    Returns:
        Name of the stage. Nodes and elements are those of two folded guides, "<name> 1" (along) and "<name> 2".

    Raises:
        ModelError: See :func:`parallel_guide`; a size that is not positive.

    Source:
        THEORY.md 13, eq. (13.1).
    """
    s = Site(b, base, stage, name, at, along, y, element, height=height)
    s.body(s.stage)
    shared: dict[str, Any] = {"length": length, "spacing": spacing, "inner": inner, "section": section}
    shared |= {"y": y, "element": element}
    for label, side in (("1", 1.0), ("2", -1.0)):
        at, along = s.place(side * height / 2), side * s.axes[0]
        double_parallel_guide(b, s.base, s.stage, name=f"{name} {label}", at=at, along=along, **shared)
    return s.stage


def xy_stage(
    b: Builder,
    base: str,
    stage: str,
    *,
    length: Scalar,
    spacing: Scalar,
    inner: Scalar,
    section: Section,
    name: str = "xy",
    at: Vector | None = None,
    along: Vector | None = None,
    y: Vector | None = None,
    element: Any = None,
) -> str:
    """Two folded guides in series at a right angle: the stage moves in a plane and hardly turns.

    Drive stiffness 12 EI/length^3 by beam theory along both lines, at small strokes. The first guide, on the base,
    moves the second one across ``along``; the second moves the stage along it.

    Args:
        b: Builder of the mechanism.
        base: Name of the node whose body the block stands on.
        stage: Name of the node whose body the block carries; made in the middle of the feet.
        length: Length of the leaf springs, () [m].
        spacing: Distance between the outer leaf springs of each guide, () [m].
        inner: Distance between the inner leaf springs of each guide, () [m].
        section: Section of one leaf spring.
        name: See :func:`parallel_guide`, also for at, along, y and element.
        at, along, y, element: The same.

    Returns:
        Name of the stage. Nodes and elements are those of two folded guides, "<name> 1" and "<name> 2", and the body
        "<name> carriage" between them.

    Raises:
        ModelError: See :func:`parallel_guide`; a size that is not positive.

    Source:
        THEORY.md 13, eq. (13.1).
    """
    s = Site(b, base, stage, name, at, along, y, element)
    shared: dict[str, Any] = {"length": length, "spacing": spacing, "inner": inner, "section": section}
    carriage = s.inner("carriage")
    shared |= {"at": s.origin, "y": y, "element": element}
    double_parallel_guide(b, s.base, carriage, name=f"{name} 1", along=along, **shared)
    return double_parallel_guide(b, carriage, s.body(s.stage), name=f"{name} 2", along=s.axes[1], **shared)
