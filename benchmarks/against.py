"""Today's package beside an older one in paired runs: ``python -m benchmarks --against COMMIT [names]``.

Asked are the rows of the quick table and the kernels of first_impression.py, designs.py and motion.py (questions.py),
all by the scripts of today; a name stands for a row or for all that begin with it. The older package is taken from the
repository into a temporary folder. Of every row two processes are held, one of each package, which compile once and
then measure in turn: a round is the median of a block of calls, of either. Times are those of the processor, of all
threads. What counts is the ratio of a round's two times, now over then; the table has the median of all rounds and
their quartiles. A row is slower if every pair of processes finds it so by more than ``SLOWER``, and the lower quartile
too.
"""

import contextlib
import io
import json
import os
import statistics
import subprocess
import sys
import tarfile
import tempfile
import time
from pathlib import Path
from typing import Any

from questions import CASES, KERNELS

HERE = Path(__file__).parent
PAIRS, ROUNDS = 2, 5
# What is called noise, whatever the quartiles say: two processes of one package differ by as much.
SLOWER = 1.05
# Seconds of a block of calls; what takes longer than LONG is measured in so many rounds.
BLOCK, LONG, FEW = 0.15, 2.0, 2


def serve(name: str) -> None:
    """Answer a question once, say what that took, and then measure a block of calls for every line that comes in.

    Args:
        name: Of the row.
    """
    import flexmb as fm

    fm.enable_x64()
    case = next(one for one in (*CASES, *KERNELS) if one.__name__ == name)()
    begin = time.process_time()
    answer = case.ask()
    first = time.process_time() - begin
    begin = time.process_time()
    case.ask()
    again = time.process_time() - begin
    head = {"where": str(Path(fm.__file__).parent), "error": case.error(answer), "first": first, "again": again}
    print(json.dumps(head), flush=True)
    for _ in sys.stdin:
        times, until = [], time.process_time() + BLOCK
        while not times or time.process_time() < until:
            begin = time.process_time()
            case.ask()
            times.append(time.process_time() - begin)
        print(json.dumps(statistics.median(times)), flush=True)


def started(name: str, package: Path, said: Path) -> subprocess.Popen:
    """A process that serves a row by a package.

    Args:
        name: Of the row.
        package: Folder that holds ``flexmb``.
        said: Where it writes its errors.
    """
    paths = os.pathsep.join([str(package), str(HERE), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PYTHONPATH": paths, "JAX_PLATFORMS": "cpu", "OPENBLAS_NUM_THREADS": "1"}
    code = f"import against; against.serve({name!r})"
    with said.open("w", encoding="utf-8") as errors:
        return subprocess.Popen(
            # Without the folder that one is in, which may hold the package of today.
            [sys.executable, "-P", "-c", code],
            env=environment,
            text=True,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
        )


def paired(name: str, packages: dict[str, Path], folder: Path) -> dict[str, Any]:
    """One pair of processes: first answers, errors, and times of rounds.

    Args:
        name: Of the row.
        packages: Folders by "then" and "now".
        folder: For what the processes say.

    Raises:
        RuntimeError: A package does not answer; its last words.
    """
    found: dict[str, Any] = {}
    with contextlib.ExitStack() as held:
        running = {}
        for which, package in packages.items():
            said = folder / f"{which}.txt"
            running[which] = process = held.enter_context(started(name, package, said))
            held.callback(process.kill)
            line = process.stdout.readline()
            if not line:
                process.wait()
                raise RuntimeError(f"{which}: {(said.read_text().strip().splitlines() or ['no word'])[-1]}")
            found[which] = head = json.loads(line)
            if Path(head.pop("where")) != (package / "flexmb").resolve():
                raise RuntimeError(f"{which}: another package than {package} was imported")
            head["times"] = []
        rounds = ROUNDS if max(own["again"] for own in found.values()) < LONG else FEW
        for i in range(rounds):
            # Neither always comes first.
            for which in sorted(running, reverse=bool(i % 2)):
                print("go", file=running[which].stdin, flush=True)
                found[which]["times"].append(json.loads(running[which].stdout.readline()))
    return found


def summary(pairs: list[dict[str, Any]]) -> dict[str, Any]:
    """What a row's pairs of processes say together.

    Args:
        pairs: As from :func:`paired`.

    Returns:
        Median time, least time of a first answer and error, then and now; ratios: median, quartiles, medians of the
        pairs.
    """
    row: dict[str, Any] = {}
    for which in ("then", "now"):
        own = [pair[which] for pair in pairs]
        times = [t for one in own for t in one["times"]]
        row[which] = {
            "time": statistics.median(times),
            "first": min(one["first"] for one in own),
            "error": own[0]["error"],
        }
    by_pair = [
        [now / then for then, now in zip(pair["then"]["times"], pair["now"]["times"], strict=True)] for pair in pairs
    ]
    every = [ratio for ratios in by_pair for ratio in ratios]
    low, middle, high = statistics.quantiles(every, n=4, method="inclusive")
    return row | {"ratio": middle, "quartiles": [low, high], "of_pairs": [statistics.median(of) for of in by_pair]}


def slower(rows: dict[str, dict[str, Any]]) -> list[str]:
    """Names of rows that are slower than they were, beyond noise.

    Args:
        rows: As from :func:`summary`, by name.
    """
    return [name for name, row in rows.items() if min(*row["of_pairs"], row["quartiles"][0]) > SLOWER]


def chosen(names: list[str]) -> list[str]:
    """Rows that are called so, or begin so.

    Args:
        names: Words; none: all rows.

    Raises:
        ValueError: A word names none.
    """
    known = [case.__name__ for case in (*KERNELS, *CASES)]
    for name in names:
        if not any(f"{row}_".startswith(f"{name}_") for row in known):
            raise ValueError(f"There is no row '{name}'. There are: {', '.join(known)}.")
    return [row for row in known if not names or any(f"{row}_".startswith(f"{name}_") for name in names)]


def package_of(commit: str, folder: Path) -> str:
    """Put the package of a commit into a folder.

    Args:
        commit: As git names it.
        folder: Where ``flexmb`` will lie.

    Returns:
        The commit and its date.

    Raises:
        ValueError: git knows no such commit.
    """

    def git(*words: str) -> bytes:
        run = subprocess.run(["git", "-C", str(HERE.parent), *words], capture_output=True)
        if run.returncode:
            raise ValueError(f"'{commit}' is no commit of this repository: {run.stderr.decode().strip()}")
        return run.stdout

    told = git("show", "-s", "--format=%h of %cs", f"{commit}^{{commit}}").decode().strip()
    with tarfile.open(fileobj=io.BytesIO(git("archive", "--format=tar", commit, "flexmb"))) as archive:
        archive.extractall(folder, filter="data")
    return told


def shown(rows: dict[str, dict[str, Any]]) -> str:
    """The table.

    Args:
        rows: As from :func:`summary`, by name.
    """
    heads = ("then [ms]", "now [ms]", "now/then", "quartiles", "first then, now [s]", "error then, now")
    lines = [f"{'row':<28}" + "".join(f"{head:>22}" for head in heads)]
    for name, row in rows.items():
        then, now = row["then"], row["now"]
        cells = [f"{1e3 * then['time']:.3g}", f"{1e3 * now['time']:.3g}", f"{row['ratio']:.2f}"]
        cells += ["{:.2f} to {:.2f}".format(*row["quartiles"]), f"{then['first']:.2f}, {now['first']:.2f}"]
        cells += [f"{then['error']:.1e}, {now['error']:.1e}"]
        lines.append(f"{name:<28}" + "".join(f"{cell:>22}" for cell in cells))
    return "\n".join(lines)


def main(arguments: list[str]) -> int:
    """Measure, print and save; 1 where something is slower, or no longer answered.

    Args:
        arguments: The commit, names of rows.
    """
    from record import RESULTS, save

    if not arguments:
        print("Which commit? python -m benchmarks --against COMMIT [names]", file=sys.stderr)
        return 2
    commit, *names = arguments
    rows, unanswered = {}, {}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place).resolve()
        try:
            wanted, told = chosen(names), package_of(commit, folder)
        except ValueError as fault:
            print(fault, file=sys.stderr)
            return 2
        packages = {"then": folder, "now": HERE.parent.resolve()}
        for name in wanted:
            try:
                rows[name] = summary([paired(name, packages, folder) for _ in range(PAIRS)])
            except RuntimeError as fault:
                unanswered[name] = str(fault)
                print(f"{name}: {fault}", flush=True)
                continue
            print(f"{name}: {rows[name]['ratio']:.2f} times", flush=True)
    print(f"Processor times beside {told}\n{shown(rows)}")
    worse = slower(rows)
    if rows:
        print("\n".join(["Slower beyond noise:", *worse]) if worse else "No row is slower beyond noise.")
    known = RESULTS / "against.json"
    before = json.loads(known.read_text()) if names and known.exists() else {}
    if before.get("commit") == told:
        rows, unanswered = before["rows"] | rows, before["unanswered"] | unanswered
    save("against", {"commit": told, "rows": rows, "unanswered": unanswered})
    return bool(worse) or any(fault.startswith("now") for fault in unanswered.values())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
