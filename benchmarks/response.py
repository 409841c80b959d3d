"""Frequency response of the spatial guide: 2000 frequencies, 6 x 6, beside python-control and SciPy.

Errors are those against solutions with nineteen digits. ``python benchmarks/response.py`` prints and draws what README
quotes and writes results/response.json and results/response.png.
"""

import time
import warnings
from typing import Any

import control
import jax
import jax.numpy as jnp
import numpy as np
import scipy.signal
from record import chart, interleaved, save, show
from scenes import guide

import flexmb as fm

FREQUENCIES = 2000
RUNS = 7
COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")


def exact(lin, hertz):
    """Responses by solutions that are refined with long numbers.

    Args:
        lin: Linearization.
        hertz: Frequencies, (n_f,) [Hz].
    """
    second = fm.control.second_order(lin)
    k, d, m, b, c = (
        np.asarray(of).astype(np.clongdouble) for of in (second.K, second.C, second.M, second.B0, second.C0)
    )
    found = []
    for w in 2 * np.pi * hertz.astype(np.longdouble):
        z = k + 1j * w * d - w**2 * m
        inverse = np.linalg.inv(z.astype(complex))
        x = np.zeros(b.shape, np.clongdouble)
        for _ in range(4):
            x = x + inverse @ (b - z @ x)
        found.append(c @ x)
    return np.array(found)


def by_scipy(plant, hertz):
    """Responses pair by pair, as SciPy's function takes them."""
    w, found = 2 * np.pi * hertz, np.zeros((len(hertz), plant.noutputs, plant.ninputs), complex)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for i in range(plant.noutputs):
            for j in range(plant.ninputs):
                one = scipy.signal.StateSpace(plant.A, plant.B[:, [j]], plant.C[[i]], plant.D[[i]][:, [j]])
                found[:, i, j] = scipy.signal.freqresp(one, w)[1]
    return found


def main() -> None:
    """Measure, check, print, draw and save."""
    fm.enable_x64()
    warnings.simplefilter("ignore", fm.BeamTheoryWarning)
    builder = guide(signals=COMPONENTS)
    lin = fm.damped(builder, ratio=0.005)
    hertz: Any = np.logspace(0, 4, FREQUENCIES)
    plant = fm.to_statespace(lin)
    reference = exact(lin, hertz)
    size = np.linalg.norm(reference.astype(complex), axis=(1, 2))

    start = time.perf_counter()
    fm.frequency_response(lin, hertz)
    compiling = time.perf_counter() - start

    # In the same process, so that all have the same thread of LAPACK.
    inside = jax.jit(lambda lin, hertz: fm.frequency_response(lin, hertz).response)
    slope = jax.jit(jax.jacfwd(lambda eta, lin: jnp.abs(fm.frequency_response(lin, hertz, loss_factor=eta).response)))
    matrix = jnp.asarray(np.asarray(lin.K))
    eigh = jax.jit(jnp.linalg.eigh)
    variants = {
        "flexmb, by modes": lambda: np.asarray(fm.frequency_response(lin, hertz).response),
        "flexmb, by modes, in jax.jit": lambda: np.asarray(inside(lin, hertz)),
        "flexmb, direct": lambda: np.asarray(fm.frequency_response(lin, hertz, method="direct").response),
        "python-control": lambda: np.moveaxis(plant(2j * np.pi * hertz, squeeze=False), -1, 0),
        "SciPy, pair by pair": lambda: by_scipy(plant, hertz),
        "flexmb, with a derivative": lambda: np.asarray(slope(0.01, lin)),
        "one jnp.linalg.eigh of that size": lambda: jax.block_until_ready(eigh(matrix)),
    }
    times = interleaved(variants, RUNS)
    found = {}
    for name in list(variants)[:5]:
        error = np.linalg.norm(np.asarray(variants[name]()) - reference.astype(complex), axis=(1, 2)) / size
        found[name] = {"error": float(np.max(error)), "median error": float(np.median(error))}
        print(f"{name:<34} error at most {np.max(error):.1e}, median {np.median(error):.1e}")
    assert found["flexmb, by modes"]["error"] < 1e-8
    show(f"{FREQUENCIES} frequencies x 6 x 6, {len(matrix)} degrees of freedom", times)
    print(f"first call, compiled: {compiling:.2f} s; control {control.__version__}")
    title = f"Frequency response of a spatial guide: {FREQUENCIES} frequencies × 6 × 6"
    drawn = {f"{name}: {FREQUENCIES}": of for name, of in found.items()}
    chart("response", drawn, {f"{name}: {FREQUENCIES}": times[name] for name in found}, title, "time", "largest error")
    own = {"frequencies": FREQUENCIES, "freedoms": len(matrix), "compiling": compiling, "times": times, "errors": found}
    save("response", own, ("jax", "jaxlib", "numpy", "scipy", "control"))


if __name__ == "__main__":
    main()
