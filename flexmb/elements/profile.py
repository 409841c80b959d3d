"""Sections that vary along a spectral beam: tapers, reinforced middles, notches."""

import inspect
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_floats, as_reals, check_real, holds, is_concrete, short_repr
from ..compilation.compile import jit
from ..compilation.program import Captured, captured
from ..errors import ModelError
from ..math.quadrature import gauss, lobatto
from ..numerical_limits import ROUND_OFF, SMOOTH_COMPLIANCE, SMOOTH_MASS, TEN_DIGITS
from .section import MaterialDamping, Rigidity, Scalar, Section

# Places in each piece at which a profile is checked for faults.
PLACES = np.linspace(0.02, 0.98, 13)
# Places at which sections are checked like the section of a whole beam.
CHECKED = np.array([0.0, 0.5, 1.0])
# Gauss nodes in each smooth piece for integrals along a beam.
NODES = 24
# Lobatto nodes for the mass of a beam in space of low order; sufficient where the mass is smooth.
FEWEST = 9
# Fine quadrature to compare NODES and FEWEST with: PARTS of each piece, with EACH Gauss nodes.
PARTS, EACH = 64, 8
# Number of beams that are checked at once.
TOGETHER = 64
# Rigidities that must not be zero at single places; the other numbers may be zero.
STIFF = ("EA", "EIy", "EIz", "GIt")


class Profile(Section):
    """A section that is a function of the place along a spectral beam.

    flexmb reads numbers outside the function (globals, closures) once, when it creates the profile. These numbers may
    be traced, so derivatives by every dimension work.

    Attributes:
        function: ``f(place) -> Section`` or ``f(place, length) -> Section``. The place is 0 at the first end and 1 at
            the last end. The length is the length of the beam [m]. The kind of section is the same everywhere.
        breaks: Places, in order, where the section or its slope jumps, or ``f(length)`` that returns them. Between
            breaks the section must be smooth.

    Raises:
        ModelError: The function does not accept a place or does not return a section; breaks that are no places.
    """

    function: Callable[..., Section]
    breaks: Sequence[Scalar] | Callable[..., Sequence[Scalar]] = ()

    varies = True

    def __post_init__(self):
        # JAX also creates records, with functions that are captured already.
        for name, capture in (("function", _function), ("breaks", _breaks)):
            value = getattr(self, name)
            if callable(value) and not isinstance(value, Captured):
                object.__setattr__(self, name, capture(value))

    def at(self, place: Scalar, length: Scalar) -> Section:
        """Return the section at a place.

        Args:
            place: From 0 to 1, () [-].
            length: Of the beam, () [m].
        """
        return self.function(jnp.asarray(place, float), jnp.asarray(length, float))

    def breaks_at(self, length: Scalar) -> tuple[Float[Array, ""], ...]:
        """Return the places of the breaks of a beam.

        Args:
            length: Of the beam, () [m].
        """
        breaks: Any = self.breaks
        breaks = breaks(jnp.asarray(length, float)) if callable(breaks) else breaks
        return tuple(jnp.asarray(place, float) for place in breaks)

    def rigidity(self) -> Rigidity:
        """Raise an error: the rigidity depends on the place.

        Raises:
            ModelError: Always.
        """
        raise ModelError(
            "A section that varies along the beam is for spectral beams (planar.spectral_beam, spatial.spectral_beam)."
            " Divide another beam into pieces of constant section."
        )

    @property
    def has_shape(self) -> bool:
        """Return whether the sections have a shape and thus a stress."""
        return self._kind().has_shape

    def states(self, quantity: str) -> bool:
        """Return whether the material of the sections has a quantity.

        Args:
            quantity: Attribute of :class:`flexmb.Material`.
        """
        return self._kind().states(quantity)

    def material_damping(self) -> MaterialDamping | None:
        """Return the damping of the material, which must be constant along the beam.

        Raises:
            ModelError: The damping varies along the beam.
        """
        if not self.states("damping"):
            return None
        times = jax.vmap(lambda place: jnp.asarray(self.at(place, 1.0).stated("damping"), float))(PLACES)
        if is_concrete(times) and np.ptp(np.asarray(times)) > ROUND_OFF * np.max(np.asarray(times)):
            raise ModelError(
                "The damping of the material varies along the section of a beam. Give a material whose damping is the"
                " same everywhere, or give the beam a damping of its own."
            )
        return MaterialDamping(times[0])

    def _kind(self) -> Section:
        """A section of the common kind, with meaningless numbers."""
        code: Any = self.function
        return jax.tree.unflatten(code.code.results, [0.0] * code.code.results.num_leaves)

    def faults(self) -> list[str]:
        """Return no faults: they depend on the beam, see :meth:`faults_along`."""
        return []

    def along(self, length: Any, count: int = NODES) -> "AlongBeams":
        """Return breaks, rigidities and mass along a beam, or along many beams if numbers are stacked.

        Args:
            length: Length of the beam, or of each beam, () or (*n) [m].
            count: Least number of Gauss nodes of the beam in each smooth piece.
        """
        return jax.tree.map(np.asarray, _sampled(*self._stacked(length), gauss(count)))

    def sections_along(self, length: Any) -> Section:
        """Return the sections at some places along each beam; numbers may be traced.

        Args:
            length: Length of the beam, or of each beam, () or (*n) [m].

        Returns:
            One stacked section, (n, places).
        """
        return jax.vmap(_at, (0, None, 0))(*self._stacked(length, np.concatenate([CHECKED, PLACES])))

    def _stacked(self, length: Any, *between: Any) -> tuple[Any, ...]:
        """Profiles of all beams stacked, the other arguments, and the lengths, (n,)."""
        length = as_floats(length)
        many = max(length.size, 1)
        stacked = jax.tree.map(
            lambda leaf: leaf.reshape(many, *leaf.shape[length.ndim :]), jax.tree.map(as_floats, self)
        )
        return stacked, *between, length.reshape(many)

    def faults_along(self, length: Any, count: int = NODES) -> list[str]:
        """Return the faults along a beam, or along many beams if numbers are stacked.

        For traced numbers it checks only sections at some places and the order of the breaks.

        Args:
            length: Length of the beam, or of each beam, () or (*n) [m].
            count: Least number of Gauss nodes of the beam in each smooth piece.
        """
        if not is_concrete((self, length)):
            breaks = jax.vmap(lambda own, length: jnp.stack([0.0, *own.breaks_at(length), 1.0]))(*self._stacked(length))
            holds(jnp.diff(breaks, axis=1) > -TEN_DIGITS)
            return self.sections_along(length).faults()
        lengths = np.asarray(length, float)
        first = jax.tree.map(lambda leaf: np.reshape(leaf, (-1, *np.shape(leaf)[lengths.ndim :]))[0], self)
        sections = jax.tree.map(np.asarray, _at(first, CHECKED, lengths.ravel()[0]))
        for i, place in enumerate(CHECKED):
            if faults := jax.tree.map(lambda numbers, i=i: numbers[i], sections).faults():
                return [f"has a section with {faults[0]}, at place {place:g}"]
        along_beam = self.along(length, count)
        breaks = along_beam.breaks
        if not (
            np.all((breaks > -TEN_DIGITS) & (breaks < 1 + TEN_DIGITS)) and np.all(np.diff(breaks, axis=1) > -TEN_DIGITS)
        ):
            wrong = ", ".join(f"{b:.6g}" for b in breaks[0])
            return [f"has a section with breaks at {wrong}, but they must lie between 0 and 1, in order"]
        for i, name in enumerate((*STIFF, "mass")):
            least, most = along_beam.least[:, i], along_beam.most[:, i]
            # A rigidity may be zero everywhere, except EA.
            gaps = (least == 0) & ((most > 0) | (name == "EA")) & (name in STIFF)
            faulty = ~np.isfinite(least) | ~np.isfinite(most) | (least < 0) | gaps
            if np.any(faulty):
                at = int(np.argmax(faulty))
                where = f"{name} = {least[at]:.6g} at place {along_beam.where[at, i]:.4g}"
                return [f"has a section with {where}, but it must be positive"]
        means, masses = along_beam.means, along_beam.masses
        # The moments of a rigidity that is zero everywhere are zero.
        uneven = np.any(np.abs(means[:, 1:] - means[:, :1]) > SMOOTH_COMPLIANCE * means[:, :1])
        heavy = np.any(np.abs(masses[:, 1] - masses[:, 0]) > SMOOTH_MASS * masses[:, 0])
        if uneven or heavy:
            noun = "section" if uneven else "mass along its section"
            more = ", take a higher order," if count < NODES else ""
            return [
                f"has a {noun} that is not smooth between its breaks: name the places where it jumps or bends sharply"
                f" in `breaks`{more} or divide the beam"
            ]
        return []


class AlongBeams(NamedTuple):
    """Breaks, rigidities and mass along n beams.

    Attributes:
        breaks: Breaks of each beam, (n, breaks).
        rigidity: Rigidities at places between the breaks, each (n, places).
        least, most, where: Least and largest values of STIFF and of the mass, and the place of the least, (n, 5). A
            value that is not finite counts as the least.
        means: Moments 0 to 2 of the compliances of STIFF, and the second moment about the last end, each by the fine
            quadrature, by NODES and by the given count, (n, 3, 4, 4).
        masses: Mean mass by the fine quadrature and by FEWEST, (n, 2).
    """

    breaks: Any
    rigidity: Any
    least: Any
    most: Any
    where: Any
    means: Any
    masses: Any


_SCALAR = jax.ShapeDtypeStruct((), np.float64)


def _function(function: Callable[..., Any]) -> Captured:
    """A function of place and length from a function of the caller with one or two arguments."""
    try:
        takes = [p for p in inspect.signature(function).parameters.values() if p.default is p.empty]
    except (TypeError, ValueError):
        takes = []
    if len(takes) not in (1, 2) or any(p.kind in (p.KEYWORD_ONLY, p.VAR_KEYWORD) for p in takes):
        raise ModelError("The function of a Profile must take a place from 0 to 1, or a place and the length.")

    def section(place: Float[Array, ""], length: Float[Array, ""]):
        result = function(place, length) if len(takes) == 2 else function(place)
        if not isinstance(result, Section) or isinstance(result, Profile):
            raise ModelError(
                f"The function of a Profile must return a section such as Rectangle(..), not {short_repr(result)}."
            )
        check_real("The section that the function of a Profile returns", result, ModelError)
        for leaf in jax.tree.leaves(result):
            if jnp.shape(leaf):
                raise ModelError(
                    f"The function of a Profile returns a section with an entry of shape {jnp.shape(leaf)}, but each"
                    " must be one number at a place."
                )
        return result

    return captured(section, _SCALAR, _SCALAR)


def _breaks(function: Callable[..., Any]) -> Captured:
    return captured(
        lambda length: tuple(as_reals("Where a Profile breaks", place, ModelError) for place in function(length)),
        _SCALAR,
    )


@jit
def _at(profile: Profile, places: Float[Array, "n"], length: Float[Array, ""]) -> Section:
    """Sections at places of a beam, stacked."""
    return jax.vmap(lambda place: profile.at(place, length))(places)


@jit
def _sampled(stacked: Profile, lengths: Float[Array, "n"], fewer: tuple[Array, Array]) -> AlongBeams:
    """Result of :meth:`Profile.along` for stacked beams."""
    fine, shares = gauss(EACH)
    fine = ((np.arange(PARTS)[:, None] + fine) / PARTS).ravel()
    # Lobatto nodes move slightly inside the pieces, since adjacent pieces share their ends.
    ends, at_ends = lobatto(FEWEST)
    within = np.clip(ends, TEN_DIGITS, 1 - TEN_DIGITS)
    rules = (fine, np.tile(shares, PARTS) / PARTS), gauss(NODES), fewer, (within, at_ends)
    # One call of the function for the nodes of all rules keeps the program small.
    nodes = jnp.concatenate([*(nodes for nodes, _ in rules), PLACES])
    first = np.cumsum([0, *(len(nodes) for nodes, _ in rules), len(PLACES)])

    def one(beam: tuple[Profile, Float[Array, ""]]):
        profile, length = beam
        breaks = jnp.stack([*profile.breaks_at(length), jnp.ones(())])
        starts = jnp.concatenate([jnp.zeros(1), breaks[:-1]])
        sizes = breaks - starts
        everywhere = starts[:, None] + sizes[:, None] * nodes
        numbers = jax.vmap(lambda place: rigidity_at(profile, place, length))(everywhere.ravel())
        all_values = jnp.stack([getattr(numbers, name) for name in (*STIFF, "mass")]).reshape(-1, *everywhere.shape)

        def of_rule(i: int) -> tuple[Float[Array, "n"], Float[Array, "5 n"]]:
            columns = slice(first[i], first[i + 1])
            return everywhere[:, columns].ravel(), all_values[:, :, columns].reshape(len(all_values), -1)

        def means(i: int):
            places, (*stiff, mass) = of_rule(i)
            stiff, weighted = jnp.stack(stiff), (sizes[:, None] * rules[i][1]).ravel()
            compliances = jnp.where(stiff <= 0, 0.0, 1 / jnp.where(stiff <= 0, 1.0, stiff))
            moments = jnp.stack([jnp.ones_like(places), places, places**2, (1 - places) ** 2])
            return (compliances * weighted) @ moments.T, mass @ weighted

        places, values = of_rule(0)
        low = jnp.argmin(jnp.where(jnp.isfinite(values), values, -jnp.inf), axis=1)
        (exact, mass), (by_nodes, _), (by_fewer, _), (_, fewest) = map(means, range(4))
        between = first[-2]
        return AlongBeams(
            breaks[:-1],
            jax.tree.map(lambda own: own.reshape(everywhere.shape)[:, between:].ravel(), numbers),
            jnp.take_along_axis(values, low[:, None], axis=1)[:, 0],
            jnp.max(values, axis=1),
            places[low],
            jnp.stack([exact, by_nodes, by_fewer]),
            jnp.stack([mass, fewest]),
        )

    return jax.lax.map(one, (stacked, lengths), batch_size=TOGETHER)


def rigidity_at(section: Section, place: Scalar, length: Scalar) -> Rigidity:
    """Return the rigidity of a section at a place of a beam, as arrays."""
    return jax.tree.map(lambda number: jnp.asarray(number, float), section.at(place, length).rigidity())


def taper(first: Section, last: Section) -> Profile:
    """Return a section whose sizes vary linearly from one end of the beam to the other.

    Args:
        first: Section at the first end.
        last: Section at the last end, of the same kind.

    Returns:
        The section of the whole beam.

    Raises:
        ModelError: The sections are of different kinds.
    """
    _check_alike(first, last)

    def between(place: Scalar) -> Section:
        return jax.tree.map(lambda a, b: a + place * (b - a), first, last)

    return Profile(between)


def stepped(sections: Sequence[Section], breaks: Sequence[Scalar]) -> Profile:
    """Return a section with jumps, such as a leaf spring with a reinforced middle; :func:`with_hole` models a hole.

    Args:
        sections: Section of each piece, from the first end of the beam to the last, of one kind.
        breaks: Places of the jumps, from 0 to 1; one fewer than sections.

    Returns:
        The section of the whole beam.

    Raises:
        ModelError: Sections of different kinds, or a number of breaks that does not match.
    """
    if len(sections) != len(breaks) + 1:
        raise ModelError(f"A stepped section of {len(sections)} pieces has one break fewer, not {len(breaks)}.")
    _check_alike(*sections)

    def piece(place: Scalar) -> Section:
        number = sum((jnp.asarray(place > b, int) for b in breaks), jnp.zeros((), int))
        return jax.tree.map(lambda *values: jnp.stack([jnp.asarray(v, float) for v in values])[number], *sections)

    return Profile(piece, tuple(breaks))


def _check_alike(*sections: Section) -> None:
    for section in sections:
        if not isinstance(section, Section) or isinstance(section, Profile):
            raise ModelError(
                f"A piece of a section must be a section, such as Rectangle(..), not {short_repr(section)}."
            )
    if len({jax.tree.structure(section) for section in sections}) > 1:
        kinds = ", ".join(type(section).__name__ for section in sections)
        raise ModelError(f"Sections along one beam must be of one kind with the same options, not {kinds}.")
