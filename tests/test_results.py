"""What a result says of itself on a terminal: a few lines with its size, its extremes and their names."""

import dataclasses
import functools

import jax
import numpy as np
import pytest
from cases.mechanisms import cart_on_rod, planar_guide

import flexmb as fm
from flexmb import paths, planar, spatial
from flexmb.mechanisms import mechanism_path


@functools.cache
def guide():
    """Leaf-spring guide pressed down."""
    return planar_guide(force=(0, -1.0)).build()


def cart(stiffness=100.0, mass=4.0):
    b = cart_on_rod(stiffness, mass)
    b.start("cart", "x", 0.02)
    return b.build()


@functools.cache
def motion():
    return fm.simulate(cart(), np.linspace(0, 1, 11))


def shipped(name, check=True):
    return fm.read_spacar(mechanism_path(name)).builder.build(check=check)


def answer(model):
    return fm.frequencies(model)[0]


def critical():
    return paths.CriticalPoint(0.5, "limit", np.zeros(400), np.ones(400), 1e-3)


def light():
    nodes, elements = [[0, 0, 0], [0, 0.1, 0]], [[1, 2]]
    leaf = {"emod": 210e9, "smod": 80e9, "dens": 7800.0, "cshape": "rect", "dim": [50e-3, 0.5e-3], "orien": [0, 0, 1]}
    return fm.spacar.spacar_light(nodes, elements, {1: {"fix": True}}, [{"elems": 1, "flex": [2], **leaf}], {})


CASES = {
    "Model": (guide, ["plane", "left1.x", "12 coordinates", "NDOF"]),
    "Equilibrium": (lambda: fm.equilibrium(cart()), ["successful", "0.01 [m, rad] at rod.e1", "-1 N at wall.x"]),
    "Configuration": (lambda: fm.configuration(cart(), np.array([0.1]), np.array([2.0])), ["2 m/s at cart.x"]),
    "Linearization": (lambda: fm.linearize(cart()), ["cart.x is displaced most", "0.01 m", "successful", "100"]),
    "Matrices": (lambda: fm.linearize(guide()).matrices, ["M0[1,1]", "x[12]"]),
    "Modes": (lambda: fm.modes(cart()), ["1 of 1", "mode 1: 0.79577 Hz, moves cart.x most", "stable: yes"]),
    "Buckling": (
        lambda: fm.buckling(guide()),
        ["1 of 1", "mode 1: load multiplier 78.75, moves left1.x most", "factor of all loads"],
    ),
    "StateMatrices": (lambda: fm.control.state_matrices(cart())[0], ["A (2, 2)"]),
    "Stress": (lambda: fm.stress(guide()), ["2 elements at 5 places", "1.1111e+05 Pa", "'left 1' at 0", "von Mises"]),
    "SectionResultants": (lambda: fm.linear.section_resultants(guide()), ["-1 to 0 N, largest in 'left 1' at 0"]),
    "Path": (lambda: fm.path(cart()), ["cart.x moves most, 1 to 1.01 m", "up to 1", "none"]),
    "CriticalPoint": (critical, ["limit at load factor 0.5 within 0.001", "(400,)"]),
    "Motion": (motion, ["11 states, cart.x moves most", "0 to 1 s, 11 times", "successful"]),
    "Observed": (lambda: motion().observe(), ["largest velocity: ", "m/s² at cart.x", "kinetic energy: 0 to "]),
    "Mobility": (
        lambda: fm.mobility(shipped("pf3dover", check=False)),
        ["overconstrained", "self-stress 1 of 1: release e3 of '1'"],
    ),
    "Designs": (lambda: fm.design.grid(stiffness=[1.0, 2.0], mass=[3.0]), ["Designs: 2", "stiffness: 1 to 2"]),
    "Sweep": (
        lambda: fm.sweep(cart, {"f": answer}, fm.design.grid(stiffness=[100.0, 400.0])),
        ["stiffness 100 to 400", "f: 0.79"],
    ),
    "Tuned": (
        lambda: fm.tune(
            cart, {"f": answer}, {"stiffness": 100.0}, bounds={"stiffness": (50.0, 500.0)}, targets={"f": 1.0}
        ),
        ["successful", "stiffness: 157.9", "start 0.79577"],
    ),
    "Sensitivities": (
        lambda: fm.sensitivities(cart, answer, {"stiffness": 100.0}),
        ["0.79577, 0.5 % per % of stiffness"],
    ),
    "Tolerances": (
        lambda: fm.design.tolerances(cart, answer, {"mass": 4.0}, {"mass": 0.04}),
        ["± 0.0039", "100 % from mass"],
    ),
    "Lean": (lambda: fm.lean(shipped("pf2d3dof"), bandwidth=21.0), ["1 of 3", "3.x", "frequencies: 10.645 Hz"]),
    "SpacarModel": (lambda: fm.read_spacar(mechanism_path("elevator")), ["elevator.dat", "settings: ", "TIMESTEP"]),
    "LightResults": (light, ["1 load step, ndof 1", "largest stress: 0 to 0 Pa", "frequencies"]),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_a_result_is_a_few_lines_that_name_what_matters(name):
    make, words = CASES[name]
    text = repr(make())
    assert text.startswith(name)
    lines = text.splitlines()
    assert len(lines) <= 12
    assert max(map(len, lines)) <= 120
    for word in words:
        assert word in text


@pytest.mark.slow
def test_a_failure_says_what_to_try():
    failed = dataclasses.replace(fm.equilibrium(cart()), result=np.int32(fm.RESULTS.not_converged))
    text = " ".join(repr(failed).split())
    assert "result: not_converged. The static equilibrium was not found" in text
    assert "lower it, or use more elements." in text


@pytest.mark.slow
def test_a_traced_result_tells_its_shapes():
    seen = []

    @jax.jit
    def look(model):
        lin = fm.linearize(model, throw=False)
        seen.extend([repr(model), repr(lin), repr(fm.stress(model, at=lin))])
        return lin.M0

    look(guide())
    for text, words in zip(seen, ("reference[12]", "K0[1,1]", "von_mises[2,5,8]"), strict=True):
        assert words in text
        assert len(text.splitlines()) <= 12


@pytest.mark.slow
def test_results_of_several_mechanisms_tell_their_shapes():
    many = jax.vmap(lambda k: fm.equilibrium(cart(k), throw=False))(np.array([1.0, 2.0, 4.0]))
    assert "x[3,4]" in repr(many)
    assert "M0[11,1,1]" in repr(fm.motion.linearize_motion(motion()))


@pytest.mark.slow
def test_matrices_are_attributes_of_what_is_linearised():
    lin, along = fm.linearize(guide()), fm.motion.linearize_motion(motion())
    for found in (lin, along, fm.path(cart())):
        for name in ("M0", "C0", "D0", "K0", "N0", "G0", "K", "DFx", "DFe", "S", "S_d", "x", "e", "sigma", "reactions"):
            assert name in dir(type(found))
            np.testing.assert_array_equal(getattr(found, name), getattr(found.matrices, name))
    assert (lin.symmetric, lin.moving, int(lin.result)) == (True, None, 0)
    assert along.moving is along.matrices.moving
    with pytest.raises(AttributeError, match="M1"):
        lin.M1  # type: ignore[attr-defined]  # noqa: B018


@pytest.mark.slow
def test_a_mode_turns_a_node_and_no_euler_parameter():
    b = fm.Builder()
    b.node("foot", (0.0, 0.0, 0.0))
    b.node("tip", (0.1, 0.0, 0.0))
    section = fm.Rigidity(EA=1e5, GIt=0.1, EIy=0.1, EIz=0.1)
    b.add(spatial.beam, "foot", "tip", section=section, y=(0, 1, 0), released=(2,))
    b.fix("foot")
    b.inertia("tip", (1e-3, 0, 0, 1e-3, 0, 1e-3))
    assert "turns tip most" in repr(fm.modes(b.build()))


@pytest.mark.slow
def test_modes_are_told_by_nodes_and_not_by_what_lies_within_an_element():
    b = fm.Builder()
    b.node("foot", (0.0, 0.0))
    b.node("tip", (0.0, 0.1))
    b.add(planar.spectral_beam(2), "foot", "tip", section=fm.Rigidity(EA=1e5, EIy=0.1, mass=0.1))
    b.fix("foot")
    told = repr(fm.modes(b.build()))
    assert "moves tip.rotation.phi most" in told
    assert "internal" not in told


@pytest.mark.slow
def test_a_mode_within_an_element_is_told_by_its_deformation():
    b = fm.Builder()
    b.node("foot", (0.0, 0.0))
    b.node("tip", (0.1, 0.0))
    b.add(planar.spectral_beam(3), "foot", "tip", name="arch", section=fm.Rigidity(EA=1e5, EIy=0.1, mass=0.1))
    b.fix("foot")
    b.fix("tip", "y", "phi")
    b.force("tip", (-1.0, 0.0))
    assert "bends 'arch' most" in repr(fm.modes(b.build(), count=1))
    buckled = repr(fm.buckling(b.build(), count=1))
    assert "bends 'arch' most" in buckled
    assert "load multiplier: factor of all loads at which the mechanism buckles" in buckled
