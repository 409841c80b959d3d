"""Block tridiagonal matrices: factored by cyclic reduction, whose steps are wide operations over all blocks at once."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Inexact

# So many blocks are left to dense factors.
LEFT = 10


class Halving(NamedTuple):
    """One step of the reduction: every second block row eliminated; blocks come last in all arrays.

    Attributes:
        inverse: Of the diagonal blocks that are eliminated, (b, b, k).
        before: The same times their coupling to the block before, (b, b, k).
        after: The same times their coupling to the block after, (b, b, k).
        lower: Coupling of the blocks that stay to the eliminated block before, (b, b, k).
        upper: To the eliminated block after, (b, b, k).
    """

    inverse: Inexact[Array, "b b k"]
    before: Inexact[Array, "b b k"]
    after: Inexact[Array, "b b k"]
    lower: Inexact[Array, "b b k"]
    upper: Inexact[Array, "b b k"]


class BlockFactors(NamedTuple):
    """Factors of a block tridiagonal matrix.

    Attributes:
        halvings: Steps of the reduction.
        last: Inverse of what is left, (s b, s b).
    """

    halvings: tuple[Halving, ...]
    last: Inexact[Array, "r r"]

    def solve(self, right: Inexact[Array, "b *m count"]) -> Inexact[Array, "b *m count"]:
        """Solution of A x = right.

        Args:
            right: By place in the block and number of the block, (b, count).
        """
        parts = []
        for half in self.halvings:
            stays, goes = right[:, 0::2], right[:, 1::2]
            own = _product(half.inverse, goes)
            parts.append(own)
            right = stays - _product(half.upper, own) - _product(half.lower, jnp.roll(own, 1, axis=-1))
        size, count = right.shape
        x = (self.last @ right.T.reshape(-1)).reshape(count, size).T
        for half, own in zip(self.halvings[::-1], parts[::-1], strict=True):
            goes = own - _product(half.before, x) - _product(half.after, jnp.roll(x, -1, axis=-1))
            x = jnp.stack([x, goes], axis=2).reshape(size, -1)
        return x


def rounds_of(count: int) -> tuple[int, int]:
    """How often so many blocks are halved, and how many blocks they are filled up to.

    Args:
        count: Number of blocks.
    """
    rounds = 0
    while -(-count // 2**rounds) > LEFT:
        rounds += 1
    return rounds, -(-count // 2**rounds) * 2**rounds


def factorise_blocks(
    lower: Inexact[Array, "b b count"], diagonal: Inexact[Array, "b b count"], upper: Inexact[Array, "b b count"]
) -> BlockFactors:
    """Factors of a block tridiagonal matrix, without an exchange of rows but among the last blocks.

    Args:
        lower: Coupling of each block row to the block before, zero in the first, (b, b, count).
        diagonal: (b, b, count), as many blocks as :func:`rounds_of` says.
        upper: Coupling to the block after, zero in the last, (b, b, count).

    Source:
        Block cyclic reduction: Golub, Van Loan (2013), Matrix Computations, section 4.5.
    """
    size, _, count = diagonal.shape
    halvings = []
    for _ in range(rounds_of(count)[0]):
        inverse = _inverted(diagonal[..., 1::2])
        before, after = _product(inverse, lower[..., 1::2]), _product(inverse, upper[..., 1::2])
        down, up = lower[..., 0::2], upper[..., 0::2]
        halvings.append(Halving(inverse, before, after, down, up))
        diagonal = diagonal[..., 0::2] - _product(up, before) - _product(down, jnp.roll(after, 1, axis=-1))
        lower, upper = -_product(down, jnp.roll(before, 1, axis=-1)), -_product(up, after)
    left = diagonal.shape[2]
    whole = jnp.zeros((left, size, left, size), diagonal.dtype)
    every = jnp.arange(left)
    whole = whole.at[every, :, every].add(jnp.moveaxis(diagonal, 2, 0))
    whole = whole.at[every[1:], :, every[:-1]].add(jnp.moveaxis(lower[..., 1:], 2, 0))
    whole = whole.at[every[:-1], :, every[1:]].add(jnp.moveaxis(upper[..., :-1], 2, 0))
    whole = whole.reshape(left * size, left * size)
    return BlockFactors(tuple(halvings), jnp.linalg.inv(whole))


def _product(a, b):
    """Products of blocks with blocks, or with vectors; sums of products, which the compiler fuses."""
    return jnp.sum(a[:, :, None] * b if b.ndim == 3 else a * b, axis=1)


def _inverted(a):
    """Inverses of many small matrices by elimination, all at once."""
    size = a.shape[0]
    places = jnp.arange(size)

    def eliminated(k, a):
        here = (places == k)[:, None]
        row = jnp.where(here, 1.0, a[k]) / a[k, k]
        column = jnp.where(here, 0.0, a[:, k])
        return jnp.where(here[:, None], row, jnp.where(here[None], 0.0, a) - column[:, None] * row)

    return jax.lax.fori_loop(0, size, eliminated, a)
