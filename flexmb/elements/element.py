"""An element type: a pure function of nodal coordinates with companions, all declared by their signatures."""

import collections.abc
import dataclasses
import functools
import inspect
import types
import typing
from collections import namedtuple
from collections.abc import Callable, Iterable
from typing import Any

import jax.core
import numpy as np

from ..arguments import as_whole, short_repr
from .element_text import help_of, repr_of
from .nodes import STATIC, NodeKind

EMPTY = inspect.Parameter.empty
# Kinds of options: the types that are accepted, and the words of messages.
ALIKE = {bool: bool | np.bool_, float: float | int}
WORDS = {bool: "True or False", int: "a whole number", float: "a number", collections.abc.Callable: "a function"}

ALL = "all"
# Companions: those that compute stress resultants from deformations first.
ELASTIC = ("stiffness", "energy", "law")
NONLINEAR = ("energy", "dissipation", "law")
SECTIONAL = ("resultants", "surface")
COMPANIONS = ("stiffness", "damping", *NONLINEAR, "inertia", "force", *SECTIONAL, "thermal")
# Keyword-only parameters that flexmb passes to an element's functions; they are no properties.
GIVEN = ("ref", "near", "place", "sigma", "fall", "resultants")


@dataclasses.dataclass(frozen=True, repr=False)
class Element:
    """An element type: the deformation function and its companions.

    Companions are functions, too. flexmb calls a companion with the properties and options in its signature. It does
    not call a companion if one of these properties is None: a beam without a section has neither stiffness nor mass. A
    companion need not repeat the annotations of the deformation.

    A keyword-only parameter annotated ``Static`` is an option: any hashable value that selects code and is no number.
    ``builder.add(planar.spectral_beam, .., order=4)`` sets an option. A call of the element type,
    ``planar.spectral_beam(order=4)`` or ``planar.spectral_beam(4)``, returns the type with that option. If a companion
    has the parameter ``**properties``, the keyword-only parameters of the functions among its options are also
    properties of the element. The companion passes them to these functions.

    Attributes:
        deformation: ``f(*nodes, ref, **properties) -> (n_e,)``, zero at ``ref`` and unchanged by rigid motion.
        stiffness: ``f(*, ref, **properties) -> (n_e, n_e)``, stress resultants per deformation.
        damping: ``f(*, ref, **properties) -> (n_e, n_e)``, stress resultants per deformation rate.
        inertia: ``f(*nodes, ref, **properties) -> (s, H)``: vectors s(x), (k, d), and a constant matrix H, (k, k),
            with kinetic energy ``1/2 sum H[a, b] s_a_dot . s_b_dot`` (THEORY.md 3, eq. (3.1)).
        force: ``f(*nodes, ref, **properties) -> (n_x,)``, nodal forces dual to the coordinates, for loads that
            depend on the configuration.
        energy: ``f(e, *, ref, **properties) -> ()`` [J], elastic energy of a nonlinear element. Its derivative by e is
            the stress.
        dissipation: ``f(e, ed, *, ref, **properties) -> ()`` [W], zero at rest. Its derivative by ed is the stress. For
            a linear damper it is therefore half of the power.
        law: ``f(e, ed, *, ref, **properties) -> (n_e,)``, stress resultants without a potential: friction, contact, a
            characteristic. An element may have several of these companions; their stresses add up.
        resultants: ``f(*nodes, ref, place, sigma, **properties) -> (6,)``, force and moment in the cross-section at a
            place, 0 at the first end and 1 at the last, from the element's stress resultants sigma (n_e,). They are the
            normal force, shear forces along y and z [N], torque, and bending moments about y and z [N m], in axes of
            the section there. The part beyond the place exerts them on the face with normal +x. A positive normal force
            therefore pulls. flexmb calls it for flexible elements with a section. A function with the parameter
            ``fall`` also receives the acceleration of free fall minus the acceleration of each vector s, (k, d)
            [m/s^2], or None without loads on the mass. Without that parameter distributed loads act on the ends.
        surface: ``f(e, *, ref, place, resultants, **properties) -> (sigma_x, tau, across)``, stress at eight points of
            the surface at a place, from the deformations minus initial strains (n_e,) and the force and moment there
            (6,): stress along x, shear stress along the surface counter-clockwise about x, and normal stress along the
            surface across x, each (8,) [Pa]. Without it the section computes the stress, with no stress across x.
        thermal: ``f(change, gradient, *, ref, **properties) -> (n_e,)``, deformations of the unloaded element after a
            change of temperature. With these deformations the element has no stress; FIXED deformations get these
            values. ``change``, (2,) [K], is the change at the first and the last end, linear in between. ``gradient``
            [K/m] is its gradient across the element: along the section's local y and z in space, (2,); along its local
            z in the plane, to the left of the way from the first end to the last, (1,). An element that does not bend
            leaves ``gradient`` out. flexmb calls it for elements with a temperature.
        shape: ``f(*nodes, ref, place, **properties) -> (d,)``, position of a point of the element for pictures, 0 at
            the first end and 1 at the last. Its properties are among the properties of the deformation. Without it an
            element with two points and two rotations is drawn as a cubic, any other as a line between its points.
        passage: ``f(*nodes, ref, **properties) -> (way, turn)`` of an element with strain series, from its
            coefficients alone: position of the last node relative to the first, (d,) [m], and the rotation between
            them, an angle (1,) [rad] or Euler parameters (4,) [-], in axes of the first node's rotation. With these
            values the deformations before the coefficients are zero. Its properties are among the properties of the
            deformation.
        check: ``f(*, ref, **properties) -> list[str]``: faults of geometry or properties, for concrete numbers. The
            checks of this package also accept many elements at once, stacked along leading axes. They accept traced
            numbers and record the conditions on them.
        released: Numbers (from 1) of the deformations that are DEPENDENT by default, or "all". The others are FIXED.
            None: the deformations of the strain fields; without strain fields, all of an elastic element and none of
            any other.
        measured: Numbers (from 1) of the deformations that nothing constrains: inputs of companions, and angles whose
            turns are counted. They are always DEPENDENT.
        angles: Numbers (from 1) of the deformations that are length times the sine of an angle. They determine the
            angle only while it is small.
        third_order: Whether the energy is at least of third order in the deformations, so that the element has no
            effect in the undeformed mechanism.
        grounded: Whether the deformations are displacements relative to the ground, which rigid motion changes.
        series: ``f(**options) -> fields``, numbers (from 1) of the deformations of each strain field, if the strains
            are series. The node annotated ``Series2`` or ``Series3`` stores their coefficients.
        lengths: Numbers (from 0) of the strain fields whose coefficients are lengths (elongation and shears). The
            coefficients of the others are angles.
        names: Name of each deformation, in order, such as ("elongation", "bending_p"). With strain series: the name of
            each deformation before the series, then the name of each field. Without names deformations have numbers
            alone.
        chosen: Options that differ from their defaults: name, type and value of each, in alphabetical order.
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
    surface: Callable[..., Any] | None = None
    thermal: Callable[..., Any] | None = None
    shape: Callable[..., Any] | None = None
    passage: Callable[..., Any] | None = None
    check: Callable[..., list[str]] | None = None
    released: tuple[int, ...] | str | None = None
    measured: tuple[int, ...] = ()
    angles: tuple[int, ...] = ()
    third_order: bool = False
    grounded: bool = False
    series: Callable[..., tuple[tuple[int, ...], ...]] | None = None
    lengths: tuple[int, ...] = ()
    names: tuple[str, ...] = ()
    chosen: tuple[tuple[str, type, Any], ...] = ()

    def __repr__(self) -> str:
        return repr_of(self)

    def __call__(self, *values: Any, **options: Any) -> "Element":
        """The same element type with other options. Options that are not given keep their values.

        Args:
            values: Values of the first options, in the order of the signature.
            options: Values of further options, by name.

        Raises:
            TypeError: An option is unknown, is not of the annotated kind, or is not hashable.
            ValueError: A value is out of range.
        """
        kinds = _options(self)
        positional = dict(zip(kinds, values, strict=False))
        unknown = [name for name in options if name not in kinds or name in positional]
        if len(values) > len(kinds) or unknown:
            wrong = f"`{unknown[0]}` is unknown or given twice" if unknown else f"there are not {len(values)} of them"
            raise TypeError(f"Options of {self.name} are: {', '.join(kinds) or 'none'}; {wrong}.")
        merged = self.options
        for name, value in (positional | options).items():
            kind = kinds[name][0]
            if expected := wanted_option(value, kind):
                raise TypeError(f"Option `{name}` of {self.name} must be {expected}, not {short_repr(value)}.")
            merged[name] = kind(value) if kind in (bool, int, float) else value
        # Equal values of different types, such as 1 and True, select different code.
        typed = {name: (type(value), value) for name, value in sorted(merged.items())}
        usual = {name: (type(value), value) for name, (_, value) in kinds.items()}
        chosen = tuple((name, *typed_value) for name, typed_value in typed.items() if typed_value != usual[name])
        adapted = self if chosen == self.chosen else _with(self.usual, chosen)
        # A value out of range raises here.
        _ = adapted.fields
        return adapted

    @property
    def options(self) -> dict[str, Any]:
        """Values of the options, without required options that are not set."""
        usual = {name: default for name, (_, default) in _options(self).items() if default is not EMPTY}
        return usual | {name: value for name, _, value in self.chosen}

    @property
    def option_names(self) -> tuple[str, ...]:
        """Names of all options, in the order of the signature."""
        return tuple(_options(self))

    @property
    def usual(self) -> "Element":
        """The element type with the default options."""
        return dataclasses.replace(self, chosen=())

    @property
    def fields(self) -> tuple[tuple[int, ...], ...]:
        """Numbers (from 1) of the deformations of each strain field, if the strains are series."""
        if self.series is None or _keywords(self.series).keys() - self.options.keys():
            return ()
        return self.series(**self._named_options(self.series))

    @property
    def closure(self) -> tuple[int, ...]:
        """Numbers (from 1) of the deformations that connect the end of the strain series to its node."""
        return tuple(n for n in range(1, self._before_fields() + 1) if n not in self.measured)

    @property
    def numbered(self) -> dict[str, tuple[int, ...]]:
        """Numbers (from 1) of the deformations by name: one number, or all coefficients of a field."""
        before = self._before_fields() if self.fields else len(self.names)
        single = {name: (n,) for n, name in enumerate(self.names[:before], 1)}
        return single | dict(zip(self.names[before:], self.fields, strict=False))

    @property
    def deformation_names(self) -> dict[int, str]:
        """Name of each deformation by its number; the first coefficient of a field has the field's name."""
        return _deformation_names(self)

    def called(self, number: int) -> str:
        """Number and name of a deformation for messages: "2 (torsion)".

        Args:
            number: From 1.
        """
        name = self.deformation_names.get(number)
        return f"{number} ({name})" if name else str(number)

    def number_of(self, deformation: Any) -> int | None:
        """Number (from 1) of a deformation, or None if there is no such deformation.

        Args:
            deformation: Its number, its number as "e2", or its name.
        """
        if not isinstance(deformation, str):
            return as_whole(deformation)
        digits = deformation.removeprefix("e")
        if digits.isascii() and digits.isdecimal():
            return int(digits)
        return next((n for n, name in self.deformation_names.items() if name == deformation), None)

    @property
    def name(self) -> str:
        """Name of the element type in the module that defines it."""
        return self.deformation.__name__.strip("_")

    @property
    def nodes(self) -> dict[str, NodeKind]:
        """Node kind of each positional parameter, in order."""
        powers = tuple(int(i in self.lengths) for i, field in enumerate(self.fields) for _ in field)
        kinds = _nodes(self.deformation).items()
        return {name: kind if kind.start else kind.sized(len(powers), powers) for name, kind in kinds}

    @property
    def properties(self) -> dict[str, inspect.Parameter]:
        """Properties in the signatures of the deformation and the companions."""
        parameters: dict[str, inspect.Parameter] = {}
        for function in self._functions():
            for name, parameter in self.wanted(function).items():
                if name not in parameters or parameters[name].default is EMPTY:
                    parameters[name] = parameter
        return parameters

    def hint(self, name: str) -> Any:
        """Annotation of a property, or None without annotation.

        Args:
            name: Name of the property.
        """
        return next((h[name] for h in map(_hints, self._functions()) if name in h), None)

    @property
    def tracks_angle(self) -> bool:
        """Whether the deformation has the parameter ``near``: its value at the last accepted state (counted turns)."""
        return "near" in inspect.signature(self.deformation).parameters

    @property
    def feels_fall(self) -> bool:
        """Whether ``resultants`` has the parameter ``fall``: weight and inertia forces along the element."""
        return self.resultants is not None and "fall" in inspect.signature(self.resultants).parameters

    @property
    def bends_by_heat(self) -> bool:
        """Whether the thermal deformations have the parameter ``gradient``."""
        return self.thermal is not None and len(_positional(self.thermal)) > 1

    def expands(self, properties: dict[str, Any]) -> bool:
        """Whether the element or its section states a coefficient of thermal expansion.

        Args:
            properties: All properties of the element.
        """
        if self.thermal is None or self.arguments(self.thermal, properties) is None:
            return False
        values = [properties.get(name) for name in ("alpha", "section") if name in self.wanted(self.thermal)]
        return not values or any(value is not None and getattr(value, "expands", True) for value in values)

    def is_elastic(self, properties: dict[str, Any]) -> bool:
        """Whether deformations cause stress at rest.

        Args:
            properties: All properties of the element.
        """
        return any(self.arguments(getattr(self, name), properties) is not None for name in ELASTIC)

    def freed(self, properties: dict[str, Any]) -> tuple[int, ...] | str:
        """Deformations that are released by default: numbers from 1, or "all".

        Args:
            properties: All properties of the element.
        """
        if self.released is not None:
            return self.released
        return tuple(n for field in self.fields for n in field) or (ALL if self.is_elastic(properties) else ())

    def of_deformation(self, properties: dict[str, Any]) -> dict[str, Any]:
        """Properties in the signature of the deformation.

        Args:
            properties: All properties of the element.
        """
        parameters = self.wanted(self.deformation)
        return {name: value for name, value in properties.items() if name in parameters}

    def alone(self) -> "Element":
        """The deformation without companions, with its own options alone."""
        options = self._named_options(self.deformation)
        return Element(self.deformation, chosen=tuple((name, type(v), v) for name, v in sorted(options.items())))

    def _named_options(self, function: Callable[..., Any]) -> dict[str, Any]:
        return {name: value for name, value in self.options.items() if name in _keywords(function)}

    def _before_fields(self) -> int:
        """Number of deformations before the strain fields."""
        return min((field[0] for field in self.fields), default=1) - 1

    def _functions(self) -> list[Callable[..., Any]]:
        companions = (getattr(self, name) for name in (*COMPANIONS, "shape", "passage", "check"))
        return [self.deformation, *(c for c in companions if c is not None)]

    def reference(self, coordinates: Iterable[Any]) -> Any:
        """The ``ref`` argument: coordinates by the names of the nodes.

        Args:
            coordinates: One array for each node, in order.
        """
        return _reference_type(self.deformation)(*coordinates)

    def wanted(self, companion: Callable[..., Any]) -> dict[str, inspect.Parameter]:
        """Properties in the signature of one of this element's functions.

        Args:
            companion: The function.
        """
        return _parameters_of(self, companion)

    def arguments(self, companion: Callable[..., Any] | None, properties: dict[str, Any]) -> dict[str, Any] | None:
        """Arguments for one of this element's functions: the properties and options that its signature names.

        None if there is no such function, or if a property that it requires is None. The element then goes without it.

        Args:
            companion: The function, such as ``energy`` or ``stiffness``, or None.
            properties: All properties of the element.
        """
        if companion is None:
            return None
        parameters = self.wanted(companion)
        chosen = {name: properties[name] for name in parameters if name in properties}
        required = companion is not self.deformation and companion is not self.check
        if required and any(value is None for name, value in chosen.items() if parameters[name].default is not None):
            return None
        return chosen | self._named_options(companion)


class _Text:
    """Docstring of the class and of each element type, for help()."""

    def __init__(self, text: str | None):
        self.own = text

    def __get__(self, element: Element | None, owner: type) -> str | None:
        return self.own if element is None else help_of(element)


Element.__doc__ = _Text(Element.__doc__)  # pyright: ignore[reportAttributeAccessIssue]


@functools.cache
def _with(usual: Element, chosen: tuple[tuple[str, type, Any], ...]) -> Element:
    return dataclasses.replace(usual, chosen=chosen)


@functools.cache
def _options(element: Element) -> dict[str, tuple[Any, Any]]:
    """Kind and default of each keyword-only parameter annotated ``Static``, in order of appearance."""
    options: dict[str, tuple[Any, Any]] = {}
    for function in element._functions():
        for name, parameter in _keywords(function).items():
            hint = _hints(function).get(name)
            if STATIC in getattr(hint, "__metadata__", ()) and options.get(name, (None, EMPTY))[1] is EMPTY:
                options[name] = typing.get_args(hint)[0], parameter.default
    # An element type of the deformation alone has chosen options whose annotations the companions had.
    return {name: (kind, EMPTY) for name, kind, _ in element.chosen} | options


@functools.cache
def _deformation_names(element: Element) -> dict[int, str]:
    named = [(n, k, name) for name, numbers in element.numbered.items() for k, n in enumerate(numbers, 1)]
    return {n: name if k == 1 else f"{name}_{k}" for n, k, name in named}


@functools.cache
def _parameters_of(element: Element, function: Callable[..., Any]) -> dict[str, inspect.Parameter]:
    """Properties in the signature of a function, and of the options to which it passes ``**properties``."""
    known = element.option_names
    parameters = {name: p for name, p in _keywords(function).items() if name not in known}
    if any(p.kind is p.VAR_KEYWORD for p in inspect.signature(function).parameters.values()):
        for option in element._named_options(function).values():
            parameters |= _keywords(option) if callable(option) else {}
    return parameters


def wanted_option(value: Any, kind: Any) -> str:
    """Words for the kind that an option should have, empty if it has that kind."""
    origin, within = typing.get_origin(kind), typing.get_args(kind)
    if isinstance(value, jax.core.Tracer):
        return "known before tracing"
    if origin is typing.Literal:
        return "" if value in within else f"one of {', '.join(map(repr, within))}"
    if origin in (types.UnionType, typing.Union):
        expected = [wanted_option(value, alternative) for alternative in within]
        return "" if "" in expected else " or ".join(expected)
    base = origin or kind
    kinds = ALIKE.get(kind, base if inspect.isclass(base) else object)
    if as_whole(value) is None if kind is int else not isinstance(value, kinds):
        return WORDS.get(base, f"a {base.__name__}")
    try:
        hash(value)
    except TypeError:
        return "hashable"
    return ""


@functools.cache
def _keywords(function: Callable[..., Any]) -> dict[str, inspect.Parameter]:
    """Keyword-only parameters without the names of ``GIVEN``."""
    parameters = inspect.signature(function).parameters.items()
    return {n: p for n, p in parameters if p.kind is p.KEYWORD_ONLY and n not in GIVEN}


@functools.cache
def _positional(function: Callable[..., Any]) -> tuple[str, ...]:
    """Names of the positional parameters."""
    parameters = inspect.signature(function).parameters.items()
    return tuple(n for n, p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD))


@functools.cache
def _hints(function: Callable[..., Any]) -> dict[str, Any]:
    """Annotations of a function, empty if they refer to unknown names."""
    try:
        return typing.get_type_hints(function, include_extras=True)
    except (NameError, TypeError):
        return {}


@functools.cache
def _nodes(function: Callable[..., Any]) -> dict[str, NodeKind]:
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
def _reference_type(function: Callable[..., Any]):
    return namedtuple("Reference", list(_nodes(function)))
