"""The three forms of the equations of motion have what the protocol declares; pyright sees that no more is used."""

import inspect

import pytest

from flexmb.motion.controlled_form import ControlledForm
from flexmb.motion.coordinates_form import CoordinatesForm
from flexmb.motion.protocol import Equations
from flexmb.motion.reduced_form import ReducedForm

FORMS: list[type[Equations]] = [CoordinatesForm, ReducedForm, ControlledForm]


@pytest.mark.parametrize("form", FORMS)
def test_a_form_takes_the_arguments_that_are_declared(form):
    """For methods that are compiled too, whose arguments a type checker does not see."""
    members = [name for name in dir(Equations) if not name.startswith("_")]
    assert len(members) >= 10
    for name in members:
        declared, own = getattr(Equations, name), getattr(form, name)
        assert isinstance(own, property) == isinstance(declared, property), name
        if not isinstance(declared, property):
            assert list(inspect.signature(own).parameters) == list(inspect.signature(declared).parameters), name
