"""LAPACK without the package around it: found, with one thread, and the package is whole for who imports it later."""

import subprocess
import sys

PROGRAM = """
import sys
import jax
import numpy as np
from threadpoolctl import threadpool_info
from flexmb.compilation.threads import one_thread
from flexmb.linear.spectrum import poles_of
from flexmb.results import collects

jax.config.update("jax_enable_x64", True)
matrix = np.diag([3.0, 1.0, 2.0])
with one_thread():
    found = jax.numpy.linalg.eigh(matrix).eigenvalues
    threads = {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}
poles = poles_of(np.diag([4.0, 9.0]), 0.4 * np.eye(2), np.eye(2))
assert not collects()
assert "scipy.linalg" not in sys.modules and "jax.extend" not in sys.modules
assert threads == {1}, threads
np.testing.assert_allclose(found, [1, 2, 3], rtol=1e-14)  # round-off
slow, fast = np.sqrt([4 - 0.04, 9 - 0.04])
np.testing.assert_allclose(poles, 1j * np.array([-slow, slow, -fast, fast]) - 0.2, rtol=1e-14)  # round-off
import jax.extend.core
import scipy.linalg.cython_lapack
from scipy.linalg import expm
assert "dgesv" in scipy.linalg.cython_lapack.__pyx_capi__
assert jax.extend.pallas and jax.extend.core.Jaxpr is type(jax.make_jaxpr(lambda: 0)().jaxpr)
np.testing.assert_allclose(expm(0 * matrix), np.eye(3), atol=1e-15)  # round-off
"""


def test_lapack_is_found_and_packages_are_whole_afterwards():
    said = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
