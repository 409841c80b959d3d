"""Where methods of motion fail, and how: scene by method by step, and a long run without losses.

``python benchmarks/stability.py`` prints the map, writes results/stability.json and draws results/stability.png.
"""

import functools
import sys
import time
from pathlib import Path

HERE = Path(__file__).parent
# Steps in periods of the scene.
STEPS = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003, 0.001)
# Error over the scene's extent that a designer would call right, and one that he would notice.
RIGHT, ROUGH = 1e-2, 1e-1
OUTCOMES = ("right", "rough", "refused", "wrong")
COLOURS = ("#009E73", "#F0E442", "#BBBBBB", "#D55E00")
LONG = 100_000


def steel_guide():
    """Two leaf springs of steel with all deformations free, released from 1 mm; period, times, node, options."""
    import motion
    import numpy as np

    model = motion.guide(True)
    return model, 0.094, np.linspace(0, 0.3, 31), "right2", {"initial": motion.at_rest(model)}, 1e-3


def whirling_pendulum():
    """Point mass on a rigid rod that goes over the top."""
    import numpy as np

    import flexmb as fm
    from flexmb import planar

    b = fm.Builder()
    b.node("pivot", (0, 0))
    b.node("mass", (0, -1.0))
    b.rotation("rod")
    b.add(planar.rigid_beam, "pivot", "rod", "mass")
    b.fix("pivot", "x", "y")
    b.mass("mass", 1.0)
    b.gravity((0, -9.81))
    b.dof("rod", "phi")
    b.start("rod", "phi", 0.0, velocity=7.0)
    return b.build(), 1.4, np.linspace(0, 4, 41), "mass", {}, 1.0


def four_bars():
    """A parallelogram that passes the positions where its constraints lose rank."""
    import numpy as np

    import flexmb as fm
    from flexmb import planar

    bar = fm.Rigidity(mass=1.0)
    b = fm.Builder()
    for i in range(2):
        b.node(f"ground{i}", (i, 0))
        b.node(f"top{i}", (i, 1.0))
        b.rotation(f"crank{i}")
        b.fix(f"ground{i}", "x", "y")
        b.add(planar.rigid_beam, f"ground{i}", f"crank{i}", f"top{i}", section=bar)
    b.add(planar.truss, "top0", "top1", section=bar, released=())
    b.start("crank0", "phi", 0.0, -1.0)
    b.gravity((0, -9.81))
    return b.build(), 1.6, np.linspace(0, 4, 41), "top1", {}, 1.0


def falling_strip():
    """A strip of steel, pinned at one end, that falls from the horizontal."""
    import numpy as np

    import flexmb as fm
    from flexmb import planar

    leaf = fm.Rectangle(0.01, 0.001, fm.Material(E=210e9, G=80e9, rho=7850.0))
    b = fm.Builder()
    for i in range(3):
        b.node(f"n{i}", (0.15 * i, 0.0))
    for i in range(2):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=leaf)
    b.fix("n0", "x", "y")
    b.gravity((0, -9.81))
    return b.build(), 0.9, np.linspace(0, 1.5, 31), "n2", {}, 0.3


def jumping_load():
    """A mass on a spring whose load jumps between two steps of any of these sizes."""
    import jax.numpy as jnp
    import numpy as np

    import flexmb as fm
    from flexmb import planar

    b = fm.Builder()
    b.node("ground", (0, 0))
    b.node("mass", (1.0, 0))
    b.add(planar.truss, "ground", "mass", section=fm.Rigidity(EA=100.0))
    b.fix("ground")
    b.fix("mass", "y")
    b.mass("mass", 1.0)
    loads = {"mass.x": lambda t: jnp.where(t < 0.31830989, 0.0, 10.0)}
    return b.build(), 0.63, np.linspace(0, 2, 41), "mass", {"loads": loads}, 0.1


def flipping_body():
    """A body in space that turns about its middle axis."""
    import numpy as np

    import flexmb as fm
    from flexmb import spatial

    b = fm.Builder()
    b.node("point", (0, 0, 0))
    b.rotation("body")
    b.node("tip", (0, 0, 1.0))
    b.fix("point", "x", "y", "z")
    b.add(spatial.rigid_beam, "point", "body", "tip")
    b.inertia("body", (1.0, 0, 0, 2.0, 0, 3.0))
    for i, rate in enumerate((0.1, 5.0, 0.0)):
        b.start("body", f"l{i + 1}", 0.0, rate / 2)
    return b.build(), 1.26, np.linspace(0, 6, 61), "tip", {}, 1.0


SCENES = {
    "guide of steel": steel_guide,
    "pendulum over the top": whirling_pendulum,
    "four-bars in line": four_bars,
    "strip that falls": falling_strip,
    "load that jumps": jumping_load,
    "body that flips": flipping_body,
}


def methods():
    """Options of a simulation by name of the method."""
    import diffrax

    import flexmb as fm
    from flexmb.motion.solver import Projected

    class Unprojected(Projected):
        """A solver whose steps may leave the constraints."""

        def step(self, *given):
            return self.solver.step(*given)

    fixed = {"controller": diffrax.ConstantStepSize()}
    return {
        "default, steps of its own": {},
        "Rodas5P": {"solver": fm.motion.Rodas5P(), **fixed},
        "Rodas5P, reduced": {"solver": fm.motion.Rodas5P(), "form": "reduced", **fixed},
        "generalised-alpha 0.8": {"solver": fm.motion.GeneralizedAlpha(0.8)},
        "trapezoidal rule": {"solver": fm.motion.GeneralizedAlpha(1.0)},
        "energy-keeping": {"solver": fm.motion.EnergyKeeping()},
        "Dopri8": {"solver": diffrax.Dopri8(), **fixed},
        "Dopri8, not projected": {"solver": Unprojected(diffrax.Dopri8()), **fixed},
    }


def outcome(model, times, node, options, exact, size):
    """Name of the outcome, and the error over the size.

    Args:
        model: Mechanism.
        times: Of the output [s].
        node: Whose place is compared.
        options: Of the simulation.
        exact: Its places, (n_t, d) [m].
        size: Of the motion [m].
    """
    import numpy as np

    import flexmb as fm

    try:
        found = fm.simulate(model, times, **options)
    except fm.AnalysisError as fault:
        return "refused", fault.code
    error = float(np.max(np.abs(np.asarray(found.at(node)) - exact))) / size
    name = "right" if error < RIGHT else "rough" if error < ROUGH else "wrong"
    return name, error


def survey(scene: str) -> dict:
    """Outcomes of a scene by method, one for each step; in a process of its own.

    Args:
        scene: Its name.
    """
    import numpy as np

    import flexmb as fm

    fm.enable_x64()
    fm.enable_cache(thorough=False)
    model, period, times, node, own, size = SCENES[scene]()
    jumps = {"jumps": np.array([0.31830989])} if "jumps" in scene else {}
    exact = np.asarray(fm.simulate(model, times, rtol=1e-10, atol=1e-12, **own, **jumps).at(node))
    found = {}
    for method, options in methods().items():
        begin = time.perf_counter()
        if not options:
            # The jump is named, as README says.
            cells = [outcome(model, times, node, own | jumps, exact, size)] * len(STEPS)
        else:
            run = functools.partial(outcome, model, times, node, exact=exact, size=size)
            cells = [run(options=own | options | {"dt0": h * period}) for h in STEPS]
        found[method] = cells
        names = " ".join(f"{name:>8}" for name, _ in cells)
        print(f"{scene:<24}{method:<28}{names}   {time.perf_counter() - begin:6.1f} s", flush=True)
    return found


def long_run() -> dict:
    """Energy of the falling strip over many steps that do not resolve its axial vibration."""
    import numpy as np

    import flexmb as fm

    fm.enable_x64()
    fm.enable_cache(thorough=False)
    model, *_ = falling_strip()
    times = np.linspace(0, LONG * 1e-3, 1001)
    begin = time.perf_counter()
    found = fm.simulate(model, times, solver=fm.motion.EnergyKeeping(), dt0=1e-3, max_steps=LONG + 1)
    seen = found.observe()
    greatest, energy = float(np.max(seen.kinetic)), np.asarray(seen.energy)
    spread, trend = np.ptp(energy) / greatest, abs(np.polyfit(times, energy, 1)[0]) * times[-1] / greatest
    assert spread < 1e-6, spread
    assert trend < 1e-8, trend
    took = time.perf_counter() - begin
    print(f"{LONG} steps: energy within {spread:.1e} of the greatest kinetic, trend {trend:.1e}, {took:.0f} s")
    return {"steps": LONG, "spread": float(spread), "trend": float(trend), "seconds": took}


def draw(found: dict) -> None:
    """Draw the map.

    Args:
        found: As from :func:`survey`.
    """
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch
    from record import RESULTS

    figure, axes = plt.subplots(2, 3, figsize=(12, 6), sharex=True, sharey=True, layout="constrained")
    for ax, (scene, rows) in zip(axes.ravel(), found.items(), strict=True):
        cells = np.array([[OUTCOMES.index(name) for name, _ in row] for row in rows.values()])
        ax.pcolormesh(cells, cmap=ListedColormap(COLOURS), vmin=-0.5, vmax=3.5, edgecolor="white", linewidth=1)
        ax.set_title(scene, fontsize=10)
        ax.set_xticks(np.arange(len(STEPS)) + 0.5, [f"{h:g}" for h in STEPS])
        ax.set_yticks(np.arange(len(rows)) + 0.5, list(rows))
    axes[0, 0].invert_yaxis()
    figure.supxlabel("step in periods")
    figure.legend(
        handles=[Patch(color=c, label=o) for c, o in zip(COLOURS, OUTCOMES, strict=True)], loc="outside right"
    )
    figure.savefig(RESULTS / "stability.png", dpi=110)


def main() -> None:
    """Survey, print, check the default, save and draw."""
    import multiprocessing
    import os
    from concurrent.futures import ProcessPoolExecutor

    from record import PACKAGES, save

    # Nothing is timed here, so that scenes run side by side.
    with ProcessPoolExecutor(os.cpu_count(), multiprocessing.get_context("spawn")) as pool:
        energy = pool.submit(long_run)
        found = dict(zip(SCENES, pool.map(survey, SCENES), strict=True))
        long = energy.result()
    for scene, rows in found.items():
        # The default choice is not wrong without saying so; a motion as sensitive as a flip is rough.
        assert rows["default, steps of its own"][0][0] != "wrong", scene
    save("stability", {"steps": STEPS, "found": found, "long": long}, (*PACKAGES, "diffrax"))
    draw(found)


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
