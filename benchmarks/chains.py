"""Error against time of the motion of chains of many beams, beside Exudyn: soft pendulums of 16 to 1000 beams.

Both packages take as many beams, and what is compared is the error of time steps and beams together, against few
spectral beams that many terms describe. Exudyn's Newton method needs a wide tolerance from some hundred beams on.
Times are those of the processor, of all threads, so that other work on the machine counts little.

    python -m benchmarks chains
"""

import functools

SIZES = (16, 64, 256, 1000)
TOLERANCES = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4)
STEPS = (250, 500, 1000, 2000)
RUNS = 3


def tip(model, beams: int, rtol: float):
    """Tip of flexmb's chain at the end [m].

    Args:
        model: Chain.
        beams: Number of them.
        rtol: Of the steps.
    """
    import numpy as np
    from swing import END

    import flexmb as fm

    return np.asarray(fm.simulate(model, [0.0, END], rtol=rtol, form="chain").at(f"n{beams}"))[-1]


def of_exudyn(beams: int, steps: int):
    """A function that gives the tip of Exudyn's chain at the end [m].

    Args:
        beams: Cables.
        steps: Time steps.
    """
    import peer_exudyn
    from swing import BENDING, END, GRAVITY, LENGTH, MASS, STRETCHING

    tolerance = 1e-8 if beams <= 64 else 1e-4
    sizes = (LENGTH, MASS, BENDING, STRETCHING, GRAVITY)
    return peer_exudyn.pendulum(*sizes, beams, END, steps, tolerance)


def main() -> None:
    """Compute, time, print, save and draw."""
    import numpy as np
    import peer_exudyn
    from record import PACKAGES, SLOW, chart, once, processor_times, save
    from solutions import kept
    from swing import pendulum

    import flexmb as fm

    fm.enable_x64()
    fm.enable_cache()
    exact = kept("pendulum")
    with_peer = peer_exudyn.installed()
    found, timed = {}, {}
    for beams in SIZES:
        model = pendulum(beams)
        calls = {f"flexmb, {beams} beams: {rtol:g}": functools.partial(tip, model, beams, rtol) for rtol in TOLERANCES}
        if with_peer:
            calls |= {f"Exudyn, {beams} cables: {steps}": of_exudyn(beams, steps) for steps in STEPS}
        for name, call in calls.items():
            try:
                place, first = once(call)
            except Exception as fault:  # Its own error class, and others.
                print(f"{name}: {str(fault).splitlines()[0]}")
                continue
            error = float(np.linalg.norm(place - exact))
            # Exudyn compiles nothing, so that its first run counts where it is long.
            long = "Exudyn" in name and first["median"] > SLOW
            found[name], timed[name] = {"error": error}, first if long else processor_times({name: call}, RUNS)[name]
            print(f"{name:<40} error {error:.1e}, {timed[name]['min']:7.3f} s", flush=True)
    # Two programs with elements of their own come as near to what is kept as their time steps allow.
    for family in dict.fromkeys(name.split(",")[0] for name in found):
        assert min(entry["error"] for name, entry in found.items() if family in name) < 3e-5, family
    save("chains", {"found": found, "times": timed}, (*PACKAGES, "diffrax", *(("exudyn",) if with_peer else ())))
    title = "Soft pendulums of 16 to 1000 beams, 1 s"
    chart("chains", found, timed, title, "time of the processor", "error of the tip at the end, over the length")


if __name__ == "__main__":
    main()
