"""Traced functions kept on disk: a fresh process that asks for the same neither traces nor compiles.

The compiler's cache saves a fresh process the compiler's work, not Python's of tracing, which for a simulation is most
of the rest.
"""

import logging
import os
import pickle
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax

from .fingerprint import UnknownError, fingerprint, of_package

LOG = logging.getLogger("flexmb")

_folder: Path | None = None


def keep_traces(folder: Path | None) -> None:
    """Where to keep traced functions, from now on.

    Args:
        folder: None: nowhere.
    """
    global _folder
    _folder = folder


def kept(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function to be compiled, which takes its traced program from disk where that is kept.

    What cannot be known from process to process, such as an object of a user's class among the arguments, is traced as
    ever.

    Args:
        function: ``function(*chosen, *leaves)`` with what chooses code, followed by arrays, given to ``jax.jit`` with
            the former static.
    """

    def call(structure, fixed, *leaves):
        path = _place(function, structure, fixed, leaves)
        if path is None:
            return function(structure, fixed, *leaves)
        found = _read(path)
        if found is None:
            found = _write(path, lambda *leaves: function(structure, fixed, *leaves), leaves)
        if found is None:
            return function(structure, fixed, *leaves)
        program, shape = found
        return jax.tree.unflatten(jax.tree.structure(shape), program.call(*leaves))

    return call


def _place(function, structure, fixed, leaves) -> Path | None:
    """File that the traced function is kept in."""
    if _folder is None:
        return None
    shapes = [(leaf.shape, leaf.dtype, leaf.weak_type) for leaf in map(jax.typeof, leaves)]
    try:
        return _folder / f"{fingerprint(of_package(), function, structure, fixed, shapes)}.trace"
    except UnknownError as reason:
        LOG.debug("%s is traced in every process: %s", function, reason)
        return None


def _read(path: Path):
    """Traced function and the shape of its result; None where there is none that can be read."""
    from jax.export import deserialize

    try:
        shape, program = pickle.loads(path.read_bytes())
        return deserialize(bytearray(program)), shape
    except FileNotFoundError:
        return None
    except Exception as reason:  # Whatever a damaged file leads to: it is made anew.
        LOG.warning("%s cannot be read and is made anew: %s", path, reason)
        return None


def _write(path: Path, function, leaves):
    """Trace a function and keep it; None where its result or what it calls cannot be kept."""
    from jax.export import deserialize, export

    shapes = []

    def flat(*leaves):
        found, structure = jax.tree.flatten(function(*leaves))
        shapes.append(jax.tree.unflatten(structure, range(len(found))))
        return found

    arguments = [jax.ShapeDtypeStruct(leaf.shape, leaf.dtype) for leaf in map(jax.typeof, leaves)]
    try:
        serialized = export(jax.jit(flat))(*arguments).serialize()
        whole = pickle.dumps((shapes[-1], bytes(serialized)))
        shape, _ = pickle.loads(whole)
        if jax.tree.structure(shape) != jax.tree.structure(shapes[-1]):
            raise TypeError("its result holds what is only equal to itself")
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent)
        with os.fdopen(handle, "wb") as file:
            file.write(whole)
        os.replace(name, path)
    except Exception as reason:  # A fault of the function itself is raised again where it is traced without this.
        LOG.debug("%s is not kept: %s", path, reason)
        return None
    return deserialize(serialized), shape
