"""Formulas of numbers from names, read from a trace of the function that computes them."""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import jax
import jax.core
import numpy as np
from jax.extend.core import ClosedJaxpr, Jaxpr, Literal

from ..arguments import noting

# Binding strength of operations. An operand that binds less stands in parentheses.
_SUM, _PRODUCT, _SIGN, _POWER, _ATOM = 1, 2, 3, 4, 5
_SIGNS = {"add": ("+", _SUM), "sub": ("-", _SUM), "mul": ("*", _PRODUCT), "div": ("/", _PRODUCT)}
# Operations that move numbers without changing them. They run on indices of formulas in a table.
_MOVES = (
    "broadcast_in_dim stack concatenate reshape squeeze slice dynamic_slice gather transpose rev expand_dims pad"
    " select_n copy copy_p convert_element_type stop_gradient scatter dynamic_update_slice device_put split"
).split()
_CALLS = ("jaxpr", "call_jaxpr", "fun_jaxpr")


class Formula(NamedTuple):
    """Arithmetic of numbers and names, None if there is none, and the binding strength of its last operation."""

    text: str | None
    rank: int = _ATOM


LOST = Formula(None)


def number_text(value: float) -> str:
    """A short text that reads back to the same number; powers of a thousand if that is shorter."""
    value = float(value)
    if value == math.pi:
        return "pi"
    if value == 0:
        return "0"
    plain = repr(value).removesuffix(".0")
    figures = next((n for n in range(17) if float(f"{value:.{n}e}") == value), 17)
    mantissa, _, power = f"{abs(value):.{figures}e}".partition("e")
    shift = int(power) % 3
    digits = mantissa.replace(".", "").ljust(shift + 1, "0")
    decimals = digits[shift + 1 :].rstrip("0")
    thousands = f"{'-' * (value < 0)}{digits[: shift + 1]}{'.' * bool(decimals)}{decimals}e{int(power) - shift}"
    if float(thousands) != value or ("e" not in plain and len(plain) <= len(thousands) + 1):
        return plain
    return thousands


def formulas(
    function: Callable[[dict[str, Any]], list[Any]], names: Mapping[str, float]
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Arithmetic that repeats a function operation by operation.

    Returns:
        For each returned number or array an object array of :class:`Formula` in its shape; and the values.
    """

    def noted(numbers: dict[str, Any]) -> list[Any]:
        # Checks of numbers are no part of their formulas.
        with noting():
            return function(numbers)

    program = jax.make_jaxpr(noted)({name: float(value) for name, value in names.items()})
    reader = _FormulaReader()
    # JAX flattens a dictionary in the order of its keys.
    ordered = sorted(names)
    inputs = [np.asarray(reader.place(Formula(name)), float) for name in ordered]
    texts = [reader.texts(value) for value in reader.run(program.jaxpr, program.consts, inputs)]
    values = jax.core.eval_jaxpr(program.jaxpr, program.consts, *(float(names[name]) for name in ordered))
    return texts, [np.asarray(value) for value in values]


class _Known(NamedTuple):
    """Numbers that depend on no name."""

    value: Any


class _FormulaReader:
    """One reading: a table of formulas, and arrays of indices into it instead of numbers."""

    def __init__(self):
        self.table: list[Formula] = [LOST]
        self.places: dict[Formula, int] = {LOST: 0}

    def place(self, formula: Formula) -> int:
        if formula not in self.places:
            self.places[formula] = len(self.table)
            self.table.append(formula)
        return self.places[formula]

    def placed(self, value: Any) -> np.ndarray:
        """Indices of the formulas of an array, also of a known one."""
        if not isinstance(value, _Known):
            return value
        array = np.asarray(value.value, float)
        flat = [self.place(_constant(number)) for number in array.ravel().tolist()]
        return np.array(flat, float).reshape(array.shape)

    def texts(self, value: Any) -> np.ndarray:
        places = self.placed(value)
        texts = np.empty(places.shape, object)
        for at in np.ndindex(places.shape):
            texts[at] = self.table[int(places[at])]
        return texts

    def run(self, jaxpr: Jaxpr, constants: Any, given: list[Any]) -> list[Any]:
        values: dict[Any, Any] = dict(zip(jaxpr.constvars, map(_Known, constants), strict=True))
        values |= zip(jaxpr.invars, given, strict=True)
        for equation in jaxpr.eqns:
            results = self.results(equation, [_value_of(atom, values) for atom in equation.invars])
            values |= zip(equation.outvars, results, strict=True)
        return [_value_of(atom, values) for atom in jaxpr.outvars]

    def results(self, equation: Any, given: list[Any]) -> list[Any]:
        """Results of one operation."""
        kind = equation.primitive.name
        inner = next((equation.params[name] for name in _CALLS if name in equation.params), None)
        if isinstance(inner, ClosedJaxpr):
            return self.run(inner.jaxpr, inner.consts, given)
        if all(isinstance(value, _Known) for value in given):
            return [_Known(result) for result in _bound(equation, [value.value for value in given])]
        # Integers and flags are instructions of an operation that moves numbers.
        numbers = [atom.aval.dtype.kind == "f" for atom in equation.invars]
        known = all(is_number or isinstance(v, _Known) for v, is_number in zip(given, numbers, strict=True))
        if kind in _MOVES and known and all(out.aval.dtype.kind == "f" for out in equation.outvars):
            moved = [self.placed(v) if is_number else v.value for v, is_number in zip(given, numbers, strict=True)]
            return [np.asarray(result) for result in _bound(equation, moved)]
        if (how := _arithmetic(kind, equation.params)) is not None:
            places = np.broadcast_arrays(*(self.placed(value) for value in given))
            rows = zip(*(p.ravel() for p in places), strict=True)
            flat = [self.place(how(*(self.table[int(p)] for p in row))) for row in rows]
            return [np.array(flat, float).reshape(places[0].shape)]
        return [np.zeros(out.aval.shape) for out in equation.outvars]


def _bound(equation: Any, given: list[Any]) -> list[Any]:
    """Results of an operation on numbers."""
    outputs = equation.primitive.bind(*given, **equation.params)
    return outputs if equation.primitive.multiple_results else [outputs]


def _value_of(atom: Any, values: dict[Any, Any]) -> Any:
    return _Known(atom.val) if isinstance(atom, Literal) else values[atom]


def _constant(value: float) -> Formula:
    if not math.isfinite(value):
        return LOST
    text = number_text(value)
    return Formula(text, _SIGN if text.startswith("-") else _ATOM)


def _arithmetic(kind: str, parameters: dict[str, Any]) -> Callable[..., Formula] | None:
    """The operation on formulas for an operation on numbers; None if arithmetic has no such operation."""
    if kind in _SIGNS:
        sign, rank = _SIGNS[kind]
        return lambda a, b: _joined(a, sign, b, rank)
    if kind == "neg":
        return lambda a: LOST if a.text is None else Formula(f"-{_inside(a, _POWER)}", _SIGN)
    powers = {"square": 2, "sqrt": 0.5, "rsqrt": -0.5, "integer_pow": parameters.get("y")}
    if kind in powers:
        return lambda a: _joined(a, "**", _constant(float(powers[kind])), _POWER)
    if kind == "pow":
        return lambda a, b: _joined(a, "**", b, _POWER)
    return None


def _joined(a: Formula, sign: str, b: Formula, rank: int) -> Formula:
    if a.text is None or b.text is None:
        return LOST
    # Simplifications that change no bit of a finite number.
    if sign == "*" and "0" in (a.text, b.text):
        return Formula("0")
    if (sign == "+" and a.text == "0") or (sign == "*" and a.text == "1"):
        return b
    if (sign in "+-" and b.text == "0") or (sign in ("*", "/", "**") and b.text == "1"):
        return a
    # Operations of the same rank run from the left.
    left = _inside(a, rank + 1 if sign == "**" else rank)
    return Formula(f"{left}{sign}{_inside(b, rank + 1)}", rank)


def _inside(a: Formula, least: int) -> str:
    return f"{a.text}" if a.rank >= least else f"({a.text})"
