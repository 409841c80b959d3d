"""Leaf springs beside solid finite elements: error and time of one leaf spring, a spectral beam, cubic beams.

``python benchmarks/solid.py`` solves the cases of ``solid_cases.py`` and ``solid_shapes.py`` by CalculiX (Debian's
``calculix-ccx``) on two meshes each, some hour, and compares. It writes results/solid.json and results/solid.png.
Without CalculiX, or with ``--committed``, the solid results that are there are used; with names of cases, only those.
"""

import json
import sys
import time
from pathlib import Path

import flexmb as fm

HERE = Path(__file__).parent
RESULTS = HERE / "results" / "solid.json"
RUNS = 7


def solids() -> dict:
    """Solid models by name, in their order."""
    from solid_cases import CASES
    from solid_shapes import SHAPES

    return CASES | SHAPES


def beams() -> dict:
    """Builders by case and kind of element."""
    import solid_beams
    import solid_shape_beams

    shapes = {
        name: {kind: (build, solid_beams.KINDS[kind]) for kind in solid_shape_beams.KINDS}
        for name, build in solid_shape_beams.CASES.items()
    }
    cases = {
        name: {kind: (build, element) for kind, element in solid_beams.KINDS.items()}
        for name, build in solid_beams.CASES.items()
    }
    return cases | shapes


def solve(name: str) -> dict:
    """A case on both meshes: numbers of the fine one with units and the difference of the coarse, and times [s]."""
    (coarse, first), (fine, second) = (solids()[name](mesh) for mesh in ("coarse", "fine"))
    numbers = {k: {"unit": unit, "coarse": coarse[k][0], "fine": value} for k, (value, unit) in fine.items()}
    return {"quantities": numbers, "seconds": {"coarse": first, "fine": second}}


def compare(name: str, case: dict) -> dict:
    """Errors and times of every kind of element in a case.

    Args:
        name: Of the case.
        case: Solid results.

    Returns:
        By kind: errors by quantity, time of the questions compiled [s] and of the first time they are asked.
    """
    from record import interleaved

    found, run = {}, {}
    for kind, (build, element) in beams()[name].items():
        try:
            ask = build(element)
            begin = time.perf_counter()
            numbers = ask()
        except (fm.AnalysisError, fm.ModelError) as fault:
            print(f"{name}, {kind}: {fault}")
            continue
        first = time.perf_counter() - begin
        errors = {k: numbers[k] / q["fine"] - 1 for k, q in case["quantities"].items() if k in numbers}
        # One cubic beam between two clamps cannot bend at all: its buckling load is no number to compare.
        errors = {k: error for k, error in errors.items() if abs(error) < 1e3}
        found[kind] = {"errors": errors, "worst": max(map(abs, errors.values())), "first": first}
        run[kind] = ask
    for kind, timed in interleaved(run, RUNS).items():
        found[kind]["time"] = timed
    return found


def table(name: str, case: dict, compared: dict) -> None:
    """Print a case: quantity, solid value, difference of the meshes, error of each kind."""
    print(f"\n{name}: solid {case['seconds']['fine']:.1f} s, coarse mesh {case['seconds']['coarse']:.1f} s")
    for i, (kind, entry) in enumerate(compared.items()):
        took = 1e3 * entry["time"]["median"]
        print(f"  ({i + 1}) {kind}: {took:.1f} ms compiled, {entry['first']:.1f} s the first time")
    heads = "".join(f"{f'({i + 1})':>9}" for i in range(len(compared)))
    print(f"  {'':<52}{'solid':>12} {'':<8}{'meshes':>8}{heads}   errors in %")
    for what, q in case["quantities"].items():
        errors = "".join(
            f"{100 * e['errors'][what]:9.2f}" if what in e["errors"] else f"{'none':>9}" for e in compared.values()
        )
        meshes = 100 * (q["coarse"] / q["fine"] - 1)
        print(f"  {what:<52}{q['fine']:12.5g} {q['unit']:<8}{meshes:8.2f}{errors}")


def draw(cases: dict, compared: dict) -> None:
    """Greatest error against time, a point for each case and kind."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6.8, 5.2), layout="constrained")
    kinds = list(dict.fromkeys(kind for found in compared.values() for kind in found))
    for kind, marker in zip(kinds, "*osD^", strict=False):
        points = [(f[kind]["time"]["median"], 100 * f[kind]["worst"]) for f in compared.values() if kind in f]
        axes.loglog(*zip(*points, strict=True), marker, label=kind, alpha=0.8)
    for mesh, marker in (("fine", "P"), ("coarse", "X")):
        # The coarse mesh is measured by the fine one; the fine one is at least as good.
        worst = [max(abs(q["coarse"] / q["fine"] - 1) for q in c["quantities"].values()) for c in cases.values()]
        times = [c["seconds"][mesh] for c in cases.values()]
        label = "solid, both meshes' difference, " + ("fine" if mesh == "fine" else "coarse")
        axes.loglog(times, [100 * w for w in worst], marker, label=label, alpha=0.8)
    axes.set_xlabel("time of all questions of a case, compiled; of CalculiX on one core [s]")
    axes.set_ylabel("greatest error of a case against solid elements [%]")
    axes.set_title("Leaf springs beside solid finite elements: a point a case", fontsize=11)
    axes.grid(True, which="major", alpha=0.4)
    figure.legend(loc="outside lower center", ncols=2, fontsize=8)
    figure.savefig(RESULTS.with_suffix(".png"), dpi=120)


def main() -> None:
    """Solve, compare, print, save and draw."""
    from record import save
    from solid_models import installed

    fm.enable_x64()
    fm.enable_cache()
    every = solids()
    given = [a for a in sys.argv[1:] if a != "--committed"]
    if unknown := [name for name in given if name not in every]:
        sys.exit(f"There is no case '{unknown[0]}'. There are: {', '.join(every)}.")
    names = given or list(every)
    solving = installed() and "--committed" not in sys.argv
    if not solving:
        why = "they were asked for" if installed() else "CalculiX (ccx) is not installed"
        print(f"The committed solid results, results/solid.json, are used, since {why}.")
    before = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    cases, compared = before.get("solid", {}), before.get("flexmb", {})
    for name in names:
        if solving:
            cases[name] = solve(name)
        elif name not in cases:
            print(f"{name}: no solid results are there.")
            continue
        found = compare(name, cases[name])
        if found:
            compared[name] = found
        else:
            print(f"{name}: not compared, no element solved it.")
        table(name, cases[name], found)
        sys.stdout.flush()
        # In the order of the cases, after each, so that what took long is kept.
        parts = {"solid": cases, "flexmb": compared}
        save("solid", {part: {k: some[k] for k in every if k in some} for part, some in parts.items()})
    draw(cases, compared)


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
