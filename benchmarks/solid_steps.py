"""What a step in width adds to the compliance of a leaf spring, by solid elements.

A wide strip, clamped at its foot, goes over into a narrow one with a rigid tip. Under a constant tension, torque or
moment half of a wide strip of twice its length and half of a narrow one, both clamped at both ends, are subtracted:
what is left belongs to the step. Printed over ratios of widths and Poisson ratios in lengths of the narrow strip over
its width, by which it would have to be longer. Takes some minutes.
"""

import sys

import numpy as np
from solid_cases import MATERIAL, Fineness, compliances
from solid_models import Mesh, installed
from solid_shapes import parts, strip

import flexmb as fm

NARROW, THICKNESS = 0.020, 0.0003
# Lengths of the parts over their widths.
LONG = 1.6
RATIOS, POISSON = (0.85, 0.75, 0.6, 0.5, 1 / 3, 0.25), (0.3, 0.2, 0.4)
MESHES = {"coarse": Fineness(2, 1 / 6, 1.8, 1), "fine": Fineness(1, 1 / 10, 1.5, 1)}
# Of the compliance: tension, torque, bending and bending in the plane.
LOADS = {"EA": 0, "GIt": 3, "EIy": 4, "EIz": 5}


def ends(fine: Fineness, material, *widths: float) -> np.ndarray:
    """Compliances of ``LOADS`` of strips in line, each ``LONG`` of its widths long; of one strip twice that."""
    mesh = Mesh()
    lengths = [LONG * w * (2 if len(widths) == 1 else 1) for w in widths]
    if len(widths) == 1:
        strip(mesh, fine, lengths[0], widths[0], THICKNESS)
    else:
        parts(mesh, fine, lengths, widths, THICKNESS)
    compliance, _ = compliances(mesh, mesh.make_rigid("TIP", (sum(lengths), 0.0, 0.0)), material)
    return np.diag(compliance)[list(LOADS.values())]


def step(fine: Fineness, ratio: float, poisson: float) -> np.ndarray:
    """Lengths of the narrow strip over its width that a step adds, by ``LOADS``."""
    material = {**MATERIAL, "nu": poisson}
    wide = NARROW / ratio
    extra = ends(fine, material, wide, NARROW) - (ends(fine, material, wide) + ends(fine, material, NARROW)) / 2
    steel = fm.Material(material["E"], material["E"] / (2 + 2 * poisson), material["rho"], nu=poisson)
    rigidity = fm.Rectangle(NARROW, THICKNESS, steel).rigidity()
    return extra * np.array([float(getattr(rigidity, name)) for name in LOADS]) / NARROW


def main() -> None:
    """Print the table; meshes and Poisson ratios by name, such as ``coarse 0.3``."""
    given = sys.argv[1:]
    fm.enable_x64()
    print(f"{'mesh':>8}{'ratio':>8}{'nu':>6}" + "".join(f"{name:>9}" for name in LOADS))
    for mesh in [m for m in MESHES if m in given] or MESHES:
        for poisson in [p for p in POISSON if str(p) in given] or POISSON:
            for ratio in RATIOS:
                found = "".join(f"{v:9.4f}" for v in step(MESHES[mesh], ratio, poisson))
                print(f"{mesh:>8}{ratio:8.3f}{poisson:6.2f}{found}", flush=True)


if __name__ == "__main__":
    if installed():
        main()
    else:
        print("CalculiX is not installed (Debian: calculix-ccx).")
