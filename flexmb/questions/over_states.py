"""Answers of all states of a path or a motion."""

from typing import Any

from ..linear.linearize import ManyStates
from .question import Asked, Series


class Along(ManyStates):
    """Base class of a path and a motion."""

    def along(self: Any, text: str) -> Series:
        """Return one quantity in every state, by its name.

        - Node: "top.x", or "top.phi" for an angle (in space "top.rx"). "displacement top.x" counts from the undeformed
          mechanism; "displacement" is the largest displacement of all nodes. "force top.x" is ``force_needed``,
          "reaction foot.x" the force of a support. "stiffness top.y" has all other motions free.
        - Element: "deformation leaf.2", "stress resultant leaf.2"; "stress leaf", the largest von Mises stress.
        - Whole mechanism: "frequency 1", "mass"; "stress", the largest von Mises stress; "utilisation", the largest
          ratio of this stress to the strength.
        - Path only: "load factor", and "multiplier 1", the first load multiplier of buckling.
        - Motion only: "time", "velocity top.x", "acceleration top.x"; "kinetic", "elastic", "potential", and their sum
          "energy".

        Each file of ``flexmb/questions`` adds its questions.

        Raises:
            KeyError: There is no such quantity, node, element or component.
        """
        return Asked(text).along(self)
