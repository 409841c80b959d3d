"""Whether motions about a state grow, where its stiffness is unsymmetric so that its sign does not tell."""

from typing import Any

import numpy as np

from .spectrum import general_spectrum, is_real, poles_of

# A pole grows whose real part is above this share of its size, unless that is round-off beside the largest.
GROWS, NOTHING = 1e-9, 1e-12


def without_growth(k: np.ndarray, c: np.ndarray, m: np.ndarray) -> bool:
    """Whether no motion about a state of stiffness K, damping C and mass M, of known numbers, grows.

    By THEORY.md 7, eq. (7.3): no pole has a positive real part, or without damping all omega^2 are real and positive. A
    motion without mass loses its stability where the determinant of the stiffness changes sign, which is not asked.

    Raises:
        AnalysisError: singular_stiffness.
    """
    if np.any(c):
        return not any_grows(poles_of(k, c, m))
    values, _ = general_spectrum(k, m)
    values = values[np.isfinite(values)]
    return bool(np.all(is_real(values) & (values.real > 0)))


def any_grows(poles: Any, share: float = GROWS) -> bool:
    """Whether some pole has a real part above a share of its size that is no round-off beside the largest."""
    sizes = np.abs(poles)
    return bool(np.any((np.real(poles) > share * sizes) & (sizes > NOTHING * np.max(sizes, initial=0.0))))
