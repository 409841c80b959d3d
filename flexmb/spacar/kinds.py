"""Element types in SPACAR input files, and the order of their numbers, for reading and writing."""

import dataclasses
from typing import Any

from ..build.assemble import stack
from ..elements import planar, spatial
from ..elements.element import Element
from ..elements.nodes import NodeKind
from ..elements.sections import Damping, Material, Rectangle, Rigidity
from .lines import is_zero

# A number that must be zero, since the element has no such property.
NOTHING = ""
# Default number of coefficients of each strain field of a spectral beam.
ORDER = 4
# Numbers of SECTION in order.
SIZES = ("width", "thickness", "E", "G", "rho", "alpha")


@dataclasses.dataclass(frozen=True)
class ElementKind:
    """The description of one element type in a file.

    Attributes:
        keyword: Keyword.
        element: Element type; for a spectral beam of the default order.
        form: Parameters of the keyword, see lines.parse.
        stiffness: Names in Rigidity of the numbers of ESTIFF, in order; ("stiffness",) * n for a hinge.
        mass: Names in Rigidity of the numbers of EM.
        damping: Names in Damping of the numbers of EDAMP; ("damping",) * n for a hinge.
        numbers: Other numbers of the form and their properties, in the order of the form.
        sized: Whether SECTION gives sizes and material, instead of ESTIFF and EM.
    """

    keyword: str
    element: Element
    form: str
    stiffness: tuple[str, ...] = ()
    mass: tuple[str, ...] = ()
    damping: tuple[str, ...] = ()
    numbers: tuple[tuple[str, str], ...] = ()
    sized: bool = False

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return next(iter(self.element.nodes.values())).dimension

    @property
    def node_names(self) -> list[str]:
        """Names of the node numbers in the form."""
        return [name for name in self.form.split() if name in ("xp", "rotp", "warpp", "xq", "rotq", "warpq")]

    @property
    def warps(self) -> bool:
        """Whether a line names the warping of the ends, for FIX and DYNX."""
        return "warpp" in self.node_names

    @property
    def node_kinds(self) -> list[NodeKind]:
        """Kinds of the nodes on an element line: no inner coordinates; warping nodes if the line names them."""
        kinds = self.element.nodes.values()
        without = ("internal",) if self.warps else ("internal", "warping")
        return [kind for kind in kinds if kind.part not in without]

    def element_of(self, order: int | None, stiffness: list[float]) -> Element:
        """Element type of a line, by its order and its numbers of ESTIFF."""
        options = {"order": order, "shear": any(not is_zero(v) for v in stiffness[4:])}
        known = {name: v for name, v in options.items() if name in self.element.options and v is not None}
        return self.element(**known)

    def properties(
        self, lines: dict[str, list[float]], vector: list[float] | None, numbers: dict[str, float]
    ) -> dict[str, Any]:
        """Properties for ``Builder.add`` from numbers by keyword, a vector y or axis, and other numbers by property."""
        properties: dict[str, Any] = dict(numbers)
        if self.warps:
            # FIX states what is held.
            properties["clamped"] = False
        if "SECTION" in lines:
            properties["section"] = leaf_section(lines["SECTION"])
        if "CLAMP" in lines:
            properties["clamped"] = [bool(flag) for flag in lines["CLAMP"]]
        rigid = "alpha" in self.element.properties
        for name, is_used in (("y", "ALPHA" in lines or not rigid), ("axis", True)):
            if vector is not None and name in self.element.properties and is_used:
                properties[name] = stack(vector)
        if "stiffness" in self.stiffness:
            for keyword, name in (("ESTIFF", "stiffness"), ("EDAMP", "damping")):
                if keyword in lines:
                    padded = stack(lines[keyword] + [0.0] * (len(self.stiffness) - len(lines[keyword])))
                    properties[name] = padded if len(padded) > 1 else padded[0]
            return properties
        if "ALPHA" in lines and rigid:
            properties["alpha"] = lines["ALPHA"][0]
        if "ESTIFF" in lines or "EM" in lines or ("ALPHA" in lines and not rigid):
            rigidities: dict[str, Any] = dict(zip(self.stiffness, lines.get("ESTIFF", []), strict=False))
            rigidities |= zip(self.mass, lines.get("EM", []), strict=False)
            rigidities.pop(NOTHING, None)
            alpha = None if rigid else lines.get("ALPHA", [None])[0]
            properties["section"] = Rigidity(**rigidities, alpha=alpha)
        if "EDAMP" in lines:
            properties["damping"] = Damping(**dict(zip(self.damping, lines["EDAMP"], strict=False)))
        return properties


def leaf_section(sizes: list[float]) -> Rectangle:
    """Section of a leaf spring from the numbers of SECTION."""
    width, thickness, *material = sizes
    return Rectangle(width, thickness, Material(**dict(zip(SIZES[2:], material, strict=False))))


_BEAM = ("EA", "GIt", "EIy", "EIz", "shear_z", "shear_y")
_INERTIA = ("mass", "Jx", "Jy", "Jz", "Jyz")
_DAMPED = _BEAM[:4]
_PLANE, _PLANE_INERTIA = ("EA", "EIy"), ("mass", "Jy")
_TURNS = ("stiffness",) * 3, (), ("damping",) * 3
_RADII = (("rp", "radius_p"), ("rq", "radius_q"))
_ENDS, _WARPED = "element xp rotp xq rotq", "element xp rotp warpp xq rotq warpq"

KINDS = (
    ElementKind("BEAM", spatial.beam, f"{_ENDS} [y1 y2 y3]", _BEAM, _INERTIA, _DAMPED),
    ElementKind("BEAMW", spatial.warping_beam, f"{_WARPED} [y1 y2 y3]", (*_BEAM, "EIw"), (*_INERTIA, "Jw"), _DAMPED),
    ElementKind("SBEAM", spatial.spectral_beam(ORDER), f"{_ENDS} y1 y2 y3 [p]", _BEAM, _INERTIA, _DAMPED),
    ElementKind("LEAF", spatial.leaf_spring, f"{_ENDS} y1 y2 y3 [p]", damping=_DAMPED, sized=True),
    ElementKind("RBEAM", spatial.rigid_beam, "element xp rotp xq [y1 y2 y3]", mass=("mass",)),
    ElementKind("PINBODY", spatial.rigid_beam, "element xp rotp xq"),
    ElementKind("HINGE", spatial.hinge, "element rotp rotq axis1 axis2 axis3", *_TURNS),
    ElementKind("SCREW", spatial.screw, f"{_ENDS} x1 x2 x3 pitch", numbers=(("pitch", "pitch"),)),
    ElementKind("TRUSS", spatial.truss, "element xp xq", ("EA",), ("mass", NOTHING), ("EA",)),
    ElementKind("PLBEAM", planar.beam, _ENDS, (*_PLANE, "shear_z"), _PLANE_INERTIA, _PLANE),
    ElementKind("PLSBEAM", planar.spectral_beam(ORDER), f"{_ENDS} [p]", (*_PLANE, NOTHING), _PLANE_INERTIA, _PLANE),
    ElementKind("PLLEAF", planar.leaf_spring, f"{_ENDS} [p]", damping=_PLANE, sized=True),
    ElementKind("PLRBEAM", planar.rigid_beam, "element xp rotp xq", mass=("mass",)),
    ElementKind("PLPINBODY", planar.rigid_beam, "element xp rotp xq"),
    ElementKind("PLTRUSS", planar.truss, "element xp xq", ("EA",), ("mass", NOTHING), ("EA",)),
    ElementKind("PLTOR", planar.hinge, "element rotp rotq", ("stiffness",), (), ("damping",)),
    # Our own form: the predecessor's form is not known.
    ElementKind("PLBELT", planar.belt, f"{_ENDS} rp rq", ("EA",), (), ("EA",), _RADII),
    ElementKind("PLBELT", planar.belt_to_point, "element xp rotp xq rp", ("EA",), (), ("EA",), _RADII[:1]),
)
FORMS = {kind.keyword: " | ".join(k.form for k in KINDS if k.keyword == kind.keyword) for kind in KINDS}
"""Form of each keyword, alternatives between bars."""
