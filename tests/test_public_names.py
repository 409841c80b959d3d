"""The package uses public names of JAX, Equinox, diffrax and Typer alone, so that it survives their next versions."""

import ast
from pathlib import Path

import pytest

import flexmb

LIBRARIES = {"jax", "jaxlib", "equinox", "diffrax", "optimistix", "lineax", "optax", "typer"}
# Nothing of these, whatever it is called.
CLOSED = ("jaxlib", "jax.interpreters")
ROOT = Path(flexmb.__file__).parent


def private_names(text: str) -> list[str]:
    """Names that are not public, in imports and attribute accesses on what was imported."""
    tree = ast.parse(text)
    full: dict[str, str] = {}
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for name in node.names:
                found.append(name.name)
                full[name.asname or name.name.partition(".")[0]] = name.name if name.asname else name.name.split(".")[0]
        elif isinstance(node, ast.ImportFrom) and not node.level:
            for name in node.names:
                full[name.asname or name.name] = f"{node.module}.{name.name}"
                found.append(f"{node.module}.{name.name}")
    for node in ast.walk(tree):
        parts = []
        while isinstance(node, ast.Attribute):
            parts.append(node.attr)
            node = node.value
        if parts and isinstance(node, ast.Name) and node.id in full:
            found.append(".".join([full[node.id], *reversed(parts)]))

    def is_private(name: str) -> bool:
        closed = any(f"{name}.".startswith(f"{one}.") for one in CLOSED)
        hidden = any(part.startswith("_") and not part.endswith("__") for part in name.split("."))
        return name.split(".")[0] in LIBRARIES and (closed or hidden)

    return sorted({name for name in found if is_private(name)})


@pytest.mark.slow("flexmb")
@pytest.mark.parametrize("folder", [ROOT, Path(__file__).parent], ids=["flexmb", "tests"])
def test_names_of_libraries_are_public(folder):
    every = {str(path.relative_to(folder)): private_names(path.read_text()) for path in folder.rglob("*.py")}
    assert {path: names for path, names in every.items() if names} == {}


@pytest.mark.parametrize(
    "text",
    [
        "from jax._src import config",
        "import jax._src.config",
        "from jaxlib import xla_client",
        "import jax\njax.interpreters.mlir.lower_fun",
        "import equinox as eqx\neqx._errors.EQX_ON_ERROR",
        "from typer import _click",
    ],
)
def test_a_name_that_is_not_public_is_found(text):
    assert private_names(text)
    assert private_names("import jax\nfrom jax.extend.core import Jaxpr\njax.__version__\njax.numpy.sin") == []
