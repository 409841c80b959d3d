"""Error against time for a guide at a large stroke: SPACAR beams and spectral beams.

``python benchmarks/large_deflection.py`` writes results/large_deflection.json and results/large_deflection.png, which
README shows. The tutorial's spatial guide under 9.5 N along its drive direction moves some 10 mm.
"""

import sys
from pathlib import Path

HERE = Path(__file__).parent
FORCE = 9.5
BEAMS = (1, 2, 4, 8, 16)
ORDERS = (2, 3, 4, 5, 6)
RUNS = 7


def guide(element, beams=1, **options):
    """Spatial guide of two leaf springs 0.1 m long and 0.1 m apart, upright, a rigid bar on top.

    Args:
        element: Beam element of the leaf springs.
        beams: Elements a leaf spring.
        options: Properties of the beams.
    """
    from scenes import STEEL

    import flexmb as fm
    from flexmb import spatial

    leaf = fm.Rectangle(0.018, 0.0005, fm.Material(**STEEL))
    b = fm.Builder()
    for side, y in (("left", 0.0), ("right", 0.1)):
        for i in range(beams + 1):
            b.node(f"{side}{i}", (0, y, 0.1 * i / beams))
        for i in range(beams):
            ends = f"{side}{i}", f"{side}{i + 1}"
            b.add(element, *ends, name=f"{side} {i + 1}", section=leaf, y=(1, 0, 0), **options)
        b.fix(f"{side}0")
    b.add(spatial.beam, f"left{beams}", f"right{beams}", name="bar", y=(1, 0, 0))
    b.force(f"right{beams}", (0, FORCE, 0))
    return b.build()


def main() -> None:
    """Compute, time, print, save and draw."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    from record import RESULTS, interleaved, save, show

    import flexmb as fm
    from flexmb import spatial

    fm.enable_x64()
    fm.enable_cache()
    families = {
        "SPACAR beams": {n: (guide(spatial.beam, n), n) for n in BEAMS},
        "SPACAR beams, no second-order terms": {n: (guide(spatial.beam, n, second_order=False), n) for n in BEAMS},
        "one spectral beam a leaf spring": {p: (guide(spatial.spectral_beam(p)), 1) for p in ORDERS},
    }
    fine = fm.equilibrium(guide(spatial.spectral_beam(8), 2))
    exact = float(fine.at("right2")[1]) - 0.1
    found = {}
    for family, models in families.items():
        for size, (model, beams) in models.items():
            solved = fm.equilibrium(model)
            stroke = float(solved.at(f"right{beams}")[1]) - 0.1
            found[f"{family}: {size}"] = {
                "error": abs(stroke / exact - 1),
                "iterations": int(solved.iterations),
                "degrees_of_freedom": model.topology.n_q,
            }
    timed = interleaved(
        {
            f"{family}: {size}": lambda model=model: fm.equilibrium(model).x.block_until_ready()
            for family, models in families.items()
            for size, (model, _) in models.items()
        },
        RUNS,
    )
    show(f"Equilibrium at a stroke of {exact:.6f} m, compiled", timed)
    for name, entry in found.items():
        size = f"{entry['degrees_of_freedom']} degrees of freedom"
        print(f"{name:44s} error {entry['error']:.1e}   {entry['iterations']:3d} iterations   {size}")
    # Two independent elements agree on the answer: the finest mesh of SPACAR beams converges to it with order two.
    errors = [found[f"SPACAR beams: {n}"]["error"] for n in BEAMS]
    np.testing.assert_allclose(np.divide(errors[2:-1], errors[3:]), 4, rtol=0.2)
    save("large_deflection", {"stroke": exact, "found": found, "times": timed})

    figure, axes = plt.subplots(figsize=(6.4, 4.2), layout="constrained")
    for (family, models), marker in zip(families.items(), "osD", strict=True):
        names = [f"{family}: {size}" for size in models]
        x = [1e3 * timed[name]["median"] for name in names]
        axes.loglog(x, [found[name]["error"] for name in names], marker=marker, label=family)
        for size, xi, name in zip(models, x, names, strict=True):
            axes.annotate(str(size), (xi, found[name]["error"]), textcoords="offset points", xytext=(4, 4), fontsize=8)
    axes.set_xlabel("time of one equilibrium, compiled [ms]")
    axes.set_ylabel("error of the stroke [-]")
    axes.set_title("Guide at 10 mm: beams a leaf spring, or the order of one", fontsize=11)
    axes.grid(True, which="major", alpha=0.4)
    axes.legend()
    figure.savefig(RESULTS / "large_deflection.png", dpi=120)


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
