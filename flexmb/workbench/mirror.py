"""Mirrored copies of things: positions, directions, what turns, inertia, and the signs of deformations.

An element's mirror image has its x axis and its vector y mirrored, so that its local z, which completes right-handed
axes, is opposite to the image of z. A building block's y is mirrored and turned round, so that its motion, along times
y, is the image of the motion.
"""

import itertools
from typing import Any

import numpy as np

from ..build.description import AXES
from ..errors import clean
from ..model.by_name import TURNS
from .building import Built, build
from .content import Document, EditError, Report, checked_text
from .copies import cloned, moved, selected
from .fields import Call
from .image import image_of, scalars_of
from .references import call_of, references, referred
from .sums import negated, reflected
from .values import value_in

# Vectors that say how something turns: their image has the other sign.
AXIAL = ("moment",)
# Two values agree to this, of the largest of them.
ALIKE = 1e-9


def mirror(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "mirror", "ids", "axis": "x", "at": "0", "keep"?: true}``: the image of things in the plane x = at.

    Nodes on the plane are their own images. Without "keep" the things themselves become their image, gravity among
    them.
    """
    axis, at = op["axis"], checked_text("", op.get("at", "0"))
    if axis not in AXES[: document.dimension]:
        raise EditError("", f"The axis is one of {', '.join(AXES[: document.dimension])}, not '{clean(axis)}'.")
    image = _Image(document, AXES.index(axis), at)
    if not op.get("keep", True):
        ids = {document.thing(id)["id"] for id in op["ids"]}
        things = [image.of(thing) if thing["id"] in ids else thing for thing in document.things]
        made = image.with_sections(things, ids, document.data["next"])
        number = document.data["next"] + len(made) - len(things)
        return document.with_things(made, next=number), Report([], [], "mirror")
    chosen = selected(document, op["ids"])
    shared = {thing["id"]: thing["id"] for thing in chosen if image.is_on_plane(thing)}
    made, ids = cloned(document, chosen, image.of, shared)
    new = set(ids)
    things = [thing for thing in made.things if thing["id"] in new]
    rest = [thing for thing in made.things if thing["id"] not in new]
    things = image.with_sections(things, new, made.data["next"])
    kept = {thing["id"] for thing in things}
    number = made.data["next"] + len(kept - new)
    return made.with_things([*rest, *things], next=number), Report([thing["id"] for thing in things], [], "mirror")


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
        here = numbers.get(f"{thing['id']}/position/{self.axis}")
        own = thing["args"].get("position")
        if here is None or not isinstance(own, list) or len(own) != self.d:
            return False
        there = self._value(reflected(own[self.axis], self.at))
        size = max([abs(v) for k, v in numbers.items() if "/position/" in k], default=0.0)
        return abs(there - here) <= ALIKE * size

    def _value(self, text: str) -> float:
        try:
            return float(value_in(self.document, text))
        except ValueError as fault:
            raise EditError("", f"The plane of a mirror: {fault}") from None

    def of(self, thing: dict[str, Any]) -> dict[str, Any]:
        """The image of a thing; references stay."""
        call = call_of(thing)
        if call is None:
            return thing
        if "step" in thing["args"]:
            raise EditError(f"{thing['id']}/step", "A body of a STEP file has no mirror image: give its numbers.")
        thing = moved(thing, self._position)
        args = {key: self._argument(call, thing, key, value) for key, value in thing["args"].items()}
        if call.kind == "element":
            args |= self._orientation(call, thing)
            args |= self._signs(thing)
        elif call.kind == "block":
            args |= self._block(thing)
        return {**thing, "args": args}

    def _position(self, own: list[str]) -> list[str]:
        return [reflected(text, self.at) if k == self.axis else text for k, text in enumerate(own)]

    def _vector(self, own: list[str], sign: int = 1) -> list[str]:
        """Image of a direction, with ``sign`` -1 that of what turns about it."""
        return [negated(text) if (k == self.axis) is (sign == 1) else text for k, text in enumerate(own)]

    def _argument(self, call: Call, thing: dict[str, Any], key: str, value: Any) -> Any:
        """Image of one argument; those of elements and blocks that are no vectors stand in methods of their own."""
        name = call.name.rpartition(".")[2]
        if key in ("value", "velocity") and name in ("prescribe", "start"):
            return negated(value) if self._sign_of_entry(thing) < 0 else value
        if key == "values" and name in ("prestress", "strain"):
            own = [value] if isinstance(value, str) else value
            signs = self._parity(thing, "element")
            return [negated(text) if sign < 0 else text for text, sign in zip(own, signs, strict=False)]
        if key == "gradient":
            return self._gradient(thing, value)
        kind = call.fields[key]["kind"] if key in call.fields else None
        if kind != "vector" or key in ("position", "change", "breaks", "curvature", "values"):
            return value
        if key == "at" and call.kind == "block":
            return value
        if key == "inertia":
            return self._tensor(value)
        if name == "rotation":
            return self._rotation(value)
        if isinstance(value, str) or len(value) == 1:
            # What turns in the plane.
            one = value if isinstance(value, str) else value[0]
            return negated(one) if isinstance(value, str) else [negated(one)]
        axial = key in AXIAL or (name == "prescribe" and key == "axis")
        return self._vector(value, -1 if axial else 1)

    def _tensor(self, value: Any) -> Any:
        """Of (Ixx, Ixy, Ixz, Iyy, Iyz, Izz) those of two different axes, one of which is across the plane."""
        if not isinstance(value, list) or len(value) != 6:
            return value
        pairs = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
        return [
            negated(text) if (i == self.axis) is not (j == self.axis) else text
            for text, (i, j) in zip(value, pairs, strict=True)
        ]

    def _rotation(self, value: Any) -> Any:
        """An angle, or Euler parameters, whose last three lie along the axis of the rotation."""
        if isinstance(value, str):
            return negated(value)
        return [negated(value[0])] if len(value) == 1 else [value[0], *self._vector(value[1:], -1)]

    # -- elements ---------------------------------------------------------------------------------------------------

    def _orientation(self, call: Call, thing: dict[str, Any]) -> dict[str, Any]:
        """The vector y of a spatial element whose own is the default, where the default of its image is another."""
        if "y" not in call.fields or thing["args"].get("y"):
            return {}
        member = self.built.builder.members.get(thing.get("name", ""))
        if member is None:
            return {}
        ends = [node.start for n in member.nodes if (node := self.built.builder.nodes[n]).kind.part == "position"]
        along = np.abs(np.asarray(ends[1], float) - np.asarray(ends[0], float))
        if np.argmin(along) != self.axis or not along.any():
            return {}
        return {"y": ["-1" if k == self.axis else "0" for k in range(3)]}

    def _signs(self, thing: dict[str, Any]) -> dict[str, Any]:
        """Numbers of an element that change their sign: a pitch, an initial curvature."""
        own = {key: value for key, value in thing["args"].items() if self._may_change(thing, key)}
        if not own:
            return {}
        flips, _ = self._image_of(thing["name"], thing["id"])
        return {
            key: negated(value)
            if isinstance(value, str)
            else [negated(v) if s < 0 else v for v, s in zip(value, flips[key], strict=False)]
            for key, value in own.items()
            if np.any(np.asarray(flips.get(key, 1)) < 0)
        }

    def _may_change(self, thing: dict[str, Any], key: str) -> bool:
        member = self.built.builder.members.get(thing.get("name", ""))
        return member is not None and key in scalars_of(member)

    def _parity(self, thing: dict[str, Any], key: str) -> np.ndarray:
        """Sign of each deformation of the element that a thing is about, in its image."""
        return self._image_of(thing["args"][key], f"{thing['id']}/{key}")[1]

    def _image_of(self, name: str, address: str) -> tuple[dict[str, Any], np.ndarray]:
        member = self.built.builder.members.get(name)
        if member is None:
            raise EditError(address, f"'{clean(name)}' cannot be mirrored before its problems are solved.")
        nodes = [self.built.builder.nodes[node] for node in member.nodes]
        references = [np.asarray(node.start, float) for node in nodes]
        found = image_of(member, references, [node.kind for node in nodes], self.axis, self._y_turns(name))
        if found is None:
            raise EditError(address, f"'{clean(name)}' ({member.element.name}) has no mirror image of its kind.")
        return found

    def _y_turns(self, name: str) -> bool:
        """Whether the image of an element has its y turned round: those of blocks."""
        id = self.document.known.thing(("element",), name)
        return id is not None and call_of(self.document.by_id[id]).kind == "block"  # pyright: ignore

    def _sign_of_entry(self, thing: dict[str, Any]) -> int:
        """Sign of the coordinate or deformation that a thing is about, in the image."""
        of, component = thing["args"].get("of", ""), str(thing["args"].get("component", ""))
        known, kind = self.document.known, thing["args"].get("kind")
        is_node = kind == "node" or (kind != "element" and of in self.built.builder.nodes)
        if not is_node and (kind == "element" or known.thing(("element",), of)):
            signs = self._parity(thing, "of")
            number = self.built.builder.members[of].element.number_of(component) or 0
            return int(signs[number - 1]) if 0 < number <= len(signs) else 1
        if component == "rotation":
            return 1 if self.d == 3 else -1
        if component == "phi":
            return -1
        if component in ("l1", "l2", "l3"):
            return 1 if int(component[1]) - 1 == self.axis else -1
        if component in TURNS:
            return 1 if TURNS.index(component) == self.axis else -1
        node = self.built.builder.nodes.get(of)
        if node is not None and node.kind.part == "rotation":
            letters = node.kind.components
            letter = letters[int(component) - 1] if component.isdecimal() and 0 < int(component) <= len(letters) else ""
            inner = {**thing, "args": {**thing["args"], "component": letter or "x"}}
            return self._sign_of_entry(inner) if letter else 1
        return -1 if component in (AXES[self.axis], str(self.axis + 1)) else 1

    def _gradient(self, thing: dict[str, Any], value: Any) -> Any:
        """Across the element: along local z in the plane; along local y and z in space."""
        if self.d == 2:
            return negated(value) if isinstance(value, str) else [negated(one) for one in value]
        turned = 0 if self._y_turns(thing["args"].get("element", "")) else 1
        return [negated(one) if k == turned else one for k, one in enumerate(value)]

    def with_sections(self, things: list[dict[str, Any]], ids: set[str], number: int) -> list[dict[str, Any]]:
        """Things, of which some have the sections of images: others where there is a product of inertia."""
        known, made = self.document.known, {}
        if self.d == 2:
            return things
        found = []
        for thing in things:
            id = known.thing(("section",), thing["args"].get("section") or "")
            section = self.document.by_id[id] if id else None
            product = section["args"].get("Jyz", "0") if section and section["call"] == "Rigidity" else "0"
            if thing["id"] not in ids or section is None or product == "0":
                found.append(thing)
                continue
            if id not in made:
                name = f"{section['name']} mirrored"
                while name in known.by_space["section"]:
                    name += "'"
                args = {**section["args"], "Jyz": negated(product)}
                made[id] = {"id": str(number + len(made)), "call": "Rigidity", "name": name, "args": args}
            found.append({**thing, "args": {**thing["args"], "section": made[id]["name"]}})
        return [*made.values(), *found]

    # -- building blocks --------------------------------------------------------------------------------------------

    def _block(self, thing: dict[str, Any]) -> dict[str, Any]:
        """Arguments of the image of a block, tried: its points must be the images of the points of the block."""
        own = thing["args"]
        default = ["0", "1", "0"][: self.d]
        found: dict[str, Any] = {}
        along = self._vector(own.get("along") or default)
        if own.get("along") or along != default:
            found["along"] = along
        if self.d == 3:
            y = [negated(one) for one in self._vector(own.get("y") or ["0", "0", "1"])]
            if own.get("y") or y != ["0", "0", "1"]:
                found["y"] = y
        scalars = [key for key, value in own.items() if key in ("apart", "fold") and isinstance(value, str)]
        if self.d == 2 and thing["call"] == "blocks.folded_leaf_spring" and "fold" not in own:
            scalars.append("fold")
        if thing["id"] not in self.built.made:
            raise EditError(thing["id"], "A block cannot be mirrored before its problems are solved.")
        wanted = {name: self._reflected(place) for name, place in self._points(self.built, thing).items()}
        inner = self._inner(thing)
        for flips in sorted(itertools.product((False, True), repeat=len(scalars)), key=sum):
            signs = {
                key: negated(own.get(key, repr(np.pi / 2))) for key, flip in zip(scalars, flips, strict=True) if flip
            }
            trial = {**thing, "args": {**own, **found, **signs}}
            if self._agrees(self._points_alone(trial), wanted, inner):
                return {**found, **signs}
        raise EditError(
            thing["id"], f"Block '{clean(thing['name'])}' has no mirror image as a block: explode it first."
        )

    def _inner(self, thing: dict[str, Any]) -> set[str]:
        """Names of the block's own nodes that other things refer to."""
        found = set()
        for other in self.document.things:
            known = referred(self.document.known, other)
            for address, _, name in references(other):
                if known.get(address) == thing["id"] and other is not thing:
                    found.add(name.removeprefix(f"{thing['name']} ") if name.startswith(f"{thing['name']} ") else "")
        return {name for name in found if name}

    def _points(self, built: Built, block: dict[str, Any]) -> dict[str, np.ndarray]:
        """Places of the nodes that a block makes and that bear its name."""
        made = [call.positional for call in built.made.get(block["id"], []) if call.method == "node"]
        return {name: np.asarray(place, float) for name, place in made if name.startswith(f"{block['name']} ")}

    def _reflected(self, point: np.ndarray) -> np.ndarray:
        return self.turned * point + np.where(np.arange(self.d) == self.axis, 2 * self._value(self.at), 0.0)

    def _points_alone(self, thing: dict[str, Any]) -> dict[str, np.ndarray]:
        """Points of a block that stands on the image of its base."""
        known = self.document.known
        records = [t for t in self.document.things if (c := call_of(t)) and c.makes in ("section", "material")]
        base = thing["args"].get("base", "")
        start = self.built.builder.nodes.get(base)
        if start is None or known.thing(("node",), base) is None:
            raise EditError(f"{thing['id']}/base", "A block cannot be mirrored before its problems are solved.")
        place = self._reflected(np.asarray(start.start, float))
        node = {"id": "0", "call": "node", "name": base, "args": {"position": [repr(float(v)) for v in place]}}
        return self._points(build(self.document.with_things([*records, node, thing])), thing)

    def _agrees(self, found: dict[str, np.ndarray], wanted: dict[str, np.ndarray], inner: set[str]) -> bool:
        """Whether points are the same, those that others refer to by their names."""
        if set(found) != set(wanted) or not wanted:
            return False
        size = max(float(np.max(np.abs(p))) for p in wanted.values()) or 1.0
        by_name = [np.max(np.abs(found[n] - wanted[n])) <= ALIKE * size for n in wanted]
        if inner:
            return all(by_name)
        rows = [sorted(np.round(p / (10 * ALIKE * size)).tolist() for p in own.values()) for own in (found, wanted)]
        return all(by_name) or bool(np.allclose(rows[0], rows[1], rtol=0, atol=2))


OPERATIONS = {"mirror": mirror}
