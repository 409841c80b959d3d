"""Factors of block tridiagonal matrices. Parts of a chain are eliminated in parallel, then the joints between them."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Inexact

# Most parts, since their joints are factored as one dense matrix.
MOST_PARTS = 10


def parts_of(count: int) -> tuple[int, int]:
    """Number of parts for a number of blocks, and number of blocks in each part; the last part is padded."""
    parts = min(MOST_PARTS, max(1, round(count**0.5)))
    return parts, -(-count // parts)


class BlockFactors(NamedTuple):
    """Factors of a block tridiagonal matrix; the first block of each part is a joint, the others are inner blocks.

    Attributes:
        inverse: Inverses of the inner diagonal blocks, after elimination of those before.
        down: Coupling of each inner block to the block before.
        joint: Coupling of the part's joint to each inner block, after elimination of those before.
        after: Inverse times coupling to the block after.
        before: Inverse times coupling to the part's joint.
        lower: Coupling of the joints to the block before.
        joints: Inverse of the matrix of the joints, after elimination of all inner blocks.
    """

    inverse: Inexact[Array, "s b b p"]
    down: Inexact[Array, "s b b p"]
    joint: Inexact[Array, "s b b p"]
    after: Inexact[Array, "s b b p"]
    before: Inexact[Array, "s b b p"]
    lower: Inexact[Array, "b b p"]
    joints: Inexact[Array, "r r"]

    def solve(self, right: Inexact[Array, "b count"]) -> Inexact[Array, "b count"]:
        """Solution of A x = right, by place in the block and number of the block."""
        size, _, parts = self.lower.shape
        first, *_ = rows = jnp.moveaxis(right.reshape(size, parts, -1), 2, 0)
        none = jnp.zeros_like(first)

        def forth(carry: tuple[Array, Array], step: tuple[Array, ...]):
            above, met = carry
            inverse, down, joint, row = step
            above = _product(inverse, row - _product(down, above))
            return (above, met - _product(joint, above)), above

        (last, met), every = jax.lax.scan(forth, (none, none), (self.inverse, self.down, self.joint, rows[1:]))
        met = first + met - _product(self.lower, jnp.roll(last, 1, axis=-1))
        ends = (self.joints @ met.T.reshape(-1)).reshape(parts, size).T

        def back(following: Inexact[Array, "b parts"], step: tuple[Array, ...]):
            inner, after, before = step
            x = inner - _product(after, following) - _product(before, ends)
            return x, x

        _, within = jax.lax.scan(back, jnp.roll(ends, -1, axis=-1), (every, self.after, self.before), reverse=True)
        return jnp.moveaxis(jnp.concatenate([ends[None], within]), 0, 2).reshape(size, -1)


def factorise_blocks(
    lower: Inexact[Array, "b b count"], diagonal: Inexact[Array, "b b count"], upper: Inexact[Array, "b b count"]
) -> BlockFactors:
    """Factors of a block tridiagonal matrix, with exchanges of rows only among the joints.

    One loop runs along all parts, so that little is compiled for any length. The number of blocks must follow
    :func:`parts_of`. The first lower and the last upper block are zero.

    Source:
        Substructures: Polizzi, Sameh (2006), A parallel hybrid banded system solver: the SPIKE algorithm, section 2.
    """
    size, _, count = diagonal.shape
    parts = parts_of(count)[0]
    down, middle, up = (jnp.moveaxis(a.reshape(size, size, parts, -1), 3, 0) for a in (lower, diagonal, upper))
    none = jnp.zeros_like(middle[0])
    itself = none - jnp.eye(size, dtype=none.dtype)[:, :, None]

    def eliminated(carry: tuple[Array, ...], step: tuple[Array, ...]):
        after, before, joint, left = carry
        down, middle, up = step
        inverse = _inverted(middle - _product(down, after))
        following, back = _product(inverse, up), -_product(inverse, _product(down, before))
        kept = inverse, down, joint, following, back
        return (following, back, -_product(joint, following), left - _product(joint, back)), kept

    start = (none, itself, up[0], middle[0])
    (after, before, joint, left), kept = jax.lax.scan(eliminated, start, (down[1:], middle[1:], up[1:]))
    left = left - _product(down[0], jnp.roll(after, 1, axis=-1))
    back = -_product(down[0], jnp.roll(before, 1, axis=-1))
    of_joints = jnp.zeros((parts, size, parts, size), diagonal.dtype)
    every = jnp.arange(parts)
    of_joints = of_joints.at[every, :, every].add(jnp.moveaxis(left, 2, 0))
    of_joints = of_joints.at[every[1:], :, every[:-1]].add(jnp.moveaxis(back[..., 1:], 2, 0))
    of_joints = of_joints.at[every[:-1], :, every[1:]].add(jnp.moveaxis(joint[..., :-1], 2, 0))
    joints = jnp.linalg.inv(of_joints.reshape(parts * size, parts * size))
    return BlockFactors(*kept, lower=down[0], joints=joints)


def _product(a: Inexact[Array, "b c parts"], b: Inexact[Array, "c *d parts"]):
    """Products of blocks with blocks or vectors, as sums that the compiler fuses."""
    return jnp.sum(a[:, :, None] * b if b.ndim == 3 else a * b, axis=1)


def _inverted(a: Inexact[Array, "b b parts"]):
    """Inverses of many small matrices by elimination, in parallel."""
    size = a.shape[0]
    places = jnp.arange(size)

    def eliminated(k: Array, a: Inexact[Array, "b b parts"]):
        here = (places == k)[:, None]
        row = jnp.where(here, 1.0, a[k]) / a[k, k]
        column = jnp.where(here, 0.0, a[:, k])
        return jnp.where(here[:, None], row, jnp.where(here[None], 0.0, a) - column[:, None] * row)

    return jax.lax.fori_loop(0, size, eliminated, a)
