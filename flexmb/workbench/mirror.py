"""Mirror images of things: positions, directions, rotations, inertia, and signs of deformations.

The x axis and the vector y of an element are mirrored. Its local z completes right-handed axes, and is therefore
opposite to the image of z. The y of a building block is mirrored and reversed: its motion is the image of the motion.
"""

import itertools
from typing import Any

import numpy as np

from ..build.description import AXES
from ..elements.general import OF_TRIANGLE, STRAINS
from ..errors import printable
from ..model.by_name import TURNS
from ..numerical_limits import TEN_DIGITS
from .building import Built, build
from .calls_of import UPPER
from .content import Document, EditError, Report, checked_text
from .copies import cloned, selected, with_position
from .edits import insert
from .fields import Call
from .image import mirror_signs, scalars_of
from .references import call_of, references, referred
from .values import arithmetic_value, negated, reflected

# Strains of a section that change sign where one of its axes is reversed.
REVERSED = {"y": ("shear_y", "twist", "curvature_z"), "z": ("shear_z", "twist", "curvature_y")}
# Vectors about which something turns: their images have the other sign.
AXIAL = ("moment",)


def mirror(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "mirror", "ids", "axis": "x", "at": "0", "keep"?: true}``: the images of things in the plane x = at.

    Nodes on the plane are their own images. Without "keep" the things are replaced by their images.
    """
    axis, at = op["axis"], checked_text("", op.get("at", "0"))
    if axis not in AXES[: document.dimension]:
        raise EditError("", f"The axis is '{printable(axis)}'. It must be {' or '.join(AXES[: document.dimension])}.")
    image = _Image(document, AXES.index(axis), at)
    if not op.get("keep", True):
        ids = {document.thing(id)["id"] for id in op["ids"]}
        items = [image.of(item) if item["id"] in ids else item for item in document.things]
        first = items[0]["id"] if items else None
        return image.with_sections(document.with_things(items), ids, first), Report([], [], "mirror")
    chosen = [item for item in selected(document, op["ids"]) if not image.is_on_plane(item)]
    mirrored, ids = cloned(document, chosen, image.of)
    mirrored = image.with_sections(mirrored, set(ids), ids[0] if ids else None)
    new = [item["id"] for item in mirrored.things if item["id"] not in document.by_id]
    return mirrored, Report(new, [], "mirror")


def _signed(texts: list[str], signs: Any) -> list[str]:
    """Texts of numbers, with the other sign where a sign is negative."""
    return [negated(text) if sign < 0 else text for text, sign in zip(texts, signs, strict=False)]


def _mirrored_section(section: dict[str, Any], turned: bool) -> dict[str, Any]:
    """Arguments of a section whose local z is reversed, or whose local y is where that is ``turned``."""
    args = dict(section["args"])
    if section["call"] not in ("Rigidity", "General"):
        return args
    changed = ["Jyz", "center_y" if turned else "center_z"]
    stiffness = args.get("stiffness")
    if isinstance(stiffness, list) and len(stiffness) in OF_TRIANGLE:
        reversed_ = REVERSED["y" if turned else "z"]
        signs = [-1 if name in reversed_ else 1 for name in STRAINS[OF_TRIANGLE[len(stiffness)]]]
        pairs = itertools.combinations_with_replacement(signs, 2)
        args["stiffness"] = [text if a == b else negated(text) for text, (a, b) in zip(stiffness, pairs, strict=True)]
    return args | {name: negated(args[name]) for name in changed if args.get(name, "0") != "0"}


class _Image:
    """The image of a document's things in a plane across an axis."""

    def __init__(self, document: Document, axis: int, at: str):
        self.document, self.axis, self.at, self.d = document, axis, at, document.dimension
        self.built: Built = build(document)
        self.turned = np.where(np.arange(self.d) == axis, -1.0, 1.0)

    def is_on_plane(self, thing: dict[str, Any]) -> bool:
        """Whether a node is its own image."""
        if thing["call"] != "node":
            return False
        numbers = self.built.numbers
        coordinate = numbers.get(f"{thing['id']}/position/{self.axis}")
        position = thing["args"].get("position")
        if coordinate is None or not isinstance(position, list) or len(position) != self.d:
            return False
        image_coordinate = self._value(reflected(position[self.axis], self.at))
        size = max([abs(v) for k, v in numbers.items() if "/position/" in k], default=0.0)
        return abs(image_coordinate - coordinate) <= TEN_DIGITS * size

    def _value(self, text: str) -> float:
        try:
            return float(arithmetic_value(self.document, text))
        except ValueError as fault:
            raise EditError("", f"The plane of the mirror is wrong: {fault}") from None

    def of(self, thing: dict[str, Any]) -> dict[str, Any]:
        """The image of a thing, with the same references."""
        call = call_of(thing)
        # Sections have their images in `with_sections`: their vectors are no directions.
        if call is None or call.kind == "record":
            return thing
        if "step" in thing["args"]:
            raise EditError(f"{thing['id']}/step", "A body of a STEP file cannot be mirrored. Give its numbers.")
        thing = with_position(thing, self._position)
        args = {key: self._argument(call, thing, key, value) for key, value in thing["args"].items()}
        if call.kind == "element":
            args |= self._orientation(call, thing) | self._signs(thing)
        elif call.kind == "block":
            args |= self._block(thing)
        return {**thing, "args": args}

    def _position(self, position: list[str]) -> list[str]:
        return [reflected(text, self.at) if k == self.axis else text for k, text in enumerate(position)]

    def _vector(self, vector: list[str], sign: int = 1) -> list[str]:
        """Image of a direction, or with sign -1 of an axis of rotation."""
        return [negated(text) if (k == self.axis) is (sign == 1) else text for k, text in enumerate(vector)]

    def _argument(self, call: Call, item: dict[str, Any], key: str, value: Any) -> Any:
        """Image of an argument; elements and blocks have more methods for arguments that are no vectors."""
        name = call.name.rpartition(".")[2]
        if key in ("value", "velocity") and name in ("prescribe", "start"):
            return negated(value) if self._sign_of_entry(item) < 0 else value
        if key == "values" and name in ("prestress", "strain"):
            values = [value] if isinstance(value, str) else value
            return _signed(values, self._parity(item, "element"))
        if key == "gradient":
            return self._gradient(item, value)
        kind = call.fields[key]["kind"] if key in call.fields else None
        if kind != "vector" or key in ("position", "change", "breaks", "curvature", "skew", "clamp", "values"):
            return value
        if key == "at" and call.kind == "block":
            return value
        if key == "inertia":
            return self._tensor(value)
        if name == "rotation":
            return self._rotation(value)
        if isinstance(value, str) or len(value) == 1:
            # A rotation in the plane.
            return negated(value) if isinstance(value, str) else [negated(value[0])]
        axial = key in AXIAL or (name == "prescribe" and key == "axis")
        return self._vector(value, -1 if axial else 1)

    def _tensor(self, value: Any) -> Any:
        """Image of (Ixx, Ixy, Ixz, Iyy, Iyz, Izz): products of inertia with the axis across the plane change sign."""
        if not isinstance(value, list) or len(value) != 6:
            return value
        pairs = zip(value, UPPER, strict=True)
        return [negated(text) if (i == self.axis) is not (j == self.axis) else text for text, (i, j) in pairs]

    def _rotation(self, value: Any) -> Any:
        """Image of an angle or of Euler parameters, whose last three lie along the axis of rotation."""
        if isinstance(value, str):
            return negated(value)
        return [negated(value[0])] if len(value) == 1 else [value[0], *self._vector(value[1:], -1)]

    def _orientation(self, call: Call, item: dict[str, Any]) -> dict[str, Any]:
        """The vector y of a spatial element with the default y, if its image has another default."""
        if "y" not in call.fields or item["args"].get("y"):
            return {}
        member = self.built.builder.members.get(item.get("name", ""))
        if member is None:
            return {}
        ends = [node.start for n in member.nodes if (node := self.built.builder.nodes[n]).kind.part == "position"]
        along = np.abs(np.asarray(ends[1], float) - np.asarray(ends[0], float))
        if np.argmin(along) != self.axis or not along.any():
            return {}
        return {"y": ["-1" if k == self.axis else "0" for k in range(3)]}

    def _signs(self, item: dict[str, Any]) -> dict[str, Any]:
        """Numbers of an element that change sign, such as a pitch or an initial curvature."""
        member = self.built.builder.members.get(item.get("name", ""))
        known = scalars_of(member) if member is not None else {}
        args = {key: value for key, value in item["args"].items() if key in known}
        if not args:
            return {}
        flips, _ = self._image_of(item["name"], item["id"])
        return {
            key: negated(value) if isinstance(value, str) else _signed(value, flips[key])
            for key, value in args.items()
            if np.any(np.asarray(flips.get(key, 1)) < 0)
        }

    def _parity(self, item: dict[str, Any], key: str) -> np.ndarray:
        """Sign of each deformation in the image of the element that a thing refers to."""
        return self._image_of(item["args"][key], f"{item['id']}/{key}")[1]

    def _image_of(self, name: str, address: str) -> tuple[dict[str, Any], np.ndarray]:
        member = self.built.builder.members.get(name)
        if member is None:
            raise EditError(address, f"'{printable(name)}' has problems. Solve them before you mirror it.")
        nodes = [self.built.builder.nodes[node] for node in member.nodes]
        references = [np.asarray(node.start, float) for node in nodes]
        image = mirror_signs(member, references, [node.kind for node in nodes], self.axis, self._y_turns(name))
        if image is None:
            raise EditError(address, f"'{printable(name)}' ({member.element.name}) has no mirror image of its type.")
        return image

    def _y_turns(self, name: str) -> bool:
        """Whether the image of an element has a reversed y: elements of blocks."""
        id = self.document.known.thing(("element",), name)
        return id is not None and call_of(self.document.by_id[id]).kind == "block"  # pyright: ignore

    def _sign_of_entry(self, item: dict[str, Any]) -> int:
        """Sign of the image of the coordinate or deformation that a thing refers to."""
        owner, component = item["args"].get("of", ""), str(item["args"].get("component", ""))
        known, kind = self.document.known, item["args"].get("kind")
        is_node = kind == "node" or (kind != "element" and owner in self.built.builder.nodes)
        if not is_node and (kind == "element" or known.thing(("element",), owner)):
            signs = self._parity(item, "of")
            number = self.built.builder.members[owner].element.number_of(component) or 0
            return int(signs[number - 1]) if 0 < number <= len(signs) else 1
        if component == "rotation":
            return 1 if self.d == 3 else -1
        if component == "phi":
            return -1
        if component in ("l1", "l2", "l3"):
            return 1 if int(component[1]) - 1 == self.axis else -1
        if component in TURNS:
            return 1 if TURNS.index(component) == self.axis else -1
        node = self.built.builder.nodes.get(owner)
        if node is not None and node.kind.part == "rotation":
            letters = node.kind.components
            letter = letters[int(component) - 1] if component.isdecimal() and 0 < int(component) <= len(letters) else ""
            inner = {**item, "args": {**item["args"], "component": letter or "x"}}
            return self._sign_of_entry(inner) if letter else 1
        return -1 if component in (AXES[self.axis], str(self.axis + 1)) else 1

    def _gradient(self, item: dict[str, Any], value: Any) -> Any:
        """Image of a gradient along local z in the plane, along local y and z in space."""
        if isinstance(value, str):
            return negated(value)
        turned = 0 if self.d == 2 or self._y_turns(item["args"].get("element", "")) else 1
        return [negated(text) if k == turned else text for k, text in enumerate(value)]

    def with_sections(self, document: Document, ids: set[str], before: str | None) -> Document:
        """A document with mirrored sections for images; only a product of inertia or a general stiffness needs them."""
        known, number = self.document.known, document.data["next"]
        new_sections: dict[str, dict[str, Any]] = {}
        if self.d == 2:
            return document
        new_items = []
        for item in document.things:
            id = known.thing(("section",), item["args"].get("section") or "")
            section = self.document.by_id[id] if id else None
            call = call_of(item)
            args = _mirrored_section(section, call is not None and call.kind == "block") if section else None
            if id and section and item["id"] in ids and args != section["args"]:
                if id not in new_sections:
                    name, new_id = known.unused(f"{section['name']} mirrored"), str(number + len(new_sections))
                    new_sections[id] = {"id": new_id, "call": section["call"], "name": name, "args": args}
                item = {**item, "args": {**item["args"], "section": new_sections[id]["name"]}}
            new_items.append(item)
        return insert(document.with_things(new_items), list(new_sections.values()), before)

    def _block(self, item: dict[str, Any]) -> dict[str, Any]:
        """Arguments of the image of a block; its points must be the images of the points of the block."""
        args = item["args"]
        default = ["0", "1", "0"][: self.d]
        vectors: dict[str, Any] = {}
        along = self._vector(args.get("along") or default)
        if args.get("along") or along != default:
            vectors["along"] = along
        if self.d == 3:
            y = [negated(text) for text in self._vector(args.get("y") or ["0", "0", "1"])]
            if args.get("y") or y != ["0", "0", "1"]:
                vectors["y"] = y
        scalars = [key for key, value in args.items() if key in ("apart", "fold") and isinstance(value, str)]
        if self.d == 2 and item["call"] == "blocks.folded_leaf_spring" and "fold" not in args:
            scalars.append("fold")
        if item["id"] not in self.built.made:
            raise EditError(item["id"], "The block has problems. Solve them before you mirror it.")
        image_points = {name: self._reflected(place) for name, place in self._points(self.built, item).items()}
        inner = self._inner(item)
        for flips in sorted(itertools.product((False, True), repeat=len(scalars)), key=sum):
            flipped = [key for key, flip in zip(scalars, flips, strict=True) if flip]
            signs = {key: negated(args.get(key, repr(np.pi / 2))) for key in flipped}
            trial = {**item, "args": {**args, **vectors, **signs}}
            if self._agrees(self._points_alone(trial), image_points, inner):
                return {**vectors, **signs}
        name = printable(item["name"])
        raise EditError(item["id"], f"Block '{name}' has no mirror image as a block. Explode it first.")

    def _inner(self, item: dict[str, Any]) -> set[str]:
        """Names of the block's own nodes that other things refer to."""
        inner_names, start = set(), f"{item['name']} "
        for other in self.document.things:
            known = referred(self.document.known, other)
            for address, _, name in references(other):
                if known.get(address) == item["id"] and other is not item and name.startswith(start):
                    inner_names.add(name.removeprefix(start))
        return inner_names - {""}

    def _points(self, built: Built, block: dict[str, Any]) -> dict[str, np.ndarray]:
        """Places of the nodes that a block makes and that begin with its name."""
        placements = [call.positional for call in built.made.get(block["id"], []) if call.method == "node"]
        return {name: np.asarray(place, float) for name, place in placements if name.startswith(f"{block['name']} ")}

    def _reflected(self, point: np.ndarray) -> np.ndarray:
        return self.turned * point + np.where(np.arange(self.d) == self.axis, 2 * self._value(self.at), 0.0)

    def _points_alone(self, item: dict[str, Any]) -> dict[str, np.ndarray]:
        """Points of a block on the image of its base."""
        known = self.document.known
        records = [t for t in self.document.things if (c := call_of(t)) and c.makes in ("section", "material")]
        base = item["args"].get("base", "")
        start = self.built.builder.nodes.get(base)
        if start is None or known.thing(("node",), base) is None:
            raise EditError(f"{item['id']}/base", "The block has problems. Solve them before you mirror it.")
        place = self._reflected(np.asarray(start.start, float))
        node = {"id": "0", "call": "node", "name": base, "args": {"position": [repr(float(v)) for v in place]}}
        return self._points(build(self.document.with_things([*records, node, item])), item)

    def _agrees(
        self, trial_points: dict[str, np.ndarray], image_points: dict[str, np.ndarray], inner: set[str]
    ) -> bool:
        """Whether points are the same; by name if other things refer to the inner points."""
        if set(trial_points) != set(image_points) or not image_points:
            return False
        size = max(float(np.max(np.abs(p))) for p in image_points.values()) or 1.0
        by_name = all(np.max(np.abs(trial_points[n] - image_points[n])) <= TEN_DIGITS * size for n in image_points)
        if inner or by_name:
            return by_name
        grid = 10 * TEN_DIGITS * size
        rows = [sorted(np.round(p / grid).tolist() for p in points.values()) for points in (trial_points, image_points)]
        return bool(np.allclose(rows[0], rows[1], rtol=0, atol=2))


OPERATIONS = {"mirror": mirror}
