"""Documents built: equal to what the same calls of the Builder give."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import documents, mechanisms
from cases.tolerances import approx

import flexmb as fm
from flexmb.workbench.building import build, free_names, numeric_values, positions, structure
from flexmb.workbench.document import apply


def frequency(model):
    return float(fm.frequencies(model)[0])


def test_the_planar_guide_as_a_document_is_that_of_the_builder():
    built = build(documents.planar_guide())
    assert (built.problems, built.skipped) == ([], [])
    actual = frequency(built.model())
    assert actual == approx(10.6448474, rel=1e-8)
    assert actual == approx(frequency(mechanisms.planar_guide().build()), rel=1e-13)


def test_the_spatial_guide_as_a_document_is_that_of_the_builder():
    built = build(documents.spatial_guide())
    assert (built.problems, built.skipped) == ([], [])
    theirs = mechanisms.spatial_guide(extra=(6,)).build()
    assert frequency(built.model()) == approx(frequency(theirs), rel=1e-13)


@pytest.mark.slow
def test_derivatives_by_fields_and_by_names_agree_with_differences():
    document = documents.planar_guide()
    model = build(document).model()
    numbers = numeric_values(document)
    assert numbers["names/t/value"] == numbers["2/thickness"] == 0.5e-3

    def of_fields(numbers):
        return fm.frequencies(build(document, numbers).model(like=model))[0]

    def of_names(names):
        return of_fields(numeric_values(document, names))

    slope = jax.jit(jax.grad(of_fields))(numbers)
    by_name = jax.grad(of_names)({"t": 0.5e-3, "L": 0.1, "d": 0.1})
    # The frequency goes as t^(3/2), but for the mass of the leaf springs.
    f = float(of_fields(numbers))
    assert float(by_name["t"]) * 0.5e-3 / f == approx(1.5, abs=0.02)
    assert float(slope["2/thickness"]) == approx(float(by_name["t"]), rel=1e-12)
    h = 1e-9
    up, down = ({**numbers, "2/thickness": jnp.asarray(0.5e-3 + s)} for s in (h, -h))
    assert float(slope["2/thickness"]) == approx(float(of_fields(up) - of_fields(down)) / (2 * h), rel=1e-6)
    assert np.isfinite(list(map(float, slope.values()))).all()
    assert free_names(document) == ["t", "L", "d"]
    assert positions(document)["right1"] == [0.1, 0.1]


def test_structure_differs_where_the_compiled_function_does_and_not_by_numbers():
    document = documents.planar_guide()
    known = structure(document)

    def after(*ops, **options):
        return structure(apply(document, list(ops))[0], **options)

    assert after({"op": "name", "name": "t", "to": {"value": "0.6e-3"}}) == known
    assert after({"op": "set", "address": "3/position/0", "to": "0.01"}) == known
    assert after({"op": "set", "address": "3/position/0", "to": "t"}) != known
    plain = structure(document, arithmetic=False)
    assert after({"op": "set", "address": "3/position/0", "to": "t"}, arithmetic=False) == plain
    for change in (
        {"op": "set", "address": "5/released", "to": "1 2 3"},
        {"op": "set", "address": "2/rotary", "to": "true"},
        {"op": "set", "address": "12/inertia", "to": ["1e-3"]},
        {"op": "set", "address": "3/position/0", "to": "nothing"},
        {"op": "delete", "ids": ["14"]},
        {"op": "rename", "id": "3", "to": "foot"},
        {"op": "order", "id": "3", "before": None},
    ):
        assert after(change, arithmetic=False) != plain, change


@pytest.mark.slow
def test_a_block_of_leaf_springs_is_differentiated_by_its_sizes():
    document = documents.drawn(
        2,
        {"t": "0.5e-3", "h": "0.1"},
        [
            ("Material", "steel", documents.STEEL),
            ("Rectangle", "leaf", documents.leaf_args()),
            ("node", "A", {"position": ["0", "0"]}),
            ("fix", None, {"node": "A"}),
            (
                "blocks.parallel_guide",
                "guide",
                {"base": "A", "stage": "S", "section": "leaf", "length": "h", "spacing": "h/2"},
            ),
            ("mass", None, {"node": "S", "mass": "0.2", "inertia": "1e-4"}),
        ],
    )
    built = build(document)
    assert built.problems == []
    model = built.model()

    def first(names):
        return fm.frequencies(build(document, numeric_values(document, names)).model(like=model))[0]

    slopes = jax.grad(first)({"t": 0.5e-3, "h": 0.1})
    for name, start in (("t", 0.5e-3), ("h", 0.1)):
        step = 1e-5 * start
        up, down = (
            frequency(
                build(apply(document, [{"op": "name", "name": name, "to": {"value": repr(start + s)}}])[0]).model()
            )
            for s in (step, -step)
        )
        assert float(slopes[name]) == approx((up - down) / (2 * step), rel=1e-6)


@pytest.mark.slow
def test_what_is_done_to_a_builder_is_not_seen_by_the_next_who_asks():
    document = documents.planar_guide()
    build(document).builder.force("left1", (1.0, 0.0))
    assert build(document).builder.loads["initial"] == {}
