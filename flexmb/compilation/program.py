"""Programs of traced functions: divided into stages, compared by their operations, with their numbers as arguments."""

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

# Depth of custom derivatives that are compared: as deep as equations of motion differentiate.
RULES = 2


class Code:
    """A program that equals other programs that do the same; numbers of a :class:`Captured` are its constants."""

    def __init__(self, jaxpr: Jaxpr, results: Any, rules: int = RULES):
        self.jaxpr, self.results = jaxpr, results
        self._meaning = (_program_meaning(jaxpr, (), rules), results)
        self._hash = hash(self._meaning)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Code) and self._meaning == other._meaning

    def __hash__(self) -> int:
        return self._hash


class Captured(Record):
    """A user's function as a program, with the numbers that it captures or that its text contains.

    Functions that differ in numbers alone share compiled code. Numbers may be traced, for a derivative.
    """

    code: Code = static()
    numbers: tuple[Any, ...]

    def __call__(self, *arguments: Any) -> Any:
        """Value of the function for arguments of the captured shapes."""
        leaves = jax.tree.leaves(arguments)
        return jax.tree.unflatten(self.code.results, jax.core.eval_jaxpr(self.code.jaxpr, self.numbers, *leaves))


def captured(function: Callable[..., Any], *like: Any, rules: int = RULES, formal: Collection[float] = ()) -> Captured:
    """Capture a function as it is now, before anything it refers to changes.

    Args:
        formal: Numbers that stay in the program, whatever their sign, because the compiler uses them.
    """
    from jax.extend.core import Var

    leaves, structure = jax.tree.flatten(like)
    results: Any = None

    # A new function, since JAX remembers traces of known ones.
    def flat(*leaves: Any):
        nonlocal results
        values, results = jax.tree.flatten(function(*jax.tree.unflatten(structure, leaves)))
        return [jnp.asarray(value) for value in values]

    program = jax.make_jaxpr(flat)(*(jax.typeof(leaf) for leaf in leaves))
    jaxpr, numbers, places, equations = program.jaxpr, list(program.consts), [], []

    def placed(atom: Any):
        """A constant in place of a number; whole numbers may be shapes or indices, and stay."""
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


# Operations of waves and low powers of time, without pulses.
WAVES = frozenset(
    "add sub mul neg sin cos square broadcast_in_dim reshape squeeze concatenate convert_element_type".split()
)

# Operations without kinks and jumps, except at singularities; any other operation may have some.
SMOOTH = WAVES | frozenset(
    """acos acosh asin asinh atan atan2 atanh cbrt copy cos cosh cumsum div dot_general dynamic_slice
    dynamic_update_slice erf erfc exp exp2 expand_dims expm1 gather integer_pow iota log log1p logistic pad pow
    reduce_sum rev rsqrt scatter scatter-add sinh slice split sqrt stop_gradient tan tanh transpose""".split()
)


def is_wave(found: Captured) -> bool:
    """Whether a function consists of sums and products of sines and constants."""
    return all(equation.primitive.name in WAVES for equation in found.code.jaxpr.eqns)


def has_effects(found: Captured) -> bool:
    """Whether a function has side effects, such as printing."""
    return bool(found.code.jaxpr.effects)


def may_bend(function: Callable[..., Any], *like: Any) -> bool:
    """Whether a function may have kinks or jumps: whether it contains other than smooth operations."""
    return _may_bend(jax.make_jaxpr(function)(*like).jaxpr)


def _may_bend(jaxpr: Jaxpr) -> bool:
    for equation in jaxpr.eqns:
        inner = [part for part in equation.params.values() if _is_program(part)]
        if not inner and equation.primitive.name not in SMOOTH:
            return True
        if any(_may_bend(getattr(part, "jaxpr", part)) for part in inner):
            return True
    return False


def captured_of_time(function: Callable[..., Any]) -> tuple[Any, tuple[int, ...]]:
    """A function of time as it is now, and the shape of its value.

    Records of this package, such as tables and laws, stay as they are: their traces may be kept on disk, traces with
    captured functions may not.
    """
    time = jax.ShapeDtypeStruct((), float)
    law: Any = function
    if not isinstance(function, Record):
        law = captured(lambda t: as_reals("its value", function(t)), time)
    # Some records know their shape without a trace.
    shape = getattr(law, "shape_of_value", None)
    # Not the record itself: the name of its trace would be its whole text.
    if shape is None:
        value = jax.eval_shape(lambda t: law(t), time)
        check_real("its value", value)
        shape = value.shape
    return law, shape


def digest(found: Captured) -> str:
    """Digest of a function's operations and numbers.

    Options of operations are left out, since they include settings of JAX and functions that each trace makes anew.
    """
    text = hashlib.sha256()

    def add(number: Any):
        text.update(repr(jax.typeof(number)).encode())
        text.update(np.asarray(number).tobytes())

    def visit(jaxpr: Jaxpr, constants: Sequence[Any]):
        for number in constants:
            add(number)
        for equation in jaxpr.eqns:
            text.update(equation.primitive.name.encode())
            for atom in equation.invars:
                if is_literal(atom):
                    add(atom.val)
            for parameter in jax.tree.leaves(list(equation.params.values()), is_leaf=_is_program):
                if _is_program(parameter):
                    visit(getattr(parameter, "jaxpr", parameter), getattr(parameter, "consts", ()))

    visit(found.code.jaxpr, found.numbers)
    return text.hexdigest()


def is_literal(atom: Any) -> TypeGuard[Literal]:
    """Whether an operand is a number in the text of a program, not a variable."""
    return hasattr(atom, "val")


def _is_program(value: Any) -> bool:
    return hasattr(value, "eqns")


def split_constants(
    function: Callable[..., Any], varying: tuple, constant: tuple
) -> tuple[Callable[..., tuple], Callable[..., Any]]:
    """Split a function without side effects of varying and constant arrays, to be called often with equal constants.

    Equal operations are done once, and unused ones left out. Returns ``early(*constant)``, a tuple of arrays ``kept``,
    and ``late(*varying, *kept)``, the result of the function.
    """
    early, (late,) = split_together([(function, varying)], constant)
    return early, late


def split_together(
    functions: Sequence[tuple[Callable[..., Any], tuple]], constant: tuple
) -> tuple[Callable[..., tuple], list[Callable[..., Any]]]:
    """As :func:`split_constants`, for several functions that share work on the same constants."""

    def every(constant: tuple, *varying: tuple):
        return (), *[
            function(*arguments, *constant) for (function, _), arguments in zip(functions, varying, strict=True)
        ]

    early, *late = split_in_stages(every, [constant, *[varying for _, varying in functions]])
    return lambda *constant: early(*constant)[1], [_result_of(stage) for stage in late]


def _result_of(stage: Callable[..., Any]):
    return lambda *arguments: stage(*arguments)[0]


def split_in_stages(function: Callable[..., Sequence[Any]], groups: Sequence[tuple]) -> list[Callable[..., Any]]:
    """Split a function without side effects by the arguments that each operation depends on.

    Equal operations are done once, and unused ones left out.

    Args:
        function: From tuples of arrays, the groups, to a result for each group, which depends on this group and those
            before it; otherwise ValueError.

    Returns:
        For each group a stage ``(*arguments, *carried) -> (result, more)``: from its arguments and all that earlier
        stages carry on, to its result and a tuple of arrays for later stages.
    """
    leaves, structure = jax.tree.flatten(tuple(groups))

    def flat(*leaves: Any):
        return function(*jax.tree.unflatten(structure, leaves))

    program, shapes = jax.make_jaxpr(flat, return_shape=True)(*(jax.typeof(leaf) for leaf in leaves))
    jaxpr = program.jaxpr
    equations, results = _without_repeats(jaxpr, program.consts)
    inputs, outputs = _in_groups(jaxpr.invars, groups), _in_groups(results, shapes)
    level = {v: i for i, members in enumerate(inputs) for v in members}
    # Operations of literals alone are done in every stage that needs them.
    steps: list[list] = [[] for _ in groups]
    for equation in equations:
        last = max((level[v] for v in _variables(equation.invars) if v in level), default=None)
        if last is not None:
            level |= dict.fromkeys(equation.outvars, last)
        for members in steps if last is None else [steps[last]]:
            members.append(equation)
    if any(level.get(v, 0) > i for i, members in enumerate(outputs) for v in _variables(members)):
        raise ValueError("A result follows from arguments of a group that comes after its own.")
    carried: list[list] = [[] for _ in groups]
    read: dict = {}
    for i in reversed(range(len(groups))):
        carried[i] = [v for v in read if level.get(v) == i]
        steps[i], more = needed(steps[i], [*outputs[i], *carried[i]])
        read |= more
    stages = []
    for i, (members, shape) in enumerate(zip(inputs, shapes, strict=True)):
        before = itertools.chain.from_iterable(carried[:i])
        stage_program = jaxpr.replace(invars=[*members, *before], eqns=steps[i], outvars=[*outputs[i], *carried[i]])
        stages.append(_evaluation(stage_program, program.consts, jax.tree.structure((shape, tuple(carried[i])))))
    return stages


def _in_groups(values: Sequence[Any], like: Sequence[Any]) -> list[list]:
    """Values in groups, as many in each as some trees have leaves."""
    remaining = iter(values)
    return [list(itertools.islice(remaining, len(jax.tree.leaves(part)))) for part in like]


def _evaluation(jaxpr: Jaxpr, constants: Any, results: Any) -> Callable[..., Any]:
    """Function of arguments in any trees."""

    def function(*arguments: Any):
        return jax.tree.unflatten(results, jax.core.eval_jaxpr(jaxpr, constants, *jax.tree.leaves(arguments)))

    return function


def _variables(atoms: Any) -> list:
    return [v for v in atoms if not is_literal(v)]


def _without_repeats(jaxpr: Jaxpr, constants: Any) -> tuple[list, list]:
    """Equations without repetitions, and results."""
    first: dict = {}
    values = [(v.aval, np.asarray(c).tobytes()) for v, c in zip(jaxpr.constvars, constants, strict=True)]
    same: dict = {v: first.setdefault(value, v) for v, value in zip(jaxpr.constvars, values, strict=True)}
    known: dict = {}
    equations = []

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
            equations.append(equation.replace(invars=inputs))
    return equations, replaced(jaxpr.outvars)


def _program_meaning(jaxpr: Jaxpr, constants: tuple, rules: int) -> tuple:
    """Value that is equal for programs that do the same with equal arguments."""
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
    """Value that is equal for equations that do the same: parameters compare by value if possible, else by identity.

    Text alone does not suffice: compiled helpers that differ in a captured array print alike.
    """
    parameters, derivative = dict(equation.params), ()
    rule = parameters.pop("jvp_jaxpr_fun", None)
    if rule is not None and rules:
        # Each trace makes a custom derivative anew, so it is compared by its program. As this may contain the function
        # itself, the depth is limited.
        argument_count = len(equation.invars) - parameters.get("num_consts", 0)
        jaxpr, constants, _ = rule.call_wrapped(*[False] * argument_count)
        rules -= 1
        derivative = _program_meaning(jaxpr, tuple(constants), rules)
    return equation.primitive, derivative, *((k, _value(v, rules)) for k, v in sorted(parameters.items()))


def _value(parameter: Any, rules: int) -> Any:
    if _is_program(parameter):
        return _program_meaning(getattr(parameter, "jaxpr", parameter), tuple(getattr(parameter, "consts", ())), rules)
    if isinstance(parameter, tuple | list):
        return (type(parameter), *(_value(element, rules) for element in parameter))
    try:
        hash(parameter)
    except TypeError:
        return id(parameter)
    # With its text, since 1, 1.0 and True are equal, as are zeros of either sign.
    return parameter if callable(parameter) else (parameter, repr(parameter))


def needed(equations: Sequence[Any], results: Sequence[Any]) -> tuple[list, dict]:
    """Equations that results depend on, and all variables that they or the results read, in order."""
    variables = dict.fromkeys(_variables(results))
    needed_equations = []
    for equation in reversed(equations):
        if any(v in variables for v in equation.outvars):
            needed_equations.append(equation)
            variables.update(dict.fromkeys(_variables(equation.invars)))
    return needed_equations[::-1], variables
