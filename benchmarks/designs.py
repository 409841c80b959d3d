"""Cost of a gradient by six dimensions and of a thousand designs of the spatial guide, compile apart."""

import json
import os
import platform
import sys
import time
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

import flexmb as fm
from flexmb import spatial
from flexmb.build.carry import carried
from flexmb.design.evaluate import build_once
from flexmb.design.sweep import _kernel

POINT = {"length": 0.1, "width": 0.018, "thickness": 5e-4, "distance": 0.1, "stage": 0.2, "E": 210e9}
REPEATS = 15


def guide(beams: int):
    """Builder of the guide with 2 leaf springs of some beams each, all deformations free."""

    def build(length, width, thickness, distance, stage, E):
        leaf = fm.Rectangle(width, thickness, fm.Material(E=E, G=80e9, rho=7850.0))
        b = fm.Builder()
        for name, y in (("left", 0.0), ("right", distance)):
            for i in range(beams + 1):
                b.node(f"{name}{i}", (0.0, y, length * i / beams))
            for i in range(beams):
                b.add(spatial.beam, f"{name}{i}", f"{name}{i + 1}", name=f"{name} {i + 1}", section=leaf, y=(1, 0, 0))
            b.fix(f"{name}0")
        b.add(spatial.beam, f"left{beams}", f"right{beams}", name="bar", y=(1, 0, 0))
        for name in ("left", "right"):
            b.mass(f"{name}{beams}", stage / 2)
        return b.build()

    return build


def first(model):
    """First natural frequency [Hz]."""
    return fm.frequencies(model, count=1)[0]


def timed(call) -> float:
    """Seconds of one call, finished."""
    start = time.perf_counter()
    jax.block_until_ready(call())
    return time.perf_counter() - start


def measure(beams: int) -> dict:
    """Ratio of gradient to value, interleaved; agreement with central differences; a thousand designs."""
    build = guide(beams)
    models = build_once(build, POINT)
    at = jnp.array(list(POINT.values()))

    def value(flat):
        with carried(models):
            return first(build(**dict(zip(POINT, flat, strict=True))))

    plain, both = fm.jit(value), fm.jit(jax.value_and_grad(value))
    compile_plain, compile_both = timed(lambda: plain(at)), timed(lambda: both(at))
    runs = np.array([(timed(lambda: plain(at)), timed(lambda: both(at))) for _ in range(REPEATS)])
    slopes = np.asarray(both(at)[1] * at)
    differences = []
    for i in range(len(at)):
        step = np.zeros(len(at))
        step[i] = 1e-5
        differences.append(float(plain(at * (1 + step)) - plain(at * (1 - step))) / 2e-5)
    error = np.max(np.abs(slopes - differences)) / np.max(np.abs(slopes))
    rng = np.random.default_rng(0)
    designs = {name: v * rng.uniform(0.8, 1.2, 1000) for name, v in POINT.items()}
    kernel = _kernel(build, {"first": first}, True, 1)
    compile_sweep = timed(lambda: kernel(designs, 1000)[0]["first"])
    sweeps = [timed(lambda: kernel(designs, 1000)[0]["first"]) for _ in range(5)]
    medians = np.median(runs, axis=0)
    return {
        "beams": beams,
        "value_ms": 1e3 * medians[0],
        "value_and_gradient_ms": 1e3 * medians[1],
        "gradient_over_value": float(np.median((runs[:, 1] - runs[:, 0]) / runs[:, 0])),
        "error_against_differences": float(error),
        "thousand_designs_s": float(np.median(sweeps)),
        "compile_s": [compile_plain, compile_both, compile_sweep],
    }


if __name__ == "__main__":
    fm.enable_x64()
    fm.enable_cache()
    about = {
        "python": sys.version.split()[0],
        "jax": jax.__version__,
        "cpu": platform.processor(),
        "cores": os.cpu_count(),
    }
    found = {**about, "date": time.strftime("%Y-%m-%d"), "runs": [measure(beams) for beams in (2, 8)]}
    text = json.dumps(found, indent=1)
    (Path(__file__).parent / "results" / "designs.json").write_text(text + "\n")
    print(text)
