"""Timing of interleaved variants, and results with the machine and versions they were measured on."""

import datetime
import importlib.metadata
import json
import os
import platform
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
RESULTS = HERE / "results"
PACKAGES = ("jax", "jaxlib", "numpy", "scipy")
# What takes longer is run once [s].
SLOW = 1.5


def interleaved(
    variants: dict[str, Callable[[], Any]],
    runs: int = 7,
    repeat: int = 1,
    warm: bool = False,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, dict[str, float]]:
    """Time variants in turn, so that a drift of the machine falls on all; what takes long is run once.

    Args:
        variants: Functions that return when their result is there.
        runs: Counted runs of each; one of what takes more than ``SLOW``.
        repeat: Calls a run; the time is that of one call.
        warm: Whether each has been called before; otherwise each is called once, uncounted.
        clock: What is read before and after [s].

    Returns:
        Median, minimum and maximum of each [s], and "runs" where that is one.
    """
    times: dict[str, list[float]] = {name: [] for name in variants}
    for function in () if warm else variants.values():
        function()
    for _ in range(runs):
        for name, function in variants.items():
            if times[name] and times[name][0] > SLOW:
                continue
            start = clock()
            for _ in range(repeat):
                function()
            times[name].append((clock() - start) / repeat)
    return {name: _of(t) for name, t in times.items()}


def _of(times: list[float]) -> dict[str, float]:
    own = {"median": statistics.median(times), "min": min(times), "max": max(times)}
    return own | ({"runs": 1} if len(times) == 1 else {})


def processor_times(calls: dict[str, Callable[[], Any]], runs: int = 7) -> dict[str, dict[str, float]]:
    """Time of the processor, of all threads, of interleaved runs: median, minimum and maximum of each [s].

    Args:
        calls: What is timed, by name; each has been called before.
        runs: Of each; one of what takes more than ``SLOW``.
    """
    return interleaved(calls, runs, warm=True, clock=time.process_time)


def once(call: Callable[[], Any]) -> tuple[Any, dict[str, float]]:
    """What a call that is not repeated gives, and its time of the processor, as from :func:`processor_times`.

    Args:
        call: Compiled.
    """
    begin = time.process_time()
    found = call()
    return found, _of([time.process_time() - begin])


def side_by_side(function: Callable[[Any], Any], of: Iterable[Any]) -> list[Any]:
    """Results of a function that waits for a process, as many at once as there are cores.

    Only what is measured by its time of the processor may run so.

    Args:
        function: Of one item.
        of: Items.
    """
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(function, of))


def numbers_of(script: str, function: str, *words: str, **around: str) -> list[float]:
    """Numbers that a function of a script gives in a process of its own.

    Args:
        script: Name of its module.
        function: Of texts.
        words: Its arguments.
        around: Variables of the environment.
    """
    paths = os.pathsep.join([str(HERE), os.environ.get("PYTHONPATH", "")])
    # Python's own compiled code lies beside the text of an installed package.
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    code = f"import sys, {script}; print(*{script}.{function}(*sys.argv[1:]))"
    environment = {**kept, "PYTHONPATH": paths, **around}
    run = [sys.executable, "-c", code, *words]
    return [float(word) for word in subprocess.check_output(run, env=environment, text=True).split()]


def peak_memory() -> float:
    """Largest memory of this process since it began its program [GB]; ``resource`` counts that of its parent in."""
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines())
    return int(status["VmHWM"].split()[0]) * 1024 / 1e9


def processor() -> str:
    """Model name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()


def save(name: str, data: dict[str, Any], packages: tuple[str, ...] = PACKAGES) -> None:
    """Write results with versions, processor and date.

    Args:
        name: File name without its ending.
        data: Results.
        packages: Those whose versions are written.
    """
    about = {
        "date": datetime.date.today().isoformat(),
        "python": platform.python_version(),
        "processor": processor(),
        "cores": os.cpu_count(),
        "versions": {p: importlib.metadata.version(p) for p in packages},
    }
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / f"{name}.json").write_text(json.dumps({"about": about, **data}, indent=1) + "\n")


def show(title: str, times: dict[str, dict[str, float]]) -> None:
    """Print a table of times.

    Args:
        title: Heading.
        times: As from :func:`interleaved`.
    """
    print(title)
    for name, t in times.items():
        spread = "one run" if "runs" in t else f"{1e3 * t['min']:.3f} to {1e3 * t['max']:.3f}"
        print(f"  {name:<44}{1e3 * t['median']:10.3f} ms   ({spread})")


def chart(
    name: str, found: dict[str, dict], timed: dict[str, dict[str, float]], title: str, time: str, error: str
) -> None:
    """Draw error against time, one line for each family of variants.

    Args:
        name: File name without its ending.
        found: Entries with their "error", by names "family: size".
        timed: Times by the same names [s].
        title: Heading.
        time: Label of the times.
        error: Label of the errors.
    """
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    families: dict[str, list[str]] = {}
    for variant in found:
        families.setdefault(variant.rsplit(": ", 1)[0], []).append(variant)
    figure, axes = plt.subplots(figsize=(6.8, 5.2), layout="constrained")
    for (family, variants), marker in zip(families.items(), "osD^v<>Pp*", strict=False):
        x, y = [1e3 * timed[v]["median"] for v in variants], [found[v]["error"] for v in variants]
        axes.loglog(x, y, marker=marker, label=family)
        for variant, xi, yi in zip(variants, x, y, strict=True):
            size = variant.rsplit(": ", 1)[1]
            axes.annotate(size, (xi, yi), textcoords="offset points", xytext=(4, 4), fontsize=8)
    axes.set_xlabel(f"{time} [ms]")
    axes.set_ylabel(f"{error} [-]")
    axes.set_title(title, fontsize=11)
    axes.grid(True, which="major", alpha=0.4)
    # Below the axes, where it hides no point.
    figure.legend(loc="outside lower center", ncols=2, fontsize=8)
    RESULTS.mkdir(exist_ok=True)
    figure.savefig(RESULTS / f"{name}.png", dpi=120)
