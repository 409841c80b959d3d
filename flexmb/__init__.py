"""Differentiable analysis of flexible multibody mechanisms.

Names are loaded on first use, so that importing the package costs nothing; ``__init__.pyi`` is the list of them. What
rooms offer, such as ``fm.design.monte_carlo``, answers as ``fm.monte_carlo`` too.
"""

from .lazy import names

__version__ = "0.1.0"

__getattr__, __dir__ = names(
    __name__,
    *(
        "elements",
        "checks",
        "statics",
        "linear",
        "paths",
        "motion",
        "control",
        "trajectory",
        "spacar",
        "design",
        "identification",
        "blocks",
        "viewer",
        "workbench",
    ),
)
