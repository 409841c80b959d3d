"""Cost of one design of the spatial guide: its first frequency, the gradient by six dimensions, a thousand designs.

``python benchmarks/designs.py`` prints the table that README quotes, writes results/designs.json and draws
results/designs.png; with the extra ``peers`` Exudyn stands beside it. Compile times are apart.
"""

import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).parent
POINT = {"length": 0.1, "width": 0.018, "thickness": 5e-4, "distance": 0.1, "stage": 0.2, "E": 210e9}
BEAMS = (2, 4, 8)
EXUDYN_BEAMS = (2, 4, 8, 16)
DESIGNS = 1000
# Relative step of Exudyn's differences; smaller ones are noise.
STEP = 1e-3


def guide(beams: int):
    """Function from dimensions to the guide with two leaf springs of some beams each, all deformations free.

    Args:
        beams: A leaf spring.
    """
    import flexmb as fm
    from flexmb import spatial

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
    """First natural frequency [Hz].

    Args:
        model: Mechanism.
    """
    import flexmb as fm

    return fm.frequencies(model, count=1)[0]


def once(call) -> float:
    """Seconds of a first call, compiling included.

    Args:
        call: What to call.
    """
    import jax

    begin = time.perf_counter()
    jax.block_until_ready(call())
    return time.perf_counter() - begin


def kernels(beams: int):
    """Compiled functions of designs of the guide.

    Args:
        beams: A leaf spring.

    Returns:
        The first frequency, of six dimensions; the same with its gradient; first frequencies of a thousand designs, and
        whether they failed, of nothing.
    """
    import jax
    import numpy as np

    import flexmb as fm
    from flexmb.build.carry import carried_choices
    from flexmb.compilation.threads import cores
    from flexmb.design.chunks import Chunk, Task, kernel_of
    from flexmb.design.evaluate import build_once

    build = guide(beams)
    models = build_once(build, POINT)

    def value(flat):
        with carried_choices(models):
            return first(build(**dict(zip(POINT, flat, strict=True))))

    draw = np.random.default_rng(0)
    # Not more: the shear modulus stays, and Poisson's ratio has to be possible.
    part = Chunk({name: v * draw.uniform(0.9, 1.1, DESIGNS) for name, v in POINT.items()}, DESIGNS)
    example = {name: np.asarray(value) for name, value in POINT.items()}
    kernel = kernel_of(Task(build, {"first": first}, True, 1, example), threads=cores())
    return fm.jit(value), fm.jit(jax.value_and_grad(value)), lambda: kernel(part)


def ours(beams: int, found: dict, run: dict) -> None:
    """Add our functions to time, and what they found: frequency, gradient against differences, compile times.

    Args:
        beams: A leaf spring.
        found: Entries by name, added to.
        run: Functions to time by name, added to.
    """
    import jax
    import jax.numpy as jnp
    import numpy as np

    at = jnp.array(list(POINT.values()))
    plain, both, many = kernels(beams)
    compiled = [once(call) for call in (lambda: plain(at), lambda: both(at), lambda: many()[0])]
    slopes, differences = np.asarray(both(at)[1] * at), []
    for i in range(len(at)):
        step = np.eye(len(at))[i] * 1e-5
        differences.append(float(plain(at * (1 + step)) - plain(at * (1 - step))) / 2e-5)
    error = float(np.max(np.abs(slopes - differences)) / np.max(np.abs(slopes)))
    assert error < 1e-6, error
    assert not np.any(many()[1])
    frequency = float(plain(at))
    entry = {"frequency": frequency, "slopes": (slopes / frequency).tolist()}
    entry |= {"gradient_error": error, "compile_s": compiled}
    found[f"flexmb, one design: {beams}"] = entry
    run[f"flexmb, one design: {beams}"] = lambda: plain(at).block_until_ready()
    run[f"flexmb, one design and its gradient: {beams}"] = lambda: jax.block_until_ready(both(at))
    run[f"flexmb, each of a thousand: {beams}"] = many


def peers(found: dict, run: dict, gradient) -> tuple[str, ...]:
    """Add Exudyn, where it is installed: a design built anew, and the gradient by central differences.

    Args:
        found: Entries by name, added to.
        run: Functions to time by name, added to.
        gradient: Ours with 8 beams, d ln f/d ln dimension.

    Returns:
        Names of the packages that took part.
    """
    import numpy as np
    import peer_exudyn

    import flexmb as fm

    if not peer_exudyn.installed():
        print("Exudyn is not installed and is left out: pip install -e '.[peers]' brings it.")
        return ()

    def frequency(elements, point):
        leaf = fm.Rectangle(
            point["width"], point["thickness"], fm.Material(E=point["E"], G=80e9, rho=7850.0), shear=True
        )
        own = leaf.rigidity(), point["length"], point["distance"], point["stage"]
        return peer_exudyn.first_frequency(*own, elements)

    def slopes(elements):
        steps = [{**POINT, name: POINT[name] * (1 + s)} for name in POINT for s in (STEP, -STEP)]
        values = np.log([frequency(elements, point) for point in steps]).reshape(-1, 2)
        return (values[:, 0] - values[:, 1]) / (2 * STEP)

    for n in EXUDYN_BEAMS:
        off = float(np.max(np.abs(slopes(n) - gradient)) / np.max(np.abs(gradient)))
        found[f"Exudyn, one design: {n}"] = {"frequency": frequency(n, POINT), "gradient_error": off}
        run[f"Exudyn, one design: {n}"] = lambda n=n: frequency(n, POINT)
        run[f"Exudyn, gradient by differences: {n}"] = lambda n=n: slopes(n)
    return ("exudyn",)


def main() -> None:
    """Compute, time, print, save and draw."""
    import numpy as np
    from record import PACKAGES, chart, interleaved, save, show

    import flexmb as fm

    fm.enable_x64()
    # An empty cache: code is optimised as for one, and compiled anew.
    folder = tempfile.TemporaryDirectory()
    fm.enable_cache(folder.name)
    found: dict[str, dict] = {}
    run: dict = {}
    for beams in BEAMS:
        ours(beams, found, run)
    exact = float(first(guide(32)(**POINT)))
    took_part = peers(found, run, np.array(found[f"flexmb, one design: {BEAMS[-1]}"]["slopes"]))
    if took_part:
        # The peer's error falls with order two: extrapolated to no element length, it agrees with ours.
        coarse, fine = (found[f"Exudyn, one design: {n}"]["frequency"] for n in EXUDYN_BEAMS[-2:])
        limit = (4 * fine - coarse) / 3
        print(f"Exudyn extrapolated: {limit:.6f} Hz, ours {exact:.6f} Hz")
        np.testing.assert_allclose(limit, exact, rtol=2e-4)
    times = interleaved(run)
    for name, t in times.items():
        if "thousand" in name:
            times[name] = {key: value / DESIGNS for key, value in t.items()}
    show("First frequency of the guide, a design", times)
    for name, entry in found.items():
        entry["error"] = abs(entry["frequency"] / exact - 1)
        errors = f"error {entry['error']:.1e}, of the gradient {entry['gradient_error']:.1e}"
        print(f"{name:<32}{entry['frequency']:11.6f} Hz, {errors}")
    for beams in BEAMS:
        one, both = (times[f"flexmb, one design{more}: {beams}"]["median"] for more in ("", " and its gradient"))
        print(f"{beams} beams: the gradient costs {both / one - 1:.2f} designs")
    save("designs", {"frequency": exact, "found": found, "times": times}, PACKAGES + took_part)
    errors = {name: {"error": found[_design(name)]["error"]} for name in times}
    title, label = "First frequency of the guide; beams a leaf spring", "error of the frequency"
    chart("designs", errors, times, title, "time of a design, compiled", label)


def _design(name: str) -> str:
    """Entry of the same discretisation."""
    return f"{name.split(',')[0]}, one design: {name.rsplit(': ', 1)[1]}"


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
