"""A whole curve as a target: values that an answer should have along a stroke or another axis."""

import dataclasses
from typing import Any

import numpy as np

from .designs import numbers


@dataclasses.dataclass(frozen=True, eq=False)
class Curve:
    """Values that an answer should come near to, as a target of ``fm.tune``.

    An array as a target counts each difference relative to its own value, so that a force near zero would weigh most;
    of a curve all count relative to its largest value.

    Attributes:
        over: Where: strokes, times, load factors, (n,) [their unit].
        values: What the answer should be there, (n,) [unit of the answer].
        label: What a picture writes below the places, such as "stroke [m]".
    """

    over: np.ndarray
    values: np.ndarray
    label: str

    def __init__(self, over: Any, values: Any, label: str = ""):
        """Keep two lists of one length.

        Args:
            over: Where, (n,) [any].
            values: What the answer should be there, (n,), or one number for all [unit of the answer].
            label: What a picture writes below the places, such as "stroke [m]".

        Raises:
            ValueError: They are no finite numbers, or their lengths differ.
        """
        where, wanted = numbers("The places of a curve", over), numbers("The values of a curve", values)
        if where.ndim != 1 or not len(where) or wanted.shape not in ((), where.shape):
            raise ValueError(
                f"A curve has one value for each of its places, but {where.shape} places and {wanted.shape} values are"
                " given."
            )
        if not (np.all(np.isfinite(where)) and np.all(np.isfinite(wanted))):
            raise ValueError("The places and values of a curve must be finite.")
        object.__setattr__(self, "over", where)
        object.__setattr__(self, "values", np.broadcast_to(wanted, where.shape))
        object.__setattr__(self, "label", str(label))
