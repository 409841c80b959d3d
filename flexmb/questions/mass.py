"""Mass of the whole mechanism: "mass"."""

from jaxtyping import Array, Float

from ..compilation.compile import unguarded
from ..mechanics.inertia import total_mass
from ..mechanics.prepared import kernel
from ..model.model import Model, as_model
from .question import Question, model_of

# One compiled program takes a third of the time of single operations, also at first.
_mass = kernel(total_mass)


@unguarded
def mass(model: Model) -> Float[Array, ""]:
    """Return the mass of the whole mechanism, including distributed mass.

    Args:
        model: Mechanism; differentiable in ``model.parameters``.

    Returns:
        () [kg].

    Source:
        Twice the kinetic energy of a uniform unit velocity.
    """
    return _mass(as_model(model, "mass").topology, model.parameters)


QUESTIONS = (Question("mass", (), lambda state, _: mass(model_of(state)), "kg"),)
