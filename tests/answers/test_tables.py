"""Tables on the terminal say the numbers that they are given, each with its sign and in its place."""

import numpy as np

from flexmb.answers.tables import table

GUIDE = {"model": "guide.dat", "mode": 9, "status": "ok", "message": "", "warnings": ["Mind the gap."]}
GUIDE |= {"nx": 12, "nxo": 6, "neo": 5, "ndof": 1, "dofs": [{"kind": "x", "of": 3, "component": 1}]}


def lines_of(**data) -> list[str]:
    return table({**GUIDE, **data}).splitlines()


def below(lines, heading, count) -> list[list[str]]:
    """Words of the lines below the one that begins with a heading."""
    (first,) = (i for i, line in enumerate(lines) if line.startswith(heading))
    return [line.split() for line in lines[first + 1 : first + 1 + count]]


def test_what_stands_above_every_answer():
    assert lines_of() == [
        "guide.dat  mode 9  status ok",
        "NDOF = NX - NXO - NEO = 12 - 6 - 5 = 1",
        "degrees of freedom: x 3.1",
        "warning: Mind the gap.",
    ]
    assert lines_of(stable=True)[-1] == "stable: yes"
    assert lines_of(stable=False, message="It fell.")[-2:] == ["It fell.", "stable: NO"]


def test_matrices():
    a, b = np.array([[0.0, 1.0], [-4485.0, -0.1732]]), np.array([[0.0], [-4.746]])
    lines = lines_of(A=a, B=b, C=np.array([[1.0, 0.0]]), D=np.zeros((1, 1)), inputs=["force 2.1"], outputs=["x 2.1"])
    assert below(lines, "A:", 2) == [["0", "1"], ["-4485", "-0.1732"]]
    assert below(lines, "B:", 2) == [["0"], ["-4.746"]]
    assert below(lines, "C:", 1) == [["1", "0"]]
    assert below(lines, "D:", 1) == [["0"]]
    assert "inputs: force 2.1" in lines
    assert "outputs: x 2.1" in lines
    empty = lines_of(A=a, B=np.zeros((2, 0)), C=np.zeros((0, 2)), D=np.zeros((0, 0)), inputs=[], outputs=[])
    assert empty[-5:] == [*(f"  {0:12.5g}  {1:12.5g}\n  {-4485:12.5g}  {-0.1732:12.5g}".split("\n")), *(
        f"{name}: empty" for name in "BCD"
    )]  # fmt: skip


def test_frequencies_and_poles():
    lines = lines_of(mode=7, eigenvalues=[-250.0, 4485.0], frequencies_hz=[None, 10.6584], massless=3)
    assert below(lines, "natural frequencies [Hz] (2, 3 motions without mass left out):", 2) == [
        ["1", "unstable,", "omega^2", "=", "-250"],
        ["2", "10.6584"],
    ]
    lines = lines_of(mode=7, poles=[[-0.25, 3.5], [-0.25, -3.5]])
    assert below(lines, "poles [1/s]:", 2) == [["1", "-0.25", "+3.5j"], ["2", "-0.25", "-3.5j"]]
    many = lines_of(mode=7, eigenvalues=np.arange(1.0, 16), frequencies_hz=np.arange(1.0, 16), massless=0)
    assert many[-1] == "  ... 3 more"
    assert many[-2].split() == ["12", "12"]


def test_load_multipliers_and_paths():
    assert below(lines_of(mode=8, load_multipliers=np.array([-78.75, 90.5])), "load multipliers:", 2) == [
        ["1", "-78.75"],
        ["2", "90.5"],
    ]
    state = {"load_factor": 0.0, "stable": True, "frequencies_hz": [10.5, 20.0], "load_multipliers": [-3.25, 4.0]}
    falling = {"load_factor": -0.75, "stable": False, "frequencies_hz": [None, 20.0], "load_multipliers": []}
    point = {"kind": "limit", "load_factor": -0.787512345}
    lines = lines_of(mode=10, path=[state, falling], critical_points=[point])
    assert below(lines, "path (2 states):", 3)[1:] == [
        ["0", "0", "yes", "10.5", "-3.25"],
        ["1", "-0.75", "NO", "unstable", "-"],
    ]
    assert below(lines, "critical points:", 1) == [["limit", "at", "load", "factor", "-0.787512345"]]
    assert lines_of(mode=10, path=[state], critical_points=[])[-1] == "critical points: none"


def test_motions():
    energy = {"kinetic": [0.0, 2.0], "elastic": [-1.5, 1.0], "potential": [-1.0, -7.5]}
    places = {"1": [[0.0, 0.0], [0.0, 0.0]], "2": [[0.1, 0.0], [-0.25, 0.5]]}
    steps = [{"time": 0.0, "frequencies_hz": [10.5]}, {"time": 0.5, "frequencies_hz": [None, 9.25]}]
    lines = lines_of(mode=4, time=[0.0, 0.5], energy=energy, trajectory=places, steps=steps)
    assert lines[-6:] == [
        "motion from 0 to 0.5 s, 2 output times; at the end:",
        "  node 1       0  0",
        "  node 2       -0.25  0.5",
        "energy [J] at start and end: -2.5, -4.5",
        "frequencies [Hz] at 0 s: 10.5",
        "frequencies [Hz] at 0.5 s: -  9.25",
    ]
