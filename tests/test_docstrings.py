"""Public functions and classes say what goes in and out, with shapes and units, and where equations come from."""

import dataclasses
import inspect
import re
from importlib import import_module
from pathlib import Path

import pytest

import flexmb
from flexmb import plot
from flexmb.lazy import offered

ROOMS = sorted(stub.parent.name for stub in Path(flexmb.__file__).parent.glob("*/__init__.pyi"))
PLACES = [flexmb, *(import_module(f"flexmb.{room}") for room in ROOMS)]
PUBLIC = {name: getattr(place, name) for place in PLACES for name in sorted(offered(place.__name__))}
PLOTS = {f"plot.{name}": getattr(plot, name) for name in dir(plot)}
FUNCTIONS = {name: f for name, f in PUBLIC.items() if inspect.isfunction(f)} | PLOTS
CLASSES = {name: c for name, c in PUBLIC.items() if inspect.isclass(c)}
METHODS = {
    f"{name}.{method}": f
    for name, c in CLASSES.items()
    for method, f in vars(c).items()
    if inspect.isfunction(f) and not method.startswith("_") and c.__module__.startswith("flexmb")
}
# They set up a process, wrap a user's function or read what a user wrote; nothing in them is an equation.
WITHOUT_EQUATION = {"save_motion", "enable_x64", "enable_cache", "jit", "read_spacar", "write_spacar"}
WITHOUT_EQUATION |= {"spacar_light", "spacar_light_model", "edit", "measured"}
# Pictures show what has been computed.
WITHOUT_EQUATION |= {*PLOTS, "view", "edit"}


def section(text: str, title: str) -> str:
    found = re.search(rf"^{title}:\n((?:[ ]+.*\n|\n)*)", inspect.cleandoc(text) + "\n", re.M)
    return found.group(1) if found else ""


@pytest.mark.parametrize("name", FUNCTIONS | METHODS)
def test_every_argument_is_documented(name):
    function = (FUNCTIONS | METHODS)[name]
    text = function.__doc__ or ""
    assert text, f"{name} has no docstring"
    documented = section(text, "Args")
    for argument in inspect.signature(function).parameters:
        if argument not in ("self", "cls"):
            assert re.search(rf"\b{argument}\b.*:", documented), f"{name} does not document '{argument}'"


@pytest.mark.parametrize("name", CLASSES)
def test_every_field_is_documented(name):
    cls = CLASSES[name]
    assert cls.__doc__, f"{name} has no docstring"
    if dataclasses.is_dataclass(cls):
        documented = section(cls.__doc__, "Attributes")
        for field in dataclasses.fields(cls):
            assert re.search(rf"\b{field.name}\b.*:", documented), f"{name} does not document '{field.name}'"


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_answer_says_its_source(name):
    if name not in WITHOUT_EQUATION:
        assert section(FUNCTIONS[name].__doc__ or "", "Source"), f"{name} does not say where its equations come from"


@pytest.mark.slow("plot.verdict")
@pytest.mark.parametrize("name", FUNCTIONS)
def test_arrays_have_shape_and_unit(name):
    function = FUNCTIONS[name]
    returned = str(inspect.signature(function).return_annotation)
    if any(word in returned for word in ("Array", "ndarray")):
        text = section(function.__doc__ or "", "Returns")
        assert re.search(r"\(.*,?.*\)", text), f"{name} does not give the shape of what it returns"
        assert re.search(r"\[.+\]", text), f"{name} does not give the unit of what it returns"
