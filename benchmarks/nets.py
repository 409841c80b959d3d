"""Error against time of the motion of nets, beside Exudyn: hung at their upper corners, let go, of 40 to 1012 beams.

Cables along and across are hinged to each other where they cross; each side of a mesh is one beam of ours, or one ANCF
cable of Exudyn's, whose generalised-alpha method takes the quicker of its two Newton methods. Errors are those of time
steps and beams together, beside two beams a side at a small tolerance; for the largest net, where that takes a minute,
beside one. Times are those of the processor, of all threads.

    python -m benchmarks nets
"""

import functools
import sys

# Edge [m], mass per length [kg/m], EI [N m^2], EA [N], gravity [m/s^2], time [s].
LENGTH, MASS, BENDING, STRETCHING, GRAVITY = 1.0, 0.1, 0.01, 1e4, 9.81
END = 0.25
SIZES = (4, 10, 22)
TOLERANCES = (1e-2, 1e-3, 1e-4)
STEPS = (100, 200, 400)
# Sizes whose dense form is timed too, and whose reference has two beams a side.
SMALL, REFERENCE = 10, 1e-5
# What is farther from the reference is wrong [m], and derivatives of which more is left than this share.
WRONG, UNBALANCED = 2e-2, 1e-3


def net(cells: int, parts: int = 1):
    """The net of flexmb.

    Args:
        cells: Meshes along an edge.
        parts: Beams a side of a mesh.
    """
    import flexmb as fm
    from flexmb import planar

    section = fm.Rigidity(EA=STRETCHING, EIy=BENDING, mass=MASS)
    b = fm.Builder()
    count = cells * parts
    for i in range(count + 1):
        for j in range(count + 1):
            if i % parts == 0 or j % parts == 0:
                b.node(f"{i},{j}", (LENGTH * i / count, -LENGTH * j / count))
    for i in range(0, count + 1, parts):
        for j in range(count + 1):
            b.rotation(f"turn {i},{j}")
    for i in range(count + 1):
        for j in range(count + 1):
            if i and j % parts == 0:
                b.add(planar.beam, f"{i - 1},{j}", f"{i},{j}", section=section)
            if j and i % parts == 0:
                b.add(planar.beam, f"{i},{j - 1}", f"turn {i},{j - 1}", f"{i},{j}", f"turn {i},{j}", section=section)
    for i in (0, count):
        b.fix(f"{i},0", "position")
    b.gravity((0.0, -GRAVITY))
    return b.build(check=False)


def lower_edge(model, cells: int, rtol: float, form: str = "chain"):
    """Lower right corner and the middle of the lower edge at the end [m].

    Args:
        model: Net.
        cells: Meshes, times beams a side of one.
        rtol: Of the steps.
        form: Of the equations.
    """
    import numpy as np

    import flexmb as fm

    motion = fm.simulate(model, [0.0, END], rtol=rtol, form=form)
    return np.concatenate([np.asarray(motion.at(f"{i},{cells}"))[-1] for i in (cells, cells // 2)])


def slopes(model, cells: int, rtol: float, form: str = "chain"):
    """Derivatives of the height of the lower right corner at the end by all numbers of the sections.

    Args:
        model: Net.
        cells: Meshes.
        rtol: Of the steps.
        form: Of the equations.

    Returns:
        What should be none, over the largest part: beams that are as much stiffer as heavier move alike, so that the
        derivatives by stiffness and mass, each times its number, add up to zero.
    """
    import dataclasses

    import jax
    import numpy as np

    import flexmb as fm

    def height(parameters):
        moved = fm.simulate(dataclasses.replace(model, parameters=parameters), [0.0, END], rtol=rtol, form=form)
        return moved.at(f"{cells},{cells}")[-1, 1]

    by = jax.grad(height, allow_int=True)(model.parameters)
    parts = []
    for own, numbers in zip(by.properties, model.parameters.properties, strict=True):
        for name in ("EA", "EIy", "mass", "Jy"):
            parts.append(np.sum(getattr(own["section"], name) * getattr(numbers["section"], name)))
    return abs(sum(parts)) / max(map(abs, parts))


def solved(cells: int):
    """The same at a tolerance of ``REFERENCE``, of small nets by two beams a side of a mesh.

    Args:
        cells: Meshes along an edge.
    """
    parts = 2 if cells <= SMALL else 1
    return lower_edge(net(cells, parts), parts * cells, REFERENCE)


def of_exudyn(cells: int, steps: int, modified: bool):
    """A function that gives the same of Exudyn's net."""
    import peer_exudyn

    # Its Newton method needs a wide tolerance from some hundred cables on.
    tolerance = 1e-8 if cells <= 4 else 1e-4
    sizes = (LENGTH, MASS, BENDING, STRETCHING, GRAVITY)
    newton = {"relativeTolerance": tolerance, "useModifiedNewton": modified}
    return peer_exudyn.net(*sizes, cells, END, steps, **newton)


def quicker() -> bool:
    """Whether Exudyn's modified Newton method is quicker here."""
    from record import processor_times

    spent = processor_times({str(how): of_exudyn(SIZES[1], STEPS[0], how) for how in (False, True)}, 1)
    return spent["True"]["min"] < spent["False"]["min"]


def main() -> int:
    """Compute, time, print, save and draw; how many answers are wrong."""
    import numpy as np
    import peer_exudyn
    from record import PACKAGES, chart, processor_times, save
    from solutions import kept

    import flexmb as fm

    fm.enable_x64()
    fm.enable_cache()
    with_peer = peer_exudyn.installed()
    modified = with_peer and quicker()
    found, timed, wrong = {}, {}, 0
    for cells in SIZES:
        exact = kept(f"net of {cells} meshes")
        model, beams = net(cells), 2 * cells * (cells + 1)
        calls = {
            f"flexmb, {beams} beams: {rtol:g}": functools.partial(lower_edge, model, cells, rtol) for rtol in TOLERANCES
        }
        if cells <= SMALL:
            dense = functools.partial(lower_edge, model, cells, TOLERANCES[1], "coordinates")
            calls[f"dense, {beams} beams: {TOLERANCES[1]:g}"] = dense
        if with_peer:
            calls |= {f"Exudyn, {beams} cables: {steps}": of_exudyn(cells, steps, modified) for steps in STEPS}
        for name, call in calls.items():
            try:
                error = float(np.max(np.abs(call() - exact)) / LENGTH)
            except Exception as fault:  # Its own error class, and others.
                print(f"{name}: {str(fault).splitlines()[0]}")
                continue
            wrong += not error < WRONG
            found[name], timed[name] = {"error": error}, processor_times({name: call}, 1)[name]
            print(f"{name:<40} error {error:.1e}, {timed[name]['min']:7.3f} s", flush=True)
    slopes_left, slopes_timed = {}, {}
    for cells, form in ((SIZES[0], "coordinates"), *((cells, "chain") for cells in SIZES), (SIZES[1], "coordinates")):
        model, name = net(cells), f"{form}, {2 * cells * (cells + 1)} beams"
        moves = functools.partial(lower_edge, model, cells, TOLERANCES[1], form)
        calls = {"motion": moves, "gradient": functools.partial(slopes, model, cells, TOLERANCES[1], form)}
        slopes_left[name], _ = float(calls["gradient"]()), moves()
        slopes_timed[name] = {what: timing["min"] for what, timing in processor_times(calls, 1).items()}
        wrong += not slopes_left[name] < UNBALANCED
        print(f"{name:<40} left {slopes_left[name]:.1e}, {slopes_timed[name]}", flush=True)
    packages = (*PACKAGES, "diffrax", *(("exudyn",) if with_peer else ()))
    gradients = {"left of gradients": slopes_left, "times of gradients": slopes_timed}
    save("nets", {"modified Newton method of Exudyn": modified, "found": found, "times": timed, **gradients}, packages)
    title = f"Nets of 40 to 1012 beams let go, {END} s"
    chart("nets", found, timed, title, "time of the processor", "error of the lower edge at the end, over the length")
    return wrong


if __name__ == "__main__":
    sys.exit(main())
