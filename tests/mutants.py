"""Change the package at random places, one at a time, and count the changes that its tests see.

    python tests/mutants.py --count 200 --seed 0         # the kill rate, and what survived as diffs
    python tests/mutants.py --count 20 --room statics    # changes of one room
    python tests/mutants.py --count 20 --list            # only what would be changed
    python tests/mutants.py --count 200 --jobs 8         # eight at a time, each in its own copy

A change is of one operator, constant, sign, index, condition or argument. The places are drawn from the syntax trees of
all modules with the seed, so that the same tree has the same changes. Texts, annotations, errors and decorators stay.
A mutant is asked the quick tests of its room: `tests/<room>/`, and tests at the root of `tests/` that name the room.
The file named as the module comes first. A mutant is killed where a test fails, or where the tests take too long.
Everything runs in copies in a temporary folder; the repository is only read. Tests that fail without a change are named
and left out. Set FLEXMB_CACHE to keep compiled code from run to run.
"""

import argparse
import ast
import copy
import difflib
import itertools
import os
import queue
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[1]
# What the tests need beside the package.
BESIDE = (
    *("tests", "notebooks", "benchmarks", "pyproject.toml", "README.md", ".ci", "LICENSE"),
    *("CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", ".github"),
)
KILLED, SURVIVED, TIMEOUT, UNTESTED = "killed", "survived", "timeout", "no test"
NO_TEST = 5  # status of pytest
SWAPPED: dict[type, tuple[type, ...]] = {
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div, ast.Add),
    ast.Div: (ast.Mult,),
    ast.FloorDiv: (ast.Mult,),
    ast.Mod: (ast.Mult,),
    ast.Pow: (ast.Mult,),
    ast.Lt: (ast.LtE, ast.Gt),
    ast.LtE: (ast.Lt, ast.GtE),
    ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.LtE),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
    ast.And: (ast.Or,),
    ast.Or: (ast.And,),
}


class Mutant(NamedTuple):
    """A change.

    Attributes:
        file: Of the package, from its folder.
        kind: What is changed, in a word.
        text: Of the module with the change.
    """

    file: str
    kind: str
    text: str

    @property
    def room(self) -> str:
        """Folder of the file; empty at the root of the package."""
        return self.file.partition("/")[0] if "/" in self.file else ""

    def diff(self, text: str) -> str:
        """The change beside the text of the module."""
        lines = difflib.unified_diff(text.splitlines(), self.text.splitlines(), self.file, self.kind, lineterm="", n=1)
        return "\n".join(lines)


Change = Callable[[Any], ast.AST]
Place = tuple[ast.expr, str, Change]  # what is changed, the kind of change in a word, and how


def changes(node: ast.AST) -> Iterator[tuple[str, Change]]:
    """Kinds of change of an expression or a condition, and functions that change a copy of it."""

    def operator(made: type, place: int | None = None) -> Change:
        def change(one: Any) -> ast.AST:
            if place is None:
                one.op = made()
            else:
                one.ops[place] = made()
            return one

        return change

    if isinstance(node, ast.BinOp | ast.BoolOp):
        yield from (("operator", operator(made)) for made in SWAPPED.get(type(node.op), ()))
    elif isinstance(node, ast.Compare):
        for i, op in enumerate(node.ops):
            yield from (("condition", operator(made, i)) for made in SWAPPED.get(type(op), ()))
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
        yield "sign" if isinstance(node.op, ast.USub) else "condition", lambda one: one.operand
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield "constant", lambda one: ast.Constant(not one.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        yield "constant", lambda one: ast.Constant(one.value + 1 if isinstance(one.value, int) else one.value * 2)
        if node.value:
            yield "sign", lambda one: ast.UnaryOp(ast.USub(), one)
    elif isinstance(node, ast.IfExp):
        yield "condition", lambda one: ast.IfExp(ast.UnaryOp(ast.Not(), one.test), one.body, one.orelse)
    elif isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load):
        if isinstance(node.slice, ast.Name | ast.Constant):
            plus = ast.Constant(1)
            yield "index", lambda one: ast.Subscript(one.value, ast.BinOp(one.slice, ast.Add(), plus), one.ctx)
        elif isinstance(node.slice, ast.Slice) and (node.slice.lower or node.slice.upper):
            yield "index", lambda one: ast.Subscript(one.value, ast.Slice(), one.ctx)
    elif isinstance(node, ast.Call):
        plain = [one for one in node.args if not isinstance(one, ast.Starred)]
        if len(plain) == len(node.args) >= 2 and ast.dump(plain[0]) != ast.dump(plain[1]):
            yield "argument", lambda one: ast.Call(one.func, [one.args[1], one.args[0], *one.args[2:]], one.keywords)
        if node.keywords and node.keywords[-1].arg:
            yield "argument", lambda one: ast.Call(one.func, one.args, one.keywords[:-1])


def places(node: ast.AST) -> Iterator[Place]:
    """Expressions that may be changed in a node and within, and how."""
    if isinstance(node, ast.Raise | ast.Assert | ast.JoinedStr | ast.Import | ast.ImportFrom):
        return
    if isinstance(node, ast.Call) and re.search(r"(?i)warn|error", ast.unparse(node.func)):
        return
    if isinstance(node, ast.If | ast.While):
        if ast.unparse(node.test) in ("TYPE_CHECKING", "__name__ == '__main__'"):
            return
        yield node.test, "condition", lambda one: ast.UnaryOp(ast.Not(), one)
    if isinstance(node, ast.expr):
        yield from ((node, kind, change) for kind, change in changes(node))
    for name, value in ast.iter_fields(node):
        if name not in ("annotation", "returns", "decorator_list", "bases"):
            for one in value if isinstance(value, list) else [value]:
                if isinstance(one, ast.AST):
                    yield from places(one)


def changed(text: str, node: ast.expr, change: Change) -> str:
    """The text of a module with one expression changed."""
    lines = text.encode().splitlines(keepends=True)
    begin = sum(map(len, lines[: node.lineno - 1])) + node.col_offset
    end = sum(map(len, lines[: (node.end_lineno or 1) - 1])) + (node.end_col_offset or 0)
    made = ast.unparse(ast.fix_missing_locations(change(copy.deepcopy(node))))
    # Brackets keep it together wherever it stands.
    whole = b"".join(lines)
    return (whole[:begin] + f"({made})".encode() + whole[end:]).decode()


def mutant_of(file: str, text: str, place: Place) -> Mutant | None:
    """The change at a place of a module; None where it changes nothing, or Python refuses it."""
    made = changed(text, place[0], place[2])
    try:
        same = ast.dump(ast.parse(made)) == ast.dump(ast.parse(text))
    except SyntaxError:
        return None
    return None if same else Mutant(file, place[1], made)


def drawn(package: Path, count: int, seed: int, room: str | None = None) -> list[Mutant]:
    """Changes drawn at random, each place as likely as any other."""
    every = []
    for path in sorted(package.rglob("*.py")):
        file, text = path.relative_to(package).as_posix(), path.read_text(encoding="utf-8")
        if room is None or (file.partition("/")[0] if "/" in file else "root") == room:
            every += [(file, text, place) for place in places(ast.parse(text))]
    random.Random(seed).shuffle(every)
    return list(itertools.islice(filter(None, itertools.starmap(mutant_of, every)), count))


def tests_for(folder: Path, mutant: Mutant) -> list[str]:
    """Files of tests that a change is shown to, that of its module first; paths from the copy."""
    tests = folder / "tests"
    own = sorted((tests / mutant.room).glob("test_*.py")) if mutant.room else []
    named = rf"flexmb[./]{mutant.room}\b" if mutant.room else r"flexmb"
    own += [path for path in sorted(tests.glob("test_*.py")) if re.search(named, path.read_text(encoding="utf-8"))]
    first = f"test_{Path(mutant.file).stem}.py"
    return [path.relative_to(folder).as_posix() for path in sorted(own, key=lambda path: path.name != first)]


def tested(folder: Path, words: list[str], limit: float) -> tuple[int | None, str]:
    """Status of pytest in a copy, None where it took longer than the limit [s]; and what it said."""
    environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1", "JAX_PLATFORMS": "cpu"}
    environment.setdefault("FLEXMB_CACHE", str(folder.parent / "cache"))
    quick = ["--slow=out"] if "--slow" in (folder / "tests/conftest.py").read_text() else ["-m", "not slow"]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--tb=no", *quick, *words]
    with tempfile.TemporaryFile("w+", encoding="utf-8") as said:
        process = subprocess.Popen(
            command, cwd=folder, env=environment, stdout=said, stderr=subprocess.STDOUT, start_new_session=True
        )
        try:
            status = process.wait(limit)
        except subprocess.TimeoutExpired:
            # Browsers and servers that the tests began end with them.
            os.killpg(process.pid, signal.SIGKILL)
            status = process.wait() and None
        said.seek(0)
        return status, said.read()


def copied(folder: Path) -> Path:
    """Copy what the tests need to a folder."""
    leave = shutil.ignore_patterns("__pycache__", "node_modules", ".hypothesis", ".pytest_cache")
    for name in ("flexmb", *BESIDE):
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, folder / name, ignore=leave)
        elif (ROOT / name).is_file():
            shutil.copy2(ROOT / name, folder / name)
    return folder


def outcome(folder: Path, mutant: Mutant, limit: float, failing: list[str]) -> str:
    """Put a change into a copy, ask the tests, and take it out again."""
    path = folder / "flexmb" / mutant.file
    text = path.read_text(encoding="utf-8")
    words = [*tests_for(folder, mutant), *(f"--deselect={name}" for name in failing)]
    if not any(word.endswith(".py") for word in words):
        return UNTESTED
    path.write_text(mutant.text, encoding="utf-8")
    try:
        status, _ = tested(folder, ["-x", *words], limit)
    finally:
        path.write_text(text, encoding="utf-8")
    return {None: TIMEOUT, 0: SURVIVED, NO_TEST: UNTESTED}.get(status, KILLED)


def main(arguments: list[str]) -> int:
    """Draw changes, ask the tests, and print what they saw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--room", help='folder of the package, or "root"')
    parser.add_argument("--jobs", type=int, default=1, help="copies that are tested at the same time")
    parser.add_argument("--list", action="store_true", help="only print the changes")
    given = parser.parse_args(arguments)
    chosen = drawn(ROOT / "flexmb", given.count, given.seed, given.room)
    texts = {one.file: (ROOT / "flexmb" / one.file).read_text(encoding="utf-8") for one in chosen}
    if given.list:
        print("\n".join(one.diff(texts[one.file]) for one in chosen))
        return 0
    with tempfile.TemporaryDirectory() as name:
        folders: queue.Queue[Path] = queue.Queue()
        for i in range(given.jobs):
            folders.put(copied(Path(name) / f"{i}"))
        limits, failing = {}, {}
        for room in dict.fromkeys(one.room for one in chosen):
            folder, began = Path(name) / "0", time.monotonic()
            words = tests_for(folder, next(one for one in chosen if one.room == room))
            said = tested(folder, words, 3600.0)[1] if words else ""
            failing[room] = re.findall(r"^(?:FAILED|ERROR) (\S+)", said, re.M)
            seconds = time.monotonic() - began
            limits[room] = 60 + 3 * seconds
            lines = [f"{room or 'root'}: tests take {seconds:.0f} s", *(f"  left out: {one}" for one in failing[room])]
            print("\n".join(lines), flush=True)

        def ask(mutant: Mutant) -> str:
            folder, began = folders.get(), time.monotonic()
            try:
                found = outcome(folder, mutant, limits[mutant.room], failing[mutant.room])
            finally:
                folders.put(folder)
            print(f"{found:9} {time.monotonic() - began:5.0f} s  {mutant.file}: {mutant.kind}", flush=True)
            return found

        with ThreadPoolExecutor(given.jobs) as pool:
            outcomes = list(pool.map(ask, chosen))
    seen = Counter(outcomes)
    print("\nSurvived:")
    left = [one for one, found in zip(chosen, outcomes, strict=True) if found in (SURVIVED, UNTESTED)]
    print("\n".join(one.diff(texts[one.file]) for one in left))
    print(", ".join(f"{seen[found]} {found}" for found in (KILLED, TIMEOUT, SURVIVED, UNTESTED)))
    rate = (seen[KILLED] + seen[TIMEOUT]) / max(len(chosen), 1)
    print(f"kill rate {100 * rate:.1f} % of {len(chosen)}, seed {given.seed}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
