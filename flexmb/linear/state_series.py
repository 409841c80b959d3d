"""One quantity in every state of a path or a motion, with its unit."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float


class Series(NamedTuple):
    """One quantity in every state of a path or a motion.

    Attributes:
        values: Its values, (states,).
        label: Its name.
        unit: Its unit, such as "N".
        of: Kind of the question: "coordinate", "force", "frequency", "energy", ..
    """

    values: Float[np.ndarray, "states"]
    label: str
    unit: str
    of: str

    @property
    def axis(self) -> str:
        """Label of an axis of a picture, with the unit."""
        return f"{self.label} [{self.unit}]"
