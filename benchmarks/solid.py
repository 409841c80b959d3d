"""Leaf springs beside solid finite elements: error and time of one leaf spring, a spectral beam, cubic beams.

``python benchmarks/solid.py`` solves the cases of ``solid_cases.py`` by CalculiX (Debian's ``calculix-ccx``) on two meshes
each, some ten minutes, and compares. It writes results/solid.json and results/solid.png, which README shows. Without
CalculiX, or with ``--committed``, the solid results that are there are used; with names of cases, only those.
"""

import json
import sys
from pathlib import Path

HERE = Path(__file__).parent
RESULTS = HERE / "results" / "solid.json"
RUNS = 7


def solve(name: str) -> dict:
    """A case on both meshes: numbers of the fine one with units and the difference of the coarse, and times [s]."""
    from solid_cases import CASES

    (coarse, first), (fine, second) = (CASES[name](mesh) for mesh in ("coarse", "fine"))
    numbers = {k: {"unit": unit, "coarse": coarse[k][0], "fine": value} for k, (value, unit) in fine.items()}
    return {"quantities": numbers, "seconds": {"coarse": first, "fine": second}}


def solids(names, solving: bool) -> dict:
    """Solid results by name, new where solving, else those that are there."""
    known = json.loads(RESULTS.read_text())["solid"] if RESULTS.exists() else {}
    for name in names:
        if solving:
            known[name] = solve(name)
            print(f"{name}: solved in {sum(known[name]['seconds'].values()):.0f} s", flush=True)
    return known


def main() -> None:
    """Solve, compare, print, save and draw."""
    from record import save
    from solid_cases import CASES
    from solid_models import installed

    given = [a for a in sys.argv[1:] if a != "--committed"]
    names = given or list(CASES)
    solving = installed() and "--committed" not in sys.argv
    if not solving:
        print("The solid results of results/solid.json are used: CalculiX is not installed, or they were asked for.")
    found = solids(names, solving)
    save("solid", {"solid": found})


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
