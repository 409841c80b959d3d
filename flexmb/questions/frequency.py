"""Natural frequencies by their number: "frequency 1"."""

from typing import Any

import jax.numpy as jnp
import numpy as np

from ..linear.linearize import Matrices
from ..linear.modes import frequencies, refuse_unsymmetric
from ..linear.sparse_solve import lowest_values
from ..linear.spectrum import general_spectrum, is_real, to_frequency
from ..mechanics.loads import lacks_potential
from ..results import RESULTS
from .question import Question, each_linearization, finite_or_nan, is_many, is_number, numbered


def _frequency(state: Any, rest: str) -> Any:
    if not is_many(state):
        count = int(rest) if is_number(rest) else 1
        return numbered(frequencies(state, count=count), "frequency", rest)
    if state.by_sparse and is_number(rest):
        refuse_unsymmetric(not lacks_potential(state.model.topology))
        lowest = [lowest_values(lin.elements, int(rest)) for lin in each_linearization(state)]
        values = to_frequency(jnp.stack(lowest))
    elif state.states().kind == "path":
        values = state.frequencies
    else:
        values = frequencies_along(state.linearizations().matrices)
    return finite_or_nan(numbered(np.asarray(values), "frequency", rest))


def frequencies_along(m: Matrices) -> np.ndarray:
    """Frequencies of K0 + N0 + G0 and M0 in every state, ascending, (states, n_q) [Hz].

    NaN where they are complex, and where the degrees of freedom do not determine the state.
    """
    mass, stiffness = np.asarray(m.M0), np.asarray(m.K)
    rows = np.full(mass.shape[:2], np.nan)
    for i in np.flatnonzero(np.asarray(m.result) == int(RESULTS.successful.value)):
        values, _ = general_spectrum(stiffness[i], mass[i])
        rows[i] = np.sort(to_frequency(np.where(is_real(values), values.real, np.nan)))
    return rows


QUESTIONS = (Question("frequency", ("number",), _frequency, "Hz", of_many=True),)
