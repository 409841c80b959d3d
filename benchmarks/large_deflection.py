"""Error against time for a guide at a large stroke: SPACAR beams, spectral beams, Exudyn's geometrically exact beam.

``python benchmarks/large_deflection.py`` writes results/large_deflection.json and results/large_deflection.png, which
README shows. The tutorial's spatial guide under 9.5 N along its drive direction moves some 10 mm. Exudyn takes part
where it is installed (``pip install -e '.[peers]'``), in the same run.
"""

import sys
import time
from pathlib import Path

HERE = Path(__file__).parent
FORCE = 9.5
LENGTH = DISTANCE = 0.1
BEAMS = (1, 2, 4, 8, 16, 32)
ORDERS = (2, 3, 4, 5, 6)
RUNS = 7
EXUDYN = "Exudyn, geometrically exact beams"
SCIPY = "SPACAR beams, scipy.optimize.root"
# More beams take SciPy twenty seconds and more. Methods and load steps are tried until one gets there.
SCIPY_BEAMS = (1, 2)
WAYS = (("hybr", 20), ("lm", 1), ("lm", 5))


def leaf(shear=False):
    """Section of the leaf springs.

    Args:
        shear: Whether shear deformation is counted.
    """
    from scenes import STEEL

    import flexmb as fm

    return fm.Rectangle(0.018, 0.0005, fm.Material(**STEEL), shear=shear)


def guide(element, beams=1, shear=False, **options):
    """Spatial guide of two leaf springs 0.1 m long and 0.1 m apart, upright, a rigid bar on top.

    Args:
        element: Beam element of the leaf springs.
        beams: Elements a leaf spring.
        shear: Whether shear deformation is counted; the element must know it too.
        options: Properties of the beams.
    """
    import flexmb as fm
    from flexmb import spatial

    section = leaf(shear)
    b = fm.Builder()
    for side, y in (("left", 0.0), ("right", DISTANCE)):
        for i in range(beams + 1):
            b.node(f"{side}{i}", (0, y, LENGTH * i / beams))
        for i in range(beams):
            ends = f"{side}{i}", f"{side}{i + 1}"
            b.add(element, *ends, name=f"{side} {i + 1}", section=section, y=(1, 0, 0), **options)
        b.fix(f"{side}0")
    b.add(spatial.beam, f"left{beams}", f"right{beams}", name="bar", y=(1, 0, 0))
    b.force(f"right{beams}", (0, FORCE, 0))
    return b.build()


def stroke(model, beams):
    """Of the stage at equilibrium [m], and the solution.

    Args:
        model: As from :func:`guide`.
        beams: Elements a leaf spring.
    """
    import flexmb as fm

    solved = fm.equilibrium(model)
    return float(solved.at(f"right{beams}")[1]) - DISTANCE, solved


def general(model, beams):
    """Equilibrium by SciPy's general solver: our equations and their Jacobian, compiled, in all coordinates.

    Args:
        model: As from :func:`guide`.
        beams: Elements a leaf spring.

    Returns:
        Function of a method and a number of load steps that solves, and gives the stroke [m].
    """
    import dataclasses

    import jax
    import jax.numpy as jnp
    import numpy as np
    import scipy.optimize

    from flexmb.motion.coordinates_form import coordinates_form
    from flexmb.motion.protocol import MotionState

    form = coordinates_form(model.topology, model.parameters)
    n, m, start = form.size, form.held.shape[0], model.parameters.reference
    memory = form.state_of(start, jnp.zeros_like(start), None).memory
    place = int(model.labels.known(f"right{beams}")[1])

    def out_of_balance(y, share):
        loads = dataclasses.replace(form.parameters.loads, force=share * model.parameters.loads.force)
        parameters = dataclasses.replace(form.parameters, loads=loads)
        state = MotionState(y[:n], jnp.zeros(n), memory)
        at = dataclasses.replace(form, parameters=parameters)
        force = at.residual(0.0, state, jnp.concatenate([jnp.zeros(n), y[n:]]))[:n]
        return jnp.concatenate([force, at.gap(0.0, state)])

    function, jacobian = jax.jit(out_of_balance), jax.jit(jax.jacfwd(out_of_balance))

    def values(y, share):
        return np.asarray(function(y, share))

    def slopes(y, share):
        return np.asarray(jacobian(y, share))

    def solve(method, steps):
        y = np.zeros(n + m)
        for share in np.arange(1, steps + 1) / steps:
            found = scipy.optimize.root(values, y, args=(share,), jac=slopes, method=method)
            if not found.success:
                raise RuntimeError(found.message)
            y = found.x
        return float(form.whole(0.0, y[:n], jnp.zeros(n), jnp.zeros(n)).x[place]) - DISTANCE

    return solve


def peers(found, run):
    """Add Exudyn to what was found and what is timed, where it is installed.

    Its beam deforms in shear, so its strokes are compared with the converged stroke that counts shear.

    Args:
        found: Entries by name, added to.
        run: Functions to time by name, added to.

    Returns:
        Names of the packages that took part.
    """
    import numpy as np
    import peer_exudyn

    from flexmb import spatial

    if not peer_exudyn.installed():
        print("Exudyn is not installed and is left out: pip install -e '.[peers]' brings it.")
        return ()
    exact, _ = stroke(guide(spatial.spectral_beam(8, shear=True), 2, shear=True), 2)
    for n in BEAMS:
        best = peer_exudyn.fastest(leaf(shear=True).rigidity(), LENGTH, DISTANCE, FORCE, n)
        # The feet stand still; the nodes above have six degrees of freedom each, the last two share theirs.
        entry = {"error": abs(best["stroke"] / exact - 1), "stroke": best["stroke"], "of": exact}
        found[f"{EXUDYN}: {n}"] = entry | {"degrees_of_freedom": 12 * n - 6, "settings": best["settings"]}
        run[f"{EXUDYN}: {n}"] = best["solve"]
    # Two programs agree on the answer: Exudyn's strokes extrapolate to ours.
    fine, finer = (found[f"{EXUDYN}: {n}"]["stroke"] for n in BEAMS[-2:])
    np.testing.assert_allclose((4 * finer - fine) / 3, exact, rtol=1e-5)
    return ("exudyn",)


def main() -> None:
    """Compute, time, print, save and draw."""
    import numpy as np
    from record import PACKAGES, chart, interleaved, save, show

    import flexmb as fm
    from flexmb import spatial

    fm.enable_x64()
    fm.enable_cache()
    families = {
        "SPACAR beams": {n: (guide(spatial.beam, n), n) for n in BEAMS},
        "SPACAR beams, no second-order terms": {n: (guide(spatial.beam, n, second_order=False), n) for n in BEAMS},
        "one spectral beam a leaf spring": {p: (guide(spatial.spectral_beam(p)), 1) for p in ORDERS},
    }
    exact, _ = stroke(guide(spatial.spectral_beam(8), 2), 2)
    found, run = {}, {}
    for family, models in families.items():
        for size, (model, beams) in models.items():
            reached, solved = stroke(model, beams)
            found[f"{family}: {size}"] = {
                "error": abs(reached / exact - 1),
                "iterations": int(solved.iterations),
                "degrees_of_freedom": model.topology.n_q,
            }
            run[f"{family}: {size}"] = lambda model=model: fm.equilibrium(model).x.block_until_ready()
    once = {}
    for n in SCIPY_BEAMS:
        model = guide(spatial.beam, n)
        solve = general(model, n)
        for method, steps in WAYS:
            try:
                solve(method, steps)
                begin = time.perf_counter()
                reached = solve(method, steps)
            except RuntimeError as fault:
                print(f"SciPy, {n} beams, {method}, {steps} steps: {' '.join(str(fault).split())}")
                continue
            took = time.perf_counter() - begin
            # Our equations: the same answer.
            np.testing.assert_allclose(reached, stroke(model, n)[0], rtol=1e-9)
            how = {"degrees_of_freedom": model.topology.n_q, "settings": f"{method}, {steps} load steps"}
            found[f"{SCIPY}: {n}"] = {"error": abs(reached / exact - 1), **how}
            once[f"{SCIPY}: {n}"] = {"median": took, "min": took, "max": took}
            break
    took_part = peers(found, run)
    timed = interleaved(run, RUNS) | once
    show(f"Equilibrium at a stroke of {exact:.6f} m, compiled", timed)
    for name, entry in found.items():
        how = entry.get("settings") or f"{entry['iterations']:3d} iterations"
        print(f"{name:44s} error {entry['error']:.1e}   {entry['degrees_of_freedom']:4d} degrees of freedom   {how}")
    # Two independent elements agree on the answer: the finest mesh of SPACAR beams converges to it with order two.
    errors = [found[f"SPACAR beams: {n}"]["error"] for n in BEAMS]
    np.testing.assert_allclose(np.divide(errors[2:-1], errors[3:]), 4, rtol=0.2)
    save("large_deflection", {"stroke": exact, "found": found, "times": timed}, PACKAGES + took_part)
    title = "Guide at 10 mm: elements a leaf spring, or the order of one"
    chart("large_deflection", found, timed, title, "time of one equilibrium, compiled", "error of the stroke")


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
