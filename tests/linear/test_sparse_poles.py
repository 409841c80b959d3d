"""Large mechanisms without a potential: poles and responses by sparse matrices are those of dense ones."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.linear.sparse_poles import is_steady
from flexmb.statics.solver_choice import MANY


def offset(p: fm.Point2, q: fm.Point2, *, ref):
    return (q - p) - (ref.q - ref.p)


def whirling(e, ed, *, ref, k, cross, c):
    """A bearing that pushes across: a law of two deformations, whose stiffness and damping are not symmetric."""
    return k * e + cross * jnp.stack([e[1], -e[0]]) + c * ed + 0.3 * c * jnp.stack([ed[1], 0 * ed[0]])


def rotor(beams=24, load=3.0, cross=2.0, check=False):
    """A clamped column in a bearing, under a force that follows its tip; its foot shakes, and what holds it is felt."""
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(f"n{i}", (i / beams, 0.0))
    section = fm.Rigidity(EA=1e4, EIy=1.0, mass=1.0)
    for i in range(beams):
        held = {"released": (2, 3)} if i == 1 else {}
        b.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"b{i}", section=section, **held)
    b.node("wall", (0.5, -0.2))
    law = fm.Element(offset, law=whirling)
    b.add(law, "wall", f"n{beams // 2}", name="bearing", k=5.0, cross=cross, c=0.1)
    for node in ("n0", "wall"):
        b.fix(node)
    tip = f"n{beams}"
    b.mass(tip, 0.1)
    b.force(tip, (-load, 0.2), follower=True)
    b.input(tip, "y", name="push")
    b.input("n0", "y", "acceleration", name="floor")
    b.output(tip, "x", name="seen")
    b.output("n0", "y", "reaction", name="held")
    b.output("b1", 1, "stress", name="cut")
    return b.build(check=check)


@pytest.mark.slow("6", "7")
@pytest.mark.parametrize("count", [6, 7, 100])
def test_slowest_poles_are_those_of_dense_matrices(count):
    """By Arnoldi iterations; where so many are asked for, one and all."""
    found: Any = fm.poles(rotor(), count=count, sparse=True)
    wanted = fm.poles(rotor(check=True), count=count)
    assert len(found) == len(wanted) >= count
    # No pair is cut.
    np.testing.assert_array_equal(np.sort(found.imag), np.sort(-found.imag))
    # Those of nearly equal |Im| may stand in another order.
    far = np.min(np.abs(found[:, None] - wanted), axis=0) / np.abs(wanted)
    np.testing.assert_allclose(far, 0.0, atol=1e-9)


def beck(load, beams=240, copies=1):
    """Columns of EI = L = m = 1 under forces that follow their tips."""
    b = fm.Builder()
    for j in range(copies):
        for i in range(beams + 1):
            b.node(f"n{i} {j}", (i / beams, j))
        for i in range(beams):
            b.add(planar.beam, f"n{i} {j}", f"n{i + 1} {j}", section=fm.Rigidity(EA=1e6, EIy=1.0, mass=1.0))
        b.fix(f"n0 {j}")
        b.force(f"n{beams} {j}", (-load, 0.0), follower=True)
    return b.build(check=False)


def light_column():
    """One of EI = L = 1 without mass but at its tip."""
    b = fm.Builder()
    for i in range(41):
        b.node(f"n{i}", (i / 40, 0.0))
    for i in range(40):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e4, EIy=1.0))
    b.fix("n0")
    b.mass("n40", 1.0)
    return b


@pytest.mark.slow
def test_a_column_of_many_beams_flutters_at_the_load_of_beck():
    """A12, closed form 20.05; beyond it a pair of poles leaves the axis, by the root of what is beyond."""
    assert np.max(np.real(fm.poles(beck(20.04), count=4))) < 1e-6
    assert np.max(np.real(fm.poles(beck(20.06), count=4))) > 0.1


@pytest.mark.slow
def test_steadiness_by_eigenvalues_of_stiffness_and_mass():
    """A12 by a pair that turns complex; Euler's column beyond its load by a value below zero."""
    assert is_steady(fm.linearize(beck(20.04), sparse=True).elements)
    assert not is_steady(fm.linearize(beck(20.06), sparse=True).elements)
    for load, steady in ((2.4, True), (2.5, False)):
        # Of EI = L = 1, pi^2/4; few coordinates have mass.
        b = light_column()
        b.force("n40", (-load, 0.0))
        assert is_steady(fm.linearize(b.build(check=False), sparse=True).elements) is steady


@pytest.mark.slow
@pytest.mark.parametrize(("copies", "count"), [(12, 24), (30, 61)])
def test_every_copy_of_a_repeated_pole_is_found(copies, count):
    """Columns alike; iterations see one pair of each, but for what round-off shows them, of thirty nearly all."""
    found = np.abs(fm.poles(beck(10.0, beams=3, copies=copies), count=count, sparse=True))
    assert len(found) >= min(count, 2 * copies)
    assert np.sum(np.abs(found / np.min(found) - 1) < 1e-9) == min(len(found), 2 * copies)


@pytest.mark.slow
def test_derivatives_of_poles_are_those_of_dense_matrices():
    """By a load that follows, and what a bearing pushes across: neither stiffness nor damping is symmetric."""

    def slopes(sparse: bool):
        def found(p):
            poles = fm.poles(rotor(3, p[0], p[1], check=not sparse), count=4, sparse=sparse)
            return jnp.stack([jnp.real(poles), jnp.imag(poles)])

        return np.asarray(fm.jit(jax.jacfwd(found))(np.array([3.0, 2.0])))

    wanted = slopes(False)
    np.testing.assert_allclose(slopes(True), wanted, rtol=0, atol=1e-9 * np.max(np.abs(wanted)))


def test_free_motions_have_poles_at_zero():
    """Closed form of a free beam: 4.7300407 squared; motions without mass have none."""
    b = fm.Builder()
    for i in range(41):
        b.node(f"n{i}", (i / 40, 0.0))
    for i in range(40):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e6, EIy=1.0, mass=1.0))
    b.node("light", (2.0, 0.0))
    b.add(planar.beam, "n40", "light", section=fm.Rigidity(EA=1e6, EIy=1.0))
    found = fm.poles(b.build(check=False), count=8, sparse=True)
    # Three pairs at zero, which round-off of double values takes its root of.
    assert np.sum(np.abs(found) < 1e-3) == 6
    np.testing.assert_allclose(np.max(np.abs(found)), 4.7300407449**2, rtol=1e-5)


@pytest.mark.filterwarnings("ignore:Argument `count`")
@pytest.mark.slow
def test_masses_of_few_coordinates_have_few_poles():
    b = light_column()
    for count in (5, 100):
        found = fm.poles(b.build(check=False), count=count, sparse=True)
        # Closed form: a mass at the end of a cantilever bends and stretches it.
        np.testing.assert_allclose(np.abs(found), [np.sqrt(3.0)] * 2 + [100.0] * 2, rtol=1e-9)


@pytest.mark.slow
def test_responses_are_those_of_dense_matrices():
    hertz = np.array([0.1, 0.5, 1.2])
    large, dense = fm.linearize(rotor(), sparse=True), rotor(check=True)
    wanted, found = (fm.frequency_response(of, hertz).response for of in (dense, large))
    np.testing.assert_allclose(found, wanted, rtol=1e-8, atol=1e-9 * np.max(np.abs(wanted)))
    wanted, found = (fm.compliance(of, "n24") for of in (dense, large))
    assert abs(wanted[0, 1] - wanted[1, 0]) > 1e-3 * np.max(np.abs(wanted))
    np.testing.assert_allclose(found, wanted, rtol=1e-8, atol=1e-9 * np.max(np.abs(wanted)))


@pytest.mark.slow
def test_derivatives_are_those_of_central_differences():
    """Of responses, a compliance and poles, by a load that follows: stiffness and damping are not symmetric."""

    def answers(load):
        lin = fm.linearize(rotor(3, load), sparse=True)
        response = fm.frequency_response(lin, jnp.array([0.5])).response[0]
        poles = fm.poles(lin, count=4)
        # With slopes of one size, in a sum that takes one program.
        parts = jnp.abs(response), 100 * fm.compliance(lin, "n3")[:2, 1], 1e4 * jnp.real(poles), 10 * jnp.abs(poles)
        return sum(map(jnp.sum, parts))

    both = fm.jit(jax.value_and_grad(answers))
    start, h = 3.0, 1e-3
    near = {i: both(start + i * h)[0] for i in (-2, -1, 1, 2)}
    difference = (8 * (near[1] - near[-1]) - (near[2] - near[-2])) / (12 * h)
    # Truncation h^4, and the equilibrium's 1e-10 over h.
    assert float(both(start)[1]) == approx(float(difference), rel=1e-6)


@pytest.mark.slow
def test_what_is_refused():
    large = fm.linearize(rotor(), sparse=True)
    for ask in (fm.frequencies, fm.modes):
        with pytest.raises(NotImplementedError, match=r"Use fm\.poles"):
            ask(large, count=2)
    with pytest.raises(NotImplementedError, match=r"Use fm\.poles"):
        fm.to_statespace(rotor(), modes=2, sparse=True)
    with pytest.raises(ValueError, match="give `count`, the number of poles"):
        fm.poles(large)
    with pytest.raises(ValueError, match="count"):
        fm.poles(large, count=0)
    with pytest.raises(fm.ModelError, match="give few of the"):
        fm.poles(beck(1.0, beams=MANY // 3 + 1), count=4 * MANY, sparse=True)
    # A motion with neither mass nor stiffness, and one of negative mass.
    for mass, inertia, why in (
        (1.0, 0.0, r"no stiffness.*that is b\.y \(1\), a\.rotation"),
        (1.0, -1e-3, "or a negative mass"),
    ):
        b = fm.Builder()
        b.node("a", (0.0, 0.0))
        b.node("b", (1.0, 0.0))
        b.add(planar.beam, "a", "b", section=fm.Rigidity(EA=1e4, EIy=1.0))
        b.fix("a", "position")
        if inertia:
            b.mass("b", mass)
            b.inertia("a", inertia)
        with pytest.raises(fm.AnalysisError, match=why):
            fm.poles(b.build(check=False), count=1, sparse=True)
