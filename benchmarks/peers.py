"""Error against time of a soft rod beside SoRoMoX, Exudyn and a shooting method of SciPy, and first calls.

    python -m benchmarks peers
    python benchmarks/peers.py statics space    # comparisons by name or dimension; the others stay

Three comparisons: motion of two constant-strain segments with shear in the plane and in space, where gravity lies off
the principal axes; the derivative of the end of this motion by the modulus; the weight of the whole rod at rest, by any
number of elements. Each program computes each comparison in a process of its own, whose processor time is measured.
References come from two programs that agree. Programs that are not installed are left out.
"""

import functools
import importlib.util
import itertools
import json
import math
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

HERE = Path(__file__).parent
RUNS = 5
END, OUTPUTS = 3.0, 301
# Young's modulus [Pa], Poisson's ratio, viscosity [Pa s] of the soft rod.
YOUNG, POISSON, VISCOSITY = 4e5, 0.45, 100.0


def scene() -> SimpleNamespace:
    """Soft rod of 0.4 m along x, whose bending rigidities differ by a factor of two."""
    radius, density = 0.02, 1000.0
    area, moment = math.pi * radius**2, math.pi * radius**4 / 4
    shear = YOUNG / (2 * (1 + POISSON))
    three = 3 * VISCOSITY

    def rigidities(long: float, across: float) -> SimpleNamespace:
        bending = {"EIy": long * moment, "EIz": 2 * long * moment, "GIt": 2 * across * moment}
        return SimpleNamespace(EA=long * area, **bending, GAy=across * area, GAz=across * area)

    return SimpleNamespace(
        length=0.4,
        segments=2,
        radius=radius,
        density=density,
        gravity=(0.0, -8.5, -4.9),
        stiffness=rigidities(YOUNG, shear),
        damping=rigidities(three, VISCOSITY),
        inertia=SimpleNamespace(mass=density * area, Jx=2 * density * moment, Jy=density * moment, Jz=density * moment),
    )


SCENE = scene()


def rod(space: bool, segments: int = SCENE.segments, order: int = 1, share: Any = 1.0) -> Any:
    """The rod as spectral beams with shear, held at node "n0".

    Args:
        space: Whether in space, else in the plane.
        segments: Number of beams; the tip is the node of this number.
        order: Terms of each strain; 1: constant strains.
        share: Factor of the stiffness.
    """
    import flexmb as fm
    from flexmb import planar, spatial

    kind, axes = (spatial, slice(3)) if space else (planar, slice(2))
    own = {name: share * value for name, value in vars(SCENE.stiffness).items()}
    shears = {"shear_y": own["EIz"] / own["GAy"], "shear_z": own["EIy"] / own["GAz"]}
    rigidities = {name: own[name] for name in ("EA", "EIy", "EIz", "GIt")}
    section = fm.Rigidity(**rigidities, **shears, **vars(SCENE.inertia))
    b = fm.Builder()
    for i in range(segments + 1):
        b.node(f"n{i}", (SCENE.length * i / segments, 0.0, 0.0)[axes])
    frame: dict[str, Any] = {"y": (0, 1, 0)} if space else {}
    for i in range(segments):
        element = kind.spectral_beam(order, shear=True)
        damping = fm.Damping(**vars(SCENE.damping))
        b.add(element, f"n{i}", f"n{i + 1}", name=f"rod {i + 1}", section=section, damping=damping, **frame)
    b.fix("n0")
    b.gravity(SCENE.gravity[axes])
    return b.build()


def flexmb_motion(space: bool) -> tuple[Any, tuple[float, ...]]:
    """Function of a relative tolerance, which gives places of the tip, and tolerances."""
    import flexmb as fm

    model, tip = rod(space), f"n{SCENE.segments}"
    return lambda rtol: fm.simulate(model, instants(), rtol=rtol).at(tip), (1e-3, 1e-4, 1e-5, 1e-6, 1e-8)


def flexmb_gradient(space: bool) -> tuple[Any, tuple[float, ...]]:
    """Function of a relative tolerance, which gives a derivative, and tolerances."""
    import jax

    import flexmb as fm
    from flexmb.build.carry import carried_choices
    from flexmb.design.evaluate import build_once

    models = build_once(lambda share: rod(space, share=share), {"share": 1.0})

    def end(share: Any, rtol: float) -> Any:
        with carried_choices(models):
            model = rod(space, share=share)
        return fm.simulate(model, instants()[[0, -1]], rtol=rtol).at(f"n{SCENE.segments}")[-1, 1]

    return lambda rtol: jax.grad(end)(1.0, rtol), (1e-3, 1e-5)


def flexmb_statics(_: bool) -> tuple[Any, tuple[float, ...]]:
    """Function of the terms of one spectral beam, which gives the place of the tip, and numbers of terms."""
    import flexmb as fm

    model = functools.cache(lambda order: rod(True, 1, order))
    return lambda order: fm.equilibrium(model(order)).at("n1"), (2, 3, 4, 6, 8)


def soromox_motion(space: bool) -> tuple[Any, tuple[float, ...]]:
    """As :func:`flexmb_motion`, by SoRoMoX with Tsit5 and adaptive steps."""
    import peer_soromox

    found = functools.cache(functools.partial(peer_soromox.compiled, SCENE, space))
    # The reference, the last one, has more places of quadrature.
    sizes = (1e-3, 1e-5, 1e-8, 1e-10)
    return lambda rtol: found(10 if rtol == sizes[-1] else 5)(rtol, 1.0, instants()), sizes


def soromox_gradient(space: bool) -> tuple[Any, tuple[float, ...]]:
    """As :func:`flexmb_gradient`, by SoRoMoX."""
    import peer_soromox

    found = peer_soromox.gradient(SCENE, space)
    return lambda rtol: found(rtol, 1.0, instants()[[0, -1]]), (1e-5,)


def soromox_statics(_: bool) -> tuple[Any, tuple[float, ...]]:
    """As :func:`flexmb_statics`, by constant-strain segments."""
    import peer_soromox

    @functools.cache
    def found(count: int) -> Any:
        return peer_soromox.statics(SimpleNamespace(**{**vars(SCENE), "segments": count}), 1e-9)

    return lambda count: found(count)(1.0), (2, 4, 8)


def exudyn_statics(_: bool) -> tuple[Any, tuple[float, ...]]:
    """As :func:`flexmb_statics`, by geometrically exact beams."""
    import peer_exudyn

    found = functools.cache(functools.partial(peer_exudyn.soft_rod, SCENE))
    return lambda count: found(count)(), (4, 16, 64)


def scipy_statics(_: bool) -> tuple[Any, tuple[float, ...]]:
    """Function of a relative tolerance: shooting for the moment at the clamp, by DOP853 and Powell's hybrid method."""
    import numpy as np
    from scipy.integrate import solve_ivp
    from scipy.optimize import root

    bending, stretch = (
        np.array([getattr(SCENE.stiffness, name) for name in names])
        for names in (("GIt", "EIy", "EIz"), ("EA", "GAy", "GAz"))
    )
    weight = SCENE.inertia.mass * np.array(SCENE.gravity)

    def rates(s: float, state: Any, load: float) -> Any:
        turn, moment = state[3:12].reshape(3, 3), state[12:]
        force = load * weight * (SCENE.length - s)
        along = turn @ ([1, 0, 0] + turn.T @ force / stretch)
        rate = turn.T @ moment / bending
        cross = np.array([[0, -rate[2], rate[1]], [rate[2], 0, -rate[0]], [-rate[1], rate[0], 0]])
        return np.concatenate([along, (turn @ cross).ravel(), -np.cross(along, force)])

    def shot(moment: Any, load: float, rtol: float) -> Any:
        start = np.concatenate([np.zeros(3), np.eye(3).ravel(), moment])
        every = solve_ivp(rates, (0, SCENE.length), start, "DOP853", rtol=rtol, atol=1e-3 * rtol, args=(load,))
        return every.y[:, -1]

    def found(rtol: float) -> Any:
        moment = np.zeros(3)
        for load in (0.25, 0.5, 0.75, 1.0):
            solved = root(lambda own, load=load: shot(own, load, rtol)[12:], moment, tol=1e-2 * rtol)
            moment = solved.x
        assert np.max(np.abs(solved.fun)) < 10 * rtol * np.max(np.abs(moment)), solved.message
        return shot(moment, 1.0, rtol)[:3]

    return found, (1e-4, 1e-7, 1e-11)


PROGRAMS = {
    "motion": {"flexmb": flexmb_motion, "SoRoMoX": soromox_motion},
    "gradient": {"flexmb": flexmb_gradient, "SoRoMoX": soromox_gradient},
    "statics": {
        "flexmb": flexmb_statics,
        "SoRoMoX": soromox_statics,
        "Exudyn": exudyn_statics,
        "SciPy": scipy_statics,
    },
}
COMPARISONS = (("motion", False), ("motion", True), ("gradient", False), ("gradient", True), ("statics", True))
# Module of each program, and the size that its first call asks.
MODULES = {"flexmb": "flexmb", "SoRoMoX": "soromox", "Exudyn": "exudyn", "SciPy": "scipy"}
# Answers of two programs agree to this share of the length, or of the derivative.
AGREE = {"motion": 1e-6, "gradient": 1e-4, "statics": 1e-7}


def instants() -> Any:
    """Times of outputs [s]."""
    import numpy as np

    return np.linspace(0.0, END, OUTPUTS)


def measured(program: str, what: str, space: str) -> list[dict[str, Any]]:
    """Answers of one program to one comparison, in this process.

    Args:
        program: Name.
        what: Comparison.
        space: "space" or "plane".

    Returns:
        For each size "size", "answer", "time" (median processor time of a run) [s], and for the first size "first":
        processor time and time by the clock of building and of the first call [s].
    """
    import statistics

    import jax
    import numpy as np

    jax.config.update("jax_enable_x64", True)
    entries: list[dict[str, Any]] = []
    begin = time.process_time(), time.perf_counter()
    call, sizes = PROGRAMS[what][program](space == "space")
    for size in sizes:
        answer = np.asarray(call(size))
        own: dict[str, Any] = {"size": size, "answer": answer.tolist()}
        if not entries:
            own["first"] = [time.process_time() - begin[0], time.perf_counter() - begin[1]]
        spent: list[float] = []
        while len(spent) < RUNS and sum(spent) < 3.0:
            start = time.process_time()
            np.asarray(call(size))
            spent.append(time.process_time() - start)
        entries.append({**own, "time": statistics.median(spent)})
    return entries


def asked(program: str, what: str, space: bool) -> list[dict[str, Any]] | None:
    """As :func:`measured`, in a process of its own; None if the program is not installed."""
    if importlib.util.find_spec(MODULES[program]) is None:
        print(f"{program} is not installed and is left out: pip install -e '.[peers]' brings it.", flush=True)
        return None
    words = [program, what, "space" if space else "plane"]
    said = subprocess.check_output([sys.executable, str(HERE / "peers.py"), *words], text=True)
    return json.loads(said.splitlines()[-1])


def difference(space: bool) -> float:
    """Derivative of the height of the tip at the end by the factor of the stiffness, by central differences."""
    import numpy as np

    import flexmb as fm

    step = 1e-3

    def end(share: float) -> float:
        found = fm.simulate(rod(space, share=share), instants()[[0, -1]], rtol=1e-10).at(f"n{SCENE.segments}")
        return float(np.asarray(found)[-1, 1])

    def central(h: float) -> float:
        return (end(1 + h) - end(1 - h)) / (2 * h)

    # Richardson's extrapolation of two steps.
    return (4 * central(step / 2) - central(step)) / 3


def main() -> None:
    """Ask every program, compare, print, save and draw."""
    import numpy as np
    from record import PACKAGES, RESULTS, save

    import flexmb as fm

    fm.enable_x64()
    kept = RESULTS / "peers.json"
    results = json.loads(kept.read_text(encoding="utf-8")) if sys.argv[1:] and kept.exists() else {}
    results.pop("about", None)
    packages = [name for name in ("soromox", "exudyn", "diffrax") if importlib.util.find_spec(name)]
    for what, space in COMPARISONS:
        title = f"{what} in {'space' if space else 'the plane'}"
        if not {*sys.argv[1:]} <= {what, "space" if space else "plane"}:
            continue
        every = {name: found for name in PROGRAMS[what] if (found := asked(name, what, space)) is not None}
        finest = {name: np.asarray(found[-1]["answer"]) for name, found in every.items()}
        other = "SciPy" if what == "statics" else "SoRoMoX"
        reference = finest.get(other, finest["flexmb"]) if what != "gradient" else np.asarray(difference(space))
        size = abs(float(reference)) if what == "gradient" else SCENE.length
        own: dict[str, Any] = {}
        for program, found in every.items():
            for entry in found:
                apart = np.linalg.norm(np.atleast_1d(np.asarray(entry.pop("answer")) - reference), axis=-1)
                entry["error"] = float(np.max(apart)) / size
            own[program] = found
        if other in finest:
            agreement = float(np.max(np.abs(finest["flexmb"] - finest[other]))) / size
            assert agreement < AGREE[what], (title, agreement)
            own["agreement of two programs"] = agreement
        if what == "gradient":
            assert min(entry["error"] for entry in own["flexmb"]) < AGREE[what], own
        results[title] = own
        show(title, own)
        save("peers", results, (*PACKAGES, *packages))
    draw(results)


def show(title: str, own: dict[str, Any]) -> None:
    """Print a comparison."""
    print(title)
    for program, found in own.items():
        if isinstance(found, float):
            print(f"  {program}: {found:.1e}")
            continue
        processor, clock = found[0]["first"]
        print(f"  {program}: first call {processor:.2f} s of the processor, {clock:.2f} s by the clock")
        for entry in found:
            print(f"    {entry['size']:<8g} error {entry['error']:.1e}   {1e3 * entry['time']:10.2f} ms", flush=True)


def draw(results: dict[str, Any]) -> None:
    """Error against time of a run, a picture for each comparison."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.ticker import NullFormatter
    from record import RESULTS

    shown = [title for title in results if not title.startswith("gradient")]
    figure, every = plt.subplots(1, len(shown), figsize=(3.6 * len(shown), 3.8), layout="constrained")
    colours = dict(zip(MODULES, itertools.cycle("rbgk")))
    lines: dict[str, Any] = {}
    for axes, title in zip(every, shown, strict=True):
        for program, found in results[title].items():
            if isinstance(found, float):
                continue
            # The finest answer of the reference itself has no error to draw.
            points = [(1e3 * e["time"], e["error"]) for e in found if e["error"] > 0]
            lines[program] = axes.loglog(*zip(*points, strict=True), "o-", color=colours[program], label=program)[0]
        axes.set_title(title, fontsize=10)
        axes.set_xlabel("processor time of a run [ms]")
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.grid(True, which="major", alpha=0.4)
    every[0].set_ylabel("largest error of the tip, over the length [-]")
    figure.legend(lines.values(), lines, loc="outside lower center", ncols=len(lines), fontsize=9)
    figure.savefig(RESULTS / "peers.png", dpi=120)


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    if sys.argv[3:]:
        print(json.dumps(measured(*sys.argv[1:])))
    else:
        main()
