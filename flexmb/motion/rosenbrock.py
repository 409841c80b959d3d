"""Rosenbrock methods for second-order equations with constraints, as diffrax solvers.

The system is u' = w, w' = a, 0 = R(t, u, w, (a, lambda)). Eliminating the first two from each stage leaves one linear
system of the size of R, ``R_z + h g R_w + (h g)^2 R_u``, which is factorised once a step.
"""

from typing import ClassVar, NamedTuple

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from ..compilation.compile import jit_beside_options
from ..math.linear import factorise
from .protocol import MotionState
from .solver import MotionSolver
from .term import MotionTerm, equations_of


class Tableau(NamedTuple):
    """Coefficients of a Rosenbrock method in the form without products of Jacobian and vector.

    Attributes:
        gamma: Diagonal.
        a: Weights of earlier stages in the arguments, strictly lower triangular.
        c: Weights of earlier stages in the right-hand sides, strictly lower triangular.
        m: Weights of the stages in the result.
        error: Weights of the stages in the error estimate.
        order: Order of the method.
    """

    gamma: float
    a: np.ndarray
    c: np.ndarray
    m: np.ndarray
    error: np.ndarray
    order: int

    @property
    def alpha(self) -> np.ndarray:
        """Times of the stages, in steps."""
        return self._in_standard_form[0].sum(axis=1)

    @property
    def gammas(self) -> np.ndarray:
        """Weights of the derivative by time, in steps."""
        return self._in_standard_form[1].sum(axis=1)

    @property
    def _in_standard_form(self):
        gamma = np.linalg.inv(np.eye(len(self.m)) / self.gamma - self.c)
        return self.a @ gamma, gamma


def _lower(rows) -> np.ndarray:
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
    order=5,
)


class Rosenbrock(MotionSolver, diffrax.AbstractAdaptiveSolver):
    """Rosenbrock methods: one factorisation a step, and one solve a stage.

    The accelerations and multipliers are carried from step to step, and found anew after a jump. After each step the
    state is brought back onto the constraints.

    Attributes:
        tableau: Coefficients.
        jumps: Whether loads may jump, so that accelerations are found anew there.

    Source:
        Hairer, Wanner (1996), Solving Ordinary Differential Equations II, section VI.4; elimination derived here.
    """

    tableau: eqx.AbstractClassVar[Tableau]
    jumps: eqx.AbstractVar[bool]

    def order(self, terms) -> int:
        """Order of the method."""
        return self.tableau.order

    def init(self, terms: MotionTerm, t0, t1, y0: MotionState, args):
        """Accelerations and multipliers at the start."""
        return equations_of(terms).acceleration(t0, y0)[0]

    @jit_beside_options
    def step(self, terms: MotionTerm, t0, t1, y0: MotionState, args, solver_state, made_jump):
        """One step, from the accelerations and multipliers at its begin, which are the state of the solver."""
        tab, equations = self.tableau, equations_of(terms)
        h, n, stages = t1 - t0, y0.u.shape[0], len(tab.m)
        z0 = solver_state
        if self.jumps:
            z0 = jax.lax.cond(made_jump, lambda: equations.acceleration(t0, y0)[0], lambda: solver_state)
        tangent = equations.tangent(t0, y0, z0)
        hg = h * tab.gamma
        # Of a batch the motions that have ended take steps of no length, which count for nothing but in derivatives.
        rate = 1.0 / jnp.where(h == 0, 1.0, h)
        factors = factorise(tangent.by_z.at[:, :n].add(hg * tangent.by_w + hg**2 * tangent.by_u))
        by_both = jnp.concatenate([tangent.by_w, tangent.by_u], axis=1)
        a, c, alpha, gammas = (jnp.asarray(of) for of in (tab.a, tab.c, tab.alpha, tab.gammas))

        def apart(row):
            return row[:n], row[n : 2 * n], row[2 * n :]

        def stage(i, increments):
            # Of u, w and z, of all earlier stages.
            (du, dw, dz), (cu, cw, _) = (apart(of[i] @ increments) for of in (a, c))
            u, w, z = y0.u + du, y0.w + dw, z0 + dz
            r = equations.residual(t0 + alpha[i] * h, MotionState(u, w, y0.memory), z)
            if tangent.by_t is not None:
                r = r + gammas[i] * h * tangent.by_t
            # k_u/hg - k_w = right_u, k_w/hg - k_a = right_w, R_u k_u + R_w k_w + R_z k_z = -r.
            right_u, right_w = w + cu * rate, z[:n] + cw * rate
            right = r + by_both @ jnp.concatenate([hg * right_w, hg * (right_u + hg * right_w)])
            own_z = -factors.solve(right)
            own_w = hg * (own_z[:n] + right_w)
            own_u = hg * (own_w + right_u)
            return jax.lax.dynamic_update_index_in_dim(increments, jnp.concatenate([own_u, own_w, own_z]), i, 0)

        increments = jax.lax.fori_loop(0, stages, stage, jnp.zeros((stages, 2 * n + z0.shape[0])))
        (du, dw, dz), (error_u, error_w, _) = (apart(of @ increments) for of in (tab.m, tab.error))
        u1, w1, z1 = y0.u + du, y0.w + dw, z0 + dz
        y1 = equations.settle(t1, MotionState(u1, w1, y0.memory), tangent.by_z[:n, :n])
        error = MotionState(_finite(error_u), _finite(error_w), jnp.zeros_like(y0.memory))
        dense = dict(y0=y0, y1=y1, a0=z0[:n], a1=z1[:n])
        return y1, error, dense, z1, diffrax.RESULTS.successful


class Rodas5P(Rosenbrock):
    """Stiffly accurate Rosenbrock method of order five with eight stages.

    Attributes:
        jumps: Whether loads may jump, so that accelerations are found anew there.

    Source:
        Steinebach (2023), BIT Numerical Mathematics 63, 27.
    """

    tableau: ClassVar[Tableau] = RODAS5P  # pyright: ignore[reportIncompatibleVariableOverride]
    jumps: bool = False


def _finite(error):
    """A step that went wrong has an error without bound, so that it is refused and shortened."""
    return jnp.where(jnp.isfinite(error), error, jnp.inf)
