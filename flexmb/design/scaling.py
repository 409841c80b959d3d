"""Dimensions between their bounds as numbers from 0 to 1, logarithmic or linear."""

from collections.abc import Mapping
from typing import Any

import jax.numpy as jnp
import numpy as np

from ..errors import printable
from .designs import checked_bounds
from .evaluate import Layout


class Scaling:
    """Dimensions between their bounds as numbers from 0 to 1, logarithmic or linear."""

    def __init__(self, layout: Layout, bounds: Mapping[str, Any], scales: Mapping[str, str]):
        """Check and keep the bounds."""
        for kind, by_name in (("Bounds", bounds), ("Scale", scales)):
            for name in by_name:
                if name not in layout.names:
                    listed = ", ".join(layout.names)
                    raise ValueError(f"{kind} of '{printable(name)}': there is no such dimension ({listed}).")
        for name in layout.names:
            if name not in bounds:
                raise ValueError(f"Dimension '{name}' has no bounds. Give lower and upper, or fix it in `build`.")
        pairs = {name: checked_bounds(name, bounds[name]) for name in layout.names}
        logarithmic = {}
        for name, (lower, _) in pairs.items():
            scale = scales.get(name, "log" if np.all(lower > 0) else "linear")
            if scale not in ("log", "linear"):
                raise ValueError(f"Scale of '{name}' must be 'log' or 'linear', but is {printable(repr(scale))}.")
            if scale == "log" and not np.all(lower > 0):
                raise ValueError(f"Scale of '{name}' cannot be 'log', since its lower bound {lower} is not positive.")
            logarithmic[name] = scale == "log"
        self.layout = layout
        self.lower = layout.join({name: lower for name, (lower, _) in pairs.items()})
        self.upper = layout.join({name: upper for name, (_, upper) in pairs.items()})
        self.log = layout.join(logarithmic) > 0

    def check_inside(self, flat: np.ndarray) -> None:
        """Refuse a start outside the bounds."""
        for name, value, lower, upper in zip(self.layout.labels, flat, self.lower, self.upper, strict=True):
            if not lower <= value <= upper:
                raise ValueError(f"Start {value:g} of '{name}' is outside its bounds, {lower:g} to {upper:g}.")

    def to_unit(self, flat: np.ndarray) -> np.ndarray:
        """Numbers from 0 to 1, (n,), of dimensions, (n,)."""
        linear = (flat - self.lower) / (self.upper - self.lower)
        pairs = (flat, 1.0), (self.lower, 1.0), (self.upper, np.e)
        value, lower, upper = (np.where(self.log, number, other) for number, other in pairs)
        return np.clip(np.where(self.log, np.log(value / lower) / np.log(upper / lower), linear), 0.0, 1.0)

    def to_dimensions(self, unit: Any) -> Any:
        """Dimensions, (n,), of numbers from 0 to 1, (n,), which may be traced."""
        ratio = np.where(self.log, self.upper / np.where(self.log, self.lower, 1.0), 1.0)
        linear = self.lower + unit * (self.upper - self.lower)
        if isinstance(unit, np.ndarray):
            dimensions = np.where(self.log, self.lower * np.exp(unit * np.log(ratio)), linear)
            return np.clip(dimensions, self.lower, self.upper)
        return jnp.where(self.log, self.lower * jnp.exp(unit * np.log(ratio)), linear)

    def slopes(self, unit: np.ndarray) -> np.ndarray:
        """Derivatives of the dimensions by their numbers from 0 to 1, (n,) [SI]."""
        ratio = np.log(np.where(self.log, self.upper / np.where(self.log, self.lower, 1.0), 1.0))
        return np.where(self.log, self.to_dimensions(unit) * ratio, self.upper - self.lower)
