"""Calls side by side: results in order, whatever the number of threads; LAPACK is given back its own."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from threadpoolctl import threadpool_info

from flexmb.math.threads import cores, each

eigenvalues = jax.jit(jnp.linalg.eigvalsh)


def matrices(count):
    drawn = np.random.default_rng(0).standard_normal((count, 5, 5))
    return list(drawn + drawn.transpose(0, 2, 1))


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_results_are_in_order(threads):
    many = matrices(7)
    for found, matrix in zip(each(eigenvalues, many, threads), many, strict=True):
        np.testing.assert_allclose(found, np.linalg.eigvalsh(matrix), atol=1e-12)  # round-off


def test_lapack_has_its_threads_again():
    eigenvalues(matrices(1)[0]).block_until_ready()
    before = [library["num_threads"] for library in threadpool_info()]

    def seen(_):
        return [library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"]

    assert each(seen, [0], 1) == [[1] * len(seen(0))]
    assert [library["num_threads"] for library in threadpool_info()] == before


def test_a_failure_reaches_the_caller():
    def fails(_):
        raise RuntimeError("of one call")

    with pytest.raises(RuntimeError, match="of one call"):
        each(fails, [0, 1, 2], 2)


def test_settings_of_one_thread_stay_in_it():
    assert cores() >= 1
    jax.config.update("jax_enable_x64", False)
    try:
        with jax.enable_x64(True):
            assert cores() == 1
    finally:
        jax.config.update("jax_enable_x64", True)
