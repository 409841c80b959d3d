"""Error against time of equilibria of chains of many beams, beside Exudyn: a cantilever bent by a load at its tip.

Of 16 to 1000 beams of ours, of as many cables of Exudyn's (ANCF), and one spectral beam of rising order. The error is
that of the elastica with extension. Times are those of the processor, of all threads, from the undeformed state.

    python -m benchmarks chains_static
"""

import functools

SIZES = (16, 64, 256, 1000)
CABLES = (4, 8, 16, 64, 256, 1000)
ORDERS = (2, 3, 4, 5, 6, 8)
# Length [m], EI [N m^2], EA [N], load across the tip [N].
LENGTH, BENDING, STRETCHING, LOAD = 1.0, 1.0, 1e5, 4.0
RUNS = 7


def elastica():
    """Tip of the rod whose bending moment is EI dtheta/ds and whose normal force is EA times its strain, by shooting.

    Returns:
        Its place, (2,) [m].
    """
    import numpy as np
    from scipy.integrate import solve_ivp
    from scipy.optimize import brentq

    def bent(moment):
        # theta, its moment, x, y along the rod of the undeformed state.
        def rates(_, state):
            theta, moment, _, _ = state
            stretch = 1 + LOAD * np.sin(theta) / STRETCHING
            along, across = stretch * np.cos(theta), stretch * np.sin(theta)
            return [moment / BENDING, -LOAD * along, along, across]

        return solve_ivp(rates, (0, LENGTH), [0.0, moment, 0.0, 0.0], method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]

    moment = brentq(lambda moment: bent(moment)[1], 0.0, LOAD * LENGTH, xtol=1e-15, rtol=1e-14)
    return bent(moment)[2:]


def cantilever(elements: int, order: int | None = None):
    """Cantilever of flexmb.

    Args:
        elements: Number of beams.
        order: Of spectral beams; None: the ordinary beam.
    """
    import flexmb as fm
    from flexmb import planar

    section = fm.Rigidity(EA=STRETCHING, EIy=BENDING, mass=1.0)
    element = planar.beam if order is None else planar.spectral_beam(order)
    b = fm.Builder()
    for i in range(elements + 1):
        b.node(f"n{i}", (LENGTH * i / elements, 0.0))
    for i in range(elements):
        b.add(element, f"n{i}", f"n{i + 1}", section=section)
    b.fix("n0")
    b.force(f"n{elements}", (0.0, -LOAD))
    return b.build()


def tip(model, elements: int):
    """Tip of flexmb's cantilever [m].

    Args:
        model: Cantilever.
        elements: Number of beams.
    """
    import numpy as np

    import flexmb as fm

    return np.asarray(fm.equilibrium(model).at(f"n{elements}"))


def main() -> None:
    """Compute, time, print, save and draw."""
    import numpy as np
    import peer_exudyn
    from record import PACKAGES, chart, processor_times, save

    import flexmb as fm

    fm.enable_x64()
    fm.enable_cache()
    exact = elastica() * [1, -1]
    beams = {f"flexmb, beams: {n}": functools.partial(tip, cantilever(n), n) for n in SIZES}
    spectral = {f"flexmb, one spectral beam: {p}": functools.partial(tip, cantilever(1, p), 1) for p in ORDERS}
    calls = beams | spectral
    with_peer = peer_exudyn.installed()
    if with_peer:
        rod = LENGTH, BENDING, STRETCHING, LOAD
        calls |= {f"Exudyn, ANCF cables: {n}": peer_exudyn.cantilever(*rod, n) for n in CABLES}
    found = {name: {"error": float(np.linalg.norm(call() - exact))} for name, call in calls.items()}
    timed = processor_times(calls, RUNS)
    for name, error in found.items():
        print(f"{name:<32} error {error['error']:.1e}, {1e3 * timed[name]['median']:8.2f} ms")
    save("chains_static", {"found": found, "times": timed}, (*PACKAGES, *(("exudyn",) if with_peer else ())))
    title = "Cantilevers of 1 to 1000 elements, load PL²/EI = 4"
    chart("chains_static", found, timed, title, "time of the processor", "error of the tip, over the length")


if __name__ == "__main__":
    main()
