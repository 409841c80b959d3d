"""The catalogue covers what the Builder, the elements, sections, materials and blocks offer, and builds it."""

import inspect
import json

import pytest

from flexmb import blocks, materials, planar, sections, spatial
from flexmb.build.builder import Builder
from flexmb.workbench.fields import calls, catalogue

KINDS = {
    *("number", "vector", "node", "nodes", "element", "of", "section", "sections", "material", "damping"),
    *("components", "deformations", "weights", "choice", "flag", "text"),
}
GROUPS = {"node", "element", "section", "material", "support", "load", "mass", "signal", "freedom", "block"}
# What needs a function of the user's own is said in Python alone; and what is no section by itself.
WITHOUT = {"spring_damper", "rotary_spring_damper", "pin_body"}
NO_CALLS = {"Profile", "Section", "MaterialDamping", "torsion_approximate", "torsion_series", "warping_factor"}
NO_CALLS |= {"curvature_along", "curvature_through", "root_stiffness"}


def test_every_method_element_section_material_and_block_is_a_call():
    found = set(catalogue())
    methods = {n for n, f in inspect.getmembers(Builder, inspect.isfunction) if not n.startswith("_")}
    assert methods - {"add", "build", "copy", "with_dofs"} <= found
    for room, name in ((planar, "planar"), (spatial, "spatial")):
        assert {f"{name}.{one}" for one in set(room.__all__) - WITHOUT} <= found
    assert {"Material" if one == "Material" else one for one in set(sections.__all__) - NO_CALLS} <= found
    assert {f"materials.{one}" for one in materials.__all__} <= found
    assert {f"blocks.{one}" for one in dir(blocks)} <= found


@pytest.mark.parametrize("name", catalogue())
def test_each_field_is_of_a_known_kind_and_each_call_in_a_group(name):
    entry = catalogue()[name]
    json.dumps(entry, allow_nan=False)
    assert entry["group"] in GROUPS
    assert entry["title"]
    assert entry["doc"]
    for field in entry["fields"]:
        assert field["kind"] in KINDS, field
        assert (field["kind"] == "choice") == bool(field["choices"]), field
        assert (field["kind"] == "vector") == isinstance(field["count"], dict), field


def test_each_argument_of_a_call_is_a_field():
    for name, call in calls().items():
        if call.kind not in ("method", "block"):
            continue
        # Numbers by name stand in the fields of those by place.
        parameters = inspect.signature(call.function).parameters
        given = {n for n, p in parameters.items() if p.kind is not p.VAR_KEYWORD} - {"self", "b", "name"}
        assert given == set(call.fields), name
        docs = [field["name"] for field in call.entry["fields"] if not field["doc"]]
        assert not docs, (name, docs)


@pytest.mark.slow
def test_fields_are_what_signatures_say():
    found = {name: call.fields for name, call in calls().items()}
    assert found["Rectangle"]["thickness"]["unit"] == "m"
    assert found["Rectangle"]["torsion"]["choices"] == ["series", "approximate"]
    assert found["Rectangle"]["clamped_ends"]["whole"]
    assert found["spatial.beam"]["y"]["count"]["3"] == 3
    assert found["planar.leaf_spring"]["section"]["optional"] is False
    assert found["planar.leaf_spring"]["order"]["default"] == "6"
    assert found["planar.gear"]["ratio"]["optional"] is False
    assert found["blocks.cross_pivot"]["half_angle"]["unit"] == "rad"
    assert found["blocks.cross_pivot"]["section"]["kind"] == "section"
    assert found["blocks.cross_pivot"]["stage"]["new"]
    assert "spatial.leaf_spring" in found["blocks.cross_pivot"]["element"]["choices"]
    assert found["mass"]["inertia"]["count"] == {"2": 1, "3": 6}
    assert found["taper"]["first"]["kind"] == "section"
    assert found["damping_from_ratio"]["ratio"]["kind"] == "number"
    assert calls()["damping_from_ratio"].makes == "damping"
