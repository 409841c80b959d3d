"""Energy and stress of the section of a bent and twisted strip by Ritz's method, beside their closed forms."""

import numpy as np

import flexmb as fm


def energy_of_section(*arguments) -> float:
    """Return the energy per length beyond that of a beam whose section keeps its shape [J/m].

    Args:
        arguments: Arguments of :func:`stress_of_section`.
    """
    return shape_of_section(*arguments)[0]


def stress_of_section(
    section: fm.Rectangle, initial: float, change: float, longer: float, stretch: float, sideways: float
) -> tuple[np.ndarray, float]:
    """Return the stress along the strip at the edges y > 0 and in the middle, and across the middle [Pa].

    The first result has the places +y, +z; +y, -z; 0, +z; 0, -z, (4,). Stress across is at +z.

    The section is a plate across the width. Its height is a polynomial of degree 20: even with mean zero, or odd and
    zero at the edges. The membrane stress acts along the strip alone.

    Args:
        section: Strip.
        initial: Initial curvature about the soft axis [1/m].
        change: Change of this curvature [1/m].
        longer: Square of the twist rate, minus its initial square [1/m^2].
        stretch: Elongation of the axis [-].
        sideways: Curvature about the stiff axis [1/m].
    """
    w, t, nu = float(section.width), float(section.thickness), float(section.material.poisson())
    youngs = float(section.material.E)
    _, shape = shape_of_section(section, initial, change, longer, stretch, sideways)
    curved = [shape.deriv(2)(y) * 4 / w**2 for y in (1.0, 0.0)]
    fibres = [stretch + longer * y**2 / 2 + sideways * y - (initial + change) * shape(2 * y / w) for y in (w / 2, 0.0)]
    bending = [youngs * t / 2 / (1 - nu**2) * (change + nu * across) for across in curved]
    along = [youngs * fibre + sign * bent for fibre, bent in zip(fibres, bending, strict=True) for sign in (1, -1)]
    return np.array(along), youngs * t / 2 / (1 - nu**2) * (curved[1] + nu * change)


def shape_of_section(
    section: fm.Rectangle, initial: float, change: float, longer: float, stretch: float, sideways: float
) -> tuple[float, np.polynomial.Legendre]:
    """Return the energy of :func:`energy_of_section` and the height over twice the place across, over the width."""
    w, t, nu = float(section.width), float(section.thickness), float(section.material.poisson())
    youngs = float(section.material.E)
    plate, membrane = youngs * t**3 / (12 * (1 - nu**2)), youngs * t
    nodes, weights = np.polynomial.legendre.leggauss(40)
    y, weights = nodes * w / 2, weights * w / 2
    even = [np.polynomial.Legendre.basis(k) for k in range(2, 21, 2)]
    odd = [np.polynomial.Legendre.basis(k) - np.polynomial.Legendre.basis(1) for k in range(3, 21, 2)]
    rows = even + odd
    height = np.array([row(nodes) for row in rows])
    bent = np.array([row.deriv(2)(nodes) for row in rows]) * 4 / w**2
    whole = initial + change
    strain = stretch + longer * y**2 / 2 + sideways * y
    # Fibres towards the centre of curvature are shorter.
    matrix = plate * bent * weights @ bent.T + membrane * whole**2 * height * weights @ height.T
    right = -plate * nu * change * bent @ weights + membrane * whole * height @ (weights * strain)
    parts = np.linalg.solve(matrix, right)
    least = -0.5 * right @ parts
    stiff = 0.5 * plate * w * change**2 + 0.5 * membrane * weights @ strain**2
    beam = 0.5 * youngs * w * t**3 / 12 * change**2 + 0.5 * membrane * (w * stretch**2 + w**3 / 12 * sideways**2)
    return float(stiff + least - beam), sum((part * row for part, row in zip(parts, rows, strict=True)), 0 * rows[0])
