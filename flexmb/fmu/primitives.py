"""The translation of each primitive of JAX to C."""

import functools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .flatten import Atom, Equation
from .writer import ArrayView, Lazy, Place, Value, Writer, c_type, compact, counters, literal, transposed, variable

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


def broadcast(w: Writer, value: Value, axes: Sequence[int], shape: tuple[int, ...]) -> Value:
    """An array in a larger shape. Its axes become ``axes`` there; entries repeat along all other axes."""
    if value.shape == shape:
        return value
    if np.prod(shape, dtype=int) > np.prod(value.shape, dtype=int):
        value = w.cheap(value)
    return value.by_axes([axis if n > 1 else None for axis, n in zip(axes, value.shape, strict=True)], shape)


def mapped(w: Writer, equation: Equation, values: list[Value], write: Callable[..., str]) -> list[Value]:
    """An elementwise operation, by its expression from those of the operands."""
    (out,) = equation.outputs
    rank = len(out.shape)
    operands = [broadcast(w, value, range(rank - len(value.shape), rank), out.shape) for value in values]
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
    ("clamp", "fx_min(fx_max({}, {}), {})", "fx_imin(fx_imax({}, {}), {})"),
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
        low, high = (literal(bound, new) for bound in bounds(new))
        return mapped(w, equation, values, f"{w.helper('fx_whole')}({{}}, {low}, {high})".format)
    (low, high), (old_low, old_high) = bounds(new), bounds(x.dtype)
    if low <= old_low and old_high <= high:
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
    axes = tuple(map(int, equation.params["broadcast_dimensions"]))
    return [broadcast(w, values[0], axes, equation.outputs[0].shape)]


@rule("reshape", "squeeze", "expand_dims")
def _reshape(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    if equation.params.get("dimensions") is not None and equation.name == "reshape":
        raise NotImplementedError("another order of axes")
    return [w.in_shape(values[0], equation.outputs[0].shape)]


@rule("transpose")
def _transpose(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    return [transposed(values[0], tuple(map(int, equation.params["permutation"])))]


def start_along(axis: int, at: int, rank: int) -> list[Place]:
    """Start of a part of an array that is complete along all other axes."""
    return [Place(at if i == axis else 0) for i in range(rank)]


@rule("slice")
def _slice(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    starts = [Place(start) for start in equation.params["start_indices"]]
    steps = list(equation.params["strides"] or [1] * len(starts))
    return [values[0].part(starts, equation.outputs[0].shape, steps)]


@rule("rev")
def _rev(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    shape, turned = values[0].shape, set(map(int, equation.params["dimensions"]))
    starts = [Place(n - 1 if axis in turned else 0) for axis, n in enumerate(shape)]
    return [values[0].part(starts, shape, [-1 if axis in turned else 1 for axis in range(len(shape))])]


@rule("split")
def _split(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    axis, at, parts = equation.params["axis"], 0, []
    for out in equation.outputs:
        parts.append(values[0].part(start_along(axis, at, len(out.shape)), out.shape))
        at += out.shape[axis]
    return parts


@rule("unstack")
def _unstack(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    (x,), axis = values, equation.params["axis"]
    rank, row = len(x.shape), tuple(1 if i == axis else n for i, n in enumerate(x.shape))
    rows = [x.part(start_along(axis, i, rank), row) for i in range(x.shape[axis])]
    return [w.in_shape(value, out.shape) for value, out in zip(rows, equation.outputs, strict=True)]


def _joined(w: Writer, equation: Equation, operands: list[Value], axis: int) -> list[Value]:
    (out,), at = equation.outputs, 0
    joined = w.new(out.shape, out.dtype)
    for piece in operands:
        w.store(piece, joined.part(start_along(axis, at, len(out.shape)), piece.shape))
        at += piece.shape[axis]
    return [joined]


@rule("concatenate")
def _concatenate(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    return _joined(w, equation, values, equation.params["dimension"])


@rule("stack")
def _stack(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    axis = equation.params["axis"]
    shape = tuple(1 if i == axis else n for i, n in enumerate(equation.outputs[0].shape))
    return _joined(w, equation, [w.in_shape(value, shape) for value in values], axis)


@rule("tile")
def _tile(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    (x,), (out,) = values, equation.outputs
    x_shape = (1,) * (len(out.shape) - len(x.shape)) + x.shape
    x = w.in_shape(w.cheap(x), x_shape)
    longer = tuple(
        n for out_length, n in zip(out.shape, x_shape, strict=True) for n in (out_length // n if n else 1, n)
    )
    again = Lazy(lambda index: x.at(index[1::2]), 0, longer, out.dtype)
    return [w.in_shape(w.copied(again), out.shape)]


@rule("pad")
def _pad(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    (x, filling), (out,) = values, equation.outputs
    config = [tuple(map(int, entry)) for entry in equation.params["padding_config"]]
    padded = w.new(out.shape, out.dtype)
    w.store(broadcast(w, filling, (), out.shape), padded)
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
    w.store(x.part([Place(entry) for entry in first], tuple(count)), padded.part(to, tuple(count), steps))
    return [padded]


# Sums and products

# Start values and operators.
OPERATORS = {"sum": ("0", "+"), "prod": ("1", "*"), "or": ("0", "|"), "and": ("1", "&"), "xor": ("0", "^")}


def bounds(dtype: np.dtype) -> tuple[Any, Any]:
    """Least and largest number of a type."""
    if dtype.kind in "fb":
        return (-np.inf, np.inf) if dtype.kind == "f" else (0, 1)
    return np.iinfo(dtype).min, np.iinfo(dtype).max


def _combined(w: Writer, kind: str, dtype: np.dtype) -> tuple[str, Callable[[str, str], str]]:
    """Start value of a reduction, and the expression that combines two numbers."""
    if kind in ("max", "min"):
        call = w.helper(f"fx_{'' if dtype.kind == 'f' else 'i'}{kind}")
        return literal(bounds(dtype)[kind == "min"], dtype), lambda a, b: f"{call}({a}, {b})"
    start, sign = OPERATORS[kind]
    if dtype.kind in "iu" and sign in "+*":
        return start, lambda a, b: wrapped(dtype, f"(uint64_t){a} {sign} (uint64_t){b}")
    return "-1" if kind == "and" and dtype.kind in "iu" else start, lambda a, b: f"({a} {sign} {b})"


def reduced(w: Writer, x: Value, axes: tuple[int, ...], kind: str) -> Value:
    """An array with some axes reduced."""
    kept_axes = [axis for axis in range(len(x.shape)) if axis not in axes]
    shape, inner = tuple(x.shape[axis] for axis in kept_axes), tuple(x.shape[axis] for axis in axes)
    start, combine = _combined(w, kind, x.dtype)
    count = int(np.prod(inner, dtype=int))
    x = transposed(x, [*kept_axes, *axes])
    if 0 < count <= SHORT:
        terms = list(np.ndindex(*inner))

        def at(index: list[Place]) -> str:
            return functools.reduce(combine, [x.at([*index, *map(Place, term)]) for term in terms])

        return Lazy(at, max(1, count * (x.cost + 1) - 1), shape, x.dtype)
    result = w.new(shape, x.dtype)
    loops, outer = counters("i", shape)
    rounds, within = counters("r", inner)
    if 0 in shape:
        return result
    step = ""
    if count:
        entry = x.at([*outer, *within])
        step = f"{rounds}s = {combine('s', entry)}; "
        if kind in ("sum", "prod") and step.count("s = (s "):
            step = f"{rounds}s {'+' if kind == 'sum' else '*'}= {entry}; "
    w.add(f"{loops}{{ {c_type(x.dtype)} s = {start}; {step}{result.at(outer)} = s; }}")
    return result


@rule(*(f"reduce_{kind}" for kind in ("sum", "prod", "max", "min", "and", "or", "xor")))
def _reduce(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    axes = tuple(map(int, equation.params["axes"]))
    return [reduced(w, values[0], axes, equation.name.removeprefix("reduce_"))]


@rule("dot_general")
def _dot_general(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    (left, right), (out,) = values, equation.outputs
    (lc, rc), (lb, rb) = (
        tuple(tuple(map(int, axes)) for axes in pair) for pair in equation.params["dimension_numbers"]
    )
    left_axes = [axis for axis in range(len(left.shape)) if axis not in (*lc, *lb)]
    other = [axis for axis in range(len(right.shape)) if axis not in (*rc, *rb)]
    orders = ([*lb, *left_axes, *lc], [*rb, *other, *rc])
    n_batch, n_left = len(lb), len(lb) + len(left_axes)
    ours = range(n_left), [*range(n_batch), *range(n_left, len(out.shape))]
    for side, atom in enumerate(equation.inputs):
        array = w.constants.get(atom)
        many = array is not None and array.dtype.kind == "f" and array.size >= LARGE
        if array is not None and many and np.count_nonzero(array) <= SPARSE * array.size:
            operand = w.stored(transposed(values[1 - side], orders[1 - side]))
            return [_sparse(w, out, np.transpose(array, orders[side]), len(lc), operand, list(ours[side]), n_batch)]
    # An expression that is read once stays an expression.
    left = left if np.prod([right.shape[axis] for axis in other], dtype=int) <= 1 else w.cheap(left)
    right = right if np.prod([left.shape[axis] for axis in left_axes], dtype=int) <= 1 else w.cheap(right)
    along, rank = tuple(left.shape[axis] for axis in lc), len(out.shape)
    first, second = transposed(left, orders[0]), transposed(right, orders[1])

    def at(index: list[Place]) -> str:
        a = first.at([*index[:n_left], *index[rank:]])
        b = second.at([*index[:n_batch], *index[n_left:]])
        return f"({a} * {b})" if out.dtype.kind == "f" else wrapped(out.dtype, f"(uint64_t){a} * (uint64_t){b}")

    product = Lazy(at, 1 + left.cost + right.cost, (*out.shape, *along), out.dtype)
    axes = tuple(range(rank, rank + len(along)))
    return [reduced(w, product, axes, "sum") if axes else product]


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
    steps = np.tensordot(other.strides[len(other.strides) - summed :], np.indices(columns), 1)
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
    step = f"s = {combine('s', x.at(index))}; {result.at(index)} = s;"
    w.add(f"{loops}{{ {c_type(x.dtype)} s = {start}; F(r, {n}) {{ {step} }} }}")
    return [result]


@rule("argmax", "argmin")
def _arg(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    (x,), (out,), (axis,) = values, equation.outputs, equation.params["axes"]
    result = w.new(out.shape, out.dtype)
    if 0 in out.shape:
        return [result]
    loops, index = counters("i", out.shape)
    sign = ">" if equation.name == "argmax" else "<"
    kind_of = c_type(x.dtype)
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
        a, b = at(view, upper), at(view, lower)
        swaps += f"{{ {c_type(view.dtype)} v = {a}; {a} = {b}; {b} = v; }} "
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
    return [x.part(places, sizes)]


@rule("dynamic_update_slice")
def _dynamic_update_slice(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    x, change, *starts = values
    places = [_start(w, start, n - size) for start, n, size in zip(starts, x.shape, change.shape, strict=True)]
    result = w.copied(x)
    w.store(change, result.part(places, change.shape))
    return [result]


# Names of the axes in gathers and scatters: with windows, without, batches of the array and the indices, indexed.
GATHERED = (
    "offset_dims", "collapsed_slice_dims", "operand_batching_dims", "start_indices_batching_dims", "start_index_map",
)  # fmt: skip
SCATTERED = (
    "update_window_dims", "inserted_window_dims", "operand_batching_dims", "scatter_indices_batching_dims",
    "scatter_dims_to_operand_dims",
)  # fmt: skip


class _Windows:
    """Windows of an array that begin at indices; an index of the result of a gather, or of updates, names an entry."""

    def __init__(self, w: Writer, equation: Equation, names: Sequence[str], shape: tuple[int, ...], indices: Value):
        numbers, x_shape = equation.params["dimension_numbers"], equation.inputs[0].shape
        offsets, absent, x_batch, index_batch, indexed = (tuple(map(int, getattr(numbers, name))) for name in names)
        along = [axis for axis in range(len(x_shape)) if axis not in (*absent, *x_batch)]
        self.rank, self.offsets = len(x_shape), dict(zip(along, offsets, strict=True))
        self.paired = dict(zip(x_batch, index_batch, strict=True))
        self.batch_axes = [axis for axis in range(len(shape)) if axis not in offsets]
        sizes = {axis: shape[offset] for axis, offset in self.offsets.items()}
        self.most = {axis: x_shape[axis] - sizes.get(axis, 1) for axis in indexed}
        self.drops = getattr(equation.params["mode"], "name", str(equation.params["mode"])) == "FILL_OR_DROP"
        self.w, self.indices, self.inside = w, w.cheap(indices), None
        self.known = w.constants.get(equation.inputs[1])
        if self.known is not None:
            self.known, limits = self.known.astype(np.int64), np.array(list(self.most.values()), int)
            inside = np.all((self.known >= 0) & (self.known <= limits), axis=-1)
            self.known = np.clip(self.known, 0, np.maximum(limits, 0))
            if self.drops and not inside.all():
                self.inside = w.tables.value(inside)

    def _start(self, number: int, bound: int, batch: list[Place]) -> Place:
        """Where a window begins along an indexed axis."""
        if self.known is None:
            return variable(f"{self.w.helper('fx_clip')}({self.indices.at([*batch, Place(number)])}, {bound})")
        return self.w.tables.integer(self.known[..., number], batch)

    def places(self, index: list[Place]) -> list[Place]:
        """Index of the array."""
        batch = [index[axis] for axis in self.batch_axes]
        places = [index[self.offsets[axis]] if axis in self.offsets else Place() for axis in range(self.rank)]
        for axis, index_axis in self.paired.items():
            places[axis] = places[axis] + batch[index_axis]
        for number, (axis, bound) in enumerate(self.most.items()):
            places[axis] = places[axis] + self._start(number, bound, batch)
        return places

    def guard(self, index: list[Place]) -> str | None:
        """Whether the window lies inside; None if all do, or are moved inside."""
        batch = [index[axis] for axis in self.batch_axes]
        if self.known is not None or not self.drops:
            return None if self.inside is None else self.inside.at(batch)
        texts = [(self.indices.at([*batch, Place(k)]), bound) for k, bound in enumerate(self.most.values())]
        return " && ".join(f"{text} >= 0 && {text} <= {bound}" for text, bound in texts)


@rule("gather")
def _gather(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    (x, indices), (out,) = values, equation.outputs
    if 0 in out.shape:
        return [Lazy(lambda index: "0", 0, out.shape, out.dtype)]
    where, source = _Windows(w, equation, GATHERED, out.shape, indices), w.cheap(x)
    filling = _filling(equation.params.get("fill_value"), out.dtype)

    def at(index: list[Place]) -> str:
        text, guard = source.at(where.places(index)), where.guard(index)
        return text if guard is None else f"({guard} ? {text} : {filling})"

    if where.known is not None and where.inside is None and isinstance(source, ArrayView):
        even = _even(source, where.places, out.shape)
        if even is not None:
            return [even]
    return [Lazy(at, 0 if where.known is not None else 1, out.shape, out.dtype)]


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
    if value is None:
        value = np.nan if dtype.kind == "f" else bounds(dtype)[dtype.kind in "ub"]
    return literal(value, dtype)


@rule("scatter", "scatter-add", "scatter_add", "scatter-mul", "scatter_mul", "scatter-min", "scatter_min",
      "scatter-max", "scatter_max", "scatter-sub", "scatter_sub")  # fmt: skip
def _scatter(w: Writer, equation: Equation, values: list[Value]) -> list[Value]:
    x, indices, change = values
    result = w.copied(x)
    if 0 in change.shape:
        return [result]
    where = _Windows(w, equation, SCATTERED, change.shape, indices)
    loops, index = counters("i", change.shape)
    target, guard = result.at(where.places(index)), where.guard(index)
    update, kind = change.at(index), equation.name.removeprefix("scatter").strip("-_")
    if kind in ("min", "max"):
        call = w.helper(f"fx_{'' if x.dtype.kind == 'f' else 'i'}{kind}")
        update = f"{call}({target}, {update})"
    elif x.dtype.kind == "b" and kind:
        raise NotImplementedError("truth values that are added")
    sign = {"add": "+=", "sub": "-=", "mul": "*="}.get(kind, "=")
    w.add(f"{loops}{f'if ({guard}) ' if guard else ''}{target} {sign} {update};")
    return [result]
