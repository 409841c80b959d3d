"""Days of a designer: each job is done as in a notebook, by names alone, and checked against another source.

Further ones are notebooks: an element of one's own (09), a bistable beam (19), a cross pivot with stress and
buckling (20).
"""

import itertools
import re
from typing import Any

import control
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np
import pytest
from cases.commands import command
from cases.tolerances import approx
from scipy.optimize import brentq

import flexmb as fm
from flexmb import planar
from flexmb.mechanisms import mechanism_path

MICRO = 1e-6


def folded_flexure(width):
    """A comb drive's suspension of silicon: eight beams, two floating trusses, and a shuttle that both carry."""
    silicon = fm.Material(E=169e9, G=169e9 / 2.44, rho=2330.0)
    section = fm.Rectangle(width=25 * MICRO, thickness=width, material=silicon)
    b = fm.Builder()
    inner, outer, length = 150 * MICRO, 300 * MICRO, 200 * MICRO
    for side, place in {"left": -1, "right": 1}.items():
        b.node(f"{side} anchor", (place * inner, 0))
        b.node(f"{side} shuttle", (place * outer, 0))
        b.fix(f"{side} anchor")
    b.add(planar.rigid_body, "left shuttle", "right shuttle")
    for end, height in {"upper": length, "lower": -length}.items():
        at = {"a": -outer, "b": -inner, "c": inner, "d": outer}
        for name, x in at.items():
            b.node(f"{end} {name}", (x, height))
            b.mass(f"{end} {name}", 1e-13)
        for one, other in ("ab", "bc", "cd"):
            b.add(planar.rigid_body, f"{end} {one}", f"{end} {other}")
        joined = {"a": "left shuttle", "b": "left anchor", "c": "right anchor", "d": "right shuttle"}
        for name, foot in joined.items():
            b.add(planar.beam, foot, f"{end} {name}", section=section)
    b.mass("left shuttle", 2e-9)
    b.mass("right shuttle", 2e-9)
    b.force("left shuttle", (1e-6, 0))
    return b.build()


def test_folded_flexure_in_micrometres():
    width = 2 * MICRO
    model = folded_flexure(width)
    state = fm.equilibrium(model)
    moved = state.position("left shuttle", "x") + 300 * MICRO
    # Eight beams, two pairs in a row at each end: 24 EI/L^3, less what stretching beams let the trusses turn.
    length, inertia = 200 * MICRO, 25 * MICRO * width**3 / 12
    stiffness = 24 * 169e9 * inertia / length**3
    assert float(moved) == approx(1e-6 / stiffness, rel=3e-3)
    assert float(state.force_needed("left shuttle", "x")) == approx(1e-6, rel=1e-9)
    feet = state.reaction("left anchor", "x") + state.reaction("right anchor", "x")
    assert float(feet) == approx(-1e-6, rel=1e-9)
    # Rayleigh's quotient: trusses go half as far, and beams count 12/35; its error is of second order in their mass.
    beams = 8 * 2330 * width * 25 * MICRO * length
    mass = 4e-9 + 8e-13 / 4 + 12 / 35 * beams
    expected = np.sqrt(1e-6 / float(moved) / mass) / 2 / np.pi
    assert float(fm.frequencies(model, count=1)[0]) == approx(expected, rel=2e-4)


@pytest.mark.slow
def test_four_bar_of_flexure_hinges_with_its_reactions_over_time():
    steel = fm.Material(E=210e9, G=80e9, rho=0.0)
    hinge = fm.Rectangle(width=0.01, thickness=0.2e-3, material=steel)
    b = fm.Builder()
    places = {"foot": (0, 0), "foot end": (0, 0.005), "crank end": (0, 0.055), "coupler": (0, 0.06)}
    places |= {"arm": (0.06, 0.06), "arm end": (0.06, 0.055), "rocker end": (0.06, 0.005), "rocker": (0.06, 0)}
    for name, place in places.items():
        b.node(name, place)
    names = list(places)
    for number, pair in enumerate(itertools.pairwise(names)):
        # A hinge, a bar, a hinge, the coupler, and so on; hinges bend and do not stretch.
        bends = {"section": hinge, "released": (2, 3)} if number % 2 == 0 else {}
        b.add(planar.beam if bends else planar.rigid_body, *pair, **bends)
    b.fix("foot")
    b.fix("rocker")
    masses = {"foot end": 0.02, "crank end": 0.02, "coupler": 0.2, "arm": 0.3, "arm end": 0.02, "rocker end": 0.02}
    for name, mass in masses.items():
        b.mass(name, mass)
    model = b.build()
    times = np.linspace(0.0, 0.05, 401)
    motion = fm.simulate(model, times, loads={"coupler.x": lambda t: 5.0 * jnp.sin(40 * t)}, rtol=1e-10)
    # Newton's law of the whole, with accelerations by second differences of positions.
    h = times[1]
    supports = motion.reaction("foot")[:, :2] + motion.reaction("rocker")[:, :2]
    inertia = np.zeros((len(times) - 2, 2))
    for node, mass in masses.items():
        x = np.asarray(motion.position(node))
        inertia += mass * (x[2:] - 2 * x[1:-1] + x[:-2]) / h**2
    drive = np.stack([5.0 * np.sin(40 * times), 0 * times], axis=1)
    # A difference of second order: h^2/12 times the fourth derivative.
    size = np.max(np.abs(inertia))
    np.testing.assert_allclose(np.asarray(supports)[1:-1], (inertia - drive[1:-1]), atol=1e-3 * size)
    np.testing.assert_allclose(motion.force_needed("coupler", "x"), drive[:, 0], atol=1e-9)
    assert np.max(np.abs(motion.position("coupler", "x"))) > 1e-3


def constant_force(height, spring):
    """Two bars that snap through between feet 20 m apart, and a spring along the stroke of their apex."""
    b = fm.Builder()
    for name, place in {"left": (-10, 0), "right": (10, 0), "apex": (0, height), "top": (0, height + 5)}.items():
        b.node(name, place)
    for foot in ("left", "right"):
        b.add(planar.truss, foot, "apex", section=fm.Rigidity(EA=1e4, mass=1.0))
        b.fix(foot)
    b.add(planar.truss, "top", "apex", section=fm.Rigidity(EA=5 * spring, mass=1.0))
    b.fix("top")
    b.fix("apex", "x")
    b.prescribe("apex", "y", -1.0, increment=True)
    return b.build()


def test_constant_force_over_a_stroke():
    strokes = np.linspace(0.8, 1.2, 9)
    found = fm.tune(
        constant_force,
        {"force": lambda model: -fm.equilibria(model, increment=strokes).force_needed("apex", "y")},
        {"height": 0.8, "spring": 8.0},
        {"height": (0.5, 1.5), "spring": (1.0, 20.0)},
        targets={"force": fm.design.Curve(strokes, np.full(9, 10.0))},
    )
    height, spring = found.dimensions["height"], found.dimensions["spring"]

    def force(stroke):
        """Closed form: the bars by their strain, the spring by its own."""
        y = height - stroke
        return spring * stroke + 2e4 * (1 / np.hypot(10, y) - 1 / np.hypot(10, height)) * y

    np.testing.assert_allclose(found.answers["force"], force(strokes), rtol=1e-8)
    # The bars' cubic term, EA y^3/a^3, stays: 1e4 0.2^3/1e3 = 0.08 N at the ends, or less.
    assert np.ptp(force(np.linspace(0.8, 1.2, 101))) < 2 * 0.08


def stage(held):
    """An xy stage: a table on two leaf springs on a frame on three, which stretch but for those that are named."""
    steel = fm.Material(E=210e9, G=80e9, rho=0.0)
    section = fm.Rectangle(width=0.02, thickness=0.3e-3, material=steel)
    b = fm.Builder()
    for name, x in {"A": 0.0, "B": 0.05, "C": 0.1}.items():
        b.node(f"foot {name}", (x, 0))
        b.node(f"frame {name}", (x, 0.08))
        b.fix(f"foot {name}")
        stretches = () if f"leaf {name}" in held else (1,)
        b.add(
            planar.beam,
            f"foot {name}",
            f"frame {name}",
            name=f"leaf {name}",
            section=section,
            released=(*stretches, 2, 3),
        )
    b.node("frame D", (0.1, 0.18))
    for pair in itertools.pairwise("ABCD"):
        b.add(planar.rigid_body, *(f"frame {name}" for name in pair))
    for name, foot, y in (("low", "C", 0.08), ("high", "D", 0.18)):
        b.node(f"table {name}", (0.18, y))
        b.add(planar.beam, f"frame {foot}", f"table {name}", section=section, released=(2, 3))
        b.mass(f"table {name}", 0.15)
    b.add(planar.rigid_body, "table low", "table high")
    b.mass("frame A", 0.2)
    b.dof("frame A", "x")
    b.dof("table low", "y")
    for axis in "xy":
        b.input("table low", axis)
        b.output("table low", axis)
    return b.build()


def test_stage_made_exactly_constrained_its_loop_and_its_bode_plot():
    held = ["leaf A", "leaf B", "leaf C"]
    with pytest.raises(fm.MechanismError, match="release deformation 1 of element") as refused:
        stage(held)
    advised = re.search(r"release deformation 1 of element '(.*?)'", str(refused.value)).group(1)
    held.remove(advised)
    model = stage(held)
    assert (fm.mobility(model).overconstraints, fm.mobility(model).underconstraints) == (0, 0)
    # 12 EI/L^3 of each leaf spring; the frame carries the table.
    leaf = 210e9 * 0.02 * 0.3e-3**3 / 0.08**3
    stiffness, mass = np.array([3, 2]) * leaf, np.array([0.5, 0.3])
    own = np.sqrt(stiffness / mass)
    # The leaf spring that stretches is the middle one, and all else follows the two motions.
    np.testing.assert_allclose(fm.frequencies(model)[:2], own / 2 / np.pi, rtol=1e-5)
    plant = fm.to_statespace(fm.damped(model, ratio=0.01), modes=2)
    assert plant.nstates == 4
    across = fm.plot.bode(plant)
    plt.close(across)
    # Proportional and derivative action on both axes, by a filter that is a hundred times as quick.
    gain, rate = 2000.0, 20.0
    lag = rate / gain / 100
    axis = control.ss(control.tf([rate, gain], [lag, 1]))
    loop: Any = control.feedback(plant, control.append(axis, axis))
    poles = loop.poles()
    for k, m, w in zip(stiffness, mass, own, strict=True):
        expected = np.roots(np.polymul([m, 2 * 0.01 * w * m, k], [lag, 1]) + np.array([0, 0, rate, gain]))
        for pole in expected:
            assert np.min(np.abs(poles - pole)) < 1e-4 * abs(pole)
    assert np.all(poles.real < 0)


def cantilever(E, t):
    material = fm.Material(E=E, G=E / 2.6, rho=7850.0)
    b = fm.Builder()
    b.node("root", (0, 0))
    b.node("tip", (0.1, 0))
    section = fm.Rectangle(width=0.02, thickness=t, material=material)
    b.add(planar.spectral_beam, "root", "tip", name="strip", order=8, section=section)
    b.fix("root")
    b.mass("tip", 0.02)
    return b.build()


def measured(E, t):
    """First two frequencies of a uniform cantilever with a mass at its tip, from its characteristic equation [Hz]."""
    line, mass, length = 7850 * 0.02 * t, 0.02, 0.1
    share = mass / (line * length)

    def equation(z):
        return 1 + np.cos(z) * np.cosh(z) - share * z * (np.sin(z) * np.cosh(z) - np.cos(z) * np.sinh(z))

    roots = [brentq(equation, *ends, xtol=1e-14) for ends in ((0.1, 2.0), (3.2, 4.7))]
    return np.array(roots) ** 2 * np.sqrt(E * 0.02 * t**3 / 12 / line) / length**2 / 2 / np.pi


def test_youngs_modulus_and_thickness_identified_from_frequencies():
    seen = measured(195e9, 0.52e-3)
    found = fm.tune(
        cantilever,
        {"frequencies": lambda model: fm.frequencies(model, count=2)},
        {"E": 210e9, "t": 0.5e-3},
        {"E": (150e9, 250e9), "t": (0.3e-3, 0.8e-3)},
        targets={"frequencies": seen},
    )
    # The beam stretches and turns as it vibrates, which the equation leaves out: (t/L)^2 of the frequencies, which the
    # second one's lead on the first multiplies.
    assert found.dimensions["t"] == approx(0.52e-3, rel=2e-3)
    assert found.dimensions["E"] == approx(195e9, rel=5e-3)


def guide(t, length):
    steel = fm.Material(E=210e9, G=80e9, rho=7850.0)
    leaf = fm.Rectangle(width=0.018, thickness=t, material=steel)
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, length), "C": (0.1, length), "D": (0.1, 0)}.items():
        b.node(name, place)
    b.add(planar.beam, "A", "B", name="left", section=leaf, released=(2, 3))
    b.add(planar.beam, "D", "C", name="right", section=leaf, released=(2, 3))
    b.add(planar.rigid_body, "B", "C", name="stage")
    b.fix("A")
    b.fix("D")
    b.mass("B", 0.2)
    b.force("C", (0.1, 0))
    b.dof("B", "x")
    return b.build()


@pytest.mark.slow
def test_twenty_thousand_designs_stopped_resumed_and_their_front(tmp_path):
    answers = {
        "drive": lambda model: 0.1 / fm.equilibrium(model).position("B", "x"),
        "stress": lambda model: fm.stress(model).maximum,
    }
    designs = fm.design.latin_hypercube(20_000, {"t": (0.2e-3, 1e-3), "length": (0.05, 0.2)}, seed=1)
    options = {"checkpoint": tmp_path / "designs", "chunk": 5000}

    def stop(done, _):
        if done >= 10_000:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fm.sweep(guide, answers, designs, progress=stop, **options)
    begun = []
    found = fm.sweep(guide, answers, designs, progress=lambda done, _: begun.append(done), **options)
    assert begun[0] > 10_000
    t, length = np.asarray(designs["t"]), np.asarray(designs["length"])
    # Closed form at small strokes: 24 EI/L^3; and each leaf spring, under half the load F, carries F L/4 at its ends.
    small = t > 0.5e-3
    np.testing.assert_allclose(
        np.asarray(found["drive"])[small], (2 * 210e9 * 0.018 * t**3 / length**3)[small], rtol=2e-3
    )
    of_ends = 6 * (0.1 * length / 4) / (0.018 * t**2)
    np.testing.assert_allclose(np.asarray(found["stress"])[small], of_ends[small], rtol=1e-2)
    front = found.pareto(minimize=["drive", "stress"])
    assert len(front) > 5
    drive, largest = front["drive"], front["stress"]
    assert np.all(np.diff(drive) > 0)
    assert np.all(np.diff(largest) < 0)
    every = np.stack([found["drive"], found["stress"]], axis=1)
    for one in np.stack([drive, largest], axis=1)[::10]:
        assert not np.any(np.all(every <= one, axis=1) & np.any(every < one, axis=1))


GUIDE = mechanism_path("pf2db").read_text()
# Files with a fault, by name: what stands in the place of what.
FAULTY = {
    "unknown.dat": ("PLBEAM 1", "PLBEEM 1"),
    "short.dat": ("PLBEAM 1 1 2 3 4", "PLBEAM 1 1 2 3"),
    "letters.dat": ("X 3 0 0.1", "X 3 0 O.1"),
    "braces.dat": ("X 3 0 0.1", "X 3 0 {l}"),
    "unfinished.dat": ("END\nHALT", ""),
    "binary.dat": ("%", "\0"),
    "empty.dat": (GUIDE, ""),
    "guide.dat": ("", ""),
}
# What is called, how it ends, and what is said.
MISUSED = [
    ("frobnicate", 2, "No such command 'frobnicate'"),
    ("run", 2, "Missing argument 'MODEL.dat'"),
    ("check", 2, "Missing argument 'MODEL.dat'"),
    ("run guide.dat", 2, "give one of --mode and --analysis"),
    ("run nowhere.dat --mode 7", 2, "cannot read 'nowhere.dat'"),
    ("run . --mode 7", 2, "cannot read '.'"),
    ("run guide.dat guide.dat --mode 7", 2, "unexpected extra argument"),
    ("run guide.dat --modes 7", 2, "No such option: --modes"),
    ("run guide.dat --mode 11", 2, "there is no mode '11'"),
    ("run guide.dat --mode x", 2, "there is no mode 'x'"),
    ("run guide.dat --analysis frequency", 2, "7 (frequencies)"),
    ("run guide.dat --mode 7 --mode 8", 2, "--mode is given twice"),
    ("run guide.dat --mode 7 --json", 2, "'--json' requires an argument"),
    ("run guide.dat --mode 7 --json no/such/out.json", 2, "the folder of 'no/such/out.json' does not exist"),
    ("run guide.dat --mode 7 --plot m.xyz", 2, "--plot writes .png, .svg, .pdf or .html"),
    ("run guide.dat --mode 7 --save guide.dat", 2, "--save writes .npz or .mat"),
    ("run guide.dat --mode 7 --set t=1", 2, "guide.dat has no {t}"),
    ("run guide.dat --mode 7 --release maybe", 2, "--release takes auto or none"),
    ("run braces.dat --mode 7", 2, "braces.dat:8: X: node 3: '{l}'"),
    ("run braces.dat --mode 7 --set l=abc", 2, "must be a number, but is 'abc'"),
    ("run braces.dat --mode 7 --set l", 2, "--set takes NAME=NUMBER"),
    ("run braces.dat --mode 7 --set l=1 --set l=2", 2, "--set gives 'l' twice"),
    ("run unknown.dat --mode 7", 2, "unknown.dat:4: PLBEEM: unknown keyword; did you mean PLBEAM?"),
    ("run short.dat --mode 7", 2, "short.dat:4: PLBEAM: element 1: too few parameters"),
    ("run letters.dat --mode 7", 2, "letters.dat:8: X: node 3: y must be a number, but is 'O.1'"),
    ("run empty.dat --mode 7", 2, "empty.dat:1: file is empty"),
    ("run unfinished.dat --mode 7", 2, "belongs in the dynamics block"),
    ("run binary.dat --mode 7", 2, "it is no text"),
    ("demo nothing", 2, "no mechanism 'nothing'. Shipped: elevator"),
    ("demo pf2d --to no/such", 2, "the folder 'no/such' does not exist"),
    ("sweep nowhere.toml", 2, "'nowhere.toml'"),
    ("tune guide.dat", 2, "guide.dat"),
]


@pytest.mark.slow("tune guide.dat")
@pytest.mark.parametrize(("words", "status", "said"), MISUSED, ids=[words for words, *_ in MISUSED])
def test_a_command_that_is_misused_says_so_and_writes_nothing(words, status, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, (old, new) in FAULTY.items():
        (tmp_path / name).write_text(GUIDE.replace(old, new, 1) if old else GUIDE)
    result = command(*words.split())
    assert (result.exit_code, result.stdout) == (status, "")
    assert said in result.stderr
    assert "Traceback" not in result.stderr
    assert {path.name for path in tmp_path.iterdir()} == set(FAULTY)
