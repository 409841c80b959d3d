"""Damping of a whole model: by ratios of its modes, in proportion to mass and stiffness, or by loss factors."""

import dataclasses
import fnmatch
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..arguments import as_reals, check_flag, check_numbers, is_concrete, library_of, short_repr
from ..compilation.compile import jit, unguarded
from ..display import among
from ..elements.section import Material
from ..math.linear import cholesky, solved_by_factor
from ..math.matrix_functions import harmonic, spectral
from ..model.model import Model
from ..numerical_limits import MASSLESS_SHARE, VIBRATES_ABOVE_SHIFT
from ..results import RESULTS, or_nan
from .about import linearized
from .linearize import Linearization, Matrices
from .loose import refuse_negative_mass
from .modes import check_spectrum, modal_frequencies, refuse_unsymmetric
from .spectrum import shift_to_definite

Ratio = float | Sequence[Any] | Float[Array, "*n"] | Callable[[Any], Any]
Losses = float | Mapping[str | Material, float]


@unguarded
def damped(
    model: Model | Linearization,
    *,
    ratio: Ratio | None = None,
    rayleigh: Sequence[float] | None = None,
    loss_factor: Losses | None = None,
    elements: bool = True,
) -> Linearization:
    """Return the linearised mechanism with damping of the whole model, for poles, state spaces and Bode plots.

    Use one or several of ``ratio``, ``rayleigh`` and ``loss_factor``. flexmb adds their damping matrices, by default
    also the damping of the elements. ``ratio`` and ``loss_factor`` do not damp motions without vibration (rigid,
    unstable or massless). :func:`flexmb.simulate` does not use this damping: use a time constant of the material, or
    dampers.

    Args:
        model: Mechanism, or its linearisation. Differentiable in its parameters, also for repeated frequencies, and in
            the numbers below.
        ratio: Damping ratio of the modes about this state [-]: one number for all modes; or one per mode, (n,), in the
            order of :func:`flexmb.modes`, the last also for all higher modes; or pairs (frequency [Hz], ratio), (k, 2),
            linear in between and constant beyond; or a function of frequencies, (n,) [Hz], that returns ratios, (n,).
        rayleigh: Numbers alpha [1/s] and beta [s] of D0 = alpha M0 + beta K0. A mode of the unloaded mechanism has the
            ratio alpha/(2 w) + beta w/2. For the ratio zeta at two frequencies f and g [Hz] use alpha = 4 pi zeta f
            g/(f + g) and beta = zeta/(pi (f + g)).
        loss_factor: Loss factor eta of the elastic elements [-]: one for all, or by name of an element, with "*" and
            "?" for any characters, or by Material. If several entries fit an element, the last one applies. An element
            without an entry has no loss factor. Structural damping does not depend on the frequency, and no real
            differential equation describes it. flexmb therefore uses an equivalent viscous damping in each mode: the
            ratio eta/2, weighted by the elements' share of strain energy.
        elements: Whether to keep the damping of the elements.

    Returns:
        Linearization with another D0, (n_q, n_q) [N s/m, N m s/rad]. With ``elements=False`` its S_d is zero too.
        Stress outputs do not include the added damping.

    Raises:
        ValueError: Nothing is given, a number is negative or not finite, there are more ratios than modes, frequencies
            do not ascend, a name is unknown, or an element with a loss factor has no stiffness.
        NotImplementedError: The stiffness is unsymmetric, so that it has no modes, and ``ratio`` or ``loss_factor`` is
            given.
        AnalysisError: The equilibrium was not found, or a motion has neither mass nor stiffness or has a negative mass.

    Source:
        THEORY.md 7, eq. (7.11) to (7.13); loss factors by modal strain energy: Johnson, Kienholz (1982), AIAA Journal
        20, 1284.
    """
    check_flag("elements", elements)
    lin = linearized(model, "damped")
    m = lin.matrices
    if ratio is None and rayleigh is None and loss_factor is None:
        raise ValueError("fm.damped needs a damping. Give `ratio`, `rayleigh` or `loss_factor`.")
    added, result = np.zeros(m.D0.shape), m.result
    if rayleigh is not None:
        _check_positive("rayleigh", rayleigh, (2,))
        added = added + rayleigh[0] * m.M0 + rayleigh[1] * m.K0
    if ratio is not None or loss_factor is not None:
        refuse_unsymmetric(m.symmetric)
        refuse_negative_mass(lin)
        ratios = None if ratio is None else _ratios(lin, ratio)
        losses = None if loss_factor is None else loss_factors(lin, loss_factor)
        modal, result = _modal_damping(m, ratios, losses)
        check_spectrum(result, True, lin)
        added = added + or_nan(modal, result)
    damping = {"D0": m.D0 + added} if elements else {"D0": added, "S_d": jnp.zeros_like(m.S_d)}
    return Linearization(dataclasses.replace(m, result=result, **damping), lin.model)


@jit
def _modal_damping(m: Matrices, ratios: Any, losses: Float[Array, "n_e"] | None):
    """Damping matrix of modal ratios and loss factors, and a code of RESULTS.

    With B = K + s M0 = L L^T all functions of (K, M0) are functions of the matrix L^-1 M0 L^-T between factors L and
    L^T. Its eigenvalue mu of a motion is 1/(w^2 + s), and zero for one without mass.
    """
    shift, _, has_shift, _ = shift_to_definite(m.K, m.M0)
    factor = cholesky(m.K + shift * m.M0)

    def reduced(matrix: Float[Array, "n n"]):
        once = solved_by_factor(factor, solved_by_factor(factor, matrix).T)
        return (once + once.T) / 2

    mass = reduced(m.M0)
    core = jnp.zeros_like(mass)
    if ratios is not None:
        core = core + spectral(_by_ratios, mass, shift, *ratios)
    if losses is not None:
        lossy = (losses[:, None] * m.S + m.S * losses) / 2
        core = core + harmonic(_inverse_frequency, mass, reduced(m.DFe.T @ lossy @ m.DFe), shift)
    damping = factor @ core @ factor.T
    result = jnp.where(has_shift, m.result, RESULTS.singular_stiffness).astype(jnp.int32)
    return (damping + damping.T) / 2, result


def _vibrations(mu: Float[Array, "n"], shift: Float[Array, ""]):
    """Whether each motion vibrates, and its angular frequency; one for others."""
    massive = mu > MASSLESS_SHARE * mu.shape[0] * jnp.max(mu, initial=0.0)
    values = 1 / jnp.where(massive, mu, 1.0) - shift
    vibrates = massive & (values > VIBRATES_ABOVE_SHIFT * shift)
    return vibrates, jnp.sqrt(jnp.where(vibrates, values, 1.0))


def _by_ratios(mu: Float[Array, "n"], shift: Float[Array, ""], ratios: Float[Array, "n"], slopes: Float[Array, "n"]):
    """2 zeta w mu, from ratios and their slopes by w."""
    vibrates, w = _vibrations(mu, shift)
    zeta = ratios + slopes * (w - jax.lax.stop_gradient(w))
    return jnp.where(vibrates, 2 * zeta * w * mu, 0.0)


def _inverse_frequency(mu: Float[Array, "n"], shift: Float[Array, ""]):
    vibrates, w = _vibrations(mu, shift)
    return jnp.where(vibrates, 1 / w, 0.0)


def _ratios(lin: Linearization, ratio: Any) -> tuple[Any, Any]:
    """Damping ratios of all motions, by descending frequency, and their slopes by angular frequency."""
    n = lin.matrices.M0.shape[0]
    sizes = () if callable(ratio) else np.shape(ratio)
    if not callable(ratio):
        _check_positive("ratio", ratio)
        if sizes == ():
            return library_of(ratio).broadcast_to(library_of(ratio).asarray(ratio, float), (n,)), np.zeros(n)
    hertz = jax.lax.stop_gradient(modal_frequencies(lin)[0])
    count = int(np.sum(np.isfinite(np.asarray(hertz)))) if is_concrete(hertz) else n
    if len(sizes) == 1:
        if sizes[0] > count:
            raise ValueError(f"Argument `ratio` has {sizes[0]} numbers, but there are {count} modes.")
        mode_ratios = library_of(ratio).asarray(ratio, float)
        return mode_ratios[np.minimum(np.arange(n), sizes[0] - 1)[::-1]], np.zeros(n)
    by_frequency = ratio if callable(ratio) else _between(ratio, sizes)
    # Without vibration any frequency will do.
    library = library_of(hertz)
    hertz = library.where(library.isfinite(hertz) & (hertz > 0), hertz, 1.0)[::-1]
    if is_concrete(lin.matrices):
        ratios, slopes = by_frequency(np.asarray(hertz)), np.zeros(n)
    else:
        ratios, slopes = jax.jvp(by_frequency, (hertz,), (jnp.ones(n),))
    _check_positive("ratio", ratios, (n,), ", a function,")
    return library_of(ratios).asarray(ratios, float), slopes / (2 * np.pi)


def _between(pairs: Any, sizes: tuple[int, ...]) -> Callable[[Any], Any]:
    """Straight lines between pairs of frequency and ratio."""
    if len(sizes) != 2 or sizes[1] != 2:
        raise ValueError(
            "Argument `ratio` must be one number, one per mode, or pairs (frequency [Hz], ratio), but has shape"
            f" {sizes}."
        )
    table = as_reals("Argument `ratio`", pairs)
    if is_concrete(table) and not np.all(np.diff(np.asarray(table)[:, 0]) > 0):
        raise ValueError(
            f"Argument `ratio`: its frequencies must ascend, but are {short_repr(np.asarray(table)[:, 0])}."
        )
    return lambda hertz: jnp.interp(hertz, table[:, 0], table[:, 1])


def _check_positive(name: str, value: Any, shape: tuple[int, ...] | None = None, kind: str = "") -> None:
    check_numbers(f"Argument `{name}`{kind}", value, shape)
    if is_concrete(value) and np.any(np.asarray(value) < 0):
        raise ValueError(f"Argument `{name}`{kind} cannot be negative, but is {short_repr(value)}.")


def loss_factors(lin: Linearization, given: Losses) -> Float[Array, "n_e"]:
    """Loss factor of each deformation [-]; raise ValueError or TypeError for wrong ones."""
    losses = np.zeros(lin.model.topology.n_e)
    if not isinstance(given, Mapping):
        _check_positive("loss_factor", given, ())
        return jnp.asarray(losses + given)
    if not given:
        raise ValueError("Argument `loss_factor` names no element.")
    for key, factor in given.items():
        _check_positive("loss_factor", factor, ())
        rows = _rows_of(lin.model, key)
        called = "that material" if isinstance(key, Material) else f"'{key}'"
        if not len(rows):
            names = among(name for name, *_ in lin.labels.elements)
            raise ValueError(f"Argument `loss_factor`: no element is of {called}. There are: {names}.")
        if is_concrete(lin.matrices) and not _has_stiffness(lin, rows):
            raise ValueError(f"Argument `loss_factor`: elements of {called} have no stiffness that could dissipate.")
        of_key = np.isin(np.arange(len(losses)), rows)
        losses = library_of((losses, factor)).where(of_key, factor, losses)
    return jnp.asarray(losses)


def _has_stiffness(lin: Linearization, rows: Int[np.ndarray, "k"]) -> bool:
    """Whether stress resultants of some deformations change in any motion; of concrete numbers."""
    if not lin.large:
        return bool(np.any(np.asarray(lin.matrices.S)[rows] @ np.asarray(lin.matrices.DFe)))
    element_matrices = lin.elements.elastic
    return any(np.any(np.asarray(matrix)[np.isin(np.asarray(at), rows)]) for at, _, matrix in element_matrices)


def _rows_of(model: Model, key: Any) -> Int[np.ndarray, "k"]:
    """Deformations of the elements of a name, or of a material."""
    if isinstance(key, str):
        return np.array([i for i, e in enumerate(model.labels.e) if fnmatch.fnmatchcase(e.of, key)], int)
    if not isinstance(key, Material):
        raise TypeError(f"Argument `loss_factor` goes by names of elements or by Materials, not by {short_repr(key)}.")
    if not is_concrete((model.parameters.properties, key)):
        raise ValueError("Argument `loss_factor`: materials cannot be compared under a trace. Name the elements.")
    rows = []
    for block, properties in zip(model.topology.blocks, model.parameters.properties, strict=True):
        sections, first = properties.get("section"), 0
        # Sections of several kinds are a tuple with one stack per kind, in the order of the elements.
        for stack in sections if isinstance(sections, tuple) else (sections,):
            after = first + (np.shape(leaves[0])[0] if (leaves := jax.tree.leaves(stack)) else 0)
            for leaf in jax.tree.leaves(stack, is_leaf=lambda value: isinstance(value, Material)):
                if isinstance(leaf, Material):
                    rows += [row for i in range(after - first) if _is_same(leaf, i, key) for row in block.e[first + i]]
            first = after
    return np.array(rows, int)


def _is_same(stacked: Material, i: int, material: Material) -> bool:
    """Whether element i of stacked elements has a material with the numbers of ``material``."""
    pairs = [(getattr(stacked, f.name), getattr(material, f.name)) for f in dataclasses.fields(Material)]
    return all((value is None) == (other is None) for value, other in pairs) and all(
        np.all(np.asarray(value)[i] == other) for value, other in pairs if value is not None
    )
