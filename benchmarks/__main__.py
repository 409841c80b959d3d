"""All charts anew: ``python -m benchmarks``, or ``python -m benchmarks designs motion`` for some.

``python -m benchmarks --quick`` draws none: in five minutes one table beside the committed one, what lost being named.
``python -m benchmarks --against COMMIT`` asks the package of another commit and today's in turn, and names what is
slower.

Each runs in a process of its own, one after the other but for those that measure their own time of the processor alone,
which run on all cores, and writes its results, with versions and processor, to benchmarks/results. Exudyn, PyNite and
SoRoMoX take part where they are installed (``pip install -e '.[peers]'``). What each took is printed in the end and
written to results/whole.json: seconds, and those of the processor, which other work on the machine changes less; and
those of all scripts in one run, by the clock.
"""

import datetime
import json
import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
# One chart or table each, the quickest first.
SCRIPTS = (
    "convergence",
    "operations",
    "threads",
    "first_impression",
    "command_line",
    "compiling",
    "response",
    "lean",
    "size",
    "large",
    "designs",
    "batch",
    "chains_static",
    "large_deflection",
    "viewer",
    "workbench",
    "along",
    "swing",
    "chains",
    "nets",
    "motion",
    "peers",
    "stability",
)
# These measure nothing, or the processor's time of their own process in calls of ten milliseconds and more, which
# another process changes little (calls of one millisecond take up to 1.7 times as long beside one). As many of them
# run at once as there are cores, those first that take longest.
BESIDE = ("motion", "swing", "nets", "chains", "size", "along", "convergence", "operations")
# These run only when named: CalculiX takes an hour, a thousand fits and measured structures some minutes,
# and what others are compared with is kept.
NAMED = ("solid", "solutions", "fits", "measured", "measured_fits")
# Tables of numbers, not charts; what follows goes to them.
TABLES = {"--quick": "quick", "--against": "against"}


def spent(name: str, words: list[str], output: Any = None) -> tuple[int, float, float]:
    """Run a script in a process of its own.

    Args:
        name: Of the script.
        words: Its arguments.
        output: File that takes what it prints; None: where this process prints.

    Returns:
        Its exit status, seconds, and those of the processor.
    """
    paths = [str(HERE.parent), str(HERE), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "JAX_PLATFORMS": "cpu"}
    begin, command = time.perf_counter(), [sys.executable, str(HERE / f"{name}.py"), *words]
    process = subprocess.Popen(command, env=environment, stdout=output, stderr=output and subprocess.STDOUT)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, time.perf_counter() - begin, used.ru_utime + used.ru_stime


def done(name: str, beside: bool = False) -> dict | None:
    """Run a script, and say what it took; None where it failed.

    Args:
        name: Of the script.
        beside: Whether another one runs at the same time, so that it prints all in the end.
    """
    with tempfile.TemporaryFile("w+", encoding="utf-8") as output:
        if not beside:
            print(f"== {name}", flush=True)
        status, seconds, processor = spent(name, [], output if beside else None)
        output.seek(0)
        own = f"== {name}\n{output.read()}" if beside else ""
    print(f"{own}== {name} {f'failed ({status})' if status else 'done'} after {seconds:.0f} s", flush=True)
    today = datetime.date.today().isoformat()
    took = {"seconds": seconds, "processor": processor, "date": today, "load": os.getloadavg()[2]}
    return None if status else took


def told(scripts: dict[str, dict]) -> str:
    """The table of what scripts took, and its sums.

    Args:
        scripts: "seconds" and "processor" by name of the script.
    """
    lines = [f"{'script':<20}{'seconds':>10}{'processor':>12}"]
    lines += [f"{name:<20}{own['seconds']:10.0f}{own['processor']:12.0f}" for name, own in scripts.items()]
    sums = [sum(own[what] for own in scripts.values()) for what in ("seconds", "processor")]
    return "\n".join([*lines, f"{'together':<20}{sums[0]:10.0f}{sums[1]:12.0f}"])


def main() -> int:
    """Run the scripts that are asked for; the number of those that failed."""
    wanted = sys.argv[1:] or list(SCRIPTS)
    if tables := [word for word in wanted if word in TABLES]:
        return spent(TABLES[tables[0]], [word for word in wanted if word != tables[0]])[0]
    if unknown := [name for name in wanted if name not in (*SCRIPTS, *NAMED)]:
        print(
            f"There is no benchmark '{unknown[0]}'. There are: {', '.join(SCRIPTS + NAMED)}; {', '.join(TABLES)}.",
            file=sys.stderr,
        )
        return 2
    begin = time.perf_counter()
    beside = [name for name in BESIDE if name in wanted]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        every = dict(zip(beside, pool.map(lambda name: done(name, True), beside), strict=True))
    every |= {name: done(name) for name in wanted if name not in beside}
    took = {name: every[name] for name in wanted if every[name] is not None}
    print(told(took))
    clock = time.perf_counter() - begin
    print(f"All of it took {clock:.0f} s.")
    sys.path.insert(0, str(HERE))
    from record import RESULTS, save

    kept = RESULTS / "whole.json"
    before = json.loads(kept.read_text()) if kept.exists() else {}
    whole = before.get("scripts", {}) | took
    # Some run side by side, so that the whole is less than the sum of their seconds.
    last = {"seconds": clock, "date": f"{datetime.date.today()}"} if set(took) >= set(SCRIPTS) else before.get("all")
    if took:
        save("whole", {"all": last, "scripts": {name: whole[name] for name in SCRIPTS if name in whole}})
    return len(wanted) - len(took)


if __name__ == "__main__":
    sys.exit(main())
