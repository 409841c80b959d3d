"""What a leaf spring has beyond a beam: clamps keep its cross-section flat, and its warping is restrained.

A strip that bends wants to curve across its width the other way. Where an end is clamped it cannot: near there it bends
as a plate, with E/(1 - nu^2) in place of E, and a little nearer it stretches so. Nor can shear warp the section there.
Far from clamps a wide strip flattens of its own as its curvature grows, and gives way where it is also bent sideways.
A strip that twists wants to warp; where it cannot, twist builds up over a distance of about a quarter of the width.

Planar (``leaf_planar``) and spatial (``leaf_spatial``) leaf springs are spectral beams of such sections.
"""

import dataclasses
import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..errors import ModelError
from ..math.derivative import pointwise
from ..math.quadrature import gauss, legendre_slopes, legendre_values, legendre_values_at, lobatto
from ..numerical_limits import DISTORTION_SERIES
from .curves import curvature_at
from .leaf_ends import Ends, ends_of
from .profile import NODES, Profile
from .section import Rigidity, Scalar, Section
from .sections import Rectangle
from .spectral import check_section, pieces_of, relative, rigidities, rigidity_of, series_matrix, strains

# How far from a clamp a leaf spring stretches and bends, about its soft axis and sideways, as a plate, and shears
# without warping, over its width; and how much further, over its thickness.
KEPT = ("EA", "EIy", "EIz", "GAy")
REACHES = np.array([[0.14], [0.40], [0.065], [0.10]])
THICKER = np.array([[0.27], [0.0], [0.25], [0.0]])
# So many of them bend or stretch; their jumps are breaks.
BREAKS = 3
# Of a thick strip the warping rigidity is smaller, by 1 over 1 and so many squares of thickness over width.
OF_THICK = 12.0
# Steps along a leaf spring for integrals of its twist, and Gauss nodes of each at least.
STEPS, DENSE = 8, 8
ENDS = np.array([0.0, 1.0])
# Which ends are clamped, as users say it. A model has 1 for a clamped end and 0 for another, (2,). Where clamps reach
# in through leaf springs in line, these count too, and a second row has their distances, (2, 2) [m]. Where leaf springs
# of other sizes go on in line, two more rows have the widths and thicknesses there, (4, 2) [m].
Clamped = tuple[bool, bool] | bool
# Gauss nodes of each of the three parts of a leaf spring, near its ends and between, for the energy of large strains.
PARTS = 10
# By how much slanted edges make a strip softer in bending sideways, over the square of the slope of its width.
IN_PLANE = 0.30
# Keeps the root of a curvature that is zero smooth, and changes no digit.
TINY = 1e-12


class Strip(Section):
    """A rectangle as part of a leaf spring: stress follows edges that are not parallel, and a thick one warps less.

    Attributes:
        rectangle: At this place, with its shear counted.
        slope: By how much the width grows along the leaf spring, () [-]; None where it is the same everywhere.

    Source:
        THEORY.md 2, eq. (2.46) and (2.57).
    """

    rectangle: Rectangle
    slope: Scalar | None = None

    def rigidity(self) -> Rigidity:
        """Rigidities, smaller than the rectangle's; the shear rigidity is the same."""
        found, nu = self.rectangle.rigidity(), self.rectangle.material.poisson()
        thick = 1 + OF_THICK * (self.rectangle.thickness / self.rectangle.width) ** 2
        found = dataclasses.replace(found, EIw=found.EIw / thick)
        if self.slope is None:
            return found
        square = self.slope**2
        # Bending sideways is coupled to shear, see Leaf._slanting.
        coupled = 1 - square * found.shear_y / (4 * self.rectangle.width**2)
        sideways, across = (1 + IN_PLANE * square) * coupled, 1 + nu / (6 * (1 + nu)) * square
        return dataclasses.replace(
            found,
            EA=found.EA / (1 + square / 6),
            GIt=found.GIt / (1 + square / 6),
            EIy=found.EIy / across,
            EIz=found.EIz / sideways,
            shear_y=found.shear_y / sideways * coupled,
            shear_z=found.shear_z / across,
        )


class Sheared(Section):
    """A section that varies smoothly, with its shear counted.

    Attributes:
        section: As it is given: a rectangle, or one whose sizes vary smoothly.
    """

    section: Section

    varies = True

    def rigidity(self) -> Rigidity:
        """There is none for the whole leaf spring. Raises ModelError: Always."""
        raise ModelError("The section of a leaf spring is not the same everywhere.")

    def rectangle(self, place: Scalar, length: Any) -> Rectangle:
        """The rectangle at a place, with its shear counted."""
        found: Any = self.section.at(place, length)
        return dataclasses.replace(found, shear=True)

    def at(self, place: Scalar, length: Any) -> Strip:
        """The section at a place, () [-]."""
        return Strip(*self.slanted(place, length))

    def slanted(self, place: Scalar, length: Any) -> tuple[Rectangle, Any]:
        """The rectangle at a place, and by how much its width grows along there, () [-]; None where it never does."""
        if not self.section.varies:
            return self.rectangle(place, length), None

        def width(place: Scalar):
            rectangle = self.rectangle(place, length)
            return jnp.asarray(rectangle.width, float), rectangle

        place = jnp.asarray(place, float)
        _, slope, rectangle = jax.jvp(width, (place,), (jnp.ones_like(place),), has_aux=True)
        return rectangle, slope / length

    def relative(self, places: Any, length: Any, names: Sequence[str]) -> Float[Array, "n names"]:
        """Compliances at places over their means, as :func:`flexmb.elements.spectral.relative` has them."""
        return relative(self, places, length, names)


class Leaf(Sheared):
    """The section of a leaf spring at each place, with what clamps do to it: they change strains (:meth:`relative`).

    Attributes:
        section: As it is given: a rectangle, or one whose sizes vary smoothly.
        clamped: 1 where a clamp keeps an end flat, 0 where none does, of the first end and of the last, (2,).
        beyond: How far beyond each end that clamp is, in line, (2,) [m].
        initial: Initial curvature as the beam has it, or None where it is straight.
        ends: Skew cuts, steps and roots at its ends, or None.

    Source:
        THEORY.md 2, eq. (2.22), (2.42), (2.55) and (2.58).
    """

    clamped: Float[Array, "2"]
    beyond: Any = 0.0
    initial: Any = None
    ends: Ends | None = None

    def plain(self) -> Section:
        """The section without clamps, with its shear counted where it varies."""
        return Sheared(self.section) if self.section.varies else self.section

    def _strips(self, length: Any) -> Section:
        """The section without clamps, with its shear counted, whether it varies or not."""
        return self.plain() if self.section.varies else self.at(0.0, length)

    def breaks_at(self, length: Any) -> tuple[Float[Array, ""], ...]:
        """Where a clamp's influence on bending sideways, on stretching and on bending ends."""
        first, last = self.kept(length)[0][:BREAKS].T
        return tuple(jnp.sort(jnp.concatenate([first, 1 - last])))

    def layers(self, length: Any) -> tuple[Scalar, Scalar]:
        """Over which distance from each end twist builds up where warping is restrained, over the length.

        Returns sqrt(E' Cw/GIt)/L at the first end and at the last, () [-].
        """
        twists, warps = rigidities(self._strips(length), jnp.asarray(ENDS), length, ("GIt", "EIw")).T
        first, last = jnp.sqrt(warps / twists) / length
        return first, last

    def _at_ends(self, length: Any) -> list[Rectangle]:
        """Rectangles at the first end and at the last; one where the section does not vary."""
        return [self.rectangle(place, length) for place in ((0.0, 1.0) if self.section.varies else (0.0,))]

    def kept(self, length: Any) -> tuple[Float[Array, "kept 2"], Float[Array, "kept 2"]]:
        """How far from each end a leaf spring is kept flat, and by which share strains are smaller there.

        Two clamps share a leaf spring that both reach all over. At an end without clamp the distance has no meaning.

        Returns:
            Over the length, of the strains of ``KEPT`` (rows) at the first end and at the last, (4, 2) [-]; at a
            clamped end nu^2, of shear 1 - k, and 0 at another, (4, 2) [-].
        """
        rectangles = self._at_ends(length)
        sizes = [(r.width / length, r.thickness / length, r.material.poisson()) for r in rectangles]
        wide, thick, nu = jnp.broadcast_to(jnp.array(sizes, float).T, (3, 2))
        # Cowper's k, 10 (1 + nu)/(12 + 11 nu), is that of a section which may warp.
        shares = jnp.stack([nu**2] * BREAKS + [(2 + nu) / (12 + 11 * nu)])
        reaches = REACHES * wide + THICKER * thick - self.beyond / length
        reaches = jnp.clip(reaches, 0.0, 0.5 + 0.5 * self.clamped)
        overlap = jnp.maximum(jnp.sum(reaches, axis=1, keepdims=True) - 1, 0.0)
        return reaches - overlap * (1 + self.clamped[::-1] - self.clamped) / 2, self.clamped * shares

    def relative(self, places: Any, length: Any, names: Sequence[str]) -> Float[Array, "n names"]:
        """Compliances at places over what they are without clamps."""
        cut = self._flat(places, *self.kept(length))
        own = jnp.stack([cut[KEPT.index(n)] if n in KEPT else jnp.zeros_like(cut[0]) for n in names], axis=1)
        base = relative(self.plain(), places, length, names) if self.section.varies else 1.0
        return base * (1 - own)

    def _flat(
        self, places: Any, reaches: Float[Array, "kept 2"], shares: Float[Array, "kept 2"]
    ) -> Float[Array, "kept n"]:
        """Of each strain of ``KEPT``, at places near the first end its share, near the last its own, else zero."""
        ends = jnp.stack([jnp.asarray(places), 1 - jnp.asarray(places)])
        return jnp.einsum("fen,fe->fn", (ends < reaches[:, :, None]).astype(float), shares)

    def thermal(
        self, change: Float[Array, "2"], bends: dict[str, Any], order: int, length: Any, names: Sequence[str]
    ) -> Float[Array, "c"]:
        """Coefficients of the strains of a free leaf spring by temperature, field by field.

        Where the section is kept flat, thermal strain and curvature are 1 + nu times as large. Returns (fields order,)
        [m, rad]. Source: THEORY.md 2, eq. (2.26), (2.32) and (2.33).

        Args:
            bends: By the rigidity of a curvature, that curvature over the coefficient of thermal expansion, () [K/m].
            names: Rigidities of the fields, as :func:`flexmb.elements.spectral.rigidities` takes them.
        """
        whole = pieces_of(self, length)
        nodes, weights = gauss(order + 2)
        places, weights = whole.spread(nodes).ravel(), (whole.sizes[:, None] * weights).ravel()
        reaches = self.kept(length)[0][:BREAKS]
        flat = self._flat(places, reaches, jnp.broadcast_to(self.clamped, reaches.shape))
        material = self.rectangle(0.5, length).material
        larger = {name: 1 + material.poisson() * flat[i] for i, name in enumerate(KEPT[:BREAKS])}
        free = {"EA": change[0] + (change[1] - change[0]) * places, **bends}
        wanted = [
            material.alpha * length * larger.get(n, 1.0) * free.get(n, 0.0) * jnp.ones_like(places) for n in names
        ]
        shapes, relative = strains(order, self, places, length, names), self.relative(places, length, names)
        stiff = rigidities(self, places, length, names) / relative
        weighted = (weights[:, None] * stiff)[:, :, None] * shapes
        matrix = jnp.einsum("nfj,nfk->fjk", weighted, shapes)
        right = jnp.einsum("nfj,nf->fj", weighted, jnp.stack(wanted, axis=1))
        return jnp.linalg.solve(matrix, right[:, :, None]).ravel()

    def near(self, order: int, starts: Any, ends: Any, length: Any, names: Sequence[str], count: int):
        """Within each step what is near a clamped end: places, their weights, and strains without clamps there.

        Returns:
            Places and weights, of those strains of ``KEPT`` that there are at both ends, (k, 2, s, count). Strains,
            (k, 2, s, count, order). By which share they are smaller, (k, 2).
        """
        kept = [name for name in KEPT if name in names]
        reaches, less = (own[np.array([KEPT.index(name) for name in kept])] for own in self.kept(length))
        nodes, weights = gauss(count)
        first = jnp.stack(
            [jnp.broadcast_to(starts, (len(kept), len(starts))), jnp.clip(1 - reaches[:, 1:], starts, ends)], 1
        )
        last = jnp.stack([jnp.clip(reaches[:, :1], starts, ends), jnp.broadcast_to(ends, (len(kept), len(starts)))], 1)
        sizes = last - first
        places = first[..., None] + sizes[..., None] * nodes
        shapes = legendre_values_at(order, places)
        if self.section.varies:
            at = relative(self.plain(), places.reshape(-1), length, names)
            at = jnp.stack([at[:, names.index(name)].reshape(places.shape)[i] for i, name in enumerate(kept)])
            shapes = at[..., None] * shapes
        return places, sizes[..., None] * weights, shapes, less

    def twist(self, order: int, places: Any, length: Any) -> Float[Array, "n c"]:
        """Twist rates over length of each coefficient and of the warping of each end.

        Polynomials times the local compliance, less what they are at the ends, where the warping is; from there twist
        dies away as where no torque is. Returns (n, order + 2) [-]; the last two of the warping at the first end and at
        the last. Source: THEORY.md 2, eq. (2.24).
        """
        layers = self.layers(length)
        own, ends = (strains(order, self.plain(), at, length, ("GIt",))[:, 0] for at in (places, ENDS))
        fading = jnp.stack([_fading(at, layer)[0] for at, layer in zip((places, 1 - places), layers, strict=True)], 1)
        return jnp.concatenate([own - fading @ ends, fading], axis=1)

    def twist_slopes(self, order: int, places: np.ndarray, length: Any) -> Float[Array, "n c"]:
        """Slopes of :meth:`twist` along the leaf spring, with the same arguments, (n, order + 2) [-]."""
        first, last = self.layers(length)
        if self.section.varies:
            at = jnp.asarray(places)
            shapes = partial(strains, order, self.plain(), length=length, names=("GIt",))
            own = jax.jvp(shapes, (at,), (jnp.ones_like(at),))[1][:, 0]
        else:
            own = legendre_slopes(order, places)
        ends = strains(order, self.plain(), ENDS, length, ("GIt",))[:, 0]
        fading = jnp.stack([_fading(places, first)[1], -_fading(1 - places, last)[1]], axis=1)
        return jnp.concatenate([own - fading @ ends, fading], axis=1)

    def moments(self, order: int, steps: Any, length: Any, names: Sequence[str]) -> Float[Array, "s g f c"]:
        """Strains at the three Gauss nodes of each step, such that their moments over the step are those of the leaf's.

        Returns the strains of each coefficient, field by field, and of the warping of both ends, (s, 3, fields, fields
        order + 2) [-].

        Args:
            names: Rigidities of the fields, as :func:`flexmb.elements.spectral.rigidities` takes them.
        """
        count, fields, turned = max(DENSE, order // 2 + 3), len(names), names.index("GIt")
        nodes, weights = gauss(count)
        ends = jnp.cumsum(steps) if isinstance(steps, jax.Array) else np.cumsum(steps)
        starts = ends - steps
        places = (starts[:, None] + steps[:, None] * nodes).ravel()
        back = legendre_values(3, gauss(3)[0]) * (2.0 * np.arange(3) + 1)
        tests = back @ (legendre_values(3, nodes) * weights[:, None]).T
        own = strains(order, self.plain(), places, length, names).reshape(len(steps), count, fields, order)
        twist = self.twist(order, places, length).reshape(len(steps), count, order + 2)
        within, shares, shapes, less = self.near(order, starts, ends, length, names, count)
        shares = shares * less[:, :, None, None]
        sizes = jnp.where(jnp.asarray(steps) > 0, steps, 1.0)[:, None]
        tested = legendre_values_at(3, (within - starts[:, None]) / sizes) * (shares / sizes)[..., None]
        cut = jnp.einsum("gj,feskj,fesko->fsgo", back, tested, shapes)
        placed = [names.index(name) for name in KEPT if name in names]
        plain = np.ones(fields) * (np.arange(fields) != turned)
        found = jnp.einsum("gk,skfo,f->sgfo", tests, own, plain)
        found = found - jnp.einsum("hsgo,hf->sgfo", cut, np.eye(fields)[placed])
        twist = jnp.einsum("gk,skc->sgc", tests, twist)
        found = found + twist[:, :, None, :order] * np.eye(fields)[turned][:, None]
        found = jnp.einsum("sgfo,fh->sgfho", found, np.eye(fields)).reshape(len(steps), 3, fields, fields * order)
        warped = twist[:, :, None, order:] * np.eye(fields)[turned][:, None]
        return jnp.concatenate([found, warped], axis=3)

    def matrix(self, of: Any, order: int, length: Any, names: Sequence[str]) -> Array:
        """Matrix of rigidities over length between all coefficients, and the warping of both ends where it twists.

        Returns (fields order, fields order), in space (fields order + 2, fields order + 2) [N/m, N, N m]. Source:
        THEORY.md 2, eq. (2.22) and (2.24).
        """
        fields, elastic = len(names), of is None
        damping: Any = of
        if elastic:
            of = self._strips(length)
        found = series_matrix(of, self.plain(), order, length, 0, names).reshape(fields, order, fields, order)
        # The steps of an order up to six along the leaf spring: what is computed there is computed once.
        steps = np.diff(lobatto(STEPS + 1)[0])
        ends = np.cumsum(steps)
        starts = ends - steps
        places, shares, shapes, less = self.near(order, starts, ends, length, names, max(DENSE, order // 2 + 3))
        # Strains are smaller there, and damping is not larger.
        shares = shares * (less if elastic else less * (2 - less))[:, :, None, None]
        kept = [name for name in KEPT if name in names]
        placed = np.eye(fields)[[names.index(name) for name in kept]]
        if elastic and self.section.varies:
            stiff = rigidities(of, places.reshape(-1), length, kept).reshape(*places.shape, len(kept))
            stiff = jnp.stack([stiff[i, ..., i] for i in range(len(kept))])
        else:
            constant = of.rigidity() if isinstance(of, Section) else of
            stiff = jnp.stack([jnp.asarray(rigidity_of(constant, name), float) for name in kept])[:, None, None, None]
        cut = jnp.einsum("fesk,fesko,feskp->fop", shares * stiff, shapes, shapes) / length
        found = found - jnp.einsum("hop,hf,hg->fogp", cut, placed, placed)
        if elastic and self.section.varies and "EIz" in names:
            found = found + self._slanting(order, length, names)
        if "GIt" not in names:
            return found.reshape(fields * order, fields * order) + self._curved(elastic, order, length, names)
        turned = np.eye(fields)[names.index("GIt")]
        found = found * (1 - turned[:, None, None, None] * turned[:, None])
        nodes, weights = gauss(DENSE)
        places = (starts[:, None] + steps[:, None] * nodes).ravel()
        weights = (steps[:, None] * weights).ravel()
        twist, slopes = self.twist(order, places, length), self.twist_slopes(order, places, length)
        if elastic:
            torsion, warping = rigidities(of, jnp.asarray(places), length, ("GIt", "EIw")).T
        else:
            torsion, warping = jnp.asarray(damping.GIt, float), 0.0
        own = jnp.einsum("n,na,nb->ab", weights * torsion, twist, twist) / length
        own = own + jnp.einsum("n,na,nb->ab", weights * warping, slopes, slopes) / length**3
        spread = np.concatenate([np.kron(turned, np.eye(order)), np.zeros((2, fields * order))])
        spread = np.concatenate([spread, np.eye(order + 2)[:, order:]], axis=1)
        found = jnp.pad(found.reshape(fields * order, fields * order), (0, 2)) + spread.T @ own @ spread
        return found + self._curved(elastic, order, length, names)

    def _slanting(self, order: int, length: Any, names: Sequence[str]) -> Float[Array, "f o f o"]:
        """Matrix between bending sideways and shear where the width varies. Source: THEORY.md 2, eq. (2.46)."""
        places, weights = gauss(NODES)
        places, pair = jnp.asarray(places), ("EIz", "GAy")
        rectangles, slopes = jax.vmap(lambda place: self.slanted(place, length))(places)
        stiff = rigidities(self.plain(), places, length, pair)[:, 0] * slopes / (2 * rectangles.width * length)
        bent, sheared = jnp.moveaxis(strains(order, self.plain(), places, length, pair), 1, 0)
        own = jnp.einsum("n,nj,nk->jk", -weights * stiff, bent, sheared)
        one, other = (np.eye(len(names))[names.index(name)] for name in pair)
        return jnp.einsum("jk,f,g->fjgk", own, one, other) + jnp.einsum("jk,f,g->gkfj", own, one, other)

    def _curved(self, elastic: bool, order: int, length: Any, names: Sequence[str]) -> Any:
        """What initial curvature and twist add to the elastic matrix, else zero. Source: THEORY.md 2, eq. (2.44)."""
        if self.initial is None or not elastic:
            return 0.0
        places, weights, free = self._parts(length)
        stretch, bent, sideways, rate = self._large(order, places, length, names)
        wide, thick, nu, stiff, bending = self._numbers(places, length)
        twisted, curved = self.initial_at(places)
        fourth = 3 * (1 - nu**2) * (curved * wide**2 / thick) ** 2
        own = jnp.einsum(
            "n,na,nb->ab", weights * free * bending * nu**2 / (1 - nu**2) * (1 - curving(fourth)), bent, bent
        )
        if rate is not None:
            softer = self.distorted(places, length) * stiff * wide**2 / 12 * (distorting(fourth) - 1)
            own = own + jnp.einsum("n,na,nb->ab", weights * softer, sideways, sideways)
            drawn = stiff * wide**2 * twisted
            both = jnp.einsum("n,na,nb->ab", weights * drawn / 12, stretch, rate)
            own = own + both + both.T
            own = own + jnp.einsum("n,na,nb->ab", weights * drawn * wide**2 * twisted / 80, rate, rate)
        return own * length

    def initial_at(self, places: Any) -> tuple[Any, Any]:
        """Initial twist and curvature about the soft axis at places, (n,) and (n,) [1/m]; zero unless given."""
        if self.initial is None:
            return 0.0, 0.0
        found = curvature_at(self.initial, places)
        return (0.0, found) if found.ndim == 1 else (found[:, 0], found[:, 1])

    def _parts(self, length: Any) -> tuple[Float[Array, "n"], Float[Array, "n"], Float[Array, "n"]]:
        """Places along a leaf spring near its ends and between, their weights, and 0 where a clamp keeps it flat."""
        nodes, weights = gauss(PARTS)
        reaches, _ = self.kept(length)
        ends = jnp.stack([0.0, reaches[1, 0], 1 - reaches[1, 1], 1.0])
        sizes = jnp.diff(ends)
        places = (ends[:-1, None] + sizes[:, None] * nodes).ravel()
        free = 1 - jnp.stack([self.clamped[0], 0.0, self.clamped[1]])
        return places, (sizes[:, None] * weights).ravel(), jnp.repeat(free, PARTS)

    def distorted(self, places: Float[Array, "n"], length: Any) -> Float[Array, "n"]:
        """Where the cross-section is free to distort, 1, and towards a clamp less, down to 0. Source: eq. (2.56)."""
        wide = jnp.stack([jnp.asarray(rectangle.width, float) for rectangle in self._at_ends(length)])
        away = (jnp.stack([places, 1 - places], axis=1) * length + self.beyond) / (REACHES[1] * wide)
        first, last = (self.clamped * (1 - jnp.minimum(away, 1.0) ** 4) ** 2).T
        return (1 - first) * (1 - last)

    def _large(
        self, order: int, places: Float[Array, "n"], length: Any, names: Sequence[str]
    ) -> tuple[Float[Array, "n c"], Float[Array, "n c"], Any, Any]:
        """Elongation and bending, in space also bending sideways and rate of twist, at places, of each coefficient.

        Each (n, coefficients) [1/m], None in the plane.
        """
        kept = [name for name in KEPT[:BREAKS] if name in names]
        reaches, shares = (own[: len(kept)] for own in self.kept(length))
        own = strains(order, self.plain(), places, length, kept)
        own = own * (1 - self._flat(places, reaches, shares)).T[:, :, None] / length
        whole = len(names) * order + (2 if "GIt" in names else 0)
        rows = [np.eye(whole)[names.index(name) * order :][:order] for name in kept]
        stretch, bent, *others = (own[:, i] @ rows[i] for i in range(len(kept)))
        rate = None
        if "GIt" in names:
            at = names.index("GIt") * order
            turned = np.concatenate([np.eye(whole)[at : at + order], np.eye(whole)[-2:]])
            rate = self.twist(order, places, length) @ turned / length
        return stretch, bent, others[0] if others else None, rate

    def energy(self, order: int, c: Float[Array, "c"], length: Any, names: Sequence[str]) -> Float[Array, ""]:
        """What large strains take beyond the quadratic energy of :meth:`matrix`.

        A wide strip flattens as its curvature grows, where no clamp keeps it flat anyway, and the stress that this
        takes stiffens its torsion; where it is also bent sideways, its cross-section distorts. And twist makes the
        fibres off the axis longer than the axis. Returns () [J], of third order in the coefficients at least. Source:
        THEORY.md 2, eq. (2.23), (2.25), (2.30) and (2.56).

        Args:
            c: Coefficients, in space with the warping of both ends after them, (fields order,) or (fields order + 2,).
        """
        places, weights, free = self._parts(length)
        stretches, bends, sideways, rates = self._large(order, places, length, names)
        stretch, bent = stretches @ c, bends @ c
        wide, thick, nu, stiff, bending = self._numbers(places, length)
        twisted, curved = self.initial_at(places)
        # u^4, which is smooth in the curvature.
        fourth = 3 * (1 - nu**2) * ((curved + bent) * wide**2 / thick) ** 2
        bending, keeps = bending * nu / (1 - nu**2), curving(fourth)
        flatter, initial = bending * (1 - keeps), None
        if self.initial is not None:
            # What is quadratic is in the matrix.
            initial = 3 * (1 - nu**2) * (curved * wide**2 / thick) ** 2
            flatter = bending * (curving(initial) - keeps)
        found = 0.5 * length * (weights * free) @ (nu * flatter * bent**2)
        if rates is None:
            return found
        # Of a strip bent sideways the cross-section distorts.
        softer = distorting(fourth) - (1 if initial is None else distorting(initial))
        softer = softer * self.distorted(places, length) * stiff * wide**2 / 12
        found = found + 0.5 * length * weights @ (softer * (sideways @ c) ** 2)
        rate = rates @ c
        square = (wide * rate) ** 2
        drawn = stiff * (stretch * square / 24 + square**2 / 640) + flatter * rate**2
        if self.initial is not None:
            longer = wide**2 * rate * (2 * twisted + rate)
            drawn = stiff * (stretch * square / 24 + (longer**2 - 4 * (wide * twisted) ** 2 * square) / 640)
            drawn = drawn + bending * (1 - keeps) * share_of_change(bent, curved) * rate**2
        return found + length * weights @ drawn

    def _numbers(self, places: Float[Array, "n"], length: Float[Array, ""]):
        """Width, thickness, Poisson's ratio, EA and EIy: of each place where they vary."""

        def numbers(place: Scalar):
            rectangle = self.rectangle(place, length)
            found = rectangle.rigidity()
            of = rectangle.width, rectangle.thickness, rectangle.material.poisson(), found.EA, found.EIy
            return tuple(jnp.asarray(one, float) for one in of)

        return jax.vmap(numbers)(places) if self.section.varies else numbers(0.0)


def share_of_change(change: Any, initial: Any) -> Any:
    """Change of a curvature over the whole curvature, with zero where that is zero."""
    whole = initial + change
    return change * whole / (whole**2 + TINY)


def leaf_of(section: Any, clamped: Any, initial: Any = None, skew: Any = None, clamp: Any = None) -> Any:
    """Section of a leaf spring, None of one whose section is not looked at; no end is clamped unless given."""
    if section is None:
        return None
    flags = flags_and_distances(jnp.zeros(2) if clamped is None else clamped)
    return Leaf(section, *flags, initial, ends_of(skew, clamp, clamped))


def flags_and_distances(clamped: Any) -> tuple[Any, Any]:
    """Which ends are kept flat, (2,), and how far beyond them the clamps are, (2,) [m]."""
    return (clamped[0], clamped[1]) if clamped.ndim == 2 else (clamped, 0.0 * clamped)


def _fading(places: Float[Array, "n"] | np.ndarray, layer: Scalar):
    """What is 1 at 0 and 0 at 1 where nothing acts in between, and its slope."""
    near, back, whole = jnp.exp(-places / layer), jnp.exp((places - 2) / layer), 1 - jnp.exp(-2 / layer)
    return (near - back) / whole, -(near + back) / (whole * layer)


@pointwise
def curving(fourth: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """How much of its curvature across a strip keeps, of what it has at small curvature along.

    Returns (2/u) (cosh u - cos u)/(sinh u + sin u), the same shape [-]: 1 for small u, 2/u for large. Source: THEORY.md
    2, eq. (2.23).
    """
    u = jnp.sqrt(jnp.sqrt(fourth + TINY))
    less, sine, cosine = jnp.expm1(-u), jnp.sin(u / 2), jnp.cos(u / 2)
    # Both times exp(-u); cosh u - cos u is 2 sinh(u/2)^2 + 2 sin(u/2)^2, which loses no digits at small u.
    above = less**2 / 2 + 2 * sine**2 * (1 + less)
    below = 2 * sine * cosine * (1 + less) - less * (2 + less) / 2
    return 2 / u * above / below


@pointwise
def distorting(fourth: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """How much of its stiffness sideways a strip keeps that is bent, as its cross-section distorts.

    Returns (3/u) (sinh u - sin u)/(cosh u - cos u), the same shape [-]: 1 for small u, 3/u for large. Source: THEORY.md
    2, eq. (2.56).
    """
    small = fourth < DISTORTION_SERIES
    v, u = jnp.where(small, fourth, 0.0), jnp.sqrt(jnp.sqrt(jnp.where(small, 1.0, fourth)))
    above, below = (
        sum(v**k * (math.factorial(first) / math.factorial(4 * k + first)) for k in range(4)) for first in (3, 2)
    )
    # Over exp(u)/2, so that nothing overflows.
    once = jnp.exp(-u)
    large = 3 / u * (1 - once**2 - 2 * once * jnp.sin(u)) / (1 + once**2 - 2 * once * jnp.cos(u))
    return jnp.where(small, above / below, large)


def faults_of_leaf(section: Section, ref: Any, curvature: Any = None, count: int = NODES) -> list[str]:
    """What is wrong with the section of a leaf spring."""
    if isinstance(section, Profile):
        if section.breaks:
            return ["has a section with breaks: make a leaf spring of each piece, and join them at nodes"]
        if faults := check_section(section, ref, curvature, count):
            return faults
        section = section._kind()
    if not isinstance(section, Rectangle):
        return [f"has a section of kind {type(section).__name__}, but a leaf spring's is a Rectangle"]
    if section.warping_length is not None:
        return ["has a section with warping_length, but it counts restrained warping itself: leave it out"]
    return []
