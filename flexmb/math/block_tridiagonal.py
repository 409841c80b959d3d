"""Block tridiagonal matrices: parts of a chain are eliminated side by side, block after block, then their joints."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Inexact

# The most parts: their joints are left to dense factors.
MOST_PARTS = 10


def parts_of(count: int) -> tuple[int, int]:
    """Into how many parts so many blocks are cut, and of how many blocks each; the last is filled up.

    Args:
        count: Number of blocks.
    """
    parts = min(MOST_PARTS, max(1, round(count**0.5)))
    return parts, -(-count // parts)


class BlockFactors(NamedTuple):
    """Factors of a block tridiagonal matrix: of each part the first block is a joint, the others lie within.

    Attributes:
        inverse: Of the diagonal blocks within, when it is their turn, (steps, b, b, parts).
        down: Coupling of each to the block before, (steps, b, b, parts).
        joint: Coupling of the part's joint to each, when it is its turn, (steps, b, b, parts).
        after: The inverse times the coupling to the block after, (steps, b, b, parts).
        before: The inverse times the coupling to the part's joint, (steps, b, b, parts).
        lower: Coupling of the joints to the block before, (b, b, parts).
        joints: Inverse of what is left of the joints, (parts b, parts b).
    """

    inverse: Inexact[Array, "s b b p"]
    down: Inexact[Array, "s b b p"]
    joint: Inexact[Array, "s b b p"]
    after: Inexact[Array, "s b b p"]
    before: Inexact[Array, "s b b p"]
    lower: Inexact[Array, "b b p"]
    joints: Inexact[Array, "r r"]

    def solve(self, right: Inexact[Array, "b count"]) -> Inexact[Array, "b count"]:
        """Solution of A x = right.

        Args:
            right: By place in the block and number of the block, (b, count).
        """
        size, _, parts = self.lower.shape
        first, *_ = rows = jnp.moveaxis(right.reshape(size, parts, -1), 2, 0)
        none = jnp.zeros_like(first)

        def forth(carry: tuple[Array, Array], step: tuple[Array, ...]):
            own, met = carry
            inverse, down, joint, row = step
            own = _product(inverse, row - _product(down, own))
            return (own, met - _product(joint, own)), own

        (last, met), every = jax.lax.scan(forth, (none, none), (self.inverse, self.down, self.joint, rows[1:]))
        met = first + met - _product(self.lower, jnp.roll(last, 1, axis=-1))
        ends = (self.joints @ met.T.reshape(-1)).reshape(parts, size).T

        def back(following: Inexact[Array, "b parts"], step: tuple[Array, ...]):
            own, after, before = step
            x = own - _product(after, following) - _product(before, ends)
            return x, x

        _, within = jax.lax.scan(back, jnp.roll(ends, -1, axis=-1), (every, self.after, self.before), reverse=True)
        return jnp.moveaxis(jnp.concatenate([ends[None], within]), 0, 2).reshape(size, -1)


def factorise_blocks(
    lower: Inexact[Array, "b b count"], diagonal: Inexact[Array, "b b count"], upper: Inexact[Array, "b b count"]
) -> BlockFactors:
    """Factors of a block tridiagonal matrix, without an exchange of rows but among the joints.

    One loop goes along all parts at once, so that little is compiled, of whatever length the chain is.

    Args:
        lower: Coupling of each block row to the block before, zero in the first, (b, b, count).
        diagonal: (b, b, count), as many blocks as :func:`parts_of` says.
        upper: Coupling to the block after, zero in the last, (b, b, count).

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
    whole = jnp.zeros((parts, size, parts, size), diagonal.dtype)
    every = jnp.arange(parts)
    whole = whole.at[every, :, every].add(jnp.moveaxis(left, 2, 0))
    whole = whole.at[every[1:], :, every[:-1]].add(jnp.moveaxis(back[..., 1:], 2, 0))
    whole = whole.at[every[:-1], :, every[1:]].add(jnp.moveaxis(joint[..., :-1], 2, 0))
    joints = jnp.linalg.inv(whole.reshape(parts * size, parts * size))
    return BlockFactors(*kept, lower=down[0], joints=joints)


def _product(a: Inexact[Array, "b c parts"], b: Inexact[Array, "c *d parts"]):
    """Products of blocks with blocks, or with vectors; sums of products, which the compiler fuses."""
    return jnp.sum(a[:, :, None] * b if b.ndim == 3 else a * b, axis=1)


def _inverted(a: Inexact[Array, "b b parts"]):
    """Inverses of many small matrices by elimination, all at once."""
    size = a.shape[0]
    places = jnp.arange(size)

    def eliminated(k: Array, a: Inexact[Array, "b b parts"]):
        here = (places == k)[:, None]
        row = jnp.where(here, 1.0, a[k]) / a[k, k]
        column = jnp.where(here, 0.0, a[:, k])
        return jnp.where(here[:, None], row, jnp.where(here[None], 0.0, a) - column[:, None] * row)

    return jax.lax.fori_loop(0, size, eliminated, a)
