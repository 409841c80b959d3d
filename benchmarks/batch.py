"""Time of a design against the number of designs in one call: one after the other, or side by side (vmap).

``python benchmarks/batch.py`` prints the table, writes results/batch.json and draws results/batch.png. Answers are
the first frequency of the spatial guide and its gradient by six dimensions. Where jax sees a GPU, it takes part.
"""

import sys
from pathlib import Path

HERE = Path(__file__).parent
SIZES = (1, 8, 64, 512)
# LAPACK side by side in larger batches can hang on a CPU, whence the default of fm.sweep: one after the other.
SIDE_BY_SIDE = 64
BEAMS = 2
RUNS = 7


def kernels(build, models):
    """Functions of a batch of designs, (designs, dimensions), by name.

    Args:
        build: Function from dimensions to the guide.
        models: What a design takes over of the first one.
    """
    import jax
    from designs import POINT, first

    import flexmb as fm
    from flexmb.build.carry import carried_choices

    def value(flat):
        with carried_choices(models):
            return first(build(**dict(zip(POINT, flat, strict=True))))

    found = {}
    for what, function in (("frequency", value), ("gradient", jax.value_and_grad(value))):
        found[f"{what}, one after the other"] = fm.jit(lambda many, f=function: jax.lax.map(f, many))
        found[f"{what}, side by side"] = fm.jit(jax.vmap(function))
    return found


def main() -> None:
    """Compute, time, print, save and draw."""
    import jax
    import jax.numpy as jnp
    import numpy as np
    from designs import POINT, guide, once
    from record import PACKAGES, interleaved, save, show

    import flexmb as fm
    from flexmb.design.evaluate import build_once

    fm.enable_x64()
    fm.enable_cache()
    build = guide(BEAMS)
    models, draw = build_once(build, POINT), np.random.default_rng(0)
    designs = np.array(list(POINT.values())) * draw.uniform(0.9, 1.1, (SIZES[-1], len(POINT)))
    exact = np.array([float(fm.frequencies(build(**dict(zip(POINT, d, strict=True))))[0]) for d in designs[:8]])
    run, first_s = {}, {}
    for device in dict.fromkeys((jax.devices("cpu")[0], jax.devices()[0])):
        with jax.default_device(device):
            for what, kernel in kernels(build, models).items():
                for size in SIZES:
                    if "side" in what and device.platform == "cpu" and size > SIDE_BY_SIDE:
                        continue
                    many = jax.device_put(jnp.asarray(designs[:size]), device)
                    name = f"{device.platform}, {what}: {size}"
                    first_s[name] = once(lambda k=kernel, m=many: k(m))
                    values = kernel(many)
                    values = np.asarray(values[0] if isinstance(values, tuple) else values)
                    np.testing.assert_allclose(values[:8], exact[:size], rtol=1e-9)
                    run[name] = lambda k=kernel, m=many: jax.block_until_ready(k(m))
    times = interleaved(run, RUNS)
    for name, t in times.items():
        times[name] = {key: value / int(name.rsplit(": ", 1)[1]) for key, value in t.items()}
    show("A design of a batch", times)
    save("batch", {"first_call_s": first_s, "times": times}, PACKAGES)
    draw_chart(times)


def draw_chart(times: dict[str, dict[str, float]]) -> None:
    """Time of a design against the size of the batch.

    Args:
        times: Of each, by names "family: size" [s].
    """
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from record import RESULTS

    figure, axes = plt.subplots(figsize=(6.8, 4.2), layout="constrained")
    for family, marker in zip(dict.fromkeys(name.rsplit(": ", 1)[0] for name in times), "osD^v<>P", strict=False):
        sizes = [n for n in SIZES if f"{family}: {n}" in times]
        axes.loglog(sizes, [1e3 * times[f"{family}: {n}"]["median"] for n in sizes], marker=marker, label=family)
    axes.set_xlabel("designs in one call")
    axes.set_ylabel("time of a design, compiled [ms]")
    axes.set_title("First frequency of the spatial guide, two beams a leaf spring", fontsize=11)
    axes.grid(True, which="major", alpha=0.4)
    axes.legend(fontsize=8)
    figure.savefig(RESULTS / "batch.png", dpi=120)


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
