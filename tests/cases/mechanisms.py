"""Published mechanisms, each once: builder, data and source.

The tutorial is "Prototype modelling of mechanical systems", WA 1239, University of Twente, 2012; keys T1 to T7 are
those of the reference problems. Data: two leaf springs 0.1 x 0.018 x 0.0005 m of steel at a distance of 0.1 m, a bar of
0.2 kg on top, a voice coil of 0.006 kg on its right end.
"""

from typing import Any

import numpy as np

import flexmb as fm
from flexmb import planar, spatial

LENGTH, WIDTH, THICKNESS, DISTANCE = 0.1, 0.018, 0.0005, 0.1
BAR, COIL = 0.2, 0.006


def steel() -> fm.Material:
    return fm.Material(E=210e9, G=80e9, rho=7850.0)


def leaf(thickness=THICKNESS, width=WIDTH, rotary=False) -> fm.Rectangle:
    return fm.Rectangle(width, thickness, steel(), rotary=rotary)


def cart_on_rod(stiffness: Any, mass: Any, load: Any = 1.0, parts: int = 1) -> fm.Builder:
    """A cart that moves along x on a rod of length 1 of this stiffness, in so many parallel parts, under a load."""
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("cart", (1, 0))
    for i in range(parts):
        b.add(planar.truss, "wall", "cart", name=f"rod {i}" if i else "rod", section=fm.Rigidity(EA=stiffness / parts))
    b.fix("wall")
    b.fix("cart", "y")
    b.mass("cart", mass)
    b.force("cart", (load, 0))
    b.dof("cart", "x")
    return b


def truss_guide(dof: str = "x", damped: bool = True) -> fm.Builder:
    """T1: mass on a truss whose stiffness is that of both leaf springs in sway."""
    stiffness = 2 * 12 * leaf().rigidity().EIy / LENGTH**3
    ml = leaf().rigidity().mass
    section = fm.Rigidity(EA=stiffness * LENGTH, mass=ml)
    b = fm.Builder()
    b.node("1", (0, 0))
    b.node("2", (LENGTH, 0))
    # Damping of both leaf springs, 2 zeta sqrt(k m) with the mass of two, printed 0.0365 N s/m (2.15).
    damping = fm.Damping(EA=0.00365) if damped else None
    b.add(planar.truss, "1", "2", name="1", section=section, damping=damping)
    b.fix("1")
    b.fix("2", "y")
    b.mass("2", BAR + COIL + ml * LENGTH)  # the other leaf spring's distributed mass is in the truss
    if dof == "x":
        b.dof("2", "x")
    else:
        b.dof("1", 1, kind="element")
    b.input("2", "x")
    b.output("2", "x")
    return b


def planar_guide(
    thickness=THICKNESS,
    *,
    beams=1,
    elongation=False,
    second_order=True,
    inertia=None,
    force=None,
    ratio=None,
    dofs=True,
    rotary=False,
) -> fm.Builder:
    """T2 to T4: two leaf springs upright along y, a rigid bar on top; nodes A B C D from left foot to right foot."""
    b = fm.Builder()
    section = leaf(thickness, rotary=rotary)
    damping = None if ratio is None else fm.sections.damping_from_ratio(section, LENGTH, ratio)
    for name, x in (("left", 0.0), ("right", DISTANCE)):
        for i in range(beams + 1):
            b.node(f"{name}{i}", (x, LENGTH * i / beams))
        for i in range(beams):
            b.add(
                planar.beam,
                f"{name}{i}",
                f"{name}{i + 1}",
                name=f"{name} {i + 1}",
                section=section,
                damping=damping,
                second_order=second_order,
                released=(1, 2, 3) if elongation else (2, 3),
            )
        b.fix(f"{name}0")
    top = (f"left{beams}", f"right{beams}")
    b.add(planar.beam, *top, name="bar")
    for node in top:
        b.mass(node, (BAR + COIL) / 2, inertia=inertia)
    if force is not None:
        b.force(top[0], force)
    if dofs:
        b.dof(top[0], *(("x", "y", "phi") if elongation else ("x",)))
    b.input(top[1], "x")
    for node in top:
        for component in ("x", "y"):
            b.output(node, component)
    for node in top:
        b.output(node, "phi")
    return b


def spatial_guide(
    thickness=THICKNESS,
    width=WIDTH,
    *,
    beams=1,
    released=None,
    extra=(),
    force=None,
    ratio=None,
    dofs=True,
    rotary=False,
) -> fm.Builder:
    """T5 and its variants: leaf springs along z, bar along y, width along x; the local z of a leaf is its thickness.

    Args:
        thickness: Of a leaf spring [m].
        width: Of a leaf spring [m].
        beams: Beams a leaf spring.
        released: Deformations of the leaf springs, torsion and soft bending unless given.
        extra: Deformations of the right leaf spring released besides.
        force: Force on the right end of the bar.
        ratio: Damping ratio of (2.14).
        dofs: Name the sway y of the left end as degree of freedom.
        rotary: Rotary inertia of the sections.
    """
    released = (2, 3, 4) if released is None else released
    section = leaf(thickness, width, rotary=rotary)
    damping = None if ratio is None else fm.sections.damping_from_ratio(section, LENGTH, ratio)
    b = fm.Builder()
    for name, y in (("left", 0.0), ("right", DISTANCE)):
        for i in range(beams + 1):
            b.node(f"{name}{i}", (0, y, LENGTH * i / beams))
        for i in range(beams):
            own = released if released == "all" else tuple(released) + (tuple(extra) if name == "right" else ())
            b.add(
                spatial.beam,
                f"{name}{i}",
                f"{name}{i + 1}",
                name=f"{name} {i + 1}",
                section=section,
                damping=damping,
                y=(1, 0, 0),
                released=own,
            )
        b.fix(f"{name}0")
    top = (f"left{beams}", f"right{beams}")
    # The bar: 7690 kg/m^3 * 2.6e-5 m^3, not 0.2 kg (T5).
    bar = fm.Rigidity(mass=7690 * 2.6e-5 / DISTANCE)
    b.add(spatial.beam, *top, name="bar", section=bar, released=(), y=(1, 0, 0))
    b.mass(top[1], COIL)
    if force is not None:
        b.force(top[1], force)
    if dofs:
        b.dof(top[0], "y")
    b.input(top[1], "y")
    for node in top:
        for component in ("x", "y", "z"):
            b.output(node, component)
    return b


def guide_with_ports(element: Any, **properties: Any) -> fm.Model:
    """The guide of T2 with these leaf springs and 0.1 kg at both ends of its bar, with a force and a position."""
    b = fm.Builder()
    places = {"A": (0, 0), "B": (0, LENGTH), "C": (DISTANCE, LENGTH), "D": (DISTANCE, 0)}
    for name, place in places.items():
        b.node(name, place)
    for name, ends in (("left", "AB"), ("right", "DC")):
        b.add(element, *ends, name=name, section=leaf(), **properties)
    b.add(planar.beam, "B", "C", name="stage")
    for foot in "AD":
        b.fix(foot)
    for end in "BC":
        b.mass(end, 0.1)
    b.input("C", "x", name="force")
    b.output("B", "x", name="position")
    return b.build()


def braced_rectangle() -> fm.Builder:
    """Six bars on four pins, 3 by 4 m: one too many. The forces of its self-stress go with the lengths of the bars."""
    b = fm.Builder()
    for name, place in {"a": (0, 0), "b": (3, 0), "c": (3, 4), "d": (0, 4)}.items():
        b.node(name, place)
    for bar in ("ab", "bc", "cd", "da", "ac", "bd"):
        b.add(planar.truss, bar[0], bar[1], name=bar, released=())
    b.fix("a")
    b.fix("b", "y")
    return b


def cross_pivot(fraction, angle) -> fm.Builder:
    """B3: two leaf springs at right angles that cross at a fraction of their length; the body turned by an angle.

    L = EI = 1, extension a billion times stiffer; one spectral beam of order six a leaf spring.
    """
    b = fm.Builder()
    section = fm.Rigidity(EA=1e9, EIy=1.0)
    d = np.array([1.0, 1.0]) / np.sqrt(2)
    b.node("body", (0, 0))
    for name, along in (("a", d), ("b", d * [-1, 1])):
        b.node(f"{name} foot", -fraction * along)
        b.node(f"{name} top", (1 - fraction) * along)
        b.add(planar.spectral_beam(6), f"{name} foot", f"{name} top", name=name, section=section)
        b.fix(f"{name} foot")
        b.add(planar.beam, "body", f"{name} top", name=f"arm {name}")
    b.prescribe("body", "phi", angle)
    return b
