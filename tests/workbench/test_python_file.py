"""Documents as Python: the script builds the same model, with the names as parameters."""

import ast

import numpy as np
import pytest

import flexmb as fm
from flexmb.mechanisms import mechanism_path
from flexmb.workbench.building import build
from flexmb.workbench.document import Document, apply
from flexmb.workbench.from_builder import document_of
from flexmb.workbench.python_file import python_of

from ..cases import documents
from .test_from_builder import SHIPPED, check_same_contents, everything


def function_of(script: str):
    """The function of a script, which ends by building its model; here it returns the Builder."""
    tree = ast.parse(script)
    (found,) = [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
    space = {"__name__": "script"}
    exec(script.replace(".build()\n\n\nif __name__", "\n\n\nif __name__"), space)
    return space[found]


@pytest.mark.parametrize("drawn", [documents.planar_guide, documents.spatial_guide])
def test_script_builds_the_same_model(drawn):
    document = drawn()
    script = python_of(document)
    builder = build(document).builder
    check_same_contents(function_of(script)(), builder)
    space = {"__name__": "script"}
    exec(script, space)
    model = space["mechanism"]()
    np.testing.assert_allclose(fm.frequencies(model), fm.frequencies(builder.build()), rtol=1e-12)
    # Its parameters are the names.
    given = {name: 1.1 * float(own["value"]) for name, own in document.names.items() if name == "t"}
    other = apply(document, [{"op": "set", "address": "names/t/value", "to": repr(given["t"])}])[0]
    found = fm.frequencies(space["mechanism"](**given))
    np.testing.assert_allclose(found, fm.frequencies(build(other).builder.build()), rtol=1e-12)
    assert abs(found[0] / fm.frequencies(model)[0] - 1) > 0.1


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_mechanism(name):
    document, _ = document_of(fm.read_spacar(mechanism_path(name)))
    check_same_contents(function_of(python_of(document))(), build(document).builder)


def test_every_feature_in_space():
    document, _ = document_of(everything(fm.Builder()))
    check_same_contents(function_of(python_of(document))(), build(document).builder)


@pytest.mark.slow
def test_building_blocks_and_derived_names():
    document = documents.drawn(
        2,
        {"t": "0.2e-3", "b": "10*t*2", "lambda": "007", "third": "b/lambda"},
        [
            ("materials.stainless_301", "steel <b>", {}),
            ("Rectangle", "leaf", {"width": "b*2", "thickness": "t", "material": "steel <b>"}),
            ("node", "ground", {"position": ["0", "0"]}),
            ("fix", None, {"node": "ground"}),
            (
                "blocks.parallel_guide",
                'a "guide"',
                {"base": "ground", "stage": "table", "length": "0.05", "spacing": "0.03", "section": "leaf"},
            ),
            ("mass", None, {"node": "table", "mass": "third"}),
            ("start", None, {"of": "table", "component": "x", "value": "1e-3"}),
        ],
    )
    script = python_of(document)
    assert "def mechanism(t=0.2e-3, lambda_=7):" in script
    assert "b_ = 10*t*2\n" in script or "b = 10*t*2\n" in script
    check_same_contents(function_of(script)(), build(document).builder)


@pytest.mark.slow
def test_what_cannot_be_built_stands_in_a_comment_and_nothing_is_run():
    evil = 'x"""\nimport os; os.abort()\n"""'
    data = documents.planar_guide().data
    things = [
        *data["things"],
        {"id": "90", "call": "mass", "args": {"node": "nowhere\nraise SystemExit", "mass": "1"}},
        {"id": "91", "call": "mass", "args": {"node": "left1", "mass": "__import__('os').abort()"}},
        {"id": "92", "call": "nothing\nraise SystemExit", "args": {}},
        {"id": "93", "call": "input", "name": 'a"); raise SystemExit #', "args": {"of": "left1", "component": "x"}},
    ]
    document = Document.from_data({**data, "title": evil, "things": things, "next": 100})
    script = python_of(document)
    assert script.count("# Left out: ") == 3
    assert all(len(line) < 300 for line in script.splitlines())
    builder = function_of(script)()
    assert [signal.name for signal in builder.signals["input"]][-1] == 'a"); raise SystemExit #'
    check_same_contents(builder, build(document).builder)
