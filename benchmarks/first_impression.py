"""How long a user waits: cold and cached start, one evaluation, its gradient, a thousand designs.

``python benchmarks/first_impression.py`` prints the table that README quotes and writes results/first_impression.json.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
START = """
import flexmb as fm
fm.enable_x64()
{cache}
from scenes import guide
print(float(fm.frequencies(guide())[0]))
"""
RUNS = 7
DESIGNS = 1000


def fresh_process(cache: str | None) -> float:
    """Frequency from a fresh process, import included.

    Args:
        cache: Folder of compiled code, or None to compile without one.
    """
    code = START.format(cache=f"fm.enable_cache({cache!r})" if cache else "")
    # Python's own compiled code lies beside the text of an installed package.
    around = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    paths = os.pathsep.join([str(HERE), os.environ.get("PYTHONPATH", "")])
    environment = {**around, "PYTHONPATH": paths, "JAX_PLATFORMS": "cpu"}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    return float(run.stdout)


def kernels():
    """The spatial guide, and functions of its numbers inside ``jax.jit``.

    Returns:
        The guide; its first frequency, of parameters; the same with its gradient; first frequencies of as many guides
        as there are rows of thickness and width, (designs, 2) [m]; such rows.
    """
    import jax
    import jax.numpy as jnp
    import numpy as np
    from scenes import guide

    import flexmb as fm

    model = guide()
    names = model.q_labels

    def lowest(parameters):
        return fm.frequencies(fm.Model(model.topology, parameters, model.labels))[0]

    def of_dimensions(dimensions):
        return fm.frequencies(guide(*dimensions, dofs=names))[0]

    batch = jax.jit(lambda d: jax.lax.map(of_dimensions, d, batch_size=50))
    drawn = np.random.default_rng(1).uniform([4e-4, 0.015], [6e-4, 0.02], (DESIGNS, 2))
    return model, jax.jit(lowest), jax.jit(jax.value_and_grad(lowest)), batch, jnp.asarray(drawn)


def main() -> None:
    """Measure, check the answers, print and save."""
    import jax
    import jax.numpy as jnp
    import numpy as np
    from record import interleaved, save, show
    from scenes import guide

    import flexmb as fm
    from flexmb.compilation.by_meaning import run_of
    from flexmb.compilation.compile import QUICK, THOROUGH, compile_thoroughly

    fm.enable_x64()
    with tempfile.TemporaryDirectory() as folder:
        fresh_process(folder)
        starts = interleaved(
            {
                "fresh process, nothing cached": lambda: fresh_process(None),
                "fresh process, compiled code cached": lambda: fresh_process(folder),
                "python -c 'import jax.numpy'": lambda: subprocess.run(
                    [sys.executable, "-c", "import jax.numpy"], check=True
                ),
            },
            RUNS,
        )
    show("Start to first frequencies, spatial guide of two beams a leaf spring", starts)

    model, optimised, lowest_and_gradient, batch, dimensions = kernels()
    n_q, names = model.topology.n_q, model.q_labels
    symmetric = np.random.default_rng(0).standard_normal((n_q, n_q))
    symmetric = jnp.asarray(symmetric + symmetric.T)
    eigh = jax.jit(jnp.linalg.eigh)

    def thorough(yes):
        compile_thoroughly(yes)
        return fm.frequencies(model).block_until_ready()

    warm = interleaved(
        {
            "frequencies(model), compiled for a cache": lambda: thorough(True),
            "frequencies(model), compiled without one": lambda: thorough(False),
            "jit(frequency of parameters)": lambda: optimised(model.parameters).block_until_ready(),
            "frequency and gradient by every number": lambda: jax.block_until_ready(
                lowest_and_gradient(model.parameters)
            ),
            f"jnp.linalg.eigh, {n_q} x {n_q}": lambda: jax.block_until_ready(eigh(symmetric)),
        },
        RUNS,
        repeat=100,
    )
    show("One evaluation, compiled", warm)
    many = interleaved(
        {f"{DESIGNS} designs of thickness and width": lambda: batch(dimensions).block_until_ready()}, RUNS
    )
    show("Many designs, compiled", many)

    options = {
        "compiled as jax.jit does": {},
        "compiled as the analyses are without a cache": QUICK,
        "compiled as the analyses are for a cache": THOROUGH,
    }

    def compile_time(own):
        jax.clear_caches()
        return optimised.lower(model.parameters).compile(compiler_options=own)

    compiling = interleaved({n: lambda own=own: compile_time(own) for n, own in options.items()}, RUNS)
    show("Trace and compile", compiling)

    widths = iter(np.linspace(0.015, 0.02, 100))

    def gradient(forgotten):
        if forgotten:
            jax.clear_caches()
            run_of.cache_clear()
        width = next(widths)
        # Another function each time, as a cell of a notebook that runs again defines it.
        value, slope = fm.jit(jax.value_and_grad(lambda t: fm.frequencies(guide(t, width, dofs=names))[0]))(5e-4)
        return float(value), float(slope)

    gradient(True)
    defining = interleaved(
        {
            "gradient by thickness, first time": lambda: gradient(True),
            "the same, defined anew with another width": lambda: gradient(False),
        },
        RUNS,
    )
    show("Functions of a design", defining)

    # The answers: a design of the batch as if alone, the gradient against a central difference.
    found = batch(dimensions)
    alone = [float(fm.frequencies(guide(*map(float, d), dofs=names))[0]) for d in dimensions[:3]]
    np.testing.assert_allclose(found[:3], alone, rtol=1e-9)
    t, step = 5e-4, 5e-9

    def of_thickness(t):
        return fm.frequencies(guide(t, 0.018, dofs=names))[0]

    slope, value = float(fm.jit(jax.grad(of_thickness))(t)), fm.jit(of_thickness)
    np.testing.assert_allclose(slope, float(value(t + step) - value(t - step)) / (2 * step), rtol=1e-6)
    save(
        "first_impression",
        {
            "starts": starts,
            "warm": warm,
            "many": many,
            "compiling": compiling,
            "defining": defining,
            "degrees_of_freedom": n_q,
        },
    )


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
