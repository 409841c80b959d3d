"""The solid models of the cases of ``solid.py``: geometry, loads, and what is read off, in metres and newtons.

A leaf spring lies along x, its width along y, its thickness along z. Held faces are clamped whole; what moves is a
rigid body on the face of the tip (or on those of two leaf springs), unless the tip is said to be free. "Stiffness along
or about" a direction is the inverse of the body's displacement there under a unit force or moment, all else free.
"""

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from solid_models import Mesh, Printed, graded, run, step

MATERIAL = {"E": 210e9, "nu": 0.3, "rho": 7850.0, "alpha": 11.5e-6}
LENGTH, THICKNESS, DISTANCE = 0.1, 0.0005, 0.1
WIDTH, WIDE = 0.018, 0.05
STROKES = (0.005, 0.010)
ANGLE = np.radians(10)
# Of the pivot: the middles of its leaf springs along the axis.
OFFSET = 0.010
# Taper, reinforced middle, notch.
THIN, THICK, MIDDLE = 0.0003, 0.005, (0.2, 0.8)
NECK, BAR, RADIUS, NOTCH_WIDTH, NOTCH_LENGTH = 0.0003, 0.005, 0.005, 0.010, 0.020
# Distance of the notch's corners from its middle.
CORNER = float(np.sqrt(RADIUS**2 - (RADIUS - (BAR - NECK) / 2) ** 2))
AXIAL = {"tension of 20 N": 20.0, "compression of 4 N": -4.0}
CLAMPED_TENSION = 100.0
AXES = ("x", "y", "z", "rx", "ry", "rz")
UNITS = dict(zip(AXES, ("N/m",) * 3 + ("N m/rad",) * 3, strict=True))
# Small loads about a stroke, for differences [N, N m].
SMALL = {"x": 1.0, "y": 0.3, "z": 0.01, "rx": 0.003, "ry": 0.1, "rz": 0.003}
# Whether the response to a small load has a part of second order: symmetry to the plane y = 0 leaves none in y, rx, rz.
UNEVEN = ("x", "z", "ry")


@dataclass(frozen=True)
class Fineness:
    """Sizes of elements.

    Attributes:
        first: Size at clamps and edges, in thicknesses.
        most: Largest size, in widths.
        growth: Ratio of neighbours.
        through: Elements through the thickness.
    """

    first: float
    most: float
    growth: float
    through: int

    def along(self, start, end, width, thickness=THICKNESS, ends=(True, True)):
        """Places along a leaf spring, fine at the ends named."""
        most = self.most * width
        first, last = (self.first * thickness if fine else most for fine in ends)
        return graded(start, end, first, last, most, self.growth)

    def across(self, width, thickness=THICKNESS):
        """Places across a width, fine at the edges."""
        half = self.along(0, width / 2, width, thickness, (False, True))
        return np.concatenate([-half[:0:-1], half])

    def thick(self, thickness=THICKNESS):
        """Places through a thickness."""
        return np.linspace(-thickness / 2, thickness / 2, self.through + 1)


# Where a step is linear, and where many are not.
MESHES = {"coarse": Fineness(1, 1 / 4, 2, 1), "fine": Fineness(0.5, 1 / 7, 1.7, 2)}
AT_STROKE = {"coarse": Fineness(1, 1 / 4, 2, 1), "fine": Fineness(0.5, 1 / 7, 1.7, 1)}


def leaf(mesh: Mesh, fine: Fineness, width=WIDTH, reinforced=False, height=0.0, shape=None) -> None:
    """Add a leaf spring from x = 0 to 0.1 m.

    Args:
        mesh: Bricks, added to.
        fine: Sizes.
        width: [m].
        reinforced: Whether its middle is thick.
        height: Of its middle plane [m].
        shape: Where its points lie, of x, y, z.
    """
    ys, zs = fine.across(width), fine.thick() + height
    if not reinforced:
        mesh.box(fine.along(0, LENGTH, width), ys, zs, shape)
        return
    a, b = (LENGTH * place for place in MIDDLE)
    mesh.box(fine.along(0, a, width), ys, zs)
    mesh.box(fine.along(b, LENGTH, width), ys, zs)
    thick = np.linspace(THICKNESS / 2, THICK / 2, 2 * fine.through + 1)[1:]
    mesh.box(fine.along(a, b, width), ys, np.concatenate([height - thick[::-1], zs, height + thick]))


def ends(mesh: Mesh) -> None:
    """Name the faces at x = 0 and x = 0.1 m."""
    mesh.pick("FOOT", lambda p: p[:, 0] < 1e-9)
    mesh.pick("TIP", lambda p: p[:, 0] > LENGTH - 1e-9)


def moved(found: dict[int, np.ndarray], body: tuple[int, ...]) -> np.ndarray:
    """Displacements and rotations of a rigid body, (6,)."""
    return np.concatenate([found[body[0]], found[body[1]]])


def compliances(mesh: Mesh, body: tuple[int, ...]) -> tuple[np.ndarray, Printed]:
    """(6, 6) compliance of a rigid body at rest."""
    done = run(mesh, MATERIAL, [step(loads=[(n, d, 1.0)]) for n in body[:2] for d in (1, 2, 3)])
    return np.array([moved(u, body) for u in done.u]).T, done


def stiffnesses(compliance: np.ndarray, before: str = "", axes=AXES) -> dict[str, tuple[float, str]]:
    """Stiffnesses by name, each with everything else free."""
    return {f"{before}stiffness {a}": (1 / compliance[AXES.index(a), AXES.index(a)], UNITS[a]) for a in axes}


def tip(fine: Fineness, build: Callable[[Mesh], None], centre=(LENGTH, 0.0, 0.0), guided: bool = True):
    """Stiffnesses of a body at zero stroke; with its rotations held as well where guided."""
    mesh = Mesh()
    build(mesh)
    body = mesh.make_rigid("TIP", centre)
    compliance, done = compliances(mesh, body)
    found = stiffnesses(compliance)
    if guided:
        stiffness = np.linalg.inv(compliance)
        found |= {f"rotations held, stiffness {a}": (stiffness[i, i], "N/m") for i, a in ((1, "y"), (2, "z"))}
    return found, done.seconds


def single_leaf(fine: Fineness, width=WIDTH, reinforced=False, taper=False):
    """Clamped leaf spring with a rigid tip."""

    def build(mesh):
        slim = THIN / THICKNESS - 1
        shape = (lambda x, y, z: (x, y, z * (1 + slim * x / LENGTH))) if taper else None
        leaf(mesh, fine, width, reinforced, shape=shape)
        ends(mesh)

    return tip(fine, build)


def notch(fine: Fineness):
    """Circular notch hinge, clamped at x = -10 mm, rigid at 10 mm; of the place in its middle."""

    def thickness(x):
        return NECK + 2 * (RADIUS - np.sqrt(RADIUS**2 - x**2)) if abs(x) < CORNER else BAR

    def build(mesh):
        first = fine.first * 0.3e-3
        half = graded(0, CORNER, first, 2 * first, 4 * first, 1 + (fine.growth - 1) / 4)
        out = graded(CORNER, NOTCH_LENGTH / 2, 2 * first, 6 * first, 6 * first, fine.growth)
        xs = np.concatenate([half, out[1:]])
        zs = np.linspace(-0.5, 0.5, 2 * fine.through + 1)
        ys = fine.across(NOTCH_WIDTH, NECK)
        mesh.box(np.concatenate([-xs[:0:-1], xs]), ys, zs, lambda x, y, z: (x, y, z * thickness(x)))
        mesh.pick("FOOT", lambda p: p[:, 0] < -NOTCH_LENGTH / 2 + 1e-9)
        mesh.pick("TIP", lambda p: p[:, 0] > NOTCH_LENGTH / 2 - 1e-9)

    return tip(fine, build, (0.0, 0.0, 0.0), guided=False)


def fold(fine: Fineness):
    """Leaf spring folded by 90 degrees: 0.1 m along x from the clamp, 0.1 m along z to the rigid tip; sharp corner."""

    def build(mesh):
        ys, zs = fine.across(WIDTH), fine.thick()
        mesh.box(fine.along(0, LENGTH - THICKNESS / 2, WIDTH), ys, zs)
        mesh.box(LENGTH + zs, ys, zs)
        mesh.box(LENGTH + zs, ys, fine.along(THICKNESS / 2, LENGTH, WIDTH))
        mesh.pick("FOOT", lambda p: p[:, 0] < 1e-9)
        mesh.pick("TIP", lambda p: p[:, 2] > LENGTH - 1e-9)

    return tip(fine, build, (LENGTH, 0.0, LENGTH))


def about(mesh: Mesh, body: tuple[int, ...], drive: tuple[int, int], strokes, axes, name, twist=None, held=()):
    """Force of a drive that is held at strokes, and stiffnesses there with it held, by small loads.

    Args:
        mesh: Bricks and rigid body.
        body: Its nodes; with two more on the y axis where moments are to be couples of forces.
        drive: Node and direction that are moved.
        strokes: How far [m, rad].
        axes: Directions of the small loads.
        name: Of a stroke, as text.
        twist: Distance between the two more nodes [m].
        held: What else is held.
    """
    node_of = {a: (body[0] if i < 3 else body[1], i % 3 + 1) for i, a in enumerate(AXES)}

    def loads(axis, size):
        if twist and axis in ("rx", "rz"):
            # The node on the side of y pushes along z for rx, against x for rz.
            direction, sign = (3, 1) if axis == "rx" else (1, -1)
            return [(body[2], direction, sign * size / twist), (body[3], direction, -sign * size / twist)]
        return [(*node_of[axis], size)]

    def read(u, axis):
        if twist and axis in ("rx", "rz"):
            direction, sign = (2, 1) if axis == "rx" else (0, -1)
            return sign * (u[body[2]] - u[body[3]])[direction] / twist
        return moved(u, body)[AXES.index(axis)]

    steps, order, before = [], [], 0.0
    for stroke in strokes:
        steps.append(step(held=[(*drive, stroke), *held], nlgeom=True, increments="0.25,1." if before == 0 else "0.5,1."))
        order.append((stroke, None, 0))
        for axis in axes:
            for sign in (1, -1) if axis in UNEVEN or twist else (1,):
                at = loads(axis, sign * SMALL[axis])
                steps.append(step(loads=at, held=[(*drive, stroke), *held], nlgeom=True, increments="1.,1."))
                order.append((stroke, axis, sign))
        before = stroke
    done = run(mesh, MATERIAL, steps)
    # The last increment of each step.
    last = [i for i, t in enumerate(done.times) if abs(t - round(t)) < 1e-6]
    states = {key: (done.u[i], done.force[i]) for key, i in zip(order, last, strict=True)}
    found = {}
    for stroke in strokes:
        rest, force = states[stroke, None, 0]
        what, unit = ("force", "N") if drive[0] == body[0] else ("moment", "N m")
        found[f"{name(stroke)}, {what} of the drive"] = (force[drive[0]][drive[1] - 1], unit)
        for axis in axes:
            up = states[stroke, axis, 1][0]
            down, span = (states[stroke, axis, -1][0], 2) if (stroke, axis, -1) in states else (rest, 1)
            slope = (read(up, axis) - read(down, axis)) / (span * SMALL[axis])
            found[f"{name(stroke)}, stiffness {axis}"] = (1 / slope, UNITS[axis])
    return found, done


def millimetres(stroke: float) -> str:
    """Name of a stroke."""
    return f"{1e3 * stroke:.0f} mm"


def guide(rest: Fineness, fine: Fineness, width=WIDTH, reinforced=False):
    """Two leaf springs 0.1 m apart along z, feet at x = 0, rigid stage; its middle between the tips is moved along z."""

    def build(sizes):
        mesh = Mesh()
        for height in (0.0, DISTANCE):
            leaf(mesh, sizes, width, reinforced, height)
        ends(mesh)
        return mesh, mesh.make_rigid("TIP", (LENGTH, 0.0, DISTANCE / 2))

    compliance, first = compliances(*build(rest))
    mesh, body = build(fine)
    axes = ("x", "y", "rx", "ry", "rz")
    found, second = about(mesh, body, (body[0], 3), STROKES, axes, millimetres)
    return stiffnesses(compliance, "0 mm, ") | found, first.seconds + second.seconds


def guided_leaf(fine: Fineness, width=WIDE):
    """Clamped leaf spring whose tip is moved along z, its rotations held."""
    mesh = Mesh()
    leaf(mesh, fine, width)
    ends(mesh)
    body = mesh.make_rigid("TIP", (LENGTH, 0.0, 0.0))
    found, done = about(
        mesh, body, (body[0], 3), STROKES, ("x", "y"), millimetres, held=[(body[1], d, 0.0) for d in (1, 2, 3)]
    )
    return found, done.seconds
