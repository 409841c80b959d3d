"""The rooms of the package: imports point one way, and nothing heavy is loaded before it is needed."""

import ast
import collections
import fnmatch
import importlib
import re
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
    ("blocks",),
    ("statics",),
    ("linear",),
    ("questions",),
    ("paths",),
    ("motion",),
    ("control", "mechanisms"),
    ("trajectory",),
    ("fmu",),
    ("spacar",),
    ("design",),
    ("identification",),
    ("answers",),
    ("plot",),
    ("viewer",),
    ("workbench",),
    ("cli",),
    ("__main__",),
]
RANK = {room: rank for rank, rooms in enumerate(ROWS) for room in rooms}
# Open to all: why a solve failed, what is raised, what arguments must be, how far one is, and the facade, whose names
# are loaded on use.
OPEN = set("results display errors collecting arguments setup progress files lazy numerical_limits".split()) | {""}
MODULES = sorted(PACKAGE.rglob("*.py"))
TOP_LEVEL = (
    "pyproject.toml flexmb tests benchmarks notebooks README.md LICENSE CHANGELOG.md CITATION.cff CONTRIBUTING.md .ci"
    " .github .gitignore"
).split()


def room_of(module: Path) -> str:
    return module.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported(module: Path) -> set[Path]:
    """Files of the package that a file imports, at its head or inside a function, for type checkers alone or not."""
    found = set()
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            folder = module.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            for name in node.names:
                places = (folder / f"{name.name}.py", folder / name.name / "__init__.py", folder.with_suffix(".py"))
                found.add(next((place for place in places if place.exists()), folder / "__init__.py"))
    return found


def test_imports_point_downwards_and_in_no_circle():
    every = {module: imported(module) for module in MODULES}
    upwards = []
    for module, others in every.items():
        own = room_of(module)
        if own in OPEN | {"__init__"}:
            continue
        assert own in RANK, f"room '{own}' has no place in the order of rooms"
        for other in set(map(room_of, others)) - OPEN - {own, "__init__"}:
            if RANK[other] >= RANK[own]:
                upwards.append(f"{module.name} in '{own}' imports from '{other}', which stands above it")
    assert upwards == []
    # Packages are left out: what stands in an __init__ is loaded when it is asked for.
    remaining = {m: {o for o in others if o.name != "__init__.py"} for m, others in every.items()}
    while out := {m for m, others in remaining.items() if not others or all(m not in o for o in remaining.values())}:
        remaining = {m: others - out for m, others in remaining.items() if m not in out}
    assert not remaining, sorted(str(m.relative_to(PACKAGE)) for m in remaining)


def test_one_hook_alone_looks_upwards_by_name():
    # What a text names, the order of rooms does not see: a result in a notebook asks the viewer, and the facade finds
    # its names.
    named = [m for m in MODULES if re.search(r"""import_module\(\s*f?["'](flexmb)?\.""", m.read_text())]
    assert [str(m.relative_to(PACKAGE)) for m in named] == ["display.py"]


def test_at_most_two_levels():
    assert [str(m) for m in MODULES if len(m.relative_to(PACKAGE).parts) > 2] == []


def loaded_by(code: str) -> set[str]:
    script = f"{code}\nimport sys\nprint(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(run.stdout.split())


def test_importing_the_package_loads_nothing_heavy():
    heavy = {"jax", "numpy", "scipy", "control", "diffrax", "optax", "equinox", "matplotlib"}
    assert not heavy & loaded_by("import flexmb, flexmb.cli")


@pytest.mark.slow
def test_frequencies_load_no_library_that_they_do_not_use():
    heavy = {"control", "diffrax", "optax", "equinox", "matplotlib", "typer"}
    assert not heavy & loaded_by("import flexmb\nflexmb.enable_x64()\nflexmb.frequencies, flexmb.Builder().node")


@pytest.mark.slow
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
    # `scatter` and `compare` are questions of their own: how made mechanisms differ, and how two models do.
    assert 50 <= len(offered("flexmb")) <= 77


def test_no_two_classes_have_one_name():
    where = collections.defaultdict(list)
    for module in MODULES:
        for name in re.findall(r"^\s*class (\w+)[(:]", module.read_text(), re.M):
            where[name].append(str(module.relative_to(PACKAGE)))
    assert {name: files for name, files in where.items() if len(files) > 1} == {}


@pytest.mark.skipif(shutil.which("git") is None, reason="git alone knows which files are tracked")
def test_the_top_level_holds_nothing_else():
    listed = subprocess.run(["git", "ls-files"], cwd=Path(__file__).parent.parent, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("this is no git repository")
    assert {name.split("/")[0] for name in listed.stdout.splitlines()} == set(TOP_LEVEL)


def test_the_tests_of_every_room_are_collected(pytestconfig):
    """A folder of a name that pytest passes over, such as "build", would be missed by nobody."""
    folders = {path.parent.name for path in Path(__file__).parent.rglob("test_*.py")}
    passed_over = pytestconfig.getini("norecursedirs")
    assert [name for name in sorted(folders) if any(fnmatch.fnmatch(name, own) for own in passed_over)] == []


def test_no_module_of_the_root_hides_a_public_name():
    """A module of the package would answer in place of a function of a room that bears its name."""
    modules = {path.stem for path in PACKAGE.glob("*.py")} | {
        path.parent.name for path in PACKAGE.glob("*/__init__.py")
    }
    public = {name for stub in PACKAGE.glob("*/__init__.pyi") for name in offered(f"flexmb.{stub.parent.name}")}
    assert not (modules & public) - set(offered("flexmb"))


def test_a_limit_has_one_value():
    """The later of two limits of one name would win in every room."""
    body = ast.parse((PACKAGE / "numerical_limits.py").read_text(encoding="utf-8")).body
    names = collections.Counter(node.targets[0].id for node in body if isinstance(node, ast.Assign))  # type: ignore
    assert [name for name, count in names.items() if count > 1] == []
