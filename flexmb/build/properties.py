"""Properties of an element: filled in with defaults, and checked for kind, shape and completeness."""

import dataclasses
import inspect
import types
import typing
import weakref
from collections.abc import Callable
from typing import Any

import jax
import jax.core
import numpy as np

from ..arguments import check_numbers, check_real, is_concrete, short_repr
from ..compilation.kept import remembered
from ..compilation.record import Record
from ..elements.curves import CurvedLine, curvature_along
from ..elements.element import COMPANIONS, Element, wanted_option
from ..elements.leaf_ends import PlanarRoots, Roots
from ..elements.sections import Damping, Material, Section
from ..errors import ModelError, first_line
from ..mechanics.blocks import companion_arguments, vector_shape
from .assemble import is_option, stack
from .mistaken_units import warn_of_material, warn_of_section

EMPTY = inspect.Parameter.empty
# Annotation of a property with one truth value for each end.
ENDS = tuple[bool, bool]
# Annotations of stiffnesses of both ends, with how many there are of each.
ROOTS = {PlanarRoots: 3, Roots: 6}
# Companions whose shapes depend on no property. Companions of this package are not checked.
SURE = ("inertia", "force", "resultants", "surface", "thermal")


def element_type(given: Any) -> Element:
    """Return an element type. A plain deformation function becomes an element type without companions.

    Raises:
        ModelError: The argument is neither, or its signature names no nodes.
    """
    function = given.deformation if isinstance(given, Element) else given
    if not inspect.isfunction(function):
        raise ModelError(
            f"Element type must be an Element or a deformation function, such as planar.beam, not {short_repr(given)}."
        )
    element = given if isinstance(given, Element) else Element(given)
    for name in COMPANIONS:
        companion = getattr(element, name)
        if companion is not None and not inspect.isroutine(companion):
            raise ModelError(
                f"Element type '{element.name}': its {name} must be a function, not {short_repr(companion)}."
            )
    try:
        nodes = element.nodes
    except TypeError as fault:
        raise ModelError(str(fault)) from None
    if not nodes:
        raise ModelError(f"Element type '{element.name}' joins no nodes: annotate its positional parameters.")
    return element


def with_options(element: Element, name: str, given: dict[str, Any]) -> tuple[Element, dict[str, Any]]:
    """Return the element type with the given options, and the other given values: its properties.

    Raises:
        ModelError: An option has the wrong kind, is not hashable, or is missing.
    """
    options = {key: value for key, value in given.items() if key in element.option_names and value is not None}
    try:
        adapted = element(**options)
    except (TypeError, ValueError) as fault:
        raise ModelError(f"Element '{name}' ({element.name}): {fault}") from None
    for key in adapted.option_names:
        if key not in adapted.options:
            raise ModelError(f"Element '{name}' ({element.name}) needs the option '{key}'.")
    return adapted, {key: value for key, value in given.items() if key not in element.option_names}


def complete_properties(element: Element, name: str, given: dict[str, Any]) -> dict[str, Any]:
    """Properties of an element with defaults filled in.

    Raises:
        ModelError: A property is unknown, has the wrong kind, or is missing.
    """
    known = element.properties
    for key in given:
        if key not in known and key != "incremental":
            raise ModelError(
                f"Element '{name}' ({element.name}) has no property '{key}'. It takes:"
                f" {', '.join([*known, *element.option_names]) or 'none'}."
            )
    completed = {key: _checked(element, name, key, value) for key, value in given.items() if value is not None}
    needed = {n for f in (element.deformation, element.law) if f is not None for n in element.wanted(f)}
    for key, parameter in known.items():
        if key in completed:
            continue
        if key in needed and parameter.default is EMPTY:
            raise ModelError(f"Element '{name}' ({element.name}) needs the property '{key}'.")
        completed[key] = None if parameter.default is EMPTY else parameter.default
    _check_complete(element, name, set(given) & {k for k, v in completed.items() if v is not None}, completed, needed)
    return completed


def with_material_damping(element: Element, properties: dict[str, Any]) -> dict[str, Any]:
    """Properties of an element. An elastic element without damping gets the damping of its material."""
    section = properties.get("section")
    if not isinstance(section, Section) or properties.get("damping") is not None:
        return properties
    if (damping := section.material_damping()) is None:
        return properties
    if element.arguments(element.stiffness, properties) is not None:
        return {**properties, "damping": damping}
    # A belt has an energy instead of a stiffness. Its damper needs rigidities.
    return {**properties, "damping": damping.rigidities(section)} if "damping" in properties else properties


def _check_complete(element: Element, name: str, stated: set[str], completed: dict[str, Any], needed: set[str]) -> None:
    """Raise if only some properties of a companion are given. flexmb would not call this companion."""
    for kind in (*COMPANIONS, "shape"):
        companion = getattr(element, kind)
        if companion is None:
            continue
        parameters = {key: p for key, p in element.wanted(companion).items() if key not in needed}
        required = [key for key, p in parameters.items() if p.default is not None]
        missing = [key for key in required if completed[key] is None]
        present = [key for key in required if key in stated]
        if missing and present:
            raise ModelError(
                f"Element '{name}' ({element.name}): its {kind} needs {_listed(missing)} too, beside"
                f" {_listed(present)}. Give all of them, or none for an element without {kind}."
            )


def _listed(names: list[str]) -> str:
    return ", ".join(f"'{n}'" for n in names)


# -- one property ---------------------------------------------------------------------------------------------------


def _checked(element: Element, name: str, key: str, value: Any) -> Any:
    """Return a property as flexmb stores it. Sequences of numbers become arrays."""
    subject = f"Property '{key}' of element '{name}'"
    hints = alternatives_of(element.hint(key))
    records = [h for h in hints if inspect.isclass(h) and issubclass(h, Record)]
    if CurvedLine in hints and callable(value) and not isinstance(value, Record):
        value = curvature_along(value)
    if records and not (_is_number(hints) and not isinstance(value, Record)):
        if not isinstance(value, tuple(records)):
            expected = " or ".join(_kind(h) for h in records)
            raise ModelError(f"{subject} must be {expected}, not {short_repr(value)}.")
    elif ENDS in hints:
        flags = [value] * 2 if isinstance(value, bool) else list(value) if isinstance(value, list | tuple) else []
        if len(flags) != 2 or not all(isinstance(flag, bool) for flag in flags):
            raise ModelError(
                f"{subject} must be True or False, or two of them, one for each end, not {short_repr(value)}."
            )
        return np.array(flags, float)
    elif roots := [ROOTS[h] for h in hints if h in ROOTS]:
        return _of_roots(subject, value, roots[0])
    elif bool in hints:
        if not isinstance(value, bool):
            raise ModelError(f"{subject} must be True or False, not {short_repr(value)}.")
        return value
    elif is_option(value) and not _is_number(hints):
        return value
    if isinstance(value, Record):
        _check_record(subject, f"{key} of element '{name}'", value)
        return value
    if isinstance(value, list | tuple):
        check_numbers(subject, value, fault=ModelError)
        value = stack(value)
    leaves, shape = jax.tree.leaves(value), None
    if len(leaves) == 1 and leaves[0] is value:
        shape = next((s for s in map(_shape, hints) if s is not None), None)
        # One number replaces several equal numbers, such as the stiffnesses of all deformations.
        shape = () if float in hints and np.ndim(value) == 0 else shape
    for leaf in leaves:
        check_numbers(subject, leaf, shape, fault=ModelError)
    return value


def _of_roots(subject: str, value: Any, count: int) -> tuple[Any, Any] | None:
    """Stiffnesses of the roots at both ends, None for a rigid one: the same for both, or each its own."""
    ends = list(value) if isinstance(value, list | tuple) else []
    ends = [stack(end) if isinstance(end, list | tuple) and not is_concrete(end) else end for end in ends]
    if len(ends) != 2 or any(end is not None and np.ndim(end) != 1 for end in ends):
        check_numbers(subject, value, fault=ModelError)
        flat = (stack(ends) if ends else stack([value])[0]).reshape(-1)
        # An array of twice as many may be six stiffnesses in space, of which a leaf spring in the plane takes three.
        if flat.size != count and (flat.size != 2 * count or (not ends and np.ndim(value) == 1)):
            raise ModelError(
                f"{subject} must be the {count} stiffnesses of a root, or a pair of such sets for the first and the"
                f" last end (None for a rigid end), not {short_repr(value)}."
            )
        ends = [flat[:count], flat[-count:]]
    for end in ends:
        if end is not None:
            check_numbers(subject, end, (count,), fault=ModelError)
    first, last = (None if end is None else stack([end])[0] for end in ends)
    return None if first is None and last is None else (first, last)


def _kind(record: type) -> str:
    """Name of a kind of record in a message."""
    example = {Section: ", such as Rectangle(..)", Damping: ", such as Damping(EA=..)"}.get(record, "")
    return f"a {record.__name__}{example}"


def alternatives_of(hint: Any) -> tuple:
    """Types that an annotation allows, without None."""
    if isinstance(hint, types.UnionType) or typing.get_origin(hint) is typing.Union:
        return tuple(h for h in typing.get_args(hint) if h is not type(None))
    return () if hint is None else (hint,)


def _is_number(hints: tuple) -> bool:
    return any(h in (float, int) or hasattr(h, "dim_str") for h in hints)


def _shape(hint: Any) -> tuple[int, ...] | None:
    """Shape in an annotation of jaxtyping; None if an axis has a name instead of a number."""
    words = getattr(hint, "dim_str", "any").split()
    return tuple(int(w) for w in words) if all(w.isdecimal() for w in words) else None


def check_record(of: str, value: Record) -> None:
    """Refuse a section, a damping or a material with wrong entries, before an element has it.

    Raises:
        ModelError: An entry has the wrong kind, is not finite, or is physically impossible.
    """
    _check_record(f"The {of}", of, value)
    if isinstance(value, Material) and is_concrete(value):
        for fault in value.faults():
            raise ModelError(f"The {of} has {fault}.")
        warn_of_material(of, value)


def _check_record(subject: str, record_name: str, value: Record) -> None:
    """Raise for a section or damping with wrong entries. Elements that share a record check it once."""
    if value in _CHECKED:
        return
    _check_fields(record_name, value)
    for leaf in jax.tree.leaves(value):
        check_numbers(subject, leaf, fault=ModelError)
    if is_concrete(value) and isinstance(value, Section | Damping):
        for fault in value.faults():
            raise ModelError(f"The {record_name} has {fault}.")
        if isinstance(value, Section):
            warn_of_section(record_name, value)
    _CHECKED.add(value)


_CHECKED: weakref.WeakSet[Record] = weakref.WeakSet()


def _check_fields(record_name: str, record: Any) -> None:
    """Refuse entries of the wrong kind, named as the engineer wrote them."""
    try:
        hints = typing.get_type_hints(type(record))
    except (NameError, TypeError):
        return
    for field in dataclasses.fields(record):
        value, hint = getattr(record, field.name), hints[field.name]
        alternatives = alternatives_of(hint)
        inner = [h for h in alternatives if inspect.isclass(h) and issubclass(h, Record)]
        right = ""
        if value is None and type(None) in typing.get_args(hint):
            continue
        if inner:
            right = "" if isinstance(value, tuple(inner)) else " or ".join(map(_kind, inner))
            if not right:
                _check_fields(record_name, value)
        elif field.metadata.get("static"):
            right = wanted_option(value, hint)
        elif float in alternatives:
            right = "" if _is_scalar(value) else "a number"
        if right:
            raise ModelError(f"The {record_name} has {field.name} = {short_repr(value)}, but it must be {right}.")


def _is_scalar(value: Any) -> bool:
    if isinstance(value, jax.core.Tracer):
        return value.shape == ()
    try:
        array = np.asarray(value)
    except (ValueError, TypeError):
        return False
    return array.shape == () and array.dtype.kind in "iuf"


# -- what the functions of an element return -------------------------------------------------------------------------


def number_of_deformations(element: Element, name: str, properties: dict[str, Any]) -> int:
    """Return the number of deformations of an element, and check the shapes that its companions return.

    Raises:
        ModelError: A function of the element fails, or returns a wrong shape.
    """
    options = {k: v for k, v in properties.items() if is_option(v)}
    leaves, structure = jax.tree.flatten({k: v for k, v in properties.items() if not is_option(v)})
    shapes = tuple(np.shape(leaf) for leaf in leaves)
    try:
        return _count(element, tuple(sorted(options.items())), structure, shapes)
    except _WrongFunction as fault:
        raise ModelError(f"Element '{name}' ({element.name}): its {fault}") from fault.__cause__


class _WrongFunction(Exception):
    """A function of an element is wrong."""


@remembered
def _count(element: Element, chosen: tuple, structure: Any, shapes: tuple) -> int:
    options = dict(chosen)
    nodes = [vector_shape(kind.size) for kind in element.nodes.values()]
    numbers = jax.tree.unflatten(structure, [jax.ShapeDtypeStruct(shape, float) for shape in shapes])

    def returned(kind: str, companion: Callable[..., Any], arguments: list, **extra: Any) -> Any:
        """Shapes of what a function returns."""
        properties = element.arguments(companion, {**numbers, **options})
        if properties is None:
            return None
        varying = {k: v for k, v in properties.items() if k in numbers}
        fixed = {k: v for k, v in properties.items() if k not in numbers}

        def call(arguments: list[Any], nodes: list[Any], varying: dict[str, Any], extra: dict[str, Any]):
            return companion(*arguments, ref=element.reference(nodes), **varying, **fixed, **extra)

        try:
            value = jax.eval_shape(call, arguments, nodes, varying, extra)
            check_real("its value", value)
            return value
        except Exception as fault:
            first = first_line(fault)
            if "unexpected keyword argument 'ref'" in first:
                first += "; every function of an element takes `ref` by name, as in def f(.., *, ref)"
            raise _WrongFunction(f"{kind} cannot be computed: {first}") from fault

    keywords = {"near": vector_shape(64)} if element.tracks_angle else {}
    deformations = returned("deformation", element.deformation, nodes, **keywords)
    if not isinstance(deformations, jax.ShapeDtypeStruct) or len(deformations.shape) != 1:
        raise _WrongFunction(f"deformation must be a vector of shape (n,), but is {_described(deformations)}.")
    n = deformations.shape[0]
    for name in ("measured", "fields"):
        indices = [i for part in getattr(element, name) for i in (part if name == "fields" else (part,))]
        if any(not 1 <= i <= n for i in indices):
            raise _WrongFunction(f"`{name}` names deformations {indices}, but it has {n}.")
    _check_names(element, n)
    positional, extra = companion_arguments(element, n)
    for kind in COMPANIONS:
        companion = getattr(element, kind)
        if companion is None or (kind in SURE and companion.__module__.startswith("flexmb.")):
            continue
        if kind == "thermal" and not element.expands({**numbers, **options}):
            continue
        answer = returned(kind, companion, list(positional.get(kind, nodes)), **extra.get(kind, {}))
        if answer is not None:
            _check_answer(element, kind, n, answer)
    return n


def _check_names(element: Element, n: int) -> None:
    """Raise unless each of n deformations has one name that can be a keyword of ``Builder.prestress``."""
    names = element.deformation_names
    if element.names and len(names) != n:
        raise _WrongFunction(f"`names` must name {n} deformations, but names {len(names)}: {', '.join(element.names)}.")
    for number, name in names.items():
        if not str(name).isidentifier() or name in ("element", "increment") or element.number_of(name) != number:
            raise _WrongFunction(f"`names` calls deformation {number} {short_repr(name)}: choose another word for it.")


def _check_answer(element: Element, kind: str, n: int, answer: Any) -> None:
    """Raise if a companion of an element with n deformations returns a wrong shape."""
    expected = {"stiffness": (n, n), "damping": (n, n), "energy": (), "dissipation": (), "law": (n,)}
    expected |= {"force": (sum(node.size for node in element.nodes.values()),), "resultants": (6,), "thermal": (n,)}
    shapes = [getattr(part, "shape", ()) for part in answer] if isinstance(answer, tuple) else []
    if kind == "inertia":
        if len(shapes) != 2 or len(shapes[0]) != 2 or shapes[1] != (shapes[0][0],) * 2:
            raise _WrongFunction(f"inertia must be vectors (k, d) and a matrix (k, k), but is {_described(answer)}.")
    elif kind == "surface":
        if shapes != [(8,)] * 3:
            raise _WrongFunction(f"surface must be three vectors (8,), but is {_described(answer)}.")
    elif getattr(answer, "shape", None) != expected[kind]:
        has = f"has {answer.shape}" if isinstance(answer, jax.ShapeDtypeStruct) else f"is {_described(answer)}"
        raise _WrongFunction(f"{kind} must have shape {expected[kind]}, but {has}.")


def _described(answer: Any) -> str:
    shapes = [getattr(leaf, "shape", "?") for leaf in jax.tree.leaves(answer)]
    return f"of shape {' and '.join(map(str, shapes))}" if shapes else "nothing"
