"""The rooms of the package: imports point one way, and nothing heavy is loaded before it is needed."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import flexmb

PACKAGE = Path(flexmb.__file__).parent
# Lowest first; rooms of one row do not see each other. Modules beside the rooms are named by themselves.
ROWS = [
    ("compilation",),
    ("math",),
    ("elements",),
    ("model",),
    ("mechanics",),
    ("checks",),
    ("build",),
    ("statics",),
    ("linear",),
    ("paths",),
    ("motion",),
    ("control", "mechanisms"),
    ("spacar",),
    ("design",),
    ("answers",),
    ("plot",),
    ("viewer",),
    ("cli",),
    ("__main__",),
]
RANK = {room: rank for rank, rooms in enumerate(ROWS) for room in rooms}
# Open to all: why a solve failed, what is raised, what arguments must be, how far one is, and the facade, whose names
# are loaded on use.
OPEN = {"results", "display", "errors", "arguments", "setup", "progress", "files", ""}
MODULES = sorted(PACKAGE.rglob("*.py"))


def room_of(module: Path) -> str:
    return module.relative_to(PACKAGE).parts[0].removesuffix(".py")


def inner_imports(module: Path):
    """Rooms that a module imports from, at its head or in a function; what type checkers alone see is not counted."""
    tree = ast.parse(module.read_text())
    guarded = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING"
        for inner in ast.walk(node)
    }
    depth = len(module.relative_to(PACKAGE).parts)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level and id(node) not in guarded:
            base = list(module.relative_to(PACKAGE).parts[: depth - node.level])
            names = [node.module.split(".")[0]] if node.module else [a.name for a in node.names]
            for name in names:
                path = [*base, name]
                is_room = (PACKAGE / path[0]).exists() or (PACKAGE / f"{path[0]}.py").exists()
                yield path[0] if is_room else ""


@pytest.mark.parametrize("module", MODULES, ids=lambda m: str(m.relative_to(PACKAGE)))
def test_imports_point_downwards(module):
    own = room_of(module)
    if own in OPEN | {"__init__"}:
        return
    assert own in RANK, f"room '{own}' has no place in the order of rooms"
    for other in inner_imports(module):
        if other in OPEN or other == own:
            continue
        assert RANK[other] < RANK[own], f"{module.name} in '{own}' imports from '{other}', which stands above it"


def test_one_hook_alone_looks_upwards_by_name():
    # What a text names, the order of rooms does not see: a result in a notebook asks the viewer, and the facade finds
    # its names.
    named = [m for m in MODULES if re.search(r"""import_module\(\s*f?["'](flexmb)?\.""", m.read_text())]
    assert [str(m.relative_to(PACKAGE)) for m in named] == ["__init__.py", "display.py"]


@pytest.mark.parametrize("module", MODULES, ids=lambda m: str(m.relative_to(PACKAGE)))
def test_at_most_two_levels(module):
    assert len(module.relative_to(PACKAGE).parts) <= 2


def loaded_by(code: str) -> set[str]:
    script = f"{code}\nimport sys\nprint(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(run.stdout.split())


def test_importing_the_package_loads_nothing_heavy():
    heavy = {"jax", "numpy", "scipy", "control", "diffrax", "optax", "equinox", "matplotlib"}
    assert not heavy & loaded_by("import flexmb, flexmb.cli")


def test_frequencies_load_no_library_that_they_do_not_use():
    heavy = {"control", "diffrax", "optax", "equinox", "matplotlib", "typer"}
    assert not heavy & loaded_by("import flexmb\nflexmb.enable_x64()\nflexmb.frequencies, flexmb.Builder().node")


def test_importing_changes_no_setting():
    code = (
        "import jax\nbefore = dict(jax.config.values)\nimport flexmb\n"
        "for name in dir(flexmb): getattr(flexmb, name)\nprint(dict(jax.config.values) == before)"
    )
    assert "True" in loaded_by(code)


def test_public_names_are_those_of_the_stub():
    stub = ast.parse((PACKAGE / "__init__.pyi").read_text())
    names = {a.asname or a.name for n in stub.body if isinstance(n, ast.ImportFrom) for a in n.names}
    assert names == set(flexmb._WHERE)
