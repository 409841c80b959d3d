"""Differentiable analysis of flexible multibody mechanisms.

Names are loaded on first use, so that the import is quick; ``__init__.pyi`` lists them. Names of rooms, such as
``fm.design.monte_carlo``, are available as ``fm.monte_carlo`` too.
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
