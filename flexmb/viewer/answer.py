"""The page of an answer of the command line."""

from typing import Any

from .view import view


def page(answer: Any) -> bytes:
    """Modes, path, motion or self-stress of an answer; its equilibrium or mechanism where it has no other."""
    return view(answer.shown).html().encode()
