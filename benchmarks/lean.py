"""What lean models cost and what they save: degrees of freedom, error and its estimate, time of a motion.

``python benchmarks/lean.py`` prints the table that README quotes and writes results/lean.json.
"""

import functools
import sys
import time
from pathlib import Path

HERE = Path(__file__).parent
RUNS = 7


def main() -> None:
    """Compute, time, print and save."""
    import numpy as np
    from record import interleaved, save, show

    import flexmb as fm
    from flexmb.mechanisms import mechanism_path

    fm.enable_x64()
    fm.enable_cache()
    full = fm.read_spacar(mechanism_path("pf3d19dof")).builder.build()
    models = {"full": full}
    found = {}
    for bandwidth in (100.0, 200.0, 260.0):
        begin = time.perf_counter()
        small = fm.lean(full, bandwidth=bandwidth)
        models[f"lean up to {bandwidth:g} Hz"] = small.model
        count = small.model.topology.n_q
        off = np.abs(np.asarray(fm.frequencies(small.model))[:count] / np.asarray(fm.frequencies(full))[:count] - 1)
        found[f"{bandwidth:g}"] = {
            "degrees_of_freedom": count,
            "error": float(np.max(off)),
            "estimate": small.error.frequencies,
            "seconds": time.perf_counter() - begin,
        }
        assert np.max(off) <= small.error.frequencies * (1 + 1e-9)
        print(small.report(), end="\n\n")
    times = np.linspace(0, 0.2, 21)
    run = {}
    for name, model in models.items():
        b = functools.partial(fm.simulate, model, times, form="reduced", loads={"3.y": push}, rtol=1e-5, throw=False)
        end = b()
        found[f"motion, {name}"] = {"steps": int(end.steps), "result": int(end.result), "y": float(end.at("3")[-1, 1])}
        if not int(end.result):
            run[f"0.2 s of motion, {name}"] = lambda b=b: b().x.block_until_ready()
        run[f"frequencies, {name}"] = lambda model=model: fm.frequencies(model).block_until_ready()
    timed = interleaved(run, RUNS)
    show("Full and lean, compiled", timed)
    save("lean", {"found": found, "times": timed})


def push(t):
    """A push of the stage that comes and goes [N].

    Args:
        t: Time [s].
    """
    import jax.numpy as jnp

    return jnp.sin(2 * jnp.pi * 5.0 * t)


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
