"""One table in five minutes, beside the one that is committed: ``python -m benchmarks --quick``.

Every row is a question with an answer known from elsewhere: its error, the time of one answer once compiled, the
processor time of the first one from nothing, the instructions that were compiled for it, and the ratio to Exudyn where
that is installed and answers the same question. Rows run in processes of their own, without kept code.

Machines differ, and this one is never quiet. So times are compared as ratios to two yardsticks of the same process, a
factorisation and a program to compile, and may lose what the table calls noise; errors and instructions do not scatter,
and may lose next to nothing. What lost more is named, and the exit status is 1. ``--keep`` writes the table anew.
"""

import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from questions import CASES

HERE = Path(__file__).parent
TABLE = HERE / "results" / "quick.json"
RUNS, PROCESSES = 7, 2
# What may be lost before it is named: factors of the best time of a run, of the first, of an error and of instructions.
NOISE = {"time": 1.6, "first": 1.4, "error": 2.0, "instructions": 1.02}
# Errors below are round-off.
ROUND_OFF = 1e-11


def measure(name: str) -> dict[str, Any]:
    """One row, in this process.

    Args:
        name: Of the case.

    Returns:
        Error; best time of one answer and of Exudyn's [s]; processor time of the first [s]; yardsticks [s].
    """
    import jax
    import jax.numpy as jnp
    import numpy as np

    import flexmb as fm

    fm.enable_x64()

    def best(call: Callable[[], Any]) -> float:
        times = []
        for _ in range(RUNS):
            begin = time.perf_counter()
            call()
            times.append(time.perf_counter() - begin)
        return min(times)

    # Yardstick of the compiler: a program of its own, traced and compiled.
    @jax.jit
    def program(a):
        def step(a, _):
            return jnp.tanh(jnp.linalg.solve(a + 4 * jnp.eye(6), a @ jnp.sin(a))), jnp.linalg.eigvalsh(a + a.T)

        return jax.jacfwd(lambda a: jax.lax.scan(step, a, length=5)[1])(a)

    begin = time.process_time()
    jax.block_until_ready(program(jnp.ones((6, 6))))
    yardstick = time.process_time() - begin
    case = next(one for one in CASES if one.__name__ == name)()
    begin = time.process_time()
    answer = case.ask()
    first = time.process_time() - begin
    symmetric = np.random.default_rng(0).standard_normal((case.size, case.size))
    symmetric, eigh = jnp.asarray(symmetric + symmetric.T), jax.jit(jnp.linalg.eigh)
    other = jnp.asarray(np.random.default_rng(1).standard_normal((120, 120)))
    jax.block_until_ready((eigh(symmetric), eigh(other)))
    found = {
        "error": case.error(answer),
        "time": best(case.ask),
        "first": first,
        "eigh": best(lambda: jax.block_until_ready(eigh(symmetric))),
        "yardstick": {"time": best(lambda: jax.block_until_ready(eigh(other))), "first": yardstick},
    }
    if case.peer is not None:
        found["peer_error"] = case.error(case.peer())
        found["peer"] = best(case.peer)
    return found


def instructions(folder: Path) -> int:
    """How many instructions the compiler was given, over all programs of a process.

    Args:
        folder: Where it left them as text.
    """
    texts = (path.read_text() for path in folder.glob("*before_optimizations.txt"))
    return sum(line.count(" = ") for text in texts for line in text.splitlines() if line.startswith("  "))


def row(name: str) -> dict[str, Any]:
    """One row, of several processes: the best of each time, and the instructions of a last one.

    Args:
        name: Of the case.
    """
    paths = os.pathsep.join([str(HERE.parent), str(HERE), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PYTHONPATH": paths, "JAX_PLATFORMS": "cpu", "OPENBLAS_NUM_THREADS": "1"}
    code = f"import json, quick; print(json.dumps(quick.measure({name!r})))"

    def found(more: dict[str, str]) -> dict[str, Any]:
        run = subprocess.run([sys.executable, "-c", code], env={**environment, **more}, capture_output=True, text=True)
        if run.returncode:
            raise RuntimeError(f"{name}: {run.stderr.strip().splitlines()[-1]}")
        return json.loads(run.stdout.splitlines()[-1])

    several = [found({}) for _ in range(PROCESSES)]
    own = dict(several[0])
    for key in ("time", "first", "eigh", "peer"):
        if key in own:
            own[key] = min(one[key] for one in several)
    own["yardstick"] = {key: min(one["yardstick"][key] for one in several) for key in own["yardstick"]}
    with tempfile.TemporaryDirectory() as folder:
        flags = f"{os.environ.get('XLA_FLAGS', '')} --xla_dump_to={folder} --xla_dump_hlo_as_text"
        found({"XLA_FLAGS": flags.strip()})
        own["instructions"] = instructions(Path(folder))
    return own


def losses(new: dict[str, dict], old: dict[str, dict]) -> list[str]:
    """What is worse than the committed table by more than its noise, one sentence each.

    Args:
        new: Rows by name.
        old: Those committed.
    """
    told = [f"{name}: in the committed table, but no longer measured" for name in old if name not in new]
    for name, own in new.items():
        if name not in old:
            told.append(f"{name}: not in the committed table; --keep writes it")
            continue
        before = old[name]
        for key, allowed in NOISE.items():
            at_least = ROUND_OFF if key == "error" else 0.0
            scale = own["yardstick"][key] / before["yardstick"][key] if key in own["yardstick"] else 1.0
            ratio = max(own[key], at_least) / max(before[key] * scale, at_least)
            if not ratio <= allowed:
                machine = f", on a machine that takes {scale:.2f} times as long" if key in own["yardstick"] else ""
                told.append(f"{name}: {key} {own[key]:.3g}, was {before[key]:.3g}{machine}: {ratio:.2f} times")
    return told


def shown(rows: dict[str, dict], old: dict[str, dict]) -> str:
    """The table, with what each number was.

    Args:
        rows: Rows by name.
        old: Those committed.
    """
    heads = ["question", "error", "time [ms]", "eighs", "of Exudyn's", "first, CPU [s]", "instructions"]
    lines = [f"{heads[0]:<20}" + "".join(f"{head:>24}" for head in heads[1:])]

    def cell(own: dict, name: str, key: str, by: float = 1.0) -> str:
        was = f" ({by * old[name][key]:.3g})" if name in old and key in old[name] else ""
        return f"{by * own[key]:.3g}{was}" if key in own else "-"

    for name, own in rows.items():
        peer = f"{own['time'] / own['peer']:.2g}" if "peer" in own else "-"
        cells = [cell(own, name, "error"), cell(own, name, "time", 1e3), f"{own['time'] / own['eigh']:.3g}", peer]
        cells += [cell(own, name, "first"), cell(own, name, "instructions")]
        lines.append(f"{name:<20}" + "".join(f"{text:>24}" for text in cells))
    return "\n".join(lines)


def main(arguments: list[str]) -> int:
    """Measure, print, compare; 1 where something lost.

    Args:
        arguments: "--keep", names of rows.
    """
    from record import save

    keep, wanted = "--keep" in arguments, [name for name in arguments if name != "--keep"]
    known = [case.__name__ for case in CASES]
    if unknown := [name for name in wanted if name not in known]:
        print(f"There is no row '{unknown[0]}'. There are: {', '.join(known)}; and --keep.", file=sys.stderr)
        return 2
    old = json.loads(TABLE.read_text())["rows"] if TABLE.exists() else {}
    if importlib.util.find_spec("exudyn") is None:
        print("Exudyn is not installed and is left out: pip install -e '.[peers]' brings it.")
    rows = {}
    for name in wanted or known:
        rows[name] = row(name)
        print(f"{name}: error {rows[name]['error']:.1e}, {1e3 * rows[name]['time']:.3g} ms", flush=True)
    print(shown(rows, old))
    if keep:
        save("quick", {"rows": {**old, **rows} if wanted else rows})
        return 0
    told = losses(rows, {name: of for name, of in old.items() if name in rows or not wanted})
    print("\n".join(["Worse than the committed table:", *told]) if told else "Nothing is worse than it was.")
    return bool(told)


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    sys.exit(main(sys.argv[1:]))
