"""The solid models of the cases of ``solid.py``: geometry, loads, and what is read off, in metres and newtons.

A leaf spring lies along x, its width along y, its thickness along z. Held faces are clamped whole; what moves is a
rigid body on the face of the tip (or on those of two leaf springs), unless the tip is said to be free. "Stiffness along
or about" a direction is the inverse of the body's displacement there under a unit force or moment, all else free.
"""

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


def compliances(mesh: Mesh, body: tuple[int, ...], material=MATERIAL) -> tuple[np.ndarray, Printed]:
    """(6, 6) compliance of a rigid body at rest."""
    done = run(mesh, material, [step(loads=[(n, d, 1.0)]) for n in body[:2] for d in (1, 2, 3)])
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


def about(
    mesh: Mesh, body: tuple[int, ...], drive: tuple[int, int], strokes, axes, name, twist=None, held=(), small=SMALL
):
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
        small: Loads by direction [N, N m].
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
        steps.append(
            step(held=[(*drive, stroke), *held], nlgeom=True, increments="0.25,1." if before == 0 else "0.5,1.")
        )
        order.append((stroke, None, 0))
        for axis in axes:
            for sign in (1, -1) if axis in UNEVEN or twist else (1,):
                at = loads(axis, sign * small[axis])
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
            slope = (read(up, axis) - read(down, axis)) / (span * small[axis])
            found[f"{name(stroke)}, stiffness {axis}"] = (1 / slope, UNITS[axis])
    return found, done


def millimetres(stroke: float) -> str:
    """Name of a stroke."""
    return f"{1e3 * stroke:.0f} mm"


def guide(rest: Fineness, fine: Fineness, width=WIDTH, reinforced=False):
    """Two leaf springs 0.1 m apart along z, feet at x = 0, rigid stage; its middle is moved along z."""

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


def pivot(rest: Fineness, fine: Fineness):
    """Two leaf springs that cross at right angles in the middle, at the origin; the rigid stage is turned about y.

    One at y = 10 mm runs from its foot along (1, 0, 1), one at y = -10 mm along (-1, 0, 1); the stage's reference point
    is the origin. Moments on it at an angle are couples of forces along fixed axes.
    """
    half, sine = LENGTH / 2, np.sqrt(0.5)

    def build(sizes):
        mesh = Mesh()
        for side in (1, -1):
            # Local x along (side, 0, 1), local y along y.
            def crossed(x, y, z, side=side):
                return sine * (side * (x - half) - z), side * OFFSET + y, sine * (x - half + side * z)

            leaf(mesh, sizes, shape=crossed)
        return mesh

    def faces(mesh):
        def along(p):
            return (np.sign(p[:, 1]) * p[:, 0] + p[:, 2]) * sine

        mesh.pick("FOOT", lambda p: along(p) < -half + 1e-9)
        mesh.pick("TIP", lambda p: along(p) > half - 1e-9)
        return mesh.make_rigid("TIP", (0, 0, 0), (0, 0.05, 0), (0, -0.05, 0))

    mesh = build(rest)
    body = faces(mesh)
    compliance, first = compliances(mesh, body)
    mesh = build(fine)
    body = faces(mesh)
    axes = ("x", "y", "z", "rx", "rz")
    found, second = about(mesh, body, (body[1], 2), (ANGLE,), axes, degrees, twist=0.1)
    return stiffnesses(compliance, "0 degrees, ") | found, first.seconds + second.seconds


def degrees(angle: float) -> str:
    """Name of an angle."""
    return f"{np.degrees(angle):.0f} degrees"


def traction(mesh: Mesh, axis: int, force: float) -> list[tuple[int, int, float]]:
    """Nodal forces of a uniform traction on the tip's face x = 0.1 m.

    Args:
        mesh: Bricks whose second face along x may lie there.
        axis: Direction, 1 to 3.
        force: Sum [N].
    """
    points = np.array(mesh.points)
    # Nodes of the face at the larger x: corners 2 3 6 7, and between them 10 14 18 19, counted from 1.
    corners, middles = np.array([1, 2, 5, 6]), np.array([9, 13, 17, 18])
    share: dict[int, float] = {}
    for brick in mesh.bricks:
        at = points[brick - 1]
        if np.all(at[corners, 0] > LENGTH - 1e-9):
            area = np.prod(np.ptp(at[corners, 1:], axis=0))
            for places, part in ((corners, -1 / 12), (middles, 1 / 3)):
                for node in brick[places]:
                    share[int(node)] = share.get(int(node), 0.0) + part * area
    whole = sum(share.values())
    return [(node, axis, force * part / whole) for node, part in share.items()]


def probes(mesh: Mesh) -> tuple[int, ...]:
    """Have the displacements of the tip printed, of its middle and of both its edges, in mid-thickness."""
    picked = []
    for y in (0.0, WIDTH / 2, -WIDTH / 2):
        points = np.array(mesh.points)
        picked.append(int(np.argmin(np.linalg.norm(points - [LENGTH, y, 0.0], axis=1))) + 1)
    mesh.sets["REFS"] = np.array(picked)
    return tuple(picked)


# Modes of a leaf spring by what its tip does, and how many of each are compared.
KINDS = {"bending": 3, "torsion": 2, "sideways": 1}


def sorted_modes(hertz, along_y, along_z, turned) -> dict[str, tuple[float, str]]:
    """Frequencies by kind of mode, in order.

    Args:
        hertz: Frequencies, rising.
        along_y: Displacement of the tip's middle in each mode.
        along_z: The same across.
        turned: Displacement of the tip's edge by its rotation about x.
    """
    found, counts = {}, dict.fromkeys(KINDS, 0)
    for f, *moves in zip(hertz, along_z, turned, along_y, strict=True):
        kind = tuple(KINDS)[int(np.argmax(np.abs(moves)))]
        counts[kind] += 1
        if counts[kind] <= KINDS[kind]:
            found[f"{kind} {counts[kind]}"] = (float(f), "Hz")
    return {name: found[name] for kind, n in KINDS.items() for i in range(n) if (name := f"{kind} {i + 1}") in found}


def frequencies(fine: Fineness):
    """Clamped leaf spring with a free tip, also under an axial force; and clamped at both ends in tension."""
    found, seconds = {}, 0.0
    for name, force in ({"free tip": 0.0} | AXIAL).items():
        mesh = Mesh()
        leaf(mesh, fine)
        ends(mesh)
        middle, edge, other = probes(mesh)
        modal = step("*FREQUENCY", increments="9", perturbation=force != 0)
        preload = [step(loads=traction(mesh, 1, force), nlgeom=True, increments="1.,1.")] if force else []
        done = run(mesh, MATERIAL, [*preload, modal])
        shapes = done.u[-len(done.frequencies) :]
        tips = np.array([[u[middle][1], u[middle][2], (u[edge][2] - u[other][2]) / 2] for u in shapes]).T
        found |= {f"{name}, {k}": v for k, v in sorted_modes(done.frequencies, *tips).items()}
        seconds += done.seconds
    mesh = Mesh()
    leaf(mesh, fine)
    ends(mesh)
    body = mesh.make_rigid("TIP", (LENGTH, 0, 0))
    held = [(n, d, 0.0) for n in body for d in (1, 2, 3) if (n, d) != (body[0], 1)]
    preload = step(loads=[(body[0], 1, CLAMPED_TENSION)], held=held, nlgeom=True, increments="1.,1.")
    done = run(mesh, MATERIAL, [preload, step("*FREQUENCY", increments="3", perturbation=True)])
    for i, f in enumerate(done.frequencies[:3]):
        found[f"both ends clamped, tension of 100 N, mode {i + 1}"] = (f, "Hz")
    return found, seconds + done.seconds


def buckling(fine: Fineness):
    """Smallest critical loads of a clamped leaf spring, by linear buckling."""
    found, seconds = {}, 0.0
    for name in ("column, free tip", "sideways, free tip", "column, tip guided", "sideways, rigid tip"):
        mesh = Mesh()
        leaf(mesh, fine)
        ends(mesh)
        axis, force = (1, -1.0) if name.startswith("column") else (2, 1.0)
        held: list[tuple[int, int, float]] = []
        if "free" in name:
            probes(mesh)
            loads = traction(mesh, axis, force)
        else:
            body = mesh.make_rigid("TIP", (LENGTH, 0, 0))
            loads = [(body[0], axis, force)]
            if axis == 1:
                held = [(n, d, 0.0) for n in body for d in (1, 2, 3) if (n, d) != (body[0], 1)]
        # Too few vectors find the wrong one first.
        done = run(mesh, MATERIAL, [step("*BUCKLE", increments="2,1e-4,20,2000", loads=loads, held=held)])
        found[name] = (min(abs(v) for v in done.values), "N")
        seconds += done.seconds
    return found, seconds


def heated(fine: Fineness):
    """A guide with one leaf spring 1 K warmer, a leaf spring clamped twice, one with 1 K across its thickness."""

    def warm(where):
        return "*TEMPERATURE\n" + "".join(f"{node},{value:.12g}\n" for node, value in where.items())

    cold = "*INITIAL CONDITIONS,TYPE=TEMPERATURE\nNALL,0.\n"
    mesh = Mesh()
    for height in (0.0, DISTANCE):
        leaf(mesh, fine, height=height)
    ends(mesh)
    lower = {i + 1: 1.0 for i, p in enumerate(mesh.points) if p[2] < DISTANCE / 2}
    body = mesh.make_rigid("TIP", (LENGTH, 0, DISTANCE / 2))
    done = run(mesh, MATERIAL, [step(more=warm(lower))], cold)
    found, seconds = {"guide, lower leaf spring 1 K warmer, tilt": (done.u[0][body[1]][1], "rad")}, done.seconds
    for name, free in (("1 K across the thickness, free tip", True), ("1 K across the thickness, rigid tip", False)):
        mesh = Mesh()
        leaf(mesh, fine)
        ends(mesh)
        bent = {i + 1: p[2] / THICKNESS for i, p in enumerate(mesh.points)}
        at = probes(mesh)[0] if free else mesh.make_rigid("TIP", (LENGTH, 0, 0))[0]
        done = run(mesh, MATERIAL, [step(more=warm(bent))], cold)
        found[f"{name}, deflection"] = (-done.u[0][at][2], "m")
        seconds += done.seconds
    mesh = Mesh()
    leaf(mesh, fine)
    ends(mesh)
    body = mesh.make_rigid("TIP", (LENGTH, 0, 0))
    held = [(n, d, 0.0) for n in body for d in (1, 2, 3)]
    all_warm = warm(dict.fromkeys(range(1, len(mesh.points) - 1), 1.0))
    done = run(mesh, MATERIAL, [step(held=held, more=all_warm)], cold)
    found["both ends clamped, 1 K warmer, force"] = (-done.force[0][body[0]][0], "N")
    return found, seconds + done.seconds


# Cases by name, each a function of "coarse" or "fine" that gives numbers with units, and the time of CalculiX [s].
CASES: dict[str, Callable] = {
    "leaf spring 18 mm wide": lambda mesh: single_leaf(MESHES[mesh]),
    "leaf spring 50 mm wide": lambda mesh: single_leaf(MESHES[mesh], WIDE),
    "tapered leaf spring": lambda mesh: single_leaf(MESHES[mesh], taper=True),
    "reinforced leaf spring": lambda mesh: single_leaf(MESHES[mesh], reinforced=True),
    "circular notch hinge": lambda mesh: notch(MESHES[mesh]),
    "folded leaf spring": lambda mesh: fold(MESHES[mesh]),
    "guide": lambda mesh: guide(MESHES[mesh], AT_STROKE[mesh]),
    "guide, reinforced": lambda mesh: guide(MESHES[mesh], AT_STROKE[mesh], reinforced=True),
    "guide, 50 mm wide": lambda mesh: guide(MESHES[mesh], AT_STROKE[mesh], WIDE),
    "guided leaf spring 50 mm wide": lambda mesh: guided_leaf(AT_STROKE[mesh]),
    "cross pivot": lambda mesh: pivot(MESHES[mesh], AT_STROKE[mesh]),
    "frequencies": lambda mesh: frequencies(MESHES[mesh]),
    "buckling": lambda mesh: buckling(MESHES[mesh]),
    "heated": lambda mesh: heated(MESHES[mesh]),
}
