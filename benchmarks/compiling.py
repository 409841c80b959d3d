"""What a leaf spring costs to compile beside a spectral beam with shear of the same order, from nothing.

``python benchmarks/compiling.py`` takes six minutes and writes results/compiling.json: processor time of a first
linearisation in a fresh process, tracing and compiling together, without that of the imports.
"""

import os
import statistics
import subprocess
import sys
import warnings

RUNS = 7
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


def main() -> None:
    """Measure in fresh processes in turn, check that both kinds agree where they should, and save."""
    from record import save

    code = "import sys, compiling; print(*compiling.first(*sys.argv[1:]))"
    times: dict[tuple[str, str], list[float]] = {}
    for run in range(RUNS + 1):
        for case in CASES:
            sideways = {}
            for kind in KINDS:
                said = subprocess.run(
                    [sys.executable, "-c", code, case, kind], capture_output=True, text=True, check=True, env=os.environ
                )
                taken, sideways[kind] = map(float, said.stdout.split())
                # The first run only fills the machine's caches.
                if run:
                    times.setdefault((case, kind), []).append(taken)
            # Restrained warping and clamps are 7 % in the fold, which twists.
            assert abs(sideways["leaf_spring"] / sideways["spectral_beam"] - 1) < 0.1, sideways
    found = {f"{case}, {kind}": statistics.median(values) for (case, kind), values in times.items()}
    for case in CASES:
        leaf, beam = (found[f"{case}, {kind}"] for kind in KINDS)
        print(f"{case:<8}{leaf:6.2f} s beside {beam:.2f} s: {leaf / beam:.2f}")
    save("compiling", {"processor time [s]": found})


if __name__ == "__main__":
    main()
