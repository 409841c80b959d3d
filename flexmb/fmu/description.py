"""modelDescription.xml of a unit for FMI 3.0 and 2.0, and build instructions for importers."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from .. import __version__
from ..errors import clean
from .plant import Plant, Variable

# Exponents of base units.
UNITS = {
    "m": {"m": 1},
    "rad": {"rad": 1},
    "s": {"s": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "m/s": {"m": 1, "s": -1},
    "rad/s": {"rad": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "rad/s2": {"rad": 1, "s": -2},
}


class Placed(NamedTuple):
    """A variable of a unit with its role.

    Attributes:
        variable: Name, unit, value at the start.
        reference: Number in the unit.
        kind: "time", "input", "state", "parameter", "rate" or "output".
        of: Reference of the state of a rate.
    """

    variable: Variable
    reference: int
    kind: str
    of: int = 0


# Causality, variability and initial value by kind.
ROLES = {
    "time": ("independent", "continuous", None),
    "input": ("input", "continuous", None),
    "state": ("local", "continuous", "exact"),
    "parameter": ("parameter", "tunable", "exact"),
    "rate": ("local", "continuous", "calculated"),
    "output": ("output", "continuous", "calculated"),
}


def placed(plant: Plant, settable: bool) -> list[Placed]:
    """All variables of a unit in the order of core.c, with matrices if they are settable."""
    parameters = list(plant.parameters)
    if plant.times is not None:
        parameters.append(Variable("substep", "s", plant.substep))
    if settable:
        # A linear plant has one of each matrix, without an index.
        linear = plant.times is None
        parameters += [Variable(name, start=m[0] if linear else m) for name, m in plant.matrices.items() if m.size]
    found = [Placed(Variable("time", "s"), 0, "time")]

    def follow(kind: str, variables: Sequence[Variable]):
        for v in variables:
            last = found[-1]
            found.append(Placed(v, last.reference + np.size(last.variable.start), kind))

    for kind, variables in (("input", plant.inputs), ("state", plant.states), ("parameter", parameters)):
        follow(kind, variables)
    states = [variable for variable in found if variable.kind == "state"]
    follow("rate", [Variable(f"der({state.variable.name})", _rate(state.variable.unit)) for state in states])
    rates = iter([state.reference for state in states])
    found = [each._replace(of=next(rates)) if each.kind == "rate" else each for each in found]
    follow("output", plant.outputs)
    return found


def _rate(unit: str) -> str:
    return {"m": "m/s", "rad": "rad/s", "m/s": "m/s2", "rad/s": "rad/s2"}.get(unit, "")


def check_names(plant: Plant, found: list[Placed]) -> None:
    """Refuse repeated names, also of the entries of arrays, which FMI 2.0 and importers name "A[1,2]"."""
    outputs = [one for one in found if one.kind == "output"]
    own = [one for one in found if one.kind == "input"] + outputs[: plant.n_own]
    others = [one for one in found if one not in own]
    kinds: dict[str, str] = {}
    for one in [*others, *(entry for entry in scalars(found) if entry.kind == "parameter"), *own]:
        name, kind = one.variable.name, one.kind
        if name in kinds and kind != "parameter":
            builder = "" if kind == "state" else f"`name` of Builder.{kind}, or "
            raise ValueError(
                f"The {kind} '{clean(name)}' shares its name with the unit's {kinds[name]}. Rename the {kind}, by"
                f" {builder}`{kind}s` of control.StateSpace."
            )
        kinds[name] = kind


def scalars(found: list[Placed]) -> Iterator[Placed]:
    """The same with each entry of an array as a variable, "A[1,2]"."""
    for one in found:
        if np.ndim(one.variable.start) == 0:
            yield one
            continue
        start = np.asarray(one.variable.start)
        for i, index in enumerate(np.ndindex(start.shape)):
            name = f"{one.variable.name}[{','.join(str(k + 1) for k in index)}]"
            yield Placed(Variable(name, one.variable.unit, float(start[index])), one.reference + i, one.kind)


def _attributes(one: Placed, of: int) -> dict[str, str]:
    """Attributes of a number in both versions."""
    v, found = one.variable, {}
    if one.kind in ("input", "state", "parameter"):
        found["start"] = " ".join(repr(float(value)) for value in np.ravel(v.start))
    if v.unit:
        found["unit"] = v.unit
    if one.kind == "rate":
        found["derivative"] = str(of)
    if one.kind == "state" and v.nominal != 1.0:
        found["nominal"] = repr(float(v.nominal))
    return found


def description(plant: Plant, found: list[Placed], identifier: str, title: str, token: str, fmi: int) -> bytes:
    """modelDescription.xml of a unit, with the token and the ``identifier`` of its functions."""
    root = ElementTree.Element(
        "fmiModelDescription",
        {
            "fmiVersion": f"{fmi}.0",
            "modelName": title,
            "guid" if fmi == 2 else "instantiationToken": token,
            "description": _told(plant),
            "generationTool": f"flexmb {__version__}",
            "variableNamingConvention": "flat",
            **({"numberOfEventIndicators": "0"} if fmi == 2 else {}),
        },
    )
    _interfaces(root, identifier, fmi)
    units = ElementTree.SubElement(root, "UnitDefinitions")
    for unit in sorted({one.variable.unit for one in found} - {""}):
        base = ElementTree.SubElement(units, "Unit", name=unit)
        if unit in UNITS:
            ElementTree.SubElement(base, "BaseUnit", {k: str(n) for k, n in UNITS[unit].items()})
    categories = ElementTree.SubElement(root, "LogCategories")
    ElementTree.SubElement(categories, "Category", name="logStatusError")
    if plant.times is not None:
        first, last = (repr(float(t)) for t in plant.times[[0, -1]])
        ElementTree.SubElement(root, "DefaultExperiment", startTime=first, stopTime=last)
    variables = ElementTree.SubElement(root, "ModelVariables")
    places = {one.reference: str(i if fmi == 2 else one.reference) for i, one in enumerate(found, 1)}
    for one in found:
        causality, variability, initial = ROLES[one.kind]
        roles = {"causality": causality, "variability": variability, **({"initial": initial} if initial else {})}
        named = {"name": one.variable.name, "valueReference": str(one.reference), **roles}
        if one.variable.description:
            named["description"] = one.variable.description
        number = _attributes(one, int(places[one.of]))
        if fmi == 2:
            ElementTree.SubElement(ElementTree.SubElement(variables, "ScalarVariable", named), "Real", number)
        else:
            element = ElementTree.SubElement(variables, "Float64", {**named, **number})
            for size in np.shape(one.variable.start):
                ElementTree.SubElement(element, "Dimension", start=str(size))
    _structure(root, plant, found, places, fmi)
    return _written(root)


def _told(plant: Plant) -> str:
    if plant.source:
        return "Nonlinear mechanism"
    if plant.times is not None:
        return (
            "Mechanism along a motion, linear and time-varying: inputs and outputs are total values, states are"
            " deviations"
        )
    return "Linear mechanism: all but absolute positions are deviations from the linearised state"


def _interfaces(root: ElementTree.Element, identifier: str, fmi: int) -> None:
    state, plural = ("state", "") if fmi == 2 else ("State", "s")
    abilities = [f"canGetAndSetFMU{state}", f"canSerializeFMU{state}", f"providesDirectionalDerivative{plural}"]
    small = dict.fromkeys([*abilities, *["canNotUseMemoryManagementFunctions"] * (fmi == 2)], "true")
    not_needed = {"completedIntegratorStepNotNeeded": "true"} if fmi == 2 else {}
    of_kinds = {"ModelExchange": not_needed, "CoSimulation": {"canHandleVariableCommunicationStepSize": "true"}}
    for kind, own in of_kinds.items():
        element = ElementTree.SubElement(root, kind, {"modelIdentifier": identifier, **small, **own})
        if fmi == 2:
            files = ElementTree.SubElement(element, "SourceFiles")
            ElementTree.SubElement(files, "File", name="fmi2.c")


def _structure(root: ElementTree.Element, plant: Plant, found: list[Placed], places: dict[int, str], fmi: int) -> None:
    """Outputs and rates, and their dependencies: without D outputs depend on no input."""

    def of(kind: str):
        return [one for one in found if one.kind == kind]

    known = [*of("time")] if plant.times is not None or plant.source else []
    if "D" in plant.matrices or plant.source:
        known += of("input")
    known += of("state")
    nominal = range(plant.n_own, plant.n_own + plant.n_nominal)
    structure = ElementTree.SubElement(root, "ModelStructure")
    outputs, rates = of("output"), of("rate")
    # Nominal inputs and outputs are functions of time.
    of_outputs = [(one, of("time") if i in nominal else known) for i, one in enumerate(outputs)]
    unknowns = sorted([*outputs, *rates], key=lambda one: one.reference)
    for group, tag, entries in (
        ("Outputs", "Output", of_outputs),
        ("Derivatives", "ContinuousStateDerivative", [(one, None) for one in rates]),
        ("InitialUnknowns", "InitialUnknown", [(one, None) for one in unknowns]),
    ):
        parent = ElementTree.SubElement(structure, group) if fmi == 2 else structure
        for one, depends_on in entries:
            attributes = {"index" if fmi == 2 else "valueReference": places[one.reference]}
            if depends_on is not None:
                attributes["dependencies"] = " ".join(places[k.reference] for k in depends_on)
            ElementTree.SubElement(parent, "Unknown" if fmi == 2 else tag, attributes)


def build_description(identifier: str) -> bytes:
    """buildDescription.xml of FMI 3.0: the file to compile."""
    root = ElementTree.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ElementTree.SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    files = ElementTree.SubElement(configuration, "SourceFileSet", language="C99")
    ElementTree.SubElement(files, "SourceFile", name="fmi3.c")
    return _written(root)


def _written(root: ElementTree.Element) -> bytes:
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"
