"""A Rosenbrock method for second-order equations with constraints: coefficients, and one step.

The system is u' = w, w' = a, 0 = R(t, u, w, (a, lambda)). Elimination of the first two from each stage leaves one
linear system of the size of R, ``R_z + h g R_w + (h g)^2 R_u``, which is factorised once a step.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import traced_once
from .protocol import Equations, MotionState


class Tableau(NamedTuple):
    """Coefficients of a Rosenbrock method in the form without products of Jacobian and vector.

    Attributes:
        gamma: Diagonal.
        a: Weights of earlier stages in the arguments, strictly lower triangular.
        c: Weights of earlier stages in the right-hand sides, strictly lower triangular.
        m: Weights of the stages in the result.
        error: Weights of the stages in the error estimate.
        within: Weights of the stages in the polynomial within a step, a row for each power.
    """

    gamma: float
    a: np.ndarray
    c: np.ndarray
    m: np.ndarray
    error: np.ndarray
    within: np.ndarray

    @property
    def rows(self) -> np.ndarray:
        """A row for each stage: weights in arguments and in right-hand sides, its time, weight of the rate by time."""
        gamma = np.linalg.inv(np.eye(len(self.m)) / self.gamma - self.c)
        return np.column_stack([self.a, self.c, (self.a @ gamma).sum(axis=1), gamma.sum(axis=1)])


def _lower(rows: Sequence[Sequence[float]]) -> np.ndarray:
    full = np.zeros((len(rows) + 1, len(rows) + 1))
    for i, row in enumerate(rows, 1):
        full[i, : len(row)] = row
    return full


_LAST = [-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946]
RODAS5P = Tableau(
    gamma=0.21193756319429014,
    a=_lower(
        [
            [3.0],
            [2.849394379747939, 0.45842242204463923],
            [-6.954028509809101, 2.489845061869568, -10.358996098473584],
            [2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641],
            _LAST,
            [*_LAST, 1.0],
            [*_LAST, 1.0, 1.0],
        ]
    ),
    c=_lower(
        [
            [-14.155112264123755],
            [-17.97296035885952, -2.859693295451294],
            [147.12150275711716, -1.41221402718213, 71.68940251302358],
            [165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306],
            [24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125, -0.6610691825249471],
            [
                30.91273214028599,
                -3.1208243349937974,
                77.79954646070892,
                34.28646028294783,
                -19.097331116725623,
                -28.087943162872662,
            ],
            [
                37.80277123390563,
                -3.2571969029072276,
                112.26918849496327,
                66.9347231244047,
                -40.06618937091002,
                -54.66780262877968,
                -9.48861652309627,
            ],
        ]
    ),
    m=np.array([*_LAST, 1.0, 1.0, 1.0]),
    error=np.eye(8)[7],
    within=np.array(
        [
            [
                25.948786856663858,
                -2.5579724845846235,
                10.433815404888879,
                -2.3679251022685204,
                0.524948541321073,
                1.1241088310450404,
                0.4272876194431874,
                -0.17202221070155493,
            ],
            [
                -9.91568850695171,
                -0.9689944594115154,
                3.0438037242978453,
                -24.495224566215796,
                20.176138334709044,
                15.98066361424651,
                -6.789040303419874,
                -6.710236069923372,
            ],
            [
                11.419903575922262,
                2.8879645146136994,
                72.92137995996029,
                80.12511834632643,
                -52.072871366152654,
                -59.78993625266729,
                -0.15582684282751913,
                4.883087185713722,
            ],
        ]
    ),
)


class StepResult(NamedTuple):
    """Result of a step.

    Attributes:
        end: State at its end, before projection onto the constraints.
        z: Accelerations and multipliers there.
        error: Estimated error of the state.
        bows: Deviation of z from the straight line within the step, see :func:`z_within`.
        tangent: Derivatives of the residual at its begin.
        increments: Of u, w and z by each stage.
    """

    end: MotionState
    z: Float[Array, "r"]
    error: MotionState
    bows: Float[Array, "3 r"]
    tangent: Any
    increments: Float[Array, "stages k"]

    @property
    def mass(self) -> Float[Array, "n n"] | None:
        """Mass matrix at its begin; None without a dense one."""
        return self.tangent.mass


def _split_row(row: Float[Array, "k"], n: int) -> tuple[Array, Array, Array]:
    """Parts of u, w and z."""
    return row[:n], row[n : 2 * n], row[2 * n :]


def _stage(
    i: Array,
    t: Float[Array, ""],
    h: Float[Array, ""],
    state: MotionState,
    z: Float[Array, "r"],
    increments: Float[Array, "stages k"],
) -> tuple[tuple[Array, MotionState, Array], Array, tuple[Array, Array]]:
    """Time, state and accelerations of a stage, its weight of the rate by time, and right sides of its equations."""
    n = state.u.shape[0]
    # Motions of a batch that have ended take steps of zero length; these still need finite derivatives.
    rate = 1.0 / jnp.where(h == 0, 1.0, h)
    row = jax.lax.dynamic_index_in_dim(jnp.asarray(RODAS5P.rows), i, keepdims=False)
    coefficients, alpha, gamma = row[:-2].reshape(2, -1), row[-2], row[-1]
    # Sums of u, w and z over earlier stages.
    (du, dw, dz), (cu, cw, _) = (_split_row(sums, n) for sums in coefficients @ increments)
    at, z_stage = MotionState(state.u + du, state.w + dw, state.memory), z + dz
    # k_u/hg - k_w = right_u, k_w/hg - k_a = right_w, R_u k_u + R_w k_w + R_z k_z = -r.
    return (t + alpha * h, at, z_stage), gamma, (at.w + cu * rate, z_stage[:n] + cw * rate)


def not_after(t: Float[Array, ""], end: Any) -> Float[Array, ""]:
    """A time, or `end` if that is earlier; its derivative is the derivative of the time. None: no end."""
    return t if end is None else t - jax.lax.stop_gradient(jnp.maximum(t - end, 0.0))


def rosenbrock_step(
    equations: Equations,
    t: Float[Array, ""],
    h: Float[Array, ""],
    state: MotionState,
    z: Float[Array, "r"],
    end: Any = None,
) -> StepResult:
    """One step of the method ``RODAS5P``, from `t` of length `h`.

    `end` limits the times of stages, so that round-off does not pass a jump of the loads.

    Source:
        Hairer, Wanner (1996), Solving Ordinary Differential Equations II, section VI.4; elimination derived here.
    """
    n, stages = state.u.shape[0], len(RODAS5P.m)
    weights = np.vstack([RODAS5P.m, RODAS5P.error, RODAS5P.within])
    tangent = equations.tangent(t, state, z)
    hg = h * RODAS5P.gamma
    solve = tangent.solver(hg)

    def stage(i: Array, increments: Float[Array, "stages k"]):
        (time, at, z_stage), gamma, (right_u, right_w) = _stage(i, t, h, state, z, increments)
        r = equations.residual(not_after(time, end), at, z_stage)
        if tangent.by_t is not None:
            r = r + gamma * h * tangent.by_t
        k_z = -solve(r + tangent.product(hg * right_w, hg * (right_u + hg * right_w)))
        k_w = hg * (k_z[:n] + right_w)
        k_u = hg * (k_w + right_u)
        return jax.lax.dynamic_update_index_in_dim(increments, jnp.concatenate([k_u, k_w, k_z]), i, 0)

    increments = jax.lax.fori_loop(0, stages, stage, jnp.zeros((stages, 2 * n + z.shape[0])))
    sums = weights @ increments
    (du, dw, dz), (error_u, error_w, _) = (_split_row(row, n) for row in sums[:2])
    error = MotionState(_finite(error_u), _finite(error_w), jnp.zeros_like(state.memory))
    end_state = MotionState(state.u + du, state.w + dw, state.memory)
    return StepResult(end_state, z + dz, error, sums[2:, 2 * n :], tangent, increments)


class StepBegin(NamedTuple):
    """Varied numbers of the equations, begin and length of a step, and state, accelerations and multipliers there."""

    numbers: list[Any]
    t: Float[Array, ""]
    h: Float[Array, ""]
    state: MotionState
    z: Float[Array, "r"]


def step_pulled_back(
    whole: Callable[[list[Any]], Equations],
    begin: StepBegin,
    tangent: Any,
    increments: Float[Array, "stages k"],
    by_end: MotionState,
    by_z: Float[Array, "r"],
    end: Any = None,
) -> StepBegin:
    """Derivatives by the begin of a step from derivatives by its end.

    The stages are solved backwards for multipliers of their equations (THEORY.md 10, eq. (10.6)). The derivative of
    R_u k_u + R_w k_w + R_z k_z is the derivative along k of the reverse derivative of R: nothing is differentiated
    through the tangent.

    Args:
        whole: Equations from their varied numbers.
        tangent, increments: As in :class:`StepResult`.
        end: As for :func:`rosenbrock_step`.
    """
    n, hg = by_end.u.shape[0], begin.h * RODAS5P.gamma
    solve = jax.linear_transpose(tangent.solver(hg), by_z)
    product = jax.linear_transpose(tangent.product, by_end.w, by_end.u)

    @traced_once
    def reverse(numbers: list[Any], t: Array, state: MotionState, z: Array, multipliers: Array):
        return jax.vjp(lambda numbers, *at: whole(numbers).residual(*at), numbers, t, state, z)[1](multipliers)

    def stage(j: Array, carry: tuple[Any, ...]):
        i = len(RODAS5P.m) - 1 - j
        changes, by_increments, multipliers = carry
        by_u, by_w, by_k = _split_row(by_increments[i], n)
        (of_r,) = solve(-by_k.at[:n].add(hg * (by_w + hg * by_u)))
        of_w, of_u = product(of_r)
        on_u = by_u + of_u
        on_w = by_w + of_w + hg * on_u
        _, k_w, k_z = _split_row(increments[i], n)

        def arguments(t: Array, h: Array, state: MotionState, z: Array, increments: Array):
            (time, *at), _, (right_u, right_w) = _stage(i, t, h, state, z, increments)
            return (
                (not_after(time, end), *at),
                h * RODAS5P.gamma * (k_w + right_u),
                h * RODAS5P.gamma * (k_z[:n] + right_w),
            )

        (at, _, _), pull = jax.vjp(arguments, *begin[1:], increments)
        of_numbers, *of_at = reverse(begin.numbers, *at, of_r)
        *more, of_increments = pull((tuple(of_at), on_u, on_w))
        changes = jax.tree.map(jnp.add, changes, StepBegin(of_numbers, *more))
        return changes, by_increments + of_increments, multipliers.at[i].set(of_r)

    by_sum = jnp.concatenate([by_end.u, by_end.w, by_z])
    nothing = jax.tree.map(jnp.zeros_like, begin), RODAS5P.m[:, None] * by_sum, jnp.zeros((len(RODAS5P.m), by_z.size))
    changes, _, multipliers = jax.lax.fori_loop(0, len(RODAS5P.m), stage, nothing)
    gammas = RODAS5P.rows[:, -1]

    def along(row: Float[Array, "k"], gamma: Float[Array, ""], multipliers: Float[Array, "r"]):
        (k_u, k_w, k_z), (u, w, memory) = _split_row(row, n), begin.state

        def moved(share: Float[Array, ""]):
            t = begin.t if tangent.by_t is None else begin.t + share * gamma * begin.h
            state = MotionState(u + share * k_u, w + share * k_w, memory)
            return reverse(begin.numbers, t, state, begin.z + share * k_z, multipliers)

        return jax.jvp(moved, (jnp.zeros(()),), (jnp.ones(()),))[1]

    bent = jax.vmap(along)(increments, jnp.asarray(gammas), multipliers)
    numbers, t, state, z = jax.tree.map(lambda rows: jnp.sum(rows, axis=0), bent)
    h = jnp.zeros(()) if tangent.by_t is None else gammas @ multipliers @ tangent.by_t
    more = StepBegin(numbers, t, h, jax.tree.map(jnp.add, state, by_end), z + by_z)
    return jax.tree.map(jnp.add, changes, more)


def z_within(ends: tuple[Array, Array], bows: Float[Array, "3 r"], share: Float[Array, ""]) -> Float[Array, "r"]:
    """Accelerations and multipliers at a share of a step, of order four (Steinebach (2023), BIT 63, 27)."""
    bow = bows[0] + share * (bows[1] + share * bows[2])
    return (1 - share) * ends[0] + share * (ends[1] + (1 - share) * bow)


def state_within_step(
    times: tuple[Any, Any], states: tuple[MotionState, MotionState], rates: tuple[Any, Any], t: Float[Array, ""]
) -> MotionState:
    """State at a time within a step, by Hermite polynomials of order three in positions and in velocities."""
    (t0, t1), (y0, y1), (a0, a1) = times, states, rates
    h = t1 - t0
    s = (t - t0) / jnp.where(h == 0, 1.0, h)
    u = hermite(s, h, y0.u, y1.u, y0.w, y1.w)
    w = hermite(s, h, y0.w, y1.w, a0, a1)
    return MotionState(u, w, y0.memory + s * (y1.memory - y0.memory))


def hermite(
    s: Float[Array, ""],
    h: Float[Array, ""],
    p0: Float[Array, "n"],
    p1: Float[Array, "n"],
    v0: Float[Array, "n"],
    v1: Float[Array, "n"],
) -> Float[Array, "n"]:
    """Polynomial of order three through two values with two rates, at a share s of a step of length h."""
    change = p1 - p0
    return p0 + s * (h * v0 + s * (3 * change - h * (2 * v0 + v1) + s * (h * (v0 + v1) - 2 * change)))


def _finite(error: Float[Array, "n"]):
    """An infinite error for NaN, so that the step is refused and shortened."""
    return jnp.where(jnp.isfinite(error), error, jnp.inf)
