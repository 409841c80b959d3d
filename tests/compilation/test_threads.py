"""Calls side by side: results in order, whatever the number of threads; LAPACK is given back its own."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from flexmb.compilation.compile import jit
from flexmb.compilation.threads import cores, in_threads, one_thread
from flexmb.math.subspace import null_spaces

eigenvalues = jax.jit(jnp.linalg.eigvalsh)


def matrices(count):
    drawn = np.random.default_rng(0).standard_normal((count, 5, 5))
    return list(drawn + drawn.transpose(0, 2, 1))


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_results_are_in_order(threads):
    many = matrices(7)
    for found, matrix in zip(in_threads(eigenvalues, many, threads), many, strict=True):
        np.testing.assert_allclose(found, np.linalg.eigvalsh(matrix), atol=1e-12)  # round-off


def threads() -> set[int]:
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


@pytest.fixture
def two_threads():
    """What a user has set, whatever this machine has."""
    eigenvalues(matrices(1)[0]).block_until_ready()
    with threadpool_limits(2, user_api="blas"):
        yield


def test_lapack_has_its_threads_again(two_threads):
    assert in_threads(lambda _: sorted(threads()), [0], 1) == [[1]]
    assert threads() == {2}


def test_every_kernel_works_in_one_thread(two_threads):
    def looked(x):
        return jax.pure_callback(lambda x: np.full_like(x, max(threads())), x, x)

    assert float(jit(looked)(jnp.array(0.0))) == 1.0
    assert threads() == {2}
    with pytest.raises(ZeroDivisionError):
        jit(lambda x: x / (1 // 0))(jnp.array(0.0))
    assert threads() == {2}
    # Within a user's own compiled function there is no call of Python's to do it.
    assert float(jax.jit(jit(looked))(jnp.array(0.0))) == 2.0


def test_the_last_of_several_gives_threads_back(two_threads):
    with one_thread():
        assert all(in_threads(lambda _: threads() == {1}, range(4), 3))
        with one_thread():
            pass
        assert threads() == {1}
    assert threads() == {2}


def test_decisions_on_the_host_take_one_thread(two_threads, monkeypatch):
    seen = []
    svd = np.linalg.svd
    monkeypatch.setattr(np.linalg, "svd", lambda *a, **k: (seen.append(threads()), svd(*a, **k))[1])
    assert null_spaces(np.eye(3))[0] == 3
    assert seen == [{1}]
    assert threads() == {2}


def test_a_failure_reaches_the_caller():
    def fails(_):
        raise RuntimeError("of one call")

    with pytest.raises(RuntimeError, match="of one call"):
        in_threads(fails, [0, 1, 2], 2)


@pytest.mark.slow
def test_settings_of_one_thread_stay_in_it():
    assert cores() >= 1
    jax.config.update("jax_enable_x64", False)
    try:
        with jax.enable_x64(True):
            assert cores() == 1
    finally:
        jax.config.update("jax_enable_x64", True)
