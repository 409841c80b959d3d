"""Solid models of leaf springs of other shapes: short, thick, arched, twisted, tapered, stepped, slotted, skew.

As in ``solid_cases.py``: a leaf spring begins along x with its width along y; the foot is clamped whole, and a rigid
body is on the face of the tip. Sizes are in metres and stand here once, for the solid models and for the beams.
"""

from collections.abc import Callable

import numpy as np
from solid_cases import (
    AT_STROKE,
    MATERIAL,
    MESHES,
    SMALL,
    THICKNESS,
    Fineness,
    about,
    compliances,
    millimetres,
    stiffnesses,
)
from solid_models import Mesh, graded

# Length, width, thickness of plain strips.
SHORT, THICK, BROAD = (0.030, 0.030, 0.0003), (0.030, 0.012, 0.002), (0.025, 0.050, 0.0005)
GUIDED, GUIDED_STROKES = (0.1, 0.05, 0.0005), (0.010, 0.020)
# Of strips whose width varies: length, and the widths at foot, middle and tip.
TRAPEZOID, TRIANGLE, WAIST = (0.080, 0.030, 0.012), (0.080, 0.040, 0.004), (0.080, 0.030, 0.012)
TWISTED, TWIST = (0.1, 0.018, 0.0005), np.radians(30)
SKEW, SKEWNESS = (0.1, 0.030, 0.0005), np.radians((15, 30, 45))
# Cut of the foot of the trapezoid, and strokes of leaf springs of other shapes than a plain strip.
CUT, TENTH, SKEW_STROKES = np.radians(30), (0.008,), (0.005, 0.010)
# Arc: radius, angle, width, thickness. Arch: span, height, width, thickness.
ARC, ARC_STROKES = (0.060, np.radians(90), 0.020, 0.0004), {"apart": (0.0045,), "together": (0.0045, 0.009)}
ARCH, ARCH_STROKES = (0.1, 0.005, 0.010, 0.0005), (0.001, 0.002, 0.003, 0.005)
# Length of a part, wide and narrow.
STEPS = (0.030, 0.036, 0.012)
# Strips with a hole in the middle: length and width of the strip, and of the hole. Strokes with the first.
SLOT, OBLONG, HOLE = ((0.1, 0.030), (0.040, 0.010)), ((0.080, 0.020), (0.030, 0.008)), ((0.060, 0.024), (0.013, 0.013))
SLOT_STROKES = (0.010, 0.020)
# Parts in thickness: lengths and thicknesses.
STIFFENED = (0.018, (0.020, 0.060, 0.020))
# Parts in width and thickness: widths of the ends and of the middle, lengths.
WIDENED = (0.018, 0.036, (0.020, 0.060, 0.020))
# Leg, width and thickness of the fold, and its strokes along x.
FOLDED, FOLD_STROKES = (0.06, 0.03, 0.0005), (0.003, 0.006, 0.012)
# Sizes where the singular edges of clamps and skew corners count, and for a leaf spring that is thick.
SHARP = {"coarse": MESHES["fine"], "fine": Fineness(0.3, 1 / 9, 1.5, 2)}
# Of curved ones: with one element through the thickness their large displacements do not converge.
BENT = {"coarse": Fineness(1, 1 / 4, 2, 2), "fine": Fineness(0.6, 1 / 6, 1.8, 2)}
THROUGH = {"coarse": Fineness(0.25, 1 / 10, 1.5, 3), "fine": Fineness(0.12, 1 / 14, 1.4, 5)}


def strip(mesh: Mesh, fine: Fineness, length, width, thickness=THICKNESS, place: Callable | None = None) -> None:
    """Add one strip from x = 0 to its length, and name its ends.

    Args:
        mesh: Bricks, added to.
        fine: Sizes.
        length: Along x [m].
        width: Along y [m].
        thickness: Along z [m].
        place: Where its points lie, of x, y, z.
    """
    xs, ys = fine.along(0, length, width, thickness), fine.across(width, thickness)
    mesh.sets["FOOT"], mesh.sets["TIP"] = mesh.box(xs, ys, fine.thick(thickness), place)


def named(compliance: np.ndarray, guided: bool = True) -> dict[str, tuple[float, str]]:
    """Stiffnesses of a tip by name, each with all else free; with all else held along y and z where guided."""
    found = stiffnesses(compliance)
    if guided:
        stiffness = np.linalg.inv(compliance)
        found |= {f"rotations held, stiffness {a}": (stiffness[i, i], "N/m") for i, a in ((1, "y"), (2, "z"))}
    return found


def at_rest(fine: Fineness, build: Callable[[Mesh, Fineness], None], centre, guided: bool = True, material=MATERIAL):
    """Stiffnesses of the tip's body at rest.

    Args:
        fine: Sizes.
        build: Adds bricks and names the ends.
        centre: Of the tip's body [m].
        guided: Whether stiffnesses with all else held are wanted.
        material: Of all.
    """
    mesh = Mesh()
    build(mesh, fine)
    compliance, done = compliances(mesh, mesh.make_rigid("TIP", centre), material)
    return named(compliance, guided), done.seconds


def plain(fine: Fineness, sizes, place: Callable | None = None, centre=None, guided: bool = True, material=MATERIAL):
    """Stiffnesses of one strip whose points are placed elsewhere; of the tip's body at the end of the x axis."""
    length, width, thickness = sizes

    def build(mesh, fine):
        strip(mesh, fine, length, width, thickness, place)

    return at_rest(fine, build, centre or (length, 0, 0), guided, material)


def tapered(fine: Fineness, sizes):
    """Strip whose width varies linearly from foot to tip."""
    length, foot, tip = sizes
    return plain(fine, (length, foot, THICKNESS), lambda x, y, z: (x, y * (1 + (tip / foot - 1) * x / length), z))


def waist(place, sizes=WAIST):
    """Width of a waisted leaf spring at places from 0 to 1, of any array's kind."""
    _, wide, narrow = sizes
    return wide + (narrow - wide) * np.sin(np.pi * place) ** 2


def waisted(fine: Fineness):
    """Strip whose width narrows to its middle as a cosine."""
    return plain(fine, (*WAIST[:2], THICKNESS), narrowed)


def narrowed(x, y, z):
    """Where the points of the waisted leaf spring lie."""
    return x, y * waist(x / WAIST[0]) / WAIST[1], z


def cut(x, y, z):
    """Where the points of a trapezoid lie whose foot is cut at an angle; its edges stay those of the trapezoid."""
    length, foot, tip = TRAPEZOID
    slope, share = (tip - foot) / length, 2 * y / foot
    start = np.tan(CUT) * share * foot / 2 / (1 - np.tan(CUT) * share * slope / 2)
    at = start + x / length * (length - start)
    return at, share * (foot + slope * at) / 2, z


def cut_trapezoid(rest: Fineness, fine: Fineness):
    """Trapezoid whose foot is cut at an angle, at rest and with its tip moved along z."""
    sizes = (*TRAPEZOID[:2], THICKNESS)
    found, first = plain(rest, sizes, cut)
    here, second = guided(fine, sizes, TENTH, place=cut)
    return {f"0 mm, {k}": v for k, v in found.items()} | here, first + second


def twisted(fine: Fineness):
    """Strip that is twisted about x before any load, evenly."""

    def place(x, y, z):
        angle = TWIST * x / TWISTED[0]
        return x, y * np.cos(angle) - z * np.sin(angle), y * np.sin(angle) + z * np.cos(angle)

    return plain(fine, TWISTED, place)


def skew(fine: Fineness, foot: float, tip: float, sizes=SKEW, material=MATERIAL):
    """Strip whose ends are cut at angles; its middle line keeps its length."""
    return plain(fine, sizes, skewed(foot, tip, sizes[0]), material=material)


def skewed(foot: float, tip: float, length: float) -> Callable:
    """Where the points of a strip lie whose ends are cut at angles."""

    def place(x, y, z):
        return x + y * (np.tan(foot) * (1 - x / length) + np.tan(tip) * x / length), y, z

    return place


def arc(chord: bool) -> Callable:
    """Where the points of the arc lie: from the foot at the origin, tangent to x, towards +z; or its chord along x."""
    radius, angle, *_ = ARC
    back = angle / 2 if chord else 0.0

    def place(x, y, z):
        turned = x / radius
        ahead, up = (radius - z) * np.sin(turned), radius - (radius - z) * np.cos(turned)
        return ahead * np.cos(back) + up * np.sin(back), y, up * np.cos(back) - ahead * np.sin(back)

    return place


def curved(fine: Fineness):
    """Arc at rest, its chord along x."""
    radius, angle, width, thickness = ARC
    place = arc(chord=True)
    return plain(fine, (radius * angle, width, thickness), place, tuple(place(radius * angle, 0.0, 0.0)))


def curved_far(fine: Fineness):
    """Arc whose tip is pulled apart from its foot and pushed towards it along the chord, its rotations held."""
    radius, angle, width, thickness = ARC
    place, found, seconds = arc(chord=True), {}, 0.0
    for sign, name in ((1, "apart"), (-1, "together")):
        mesh = Mesh()
        strip(mesh, fine, radius * angle, width, thickness, place)
        body = mesh.make_rigid("TIP", tuple(place(radius * angle, 0.0, 0.0)))
        strokes, held = [sign * s for s in ARC_STROKES[name]], [(body[1], d, 0.0) for d in (1, 2, 3)]
        here, done = about(
            mesh, body, (body[0], 1), strokes, ("y",), lambda s, n=name: f"{n} {1e3 * abs(s):.1f} mm", held=held
        )
        found |= here
        seconds += done.seconds
    return found, seconds


def arch(x, y, z):
    """Where the points of half a cosine arch lie: by the place along the span, with the thickness along the normal."""
    span, height, *_ = ARCH
    turn = 2 * np.pi / span
    up, slope = height / 2 * (1 - np.cos(turn * x)), height / 2 * turn * np.sin(turn * x)
    size = np.hypot(1, slope)
    return x - z * slope / size, y, up + z / size


def arched(fine: Fineness):
    """Half of a cosine arch that is clamped at its foot, with a rigid part in its middle."""
    span, height, width, thickness = ARCH
    return plain(fine, (span / 2, width, thickness), arch, (span / 2, 0, height))


def arched_far(fine: Fineness):
    """Half of a cosine arch whose middle is moved down without turning.

    It moves from the height of the arch towards its mirror image. The force of a whole arch is twice that.
    """
    span, height, width, thickness = ARCH
    mesh = Mesh()
    strip(mesh, fine, span / 2, width, thickness, arch)
    body = mesh.make_rigid("TIP", (span / 2, 0, height))
    held = [(body[1], d, 0.0) for d in (1, 2, 3)] + [(body[0], d, 0.0) for d in (1, 2)]
    strokes = [-s for s in ARCH_STROKES]
    found, done = about(mesh, body, (body[0], 3), strokes, (), lambda s: f"down {1e3 * abs(s):.1f} mm", held=held)
    return found, done.seconds


def parts(mesh: Mesh, fine: Fineness, lengths, widths, thickness=THICKNESS) -> None:
    """Strips in line that share their middle line, of widths of their own."""
    ys_of = {}
    inner, outer = min(widths), max(widths)
    ys_of[inner] = fine.across(inner, thickness)
    # The wide parts have the narrow one's planes, and further ones that grow away from its edge.
    for w in sorted(set(widths) - {inner}):
        out = graded(inner / 2, w / 2, fine.first * thickness, fine.first * thickness, fine.most * outer, fine.growth)
        ys_of[w] = np.concatenate([-out[:0:-1], ys_of[inner], out[1:]])
    start, faces = 0.0, []
    for length, w in zip(lengths, widths, strict=True):
        # Fine at the steps as at the clamps; coarser than the narrow part nowhere by much.
        xs = fine.along(start, start + length, min(w, 1.5 * inner), thickness)
        faces.append(mesh.box(xs, ys_of[w], fine.thick(thickness)))
        start += length
    mesh.sets["FOOT"], mesh.sets["TIP"] = faces[0][0], faces[-1][1]


def stepped(fine: Fineness, lengths, widths, thickness=THICKNESS, material=MATERIAL):
    """Leaf spring whose width steps."""

    def build(mesh, fine):
        parts(mesh, fine, lengths, widths, thickness)

    return at_rest(fine, build, (sum(lengths), 0, 0), material=material)


def rectangular(mesh: Mesh, fine: Fineness, sizes=SLOT) -> None:
    """Add a strip from x = 0 with a slot in its middle, whose corners are sharp, and name its ends."""
    (length, width), (long, open_) = sizes
    start, end = (length - long) / 2, (length + long) / 2
    rail = (width - open_) / 2
    first = fine.first * THICKNESS
    ys_rail = graded(open_ / 2, width / 2, first, first, fine.most * rail, fine.growth)
    ys_slot = graded(0, open_ / 2, fine.most * rail, first, fine.most * rail, fine.growth)
    zs = fine.thick()
    right = np.concatenate([ys_slot, ys_rail[1:]])
    whole = np.concatenate([-right[:0:-1], right])
    foot, _ = mesh.box(fine.along(0, start, rail * 1.5), whole, zs)
    for ys in (ys_rail, -ys_rail[::-1]):
        mesh.box(fine.along(start, end, rail), ys, zs)
    _, tip = mesh.box(fine.along(end, length, rail * 1.5), whole, zs)
    mesh.sets["FOOT"], mesh.sets["TIP"] = foot, tip


def round_ended(mesh: Mesh, fine: Fineness, sizes) -> None:
    """Add a strip from x = 0 with a slot in its middle, whose ends are half circles, and name its ends.

    Around each end the bricks lie between the half circle and three sides of a rectangle. Their places along it are 0
    to 1 on the first side, 1 to 3 on the second, across the strip, and 3 to 4 on the last.
    """
    (length, width), (long, open_) = sizes
    half, radius, straight = width / 2, open_ / 2, (long - open_) / 2
    rail, first = half - radius, fine.first * THICKNESS
    outwards = graded(0, 1, first / rail, first / rail, fine.most, fine.growth)
    side = np.linspace(0, 1, 1 + round(1 / fine.most))
    corner = graded(0, 1, fine.most, first / half, fine.most, fine.growth)
    around = np.concatenate([side, 2 - corner[-2::-1], 2 + corner[1:], 4 - side[-2::-1]])

    def place(sign: int) -> Callable:
        def at(out, along, z):
            if 1 < along < 3:
                x, y = half, (along - 2) * half
            else:
                x, y = min(along, 4 - along) * half, np.sign(along - 2) * half
            shrunk = 1 + (radius / np.hypot(x, y) - 1) * (1 - out)
            return length / 2 + sign * (straight + x * shrunk), sign * y * shrunk, z

        return at

    zs = fine.thick()
    for sign in (1, -1):
        mesh.box(outwards, around, zs, place(sign))
    if straight > 0:
        xs = np.linspace(length / 2 - straight, length / 2 + straight, 1 + int(np.ceil(2 * straight / (rail / 2))))
        for ys in (radius + rail * outwards, -(radius + rail * outwards)[::-1]):
            mesh.box(xs, ys, zs)
    ys = half * np.concatenate([-corner[:0:-1], corner])
    foot, _ = mesh.box(fine.along(0, length / 2 - straight - half, width), ys, zs)
    _, tip = mesh.box(fine.along(length / 2 + straight + half, length, width), ys, zs)
    mesh.sets["FOOT"], mesh.sets["TIP"] = foot, tip


def holed(fine: Fineness, build: Callable, sizes):
    """Leaf spring with a hole.

    Args:
        fine: Sizes of elements.
        build: Adds a strip with a hole.
        sizes: Length and width of the strip, and of the hole.
    """
    return at_rest(fine, lambda mesh, fine: build(mesh, fine, sizes), (sizes[0][0], 0, 0))


def slotted_far(fine: Fineness):
    """Leaf spring with a rectangular slot whose tip is moved along z, its rotations held."""
    mesh = Mesh()
    rectangular(mesh, fine)
    return driven(mesh, (SLOT[0][0], 0.0, 0.0), SLOT_STROKES)


def stiffened(fine: Fineness, thick: float, sizes=STIFFENED):
    """Leaf spring whose middle part is thicker, by the same on both faces."""
    width, lengths = sizes

    def build(mesh, fine):
        ys, zs = fine.across(width), fine.thick()
        ends = np.cumsum([0.0, *lengths])
        up = graded(THICKNESS / 2, thick / 2, fine.first * THICKNESS, THICKNESS, THICKNESS, fine.growth)[1:]
        foot, _ = mesh.box(fine.along(ends[0], ends[1], width), ys, zs)
        mesh.box(fine.along(ends[1], ends[2], width), ys, np.concatenate([-up[::-1], zs, up]))
        _, tip = mesh.box(fine.along(ends[2], ends[3], width), ys, zs)
        mesh.sets["FOOT"], mesh.sets["TIP"] = foot, tip

    return at_rest(fine, build, (sum(lengths), 0, 0))


def widened(fine: Fineness, middle: float, ends: float, sizes=WIDENED):
    """Leaf spring whose middle part is wider, and of another thickness."""
    width, wide, lengths = sizes
    thin, thick = sorted((middle, ends))

    def build(mesh, fine):
        places = np.cumsum([0.0, *lengths])
        first = fine.first * thin
        ys, zs = fine.across(width, thin), fine.thick(thin)
        beside = graded(width / 2, wide / 2, first, 2 * first, fine.most * wide, fine.growth)[1:]
        up = graded(thin / 2, thick / 2, first, thin, thin, fine.growth)[1:]
        whole = np.concatenate([-up[::-1], zs, up])
        of_ends, of_middle = (whole, zs) if ends > middle else (zs, whole)
        foot, _ = mesh.box(fine.along(places[0], places[1], width), ys, of_ends)
        mesh.box(fine.along(places[1], places[2], width), np.concatenate([-beside[::-1], ys, beside]), of_middle)
        _, tip = mesh.box(fine.along(places[2], places[3], width), ys, of_ends)
        mesh.sets["FOOT"], mesh.sets["TIP"] = foot, tip

    return at_rest(fine, build, (sum(lengths), 0, 0))


def driven(mesh: Mesh, tip, strokes, axes=("x", "y"), small=SMALL):
    """Force and stiffnesses of a strip whose tip is moved along z, its rotations held."""
    body = mesh.make_rigid("TIP", tip)
    held = [(body[1], d, 0.0) for d in (1, 2, 3)]
    found, done = about(mesh, body, (body[0], 3), strokes, axes, millimetres, held=held, small=small)
    return found, done.seconds


def guided(fine: Fineness, sizes, strokes, axes=("x", "y"), small=SMALL, place: Callable | None = None):
    """Clamped strip whose tip is moved along z, its rotations held."""
    mesh = Mesh()
    strip(mesh, fine, *sizes, place)
    return driven(mesh, (sizes[0], 0.0, 0.0), strokes, axes, small)


def folded(rest: Fineness, fine: Fineness, strokes=FOLD_STROKES):
    """Wide fold by 90 degrees, one leg along x and one along z, whose tip is moved along x, rotations held."""
    leg, width, thickness = FOLDED

    def build(mesh, fine):
        ys, zs = fine.across(width, thickness), fine.thick(thickness)
        foot, _ = mesh.box(fine.along(0, leg - thickness / 2, width, thickness), ys, zs)
        mesh.box(leg + zs, ys, zs)
        mesh.box(leg + zs, ys, fine.along(thickness / 2, leg, width, thickness))
        mesh.sets["FOOT"] = foot
        mesh.pick("TIP", lambda p: p[:, 2] > leg - 1e-9)

    found, seconds = at_rest(rest, build, (leg, 0, leg))
    found = {f"0 mm, {k}": v for k, v in found.items()}
    mesh = Mesh()
    build(mesh, fine)
    body = mesh.make_rigid("TIP", (leg, 0, leg))
    held = [(body[1], d, 0.0) for d in (1, 2, 3)]
    here, done = about(mesh, body, (body[0], 1), strokes, ("y", "z"), millimetres, held=held)
    return found | here, seconds + done.seconds


def _angles(foot: bool, tip: bool):
    sizes = {a: SHARP if tip and a > np.radians(40) else MESHES for a in SKEWNESS}
    return {
        f"skew {np.degrees(a):.0f} degrees, {'both ends' if tip else 'foot alone'}": (
            lambda mesh, a=a: skew(sizes[a][mesh], a if foot else 0.0, a if tip else 0.0)
        )
        for a in SKEWNESS
    }


# Cases by name, as those of ``solid_cases.py``.
SHAPES: dict[str, Callable] = {
    "short leaf spring": lambda mesh: plain(SHARP[mesh], SHORT),
    "broad leaf spring": lambda mesh: plain(SHARP[mesh], BROAD),
    "thick leaf spring": lambda mesh: plain(THROUGH[mesh], THICK),
    "arc": lambda mesh: curved(MESHES[mesh]),
    "arc at strokes": lambda mesh: curved_far(BENT[mesh]),
    "cosine arch": lambda mesh: arched(MESHES[mesh]),
    "cosine arch at strokes": lambda mesh: arched_far(BENT[mesh]),
    "twisted leaf spring": lambda mesh: twisted(MESHES[mesh]),
    "trapezoid": lambda mesh: tapered(MESHES[mesh], TRAPEZOID),
    "triangle": lambda mesh: tapered(SHARP[mesh], TRIANGLE),
    "waist": lambda mesh: waisted(MESHES[mesh]),
    "steps in width": lambda mesh: stepped(MESHES[mesh], (STEPS[0],) * 3, (STEPS[1], STEPS[2], STEPS[1])),
    "slot": lambda mesh: holed(MESHES[mesh], rectangular, SLOT),
    "slot at strokes": lambda mesh: slotted_far(AT_STROKE[mesh]),
    "slot with round ends": lambda mesh: holed(MESHES[mesh], round_ended, OBLONG),
    "round hole": lambda mesh: holed(MESHES[mesh], round_ended, HOLE),
    "steps in thickness, 1.75 mm": lambda mesh: stiffened(MESHES[mesh], 0.00175),
    "steps in thickness, 5 mm": lambda mesh: stiffened(MESHES[mesh], 0.005),
    "wide thick middle": lambda mesh: widened(MESHES[mesh], 0.001, THICKNESS),
    "wide thin middle": lambda mesh: widened(MESHES[mesh], THICKNESS, 0.001),
    **_angles(True, True),
    **_angles(True, False),
    "wide fold": lambda mesh: folded(MESHES[mesh], AT_STROKE[mesh]),
    "guided leaf spring 50 mm wide, far": lambda mesh: guided(AT_STROKE[mesh], GUIDED, GUIDED_STROKES),
    "trapezoid, foot cut at 30 degrees": lambda mesh: cut_trapezoid(MESHES[mesh], AT_STROKE[mesh]),
    "waist at a stroke": lambda mesh: guided(AT_STROKE[mesh], (*WAIST[:2], THICKNESS), TENTH, place=narrowed),
    "skew 30 degrees, foot alone, at strokes": lambda mesh: guided(
        AT_STROKE[mesh], SKEW, SKEW_STROKES, place=skewed(CUT, 0.0, SKEW[0])
    ),
}
