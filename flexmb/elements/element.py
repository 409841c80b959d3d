"""An element type is a pure function of nodal coordinates; its signature is read here."""

import dataclasses
import functools
import inspect
import typing
from collections import namedtuple
from collections.abc import Callable
from typing import Any

from .nodes import NodeKind

ALL = "all"
# Companions by what makes them: stress resultants from deformations, and the rest.
ELASTIC = ("stiffness", "energy", "law")
NONLINEAR = ("energy", "dissipation", "law")
COMPANIONS = ("stiffness", "damping", *NONLINEAR, "inertia", "force", "resultants")
# Keyword-only parameters that are handed to an element's functions and are no properties of it.
GIVEN = ("ref", "near", "place", "sigma", "fall")


@dataclasses.dataclass(frozen=True)
class Element:
    """An element type: the deformation function and its companions.

    Companions are functions too, called with the properties that they name in their signature. One that names a
    property whose value is None is not called: a beam without a section has neither stiffness nor mass.

    Attributes:
        deformation: ``f(*nodes, ref, **properties) -> (n_e,)``, zero at ``ref`` and unchanged by rigid motion.
        stiffness: ``f(*, ref, **properties) -> (n_e, n_e)``, stress resultants per deformation.
        damping: The same for deformation rates.
        inertia: ``f(*nodes, ref, **properties) -> (s, H)``: vectors s(x), (k, d), and a constant matrix H, (k, k),
            with kinetic energy ``1/2 sum H[a, b] s_a_dot . s_b_dot`` (THEORY.md 3, eq. (3.1)).
        force: ``f(*nodes, ref, **properties) -> (n_x,)``, nodal forces dual to the coordinates, for loads that
            depend on the configuration.
        energy: ``f(e, *, ref, **properties) -> ()`` [J], elastic energy, where stress is no constant matrix times
            deformation: its derivative by e is the stress.
        dissipation: ``f(e, ed, *, ref, **properties) -> ()`` [W], zero at rest, whose derivative by ed is the stress:
            half of what a linear damper takes.
        law: ``f(e, ed, *, ref, **properties) -> (n_e,)``, stress resultants that need no potential: friction, contact,
            a characteristic. An element may have several of the companions; their stresses add up.
        resultants: ``f(*nodes, ref, place, sigma, **properties) -> (6,)``, force and moment in the cross-section at a
            place, 0 at the first end and 1 at the last, from the element's stress resultants sigma (n_e,): normal
            force, shear forces along y and z [N], torque, bending moments about y and z [N m], in axes of the section
            there. They are what the part beyond the place does to the part before it (the face whose normal is +x),
            so that a positive normal force pulls. Asked of flexible elements with a section. One that names ``fall``
            is also given what acts on its mass: the acceleration of free fall less its own of each vector s, (k, d)
            [m/s^2], or None where nothing acts. Without it distributed loads are taken to act on the ends.
        shape: ``f(*nodes, ref, place, **properties) -> (d,)``, where a point of the element is, 0 at its first end and
            1 at its last, for pictures; its properties are among those of the deformation. Without it an element with
            two points and two rotations is drawn as a cubic, another as a line between its points.
        check: ``f(*, ref, **properties) -> list[str]``: faults of geometry or properties, on concrete numbers. Those of
            this package also take many elements at once, stacked along leading axes.
        released: Numbers (from 1) of the deformations that are DEPENDENT unless the caller says otherwise, or "all".
            The rest is FIXED. None: all if the element is elastic, none if not.
        measured: Numbers (from 1) of the deformations that no one holds: what companions need to know, and angles whose
            turns are counted. They are DEPENDENT whatever the caller releases.
        fields: Numbers (from 1) of the deformations of each strain field, where the strains are series.
    """

    deformation: Callable[..., Any]
    stiffness: Callable[..., Any] | None = None
    damping: Callable[..., Any] | None = None
    inertia: Callable[..., Any] | None = None
    force: Callable[..., Any] | None = None
    energy: Callable[..., Any] | None = None
    dissipation: Callable[..., Any] | None = None
    law: Callable[..., Any] | None = None
    resultants: Callable[..., Any] | None = None
    shape: Callable[..., Any] | None = None
    check: Callable[..., list[str]] | None = None
    released: tuple[int, ...] | str | None = None
    measured: tuple[int, ...] = ()
    fields: tuple[tuple[int, ...], ...] = ()

    @property
    def name(self) -> str:
        """Name of the element type, as the module that defines it spells it."""
        return self.deformation.__name__.strip("_")

    @property
    def nodes(self) -> dict[str, NodeKind]:
        """Node kind of each positional parameter, in order."""
        return _nodes(self.deformation)

    @property
    def properties(self) -> dict[str, inspect.Parameter]:
        """Properties that the deformation and the companions name."""
        found: dict[str, inspect.Parameter] = {}
        for function in self._functions():
            for name, parameter in _properties(function).items():
                if name not in found or found[name].default is inspect.Parameter.empty:
                    found[name] = parameter
        return found

    def hint(self, name: str) -> Any:
        """Annotation of a property, None where there is none.

        Args:
            name: Name of the property.
        """
        return next((h[name] for h in map(_hints, self._functions()) if name in h), None)

    @property
    def tracks_angle(self) -> bool:
        """Whether the deformation asks for ``near``: its value at the last accepted state (angles past a turn)."""
        return "near" in inspect.signature(self.deformation).parameters

    @property
    def feels_fall(self) -> bool:
        """Whether the section resultants ask for ``fall``: what acts on the mass along the element."""
        return self.resultants is not None and "fall" in inspect.signature(self.resultants).parameters

    def is_elastic(self, properties: dict[str, Any]) -> bool:
        """Whether deformations are stressed at rest.

        Args:
            properties: All properties of the element.
        """
        return any(self.arguments(getattr(self, name), properties) is not None for name in ELASTIC)

    def _functions(self) -> list[Callable[..., Any]]:
        companions = (getattr(self, name) for name in (*COMPANIONS, "shape", "check"))
        return [self.deformation, *(c for c in companions if c is not None)]

    def reference(self, coordinates) -> Any:
        """The ``ref`` argument: coordinates under the names of the nodes.

        Args:
            coordinates: One array a node, in order.
        """
        return _reference_type(self.deformation)(*coordinates)

    def wanted(self, companion: Callable[..., Any]) -> dict[str, inspect.Parameter]:
        """Properties that one of this element's functions names.

        Args:
            companion: The function.
        """
        return _properties(companion)

    def arguments(self, companion: Callable[..., Any] | None, properties: dict[str, Any]) -> dict | None:
        """Properties that a companion names, or None where it does not exist for these properties.

        Args:
            companion: One of this element's functions, or None.
            properties: All properties of the element.
        """
        if companion is None:
            return None
        wanted = _properties(companion)
        chosen = {name: properties[name] for name in wanted if name in properties}
        required = companion is not self.deformation and companion is not self.check
        if required and any(value is None for name, value in chosen.items() if wanted[name].default is not None):
            return None
        return chosen


@functools.cache
def _properties(function) -> dict[str, inspect.Parameter]:
    """Keyword-only parameters but for those that are given."""
    parameters = inspect.signature(function).parameters.items()
    return {n: p for n, p in parameters if p.kind is p.KEYWORD_ONLY and n not in GIVEN}


@functools.cache
def _hints(function) -> dict[str, Any]:
    """Annotations of a function; none where they name what is not there."""
    try:
        return typing.get_type_hints(function, include_extras=True)
    except (NameError, TypeError):
        return {}


@functools.cache
def _nodes(function) -> dict[str, NodeKind]:
    """Node kinds of the positional parameters."""
    hints = _hints(function)
    nodes = {}
    for name, parameter in inspect.signature(function).parameters.items():
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY:
            continue
        kinds = [k for k in getattr(hints.get(name), "__metadata__", ()) if isinstance(k, NodeKind)]
        if not kinds:
            raise TypeError(
                f"Positional parameter '{name}' of element '{function.__name__}' must be annotated with a node kind"
                " (Point2, Angle, Point3, Rotation3)."
            )
        nodes[name] = kinds[0]
    return nodes


@functools.cache
def _reference_type(function):
    return namedtuple("Reference", list(_nodes(function)))
