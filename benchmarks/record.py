"""Timing of interleaved variants, and results with the machine and versions they were measured on."""

import datetime
import importlib.metadata
import json
import platform
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).parent / "results"
PACKAGES = ("jax", "jaxlib", "numpy", "scipy")


def interleaved(variants: dict[str, Callable[[], Any]], runs: int = 7, repeat: int = 1) -> dict[str, dict[str, float]]:
    """Time variants in turn, so that a drift of the machine falls on all.

    Args:
        variants: Functions that return when their result is there; each is called once before, uncounted.
        runs: Counted runs of each.
        repeat: Calls a run; the time is that of one call.

    Returns:
        Median, minimum and maximum of each [s].
    """
    times: dict[str, list[float]] = {name: [] for name in variants}
    for function in variants.values():
        function()
    for _ in range(runs):
        for name, function in variants.items():
            start = time.perf_counter()
            for _ in range(repeat):
                function()
            times[name].append((time.perf_counter() - start) / repeat)
    return {n: {"median": statistics.median(t), "min": min(t), "max": max(t)} for n, t in times.items()}


def processor_times(calls: dict[str, Callable[[], Any]], runs: int = 7) -> dict[str, dict[str, float]]:
    """Time of the processor, of all threads, of interleaved runs: median, minimum and maximum of each [s].

    Args:
        calls: What is timed, by name.
        runs: Of each.
    """
    spent = {name: [] for name in calls}
    for _ in range(runs):
        for name, call in calls.items():
            begin = time.process_time()
            call()
            spent[name].append(time.process_time() - begin)
    return {name: {"min": min(t), "median": statistics.median(t), "max": max(t)} for name, t in spent.items()}


def processor() -> str:
    """Model name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
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
    import os

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
        print(f"  {name:<44}{1e3 * t['median']:10.3f} ms   ({1e3 * t['min']:.3f} to {1e3 * t['max']:.3f})")


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
