"""Numbers of elements replaced in a model: the same as building it with them."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar

STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0)
THICKNESSES = np.array([1.0e-3, 0.6e-3, 0.8e-3])
LENGTH = 0.1


def row(thicknesses=(1e-3, 1e-3, 1e-3), diameter=4e-3, stiffness=50.0):
    """Three leaf springs in a row, a wire between the second and the third, and a spring that turns the tip back."""
    b = fm.Builder()
    for i in range(5):
        b.node(f"n{i}", (LENGTH * i, 0))
    # Leaf springs and a wire have sections of two kinds, stacked apart; the order of addition is another one.
    for name, p, t in (("first", 0, thicknesses[0]), ("second", 1, thicknesses[1])):
        b.add(planar.beam, f"n{p}", f"n{p + 1}", name=name, section=fm.Rectangle(0.01, t, STEEL))
    b.add(planar.beam, "n2", "n3", name="wire", section=fm.Circle(diameter, STEEL))
    b.add(planar.beam, "n3", "n4", name="third", section=fm.Rectangle(0.01, thicknesses[2], STEEL))
    b.add(planar.hinge, "n0", "n4", name="spring", stiffness=stiffness)
    b.fix("n0")
    b.force("n4", (0.0, -1.0))
    return b.build()


@pytest.fixture(scope="module")
def model():
    return row()


def test_the_model_is_that_of_a_build_with_these_numbers(model):
    changed = model.with_property("section.thickness", THICKNESSES).with_property("section.diameter", 3e-3)
    changed = changed.with_property("stiffness", [20.0], ["spring"])
    ours, built = (jax.tree.leaves(m.parameters) for m in (changed, row(THICKNESSES, 3e-3, 20.0)))
    for one, other in zip(ours, built, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.slow
def test_elements_that_are_named_alone_are_changed_in_their_order(model):
    changed = model.with_property("section.thickness", [0.7e-3, 0.5e-3], ["third", "first"])
    built = row((0.5e-3, 1e-3, 0.7e-3))
    for one, other in zip(jax.tree.leaves(changed), jax.tree.leaves(built), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.slow
def test_one_number_of_jax_is_that_of_all(model):
    def first(thickness):
        changed = model.with_property("section.thickness", thickness)
        return sum(jnp.sum(leaf) for leaf in jax.tree.leaves(changed.parameters.properties))

    assert float(jax.grad(first)(jnp.asarray(1e-3))) == 3.0


@pytest.mark.slow
def test_its_derivative_is_that_of_the_closed_form():
    """A cantilever of two leaf springs under a small force at its tip, where δ = F ∫ s²/EI ds."""
    b = fm.Builder()
    for i in range(3):
        b.node(f"n{i}", (LENGTH * i, 0))
    for i in range(2):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rectangle(0.01, 1e-3, STEEL))
    b.fix("n0")
    b.force("n2", (0.0, 1e-4))
    model = b.build(check=False)
    start = np.array([1e-3, 0.8e-3])

    def tip(thickness):
        return fm.equilibrium(model.with_property("section.thickness", thickness), sparse=True).at("n2")[1]

    bending = STEEL.E * 0.01 * start**3 / 12
    exact = -3 / start * 1e-4 / bending * np.array([7.0, 1.0]) * LENGTH**3 / 3
    # Beyond: the square of the tip's slope, 1e-5.
    np.testing.assert_allclose(jax.grad(tip)(jnp.asarray(start)), exact, rtol=1e-6)


@pytest.mark.slow
def test_what_is_refused(model):
    for path, values, elements, told in (
        ("section.thicknes", 1e-3, None, "No element of this model has a property 'section.thicknes'"),
        ("section.material", 1e-3, None, "that is one number"),
        (3, 1e-3, None, "Argument `path` must name a property"),
        ("section.thickness", [1e-3, 1e-3], None, r"\(3,\)"),
        ("section.thickness", "thin", None, "numbers"),
        ("section.thickness", [1e-3, np.nan, 1e-3], None, "finite"),
        ("section.thickness", [1e-3, -1e-3, 1e-3], None, "thickness = .* must be positive"),
        ("section.thickness", 1e-3, ["wire"], "Element 'wire' has no property 'section.thickness'"),
        ("section.thickness", 1e-3, ["first", "first"], "names an element twice"),
    ):
        with pytest.raises(fm.ModelError, match=told):
            model.with_property(path, values, elements)
