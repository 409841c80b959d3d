"""Natural frequencies by their number: "frequency 1"."""

from typing import Any

import jax.numpy as jnp
import numpy as np

from ..linear.linearize import Matrices
from ..linear.modes import frequencies, refuse_unsymmetric
from ..linear.sparse_solve import lowest_values
from ..linear.spectrum import real_frequencies, to_frequency
from ..mechanics.loads import lacks_potential
from ..results import RESULTS
from ..statics.solver_choice import up_to
from .question import Question, each_linearization, finite_or_nan, is_index, is_many, model_of, number_along_axis


def _frequency(state: Any, argument: str) -> Any:
    if not is_many(state):
        count = up_to(int(argument), model_of(state)) if is_index(argument) else 1
        return number_along_axis(frequencies(state, count=count), "frequency", argument)
    if state.by_sparse and is_index(argument):
        refuse_unsymmetric(not lacks_potential(state.model.topology))
        lowest = [lowest_values(lin.elements, int(argument)) for lin in each_linearization(state)]
        values = to_frequency(jnp.stack(lowest))
    elif state.states().kind == "path":
        values = state.frequencies
    else:
        values = frequencies_along(state.linearizations().matrices)
    return finite_or_nan(number_along_axis(np.asarray(values), "frequency", argument))


def frequencies_along(m: Matrices) -> np.ndarray:
    """Frequencies of K0 + N0 + G0 and M0 in every state, ascending, (states, n_q) [Hz].

    NaN where they are complex, and where the degrees of freedom do not determine the state.
    """
    mass, stiffness = np.asarray(m.M0), np.asarray(m.K)
    rows = np.full(mass.shape[:2], np.nan)
    for i in np.flatnonzero(np.asarray(m.result) == int(RESULTS.successful.value)):
        rows[i] = real_frequencies(stiffness[i], mass[i])
    return rows


QUESTIONS = (Question("frequency", ("number",), _frequency, "Hz", of_many=True),)
