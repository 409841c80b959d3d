"""The help text of an element type: its docstring in its module, and its signature in words."""

import ast
import functools
import inspect
import itertools
import sys
from typing import Any


def repr_of(element: Any) -> str:
    """An element type in one line: name, nodes, properties and options."""
    parts = [f"joins {', '.join(_joined(element))}"]
    if element.properties:
        parts.append(f"takes {', '.join(element.properties)}")
    if options := _options(element):
        parts.append(f"options {options}")
    return f"<{_name(element)}: {'; '.join(parts)}>"


def help_of(element: Any) -> str:
    """Name and docstring of an element type, then its nodes, deformations, properties and options."""
    kinds = ", ".join(f"{name} ({kind.part})" for name, kind in element.nodes.items() if kind.part != "internal")
    ends = list(_ends(element))
    short = f", or one for each end: {', '.join(ends)}" if len(ends) < len(_joined(element)) else ""
    lines = [f"Nodes: {kinds}{short}."]
    lines += [f"Deformations: {names}."] if (names := deformations_of(element)) else []
    lines += [f"Takes: {', '.join(element.properties)}."] if element.properties else []
    lines += [f"Options: {options}."] if (options := _options(element)) else []
    return f"{_name(element)}: {_name_and_text(element)[1]}\n\n" + "\n".join(lines)


def deformations_of(element: Any, *without: int) -> str:
    """Numbers and names of an element's deformations, except some; empty without names."""
    entries = [(numbers, name) for name, numbers in element.numbered.items() if not {*numbers} & {*without}]
    return ", ".join(f"{n[0]} to {n[-1]} {name}" if len(n) > 1 else f"{n[0]} {name}" for n, name in entries)


def _joined(element: Any) -> list[str]:
    return [name for name, kind in element.nodes.items() if kind.part != "internal"]


def _ends(element: Any):
    """Parameters that need a name of their own: a node's name also means its rotation and its warping."""
    seen: set[str] = set()
    for name in _joined(element):
        part = element.nodes[name].part
        if not seen or part in seen or part == "position":
            seen = set()
            yield name
        seen.add(part)


def _options(element: Any) -> str:
    chosen = element.options
    return ", ".join(f"{name}={_word(chosen[name])}" if name in chosen else name for name in element.option_names)


def _word(value: Any) -> str:
    return getattr(value, "__name__", None) or repr(value)


def _name(element: Any) -> str:
    """Public name, such as planar.beam."""
    name, _ = _name_and_text(element)
    room = "planar" if next(iter(element.nodes.values())).dimension == 2 else "spatial"
    public = sys.modules.get(f"{__package__}.{room}")
    return f"{room}.{name}" if _same_type(getattr(public, name, None), element) else name


def _same_type(other: Any, element: Any) -> bool:
    return isinstance(other, type(element)) and other.usual == element.usual


@functools.cache
def _name_and_text(element: Any) -> tuple[str, str]:
    """Name and docstring of an element type in the module that defines it, else of its deformation function."""
    module = sys.modules.get(element.deformation.__module__)
    for name, text in _texts(element.deformation.__module__).items():
        if _same_type(getattr(module, name, None), element):
            return name, text
    return element.name, inspect.getdoc(element.deformation) or "an element type."


@functools.cache
def _texts(module: str) -> dict[str, str]:
    """Docstrings below assignments of a module, by name; empty without source."""
    try:
        body = ast.parse(inspect.getsource(sys.modules[module])).body
    except (KeyError, OSError, TypeError):
        return {}
    texts = {}
    for first, after in itertools.pairwise(body):
        target = first.targets[0] if isinstance(first, ast.Assign) else None
        text = after.value.value if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) else None
        if isinstance(target, ast.Name) and isinstance(text, str):
            texts[target.id] = inspect.cleandoc(text)
    return texts
