"""Whether confidence intervals contain the truth: ``python benchmarks/fits.py [SETS]`` prints the share and keeps it.

A guide with a clamp that gives is fitted to a frequency response with noise, a thousand times with other noise. The
thickness, the modulus, the stiffness of the clamp and the loss factor are unknown. Each interval of 95 % should contain
the truth in 95 % of the sets, and a share over N sets scatters by sqrt(0.95 * 0.05/N). The second table fits three
parameters to ten frequencies, the third one six parameters to a response with 500 frequencies. The fourth table counts
fits from starts that are up to 20 % off: those that find the truth, and those that do not and report success.
"""

import itertools
import sys
import time
import warnings
from typing import Any

import numpy as np

TRUTH = {"thickness": 0.52e-3, "modulus": 205e9, "clamp": 60.0, "loss": 0.012}
START = {"thickness": 0.5e-3, "modulus": 210e9, "clamp": 72.0, "loss": 0.01}
BOUNDS = {"thickness": (0.3e-3, 0.8e-3), "modulus": (150e9, 300e9), "clamp": (5.0, 5000.0), "loss": (1e-3, 0.1)}
HERTZ = np.linspace(2.0, 800.0, 120)
# Scatter of each value of the response, and of each frequency, as shares.
RESPONSE_SCATTER, FREQUENCY_SCATTER = 0.02, 1e-3
# Difference from the truth, in deviations, above which a fit is at another minimum.
FAR = 4.5


def guide(thickness: Any, modulus: Any, clamp: Any, mass: Any = 0.2) -> Any:
    """A stage with a mass on two leaf springs, one of which turns in its clamp."""
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
    b.mass("B", mass / 2)
    b.mass("C", mass / 2)
    b.input("B", "x")
    b.output("B", "x")
    return b.build()


def response_fits(sets: int) -> dict[str, Any]:
    """Shares of sets whose interval contains the truth, by parameter; times of the first fit and of each other.

    "again" is the time of the clock, "busy" the time of all cores [s].
    """
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


def long_response() -> dict[str, Any]:
    """Times of two fits of six parameters to 500 frequencies, and the worst error of a parameter [deviations]."""
    import flexmb as fm

    truth = TRUTH | {"mass": 0.2, "delay": 5e-5}
    start = START | {"mass": 0.22, "delay": 0.0}
    bounds = BOUNDS | {"mass": (0.1, 0.4), "delay": (-1e-3, 1e-3)}
    hertz = np.linspace(2.0, 800.0, 500)
    model = guide(*(truth[name] for name in ("thickness", "modulus", "clamp", "mass")))
    clean = np.asarray(fm.frequency_response(model, hertz.tolist(), loss_factor=truth["loss"]).of())
    clean = clean * np.exp(-2j * np.pi * hertz * truth["delay"])
    deviation = RESPONSE_SCATTER * np.abs(clean)
    noise = np.random.default_rng(0).standard_normal((2, len(hertz)))
    values = clean + deviation * (noise[0] + 1j * noise[1])
    data = fm.measured_response(hertz, values, deviation, loss_factor="loss", delay="delay")
    seconds, busy = [], []
    for _ in range(2):
        begin, began = time.perf_counter(), time.process_time()
        found = fm.fit(guide, data, start, bounds)
        seconds.append(time.perf_counter() - begin)
        busy.append(time.process_time() - began)
    pulls = [abs(float(found.parameters[name] - truth[name]) / float(found.deviation[name])) for name in truth]
    times = {"first": seconds[0], "second": seconds[1], "busy": busy[1]}
    return times | {"evaluations": found.evaluations, "worst error": max(pulls)}


def from_far() -> dict[str, Any]:
    """Counts of fits from 24 starts up to 20 % off, by loss factor and by comparison of values or of logarithms."""
    import flexmb as fm

    random = np.random.default_rng(1)
    shares = [*itertools.product((0.8, 1.2), repeat=4), *(1 + 0.2 * random.uniform(-1, 1, (8, 4)))]
    model = guide(TRUTH["thickness"], TRUTH["modulus"], TRUTH["clamp"])
    noise = np.random.default_rng(0).standard_normal((2, len(HERTZ)))
    counts = {"starts": len(shares)}
    for loss, logarithmic in itertools.product((TRUTH["loss"], 0.002), (False, True)):
        truth = TRUTH | {"loss": loss}
        clean = np.asarray(fm.frequency_response(model, HERTZ.tolist(), loss_factor=loss).of())
        deviation = RESPONSE_SCATTER * np.abs(clean)
        values = clean + deviation * (noise[0] + 1j * noise[1])
        data = fm.measured_response(HERTZ, values, deviation, loss_factor="loss", logarithmic=logarithmic)
        right = silent = 0
        for share in shares:
            start = {name: value * factor for (name, value), factor in zip(truth.items(), share, strict=True)}
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                found = fm.fit(guide, data, start, BOUNDS, throw=False)
            pulls = [abs(float(found.parameters[name] - truth[name]) / float(found.deviation[name])) for name in truth]
            is_right = max(pulls) < FAR
            right += is_right
            silent += not is_right and found.result is fm.RESULTS.successful
        kind = f"loss {loss:g}, {'logarithms' if logarithmic else 'values'}"
        counts |= {f"{kind}, right": right, f"{kind}, wrong and successful": silent}
    return counts


def _repeated(build: Any, data: Any, start: dict[str, float], deviation: np.ndarray, sets: int) -> dict[str, Any]:
    import flexmb as fm

    begin = time.perf_counter()
    found = fm.fit(build, data, start, {name: BOUNDS[name] for name in start})
    first = time.perf_counter() - begin
    noise = np.random.default_rng(0).standard_normal((sets, len(data.values)))
    # Compile.
    found.again(data.values + deviation * noise[:50])
    begin, busy = time.perf_counter(), time.process_time()
    several = found.again(data.values + deviation * noise)
    again, busy = (time.perf_counter() - begin) / sets, (time.process_time() - busy) / sets
    shares = {}
    for name in start:
        # Symmetric in the logarithm, as `interval` is.
        relative = np.log(several.parameters[name] / TRUTH[name]) * several.parameters[name] / several.deviation[name]
        shares[name] = float(np.mean(np.abs(relative) < 1.959964))
    times = {"first": first, "again": again, "busy": busy}
    return {"sets": sets, "converged": float(np.mean(several.converged))} | times | shares


def main() -> None:
    """All tables, with the results kept."""
    import flexmb as fm

    fm.enable_x64()
    from record import save

    sets = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    found = {"response": response_fits(sets), "frequencies": frequency_fits(sets), "long": long_response()}
    found["far"] = from_far()
    assert not any(value for key, value in found["far"].items() if key.endswith("successful"))
    for name, row in found.items():
        print(name, ", ".join(f"{key} {value:.4g}" for key, value in row.items()))
        for parameter in TRUTH.keys() & row.keys():
            assert abs(row[parameter] - 0.95) < max(0.02, 3 * np.sqrt(0.95 * 0.05 / sets)), (name, parameter)
    save("fits", found)


if __name__ == "__main__":
    main()
