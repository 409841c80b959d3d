"""Error against the number of beams and against time, for a cantilever with closed-form answers.

``python benchmarks/convergence.py`` writes results/convergence.json, results/convergence.png and results/accuracy.png,
which README shows.
"""

import sys
from pathlib import Path

HERE = Path(__file__).parent
MESHES = (1, 2, 4, 8, 16)
ORDERS = (2, 3, 4, 6, 8)
# Closed forms for EI = L = m/L = 1, inextensible: (beta L)^2/2 pi, pi^2/4, and the elastica's tip under P L^2/EI = 1.
EXACT = {
    "first frequency": 1.8751040687119611**2 / (2 * 3.141592653589793),
    "buckling load": 2.4674011002723395,
    "large deflection": 0.3017207738,
}


def cantilever(beams, force=None, order=None):
    """Cantilever along x of unit length, bending stiffness and mass per length, elongation FIXED.

    Args:
        beams: Number of beams.
        force: Force at the tip.
        order: Order of spectral beams; None: SPACAR beams.
    """
    import flexmb as fm
    from flexmb import planar

    b = fm.Builder()
    for i in range(beams + 1):
        b.node(str(i), (i / beams, 0))
    for i in range(beams):
        section = fm.Rigidity(EIy=1.0, mass=1.0)
        if order is None:
            b.add(planar.beam, str(i), str(i + 1), name=f"beam {i}", section=section, released=(2, 3))
        else:
            element = planar.spectral_beam(order)
            # Elongation FIXED, as above: of the strains only the curvature is free.
            b.add(element, str(i), str(i + 1), name=f"beam {i}", section=section, released=element.fields[1])
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
    from record import RESULTS, chart, interleaved, save, show

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
    found, run = {}, {}
    for kind, sizes in (("SPACAR beams", MESHES), ("one spectral beam", ORDERS)):
        for n in sizes:
            beams, order = (n, None) if kind == "SPACAR beams" else (1, n)
            free, pressed, pushed = (cantilever(beams, f, order) for f in (None, (-1.0, 0.0), (0.0, 1.0)))
            calls = {
                "first frequency": lambda m=free: fm.frequencies(m, count=1)[0],
                "buckling load": lambda m=pressed: fm.buckling_loads(m)[0],
                "large deflection": lambda m=pushed, tip=str(beams): fm.equilibrium(m).at(tip)[1],
            }
            for name, call in calls.items():
                variant = f"{name}, {kind}: {n}"
                # Below this an answer is as good as the digits of what it is compared with.
                found[variant] = {"error": max(abs(float(call()) / EXACT[name] - 1), 1e-10)}
                run[variant] = lambda call=call: call().block_until_ready()
    timed = interleaved(run)
    show("A cantilever, compiled", timed)
    title = "A cantilever: number of beams, or order of a spectral one"
    chart("accuracy", found, timed, title, "time, compiled", "error against the closed form")
    save("convergence", {"beams": MESHES, "errors": errors, "orders": orders, "found": found, "times": timed})
    figure.savefig(RESULTS / "convergence.png", dpi=110)


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
