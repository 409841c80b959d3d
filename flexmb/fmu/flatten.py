"""A traced function as plain lists of equations: calls opened, constants worked out, what stays out of loops.

C has no use for the calls that a trace is made of, and a mechanism's numbers do not change once it is exported. So
every inner program is put in the place of its call, what follows from constants alone is worked out by JAX once, what
does not change in a loop goes in front of it, and what is done twice is done once.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend.core import ClosedJaxpr, Jaxpr, Literal

from ..compilation.compile import QUICK
from ..compilation.threads import one_thread
from ..errors import ModelError

# Calls whose program is that of the function itself; what is said of their derivatives does not matter here.
CALLS = {
    "jit": "jaxpr",
    "closed_call": "call_jaxpr",
    "core_call": "call_jaxpr",
    "remat2": "jaxpr",
    "checkpoint": "jaxpr",
    "custom_jvp_call": "call_jaxpr",
    "custom_vjp_call": "call_jaxpr",
    "custom_lin": "jaxpr",
}
# What hands its input on.
SAME = {"stop_gradient", "copy", "copy_p", "optimization_barrier", "sharding_constraint", "layout_constraint"}
LOOPS = {"scan", "while"}


class Atom:
    """A value of the program.

    Attributes:
        shape: Of the array.
        dtype: Of its numbers.
        depth: 0 of what follows from constants, 1 of the outermost list, one more in each loop or branch.
    """

    __slots__ = ("depth", "dtype", "shape")

    def __init__(self, shape: tuple[int, ...], dtype: Any, depth: int):
        self.shape, self.dtype, self.depth = tuple(map(int, shape)), np.dtype(dtype), depth


def _atom(variable: Any, depth: int) -> Atom:
    return Atom(variable.aval.shape, variable.aval.dtype, depth)


class Body(NamedTuple):
    """Body of a loop or branch.

    Attributes:
        inputs: Carried values and those of the step; whatever else is read stands outside.
        equations: In their order.
        outputs: Values.
    """

    inputs: list[Atom]
    equations: list["Equation"]
    outputs: list[Atom]


class Equation(NamedTuple):
    """One operation.

    Attributes:
        name: Of the primitive.
        params: Its options, as JAX names them.
        inputs: What it reads.
        outputs: What it gives.
        blocks: Bodies of a loop or branch.
        origin: The equation of the trace, then those that called it, the outermost first.
    """

    name: str
    params: dict[str, Any]
    inputs: list[Atom]
    outputs: list[Atom]
    blocks: tuple[Body, ...]
    origin: tuple[Any, ...]


class FlatProgram(NamedTuple):
    """A function whose constants are numbers.

    Attributes:
        block: Its inputs, equations and outputs.
        constants: Numbers of the values of depth 0 that it reads.
    """

    block: Body
    constants: dict[Atom, np.ndarray]


def flattened(function: Callable[..., Any], *like: Any) -> FlatProgram:
    """Trace a function of arrays and open all that it calls; raise ModelError if that calls back to Python."""
    program = jax.make_jaxpr(function)(*(jax.typeof(one) for one in like))
    refuse_callbacks(program.jaxpr)
    opener = _Opener()
    inputs = [_atom(v, 1) for v in program.jaxpr.invars]
    outputs = opener.opened(program.jaxpr, program.consts, inputs)
    equations = _needed(opener.lists[1], set(outputs))
    return FlatProgram(Body(inputs, equations, outputs), opener.numbers(read_by(equations, outputs)))


def read_by(equations: list[Equation], also: list[Atom]) -> list[Atom]:
    """Values that equations or their bodies read, and some more, each once, in order."""
    found: dict[Atom, None] = {}
    for equation in equations:
        found.update(dict.fromkeys(equation.inputs))
        for block in equation.blocks:
            found.update(dict.fromkeys(read_by(block.equations, block.outputs)))
    return list(dict.fromkeys([*found, *also]))


class _Opener:
    """Puts equations where they belong: into the list of the deepest value that they read."""

    def __init__(self):
        self.early: list[Equation] = []
        self.lists: list[list[Equation]] = [self.early, []]
        # Below this depth a value of a branch is not worked out: the branch may not be taken.
        self.floors = [1]
        self.known: list[dict[Any, list[Atom]]] = [{}, {}]
        self.values: dict[Atom, np.ndarray] = {}
        self.words: dict[Any, Atom] = {}
        self.callers: list[Any] = []

    def constant(self, number: Any) -> Atom:
        """A number as a value; equal ones are one."""
        number = np.asarray(number)
        key = (number.dtype.str, number.shape, number.tobytes())
        if key not in self.words:
            self.words[key] = Atom(number.shape, number.dtype, 0)
            self.values[self.words[key]] = number
        return self.words[key]

    def opened(self, jaxpr: Jaxpr, constants: Any, arguments: list[Atom]) -> list[Atom]:
        """Results of a program for given arguments, its equations put into the lists."""
        place: dict[Any, Atom] = {}
        for variables, atoms in ((jaxpr.constvars, map(self.constant, constants)), (jaxpr.invars, arguments)):
            place.update(zip(variables, atoms, strict=True))

        def read(one: Any) -> Atom:
            # A literal may be a number of Python's, whose type its place says.
            if not isinstance(one, Literal):
                return place[one]
            kind: Any = one.aval
            return self.constant(np.asarray(one.val, kind.dtype))

        for equation in jaxpr.eqns:
            self.callers.append(equation)
            results = self.equation(equation, [read(one) for one in equation.invars])
            self.callers.pop()
            place.update(zip(equation.outvars, results, strict=True))
        return [read(one) for one in jaxpr.outvars]

    def equation(self, equation: Any, inputs: list[Atom]) -> list[Atom]:
        """Results of one equation of the trace."""
        name, params = equation.primitive.name, equation.params
        if name in SAME:
            return inputs
        if name in CALLS:
            inner = params[CALLS[name]]
            return self.opened(getattr(inner, "jaxpr", inner), getattr(inner, "consts", ()), inputs)
        if name == "call_hi_primitive":
            # JAX from 0.12 on writes out some of its functions, such as jnp.searchsorted, at the very last.
            like = [jax.ShapeDtypeStruct(one.shape, one.dtype) for one in inputs]
            inner = jax.make_jaxpr(lambda *given: jax.tree.leaves(params["_prim"].expand(*given)))(*like)
            return self.opened(inner.jaxpr, inner.consts, inputs)
        if name == "platform_index":
            names = [("cpu" in one) if one else True for one in params["platforms"]]
            return [self.constant(np.int32(names.index(True)))]
        if name == "custom_linear_solve":
            # Its solution is written out; the product that it inverts serves derivatives only.
            lengths, inner = params["const_lengths"], params["jaxprs"].solve
            first = lengths.matvec + lengths.vecmat
            own, right = inputs[first : first + lengths.solve], inputs[sum(lengths) :]
            return self.opened(inner.jaxpr, inner.consts, own + right)
        if name == "cond" and inputs[0] in self.values:
            branches = params["branches"]
            taken = branches[int(np.clip(self.values[inputs[0]], 0, len(branches) - 1))]
            return self.opened(taken.jaxpr, taken.consts, inputs[1:])
        if name in (*LOOPS, "cond") and any(one.depth for one in inputs):
            return self.structured(name, params, inputs, equation)
        return self.placed(name, params, inputs, equation)

    def placed(self, name: str, params: dict, inputs: list[Atom], origin: Any, blocks: tuple = ()) -> list[Atom]:
        """Put an equation into the list that it belongs to, unless the same was done before."""
        depth = max((one.depth for one in inputs), default=0)
        if depth:
            depth = max(depth, self.floors[-1])
        if blocks:
            # A loop that may not end is begun where it was begun.
            depth = len(self.lists) - 1
        meaning = _meaning(params)
        key = None if meaning is None else (name, meaning, *map(_signature, blocks), *inputs)
        for known in self.known[: depth + 1] if key else ():
            if key in known:
                return known[key]
        outputs = [_atom(v, depth) for v in origin.outvars]
        whence = (origin, *self.callers[:-1])
        self.lists[depth].append(Equation(name, params, inputs, outputs, blocks, whence))
        if key:
            self.known[depth][key] = outputs
        return outputs

    def structured(self, name: str, params: dict, inputs: list[Atom], origin: Any) -> list[Atom]:
        """A loop or branch with its bodies opened."""
        if name == "cond":
            blocks = tuple(self.block(one, inputs[1:], branch=True) for one in params["branches"])
            return self.placed(name, {}, inputs[:1], origin, blocks)
        if name == "scan":
            if "ft_in" in params:
                # JAX from 0.12 on.
                fixed, carried, _ = (len(group) for group in params["ft_in"].unpack())
            else:
                fixed, carried = params["num_consts"], params["num_carry"]
            body = self.block(params["jaxpr"], inputs[:fixed])
            kept = {"length": params["length"], "reverse": params["reverse"], "num_carry": carried}
            return self.placed(name, kept, inputs[fixed:], origin, (body,))
        first, second = params["cond_nconsts"], params["cond_nconsts"] + params["body_nconsts"]
        carry = inputs[second:]
        unfinished = self.block(params["cond_jaxpr"], inputs[:first])
        body = self.block(params["body_jaxpr"], inputs[first:second])
        return self.placed(name, {}, carry, origin, (unfinished, body))

    def block(self, program: ClosedJaxpr, fixed: list[Atom], branch: bool = False) -> Body:
        """A body; what it reads from outside is read where it stands."""
        depth = len(self.lists)
        self.lists.append([])
        self.known.append({})
        self.floors.append(depth if branch else self.floors[-1])
        own = [_atom(v, depth) for v in program.jaxpr.invars[len(fixed) :]]
        outputs = self.opened(program.jaxpr, program.consts, [*fixed, *own])
        self.floors.pop()
        self.known.pop()
        return Body(own, self.lists.pop(), outputs)

    def numbers(self, wanted: list[Atom]) -> dict[Atom, np.ndarray]:
        """Numbers of values that follow from constants."""
        wanted = [one for one in wanted if not one.depth]
        later = [one for one in wanted if one not in self.values]
        equations = _needed(self.early, set(later))
        given = [one for one in read_by(equations, []) if one in self.values]

        def work_out(numbers: list) -> list:
            at = dict(zip(given, numbers, strict=True))
            for equation in equations:
                primitive = equation.origin[0].primitive
                options = primitive.get_bind_params(equation.params)
                found = primitive.bind(*[at[one] for one in equation.inputs], **options)
                found = found if primitive.multiple_results else [found]
                at.update(zip(equation.outputs, found, strict=True))
            return [at[one] for one in later]

        # A trace is never kept on disk: what it captures is this program's own.
        run = jax.jit(work_out, compiler_options=QUICK)
        with one_thread():
            found = run([jnp.asarray(self.values[one]) for one in given]) if later else []
        computed = {one: np.asarray(number) for one, number in zip(later, found, strict=True)}
        return {one: computed[one] if one in computed else self.values[one] for one in wanted}


def _needed(equations: list[Equation], wanted: set[Atom]) -> list[Equation]:
    """Equations that lead to what is wanted, also within loops and branches; ``wanted`` grows by what they read."""
    found = []
    for equation in reversed(equations):
        if not wanted.intersection(equation.outputs):
            continue
        blocks = []
        for block in equation.blocks:
            wanted.update(block.outputs)
            blocks.append(block._replace(equations=_needed(block.equations, wanted)))
        wanted.update(equation.inputs)
        found.append(equation._replace(blocks=tuple(blocks)))
    return found[::-1]


def _signature(block: Body) -> tuple:
    """Equal for bodies that do the same with what stands outside."""
    places: dict[Atom, Any] = {atom: i for i, atom in enumerate(block.inputs)}
    found: list[Any] = [len(block.inputs)]
    for equation in block.equations:
        inner = tuple(map(_signature, equation.blocks))
        inputs = tuple(places.get(atom, atom) for atom in equation.inputs)
        meaning = _meaning(equation.params)
        found.append((equation.name, id(equation) if meaning is None else meaning, inner, inputs))
        for atom in equation.outputs:
            places[atom] = len(places)
    return (*found, tuple(places.get(atom, atom) for atom in block.outputs))


def _meaning(params: dict[str, Any]) -> Any:
    """Equal for equal options; None where they cannot be compared."""
    try:
        key = tuple((name, repr(one), one) for name, one in sorted(params.items()))
        hash(key)
    except TypeError:
        return None
    return key


def _programs(jaxpr: Jaxpr) -> Iterator[Any]:
    """All equations, those of inner programs too."""
    for equation in jaxpr.eqns:
        yield equation
        for parameter in jax.tree.leaves(list(equation.params.values()), is_leaf=_is_program):
            if _is_program(parameter):
                yield from _programs(getattr(parameter, "jaxpr", parameter))


def _is_program(thing: Any) -> bool:
    return isinstance(thing, ClosedJaxpr | Jaxpr)


def refuse_callbacks(jaxpr: Jaxpr) -> None:
    """Raise where a program calls back to Python, with the name of what it calls.

    Raises:
        ModelError: The same.
    """
    found: dict[str, None] = {}
    for equation in _programs(jaxpr):
        if "callback" in equation.primitive.name:
            called = equation.params.get("callback")
            called = getattr(called, "callback_func", called)
            name = getattr(called, "__name__", type(called).__name__)
            found[f"{equation.primitive.name} of `{name}`{origin_of([equation])}"] = None
    if found:
        raise ModelError(
            f"C cannot call back to Python, but the model does: {'; '.join(found)}. Write these functions with"
            " jax.numpy, or take prints out of them."
        )


def origin_of(equations: Sequence[Any]) -> str:
    """Where the first equation was written, which the others called, as " in law, springs.py:12"; "" if not known."""
    traces = [getattr(one.source_info, "traceback", None) for one in [*equations[:1], *reversed(equations[1:])]]
    for frame in (frame for trace in traces if trace is not None for frame in trace.frames):
        parts = frame.file_name.replace("\\", "/").split("/")
        name = frame.function_name.rpartition("<locals>.")[2]
        if not {"jax", "jaxlib", "equinox"}.intersection(parts[:-1]) and not frame.file_name.startswith("<frozen"):
            return f" in {name}, {parts[-1]}:{frame.line_num}"
    return ""
