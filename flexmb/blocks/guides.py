"""Guides: stages on parallel leaf springs that move along a line, or along two.

The drive stiffnesses are those of clamped beams in sway, THEORY.md 13, eq. (13.1), in parallel and in series. Leaf
springs, which the blocks are made of, are plates near their clamps and make all of them stiffer by the same factor, eq.
(13.9): 1.04 where their width is a fifth of their length.
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

    Drive stiffness 24 EI/length^3 by beam theory, with EI of one leaf spring; along the leaf springs 2 EA/length. The
    stage sinks by 3/5 of the square of its stroke over the length.

        stage ___________
               |       |
               |       |    along, length
        base __|_______|__
               spacing

    Args:
        b: Builder of the mechanism.
        base: Name of the node whose body the block stands on. It must be there.
        stage: Name of the node whose body it carries. Where it is not there, it is made in the middle of the tops.
        length: Of the leaf springs, () [m].
        spacing: Distance between the leaf springs, () [m].
        section: Of one leaf spring, such as ``fm.Rectangle(width, thickness, material)``.
        name: Of the block; the names of its own nodes and elements begin with it.
        at: The middle between the feet, (d,) [m]; the place of ``base`` unless given. Base and stage may be anywhere:
            they are rigid bodies.
        along: Direction of the leaf springs from base to stage, (d,) [-]; (0, 1) or (0, 1, 0) unless given.
        y: Direction of their width, in space only, (3,) [-]; (0, 0, 1) unless given. The stage moves along
            ``along`` × ``y``.
        element: Type of the flexible elements, such as ``spatial.beam``, instead of what the block takes:
            ``leaf_spring`` for a rectangle that is the same everywhere or varies smoothly, else a spectral beam.

    Returns:
        Name of the stage. Nodes: "<name> foot 1", "<name> top 1" and the same of leaf 2, rigidly attached to base and
        stage; elements "<name> leaf 1" and 2.

    Raises:
        ModelError: No such base, a name that is taken, or directions that are none; a size that is not positive.

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
    """Folded guide: a parallel guide that hangs in another one, so that the stage moves on a straighter line.

    Drive stiffness 12 EI/length^3 by beam theory: two parallel guides in series. What one sinks the other lifts. The
    middle body is held along the line of motion by the leaf springs alone.

    Args:
        b: Builder of the mechanism.
        base: Name of the node whose body the block stands on, by its outer leaf springs.
        stage: Name of the node whose body the inner leaf springs carry; made in the middle of their ends, which lie
            beside the feet.
        length: Of the leaf springs, () [m].
        spacing: Distance between the two that stand on the base, () [m].
        inner: Distance between the two that carry the stage, () [m]; it may be the larger one.
        section: Of one leaf spring.
        name: See :func:`parallel_guide`, also for at, along, y and element.
        at, along, y, element: The same.

    Returns:
        Name of the stage. Nodes and elements are those of two parallel guides, "<name> outer" and "<name> inner", and
        the body "<name> middle", on which one may put a mass.

    Raises:
        ModelError: See :func:`parallel_guide`; a size that is not positive.

    Source:
        THEORY.md 13, eq. (13.1), (13.2).
    """
    s = Site(b, base, stage, name, at, along, y, element, length=length, spacing=spacing, inner=inner)
    own: dict[str, Any] = {"length": length, "section": section, "y": y, "element": element}
    middle = parallel_guide(
        b, s.base, s.inner("middle", length), spacing=spacing, name=f"{name} outer", at=s.origin, along=along, **own
    )
    s.body(s.stage)
    return parallel_guide(
        b, middle, s.stage, spacing=inner, name=f"{name} inner", at=s.place(length), along=-s.axes[0], **own
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
    """Two folded guides, one the mirror image of the other: the stage moves on a straight line and does not turn.

    Drive stiffness 24 EI/length^3 by beam theory: four leaf springs beside each other, twice in series. By symmetry the
    stage neither sinks nor turns, at any stroke.

    Args:
        b: Builder of the mechanism.
        base: Name of the node whose body the block stands on.
        stage: Name of the node whose body it carries; made in the middle of the block.
        length: Of the leaf springs, () [m].
        spacing: Distance between the two of each side that stand on the base, () [m].
        inner: Distance between the two of each side that carry the stage, () [m].
        height: Distance between the feet of the two sides, () [m].
        section: Of one leaf spring.
        name: See :func:`parallel_guide`, also for at, along, y and element; the block's middle is at ``at``.
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
    own: dict[str, Any] = {"length": length, "spacing": spacing, "inner": inner, "section": section}
    for label, side in (("1", 1.0), ("2", -1.0)):
        double_parallel_guide(
            b,
            s.base,
            s.stage,
            name=f"{name} {label}",
            at=s.place(side * height / 2),
            along=side * s.axes[0],
            y=y,
            element=element,
            **own,
        )
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

    Drive stiffness 12 EI/length^3 by beam theory along both lines, small strokes. The first guide, on the base, moves
    the second one across ``along``; the second moves the stage along it.

    Args:
        b: Builder of the mechanism.
        base: Name of the node whose body the block stands on.
        stage: Name of the node whose body it carries; made in the middle of the feet.
        length: Of the leaf springs, () [m].
        spacing: Of each guide: distance between the two leaf springs that stand on what carries it, () [m].
        inner: Of each guide: distance between the two that carry, () [m].
        section: Of one leaf spring.
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
    own: dict[str, Any] = {"length": length, "spacing": spacing, "inner": inner, "section": section}
    carriage = s.inner("carriage")
    own |= {"at": s.origin, "y": y, "element": element}
    double_parallel_guide(b, s.base, carriage, name=f"{name} 1", along=along, **own)
    return double_parallel_guide(b, carriage, s.body(s.stage), name=f"{name} 2", along=s.axes[1], **own)
