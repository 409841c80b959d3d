"""Springs that constrain one direction and leave the others free: folded leaf spring and wire flexure."""

from typing import Any

import jax.numpy as jnp
import numpy as np

from ..arguments import check_number, is_concrete
from ..build.builder import Builder
from ..elements.sections import Scalar, Section
from ..errors import ModelError
from .site import Site, Vector


def folded_leaf_spring(
    b: Builder,
    base: str,
    stage: str,
    *,
    length: Scalar,
    section: Section,
    second: Scalar | None = None,
    fold: Scalar = np.pi / 2,
    name: str = "folded",
    at: Vector | None = None,
    along: Vector | None = None,
    y: Vector | None = None,
    element: Any = None,
) -> str:
    """Leaf spring with a fold: it constrains its end along the fold line and leaves the five other motions free.

    If the end may turn, two equal legs at a right angle have the compliance 2 (length^3/(3 EIz) + length/(GA k)) +
    length^3/GIt along the fold line by beam theory, with EIz in the plane of a leg. Restrained warping makes them
    stiffer, by some 14 % for a width of a third of a leg's length. ``build()`` decides by the numbers whether the legs
    form a fold. If sizes are traced, it cannot read them by itself: build the model in a function that you pass to
    ``fm.tune``, ``fm.sweep`` or the like.

    Args:
        b: Builder of the mechanism.
        base: Name of the node whose body the first leg stands on.
        stage: Name of the node whose body the second leg carries; made at its end.
        length: Length of the first leg, () [m].
        section: Section of both legs.
        second: Length of the second leg, () [m]; by default equal to the first.
        fold: Angle by which the second leg turns from the first towards ``along`` × ``y``, () [rad].
        name: See :func:`flexmb.blocks.parallel_guide`, also for at, along, y and element. The first leg is parallel to
            ``along``; the fold line is parallel to ``y``, or perpendicular to a planar mechanism.
        at, along, y, element: The same.

    Returns:
        Name of the stage. Nodes: "<name> fold"; "<name> foot" and "<name> top", rigidly attached to base and stage;
        elements "<name> leaf 1" and 2.

    Raises:
        ModelError: See :func:`flexmb.blocks.parallel_guide`; a length that is not positive.

    Source:
        THEORY.md 13, eq. (13.6), (13.11).
    """
    second = length if second is None else second
    s = Site(b, base, stage, name, at, along, y, element, length=length, second=second)
    check_number("fold", fold, fault=ModelError)
    xp: Any = np if is_concrete(fold) else jnp
    end = length + second * xp.cos(fold), second * xp.sin(fold)
    s.body(s.stage, *end)
    foot, middle, top = s.clamp("foot", (s.base, ())), s.inner("fold", length), s.clamp("top", (s.stage, end))
    leaf = s.leaf_spring(section)
    s.beam("leaf 1", (foot, s.base), (middle, middle), *leaf)
    s.beam("leaf 2", (middle, middle), (top, s.stage), *leaf)
    return s.stage


def wire_flexure(
    b: Builder,
    base: str,
    stage: str,
    *,
    length: Scalar,
    section: Section,
    name: str = "wire",
    at: Vector | None = None,
    along: Vector | None = None,
    y: Vector | None = None,
    element: Any = None,
) -> str:
    """Wire: it constrains its end along the wire and leaves the five other motions free.

    Stiffness EA/length along it, 12 EI/length^3 across it if the end does not turn, GIt/length in torsion.

    Args:
        b: Builder of the mechanism.
        base: Name of the node whose body the wire stands on.
        stage: Name of the node whose body the block carries; made at its end.
        length: Length of the wire, () [m].
        section: Section of the wire, such as ``fm.Circle(diameter, material)``.
        name: See :func:`flexmb.blocks.parallel_guide`, also for at, along, y and element.
        at, along, y, element: The same.

    Returns:
        Name of the stage. Nodes: "<name> foot" and "<name> top", rigidly attached to base and stage; element "<name>
        wire".

    Raises:
        ModelError: See :func:`flexmb.blocks.parallel_guide`; a length that is not positive.

    Source:
        THEORY.md 13, eq. (13.1).
    """
    s = Site(b, base, stage, name, at, along, y, element, length=length)
    s.body(s.stage, length)
    foot, top = s.clamp("foot", (s.base, ())), s.clamp("top", (s.stage, (length,)))
    s.beam("wire", (foot, s.base), (top, s.stage), *s.slender(section))
    return s.stage
