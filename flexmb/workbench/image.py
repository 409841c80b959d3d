"""The mirror image of one element: signs of its numbers and of its deformations."""

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

from ..build.description import Member
from ..compilation.by_meaning import jit
from ..elements.element import Element
from ..numerical_limits import NEGLIGIBLE

# Signs of the strain fields of a beam in series: elongation; in space also twist, bending about y and z, shear.
FIELDS = {2: (1, -1), 3: (1, -1, -1, 1, 1, -1)}
# Signs of its initial curvature: twist, about y, about z.
CURVATURE = {2: (-1,), 3: (-1, -1, 1)}


def scalars_of(member: Member) -> dict[str, np.ndarray]:
    """Numbers of an element's geometry that may change sign: arguments of its deformation without directions."""
    arguments = member.element.of_deformation(member.properties)
    others = ("section", "clamped", "clamp")
    return {
        key: np.asarray(value, float)
        for key, value in arguments.items()
        if value is not None and key not in others and not _is_direction(key)
    }


def mirror_signs(
    member: Member, references: list[np.ndarray], kinds: list[Any], axis: int, y_turns: bool
) -> tuple[dict[str, Any], np.ndarray] | None:
    """Signs of an element's numbers and of its deformations in its mirror image; None if it has none.

    The signs of beams in series are known. For other elements the deformation function is evaluated at random states
    and at the images of these states. Signs for which both agree make the image.
    """
    element, d = member.element, kinds[0].dimension
    if element.fields:
        signs = np.ones(len(member.roles))
        flips = np.array(FIELDS[d])
        if d == 3:
            # Displacements and tilts of the closure; of warping the twist rates.
            closure = np.array([1, 1, -1, -1, -1, 1])
            if y_turns:
                flips, closure = np.array([1, -1, 1, -1, -1, 1]), np.array([1, -1, 1, -1, 1, -1])
            signs[: element.fields[0][0] - 1] = np.resize([*closure, -1, -1], element.fields[0][0] - 1)
        else:
            signs[:3] = (1, -1, -1)
        for sign, numbers in zip(flips, element.fields, strict=False):
            signs[np.array(numbers) - 1] = sign
        curved = CURVATURE[d] if not y_turns else (-1, 1, -1)
        skew = np.full(2, -1 if y_turns else 1)
        return {"curvature": np.array(curved if d == 3 else curved[0]), "skew": skew}, signs
    properties, scalars = element.of_deformation(member.properties), scalars_of(member)
    fixed = {key: value for key, value in properties.items() if key not in scalars}
    turned = {
        key: v if v is None or not _is_direction(key) else _turned(np.asarray(v, float), axis, y_turns and key == "y")
        for key, v in fixed.items()
    }
    if d == 3 and "y" in properties and properties["y"] is None:
        ends = [r for r, kind in zip(references, kinds, strict=True) if kind.part == "position"]
        default = np.eye(3)[np.argmin(np.abs(ends[1] - ends[0]))] if len(ends) > 1 else None
        turned["y"] = None if default is None else _turned(default, axis, y_turns)
    random = np.random.default_rng(7)
    states = [[r + 0.05 * random.normal(size=r.shape) for r in references] for _ in range(3)]
    deformation = _deformation(element)
    ours = [deformation(state, references, properties) for state in states]
    images = [[_coordinates(x, k, axis) for x, k in zip(s, kinds, strict=True)] for s in [*states, references]]
    sizes = {key: value.shape for key, value in scalars.items()}
    count = sum(int(np.prod(size)) for size in sizes.values())
    for signs in sorted(itertools.product((1, -1), repeat=count), key=lambda s: -sum(s)):
        remaining_signs, flips = list(signs), {}
        for key, size in sizes.items():
            n = int(np.prod(size))
            flips[key], remaining_signs = np.reshape(remaining_signs[:n], size), remaining_signs[n:]
        image_properties = turned | {key: value * flips[key] for key, value in scalars.items()}
        theirs = [deformation(image, images[-1], image_properties) for image in images[:-1]]
        deformation_signs = _signs_between(np.array(ours), np.array(theirs))
        if deformation_signs is not None:
            return flips, deformation_signs
    return None


def _is_direction(key: str) -> bool:
    return key == "y" or key.startswith("axis")


def _turned(vector: np.ndarray, axis: int, turns: bool) -> np.ndarray:
    image = np.where(np.arange(len(vector)) == axis, -vector, vector)
    return -image if turns else image


def _coordinates(x: np.ndarray, kind: Any, axis: int) -> np.ndarray:
    """Coordinates of the image of a node, in the plane through the origin."""
    if kind.part == "position":
        return np.where(np.arange(kind.size) == axis, -x, x)
    if kind.part == "rotation" and kind.dimension == 3:
        return np.append(x[:1], np.where(np.arange(3) == axis, x[1:], -x[1:]))
    return -x


def _deformation(element: Element) -> Callable[..., np.ndarray]:
    """Deformations of an element as a function of its state, its reference and its properties."""
    options = dict(element.alone().options)
    angle_options = {"near": np.zeros(64)} if element.tracks_angle else {}

    @jit
    def compiled(state: list[Any], references: list[Any], properties: dict[str, Any]):
        return element.deformation(*state, ref=element.reference(references), **angle_options, **options, **properties)

    return lambda *inputs: np.asarray(compiled(*inputs), float)


def _signs_between(ours: np.ndarray, theirs: np.ndarray) -> np.ndarray | None:
    """Signs by which deformations at states and at their images differ; None if they differ otherwise."""
    if ours.shape[1] == 0:
        return np.ones(0)
    signs = np.where(np.sum(ours * theirs, axis=0) < 0, -1.0, 1.0)
    return signs if np.max(np.abs(theirs - signs * ours)) <= NEGLIGIBLE * np.max(np.abs(ours)) else None
