"""Traced functions taken apart: what follows from constants and what varies; a user's code and the numbers in it."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING, Any, TypeGuard

import jax
import jax.core
import jax.numpy as jnp
import numpy as np

from ..arguments import as_reals, check_real
from .record import Record, static

if TYPE_CHECKING:
    from jax.extend.core import Jaxpr, Literal

# Derivatives of one's own are looked at as deep as equations of motion take derivatives.
RULES = 2


class Code:
    """A program, equal to another that does the same.

    Attributes:
        jaxpr: The program, with the numbers of a :class:`Captured` as its constants.
        results: Structure of what it returns.
    """

    def __init__(self, jaxpr: Jaxpr, results: Any, rules: int = RULES):
        self.jaxpr, self.results = jaxpr, results
        self._meaning = (_of_program(jaxpr, (), rules), results)
        self._hash = hash(self._meaning)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Code) and self._meaning == other._meaning

    def __hash__(self) -> int:
        return self._hash


class Captured(Record):
    """A user's function as a program and the numbers that it captures or that stand in its text.

    Functions that differ in numbers alone are the same code, compiled once; numbers may be traced, for a derivative.

    Attributes:
        code: The program.
        numbers: What it captured when it was taken.
    """

    code: Code = static()
    numbers: tuple[Any, ...]

    def __call__(self, *arguments: Any) -> Any:
        """Value of the function for arguments of the shapes that it was taken for."""
        leaves = jax.tree.leaves(arguments)
        return jax.tree.unflatten(self.code.results, jax.core.eval_jaxpr(self.code.jaxpr, self.numbers, *leaves))


def captured(function: Callable[..., Any], *like: Any, rules: int = RULES, formal: Collection[float] = ()) -> Captured:
    """Take a function as it is now: what its text refers to may change afterwards.

    Returns the function as a record of numbers.

    Args:
        formal: Numbers that stay in its text, whatever their sign, where the compiler makes use of them.
    """
    from jax.extend.core import Var

    leaves, structure = jax.tree.flatten(like)
    results: Any = None

    # A function of its own: JAX remembers the traces of those it knows.
    def flat(*leaves: Any):
        nonlocal results
        found, results = jax.tree.flatten(function(*jax.tree.unflatten(structure, leaves)))
        return [jnp.asarray(one) for one in found]

    program = jax.make_jaxpr(flat)(*(jax.typeof(leaf) for leaf in leaves))
    jaxpr, numbers, places, equations = program.jaxpr, list(program.consts), [], []

    def placed(atom: Any):
        """A constant in place of a number in the text; whole numbers may be shapes or places, and stay."""
        kind: Any = atom.aval
        if not is_literal(atom) or not np.issubdtype(kind.dtype, np.inexact) or abs(atom.val) in formal:
            return atom
        numbers.append(np.asarray(atom.val, kind.dtype))
        places.append(Var(jax.typeof(numbers[-1])))
        return places[-1]

    for equation in jaxpr.eqns:
        equations.append(equation.replace(invars=[placed(atom) for atom in equation.invars]))
    results_of = [placed(atom) for atom in jaxpr.outvars]
    jaxpr = jaxpr.replace(constvars=[*jaxpr.constvars, *places], eqns=equations, outvars=results_of)
    return Captured(Code(jaxpr, results, rules), tuple(numbers))


# Operations of what changes as waves and low powers of time do, without pulses.
WAVES = frozenset(
    "add sub mul neg sin cos square broadcast_in_dim reshape squeeze concatenate convert_element_type".split()
)

# Operations without kinks and jumps, but for what is singular: anything else may have some.
SMOOTH = WAVES | frozenset(
    """acos acosh asin asinh atan atan2 atanh cbrt copy cos cosh cumsum div dot_general dynamic_slice
    dynamic_update_slice erf erfc exp exp2 expand_dims expm1 gather integer_pow iota log log1p logistic pad pow
    reduce_sum rev rsqrt scatter scatter-add sinh slice split sqrt stop_gradient tan tanh transpose""".split()
)


def is_wave(found: Captured) -> bool:
    """Whether a function is made of sums and products of sines and constants alone."""
    return all(equation.primitive.name in WAVES for equation in found.code.jaxpr.eqns)


def has_effects(found: Captured) -> bool:
    """Whether a function does more than to give numbers, such as to print."""
    return bool(found.code.jaxpr.effects)


def may_bend(function: Callable[..., Any], *like: Any) -> bool:
    """Whether a function may have kinks or jumps: whether it is made of other than smooth operations."""
    return _may_bend(jax.make_jaxpr(function)(*like).jaxpr)


def _may_bend(jaxpr: Jaxpr) -> bool:
    for equation in jaxpr.eqns:
        inner = [part for part in equation.params.values() if _is_program(part)]
        if not inner and equation.primitive.name not in SMOOTH:
            return True
        if any(_may_bend(getattr(part, "jaxpr", part)) for part in inner):
            return True
    return False


def of_time(function: Callable[..., Any]) -> tuple[Any, tuple[int, ...]]:
    """A function of time as it is now, and the shape of what it gives.

    A record of this package, such as a table or a law, does what its numbers say, and is taken as it stands: a trace
    with it may be kept, which one with a captured function is not.
    """
    time = jax.ShapeDtypeStruct((), float)
    taken: Any = function
    if not isinstance(function, Record):
        taken = captured(lambda t: as_reals("its value", function(t)), time)
    # Some say it, which takes no trace.
    shape = getattr(taken, "shape_of_value", None)
    # By another name: that of a record is its text, with all that follows from it.
    if shape is None:
        value = jax.eval_shape(lambda t: taken(t), time)
        check_real("its value", value)
        shape = value.shape
    return taken, shape


def digest(found: Captured) -> str:
    """What a function does, as a word: changes with every number in it, and with its operations.

    Options of operations are left out: among them are settings of JAX, and functions that each trace makes anew.
    """
    text = hashlib.sha256()

    def add(number: Any):
        text.update(repr(jax.typeof(number)).encode())
        text.update(np.asarray(number).tobytes())

    def walk(jaxpr: Jaxpr, constants: Sequence[Any]):
        for number in constants:
            add(number)
        for equation in jaxpr.eqns:
            text.update(equation.primitive.name.encode())
            for atom in equation.invars:
                if is_literal(atom):
                    add(atom.val)
            for parameter in jax.tree.leaves(list(equation.params.values()), is_leaf=_is_program):
                if _is_program(parameter):
                    walk(getattr(parameter, "jaxpr", parameter), getattr(parameter, "consts", ()))

    walk(found.code.jaxpr, found.numbers)
    return text.hexdigest()


def is_literal(atom: Any) -> TypeGuard[Literal]:
    """Whether what an operation takes is a number in the text of a program, not one of its variables."""
    return hasattr(atom, "val")


def _is_program(thing: Any) -> bool:
    return hasattr(thing, "eqns")


def split(
    function: Callable[..., Any], varying: tuple, constant: tuple
) -> tuple[Callable[..., tuple], Callable[..., Any]]:
    """Take a function apart, so that it can be called many times with equal constants.

    Equal operations are done once, and what no result needs is left out. Returns ``early(*constant)``, a tuple of
    arrays ``kept``, and ``late(*varying, *kept)``, what the function returns.

    Args:
        function: Function of arrays that vary, followed by arrays that do not; it must not have side effects.
    """
    early, (late,) = split_together([(function, varying)], constant)
    return early, late


def split_together(
    functions: Sequence[tuple[Callable[..., Any], tuple]], constant: tuple
) -> tuple[Callable[..., tuple], list[Callable[..., Any]]]:
    """As :func:`split`, of several functions of the same constants: what they make of these alike is done once.

    Returns ``early(*constant)``, a tuple of arrays ``kept``, and of each function ``late(*varying, *kept)``.
    """

    def every(constant: tuple, *varying: tuple):
        return (), *[function(*own, *constant) for (function, _), own in zip(functions, varying, strict=True)]

    early, *late = split_in_stages(every, [constant, *[varying for _, varying in functions]])
    return lambda *constant: early(*constant)[1], [_result_of(one) for one in late]


def _result_of(stage: Callable[..., Any]):
    return lambda *arguments: stage(*arguments)[0]


def split_in_stages(function: Callable[..., Sequence[Any]], groups: Sequence[tuple]) -> list[Callable[..., Any]]:
    """Take a function apart by what each of its operations follows from.

    Equal operations are done once, and what no result needs is left out. Raises ValueError: A result follows from a
    group after its own.

    Args:
        function: Of tuples of arrays, to a result for each of them, which follows from that one and those before it;
            it must not have side effects.

    Returns:
        For each group a stage ``(*own, *kept) -> (result, more)``, of its arguments and of all that stages before it
        have kept: its result, and what it keeps for those after it, a tuple of arrays.
    """
    leaves, structure = jax.tree.flatten(tuple(groups))

    def flat(*leaves: Any):
        return function(*jax.tree.unflatten(structure, leaves))

    program, shapes = jax.make_jaxpr(flat, return_shape=True)(*(jax.typeof(leaf) for leaf in leaves))
    jaxpr = program.jaxpr
    equations, results = _without_repeats(jaxpr, program.consts)
    inputs, outputs = _in_groups(jaxpr.invars, groups), _in_groups(results, shapes)
    level = {v: i for i, own in enumerate(inputs) for v in own}
    # What is of literals alone, of no argument, is done where it is asked for: in every stage.
    steps: list[list] = [[] for _ in groups]
    for equation in equations:
        last = max((level[v] for v in _variables(equation.invars) if v in level), default=None)
        if last is not None:
            level |= dict.fromkeys(equation.outvars, last)
        for own in steps if last is None else [steps[last]]:
            own.append(equation)
    if any(level.get(v, 0) > i for i, own in enumerate(outputs) for v in _variables(own)):
        raise ValueError("A result follows from arguments of a group that comes after its own.")
    kept: list[list] = [[] for _ in groups]
    read: dict = {}
    for i in reversed(range(len(groups))):
        kept[i] = [v for v in read if level.get(v) == i]
        steps[i], more = needed(steps[i], [*outputs[i], *kept[i]])
        read |= more
    stages = []
    for i, (own, shape) in enumerate(zip(inputs, shapes, strict=True)):
        before = itertools.chain.from_iterable(kept[:i])
        then = _program(jaxpr, [*own, *before], steps[i], [*outputs[i], *kept[i]])
        stages.append(_evaluation(then, program.consts, jax.tree.structure((shape, tuple(kept[i])))))
    return stages


def _in_groups(things: Sequence[Any], like: Sequence[Any]) -> list[list]:
    """Things in groups of as many as some trees have leaves."""
    left = iter(things)
    return [list(itertools.islice(left, len(jax.tree.leaves(one)))) for one in like]


def _evaluation(jaxpr: Jaxpr, constants: Any, results: Any) -> Callable[..., Any]:
    """Function of arguments in whatever trees."""

    def function(*arguments: Any):
        return jax.tree.unflatten(results, jax.core.eval_jaxpr(jaxpr, constants, *jax.tree.leaves(arguments)))

    return function


def _program(jaxpr: Jaxpr, inputs: list, equations: list, results: list):
    return jaxpr.replace(invars=inputs, eqns=equations, outvars=results)


def _variables(atoms: Any) -> list:
    return [v for v in atoms if not is_literal(v)]


def _without_repeats(jaxpr: Jaxpr, constants: Any) -> tuple[list, list]:
    """Equations without those done before, and results."""
    first: dict = {}
    values = [(v.aval, np.asarray(c).tobytes()) for v, c in zip(jaxpr.constvars, constants, strict=True)]
    same: dict = {v: first.setdefault(value, v) for v, value in zip(jaxpr.constvars, values, strict=True)}
    known: dict = {}
    found = []

    def replaced(atoms: Sequence[Any]) -> list:
        return [v if is_literal(v) else same.get(v, v) for v in atoms]

    for equation in jaxpr.eqns:
        inputs = replaced(equation.invars)
        names = tuple((v.aval, np.asarray(v.val).tobytes()) if is_literal(v) else v for v in inputs)
        key = (names, *_meaning(equation))
        if key in known and not equation.effects:
            same.update(zip(equation.outvars, known[key], strict=True))
        else:
            known[key] = equation.outvars
            found.append(equation.replace(invars=inputs))
    return found, replaced(jaxpr.outvars)


def _of_program(jaxpr: Jaxpr, constants: tuple, rules: int) -> tuple:
    """Equal for programs that do the same with equal arguments."""
    places = {v: i for i, v in enumerate([*jaxpr.constvars, *jaxpr.invars])}
    meaning: list[Any] = [tuple((type(c), np.asarray(c).dtype, np.asarray(c).tobytes()) for c in constants)]
    meaning.append(tuple(v.aval for v in places))

    def place(atom: Any):
        return (atom.aval, np.asarray(atom.val).tobytes()) if is_literal(atom) else places[atom]

    for equation in jaxpr.eqns:
        meaning.append((*_meaning(equation, rules), *map(place, equation.invars)))
        for v in equation.outvars:
            places[v] = len(places)
    return (*meaning, *map(place, jaxpr.outvars))


def _meaning(equation: Any, rules: int = RULES) -> tuple:
    """Equal for equations that do the same with their inputs: by value where values compare, otherwise by identity.

    What prints alike need not be alike: compiled helpers that differ in an array they capture do.
    """
    parameters, derivative = dict(equation.params), ()
    rule = parameters.pop("jvp_jaxpr_fun", None)
    if rule is not None and rules:
        # A derivative of one's own is made anew by each trace, and is known by its program: in which the function
        # itself may stand, so that no more derivatives are looked at than equations of motion take.
        own = len(equation.invars) - parameters.get("num_consts", 0)
        jaxpr, constants, _ = rule.call_wrapped(*[False] * own)
        rules -= 1
        derivative = _of_program(jaxpr, tuple(constants), rules)
    return equation.primitive, derivative, *((k, _value(v, rules)) for k, v in sorted(parameters.items()))


def _value(parameter: Any, rules: int) -> Any:
    if _is_program(parameter):
        return _of_program(getattr(parameter, "jaxpr", parameter), tuple(getattr(parameter, "consts", ())), rules)
    if isinstance(parameter, tuple | list):
        return (type(parameter), *(_value(one, rules) for one in parameter))
    try:
        hash(parameter)
    except TypeError:
        return id(parameter)
    # The text as well: 1, 1.0 and True are equal, as are zeros of either sign.
    return parameter if callable(parameter) else (parameter, repr(parameter))


def needed(equations: Sequence[Any], results: Sequence[Any]) -> tuple[list, dict]:
    """Equations that lead to results, and all variables that they or the results read, in order."""
    wanted = dict.fromkeys(_variables(results))
    found = []
    for equation in reversed(equations):
        if any(v in wanted for v in equation.outvars):
            found.append(equation)
            wanted.update(dict.fromkeys(_variables(equation.invars)))
    return found[::-1], wanted
