"""Questions with answers known from elsewhere, which the quick table and paired runs of two versions ask.

``CASES`` are rows of the quick table (quick.py). ``KERNELS`` are what first_impression.py, designs.py and motion.py
time besides; against.py asks them all of two versions of the package.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

# Of the spatial guide by two spectral beams of order 8 a leaf spring [m], to which SPACAR beams converge
# (large_deflection.py).
STROKE = 0.009954041778976519
# First frequencies of the spatial guide by eight beams a leaf spring [Hz], and by 32 (designs.py).
SPATIAL = (10.64461093830858, 192.43952671102812)
FINE = 10.799070236461514
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


def chain_motion() -> Case:
    """The same of 256 beams, solved in the order of the chain, and of as many of Exudyn's cables."""
    import numpy as np
    import swing
    from chains import of_exudyn, tip
    from peer_exudyn import installed

    model, exact = swing.pendulum(256), np.array(SOFT)
    peer = of_exudyn(256, 1000) if installed() else None
    return Case(lambda: tip(model, 256, 1e-3), lambda found: float(np.linalg.norm(found - exact)), 90, peer)


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
    chain_motion,
    spectral_motion,
)


def _first_impression(of: Callable[[Any], Any], error: Callable[[Any], float]) -> Case:
    """A kernel of first_impression.py: ``of`` makes it of what ``first_impression.kernels`` gives."""
    import warnings

    import first_impression

    import flexmb as fm

    warnings.simplefilter("ignore", fm.BeamTheoryWarning)
    return Case(of(first_impression.kernels()), error, 18)


def first_impression_frequencies() -> Case:
    """Frequencies of the spatial guide, compiled for a cache."""
    import numpy as np

    import flexmb as fm
    from flexmb.compilation.compile import compile_thoroughly

    compile_thoroughly(True)
    return _first_impression(lambda own: lambda: np.asarray(fm.frequencies(own[0])[:2]), _off(SPATIAL))


def first_impression_inside() -> Case:
    """The first of them inside ``jax.jit``."""
    import numpy as np

    return _first_impression(lambda own: lambda: np.asarray(own[1](own[0].parameters)), _off(SPATIAL[:1]))


def first_impression_gradient() -> Case:
    """The same with its gradient by every number of the model; the error is that of the frequency."""
    import jax

    def of(own):
        return lambda: float(jax.block_until_ready(own[2](own[0].parameters))[0])

    return _first_impression(of, _off(SPATIAL[:1]))


def first_impression_thousand() -> Case:
    """First frequencies of a thousand spatial guides, beside the one above by how sway scales with their dimensions."""
    import first_impression
    import numpy as np

    thickness, width = np.asarray(first_impression.kernels()[4]).T

    def sway(thickness, width):
        return np.sqrt(width * thickness**3 / (0.206 + 26 / 35 * 7850 * 0.2 * width * thickness))

    off = _off(SPATIAL[0] * sway(thickness, width) / sway(5e-4, 0.018))
    return _first_impression(lambda own: lambda: np.asarray(own[3](own[4])), off)


def _designs(which: int, beams: int) -> Case:
    """A kernel of designs.py: frequency, with its gradient, or a thousand; the error is that of the first frequency.

    Args:
        which: Place of the kernel.
        beams: A leaf spring.
    """
    import designs
    import jax
    import jax.numpy as jnp
    import numpy as np

    at, kernel = jnp.array(list(designs.POINT.values())), designs.kernels(beams)[which]
    if which == 2:
        return Case(lambda: np.asarray(kernel()[1]), lambda failed: float(np.any(failed)), 18)
    off = _off([FINE])
    return Case(lambda: jax.block_until_ready(kernel(at)), lambda found: off(found[0] if which else found), 18)


def designs_one() -> Case:
    """First frequency of a design of two beams a leaf spring."""
    return _designs(0, 2)


def designs_gradient() -> Case:
    """The same with its gradient by six dimensions."""
    return _designs(1, 2)


def designs_thousand() -> Case:
    """A thousand of them on all cores; the error says whether one failed."""
    return _designs(2, 2)


def designs_fine() -> Case:
    """One with eight beams a leaf spring, and its gradient."""
    return _designs(1, 8)


def _motion(plane: bool, fixed: bool = False) -> Case:
    """A second of motion of the guide of motion.py at a tolerance of 1e-4, beside its tight solution.

    Args:
        plane: In the plane, otherwise in space.
        fixed: Whether elongations are FIXED.
    """
    import motion
    import numpy as np

    import flexmb as fm

    model = motion.guide(plane, fixed)
    times, bent, exact = motion.times(), motion.at_rest(model), motion.tight(plane, fixed)

    def ask():
        return np.asarray(fm.simulate(model, times, initial=bent, rtol=1e-4).at("right2"))[:, 0]

    return Case(ask, lambda found: float(np.max(np.abs(found - exact))) / motion.STROKE, model.topology.n_x)


def motion_plane() -> Case:
    """The guide in the plane, all deformations free."""
    return _motion(True)


def motion_fixed() -> Case:
    """The same with its elongations FIXED."""
    return _motion(True, True)


def motion_space() -> Case:
    """The guide in space, all deformations free."""
    return _motion(False)


def motion_derivative() -> Case:
    """The guide in the plane with the derivative of its motion by the thickness; the error is that of the motion."""
    import jax
    import motion
    import numpy as np

    _, with_slope = motion.by_thickness(True, motion.times(), 1e-4)
    exact = motion.tight(True)

    def error(found):
        return float(np.max(np.abs(np.asarray(found[0]) - exact))) / motion.STROKE

    return Case(lambda: jax.block_until_ready(with_slope(1.0)), error, 38)


KERNELS: tuple[Callable[[], Case], ...] = (
    first_impression_frequencies,
    first_impression_inside,
    first_impression_gradient,
    first_impression_thousand,
    designs_one,
    designs_gradient,
    designs_thousand,
    designs_fine,
    motion_plane,
    motion_fixed,
    motion_space,
    motion_derivative,
)
