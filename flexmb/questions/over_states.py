"""Answers of all states of a path or a motion."""

from typing import Any

from ..linear.linearize import ManyStates
from .question import Asked, Series


class Along(ManyStates):
    """Base class of a path and a motion."""

    def along(self: Any, text: str) -> Series:
        """One quantity in every state, asked for by name.

        "top.x", "displacement top.x" (from the undeformed mechanism), "top.phi" (an angle; in space "top.rx");
        "displacement" (the largest); "force top.x" (see ``force_needed``), "reaction foot.x"; "deformation leaf.2",
        "stress resultant leaf.2"; "stress" (largest von Mises stress), "stress leaf", "utilisation" (over the
        strength); "frequency 1", "stiffness top.y" (of all else free to follow), "mass"; "load factor", "multiplier 1"
        (of buckling) of a path; "time", "velocity top.x", "acceleration top.x", "kinetic", "elastic", "potential",
        "energy" (their sum) of a motion. Each file of ``flexmb/questions`` adds its own.

        Raises:
            KeyError: There is no such quantity, node, element or component.
        """
        return Asked(text).along(self)
