"""Error against time of large motions of flexible rods, beside Exudyn: a pendulum in the plane, a free rod in space.

Both packages take beams and Exudyn its generalised-alpha method; what is compared is the whole error, of beams and of
time steps, against one rod that many terms describe (solutions.py), or REFERENCES.md D1. Times are those of the
processor.

    python -m benchmarks swing
"""

import functools

# Flexible pendulum: length [m], mass per length [kg/m], EI [N m^2], EA [N], gravity [m/s^2], released horizontally.
LENGTH, MASS, BENDING, STRETCHING, GRAVITY = 1.0, 1.0, 1.0, 1e5, 9.81
END = 1.0
# REFERENCES.md D1: length [m], time of the peak of the load [s], load; the lower and the upper end then [m].
ROD, PEAK, LOAD = 10.0, 2.5, 200.0
LOWER, UPPER = (3.60683, 0.04469, -0.42725), (3.98176, 8.53172, -0.54047)
RUNS = 7


def pendulum(elements: int, order: int | None = None):
    """Flexible pendulum of flexmb.

    Args:
        elements: Number of beams.
        order: Of spectral beams; None: the ordinary beam.
    """
    import flexmb as fm
    from flexmb import planar

    section = fm.Rigidity(EA=STRETCHING, EIy=BENDING, mass=MASS)
    b = fm.Builder()
    for i in range(elements + 1):
        b.node(f"n{i}", (LENGTH * i / elements, 0.0))
    element = planar.beam if order is None else planar.spectral_beam(order)
    for i in range(elements):
        b.add(element, f"n{i}", f"n{i + 1}", name=f"rod {i + 1}", section=section)
    b.fix("n0", "position")
    b.gravity((0.0, -GRAVITY))
    return b.build()


def spaghetti(elements: int, order: int):
    """Free rod of flexmb in space.

    Args:
        elements: Number of spectral beams.
        order: Of them.
    """
    import numpy as np

    import flexmb as fm
    from flexmb import spatial

    section = fm.Rigidity(
        EA=1e4, EIy=500.0, EIz=500.0, GIt=500.0, shear_y=0.05, shear_z=0.05, mass=1.0, Jx=20.0, Jy=10.0, Jz=10.0
    )
    b = fm.Builder()
    for i, place in enumerate(np.linspace((6.0, 0.0, 0.0), (0.0, 8.0, 0.0), elements + 1)):
        b.node(f"n{i}", tuple(place))
    for i in range(elements):
        element = spatial.spectral_beam(order, shear=True)
        b.add(element, f"n{i}", f"n{i + 1}", name=f"rod {i + 1}", section=section, y=(0, 0, 1))
    return b.build()


def of_pendulum(found: dict, run: dict) -> float:
    """Add flexmb's pendulums, and give where the tip is at the end [m].

    Args:
        found: Entries by name, added to.
        run: Functions to time by name, added to.
    """
    import numpy as np
    from solutions import kept

    import flexmb as fm

    def tip(model, elements, rtol, form):
        return np.asarray(fm.simulate(model, [0.0, END], rtol=rtol, form=form).at(f"n{elements}"))[-1]

    exact = kept("pendulum")
    for family, elements, order, form, tolerances in (
        ("16 beams", 16, None, None, (1e-2, 1e-3, 1e-4, 1e-5)),
        ("16 beams as a chain", 16, None, "chain", (1e-2, 1e-3, 3e-4)),
        ("one spectral beam of order 4", 1, 4, None, (1e-1, 1e-2)),
        ("one spectral beam of order 9", 1, 9, None, (6e-2, 3e-2, 2e-2)),
        ("one spectral beam of order 12", 1, 12, None, (3e-2, 1e-2)),
        ("2 spectral beams of order 6", 2, 6, None, (1e-3, 1e-4)),
    ):
        model = pendulum(elements, order)
        for rtol in tolerances:
            call = functools.partial(tip, model, elements, rtol, form)
            add(found, run, f"pendulum, flexmb, {family}: {rtol:g}", call, exact)
    return exact


def of_spaghetti(found: dict, run: dict) -> None:
    """Add flexmb's free rods.

    Args:
        found: Entries by name, added to.
        run: Functions to time by name, added to.
    """
    import numpy as np

    import flexmb as fm

    ramp = np.array([0.0, PEAK, 2 * PEAK])
    force, moment = np.zeros((2, 3, 3))
    force[1], moment[1] = (LOAD / 10, 0, 0), (0, -LOAD / 2, -LOAD)
    loads = {"n0": fm.motion.Table(ramp, force), "n0.rotation": fm.motion.Table(ramp, moment)}

    def ends(model, elements, rtol):
        motion = fm.simulate(model, [0.0, PEAK], loads=loads, rtol=rtol)
        return np.concatenate([np.asarray(motion.at(f"n{i}"))[-1] for i in (0, elements)])

    # Each takes twenty seconds to compile for the cache.
    for order in (4, 6):
        call = functools.partial(ends, spaghetti(1, order), 1, 1e-4)
        add(found, run, f"spaghetti, flexmb, one spectral beam: order {order}", call, np.array([*LOWER, *UPPER]), ROD)


def add(found: dict, run: dict, name: str, call, exact, length: float = LENGTH) -> None:
    """Note the error of a variant, and that it is to be timed.

    Args:
        found: Entries by name, added to.
        run: Functions to time by name, added to.
        name: Name.
        call: Gives what ``exact`` is.
        exact: Positions [m].
        length: Of the rod, which the error is divided by [m].
    """
    import numpy as np
    from record import once

    place, first = once(call)
    error = float(np.linalg.norm(place - exact)) / length
    found[name] = {"error": error, "first_s": first["median"]}
    run[name] = call
    print(f"{name:<60} error {error:.1e}, first {first['median']:.2f} s", flush=True)


def of_exudyn(found: dict, run: dict, exact) -> tuple[str, ...]:
    """Add Exudyn's pendulums and rods, where it is installed.

    Args:
        found: Entries by name, added to.
        run: Functions to time by name, added to.
        exact: Tip of the pendulum at the end [m].

    Returns:
        Names of the packages that took part.
    """
    import numpy as np
    import peer_exudyn

    if not peer_exudyn.installed():
        print("Exudyn is not installed and is left out: pip install -e '.[peers]' brings it.")
        return ()
    sizes = (LENGTH, MASS, BENDING, STRETCHING, GRAVITY)
    for elements, steps in ((16, 250), (16, 1000), (16, 4000), (32, 4000), (64, 4000)):
        call = peer_exudyn.pendulum(*sizes, elements, END, steps)
        add(found, run, f"pendulum, Exudyn: {elements} cables, {steps}", call, exact)
    for elements, steps in ((8, 250), (8, 1000), (16, 1000), (32, 2000)):
        call = peer_exudyn.spaghetti(elements, PEAK, LOAD, steps)
        add(found, run, f"spaghetti, Exudyn: {elements} beams, {steps}", call, np.array([*LOWER, *UPPER]), ROD)
    return ("exudyn",)


def main() -> None:
    """Compute, time, print, save and draw."""
    from record import PACKAGES, chart, processor_times, save, show

    import flexmb as fm

    fm.enable_x64()
    fm.enable_cache()
    found, run = {}, {}
    exact = of_pendulum(found, run)
    of_spaghetti(found, run)
    took_part = of_exudyn(found, run, exact)
    # Two programs with elements of their own come near to what is kept.
    for program in ("flexmb", *took_part):
        near = [own["error"] for name, own in found.items() if f"pendulum, {program}" in name.replace("Exu", "exu")]
        assert min(near) < 1e-5, program
    timed = processor_times(run, RUNS)
    show("Large motions, compiled, times of the processor", timed)
    save("swing", {"found": found, "times": timed}, (*PACKAGES, "diffrax", *took_part))
    title = "Flexible pendulum, 1 s, and free rod in space, 2.5 s"
    chart("swing", found, timed, title, "time of the processor", "error of the ends at the end, over the length")


if __name__ == "__main__":
    main()
