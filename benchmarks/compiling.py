"""What first answers cost to compile, and a leaf spring beside a spectral beam with shear of the same order.

``python benchmarks/compiling.py`` takes two minutes and writes results/compiling.json: processor time in fresh
processes, on all cores at once, tracing and compiling together, without that of the imports. Of the answers of one
element and of a guide, less that of a second answer: from nothing, for a cache, and with it, and of the whole process
with it above that of ``import jax.numpy``, one run of each; ``python benchmarks/compiling.py answers 7`` measures these
alone, medians of seven. How long one waits for each from nothing is measured one after the other, on idle cores.
"""

import dataclasses
import json
import statistics
import sys
import tempfile
import warnings
from typing import Any

# Processor times scatter little: one run each, but where more are asked for.
RUNS = 1
ANSWERS = (
    "equilibrium of a spectral beam in space",
    "path of a spectral beam in the plane",
    "motion of a guide in the plane",
    "motion of a beam in space",
    "motion of a spectral beam in space",
    "derivative of the motion of a guide in the plane",
)
WAYS = ("from nothing", "for a cache", "with it")
WHOLE = "whole process with it, above import jax.numpy"
CASES = ("plain", "fold", "taper", "loaded")
KINDS = ("leaf_spring", "spectral_beam")


def first(case: str, kind: str) -> tuple[float, float]:
    """Processor time of a first linearisation in this process [s], and a compliance that it gives [m/N]."""
    import time

    import flexmb as fm
    from flexmb import spatial

    fm.enable_x64()
    warnings.simplefilter("ignore", fm.BeamTheoryWarning)
    steel = fm.Material(E=210e9, G=210e9 / 2.6, rho=7850)
    element = spatial.leaf_spring if kind == "leaf_spring" else spatial.spectral_beam(6, shear=True)
    sizes = {"material": steel, "shear": kind != "leaf_spring"}
    section = fm.Rectangle(0.018, 0.5e-3, **sizes)
    if case == "taper":
        section = fm.sections.taper(section, fm.Rectangle(0.018, 0.3e-3, **sizes))
    b = fm.Builder()
    b.node("a", (0, 0, 0))
    b.node("c", (0.1, 0, 0))
    b.add(element, "a", "c", section=section, y=(0, 1, 0))
    b.fix("a")
    end = "c"
    if case == "fold":
        end = "d"
        b.node("d", (0.1, 0, 0.1))
        b.add(element, "c", "d", section=section, y=(0, 1, 0))
    b.mass(end, 0.1, inertia=(1e-5, 0, 0, 1e-5, 0, 1e-5))
    if case == "loaded":
        b.force(end, (0, 0, 0.3))
    model = b.build()
    start = time.process_time()
    lin = fm.linearize(model)
    taken = time.process_time() - start
    return taken, float(fm.compliance(lin, end)[1, 1])


def answered(what: str, folder: str = "") -> tuple[float, float, float, float]:
    """Processor time of a first answer in this process less that of a second one [s], and a number of the answer.

    Args:
        what: One of ``ANSWERS``.
        folder: Of the cache; empty: none.

    Returns:
        The two, the processor time of this process from its start to the first answer, imports included, and by how
        much longer than for the second one waits for the first [s].
    """
    import time

    import jax
    import numpy as np

    import flexmb as fm
    from flexmb import planar, spatial

    fm.enable_x64()
    if folder:
        fm.enable_cache(folder)
    warnings.simplefilter("ignore")
    plane, space = "plane" in what, np.s_[:2] if "plane" in what else np.s_[:]
    if "guide" in what:
        from motion import guide

        model = guide(plane)
    else:
        kind = planar if plane else spatial
        b = fm.Builder()
        b.node("a", (0.0, 0.0, 0.0)[space])
        b.node("c", (0.3, 0.0, 0.0)[space])
        section = fm.Rectangle(0.018, 0.0005, fm.Material(E=210e9, G=80e9, rho=7850.0))
        element = kind.spectral_beam(5) if "spectral" in what else kind.beam
        across: dict[str, Any] = {} if plane else {"y": (0, 1, 0)}
        b.add(element, "a", "c", section=section, **across)
        b.fix("a")
        b.force("c", (0.1, 0.5, 1.0)[space])
        model = b.build()
    times = np.linspace(0, 1e-3, 11)
    # Names are loaded when they are asked for.
    name, *arguments = {"equilibrium": ("equilibrium",), "path": ("path",), "motion": ("simulate", times)}[
        "motion" if "motion" in what else what.split()[0]
    ]

    def asked(model: Any) -> Any:
        return getattr(fm, name)(model, *arguments).x

    def derivative(model: Any) -> Any:
        def last(share: Any):
            scaled = jax.tree.map(lambda number: share * number, model.parameters.properties)
            parameters = dataclasses.replace(model.parameters, properties=scaled)
            return asked(dataclasses.replace(model, parameters=parameters))[-1].sum()

        return jax.grad(last)(1.0)[None]

    question = derivative if what.startswith("derivative") else asked

    def once() -> tuple[np.ndarray, np.ndarray]:
        start = np.array([time.process_time(), time.perf_counter()])
        found = np.asarray(question(model))
        taken = np.array([time.process_time(), time.perf_counter()]) - start
        return taken, found.reshape(-1, found.shape[-1])[-1]

    first, found = once()
    whole = time.process_time()
    taken, waited = first - once()[0]
    return float(taken), float(np.sum(np.abs(found))), whole, float(waited)


def imported() -> tuple[float]:
    """Processor time of this process after ``import jax.numpy`` [s]."""
    import time

    import jax.numpy  # noqa: F401

    return (time.process_time(),)


def _said(function: str, *words: str) -> list[float]:
    """Numbers that a fresh process says, which itself imports nothing beside what is measured."""
    from record import numbers_of

    return numbers_of("compiling", function, *words)


def once_of_all(what: str) -> dict[str, float]:
    """Processor time of one first answer each way, and of a whole process above ``import jax.numpy`` [s].

    Args:
        what: One of ``ANSWERS``.
    """
    with tempfile.TemporaryDirectory() as folder:
        words = dict(zip(WAYS, ((), (folder,), (folder,)), strict=True))
        found = {way: _said("answered", what, *own) for way, own in words.items()}
    numbers = [number for _, number, *_ in found.values()]
    assert max(numbers) - min(numbers) <= 1e-6 * max(numbers), (what, numbers)
    return {way: taken for way, (taken, *_) in found.items()} | {WHOLE: found["with it"][2] - _said("imported")[0]}


def first_answers(runs: int = RUNS) -> dict[str, dict[str, float]]:
    """Medians of the processor time of first answers, each way, and of a whole process above ``import jax.numpy`` [s].

    Args:
        runs: How many of each.
    """
    from record import side_by_side

    every = side_by_side(once_of_all, [what for _ in range(runs) for what in ANSWERS])
    medians = {}
    for i, what in enumerate(ANSWERS):
        own = every[i :: len(ANSWERS)]
        medians[what] = {way: statistics.median(times[way] for times in own) for way in own[0]}
        print(f"{what:<50}" + "".join(f"{taken:7.2f} s {way}" for way, taken in medians[what].items()), flush=True)
    return medians


def waits(runs: int = RUNS) -> dict[str, float]:
    """How long one waits for each first answer from nothing, one after the other [s], medians.

    Args:
        runs: How many of each.
    """
    found = {what: statistics.median(_said("answered", what)[3] for _ in range(runs)) for what in ANSWERS}
    for what, waited in found.items():
        print(f"{what:<50}{waited:7.2f} s by the clock from nothing", flush=True)
    return found


def main() -> None:
    """Measure in fresh processes in turn, check that both kinds agree where they should, and save."""
    from record import RESULTS, save, side_by_side

    # ``answers 7``: as many runs of each.
    runs = [int(word) for word in sys.argv[1:] if word.isdigit()]
    first_of_all = {
        "processor time of first answers [s]": first_answers(*runs),
        "waiting for first answers from nothing [s]": waits(*runs),
        "runs of these": (*runs, RUNS)[0],
    }
    if "answers" in sys.argv[1:]:
        known = json.loads((RESULTS / "compiling.json").read_text())
        save("compiling", {name: value for name, value in known.items() if name != "about"} | first_of_all)
        return
    asked = [(case, kind) for case in CASES for kind in KINDS]
    said = side_by_side(lambda which: _said("first", *which), asked * RUNS)
    found = {}
    for i, (case, kind) in enumerate(asked):
        found[f"{case}, {kind}"] = statistics.median(taken for taken, _ in said[i :: len(asked)])
    sideways = dict(zip(asked, (compliance for _, compliance in said), strict=False))
    for case in CASES:
        # Restrained warping and clamps are 7 % in the fold, which twists.
        assert abs(sideways[case, "leaf_spring"] / sideways[case, "spectral_beam"] - 1) < 0.1, sideways
    for case in CASES:
        leaf, beam = (found[f"{case}, {kind}"] for kind in KINDS)
        print(f"{case:<8}{leaf:6.2f} s beside {beam:.2f} s: {leaf / beam:.2f}")
    save("compiling", {"processor time [s]": found} | first_of_all)


if __name__ == "__main__":
    main()
