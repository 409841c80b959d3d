"""The mechanism in modal amplitudes, and a controller around it, as a state space or by frequency."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float

from ..arguments import as_reals, is_concrete, numbers, short_repr
from ..compilation.compile import jit
from ..linear.spectrum import shift_to_definite
from ..math.linear import factorise, pencil
from ..motion.controllers import signal_places
from ..numerical_limits import BOUNDED_ROUND_OFF, MASSLESS_SHARE, NEGLIGIBLE
from .frequency_response import place_of_name
from .second_order_form import SecondOrder


class EnergyForm(NamedTuple):
    """z' = A z + B u, y = C z + D u with the energy |z|^2/2 of a stable mechanism at rest.

    ``rough``: outputs that depend on rates of inputs or on drift, which these matrices do not include.
    """

    A: Float[Array, "z z"]
    B: Float[Array, "z n_u"]
    C: Float[Array, "n_y z"]
    D: Float[Array, "n_y n_u"]
    rough: Bool[Array, "n_y n_u"]


def energy_form(system: SecondOrder, orders: tuple[int, ...]) -> EnergyForm:
    """State space of a second-order form, whose inputs are p or its derivatives of ``orders``; differentiable.

    The states are z = (w, sqrt(mu) w') of the amplitudes w of modes scaled to a stiffness of one, with masses mu. For
    an input p that moves held coordinates, such as a floor, they are relative to the motion at rest. Motions without
    mass follow the inputs immediately, and their damping is left out. Their states decay; no input acts on them and no
    output depends on them (THEORY.md 14, eq. (14.34)).
    """
    symmetric = (system.K + system.K.T) / 2
    shift, *_ = shift_to_definite(symmetric, system.M)
    # The equations hold in any basis: it is not differentiated.
    mu, basis = jax.lax.stop_gradient(pencil(system.M, symmetric + shift * system.M))
    massive = mu > MASSLESS_SHARE * len(mu) * jnp.max(mu, initial=0.0)
    with_mass, massless = massive.astype(float), (~massive).astype(float)
    scale = jnp.where(massive, 1 / jnp.sqrt(jnp.where(massive, mu, 1.0)), 0.0)
    mass, damping, stiffness = (basis.T @ matrix @ basis for matrix in system[:3])
    b = jnp.stack([basis.T @ matrix for matrix in system[3:6]])
    c = jnp.stack([matrix @ basis for matrix in system[6:9]])
    d = jnp.stack(system[9:12])
    # Smaller effects on motions without mass are round-off: the squares of all effects add up to the flexibility at
    # rest.
    b = jnp.where(massive[:, None] | (jnp.abs(b) > NEGLIGIBLE * jnp.linalg.norm(b, axis=1, keepdims=True)), b, 0.0)
    c = jnp.where(massive | (jnp.abs(c) > NEGLIGIBLE * jnp.linalg.norm(c, axis=2, keepdims=True)), c, 0.0)
    if any(orders):
        size = jnp.abs(basis)
        parts, by_p, by_q = (jnp.abs(jnp.stack(some)) for some in (system[2::-1], system[3:6], system[6:9]))
        sizes = size.T @ parts @ size, size.T @ by_p, by_q @ size
        b, d, adrift, noted = _beyond_rest_motion(b, c, d, (stiffness, damping, mass), orders, sizes)
    else:
        adrift, noted = jnp.zeros(d.shape[1:], bool), jnp.sum(jnp.abs(d), axis=0)
    # Motions without mass follow the other motions and the forces immediately.
    rigid = factorise(massless[:, None] * stiffness * massless + jnp.diag(with_mass))

    def follows(right: Float[Array, "n k"], solve: Callable[..., Any]):
        return massless[:, None] * solve(massless[:, None] * right)

    onto = jnp.diag(with_mass) - follows(stiffness * with_mass, rigid.solve)
    from_left = jnp.diag(with_mass) - follows(stiffness.T * with_mass, rigid.solve_transposed)
    direct = follows(b[0], rigid.solve)
    k, rate = from_left.T @ stiffness @ onto, from_left.T @ damping @ onto
    inertia = factorise(scale[:, None] * mass * scale + jnp.diag(massless))

    def accelerated(force: Float[Array, "n k"]):
        return scale[:, None] * inertia.solve(scale[:, None] * force)

    b = jnp.einsum("ji,kju->kiu", from_left, b)
    moved = accelerated(b[2])
    force, push = b[0] - k @ moved, b[1] - rate @ moved
    jump = accelerated(push)
    lower = jnp.concatenate([-inertia.solve(scale[:, None] * k), -inertia.solve(scale[:, None] * rate * scale)], axis=1)
    still = jnp.diag(massless / jnp.sqrt(jnp.max(mu)))
    upper = jnp.concatenate([-still, jnp.diag(scale)], axis=1)
    n = len(mu)
    lower = lower - jnp.concatenate([jnp.zeros((n, n)), still], axis=1)
    driven = inertia.solve(scale[:, None] * (force - rate @ jump))
    position, velocity, acceleration = c @ onto
    sensed = jnp.concatenate([position, velocity * scale], axis=1) + (acceleration * scale) @ lower
    terms = [position @ moved, c[0] @ direct, velocity @ jump, (acceleration * scale) @ driven, d[0]]
    passed, sizes = sum(terms), sum(jnp.abs(term) for term in terms[:-1]) + noted
    rates = velocity @ moved + acceleration @ jump + d[1], acceleration @ moved + d[2]
    allowed = jnp.abs(velocity) @ jnp.abs(moved) + jnp.abs(acceleration) @ (jnp.abs(jump) + jnp.abs(moved)) + noted
    rough = adrift | jnp.any(jnp.abs(jnp.stack(rates)) > NEGLIGIBLE * allowed, axis=0)
    passed = jnp.where(jnp.abs(passed) > NEGLIGIBLE * sizes, passed, 0.0)
    return EnergyForm(jnp.concatenate([upper, lower]), jnp.concatenate([jump, driven]), sensed, passed, rough)


def _beyond_rest_motion(
    b: Float[Array, "3 n n_u"],
    c: Float[Array, "3 n_y n"],
    d: Float[Array, "3 n_y n_u"],
    parts: tuple[Array, ...],
    orders: tuple[int, ...],
    sizes: tuple[Array, ...],
):
    """Effects on the motion beside the motion at rest, for inputs that are rates, by powers of the rate.

    q = q' + r p with K r = B0: B1 - C r and B2 - M r remain, and outputs include C0 r + D0 and so on. If a floor moves
    everything as one body, B1 - C r and C0 r + D0 are zero but for round-off. The round-off is bounded by
    ``sizes`` of the terms of (K, C, M), b and c in the degrees of freedom. The round-off of r is bounded by K r - B0
    times the inverse of K, here one.

    Returns b and d by u and its rates, whether outputs drift, and sizes of their terms.
    """
    factors = factorise(parts[0])
    is_rate = np.array([order > 0 for order in orders])
    follows = jnp.where(is_rate & factors.regular(), factors.solve(jnp.where(is_rate, b[0], 0.0)), 0.0)
    follows = jnp.where(jnp.isfinite(follows), follows, 0.0)
    by_parts, by_inputs, by_outputs = sizes
    size = jnp.abs(follows)
    unsure = by_parts[0] @ size + by_inputs[0]

    def beyond_round_off(total: Array, moved: Array, terms: Array, beside: Array):
        allowed = NEGLIGIBLE * (jnp.abs(moved) @ size + jnp.abs(beside))
        return jnp.where(jnp.abs(total) > allowed + BOUNDED_ROUND_OFF * (terms + jnp.abs(moved) @ unsure), total, 0.0)

    moved = jnp.stack(parts)
    b = beyond_round_off(b - moved @ follows, moved, by_parts @ size + by_inputs, b)
    noted = jnp.abs(c) @ size + jnp.abs(d)
    seen = beyond_round_off(c @ follows + d, c, by_outputs @ size, d)
    rank = np.asarray(orders)
    drifts = jnp.zeros(d.shape[1:], bool)
    for k in range(2):
        late = rank > k
        # Everything that the motion moves drifts with it.
        drifts = drifts | (late & ((seen[k] != 0) | jnp.any(b[k] != 0, axis=0)))
    power = np.add.outer(np.arange(3), rank)
    every = np.arange(len(rank))
    shifted = [jnp.concatenate([m, jnp.zeros_like(m)])[power, :, every].transpose(0, 2, 1) for m in (b, seen)]
    return *shifted, drifts, jnp.sum(noted, axis=0)


# Numbers of the outputs that a controller reads, and of the inputs that it drives.
Places = tuple[tuple[int, ...], tuple[int, ...]]


class Controller(NamedTuple):
    """Controller u = H y, its sign included.

    Attributes:
        measured: Numbers of the outputs that it reads.
        driven: Numbers of the inputs that it drives.
        matrices: A, B, C and D; None if it is known by frequency alone.
        by_frequency: Function of frequencies, (n_f,) [Hz], that returns (n_f, n_driven, n_measured).
    """

    measured: tuple[int, ...]
    driven: tuple[int, ...]
    matrices: tuple[Any, Any, Any, Any] | None
    by_frequency: Callable[[Any], Any]

    @property
    def places(self) -> Places:
        """Numbers of the outputs that it reads, and of the inputs that it drives."""
        return self.measured, self.driven


def feedback_controller(
    given: Any, measured: Any, driven: Any, outputs: Sequence[str], inputs: Sequence[str], sign: float
) -> Controller:
    """Controller from a control.LTI, (A, B, C, D), gains, or a function of frequencies; raise for wrong ones.

    ``measured`` and ``driven`` name outputs and inputs; None for the names of the controller's signals, or all.
    """
    shape, labels, matrices, respond = _controller_parts(given)
    places = []
    for kind, names, all_of, count, own_names in (
        ("measured", measured, outputs, shape and shape[1], labels and labels[0]),
        ("driven", driven, inputs, shape and shape[0], labels and labels[1]),
    ):
        side = "output" if kind == "measured" else "input"
        if names is None:
            names = list(all_of) if signal_places(own_names, all_of, side) is None else own_names
        names = [names] if isinstance(names, str) else list(names)
        if count is not None and len(names) != count:
            raise ValueError(
                f"The controller has {count} {'inputs' if side == 'output' else 'outputs'}, but the mechanism has"
                f" {len(names)} {side}s. Choose some by `{kind}`, of: {', '.join(all_of)}."
            )
        places.append(tuple(place_of_name(side, all_of, name) for name in names))
    sizes = (len(places[1]), len(places[0]))
    if matrices is not None:
        a, b, c, d = matrices
        matrices = (a, b, sign * c, sign * d)

    def by_frequency(hertz: Float[Array | np.ndarray, "n_f"]):
        gain: Any = respond(hertz) if matrices is None else _state_response(matrices, hertz)
        gain = np.asarray(gain, complex) if is_concrete(gain) else gain.astype(complex)
        if gain.ndim == 1 and sizes == (1, 1):
            gain = gain[:, None, None]
        if gain.shape != (len(hertz), *sizes):
            raise ValueError(
                f"The controller, a function of frequencies, must return shape {(len(hertz), *sizes)}, not"
                f" {gain.shape}."
            )
        if is_concrete(gain) and len(wrong := np.argwhere(~np.isfinite(np.asarray(gain)))):
            raise ValueError(
                f"The response of the controller is not finite at {float(hertz[wrong[0, 0]]):.6g} Hz; an integrator has"
                " such a response at 0 Hz. Leave out this frequency."
            )
        return gain if matrices is not None else sign * gain

    return Controller(places[0], places[1], matrices, by_frequency)


def _controller_parts(controller: Any) -> tuple[Any, Any, Any, Any]:
    """Shape (outputs, inputs) and labels if known, matrices or a function of frequencies."""
    if any(kind.__module__.split(".")[0] == "control" for kind in type(controller).__mro__):
        import control

        if getattr(controller, "isdtime", lambda **_: False)(strict=True):
            raise ValueError(
                "A sampled controller has no response to continuous noise. Give the continuous controller that it is"
                " made from."
            )
        labels = list(controller.input_labels), list(controller.output_labels)
        shape = controller.noutputs, controller.ninputs
        if isinstance(controller, control.FrequencyResponseData):

            def respond(hertz: Any):
                return np.moveaxis(np.asarray(controller(2j * np.pi * np.asarray(hertz), squeeze=False)), -1, 0)

            return shape, labels, None, respond
        system: Any = control.ss(controller)
        parts = tuple(as_reals("The controller", part) for part in (system.A, system.B, system.C, system.D))
        return shape, labels, parts, None
    if callable(controller):
        return None, None, None, controller
    if isinstance(controller, tuple) and len(controller) == 4:
        a, b, c, d = (jnp.atleast_2d(as_reals("The controller", part)) for part in controller)
        n = a.shape[0]
        d_shape = (c.shape[0], b.shape[1])
        if a.shape != (n, n) or b.shape[0] != n or c.shape[1] != n or d.shape != d_shape:
            raise ValueError("The matrices A, B, C and D of the controller have sizes that do not agree.")
        return d.shape, None, (a, b, c, d), None
    if (array := numbers(controller)) is not None and array.ndim in (0, 2):
        d = jnp.atleast_2d(jnp.asarray(array, float))
        none = jnp.zeros((0, 0)), jnp.zeros((0, d.shape[1])), jnp.zeros((d.shape[0], 0)), d
        return d.shape, None, none, None
    raise TypeError(
        "A controller is a system of python-control, a tuple of A, B, C and D, gains (n_driven, n_measured), or a"
        f" function of frequencies, not {short_repr(controller)}."
    )


@jit
def _state_response(matrices: Any, hertz: Float[Array, "n_f"]) -> Complex[Array, "n_f i j"]:
    a, b, c, d = (part.astype(complex) for part in matrices)
    n = a.shape[0]
    direct = jnp.broadcast_to(d, (len(hertz), *d.shape))
    if not n:
        return direct
    s = 2j * np.pi * jnp.asarray(hertz).astype(complex)
    right = jnp.broadcast_to(b, (len(hertz), *b.shape))
    return c @ jnp.linalg.solve(s[:, None, None] * jnp.eye(n, dtype=complex) - a, right) + direct


def closed(
    plant: EnergyForm, matrices: Any, places: Places | None, us: Sequence[int], sensed: Sequence[int]
) -> EnergyForm:
    """State space from noise at inputs and of sensors to all outputs of the closed loop (THEORY.md 14, eq. (14.35)).

    Inputs are the inputs of ``us``, then sensors of the outputs ``sensed``. States of the controller are last.
    """
    a, b, c, d, rough = plant
    w = np.asarray(us, int)
    if places is None:
        return EnergyForm(a, b[:, w], c, d[:, w], rough[:, w])
    ak, bk, ck, dk = matrices
    ms, ds = (np.asarray(place) for place in places)
    noise = jnp.asarray(np.equal.outer(ms, np.asarray(sensed, int)).astype(float))
    bd, dd = b[:, ds], d[:, ds]
    bw = jnp.concatenate([b[:, w], jnp.zeros((len(a), len(sensed)))], axis=1)
    dw = jnp.concatenate([d[:, w], jnp.zeros((len(c), len(sensed)))], axis=1)
    read = jnp.concatenate([d[ms][:, w], noise], axis=1)
    around = jnp.eye(len(ds)) - dk @ dd[ms]
    by_z, by_x, by_w = (jnp.linalg.solve(around, part) for part in (dk @ c[ms], ck, dk @ read))
    seen = dd[ms]
    system_matrix = jnp.block([[a + bd @ by_z, bd @ by_x], [bk @ (c[ms] + seen @ by_z), ak + bk @ seen @ by_x]])
    enters = jnp.concatenate([bw + bd @ by_w, bk @ (read + seen @ by_w)])
    leaves = jnp.concatenate([c + dd @ by_z, dd @ by_x], axis=1)
    # If a sensor's signal is not known, neither is the loop.
    lost = rough[:, w] | jnp.any(rough[ms][:, w], axis=0) | jnp.any(rough[ms][:, ds])
    lost = jnp.concatenate([lost, jnp.zeros((len(c), len(sensed)), bool)], axis=1)
    return EnergyForm(system_matrix, enters, leaves, dw + dd @ by_w, lost)


def closed_by_frequency(
    plant: Complex[Array, "n_f n_y n_u"],
    gain: Complex[Array, "n_f n_d n_m"] | None,
    places: Places | None,
    us: Sequence[int],
    sensed: Sequence[int],
) -> Complex[Array, "n_f n_y n_s"]:
    """Responses of all outputs to noise at inputs and of sensors (THEORY.md 14, eq. (14.33)); see :func:`closed`."""
    enters = plant[:, :, np.asarray(us, int)]
    if places is None or gain is None:
        return enters
    ms, ds = (np.asarray(place) for place in places)
    noise = np.equal.outer(ms, np.asarray(sensed, int)).astype(complex)
    noise = jnp.broadcast_to(jnp.asarray(noise), (len(plant), *noise.shape))
    enters = jnp.concatenate([enters, jnp.zeros((*plant.shape[:2], len(sensed)), complex)], axis=2)
    read = jnp.concatenate([plant[:, ms][:, :, np.asarray(us, int)], noise], axis=2)
    around = jnp.eye(len(ds), dtype=complex) - gain @ plant[:, ms][:, :, ds]
    return enters + plant[:, :, ds] @ jnp.linalg.solve(around, gain @ read)
