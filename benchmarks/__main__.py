"""All charts anew: ``python -m benchmarks``, or ``python -m benchmarks designs motion`` for some.

``python -m benchmarks --quick`` draws none: in five minutes one table beside the committed one, what lost being named.
``python -m benchmarks --against COMMIT`` asks the package of another commit and today's in turn, and names what is
slower.

Each runs in a process of its own, one after the other, and writes its results, with versions and processor, to
benchmarks/results. Exudyn and PyNite take part where they are installed (``pip install -e '.[peers]'``). What each took
is printed in the end and written to results/whole.json: seconds, and those of the processor, which other work on the
machine changes less.
"""

import datetime
import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

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
    "stability",
)
# These run only when named: CalculiX takes half an hour, and what others are compared with is kept.
NAMED = ("solid", "solutions")
# Tables of numbers, not charts; what follows goes to them.
TABLES = {"--quick": "quick", "--against": "against"}


def spent(name: str, words: list[str]) -> tuple[int, float, float]:
    """Run a script in a process of its own.

    Args:
        name: Of the script.
        words: Its arguments.

    Returns:
        Its exit status, seconds, and those of the processor.
    """
    paths = [str(HERE.parent), str(HERE), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "JAX_PLATFORMS": "cpu"}

    def processor() -> float:
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    begin, before = time.perf_counter(), processor()
    status = subprocess.run([sys.executable, str(HERE / f"{name}.py"), *words], env=environment).returncode
    return status, time.perf_counter() - begin, processor() - before


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
    took, failed = {}, 0
    for name in wanted:
        print(f"== {name}", flush=True)
        status, seconds, processor = spent(name, [])
        failed += status != 0
        print(f"== {name} {f'failed ({status})' if status else 'done'} after {seconds:.0f} s", flush=True)
        if not status:
            today = datetime.date.today().isoformat()
            took[name] = {"seconds": seconds, "processor": processor, "date": today, "load": os.getloadavg()[2]}
    print(told(took))
    sys.path.insert(0, str(HERE))
    from record import RESULTS, save

    kept = RESULTS / "whole.json"
    before = json.loads(kept.read_text())["scripts"] if kept.exists() else {}
    every = before | took
    if took:
        save("whole", {"scripts": {name: every[name] for name in SCRIPTS if name in every}})
    return failed


if __name__ == "__main__":
    sys.exit(main())
