"""One table in five minutes, beside the one that is committed: ``python -m benchmarks --quick``.

Every row is a question with an answer known from elsewhere: its error, the time of one answer once compiled, the
processor time of the first one from nothing, the instructions that were compiled for it, and the ratio to Exudyn where
that is installed and answers the same question. Rows run in processes of their own, without kept code.

Machines differ, and this one is never quiet. So times are compared as ratios to two yardsticks of the same process, a
factorisation and a program to compile, and may lose what the table calls noise; errors and instructions do not scatter,
and may lose next to nothing. What lost more is named, and the exit status is 1. ``--keep`` writes the table anew.
"""

import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

HERE = Path(__file__).parent
TABLE = HERE / "results" / "quick.json"
RUNS, PROCESSES = 7, 2
# What may be lost before it is named: factors of the best time of a run, of the first, of an error and of instructions.
NOISE = {"time": 1.6, "first": 1.4, "error": 2.0, "instructions": 1.02}
# Errors below are round-off.
ROUND_OFF = 1e-11
# Of the spatial guide by two spectral beams of order 8 a leaf spring [m], to which SPACAR beams converge
# (large_deflection.py).
STROKE = 0.009954041778976519
# First frequencies of the spatial guide by eight beams a leaf spring [Hz].
SPATIAL = (10.64461093830858, 192.43952671102812)
# Tip of the soft pendulum after a second by six spectral beams of order 5 [m]; four of them are 5e-6 from there
# (swing.py).
SOFT = (-0.9875879785147055, 0.051795336526723725)


class Case(NamedTuple):
    """A question.

    Attributes:
        ask: Answers it, and returns when the answer is there.
        error: Of an answer, relative.
        size: Of the matrix whose eigenvalues are timed beside it.
        peer: Answers the same question by Exudyn, about as accurately: its error stands in the file.
    """

    ask: Callable[[], Any]
    error: Callable[[Any], float]
    size: int
    peer: Callable[[], Any] | None = None


def _off(exact: Any) -> Callable[[Any], float]:
    """Largest difference from what is known, over its largest value."""
    import numpy as np

    exact = np.asarray(exact, float)
    return lambda found: float(np.max(np.abs(np.asarray(found) - exact)) / np.max(np.abs(exact)))


def _planar(thickness: Any = 0.5e-3, force: float = 0.0):
    """The tutorial's guide in the plane, with the voice coil on its bar."""
    import flexmb as fm
    from flexmb import planar

    leaf = fm.Rectangle(0.018, thickness, fm.Material(E=210e9, G=80e9, rho=7850.0))
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, 0.1), "C": (0.1, 0.1), "D": (0.1, 0)}.items():
        b.node(name, place)
    b.add(planar.beam, "A", "B", name="left", section=leaf, released=(2, 3))
    b.add(planar.beam, "D", "C", name="right", section=leaf, released=(2, 3))
    b.add(planar.beam, "B", "C", name="bar")
    b.fix("A")
    b.fix("D")
    b.mass("B", 0.1)
    b.mass("C", 0.1)
    b.force("B", (0.0, force))
    b.dof("B", "x")
    return b.build()


def frequency() -> Case:
    """First frequency of the guide in the plane, closed form."""
    import numpy as np

    import flexmb as fm

    # Stiffness of two clamped leaf springs in sway; mass of the stage, and 26/35 of theirs by their cubic shape.
    stiffness, mass = 24 * 0.039375 / 0.1**3, 0.2 + 2 * 13 / 35 * 0.0070650
    model = _planar()
    return Case(lambda: np.asarray(fm.frequencies(model)), _off([np.sqrt(stiffness / mass) / (2 * np.pi)]), 1)


def spatial_frequencies() -> Case:
    """Frequencies of the spatial guide, all 18 deformations free, beside the same with four times as many beams."""
    import warnings

    import numpy as np
    from scenes import guide

    import flexmb as fm

    # What plain beams leave out is not the question.
    warnings.simplefilter("ignore", fm.BeamTheoryWarning)
    model = guide()
    return Case(lambda: np.asarray(fm.frequencies(model)[:2]), _off(SPATIAL), 18)


def gradient() -> Case:
    """Frequency and its derivative by the thickness, of the stiffness and of the mass: closed form."""
    import jax
    import numpy as np

    import flexmb as fm

    both = fm.jit(jax.value_and_grad(lambda t: fm.frequencies(_planar(t))[0]))

    def exact(t):
        stiffness, mass = 24 * 210e9 * 0.018 * t**3 / 12 / 0.1**3, 0.2 + 2 * 13 / 35 * 7850 * 0.018 * t * 0.1
        return np.sqrt(stiffness / mass) / (2 * np.pi), mass

    value, mass = exact(5e-4)
    slope = value / 2 * (3 / 5e-4 - 2 * 13 / 35 * 7850 * 0.018 * 0.1 / mass)

    def error(found):
        return float(max(abs(found[0] / value - 1), abs(found[1] / slope - 1)))

    return Case(lambda: [np.asarray(one) for one in both(5e-4)], error, 1)


def buckling() -> Case:
    """Buckling load of the guide in the plane, T3 of the reference problems."""
    import numpy as np

    import flexmb as fm

    model = _planar(force=-1.0)
    return Case(lambda: np.asarray(fm.buckling(model).multipliers), _off([78.75]), 1)


def _rod(load: tuple[float, float]):
    """A cantilever of unit length and bending stiffness, one spectral beam of order 8.

    Args:
        load: Dead force at its tip [N].
    """
    import flexmb as fm
    from flexmb import planar

    b = fm.Builder()
    b.node("root", (0.0, 0.0))
    b.node("tip", (1.0, 0.0))
    b.add(planar.spectral_beam, "root", "tip", section=fm.Rigidity(EA=1e9, EIy=1.0), order=8)
    b.fix("root")
    b.force("tip", load)
    return b.build()


def elastica() -> Case:
    """One spectral beam of order 8 under P L^2/EI = 5, A1 of the reference problems."""
    import numpy as np

    import flexmb as fm

    model = _rod((0.0, 5.0))
    exact = [1 - 0.3876283607, 0.7137915236]
    return Case(lambda: np.asarray(fm.equilibrium(model).at("tip")), _off(exact), 8)


def path() -> Case:
    """The same rod pressed past its buckling load, on one of the branches, where it turned by 40 degrees: A2."""
    import numpy as np

    import flexmb as fm

    factor, x, y = 1.0636632664, 0.8812035117, 0.4222403401
    load = factor * np.pi**2 / 4
    model = _rod((-load, 0.0))

    def ask():
        found = fm.path(model, switch=1)
        return np.asarray(found.at("tip"))[-1]

    return Case(ask, lambda found: float(np.max(np.abs(found - [x, y]))), 8)


def stroke() -> Case:
    """The spatial guide at a stroke of 10 mm by eight beams a leaf spring, beside Exudyn with 32."""
    import large_deflection as case
    import peer_exudyn

    import flexmb as fm
    from flexmb import spatial

    model, off = case.guide(spatial.beam, 8), _off([STROKE])
    peer = None
    if peer_exudyn.installed():
        sizes = case.leaf(shear=True).rigidity(), case.LENGTH, case.DISTANCE, case.FORCE, 32
        peer = peer_exudyn.fastest(*sizes)["solve"]
    return Case(lambda: float(fm.equilibrium(model).at("right8")[1]) - case.DISTANCE, lambda y: off([y]), 90, peer)


def spectral_stroke() -> Case:
    """The same by one spectral beam of order 4 a leaf spring."""
    import large_deflection as case

    import flexmb as fm
    from flexmb import spatial

    model, off = case.guide(spatial.spectral_beam(4)), _off([STROKE])
    return Case(lambda: float(fm.equilibrium(model).at("right1")[1]) - case.DISTANCE, lambda y: off([y]), 48)


def designs() -> Case:
    """A thousand designs of the guide in the plane in one call, closed form of each."""
    import jax
    import jax.numpy as jnp
    import numpy as np

    import flexmb as fm

    thickness = np.linspace(2e-4, 1e-3, 1000)
    stiffness, mass = 24 * 210e9 * 0.018 * thickness**3 / 12 / 0.1**3, 0.2 + 26 / 35 * 7850 * 0.018 * thickness * 0.1
    many = fm.jit(lambda t: jax.lax.map(lambda one: fm.frequencies(_planar(one))[0], t, batch_size=50))
    given = jnp.asarray(thickness)
    return Case(lambda: np.asarray(many(given)), _off(np.sqrt(stiffness / mass) / (2 * np.pi)), 1)


def pendulum() -> Case:
    """Soft pendulum of sixteen beams, one second, beside six spectral beams at 1e-9, and Exudyn at the same error."""
    import numpy as np
    import peer_exudyn
    import swing

    import flexmb as fm

    exact = np.array(SOFT)
    model = swing.pendulum(16)
    sizes = swing.LENGTH, swing.MASS, swing.BENDING, swing.STRETCHING, swing.GRAVITY
    peer = peer_exudyn.pendulum(*sizes, 16, swing.END, 2000) if peer_exudyn.installed() else None

    def ask():
        return np.asarray(fm.simulate(model, [0.0, swing.END], rtol=3e-5).at("n16"))[-1]

    return Case(ask, lambda found: float(np.linalg.norm(found - exact)), 48, peer)


def spectral_motion() -> Case:
    """Free rod in space by one spectral beam of order 4, D1 of the reference problems."""
    import numpy as np
    import swing

    import flexmb as fm

    ramp = np.array([0.0, swing.PEAK, 2 * swing.PEAK])
    force, moment = np.zeros((2, 3, 3))
    force[1], moment[1] = (swing.LOAD / 10, 0, 0), (0, -swing.LOAD / 2, -swing.LOAD)
    loads = {"n0": fm.motion.Table(ramp, force), "n0.rotation": fm.motion.Table(ramp, moment)}
    model, exact = swing.spaghetti(1, 4), np.array([*swing.LOWER, *swing.UPPER])

    def ask():
        motion = fm.simulate(model, [0.0, swing.PEAK], loads=loads, rtol=1e-4)
        return np.concatenate([np.asarray(motion.at(f"n{i}"))[-1] for i in (0, 1)])

    return Case(ask, lambda found: float(np.linalg.norm(found - exact)) / swing.ROD, 42)


def thousand_beams() -> Case:
    """Four frequencies of a cantilever of a thousand beams by sparse matrices, closed form."""
    import numpy as np

    import flexmb as fm
    from flexmb import planar

    b = fm.Builder()
    for i in range(1001):
        b.node(f"n{i}", (i / 1000, 0.0))
    for i in range(1000):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e6, EIy=1.0, mass=1.0))
    b.fix("n0")
    model = b.build(check=False)
    roots = np.array([1.8751040687119611, 4.694091132974174, 7.854757438237613, 10.995540734875467])
    return Case(lambda: np.asarray(fm.frequencies(model, count=4, sparse=True)), _off(roots**2 / (2 * np.pi)), 300)


CASES: tuple[Callable[[], Case], ...] = (
    frequency,
    gradient,
    buckling,
    spatial_frequencies,
    designs,
    elastica,
    path,
    stroke,
    spectral_stroke,
    thousand_beams,
    pendulum,
    spectral_motion,
)


def measure(name: str) -> dict[str, Any]:
    """One row, in this process.

    Args:
        name: Of the case.

    Returns:
        Error; best time of one answer and of Exudyn's [s]; processor time of the first [s]; yardsticks [s].
    """
    import jax
    import jax.numpy as jnp
    import numpy as np

    import flexmb as fm

    fm.enable_x64()

    def best(call: Callable[[], Any]) -> float:
        times = []
        for _ in range(RUNS):
            begin = time.perf_counter()
            call()
            times.append(time.perf_counter() - begin)
        return min(times)

    # Yardstick of the compiler: a program of its own, traced and compiled.
    @jax.jit
    def program(a):
        def step(a, _):
            return jnp.tanh(jnp.linalg.solve(a + 4 * jnp.eye(6), a @ jnp.sin(a))), jnp.linalg.eigvalsh(a + a.T)

        return jax.jacfwd(lambda a: jax.lax.scan(step, a, length=5)[1])(a)

    begin = time.process_time()
    jax.block_until_ready(program(jnp.ones((6, 6))))
    yardstick = time.process_time() - begin
    case = next(one for one in CASES if one.__name__ == name)()
    begin = time.process_time()
    answer = case.ask()
    first = time.process_time() - begin
    symmetric = np.random.default_rng(0).standard_normal((case.size, case.size))
    symmetric, eigh = jnp.asarray(symmetric + symmetric.T), jax.jit(jnp.linalg.eigh)
    other = jnp.asarray(np.random.default_rng(1).standard_normal((120, 120)))
    jax.block_until_ready((eigh(symmetric), eigh(other)))
    found = {
        "error": case.error(answer),
        "time": best(case.ask),
        "first": first,
        "eigh": best(lambda: jax.block_until_ready(eigh(symmetric))),
        "yardstick": {"time": best(lambda: jax.block_until_ready(eigh(other))), "first": yardstick},
    }
    if case.peer is not None:
        found["peer_error"] = case.error(case.peer())
        found["peer"] = best(case.peer)
    return found


def instructions(folder: Path) -> int:
    """How many instructions the compiler was given, over all programs of a process.

    Args:
        folder: Where it left them as text.
    """
    texts = (path.read_text() for path in folder.glob("*before_optimizations.txt"))
    return sum(line.count(" = ") for text in texts for line in text.splitlines() if line.startswith("  "))


def row(name: str) -> dict[str, Any]:
    """One row, of several processes: the best of each time, and the instructions of a last one.

    Args:
        name: Of the case.
    """
    paths = os.pathsep.join([str(HERE.parent), str(HERE), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PYTHONPATH": paths, "JAX_PLATFORMS": "cpu", "OPENBLAS_NUM_THREADS": "1"}
    code = f"import json, quick; print(json.dumps(quick.measure({name!r})))"

    def found(more: dict[str, str]) -> dict[str, Any]:
        run = subprocess.run([sys.executable, "-c", code], env={**environment, **more}, capture_output=True, text=True)
        if run.returncode:
            raise RuntimeError(f"{name}: {run.stderr.strip().splitlines()[-1]}")
        return json.loads(run.stdout.splitlines()[-1])

    several = [found({}) for _ in range(PROCESSES)]
    own = dict(several[0])
    for key in ("time", "first", "eigh", "peer"):
        if key in own:
            own[key] = min(one[key] for one in several)
    own["yardstick"] = {key: min(one["yardstick"][key] for one in several) for key in own["yardstick"]}
    with tempfile.TemporaryDirectory() as folder:
        flags = f"{os.environ.get('XLA_FLAGS', '')} --xla_dump_to={folder} --xla_dump_hlo_as_text"
        found({"XLA_FLAGS": flags.strip()})
        own["instructions"] = instructions(Path(folder))
    return own


def losses(new: dict[str, dict], old: dict[str, dict]) -> list[str]:
    """What is worse than the committed table by more than its noise, one sentence each.

    Args:
        new: Rows by name.
        old: Those committed.
    """
    told = [f"{name}: in the committed table, but no longer measured" for name in old if name not in new]
    for name, own in new.items():
        if name not in old:
            told.append(f"{name}: not in the committed table; --keep writes it")
            continue
        before = old[name]
        for key, allowed in NOISE.items():
            at_least = ROUND_OFF if key == "error" else 0.0
            scale = own["yardstick"][key] / before["yardstick"][key] if key in own["yardstick"] else 1.0
            ratio = max(own[key], at_least) / max(before[key] * scale, at_least)
            if not ratio <= allowed:
                machine = f", on a machine that takes {scale:.2f} times as long" if key in own["yardstick"] else ""
                told.append(f"{name}: {key} {own[key]:.3g}, was {before[key]:.3g}{machine}: {ratio:.2f} times")
    return told


def shown(rows: dict[str, dict], old: dict[str, dict]) -> str:
    """The table, with what each number was.

    Args:
        rows: Rows by name.
        old: Those committed.
    """
    heads = ["question", "error", "time [ms]", "eighs", "of Exudyn's", "first, CPU [s]", "instructions"]
    lines = [f"{heads[0]:<20}" + "".join(f"{head:>24}" for head in heads[1:])]

    def cell(own: dict, name: str, key: str, by: float = 1.0) -> str:
        was = f" ({by * old[name][key]:.3g})" if name in old and key in old[name] else ""
        return f"{by * own[key]:.3g}{was}" if key in own else "-"

    for name, own in rows.items():
        peer = f"{own['time'] / own['peer']:.2g}" if "peer" in own else "-"
        cells = [cell(own, name, "error"), cell(own, name, "time", 1e3), f"{own['time'] / own['eigh']:.3g}", peer]
        cells += [cell(own, name, "first"), cell(own, name, "instructions")]
        lines.append(f"{name:<20}" + "".join(f"{text:>24}" for text in cells))
    return "\n".join(lines)


def main(arguments: list[str]) -> int:
    """Measure, print, compare; 1 where something lost.

    Args:
        arguments: "--keep", names of rows.
    """
    from record import save

    keep, wanted = "--keep" in arguments, [name for name in arguments if name != "--keep"]
    known = [case.__name__ for case in CASES]
    if unknown := [name for name in wanted if name not in known]:
        print(f"There is no row '{unknown[0]}'. There are: {', '.join(known)}; and --keep.", file=sys.stderr)
        return 2
    old = json.loads(TABLE.read_text())["rows"] if TABLE.exists() else {}
    if importlib.util.find_spec("exudyn") is None:
        print("Exudyn is not installed and is left out: pip install -e '.[peers]' brings it.")
    rows = {}
    for name in wanted or known:
        rows[name] = row(name)
        print(f"{name}: error {rows[name]['error']:.1e}, {1e3 * rows[name]['time']:.3g} ms", flush=True)
    print(shown(rows, old))
    if keep:
        save("quick", {"rows": {**old, **rows} if wanted else rows})
        return 0
    told = losses(rows, {name: of for name, of in old.items() if name in rows or not wanted})
    print("\n".join(["Worse than the committed table:", *told]) if told else "Nothing is worse than it was.")
    return bool(told)


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    sys.exit(main(sys.argv[1:]))
