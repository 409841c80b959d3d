"""Mass, centre and inertia of a part from a STEP file, by build123d."""

import importlib
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import check_numbers, is_concrete, short_repr
from ..elements.sections import Material
from ..errors import ModelError, printable
from .assemble import stack

# build123d returns millimetres for any unit of the file.
MILLIMETRE = 1e-3


def body_of_step(what: str, step: Any, material: Any, at: Any = None, dimension: int = 3) -> tuple[Any, Any, Any]:
    """Mass, centre of mass (d,) and inertia about it of all solids of a STEP file, in axes of the file [kg, m, kg m^2].

    Args:
        what: Beginning of messages.
        step: Path of the file.
        material: Material with a density, or a density [kg/m^3].
        at: Origin of the file, (d,) [m].
        dimension: d; 2 for the axes x and y of the file.

    Raises:
        ImportError: build123d is not installed.
        ModelError: The file is missing or has no solids, or there is no density.

    Source:
        Volume integrals over each solid by Open CASCADE; parallel axes.
    """
    density = _density(what, material)
    path = Path(os.fspath(step)) if isinstance(step, str | os.PathLike) else None
    if path is None or not path.is_file():
        raise ModelError(f"{what}: there is no STEP file {short_repr(str(step))}.")
    volumes, centers, inertias = _solids(what, path)
    volume = np.sum(volumes)
    center = volumes @ centers / volume
    arms = centers - center
    parallel = np.einsum("s,s,ij->ij", volumes, np.sum(arms**2, axis=1), np.eye(3))
    inertia = np.sum(inertias, axis=0) + parallel - np.einsum("s,si,sj->ij", volumes, arms, arms)
    inertia, center = density * (inertia + inertia.T) / 2, center[:dimension]
    if at is not None:
        check_numbers(f"{what}: at", at, (dimension,), ModelError)
        center = stack([a + c for a, c in zip(at, center, strict=True)])
    return density * volume, center, inertia[2, 2] if dimension == 2 else inertia


def _density(subject: str, material: Any) -> Any:
    if material is None:
        raise ModelError(
            f"{subject}: a STEP file contains only volumes. Give material=, a Material or a density [kg/m^3]."
        )
    density = material.rho if isinstance(material, Material) else material
    check_numbers(f"{subject}: the density", density, (), ModelError)
    if is_concrete(density) and not density > 0:
        raise ModelError(f"{subject}: the density of its material is {density}, but it must be positive.")
    return density


def _solids(subject: str, path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Volumes (n,) [m^3], centres (n, 3) [m] and inertias over density (n, 3, 3) [m^5] of the solids of a file."""
    try:
        cad: Any = importlib.import_module("build123d")
    except ImportError:
        raise ImportError(f"{subject}: a STEP file needs build123d: pip install 'flexmb[cad]'.") from None
    try:
        solids = cad.import_step(path).solids()
    except Exception as fault:
        raise ModelError(f"{subject}: cannot read '{printable(path)}' as a STEP file: {printable(fault)}.") from fault
    if not solids:
        raise ModelError(f"{subject}: the STEP file '{printable(path)}' has no solids. Surfaces have no mass.")
    volumes = np.array([solid.volume for solid in solids])
    if not np.all(volumes > 0):
        raise ModelError(f"{subject}: a solid in the STEP file '{printable(path)}' has no volume.")
    centers = np.array([tuple(solid.center(cad.CenterOf.MASS)) for solid in solids])
    inertias = np.array([solid.matrix_of_inertia for solid in solids])
    return volumes * MILLIMETRE**3, centers * MILLIMETRE, inertias * MILLIMETRE**5
