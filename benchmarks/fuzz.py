"""Random cases in numbers, far more than the tests run: which answers and refusals, and whether anything else left.

``python benchmarks/fuzz.py`` lists the kinds; ``python benchmarks/fuzz.py studies 10000`` runs so many of one, of seed
0 unless given as a third argument, and adds the counts to results/fuzz.json, by seed. A kind is a module of tests/fuzz
with ``cases(seed)``, which yields cases without end, and ``run(case)``, which says in a word what happened or raises.
"""

import collections
import importlib.util
import itertools
import json
import sys
import time
import traceback
from pathlib import Path

import record

KINDS = Path(__file__).parents[1] / "tests" / "fuzz"
# A process has 65530 memory maps, of which each compiled program takes a dozen.
MOST_MAPS = 40_000
AT_A_TIME = 100
MAPS = Path("/proc/self/maps")
MOST_FAULTS = 10


def kinds() -> dict[str, str]:
    """Kinds of cases, and what they say of themselves."""
    found = {}
    for path in sorted(KINDS.glob("*.py")):
        text = path.read_text()
        if "\ndef cases(" in text and "\ndef run(" in text:
            found[path.stem] = text.split('"""')[1].strip().splitlines()[0]
    return found


def keep(kind: str, seed: int, happened: collections.Counter, faults: int) -> None:
    """Write what has happened so far.

    Args:
        kind: Of the cases.
        seed: Of the random numbers.
        happened: How often what happened.
        faults: Number of cases in which something left that must not.
    """
    path = record.RESULTS / "fuzz.json"
    data = json.loads(path.read_text()) if path.exists() else {}
    data.pop("about", None)
    found = {"cases": sum(happened.values()) + faults, "happened": happened, "faults": faults}
    data.setdefault(kind, {})[f"seed {seed}"] = found
    record.save("fuzz", data)


def main(arguments: list[str]) -> int:
    """Run what is asked for; 1 where something left that must not.

    Args:
        arguments: Kind, count and seed.
    """
    known = kinds()
    if not 2 <= len(arguments) <= 3 or arguments[0] not in known or not all(a.isdecimal() for a in arguments[1:]):
        print("Give a kind and a count, such as: python benchmarks/fuzz.py studies 1000\n")
        print("\n".join(f"  {name:<12}{text}" for name, text in known.items()))
        return 2
    kind, count, seed = arguments[0], int(arguments[1]), int(arguments[2]) if arguments[2:] else 0
    # For what such a module takes from the tests beside it.
    sys.path.append(str(KINDS.parent))
    import jax

    import flexmb as fm

    fm.enable_x64()
    fm.enable_cache(thorough=False)
    # By its place: this script has the name of the folder.
    spec = importlib.util.spec_from_file_location(f"fuzz_{kind}", KINDS / f"{kind}.py")
    sys.modules[spec.name] = module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    happened, faults, begin = collections.Counter(), 0, time.perf_counter()
    for number, case in enumerate(itertools.islice(module.cases(seed), count)):
        try:
            happened[module.run(case)] += 1
        except (Exception, SystemExit):
            faults += 1
            print(f"== case {number} of seed {seed}: {case!r:.2000}", file=sys.stderr)
            traceback.print_exc()
            if faults >= MOST_FAULTS:
                break
        if number % AT_A_TIME == AT_A_TIME - 1 and len(MAPS.read_text(encoding="utf-8").splitlines()) > MOST_MAPS:
            jax.clear_caches()
        if number % max(count // 100, 1) == 0:
            print(f"{number + 1} of {count}: {dict(happened)}, {faults} faults", flush=True)
            keep(kind, seed, happened, faults)
    seconds = time.perf_counter() - begin
    print(f"{kind}: {sum(happened.values()) + faults} cases in {seconds:.0f} s, {dict(happened)}, {faults} faults")
    keep(kind, seed, happened, faults)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
