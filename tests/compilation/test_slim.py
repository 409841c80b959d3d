"""Programs without the bodies of their fusions and loops are the same programs."""

import io
import pickle
import sys
import zlib

import jax
import jax.numpy as jnp
import jaxlib.version
import numpy as np
import pytest
from jax.experimental.serialize_executable import deserialize_and_load, serialize

from flexmb.compilation import kept, slim
from flexmb.compilation.compile import QUICK, THOROUGH, jit
from flexmb.compilation.executables import _config, named
from flexmb.compilation.slim import slim as without_bodies
from flexmb.math import linear

pytestmark = pytest.mark.skipif(jaxlib.version.__version__ not in slim.KNOWN, reason="programs stay whole")
X = np.linspace(0.1, 2.0, 12)


def compiled_here(function, options=QUICK):
    """What JAX finds in its cache cannot be written again."""
    with _config.persistent_cache_min_compile_time_secs(np.inf):
        return named(function, f"{function.__name__}.kept", options).lower(X).compile()


def chained(x):
    return jnp.sin(x) * jnp.exp(-x) + 2.0


def several(x):
    # Results of one kernel, a sum and what it is made of.
    y = jnp.cos(x) ** 2 + x
    return y, jnp.sum(y), y[::-1] > 1.5


def loop(x):
    def body(state):
        count, y = state
        return count + 1, jnp.where(y > 1.0, jnp.sqrt(y) + 0.1, y * 1.7 - 0.2)

    return jax.lax.while_loop(lambda state: state[0] < 20, body, (0, x))


def choice(x):
    return jax.lax.cond(x[0] > 0.0, lambda y: jnp.tanh(y) * y, lambda y: y - 3.0 * y**2, x)


def factored(x):
    matrix = jnp.outer(x, x) + jnp.diag(x + 1.0)
    return jnp.linalg.cholesky(matrix) @ jnp.sort(x * 3.0 % 1.0)


def placed(x):
    return jnp.zeros(20).at[3:15].add(x * x).at[jnp.array([0, 2, 19])].set(x[:3] + 1.0)


def turned(x):
    return jax.vmap(lambda y: jax.lax.associative_scan(jnp.multiply, y * 1.1))(x.reshape(3, 4))


MATRIX = np.random.default_rng(0).standard_normal((12, 12)) / 12


def nested(x):
    """Loops in loops, with constants, choices and library calls in them."""

    def inner(i, y):
        return jnp.where(i % 2 == 0, MATRIX @ y, jnp.linalg.solve(MATRIX + 2 * jnp.eye(12), y))

    def outer(state, row):
        y = jax.lax.fori_loop(0, 3, inner, state + row)
        y = jax.lax.cond(y[0] > 0.5, lambda y: MATRIX.T @ y, lambda y: y[::-1] * np.arange(12.0), y)
        return y, jnp.sort(y)[:4]

    return jax.lax.scan(outer, x, MATRIX[:5])


def passed_on(x):
    """Results that are arguments, constants, of a loop, and of one loop into another; some twice."""
    y, count = jax.lax.while_loop(lambda s: jnp.sum(s[0]) < 1e3, lambda s: (s[0] * 1.5 + MATRIX[0], s[1] + 1), (x, 0))
    z = jax.lax.fori_loop(0, count, lambda i, z: MATRIX @ z + y, y)
    return x, y, jnp.array(MATRIX[1]), (count, z), y, jnp.float32(2.5), z[3]


@pytest.mark.parametrize("options", [QUICK, THOROUGH], ids=["quick", "thorough"])
@pytest.mark.parametrize("function", [chained, several, loop, choice, factored, placed, turned, nested, passed_on])
def test_it_says_bit_by_bit_the_same(function, options):
    compiled = compiled_here(function, options)
    code, arguments, results = serialize(compiled)
    quick = without_bodies(code)
    own = deserialize_and_load(quick, arguments, results)
    for one, other in zip(jax.tree.leaves(own(X)), jax.tree.leaves(compiled(X)), strict=True):
        np.testing.assert_array_equal(one, other)
    assert len(quick) < len(code)
    # In the text of a program each kernel is one operation, and nothing is left of what a loop does.
    whole, text = str(compiled.as_text()), str(own.as_text())
    assert "kind=kLoop" not in text
    assert 'custom_call_target="compiled"' in text
    if function is nested:
        assert text.count(" while(") == 1 < whole.count(" while(")


def multiplied(x):
    x = jnp.tile(x, 6)
    matrix = jnp.outer(x, jnp.cos(x))
    return jnp.sum(matrix @ matrix, axis=0) * 2.0 + x


def test_kernels_that_a_library_makes_when_they_run_stay_whole():
    """With options of XLA's own, which the package does not use for its programs."""
    compiled = compiled_here(multiplied, None)
    assert "__ynn_fusion" in compiled.as_text()
    code, arguments, results = serialize(compiled)
    np.testing.assert_array_equal(deserialize_and_load(without_bodies(code), arguments, results)(X), compiled(X))


def test_a_loop_in_which_a_library_makes_code_stays_whole():
    def repeated(x):
        return jax.lax.fori_loop(0, 3, lambda i, y: multiplied(y)[:12], x)

    code = serialize(compiled_here(repeated, None))[0]
    with pytest.raises(ValueError, match="a library makes code of what a loop does"):
        without_bodies(code)
    assert kept._as_kept(code) == code


@pytest.mark.parametrize(("version", "platform"), [("0.11.0", "cpu"), (slim.KNOWN[0], "gpu")])
def test_what_is_not_known_stays_whole(monkeypatch, version, platform):
    code = serialize(compiled_here(chained))[0]
    monkeypatch.setattr(jaxlib.version, "__version__", version)
    monkeypatch.setattr(jax, "default_backend", lambda: platform)
    with pytest.raises(ValueError, match="is not known"):
        without_bodies(code)
    assert kept._as_kept(code) == code


def code_of(program: bytes) -> bytes:
    """What XLA wrote of it."""
    found = []

    class Reader(pickle.Unpickler):
        def persistent_load(self, pid):
            found.extend(pid[1:] if pid[0] == "exec" else [])
            raise pickle.UnpicklingError

    with pytest.raises(pickle.UnpicklingError):
        Reader(io.BytesIO(program)).load()
    return found[0]


def test_what_is_cut_off_is_refused():
    code = code_of(serialize(compiled_here(several))[0])
    assert slim._slim(code) != code
    # Behind the program stand settings of the compiler, which are not looked into: without them it ends between parts.
    length, start = slim._number(code, 0)
    ahead = start + length
    program = next(written for _, _, written in slim._parts(code[ahead:]))
    for end in [*range(0, ahead + len(program), 97), ahead + len(program) - 1]:
        with pytest.raises(ValueError, match=r"ends within|goes beyond|is missing|unpack"):
            slim._slim(code[:end])


def test_so_are_programs_on_disk(tmp_path):
    product = jit(linear.multiplied)
    before = jax.config.values["jax_compilation_cache_dir"]
    jax.clear_caches()
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    np.testing.assert_array_equal(product(X[None, :, None], X[None, None]), np.outer(X, X)[None])
    jax.config.update("jax_compilation_cache_dir", before)
    (file,) = tmp_path.glob("programs/*")
    code = code_of(zlib.decompress(file.read_bytes().split(b"\n", 2)[2]))
    assert slim._slim(code) == code


def test_what_cannot_be_read_is_kept_whole(monkeypatch):
    """As where JAX has its writer elsewhere."""
    code = serialize(compiled_here(chained))[0]
    monkeypatch.setitem(sys.modules, "flexmb.compilation.slim", None)
    assert kept._as_kept(code) == code
