"""Motions without stiffness, without mass or with a negative one: named, and no number that is none."""

import dataclasses

import jax
import numpy as np
import pytest
from cases import mechanisms, motions
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.answers.answers import answer

LEAF = mechanisms.leaf()
EI = float(LEAF.rigidity().EIy)


# -- negative mass ------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def negative():
    # The bar turns with both of its ends: 2 * 0.01 kg m^2 less than the half millionth that the rest of it has.
    return mechanisms.planar_guide(elongation=True, inertia=-0.01).build()


def at_two_times(lin):
    return dataclasses.replace(lin, matrices=jax.tree.map(lambda a: np.stack([a, a]), lin.matrices))


@pytest.mark.slow("frequencies", "count", "modes", "like")
@pytest.mark.parametrize(
    "ask",
    [
        fm.frequencies,
        lambda model: fm.frequencies(model, count=1),
        fm.modes,
        fm.poles,
        fm.control.state_matrices,
        fm.to_statespace,
        lambda model: fm.frequencies(fm.linearize(model)),
        lambda model: fm.linear.frequency_like(model, np.array([1.0, 0, 0])),
        lambda model: fm.control.state_matrices(at_two_times(fm.linearize(model))),
    ],
    ids="frequencies count modes poles state_matrices to_statespace of_linearisation like along_a_motion".split(),
)
def test_a_negative_mass_is_refused_by_the_name_of_its_nodes(negative, ask):
    with pytest.raises(fm.AnalysisError, match=r"negative mass.*(left1|right1)\.rotation\.phi") as fault:
        ask(negative)
    assert fault.value.code == "singular_mass"


@pytest.mark.slow
@pytest.mark.parametrize("mode", [7, 8, 9, 10])
def test_a_negative_mass_on_the_command_line(mode):
    builder = mechanisms.planar_guide(elongation=True, inertia=-0.01, force=(0, -1.0))
    found = answer(builder, "guide", mode)
    assert found.exit_status == 1
    assert found.data["status"] == "singular_mass"
    assert "left1.rotation.phi" in found.data["message"]


@pytest.mark.slow
def test_a_code_says_so_where_nothing_is_raised(negative):
    def code(model):
        with pytest.raises(fm.AnalysisError) as fault:
            fm.frequencies(model)
        return fault.value.code

    assert code(negative) == "singular_mass"
    # Within a compiled function of designs the code is collected.
    assert np.all(np.isfinite(fm.frequencies(negative, throw=False)[:2]))


@pytest.mark.parametrize("inertia", [-1e-7, -1e-5])
def test_negative_rotary_inertia_is_legal_while_the_mass_matrix_is_positive(inertia):
    """The tutorial's trick (3.9): the rotary inertia of a leaf spring's end taken off; against SciPy."""
    import scipy.linalg

    lin = fm.linearize(mechanisms.planar_guide(elongation=True, inertia=inertia).build())
    values = scipy.linalg.eigh(np.asarray(lin.K), np.asarray(lin.M0), eigvals_only=True)
    np.testing.assert_allclose(fm.frequencies(lin), np.sqrt(values) / (2 * np.pi), rtol=1e-9)


@pytest.mark.slow
def test_a_motion_without_mass_is_none_with_a_negative_one():
    """Massless rotations, alone and combined with others, stay left out."""
    b = fm.Builder()
    for i in range(4):
        b.node(f"{i}", (0.03 * i, 0))
    for i in range(3):
        b.add(planar.beam, f"{i}", f"{i + 1}", name=f"b{i}", section=fm.Rigidity(EA=1e6, EIy=1.0))
    b.fix("0")
    b.mass("3", 1.0)
    model = b.build()
    found = fm.modes(model)
    # Tip mass on a cantilever: 3 EI/L^3, and EA/L.
    expected = np.sqrt([3 / 0.09**3, 1e6 / 0.09]) / (2 * np.pi)
    np.testing.assert_allclose(found.frequencies, expected, rtol=1e-8)
    assert found.massless == 7
    np.testing.assert_allclose(fm.frequencies(model, count=1), expected[:1], rtol=1e-8)


# -- no mass ------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_what_carries_no_mass_is_named_in_a_simulation():
    b = motions.pendulum()
    b.members = {name: member for name, member in b.members.items() if not member.hidden}
    with pytest.raises(fm.AnalysisError, match=r"without mass: .*mass\.(x|y)|rod\.phi") as fault:
        fm.simulate(b.build(), [0, 1.0], form="reduced")
    assert fault.value.code == "singular_mass"


@pytest.mark.slow
def test_one_of_two_motions_that_carries_no_mass_is_named_in_a_simulation():
    b = motions.double_pendulum()
    b.members = {name: m for name, m in b.members.items() if not (m.hidden and "lower" in m.nodes)}
    with pytest.raises(fm.AnalysisError, match=r"without mass: .*(lower\.x|second\.phi)") as fault:
        fm.simulate(b.build(), [0, 1.0])
    assert fault.value.code == "singular_mass"


@pytest.mark.slow
def test_a_motion_with_neither_mass_nor_stiffness_is_named():
    for ask in (fm.frequencies, fm.modes, fm.poles):
        with pytest.raises(fm.AnalysisError, match=r"arm\.phi.* no mass either. Give it a mass or an inertia") as fault:
            ask(with_free_arm(mass=None))
        assert fault.value.code == "singular_stiffness"


@pytest.mark.slow
def test_sections_without_rotary_inertia_are_named_where_a_motion_carries_no_mass():
    """A pinned bar turns about its own axis: without rotary inertia nothing of it resists or carries that."""
    b = fm.Builder()
    for name, place in {"A": (0, 0, 0), "B": (0.1, 0, 0)}.items():
        b.node(name, place)
    section = fm.Rectangle(0.02, 0.02, fm.Material(E=2e11, G=8e10, rho=8e3), rotary=False)
    b.add(fm.spatial.beam, "A", "B", section=section)
    b.fix("A", "position")
    for ask in (fm.frequencies, fm.modes, fm.poles):
        with pytest.raises(
            fm.AnalysisError,
            match=r"that is A\.rotation\.l1 .*, B\.rotation\.l1 .*\. It has no mass either.*rotary=False",
        ):
            ask(b.build())


# -- no stiffness -------------------------------------------------------------------------------------------------


def with_free_arm(mass=1.0):
    """A cantilever, and beside it an arm that turns freely."""
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0.1, 0), "P": (0, 0.1), "Q": (0, 0.2)}.items():
        b.node(name, place)
    b.add(planar.beam, "A", "B", name="leaf", section=LEAF)
    b.fix("A")
    b.mass("B", 1.0, inertia=1e-4)
    b.rotation("arm")
    b.add(planar.rigid_beam, "P", "arm", "Q", name="bar")
    b.fix("P", "position")
    if mass:
        b.mass("Q", mass)
    return b.build()


def test_compliance_beside_a_free_motion():
    model = with_free_arm()
    # Of a cantilever: EA/L, 3 EI/L^3, 2 EI/L^2, EI/L.
    bending = np.array([[0.1**3 / 3, 0.1**2 / 2], [0.1**2 / 2, 0.1]]) / EI
    found = fm.compliance(model, "B")
    np.testing.assert_allclose(found[1:, 1:], bending, rtol=1e-9)
    assert fm.stiffness(model, "B", "y") == approx(1 / bending[0, 0], rel=1e-9)
    for ask in (lambda: fm.compliance(model, "Q"), lambda: fm.stiffness(model, "Q", "x")):
        with pytest.raises(fm.AnalysisError, match=r"'Q'.* arm\.phi") as fault:
            ask()
        assert fault.value.code == "singular_stiffness"
    with pytest.warns(fm.FlexmbWarning, match=r"unbounded.* arm\.phi"):
        each = fm.linear.directional_compliance(model)
    np.testing.assert_allclose(each["B"][1], bending[0, 0], rtol=1e-9)
    np.testing.assert_allclose(each["B.rotation"], bending[1, 1], rtol=1e-9)
    # The arm stands upright: its end moves along x, and not along y.
    np.testing.assert_array_equal(np.isinf(each["Q"]), [True, False])
    np.testing.assert_allclose(each["Q"][1], 0, atol=1e-15)
    assert np.isinf(each["arm"][0])
    np.testing.assert_array_equal(each["A"], 0)


@pytest.mark.slow
def test_compliance_of_a_free_motion_in_a_path_is_null_with_a_warning():
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0.1, 0), "P": (0, 0.1), "Q": (0, 0.2)}.items():
        b.node(name, place)
    b.add(planar.beam, "A", "B", name="leaf", section=LEAF)
    b.fix("A")
    b.rotation("arm")
    b.add(planar.rigid_beam, "P", "arm", "Q", name="bar")
    b.fix("P", "position")
    b.mass("Q", 1.0)
    b.force("B", (0, 1e-3))
    found = answer(b, "free", 10, dofs="auto").data
    told = [text for text in found["warnings"] if "unbounded" in text]
    assert len(told) == 1
    assert "arm.phi" in told[0]
    compliance = found["path"][0]["compliance"]
    assert np.isfinite(compliance["B"]).all()
    assert not np.any(np.isnan(compliance["Q"]))


@pytest.mark.slow
def test_compliance_of_slender_springs_is_not_called_free():
    # EA L^2/EI of 1e9, coordinates in which stretching and bending mix.
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0.6, 0.8))
    b.add(planar.beam, "A", "B", section=fm.Rigidity(EA=1e9, EIy=1.0))
    b.fix("A")
    b.dof("B", "x", "y", "phi")
    model = b.build()
    along = np.array([0.6, 0.8])
    expected = np.outer(along, along) / 1e9 + np.outer([-0.8, 0.6], [-0.8, 0.6]) / 3
    # Round-off times the ratio of the stiffnesses.
    np.testing.assert_allclose(fm.compliance(model, "B")[:2, :2], expected, rtol=1e-6)
    assert np.all(np.isfinite(np.concatenate(list(fm.linear.directional_compliance(model).values()))))


@pytest.mark.slow
def test_derivative_of_a_compliance_still_is():
    def flexibility(thickness):
        b = fm.Builder()
        b.node("A", (0, 0))
        b.node("B", (0.1, 0))
        section = fm.Rectangle(0.018, thickness, mechanisms.steel())
        b.add(planar.beam, "A", "B", name="leaf", section=section)
        b.fix("A")
        b.dof("leaf", 1, 2, 3)
        return fm.compliance(b.build(), "B")[1, 1]

    # With the cube of the thickness.
    value, slope = jax.value_and_grad(flexibility)(5e-4)
    assert slope == approx(-3 * float(value) / 5e-4, rel=1e-9)


# -- neither mass nor stiffness -------------------------------------------------------------------------------------


def with_a_wheel(damping=0.0, factor=1.0):
    """A mass on a damped spring, and a rotation that nothing joins, which a damper may hold to the frame."""
    b = motions.sprung_mass(stiffness=500.0 * factor, damping=0.1, mass=2.0)
    b.rotation("wheel")
    b.dof("wheel", "phi")
    if damping:
        b.rotation("frame")
        b.fix("frame")
        b.add(planar.hinge, "frame", "wheel", name="brake", damping=damping, released="all")
    b.input("mass", "x", name="push")
    b.output("mass", "x", name="tip")
    return b.build()


@pytest.mark.parametrize(
    "ask",
    [
        fm.poles,
        lambda model: fm.poles(model, count=2, sparse=True),
        fm.to_statespace,
        lambda model: fm.frequency_response(model, [0.5]),
        lambda model: fm.control.noise_budget(model, sources={"push": 1.0}),
        lambda model: fm.save_fmu(model, "never.fmu", nonlinear=True),
    ],
    ids=["poles", "sparse poles", "state space", "response", "noise", "unit"],
)
def test_what_has_neither_mass_nor_stiffness_is_named(ask):
    with pytest.raises(fm.AnalysisError, match=r"wheel\.phi \(1\)"):
        ask(with_a_wheel())


TRACED = {
    "frequencies": lambda model: fm.frequencies(model)[0],
    "frequencies of a linearisation": lambda model: fm.frequencies(fm.linearize(model))[0],
    "poles": lambda model: fm.poles(model, count=2)[0].imag,
    "sparse poles": lambda model: fm.poles(model, count=2, sparse=True)[0].imag,
    "compliance": lambda model: fm.compliance(model, "wheel")[0, 0],
    "stiffness": lambda model: fm.stiffness(model, "wheel", "phi"),
    "matrices": lambda model: jax.tree.leaves(fm.control.state_matrices(model))[0].sum(),
    "response": lambda model: abs(fm.frequency_response(model, [0.5]).response).sum(),
}
DERIVATIVES = {"grad": jax.grad, "jacfwd": jax.jacfwd, "jacrev": jax.jacrev}


@pytest.mark.slow
@pytest.mark.parametrize("name", TRACED)
def test_what_is_differentiated_is_refused_by_the_same_words_and_is_nan_in_a_program(name):
    def asked(factor):
        return TRACED[name](with_a_wheel(factor=factor))

    for derivative in DERIVATIVES.values():
        with pytest.raises(fm.AnalysisError, match=r"wheel\.phi \(1\)"):
            derivative(asked)(1.0)
    assert np.isnan(jax.jit(asked)(1.0))


@pytest.mark.parametrize("name", ["frequencies", "poles", "matrices", "response"])
def test_a_negative_mass_is_refused_where_it_is_differentiated(name):
    def asked(inertia):
        return TRACED[name](mechanisms.planar_guide(elongation=True, inertia=inertia).build())

    with pytest.raises(fm.AnalysisError, match="negative mass"):
        jax.grad(asked)(-0.01)


@pytest.mark.slow
def test_derivative_of_a_compliance_beside_a_free_motion():
    def flexibility(factor):
        return fm.compliance(with_a_wheel(factor=factor), "mass")[0, 0]

    # One over the stiffness, and its derivatives.
    assert jax.grad(flexibility)(2.0) == approx(-1 / (500 * 2.0**2), rel=1e-9)
    assert jax.hessian(flexibility)(2.0) == approx(2 / (500 * 2.0**3), rel=1e-9)


@pytest.mark.slow
def test_what_damping_alone_holds_has_a_pole_at_zero():
    decay = 0.1 / (2 * 2.0)
    rate = np.sqrt(500.0 / 2.0 - decay**2)
    found = fm.poles(with_a_wheel(damping=0.3))
    np.testing.assert_allclose(found, [0, -decay - 1j * rate, -decay + 1j * rate], rtol=1e-12, atol=1e-12)
