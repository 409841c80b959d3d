"""Ten thousand planar beams: a path, modes, load multipliers, a gradient, each compiled and alone; and are they right.

``python benchmarks/large.py`` prints the tables that README quotes, writes results/large.json and draws
results/large.png. Each question runs in a process of its own, whose memory is measured: ``large.py path 1000``.
"""

import json
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).parent
# Beams of one column of an arch: 4 along it, 3 across, 3 diagonals.
COLUMN, ROWS, CELL = 10, 3, 4e-3
SIZES = (1000, 10_000)
SMALL = 200
# Forces that bend such an arch by some millimetres, a part of what it carries; their product with the cube of its
# length hardly changes [N].
FORCES = {200: 8.0, 1000: 1.5, 10_000: 1.5e-3}
BEYOND = 4.0
STEPS = 20
QUESTIONS = ("equilibrium", "gradient", "modes", "multipliers", "path", "limit")
TOLD = {
    "equilibrium": "equilibrium at large deflection",
    "gradient": "gradient of a displacement by all thicknesses, equilibrium included",
    "modes": "ten frequencies about the equilibrium",
    "multipliers": "five load multipliers",
    "path": f"path of {STEPS} steps past a limit point",
    "limit": "limit load with its gradient by all thicknesses",
}


def members(columns: int) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Places of the ends of every beam: along the arch, across it, diagonals to either side in turn."""
    found = []
    for i in range(columns):
        found += [((i, j), (i + 1, j)) for j in range(ROWS + 1)]
        for j in range(ROWS):
            up = (i + j) % 2 == 0
            found += [((i + 1, j), (i + 1, j + 1)), ((i, j + 1 - up), (i + 1, j + up))]
    return found


def place(columns: int, i: int, j: int) -> tuple[float, float]:
    """Where a node of a shallow sine arch is [m]; its rise is 2.5 times its height."""
    import math

    return CELL * i, CELL * (j + 2.5 * ROWS * math.sin(math.pi * i / columns))


def arch(beams: int, force: float, check: bool = False):
    """A lattice arch between two walls, pressed in its middle.

    Args:
        beams: Its beams, a multiple of ten.
        force: Upon the middle of its top [N].
        check: Whether degrees of freedom are found, for dense matrices.
    """
    import flexmb as fm
    from flexmb import planar

    columns = beams // COLUMN
    section = fm.Rectangle(10e-3, 0.5e-3, fm.Material(E=60e6, G=20e6, rho=1200.0))
    b = fm.Builder()
    for i in range(columns + 1):
        for j in range(ROWS + 1):
            b.node(f"{i},{j}", place(columns, i, j))
    for (i, j), (k, m) in members(columns):
        b.add(planar.beam, f"{i},{j}", f"{k},{m}", section=section)
    for j in range(ROWS + 1):
        b.fix(f"0,{j}")
        b.fix(f"{columns},{j}")
    b.force(f"{columns // 2},{ROWS}", (0.0, -force))
    return b.build(check=check)


def questions(beams: int, sparse: bool = True) -> dict:
    """Functions of thicknesses, by name, that return when their answer is there."""
    import jax
    import numpy as np

    import flexmb as fm

    model = arch(beams, FORCES[beams], check=not sparse)
    top = int(model.labels.known(f"{beams // COLUMN // 2},{ROWS}")[1])

    def of(thickness):
        return model.with_property("section.thickness", thickness)

    def height(thickness):
        return fm.equilibrium(of(thickness), sparse=sparse).x[top]

    def multipliers(thickness):
        if sparse:
            return np.asarray(fm.buckling_loads(of(thickness), count=5, sparse=True))
        return np.asarray(fm.buckling_loads(of(thickness), sparse=False))[:5]

    def path(thickness):
        pushed = arch(beams, BEYOND * FORCES[beams], check=not sparse).with_property("section.thickness", thickness)
        found = fm.path(pushed, max_steps=STEPS, throw=False, **({"sparse": True} if sparse else {}))
        kinds = [p.kind for p in found.critical_points]
        first = next((p.load_factor for p in found.critical_points if p.kind == "limit"), float("nan"))
        return np.array([float(first), len(found.load_factor), len(kinds)])

    def limit(thickness):
        def load(thickness):
            pushed = arch(beams, BEYOND * FORCES[beams], check=not sparse)
            return fm.limit_load(pushed.with_property("section.thickness", thickness), sparse=sparse)

        value, slopes = jax.value_and_grad(load)(thickness)
        return np.array([float(value), float(np.sum(slopes * thickness))])

    return {
        "equilibrium": lambda t: np.asarray(height(t)),
        "gradient": lambda t: np.asarray(jax.grad(height)(t)),
        "modes": lambda t: np.asarray(fm.frequencies(of(t), count=10, sparse=sparse)),
        "multipliers": multipliers,
        "path": path,
        "limit": limit,
    }


def measured(question: str, beams: int, sparse: bool = True) -> dict:
    """Times of one question in this process, and what it took of memory."""
    import numpy as np
    from record import peak_memory

    import flexmb as fm

    fm.enable_x64()
    begin = time.perf_counter()
    ask = questions(beams, sparse)[question]
    built = time.perf_counter() - begin
    rng, runs = np.random.default_rng(0), []
    # Each time with other numbers, so that no answer is at hand; the first compiles.
    for _ in range(2 if question in ("path", "limit") else 3):
        thickness = 0.5e-3 * (1 + 0.01 * rng.uniform(-1, 1, beams))
        begin, processor = time.perf_counter(), time.process_time()
        answer = ask(thickness)
        runs.append((time.perf_counter() - begin, time.process_time() - processor))
    best = min(runs[1:])
    return {
        "build_s": built,
        "first_s": runs[0][0],
        "first_processor_s": runs[0][1],
        "time_s": best[0],
        "processor_s": min(run[1] for run in runs[1:]),
        "peak_GB": peak_memory(),
        "answer": np.atleast_1d(answer).tolist() if question != "gradient" else [],
    }


def apart(question: str, beams: int, sparse: bool = True) -> dict:
    """The same in a process of its own."""
    words = [sys.executable, str(HERE / "large.py"), question, str(beams), *(() if sparse else ("dense",))]
    return json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout.splitlines()[-1])


def agreement() -> dict[str, float]:
    """Largest relative difference of sparse and dense answers about an arch of 200 beams."""
    import numpy as np

    start = 0.5e-3 * (1 + 0.01 * np.random.default_rng(1).uniform(-1, 1, SMALL))
    one, other = questions(SMALL), questions(SMALL, sparse=False)
    found = {}
    for name in QUESTIONS[:4]:
        a, b = one[name](start), other[name](start)
        found[name] = float(np.max(np.abs(a - b)) / np.max(np.abs(b)))
    return found


def frame_gradient(beams: int, force: float):
    """Height of the middle and its derivative by every thickness, by a linear frame program in plain NumPy.

    Stiffness matrices of Hermite beams, an adjoint solution, and the derivative of each matrix by its thickness. It
    shares nothing with flexmb but the places of the beams.
    """
    import numpy as np
    import scipy.sparse
    import scipy.sparse.linalg

    columns, width, thickness, modulus = beams // COLUMN, 10e-3, 0.5e-3, 60e6
    places = np.array([place(columns, i, j) for i in range(columns + 1) for j in range(ROWS + 1)])
    ends = np.array([[i * (ROWS + 1) + j, k * (ROWS + 1) + m] for (i, j), (k, m) in members(columns)])
    along = places[ends[:, 1]] - places[ends[:, 0]]
    long = np.linalg.norm(along, axis=1)
    c, s = along.T / long

    def matrices(axial, bending):
        """Stiffness of each beam in global axes, (beams, 6, 6)."""
        a, z = axial / long, np.zeros_like(long)
        b, d, e, f = 12 * bending / long**3, 6 * bending / long**2, 4 * bending / long, 2 * bending / long
        rows = [
            [a, z, z, -a, z, z],
            [z, b, d, z, -b, d],
            [z, d, e, z, -d, f],
            [-a, z, z, a, z, z],
            [z, -b, -d, z, b, -d],
            [z, d, f, z, -d, e],
        ]
        turn = np.zeros((len(long), 6, 6))
        for k in (0, 3):
            turn[:, k, k], turn[:, k, k + 1], turn[:, k + 1, k], turn[:, k + 1, k + 1] = c, s, -s, c
            turn[:, k + 2, k + 2] = 1
        return np.einsum("nai,nab,nbj->nij", turn, np.moveaxis(np.array(rows), 2, 0), turn)

    full = np.full(beams, thickness)
    dofs = (3 * ends[:, :, None] + np.arange(3)).reshape(-1, 6)
    whole = scipy.sparse.coo_array(
        (
            matrices(modulus * width * full, modulus * width * full**3 / 12).ravel(),
            (np.repeat(dofs, 6, axis=1).ravel(), np.tile(dofs, (1, 6)).ravel()),
        ),
        (3 * len(places), 3 * len(places)),
    ).tocsr()
    moves = np.ones(3 * len(places), bool)
    moves[: 3 * (ROWS + 1)] = moves[-3 * (ROWS + 1) :] = False
    middle = 3 * (columns // 2 * (ROWS + 1) + ROWS) + 1
    load = np.zeros(3 * len(places))
    load[middle] = -force
    u = np.zeros_like(load)
    u[moves] = scipy.sparse.linalg.spsolve(whole[moves][:, moves].tocsc(), load[moves])
    # The adjoint load is the unit force where the load is.
    slopes = matrices(modulus * width * np.ones(beams), modulus * width * full**2 / 4)
    gradient = -np.einsum("ni,nij,nj->n", u[dofs] / -force, slopes, u[dofs])
    return places.ravel()[2 * (middle // 3) + 1] + u[middle], gradient


def check_gradient(beams: int) -> dict[str, float]:
    """Relative error of the gradient, of a linear frame under a tiny load and of differences at large deflection."""
    import jax
    import numpy as np

    import flexmb as fm

    tiny = 1e-6 * FORCES[beams]
    start = np.full(beams, 0.5e-3)
    found = {}
    for name, force in (("linear", tiny), ("large", FORCES[beams])):
        model = arch(beams, force)
        top = int(model.labels.known(f"{beams // COLUMN // 2},{ROWS}")[1])

        def height(thickness, model=model, top=top):
            return fm.equilibrium(model.with_property("section.thickness", thickness), sparse=True).x[top]

        gradient = np.asarray(jax.grad(height)(start))
        if name == "linear":
            exact = frame_gradient(beams, force)[1]
            found["linear frame"] = float(np.max(np.abs(gradient - exact)) / np.max(np.abs(exact)))
            continue
        along, step = np.random.default_rng(2).standard_normal(beams), 2e-6
        near, far = (float(height(start + k * step * along) - height(start - k * step * along)) for k in (1, 2))
        found["central differences"] = abs((8 * near - far) / (12 * step) / float(gradient @ along) - 1)
    return found


def elastica_errors() -> dict[int, float]:
    """Error of a cantilever's tip at a large deflection, relative to its length, by its number of beams."""
    import numpy as np
    from scipy.integrate import solve_bvp

    import flexmb as fm
    from flexmb import planar

    # theta'' = -(F L^2/EI) cos(theta), clamped at 0 and without moment at 1, with F L^2/EI = 2.
    def rates(_, y):
        return [y[1], -2 * np.cos(y[0])]

    s = np.linspace(0, 1, 41)
    guess = np.array([s, 1 - s])
    solved = solve_bvp(lambda s, y: np.array(rates(s, y)), lambda a, b: np.array([a[0], b[1]]), s, guess, tol=1e-10)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    turned = solved.sol((nodes + 1) / 2)[0]
    exact = np.array([weights @ np.cos(turned), weights @ np.sin(turned)]) / 2
    found = {}
    for count in (10, 100, 1000):
        b = fm.Builder()
        for i in range(count + 1):
            b.node(f"n{i}", (i / count, 0.0))
        for i in range(count):
            b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e4, EIy=1.0), released=(2, 3))
        b.fix("n0")
        b.force(f"n{count}", (0.0, 2.0))
        tip = fm.equilibrium(b.build(check=False), sparse=True).at(f"n{count}")
        found[count] = float(np.max(np.abs(np.asarray(tip) - exact)))
    return found


def main() -> None:
    """Check, measure, print, save and draw."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from record import RESULTS, save, side_by_side

    import flexmb as fm

    fm.enable_x64()
    right: dict = {"dense": agreement(), "gradient": check_gradient(1000), "elastica": elastica_errors()}
    print(json.dumps(right, indent=1), flush=True)
    few, many = SIZES
    found = dict(zip(QUESTIONS, side_by_side(lambda question: apart(question, few), QUESTIONS), strict=True))
    found = {f"{question}: {few}": entry for question, entry in found.items()}
    # Whose seconds are told have the machine alone.
    found |= {f"{question}: {many}": apart(question, many) for question in QUESTIONS}
    for name, entry in found.items():
        question, beams = name.split(": ")
        print(
            f"{beams:>6} beams, {TOLD[question]}: {entry['time_s']:.2f} s (processor {entry['processor_s']:.2f} s),"
            f" first {entry['first_s']:.1f} s, {entry['peak_GB']:.2f} GB"
        )
    for beams in SIZES:
        walked, alone = (found[f"{question}: {beams}"]["answer"][0] for question in ("path", "limit"))
        right[f"limit load beside that of the path: {beams}"] = abs(alone / walked - 1)
    save("large", {"right": right, "found": found})
    figure, axes = plt.subplots(figsize=(6.8, 4.2), layout="constrained")
    for question, marker in zip(QUESTIONS, "osD^vP", strict=True):
        axes.loglog(
            SIZES, [found[f"{question}: {n}"]["processor_s"] for n in SIZES], marker=marker, label=TOLD[question]
        )
    axes.set(xlabel="beams", ylabel="processor time, compiled [s]", title="A lattice arch")
    axes.grid(alpha=0.4)
    axes.legend(fontsize=8)
    figure.savefig(RESULTS / "large.png", dpi=120)


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    if sys.argv[1:]:
        print(json.dumps(measured(sys.argv[1], int(sys.argv[2]), "dense" not in sys.argv)))
    else:
        main()
