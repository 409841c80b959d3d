"""What lean models cost and what they save: degrees of freedom, error and its estimate, time of a motion.

``python benchmarks/lean.py`` prints the table that README quotes and writes results/lean.json.
"""

import dataclasses
import functools
import sys
import time
from pathlib import Path

HERE = Path(__file__).parent
RUNS = 7


def main() -> None:
    """Compute, time, print and save."""
    import jax.numpy as jnp
    import numpy as np
    from motion import STROKE, at_rest, guide, tight
    from record import PACKAGES, interleaved, save, show

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
    run = {f"frequencies, {name}": lambda m=m: fm.frequencies(m).block_until_ready() for name, m in models.items()}
    # One second of motion of the guide of motion.py, released from 1 mm.
    times = np.linspace(0, 1, 101)
    for plane in (True, False):
        where = "plane" if plane else "space"
        whole = guide(plane)
        bent = at_rest(whole)
        small = fm.lean(whole, bandwidth=100.0)
        place = int(whole.labels.known("right2")[0])
        exact = tight(plane)
        for name, model in (("full", whole), ("lean", small.model)):
            start = dataclasses.replace(bent, e=jnp.zeros(model.topology.n_e), labels=model.labels)
            call = functools.partial(fm.simulate, model, times, initial=start, rtol=1e-4, throw=False)
            end = call()
            off = float(np.max(np.abs(np.asarray(end.x[:, place]) - exact)) / STROKE)
            found[f"motion in {where}, {name}"] = {
                "degrees_of_freedom": model.topology.n_q,
                "steps": int(end.steps),
                "result": int(end.result),
                "error": off,
            }
            print(f"motion in {where}, {name}: {found[f'motion in {where}, {name}']}", flush=True)
            run[f"one second of motion in {where}, {name}"] = lambda call=call: call().x.block_until_ready()
    timed = interleaved(run, RUNS)
    show("Full and lean, compiled", timed)
    save("lean", {"found": found, "times": timed}, (*PACKAGES, "diffrax"))


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
