"""modelDescription.xml of a unit for FMI 3.0 and 2.0, and build instructions for importers."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from .. import __version__
from ..errors import printable
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


def ordered_variables(plant: Plant, settable: bool) -> list[Placed]:
    """All variables of a unit in the order of core.c, with matrices if they are settable."""
    parameters = list(plant.parameters)
    if plant.times is not None:
        parameters.append(Variable("substep", "s", plant.substep))
    if settable:
        # A linear plant has one of each matrix, without an index.
        linear = plant.times is None
        parameters += [Variable(name, start=m[0] if linear else m) for name, m in plant.matrices.items() if m.size]
    placed_variables = [Placed(Variable("time", "s"), 0, "time")]

    def follow(kind: str, variables: Sequence[Variable]):
        for v in variables:
            last = placed_variables[-1]
            placed_variables.append(Placed(v, last.reference + np.size(last.variable.start), kind))

    for kind, variables in (("input", plant.inputs), ("state", plant.states), ("parameter", parameters)):
        follow(kind, variables)
    states = [variable for variable in placed_variables if variable.kind == "state"]
    follow("rate", [Variable(f"der({state.variable.name})", _rate(state.variable.unit)) for state in states])
    rates = iter([state.reference for state in states])
    placed_variables = [entry._replace(of=next(rates)) if entry.kind == "rate" else entry for entry in placed_variables]
    follow("output", plant.outputs)
    return placed_variables


def _rate(unit: str) -> str:
    return {"m": "m/s", "rad": "rad/s", "m/s": "m/s2", "rad/s": "rad/s2"}.get(unit, "")


def check_unique_names(plant: Plant, found: list[Placed]) -> None:
    """Refuse repeated names, also of the entries of arrays, which FMI 2.0 and importers name "A[1,2]"."""
    outputs = [entry for entry in found if entry.kind == "output"]
    own_entries = [entry for entry in found if entry.kind == "input"] + outputs[: plant.n_own]
    others = [entry for entry in found if entry not in own_entries]
    kinds: dict[str, str] = {}
    for entry in [*others, *(scalar for scalar in scalars(found) if scalar.kind == "parameter"), *own_entries]:
        name, kind = entry.variable.name, entry.kind
        if name in kinds and kind != "parameter":
            builder = "" if kind == "state" else f"`name` of Builder.{kind}, or "
            raise ValueError(
                f"The {kind} '{printable(name)}' shares its name with the unit's {kinds[name]}. Rename the {kind}, by"
                f" {builder}`{kind}s` of control.StateSpace."
            )
        kinds[name] = kind


def scalars(found: list[Placed]) -> Iterator[Placed]:
    """The same with each entry of an array as a variable, "A[1,2]"."""
    for entry in found:
        if np.ndim(entry.variable.start) == 0:
            yield entry
            continue
        start = np.asarray(entry.variable.start)
        for i, index in enumerate(np.ndindex(start.shape)):
            name = f"{entry.variable.name}[{','.join(str(k + 1) for k in index)}]"
            yield Placed(Variable(name, entry.variable.unit, float(start[index])), entry.reference + i, entry.kind)


def _attributes(entry: Placed, of: int) -> dict[str, str]:
    """Attributes of a number in both versions."""
    v, attributes = entry.variable, {}
    if entry.kind in ("input", "state", "parameter"):
        attributes["start"] = " ".join(repr(float(value)) for value in np.ravel(v.start))
    if v.unit:
        attributes["unit"] = v.unit
    if entry.kind == "rate":
        attributes["derivative"] = str(of)
    if entry.kind == "state" and v.nominal != 1.0:
        attributes["nominal"] = repr(float(v.nominal))
    return attributes


def description(plant: Plant, found: list[Placed], identifier: str, title: str, token: str, fmi: int) -> bytes:
    """modelDescription.xml of a unit, with the token and the ``identifier`` of its functions."""
    root = ElementTree.Element(
        "fmiModelDescription",
        {
            "fmiVersion": f"{fmi}.0",
            "modelName": title,
            "guid" if fmi == 2 else "instantiationToken": token,
            "description": _plant_description(plant),
            "generationTool": f"flexmb {__version__}",
            "variableNamingConvention": "flat",
            **({"numberOfEventIndicators": "0"} if fmi == 2 else {}),
        },
    )
    _interfaces(root, identifier, fmi)
    units = ElementTree.SubElement(root, "UnitDefinitions")
    for unit in sorted({entry.variable.unit for entry in found} - {""}):
        base = ElementTree.SubElement(units, "Unit", name=unit)
        if unit in UNITS:
            ElementTree.SubElement(base, "BaseUnit", {k: str(n) for k, n in UNITS[unit].items()})
    categories = ElementTree.SubElement(root, "LogCategories")
    ElementTree.SubElement(categories, "Category", name="logStatusError")
    if plant.times is not None:
        first, last = (repr(float(t)) for t in plant.times[[0, -1]])
        ElementTree.SubElement(root, "DefaultExperiment", startTime=first, stopTime=last)
    variables = ElementTree.SubElement(root, "ModelVariables")
    places = {entry.reference: str(i if fmi == 2 else entry.reference) for i, entry in enumerate(found, 1)}
    for entry in found:
        causality, variability, initial = ROLES[entry.kind]
        roles = {"causality": causality, "variability": variability, **({"initial": initial} if initial else {})}
        named = {"name": entry.variable.name, "valueReference": str(entry.reference), **roles}
        if entry.variable.description:
            named["description"] = entry.variable.description
        number = _attributes(entry, int(places[entry.of]))
        if fmi == 2:
            ElementTree.SubElement(ElementTree.SubElement(variables, "ScalarVariable", named), "Real", number)
        else:
            element = ElementTree.SubElement(variables, "Float64", {**named, **number})
            for size in np.shape(entry.variable.start):
                ElementTree.SubElement(element, "Dimension", start=str(size))
    _structure(root, plant, found, places, fmi)
    return _written(root)


def _plant_description(plant: Plant) -> str:
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
    for kind, attributes in of_kinds.items():
        element = ElementTree.SubElement(root, kind, {"modelIdentifier": identifier, **small, **attributes})
        if fmi == 2:
            files = ElementTree.SubElement(element, "SourceFiles")
            ElementTree.SubElement(files, "File", name="fmi2.c")


def _structure(
    root: ElementTree.Element, plant: Plant, placed_variables: list[Placed], places: dict[int, str], fmi: int
) -> None:
    """Outputs and rates, and their dependencies: without D outputs depend on no input."""

    def of_kind(kind: str):
        return [entry for entry in placed_variables if entry.kind == kind]

    known = [*of_kind("time")] if plant.times is not None or plant.source else []
    if "D" in plant.matrices or plant.source:
        known += of_kind("input")
    known += of_kind("state")
    nominal = range(plant.n_own, plant.n_own + plant.n_nominal)
    structure = ElementTree.SubElement(root, "ModelStructure")
    outputs, rates = of_kind("output"), of_kind("rate")
    # Nominal inputs and outputs are functions of time.
    of_outputs = [(entry, of_kind("time") if i in nominal else known) for i, entry in enumerate(outputs)]
    unknowns = sorted([*outputs, *rates], key=lambda entry: entry.reference)
    for group, tag, entries in (
        ("Outputs", "Output", of_outputs),
        ("Derivatives", "ContinuousStateDerivative", [(entry, None) for entry in rates]),
        ("InitialUnknowns", "InitialUnknown", [(entry, None) for entry in unknowns]),
    ):
        parent = ElementTree.SubElement(structure, group) if fmi == 2 else structure
        for entry, depends_on in entries:
            attributes = {"index" if fmi == 2 else "valueReference": places[entry.reference]}
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
