"""Faults put into the package, one at a time, and whether the tests see them: `python tests/faults.py [room ..]`.

A suite that passes says nothing about what it would let through. Each fault here is a small one, such as are really
made: a sign, a factor, a transposed matrix, an early return, a status that is forgotten. Each names the few tests that
should see it. Faults are put into a copy of the package in a temporary folder, never into the working tree.

    python tests/faults.py                # all of them, which takes the better part of an hour
    python tests/faults.py cli control    # those of some rooms
    python tests/faults.py --only C0      # those whose texts or files contain a word
    python tests/faults.py --list         # only whether each still finds its place; the suite does so too

A fault whose text does not occur exactly once in its file is stale and must be mended; all stale ones are listed at
once, and nothing is run. Before the faults of a room its tests run on the copy as it is: what fails then proves
nothing.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
# What a run needs beside the package itself.
BESIDE = ("tests", "notebooks", "benchmarks", "pyproject.toml", "README.md")
ENOUGH = 0.95
PASSED, FAILED = 0, 1
# A test that a fault sends into an endless loop has seen it.
LONGEST = 900


class Fault(NamedTuple):
    """One fault.

    Attributes:
        file: Of the package, from its folder.
        old: Text that occurs in it once.
        new: What stands there instead.
        tests: What pytest is called with: files or tests from ``tests/``, and ``-k`` with an expression.
    """

    file: str
    old: str
    new: str
    tests: str

    @property
    def room(self) -> str:
        """Folder of the file, or its own name at the root of the package."""
        return self.file.partition("/")[0].removesuffix(".py")

    def __str__(self) -> str:
        return f"{self.file}: {self.old.strip()!r} -> {self.new.strip()!r}"


def stale(faults: list[Fault], package: Path = ROOT / "flexmb") -> list[str]:
    """What is wrong with faults whose text does not occur exactly once."""
    found = []
    for fault in faults:
        path = package / fault.file
        count = path.read_text(encoding="utf-8").count(fault.old) if path.is_file() else -1
        if count != 1:
            what = "there is no such file" if count < 0 else f"its text occurs {count} times"
            found.append(f"{what}: {fault}")
    return found


def copied(folder: Path) -> None:
    """Copy what a run needs to a folder."""
    leave = shutil.ignore_patterns("__pycache__", "node_modules", ".hypothesis", ".pytest_cache")
    shutil.copytree(ROOT / "flexmb", folder / "flexmb", ignore=leave)
    for name in BESIDE:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, folder / name, ignore=leave)
        elif (ROOT / name).is_file():
            shutil.copy2(ROOT / name, folder / name)


def tested(folder: Path, tests: str) -> tuple[int, str]:
    """Exit status of pytest in a folder, and the last of what it said."""
    words = [f"tests/{word}" if word.partition("::")[0].endswith(".py") else word for word in split(tests)]
    command = [sys.executable, "-m", "pytest", "-x", "-p", "no:cacheprovider", "--no-header", *words]
    environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=LONGEST)
    except subprocess.TimeoutExpired:
        return FAILED, "too long"
    return done.returncode, done.stdout[-2000:] + done.stderr[-2000:]


def split(tests: str) -> list[str]:
    """Words of a call of pytest; all behind -k is one expression."""
    files, flag, expression = tests.partition(" -k ")
    return files.split() + (["-k", expression] if flag else [])


def put(folder: Path, fault: Fault) -> str:
    """Put a fault into the copy and return the text as it was."""
    path = folder / "flexmb" / fault.file
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace(fault.old, fault.new), encoding="utf-8")
    return text


def is_right(folder: Path, faults: list[Fault]) -> bool:
    """Whether the tests pass in the copy without a fault, each call once."""
    good = True
    for tests in dict.fromkeys(fault.tests for fault in faults):
        status, said = tested(folder, tests)
        if status != PASSED:
            good = False
            print(f"  does not pass without a fault ({status}): {tests}\n{said}", flush=True)
    return good


def main(arguments: list[str]) -> int:
    """Run what is asked for; 0 where enough faults are killed."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("rooms", nargs="*", help="rooms of the package; all without")
    parser.add_argument("--list", action="store_true", help="only look whether each fault finds its place")
    parser.add_argument("--only", default="", help="only faults whose text, file or tests contain this")
    parser.add_argument("--trust", action="store_true", help="do not run the tests without faults first")
    options = parser.parse_args(arguments)
    chosen = [f for f in FAULTS if not options.rooms or f.room in options.rooms]
    chosen = [f for f in chosen if options.only in f"{f} {f.tests}"]
    if wrong := stale(chosen):
        print("\n".join(["Stale:", *wrong]))
        return 1
    if options.list:
        print(f"{len(chosen)} faults in {len({f.room for f in chosen})} rooms, all of which find their place")
        return 0
    killed, survived = [], []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        copied(folder)
        for room in dict.fromkeys(f.room for f in chosen):
            own = [f for f in chosen if f.room == room]
            print(f"{room}:", flush=True)
            if not options.trust and not is_right(folder, own):
                return 1
            for fault in own:
                text, began = put(folder, fault), time.monotonic()
                try:
                    status, said = tested(folder, fault.tests)
                finally:
                    (folder / "flexmb" / fault.file).write_text(text, encoding="utf-8")
                (killed if status == FAILED else survived).append(fault)
                word = {PASSED: "SURVIVED", FAILED: "killed"}.get(status, f"NO TEST RAN ({status}): {said}")
                print(f"  {word:9} {time.monotonic() - began:4.0f} s  {fault}", flush=True)
    share = len(killed) / max(len(chosen), 1)
    print(f"{len(killed)} of {len(chosen)} killed, {100 * share:.1f} %")
    print("\n".join(f"survived: {fault}" for fault in survived))
    return 0 if share >= ENOUGH else 1


FAULTS = [
    # The command line and what it answers.
    Fault("cli.py", "raise typer.Exit(found.exit_status)", "raise typer.Exit(0)", "test_cli.py -k begin_has_no_states"),
]

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
