"""Responses to harmonic inputs: complex, by frequency, output and input, with derivatives."""

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float

from ..arguments import as_known, check_choice, check_numbers, is_concrete, library_of, shown, undifferentiated
from ..compilation.compile import jit, unguarded
from ..compilation.record import Record, static
from ..display import Result, Summary, listed, short, span
from ..errors import ModelError, clean, warn
from ..linear.about import Where, by_elements, linearized
from ..linear.damping import Losses, loss_factors
from ..linear.linearize import Linearization, ManyStates, Matrices
from ..linear.loose import refuse_negative_mass
from ..linear.modes import check_spectrum, refuse_unsymmetric
from ..linear.spectrum import shift_to_definite
from ..math.linear import diagonal_of, pencil
from ..mechanics.loads import lacks_potential
from ..model.model import Model
from ..results import RESULTS, collect, or_nan
from ..statics.stable import is_unstable, unstable_motions
from .second_order_form import SecondOrder, second_order
from .sparse_response import responses
from .sparse_second_order import lossy_elements, some_of, sparse_second_order
from .state_space import refuse_idle_inputs

# Damping couples two modes where what is between them is above this share of the mean of their own, or, beside it, of
# the largest there is: both are far above round-off and far below what an answer would show.
COUPLED, ROUND_OFF = 1e-8, 1e-14
# A resonance is hit where all that is left of stiffness less inertia is so many round-offs of them.
HIT = 16 * float(np.finfo(float).eps)
# A mode has no part in a response where it is below this share of the largest part that any has.
NO_PART = 1e-12
# Modes whose frequencies squared are nearer than this, relatively, are not told apart.
NEAR = 1e-9
# Nor are those that a step of Newton's method turns by more than this into each other: round-off does.
TURN = 1e-5


class FrequencyResponse(Result, Record):
    """Complex response of outputs to harmonic inputs, y = H(i 2 pi f) u, by frequency and by names.

    Attributes:
        hertz: Frequencies, (n_f,) [Hz].
        response: H, (n_f, n_y, n_u) [unit of the output over that of the input].
        outputs: Names of the outputs.
        inputs: Names of the inputs.
    """

    hertz: Float[Array, "n_f"]
    response: Complex[Array, "n_f n_y n_u"]
    outputs: tuple[str, ...] = static()
    inputs: tuple[str, ...] = static()
    one_axis = "hertz"

    def of(self, output: str | None = None, input: str | None = None) -> Complex[Array, "n_f"]:
        """Response of one output to one input.

        Args:
            output: Name of the output; may be left out where there is one.
            input: Name of the input likewise.

        Returns:
            (n_f,) [unit of the output over that of the input].

        Raises:
            KeyError: There is no such output or input, or several and none is named.
        """
        i, j = one_of("output", self.outputs, output), one_of("input", self.inputs, input)
        return self.response[..., i, j]

    def magnitude(self, output: str | None = None, input: str | None = None) -> Float[Array, "n_f"]:
        """Amplitude of one output by that of one input.

        Args:
            output: As of :meth:`of`.
            input: As of :meth:`of`.

        Returns:
            (n_f,) [unit of the output over that of the input].
        """
        return jnp.abs(self.of(output, input))

    def phase(self, output: str | None = None, input: str | None = None) -> Float[Array, "n_f"]:
        """Phase by which one output leads one input, without jumps of a full turn from one frequency to the next.

        Args:
            output: As of :meth:`of`.
            input: As of :meth:`of`.

        Returns:
            (n_f,) [rad]; it begins between -pi and pi.
        """
        return jnp.unwrap(jnp.angle(self.of(output, input)))

    def summary(self) -> Summary:
        """Frequencies, names, and where each response is largest."""
        hertz, sizes = np.asarray(self.hertz), np.abs(np.asarray(self.response))
        rows = {"frequencies": f"{len(hertz)}, {span(hertz, 'Hz')}"}
        rows |= {"outputs": listed(self.outputs), "inputs": listed(self.inputs)}
        for j, source in enumerate(self.inputs):
            for i, output in enumerate(self.outputs):
                most = int(np.argmax(sizes[:, i, j]))
                if sizes[most, i, j] > 0:
                    text = f"at most {short(sizes[most, i, j])}, at {short(hertz[most])} Hz"
                    rows[f"{output} by {source}"] = text
        title = f"FrequencyResponse: {len(self.outputs)} x {len(self.inputs)} at {len(hertz)} frequencies"
        return Summary(title, rows, "bode", {} if len(self.outputs) * len(self.inputs) == 1 else None)


def one_of(kind: str, known: Sequence[str], name: str | None) -> int:
    """Which of some names one is; a blank stands for a dot, as in names of python-control.

    Args:
        kind: What is named, for the message.
        known: The names.
        name: One of them; None where there is but one.

    Raises:
        KeyError: There is none, or several and none is named.
    """
    if name is None and len(known) == 1:
        return 0
    if isinstance(name, str):
        for i, own in enumerate(known):
            if name in (own, own.replace(".", " ")):
                return i
    asked = "Say which" if name is None else f"There is no {kind} '{clean(name)}'"
    raise KeyError(f"{asked}: the {kind}s are {', '.join(known)}.")


def places_of(kind: str, known: Sequence[str], wanted: Sequence[str] | str | None) -> list[int]:
    """Which of some names are wanted, in the order in which they are wanted; all of them unless said.

    Raises:
        KeyError: There is none of a name.
        ModelError: There are no names at all.
        TypeError: What is wanted is neither a name nor a list.
    """
    if not known:
        raise ModelError(f"A response needs an {kind}: name it with {kind}() of the builder.")
    if wanted is None:
        return list(range(len(known)))
    if not isinstance(wanted, Iterable):
        raise TypeError(f"Argument `{kind}s` must be a name or a list of names, not {shown(wanted)}.")
    found = [one_of(kind, known, name) for name in ([wanted] if isinstance(wanted, str) else wanted)]
    if not found or len(set(found)) < len(found):
        raise ValueError(f"Argument `{kind}s` must name {kind}s, each once. There are: {', '.join(known)}.")
    return found


def check_hertz(hertz: Any) -> Float[Array, "n_f"]:
    """Frequencies as an array.

    Raises:
        ValueError: They are no finite numbers that are not negative, or have more than one axis.
    """
    check_numbers("Argument `hertz`", hertz)
    if np.ndim(hertz) > 1:
        raise ValueError(f"Argument `hertz` must be frequencies, (n_f,), but has shape {np.shape(hertz)}.")
    if is_concrete(hertz) and np.any(np.asarray(hertz) < 0):
        raise ValueError(f"Argument `hertz` cannot be negative, but is at least {np.min(np.asarray(hertz)):g}.")
    return np.atleast_1d(np.asarray(hertz, float)) if is_concrete(hertz) else jnp.atleast_1d(hertz)  # type: ignore


@unguarded
def frequency_response(
    model: Model | Linearization,
    hertz: Float[Array, "n_f"] | Sequence[float] | float,
    *,
    inputs: Sequence[str] | str | None = None,
    outputs: Sequence[str] | str | None = None,
    loss_factor: Losses | None = None,
    method: str | None = None,
    sparse: bool | None = None,
    at: Linearization | ManyStates | None = None,
    step: int | None = None,
    time: float | None = None,
    increment: float | None = None,
) -> FrequencyResponse:
    """Response of the outputs to harmonic inputs, at thousands of frequencies in one go.

    Damping is that of the elements, or what :func:`flexmb.damped` states, and structural damping, which only a response
    by frequency can have as it is. Motions without mass follow at once, with their damping. About a state of motion the
    response is that of the equations there, taken as constant.

    Args:
        model: Mechanism, or its linearisation; differentiable in its parameters, also where frequencies are repeated.
        hertz: Frequencies, (n_f,) [Hz]; differentiable.
        inputs: Names of the inputs wanted; all unless given.
        outputs: Names of the outputs wanted; all unless given.
        loss_factor: Structural damping K0 (1 + i eta), at all frequencies and at 0 Hz too: one loss factor eta [-] for
            all elements, or by name or Material, as :func:`flexmb.damped` takes them.
        method: "modes" for a sum over all undamped modes, which costs next to nothing for each frequency where damping
            does not couple them, and otherwise solves for their amplitudes; "direct" for a solution in the degrees of
            freedom at each frequency. Both are exact but for round-off: where the contributions of many modes cancel,
            as in an internal stress by an internal actuator far below the resonances, "direct" keeps more digits.
            "modes" unless given, and "direct" where there are no modes: of an unsymmetric stiffness, about a state of
            motion, and by sparse matrices.
        sparse: By a solution with sparse matrices at each frequency, in all coordinates of a model that needs no
            degrees of freedom; see :func:`flexmb.equilibrium` for what these take. Chosen by size unless given.
        at: Path, Motion or Linearization of the model, about a state of which it is asked in place of an equilibrium.
        step: Number of the state of a path or a motion, from 0; -1 for the last.
        time: Time of the state of a motion, one of its output times [s].
        increment: Factor of the incremental loads of the equilibrium, () [-]; zero unless given.

    Returns:
        FrequencyResponse with the complex response (n_f, n_y, n_u) [SI]. Infinite where a resonance without damping is
        hit exactly, as that of a free body at 0 Hz.

    Raises:
        KeyError: There is no such input or output.
        ModelError: The model names no inputs or no outputs, or an input that moves nothing.
        ValueError: A frequency that is negative or not finite; a loss factor of what has no stiffness.
        NotImplementedError: ``method="modes"``, and an unsymmetric stiffness or a motion gives none.
        AnalysisError: The equilibrium was not found, or a motion has neither mass nor stiffness, or a negative mass.

    Warns:
        FlexmbWarning: A response is infinite, or the equilibrium is not stable.

    Source:
        THEORY.md 14, eq. (14.30) and (14.31); its derivative (14.32); of sparse matrices 7, eq. (7.15) and (7.18).
    """
    check_choice("method", method, (None, "modes", "direct"))
    frequencies = check_hertz(hertz)
    where = Where(at, step, time, increment)
    large = by_elements(model, "frequency_response", where, sparse, few=method != "modes")
    if large is not None:
        if method == "modes":
            raise NotImplementedError('Sparse matrices give no sum over all modes: leave out method="modes".')
        found = _response_of_large(large, frequencies, inputs, outputs, loss_factor)
        if is_concrete((large, found)):
            _tell_of_infinite(found)
            elements = jax.tree.map(np.asarray, large.elements)
            _tell_of_unstable(is_unstable(elements, not lacks_potential(large.model.topology)))
        return found
    lin = linearized(model, "frequency_response", where=where)
    found = response_of(lin, frequencies, inputs, outputs, loss_factor, method)
    if is_concrete((lin, found)):
        _tell_of_infinite(found)
        m = lin.matrices
        _tell_of_unstable(m.moving is None and unstable_motions(m.K0 + m.G0, m.K0, m.symmetric).shape[1] > 0)
    return found


def response_of(
    lin: Linearization, hertz: Float[Array, "n_f"], inputs: Any, outputs: Any, losses: Any, method: str | None
) -> FrequencyResponse:
    """As :func:`frequency_response`, of a linearisation, without a warning."""
    m, labels = lin.matrices, lin.labels
    us = places_of("input", [s.name for s in labels.inputs], inputs)
    ys = places_of("output", [s.name for s in labels.outputs], outputs)
    rests = m.symmetric and m.moving is None
    if method == "modes":
        refuse_unsymmetric(m.symmetric)
        if not rests:
            raise NotImplementedError('About a state of motion there are no real modes: leave out method="modes".')
    whole = second_order(lin)
    refuse_negative_mass(lin)
    known = undifferentiated((lin, whole))
    if is_concrete(known):
        refuse_idle_inputs(*known)
    whole, orders = plain(whole)
    _check_rest(hertz, [labels.inputs[j].name for j in us if orders[j]])
    lossy = None if losses is None else _with_losses(lin, loss_factors(lin, losses))
    by_modes = method != "direct" and rests
    found, result = _response(whole, lossy, hertz, us=tuple(us), ys=tuple(ys), orders=orders, by_modes=by_modes)
    check_spectrum(result, True, lin)
    found = or_nan(found, result)
    return FrequencyResponse(
        hertz, found, tuple(labels.outputs[i].name for i in ys), tuple(labels.inputs[j].name for j in us)
    )


def _response_of_large(
    lin: Linearization, hertz: Float[Array, "n_f"], inputs: Any, outputs: Any, losses: Any
) -> FrequencyResponse:
    """As :func:`response_of`, by sparse matrices."""
    labels = lin.labels
    us = places_of("input", [s.name for s in labels.inputs], inputs)
    ys = places_of("output", [s.name for s in labels.outputs], outputs)
    every = sparse_second_order(lin)
    whole, orders = some_of(every, us, ys), every.orders
    _check_rest(hertz, [labels.inputs[j].name for j in us if orders[j]])
    lossy = None
    if losses is not None:
        lossy = some_of(sparse_second_order(lin, lossy_elements(lin, loss_factors(lin, losses))), us, ys)
    w = 2 * np.pi * as_known(hertz)
    at_once = responses(whole, lossy, w)
    library = library_of(at_once)
    # What is infinite at a resonance stays so, whatever it is divided by; what is no number stays none.
    with np.errstate(invalid="ignore"):
        found = library.where(library.isinf(abs(at_once)), np.inf + 0j, integrated(at_once, w, whole.orders))
    return FrequencyResponse(
        hertz,
        jax.device_put(found),
        tuple(labels.outputs[i].name for i in ys),
        tuple(labels.inputs[j].name for j in us),
    )


def plain(whole: SecondOrder) -> tuple[SecondOrder, tuple[int, ...]]:
    """Second-order form with arrays alone, and beside it of which derivative of what is moved each input is."""
    none = np.zeros(0)
    return whole._replace(orders=none, moves=none), tuple(int(order) for order in whole.orders)


def _of(whole: SecondOrder, us: tuple[int, ...], ys: tuple[int, ...]) -> SecondOrder:
    """The same of some inputs and outputs."""
    u, y = np.array(us), np.array(ys)
    own = {f"B{i}": getattr(whole, f"B{i}")[:, u] for i in range(3)}
    own |= {f"C{i}": getattr(whole, f"C{i}")[y] for i in range(3)}
    return whole._replace(**own, **{f"D{i}": getattr(whole, f"D{i}")[y[:, None], u] for i in range(3)})


def _check_rest(hertz: Any, rates: list[str]) -> None:
    """Refuse a response at rest to what is a rate: it would have moved without bounds."""
    if rates and is_concrete(hertz) and np.any(np.asarray(hertz) == 0):
        raise ValueError(
            f"Argument `hertz`: at 0 Hz there is no response to '{rates[0]}', a velocity or an acceleration that would"
            " go on for ever. Leave that frequency out."
        )


def _tell_of_infinite(found: FrequencyResponse) -> None:
    """Warn of responses that are infinite, by the first."""
    infinite = np.argwhere(~np.isfinite(np.asarray(found.response)))
    if len(infinite):
        f, i, j = infinite[0]
        hertz = float(found.hertz[f])
        remedy = "Damp it (fm.damped, or `loss_factor`) or leave that frequency out."
        if hertz == 0:
            remedy = "A motion meets no stiffness: support it, or leave 0 Hz out."
        warn(
            f"The response of '{found.outputs[i]}' to '{found.inputs[j]}' is infinite at {hertz:.6g} Hz: a resonance"
            f" without damping is hit. {remedy}"
        )


def _tell_of_unstable(unstable: bool) -> None:
    """Warn of a response that no mechanism has by itself."""
    if unstable:
        collect(RESULTS.unstable_state)
        warn(
            "The equilibrium is not stable, as a negative frequency tells: the response is the transfer function there,"
            " which is measured only while a controller holds the mechanism. Lower the load, or ask about a stable"
            " state of fm.path."
        )


@jit
def _response(
    system: SecondOrder,
    lossy: tuple[SecondOrder, SecondOrder] | None,
    hertz: Float[Array, "n_f"],
    *,
    us: tuple[int, ...],
    ys: tuple[int, ...],
    orders: tuple[int, ...],
    by_modes: bool,
):
    """H(i 2 pi f), (n_f, n_y, n_u), and a code of RESULTS."""
    w = 2 * np.pi * hertz
    system = _of(system, us, ys)
    loss, of_loss = jnp.zeros_like(system.K), None
    if lossy is not None:
        # Geometric stiffness and inertia do not depend on the elements' stiffness: what is left is linear in it.
        with_it, without = (_of(own, us, ys) for own in lossy)
        of_loss = jax.tree.map(lambda one, other: one - other, with_it, without)
        loss = of_loss.K
    by_inputs, by_outputs, through = _polynomials(system, of_loss)
    parts = (system.M, system.C, system.K, loss)
    factors, found = _modal_factors(*parts) if by_modes else (None, jnp.array(True))
    responses = _transfer(factors, w, parts, by_inputs, by_outputs) + _at(w, through)
    responses = integrated(responses, w, np.asarray(orders)[np.array(us)])
    # What is divided by nothing is infinite; of a state that was not found nothing is a number.
    known = jnp.all(jnp.isfinite(system.M)) & jnp.all(jnp.isfinite(system.K))
    responses = jnp.where(jnp.isfinite(jnp.abs(responses)) | ~known, responses, jnp.inf + 0j)
    return responses, jnp.where(found, RESULTS.successful, RESULTS.singular_stiffness).astype(jnp.int32)


def integrated(responses: Complex[Array, "n_f n_y n_u"], w: Float[Array, "n_f"], orders: Any) -> Any:
    """Responses to inputs that are velocities or accelerations, of those to the displacements.

    Args:
        responses: To displacements and forces.
        w: Angular frequencies, (n_f,) [rad/s].
        orders: Which derivative of a displacement each input is, (n_u,); plain numbers.
    """
    for order in (1, 2):
        own = np.asarray(orders) == order
        if np.any(own):
            whole = responses / _powers(w)[order][:, None, None]
            responses = library_of((responses, w)).where(own, whole, responses)
    return responses


def _with_losses(lin: Linearization, losses: Float[Array, "n_e"]) -> tuple[SecondOrder, SecondOrder]:
    """Second-order forms with the stiffness of the elements times their loss factors, and with none.

    Their difference, in K, B0, C0 and D0, is what is lossy, to be taken i times.

    Args:
        lin: Linearization.
        losses: Loss factor of each deformation, (n_e,) [-].
    """
    m = lin.matrices
    lossy, k = _lossy(m, losses)
    none = {name: np.zeros(m.K0.shape) for name in ("M0", "C0", "D0", "K0", "N0", "G0")} | {"S_d": np.zeros(m.S.shape)}

    def of(**own: Any):
        return plain(second_order(Linearization(dataclasses.replace(m, **{**none, **own}), lin.model)))[0]

    return of(S=lossy, K0=k), of(S=np.zeros(m.S.shape))


@jit
def _lossy(m: Matrices, losses: Float[Array, "n_e"]):
    """Lossy stiffness of the elements and of the degrees of freedom."""
    lossy = (losses[:, None] * m.S + m.S * losses) / 2
    return lossy, m.DFe.T @ lossy @ m.DFe


def _polynomials(system: SecondOrder, lossy: SecondOrder | None) -> list[Complex[Array, "3 i j"]]:
    """What inputs do, outputs take, and takes outputs of inputs at once, by powers of i w from the lowest."""
    found = []
    for name in "BCD":
        own = jnp.stack([getattr(system, f"{name}{i}") for i in range(3)]).astype(complex)
        if lossy is not None:
            own = own.at[0].add(1j * getattr(lossy, f"{name}0").astype(complex))
        found.append(own)
    return found


def _powers(w: Float[Array, "n_f"], count: int = 3) -> Complex[Array, "count n_f"]:
    """Powers of i w, from the lowest."""
    turns = np.array([1, 1j, -1, -1j, 1])[:count]
    return library_of(w).stack([w**i for i in range(count)]).astype(complex) * turns[:, None]


def _at(w: Float[Array, "n_f"], polynomial: Complex[Array, "3 i j"]) -> Complex[Array, "n_f i j"]:
    """Polynomial of i w."""
    return jnp.einsum("pf,pij->fij", _powers(w), polynomial)


def _modal_factors(
    m: Float[Array, "n n"], c: Float[Array, "n n"], k: Float[Array, "n n"], loss: Float[Array, "n n"]
) -> tuple[Any, Any]:
    """Undamped modes W with W^T (K + s M) W = 1, what mass, damping and loss are between them, and whether there are.

    Scaled so, motions without mass are modes like others, with a mass of zero, and the sum has the whole flexibility.
    """
    m, c, k, loss = (jax.lax.stop_gradient(part) for part in (m, c, k, loss))
    shift, _, found = shift_to_definite(k, m)
    mu, vectors = _refined(m, k + shift * m, *pencil(m, k + shift * m))
    damping, losses = vectors.T @ c @ vectors, vectors.T @ loss @ vectors
    return (mu, shift * mu, vectors, damping, losses), found


def _refined(
    a: Float[Array, "n n"], b: Float[Array, "n n"], mu: Float[Array, "n"], vectors: Float[Array, "n n"]
) -> tuple[Any, Any]:
    """Eigenvalues and vectors of A w = mu B w after one step of Newton's method.

    As they are found they are known to round-off of the largest mu, of the slowest mode: here each to its own. What is
    left of products w_i^T B w_j, the square of how far the step turned, is taken off once more.

    Source:
        Ogita, Aishima (2018), Japan J. Industrial and Applied Mathematics 35, 1007, with B in place of the unit matrix.
    """
    of_a, of_b = vectors.T @ a @ vectors, vectors.T @ b @ vectors
    values = diagonal_of(of_a) / diagonal_of(of_b)
    gap = values[None, :] - values[:, None]
    apart = jnp.abs(gap) > NEAR * jnp.maximum(jnp.abs(values)[None, :], jnp.abs(values)[:, None])
    turned = jnp.where(apart, (of_a - values[None, :] * of_b) / jnp.where(apart, gap, 1.0), 0.0)
    # Modes of one frequency are as good in any directions, and so are those that round-off does not tell apart, as of
    # motions almost without mass: those stay.
    turned = jnp.where(jnp.maximum(jnp.abs(turned), jnp.abs(turned.T)) < TURN, turned, 0.0)
    vectors = vectors + vectors @ turned
    # Slow modes, the last ones, take the part of faster ones off, which moves them little; not the other way round.
    vectors = vectors - vectors @ jnp.triu(vectors.T @ b @ vectors, 1)
    of_a, of_b = jnp.sum(vectors * (a @ vectors), axis=0), jnp.sum(vectors * (b @ vectors), axis=0)
    return of_a / of_b, vectors / jnp.sqrt(of_b)


def _is_coupled(matrix: Float[Array, "n n"]) -> Any:
    own = jnp.abs(diagonal_of(matrix))
    allowed = COUPLED * jnp.sqrt(own[:, None] * own) + ROUND_OFF * jnp.max(own, initial=0.0)
    return jnp.any((jnp.abs(matrix) > allowed) & ~np.eye(len(matrix), dtype=bool))


@jax.custom_jvp
def _transfer(
    factors: tuple[Array, ...] | None,
    w: Float[Array, "n_f"],
    parts: tuple[Array, ...],
    by_inputs: Complex[Array, "3 n_q n_u"] | tuple[Array],
    by_outputs: Complex[Array, "3 n_y n_q"] | tuple[Array],
) -> Complex[Array, "n_f n_y n_u"]:
    """C(i w) (-w^2 M + i w C + K + i L)^-1 B(i w).

    Args:
        factors: As of :func:`_modal_factors`; None for solutions in the degrees of freedom.
        w: Angular frequencies, (n_f,) [rad/s].
        parts: M, C, K and L.
        by_inputs: B by powers, (3, n_q, n_u), or one matrix for each frequency, (n_f, n_q, n_u), in a tuple.
        by_outputs: C likewise.

    Source:
        THEORY.md 14, eq. (14.30), by modes (14.31).
    """
    if factors is None:
        m, c, k, loss = parts
        # Each freedom in a unit that makes its own stiffness one.
        own = jnp.abs(diagonal_of(k))
        scale = 1 / jnp.sqrt(jnp.where(own > 0, own, 1.0))
        m, c, k, loss = (part * scale[:, None] * scale for part in (m, c, k, loss))
        units = scale.astype(complex)
        right, left = _expanded(w, by_inputs) * units[:, None], _expanded(w, by_outputs) * units
        return _solved_each(w, k, m, c, loss, right, left)
    mu, shifted, vectors, damping, losses = factors
    vectors = vectors.astype(complex)
    coupled = _is_coupled(damping) | _is_coupled(losses)

    def summed():
        return _sum_over_modes(w, factors, by_inputs, by_outputs)

    def solved():
        right, left = (_expanded(w, of) for of in (by_inputs, by_outputs))
        stiffness, mass = jnp.diag(1 - shifted), jnp.diag(mu)
        return _solved_each(w, stiffness, mass, damping, losses, vectors.T @ right, left @ vectors)

    return jax.lax.cond(coupled, solved, summed)


def _expanded(w: Float[Array, "n_f"], given: Complex[Array, "3 i j"] | tuple[Array]):
    """One matrix for each frequency, of a polynomial or of what is so already."""
    return given[0] if isinstance(given, tuple) else _at(w, given)


def _sum_over_modes(
    w: Float[Array, "n_f"],
    factors: tuple[Array, ...],
    by_inputs: Complex[Array, "3 n_q n_u"] | tuple[Array],
    by_outputs: Complex[Array, "3 n_y n_q"] | tuple[Array],
):
    mu, shifted, vectors, damping, losses = factors
    vectors = vectors.astype(complex)
    column = w[:, None]
    inverse = jax.lax.complex(1 - shifted - column**2 * mu, column * diagonal_of(damping) + diagonal_of(losses))
    hit = jnp.abs(inverse) <= HIT * (1 + shifted + column**2 * mu)
    gains = jnp.where(hit, 0.0, 1 / jnp.where(hit, 1.0, inverse))
    if isinstance(by_inputs, tuple) or isinstance(by_outputs, tuple):
        right, left = vectors.T @ _expanded(w, by_inputs), _expanded(w, by_outputs) @ vectors
        return left @ (gains[:, :, None] * right)
    right, left = vectors.T @ by_inputs, by_outputs @ vectors
    # Of each mode, output and input by powers of i w: then one product of matrices sums over all modes.
    (_, n, n_u), n_y = right.shape, left.shape[1]
    shares = [jnp.zeros((n, n_y, n_u), complex)] * 5
    for i in range(3):
        for j in range(3):
            shares[i + j] = shares[i + j] + left[i].T[:, :, None] * right[j][:, None, :]
    flat = jnp.stack(shares).reshape(5, n, n_y * n_u)
    responses = jnp.sum(_powers(w, 5)[:, :, None] * (gains @ flat), axis=0)
    sizes = jnp.max(jnp.abs(flat), axis=0)
    takes_part = sizes > NO_PART * jnp.max(sizes, axis=0, initial=0.0)
    unbounded = (hit.astype(float) @ takes_part.astype(float)) > 0
    return jnp.where(unbounded, jnp.inf + 0j, responses).reshape(len(w), n_y, n_u)


def _solved_each(
    w: Float[Array, "n_f"],
    k: Float[Array, "n n"],
    m: Float[Array, "n n"],
    c: Float[Array, "n n"],
    loss: Float[Array, "n n"],
    right: Complex[Array, "n_f n n_u"],
    left: Complex[Array, "n_f n_y n"],
):
    """Solutions at each frequency, one after the other: a batch of large LAPACK calls may never end on a CPU."""

    def one(at: tuple[Array, ...]):
        w, right, left = at
        return left @ jnp.linalg.solve(jax.lax.complex(k - w**2 * m, w * c + loss), right)

    return jax.lax.map(one, (w, right, left))


@_transfer.defjvp
def _transfer_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    """d(C Z^-1 B) = dC X + Y dB - Y dZ X with X = Z^-1 B and Y = C Z^-1: no mode is differentiated."""
    factors, w, parts, by_inputs, by_outputs = primals
    _, dw, (dm, dc, dk, dloss), d_inputs, d_outputs = tangents
    n = parts[0].shape[0]
    every = (jnp.broadcast_to(jnp.eye(n, dtype=complex), (len(w), n, n)),)
    right, left = (_expanded(w, of) for of in (by_inputs, by_outputs))
    moved = _transfer(factors, w, parts, (right,), every)
    felt = _transfer(factors, w, parts, every, (left,))
    found = left @ moved
    one, s, s2 = (power[:, None, None] for power in _powers(w))
    of_z = sum(
        change.astype(complex) @ (power * moved) for change, power in ((dm, s2), (dc, s), (dk, one), (dloss, 1j))
    )
    m, c = (part.astype(complex) for part in parts[:2])
    turned = (1j * dw.astype(complex))[:, None, None]
    of_z = of_z + turned * ((2 * s * m + c) @ moved)
    change = -felt @ of_z

    def moves(polynomial: Complex[Array, "3 i j"] | tuple[Array], d_polynomial: Any):
        if isinstance(polynomial, tuple):
            return d_polynomial[0]
        return _at(w, d_polynomial) + turned * (polynomial[1] + 2 * s * polynomial[2])

    change = change + moves(by_outputs, d_outputs) @ moved + felt @ moves(by_inputs, d_inputs)
    return found, change
