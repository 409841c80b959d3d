"""Error against the number of beams, for a cantilever with closed-form answers.

``python benchmarks/convergence.py`` writes results/convergence.json and results/convergence.png, which README shows.
"""

import sys
from pathlib import Path

HERE = Path(__file__).parent
MESHES = (1, 2, 4, 8, 16)
# Closed forms for EI = L = m/L = 1, inextensible: (beta L)^2/2 pi, pi^2/4, and the elastica's tip under P L^2/EI = 1.
EXACT = {
    "first frequency": 1.8751040687**2 / (2 * 3.141592653589793),
    "buckling load": 2.4674011003,
    "large deflection": 0.3017207738,
}


def cantilever(beams, force=None):
    """Cantilever along x of unit length, bending stiffness and mass per length, elongation FIXED.

    Args:
        beams: Number of beams.
        force: Force at the tip.
    """
    import flexmb as fm
    from flexmb import planar

    b = fm.Builder()
    for i in range(beams + 1):
        b.node(str(i), (i / beams, 0))
    for i in range(beams):
        section = fm.Rigidity(EIy=1.0, mass=1.0)
        b.add(planar.beam, str(i), str(i + 1), name=f"beam {i}", section=section, released=(2, 3))
    b.fix("0")
    if force is not None:
        b.force(str(beams), force)
    return b.build()


def main() -> None:
    """Compute, print, save and draw."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    from record import RESULTS, save

    import flexmb as fm

    fm.enable_x64()
    errors: dict[str, list[float]] = {name: [] for name in EXACT}
    for n in MESHES:
        found = {
            "first frequency": float(fm.frequencies(cantilever(n))[0]),
            "buckling load": float(fm.buckling_loads(cantilever(n, (-1.0, 0.0)))[0]),
            "large deflection": float(fm.equilibrium(cantilever(n, (0.0, 1.0))).at(str(n))[1]),
        }
        for name, value in found.items():
            errors[name].append(abs(value / EXACT[name] - 1))
    orders = {n: float(-np.polyfit(np.log(MESHES[1:4]), np.log(e[1:4]), 1)[0]) for n, e in errors.items()}
    figure, axes = plt.subplots(figsize=(6, 4))
    for name, error in errors.items():
        axes.loglog(MESHES, error, "o-", label=f"{name}, order {orders[name]:.1f}")
        print(f"{name:<20}" + "  ".join(f"{e:.2e}" for e in error) + f"   order {orders[name]:.2f}")
    axes.set(xlabel="beams in the cantilever", ylabel="relative error against the closed form")
    axes.set_xticks(MESHES, [str(n) for n in MESHES])
    axes.minorticks_off()
    axes.grid(alpha=0.3)
    axes.legend()
    figure.tight_layout()
    save("convergence", {"beams": MESHES, "errors": errors, "orders": orders})
    figure.savefig(RESULTS / "convergence.png", dpi=110)


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
