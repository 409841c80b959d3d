"""Stress of a leaf spring by solid finite elements: the numbers of A14-stress in tests/REFERENCES.md, on two meshes.

Of nodes on the surface, averaged over the elements that meet there, as CalculiX extrapolates it. Takes ten minutes, and
prints. With ``wide`` it prints instead the stress of both faces near the clamp, at the edge and in the middle, of a
leaf spring half as wide as long at a stroke of a tenth of its length.
"""

import os
import sys
import tempfile
from pathlib import Path

import numpy as np
from solid_cases import LENGTH, MATERIAL, THICKNESS, WIDE, WIDTH, Fineness, ends, leaf
from solid_models import Mesh, installed, run, step

CORNER, MIDDLE = (WIDTH / 2, THICKNESS / 2), (0.0, THICKNESS / 2)
STRESS = "*EL FILE\nS\n"
# Where a step is linear, and where many are not.
MESHES = Fineness(1, 1 / 14, 1.4, 2), Fineness(0.6, 1 / 20, 1.3, 2)
FAR = Fineness(1, 1 / 12, 1.5, 1), Fineness(0.7, 1 / 16, 1.4, 1)
CURVATURE, STROKE = 8.0, 0.010


def read(path: Path) -> tuple[np.ndarray, list[np.ndarray]]:
    """Places of the nodes (n, 3), and of each step's stress xx, yy, zz, xy, yz, zx (n, 6)."""
    points: dict[int, list[float]] = {}
    stresses: list[dict[int, list[float]]] = []
    into = None
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("    2C"):
            into = points
        elif line.startswith(" -4"):
            stresses += [{}] if "STRESS" in line else []
            into = stresses[-1] if "STRESS" in line else None
        elif line.startswith(" -3"):
            into = None
        elif line.startswith(" -1") and into is not None:
            into[int(line[3:13])] = [float(line[at : at + 12]) for at in range(13, len(line), 12)]
    nodes = sorted(stresses[0])
    return np.array([points[n] for n in nodes]), [np.array([one[n] for n in nodes]) for one in stresses]


def solved(fine: Fineness, steps, width=WIDTH):
    """Places and stress of a strip with a clamped foot and a rigid tip; ``steps(reference node, rotation node)``."""
    mesh = Mesh()
    leaf(mesh, fine, width)
    ends(mesh)
    body = mesh.make_rigid("TIP", (LENGTH, 0, 0))
    with tempfile.TemporaryDirectory() as folder:
        os.environ["SOLID_KEEP"] = folder
        run(mesh, MATERIAL, steps(*body))
        return read(Path(folder) / "case.frd")


def along(points, values, at, widths, width=WIDTH):
    """Values of a line of nodes at y and z, at distances from the clamp in widths."""
    chosen = np.flatnonzero(np.max(np.abs(points[:, 1:] - at), axis=1) < 1e-9)
    chosen = chosen[np.argsort(points[chosen, 0])]
    return np.interp(np.asarray(widths) * width, points[chosen, 0], values[chosen])


def von_mises(s):
    """Equivalent stress, (n,)."""
    xx, yy, zz, xy, yz, zx = s.T
    return np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (xy**2 + yz**2 + zx**2))


def near_clamp(fine: Fineness, width: float, places=(0.1, 0.2, 0.5)) -> dict[str, np.ndarray]:
    """Stress at a stroke [MPa] along the strip and across it, of both faces, at the edge and in the middle.

    Args:
        fine: Sizes.
        width: [m].
        places: Distances from the clamp in widths.

    Returns:
        By name; tension is positive, and the face at +z is the one towards which the tip moves.
    """
    far = {"nlgeom": True, "increments": "0.25,1.", "more": STRESS}

    def steps(a, b):
        held = [(a, 3, STROKE), (a, 2, 0.0), *((b, d, 0.0) for d in (1, 2, 3))]
        return [step(held=held, **far)]

    points, found = solved(fine, steps, width)
    # The faces are free, so that what is along the strip is the sum in the plane in which it bends.
    lengthwise, across = (found[-1][:, 0] + found[-1][:, 2]) / 1e6, found[-1][:, 1] / 1e6
    return {
        f"{where}, {face}, {name}": along(points, values, (y, z), places, width)
        for where, y in (("edge", width / 2), ("middle", 0.0))
        for face, z in (("+z", THICKNESS / 2), ("-z", -THICKNESS / 2))
        for name, values in (("along", lengthwise), ("across", across))
    }


def main() -> None:
    """Print all numbers."""
    if "wide" in sys.argv[1:]:
        for fine in FAR:
            print("At 0.1, 0.2 and 0.5 widths from the clamp [MPa]:")
            for name, values in near_clamp(fine, WIDE).items():
                print(f"  {name:<24}" + "".join(f"{v:10.2f}" for v in values), flush=True)
        return
    near, places = (0.1, 0.15, 0.3), (0.2, 0.5, 1.0)
    for fine in MESHES:
        points, (bent, turned) = solved(fine, lambda _, b: [step(loads=[(b, d, 1.0)], more=STRESS) for d in (2, 1)])
        print(len(points), "nodes; bending, middle, along:", along(points, bent[:, 0], MIDDLE, near))
        print("  across:", along(points, bent[:, 1], MIDDLE, near))
        print("  torsion, corner, along:", along(points, turned[:, 0], CORNER, near))
        print("  shear in the middle:", -along(points, turned[:, 3], MIDDLE, near))
    moment = -MATERIAL["E"] * WIDTH * THICKNESS**3 / 12 * CURVATURE
    base = MATERIAL["E"] * CURVATURE * THICKNESS / 2
    for fine in FAR:
        far = {"nlgeom": True, "increments": "0.25,1.", "more": STRESS}
        points, found = solved(fine, lambda _, b, far=far: [step(loads=[(b, 2, moment)], **far)])
        # The surface is free, so that what is along it is the sum in the plane in which the strip bends.
        for y, z in (CORNER, MIDDLE):
            for side in (z, -z):
                lengthwise = along(points, found[-1][:, 0] + found[-1][:, 2], (y, side), [2.7])
                across = along(points, found[-1][:, 1], (y, side), [2.7]) / MATERIAL["nu"]
                print(
                    len(points),
                    "nodes; curvature 8/m at",
                    (y, side),
                    "along:",
                    lengthwise / base,
                    "across:",
                    across / base,
                )
        held = [(3, STROKE), (2, 0.0)]
        points, found = solved(
            fine,
            lambda a, b, far=far, held=held: [
                step(held=[(a, d, u) for d, u in held] + [(b, d, 0.0) for d in (1, 2, 3)], **far)
            ],
        )
        equivalent = von_mises(found[-1]) / 1e6
        for y, z in (CORNER, MIDDLE):
            for side in (z, -z):
                print("  stroke, von Mises [MPa], y, z:", (y, side), along(points, equivalent, (y, side), places))
        inner = (points[:, 0] > 0.02 * WIDTH) & (points[:, 0] < LENGTH - 0.02 * WIDTH)
        print("  largest:", equivalent[inner].max())


if __name__ == "__main__":
    if installed():
        main()
    else:
        print("CalculiX is not installed (Debian: calculix-ccx). The numbers stand in tests/REFERENCES.md.")
