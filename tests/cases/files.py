"""What tests read back."""

import os
from typing import Any

import numpy as np


def arrays_of(path: str | os.PathLike) -> dict[str, Any]:
    """What a .npz file holds; the file is closed."""
    with np.load(path) as file:
        return dict(file)
