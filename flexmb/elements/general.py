"""Sections given by a stiffness matrix, which couples extension, shear, twist and bending, and by an offset mass."""

from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_known, holds, library_of
from ..errors import ModelError
from ..numerical_limits import LEAST_OF_STIFFNESS, SAME_STIFFNESS
from .section import Rigidity, Scalar, Section, faults_of

# Strains of a stiffness matrix by its size.
STRAINS = {
    4: ("elongation", "twist", "curvature_y", "curvature_z"),
    6: ("elongation", "shear_y", "shear_z", "twist", "curvature_y", "curvature_z"),
}
# Sizes by the number of entries on and above the diagonal.
OF_TRIANGLE = {size * (size + 1) // 2: size for size in STRAINS}
# Order of the strains in a spectral beam in space, by the size of the matrix.
ORDER = {4: np.arange(4), 6: np.array([0, 3, 4, 5, 1, 2])}


class General(Section):
    """A section given by its stiffness matrix, for ``spatial.spectral_beam`` alone.

    Its strains may be coupled: tension twists a composite strip, and torque bends a wing box. All numbers are in local
    axes. The matrix refers to the line from end to end of the beam. The centre of mass may lie beside this line. The
    section has no shape and no thermal expansion, so flexmb computes neither its stress nor its thermal strain.

    Attributes:
        stiffness: Symmetric and positive definite matrix of force and moment per strain [N, N m, N m^2]. With
            ``shear=True``, (6, 6) for elongation, shears along y and z, twist, curvatures about y and z. Without shear,
            (4, 4) for elongation, twist, curvatures about y and z. A sequence of 21 or 10 numbers has the entries on
            and above the diagonal, row by row.
        mass: Mass per length [kg/m].
        center_y, center_z: Local coordinates of the centre of mass [m].
        Jx, Jy, Jz, Jyz: Rotary inertia per length about axes through the centre of mass [kg m], with the
            sign of Jyz as in :class:`flexmb.Rigidity`.
        damping: Time constant of Kelvin and Voigt [s], as in :class:`flexmb.Material`: force and moment are stiffness
            times (strain + damping * strain rate). None: no damping.

    Source:
        THEORY.md 2, eq. (2.63) and (2.64).
    """

    stiffness: Sequence[Scalar] | Float[Array, "n n"]
    mass: Scalar = 0.0
    center_y: Scalar = 0.0
    center_z: Scalar = 0.0
    Jx: Scalar = 0.0
    Jy: Scalar = 0.0
    Jz: Scalar = 0.0
    Jyz: Scalar = 0.0
    damping: Scalar | None = None

    def __post_init__(self):
        # JAX also creates records, with matrices instead of sequences.
        stiffness: Any = self.stiffness
        if isinstance(stiffness, list | tuple):
            stiffness = library_of(stiffness).asarray(stiffness, float)
        if size := OF_TRIANGLE.get(np.shape(stiffness)[0] if np.ndim(stiffness) == 1 else 0):
            places = np.zeros((size, size), int)
            places[np.triu_indices(size)] = np.arange(len(stiffness))
            stiffness = stiffness[np.maximum(places, places.T)]
        object.__setattr__(self, "stiffness", stiffness)

    def rigidity(self) -> Rigidity:
        """Raise an error: rigidities cannot describe coupled strains.

        Raises:
            ModelError: Always.
        """
        raise ModelError(
            "A section of general stiffness is for spatial.spectral_beam. Use a Rigidity or a section with a shape."
        )

    def stated(self, quantity: str) -> Any:
        """Return the time constant of the damping, and None for every other quantity.

        Args:
            quantity: Attribute of :class:`flexmb.Material`.
        """
        return self.damping if quantity == "damping" else None

    def triangle(self) -> Float[Array, "m"]:
        """Return the entries of the stiffness on and above its diagonal, row by row, (21,) or (10,)."""
        return self.stiffness[np.triu_indices(len(self.stiffness))]  # pyright: ignore

    def series_matrix(self, order: int, length: Float[Array, ""], shear: bool) -> Float[Array, "c c"]:
        """Return the stiffness matrix between the coefficients of the strains of a spectral beam.

        Args:
            order: Number of coefficients of each strain.
            length: Length of the beam, () [m].
            shear: Whether the beam counts shear.

        Returns:
            (c, c) [N/m, N, N m].

        Raises:
            ModelError: The beam counts shear and the stiffness is (4, 4), or the beam does not and it is (6, 6).

        Source:
            THEORY.md 2, eq. (2.63): the integral of a squared polynomial P_k is 1/(2k + 1).
        """
        stiff: Any = self.stiffness
        if shear and stiff.shape[0] == 4:
            raise ModelError("It counts shear, but the stiffness of its section is (4, 4): give a (6, 6) one.")
        if not shear and stiff.shape[0] == 6:
            raise ModelError("It counts no shear, but the stiffness of its section is (6, 6): give it shear=True.")
        places = ORDER[stiff.shape[0]]
        return jnp.kron(stiff[np.ix_(places, places)] / length, np.diag(1 / (2.0 * np.arange(order) + 1)))

    def moments_of_mass(self) -> tuple[Float[Array, ""], Float[Array, "3"], Float[Array, "3 3"]]:
        """Return mass and its first and second moments per length about the line from end to end.

        Returns:
            () [kg/m], (3,) [kg], (3, 3) [kg m].

        Source:
            THEORY.md 2, eq. (2.64).
        """
        mass, y, z, jx, jy, jz, jyz = (
            jnp.asarray(number, float)
            for number in (self.mass, self.center_y, self.center_z, self.Jx, self.Jy, self.Jz, self.Jyz)
        )
        center = jnp.stack([jnp.zeros(()), y, z])
        about_center = jnp.diag(jnp.stack([jy + jz - jx, jx - jy + jz, jx + jy - jz]) / 2).at[[1, 2], [2, 1]].set(-jyz)
        return mass, mass * center, about_center + mass * jnp.outer(center, center)

    def faults(self) -> list[str]:
        """Return faults: wrong size, no symmetry, not positive definite; negative mass, inertia or damping."""
        numbers = {name: getattr(self, name) for name in ("mass", "Jx", "Jy", "Jz", "Jyz")}
        faults = faults_of(Rigidity(**numbers), at_least_zero=("EA", "EIy", "EIz", "GIt", *RIGIDITIES, *numbers))
        if self.damping is not None and not holds(as_known(self.damping) >= 0):
            faults.append(f"damping = {self.damping}, but it cannot be negative")
        stiff: Any = as_known(self.stiffness)
        size = np.shape(stiff)[-1] if np.ndim(stiff) > 1 else 0
        if size not in STRAINS or np.shape(stiff)[-2] != size:
            shape = np.shape(stiff)
            return [*faults, f"stiffness of shape {shape}, but it must be (6, 6), (4, 4), (21,) or (10,)"]
        return faults + _faults_of_stiffness(stiff, STRAINS[size])


# Other rigidities of a Rigidity; they are zero here.
RIGIDITIES = ("shear_z", "shear_y", "EIw", "Jw")


def _faults_of_stiffness(stiff: Any, names: tuple[str, ...]) -> list[str]:
    """Faults of stiffness matrices, (*n, k, k)."""
    xp = library_of(stiff)
    diagonal = xp.diagonal(stiff, axis1=-2, axis2=-1)
    for k, name in enumerate(names):
        if not holds(diagonal[..., k] > 0):
            return [f"stiffness whose diagonal entry of the {name} is not positive"]
    # Entries differ in unit, so the matrices are scaled to ones on their diagonals.
    roots = xp.sqrt(xp.abs(diagonal))
    scaled = stiff / (roots[..., :, None] * roots[..., None, :])
    for i, j in zip(*np.triu_indices(len(names), 1), strict=True):
        if not holds(xp.abs(scaled[..., i, j] - scaled[..., j, i]) <= SAME_STIFFNESS):
            return [f"stiffness that is not symmetric: its entries between {names[i]} and {names[j]} differ"]
    least, shapes = xp.linalg.eigh((scaled + xp.swapaxes(scaled, -1, -2)) / 2)
    if holds(least[..., 0] > LEAST_OF_STIFFNESS):
        return []
    # Strains of the worst matrix whose combination has the least energy.
    worst = shapes[..., 0].reshape(-1, len(names))[np.argmin(least[..., 0].ravel())]
    taking = " and ".join(name for name, part in zip(names, worst, strict=True) if abs(part) > PART)
    return [f"stiffness that is not positive definite: combined strains of {taking} need no work"]


# Least share of a strain in an eigenvector to be named in the error.
PART = 0.1
