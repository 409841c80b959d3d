"""Curves as targets: values of an answer along a stroke or another axis."""

import dataclasses
from typing import Any

import numpy as np

from .designs import float_array


@dataclasses.dataclass(frozen=True, eq=False)
class Curve:
    """Target values of an answer along an axis, for ``fm.tune``.

    Differences are relative to the largest value of the curve. In a target that is an array, each difference is
    relative to its own target value. Forces near zero would then have the largest weight.

    Attributes:
        over: Places: strokes, times, load factors, (n,) [their unit].
        values: Target values there, (n,) [unit of the answer].
        label: Label of the places in a picture, such as "stroke [m]".
    """

    over: np.ndarray
    values: np.ndarray
    label: str

    def __init__(self, over: Any, values: Any, label: str = ""):
        """Keep two lists of one length.

        Args:
            over: Places, (n,) [any].
            values: Target values there, (n,), or one number for all [unit of the answer].
            label: Label of the places in a picture, such as "stroke [m]".

        Raises:
            ValueError: Numbers are not finite, or the lengths differ.
        """
        where, curve_values = (
            float_array("The places of a curve", over),
            float_array("The values of a curve", values),
        )
        if where.ndim != 1 or not len(where) or curve_values.shape not in ((), where.shape):
            shapes = f"{where.shape} places and {curve_values.shape} values"
            raise ValueError(f"A curve has {shapes}. Give one value for each place.")
        if not (np.all(np.isfinite(where)) and np.all(np.isfinite(curve_values))):
            raise ValueError("The places and values of a curve must be finite.")
        object.__setattr__(self, "over", where)
        object.__setattr__(self, "values", np.broadcast_to(curve_values, where.shape))
        object.__setattr__(self, "label", str(label))
