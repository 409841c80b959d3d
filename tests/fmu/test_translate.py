"""Functions in C beside the same in JAX; whole right-hand sides of mechanisms; what C cannot do is refused by name."""

import ctypes

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.c_code import called, compiled, needs_compiler, pointer
from cases.mechanisms import planar_guide, spatial_guide
from cases.motions import meshing_wheels
from cases.units import simulated
from fmpy.validation import validate_fmu
from jax import lax

import flexmb as fm
from flexmb import planar
from flexmb.fmu.plant import nonlinear as plant
from flexmb.fmu.translate import Unit

# Sums of some ten numbers of order one, in another order: round-off.
ROUND_OFF = 1e-13
# Rates and outputs of a mechanism, as shares of the largest: round-off times the condition of its mass matrix.
RELATIVE = 1e-12
RNG = np.random.default_rng(0)
# A vector, a matrix, three matrices, one that is positive definite, indices, one index, truth values, and special ones.
V, M, B = RNG.standard_normal(6), RNG.standard_normal((6, 6)), RNG.standard_normal((3, 6, 6))
P = M @ M.T + np.eye(6)
K, AT, T = np.array([4, -7, 0, 2, 9, 2]), np.int64(4), V > 0
S = np.array([np.nan, 1.0, -0.0, 0.0, -np.inf, np.inf])
GIVEN = (V, M, B, P, K, AT, T, S)
# Constants with many zeros.
SPARSE = np.diag(np.arange(1.0, 19)) + np.diag(np.full(7, 0.5), 11)
BATCHED = np.where(RNG.uniform(size=(18, 5, 6)) < 0.1, 1.5, 0.0)
ONE = lax.GatherDimensionNumbers(offset_dims=(), collapsed_slice_dims=(0,), start_index_map=(0,))
TWO = lax.GatherDimensionNumbers(offset_dims=(1,), collapsed_slice_dims=(), start_index_map=(0,))
PUT = lax.ScatterDimensionNumbers(update_window_dims=(), inserted_window_dims=(0,), scatter_dims_to_operand_dims=(0,))


def gathered(mode, at=None):
    return lambda v, m, b, p, k, i, t, s: lax.gather(v, (k if at is None else at)[:, None], ONE, (1,), mode=mode)


def scattered(kind, mode, at=None):
    def function(v, m, b, p, k, i, t, s):
        return getattr(lax, kind)(v, (k if at is None else at)[:, None], v[::-1] + 2, PUT, mode=mode)

    return function


def counted(v, m, b, p, k, i, t, s):
    """A loop whose rounds depend on numbers, in one whose rounds depend on those."""

    def inner(at):
        x, rounds = at
        return x / 2, rounds + 1

    def outer(at):
        x, n = at
        return lax.while_loop(lambda a: jnp.max(jnp.abs(a[0])) > 0.3, inner, (x * 3, n))

    return lax.while_loop(lambda a: a[1] < 9, outer, (v, 0))


def stepped(v, m, b, p, k, i, t, s):
    """Carried values that change places, a loop within the loop, rows in and out, backwards."""

    def step(carry, row):
        x, y, n = carry
        z = lax.fori_loop(0, 2, lambda j, z: jnp.tanh(p @ z / 10) + j, x)
        return (y, x + z[n % 6] * row[0], n + 1), (row[:2] * x[0], z.sum())

    return lax.scan(step, (v, v[::-1], i), m, reverse=True)


CASES = {
    "arithmetic": lambda v, m, b, p, k, i, t, s: (v + m) * v / (m - 2.5) - m % 0.3 + abs(m) ** 2.5 + v**3 - v**-2,
    "elementary": lambda v, m, b, p, k, i, t, s: [
        *(f(v) for f in (jnp.sin, jnp.cos, jnp.tan, jnp.exp, jnp.expm1, jnp.tanh, jnp.sinh, jnp.cosh, jnp.arctan)),
        *(f(abs(v) + 0.1) for f in (jnp.sqrt, jnp.log, jnp.log1p, lax.rsqrt, jnp.cbrt, jnp.exp2)),
        *(f(v / 4) for f in (jnp.arcsin, jnp.arccos, jnp.arctanh, jnp.arcsinh, lax.logistic, lax.erf, lax.erfc)),
        jnp.arctan2(v, v[::-1]),
        jnp.arccosh(1 + abs(v)),
    ],
    "rounding": lambda v, m, b, p, k, i, t, s: [
        f(3 * m) for f in (jnp.floor, jnp.ceil, jnp.round, jnp.trunc, jnp.sign)
    ],
    "whole numbers": lambda v, m, b, p, k, i, t, s: [
        *(k + i, k * k - 3, k // 3, k % 3, abs(k), -k, jnp.sign(k), lax.div(k, k - 2), lax.rem(k, k - 2), k**3),
        *(k & 6, k | 9, k ^ 5, ~k, jnp.maximum(k, 1), k.sum(), k.prod(), k.max(), jnp.clip(k, -1, 3)),
    ],
    "overflow": lambda v, m, b, p, k, i, t, s: [
        (k.astype(jnp.int32) + 2**31 - 5).astype(jnp.int64),
        (k * (2**62 + 1)).astype(jnp.int64),
        (k.astype(jnp.uint32) - 3).astype(jnp.int64),
        (s * 1e300).astype(jnp.int64),
        (v * 1e10).astype(jnp.int32),
    ],
    "truth": lambda v, m, b, p, k, i, t, s: [
        *(t & (v < 1), t | (k > 0), ~t, t ^ (k == 2), t.any(), t.all(), t.astype(float) + t.astype(int)),
        *(jnp.where(t, v, -1.0), jnp.where(t[:, None], m, v), lax.select_n(k % 3, v, 2 * v, 3 * v), k.astype(bool)),
    ],
    "no numbers": lambda v, m, b, p, k, i, t, s: [
        *(jnp.maximum(s, 0.5), jnp.minimum(s, 0.5), jnp.sign(s), jnp.isfinite(s), jnp.isnan(s), s < 1, s != s),
        *(s.max(), s[1:].min(), jnp.argmax(s), jnp.argmin(s), jnp.sort(s), jnp.argsort(s), jnp.clip(s, -1, 1)),
        *(jnp.searchsorted(jnp.sort(v), s), jnp.cumsum(s)),
    ],
    "shapes": lambda v, m, b, p, k, i, t, s: [
        *(b.transpose(2, 0, 1), b.reshape(9, 12), b.transpose(1, 0, 2).reshape(-1), m[1:5:2, ::-1], b[:, 2], m.T[None]),
        *(jnp.concatenate([m, v[None], m[:2]]), jnp.stack([v, k * 1.0], axis=1), jnp.hstack([v, 2.0]), jnp.flip(b, 1)),
        *(jnp.pad(m, ((1, 2), (0, 3)), constant_values=7), lax.pad(m, 0.5, ((-1, 2, 1), (2, -3, 2)))),
        *(jnp.split(m + 1, 3, axis=1), lax.broadcast_in_dim(v, (2, 6, 3), (1,)), jnp.tile(v, 2), jnp.roll(m, 2, 1)),
        *(jnp.diag(m), jnp.eye(6) * v, jnp.arange(6) + v, jnp.unstack(m * 2)[3], jnp.zeros((0, 3)), m[:, :0].sum(1)),
    ],
    "sums": lambda v, m, b, p, k, i, t, s: [
        *(b.sum(), b.sum((0, 2)), b.prod(1), b.max((1, 2)), b.min(0), v[:2].sum(), m[:, :3].sum(1), jnp.linalg.norm(v)),
        *(jnp.cumsum(m, 0), jnp.cumprod(v), lax.cummax(m, 1), lax.cumsum(v, reverse=True), jnp.argmax(m, 1)),
    ],
    "products": lambda v, m, b, p, k, i, t, s: [
        *(m @ p, v @ m, v @ v, jnp.outer(v, v), b @ m, b @ b.transpose(0, 2, 1), k @ k, jnp.cross(v[:3], v[3:])),
        *(SPARSE @ jnp.tile(m, (3, 1)), jnp.tile(b, 3) @ SPARSE, jnp.einsum("aij,jbi->ab", jnp.tile(b, 3), BATCHED)),
        jnp.einsum("aij,akj->aik", jnp.tile(b, 3), BATCHED.T[:3]),
        *(jnp.einsum("aij,bjk->aibk", b, b), jnp.einsum("aij,aij->a", b, b), m[:2, :2] @ p[:2, :3], 2.0 * m @ v),
    ],
    "sorting": lambda v, m, b, p, k, i, t, s: [
        *(jnp.sort(m, 0), jnp.argsort(k), jnp.lexsort((v, k)), jnp.median(v), jnp.interp(v, jnp.sort(v), v)),
    ],
    "factors": lambda v, m, b, p, k, i, t, s: [
        *lax.linalg.lu(m), *lax.linalg.lu(b), lax.linalg.cholesky(p), jnp.linalg.solve(b, m), jnp.linalg.inv(m),
        jnp.linalg.det(m), lax.linalg.cholesky(p - 3 * jnp.eye(6)), lax.linalg.lu(m[:, :4])[0],
    ],
    "triangles": lambda v, m, b, p, k, i, t, s: [
        lax.linalg.triangular_solve(
            b + 4 * jnp.eye(6), 2 * b, left_side=left, lower=lower, transpose_a=turned, unit_diagonal=unit
        )
        for left in (True, False) for lower in (True, False) for turned in (True, False) for unit in (True, False)
    ],
    "indices": lambda v, m, b, p, k, i, t, s: [
        *(v[i], v[i + 7], v[-i], m[i % 6, 1], m[jnp.array([0, 5, 2]), i], m[k % 6], b[jnp.array([2, 0]), :, k[:2] % 6]),
        *(m[:, np.array([0, 2, 4])], m[np.array([3, 0]), np.array([1, 5])], jnp.take(v, k, mode="fill"), v[k]),
        *(m.at[k % 6].add(v), m.at[:, 2].set(v), m.at[i].multiply(3.0), m.at[k % 6, 1].max(2.0), v.at[i].set(1.0)),
        *(lax.dynamic_slice(m, (i, i - 9), (3, 2)), lax.dynamic_update_slice(m, b[0, :2, :2], (i + 1, -1))),
        lax.gather(v, k[:, None], TWO, (2,), mode="clip"),
        jnp.take_along_axis(m, jnp.argsort(m, 1), 1),
    ],
    **{f"gather {mode}": gathered(mode) for mode in ("clip", "fill")},
    **{f"gather {mode} at constants": gathered(mode, K) for mode in ("clip", "fill")},
    **{f"{kind} {mode}": scattered(kind, mode) for kind in ("scatter_add", "scatter_mul") for mode in ("clip", "drop")},
    "scatter drop at constants": scattered("scatter_add", "drop", K),
    "while": counted,
    "scan": stepped,
    "cond": lambda v, m, b, p, k, i, t, s: [
        lax.cond(v[0] > 0, lambda: m @ v, lambda: v),
        *(lax.switch(j, [lambda x: x, lambda x: x @ m, lambda x: (x * 2)[::-1]], v) for j in (i - 9, i - 3, i, k[3])),
    ],
    "derivatives": lambda v, m, b, p, k, i, t, s: [
        jax.jacfwd(lambda x: jnp.linalg.solve(p + jnp.outer(x, x), jnp.sin(x)))(v),
        jax.grad(lambda x: lax.fori_loop(0, 3, lambda j, y: jnp.cos(m @ y), x).sum())(v),
        jax.hessian(lambda x: jnp.prod(x) + x @ m @ x)(v),
    ],
}  # fmt: skip


@pytest.fixture(scope="module")
def functions(tmp_path_factory):
    """All cases in one file, and in one program of JAX."""
    with jax.numpy_dtype_promotion("standard"):
        unit, found = Unit(), {}
        for number, (name, case) in enumerate(CASES.items()):
            found[name] = unit.add(f"f{number}", lambda *a, case=case: jax.tree.leaves(case(*a)), GIVEN)
        library = compiled(unit.source(), tmp_path_factory.mktemp("c"))
        whole = jax.jit(lambda *given: {name: jax.tree.leaves(case(*given)) for name, case in CASES.items()})
        return library, found, whole(*GIVEN)


@pytest.mark.slow("arithmetic", "elementary", "overflow", "rounding", "whole numbers", "truth")
@needs_compiler
@pytest.mark.parametrize("name", CASES)
def test_a_primitive_is_that_of_jax(functions, name):
    library, found, expected = functions
    results = called(library, found[name], *GIVEN)
    for place, (result, wanted) in enumerate(zip(results, expected[name], strict=True)):
        size = np.max(np.abs(wanted), initial=1e-300, where=np.isfinite(wanted))
        np.testing.assert_allclose(
            result, np.asarray(wanted, result.dtype), rtol=ROUND_OFF, atol=ROUND_OFF * size, err_msg=f"{name} {place}"
        )


def beside(model, folder, states, **drives):
    """Largest differences of rates and outputs in C from those in JAX, as shares of the largest of each."""
    found = plant(model, **drives)
    text = "int call(const double *x, const double *u, double *xd, double *y, double *m, double *work, double t)\n"
    text += "{ return plant(0, t, x, u, xd, y, m, work); }\n"
    library = compiled(found.source + text, folder)
    library.call.argtypes = [ctypes.c_void_p] * 6 + [ctypes.c_double]
    system = fm.control.to_nonlinear_system(model, **drives)
    n_u = len(model.labels.inputs)
    near, work = np.array(found.memory), np.full(found.work, np.nan)

    def called(t, x, u, memory=near):
        xd, y = np.full(len(x), np.nan), np.full(len(model.labels.outputs), np.nan)
        assert library.call(*map(pointer, (x, u, xd, y, memory, work)), t) == 0
        return xd, y

    worst = 0.0
    for t, x in enumerate(states):
        u = RNG.standard_normal(n_u)
        xd, y = called(t / 10, x, u)
        for result, wanted in ((xd, system.dynamics(t / 10, x, u)), (y, system.output(t / 10, x, u))):
            worst = max(worst, np.max(np.abs(result - wanted)) / np.max(np.abs(wanted)))
    return worst, found, called


def around(n, size, speed, count=20):
    """Random states."""
    return [np.concatenate([size * RNG.uniform(-1, 1, n), speed * RNG.uniform(-1, 1, n)]) for _ in range(count)]


@pytest.mark.slow
@needs_compiler
def test_the_guide_in_c_is_that_in_jax(tmp_path):
    """Three thousand equations, scans of Newton's method and LU factors among them, and a load as function of time."""
    model = planar_guide(force=(0, -1.0)).build()
    loads = {"left1.x": lambda t: 10 * jnp.sin(30 * t), "right1.x": fm.motion.Table([0.0, 0.7, 5.0], [1.0, 2.0, -3.0])}
    worst, found, _ = beside(model, tmp_path, around(1, 0.02, 0.3, 50), loads=loads)
    assert worst < RELATIVE
    # A loop an operation: written out it was twenty times as long.
    assert len(found.source) < 60_000
    assert plant(model, loads=loads).source == found.source
    # As a unit, beside our own simulation: the importer's tolerance and ours, of a stroke of 19 mm.
    times = np.linspace(0, 0.2, 21)
    expected = fm.simulate(model, times, loads=loads, rtol=1e-9).position("left1", "x")
    for fmi in (2, 3):
        path = tmp_path / f"guide{fmi}.fmu"
        fm.save_fmu(model, path, fmi=fmi, nonlinear=True, loads=loads)
        assert validate_fmu(str(path)) == []
        moved = simulated(path, "cs", 0.2, 0.01, {"force right1.x": 0.0}, relative_tolerance=1e-8)
        np.testing.assert_allclose(moved["position left1.x"], expected, atol=1e-9)


@pytest.mark.slow
@needs_compiler
def test_a_guide_in_space_in_c_is_that_in_jax(tmp_path):
    b = spatial_guide(extra=(5,))
    with pytest.warns(fm.BeamTheoryWarning):
        model = b.build()
    worst, found, call = beside(model, tmp_path, around(1, 0.02, 0.3))
    assert worst < RELATIVE
    assert [v.name for v in found.states] == ["left1.y", "d left1.y"]
    # Too far away for Newton's method: as if one had gone there slowly.
    slowly = [call(0.0, np.array([way, 0.0]), np.zeros(1)) for way in np.linspace(0, 0.085, 100)]
    at_once = call(0.0, np.array([0.085, 0.0]), np.zeros(1), np.array(found.memory))
    np.testing.assert_allclose(np.concatenate(at_once), np.concatenate(slowly[-1]), rtol=1e-9, atol=1e-12)


@pytest.mark.slow
def test_turns_are_counted_in_c_too(tmp_path):
    """Wheels that mesh with no stress, at once far from where they were."""
    still = [np.array([turn, -turn / 2, 0.0, 0.0]) for turn in (1.0, 4.0, -300.0)]
    _, _, call = beside(meshing_wheels(50.0).build(), tmp_path, [still[0] + 0.1])
    for state in still:
        # Round-off of 300 rad times 1000 N m/rad over 0.01 kg m^2.
        np.testing.assert_allclose(call(0.0, state, np.array([0.01, 0.08]))[0], [0, 0, 1, 2], atol=1e-7)
        np.testing.assert_allclose(call(0.0, state, np.zeros(2))[1], state[:2], rtol=1e-12)


def cart():
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("cart", (1, 0))
    b.add(planar.truss, "wall", "cart", section=fm.Rigidity(EA=100.0))
    b.fix("wall")
    b.fix("cart", "y")
    b.mass("cart", 2.0)
    b.input("cart", "x")
    b.output("cart", "x")
    return b.build()


def test_what_c_cannot_do_is_refused_by_name():
    model = cart()

    def wind(t):
        return jax.pure_callback(np.sin, jax.ShapeDtypeStruct((), float), t)

    def gust(t):
        return jnp.linalg.eigvalsh(jnp.diag(jnp.stack([t, 2 * t])))[0]

    with pytest.raises(fm.ModelError, match=r"Python.*pure_callback of `sin` in wind, test_translate.py:\d+"):
        plant(model, loads={"cart.x": wind})
    with pytest.raises(fm.ModelError, match=r"`eigh` in gust, test_translate.py:\d+ has no translation to C"):
        plant(model, loads={"cart.x": gust})
    with pytest.raises(fm.ModelError, match="returns numbers of type float32"):
        Unit().add("f", lambda x: x.astype(jnp.float32) + 1, (1.0,))
