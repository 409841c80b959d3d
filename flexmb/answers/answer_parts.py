"""Parts of answers that several modes share: numbers by node and element, matrices, rows of a table."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import ArrayLike

from ..compilation.compile import jit
from ..errors import heard
from ..linear.compliance import directional_compliance, rates_on_host
from ..linear.linearize import Linearization
from ..linear.modes import poles
from ..linear.spectrum import without_growth
from ..linear.stress import has_stress, stress
from ..math.linear import is_positive_definite
from ..model.model import Entry, Labels
from ..numerical_limits import NO_STIFFNESS

# Rows and columns on the terminal.
SHOWN_VALUES = 12


def number(name: str) -> int | str:
    """Number of a node or element; a rotation keeps its name."""
    return int(name) if name.isdigit() else name


def is_shown(entry: Entry) -> bool:
    """Whether a coordinate or deformation is listed by the node or element that it belongs to."""
    return entry.kind not in ("norm", "internal") and not entry.of.endswith(".warping")


def by_owner(values: ArrayLike, entries: Sequence[Entry]) -> dict[str, list[float]]:
    """Entries of a vector by their node or element, without coordinates that elements own."""
    grouped: dict[str, list[float]] = {}
    for value, entry in zip(np.asarray(values).tolist(), entries, strict=True):
        if is_shown(entry):
            grouped.setdefault(entry.of, []).append(value)
    return grouped


def reactions(lin: Linearization) -> dict[str, list[float]]:
    """Support forces, moments of spatial rotations about global axes, at nodes where something is held."""
    labels, by_node = lin.labels, {}
    constrained = set(np.asarray(lin.model.topology.x.held).tolist())
    reactions, x = np.asarray(lin.matrices.reactions), np.asarray(lin.matrices.x)
    for node in dict.fromkeys(entry.of for entry in labels.x if is_shown(entry)):
        indices = labels.coordinates(node)
        if constrained.isdisjoint(indices):
            continue
        values = reactions[indices]
        # The dual of Euler parameters is 2 Lbar^T M and Lbar Lbar^T = I, so M = Lbar f / 2, and rates are 2 Lbar.
        by_node[node] = (rates_on_host(x[indices]) @ values / 4 if len(indices) == 4 else values).tolist()
    return by_node


def equilibrium_answers(lin: Linearization) -> dict[str, Any]:
    """Answers about a static equilibrium."""
    return {**configuration_answers(lin), **matrix_answers(lin), "stable": _rests(lin)}


def _rests(lin: Linearization) -> bool:
    """Whether the state is stable: by its stiffness; if that is unsymmetric, also by motions that grow."""
    stiffness, m = _stiffness(lin), lin.matrices
    if m.symmetric:
        return bool(_is_stable(stiffness))
    # A motion without mass loses its stability where the determinant changes sign.
    is_stable = np.linalg.slogdet(stiffness)[0] > 0
    return bool(is_stable and without_growth(stiffness, np.asarray(m.C0) + np.asarray(m.D0), np.asarray(m.M0)))


def _stiffness(lin: Linearization) -> np.ndarray:
    """Whole stiffness, (n_q, n_q), added on the host: JAX compiles a program to add."""
    m = lin.matrices
    return np.asarray(m.K0) + np.asarray(m.N0) + np.asarray(m.G0)


@jit
def _is_stable(stiffness: Any) -> Any:
    """Whether a stiffness matrix, (n_q, n_q), is positive definite; one program, not one for each operation."""
    return is_positive_definite((stiffness + stiffness.T) / 2)


def configuration_answers(lin: Linearization) -> dict[str, Any]:
    """Coordinates, deformations, stress resultants, reactions and the largest stress."""
    labels, m = lin.labels, lin.matrices
    return {
        "x": by_owner(m.x, labels.x),
        "e": by_owner(m.e, labels.e),
        "sig": by_owner(m.sigma, labels.e),
        "reactions": reactions(lin),
        **_stress(lin),
    }


def _stress(lin: Linearization) -> dict[str, Any]:
    """Largest von Mises stress and its place, of the flexible elements whose sections have a shape."""
    if not has_stress(lin.model):
        return {}
    with heard():
        stress_result = stress(lin.model, at=lin)
    element, place, *_ = stress_result.where
    used = {} if stress_result.strength is None else {"utilisation": float(np.max(stress_result.utilisation))}
    left_out = {"left_out": list(map(number, stress_result.left_out))} if stress_result.left_out else {}
    largest = {"maximum": float(stress_result.maximum), "element": number(element), "place": place, **used, **left_out}
    return {"stress": largest}


def matrix_answers(lin: Linearization) -> dict[str, Any]:
    """The matrices of the linearised equations."""
    return {name.lower(): np.asarray(getattr(lin.matrices, name)) for name in ("M0", "C0", "D0", "K0", "N0", "G0")}


def pole_answers(lin: Linearization, always: bool) -> dict[str, Any]:
    """Poles, real and imaginary parts."""
    damped = np.any(np.asarray(lin.matrices.C0) + np.asarray(lin.matrices.D0))
    if not (always or damped or not lin.matrices.symmetric):
        return {}
    return {"poles": [[p.real, p.imag] for p in poles(lin).tolist()]}


def compliance_answers(lin: Linearization) -> dict[str, list[float]]:
    """Directional compliance of each node, infinite (null in JSON) if it takes part in a free motion."""
    node_names = {entry.of for entry in lin.labels.x if is_shown(entry)}
    return {node: values.tolist() for node, values in directional_compliance(lin).items() if node in node_names}


def shapes(columns: ArrayLike, labels: Labels) -> list[dict[str, list[float]]]:
    """Motions by node."""
    return [by_owner(column, labels.x) for column in np.asarray(columns).T]


def hertz_of(values: ArrayLike, hertz: ArrayLike) -> list[float | None]:
    """Frequencies, None where the eigenvalue is negative."""
    return [None if v < 0 else f for v, f in zip(np.asarray(values).tolist(), np.asarray(hertz).tolist(), strict=True)]


def loose_warnings(lin: Linearization) -> list[str]:
    """Warnings of degrees of freedom that nothing holds."""
    m = lin.matrices
    magnitudes = np.abs(_stiffness(lin))
    stiffness, coupled = np.diag(magnitudes), np.max(magnitudes, axis=1, initial=0.0)
    largest = max(stiffness.max(initial=0.0), np.abs(np.asarray(m.S)).max(initial=0.0))
    return [
        f"Degree of freedom {name} has neither stiffness nor load: nothing holds it."
        for name, c in zip(lin.model.q_labels, coupled, strict=True)
        if c <= NO_STIFFNESS * largest
    ]


def row(values: ArrayLike, digits: int = 6) -> str:
    """Numbers in a line."""
    return "  ".join(f"{v:.{digits}g}" for v in np.ravel(np.asarray(values, float)).tolist())


def numbered_lines(texts: list[str]) -> list[str]:
    """Numbered lines of the terminal, at most the first twelve."""
    more = len(texts) - SHOWN_VALUES
    lines = [f"  {i + 1:3d}  {text}" for i, text in enumerate(texts[:SHOWN_VALUES])]
    return [*lines, f"  ... {more} more"] if more > 0 else lines


def matrix(name: str, values: ArrayLike) -> list[str]:
    """Lines of the terminal with a matrix, or with its size if it is large."""
    values = np.atleast_2d(np.asarray(values, float))
    if max(values.shape, default=0) > SHOWN_VALUES:
        return [f"{name}: {values.shape[0]} x {values.shape[1]}, see --json or --save"]
    return [f"{name}:", *("  " + "  ".join(f"{v:12.5g}" for v in row) for row in values.tolist())]
