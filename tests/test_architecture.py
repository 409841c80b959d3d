"""The rooms of the package: imports point one way, and nothing heavy is loaded before it is needed."""

import ast
import importlib
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import flexmb
from flexmb.lazy import offered

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
OPEN = {"results", "errors", "arguments", "setup", "progress", "files", "lazy", ""}
# What notebooks ask a result for; it alone may look upwards, when it is called.
DISPLAY = "_repr_html_"
MODULES = sorted(PACKAGE.rglob("*.py"))
TOP_LEVEL = "pyproject.toml flexmb tests benchmarks notebooks README.md LICENSE .ci .gitignore".split()


def room_of(module: Path) -> str:
    return module.relative_to(PACKAGE).parts[0].removesuffix(".py")


def inner_imports(module: Path):
    """Rooms that a module imports from, at its head or inside a function.

    Not counted is what type checkers alone see, and what :data:`DISPLAY` takes from the viewer for a notebook.
    """
    tree = ast.parse(module.read_text())
    guarded = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING"
        for inner in ast.walk(node)
    }
    guarded |= {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and node.name == DISPLAY
        for inner in ast.walk(node)
        if isinstance(inner, ast.ImportFrom) and inner.module == "viewer.notebook"
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


def test_names_of_a_room_are_no_modules_of_it():
    # A module that is imported becomes an attribute of its package, and would hide a function of its name.
    for stub in PACKAGE.rglob("__init__.pyi"):
        package = ".".join(stub.parent.relative_to(PACKAGE.parent).parts)
        importlib.import_module(package)
        for name, where in offered(package).items():
            module = (stub.parent / f"{name}.py").exists() or (stub.parent / name).is_dir()
            assert where == package or not module, f"{package}.{name}"


def test_a_small_surface():
    assert 50 <= len(offered("flexmb")) <= 60


@pytest.mark.skipif(shutil.which("git") is None, reason="git alone knows which files are tracked")
def test_the_top_level_holds_nothing_else():
    listed = subprocess.run(["git", "ls-files"], cwd=Path(__file__).parent.parent, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("this is no git repository")
    assert {name.split("/")[0] for name in listed.stdout.splitlines()} == set(TOP_LEVEL)
