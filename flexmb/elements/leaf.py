"""The section of a leaf spring: clamps keep it flat, warping can be restrained, and wide strips flatten.

A strip that bends tends to curve across its width in the opposite direction. A clamp prevents this curvature. Near a
clamp the strip therefore bends as a plate, with E/(1 - nu^2) in place of E. At smaller distances it also stretches and
bends sideways as a plate, and shear does not warp its section.

Far from clamps a wide strip flattens as its curvature grows. It then becomes softer in sideways bending. A strip that
twists tends to warp. Where warping is restrained, twist builds up over about a quarter of the width.

Planar (``leaf_planar``) and spatial (``leaf_spatial``) leaf springs are spectral beams with such sections.
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
from ..math.quadrature import gauss, legendre_slopes, legendre_values, lobatto
from ..numerical_limits import DISTINCT_DECAY
from .bent_strip import curving, relaxing_and_distorting
from .curves import curvature_at
from .leaf_ends import ENDS, Ends, ends_matrix, ends_of, free_of_jumps
from .profile import NODES, Profile
from .section import Rigidity, Scalar, Section
from .sections import Rectangle
from .spectral import check_section, constant_rigidities, pieces_of, relative, rigidities, series_matrix, strains

# Distances from a clamp, over the width, within which a leaf spring stretches, bends about its soft axis and bends
# sideways as a plate, and shears without warping. THICKER: additions to these distances, over the thickness.
KEPT = ("EA", "EIy", "EIz", "GAy")
REACHES = np.array([[0.14], [0.40], [0.065], [0.10]])
THICKER = np.array([[0.27], [0.0], [0.25], [0.0]])
# The first three of KEPT stretch or bend; their jumps are breaks.
BREAKS = 3
# The warping rigidity of a thick strip is divided by 1 + OF_THICK (thickness/width)^2.
OF_THICK = 12.0
# Steps along a leaf spring for integrals of its twist, and least number of Gauss nodes in each step.
STEPS, DENSE = 8, 8
# Input of users: whether the first end and the last are clamped. A model stores 1 for a clamped end and 0 for another
# end, (2,). If a clamp acts through leaf springs in line, its end has 1 too, and a second row has the distances from
# both ends to their clamps, (2, 2) [m]. If a leaf spring of another size follows in line, two more rows have the widths
# and the thicknesses beyond both ends, (4, 2) [m].
Clamped = tuple[bool, bool] | bool
# Gauss nodes of each of the three parts of a leaf spring, near its ends and between, for the energy of large strains.
PARTS = 10
# Relative increase of the compliance in sideways bending by slanted edges, over the squared slope of the width.
IN_PLANE = 0.30
# Keeps roots smooth at zero curvature, and changes no digit.
TINY = 1e-12


class Strip(Section):
    """A rectangle at a place of a leaf spring, with the effects of slanted edges and of thickness on its rigidities.

    Attributes:
        rectangle: Rectangle at this place, with shear.
        slope: Slope of the width along the leaf spring, () [-]; None for a section that does not vary.

    Source:
        THEORY.md 2, eq. (2.46) and (2.57).
    """

    rectangle: Rectangle
    slope: Scalar | None = None

    def rigidity(self) -> Rigidity:
        """Return rigidities, at most as large as the rigidities of the rectangle. The shear rigidity is equal."""
        rigidity, nu = self.rectangle.rigidity(), self.rectangle.material.poisson()
        thick = 1 + OF_THICK * (self.rectangle.thickness / self.rectangle.width) ** 2
        rigidity = dataclasses.replace(rigidity, EIw=rigidity.EIw / thick)
        if self.slope is None:
            return rigidity
        square = self.slope**2
        # Sideways bending and shear are coupled, see Leaf._slanting.
        coupled = 1 - square * rigidity.shear_y / (4 * self.rectangle.width**2)
        sideways, across = (1 + IN_PLANE * square) * coupled, 1 + nu / (6 * (1 + nu)) * square
        return dataclasses.replace(
            rigidity,
            EA=rigidity.EA / (1 + square / 6),
            GIt=rigidity.GIt / (1 + square / 6),
            EIy=rigidity.EIy / across,
            EIz=rigidity.EIz / sideways,
            shear_y=rigidity.shear_y / sideways * coupled,
            shear_z=rigidity.shear_z / across,
        )


class Sheared(Section):
    """A section that varies smoothly, with shear.

    Attributes:
        section: Rectangle, or section whose rectangles vary smoothly.
    """

    section: Section

    varies = True

    def rigidity(self) -> Rigidity:
        """Raise ModelError: the rigidity depends on the place."""
        raise ModelError("The section of a leaf spring is not the same everywhere.")

    def rectangle(self, place: Scalar, length: Any) -> Rectangle:
        """Return the rectangle at a place, with shear."""
        rectangle: Any = self.section.at(place, length)
        return dataclasses.replace(rectangle, shear=True)

    def at(self, place: Scalar, length: Any) -> Strip:
        """Return the section at a place, () [-]."""
        return Strip(*self.slanted(place, length))

    def slanted(self, place: Scalar, length: Any) -> tuple[Rectangle, Any]:
        """Return the rectangle at a place and the slope of its width, () [-]; None if the section does not vary."""
        if not self.section.varies:
            return self.rectangle(place, length), None

        def width(place: Scalar):
            rectangle = self.rectangle(place, length)
            return jnp.asarray(rectangle.width, float), rectangle

        place = jnp.asarray(place, float)
        _, slope, rectangle = jax.jvp(width, (place,), (jnp.ones_like(place),), has_aux=True)
        return rectangle, slope / length

    def relative(self, places: Any, length: Any, names: Sequence[str]) -> Float[Array, "n names"]:
        """Return compliances at places over their means, see :func:`flexmb.elements.spectral.relative`."""
        return relative(self, places, length, names)


class Leaf(Sheared):
    """The section of a leaf spring at each place. Clamps reduce its strains (:meth:`relative`).

    Attributes:
        section: Rectangle, or section whose rectangles vary smoothly.
        clamped: 1 for an end that a clamp keeps flat, 0 for a free end, between beside a thicker leaf spring, (2,).
        beyond: Distance from each end to its clamp in line, (2,) [m].
        initial: Initial curvature of the beam, or None for a straight beam.
        ends: Skew cuts, steps and roots at both ends, or None.

    Source:
        THEORY.md 2, eq. (2.22), (2.42), (2.55) and (2.58).
    """

    clamped: Float[Array, "2"]
    beyond: Any = 0.0
    initial: Any = None
    ends: Ends | None = None

    def plain(self) -> Section:
        """Return the section without clamps; with shear if the section varies."""
        return Sheared(self.section) if self.section.varies else self.section

    def _strips(self, length: Any) -> Section:
        """Section without clamps, with shear."""
        return self.plain() if self.section.varies else self.at(0.0, length)

    def breaks_at(self, length: Any) -> tuple[Float[Array, ""], ...]:
        """Return the places where the effects of clamps on stretching, bending and sideways bending end, () [-]."""
        first, last = self.kept(length)[0][:BREAKS].T
        return tuple(jnp.sort(jnp.concatenate([first, 1 - last])))

    def layers(self, length: Any) -> tuple[Scalar, Scalar]:
        """Return the distance over which twist builds up at each end with restrained warping, over the length.

        The distances are sqrt(E' Cw/GIt)/L at the first end and at the last, () [-].
        """
        twists, warps = rigidities(self._strips(length), jnp.asarray(ENDS), length, ("GIt", "EIw")).T
        first, last = jnp.sqrt(warps / twists) / length
        return first, last

    def _fading_over(self, order: int, length: Any) -> list[Scalar]:
        """Return :meth:`layers`, shortened where polynomials represent the functions that decay over them."""
        longest = (DISTINCT_DECAY * math.factorial(order)) ** (-1 / order) / 4
        return [jnp.minimum(layer, longest) for layer in self.layers(length)]

    def _at_ends(self, length: Any) -> list[Rectangle]:
        """Rectangles at the first end and at the last; one rectangle if the section does not vary."""
        return [self.rectangle(place, length) for place in ((0.0, 1.0) if self.section.varies else (0.0,))]

    def kept(self, length: Any) -> tuple[Float[Array, "kept 2"], Float[Array, "kept 2"]]:
        """Return the flat lengths at both ends, and the shares by which strains are smaller there.

        If two flat lengths overlap, both are reduced by half of the overlap. At an end without a clamp the flat length
        has no meaning.

        Returns:
            Flat lengths over the length of the leaf spring, for the strains of ``KEPT`` (rows) at both ends, (4, 2)
            [-]. Shares, (4, 2) [-]: nu^2 at a clamped end, 1 - k for shear, and 0 at another end.
        """
        rectangles = self._at_ends(length)
        sizes = [(r.width / length, r.thickness / length, r.material.poisson()) for r in rectangles]
        wide, thick, nu = jnp.broadcast_to(jnp.array(sizes, float).T, (3, 2))
        # 1 - k, with Cowper's k = 10 (1 + nu)/(12 + 11 nu) of a section that warps.
        shares = jnp.stack([nu**2] * BREAKS + [(2 + nu) / (12 + 11 * nu)])
        reaches = REACHES * wide + THICKER * thick - self.beyond / length
        reaches = jnp.clip(reaches, 0.0, 0.5 + 0.5 * self.clamped)
        overlap = jnp.maximum(jnp.sum(reaches, axis=1, keepdims=True) - 1, 0.0)
        return reaches - overlap * (1 + self.clamped[::-1] - self.clamped) / 2, self.clamped * shares

    def relative(self, places: Any, length: Any, names: Sequence[str]) -> Float[Array, "n names"]:
        """Return compliances at places over the mean compliances without clamps."""
        cut = self._flat(places, *self.kept(length))
        flat_share = jnp.stack([cut[KEPT.index(n)] if n in KEPT else jnp.zeros_like(cut[0]) for n in names], axis=1)
        base = relative(self.plain(), places, length, names) if self.section.varies else 1.0
        return base * (1 - flat_share)

    def _flat(
        self, places: Any, reaches: Float[Array, "kept 2"], shares: Float[Array, "kept 2"]
    ) -> Float[Array, "kept n"]:
        """Sum of the shares of both ends at places within their flat lengths, for each strain of ``KEPT``."""
        ends = jnp.stack([jnp.asarray(places), 1 - jnp.asarray(places)])
        return jnp.einsum("fen,fe->fn", (ends < reaches[:, :, None]).astype(float), shares)

    def thermal(
        self, change: Float[Array, "2"], bends: dict[str, Any], order: int, length: Any, names: Sequence[str]
    ) -> Float[Array, "c"]:
        """Return the coefficients of the thermal strains of a free leaf spring, field by field.

        Thermal strain and curvature are 1 + nu times as large where clamps keep the section flat. Compliant ends
        do not move, since no force acts. Returns (fields order,) [m, rad]. Source: THEORY.md 2, eq. (2.26), (2.32) and
        (2.33).

        Args:
            bends: Curvature over the coefficient of thermal expansion, by the name of its rigidity, () [K/m].
            names: Rigidities of the fields, see :func:`flexmb.elements.spectral.rigidities`.
        """
        pieces = pieces_of(self, length)
        nodes, weights = gauss(order + 2)
        places, weights = pieces.spread(nodes).ravel(), (pieces.sizes[:, None] * weights).ravel()
        reaches = self.kept(length)[0][:BREAKS]
        flat = self._flat(places, reaches, jnp.broadcast_to(self.clamped, reaches.shape))
        material = self.rectangle(0.5, length).material
        larger = {name: 1 + material.poisson() * flat[i] for i, name in enumerate(KEPT[:BREAKS])}
        free = {"EA": change[0] + (change[1] - change[0]) * places, **bends}
        free_strains = [
            material.alpha * length * larger.get(n, 1.0) * free.get(n, 0.0) * jnp.ones_like(places) for n in names
        ]
        shapes, relative = strains(order, self, places, length, names), self.relative(places, length, names)
        stiff = rigidities(self, places, length, names) / relative
        weighted = (weights[:, None] * stiff)[:, :, None] * shapes
        matrix = jnp.einsum("nfj,nfk->fjk", weighted, shapes)
        right = jnp.einsum("nfj,nf->fj", weighted, jnp.stack(free_strains, axis=1))
        coefficients = jnp.linalg.solve(matrix, right[:, :, None]).ravel()
        if self.ends is None:
            return coefficients
        return free_of_jumps(self, order, length, names, coefficients, self.matrix(None, order, length, names))

    def near(self, order: int, starts: Any, ends: Any, length: Any, names: Sequence[str], count: int):
        """Return the quadrature over the flat lengths within each step, and the strains without clamps there.

        Returns:
            Places and weights at both ends, for the k strains of ``KEPT`` among ``names``, (k, 2, s, count). Strains,
            (k, 2, s, count, order). Shares by which clamps reduce the strains, (k, 2).
        """
        kept_names = [name for name in KEPT if name in names]
        reaches, less = (values[np.array([KEPT.index(name) for name in kept_names])] for values in self.kept(length))
        nodes, weights = gauss(count)
        of_all, to_all = (jnp.broadcast_to(places, (len(kept_names), len(starts))) for places in (starts, ends))
        first = jnp.stack([of_all, jnp.clip(1 - reaches[:, 1:], starts, ends)], 1)
        last = jnp.stack([jnp.clip(reaches[:, :1], starts, ends), to_all], 1)
        sizes = last - first
        places = first[..., None] + sizes[..., None] * nodes
        shapes = legendre_values(order, places)
        if self.section.varies:
            at = relative(self.plain(), places.reshape(-1), length, names)
            at = jnp.stack([at[:, names.index(name)].reshape(places.shape)[i] for i, name in enumerate(kept_names)])
            shapes = at[..., None] * shapes
        return places, sizes[..., None] * weights, shapes, less

    def twist(self, order: int, places: Any, length: Any) -> Float[Array, "n c"]:
        """Return twist rates times length by each coefficient and by the warping of each end.

        The rate of a coefficient is a polynomial times the local relative compliance. Functions that decay from the
        ends correct it to zero at both ends. The rate of the warping of an end is the decaying function of this end.
        Returns (n, order + 2) [-]; the last two columns belong to the warping of the first end and of the last.
        Source: THEORY.md 2, eq. (2.24).
        """
        layers = self._fading_over(order, length)
        base, ends = (strains(order, self.plain(), at, length, ("GIt",))[:, 0] for at in (places, ENDS))
        fading = jnp.stack([_fading(at, layer)[0] for at, layer in zip((places, 1 - places), layers, strict=True)], 1)
        return jnp.concatenate([base - fading @ ends, fading], axis=1)

    def twist_slopes(self, order: int, places: np.ndarray, length: Any) -> Float[Array, "n c"]:
        """Return the slopes of :meth:`twist` by the place, (n, order + 2) [-]."""
        first, last = self._fading_over(order, length)
        if self.section.varies:
            at = jnp.asarray(places)
            shapes = partial(strains, order, self.plain(), length=length, names=("GIt",))
            base = jax.jvp(shapes, (at,), (jnp.ones_like(at),))[1][:, 0]
        else:
            base = legendre_slopes(order, places)
        ends = strains(order, self.plain(), ENDS, length, ("GIt",))[:, 0]
        fading = jnp.stack([_fading(places, first)[1], -_fading(1 - places, last)[1]], axis=1)
        return jnp.concatenate([base - fading @ ends, fading], axis=1)

    def moments(self, order: int, steps: Any, length: Any, names: Sequence[str]) -> Float[Array, "s g f c"]:
        """Return strains at the three Gauss nodes of each step that have the same moments over the step as the leaf.

        Returns the strains by each coefficient, field by field, and by the warping of both ends, (s, 3, fields, fields
        order + 2) [-].

        Args:
            names: Rigidities of the fields, see :func:`flexmb.elements.spectral.rigidities`.
        """
        count, fields, turned = max(DENSE, order // 2 + 3), len(names), names.index("GIt")
        nodes, weights = gauss(count)
        ends = jnp.cumsum(steps) if isinstance(steps, jax.Array) else np.cumsum(steps)
        starts = ends - steps
        places = (starts[:, None] + steps[:, None] * nodes).ravel()
        back = legendre_values(3, gauss(3)[0]) * (2.0 * np.arange(3) + 1)
        tests = back @ (legendre_values(3, nodes) * weights[:, None]).T
        base = strains(order, self.plain(), places, length, names).reshape(len(steps), count, fields, order)
        twist = self.twist(order, places, length).reshape(len(steps), count, order + 2)
        within, shares, shapes, less = self.near(order, starts, ends, length, names, count)
        shares = shares * less[:, :, None, None]
        sizes = jnp.where(jnp.asarray(steps) > 0, steps, 1.0)[:, None]
        tested = legendre_values(3, (within - starts[:, None]) / sizes) * (shares / sizes)[..., None]
        cut = jnp.einsum("gj,feskj,fesko->fsgo", back, tested, shapes)
        placed = [names.index(name) for name in KEPT if name in names]
        plain = np.ones(fields) * (np.arange(fields) != turned)
        averaged = jnp.einsum("gk,skfo,f->sgfo", tests, base, plain)
        averaged = averaged - jnp.einsum("hsgo,hf->sgfo", cut, np.eye(fields)[placed])
        twist = jnp.einsum("gk,skc->sgc", tests, twist)
        averaged = averaged + twist[:, :, None, :order] * np.eye(fields)[turned][:, None]
        averaged = jnp.einsum("sgfo,fh->sgfho", averaged, np.eye(fields)).reshape(len(steps), 3, fields, fields * order)
        warped = twist[:, :, None, order:] * np.eye(fields)[turned][:, None]
        return jnp.concatenate([averaged, warped], axis=3)

    def matrix(self, of: Any, order: int, length: Any, names: Sequence[str]) -> Array:
        """Return the stiffness or damping matrix between all coefficients, in space also the warping of both ends.

        The stiffness includes the compliances of the ends. Returns (fields order, fields order), in space (fields order
        + 2, fields order + 2) [N/m, N, N m]. Source: THEORY.md 2, eq. (2.22) and (2.24).
        """
        fields, elastic = len(names), of is None
        if elastic:
            of = self._strips(length)
        matrix = series_matrix(of, self.plain(), order, length, 0, names).reshape(fields, order, fields, order)
        # Steps as of a spectral beam of order up to six: XLA then computes common expressions once.
        steps = np.diff(lobatto(STEPS + 1)[0])
        ends = np.cumsum(steps)
        starts = ends - steps
        places, shares, shapes, less = self.near(order, starts, ends, length, names, max(DENSE, order // 2 + 3))
        # Strains are 1 - less times as large there. The stiffness is R/(1 - less), the damping is not increased.
        shares = shares * (less if elastic else less * (2 - less))[:, :, None, None]
        kept_names = [name for name in KEPT if name in names]
        placed = np.eye(fields)[[names.index(name) for name in kept_names]]
        if elastic and self.section.varies:
            stiff = rigidities(of, places.reshape(-1), length, kept_names).reshape(*places.shape, len(kept_names))
            stiff = jnp.stack([stiff[i, ..., i] for i in range(len(kept_names))])
        else:
            stiff = constant_rigidities(of, kept_names)[:, None, None, None]
        cut = jnp.einsum("fesk,fesko,feskp->fop", shares * stiff, shapes, shapes) / length
        matrix = matrix - jnp.einsum("hop,hf,hg->fogp", cut, placed, placed)
        if elastic and self.section.varies and "EIz" in names:
            matrix = matrix + self._slanting(order, length, names)
        if "GIt" in names:
            turned = np.eye(fields)[names.index("GIt")]
            matrix = matrix * (1 - turned[:, None, None, None] * turned[:, None])
            spread = np.concatenate([np.kron(turned, np.eye(order)), np.zeros((2, fields * order))])
            spread = np.concatenate([spread, np.eye(order + 2)[:, order:]], axis=1)
            torsional = spread.T @ self._torsional(of, order, length, steps) @ spread
            matrix = jnp.pad(matrix.reshape(fields * order, fields * order), (0, 2)) + torsional
        else:
            matrix = matrix.reshape(fields * order, fields * order)
        if not elastic:
            return matrix
        if self.initial is not None:
            matrix = matrix + self._curved(order, length, names)
        return matrix if self.ends is None else matrix + ends_matrix(self, order, length, names)

    def _torsional(self, of: Any, order: int, length: Any, steps: np.ndarray) -> Float[Array, "c c"]:
        """Stiffness or damping matrix between the coefficients of twist and the warping of both ends."""
        nodes, weights = gauss(DENSE)
        places = ((np.cumsum(steps) - steps)[:, None] + steps[:, None] * nodes).ravel()
        weights = (steps[:, None] * weights).ravel()
        twist, slopes = self.twist(order, places, length), self.twist_slopes(order, places, length)
        if isinstance(of, Section):
            torsion, warping = rigidities(of, jnp.asarray(places), length, ("GIt", "EIw")).T
        else:
            torsion, warping = jnp.asarray(of.GIt, float), 0.0
        torsional = jnp.einsum("n,na,nb->ab", weights * torsion, twist, twist) / length
        return torsional + jnp.einsum("n,na,nb->ab", weights * warping, slopes, slopes) / length**3

    def _slanting(self, order: int, length: Any, names: Sequence[str]) -> Float[Array, "f o f o"]:
        """Matrix between bending sideways and shear where the width varies. Source: THEORY.md 2, eq. (2.46)."""
        places, weights = gauss(NODES)
        places, pair = jnp.asarray(places), ("EIz", "GAy")
        rectangles, slopes = jax.vmap(lambda place: self.slanted(place, length))(places)
        stiff = rigidities(self.plain(), places, length, pair)[:, 0] * slopes / (2 * rectangles.width * length)
        bent, sheared = jnp.moveaxis(strains(order, self.plain(), places, length, pair), 1, 0)
        coupling = jnp.einsum("n,nj,nk->jk", -weights * stiff, bent, sheared)
        bending, shearing = (np.eye(len(names))[names.index(name)] for name in pair)
        return jnp.einsum("jk,f,g->fjgk", coupling, bending, shearing) + jnp.einsum(
            "jk,f,g->gkfj", coupling, bending, shearing
        )

    def _curved(self, order: int, length: Any, names: Sequence[str]) -> Any:
        """Matrix that initial curvature and twist add to the elastic matrix. Source: THEORY.md 2, eq. (2.44)."""
        places, weights, free = self._parts(length)
        stretch, bent, sideways, rate = self._large(order, places, length, names)
        wide, thick, nu, stiff, bending = self._numbers(places, length)
        twisted, curved = self.initial_at(places)
        fourth = 3 * (1 - nu**2) * (curved * wide**2 / thick) ** 2
        matrix = jnp.einsum(
            "n,na,nb->ab", weights * free * bending * nu**2 / (1 - nu**2) * (1 - curving(fourth)), bent, bent
        )
        if rate is not None:
            keeps, distorting = relaxing_and_distorting(fourth)
            softer = self.distorted(places, length) * stiff * wide**2 / 12 * (distorting - 1)
            matrix = matrix + jnp.einsum("n,na,nb->ab", weights * softer, sideways, sideways)
            drawn = stiff * wide**2 * twisted
            coupling = jnp.einsum("n,na,nb->ab", weights * drawn / 12, stretch, rate)
            pulled = bending * nu / (1 - nu**2) * fourth * keeps / 180 * curved / (curved**2 + TINY) * 2 * twisted
            coupling = coupling + jnp.einsum("n,na,nb->ab", weights * pulled, bent, rate)
            matrix = matrix + coupling + coupling.T
            drawn = drawn * wide**2 * twisted * (1 / 144 + keeps / 180)
            matrix = matrix + jnp.einsum("n,na,nb->ab", weights * drawn, rate, rate)
        return matrix * length

    def initial_at(self, places: Any) -> tuple[Any, Any]:
        """Return initial twist and curvature about the soft axis at places, (n,) and (n,) [1/m]; zero if straight."""
        if self.initial is None:
            return 0.0, 0.0
        curvature = curvature_at(self.initial, places)
        return (0.0, curvature) if curvature.ndim == 1 else (curvature[:, 0], curvature[:, 1])

    def _parts(self, length: Any) -> tuple[Float[Array, "n"], Float[Array, "n"], Float[Array, "n"]]:
        """Places and weights near both ends and between them; 0 where a clamp keeps the section flat, else 1."""
        nodes, weights = gauss(PARTS)
        reaches, _ = self.kept(length)
        ends = jnp.stack([0.0, reaches[1, 0], 1 - reaches[1, 1], 1.0])
        sizes = jnp.diff(ends)
        places = (ends[:-1, None] + sizes[:, None] * nodes).ravel()
        free = 1 - jnp.stack([self.clamped[0], 0.0, self.clamped[1]])
        return places, (sizes[:, None] * weights).ravel(), jnp.repeat(free, PARTS)

    def distorted(self, places: Float[Array, "n"], length: Any) -> Float[Array, "n"]:
        """Return the share of distortion of the cross-section: 1 far from clamps, 0 at a clamp. Source: eq. (2.56)."""
        wide = jnp.stack([jnp.asarray(rectangle.width, float) for rectangle in self._at_ends(length)])
        away = (jnp.stack([places, 1 - places], axis=1) * length + self.beyond) / (REACHES[1] * wide)
        first, last = (self.clamped * (1 - jnp.minimum(away, 1.0) ** 4) ** 2).T
        return (1 - first) * (1 - last)

    def _large(
        self, order: int, places: Float[Array, "n"], length: Any, names: Sequence[str]
    ) -> tuple[Float[Array, "n c"], Float[Array, "n c"], Any, Any]:
        """Elongation, curvature, in space also sideways curvature and twist at places, by each coefficient, (n, c)."""
        kept_names = [name for name in KEPT[:BREAKS] if name in names]
        reaches, shares = (numbers[: len(kept_names)] for numbers in self.kept(length))
        values = strains(order, self.plain(), places, length, kept_names)
        values = values * (1 - self._flat(places, reaches, shares)).T[:, :, None] / length
        count = len(names) * order + (2 if "GIt" in names else 0)
        rows = [np.eye(count)[names.index(name) * order :][:order] for name in kept_names]
        stretch, bent, *others = (values[:, i] @ rows[i] for i in range(len(kept_names)))
        rate = None
        if "GIt" in names:
            at = names.index("GIt") * order
            turned = np.concatenate([np.eye(count)[at : at + order], np.eye(count)[-2:]])
            rate = self.twist(order, places, length) @ turned / length
        return stretch, bent, others[0] if others else None, rate

    def energy(self, order: int, c: Float[Array, "c"], length: Any, names: Sequence[str]) -> Float[Array, ""]:
        """Return the elastic energy of large strains beyond the quadratic energy of :meth:`matrix`.

        - A wide strip flattens as its curvature grows, except near clamps. The stress of flattening stiffens torsion.
        - A strip that is also bent sideways distorts in its cross-section.
        - Twist makes the fibres off the axis longer than the axis.

        Returns () [J], at least of third order in the coefficients. Source: THEORY.md 2, eq. (2.23), (2.25), (2.30),
        (2.44) and (2.56).

        Args:
            c: Coefficients, (fields order,); in space followed by the warping of both ends, (fields order + 2,).
        """
        places, weights, free = self._parts(length)
        stretches, bends, sideways, rates = self._large(order, places, length, names)
        stretch, bent = stretches @ c, bends @ c
        wide, thick, nu, stiff, bending = self._numbers(places, length)
        twisted, curved = self.initial_at(places)
        # u^4 is a smooth function of the curvature.
        scale = 3 * (1 - nu**2) * (wide**2 / thick) ** 2
        fourth = scale * (curved + bent) ** 2
        bending, (keeps, distorting) = bending * nu / (1 - nu**2), relaxing_and_distorting(fourth)
        initial = None if self.initial is None else scale * curved**2
        kept, distorted = (0.0, 1.0) if initial is None else relaxing_and_distorting(initial)
        flatter = bending * fourth * keeps / 180
        # The matrix contains the quadratic part.
        first = 0.0 if initial is None else bending * initial * kept / 180
        energy = 0.5 * length * (weights * free) @ (nu * (flatter - first) * bent**2)
        if rates is None:
            return energy
        # Distortion of the cross-section in sideways bending.
        softer = (distorting - distorted) * self.distorted(places, length) * stiff * wide**2 / 12
        energy = energy + 0.5 * length * weights @ (softer * (sideways @ c) ** 2)
        rate = rates @ c
        longer, before = rate * (2 * twisted + rate), 2 * twisted * rate
        drawn = stiff * (stretch * rate**2 / 24 + wide**2 * (longer**2 - before**2) / 1152) * wide**2
        drawn = drawn + stiff * wide**4 * (keeps * longer**2 - kept * before**2) / 1440
        pulled = flatter * longer
        if initial is not None:
            pulled = pulled * share_of_change(bent, curved) - first * share_at_rest(bent, curved) * before
        return energy + length * weights @ (drawn + pulled)

    def _numbers(self, places: Float[Array, "n"], length: Float[Array, ""]):
        """Width, thickness, Poisson's ratio, EA and EIy; at each place if the section varies."""

        def numbers(place: Scalar):
            rectangle = self.rectangle(place, length)
            rigidity = rectangle.rigidity()
            values = rectangle.width, rectangle.thickness, rectangle.material.poisson(), rigidity.EA, rigidity.EIy
            return tuple(jnp.asarray(value, float) for value in values)

        return jax.vmap(numbers)(places) if self.section.varies else numbers(0.0)


def share_of_change(change: Any, initial: Any) -> Any:
    """Return the change of a curvature over the whole curvature; zero if the whole curvature is zero."""
    total = initial + change
    return change * total / (total**2 + TINY)


def share_at_rest(change: Any, initial: Any) -> Any:
    """Return the change of a curvature over the initial curvature; zero without initial curvature."""
    return change * initial / (initial**2 + TINY)


def leaf_of(section: Any, clamped: Any, initial: Any = None, skew: Any = None, clamp: Any = None) -> Any:
    """Return the section of a leaf spring; None without a section. Without ``clamped`` no end is clamped."""
    if section is None:
        return None
    if isinstance(section, Profile) and not isinstance(kind := section._kind(), Rectangle):
        remedy = ": a piece beside a hole is a spectral_beam(shear=True)" if hasattr(kind, "hole") else ""
        raise ModelError(f"a leaf spring needs a Rectangle, not a section of kind {type(kind).__name__}{remedy}")
    flags = flags_and_distances(jnp.zeros(2) if clamped is None else clamped)
    return Leaf(section, *flags, initial, ends_of(skew, clamp, clamped))


def flags_and_distances(clamped: Any) -> tuple[Any, Any]:
    """Return 1 for each end that a clamp keeps flat, (2,), and the distances from the ends to the clamps, (2,) [m]."""
    return (clamped[0], clamped[1]) if clamped.ndim == 2 else (clamped, 0.0 * clamped)


def _fading(places: Float[Array, "n"] | np.ndarray, layer: Scalar):
    """Function h with layer^2 h'' = h, h(0) = 1 and h(1) = 0, and its slope."""
    decaying, back, scale = jnp.exp(-places / layer), jnp.exp((places - 2) / layer), 1 - jnp.exp(-2 / layer)
    return (decaying - back) / scale, -(decaying + back) / (scale * layer)


def faults_of_leaf(section: Section, ref: Any, curvature: Any = None, count: int = NODES) -> list[str]:
    """Return the faults of the section of a leaf spring."""
    if isinstance(section, Profile):
        if section.breaks:
            return ["has a section with breaks: use one leaf spring per piece, and join them at nodes"]
        if faults := check_section(section, ref, curvature, count):
            return faults
        section = section._kind()
    if not isinstance(section, Rectangle):
        return [f"has a section of kind {type(section).__name__}, but a leaf spring needs a Rectangle"]
    if section.warping_length is not None:
        return ["has a section with warping_length, but it counts restrained warping itself: leave it out"]
    return []
