"""Finds and names motions without stiffness, without mass or with negative mass, and elements that are too stiff."""

import contextlib
from collections.abc import Iterator

import jax
import jax.numpy as jnp
import numpy as np

from ..arguments import is_concrete, undifferentiated
from ..checks.mobility import allowed_motions, constraints, shares
from ..errors import AnalysisError
from ..math.by_deformations import motions_from_free
from ..math.element_matrices import AssembledEquations
from ..math.linear import unit_scale
from ..math.sparse import unresisted
from ..math.subspace import dense
from ..mechanics.deformation import jacobian_pieces
from ..mechanics.inertia import mass_matrix
from ..mechanics.stress_resultants import known_stiffness_pieces
from ..model.model import Model
from ..model.topology import coordinate_scales
from ..numerical_limits import FREE_STIFFNESS, NEGLIGIBLE, NO_MASS, SEMIDEFINITE
from ..results import RESULTS
from .linearize import Linearization, Matrices
from .spectrum import masses_of_motions

TINY = np.finfo(float).tiny


def moving_names(model: Model, motions: np.ndarray) -> str:
    """Names of the coordinates that move most in each motion, one motion a column, (n_x, k)."""
    names = []
    for motion in motions.T:
        largest = shares(motion / np.max(np.abs(motion), initial=np.finfo(float).tiny), model.labels.x)[:4]
        names.append(", ".join(f"{s.of}.{s.symbol} ({s.share:.2g})" for s in largest))
    return "; ".join(names)


def free_motions(m: Matrices) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Inverse of K on the other motions, free motions (n_q, k), and forces of springs that each hold one, (n_q, k).

    By singular values of K, with each degree of freedom scaled by the stiffnesses at it.
    """
    k, dfe = np.asarray(m.K), np.abs(np.asarray(m.DFe))
    if not np.all(np.isfinite(k)):
        raise AnalysisError("not_finite", RESULTS.not_finite.message)
    meeting = np.diag(dfe.T @ np.abs(np.asarray(m.S)) @ dfe) + np.abs(np.diag(k))
    scale = unit_scale(meeting)
    left_vectors, sizes, right_vectors = np.linalg.svd(k * scale[:, None] * scale)
    stiff = sizes > FREE_STIFFNESS * len(k) * max(1.0, np.max(sizes, initial=0.0))
    inverse = right_vectors[stiff].T @ (left_vectors[:, stiff] / sizes[stiff]).T
    free = right_vectors[~stiff].T
    return inverse * scale[:, None] * scale, free * scale[:, None], free / scale[:, None]


def takes_part(rows: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Whether directions, (k, n_q), take part in any of some motions, (k,)."""
    return np.any(np.abs(rows @ free) > NEGLIGIBLE * (np.abs(rows) @ np.abs(free)), axis=1)


def negative_mass(lin: Linearization) -> str:
    """Coordinates of negative mass in a motion of negative mass, at the first time with one; or empty."""
    m = lin.matrices
    mass = np.asarray(m.M0)
    if not mass.size:
        return ""
    if mass.ndim > 2:
        wrong = next((i for i, at_time in enumerate(mass) if _is_negative(at_time)), None)
        return "" if wrong is None else negative_mass(lin.at_time(wrong))
    if not _is_negative(mass):
        return ""
    _, motions = masses_of_motions(mass)
    motion = np.asarray(m.DFx) @ motions[:, 0]
    share = motion * (np.asarray(mass_matrix(lin.model.topology, lin.model.parameters, m.x)) @ motion)
    negative = [i for i in np.argsort(share) if share[i] < 0][:4]
    return ", ".join(str(lin.labels.x[i]) for i in negative) or moving_names(lin.model, motion[:, None])


def _is_negative(mass: np.ndarray) -> bool:
    """Whether a motion has a negative mass."""
    values, _ = masses_of_motions(mass)
    return bool(values[0] < -SEMIDEFINITE)


def refuse_negative_mass(lin: Linearization) -> None:
    """Raise singular_mass with names if the known mass matrix has a negative eigenvalue."""
    known = undifferentiated(lin)
    if is_concrete(known) and (names := negative_mass(known)):
        raise AnalysisError("singular_mass", f"{RESULTS.singular_mass.message} {negative_mass_note(names)}")


def negative_mass_note(names: str) -> str:
    """Sentence of a message."""
    return f"Here a motion has a negative mass, that of {names}."


def without_mass(model: Model) -> str:
    """Sentence on motions of the undeformed mechanism without mass; empty if there is none or numbers are traced."""
    model = undifferentiated(model)
    if not is_concrete(model):
        return ""
    motions = dense(allowed_motions(model)[0]) * constraints(model).columns[:, None]
    mass = np.asarray(mass_matrix(model.topology, model.parameters, model.parameters.reference))
    values, vectors = np.linalg.eigh(motions.T @ mass @ motions)
    light = values <= NO_MASS * max(np.max(np.abs(values), initial=0.0), np.finfo(float).tiny)
    return f"Motions without mass: {moving_names(model, motions @ vectors[:, light])}." if np.any(light) else ""


def without_anything(lin: Linearization, *, damped: bool = True) -> str:
    """Sentence on motions with neither mass nor stiffness, nor damping unless ``damped``, with a remedy; or empty."""
    # On the host from the start: within another program JAX would trace sums of its arrays.
    m = jax.tree.map(np.asarray, lin.matrices)
    _, free, _ = free_motions(m)
    # Scale each motion to a mass of one, without cancellation.
    sizes = np.sqrt(_uncancelled(free, m.M0))
    free = free / np.where(sizes > 0, sizes, 1.0)
    resistance = free.T @ m.M0 @ free
    if not damped:
        damping = m.C0 + m.D0
        resistance = resistance + free.T @ damping @ free / max(np.max(_uncancelled(free, damping), initial=0.0), TINY)
    shares, combinations = np.linalg.eigh((resistance + resistance.T) / 2)
    light = free @ combinations[:, shares <= NO_MASS]
    if not light.size:
        return ""
    moving = moving_names(lin.model, np.asarray(m.DFx) @ light)
    return (
        f"Here that is {moving}. It has no mass either. Give it a mass or an inertia (sections have rotary inertia"
        " unless rotary=False), or fix it."
    )


def _uncancelled(motions: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """A quadratic form of each motion, as if all its terms had one sign, (k,)."""
    return np.sum(np.abs(motions) * (np.abs(matrix) @ np.abs(motions)), axis=0)


def refuse_without_anything(lin: Linearization, *, damped: bool = True) -> None:
    """Raise singular_stiffness with names of motions of one state with neither mass nor stiffness, nor damping."""
    lin = undifferentiated(lin)
    m = lin.matrices
    if not is_concrete(m) or np.ndim(m.K0) != 2 or not np.size(m.K0):
        return
    about = without_anything(lin, damped=damped)
    if about:
        raise AnalysisError("singular_stiffness", f"{RESULTS.singular_stiffness.message} {about}")


def stiffest_element_note(model: Model) -> str:
    """Sentence on the stiffest element, by motions of the mechanism's extent and radians."""
    topology, parameters = model.topology, model.parameters
    sizes, size, stiff = coordinate_scales(topology, parameters), np.zeros(topology.n_e), np.zeros(topology.n_e)
    for at, columns, rows in jacobian_pieces(topology, parameters, parameters.reference, jnp.zeros(topology.n_e))[1]:
        size[at] = np.linalg.norm(np.asarray(rows) * sizes[columns][:, None, :], axis=2)
    for at, _, matrices in known_stiffness_pieces(topology, parameters):
        np.maximum.at(stiff, np.asarray(at), np.abs(np.einsum("eii->ei", np.asarray(matrices))))
    stiff[np.asarray(topology.e.held)] = 0.0
    return f"Here the stiffest is '{model.labels.e[int(np.argmax(stiff * size**2))].of}'."


def unresisted_note(lin: Linearization) -> str:
    """Sentence on the motion that a singular stiffness does not resist; empty if constraints are redundant."""
    elements = jax.tree.map(np.asarray, lin.elements)
    assembled = AssembledEquations(elements)
    motion = unresisted(assembled.at(), assembled.n)
    if motion is None:
        return ""
    return f"Here that is {moving_names(lin.model, motions_from_free(elements, motion[:, None]))}."


@contextlib.contextmanager
def naming_culprit(lin: Linearization) -> Iterator[None]:
    """Context whose errors name the motion that a singular stiffness frees, or an element that is too stiff."""
    try:
        yield
    except AnalysisError as fault:
        about, lin = "", undifferentiated(lin)
        if not is_concrete(lin):
            raise
        if fault.code == RESULTS.lost_in_round_off.name:
            about = stiffest_element_note(lin.model)
        elif fault.code == RESULTS.singular_stiffness.name and lin.large:
            about = unresisted_note(lin)
        if not about:
            raise
        raise AnalysisError(fault.code, f"{fault} {about}") from None
