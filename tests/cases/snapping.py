"""Mechanisms that snap through or buckle, with closed forms."""

import numpy as np

import flexmb as fm
from flexmb import planar

BASE = 10.0


def truss(EA=1e4, height=1.0, base=BASE, load=5.0, sideways=False):
    """A7: two bars from (-base, 0) and (base, 0) to the apex (0, height), load down on the apex."""
    section = fm.Rigidity(EA=EA, mass=1.0)
    b = fm.Builder()
    for name, position in {"left": (-base, 0), "right": (base, 0), "apex": (0, height)}.items():
        b.node(name, position)
    b.add(planar.truss, "left", "apex", section=section)
    b.add(planar.truss, "apex", "right", section=section)
    b.fix("left")
    b.fix("right")
    if not sideways:
        b.fix("apex", "x")
    b.dof("apex", *(("x", "y") if sideways else ("y",)))
    b.force("apex", (0, -load))
    return b.build()


def load_at(y, EA=1e4, height=1.0, base=BASE):
    """Load down that holds the apex at height y on the axis of symmetry, closed form."""
    return 2 * EA * (1 / np.hypot(base, y) - 1 / np.hypot(base, height)) * y


def limit_of(EA, height):
    """A7, closed form."""
    return 2 * EA * (1 - (BASE / np.hypot(BASE, height)) ** (2 / 3)) ** 1.5


def toggle(EI, height, gap=0.0, *, follower=False, check=True):
    """Two clamped beams to an apex that stays on the axis; the left foot can be moved outwards."""
    section = fm.Rigidity(EA=1e4, EIy=EI, mass=1.0)
    b = fm.Builder()
    for name, position in {"left": (-BASE - gap, 0), "right": (BASE, 0), "apex": (0, height)}.items():
        b.node(name, position)
    for ends in (("left", "apex"), ("apex", "right")):
        b.add(planar.beam, *ends, section=section)
    b.fix("left")
    b.fix("right")
    if check:
        b.dof("beam 1", 1, 2, 3)
    b.force("apex", (0.0, -5.0), follower=follower)
    return b.build(check=check)


def column(beams, load, *, preload=0.0, bow=0.0, shortening=0.0):
    """Pinned column of length 2 along x, EI = 1: two cantilevers of length 1, back to back."""
    section = fm.Rigidity(EA=1e8, EIy=1.0, mass=1.0)
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(str(i), (2 * i / beams, bow * np.sin(np.pi * i / beams)))
    for i in range(beams):
        b.add(planar.beam, str(i), str(i + 1), section=section)
    b.fix("0", "x", "y")
    b.fix(str(beams), "y")
    if shortening:
        b.prescribe(str(beams), "x", -shortening)
    else:
        b.force(str(beams), (-load, 0), increment=preload > 0)
    if preload:
        b.force(str(beams), (-preload, 0))
    return b.build()


EULER = np.pi**2 / 4
