"""Functions of several eigenvalues that stay smooth where eigenvalues meet, and modes identified by their shape."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..arguments import check_number, check_numbers, check_real, check_whole, is_concrete, numbers, short_repr
from ..display import kind_of
from ..mechanics.loads import LoadFactors, lacks_potential, warn_of_increment
from ..mechanics.prepared import kernel
from ..model.model import Model, as_determined
from ..model.topology import Parameters, Topology
from ..numerical_limits import ONE_CLUSTER
from ..results import RESULTS, or_nan
from .linearize import Matrices, matrices
from .modes import Modes, check_spectrum, refuse_unsymmetric
from .spectrum import spectrum, to_frequency


def smooth_minimum(values: Float[Array, "n"], sharpness: float = 50.0) -> Float[Array, ""]:
    """Return the lower estimate (sum of v^-p)^(-1/p) of the minimum of positive values, smooth where several are equal.

    The estimate lies between n^(-1/p) times the minimum and the minimum. It is a symmetric function of the values, and
    therefore has a first derivative where eigenvalues or load multipliers are repeated.

    Args:
        values: Positive numbers, which may be infinite, (n,).
        sharpness: p, () [-].

    Returns:
        () [unit of the values].

    Raises:
        ValueError: A value is not positive, or the sharpness is below 1.

    Source:
        Norms of order -p; spectral functions are as smooth as they are symmetric: Lewis 1996, Math. Oper. Res. 21.
    """
    values = _positive("smooth_minimum", values, sharpness)
    least = jax.lax.stop_gradient(jnp.min(values))
    ratios = jnp.where(jnp.isfinite(values), values, 1.0) / least
    total = jnp.sum(jnp.where(jnp.isfinite(values), ratios ** (-sharpness), 0.0))
    return least * total ** (-1 / sharpness)


def smooth_maximum(values: Float[Array, "n"], sharpness: float = 50.0) -> Float[Array, ""]:
    """Return the upper estimate (sum of v^p)^(1/p) of the maximum of positive values.

    It is at most n^(1/p) times the maximum.

    Args:
        values, sharpness: As for :func:`smooth_minimum`, values finite.

    Returns:
        () [unit of the values].

    Raises:
        ValueError: As :func:`smooth_minimum`.

    Source:
        As :func:`smooth_minimum`.
    """
    values = _positive("smooth_maximum", values, sharpness)
    largest = jax.lax.stop_gradient(jnp.max(values))
    return largest * jnp.sum((values / largest) ** sharpness) ** (1 / sharpness)


def _positive(name: str, values: Any, sharpness: Any) -> Float[Array, "n"]:
    """Several positive values as an array."""
    check_number("sharpness", sharpness, least=1)
    check_real(f"Argument `values` of {name}", values)
    concrete = is_concrete(values)
    if concrete and (numbers(values) is None or np.ndim(values) != 1 or not np.size(values)):
        raise ValueError(f"Argument `values` of {name} must be several numbers, not {short_repr(values)}.")
    if concrete and not np.all(np.asarray(values) > 0):
        raise ValueError(f"Argument `values` of {name} must be positive, but is {np.asarray(values)}.")
    return jnp.asarray(values, float)


def mode_assurance(one: Modes, other: Modes) -> Float[np.ndarray, "n m"]:
    """Return the similarity of the modes of two states or designs.

    Args:
        one: Modes of a model.
        other: Modes of the same model, or of a model with other dimensions or degrees of freedom.

    Returns:
        (n, m) [-]: 1 for equal shapes, 0 for orthogonal shapes, in the mass and the degrees of freedom of ``one``.

    Raises:
        TypeError: An argument is no Modes, or has sparse matrices.
        ValueError: The models differ in nodes or elements.

    Source:
        Modal assurance criterion, Allemang, Brown 1982, weighted with M0.
    """
    for modes in (one, other):
        _check_modes(modes, "mode_assurance")
    a, b = (_shapes_in(one.lin.model, modes, "mode_assurance") for modes in (one, other))
    m = np.asarray(one.lin.matrices.M0)
    return (a.T @ m @ b) ** 2 / np.outer(np.sum(a * (m @ a), axis=0), np.sum(b * (m @ b), axis=0))


def _check_modes(modes: Any, function: str) -> None:
    """Refuse anything but modes in degrees of freedom."""
    if not isinstance(modes, Modes):
        raise TypeError(f"fm.linear.{function} needs Modes, of fm.modes(model), not {kind_of(modes)}.")
    if modes.lin.large:
        raise TypeError(f"fm.linear.{function} takes no modes by sparse matrices. Give fm.modes(model, sparse=False).")


def _shapes_in(model: Model, modes: Modes, function: str) -> Float[np.ndarray, "n_q n"]:
    """Shapes of modes in the degrees of freedom of a model."""
    of_modes, shapes = modes.lin.model, np.asarray(modes.q_shapes)
    if (of_modes.labels.x, of_modes.labels.e) != (model.labels.x, model.labels.e):
        raise ValueError(f"fm.linear.{function}: the models differ. Their nodes or elements have other names.")
    if of_modes.q_labels == model.q_labels:
        return shapes
    x, e = (np.asarray(roles.dof) for roles in (model.topology.x, model.topology.e))
    m = modes.lin.matrices
    return np.concatenate([np.asarray(m.DFx)[x], np.asarray(m.DFe)[e]]) @ shapes


def follow_modes(one: Modes, other: Modes) -> Int[np.ndarray, "n"]:
    """Return, for each mode of a state, which mode of another state has the matching shape.

    Args:
        one, other: As for :func:`mode_assurance`.

    Returns:
        (n,) [-]: number, from 0, of the mode in ``other`` that continues each mode of ``one``; -1 if ``other`` has
            fewer.

    Raises:
        TypeError, ValueError: As :func:`mode_assurance`.

    Source:
        Assignment of the largest sum of :func:`mode_assurance` (Kuhn 1955).
    """
    import scipy.optimize

    assurance = mode_assurance(one, other)
    rows, columns = scipy.optimize.linear_sum_assignment(assurance, maximize=True)
    numbers = np.full(len(assurance), -1)
    numbers[rows] = columns
    return numbers


def frequency_like(
    model: Model, shape: Modes | Float[Array, "n_q"], number: int | None = None, *, throw: bool = True
) -> Float[Array, ""]:
    """Return the frequency of the mode most similar to a given shape, also past crossings of frequencies.

    If other modes have the same frequency, flexmb projects the shape onto the common space of these modes. The
    derivative belongs to the mode that continues this shape. Only the first derivative is right.

    Args:
        model: Mechanism; differentiable in ``model.parameters``.
        shape: Modes of a design such as ``fm.modes(start)``, in any degrees of freedom; or one shape in the degrees of
            freedom of the model, (n_q,). In this case name the degrees of freedom: flexmb may choose others in another
            design.
        number: Number of the mode, from 0, if Modes are given.
        throw: Raise if the equilibrium or the eigenproblem fails.

    Returns:
        () [Hz]; negative if the motion grows.

    Raises:
        ValueError: The shape and the degrees of freedom differ in number; the number of the mode is wrong or missing;
            the Modes belong to a model with other nodes or elements.
        AnalysisError: The equilibrium was not found, or a motion has neither mass nor stiffness.

    Source:
        :func:`mode_assurance`; Rayleigh's quotient, stationary at a mode.
    """
    warn_of_increment(as_determined(model, "frequency_like"), "frequency_like")
    refuse_unsymmetric(not lacks_potential(model.topology))
    vector: Any = shape
    if isinstance(shape, Modes):
        _check_modes(shape, "frequency_like")
        every = _shapes_in(model, shape, "frequency_like")
        if number is None or not check_whole("number", number, 0) < every.shape[1]:
            raise ValueError(
                f"Argument `number` of fm.linear.frequency_like must be the number of one of the {every.shape[1]}"
                f" modes, from 0, but is {short_repr(number)}."
            )
        vector = every[:, number]
    elif number is not None:
        raise ValueError("Argument `number` of fm.linear.frequency_like needs Modes as `shape`, not numbers.")
    check_numbers("Argument `shape`", vector)
    if np.shape(vector) != (model.topology.n_q,):
        raise ValueError(f"Argument `shape` must have {model.topology.n_q} entries, but has shape {np.shape(vector)}.")
    if is_concrete(vector) and not np.any(np.asarray(vector)):
        raise ValueError("Argument `shape` must have an entry that is not zero.")
    value, result = _frequency_like(model.topology, model.parameters, jnp.asarray(vector, float))
    check_spectrum(result, throw, model)
    return or_nan(value, result, throw)


@kernel
def _frequency_like(topology: Topology, parameters: Parameters, shape: Float[Array, "n_q"]):
    m: Matrices = matrices(topology, parameters, LoadFactors(1.0, 0.0))
    values, vectors, _, result = spectrum(m.K, m.M0)
    parts = jax.lax.stop_gradient(vectors.T @ (m.M0 @ shape))
    # Massless motions have no vector.
    parts = jnp.where(jnp.isfinite(values), parts, 0.0)
    best = jnp.argmax(jnp.abs(parts))
    finite = jnp.where(jnp.isfinite(values), values, 0.0)
    together = (jnp.abs(finite - finite[best]) <= ONE_CLUSTER * jnp.abs(finite[best])) & jnp.isfinite(values)
    mode = jax.lax.stop_gradient(vectors @ jnp.where(together, parts, 0.0))
    quotient = (mode @ (m.K @ mode)) / (mode @ (m.M0 @ mode))
    value = jnp.where(jnp.sum(together) > 1, quotient, finite[best])
    return to_frequency(value[None])[0], jnp.where(m.result == RESULTS.successful, result, m.result)
