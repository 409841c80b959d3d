"""Base class of modes of vibration and of buckling: motions about a linearised state."""

from typing import Any

from jaxtyping import Array, Float

from ..model.by_name import ByName, node_motions
from ..model.model import Labels
from .linearize import AboutState


class Shapes(ByName, AboutState):
    """Base class of modes, asked by name as the state that they are about.

    Attributes:
        shapes: Modes in the coordinates, one a column, (n_x, n).
        lin: Linearization that they belong to.
    """

    shapes: Float[Array, "n_x n"]
    lin: Any

    @property
    def matrices(self) -> Any:
        """Linearised equations of the state."""
        return self.lin.matrices

    @property
    def labels(self) -> Labels:
        """Names."""
        return self.lin.labels

    def shape(self, node: str, component: str | None = None) -> Float[Array, "modes n"]:
        """Return the motion of a node in each mode.

        Args:
            node: Name of the node, or "name.rotation" for its rotation alone.
            component: One component: "x", "y", "z", "phi", "rx", "ry" or "rz".

        Returns:
            Displacements, then rotations about global axes if the node has a rotation, (modes, n), or (modes,) for one
                component. Modes of vibration [1/sqrt(kg), rad/(m sqrt(kg))], of buckling [-].
        """
        return node_motions(self.labels, self.lin.x, self.shapes, node, component)
