"""A traced function in two parts: what follows from constants, computed once, and what varies."""

from collections.abc import Callable
from typing import Any

import jax
import jax.core
import numpy as np
from jax.extend.core import ClosedJaxpr, Jaxpr, Literal


def split(
    function: Callable[..., Any], varying: tuple, constant: tuple
) -> tuple[Callable[..., tuple], Callable[..., Any]]:
    """Take a function apart, so that it can be called many times with equal constants.

    Equal operations are done once, and what no result needs is left out.

    Args:
        function: Function of arrays that vary, followed by arrays that do not; it must not have side effects.
        varying: Arguments that vary, or their shapes.
        constant: The others, or their shapes.

    Returns:
        ``early(*constant)``, a tuple of arrays ``kept``, and ``late(*varying, *kept)``, what the function returns.
    """
    leaves, structure = jax.tree.flatten((varying, constant))
    count = len(jax.tree.leaves(varying))

    def flat(*leaves):
        varying, constant = jax.tree.unflatten(structure, leaves)
        return function(*varying, *constant)

    program, shape = jax.make_jaxpr(flat, return_shape=True)(*(jax.typeof(leaf) for leaf in leaves))
    jaxpr, tree = program.jaxpr, jax.tree.structure(shape)
    equations, results = _without_repeats(jaxpr)
    moving, given = set(jaxpr.invars[:count]), set(jaxpr.invars[count:])
    late, early = [], []
    for equation in equations:
        inputs = _variables(equation.invars)
        if moving.intersection(inputs):
            late.append(equation)
            moving.update(equation.outvars)
        elif given.intersection(inputs):
            early.append(equation)
            given.update(equation.outvars)
        else:
            # Of literals alone: of no argument, and so done where it is asked for.
            late.append(equation)
            early.append(equation)
    late, wanted = _needed(late, results)
    kept = [v for v in wanted if v in given]
    early, _ = _needed(early, kept)
    first = _program(jaxpr, jaxpr.invars[count:], early, kept)
    then = _program(jaxpr, [*jaxpr.invars[:count], *kept], late, results)

    def prepared(*constant):
        return tuple(jax.core.eval_jaxpr(first, program.consts, *jax.tree.leaves(constant)))

    def function_of(*arguments):
        return jax.tree.unflatten(tree, jax.core.eval_jaxpr(then, program.consts, *jax.tree.leaves(arguments)))

    return prepared, function_of


def _program(jaxpr, inputs: list, equations: list, results: list):
    named = jaxpr.debug_info._replace(arg_names=None, result_paths=None)
    return jaxpr.replace(invars=inputs, eqns=equations, outvars=results, debug_info=named)


def _variables(atoms) -> list:
    return [v for v in atoms if not isinstance(v, Literal)]


def _without_repeats(jaxpr) -> tuple[list, list]:
    """Equations without those done before, and results."""
    same: dict = {}
    known: dict = {}
    found = []

    def replaced(atoms) -> list:
        return [v if isinstance(v, Literal) else same.get(v, v) for v in atoms]

    for equation in jaxpr.eqns:
        inputs = replaced(equation.invars)
        key = _meaning(equation, inputs)
        if key in known and not equation.effects:
            same.update(zip(equation.outvars, known[key], strict=True))
        else:
            known[key] = equation.outvars
            found.append(equation.replace(invars=inputs))
    return found, replaced(jaxpr.outvars)


def _meaning(equation, inputs: list) -> tuple:
    """Equal for equations that do the same: by value where values compare, otherwise by identity.

    What prints alike need not be alike: compiled helpers that differ in an array they capture do.
    """
    names = tuple((v.aval, np.asarray(v.val).tobytes()) if isinstance(v, Literal) else v for v in inputs)
    return equation.primitive, names, tuple((k, *_value(v)) for k, v in sorted(equation.params.items()))


def _value(parameter) -> tuple:
    try:
        hash(parameter)
    except TypeError:
        return (id(parameter),)
    if isinstance(parameter, Jaxpr | ClosedJaxpr) or callable(parameter):
        return (parameter,)
    # The text as well: 1, 1.0 and True are equal, as are zeros of either sign.
    return parameter, repr(parameter)


def _needed(equations: list, results: list) -> tuple[list, dict]:
    """Equations that lead to results, and all variables that they or the results read, in order."""
    wanted = dict.fromkeys(_variables(results))
    found = []
    for equation in reversed(equations):
        if any(v in wanted for v in equation.outvars):
            found.append(equation)
            wanted.update(dict.fromkeys(_variables(equation.invars)))
    return found[::-1], wanted
