"""What is compiled depends on sizes alone: another support, connection or dimension reuses the code."""

import collections

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar
from flexmb.compilation.compile import _known, jit


def frame(thickness: float, *, support: str, braces: tuple[str, str]) -> fm.Model:
    """Two uprights, a rigid bar and a brace, held at one of two feet and guided at the other."""
    section = fm.Rectangle(0.018, thickness, fm.Material(210e9, 80e9, 7850.0))
    b = fm.Builder()
    for name, position in {"A": (0, 0), "B": (0, 0.1), "C": (0.1, 0.1), "D": (0.1, 0)}.items():
        b.node(name, position)
    b.add(planar.beam, "A", "B", section=section)
    b.add(planar.beam, "C", "D", section=section)
    b.add(planar.beam, "B", "C")
    b.add(planar.truss, *braces, section=fm.Rigidity(EA=50.0))
    b.fix("A" if support == "A" else "D")
    b.fix("D" if support == "A" else "A", "y", "phi")
    b.mass("B", 0.1)
    b.mass("C", 0.1)
    for i in (1, 2, 3):
        b.dof("beam 1", i)
    b.dof("beam 2", 2)
    return b.build()


@pytest.mark.slow
def test_same_sizes_do_not_compile_again(compilations):
    first = fm.frequencies(frame(5e-4, support="A", braces=("A", "C")))
    assert compilations  # the counter counts
    compilations.clear()
    others = [
        fm.frequencies(frame(6e-4, support="A", braces=("A", "C"))),
        fm.frequencies(frame(5e-4, support="D", braces=("A", "C"))),
        fm.frequencies(frame(5e-4, support="A", braces=("D", "B"))),
    ]
    assert not compilations
    assert all(abs(float(f[0] / first[0]) - 1) > 1e-3 for f in others)


@pytest.mark.slow
def test_another_size_compiles(compilations):
    frame_of_beams = frame(5e-4, support="A", braces=("A", "C"))
    fm.frequencies(frame_of_beams)
    compilations.clear()
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0, 0.1))
    b.add(planar.beam, "A", "B", section=fm.Rectangle(0.01, 3e-4, fm.Material(210e9, 80e9, 7850.0)))
    b.fix("A")
    fm.frequencies(b.build())
    assert compilations


def guide(mass: str = "C") -> fm.Model:
    """A frame of two leaf springs under load, with a signal."""
    section = fm.Rectangle(0.018, 5e-4, fm.Material(210e9, 80e9, 7850.0))
    b = fm.Builder()
    for name, position in {"A": (0, 0), "B": (0, 0.1), mass: (0.1, 0.1), "D": (0.1, 0)}.items():
        b.node(name, position)
    b.add(planar.beam, "A", "B", name="left", section=section)
    b.add(planar.beam, "D", mass, name="right", section=section)
    b.add(planar.beam, "B", mass, name="bar")
    b.fix("A")
    b.fix("D")
    b.mass("B", 0.1)
    b.mass(mass, 0.1)
    b.force("B", (0.1, -1.0))
    b.input(mass, "x")
    b.output("B", "x")
    return b.build()


TIMES = np.linspace(0.0, 0.01, 3)


def moved(model):
    """All that is asked of a motion."""
    motion = fm.simulate(model, TIMES)
    return motion.observe(), fm.motion.linearize_motion(motion)


def controlled(model):
    return fm.simulate(model, TIMES, control=lambda t, y: -y).observe()


ANALYSES = {
    "build": lambda model: guide(),
    "mobility": fm.mobility,
    "equilibrium": fm.equilibrium,
    "linearize": fm.linearize,
    "second_transfer": lambda model: fm.linear.second_transfer(fm.linearize(model)),
    "frequencies": fm.frequencies,
    "lowest": lambda model: fm.frequencies(model, count=1),
    "modes": fm.modes,
    "poles": fm.poles,
    "buckling": fm.buckling,
    "stress": fm.stress,
    "section_resultants": fm.linear.section_resultants,
    "compliance": lambda model: fm.compliance(model, "B"),
    "to_statespace": fm.to_statespace,
    "path": fm.path,
    "motion": moved,
    "controlled": controlled,
}


@pytest.mark.slow
@pytest.mark.parametrize("analysis", ANALYSES)
def test_each_kernel_is_compiled_once(analysis, compilations):
    """On a fresh model each program of the package is compiled once, and asking again compiles nothing."""
    model = guide()
    jax.clear_caches()
    compilations.clear()
    ANALYSES[analysis](model)
    # Those of jax's own, one operation each, repeat with shapes.
    own = collections.Counter(name for name in compilations if "flexmb" in name)
    assert own
    assert [name for name, count in own.items() if count > 1] == []
    compilations.clear()
    ANALYSES[analysis](model)
    assert compilations == []


@jit
def doubled(number):
    return 2 * number


def test_however_a_number_is_given_the_kernel_is_the_same(compilations):
    for number in (1.5, np.float64(0.3), jnp.asarray(0.3), jnp.asarray(0.3, float), doubled(0.2)):
        assert float(doubled(number)) == 2 * float(number)
    assert len([name for name in compilations if "doubled" in name]) == 1


@pytest.mark.slow
def test_names_compile_nothing(compilations):
    controlled(guide())
    other = guide("another name")
    compilations.clear()
    controlled(other)
    assert compilations == []


@pytest.mark.slow
def test_degrees_of_freedom_do_not_compile_the_reference_jacobian_again(compilations):
    frame(5e-4, support="A", braces=("A", "C"))
    compilations.clear()
    b = fm.Builder()
    section = fm.Rectangle(0.018, 5e-4, fm.Material(210e9, 80e9, 7850.0))
    for i in range(4):
        b.node(str(i), (0, 0.1 * i))
    for i in range(3):
        b.add(planar.beam, str(i), str(i + 1), section=section)
    b.add(planar.truss, "0", "3", section=fm.Rigidity(EA=50.0), released=(1,))
    b.fix("0")
    b.force("3", (1.0, 0.0))
    # As many beams and trusses as the frame has, in another mechanism.
    b.build()
    assert compilations == []


def test_what_is_traced_is_known_though_it_comes_first():
    """The first call of a process may stand in another program: its numbers are no arrays."""
    _known.cache_clear()
    doubled = jit(lambda x: 2 * x)
    assert float(jax.jit(lambda x: jit(lambda y: doubled(y))(x))(jnp.array(3.0))) == 6.0
