"""All charts anew: ``python -m benchmarks``, or ``python -m benchmarks designs motion`` for some.

``python -m benchmarks --quick`` draws none: in five minutes one table beside the committed one, what lost being named.

Each runs in a process of its own, one after the other, and writes its results, with versions and processor, to
benchmarks/results. Exudyn and PyNite take part where they are installed (``pip install -e '.[peers]'``).
"""

import os
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
    "motion",
    "stability",
)
# These run only when named: CalculiX takes half an hour.
NAMED = ("solid",)
QUICK = "quick"


def main() -> int:
    """Run the scripts that are asked for; the number of those that failed."""
    wanted, options = sys.argv[1:] or SCRIPTS, []
    if "--quick" in wanted:
        options = [word for word in wanted if word != "--quick"]
        wanted = [QUICK]
    unknown = [name for name in wanted if name not in (*SCRIPTS, *NAMED, QUICK)]
    if unknown:
        print(f"There is no benchmark '{unknown[0]}'. There are: {', '.join(SCRIPTS + NAMED)}.", file=sys.stderr)
        return 2
    paths = [str(HERE.parent), str(HERE), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "JAX_PLATFORMS": "cpu"}
    failed = 0
    for name in wanted:
        begin = time.perf_counter()
        print(f"== {name}", flush=True)
        code = subprocess.run([sys.executable, str(HERE / f"{name}.py"), *options], env=environment).returncode
        failed += code != 0
        outcome = "done" if code == 0 else f"failed ({code})"
        print(f"== {name} {outcome} after {time.perf_counter() - begin:.0f} s", flush=True)
    return failed


if __name__ == "__main__":
    sys.exit(main())
