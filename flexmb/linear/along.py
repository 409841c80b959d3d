"""What a path or a motion tells of each of its states, asked for by a text such as "force top.x" or "frequency 1"."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import jit
from ..display import unit_of
from ..mechanics.loads import lacks_potential
from ..model.by_name import TURNS
from ..results import RESULTS
from .compliance import compliance_of, compliance_of_large
from .linearize import ManyStates, Matrices
from .modes import refuse_unsymmetric
from .sparse_solve import lowest_values
from .spectrum import general_spectrum, is_real, to_frequency
from .stress import stress

ENERGIES = ("kinetic", "elastic", "potential", "energy")
ANGLES = ("phi", *TURNS)


class Series(NamedTuple):
    """One quantity in every state of a path or a motion.

    Attributes:
        values: Its values, (states,).
        label: Its name.
        unit: Its unit, such as "N".
        of: What kind of quantity it is, the first word of the question: "coordinate", "force", "frequency", ..
    """

    values: Float[np.ndarray, "states"]
    label: str
    unit: str
    of: str

    @property
    def axis(self) -> str:
        """Label of an axis, with the unit."""
        return f"{self.label} [{self.unit}]"


class Along(ManyStates):
    """Base class of a path and a motion: what they tell of each of their states, for axes of pictures."""

    def along(self, text: str) -> Series:
        """One quantity in every state, asked for by name.

        "top.x", "displacement top.x" (from the undeformed mechanism), "top.phi" (an angle; in space "top.rx");
        "force top.x" (see ``force_needed``), "reaction foot.x"; "deformation leaf.2", "stress resultant leaf.2";
        "stress" (largest von Mises stress), "stress leaf"; "frequency 1", "stiffness top.y" (of all else free to
        follow), "load factor", "multiplier 1" (of buckling) of a path; "time", "velocity top.x", "acceleration top.x",
        "kinetic", "elastic", "potential", "energy" (their sum) of a motion.

        Args:
            text: The question.

        Returns:
            Series with values (states,) and their unit.

        Raises:
            KeyError: There is no such quantity, node, element or component.
        """
        result: Any = self
        kinds = ", ".join([*_of_result(result), *sorted(_QUESTIONS)])
        if str(text) in _of_result(result):
            return _of_result(result)[str(text)]()
        if text in [str(entry) for entry in result.labels.x]:
            return _coordinate(result, text)
        for kind, ask in _QUESTIONS.items():
            if text == kind or str(text).startswith(f"{kind} "):
                return ask(result, str(text).removeprefix(kind).strip())
        node, _, component = str(text).rpartition(".")
        if component in ANGLES and result.labels.coordinates(node):
            values = result.rotation(node, component)
            return Series(np.asarray(values), str(text), "rad", "coordinate")
        own = [str(entry) for entry in result.labels.x if entry.of == node or entry.of == text]
        hint = f"there is {', '.join(own)}" if own else f"write node and component, such as tip.y, or ask for {kinds}"
        raise KeyError(f"no coordinate '{text}' in this model; {hint}")


def _split(text: str) -> tuple[str, str]:
    """Node and component of "top.x"; element and number likewise."""
    of, _, component = text.rpartition(".")
    if not of:
        raise KeyError(f"'{text}' is no component: write node and component, such as tip.y, element and number: leaf.2")
    return of, component


def _of_result(result: Any) -> dict[str, Callable[[], Series]]:
    """What is asked for by one word: what states stand over, and energies of a motion."""
    states = result.states()
    kind = "time" if states.kind == "motion" else "load factor"
    unit = "s" if kind == "time" else "-"
    found = {kind: lambda: Series(np.asarray(states.along), kind, unit, kind)}
    if kind == "time":
        for name in ENERGIES:
            found[name] = lambda name=name: Series(np.asarray(getattr(result.observe(), name)), name, "J", "energy")
    return found


def _coordinate(result: Any, text: str) -> Series:
    index = [str(entry) for entry in result.labels.x].index(text)
    return Series(np.asarray(result.x)[:, index], text, unit_of(result.labels.x[index]), "coordinate")


def _displacement(result: Any, text: str) -> Series:
    node, component = _split(text)
    names = [str(entry) for entry in result.labels.x]
    entry = f"{node}.rotation.phi" if component == "phi" and f"{node}.rotation.phi" in names else text
    if component in TURNS:
        values = result.rotation(node, component)
        return Series(np.asarray(values), f"displacement {text}", "rad", "coordinate")
    if entry not in names:
        result.position(node, component)
    found = _coordinate(result, entry)
    start = np.asarray(result.model.parameters.reference)[names.index(entry)]
    return found._replace(values=found.values - start, label=f"displacement {text}")


def _rate(method: str, per: str) -> Callable[[Any, str], Series]:
    """Velocities and accelerations."""

    def ask(result: Any, text: str) -> Series:
        node, component = _split(text)
        turns = component in ANGLES
        values = getattr(result, f"angular_{method}" if turns else method)(node, component)
        return Series(np.asarray(values), f"{method} {text}", f"{'rad' if turns else 'm'}/{per}", method)

    return ask


def _force(method: str, word: str) -> Callable[[Any, str], Series]:
    def ask(result: Any, text: str) -> Series:
        node, component = _split(text)
        values = getattr(result, method)(node, component)
        return Series(np.asarray(values), f"{word} {text}", "N m" if component in ANGLES else "N", word)

    return ask


def _of_element(method: str, word: str, unit: str) -> Callable[[Any, str], Series]:
    def ask(result: Any, text: str) -> Series:
        element, number = _split(text)
        values = getattr(result, method)(element, int(number) if number.isdecimal() else number)
        return Series(np.asarray(values), f"{word} {text}", unit, word)

    return ask


def _stress(result: Any, element: str) -> Series:
    found = stress(result.model, at=result)
    if not element:
        return Series(np.asarray(found.maximum), "largest von Mises stress", "Pa", "stress")
    if element not in found.names:
        raise KeyError(f"no stress of an element '{element}'; there is {', '.join(found.names)}")
    return Series(np.asarray(found.by_element)[:, found.names.index(element)], f"stress {element}", "Pa", "stress")


def _numbered(values: np.ndarray, word: str, text: str, unit: str) -> Series:
    if not text.isdigit() or not 1 <= int(text) <= values.shape[1]:
        raise KeyError(f"no {word} '{text}': they are numbered 1 to {values.shape[1]}")
    own = values[:, int(text) - 1]
    return Series(np.where(np.isfinite(own), own, np.nan), f"{word} {text}", unit, word)


def _frequency(result: Any, text: str) -> Series:
    path = result.states().kind == "path"
    if result.by_sparse and text.isdigit():
        refuse_unsymmetric(not lacks_potential(result.model.topology))
        each = [lowest_values(lin.elements, int(text)) for lin in _each_linearization(result)]
        return _numbered(np.asarray(to_frequency(jnp.stack(each))), "frequency", text, "Hz")
    found = np.asarray(result.frequencies) if path else frequencies_along(result.linearizations().matrices)
    return _numbered(found, "frequency", text, "Hz")


def _multiplier(result: Any, text: str) -> Series:
    if result.states().kind != "path":
        raise KeyError("load multipliers are asked of a path, not of a motion")
    if result.by_sparse:
        raise KeyError(
            "a path by sparse matrices has no load multipliers of all states: ask about one, as"
            " fm.buckling_loads(model, count=1, at=path, step=-1)"
        )
    return _numbered(np.asarray(result.multipliers), "multiplier", text, "-")


def _stiffness(result: Any, text: str) -> Series:
    node, component = _split(text)
    labels, names = result.labels, []
    for part in labels.parts(node):
        own = [labels.x[i].symbol for i in labels.known(part)]
        names += TURNS if own[0] == "l0" else own
    if component not in names:
        raise KeyError(f"node '{node}' has no component '{component}' here; it has {', '.join(names)}")
    places = tuple(labels.known(part) for part in labels.parts(node))
    at = names.index(component)
    if result.by_sparse:
        found = np.array([compliance_of_large(lin, places)[at, at] for lin in _each_linearization(result)])
    else:
        found = np.asarray(_compliances(result.linearizations().matrices, places))[:, at, at]
    with np.errstate(divide="ignore"):
        values = 1 / found
    return Series(values, f"stiffness {text}", "N m/rad" if component in ANGLES else "N/m", "stiffness")


def _each_linearization(result: Any) -> Iterator[Any]:
    """Linearised equations of each state of a path, one after the other."""
    return (result.linearization(i) for i in range(len(result.x)))


@jit
def _compliances(found: Matrices, parts: Any) -> Float[Array, "states n n"]:
    """Compliance at a node in every state; in space a rotation is about the global axes."""
    return jax.vmap(lambda m: compliance_of(m, parts, local=False)[0])(found)


def frequencies_along(m: Matrices) -> np.ndarray:
    """Frequencies of K0 + N0 + G0 and M0 in every state, ascending, (states, n_q) [Hz].

    NaN where they are complex, and where the degrees of freedom do not determine the state.
    """
    mass, stiffness = np.asarray(m.M0), np.asarray(m.K)
    rows = np.full(mass.shape[:2], np.nan)
    for i in np.flatnonzero(np.asarray(m.result) == int(RESULTS.successful.value)):
        values, _ = general_spectrum(stiffness[i], mass[i])
        rows[i] = np.sort(to_frequency(np.where(is_real(values), values.real, np.nan)))
    return rows


# Longer words first: "stress resultant" is no stress.
_QUESTIONS: dict[str, Callable[[Any, str], Series]] = {
    "stress resultant": _of_element("stress_resultant", "stress resultant", "N, N m"),
    "displacement": _displacement,
    "velocity": _rate("velocity", "s"),
    "acceleration": _rate("acceleration", "s²"),
    "force": _force("force_needed", "force"),
    "moment": _force("force_needed", "moment"),
    "reaction": _force("reaction", "reaction"),
    "deformation": _of_element("deformation", "deformation", "m, rad"),
    "stress": _stress,
    "frequency": _frequency,
    "multiplier": _multiplier,
    "stiffness": _stiffness,
}
