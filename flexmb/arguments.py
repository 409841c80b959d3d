"""Checks of arguments of public functions: an error names the argument and states what is right."""

import contextlib
import functools
import inspect
import operator
import reprlib
import types
import typing
from collections.abc import Callable, Iterator, Mapping
from decimal import Decimal
from fractions import Fraction
from functools import partial
from typing import Annotated, Any, Literal, NamedTuple, TypeVar, cast

import jax
import jax.core
import jax.numpy
import numpy as np

from .collecting import Collector
from .errors import ModelError
from .numerical_limits import ROUND_OFF

# Real numbers without a NumPy type.
EXACT = (Fraction, Decimal)
Function = TypeVar("Function", bound=Callable[..., Any])
# Squares and cubes of larger numbers overflow.
LARGEST = 1e100


def is_concrete(tree: Any) -> bool:
    """Whether no leaf of a pytree is traced."""
    if type(tree) in (int, float):
        return True
    return not any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves(tree))


def undifferentiated(tree: Any) -> Any:
    """A pytree whose numbers have no derivatives: numbers that only ``jax.grad`` traces become known."""
    return jax.tree.map(lambda leaf: jax.lax.stop_gradient(leaf) if isinstance(leaf, jax.core.Tracer) else leaf, tree)


def differs_beyond_round_off(one: Any, other: Any) -> np.ndarray:
    """Return which entries of two arrays differ by more than round-off; none if jax.jit or jax.vmap traces a value."""
    one, other = undifferentiated((one, other))
    if not is_concrete((one, other)):
        return np.zeros(1, bool)
    one, other = np.asarray(one), np.asarray(other)
    if one.shape != other.shape:
        return np.ones(1, bool)
    size = np.max(np.abs(other), initial=0.0, where=np.isfinite(other))
    return ~np.isclose(one, other, rtol=0.0, atol=ROUND_OFF * size, equal_nan=True)


def require_double_precision() -> None:
    """Raise RuntimeError in single precision."""
    if jax.dtypes.canonicalize_dtype(np.float64) != np.float64:
        raise RuntimeError(
            "flexmb needs double precision: a leaf spring is 1e5 times stiffer in tension than in bending."
            " Call flexmb.enable_x64() before building a model, and leave it on."
        )


def library_of(numbers: Any) -> Any:
    """NumPy for a tree of known numbers, which compiles nothing; jax.numpy for traced ones."""
    return np if is_concrete(numbers) else jax.numpy


def as_known(tree: Any) -> Any:
    """Known arrays of JAX as arrays of NumPy: within a trace, JAX would trace operations on them."""
    leaves = jax.tree.leaves(tree)
    if not any(isinstance(leaf, jax.Array) for leaf in leaves) or not is_concrete(leaves):
        return tree
    return jax.tree.map(lambda leaf: np.asarray(leaf) if isinstance(leaf, jax.Array) else leaf, tree)


def by_library(function: Callable[..., Any], *given: Any) -> Any:
    """Result of ``function(*given, library)``: NumPy for known numbers, also within a trace, else jax.numpy."""
    if not is_concrete(given):
        return function(*given, jax.numpy)
    with jax.core.eval_context():
        return function(*as_known(given), np)


def copied(tree: Any) -> Any:
    """Copy a pytree's arrays of NumPy, into which the caller may write; fractions and decimals become floats.

    A pytree without any is returned itself: elements that share a section are recognised by identity.
    """
    if not any(isinstance(leaf, (np.ndarray, *EXACT)) for leaf in jax.tree.leaves(tree)):
        return tree

    def leaf_copy(leaf: Any) -> Any:
        return leaf.copy() if isinstance(leaf, np.ndarray) else float(leaf) if isinstance(leaf, EXACT) else leaf

    return jax.tree.map(leaf_copy, tree)


_NOTED = Collector("noted")
# Collect conditions on traced numbers that a check of concrete numbers would refuse, () of bool each.
noting = _NOTED.collecting


def note(condition: Any) -> None:
    """Note a condition that a traced number must meet, () of bool, if :func:`noting` collects them."""
    if (noted := _NOTED.here()) is not None:
        noted.append(condition)


def is_noting() -> bool:
    """Whether conditions on traced numbers are collected here."""
    return _NOTED.here() is not None


def holds(condition: Any) -> bool:
    """Whether a condition holds everywhere; a traced one is noted and counts as true."""
    if is_concrete(condition):
        return bool(np.all(np.asarray(condition)))
    note(jax.numpy.all(condition))
    return True


@contextlib.contextmanager
def nan_if_refused() -> Iterator[Callable[[Any], Any]]:
    """Yield a function that makes a pytree of floats NaN if a condition noted meanwhile is violated.

    Nothing can be raised in a trace. If conditions are already collected further out, numbers stay unchanged.
    """
    if is_noting():
        yield lambda tree: tree
        return
    with noting() as conditions:

        def marked(tree: Any) -> Any:
            if not conditions:
                return tree
            # A factor, since a selection would have zero derivatives.
            factor = jax.numpy.where(jax.numpy.stack(conditions).all(), 1.0, jax.numpy.nan)
            return jax.tree.map(lambda leaf: leaf * factor, tree)

        yield marked


def check_real(what: str, value: Any, fault: type = ValueError) -> None:
    """Raise ``fault`` for complex numbers in a pytree, whose imaginary part real arithmetic would drop."""
    if any(np.iscomplexobj(leaf) for leaf in jax.tree.leaves(value)):
        raise fault(f"{what} must be real, but is complex. Give its real part if that is meant.")


def as_reals(what: str, value: Any, fault: type = ValueError) -> jax.Array:
    """Real numbers as an array of JAX."""
    check_real(what, value, fault)
    return jax.numpy.asarray(value, float)


def as_floats(value: Any) -> Any:
    """Numbers as floats: known ones by NumPy, without compiling, traced ones by JAX."""
    return np.asarray(value, float) if is_concrete(value) else jax.numpy.asarray(value, float)


def returned(what: str, value: Any) -> Any:
    """Numbers that a user's function returned, as an array of JAX; raise ModelError for anything else."""
    check_real(what, value, ModelError)
    try:
        return jax.numpy.atleast_1d(jax.numpy.asarray(value, float))
    except (TypeError, ValueError) as fault:
        raise ModelError(f"{what} must return a number or an array of numbers, not {short_repr(value)}.") from fault


def computed(function: Callable[..., Any], *arrays: Any) -> Any:
    """Result of ``function(xp, *arrays)``: by NumPy for known arrays, since JAX would compile each operation.

    The result is an array of NumPy if all arguments are, else of JAX.
    """
    if not is_concrete(arrays):
        return function(jax.numpy, *arrays)
    result = function(np, *map(np.asarray, arrays))
    return result if all(isinstance(array, np.ndarray) for array in arrays) else jax.device_put(result)


def short_repr(value: Any) -> str:
    """A value as a message quotes it: one shortened line."""
    if isinstance(value, np.ndarray | jax.Array) and is_concrete(value):
        value = np.asarray(value).tolist()
    return " ".join(reprlib.repr(value).split())


def numbers(value: Any) -> np.ndarray | None:
    """Real numbers, nested sequences or arrays of them as an array of float64; None for anything else or traced."""
    try:
        array = np.asarray(value)
        if array.dtype == object and all(type(entry) in (int, float, *EXACT) for entry in array.flat):
            array = array.astype(float)
    except (ValueError, TypeError, OverflowError, jax.errors.TracerArrayConversionError):
        return None
    return array.astype(float) if array.dtype.kind in "iuf" else None


def check_numbers(what: str, value: Any, shape: tuple[int, ...] | None = None, fault: type = ValueError) -> None:
    """Raise ``fault`` for anything but finite real numbers of sensible size and the given shape; traced ones pass."""
    if type(value) in (int, float) and shape in (None, ()) and abs(value) <= LARGEST:
        # The usual case.
        return
    check_real(what, value, fault)
    traced = not is_concrete(value)
    array = None if traced else numbers(value)
    # Dictionaries may hold traced numbers too.
    if isinstance(value, dict) or (not traced and (array is None or (not array.size and shape is None))):
        expected = "a number" if shape == () else "numbers"
        raise fault(f"{what} must be {expected}, not {short_repr(value)}.")
    actual_shape = getattr(value, "shape", shape) if array is None else array.shape
    if shape is not None and actual_shape != shape:
        expected = "be one number" if shape == () else f"have shape {shape}"
        raise fault(f"{what} must {expected}, but has shape {actual_shape}.")
    if array is None:
        return
    if not np.all(np.isfinite(array)):
        raise fault(f"{what} has a value that is not a finite number: {short_repr(value)}.")
    if np.any(np.abs(array) > LARGEST):
        raise fault(f"{what} has a value that is too large to compute with, beyond {LARGEST:g}: {short_repr(value)}.")


def checked_times(times: Any) -> Any:
    """Return two or more ascending times as floats, (n_t,) [s]; on the host if known. Raise ValueError for others."""
    check_numbers("Argument `times`", times)
    array = as_floats(times)
    if array.ndim != 1 or len(array) < 2:
        raise ValueError(f"Argument `times` must be at least two times, not {short_repr(times)}.")
    if is_concrete(array) and not np.all(np.diff(array) > 0):
        raise ValueError("Argument `times` must be ascending, without a time twice.")
    return array


class Range(NamedTuple):
    """Bounds of a number; None for no bound. The number must exceed ``above``."""

    above: float | None = None
    least: float | None = None
    most: float | None = None

    def words(self) -> str:
        """What the number must be, such as "positive" or "at least 1 and at most 9"."""
        parts = [
            "" if self.above is None else "positive" if self.above == 0 else f"greater than {self.above:g}",
            "" if self.least is None else f"at least {self.least:g}",
            "" if self.most is None else f"at most {self.most:g}",
        ]
        return " and ".join(part for part in parts if part) or "finite"

    def holds(self, number: Any) -> Any:
        """Whether a number is finite and within the bounds, () of bool; traced for a traced number."""
        within = (np if is_concrete(number) else jax.numpy).isfinite(number)
        within = within if self.above is None else within & (number > self.above)
        within = within if self.least is None else within & (number >= self.least)
        return within if self.most is None else within & (number <= self.most)


def check_number(
    name: str,
    value: Any,
    *,
    above: float | None = None,
    least: float | None = None,
    most: float | None = None,
    fault: type[ValueError] = ValueError,
) -> Any:
    """Return an argument that is a finite number within a :class:`Range`; the condition of a traced one is noted.

    Raises:
        TypeError: The value is no number.
        ValueError: The number is not finite, or out of range; ``fault`` where given.
    """
    bounds = Range(above, least, most)
    check_real(f"Argument `{name}`", value, fault)
    if not is_concrete(value):
        if np.shape(value) == ():
            note(bounds.holds(value))
        return value
    array = numbers(value)
    if array is None or array.shape != ():
        raise TypeError(f"Argument `{name}` must be one number, not {short_repr(value)}.")
    if not bounds.holds(array):
        raise fault(f"Argument `{name}` must be {bounds.words()}, but is {short_repr(value)}.")
    return value


def check_whole(name: str, value: Any, least: int | None = None, most: int | None = None) -> int:
    """Return an argument that is a whole number within its range, as an int.

    Raises:
        TypeError: The value is no whole number.
        ValueError: The number is out of range.
    """
    number = as_whole(value)
    if number is None:
        raise TypeError(f"Argument `{name}` must be a whole number, not {short_repr(value)}.")
    if (least is not None and number < least) or (most is not None and number > most):
        bounds = Range(least=least, most=most)
        raise ValueError(f"Argument `{name}` must be {bounds.words()}, but is {short_repr(number)}.")
    return number


def as_whole(value: Any) -> int | None:
    """Return a whole number as an int; None for anything else, such as a truth value."""
    if isinstance(value, bool | np.bool_):
        return None
    try:
        return operator.index(value)
    except TypeError:
        return None


def check_flag(name: str, value: Any, fault: type = TypeError) -> Any:
    """Return an argument that is True or False; raise ``fault`` for another."""
    if not isinstance(value, bool | np.bool_):
        raise fault(f"Argument `{name}` must be True or False, not {short_repr(value)}.")
    return value


def check_by_name(name: str, value: Any) -> Any:
    """Return a dictionary by name; an empty list is an empty dictionary. Raise TypeError for anything else."""
    if isinstance(value, list | tuple) and not value:
        return {}
    if not isinstance(value, Mapping):
        raise TypeError(
            f"Argument `{name}` must be a dictionary by name, such as {{'thickness': ..}}, not {short_repr(value)}."
        )
    return value


def check_choice(name: str, value: Any, allowed: tuple, fault: type = ValueError) -> Any:
    """Return an argument that is one of a few values; raise ``fault`` for another."""
    if not any(value is choice or (type(value) is type(choice) and value == choice) for choice in allowed):
        listed = " or ".join(repr(choice) for choice in allowed)
        raise fault(f"Argument `{name}` must be {listed}, but is {short_repr(value)}.")
    return value


# What an argument must be, as its annotation declares it for :func:`checked`. A choice is a ``Literal``.
Positive = Annotated[float, partial(check_number, above=0)]
Count = Annotated[int, partial(check_whole, least=1)]
WholeFromZero = Annotated[int, partial(check_whole, least=0)]
Flag = Annotated[bool, check_flag]
ByName = Annotated[Mapping[str, Any], check_by_name]


def checked(function: Function) -> Function:
    """Check arguments by their annotations before each call of a function.

    An annotation is one of the above, a ``Literal``, or ``Annotated`` with a function of name and value that returns
    the value to use. None passes where the annotation allows it.
    """
    signature = inspect.signature(function)

    @functools.wraps(function)
    def call(*values: Any, **named: Any) -> Any:
        bound = signature.bind(*values, **named)
        for name, (check, optional) in _checks_of(function).items():
            if name in bound.arguments and not (optional and bound.arguments[name] is None):
                bound.arguments[name] = check(name, bound.arguments[name])
        return function(*bound.args, **bound.kwargs)

    return cast(Function, call)


@functools.cache
def _checks_of(function: Callable[..., Any]) -> dict[str, tuple[Callable[[str, Any], Any], bool]]:
    """Check of each argument that has one, and whether the argument may be None."""
    checks = {}
    for name, hint in typing.get_type_hints(function, include_extras=True).items():
        united = isinstance(hint, types.UnionType) or typing.get_origin(hint) is typing.Union
        hints = typing.get_args(hint) if united else (hint,)
        for alternative in hints:
            if typing.get_origin(alternative) is Literal:
                checks[name] = partial(check_choice, allowed=typing.get_args(alternative)), type(None) in hints
            for check in getattr(alternative, "__metadata__", ()):
                checks[name] = check, type(None) in hints
    return {name: check for name, check in checks.items() if name != "return"}
