"""Block tridiagonal systems against NumPy's dense solution."""

import jax
import numpy as np
import pytest

from flexmb.math.block_tridiagonal import factorise_blocks, parts_of


@pytest.mark.slow("1-float", "1-complex", "7-float", "23-float", "23-complex", "150-float", "150-complex")
@pytest.mark.parametrize("kind", [float, complex])
@pytest.mark.parametrize("count", [1, 7, 23, 150])
def test_it_is_solved(count, kind):
    draw, size = np.random.default_rng(count), 3
    parts, blocks = parts_of(count)
    assert (parts > 1) == (count > 2)
    count = parts * blocks
    lower, diagonal, upper, right = (
        draw.standard_normal(shape) + (1j * draw.standard_normal(shape) if kind is complex else 0)
        for shape in (*[(size, size, count)] * 3, (size, count))
    )
    diagonal = diagonal + 6 * np.eye(size)[:, :, None]
    lower[..., 0] = upper[..., -1] = 0.0
    whole = np.zeros((count, size, count, size), kind)
    for i in range(count):
        whole[i, :, i] = diagonal[..., i]
        if i:
            whole[i, :, i - 1], whole[i - 1, :, i] = lower[..., i], upper[..., i - 1]
    wanted = np.linalg.solve(whole.reshape(count * size, -1), right.T.reshape(-1)).reshape(count, size).T
    found = jax.jit(lambda *blocks: factorise_blocks(*blocks).solve(right))(lower, diagonal, upper)
    np.testing.assert_allclose(found, wanted, atol=1e-12)
