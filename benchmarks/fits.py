"""Whether confidence intervals contain the truth: ``python benchmarks/fits.py [SETS]`` prints the share and keeps it.

A guide with a clamp that gives is fitted to a frequency response with noise, a thousand times with other noise. The
thickness, the modulus, the stiffness of the clamp and the loss factor are unknown. Each interval of 95 % should contain
the truth in 95 % of the sets, and a share over N sets scatters by sqrt(0.95 * 0.05/N). The second table fits three
parameters to ten frequencies.
"""

import sys
import time
from typing import Any

import numpy as np

TRUTH = {"thickness": 0.52e-3, "modulus": 205e9, "clamp": 60.0, "loss": 0.012}
START = {"thickness": 0.5e-3, "modulus": 210e9, "clamp": 72.0, "loss": 0.01}
BOUNDS = {"thickness": (0.3e-3, 0.8e-3), "modulus": (150e9, 300e9), "clamp": (5.0, 5000.0), "loss": (1e-3, 0.1)}
HERTZ = np.linspace(2.0, 800.0, 120)
# Scatter of each value of the response, and of each frequency, as shares.
RESPONSE_SCATTER, FREQUENCY_SCATTER = 0.02, 1e-3


def guide(thickness: Any, modulus: Any, clamp: Any) -> Any:
    """A stage of 0.2 kg on two leaf springs, one of which turns in its clamp."""
    import flexmb as fm
    from flexmb import planar

    leaf = fm.Rectangle(width=0.018, thickness=thickness, material=fm.Material(E=modulus, G=modulus / 2.6, rho=7850))
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, 0.1), "C": (0.1, 0.1), "D": (0.1, 0)}.items():
        b.node(name, place)
    b.add(planar.leaf_spring(4), "A", "B", name="left", section=leaf)
    b.add(planar.leaf_spring(4), "D", "C", name="right", section=leaf)
    b.add(planar.rigid_body, "B", "C", name="stage")
    b.fix("A", "x", "y")
    b.rotation("wall")
    b.fix("wall")
    b.add(planar.hinge, "wall", "A", name="clamp", released=(1,), stiffness=clamp)
    b.fix("D")
    b.mass("B", 0.1)
    b.mass("C", 0.1)
    b.input("B", "x")
    b.output("B", "x")
    return b.build()


def response_fits(sets: int) -> dict[str, Any]:
    """Shares of sets whose interval contains the truth, by parameter; seconds of the first fit and of each other."""
    import flexmb as fm

    model = guide(TRUTH["thickness"], TRUTH["modulus"], TRUTH["clamp"])
    clean = np.asarray(fm.frequency_response(model, HERTZ.tolist(), loss_factor=TRUTH["loss"]).of())
    deviation = RESPONSE_SCATTER * np.abs(clean)
    data = fm.measured_response(HERTZ, clean, deviation, loss_factor="loss")
    return _repeated(guide, data, START, np.tile(deviation, 2), sets)


def frequency_fits(sets: int) -> dict[str, Any]:
    """The same of thickness, modulus and clamp from ten frequencies."""
    import flexmb as fm

    start = {name: value for name, value in START.items() if name != "loss"}
    model = guide(TRUTH["thickness"], TRUTH["modulus"], TRUTH["clamp"])
    hertz = np.asarray(fm.frequencies(model))[:10]
    deviation = FREQUENCY_SCATTER * hertz
    return _repeated(guide, fm.measured_modes(hertz, deviation), start, deviation, sets)


def _repeated(build: Any, data: Any, start: dict[str, float], deviation: np.ndarray, sets: int) -> dict[str, Any]:
    import flexmb as fm

    begin = time.perf_counter()
    found = fm.fit(build, data, start, {name: BOUNDS[name] for name in start})
    first = time.perf_counter() - begin
    noise = np.random.default_rng(0).standard_normal((sets, len(data.values)))
    begin = time.perf_counter()
    several = found.again(data.values + deviation * noise)
    again = (time.perf_counter() - begin) / sets
    shares = {}
    for name in start:
        # Symmetric in the logarithm, as `interval` is.
        relative = np.log(several.parameters[name] / TRUTH[name]) * several.parameters[name] / several.deviation[name]
        shares[name] = float(np.mean(np.abs(relative) < 1.959964))
    return {"sets": sets, "converged": float(np.mean(several.converged)), "first": first, "again": again} | shares


def main() -> None:
    """Both tables, with the results kept."""
    import flexmb as fm

    fm.enable_x64()
    from record import save

    sets = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    found = {"response": response_fits(sets), "frequencies": frequency_fits(sets)}
    for name, row in found.items():
        print(name, ", ".join(f"{key} {value:.4g}" for key, value in row.items()))
        for parameter in TRUTH.keys() & row.keys():
            assert abs(row[parameter] - 0.95) < max(0.02, 3 * np.sqrt(0.95 * 0.05 / sets)), (name, parameter)
    save("fits", found)


if __name__ == "__main__":
    main()
