"""Problems of REFERENCE in `rod_references.py`, solved by shooting: problem data in, rows out.

`python -m references.rod_cases`, in `tests`, writes that file anew; `test_rods.py` holds its rows against these
functions.
"""

import itertools
import re
import runpy
import sys
import time
from math import inf, sqrt
from pathlib import Path

import numpy as np
from references import shooting
from references.rods import Assembly, Cantilever, Chain, Hinged, PlanarRod, SpatialRod, matrix, quaternion

NONE = (0.0, 0.0, 0.0)


def follower_force(data):
    for alpha, EA, GA in data["cases"]:
        problem = Cantilever(PlanarRod(1.0, 1.0, EA, GA), NONE, follower_force=(0.0, alpha))
        yield alpha, EA, GA, *problem.tip(shooting.solve(problem))


def follower_moment(data):
    for angle in data["cases"]:
        problem = Cantilever(PlanarRod(1.0), NONE, follower_moment=(angle,))
        yield angle, *problem.tip(shooting.solve(problem))


def arc(data, **loads):
    """Cantilever of Bathe and Bolourchi: in the xy plane from the origin along y, bending towards +x."""
    R, E, G, side, angle = (data[name] for name in ("R", "E", "G", "side", "angle"))
    area, inertia = side**2, side**4 / 12
    rod = SpatialRod(
        length=R * angle,
        GJ=G * data["J"],
        EIy=E * inertia,
        EIz=E * inertia,
        EA=E * area,
        GAy=G * data["k"] * area,
        GAz=G * data["k"] * area,
        curvature=(0.0, 0.0, -1 / R),
    )
    return Cantilever(rod, (*NONE, *quaternion((0.0, 0.0, np.pi / 2))), **loads)


def follower_arc(data):
    for P in data["cases"]:
        problem = arc(data, follower_force=(0.0, 0.0, P))
        yield P, *problem.tip(shooting.solve(problem))


def moment_space(data):
    GJ, EIy, EIz = data["GJ"], data["EIy"], data["EIz"]
    root = (*NONE, *quaternion(data["turn"]))
    for moment in data["cases"]:
        for name in ("moment", "follower_moment"):
            problem = Cantilever(SpatialRod(1.0, GJ, EIy, EIz), root, **{name: moment})
            yield *moment, name, *problem.tip(shooting.solve(problem))


def rollup_space(data):
    GJ, EIy, EIz = data["GJ"], data["EIy"], data["EIz"]
    turn = quaternion(data["turn"])
    for axis, angle in data["cases"]:
        moment = matrix(turn)[:, axis] * (EIy if axis == 1 else EIz) * angle
        problem = Cantilever(SpatialRod(1.0, GJ, EIy, EIz), (*NONE, *turn), moment=tuple(moment))
        yield axis, angle, tuple(moment), *problem.tip(shooting.solve(problem))


def distributed(data):
    for angle, q in data["cases"]:
        problem = Cantilever(PlanarRod(1.0, load=(0.0, q)), (0.0, 0.0, np.deg2rad(angle)))
        z = shooting.solve(problem)
        yield angle, q, *problem.tip(z), z[2]


def right_angle_frame(data):
    for EA, corner, tip in data["cases"]:
        leg = PlanarRod(1.0, 1.0, EA)
        parts = ((leg, (0.0, 0.0, -np.pi / 2), corner), (leg, NONE, (0.0, 0.0)))
        problem = Cantilever(Chain(parts), (0.0, 0.0, np.pi / 2), force=tip)
        z = shooting.solve(problem)
        first = leg.march(np.array([[0.0], [0.0], [np.pi / 2]]), z[:2, None], z[2:3, None])[0][:, 0]
        yield EA, corner, tip, tuple(first), tuple(problem.tip(z))


def lee_frame(L, EI, EA):
    """Column from (0, 0) up to (0, L), beam to (L, L), hinged at both ends; dead unit load down at (L/5, L)."""
    column, near, far = (PlanarRod(length, EI, EA) for length in (L, L / 5, 4 * L / 5))
    corner, down = (0.0, 0.0, -np.pi / 2), (0.0, -EI / L**2)
    chain = Chain(((column, corner, (0.0, 0.0)), (near, NONE, down), (far, NONE, (0.0, 0.0))))
    return Hinged(chain, (0.0, 0.0), (L, L), np.pi / 2)


def lee(data):
    """Points of the path, limit points of the load, extremes of v: each (u, v, P, foot force x, y, foot angle)."""
    L, unit = data["L"], data["EI"] / data["L"] ** 2
    for EA in data["cases"]:
        problem = lee_frame(L, data["EI"], EA)

        def drop(z, problem=problem):
            return L - problem.joint(z, 2)[1:2]

        def row(z, problem=problem):
            x, y, _ = problem.joint(z[:, None], 2)[:, 0]
            return x - L / 5, L - y, z[-1] * unit, *z[:3]

        loading, end = np.eye(4)[-1], data["P_end"] / unit
        path = shooting.trace(problem, problem.start, loading, lambda z, end=end: z[-1] > end, largest=1.0)
        limits, returns = shooting.turning_points(problem, *path), shooting.turning_points(problem, *path, drop)
        yield EA, *([row(z) for z in zs] for zs in (path[0][:: data["every"]], limits, returns))


def cross_pivot(fraction, EA, angle, force):
    """Leaves of unit length at +-45 deg to y, crossing at the origin; the body's pose is that of the crossing point."""
    leaves = []
    for side in (-1.0, 1.0):
        direction = np.array([side, 1.0]) / sqrt(2)
        phi = np.arctan2(1.0, side)
        leaves.append((PlanarRod(1.0, 1.0, EA), (*-fraction * direction, phi), (*(1 - fraction) * direction, phi)))
    return Assembly(tuple(leaves), NONE, (0.0, force, 0.0), {2: angle})


def pivot(data):
    for EA, fraction, force, degrees in itertools.product(
        *(data[name] for name in ("EA", "fractions", "forces", "degrees"))
    ):
        problem = cross_pivot(fraction, EA, np.deg2rad(degrees), force)
        z = shooting.solve(problem)
        yield EA, fraction, force, degrees, problem.wrench(z)[2], *problem.platform(z)[:2]


def planar_guide(data, load=NONE, given=None):
    """Leaves along +y from (-+b/2, 0); the platform's pose is that of the middle between their tops."""
    rod, b = PlanarRod(data["l"], data["EI"], data["EA"]), data["b"]
    leaves = [(rod, (x, 0.0, np.pi / 2), (x, 0.0, np.pi / 2)) for x in (-b / 2, b / 2)]
    return Assembly(tuple(leaves), (0.0, rod.length, 0.0), load, given or {})


def guide_row(problem):
    z = shooting.solve(problem)
    K = problem.stiffness(z)
    x, y, phi = problem.platform(z) - problem.home
    drive = 1 / problem.compliance(z)[0, 0]
    support = 1 / np.linalg.inv(K[1:, 1:])[0, 0]
    return *(problem.wrench(z)[:2]), x, y, phi, drive, support


def guide_planar(data):
    for stroke in data["strokes"]:
        yield guide_row(planar_guide(data, given={0: stroke}))
    for force in data["forces"]:
        yield guide_row(planar_guide(data, load=(*force, 0.0)))


def torsion_constant(w, t):
    """Torsion constant of a rectangle, Saint-Venant's series [m^4]."""
    n = np.arange(1, 200, 2)
    return w * t**3 / 3 * (1 - 192 * t / (np.pi**5 * w) * np.sum(np.tanh(n * np.pi * w / (2 * t)) / n**5))


def spatial_guide(data, load, k=inf):
    """As `planar_guide`, widths along z: section y against the drive direction, so EIz is the weak one."""
    w, t, E, G, b, length = (data[name] for name in ("w", "t", "E", "G", "b", "l"))
    rod = SpatialRod(
        length=length,
        GJ=G * torsion_constant(w, t),
        EIy=E * t * w**3 / 12,
        EIz=E * w * t**3 / 12,
        EA=E * w * t,
        GAy=k * G * w * t,
        GAz=k * G * w * t,
    )
    up = quaternion((0.0, 0.0, np.pi / 2))
    leaves = [(rod, (x, 0.0, 0.0, *up), (x, 0.0, 0.0, *up)) for x in (-b / 2, b / 2)]
    return Assembly(tuple(leaves), (0.0, length, 0.0, 1.0, 0.0, 0.0, 0.0), (*load, 0.0, 0.0, 0.0))


def guide_spatial(data):
    for k, force in data["cases"]:
        problem = spatial_guide(data, force, k)
        z = shooting.solve(problem, steps=2)
        K = problem.stiffness(z)
        pose = problem.platform(z) - np.r_[0.0, data["l"], np.zeros(5)]
        held = np.linalg.inv(K[1:, 1:])
        yield k, force, tuple(pose), 1 / problem.compliance(z)[0, 0], 1 / held[0, 0], 1 / held[1, 1]


def lateral(data):
    for kind, ratio, kappa, sign in data["cases"]:
        load = (0.0, 0.0, sign)
        rod = SpatialRod(
            1.0, 1.0, ratio, 1.0, curvature=(0.0, kappa, 0.0), load=load if kind == "distributed" else NONE
        )
        problem = Cantilever(rod, (*NONE, 1.0, 0.0, 0.0, 0.0), force=load if kind == "tip" else None)
        yield kind, ratio, kappa, sign, sign * shooting.critical_factor(problem, 1.5, [1, 3, 5])


def argyris(data, J, sign):
    """Right-angle frame: clamped at (0, 0), to (leg, 0), to (leg, -leg); dead force along x at the end."""
    E, G = data["E"], data["E"] / 2 / (1 + data["nu"])
    b, t = data["width"], data["thickness"]
    leg = SpatialRod(data["leg"], GJ=G * J, EIy=E * b * t**3 / 12, EIz=E * t * b**3 / 12, EA=E * b * t)
    corner = (*NONE, *quaternion((0.0, 0.0, -np.pi / 2)))
    chain = Chain(((leg, corner, NONE), (leg, (*NONE, 1.0, 0.0, 0.0, 0.0), NONE)))
    return Cantilever(chain, (*NONE, 1.0, 0.0, 0.0, 0.0), force=(sign, 0.0, 0.0))


def frame_lateral(data):
    for J, sign in data["cases"]:
        yield J, sign, sign * shooting.critical_factor(argyris(data, J, sign), 0.25, [2, 3, 4])


CANTILEVER = "Cantilever, clamped at the origin along +x. Dimensionless, L = EI = 1."
TORSION = torsion_constant(30.0, 0.6)
PROBLEMS = {
    "follower-force": {
        "solver": follower_force,
        "problem": f"{CANTILEVER} Tip force normal to the tip's section frame (along its y), turning with it.",
        "columns": "P, EA, GA; tip x, y, angle",
        "cases": [(P, *stiff) for P in (1.0, 3.0, 5.0) for stiff in ((inf, inf), (1000.0, inf), (1000.0, 400.0))],
    },
    "follower-moment": {
        "solver": follower_moment,
        "problem": f"{CANTILEVER} End moment M, in the plane the same as one about a fixed axis: a circle.",
        "columns": "M; tip x, y, angle",
        "cases": [1.0, np.pi, 2 * np.pi],
    },
    "follower-arc": {
        "solver": follower_arc,
        "problem": "A5-bend45 with a follower force: arc of radius R in the xy plane, clamped at the origin, tangent "
        "+y, bending towards +x; square section, shear factor k. Tip force P along the section axis that starts as +z.",
        "columns": "P; tip x, y, z, rotation of the section frame (tangent, y, z) as quaternion, scalar first",
        "R": 100.0,
        "angle": np.pi / 4,
        "side": 1.0,
        "E": 1e7,
        "G": 5e6,
        "J": 1 / 6,
        "k": 5 / 6,
        "cases": [100.0, 300.0, 450.0],
    },
    "moment-space": {
        "solver": moment_space,
        "problem": "Straight cantilever of length 1 from the origin, root frame (tangent, y, z) turned by the rotation "
        "vector `turn`; no extension or shear. End moment M, once about a fixed axis (entries in space), once a "
        "follower with the same entries in the tip's section frame. Dimensionless.",
        "columns": "M (3), kind; tip x, y, z, quaternion of the section frame, scalar first",
        "GJ": 0.5,
        "EIy": 1.0,
        "EIz": 2.0,
        "turn": (0.3, 0.4, 0.5),
        "cases": [(0.5, 1.0, 1.5), (1.0, 2.0, 3.0)],
    },
    "rollup-space": {
        "solver": rollup_space,
        "problem": "As moment-space, fixed moment about the root section's own y (axis 1) or z (axis 2), normal to the "
        "rod, so large that the rod turns by `angle` in its tilted plane: a circle.",
        "columns": "axis, angle, M (3); tip x, y, z, quaternion of the section frame, scalar first",
        "GJ": 0.5,
        "EIy": 1.0,
        "EIz": 2.0,
        "turn": (0.3, 0.4, 0.5),
        "cases": [(1, np.pi), (2, np.pi), (2, 2 * np.pi), (1, 4 * np.pi)],
    },
    "distributed": {
        "solver": distributed,
        "problem": "Cantilever from the origin at an angle to +x, L = EI = 1, no extension or shear; uniform dead load "
        "q along y, per length of rod.",
        "columns": "angle [deg], q; tip x, y, angle [rad] from +x, moment at the root (on the rod's positive cut)",
        "cases": [(0.0, 2.0), (0.0, 10.0), (0.0, -10.0), (30.0, 2.0), (30.0, 10.0), (30.0, -10.0)],
    },
    "right-angle-frame": {
        "solver": right_angle_frame,
        "problem": "Two legs of unit length, EI = 1, no shear, rigidly joined: (0, 0) clamped, (0, 1) the corner, (1, "
        "1) the free tip. Dead force at the corner and at the tip. Dimensionless.",
        "columns": "EA, force at the corner, force at the tip; corner x, y, angle of leg 1, tip x, y, angle of leg 2",
        "cases": [
            *((inf, (0.0, 0.0), (0.0, -P)) for P in (0.5, 1.0, 2.0, 4.0)),
            (inf, (0.0, 0.0), (0.0, 1.0)),
            (inf, (2.0, 0.0), (0.0, 0.0)),
            (inf, (0.0, 0.0), (2.0, 0.0)),
            (1000.0, (0.0, 0.0), (0.0, -2.0)),
            (1000.0, (2.0, -1.0), (0.0, 0.0)),
        ],
    },
    "lee-frame": {
        "solver": lee,
        "problem": "Lee's frame, no shear: column (0, 0) to (0, L), beam on to (L, L), rigid corner, hinges at both "
        "ends, dead load P down on the beam at L/5 from the corner. First path from zero load until P_end.",
        "columns": "EA; points of the path, limit points of P, extremes of v, each a list of u (to +x), v (down) of "
        "the loaded point, P, then for the solver: force x, y and angle at the column's foot",
        "L": 120.0,
        "EI": 1440.0,
        "P_end": 3.0,
        "every": 2,
        "cases": [4320.0, inf],
    },
    "cross-pivot": {
        "solver": pivot,
        "problem": "B3-cross-pivot under load: leaves of L = EI = 1, no shear, at +-45 deg to +y, crossing at a "
        "fraction of their length from the base. Dead force along y on the body point that starts at the crossing, "
        "body turned by a prescribed angle, its position free. Dimensionless.",
        "columns": "EA, fraction, force, angle [deg]; moment, shift x, y of that body point",
        "EA": [inf, 480000.0],
        "fractions": [0.5, 0.1273],
        "forces": [-2.0, 0.0, 2.0],
        "degrees": [5.0, 15.0, 30.0],
    },
    "guide-planar": {
        "solver": guide_planar,
        "problem": "The tutorial's parallel guide in the plane, no shear: leaves of length l along +y, clamped at "
        "x = -+b/2 and to a rigid platform. Stroke prescribed in x at the platform's middle between the tops, y and "
        "phi free; or dead force (Fx, Fy) there. SI units.",
        "columns": "Fx, Fy; x, y (displacements), phi, drive stiffness dFx/dx (y, phi free), support stiffness dFy/dy "
        "(x held, phi free), both tangents about the loaded state",
        "l": 0.1,
        "b": 0.1,
        "EI": 0.039375,
        "EA": 1.89e6,
        "strokes": [0.001, 0.005, 0.01, 0.02],
        "forces": [(9.5, 0.0), (9.5, 20.0), (9.5, -20.0)],
    },
    "guide-spatial": {
        "solver": guide_spatial,
        "problem": "As guide-planar in space: sections w (along z) x t, torsion constant by Saint-Venant's series, "
        "free warping, shear stiffness k G w t. Dead force at the platform's middle. SI units.",
        "columns": "k, force; displacements x, y, z and rotation (quaternion, scalar first), drive stiffness (rest "
        "free), support stiffness along y and along z (x held, rest free)",
        "l": 0.1,
        "b": 0.1,
        "w": 0.018,
        "t": 0.0005,
        "E": 210e9,
        "G": 80e9,
        "cases": [(k, (9.5, Fy, Fz)) for k in (inf, 5 / 6) for Fy, Fz in ((0.0, 0.0), (0.0, 1.0), (-20.0, 1.0))],
    },
    "lateral": {
        "solver": lateral,
        "problem": "Lateral buckling: cantilever along +x, L = EIz = GJ = 1, stiff EIy, no extension or shear, initial "
        "curvature kappa0 about y (bends towards -z, unloaded). Dead load along +-z at the centroid, uniform or at the "
        "tip, with the bending before buckling. Dimensionless.",
        "columns": "kind, EIy, kappa0, sign; first critical q or P",
        "cases": [
            ("distributed", 1e6, 0.0, 1.0),
            ("distributed", 1e6, 0.0, -1.0),
            ("distributed", 20.0, 0.0, 1.0),
            ("distributed", 20.0, 0.0, -1.0),
            ("distributed", 20.0, 0.5, 1.0),
            ("distributed", 20.0, 0.5, -1.0),
            ("tip", 20.0, 0.0, 1.0),
            ("tip", 20.0, 0.5, 1.0),
            ("tip", 20.0, 0.5, -1.0),
        ],
    },
    "frame-lateral": {
        "solver": frame_lateral,
        "problem": "A8-frame, also with the load reversed: legs clamped at (0, 0), to (leg, 0), to (leg, -leg); dead "
        "force P along +x at that end; width in the plane, no shear, G = E/2(1 + nu). P at which it leaves its plane.",
        "columns": "J, sign; critical P",
        "leg": 240.0,
        "width": 30.0,
        "thickness": 0.6,
        "E": 71240.0,
        "nu": 0.31,
        "cases": [(2.16, 1.0), (2.16, -1.0), (TORSION, 1.0), (TORSION, -1.0)],
    },
}


def tidy(value):
    """Plain Python numbers of 12 digits; what is below 1e-13 is zero."""
    if isinstance(value, dict):
        return {name: tidy(entry) for name, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(tidy(entry) for entry in value)
    if isinstance(value, (float, np.floating)):
        return 0.0 if abs(value) < 1e-13 else float(f"{value:.12g}")
    return value


def literal(value) -> str:
    """Source of a value; long text in pieces that fit a line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{name!r}: {literal(entry)}" for name, entry in value.items()) + "}"
    if isinstance(value, str):
        return "(" + " ".join(repr(piece) for piece in re.findall(r".{1,100}(?:\s|$)", value)) + ")"
    return repr(value)


def write(names):
    """Solve the named problems, or all (two minutes), and write `rod_references.py`; it is then for the formatter."""
    place = Path(__file__).with_name("rod_references.py")
    known = runpy.run_path(str(place))["REFERENCE"] if place.exists() else {}
    for name in names or PROBLEMS:
        begin = time.time()
        data = {key: value for key, value in PROBLEMS[name].items() if key != "solver"}
        known[name] = tidy(data | {"rows": list(PROBLEMS[name]["solver"](data))})
        print(name, f"{time.time() - begin:.1f} s")
    known = {name: known[name] for name in PROBLEMS if name in known}
    text = (
        '"""Reference numbers of static rod problems, by shooting: written by `rod_cases.py`, not by hand.\n\n'
        "Each entry states its problem, its data and the columns of its `rows`. Digits: positions, angles and\n"
        'forces to 1e-10 of their scale, tangent stiffness and critical loads to 1e-8.\n"""\n\n'
        "from math import inf\n\n"
    )
    place.write_text(f"{text}REFERENCE = {literal(known)}\n")


if __name__ == "__main__":
    write(sys.argv[1:])
