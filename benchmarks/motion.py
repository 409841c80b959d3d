"""Error against time of one second of motion of a guide of steel, released from 1 mm.

``python benchmarks/motion.py`` prints the tables that README quotes, writes results/motion.json and draws
results/motion.png. Compile times come from fresh processes, without a cache and with compiled code cached.
"""

import functools
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).parent
RUNS = 7
TOLERANCES = (1e-3, 3e-4, 1e-4, 1e-5)
STROKE = 1e-3
# A call that takes longer is not repeated, and one that took longer with compiling is not made again [s].
SLOW, LONGEST = 5.0, 30.0
FIRST = """
import time
import numpy as np
import flexmb as fm
fm.enable_x64()
{cache}
from motion import at_rest, guide
model = guide({plane!r})
bent = at_rest(model)
begin = time.perf_counter()
fm.simulate(model, np.linspace(0, 1, 11), initial=bent).x.block_until_ready()
print(time.perf_counter() - begin)
"""


def guide(plane: bool, fixed: bool = False):
    """Two leaf springs of two beams each with a bar on top: all deformations, or with their elongations FIXED.

    Args:
        plane: In the plane, otherwise in space.
        fixed: Whether elongations are FIXED.
    """
    import flexmb as fm
    from flexmb import planar, spatial

    leaf = fm.Rectangle(0.018, 0.0005, fm.Material(E=210e9, G=80e9, rho=7850.0))
    b = fm.Builder()
    element = planar.beam if plane else spatial.beam
    across = {} if plane else {"y": (0, 1, 0)}
    bending = (2, 3) if plane else (2, 3, 4, 5, 6)
    for side, place in (("left", 0.0), ("right", 0.1)):
        for i in range(3):
            height = 0.05 * i
            b.node(f"{side}{i}", (place, height) if plane else (place, 0.0, height))
        for i in range(2):
            released = {"released": bending} if fixed else {}
            b.add(element, f"{side}{i}", f"{side}{i + 1}", name=f"{side} {i + 1}", section=leaf, **across, **released)
        b.fix(f"{side}0")
    b.add(element, "left2", "right2", name="bar", section=fm.Rigidity(mass=2.0), released=(), **across)
    b.mass("right2", 0.006)
    return b.build()


def at_rest(model, push: float | None = None):
    """Equilibrium with the bar displaced by 1 mm, or by a given force.

    Args:
        model: Mechanism.
        push: Force along x [N].
    """
    import dataclasses

    import jax.numpy as jnp

    import flexmb as fm

    index = int(model.labels.known("right2")[0])

    def pushed(force):
        loads = dataclasses.replace(model.parameters.loads, force=jnp.zeros(model.topology.n_x).at[index].set(force))
        parameters = dataclasses.replace(model.parameters, loads=loads)
        return fm.equilibrium(fm.Model(model.topology, parameters, model.labels))

    if push is not None:
        return pushed(push)
    force, moved = 1.0, 0.0
    for _ in range(4):
        found = pushed(force)
        moved = float(found.x[index] - model.parameters.reference[index])
        force *= STROKE / moved
    return found


def by_thickness(plane: bool, times, rtol: float):
    """Position of the bar over time by the thickness of the leaf springs over its own, and the same with its slope.

    Args:
        plane: In the plane, otherwise in space.
        times: Of the output [s].
        rtol: Tolerance.
    """
    import dataclasses

    import diffrax
    import jax

    import flexmb as fm

    model = guide(plane)
    place = int(model.labels.known("right2")[0])
    force = 1.0 / float(fm.compliance(model, "right2")[0, 0]) * STROKE

    def thicker(section, scale):
        if isinstance(section, tuple):
            return tuple(thicker(one, scale) for one in section)
        return (
            dataclasses.replace(section, thickness=scale * section.thickness)
            if "thickness" in dir(section)
            else section
        )

    def position(scale):
        own = tuple(
            {**block, "section": thicker(block["section"], scale)} if "section" in block else block
            for block in model.parameters.properties
        )
        changed = fm.Model(model.topology, dataclasses.replace(model.parameters, properties=own), model.labels)
        loads = dataclasses.replace(
            changed.parameters.loads, force=jax.numpy.zeros(model.topology.n_x).at[place].set(force)
        )
        pushed = fm.Model(model.topology, dataclasses.replace(changed.parameters, loads=loads), model.labels)
        bent = fm.equilibrium(pushed)
        return fm.simulate(changed, times, initial=bent, rtol=rtol, adjoint=diffrax.ForwardMode(), throw=False).x[
            :, place
        ]

    return fm.jit(position), fm.jit(lambda scale: jax.jvp(position, (scale,), (1.0,)))


def first_call(plane: bool, cache: str | None) -> float:
    """Seconds of the first simulation in a fresh process.

    Args:
        plane: In the plane or in space.
        cache: Folder of compiled code, or None.
    """
    code = FIRST.format(cache=f"fm.enable_cache({cache!r})" if cache else "", plane=plane)
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(HERE), os.environ.get("PYTHONPATH", "")]),
        "JAX_PLATFORMS": "cpu",
    }
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    return float(run.stdout)


def general(model, bent, times, rtol: float):
    """Motion by SciPy's Radau method: our equations, compiled, in the degrees of freedom.

    Args:
        model: Mechanism.
        bent: Where it starts from.
        times: Of the output [s].
        rtol: Tolerance.

    Returns:
        Function that gives nodal coordinates at the times and the number of evaluations.
    """
    import jax
    import jax.numpy as jnp
    import numpy as np
    import scipy.integrate

    from flexmb.motion.coordinates_form import coordinates_form
    from flexmb.motion.protocol import MotionState
    from flexmb.motion.reduced_form import reduced_form

    form = reduced_form(coordinates_form(model.topology, model.parameters))
    start = form.state_of(bent.x, jnp.zeros(model.topology.n_x), None)
    n = start.u.shape[0]

    def placed(y):
        return form.settle(0.0, MotionState(y[:n], y[n:], start.memory))

    rates = jax.jit(lambda y: jnp.concatenate([y[n:], form.acceleration(0.0, placed(y))[0]]))
    whole = jax.jit(jax.vmap(lambda y: form.whole_motion(0.0, placed(y))[0]))

    def run():
        found = scipy.integrate.solve_ivp(
            lambda t, y: np.asarray(rates(y)),
            (times[0], times[-1]),
            np.concatenate([start.u, start.w]),
            method="Radau",
            t_eval=times,
            rtol=rtol,
            atol=1e-3 * rtol,
        )
        return np.asarray(whole(found.y.T)), found.nfev

    return run


def peers(found: dict, run: dict, times) -> tuple[str, ...]:
    """Add Exudyn in space, where it is installed: its beams deform in shear, so that it is compared with such ones.

    Args:
        found: Entries by name, added to.
        run: Functions to time by name, added to.
        times: Of the output [s].

    Returns:
        Names of the packages that took part.
    """
    import numpy as np
    import peer_exudyn

    import flexmb as fm
    from flexmb import spatial

    if not peer_exudyn.installed():
        print("Exudyn is not installed and is left out: pip install -e '.[peers]' brings it.")
        return ()
    leaf = fm.Rectangle(0.018, 0.0005, fm.Material(E=210e9, G=80e9, rho=7850.0), shear=True)
    b = fm.Builder()
    for side, place in (("left", 0.0), ("right", 0.1)):
        b.node(f"{side}0", (place, 0.0, 0.0))
        b.node(f"{side}2", (place, 0.0, 0.1))
        b.add(spatial.spectral_beam(4, shear=True), f"{side}0", f"{side}2", name=side, section=leaf, y=(0, 1, 0))
        b.fix(f"{side}0")
        b.mass(f"{side}2", 0.1)
    b.add(spatial.beam, "left2", "right2", name="bar", y=(0, 1, 0))
    model = b.build()
    bent = at_rest(model, force := 0.95)
    exact = np.asarray(fm.simulate(model, times, initial=bent, rtol=1e-6, atol=1e-9).at("right2"))[:, 0] - 0.1
    for elements, steps in ((4, 1000), (8, 1000), (8, 2000), (16, 2000), (32, 2000)):
        for node in peer_exudyn.NODES:
            name = f"space, Exudyn: {elements} at {1 / steps:g}"
            try:
                built = peer_exudyn.guide(leaf.rigidity(), 0.1, 0.1, force, elements, node, (0.1, 0.1))
                call = peer_exudyn.released(built, times, 1 / steps)
                error = float(np.max(np.abs(call() - exact))) / STROKE
            except Exception as fault:  # Its own error class, and others.
                print(f"{name}, {node}: {str(fault).splitlines()[0]}")
                continue
            found[name] = {"error": error, "steps": steps, "node": node}
            run[name] = call
            print(f"{name:<50} error {error:.1e} {steps:7d} steps", flush=True)
            break
    return ("exudyn",)


def main() -> None:
    """Compute, time, print, save and draw."""
    import diffrax
    import jax
    import jax.numpy as jnp
    import numpy as np
    from record import PACKAGES, chart, interleaved, save, show

    import flexmb as fm

    fm.enable_x64()
    first = {}
    for plane in (True, False):
        where = "plane" if plane else "space"
        first[f"{where}, no cache"] = first_call(plane, None)
        with tempfile.TemporaryDirectory() as folder:
            first[f"{where}, for a cache"] = first_call(plane, folder)
            first[f"{where}, cached"] = first_call(plane, folder)
    print("First simulation of a process:")
    for name, seconds in first.items():
        print(f"  {name:<30}{seconds:6.2f} s")

    fm.enable_cache()
    times = np.linspace(0, 1, 101)
    found, run, slow = {}, {}, {}
    for plane, fixed in ((True, False), (True, True), (False, False)):
        model = guide(plane, fixed)
        bent = at_rest(model)
        place = model.labels.known("right2")[0]
        simulate = functools.partial(fm.simulate, model, times, initial=bent)
        exact = np.asarray(simulate(rtol=1e-9, atol=1e-11).x[:, place])
        solvers = {"": TOLERANCES}
        if plane:
            solvers |= {"Dopri8": TOLERANCES[1:] if fixed else (1e-4,)} | ({"Kvaerno5": (1e-3,)} if fixed else {})
        for solver, tolerances in solvers.items():
            chosen = {"solver": getattr(diffrax, solver)()} if solver else {}
            family = f"{'plane' if plane else 'space'}{', elongations FIXED' if fixed else ''}, {solver or 'Rodas5P'}"
            for rtol in tolerances:
                call = functools.partial(simulate, rtol=rtol, throw=False, **chosen)
                begin = time.perf_counter()
                motion = call()
                error = float(np.max(np.abs(np.asarray(motion.x[:, place]) - exact))) / STROKE
                name = f"{family}: {rtol:g}"
                found[name] = {"error": error, "steps": int(motion.steps)}
                took = time.perf_counter() - begin
                print(f"{name:<50} error {error:.1e} {int(motion.steps):7d} steps, first {took:.1f} s", flush=True)
                if SLOW <= took < LONGEST:
                    begin = time.perf_counter()
                    call()
                    took = time.perf_counter() - begin
                if took < SLOW:
                    run[name] = lambda call=call: call().x.block_until_ready()
                else:
                    slow[name] = {"median": took, "min": took, "max": took}
        if plane and not fixed:
            for rtol in (1e-2, 1e-3):
                call = general(model, bent, times, rtol)
                begin = time.perf_counter()
                x, evaluations = call()
                took = time.perf_counter() - begin
                error = float(np.max(np.abs(x[:, place] - exact))) / STROKE
                name = f"plane, scipy.integrate Radau: {rtol:g}"
                found[name] = {"error": error, "steps": int(evaluations)}
                slow[name] = {"median": took, "min": took, "max": took}
                print(f"{name:<50} error {error:.1e} {evaluations:7d} evaluations, {took:.1f} s", flush=True)
    gradients = {}
    for plane in (True, False):
        where = "plane" if plane else "space"
        position, with_slope = by_thickness(plane, times, 1e-4)
        fine, _ = by_thickness(plane, times, 1e-7)
        _, slope = with_slope(1.0)
        difference = (np.asarray(fine(1 + 1e-4)) - np.asarray(fine(1 - 1e-4))) / 2e-4
        apart = float(np.max(np.abs(np.asarray(slope) - difference)) / np.max(np.abs(difference)))
        gradients[f"{where}, from differences at 1e-7"] = apart
        print(f"Derivative by thickness, {where}: {apart:.1e} from differences")
        run[f"{where}, motion alone: 1e-4"] = lambda call=position: jax.block_until_ready(call(1.0))
        run[f"{where}, with its derivative by thickness: 1e-4"] = lambda call=with_slope: jax.block_until_ready(
            call(1.0)
        )
    took_part = peers(found, run, times)
    symmetric = np.random.default_rng(0).standard_normal((38, 38))
    symmetric = jnp.asarray(symmetric + symmetric.T)
    eigh = jax.jit(jnp.linalg.eigh)
    timed = interleaved(run, RUNS) | slow
    timed |= interleaved({"jnp.linalg.eigh, 38 x 38": lambda: jax.block_until_ready(eigh(symmetric))}, RUNS, 100)
    show("One second of motion, compiled", timed)
    save(
        "motion",
        {"first_call_s": first, "found": found, "gradients": gradients, "times": timed},
        (*PACKAGES, "diffrax", *took_part),
    )
    title, error = "Guide of steel released from 1 mm", "greatest error of the bar's position, over 1 mm"
    chart("motion", found, timed, title, "time of one second of motion", error)


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
