"""Error against time of one second of motion of a guide of steel, released from 1 mm.

``python benchmarks/motion.py`` prints the tables that README quotes, writes results/motion.json and draws
results/motion.png. Times are those of the processor, compiled; compiling.py says what a first motion takes.
"""

import functools
import sys
from pathlib import Path

HERE = Path(__file__).parent
RUNS = 7
# Output times of a tenth of the motion.
TENTH = 11
TOLERANCES = (1e-3, 3e-4, 1e-4, 1e-5)
STROKE = 1e-3
# Bends the guide in space about as far, with shear [N].
FORCE = 0.95
# So near integrators that share no step with ours come to what is kept, shares of the stroke.
AGREED = 5e-5


def times():
    """Of the output, a second of motion, (101,) [s]."""
    import numpy as np

    return np.linspace(0, 1, 101)


def tight(plane: bool, fixed: bool = False):
    """Position of the bar at these times, as it is kept, (101,) [m].

    Args:
        plane: In the plane, otherwise in space.
        fixed: Whether elongations are FIXED.
    """
    from solutions import kept

    return kept(f"guide in {'the plane' if plane else 'space'}{', elongations FIXED' if fixed else ''}")


def solved(plane: bool, fixed: bool = False):
    """The same, solved at a tolerance of 1e-9.

    Args:
        plane: In the plane, otherwise in space.
        fixed: Whether elongations are FIXED.
    """
    import numpy as np

    import flexmb as fm

    model = guide(plane, fixed)
    found = fm.simulate(model, times(), initial=at_rest(model), rtol=1e-9, atol=1e-11)
    return np.asarray(found.at("right2"))[:, 0]


def guide(plane: bool, fixed: bool = False):
    """Two leaf springs of two beams each with a bar on top: all deformations, or with their elongations FIXED.

    Args:
        plane: In the plane, otherwise in space.
        fixed: Whether elongations are FIXED.
    """
    import flexmb as fm
    from flexmb import planar, spatial

    section = leaf(shear=False)
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
            b.add(
                element, f"{side}{i}", f"{side}{i + 1}", name=f"{side} {i + 1}", section=section, **across, **released
            )
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


def general(model, bent, times, rtol: float):
    """Motion by SciPy's Radau method: our equations, compiled here, in the degrees of freedom.

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
    begin = jnp.concatenate([start.u, start.w])
    jax.block_until_ready((rates(np.asarray(begin)), whole(np.tile(begin, (len(times), 1)))))

    def run():
        found = scipy.integrate.solve_ivp(
            lambda t, y: np.asarray(rates(y)),
            (times[0], times[-1]),
            np.asarray(begin),
            method="Radau",
            t_eval=times,
            rtol=rtol,
            atol=1e-3 * rtol,
        )
        return np.asarray(whole(found.y.T)), found.nfev

    return run


def leaf(shear: bool):
    """Section of the leaf springs.

    Args:
        shear: Whether shear deformation is counted.
    """
    import flexmb as fm

    return fm.Rectangle(0.018, 0.0005, fm.Material(E=210e9, G=80e9, rho=7850.0), shear=shear)


def with_shear():
    """Displacement of the bar in space by one spectral beam a leaf spring, with shear, once ``FORCE`` lets go [m]."""
    import numpy as np

    import flexmb as fm
    from flexmb import spatial

    section = leaf(shear=True)
    b = fm.Builder()
    for side, place in (("left", 0.0), ("right", 0.1)):
        b.node(f"{side}0", (place, 0.0, 0.0))
        b.node(f"{side}2", (place, 0.0, 0.1))
        b.add(spatial.spectral_beam(4, shear=True), f"{side}0", f"{side}2", name=side, section=section, y=(0, 1, 0))
        b.fix(f"{side}0")
        b.mass(f"{side}2", 0.1)
    b.add(spatial.beam, "left2", "right2", name="bar", y=(0, 1, 0))
    model = b.build()
    bent = at_rest(model, FORCE)
    return np.asarray(fm.simulate(model, times(), initial=bent, rtol=1e-6, atol=1e-9).at("right2"))[:, 0] - 0.1


def peers(found: dict, run: dict) -> tuple[str, ...]:
    """Add Exudyn in space, where it is installed: its beams deform in shear, so that it is compared with such ones.

    Args:
        found: Entries by name, added to.
        run: Functions to time by name, added to.

    Returns:
        Names of the packages that took part.
    """
    import numpy as np
    import peer_exudyn
    from solutions import kept

    if not peer_exudyn.installed():
        print("Exudyn is not installed and is left out: pip install -e '.[peers]' brings it.")
        return ()
    exact = kept("guide in space, spectral beams with shear")
    for elements, steps in ((4, 1000), (8, 1000), (8, 2000), (16, 2000), (32, 2000)):
        for node in peer_exudyn.NODES:
            name = f"space, Exudyn: {elements} at {1 / steps:g}"
            try:
                built = peer_exudyn.guide(leaf(shear=True).rigidity(), 0.1, 0.1, FORCE, elements, node, (0.1, 0.1))
                call = peer_exudyn.released(built, times(), 1 / steps)
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
    from record import PACKAGES, SLOW, chart, interleaved, once, processor_times, save, show

    import flexmb as fm

    fm.enable_x64()
    fm.enable_cache()
    found, run, slow = {}, {}, {}

    def add(name: str, took: dict, error: float, steps: int, call) -> None:
        found[name] = {"error": error, "steps": steps}
        print(f"{name:<50} error {error:.1e} {steps:7d} steps, {took['median']:.2f} s", flush=True)
        if took["median"] > SLOW:
            slow[name] = took
        else:
            run[name] = call

    for plane, fixed in ((True, False), (True, True), (False, False)):
        model = guide(plane, fixed)
        bent, exact = at_rest(model), tight(plane, fixed)
        place = model.labels.known("right2")[0]
        # Of each solver: its tolerances, and how many of the output times, which of a slow one are few.
        solvers: dict[str, tuple[tuple[float, ...], int]] = {"": (TOLERANCES, len(exact))}
        if plane:
            solvers["Dopri8"] = (TOLERANCES[1:], len(exact)) if fixed else ((1e-4,), TENTH)
        if fixed:
            solvers["Kvaerno5"] = (1e-3,), TENTH
        for solver, (tolerances, count) in solvers.items():
            chosen = {"solver": getattr(diffrax, solver)()} if solver else {}
            family = f"{'plane' if plane else 'space'}{', elongations FIXED' if fixed else ''}, {solver or 'Rodas5P'}"
            family += ", a tenth of it" if count == TENTH else ""
            simulate = functools.partial(fm.simulate, model, initial=bent, throw=False, **chosen)
            # Compiles, and is short.
            simulate(1e-3 * times()[:count], rtol=1e-3)
            for rtol in tolerances:

                def call(simulate=simulate, rtol=rtol, count=count):
                    return jax.block_until_ready(simulate(times()[:count], rtol=rtol))

                motion, took = once(call)
                error = float(np.max(np.abs(np.asarray(motion.x[:, place]) - exact[:count]))) / STROKE
                add(f"{family}: {rtol:g}", took, error, int(motion.steps), call)
        if plane and not fixed:
            (x, evaluations), took = once(general(model, bent, times(), 1e-3))
            error = float(np.max(np.abs(x[:, place] - exact))) / STROKE
            add("plane, scipy.integrate Radau: 0.001", took, error, evaluations, None)
    # What is kept is where methods of others come near to, in the plane; in space it is where tolerances converge to.
    for others in (("plane, scipy",), ("plane, elongations FIXED, Dopri8",), ("space, Rodas5P",)):
        near = min(entry["error"] for name, entry in found.items() if name.startswith(others))
        assert near < AGREED, (others, near)
    gradients = {}
    for plane in (True, False):
        where = "plane" if plane else "space"
        position, with_slope = by_thickness(plane, times(), 1e-4)
        _, slope = with_slope(1.0)
        if plane:
            fine, _ = by_thickness(plane, times(), 1e-7)
            difference = (np.asarray(fine(1 + 1e-4)) - np.asarray(fine(1 - 1e-4))) / 2e-4
            apart = float(np.max(np.abs(np.asarray(slope) - difference)) / np.max(np.abs(difference)))
            gradients["plane, from differences at 1e-7"] = apart
            print(f"Derivative by thickness in the plane: {apart:.1e} from differences")
        run[f"{where}, motion alone: 1e-4"] = lambda call=position: jax.block_until_ready(call(1.0))
        run[f"{where}, with its derivative by thickness: 1e-4"] = lambda call=with_slope: jax.block_until_ready(
            call(1.0)
        )
        run[f"{where}, motion alone: 1e-4"]()
    took_part = peers(found, run)
    symmetric = np.random.default_rng(0).standard_normal((38, 38))
    symmetric = jnp.asarray(symmetric + symmetric.T)
    eigh = jax.jit(jnp.linalg.eigh)
    timed = processor_times(run, RUNS) | slow
    timed |= interleaved({"jnp.linalg.eigh, 38 x 38": lambda: jax.block_until_ready(eigh(symmetric))}, RUNS, 100)
    show("One second of motion, compiled, times of the processor", timed)
    save("motion", {"found": found, "gradients": gradients, "times": timed}, (*PACKAGES, "diffrax", *took_part))
    title, error = "Guide of steel released from 1 mm", "greatest error of the bar's position, over 1 mm"
    chart("motion", found, timed, title, "time of the processor for one second of motion", error)


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
