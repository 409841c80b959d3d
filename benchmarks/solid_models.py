"""Solid finite-element models for CalculiX: meshes of 20-node bricks, steps of an analysis, what came out.

A model is bricks that share the nodes at which they touch, a foot that is held and faces that a rigid body joins. A
run writes one input file into a temporary folder and reads what CalculiX prints.
"""

import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

# Where points of equal place are one node [m].
SAME = 1e-9
# Corners and mid-edge points of a C3D20 as steps of half an element along x, y, z.
CORNERS = ((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2))
EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
BRICK = np.array(
    CORNERS + tuple(tuple((np.array(CORNERS[a]) + np.array(CORNERS[b])) // 2) for a, b in EDGES), dtype=int
)
# Residual and correction at which a step has converged; the usual half a percent is not enough for differences.
TIGHT = "*CONTROLS,PARAMETERS=FIELD\n1e-7,1e-6,,,1e-6\n"


def installed() -> bool:
    """Whether CalculiX is there."""
    return shutil.which("ccx") is not None


def graded(start: float, end: float, first: float, last: float, most: float, growth: float) -> np.ndarray:
    """Places between two ends, close together at the ends and further apart between them.

    Args:
        start: First place [m].
        end: Last place [m].
        first: Size of the element at the first place [m].
        last: At the last place [m].
        most: Largest size [m].
        growth: Ratio of neighbours.

    Returns:
        Places from start to end [m].
    """
    length = end - start

    def size(s):
        from_first, from_last = first + (growth - 1) * s, last + (growth - 1) * (length - s)
        return np.minimum(np.minimum(from_first, from_last), most)

    # Elements as equal shares of the integral of 1/size.
    s = np.linspace(0, length, 4001)
    density = 1 / size(s)
    count = np.concatenate([[0], np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(s))])
    number = max(1, round(count[-1]))
    return start + np.interp(np.linspace(0, count[-1], number + 1), count, s)


class Mesh:
    """Bricks of 20 nodes, and the rigid bodies and held nodes.

    Args:
        element: "C3D20R" or "C3D20".
    """

    def __init__(self, element: str = "C3D20R"):
        self.element = element
        self.points: list[np.ndarray] = []
        self.bricks: list[np.ndarray] = []
        self.sets: dict[str, np.ndarray] = {}
        self.rigid: list[tuple[str, int, int]] = []
        self._known: dict[tuple[int, ...], int] = {}

    def node(self, point: Sequence[float], shared: bool = True) -> int:
        """Number of the node at a place, made where there is none.

        Args:
            point: (3,) [m].
            shared: Whether a node that is there already is taken.
        """
        key = tuple(round(c / SAME) for c in point)
        if shared and key in self._known:
            return self._known[key]
        self.points.append(np.asarray(point, float))
        if shared:
            self._known[key] = len(self.points)
        return len(self.points)

    def box(self, xs, ys, zs, shape: Callable | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Add bricks between planes.

        Args:
            xs, ys, zs: Places of the planes between elements [m].
            shape: Where a point of the box lies, of x, y, z; as it is if None.

        Returns:
            Numbers of the nodes on its first face along x and on its last.
        """
        halves = [np.interp(np.arange(2 * len(p) - 1) / 2, np.arange(len(p)), p) for p in (xs, ys, zs)]
        numbers: dict[tuple[int, int, int], int] = {}

        def number(at):
            if at not in numbers:
                point = [h[i] for h, i in zip(halves, at, strict=True)]
                numbers[at] = self.node(point if shape is None else shape(*point))
            return numbers[at]

        for i in range(len(xs) - 1):
            for j in range(len(ys) - 1):
                for k in range(len(zs) - 1):
                    at = BRICK + 2 * np.array([i, j, k])
                    self.bricks.append(np.array([number(tuple(int(a) for a in one)) for one in at]))
        ends = (0, 2 * len(xs) - 2)
        first, last = (np.array(sorted(n for at, n in numbers.items() if at[0] == end)) for end in ends)
        return first, last

    def pick(self, name: str, where: Callable) -> np.ndarray:
        """Name the nodes at which a condition holds.

        Args:
            name: Of the set.
            where: Of places (n, 3), booleans (n,).

        Returns:
            Numbers of the nodes.
        """
        self.sets[name] = np.flatnonzero(where(np.array(self.points))) + 1
        if not self.sets[name].size:
            raise ValueError(f"No node lies in '{name}'.")
        return self.sets[name]

    def make_rigid(self, name: str, centre: Sequence[float], *also: Sequence[float]) -> tuple[int, ...]:
        """Join the nodes of a set by a rigid body.

        Args:
            name: Of the set.
            centre: Where its reference node lies [m].
            also: More places that move with it [m].

        Returns:
            Reference node, node whose displacements are the rotation vector, and a node for each further place.
        """
        more = [self.node(point, shared=False) for point in also]
        self.sets[name] = np.concatenate([self.sets[name], np.array(more, int)])
        reference, rotation = self.node(centre, shared=False), self.node(centre, shared=False)
        self.rigid.append((name, reference, rotation))
        self.sets.setdefault("REFS", np.array([], int))
        self.sets["REFS"] = np.concatenate([self.sets["REFS"], [reference, rotation], np.array(more, int)])
        return reference, rotation, *more

    def text(self, material: dict[str, float]) -> str:
        """What stands before the steps.

        Args:
            material: E, nu, rho and alpha.
        """
        # CalculiX reads twenty characters of a number and drops the rest, an exponent too.
        lines = ["*NODE,NSET=NALL"]
        lines += [f"{i + 1},{p[0]:.12g},{p[1]:.12g},{p[2]:.12g}" for i, p in enumerate(self.points)]
        lines.append(f"*ELEMENT,TYPE={self.element},ELSET=EALL")
        for i, nodes in enumerate(self.bricks):
            lines += [f"{i + 1}," + ",".join(map(str, nodes[:15])) + ",", ",".join(map(str, nodes[15:]))]
        for name, nodes in self.sets.items():
            lines.append(f"*NSET,NSET={name}")
            lines += [",".join(map(str, nodes[i : i + 15])) + "," for i in range(0, len(nodes), 15)]
        lines += ["*MATERIAL,NAME=M", "*ELASTIC", f"{material['E']},{material['nu']}", "*DENSITY", f"{material['rho']}"]
        lines += ["*EXPANSION,ZERO=0", f"{material['alpha']}", "*SOLID SECTION,ELSET=EALL,MATERIAL=M"]
        lines += [f"*RIGID BODY,NSET={n},REF NODE={a},ROT NODE={b}" for n, a, b in self.rigid]
        return "\n".join(lines) + "\n*BOUNDARY\nFOOT,1,3\n"


def step(
    kind: str = "*STATIC",
    loads: Sequence[tuple[int, int, float]] = (),
    held: Sequence[tuple[int, int, float]] = (),
    nlgeom: bool = False,
    more: str = "",
    increments: str = "",
    perturbation: bool = False,
) -> str:
    """One step of the analysis; it prints displacements of, and forces on, rigid bodies and probes.

    Args:
        kind: Keyword of the procedure, with its data.
        loads: Node, direction 1 to 3, force [N] (or moment, of a rotation node): all that act.
        held: Node, direction, displacement [m]: added to what is held, or changed.
        nlgeom: Whether displacements are large.
        more: Further lines.
        increments: Data of a static step.
        perturbation: Whether it is small about what came before.
    """
    lines = ["*STEP" + (",NLGEOM,INC=1000" if nlgeom else "") + (",PERTURBATION" if perturbation else "")]
    # Without the tight tolerance where nothing is iterated.
    lines += [TIGHT.strip()] if nlgeom else []
    lines += [kind + (f"\n{increments}" if increments else "")]
    if held:
        lines += ["*BOUNDARY", *(f"{n},{d},{d},{v:.12g}" for n, d, v in held)]
    lines += ["*CLOAD,OP=NEW", *(f"{n},{d},{v:.12g}" for n, d, v in loads)] if loads or nlgeom else []
    return "\n".join(lines) + "\n" + more + "*NODE PRINT,NSET=REFS\nU,RF\n*END STEP\n"


class Printed:
    """What CalculiX printed.

    Attributes:
        u: Displacements by node of each increment, and of each mode [m, rad].
        force: Forces and moments on the same nodes [N, N m].
        times: Of the increments: 1 at the end of the first step.
        values: Eigenvalues or buckling factors, if any.
        frequencies: Natural frequencies [Hz], if any.
        seconds: Wall time of CalculiX [s].
    """

    def __init__(self, text: str, seconds: float):
        self.seconds = seconds
        self.u: list[dict[int, np.ndarray]] = []
        self.force: list[dict[int, np.ndarray]] = []
        self.times: list[float] = []
        self.frequencies: list[float] = []
        self.values: list[float] = []
        mode = ""
        for line in text.splitlines():
            words = line.split()
            if line.startswith(" displacements"):
                mode = "u"
                self.u.append({})
                self.times.append(float(words[-1]))
            elif line.startswith(" forces"):
                mode = "f"
                self.force.append({})
            elif "E I G E N V A L U E" in line and "O U T P U T" in line:
                mode = "frequency"
            elif "B U C K L I N G   F A C T O R" in line:
                mode = "buckling"
            elif "P A R T I C I P A T I O N" in line or "E F F E C T I V E" in line:
                mode = ""
            elif words and mode in ("u", "f") and len(words) == 4:
                (self.u if mode == "u" else self.force)[-1][int(words[0])] = np.array([float(w) for w in words[1:]])
            elif words and mode == "frequency" and words[0].isdigit() and len(words) == 5:
                self.frequencies.append(float(words[3]))
            elif words and mode == "buckling" and words[0].isdigit() and len(words) == 2:
                self.values.append(float(words[1]))


def run(mesh: Mesh, material: dict[str, float], steps: Sequence[str], before: str = "") -> Printed:
    """Have CalculiX solve, on one core.

    Args:
        mesh: Nodes, bricks and rigid bodies; with set "FOOT" held.
        material: E, nu, rho and alpha.
        steps: As from :func:`step`.
        before: Further lines before the steps.

    Raises:
        RuntimeError: CalculiX did not get to the end.
    """
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "case.inp").write_text(mesh.text(material) + before + "".join(steps))
        begin = time.perf_counter()
        done = subprocess.run(
            ["ccx", "case"], cwd=folder, env={**os.environ, "OMP_NUM_THREADS": "1"}, capture_output=True, text=True
        )
        seconds = time.perf_counter() - begin
        if keep := os.environ.get("SOLID_KEEP"):
            shutil.copytree(folder, keep, dirs_exist_ok=True)
        if done.returncode or "Job finished" not in done.stdout or "*ERROR" in done.stdout:
            raise RuntimeError(f"CalculiX: {done.stdout[-3000:]}")
        return Printed((Path(folder) / "case.dat").read_text(), seconds)
