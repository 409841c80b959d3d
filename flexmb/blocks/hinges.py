"""Notch hinges, and guides on notch hinges: bars that bend at thin necks between notches."""

from typing import Any

from ..arguments import holds, nan_if_refused
from ..build.builder import Builder
from ..elements.necks import notch_length
from ..elements.sections import Material, Scalar, hinge_circular, notch_circular
from ..errors import ModelError
from .site import Site, Vector


def notch_hinge(
    b: Builder,
    base: str,
    stage: str,
    *,
    width: Scalar,
    height: Scalar,
    neck: Scalar,
    radius: Scalar,
    material: Material,
    name: str = "hinge",
    at: Vector | None = None,
    along: Vector | None = None,
    y: Vector | None = None,
    element: Any = None,
) -> str:
    """Add a circular notch hinge: a bar with a round notch on both sides. The block ends at the rims of the notch.

    Its six stiffnesses are within 5 % of solid elements if neck/radius is at most 0.2 and the width at least twice
    sqrt(radius neck). A thin and narrow neck has the rotational stiffness 2 E width neck^(5/2)/(9 pi radius^(1/2)). The
    stiffness of a wide neck is up to 1/(1 - nu^2) times as large. If you choose an ``element``, its section follows
    plain beam theory, without the fit to solid elements. For another notch, use :func:`flexmb.blocks.wire_flexure` with
    a section such as ``fm.sections.notch_filleted(..)``.

    Args:
        b: Builder of the mechanism.
        base: Name of the node whose body has the first rim of the notch.
        stage: Name of the node whose body has the second rim; created at this rim if absent.
        width: Width of the bar along the axis of the hinge, () [m].
        height: Height of the bar beside the notch, () [m].
        neck: Height of the remaining neck, () [m].
        radius: Radius of the notch, () [m]; at least half of height - neck.
        material: Material of the bar.
        name: See :func:`flexmb.blocks.parallel_guide`, also for at, along, y and element; ``y`` is the axis.
        at, along, y, element: The same.

    Returns:
        Name of the stage. Nodes: "<name> foot" and "<name> top", rigidly attached to base and stage; element "<name>
        notch".

    Raises:
        ModelError: See :func:`flexmb.blocks.parallel_guide`; a size that is not positive, a neck higher than the bar, a
            notch deeper than its radius.

    Source:
        THEORY.md 13, eq. (13.7), and 2, eq. (2.60) and (2.61).
    """
    s = Site(b, base, stage, name, at, along, y, element)
    end = notch_length(height, neck, radius)
    hinge = _hinge(s, width, height, neck, radius, material)
    s.body(s.stage, end)
    foot, top = s.clamp("foot", (s.base, ())), s.clamp("top", (s.stage, (end,)))
    s.beam("notch", (foot, s.base), (top, s.stage), *hinge)
    return s.stage


def notch_four_bar(
    b: Builder,
    base: str,
    stage: str,
    *,
    length: Scalar,
    spacing: Scalar,
    width: Scalar,
    height: Scalar,
    neck: Scalar,
    radius: Scalar,
    material: Material,
    name: str = "guide",
    at: Vector | None = None,
    along: Vector | None = None,
    y: Vector | None = None,
    element: Any = None,
) -> str:
    """Add a parallel guide of two bars with a circular notch hinge at each end: a parallelogram of four hinges.

    The drive stiffness is 4 k/length^2, with the rotational stiffness k of a hinge (see :func:`notch_hinge`). The bars
    are rigid between their notches.

    Args:
        b: Builder of the mechanism.
        base: Name of the node of the fixed body.
        stage: Name of the node of the moving body; created in the middle of the tops if absent.
        length: Distance between the middles of the two hinges of a bar, () [m].
        spacing: Distance between the bars, () [m].
        width: See :func:`notch_hinge`, also for height, neck, radius and material.
        height, neck, radius, material: The same.
        name: See :func:`flexmb.blocks.parallel_guide`, also for at, along, y and element.
        at, along, y, element: The same.

    Returns:
        Name of the stage. Nodes: "<name> foot 1", "<name> bar 1", "<name> upper 1", "<name> top 1" and the same of bar
        2; elements "<name> lower hinge 1", "<name> upper hinge 1" and the same of bar 2.

    Raises:
        ModelError: See :func:`flexmb.blocks.parallel_guide` and :func:`notch_hinge`; a bar shorter than its notches.

    Source:
        THEORY.md 13, eq. (13.7), (13.8).
    """
    s = Site(b, base, stage, name, at, along, y, element, length=length, spacing=spacing)
    hinge = _hinge(s, width, height, neck, radius, material)
    notch = notch_length(height, neck, radius)
    with nan_if_refused() as marked:
        if not holds(length > notch):
            raise ModelError(f"Argument `length` must exceed the length of a notch, {notch:g} m, but is {length:g}.")
        length = marked(length)
    s.body(s.stage, length + notch)
    for label, across in (("1", -spacing / 2), ("2", spacing / 2)):
        foot = s.clamp(f"foot {label}", (s.base, (0.0, across)))
        bar = s.inner(f"bar {label}", notch, across)
        upper = s.clamp(f"upper {label}", (bar, (length, across)))
        top = s.clamp(f"top {label}", (s.stage, (length + notch, across)))
        s.beam(f"lower hinge {label}", (foot, s.base), (bar, bar), *hinge)
        s.beam(f"upper hinge {label}", (upper, bar), (top, s.stage), *hinge)
    return s.stage


def _hinge(s: Site, *sizes: Any) -> tuple[Any, Any]:
    """Element type of a hinge and its section; a given element has the section of plain beam theory."""
    if s.element is not None:
        return s.element, notch_circular(*sizes)
    # Order 3 suffices at any stroke, since resultants along a hinge are smooth.
    return s.spectral_beam(order=3, shear=True), hinge_circular(*sizes)
