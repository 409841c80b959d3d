"""The translation of each primitive of JAX to C."""

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from .flatten import Atom, Equation
from .writer import ArrayView, Lazy, Place, Value, Writer, compact, counters, literal, reshaped, variable

# Number of terms of a sum that are written out; more make a loop.
SHORT = 4
# A constant matrix with at least so many entries is multiplied by its nonzero entries if their share is at most this.
# NaN then passes through nonzero entries only.
LARGE, SPARSE = 256, 0.25
RULES: dict[str, Callable[..., list[Value]]] = {}


def rule(*names: str):
    """Register a translation under the names of primitives."""

    def enter(function: Callable[..., Any]):
        for name in names:
            RULES[name] = function
        return function

    return enter


# Elementwise


def broadcast_operand(w: Writer, value: Value, shape: tuple[int, ...]) -> Value:
    """An operand in the wanted shape, with axes of one entry repeated."""
    if value.shape == shape:
        return value
    operand, missing = w.cheap(value), len(shape) - len(value.shape)
    value_shape = value.shape

    def at(index: list[Place]) -> str:
        return operand.at([place if n > 1 else Place() for place, n in zip(index[missing:], value_shape, strict=True)])

    return Lazy(at, 0, shape, value.dtype)


def mapped(w: Writer, equation: Equation, values: list[Value], write: Callable[..., str]) -> list[Value]:
    """An elementwise operation, by its expression from those of the operands."""
    (out,) = equation.outputs
    operands = [broadcast_operand(w, value, out.shape) for value in values]
    cost = 1 + sum(operand.cost for operand in operands)
    return [Lazy(lambda index: write(*(operand.at(index) for operand in operands)), cost, out.shape, out.dtype)]


def wrapped(dtype: np.dtype, text: str) -> str:
    """An integer wrapped to its type."""
    if dtype.kind == "b":
        return text
    bits = f"{'u' if dtype.kind == 'u' else ''}int{8 * dtype.itemsize}_t"
    return f"(({bits})({text}))"


def _by_kind(names: str, decimal: str, integer: str | None = None, truth: str | None = None) -> None:
    """Register operations by their C expressions for numbers, integers and truth values."""

    def translate(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
        dtype = values[-1].dtype
        template = {"f": decimal, "b": truth or integer}.get(dtype.kind, integer)
        if template is None:
            raise NotImplementedError(f"numbers of type {dtype}")
        for word in template.replace("(", " ( ").split():
            if word.startswith("fx_"):
                w.helper(word)
        out = equation.outputs[0].dtype
        wraps = dtype.kind in "iu" and out == dtype
        return mapped(
            w, equation, values, lambda *v: wrapped(out, template.format(*v)) if wraps else template.format(*v)
        )

    for name in names.split():
        RULES[name] = translate


COMPARISONS = {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "eq": "==", "ne": "!="}
OF_MATH = (
    "sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp exp2 expm1 log log1p sqrt cbrt floor ceil erf erfc"
)
# Names of primitives, and their expressions for numbers, integers and truth values.
ELEMENTWISE = (
    ("add add_any", "({} + {})", "(uint64_t){} + (uint64_t){}", "({} | {})"),
    ("sub", "({} - {})", "(uint64_t){} - (uint64_t){}"),
    ("mul", "({} * {})", "(uint64_t){} * (uint64_t){}", "({} & {})"),
    ("div", "({} / {})", "fx_idiv({}, {})"),
    ("rem", "fmod({}, {})", "fx_irem({}, {})"),
    ("max", "fx_max({}, {})", "fx_imax({}, {})", "({} | {})"),
    ("min", "fx_min({}, {})", "fx_imin({}, {})", "({} & {})"),
    ("neg", "(-{})", "-(uint64_t){}"),
    ("abs", "fabs({})", "fx_iabs({})"),
    ("sign", "fx_sign({})", "fx_isign({})"),
    ("square", "fx_square({})", "(uint64_t){0} * (uint64_t){0}"),
    ("is_finite", "(isfinite({}) != 0)"),
    ("lt_to", "fx_before({}, {})", "({} < {})"),
    ("le_to", "(!fx_before({1}, {0}))", "({} <= {})"),
    ("and", "", "{} & {}", "({} & {})"),
    ("or", "", "{} | {}", "({} | {})"),
    ("xor", "", "{} ^ {}", "({} ^ {})"),
    ("not", "", "~{}", "(!{})"),
    ("atan2", "atan2({}, {})"),
    ("nextafter", "nextafter({}, {})"),
    ("rsqrt", "(1.0 / sqrt({}))"),
    ("logistic", "(1.0 / (1.0 + exp(-{})))"),
    *((name, f"({{}} {sign} {{}})", f"({{}} {sign} {{}})") for name, sign in COMPARISONS.items()),
    *((name, f"{name}({{}})") for name in OF_MATH.split()),
)
for _row in ELEMENTWISE:
    _by_kind(*_row)


@rule("pow")
def _pow(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    power = values[1]
    if power.dtype.kind == "f":
        return mapped(w, equation, values, lambda x, y: f"pow({x}, {y})")
    if values[0].dtype.kind != "f":
        raise NotImplementedError("powers of whole numbers")
    return mapped(w, equation, values, lambda x, y: f"pow({x}, (double){y})")


@rule("round")
def _round(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    to_even = int(equation.params["rounding_method"]) == 1
    return mapped(w, equation, values, lambda x: f"{'rint' if to_even else 'round'}({x})")


@rule("integer_pow")
def _integer_pow(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    y = int(equation.params["y"])
    if values[0].dtype.kind != "f":
        return mapped(w, equation, values, lambda x: wrapped(values[0].dtype, f"{w.helper('fx_iipow')}({x}, {y})"))
    if y == 2:
        return mapped(w, equation, values, lambda x: f"{w.helper('fx_square')}({x})")
    return mapped(w, equation, values, lambda x: f"{w.helper('fx_ipow')}({x}, {y})")


@rule("reduce_precision")
def _reduce_precision(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    if (equation.params["exponent_bits"], equation.params["mantissa_bits"]) != (11, 52):
        raise NotImplementedError("less than double precision")
    return values


@rule("clamp")
def _clamp(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    i = "" if values[1].dtype.kind == "f" else "i"
    most, least = w.helper(f"fx_{i}min"), w.helper(f"fx_{i}max")
    return mapped(w, equation, values, lambda lo, x, hi: f"{most}({least}({lo}, {x}), {hi})")


@rule("select_n")
def _select_n(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    def write(which: str, *cases: str) -> str:
        *first, text = cases
        if len(first) == 1:
            return f"({which} ? {text} : {first[0]})"
        for i, case in reversed(list(enumerate(first))):
            text = f"({which} == {i} ? {case} : {text})"
        return text

    return mapped(w, equation, values, write)


@rule("convert_element_type")
def _convert(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    (x,), new = values, equation.outputs[0].dtype
    if x.dtype == new or (x.dtype.kind == "b" and new.kind in "iu"):
        return [x._replace(dtype=new)]
    if new.kind == "b":
        return mapped(w, equation, values, lambda x: f"({x} != 0)")
    if new.kind == "f":
        return mapped(w, equation, values, lambda x: f"(double){x}")
    if x.dtype.kind == "f":
        bounds = np.iinfo(new)
        low = "INT64_MIN" if bounds.min == -(2**63) else f"INT64_C({bounds.min})"
        text = f"{w.helper('fx_whole')}({{}}, {low}, INT64_C({bounds.max}))"
        return mapped(w, equation, values, text.format)
    bounds, old = np.iinfo(new), np.iinfo(x.dtype)
    if bounds.min <= old.min and old.max <= bounds.max:
        return [x._replace(dtype=new)]
    return mapped(w, equation, values, lambda x: wrapped(new, x))


# Shapes


@rule("iota")
def _iota(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    (out,), axis = equation.outputs, equation.params["dimension"]
    cast = "(double)" if out.dtype.kind == "f" else "(int64_t)"
    return [Lazy(lambda index: f"({cast}({index[axis]}))", 0, out.shape, out.dtype)]


@rule("broadcast_in_dim")
def _broadcast(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    (x, *_), (out,) = values, equation.outputs
    axes = tuple(map(int, equation.params["broadcast_dimensions"]))
    if np.prod(out.shape, dtype=int) > np.prod(x.shape, dtype=int):
        x = w.cheap(x)
    if isinstance(x, ArrayView):
        strides = [0] * len(out.shape)
        for axis, length, stride in zip(axes, x.shape, x.strides, strict=True):
            strides[axis] = stride if length > 1 else 0
        return [x._replace(strides=tuple(strides), shape=out.shape)]
    x_shape = x.shape

    def at(index: list[Place]) -> str:
        return x.at([index[axis] if n > 1 else Place() for axis, n in zip(axes, x_shape, strict=True)])

    return [Lazy(at, x.cost, out.shape, out.dtype)]


@rule("reshape", "squeeze", "expand_dims")
def _reshape(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    if equation.params.get("dimensions") is not None and equation.name == "reshape":
        raise NotImplementedError("another order of axes")
    return [in_shape(w, values[0], equation.outputs[0].shape)]


def in_shape(w: Writer, value: Value, shape: tuple[int, ...]) -> Value:
    """The same numbers in another shape."""
    if isinstance(value, Lazy):
        longer = [axis for axis, n in enumerate(shape) if n != 1]
        if [shape[axis] for axis in longer] == [n for n in value.shape if n != 1]:
            value_shape = value.shape

            def at(index: list[Place]) -> str:
                remaining = iter([index[axis] for axis in longer])
                return value.at([next(remaining) if n != 1 else Place() for n in value_shape])

            return Lazy(at, value.cost, shape, value.dtype)
    view = w.stored(value)
    result = reshaped(view, shape)
    if result is None:
        result = reshaped(w.copied(view), shape)
    assert result is not None
    return result


@rule("transpose")
def _transpose(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    (x,), (out,) = values, equation.outputs
    order = tuple(map(int, equation.params["permutation"]))
    if isinstance(x, ArrayView):
        return [x._replace(strides=tuple(x.strides[axis] for axis in order), shape=out.shape)]
    return [Lazy(lambda index: x.at([index[order.index(i)] for i in range(len(order))]), x.cost, out.shape, out.dtype)]


def part(x: Value, starts: list[Place], steps: list[int], shape: tuple[int, ...]) -> Value:
    """A part of an array from a place in steps along each axis, which may be negative."""
    if isinstance(x, ArrayView):
        strides = tuple(stride * step for stride, step in zip(x.strides, steps, strict=True))
        return ArrayView(x.pool, x.place(starts), strides, shape, x.dtype)

    def at(index: list[Place]) -> str:
        return x.at([start + place * step for start, place, step in zip(starts, index, steps, strict=True)])

    return Lazy(at, x.cost, shape, x.dtype)


def window(x: Value, axis: int, at: int | Place, shape: tuple[int, ...]) -> Value:
    """A part of an array that begins at a place along one axis and is complete along the others."""
    place = at if isinstance(at, Place) else Place(at)
    return part(x, [place if i == axis else Place() for i in range(len(shape))], [1] * len(shape), shape)


@rule("slice")
def _slice(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    starts = [Place(start) for start in equation.params["start_indices"]]
    steps = list(equation.params["strides"] or [1] * len(starts))
    return [part(values[0], starts, steps, equation.outputs[0].shape)]


@rule("rev")
def _rev(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    shape, turned = values[0].shape, set(map(int, equation.params["dimensions"]))
    starts = [Place(n - 1 if axis in turned else 0) for axis, n in enumerate(shape)]
    return [part(values[0], starts, [-1 if axis in turned else 1 for axis in range(len(shape))], shape)]


@rule("split")
def _split(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    axis, at, parts = equation.params["axis"], 0, []
    for out in equation.outputs:
        parts.append(window(values[0], axis, at, out.shape))
        at += out.shape[axis]
    return parts


@rule("unstack")
def _unstack(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    (x,), axis = values, equation.params["axis"]
    window_shape = tuple(1 if i == axis else n for i, n in enumerate(x.shape))
    return [in_shape(w, window(x, axis, i, window_shape), out.shape) for i, out in enumerate(equation.outputs)]


def _joined(w: Writer, equation: Equation, operands: list[Value], axis: int) -> list[Value]:
    (out,), at = equation.outputs, 0
    joined = w.new(out.shape, out.dtype)
    for piece in operands:
        to = window(joined, axis, at, piece.shape)
        assert isinstance(to, ArrayView)
        w.store(piece, to)
        at += piece.shape[axis]
    return [joined]


@rule("concatenate")
def _concatenate(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    return _joined(w, equation, values, equation.params["dimension"])


@rule("stack")
def _stack(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    axis = equation.params["axis"]
    shape = tuple(1 if i == axis else n for i, n in enumerate(equation.outputs[0].shape))
    return _joined(w, equation, [in_shape(w, value, shape) for value in values], axis)


@rule("tile")
def _tile(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    (x,), (out,) = values, equation.outputs
    x_shape = (1,) * (len(out.shape) - len(x.shape)) + x.shape
    x = in_shape(w, w.cheap(x), x_shape)
    longer = tuple(
        n for out_length, n in zip(out.shape, x_shape, strict=True) for n in (out_length // n if n else 1, n)
    )
    again = Lazy(lambda index: x.at(index[1::2]), 0, longer, out.dtype)
    return [in_shape(w, w.copied(again), out.shape)]


@rule("pad")
def _pad(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    (x, filling), (out,) = values, equation.outputs
    config = [tuple(map(int, entry)) for entry in equation.params["padding_config"]]
    padded = w.new(out.shape, out.dtype)
    w.store(broadcast_operand(w, filling, out.shape), padded)
    # What stands outside after a negative padding is left away.
    first, count, to = [], [], []
    for (low, _, inner), n, length in zip(config, x.shape, out.shape, strict=True):
        step = inner + 1
        begin = max(0, -(low // step)) if low < 0 else 0
        last = min(n - 1, (length - 1 - low) // step) if length else -1
        first.append(begin)
        count.append(max(0, last - begin + 1))
        to.append(Place(low + begin * step))
    steps = [entry[2] + 1 for entry in config]
    inside = part(x, [Place(entry) for entry in first], [1] * len(first), tuple(count))
    target = part(padded, to, steps, tuple(count))
    assert isinstance(target, ArrayView)
    w.store(inside, target)
    return [padded]


# Sums and products

STARTS = {"sum": "0", "prod": "1", "or": "0", "and": "1", "xor": "0"}


def _combined(w: Writer, kind: str, dtype: np.dtype) -> tuple[str, Callable[[str, str], str]]:
    """Start value of a reduction, and the expression that combines two numbers."""
    decimal = dtype.kind == "f"
    if kind in ("max", "min"):
        if decimal:
            start = "-INFINITY" if kind == "max" else "INFINITY"
        else:
            bounds = np.iinfo(dtype) if dtype.kind in "iu" else None
            bound = 0 if bounds is None else bounds.min if kind == "max" else bounds.max
            start = "INT64_MIN" if bound == -(2**63) else f"INT64_C({1 if bounds is None and kind == 'min' else bound})"
        call = w.helper(f"fx_{'' if decimal else 'i'}{kind}")
        return start, lambda a, b: f"{call}({a}, {b})"
    sign = {"sum": "+", "prod": "*", "or": "|", "and": "&", "xor": "^"}[kind]
    if kind == "and" and dtype.kind in "iu":
        return "-1", lambda a, b: f"({a} & {b})"
    if dtype.kind in "iu" and sign in "+*":
        return STARTS[kind], lambda a, b: wrapped(dtype, f"(uint64_t){a} {sign} (uint64_t){b}")
    return STARTS[kind], lambda a, b: f"({a} {sign} {b})"


def reduced(w: Writer, x: Value, axes: tuple[int, ...], kind: str) -> Value:
    """An array with some axes reduced."""
    kept_axes = [axis for axis in range(len(x.shape)) if axis not in axes]
    shape, inner = tuple(x.shape[axis] for axis in kept_axes), tuple(x.shape[axis] for axis in axes)
    start, combine = _combined(w, kind, x.dtype)
    count = int(np.prod(inner, dtype=int))

    def all_places(outer: list[Place], within: list[Place]) -> list[Place]:
        places = dict(zip([*kept_axes, *axes], [*outer, *within], strict=True))
        return [places[axis] for axis in range(len(x.shape))]

    if 0 < count <= SHORT:
        terms = list(np.ndindex(*inner))

        def at(index: list[Place]) -> str:
            texts = [x.at(all_places(index, [Place(i) for i in term])) for term in terms]
            return functools.reduce(combine, texts)

        return Lazy(at, max(1, count * (x.cost + 1) - 1), shape, x.dtype)
    result = w.new(shape, x.dtype)
    loops, outer = counters("i", shape)
    rounds, within = counters("r", inner)
    kind_of = "double" if x.dtype.kind == "f" else "int64_t"
    if 0 in shape:
        return result
    if count:
        step = f"{rounds}s = {combine('s', x.at(all_places(outer, within)))}; "
        if kind in ("sum", "prod") and step.count("s = (s "):
            sign = "+" if kind == "sum" else "*"
            step = f"{rounds}s {sign}= {x.at(all_places(outer, within))}; "
    else:
        step = ""
    w.add(f"{loops}{{ {kind_of} s = {start}; {step}{result.at(outer)} = s; }}")
    return result


@rule(*(f"reduce_{kind}" for kind in ("sum", "prod", "max", "min", "and", "or", "xor")))
def _reduce(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    axes = tuple(map(int, equation.params["axes"]))
    return [reduced(w, values[0], axes, equation.name.removeprefix("reduce_"))]


@rule("dot_general")
def _dot_general(w: Writer, equation: Equation, values: list[Value], known: list[np.ndarray | None]) -> list[Value]:
    (left, right), (out,) = values, equation.outputs
    (lc, rc), (lb, rb) = (
        tuple(tuple(map(int, axes)) for axes in pair) for pair in equation.params["dimension_numbers"]
    )
    left_axes = [axis for axis in range(len(left.shape)) if axis not in (*lc, *lb)]
    other = [axis for axis in range(len(right.shape)) if axis not in (*rc, *rb)]
    orders = ([*lb, *left_axes, *lc], [*rb, *other, *rc])
    ours = range(len(lb) + len(left_axes)), [*range(len(lb)), *range(len(lb) + len(left_axes), len(out.shape))]
    for side, array in enumerate(known):
        many = array is not None and array.dtype.kind == "f" and array.size >= LARGE
        if array is not None and many and np.count_nonzero(array) <= SPARSE * array.size:
            operand = w.stored(values[1 - side])
            operand = _in_order(operand, orders[1 - side])
            return [_sparse(w, out, np.transpose(array, orders[side]), len(lc), operand, list(ours[side]), len(lb))]
    # An expression that is read once stays an expression.
    left = left if np.prod([right.shape[axis] for axis in other], dtype=int) <= 1 else w.cheap(left)
    right = right if np.prod([left.shape[axis] for axis in left_axes], dtype=int) <= 1 else w.cheap(right)
    along = tuple(left.shape[axis] for axis in lc)

    def at(index: list[Place]) -> str:
        batch, free_places = index[: len(lb)], index[len(lb) :]
        places = (
            [*batch, *free_places[: len(left_axes)], *free_places[len(left_axes) + len(other) :]],
            [*batch, *free_places[len(left_axes) :]],
        )
        texts = []
        for operand, order, operand_places in zip((left, right), orders, places, strict=True):
            by_axis = dict(zip(order, operand_places, strict=True))
            texts.append(operand.at([by_axis[axis] for axis in range(len(order))]))
        if out.dtype.kind == "f":
            return f"({texts[0]} * {texts[1]})"
        return wrapped(out.dtype, f"(uint64_t){texts[0]} * (uint64_t){texts[1]}")

    product = Lazy(at, 1 + left.cost + right.cost, (*out.shape, *along), out.dtype)
    axes = tuple(range(len(out.shape), len(out.shape) + len(along)))
    return [reduced(w, product, axes, "sum") if axes else product]


def _in_order(view: ArrayView, axes: list[int]) -> ArrayView:
    """The same numbers with axes in another order."""
    shape, strides = (tuple(kind[axis] for axis in axes) for kind in (view.shape, view.strides))
    return view._replace(shape=shape, strides=strides)


def _sparse(
    w: Writer, out: Atom, array: np.ndarray, summed: int, other: ArrayView, axes: list[int], batch: int
) -> ArrayView:
    """A product with the nonzero entries of a constant, row by row.

    The last ``summed`` axes of both operands are summed over. ``axes`` of the product belong to the constant, and its
    first ``batch`` axes to both.
    """
    rows, columns = array.shape[: array.ndim - summed], array.shape[array.ndim - summed :]
    table = array.reshape(int(np.prod(rows, dtype=int)), -1)
    row, column = np.nonzero(table)
    steps = np.zeros(columns, np.int64)
    for axis, stride in enumerate(other.strides[len(other.strides) - summed :]):
        steps += np.arange(columns[axis]).reshape([-1 if i == axis else 1 for i in range(summed)]) * stride
    ends = w.tables.start("I", np.searchsorted(row, np.arange(len(table) + 1)))
    places, numbers = w.tables.start("I", steps.ravel()[column]), w.tables.start("K", table[row, column])
    product = w.new(out.shape, out.dtype)
    loops, index = counters("i", out.shape)
    at = ends
    for axis, stride in zip(axes, compact(rows), strict=True):
        at = at + index[axis] * stride
    entry_index = [*index[:batch], *(index[axis] for axis in range(batch, len(out.shape)) if axis not in axes)]
    start = other.place([*entry_index, *[Place()] * summed])
    entry = f"{other.pool}[{start + variable(f'I[k+{places}]')}]"
    step = f"for (int64_t k = I[{at}]; k < I[{at + 1}]; k++) s += K[k+{numbers}] * {entry};"
    w.add(f"{loops}{{ double s = 0; {step} {product.at(index)} = s; }}")
    return product


@rule("cumsum", "cumprod", "cummax", "cummin")
def _cumulative(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    (x,), axis, kind = values, equation.params["axis"], equation.name.removeprefix("cum")
    start, combine = _combined(w, kind, x.dtype)
    result, n = w.new(x.shape, x.dtype), x.shape[axis]
    if 0 in x.shape:
        return [result]
    loops, index = counters("i", tuple(1 if i == axis else length for i, length in enumerate(x.shape)))
    index[axis] = variable("r") * -1 + (n - 1) if equation.params["reverse"] else variable("r")
    kind_of = "double" if x.dtype.kind == "f" else "int64_t"
    step = f"s = {combine('s', x.at(index))}; {result.at(index)} = s;"
    w.add(f"{loops}{{ {kind_of} s = {start}; F(r, {n}) {{ {step} }} }}")
    return [result]


@rule("argmax", "argmin")
def _arg(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    (x,), (out,), (axis,) = values, equation.outputs, equation.params["axes"]
    result = w.new(out.shape, out.dtype)
    if 0 in out.shape:
        return [result]
    loops, index = counters("i", out.shape)
    sign = ">" if equation.name == "argmax" else "<"
    kind_of = "double" if x.dtype.kind == "f" else "int64_t"
    first = x.at([*index[:axis], Place(), *index[axis:]])
    candidate = x.at([*index[:axis], variable("r"), *index[axis:]])
    # The first NaN is the answer.
    better = f"v {sign} s || (v != v && s == s)" if x.dtype.kind == "f" else f"v {sign} s"
    step = f"{{ {kind_of} v = {candidate}; if ({better}) {{ s = v; k = r; }} }}"
    w.add(f"{loops}{{ {kind_of} s = {first}; int k = 0; F(r, {x.shape[axis]}) {step} {result.at(index)} = k; }}")
    return [result]


@rule("sort")
def _sort(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    axis, keys = equation.params["dimension"], equation.params["num_keys"]
    shape = values[0].shape
    copies = [w.copied(value) for value in values]
    if 0 in shape:
        return list(copies)
    loops, index = counters("i", tuple(1 if i == axis else n for i, n in enumerate(shape)))

    def at(view: ArrayView, place: Place) -> str:
        return view.at([*index[:axis], place, *index[axis + 1 :]])

    upper, lower = variable("k"), variable("k") + (-1)
    before = "0"
    for view in reversed(copies[:keys]):
        a, b = at(view, upper), at(view, lower)
        less = f"{w.helper('fx_sooner')}({a}, {b})" if view.dtype.kind == "f" else f"{a} < {b}"
        more = f"fx_sooner({b}, {a})" if view.dtype.kind == "f" else f"{b} < {a}"
        before = f"({less} || (!({more}) && {before}))"
    swaps = ""
    for view in copies:
        kind_of, a, b = "double" if view.dtype.kind == "f" else "int64_t", at(view, upper), at(view, lower)
        swaps += f"{{ {kind_of} v = {a}; {a} = {b}; {b} = v; }} "
    w.add(f"{loops}F(r, {shape[axis]}) for (int k = r; k > 0 && {before}; k--) {{ {swaps}}}")
    return list(copies)


# Matrices


def _call_each(w: Writer, batch: tuple[int, ...], name: str, *arguments: Any) -> None:
    """Call a helper for each entry of a batch, with the place of the entry for arrays."""
    loops, index = counters("i", batch)
    index = [*index, Place(), Place()]
    if not any(isinstance(argument, ArrayView) and 0 in argument.shape for argument in arguments):
        words = (
            f"{argument.pool} + {argument.place(index[: len(argument.shape)])}"
            if isinstance(argument, ArrayView)
            else str(int(argument))
            for argument in arguments
        )
        w.add(f"{loops}{w.helper(name)}({', '.join(words)});")


@rule("lu")
def _lu(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    lu = w.copied(values[0])
    pivots, order = (w.new(atom.shape, atom.dtype) for atom in equation.outputs[1:])
    _call_each(w, lu.shape[:-2], "fx_lu", lu, pivots, order, *lu.shape[-2:])
    return [lu, pivots, order]


@rule("lu_pivots_to_permutation")
def _permutation(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    pivots, order = w.copied(values[0]), w.new(equation.outputs[0].shape, equation.outputs[0].dtype)
    _call_each(w, pivots.shape[:-1], "fx_permutation", pivots, order, pivots.shape[-1], order.shape[-1])
    return [order]


@rule("triangular_solve")
def _triangular(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    a, x = w.stored(values[0]), w.copied(values[1])
    params = equation.params
    lower, turned = params["lower"], params["transpose_a"]
    row, column = a.strides[-2:]
    down, across = x.strides[-2:]
    count = x.shape[-1]
    if not params["left_side"]:
        # X A = B is A^T X^T = B^T.
        turned, down, across, count = not turned, across, down, x.shape[-2]
    if turned:
        row, column, lower = column, row, not lower
    sizes = a.shape[-1], count, lower, params["unit_diagonal"]
    _call_each(w, x.shape[:-2], "fx_triangle", a, row, column, x, down, across, *sizes)
    return [x]


@rule("cholesky")
def _cholesky(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    factor = w.copied(values[0])
    _call_each(w, factor.shape[:-2], "fx_cholesky", factor, factor.shape[-1])
    return [factor]


# Places by index


def _start(w: Writer, value: Value, most: int) -> Place:
    """A place that is worked out, kept within bounds as JAX does."""
    text = w.cheap(value).at([])
    if text.isdigit() or text.strip("()").lstrip("-").isdigit():
        return Place(min(max(int(text.strip("()")), 0), most))
    return variable(f"{w.helper('fx_clip')}({text}, {most})")


@rule("dynamic_slice")
def _dynamic_slice(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    x, *starts = values
    sizes = equation.outputs[0].shape
    places = [_start(w, start, n - size) for start, n, size in zip(starts, x.shape, sizes, strict=True)]
    return [part(x, places, [1] * len(sizes), sizes)]


@rule("dynamic_update_slice")
def _dynamic_update_slice(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    x, change, *starts = values
    places = [_start(w, start, n - size) for start, n, size in zip(starts, x.shape, change.shape, strict=True)]
    result = w.copied(x)
    to = part(result, places, [1] * len(places), change.shape)
    assert isinstance(to, ArrayView)
    w.store(change, to)
    return [result]


class _Indices:
    """Where windows begin, by the indices of a gather or scatter."""

    def __init__(self, w: Writer, equation: Equation, indices: Value, known: np.ndarray | None, most: dict[int, int]):
        self.w, self.most = w, most
        name = getattr(equation.params["mode"], "name", str(equation.params["mode"]))
        self.drops = name == "FILL_OR_DROP"
        self.columns: dict[int, Value] = {}
        self.known = known is not None
        self.guarded: Value | None = None
        if known is None:
            view, shape = w.cheap(indices), (*indices.shape[:-1], 1)
            for k, axis in enumerate(most):
                self.columns[axis] = part(view, [*[Place()] * (len(shape) - 1), Place(k)], [1] * len(shape), shape)
            return
        inside = np.ones(known.shape[:-1], bool)
        for k, (axis, bound) in enumerate(most.items()):
            column = known[..., k].astype(np.int64)
            inside &= (column >= 0) & (column <= bound)
            self.columns[axis] = w.tables.value(np.clip(column, 0, max(bound, 0)))
        if self.drops and not inside.all():
            self.guarded = w.tables.value(inside)

    def place(self, axis: int, batch: list[Place]) -> Place:
        """Where a window begins along an axis."""
        column = self.columns[axis]
        if not self.known:
            return variable(f"{self.w.helper('fx_clip')}({column.at([*batch, Place()])}, {self.most[axis]})")
        if isinstance(column, ArrayView):
            return variable(column.at(batch))
        even = column.at([Place()] * len(batch)).strip("()")
        start = Place(int(even))
        for i, position in enumerate(batch):
            unit = [Place(1 if k == i else 0) for k in range(len(batch))]
            start = start + position * (int(column.at(unit).strip("()")) - int(even))
        return start

    def guard(self, batch: list[Place]) -> str | None:
        """A condition by the index within the batch; None where no window lies outside or all are kept inside."""
        if self.known:
            return None if self.guarded is None else self.guarded.at(batch)
        if not self.drops:
            return None
        texts = [(self.columns[axis].at([*batch, Place()]), bound) for axis, bound in self.most.items()]
        return " && ".join(f"{text} >= 0 && {text} <= {bound}" for text, bound in texts)


def _places(
    indices: _Indices, batch: list[Place], window: dict[int, Place], paired: dict[int, int], rank: int
) -> list[Place]:
    places = []
    for axis in range(rank):
        place = window.get(axis, Place())
        if axis in paired:
            place = place + batch[paired[axis]]
        if axis in indices.most:
            place = place + indices.place(axis, batch)
        places.append(place)
    return places


@rule("gather")
def _gather(w: Writer, equation: Equation, values: list[Value], known: list[np.ndarray | None]) -> list[Value]:
    (x, indices), (out,), params = values, equation.outputs, equation.params
    numbers, sizes = params["dimension_numbers"], [int(size) for size in params["slice_sizes"]]
    collapsed = (*map(int, numbers.collapsed_slice_dims), *map(int, numbers.operand_batching_dims))
    offsets = list(map(int, numbers.offset_dims))
    along = [axis for axis in range(len(x.shape)) if axis not in collapsed]
    batch_axes = [axis for axis in range(len(out.shape)) if axis not in offsets]
    paired = dict(
        zip(map(int, numbers.operand_batching_dims), map(int, numbers.start_indices_batching_dims), strict=True)
    )
    if 0 in out.shape:
        return [Lazy(lambda index: "0", 0, out.shape, out.dtype)]
    most = {int(axis): x.shape[axis] - sizes[axis] for axis in numbers.start_index_map}
    where = _Indices(w, equation, indices, known[1], most)
    source = w.cheap(x)

    def at(index: list[Place]) -> str:
        batch = [index[axis] for axis in batch_axes]
        window = {axis: index[offset] for axis, offset in zip(along, offsets, strict=True)}
        text = source.at(_places(where, batch, window, paired, len(source.shape)))
        guard = where.guard(batch)
        return text if guard is None else f"({guard} ? {text} : {filling})"

    filling = _filling(params.get("fill_value"), out.dtype)
    if where.known and where.guarded is None and isinstance(source, ArrayView):
        even = _even(source, lambda index: _places(
            where, [index[axis] for axis in batch_axes],
            {axis: index[offset] for axis, offset in zip(along, offsets, strict=True)}, paired, len(source.shape),
        ), out.shape)  # fmt: skip
        if even is not None:
            return [even]
    return [Lazy(at, 0 if where.known else 1, out.shape, out.dtype)]


def _even(source: ArrayView, places: Callable[[list[Place]], list[Place]], shape: tuple[int, ...]) -> ArrayView | None:
    """A gather as a view, where its places grow evenly."""
    names = [f"i{axis}" for axis in range(len(shape))]
    place = source.place(places([variable(name) for name in names]))
    other_terms = {key: factor for key, factor in place.terms.items() if key not in names}
    if any(key.startswith("I[") for key in other_terms):
        return None
    strides = tuple(place.terms.get(name, 0) for name in names)
    return ArrayView(source.pool, Place(place.constant, other_terms, place.buffer), strides, shape, source.dtype)


def _filling(value: Any, dtype: np.dtype) -> str:
    if value is not None:
        return literal(value, dtype)
    if dtype.kind == "f":
        return "NAN"
    if dtype.kind == "b":
        return "1"
    bounds = np.iinfo(dtype)
    return literal(bounds.max if dtype.kind == "u" else bounds.min, dtype)


@rule("scatter", "scatter-add", "scatter_add", "scatter-mul", "scatter_mul", "scatter-min", "scatter_min",
      "scatter-max", "scatter_max", "scatter-sub", "scatter_sub")  # fmt: skip
def _scatter(w: Writer, equation: Equation, values: list[Value], known: list[np.ndarray | None]) -> list[Value]:
    (x, indices, change), params = values, equation.params
    numbers = params["dimension_numbers"]
    windows = list(map(int, numbers.update_window_dims))
    inserted = (*map(int, numbers.inserted_window_dims), *map(int, numbers.operand_batching_dims))
    along = [axis for axis in range(len(x.shape)) if axis not in inserted]
    batch_axes = [axis for axis in range(len(change.shape)) if axis not in windows]
    paired = dict(
        zip(map(int, numbers.operand_batching_dims), map(int, numbers.scatter_indices_batching_dims), strict=True)
    )
    result = w.copied(x)
    if 0 in change.shape:
        return [result]
    size = {axis: change.shape[window_axis] for axis, window_axis in zip(along, windows, strict=True)}
    most = {int(axis): x.shape[axis] - size.get(int(axis), 1) for axis in numbers.scatter_dims_to_operand_dims}
    where = _Indices(w, equation, indices, known[1], most)
    loops, index = counters("i", change.shape)
    batch = [index[axis] for axis in batch_axes]
    window = {axis: index[window_axis] for axis, window_axis in zip(along, windows, strict=True)}
    target = result.at(_places(where, batch, window, paired, len(x.shape)))
    update, kind = change.at(index), equation.name.removeprefix("scatter").strip("-_")
    if kind in ("min", "max"):
        call = w.helper(f"fx_{'' if x.dtype.kind == 'f' else 'i'}{kind}")
        update = f"{call}({target}, {update})"
    elif x.dtype.kind == "b" and kind:
        raise NotImplementedError("truth values that are added")
    sign = {"add": "+=", "sub": "-=", "mul": "*="}.get(kind, "=")
    guard = where.guard(batch)
    w.add(f"{loops}{f'if ({guard}) ' if guard else ''}{target} {sign} {update};")
    return [result]


# What is written otherwise where operands are constants.
BY_CONSTANTS = frozenset(name for name, function in RULES.items() if function in (_gather, _scatter, _dot_general))
