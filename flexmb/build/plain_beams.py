"""Warnings of leaf springs made of plain beams, if missing shear or warping changes a stiffness."""

import dataclasses
import math
from typing import Any, NamedTuple

import jax
import numpy as np

from ..arguments import is_concrete
from ..elements import planar, spatial
from ..elements.general import General
from ..elements.profile import Profile
from ..elements.section import Section
from ..elements.sections import Circle, HollowRectangle, Rectangle, Rigidity, Tube
from ..elements.spectral import pieces_of
from ..errors import BeamTheoryWarning, ModelError, warn
from ..math.quadrature import gauss
from ..model.topology import HELD
from .clamps import THICK, End, elements_at, ends_at, ends_of, is_clamped, leaf_axes, opposite
from .description import Description, Member

PLAIN = (
    *(planar.beam, planar.spectral_beam, planar.leaf_spring),
    *(spatial.beam, spatial.warping_beam, spatial.spectral_beam),
)
# Thin-walled sections. They have no option ``shear``.
HOLLOW = (Tube, HollowRectangle)
# Smallest relative change of a stiffness that causes a warning.
SHARE = 0.01
# Beams of one leaf spring are in line up to this angle [rad].
IN_LINE = np.radians(15.0)
# A rectangle with at least this ratio of width to thickness warps as a thin strip.
STRIP = 3.0
# Places in each smooth piece of a section that varies.
SAMPLES = 12


class _Chain(NamedTuple):
    """Beams in line, one after the other: their names, whole length, and the two ends."""

    names: list[str]
    length: Any
    ends: tuple[End, End]


def warn_of_plain_beams(builder: Description) -> None:
    """Warn where plain beams leave out shear, or warping that clamps restrain, of more than 1 % of a stiffness.

    Also warn of a single coefficient for a curvature that varies, and of thick sections that warp as thin strips.

    Only rectangles, circles and tubes with known sizes are checked, also sections that vary along the beam.

    Source:
        Shear increases the compliance of a beam with a guided end by the factor 1 + 12 EI/(GAk L^2). If the section
        varies, both compliances are integrated along the beam. Warping: :func:`flexmb.sections.warping_factor`.
        n pieces of constant curvature have 1 - 1/n^2 of this compliance in bending.
    """
    _warn_of_thick_strips(builder)
    largest: dict[str, tuple[float, str, str]] = {}
    # Beams that share a section evaluate it once.
    known: dict[int, Any] = {}
    joined = elements_at(builder)
    for chain in _chains(builder, joined):
        # Results from known sizes stay known numbers, also in a traced build.
        with jax.ensure_compile_time_eval():
            left_out = _left_out(builder, chain, joined, known)
        for effect, share in left_out.items():
            if share > SHARE and share > largest.get(effect, (0.0,))[0]:
                largest[effect] = share, chain.names[0], "" if len(chain.names) == 1 else f" to '{chain.names[-1]}'"
    if not largest:
        return
    phrases = [
        f"{effect} by {f'{share:.0%}' if share < 100 else 'more than 9999%'} ('{first}'{last})"
        for effect, (share, first, last) in largest.items()
    ]
    worst = {effect: builder.members[first] for effect, (_, first, _) in largest.items()}
    warn(
        f"Plain beams neglect effects on a stiffness: {', '.join(phrases)}. {_remedy(builder, worst)} If you want beam"
        " theory, ignore fm.BeamTheoryWarning.",
        BeamTheoryWarning,
    )


def _warn_of_thick_strips(builder: Description) -> None:
    """Warn of the first rectangle that restrains warping as a thin strip and is none.

    In a row of warping beams along a notch, thick pieces belong to a thin one and twist little.
    """
    rectangles = [
        (name, member.element.usual, section)
        for name, member in (builder.members.items() if builder.dimension == 3 else ())
        if isinstance(section := member.properties.get("section"), Rectangle) and is_concrete(section)
    ]
    strips = {name: float(section.width) / float(section.thickness) for name, _, section in rectangles}
    beams = [name for name, element, _ in rectangles if element == spatial.warping_beam]
    thick_beams = set(beams) if all(max(strips[name], 1 / strips[name]) < STRIP for name in beams) else set()
    thick_beams = {name for name in thick_beams if not _warps_freely(builder.members[name])}
    for name, element, section in rectangles:
        factor = element in PLAIN and section.warping_length is not None and section.clamped_ends > 0
        if (factor and strips[name] < STRIP) or name in thick_beams:
            in_beam = name in thick_beams
            remedy = "use spatial.beam" if in_beam else "give the longer side as width, or leave out warping_length"
            warn(
                f"Element '{name}' restrains its warping as a thin strip does, but it is {strips[name]:.2g} times as"
                f" wide as thick. Its stiffness in torsion may be more than 10 % off: {remedy}.",
                BeamTheoryWarning,
            )
            return


def _warps_freely(member: Member) -> bool:
    """Whether a beam states that no end restrains its warping."""
    stated = member.properties.get("clamped")
    return stated is not None and is_concrete(stated) and not np.any(stated)


def _remedy(builder: Description, worst: dict[str, Member]) -> str:
    """Sentence on how to include the missing effects; ``worst``: for each effect the beam with the largest change."""
    ways = []
    if sheared := [member for effect, member in worst.items() if "shear" in effect]:
        hollow = any(isinstance(_kind(member), HOLLOW) for member in sheared)
        of_section = "a Rigidity with shear_y and shear_z" if hollow else "shear=True of the section"
        ways.append(f"shear by {of_section} (and {'shear=True ' * hollow}of a spectral_beam)")
    if any("curvature" in effect for effect in worst):
        ways.append("varying curvature by an order of 2 or more")
    if twisted := [member for effect, member in worst.items() if "warping" in effect]:
        # A `warping_length` needs the same section along the whole beam.
        varies = any(member.properties["section"].varies for member in twisted)
        row = "a row of spatial.warping_beam along it, each with the section there"
        ways.append(f"warping by {row if varies else 'warping_length= of the section'}")
    counted = f"ount {' and '.join(ways)}."
    if all("curvature" in effect for effect in worst) or not all(map(_may_be_leaf, worst.values())):
        return f"C{counted}"
    leaf = "spatial.leaf_spring" if builder.dimension == 3 else "planar.leaf_spring(shear=True)"
    return f"A {leaf} counts it. Or c{counted}"


def _may_be_leaf(member: Member) -> bool:
    """Whether a leaf spring takes the section of a beam: a rectangle without breaks."""
    section: Any = member.properties["section"]
    breaks = isinstance(section, Profile) and section.breaks
    return isinstance(_kind(member), Rectangle) and not breaks


def _kind(member: Member) -> Any:
    """The section of a beam, or a section of the kind that varies along it, with meaningless numbers."""
    section: Any = member.properties["section"]
    return section._kind() if isinstance(section, Profile) else section


def _left_out(
    builder: Description, chain: _Chain, joined: dict[str, list[str]], known: dict[int, Any]
) -> dict[str, float]:
    """Relative change of a stiffness by each missing effect; rigidities of constant sections are added to ``known``."""
    member = builder.members[chain.names[0]]
    section: Section = member.properties["section"]
    segments = pieces_of(section, chain.length)
    if not is_concrete(segments):
        return {}
    changes, in_space = {}, builder.dimension == 3
    if member.element.options.get("order") == 1 and any(_is_free(member, i) for i in ((2, 3) if in_space else (1,))):
        n = len(chain.names)
        changes["varying curvature in bending"] = 1 / (n**2 - 1) if n > 1 else math.inf
    if _counts_shear(member):
        return changes
    nodes, weights = gauss(SAMPLES)
    places, weights = (
        np.asarray(values).ravel() for values in (segments.spread(nodes), segments.sizes[:, None] * weights)
    )
    sections: list[Any] = [section.at(place, chain.length) for place in (places if section.varies else (0.0,))]
    if not isinstance(sections[0], Rectangle | Circle | Tube | HollowRectangle) or not is_concrete(sections):
        return changes
    # By NumPy, for which nothing is compiled.
    first, *_ = sections = jax.tree.map(np.asarray, sections)
    counted = [] if section.varies else known.setdefault(id(section), [])
    if not counted:
        counted += map(_sheared, sections)
    bendings = {"z": ("EIy", "shear_z"), "y": ("EIz", "shear_y")} if in_space else {"z": ("EIy", "shear_z")}
    for field, (axis, names) in enumerate(bendings.items(), 2 if in_space else 1):
        if not first.shear and _is_free(member, field):
            stiff, shear = (np.array([float(getattr(entry, name)) for entry in counted]) for name in names)
            # Relative to the place where a force causes no rotation.
            bends = weights / stiff
            away = places - (bends @ places) / bends.sum()
            added = (weights * shear / stiff).sum() / (bends @ away**2) / chain.length**2
            changes[f"shear in bending along local {axis}"] = float(added)
    warps = in_space and member.element.usual != spatial.warping_beam
    if warps and isinstance(first, Rectangle) and first.warping_length is None and _is_free(member, 1):
        stiff = np.array([float(entry.GIt) for entry in counted])
        neck = int(np.argmin(stiff))
        if sections[neck].width >= STRIP * sections[neck].thickness:
            # Length of a beam of the thinnest section with equal twist. Much thicker parts prevent its warping.
            length = chain.length * (weights * stiff[neck] / stiff).sum()
            notched = max(entry.thickness for entry in sections) >= THICK * sections[neck].thickness
            count = 2 if notched else sum(_is_restrained(builder, end, joined) for end in chain.ends)
            decay = length * math.sqrt(stiff[neck] / float(counted[neck].EIw))
            changes["restrained warping in torsion"] = count and 1 / (1 - count * math.tanh(decay / count) / decay) - 1
    return changes


def _sheared(section: Any) -> Rigidity:
    """Rigidities with shear. Source of a tube: Cowper (1966). The walls along a shear force carry it in a box."""
    if not isinstance(section, HOLLOW):
        return dataclasses.replace(section, shear=True).rigidity()
    rigidity, shear_modulus = section.rigidity(), section.material.shear_modulus()
    if isinstance(section, Tube):
        nu, square = section.material.poisson(), (1 - 2 * section.wall / section.diameter) ** 2
        both = (1 + square) ** 2
        area = np.pi / 4 * section.diameter**2 * (1 - square)
        along_y = along_z = area * 6 * (1 + nu) * both / ((7 + 6 * nu) * both + (20 + 12 * nu) * square)
    else:
        along_y, along_z = 2 * section.wall_z * section.width, 2 * section.wall_y * section.thickness
    return dataclasses.replace(
        rigidity,
        shear_y=rigidity.EIz / (shear_modulus * along_y),
        shear_z=rigidity.EIy / (shear_modulus * along_z),
    )


def _is_free(member: Member, field: int) -> bool:
    """Whether a field has a free deformation: elongation, twist, bending along z, y; planar: elongation, bending."""
    in_space = member.element.usual in (spatial.beam, spatial.warping_beam)
    cubic = ((1,), (2,), (3, 4), (5, 6)) if in_space else ((1,), (2, 3))
    numbers = (member.element.fields or cubic)[field]
    return any(member.roles[number - 1] not in HELD for number in numbers)


def _is_restrained(builder: Description, end: End, joined: dict[str, list[str]]) -> bool:
    try:
        return is_clamped(builder, end, joined)[1]
    except ModelError:
        return False


def _chains(builder: Description, joined: dict[str, list[str]]) -> list[_Chain]:
    """Plain beams with a section. Beams in line with the same section form one chain."""
    names = [name for name, member in builder.members.items() if _is_plain(builder, member)]
    along = {name: leaf_axes(builder, builder.members[name])[0] for name in names}
    beyond: dict[End, End] = {}
    for ends in ends_at(builder, names).values():
        if len(ends) == 2 and _continues(builder, along, joined, *ends):
            beyond[ends[0]], beyond[ends[1]] = ends[1], ends[0]
    chains, seen = [], set()
    for name in names:
        if name in seen:
            continue
        chain, outer = [name], []
        seen.add(name)
        for end in reversed(ends_of(name, builder.members[name])):
            while end in beyond and beyond[end].leaf not in seen:
                end = opposite(builder, beyond[end])
                chain.append(end.leaf)
                seen.add(end.leaf)
            outer.append(end)
        chains.append(_Chain(chain, sum(_span(builder, beam) for beam in chain), (outer[1], outer[0])))
    return chains


def _counts_shear(member: Member) -> bool:
    """Whether a beam counts shear although its section states none."""
    return member.element.usual == planar.leaf_spring and member.element.options["shear"]


def _is_plain(builder: Description, member: Member) -> bool:
    if member.element.usual not in PLAIN or isinstance(member.properties.get("section"), General | None):
        return False
    # With one coefficient its curvature cannot vary.
    if _counts_shear(member) and member.element.options["order"] > 1:
        return False
    p, q = member.nodes_of_kind("position")
    starts = builder.nodes[p].start, builder.nodes[q].start
    return is_concrete((starts, member.properties.get("y")))


def _continues(
    builder: Description, along: dict[str, np.ndarray], joined: dict[str, list[str]], one: End, other: End
) -> bool:
    """Whether two beams with a common rotation are in line, have equal sections, and no clamp between them."""
    first, second = (builder.members[end.leaf].properties["section"] for end in (one, other))
    if one.leaf == other.leaf or first.varies or jax.tree.structure(first) != jax.tree.structure(second):
        return False
    leaves, others = jax.tree.leaves(first), jax.tree.leaves(second)
    in_line = bool(abs(along[one.leaf] @ along[other.leaf]) > np.cos(IN_LINE))
    return in_line and is_concrete((leaves, others)) and leaves == others and not _is_restrained(builder, one, joined)


def _span(builder: Description, name: str) -> float:
    p, q = (np.asarray(builder.nodes[node].start, float) for node in builder.members[name].nodes_of_kind("position"))
    return float(np.linalg.norm(q - p))
