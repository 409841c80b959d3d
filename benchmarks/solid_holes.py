"""What a hole in a strip adds to its compliance, by solid elements: the data of the fit in ``elements/holes.py``.

A strip that is clamped at its foot has a hole in its middle and a rigid tip, both 1.5 widths away from the hole. From
the compliance about the centre of the hole, the compliance of a strip without a hole is subtracted. The rest is
diagonal. Printed over widths of the hole, its lengths and Poisson ratios, in the units w/EA, w/GIt, w/EIy, w/EIz,
w^3/EIz and w^3/EIy of the strip. Takes some hours; names of shapes, meshes and Poisson ratios select a part.
"""

import sys

import numpy as np
from solid_cases import MATERIAL, Fineness, compliances
from solid_models import Mesh, installed
from solid_shapes import rectangular, round_ended, strip

import flexmb as fm

WIDTH, THICKNESS, BEYOND = 0.030, 0.0005, 1.5
# Width of the hole over width of the strip, length over width of the hole.
SHARES, RATIOS, POISSON = (0.2, 1 / 3, 0.45, 0.6, 0.7), (1.0, 1.5, 2.5, 4.0, 6.0), (0.3, 0.2, 0.4)
MESHES = {"coarse": Fineness(2, 1 / 6, 1.8, 1), "fine": Fineness(1, 1 / 8, 1.6, 1)}
SHAPES = {"round": round_ended, "sharp": rectangular}
# Of the compliance: resultants, with the rigidity and the power of the width of their units.
UNITS = {0: ("N", "EA", 1), 3: ("T", "GIt", 1), 4: ("My", "EIy", 1), 5: ("Mz", "EIz", 1), 1: ("Vy", "EIz", 3)}
UNITS[2] = ("Vz", "EIy", 3)


def hole(fine: Fineness, shape: str, share: float, ratio: float, poisson: float) -> np.ndarray:
    """Compliances that a hole adds at its centre, in the units of ``UNITS``, (6,)."""
    long, material = ratio * share * WIDTH, {**MATERIAL, "nu": poisson}
    length = long + 2 * BEYOND * WIDTH
    found = []
    for holed in (True, False):
        mesh = Mesh()
        if holed:
            SHAPES[shape](mesh, fine, ((length, WIDTH), (long, share * WIDTH)))
        else:
            strip(mesh, fine, length, WIDTH, THICKNESS)
        compliance, _ = compliances(mesh, mesh.make_rigid("TIP", (length / 2, 0.0, 0.0)), material)
        found.append(np.diag(compliance))
    steel = fm.Material(material["E"], nu=poisson)
    rigidity = fm.Rectangle(WIDTH, THICKNESS, steel).rigidity()
    added = found[0] - found[1]
    return np.array([added[i] * float(getattr(rigidity, name)) / WIDTH**power for i, (_, name, power) in UNITS.items()])


def main() -> None:
    """Print the table; shapes, meshes and Poisson ratios by name, such as ``round coarse 0.3``."""
    given = sys.argv[1:]
    fm.enable_x64()
    print(
        f"{'shape':>8}{'mesh':>8}{'width':>8}{'length':>8}{'nu':>6}" + "".join(f"{n:>10}" for n, *_ in UNITS.values())
    )
    for shape in [s for s in SHAPES if s in given] or SHAPES:
        for mesh in [m for m in MESHES if m in given] or MESHES:
            for poisson in [p for p in POISSON if str(p) in given] or POISSON:
                for ratio in RATIOS:
                    for share in SHARES:
                        found = "".join(f"{v:10.5f}" for v in hole(MESHES[mesh], shape, share, ratio, poisson))
                        print(f"{shape:>8}{mesh:>8}{share:8.3f}{ratio:8.1f}{poisson:6.2f}{found}", flush=True)


if __name__ == "__main__":
    if installed():
        main()
    else:
        print("CalculiX is not installed (Debian: calculix-ccx).")
