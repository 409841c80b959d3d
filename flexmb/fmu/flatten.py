"""A traced function as flat lists of equations, without calls and with computed constants.

Every inner program replaces its call. JAX computes once what follows from constants, since the numbers of a mechanism
are fixed after the export. Equations that do not change in a loop stand before it, and equal ones stand once.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend.core import ClosedJaxpr, Jaxpr, Literal, jaxprs_in_params

from ..compilation.compile import QUICK
from ..compilation.threads import one_thread
from ..errors import ModelError

# Calls of plain programs; their derivative rules have no effect here.
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
# Operations that return their input.
SAME = {"stop_gradient", "copy", "copy_p", "optimization_barrier", "sharding_constraint", "layout_constraint"}
LOOPS = {"scan", "while"}


class Atom:
    """A value of the program; depth 0 follows from constants, 1 is the outermost list, then each loop adds one."""

    __slots__ = ("depth", "dtype", "shape")

    def __init__(self, shape: tuple[int, ...], dtype: Any, depth: int):
        self.shape, self.dtype, self.depth = tuple(map(int, shape)), np.dtype(dtype), depth


def _atom(variable: Any, depth: int) -> Atom:
    return Atom(variable.aval.shape, variable.aval.dtype, depth)


class Body(NamedTuple):
    """Body of a loop or branch: carried values and values of the step, equations, and outputs."""

    inputs: list[Atom]
    equations: list["Equation"]
    outputs: list[Atom]


class Equation(NamedTuple):
    """One operation.

    Attributes:
        name: Name of the primitive.
        params: Options, as JAX names them.
        blocks: Bodies of a loop or branch.
        origin: The equation of the trace, then the calls around it, the innermost first.
    """

    name: str
    params: dict[str, Any]
    inputs: list[Atom]
    outputs: list[Atom]
    blocks: tuple[Body, ...]
    origin: tuple[Any, ...]


class FlatProgram(NamedTuple):
    """A function with constants, the numbers of values of depth 0."""

    block: Body
    constants: dict[Atom, np.ndarray]


def flattened(function: Callable[..., Any], *like: Any) -> FlatProgram:
    """Trace a function of arrays and open all calls; ModelError if it calls back to Python."""
    program = jax.make_jaxpr(function)(*(jax.typeof(array) for array in like))
    refuse_callbacks(program.jaxpr)
    opener = _Opener()
    inputs = [_atom(v, 1) for v in program.jaxpr.invars]
    outputs = opener.opened(program.jaxpr, program.consts, inputs)
    equations = _needed(opener.lists[1], set(outputs))
    return FlatProgram(Body(inputs, equations, outputs), opener.numbers(read_by(equations, outputs)))


def read_by(equations: list[Equation], also: list[Atom]) -> list[Atom]:
    """Values that equations or their bodies read, and more values, each once, in order."""
    atoms: dict[Atom, None] = {}
    for equation in equations:
        atoms.update(dict.fromkeys(equation.inputs))
        for block in equation.blocks:
            atoms.update(dict.fromkeys(read_by(block.equations, block.outputs)))
    return list(dict.fromkeys([*atoms, *also]))


class _Opener:
    """Appends equations to the list of the deepest value that they read."""

    def __init__(self):
        self.early: list[Equation] = []
        self.lists: list[list[Equation]] = [self.early, []]
        # Values of a branch are not computed outside: it may not be taken.
        self.floors = [1]
        self.known: list[dict[Any, list[Atom]]] = [{}, {}]
        self.values: dict[Atom, np.ndarray] = {}
        self.words: dict[Any, Atom] = {}
        self.callers: list[Any] = []

    def constant(self, number: Any) -> Atom:
        """A number as a value, equal ones once."""
        number = np.asarray(number)
        key = (number.dtype.str, number.shape, number.tobytes())
        if key not in self.words:
            self.words[key] = Atom(number.shape, number.dtype, 0)
            self.values[self.words[key]] = number
        return self.words[key]

    def opened(self, jaxpr: Jaxpr, constants: Any, arguments: list[Atom]) -> list[Atom]:
        """Results of a program for arguments; its equations go into the lists."""
        place: dict[Any, Atom] = {}
        for variables, atoms in ((jaxpr.constvars, map(self.constant, constants)), (jaxpr.invars, arguments)):
            place.update(zip(variables, atoms, strict=True))

        def read(atom: Any) -> Atom:
            # A Python number has the type of its place.
            if not isinstance(atom, Literal):
                return place[atom]
            kind: Any = atom.aval
            return self.constant(np.asarray(atom.val, kind.dtype))

        for equation in jaxpr.eqns:
            self.callers.append(equation)
            results = self.equation(equation, [read(atom) for atom in equation.invars])
            self.callers.pop()
            place.update(zip(equation.outvars, results, strict=True))
        return [read(atom) for atom in jaxpr.outvars]

    def equation(self, equation: Any, inputs: list[Atom]) -> list[Atom]:
        """Results of one equation of the trace."""
        name, params = equation.primitive.name, equation.params
        if name in SAME:
            return inputs
        if name in CALLS:
            inner = params[CALLS[name]]
            return self.opened(getattr(inner, "jaxpr", inner), getattr(inner, "consts", ()), inputs)
        if name == "call_hi_primitive":
            # JAX from 0.12 on opens some functions, such as jnp.searchsorted, late.
            like = [jax.ShapeDtypeStruct(entry.shape, entry.dtype) for entry in inputs]
            inner = jax.make_jaxpr(lambda *values: jax.tree.leaves(params["_prim"].expand(*values)))(*like)
            return self.opened(inner.jaxpr, inner.consts, inputs)
        if name == "platform_index":
            names = [("cpu" in entry) if entry else True for entry in params["platforms"]]
            return [self.constant(np.int32(names.index(True)))]
        if name == "custom_linear_solve":
            # Only derivatives need the product that it inverts.
            lengths, inner = params["const_lengths"], params["jaxprs"].solve
            first = lengths.matvec + lengths.vecmat
            solve_inputs, right = inputs[first : first + lengths.solve], inputs[sum(lengths) :]
            return self.opened(inner.jaxpr, inner.consts, solve_inputs + right)
        if name == "cond" and inputs[0] in self.values:
            branches = params["branches"]
            branch = branches[int(np.clip(self.values[inputs[0]], 0, len(branches) - 1))]
            return self.opened(branch.jaxpr, branch.consts, inputs[1:])
        if name in (*LOOPS, "cond") and any(entry.depth for entry in inputs):
            return self.structured(name, params, inputs, equation)
        return self.placed(name, params, inputs, equation)

    def placed(self, name: str, params: dict, inputs: list[Atom], origin: Any, blocks: tuple = ()) -> list[Atom]:
        """Append an equation to its list, unless an equal one exists."""
        depth = max((atom.depth for atom in inputs), default=0)
        if depth:
            depth = max(depth, self.floors[-1])
        if blocks:
            # A loop that may not end stays where it is.
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
            blocks = tuple(self.block(branch, inputs[1:], branch=True) for branch in params["branches"])
            return self.placed(name, {}, inputs[:1], origin, blocks)
        if name == "scan":
            if "ft_in" in params:
                # JAX from 0.12 on.
                fixed, carried, _ = (len(group) for group in params["ft_in"].unpack())
            else:
                fixed, carried = params["num_consts"], params["num_carry"]
            body = self.block(params["jaxpr"], inputs[:fixed])
            options = {"length": params["length"], "reverse": params["reverse"], "num_carry": carried}
            return self.placed(name, options, inputs[fixed:], origin, (body,))
        first, second = params["cond_nconsts"], params["cond_nconsts"] + params["body_nconsts"]
        carry = inputs[second:]
        unfinished = self.block(params["cond_jaxpr"], inputs[:first])
        body = self.block(params["body_jaxpr"], inputs[first:second])
        return self.placed(name, {}, carry, origin, (unfinished, body))

    def block(self, program: ClosedJaxpr, fixed: list[Atom], branch: bool = False) -> Body:
        """A body, which reads outer values where they are."""
        depth = len(self.lists)
        self.lists.append([])
        self.known.append({})
        self.floors.append(depth if branch else self.floors[-1])
        inputs = [_atom(v, depth) for v in program.jaxpr.invars[len(fixed) :]]
        outputs = self.opened(program.jaxpr, program.consts, [*fixed, *inputs])
        self.floors.pop()
        self.known.pop()
        return Body(inputs, self.lists.pop(), outputs)

    def numbers(self, wanted: list[Atom]) -> dict[Atom, np.ndarray]:
        """Numbers of values that follow from constants."""
        wanted = [atom for atom in wanted if not atom.depth]
        later = [atom for atom in wanted if atom not in self.values]
        equations = _needed(self.early, set(later))
        known_atoms = [atom for atom in read_by(equations, []) if atom in self.values]

        def work_out(numbers: list) -> list:
            at = dict(zip(known_atoms, numbers, strict=True))
            for equation in equations:
                primitive = equation.origin[0].primitive
                options = primitive.get_bind_params(equation.params)
                results = primitive.bind(*[at[atom] for atom in equation.inputs], **options)
                results = results if primitive.multiple_results else [results]
                at.update(zip(equation.outputs, results, strict=True))
            return [at[atom] for atom in later]

        # The captured numbers belong to this program: the trace is never kept on disk.
        run = jax.jit(work_out, compiler_options=QUICK)
        with one_thread():
            later_numbers = run([jnp.asarray(self.values[atom]) for atom in known_atoms]) if later else []
        computed = {atom: np.asarray(number) for atom, number in zip(later, later_numbers, strict=True)}
        return {atom: computed[atom] if atom in computed else self.values[atom] for atom in wanted}


def _needed(equations: list[Equation], needed_atoms: set[Atom]) -> list[Equation]:
    """Equations for wanted values, also in loops and branches; ``needed_atoms`` grows by their inputs."""
    needed_equations = []
    for equation in reversed(equations):
        if not needed_atoms.intersection(equation.outputs):
            continue
        blocks = []
        for block in equation.blocks:
            needed_atoms.update(block.outputs)
            blocks.append(block._replace(equations=_needed(block.equations, needed_atoms)))
        needed_atoms.update(equation.inputs)
        needed_equations.append(equation._replace(blocks=tuple(blocks)))
    return needed_equations[::-1]


def _signature(block: Body) -> tuple:
    """Equal for bodies that do the same with outer values."""
    places: dict[Atom, Any] = {atom: i for i, atom in enumerate(block.inputs)}
    parts: list[Any] = [len(block.inputs)]
    for equation in block.equations:
        inner = tuple(map(_signature, equation.blocks))
        inputs = tuple(places.get(atom, atom) for atom in equation.inputs)
        meaning = _meaning(equation.params)
        parts.append((equation.name, id(equation) if meaning is None else meaning, inner, inputs))
        for atom in equation.outputs:
            places[atom] = len(places)
    return (*parts, tuple(places.get(atom, atom) for atom in block.outputs))


def _meaning(params: dict[str, Any]) -> Any:
    """Equal for equal options; None if they cannot be compared."""
    try:
        key = tuple((name, repr(value), value) for name, value in sorted(params.items()))
        hash(key)
    except TypeError:
        return None
    return key


def _equations_within(jaxpr: Jaxpr) -> Iterator[Any]:
    """All equations, also of inner programs."""
    for equation in jaxpr.eqns:
        yield equation
        for inner in jaxprs_in_params(equation.params):
            yield from _equations_within(inner)


def refuse_callbacks(jaxpr: Jaxpr) -> None:
    """Raise ModelError with the names of Python functions that a program calls."""
    callbacks: dict[str, None] = {}
    for equation in _equations_within(jaxpr):
        if "callback" in equation.primitive.name:
            called = equation.params.get("callback")
            called = getattr(called, "callback_func", called)
            name = getattr(called, "__name__", type(called).__name__)
            callbacks[f"{equation.primitive.name} of `{name}`{origin_of([equation])}"] = None
    if callbacks:
        raise ModelError(
            f"C cannot call back to Python, but the model does: {'; '.join(callbacks)}. Write these functions with"
            " jax.numpy, or remove prints."
        )


def origin_of(equations: Sequence[Any]) -> str:
    """Where the first equation was written, which the others called, as " in law, springs.py:12"; "" if not known."""
    traces = [
        getattr(equation.source_info, "traceback", None) for equation in [*equations[:1], *reversed(equations[1:])]
    ]
    for frame in (frame for trace in traces if trace is not None for frame in trace.frames):
        parts = frame.file_name.replace("\\", "/").split("/")
        name = frame.function_name.rpartition("<locals>.")[2]
        if not {"jax", "jaxlib", "equinox"}.intersection(parts[:-1]) and not frame.file_name.startswith("<frozen"):
            return f" in {name}, {parts[-1]}:{frame.line_num}"
    return ""
