"""What threads of LAPACK are worth: kernels in one thread, as the package runs them, and in as many as there are.

Equilibrium and frequencies of a cantilever of planar beams, on a machine that does nothing else and beside one other
busy process. And what XLA's own are, which are as many as there are cores unless ``NPROC`` says otherwise when Python
starts. ``python benchmarks/threads.py`` prints the tables that README quotes and writes results/threads.json.
"""

import contextlib
import functools
import os
import statistics
import subprocess
import sys

SIZES = (16, 32, 64, 128)
RUNS = 7
# Motions, the guide and two pendulums: how they are asked.
ASKED = {
    "guide in space": {"rtol": 1e-6},
    "pendulum of one spectral beam": {"rtol": 3e-2},
    "pendulum of sixteen beams, as a chain": {"rtol": 1e-3, "form": "chain"},
}


def cantilever(beams: int):
    """A leaf spring of so many beams under a force across, beyond its small displacements.

    Args:
        beams: Number of beams.
    """
    import flexmb as fm
    from flexmb import planar

    leaf = fm.Rectangle(0.018, 0.0005, fm.Material(E=210e9, G=80e9, rho=7850.0))
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(f"n{i}", (0.1 * i / beams, 0.0))
    for i in range(beams):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=leaf)
    b.fix("n0")
    b.force(f"n{beams}", (0.0, -4.0))
    return b.build()


@contextlib.contextmanager
def busy(others: int):
    """Beside so many processes that do nothing but count."""
    running = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(others)]
    try:
        yield
    finally:
        for one in running:
            one.kill()
            one.wait()


def asked(what: str) -> tuple[float, float, float]:
    """How long a motion takes in this process by the clock and of the processor [s], and a number of it.

    Args:
        what: One of ``ASKED``.
    """
    import numpy as np
    import swing
    from motion import guide
    from record import interleaved, processor_times

    import flexmb as fm

    fm.enable_x64()
    fm.enable_cache()
    if "guide" in what:
        model, end = guide(False), 0.02
    else:
        model, end = swing.pendulum(*((1, 9) if "spectral" in what else (16,))), swing.END

    def motion():
        return np.asarray(fm.simulate(model, np.linspace(0.0, end, 11), **ASKED[what]).x)

    by_clock = interleaved({what: motion}, RUNS)
    return by_clock[what]["median"], processor_times({what: motion}, RUNS)[what]["median"], float(np.sum(motion()))


def of_xla() -> dict[str, dict[str, list[float]]]:
    """Of each of ``ASKED``, both ways, medians over processes by the clock and of the processor [s]."""
    from record import numbers_of

    ways = {"all threads": {}, "one thread": {"NPROC": "1"}}
    found = {}
    for what in ASKED:
        every = [{way: numbers_of("threads", "asked", what, **own) for way, own in ways.items()} for _ in range(3)]
        answers = [one[way][-1] for one in every for way in ways]
        assert max(answers) - min(answers) <= 1e-6 * abs(answers[0]), what
        found[what] = {way: [statistics.median(one[way][k] for one in every) for k in range(2)] for way in ways}
        for way, (by_clock, used) in found[what].items():
            print(f"{what:<40} XLA, {way}: {1e3 * by_clock:.1f} ms, {1e3 * used:.1f} of the processor")
    return found


def main() -> None:
    """Measure, check that both give the same, print and save."""
    # Before LAPACK is loaded: what a user's shell may have set would hide what is measured.
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.pop(name, None)
    import numpy as np
    from record import interleaved, save, show

    import flexmb as fm
    from flexmb.compilation import compile as kernels

    fm.enable_x64()
    fm.enable_cache()
    one_thread = kernels.one_thread
    found = {}

    def run(model, analysis, limited):
        kernels.one_thread = one_thread if limited else contextlib.nullcontext
        return np.asarray(analysis(model))

    for beams in SIZES:
        model = cantilever(beams)
        # Dense matrices, which are LAPACK's: a chain of so many beams is solved in another way by itself.
        analyses = {
            "equilibrium": lambda m: fm.equilibrium(m, sparse=False).x,
            "frequencies": lambda m: fm.frequencies(m, sparse=False),
        }
        for name, analysis in analyses.items():
            a, b = (run(model, analysis, limited) for limited in (True, False))
            # Sums in another order: round-off, times the condition of the stiffness.
            np.testing.assert_allclose(a, b, rtol=1e-6, atol=1e-9 * np.max(np.abs(a)))
            for others, where in ((0, "alone"), (1, "beside a busy process")):
                with busy(others):
                    variants = {
                        "one thread": functools.partial(run, model, analysis, True),
                        "all threads": functools.partial(run, model, analysis, False),
                    }
                    title = f"{name}, {beams} beams ({model.topology.n_x} coordinates), {where}"
                    found[title] = interleaved(variants, RUNS)
                    show(title, found[title])
    save("threads", {"cores": os.cpu_count(), "times": found, "XLA's, by the clock and of the processor [s]": of_xla()})


if __name__ == "__main__":
    main()
