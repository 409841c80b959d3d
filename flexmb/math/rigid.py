"""Rigid motions along a line: poses from strains by exponentials of six-vectors (rotation first, then translation).

A pose is a rotation R and a position r. Along a rod dR/ds = R hat(curvatures) and dr/ds = R stretches; curvatures and
stretches are in axes of the section.
"""

import functools
import math
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .rotation import CONJUGATE, RELATIVE, SQUARES

# Quaternion product: (a b)_i = a_j b_k TURNS[4 j + k, i].
TURNS = np.swapaxes(CONJUGATE[:, None, None] * RELATIVE, 1, 2).reshape(16, 4)
# Rows of a triad from the 16 products of pairs of Euler parameters.
TRIADS = SQUARES.reshape(16, 3, 3).swapaxes(1, 2).reshape(16, 9)
# Cross products from the 9 products of pairs; vector part of the quaternion product of 4 parameters and a vector.
CROSSES = np.cross(np.eye(3)[:, None], np.eye(3))
HALF_TURNED = TURNS.reshape(4, 4, 4)[:, 1:, 1:].reshape(12, 3)
# Lie brackets of six-vectors from the 36 products of pairs.
BRACKETS = np.zeros((2, 3, 2, 3, 2, 3))
for _first, _second in ((0, 0), (0, 1), (1, 0)):
    BRACKETS[_first, :, _second, :, _first + _second] = CROSSES
BRACKETS = BRACKETS.reshape(36, 6)
# Functions c_j(z) = sum over k of z^k/(2k + j)!: cos t, sin t / t, (1 - cos t)/t^2 and (t - sin t)/t^3 at z = -t^2.
# Power series up to |z| = SWITCH, exact to rounding; c_j = 1/j! + z c_(j+2) beyond.
FUNCTIONS, TERMS, SWITCH = 4, 16, 4.0
# Derivatives from one evaluation; each needs two more functions.
DERIVATIVES = 4


@functools.cache
def _tables(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients of the power series, (terms, count), and matrix of 2 c_j' = c_(j+1) - j c_(j+2)."""
    series = [[1 / math.factorial(2 * k + j) for j in range(count)] for k in range(TERMS)]
    return np.array(series), (np.eye(count, k=-1) - np.arange(count) * np.eye(count, k=-2)) / 2


@functools.partial(jax.custom_jvp, nondiff_argnums=(1, 2))
def _functions(z: Float[Array, "n 1"], count: int, derivatives: int) -> Float[Array, "n count"]:
    """Functions at z <= 0; the derivatives of all but two for each of them follow from their values."""
    series, _ = _tables(count)
    is_small = z > -SWITCH
    small, large = jnp.where(is_small, z, 0.0), jnp.where(is_small, -SWITCH, z)
    powers = jnp.concatenate([jnp.ones_like(z), small], axis=1)
    for power in (2, 4, 8):
        powers = jnp.concatenate([powers, powers * small**power], axis=1)
    angle = jnp.sqrt(-large)
    beyond = [jnp.cos(angle), jnp.sin(angle) / angle]
    for j in range(count - 2):
        beyond.append((beyond[j] - 1 / math.factorial(j)) / large)
    return jnp.where(is_small, powers @ series, jnp.concatenate(beyond, axis=1))


@_functions.defjvp
def _functions_jvp(count: int, derivatives: int, primals: tuple[Array, ...], tangents: tuple[Array, ...]):
    more = 0 if derivatives else 2 * DERIVATIVES
    values = _functions(primals[0], count + more, derivatives - 1 if derivatives else DERIVATIVES - 1)
    slopes = values @ _tables(count + more)[1][:, :count]
    return values[:, :count], slopes * tangents[0]


def _product(a: Float[Array, "*#n j"], b: Float[Array, "*#n k"], table: np.ndarray) -> Float[Array, "*#n m"]:
    """Bilinear products: the products of all pairs times a constant table, (j k, m)."""
    pairs = a[..., :, None] * b[..., None, :]
    return pairs.reshape(*pairs.shape[:-2], table.shape[0]) @ table


def compose_turns(a: Float[Array, "*#n 4"], b: Float[Array, "*#n 4"]) -> Float[Array, "*#n 4"]:
    """Return Euler parameters of rotation a followed by b about axes that turn with a: quaternion products."""
    return _product(a, b, TURNS)


class Chain(NamedTuple):
    """Poses along a line, relative to its beginning.

    Attributes:
        turns: Euler parameters of the rotations, without a jump of sign at a full turn.
        axes: Axes of the sections as rows: transposed rotation matrices.
        places: Positions.
    """

    turns: Float[Array, "n 4"]
    axes: Float[Array, "n 3 3"]
    places: Float[Array, "n 3"]


def _exponentials(motions: Float[Array, "n 6"]) -> tuple[Float[Array, "n 4"], Float[Array, "n 3"]]:
    """Euler parameters and translations of screw motions. Source: THEORY.md 2, eq. (2.13)."""
    half, way = motions[:, :3] / 2, motions[:, 3:]
    c = _functions(-jnp.sum(half**2, axis=1)[:, None], FUNCTIONS + 2 * DERIVATIVES, DERIVATIVES)
    turns = jnp.concatenate([c[:, :1], c[:, 1:2] * half], axis=1)
    along = jnp.sum(half * way, axis=1)[:, None]
    ways = c[:, 1:2] * _product(turns, way, HALF_TURNED) + (c[:, 3:4] + c[:, 1:2] * c[:, 2:3]) * along * half
    return turns, ways


def _axes(turns: Float[Array, "n 4"]) -> Float[Array, "n 3 3"]:
    return _product(turns, turns, TRIADS).reshape(-1, 3, 3)


def screw_line(motion: Float[Array, "6"], shares: Float[Array, "n"]) -> Chain:
    """Return poses at shares of one screw motion; differentiable at zero rotation."""
    turns, ways = _exponentials(shares[:, None] * motion)
    return Chain(turns, _axes(turns), ways)


def chain(motions: Float[Array, "n 6"]) -> Chain:
    """Return poses at the beginning and after each of n consecutive screw motions; differentiable at zero rotation."""
    turns, ways = _exponentials(motions)
    # Products of 2, 4, .. neighbours, until each product includes all earlier motions.
    count = 1
    while count < turns.shape[0]:
        turns = jnp.concatenate([turns[:count], compose_turns(turns[:-count], turns[count:])])
        count *= 2
    turns = jnp.concatenate([np.eye(4)[:1], turns])
    axes = _axes(turns)
    sums = jnp.asarray(np.tri(ways.shape[0] + 1, ways.shape[0], -1))
    return Chain(turns, axes, sums @ jnp.sum(axes[:-1] * ways[:, :, None], axis=1))


def _bracket(a: Float[Array, "n 6"], b: Float[Array, "n 6"]) -> Float[Array, "n 6"]:
    """Lie bracket of six-vectors, with matrix(a) matrix(b) - matrix(b) matrix(a)."""
    return _product(a, b, BRACKETS)


def screws(strains: Float[Array, "n 3 6"], steps: np.ndarray) -> Float[Array, "n 6"]:
    """Return screw motions v over steps along a line, pose(s + h) = pose(s) exp(v), with order six in h.

    Strains are curvatures and stretches in axes of the section, at three Gauss nodes per step. For constant strains the
    result is exact. Source: Magnus expansion of order six by Blanes, Casas, Oteo and Ros (2009), Physics Reports 470,
    section 5.4. The brackets are reversed, because the strains multiply the pose from the right.
    """
    first, middle, last = (strains[:, i] * steps[:, None] for i in range(3))
    a1 = middle
    a2 = np.sqrt(15) / 3 * (last - first)
    a3 = 10 / 3 * (last - 2 * middle + first)
    c1 = -_bracket(a1, a2)
    c2 = _bracket(a1, 2 * a3 + c1) / 60
    return a1 + a3 / 12 - _bracket(-20 * a1 - a3 + c1, a2 + c2) / 240
