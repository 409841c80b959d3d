"""Arguments of analyses: what is no model, no number or no function of time is refused by name, nothing is clamped."""

import re
from pathlib import Path
from typing import Literal

import control
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.arguments import Count, Flag, Positive, checked
from flexmb.control.frequency_response import places_of_names
from flexmb.control.truncation import ascending_modes


def cart(**options):
    """A mass on a spring and a second one on it, both along x; forces on both, places of both."""
    b = fm.Builder()
    for i in range(3):
        b.node(f"{i}", (0.1 * i, 0))
    for i in range(2):
        b.add(planar.truss, f"{i}", f"{i + 1}", name=f"spring {i}", section=fm.Rigidity(EA=10.0))
        b.fix(f"{i + 1}", "y")
        b.mass(f"{i + 1}", 1.0)
        b.input(f"{i + 1}", "x")
        b.output(f"{i + 1}", "x")
    b.fix("0")
    if options:
        b.force("2", (1.0, 0), **options)
    return b


MODEL = cart().build()
INPUT = MODEL.labels.inputs[0].name
SPACAR = "PLTRUSS 1 1 2\nX 2 1 0\nFIX 1\nFIX 2 2\nRLSE 1 1\nDYNX 2 1\nEND\nHALT\nXM 2 1\nESTIFF 1 1\nEND\nEND\n"

ASKS = {
    "mobility": fm.mobility,
    "equilibrium": fm.equilibrium,
    "linearize": fm.linearize,
    "frequencies": fm.frequencies,
    "modes": fm.modes,
    "poles": fm.poles,
    "buckling": fm.buckling,
    "buckling_loads": fm.buckling_loads,
    "path": fm.path,
    "limit_load": fm.limit_load,
    "configuration": fm.configuration,
    "simulate": lambda m: fm.simulate(m, [0, 1.0]),
    "steady_motion": lambda m: fm.motion.steady_motion(m, {"1.x": lambda t: t}),
    "stress": fm.stress,
    "section_resultants": fm.linear.section_resultants,
    "compliance": lambda m: fm.compliance(m, "1"),
    "directional_compliance": fm.linear.directional_compliance,
    "frequency_like": lambda m: fm.linear.frequency_like(m, np.ones(2)),
    "state_matrices": fm.control.state_matrices,
    "to_statespace": fm.to_statespace,
    "damped": lambda m: fm.damped(m, ratio=0.01),
    "to_nonlinear_system": fm.control.to_nonlinear_system,
    "mass": fm.mass,
    "stiffness": lambda m: fm.stiffness(m, "1", "x"),
}


@pytest.mark.parametrize("name", ASKS)
def test_what_is_no_model_is_refused_by_what_to_do(name):
    given = {
        "Builder": (cart(), r"call its build\(\) first"),
        "SpacarModel": (fm.read_spacar(SPACAR), r"builder\.build\(\)"),
        "str": ("guide.dat", r"fm\.read_spacar\(.*\)\.builder\.build\(\)"),
        "PosixPath": (Path("guide.dat"), r"fm\.read_spacar"),
        "NoneType": (None, r"return b\.build\(\)"),
        "function": (cart, "call it"),
        "type": (fm.Model, r"build\(\)"),
        "Topology": (MODEL.topology, r"build\(\)"),
    }
    for kind, (what, hint) in given.items():
        with pytest.raises(TypeError, match=rf"fm\.{name} takes a Model.* not a {kind}.*{hint}"):
            ASKS[name](what)


@pytest.mark.slow
def test_results_are_not_taken_for_models():
    equilibrium = fm.equilibrium(MODEL)
    for name in ("frequencies", "modes", "compliance", "to_statespace"):
        with pytest.raises(TypeError, match=r"not an Equilibrium.*fm\.linearize"):
            ASKS[name](equilibrium)
    path = fm.path(cart(increment=True).build(), step=1.0)
    with pytest.raises(TypeError, match=r"not a Path.*at=path, step=-1"):
        fm.frequencies(path)
    with pytest.raises(
        TypeError,
        match=r"fm\.linearize takes a Model.*not a Linearization: give its \.model.*fm\.sections\.damping_from_ratio",
    ):
        fm.linearize(path.linearization())
    motion = fm.simulate(MODEL, [0, 0.1, 0.2])
    with pytest.raises(TypeError, match=r"not a Motion.*at=motion, step=-1"):
        fm.modes(motion)
    along = fm.motion.linearize_motion(motion)
    for name in ("poles", "compliance", "directional_compliance", "modes", "frequencies"):
        with pytest.raises(ValueError, match=r"along a motion, at 3 times.*at_time\(0\)"):
            ASKS[name](along)
    for call in (
        lambda: fm.motion.linearize_motion(MODEL),
        lambda: fm.linear.second_transfer(MODEL),
        lambda: fm.linear.mode_assurance(1, 2),
    ):
        with pytest.raises(TypeError, match=r"needs (a Motion|a Linearization|Modes)"):
            call()


# -- incremental loads --------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        *("equilibrium", "linearize", "frequencies", "modes", "poles", "stress", "section_resultants", "compliance"),
        *("directional_compliance", "frequency_like", "state_matrices", "to_statespace", "stiffness", "simulate"),
        *("to_nonlinear_system", "damped"),
    ],
)
def test_an_answer_without_the_incremental_loads_says_so(name):
    b = cart(increment=True)
    if name in ("stress", "section_resultants"):
        b.members["spring 0"].properties["section"] = fm.Circle(0.01, fm.Material(1e5, 1e5, 1.0))
        b.members["spring 1"].properties["section"] = fm.Circle(0.01, fm.Material(1e5, 1e5, 1.0))
    model = b.build()
    with pytest.warns(fm.FlexmbWarning, match=rf"fm\.{name}.* incremental loads") as told:
        ASKS[name](model)
    # Once, and at the line that asks.
    assert len(told) == 1
    assert Path(told[0].filename) == Path(__file__)
    assert "increment=" in str(told[0].message)


@pytest.mark.slow
def test_an_answer_that_is_meant_without_them_says_nothing():
    model = cart(increment=True).build()
    found = fm.equilibrium(model, increment=0.0)
    assert found.at("2")[0] == approx(0.2)
    # A force of 1 N stretches two springs of 100 N/m.
    assert fm.equilibrium(model, increment=1.0).at("2")[0] == approx(0.22)
    lin = fm.linearize(model, increment=0.0)
    fm.frequencies(lin), fm.modes(lin), fm.compliance(lin, "1")
    # These are about the incremental loads.
    fm.buckling_loads(model, throw=False), fm.path(model, step=1.0)
    # In a transformation one knows.
    fm.jit(jax.vmap(lambda scale: fm.frequencies(scaled(model, scale))[0]))(jnp.ones(2))
    # Without any there is nothing to say.
    fm.frequencies(MODEL)


def scaled(model, scale):
    return jax.tree.map(lambda a: a * scale if jnp.issubdtype(a.dtype, jnp.floating) else a, model)


# -- numbers ------------------------------------------------------------------------------------------------------

TIMES = [0.0, 0.1]
NUMBERS = {
    "rtol below zero": (lambda: fm.simulate(MODEL, TIMES, rtol=-1), "`rtol` must be positive"),
    "rtol zero": (lambda: fm.simulate(MODEL, TIMES, rtol=0.0), "`rtol` must be positive"),
    "rtol none": (lambda: fm.simulate(MODEL, TIMES, rtol=float("nan")), "`rtol` must be .*, but is nan"),
    "rtol a word": (lambda: fm.simulate(MODEL, TIMES, rtol="1e-5"), "`rtol` must be one number, not '1e-5'"),
    "atol below zero": (lambda: fm.simulate(MODEL, TIMES, atol=-1e-9), "`atol` must be at least 0"),
    "atol two": (lambda: fm.simulate(MODEL, TIMES, atol=[1e-9, 1e-9]), "`atol` must be one number"),
    "dt0 zero": (lambda: fm.simulate(MODEL, TIMES, dt0=0), "`dt0` must be positive"),
    "dt0 below zero": (lambda: fm.simulate(MODEL, TIMES, dt0=-0.1), "`dt0` must be positive"),
    "no steps": (lambda: fm.simulate(MODEL, TIMES, max_steps=0), "`max_steps` must be at least 1"),
    "half steps": (lambda: fm.simulate(MODEL, TIMES, max_steps=10.5), "`max_steps` must be a whole number"),
    "times without end": (lambda: fm.simulate(MODEL, [0, np.inf]), "`times` .*finite"),
    "times that are none": (lambda: fm.simulate(MODEL, [0, np.nan, 1]), "`times` .*finite"),
    "times of words": (lambda: fm.simulate(MODEL, ["0", "1"]), "`times` must be numbers"),
    "jumps that are none": (lambda: fm.simulate(MODEL, TIMES, jumps=[np.nan]), "`jumps` .*finite"),
    "a solver's class": (lambda: fm.simulate(MODEL, TIMES, solver=fm.motion.Rodas5P), r"`solver` .*Rodas5P\(\)"),
    "a solver's name": (lambda: fm.simulate(MODEL, TIMES, solver="Rodas5P"), "`solver` must be a solver"),
    "a reference for no one": (lambda: fm.simulate(MODEL, TIMES, reference=lambda t: t), "`reference` .*`control`"),
    "progress a word": (lambda: fm.simulate(MODEL, TIMES, progress="yes"), "`progress` must be True, False or a fun"),
    "load factor": (lambda: fm.equilibrium(MODEL, load_factor=float("nan")), "`load_factor` must be finite"),
    "load factors": (lambda: fm.linearize(MODEL, load_factor=[0, 1]), "`load_factor` must be one number"),
    "increment": (lambda: fm.linearize(MODEL, increment=float("inf")), "`increment` must be finite"),
    "an increment for no one": (lambda: fm.equilibrium(MODEL, increment=0.5), "no incremental loads"),
    "half a frequency": (lambda: fm.frequencies(MODEL, count=1.5), "`count` must be a whole number"),
    "no frequency": (lambda: fm.frequencies(MODEL, count=0), "`count` must be at least 1"),
    "half a point": (lambda: fm.linear.section_resultants(MODEL, points=2.5), "`points` must be a whole number"),
    "one point": (lambda: fm.linear.section_resultants(MODEL, points=1), "`points` must be at least 2"),
    "time of a steady motion": (
        lambda: fm.motion.steady_motion(MODEL, {"1.x": lambda t: t}, time=float("nan")),
        "`time` must be finite",
    ),
    "q that is none": (lambda: fm.configuration(MODEL, q=[np.nan, 0]), "`q` .*not a finite number"),
    "q by name in a trace": (
        lambda: jax.eval_shape(lambda x: fm.configuration(MODEL, q={"1.x": x}).x, 0.0),
        r"`q` must be numbers, not \{'1\.x': ",
    ),
    "q of words": (lambda: fm.configuration(MODEL, q=["a", "b"]), "`q` must be numbers"),
    "step of a path": (lambda: fm.path(MODEL, step=float("nan")), "`step` must be finite"),
    "steps of a path": (lambda: fm.path(MODEL, max_steps=1.5), "`max_steps` must be a whole number"),
    "a complex thickness in a trace": (
        lambda: jax.eval_shape(lambda t: fm.mass(leaf(t)), 1e-3 + 1e-20j),
        "Property 'section' of element 'l' must be real",
    ),
    "a complex place in a trace": (
        lambda: jax.eval_shape(lambda x: fm.Builder().node("A", (x, 0)) and x, 1j),
        "Node 'A' must be real",
    ),
    "a complex mass": (lambda: cart().mass("1", 1 + 0j), "mass on node '1' must be real"),
    "complex masses of many designs": (
        lambda: jax.vmap(lambda m: fm.mass(cart_of(m)))(jnp.array([1j, 2])),
        "mass on node '1' must be real",
    ),
    "a complex load factor": (lambda: fm.equilibrium(MODEL, load_factor=jnp.array(1j)), "`load_factor` must be real"),
    "complex frequencies": (lambda: fm.frequency_response(MODEL, [1j]), "`hertz` must be real"),
    "a complex rotation": (
        lambda: fm.rotations.from_vector(jnp.array([1j, 0, 0])),
        "`vector` must be real",
    ),
    "local a word": (lambda: fm.compliance(MODEL, "1", local="no"), "`local` must be True or False"),
}


@pytest.mark.parametrize("case", NUMBERS)
def test_numbers(case):
    act, message = NUMBERS[case]
    with pytest.raises((ValueError, TypeError), match=message):
        act()


# -- functions of time --------------------------------------------------------------------------------------------

FUNCTIONS = {
    "a load that is a number": (
        lambda: fm.simulate(MODEL, TIMES, loads={"1.x": 3.0}),
        r"Load '1\.x' .*function of time",
    ),
    "loads that are a function": (lambda: fm.simulate(MODEL, TIMES, loads=abs), "`loads` must be a dictionary"),
    "a load of one number on a node": (
        lambda: fm.simulate(MODEL, TIMES, loads={"1": lambda t: 1.0}),
        r"Load '1' must return 2 numbers, one for each component, but returns shape \(\)",
    ),
    "a load of three numbers": (
        lambda: fm.simulate(MODEL, TIMES, loads={"1": lambda t: jnp.ones(3)}),
        r"Load '1' must return 2 numbers, .* returns shape \(3,\)",
    ),
    "a load of two numbers on a coordinate": (
        lambda: fm.simulate(MODEL, TIMES, loads={"1.x": lambda t: jnp.ones(2)}),
        r"Load '1\.x' must return one number, but returns shape \(2,\)",
    ),
    "a table of one number on a node": (
        lambda: fm.simulate(MODEL, TIMES, loads={"1": fm.motion.Table(jnp.array([0.0, 1.0]), jnp.array([0.0, 1.0]))}),
        r"Load '1' must return 2 numbers",
    ),
    "a table that runs backwards": (
        lambda: fm.simulate(MODEL, TIMES, loads={"1.x": fm.motion.Table(jnp.array([1.0, 0.0]), jnp.zeros(2))}),
        r"Load '1\.x': the times of a table must be finite and ascending",
    ),
    "a table with a time too many": (
        lambda: fm.simulate(MODEL, TIMES, loads={"1.x": fm.motion.Table(jnp.array([0.0, 0.5, 1.0]), jnp.zeros(2))}),
        r"Load '1\.x': a table needs as many values as times",
    ),
    "a table with a value that is none": (
        lambda: fm.simulate(
            MODEL, TIMES, loads={"1.x": fm.motion.Table(jnp.array([0.0, 1.0]), jnp.array([0, np.nan]))}
        ),
        r"Load '1\.x': the values of a table must be finite",
    ),
    "an increment that is a number": (
        lambda: fm.simulate(cart(increment=True).build(), TIMES, increment=1.0),
        "`increment` must be a function of time",
    ),
    "an increment of two": (
        lambda: fm.simulate(cart(increment=True).build(), TIMES, increment=lambda t: jnp.ones(2)),
        r"`increment` must return one number, but returns shape \(2,\)",
    ),
    "a controller of one input for two": (
        lambda: fm.simulate(MODEL, TIMES, control=lambda t, y: y[:1]),
        r"controller returns shape \(1,\), but the mechanism has 2 inputs",
    ),
    "a reference of one output for two": (
        lambda: fm.simulate(MODEL, TIMES, control=lambda t, y: y, reference=lambda t: jnp.zeros(1)),
        r"`reference` returns shape \(1,\), but the mechanism has 2 outputs",
    ),
    "a sample that takes no time": (
        lambda: fm.simulate(MODEL, TIMES, control=fm.motion.Sampled(lambda t, z, y: (y, z), 0.0)),
        "`period` must be positive",
    ),
    "a sample that forgets its state": (
        lambda: fm.simulate(MODEL, TIMES, control=fm.motion.Sampled(lambda t, z, y: y, 0.1)),
        "must return the inputs and the next state",
    ),
    "a sample whose state changes size": (
        lambda: fm.simulate(
            MODEL, TIMES, control=fm.motion.Sampled(lambda t, z, y: (y, jnp.ones(3)), 0.1, jnp.zeros(2))
        ),
        r"returns a state \(3,\), but starts at \(2,\)",
    ),
    "a sample of one input for two": (
        lambda: fm.simulate(MODEL, TIMES, control=fm.motion.Sampled(lambda t, z, y: (y[:1], z), 0.1)),
        r"controller returns shape \(1,\), but the mechanism has 2 inputs",
    ),
    "a complex load": (
        lambda: fm.simulate(MODEL, TIMES, loads={"1.x": lambda t: jax.lax.complex(0.0 * t, t)}),
        "Load '1.x' .* must be real",
    ),
    "a complex input in a trace": (
        lambda: jax.eval_shape(lambda c: fm.simulate(MODEL, TIMES, inputs={INPUT: lambda t: c}).x, 1j),
        "Input '.*' .* must be real",
    ),
    "a complex table": (
        lambda: fm.simulate(MODEL, TIMES, loads={"1.x": fm.motion.Table(jnp.array([0.0, 1]), jnp.array([0j, 1j]))}),
        "Load '1.x', a table, must be real",
    ),
    "a complex controller": (
        lambda: fm.simulate(MODEL, TIMES, control=lambda t, y: jax.lax.complex(y, y)),
        "The controller must be real",
    ),
    "a complex rate of a controller": (
        lambda: fm.simulate(
            MODEL,
            TIMES,
            control=fm.motion.Feedback(lambda t, z, y: y, lambda t, z, y: jax.lax.complex(z, z), np.ones(1)),
        ),
        "The controller's rate must be real",
    ),
    "a complex state of a sample": (
        lambda: fm.simulate(
            MODEL, TIMES, control=fm.motion.Sampled(lambda t, z, y: (y, jax.lax.complex(z, z)), 0.1, jnp.zeros(2))
        ),
        "of the sampled controller must be real",
    ),
    "a complex reference": (
        lambda: fm.simulate(MODEL, TIMES, control=lambda t, y: y, reference=lambda t: jnp.array([1j, 2])),
        "`reference` must be real",
    ),
    "nothing that moves": (lambda: fm.simulate(held(), TIMES), "Nothing moves by itself"),
    "a start that is a number": (lambda: fm.simulate(MODEL, TIMES, initial=0.0), "`initial` must be an Equilibrium"),
    "a start of another model": (
        lambda: fm.simulate(MODEL, TIMES, initial=fm.equilibrium(other())),
        "`initial` is a state of another model",
    ),
    "a control system that is none": (lambda: fm.simulate(MODEL, TIMES, control=1.0), "`control` must be a control"),
    "a control system of another size": (
        lambda: fm.simulate(MODEL, TIMES, control=control.ss([], [], [], [[1.0]])),
        "The controller has 1 inputs",
    ),
}


def leaf(thickness):
    b = fm.Builder()
    b.node("a", (0, 0))
    b.node("b", (0.1, 0))
    b.fix("a")
    b.add(planar.beam, "a", "b", name="l", section=fm.Rectangle(0.01, thickness, fm.Material(2e11, 8e10, 8e3)))
    return b.build()


def cart_of(mass):
    b = cart()
    b.mass("1", mass)
    return b.build()


def held():
    b = fm.Builder()
    for i in "ab":
        b.node(i, (ord(i), 0))
        b.fix(i)
    b.add(planar.truss, "a", "b", name="s", section=fm.Rigidity(EA=1.0))
    b.mass("b", 1.0)
    return b.build()


def other():
    b = fm.Builder()
    for i in "abc":
        b.node(i, (0.1 * ord(i), 0))
    for i in "bc":
        b.add(planar.truss, "a", i, name=i, section=fm.Rigidity(EA=1.0))
        b.fix(i, "y")
    b.fix("a")
    return b.build()


@pytest.mark.parametrize("case", FUNCTIONS)
def test_functions_of_time(case):
    act, message = FUNCTIONS[case]
    with pytest.raises((ValueError, TypeError), match=message):
        act()


@pytest.mark.slow
def test_a_rotation_is_driven_by_the_name_it_was_prescribed_by():
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (1.0, 0))
    b.add(planar.rigid_beam, "A", "B", name="arm")
    b.fix("A", "position")
    b.mass("B", 1.0)
    b.prescribe("A", "rotation", 0.0)
    model = b.build()
    found = fm.simulate(model, [0, 0.1], motion={"A.rotation": lambda t: 2.0 * t})
    np.testing.assert_allclose(found.at("A.rotation")[-1], 0.2, rtol=1e-9)
    twice = {"A.rotation": lambda t: 2.0 * t, "A.rotation.phi": lambda t: 3.0 * t}
    with pytest.raises(fm.ModelError, match=r"'A\.rotation' and 'A\.rotation\.phi' drive the same coordinate"):
        fm.simulate(model, [0, 0.1], motion=twice)
    with pytest.raises(fm.ModelError, match=r"Motion 'B' names no coordinate"):
        fm.simulate(model, [0, 0.1], motion={"B": lambda t: t})
    b = fm.Builder()
    b.node("A", (0, 0, 0))
    b.node("B", (1.0, 0, 0))
    b.add(fm.spatial.rigid_beam, "A", "B", name="arm")
    b.fix("A", "position")
    b.mass("B", 1.0)
    with pytest.raises(
        fm.ModelError, match=r"Motion 'A\.rotation' is not PRESCRIBED\. Call prescribe\('A', \"rotation\""
    ):
        fm.simulate(b.build(), [0, 0.1], motion={"A.rotation": lambda t: t})


def test_an_axis_that_a_node_does_not_have():
    for axis in ("rotation", "phi", 0, None):
        with pytest.raises(ValueError, match=re.escape(f"Node '1' has no axis {axis!r}: it is one of 'x', 'y'")):
            fm.stiffness(MODEL, "1", axis)


def truss_corner():
    b = fm.Builder()
    for name, place in {"a": (0, 0), "b": (1, 0), "c": (0.5, 1)}.items():
        b.node(name, place)
    for p, q in ("ab", "bc", "ac"):
        b.add(planar.truss, p, q, name=p + q, section=fm.Rigidity(EA=1.0))
    b.fix("a")
    b.fix("b", "y")
    return b.build()


OTHERS = {
    "axes of a node that cannot turn": (lambda: fm.compliance(truss_corner(), "c", local=True), "'c' has no rotation"),
    "sparse a word": (lambda: fm.frequencies(MODEL, sparse="yes", count=1), "`sparse` must be True or False"),
    "throw a word": (lambda: fm.equilibrium(MODEL, throw="no"), "`throw` must be True or False"),
    "a step that a path has not": (lambda: fm.path(truss_corner(), step=1.0).linearization(9), "The path has"),
    "times that a motion has not": (lambda: fm.simulate(MODEL, TIMES).until(3), "`count` must be 0 to 2"),
    "a state that is none": (lambda: fm.linear.section_resultants(MODEL, at=MODEL), "`at` must be an Equilibrium"),
    "a shape that is none": (lambda: fm.linear.frequency_like(MODEL, [0.0, 0.0]), "`shape` must have an entry"),
    "a shape that is no number": (lambda: fm.linear.frequency_like(MODEL, [np.nan, 0.0]), "`shape` .*finite"),
    "a shape of another size": (lambda: fm.linear.frequency_like(MODEL, [1.0]), "`shape` must have 2 entries"),
    "no values": (lambda: fm.linear.smooth_minimum([]), "`values` of smooth_minimum must be several numbers"),
    "values that are words": (
        lambda: fm.linear.smooth_maximum(["1", "2"]),
        "`values` of smooth_maximum must be several",
    ),
    "a motion that is none": (lambda: fm.save_motion(MODEL, "x.npz"), "fm.save_motion takes a Motion"),
    "a function that is none": (lambda: fm.jit("frequencies"), "fm.jit takes a function"),
    "jumps in rows": (lambda: fm.simulate(MODEL, TIMES, jumps=[[0.05]]), "`jumps` must be a list of times"),
    "a level below zero": (
        lambda: fm.design.settling_time(-np.eye(2), np.ones(2), np.ones(2), -0.1, horizon=1.0),
        "`level` must be positive",
    ),
    "a loop that is none": (
        lambda: fm.design.settling_time(np.full((2, 2), np.nan), np.ones(2), np.ones(2), 0.1, horizon=1.0),
        "`matrix` .*finite",
    ),
    "an output of another size": (
        lambda: fm.design.settling_time(-np.eye(2), np.ones(2), np.ones(3), 0.1, horizon=1.0),
        r"`output` must have shape \(2,\)",
    ),
    "a ratio below zero": (
        lambda: fm.sections.damping_from_ratio(fm.Rigidity(EA=1.0, mass=1.0), 0.1, -0.01),
        "`ratio` must be at least 0",
    ),
    "a spring without length": (
        lambda: fm.sections.damping_from_ratio(fm.Rigidity(EA=1.0, mass=1.0), 0.0, 0.01),
        "`length` must be positive",
    ),
    "a section that is none": (lambda: fm.sections.damping_from_ratio(3.0, 0.1, 0.01), "`section` must be a Section"),
    "a strip without width": (lambda: fm.sections.warping_factor(0.1, 0.0, 0.3), "`width` must be positive"),
    "a Poisson's ratio in percent": (lambda: fm.sections.warping_factor(0.1, 0.02, 30), "`nu` must be .* at most 1"),
    "a side below zero": (lambda: fm.sections.torsion_series(-0.02, 5e-4), "`width` must be positive"),
    "half an order": (lambda: planar.spectral_beam(2.5), "`order` of spectral_beam must be a whole number"),
    "an order beyond sense": (lambda: fm.spatial.spectral_beam(10_000), "order must be at least 1 and at most 40"),
    "a law that is none": (lambda: planar.spring_damper(3.0), "`law` of spring_damper must be a function"),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", OTHERS)
def test_other_arguments(case):
    act, message = OTHERS[case]
    with pytest.raises((ValueError, TypeError, IndexError), match=message):
        act()


def test_the_sides_of_a_rectangle_are_exchanged_by_either_torsion_constant():
    for function in (fm.sections.torsion_series, fm.sections.torsion_approximate):
        assert function(0.018, 5e-4) == approx(float(function(5e-4, 0.018)), rel=1e-12)


@pytest.mark.parametrize(
    "name",
    [
        *(
            "equilibrium",
            "linearize",
            "frequencies",
            "modes",
            "poles",
            "buckling",
            "buckling_loads",
            "path",
            "limit_load",
        ),
        *("configuration", "section_resultants", "compliance", "frequency_like", "state_matrices", "stiffness"),
    ],
)
def test_a_model_that_was_not_checked_is_refused_where_its_freedoms_do_not_determine_it(name):
    model = cart().build(check=False)
    with pytest.raises(fm.ModelError, match=rf"fm\.{name}: .*check=False.* 2 more"):
        ASKS[name](model)


def beyond_reach():
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0.1, 0))
    leaf = fm.Rectangle(0.018, 5e-4, fm.Material(E=210e9, G=80e9, rho=7850.0))
    b.add(planar.beam, "A", "B", name="leaf", section=leaf)
    b.fix("A")
    b.force("B", (1e12, 1e12))
    b.input("B", "x")
    b.output("B", "x")
    return b.build()


@pytest.mark.slow
def test_what_was_not_found_is_not_gone_on_with():
    model = beyond_reach()
    lin = fm.linearize(model, throw=False)
    for name in ("frequencies", "modes", "poles", "directional_compliance", "state_matrices", "to_statespace"):
        with pytest.raises(fm.AnalysisError, match="equilibrium was not found"):
            ASKS[name](lin)
    with pytest.raises(fm.AnalysisError, match="equilibrium was not found"):
        fm.compliance(lin, "B")
    with pytest.raises(fm.AnalysisError, match="equilibrium was not found"):
        fm.simulate(model, TIMES, initial=fm.equilibrium(model, throw=False))
    # Unless one asks for it, with its code.
    assert fm.modes(lin, throw=False).lin.result == lin.result


@pytest.mark.slow
def test_a_motion_that_ended_early_is_no_start():
    found = fm.simulate(MODEL, np.linspace(0, 1, 5), loads={"1.x": jnp.sin}, max_steps=2, throw=False)
    with pytest.raises(fm.ModelError, match=r"`initial` .* did not reach its end"):
        fm.simulate(MODEL, TIMES, initial=found)


@pytest.mark.slow
def test_a_mechanism_that_cannot_move_has_no_poles():
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0.1, 0))
    b.add(planar.beam, "A", "B", name="leaf")
    b.fix("A")
    assert fm.poles(b.build()).shape == (0,)


@pytest.mark.parametrize(
    ("ask", "why"),
    [
        (fm.poles, "give fm.poles `count`"),
        (fm.to_statespace, r"use fm\.control\.state_matrices"),
        (fm.mobility, r"fm\.mobility takes a model of known numbers"),
        (fm.control.to_nonlinear_system, "to_nonlinear_system takes a model of known numbers"),
        (lambda model: fm.verdict(model, {"B.x": 1e-3}), r"fm\.verdict takes a model of known numbers"),
        (fm.linear.directional_compliance, "directional_compliance needs a model of known numbers. Use fm.compliance"),
    ],
)
def test_what_needs_concrete_numbers_says_so(ask, why):
    with pytest.raises(TypeError, match=why):
        jax.jit(lambda mass: ask(_weighed(mass)))(1.0)


def _weighed(mass):
    b = cart()
    b.mass("2", mass)
    return b.build(dofs=MODEL.q_labels)


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda build, answers: fm.sweep(build, answers, [1e-3]), "`designs` must be a dictionary"),
        (lambda build, answers: fm.sensitivities(build, answers, [1e-3]), "`dimensions` must be a dictionary"),
        (lambda build, answers: fm.tune(build, answers, [1e-3], bounds={}), "`dimensions` must be a dictionary"),
        (lambda build, answers: fm.tune(build, answers, {}, bounds=None), "`bounds` must be a dictionary"),
        (lambda build, answers: fm.lean(build, bandwidth=1.0, increments=5), "`increments` must be a list of factors"),
        (lambda build, answers: fm.lean(build, bandwidth=1.0, nodes=5), "`nodes` must be a list of names"),
        (
            lambda build, answers: places_of_names("input", ["push"], 3),
            "`inputs` must be a name or a list of names, not 3",
        ),
        (
            lambda build, answers: ascending_modes(np.array(0.5), 3),
            "`modes` must be a whole number, or numbers of modes",
        ),
    ],
)
def test_what_is_neither_a_dictionary_nor_a_list_is_named(ask, words):
    with pytest.raises((TypeError, fm.ModelError), match=words):
        ask(lambda t: None, {"mass": fm.mass})


# -- kinds and bounds that annotations declare --------------------------------------------------------------------


@checked
def declared(step: Positive, count: Count = 3, form: Literal["dense", "sparse"] | None = None, sparse: Flag = False):
    return step, count, form, sparse


@pytest.mark.parametrize(
    ("arguments", "options", "fault", "message"),
    [
        ((0.0,), {}, ValueError, "`step` must be positive, but is 0.0"),
        (("a",), {}, TypeError, "`step` must be one number, not 'a'"),
        ((None,), {}, TypeError, "`step` must be one number, not None"),
        ((1.0, 0), {}, ValueError, "`count` must be at least 1, but is 0"),
        ((1.0,), {"count": 2.5}, TypeError, "`count` must be a whole number, not 2.5"),
        ((1.0,), {"form": "full"}, ValueError, "`form` must be 'dense' or 'sparse', but is 'full'"),
        ((1.0,), {"sparse": 1}, TypeError, "`sparse` must be True or False, not 1"),
    ],
)
def test_an_annotation_says_what_an_argument_must_be(arguments, options, fault, message):
    with pytest.raises(fault, match=message):
        declared(*arguments, **options)


def test_declared_arguments_that_are_right():
    assert declared(1.0) == (1.0, 3, None, False)
    assert declared(step=0.5, count=np.int64(2), form="dense", sparse=True) == (0.5, 2, "dense", True)
    assert jax.jit(lambda step: declared(step)[0])(2.0) == 2.0
