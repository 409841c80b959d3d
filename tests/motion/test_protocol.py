"""The three forms of the equations of motion have what the protocol declares; pyright sees that no more is used."""

import inspect

import pytest

from flexmb.motion.controlled_form import ControlledForm
from flexmb.motion.coordinates_form import CoordinatesForm
from flexmb.motion.protocol import EnergyEquations, Equations
from flexmb.motion.reduced_form import ReducedForm

FORMS: list[type[Equations]] = [CoordinatesForm, ReducedForm, ControlledForm]
FORMS_OF_ENERGY: list[type[EnergyEquations]] = [CoordinatesForm]
PAIRS = [(form, Equations) for form in FORMS] + [(form, EnergyEquations) for form in FORMS_OF_ENERGY]


@pytest.mark.slow("CoordinatesForm-EnergyEquations")
@pytest.mark.parametrize(("form", "protocol"), PAIRS, ids=lambda kind: kind.__name__)
def test_a_form_takes_the_arguments_that_are_declared(form, protocol):
    """For methods that are compiled too, whose arguments a type checker does not see."""
    members = [name for name in dir(protocol) if not name.startswith("_")]
    assert len(members) >= 10
    for name in members:
        declared, own = getattr(protocol, name), getattr(form, name)
        assert isinstance(own, property) == isinstance(declared, property), name
        if not isinstance(declared, property):
            assert list(inspect.signature(own).parameters) == list(inspect.signature(declared).parameters), name
