"""What is shipped, found by looking, and how to ask it; `frozen.py` says what for."""

import ast
import contextlib
import importlib
import json
import re
import shlex
import sys
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
from recorded import RTOL, TIGHT, Recorder, collect

ROOT = Path(__file__).resolve().parents[1]
# Commands of the manuals whose answers are kept; those of other commands are asked of the shipped mechanisms.
STUDIES = {"sweep", "tune", "verdict"}
# Modes of the command line that integrate in time.
INTEGRATED = (1, 4, 6)


def ask_mechanism(name: str, recorder: Recorder) -> None:
    """Ask the command line all modes."""
    from cases.commands import command

    text = (ROOT / "flexmb/mechanisms" / name).read_text()
    rtol = max([float(found) for found in re.findall(r"^ERROR \S+ (\S+)", text, re.M)], default=RTOL)
    Path(name).write_text(
        re.sub(r"^ERROR .*", f"ERROR {TIGHT} {TIGHT}", text, flags=re.M) if recorder.tight else text, encoding="utf-8"
    )
    for mode in range(11):
        found = command("run", name, "--mode", mode, "--json", "-")
        collect({"exit": found.exit_code}, f"mode {mode}", recorder.out)
        with contextlib.suppress(ValueError):
            collect(
                json.loads(found.stdout), f"mode {mode}", recorder.out, {"rtol": rtol} if mode in INTEGRATED else {}
            )


def run_text(text: str, scope: dict, name: str) -> None:
    """Run Python code without what it asserts."""
    tree = ast.parse(text)
    tree.body = [one for one in tree.body if not isinstance(one, ast.Assert)]
    exec(compile(tree, name, "exec"), scope)


@contextlib.contextmanager
def kept_scope(recorder: Recorder):
    """A namespace whose numbers are kept in the end, also where something failed."""
    scope = {"__name__": "__main__"}
    try:
        yield scope
    finally:
        for name, value in scope.items():
            if not name.startswith("_"):
                recorder.keep(value, name, {})


def ask_notebook(name: str, recorder: Recorder) -> None:
    """Run a notebook."""
    with kept_scope(recorder) as scope:
        run_text((ROOT / "notebooks" / name).read_text(), scope, name)


def ask_manual(name: str, recorder: Recorder) -> None:
    """Run the Python code of a manual, and ask its commands about studies."""
    from cases.commands import command
    from test_readme import blocks_of, run_commands

    sys.path.insert(0, "")
    with kept_scope(recorder) as scope:
        for block in blocks_of(name):
            if block.file:
                Path(block.file).write_text(block.text, encoding="utf-8")
            elif block.language == "python":
                run_text(block.text, scope, name)
            elif block.language == "sh":
                run_commands(block.text)
                for words in (shlex.split(line, comments=True) for line in block.text.splitlines()):
                    if words[:1] == ["flexmb"] and STUDIES & set(words[1:2]) and "--json" not in words:
                        with contextlib.suppress(ValueError):
                            collect(json.loads(command(*words[1:], "--json", "-").stdout), words[1], recorder.out)


def ask_model(model: Any, recorder: Recorder) -> None:
    """Ask all that can be asked of any model."""
    import flexmb as fm

    asked = [fm.mobility, fm.equilibrium, fm.linearize, fm.modes, fm.poles, fm.buckling, fm.stress, fm.to_statespace]
    for function in [*asked, fm.mass, fm.path, fm.linear.section_resultants, fm.control.second_order]:
        with contextlib.suppress(Exception):
            function(model)
    with contextlib.suppress(Exception):
        fm.equilibria(model, load_factor=[0.0, 0.5, 1.0])
    hertz = max(recorder.out.get("modes#0/frequencies", (np.zeros(1),))[0][0], 0.0) or 10.0
    stiffness = recorder.out.get("linearize#0/K0", (np.ones((1, 1)),))[0].flat[0]
    loads = {name: lambda t: 1e-3 * stiffness * jnp.sin(6 * hertz * t) for name in model.q_labels[:1]}
    for how in ({"loads": loads}, {}):
        with contextlib.suppress(Exception):
            fm.simulate(model, np.linspace(0, 2 / hertz, 11), rtol=1e-7, **how)
            return


def ask_case(name: str, recorder: Recorder) -> None:
    """Ask all of a mechanism that tests or benchmarks share."""
    module, _, function = name.rpartition(".")
    made = getattr(importlib.import_module(module), function)()
    ask_model(made.build() if hasattr(made, "build") else made, recorder)


def ask_question(name: str, recorder: Recorder) -> None:
    """Ask a question of the benchmarks."""
    collect(getattr(importlib.import_module("questions"), name)().ask(), "answer", recorder.out)


def ask_tests(name: str, recorder: Recorder) -> None:
    """Run the tests of reference problems that a file has."""
    import pytest

    class Plugin:
        def pytest_collection_finish(self):
            recorder.install()

        def pytest_runtest_setup(self, item):
            recorder.prefix = f"{item.name}/"

    words = [f"{ROOT}/tests/{name}::{test}" for test in tests_of_references()[name]]
    pytest.main(["-p", "no:cacheprovider", "--rootdir", f"{ROOT}", "-c", f"{ROOT}/pyproject.toml", *words], [Plugin()])


def tests_of_references() -> dict[str, list[str]]:
    """Names of the tests of reference problems, by file."""
    found, last = {}, ""
    for file, test in re.findall(r"`(?:tests/([\w/]+\.py))?(?:::(\w+))?`", (ROOT / "tests/REFERENCES.md").read_text()):
        last = file or last
        if test and test not in found.setdefault(last, []):
            found[last].append(test)
    return {file: tests for file, tests in sorted(found.items()) if tests}


def functions_of(path: Path) -> list[ast.FunctionDef]:
    """Public functions of a module that need no argument."""
    found = [one for one in ast.parse(path.read_text(encoding="utf-8")).body if isinstance(one, ast.FunctionDef)]
    found = [one for one in found if not one.name.startswith("_") and None not in one.args.kw_defaults]
    return [one for one in found if len(one.args.args) == len(one.args.defaults)]


def jobs() -> list[str]:
    """What there is to ask, as "kind:name", the quickest kinds first."""
    from test_readme import MANUALS, blocks_of

    found = [f"mechanism:{path.name}" for path in sorted((ROOT / "flexmb").rglob("*.dat"))]
    shared = [(f"cases.{path.stem}", path) for path in sorted((ROOT / "tests/cases").glob("*.py"))]
    for module, path in [*shared, ("scenes", ROOT / "benchmarks/scenes.py")]:
        found += [f"case:{module}.{one.name}" for one in functions_of(path) if "Builder" in ast.dump(one)]
    questions = functions_of(ROOT / "benchmarks/questions.py")
    found += [f"question:{one.name}" for one in questions if "Case" in ast.dump(one.returns or one)]
    found += [f"manual:{name}" for name in MANUALS if any(block.language == "python" for block in blocks_of(name))]
    found += [f"notebook:{path.name}" for path in sorted((ROOT / "notebooks").glob("[0-9][0-9]_*.py"))]
    return found + [f"tests:{name}" for name in tests_of_references()]
