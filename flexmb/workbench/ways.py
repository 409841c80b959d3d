"""Sensitivities of an answer to every number and every free name of the document."""

import dataclasses
import logging
import threading
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ..compilation.compile import jit
from ..elements.section import Material
from ..errors import AnalysisError, heard
from ..linear.linearize import linearize
from ..model.model import Model
from ..model.topology import Parameters
from ..numerical_limits import REPEATED_ANSWER, SAME_ANSWER
from ..plot.geometry import element_names
from ..results import RESULTS, check, collected, worst_of
from .building import build, free_names, numeric_values, structure
from .content import Document
from .live_answers import Answers
from .references import call_of
from .traced import Answer, answer_of, clamps_of

# Number of compiled functions that are kept.
MOST = 12


class _Closure(NamedTuple):
    """A compiled function of the numbers of documents of one structure, at addresses in order.

    ``slopes`` returns from numbers (n,) the answer, its slopes (n,), relative slopes by the sections of each block's
    elements, and a code of RESULTS.
    """

    addresses: tuple[str, ...]
    slopes: Callable[[Any], Any]


class Ways:
    """Sensitivities of answers, compiled once for each structure and answer in a thread of its own."""

    def __init__(self, changed: Callable[[], None]):
        self._changed = changed
        self._closures: dict[Any, _Closure | Exception | None] = {}

    def of(self, document: Document, found: Answers, *, wait: bool = False) -> dict[str, Any]:
        """Sensitivities of the wanted answer, as a message to pages."""
        key = str(found.wants.sensitivity_of)
        empty = {"answer": key, "message": "", "by_field": {}, "by_name": {}, "relative": {}, "by_element": {}}

        def without(status: str, message: str = "") -> dict[str, Any]:
            return {**empty, "status": status, "message": message, "words": []}

        value = found.values.get(key, {}).get("value")
        why = _meaningless(key, found) if value is not None else f"There is no {key} here, so it has no sensitivity."
        if value is None or why:
            return without("failed", why)
        kind = _kind(document, found, key)
        if kind not in self._closures:
            self._prepare(kind, document, found, key, wait)
        closure = self._closures.get(kind)
        if closure is None:
            return without("computing")
        if isinstance(closure, Exception):
            return without("failed", str(closure))
        numbers = numeric_values(document)
        point = np.array([numbers[address] for address in closure.addresses])
        same, slopes, shares, code = closure.slopes(point)
        slopes = np.asarray(slopes)
        try:
            check(int(code), True)
        except AnalysisError as fault:
            return without("failed", str(fault))
        if abs(float(same) - value) > SAME_ANSWER * abs(value):
            # The function belongs to another mechanism, such as one with another clamped end.
            del self._closures[kind]
            return without("computing")
        if not np.all(np.isfinite(slopes)):
            critical = int(code) == RESULTS.critical_state
            return without("failed", RESULTS.critical_state.message if critical else "It has no derivative here.")
        by_field = dict(zip(closure.addresses, slopes.tolist(), strict=True))
        by_name = _by_name(document, by_field)
        at = {**{a: numbers[a] for a in by_field}, **{n: numbers[f"names/{n}/value"] for n in by_name}}
        every = {**by_field, **by_name}
        return {
            **empty,
            "status": "ok",
            "by_field": by_field,
            "by_name": by_name,
            "relative": {name: every[name] * float(at[name]) / value for name in every if at[name] != 0 and value != 0},
            "by_element": _by_element(found.model, shares, value),
            "words": _words(key, found, by_field),
        }

    def _prepare(self, kind: Any, document: Document, answers: Answers, key: str, wait: bool) -> None:
        """Compile a function, in a thread unless told to wait."""
        self._closures[kind] = None
        while len(self._closures) > MOST:
            del self._closures[next(iter(self._closures))]

        def compile_() -> None:
            try:
                answer = answer_of(key, answers.wants.support_node)
                with heard():
                    closure: Any = _closure(document, answers, answer, numeric_values(document))
            except Exception as fault:  # No one else waits for this thread: the pages show the fault.
                logging.getLogger("flexmb").debug("%s", key, exc_info=True)
                closure = fault
            if kind in self._closures:
                self._closures[kind] = closure
            if not wait:
                self._changed()

        if wait:
            compile_()
        else:
            threading.Thread(target=compile_, name="flexmb ways", daemon=True).start()


def numeric_fields(document: Document) -> list[str]:
    """Addresses of the fields with numbers to differentiate by: no names, and no numbers that choose code."""
    whole_fields = {"names"}
    for item in document.things:
        fields = call.fields if (call := call_of(item)) else {}
        whole_fields.update(f"{item['id']}/{name}" for name, field in fields.items() if field["whole"])

    def varies(address: str) -> bool:
        parts = address.split("/")
        return whole_fields.isdisjoint((parts[0], "/".join(parts[:2])))

    return [address for address in numeric_values(document) if varies(address)]


def _kind(document: Document, answers: Answers, key: str) -> Any:
    """Key of a compiled function: structure, roles that depend on numbers, and the answer."""
    model = answers.model
    roles = tuple(tuple(map(str, some)) for some in model.roles())
    where = answers.values[key].get("where", {}).get("node") if key == "displacement" else None
    return structure(document, arithmetic=False), key, answers.wants.support_node, where, roles, clamps_of(model)


def _closure(document: Document, answers: Answers, answer: Answer, numbers: Mapping[str, Any]) -> _Closure:
    """Answer and slopes for documents of this structure, compiled by a first call."""
    like, increment, addresses = answers.model, answers.increment, tuple(numeric_fields(document))

    def parameters(flat: Any) -> Parameters:
        return build(document, dict(zip(addresses, flat, strict=True))).model(like).parameters

    def of_parameters(parameter_tree: Parameters):
        with collected() as codes:
            value = answer(linearize(dataclasses.replace(like, parameters=parameter_tree), increment=increment))
        return value, worst_of(codes)

    def value_and_slopes(flat: Any):
        parameter_tree, pull = jax.vjp(parameters, flat)
        (value, code), slopes = jax.value_and_grad(of_parameters, has_aux=True)(parameter_tree)
        pairs = zip(parameter_tree.properties, slopes.properties, strict=True)
        shares = [_section_slopes(properties, changes) for properties, changes in pairs]
        return value, pull(slopes)[0], shares, code

    compiled = jit(value_and_slopes)
    compiled(np.array([float(numbers[address]) for address in addresses]))
    return _Closure(addresses, compiled)


def _section_slopes(properties: dict[str, Any], slopes: dict[str, Any]) -> list[Any]:
    """Slopes times sizes, summed over the sizes of each section, for every stack of sections of a block."""
    sums = []
    sections = [part.get("section") for part in (properties, slopes)]
    stacks = [section if isinstance(section, tuple) else (section,) for section in sections]
    for section, slope in zip(*stacks, strict=True):
        if section is not None:
            pairs = zip(jax.tree.leaves(_sizes(section)), jax.tree.leaves(_sizes(slope)), strict=True)
            # A leaf without axes is shared by several elements.
            products = [a * b for a, b in pairs if jnp.ndim(a)]
            sums.append(sum(jnp.sum(jnp.reshape(product, (len(product), -1)), axis=1) for product in products))
    return sums


def _sizes(section: Any) -> Any:
    """Sizes of a section, without its material."""
    fields = [getattr(section, field.name) for field in dataclasses.fields(section)]
    return [value for value in fields if not isinstance(value, Material)]


def _by_element(model: Model, shares: list[list[Any]], value: float) -> dict[str, float]:
    """Relative slopes by the name of each element."""
    relative_slopes: dict[str, float] = {}
    for block, stacks in zip(model.topology.blocks, shares, strict=True):
        names = element_names(model, block)
        slopes = [slope for stack in stacks for slope in np.asarray(stack).tolist()]
        for name, slope in zip(names, slopes, strict=False):
            relative_slopes[name] = relative_slopes.get(name, 0.0) + slope / value
    return relative_slopes


def _by_name(document: Document, by_field: Mapping[str, float]) -> dict[str, float]:
    """Slopes by the free names, from the slopes of the fields and the arithmetic in each field."""
    values, names = numeric_values(document), free_names(document)

    def weighted(name_values: dict[str, Any]) -> Any:
        numbers = numeric_values(document, name_values)
        return jnp.asarray(sum(slope * numbers[address] for address, slope in by_field.items()), float)

    slopes = jax.grad(weighted)({name: float(values[f"names/{name}/value"]) for name in names}) if names else {}
    return {name: float(slopes[name]) for name in names}


def _meaningless(key: str, answers: Answers) -> str:
    """Reason why an answer has no sensitivity; empty if it has one."""
    word, _, number = key.partition(" ")
    several: dict[str, Any] = {}
    if answers.modes is not None:
        several["frequency"] = answers.modes.eigenvalues
    if answers.buckled is not None:
        several["multiplier"] = answers.buckled.multipliers
    if word == "pole":
        return "flexmb does not differentiate poles of loads without a potential."
    if word in several:
        values, place = np.asarray(several[word]), int(number) - 1
        alike = np.abs(values - values[place]) <= REPEATED_ANSWER * np.abs(values[place])
        repeated = [i for i in np.flatnonzero(alike).tolist() if i != place]
        if answers.values[key]["text"].startswith("0 Hz"):
            return f"{key.capitalize()} belongs to a free motion: it stays zero."
        if repeated:
            others = ", ".join(f"{word} {i + 1}" for i in repeated)
            return f"{key.capitalize()} is repeated, as {others}: alone it has no derivative."
    if word in ("displacement", "stress") and not answers.values[key]["value"]:
        return f"There is no {key}, so it has no sensitivity."
    return ""


def _words(key: str, answers: Answers, by_field: Mapping[str, float]) -> list[str]:
    """Special properties of sensitivities, in words."""
    words = []
    if not any(by_field.values()):
        words.append(f"No number changes {key}.")
    if key == "stress" and answers.stress is not None:
        largest = np.max(np.asarray(answers.stress.von_mises), axis=-1)
        if np.sum(largest >= (1 - REPEATED_ANSWER) * np.max(largest)) > 1:
            words.append("Several places have the largest stress. The sensitivity holds for one of them.")
    return words
