"""Documents of the workbench for tests: the tutorial's guides, drawn call by call."""

from collections.abc import Iterable

from flexmb.workbench.document import Document, apply

from .mechanisms import BAR, COIL, DISTANCE, LENGTH, THICKNESS, WIDTH

STEEL = {"E": "210e9", "G": "80e9", "rho": "7850"}


def drawn(dimension: int, names: dict[str, str], things: Iterable[tuple]) -> Document:
    """A document of these names of numbers, and of things: call, name or None, arguments."""
    ops: list[dict] = [{"op": "name", "name": name, "to": {"value": value}} for name, value in names.items()]
    ops += [{"op": "add", "thing": {"call": call, "name": name, "args": args}} for call, name, args in things]
    return apply(Document.empty(dimension), ops)[0]


def planar_guide(**more) -> Document:
    """``mechanisms.planar_guide()`` as a document, with the names t, L and d."""
    names = {"t": repr(THICKNESS), "L": repr(LENGTH), "d": repr(DISTANCE)}
    beam = {"section": "leaf", "released": "2 3"}
    return drawn(
        2,
        names,
        [
            ("Material", "steel", STEEL),
            ("Rectangle", "leaf", leaf_args()),
            ("node", "left0", {"position": ["0", "0"]}),
            ("node", "left1", {"position": ["0", "L"]}),
            ("planar.beam", "left 1", {"nodes": ["left0", "left1"], **beam}),
            ("fix", None, {"node": "left0"}),
            ("node", "right0", {"position": ["d", "0"]}),
            ("node", "right1", {"position": ["d", "L"]}),
            ("planar.beam", "right 1", {"nodes": ["right0", "right1"], **beam}),
            ("fix", None, {"node": "right0"}),
            ("planar.beam", "bar", {"nodes": ["left1", "right1"]}),
            ("mass", None, {"node": "left1", "mass": f"({BAR} + {COIL})/2"}),
            ("mass", None, {"node": "right1", "mass": f"({BAR} + {COIL})/2"}),
            ("dof", None, {"of": "left1", "components": "x"}),
        ],
    )


def spatial_guide() -> Document:
    """``mechanisms.spatial_guide()`` as a document, with the names t, L and d."""
    names = {"t": repr(THICKNESS), "L": repr(LENGTH), "d": repr(DISTANCE)}
    beam = {"section": "leaf", "released": "2 3 4", "y": ["1", "0", "0"]}
    return drawn(
        3,
        names,
        [
            ("Material", "steel", STEEL),
            ("Rectangle", "leaf", leaf_args()),
            ("Rigidity", "rail", {"mass": "7690*2.6e-5/d"}),
            ("node", "left0", {"position": ["0", "0", "0"]}),
            ("node", "left1", {"position": ["0", "0", "L"]}),
            ("spatial.beam", "left 1", {"nodes": ["left0", "left1"], **beam}),
            ("fix", None, {"node": "left0"}),
            ("node", "right0", {"position": ["0", "d", "0"]}),
            ("node", "right1", {"position": ["0", "d", "L"]}),
            ("spatial.beam", "right 1", {"nodes": ["right0", "right1"], **beam, "released": "2 3 4 6"}),
            ("fix", None, {"node": "right0"}),
            (
                "spatial.beam",
                "bar",
                {"nodes": ["left1", "right1"], "section": "rail", "released": "none", "y": ["1", "0", "0"]},
            ),
            ("mass", None, {"node": "right1", "mass": repr(COIL)}),
            ("dof", None, {"of": "left1", "components": "y"}),
        ],
    )


def leaf_args() -> dict[str, str]:
    """Arguments of the leaf springs' section."""
    return {"width": repr(WIDTH), "thickness": "t", "material": "steel", "rotary": "false"}
