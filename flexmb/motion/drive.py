"""Functions of time in a simulation: loads, prescribed motion, and the factor of the incremental loads."""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..compilation.record import Record, static
from ..math.indices import accumulate, put
from ..math.rotation import LBAR, LBODY
from ..mechanics.loads import LoadFactors, scaled_loads
from ..model.topology import Loads, Parameters, Topology

# The tensor of each kind of moment.
MOMENTS = {"moment": LBAR, "local moment": LBODY}


class Drive(NamedTuple):
    """Loads and prescribed values at one time; None if the mechanism has none of a kind.

    Attributes:
        loads: Constant and incremental loads together, with temperatures.
        increment: Factor of the incremental loads.
        force: Nodal forces.
        turning: Matrix from coordinates to nodal forces, for moments about global axes and axes of bodies.
        stress: Additional stress resultants.
        x: Values of the PRESCRIBED coordinates, from their start.
        e: Values of the PRESCRIBED deformations.
    """

    loads: Loads
    increment: Float[Array, ""]
    force: Float[Array, "n_x"] | None = None
    turning: Float[Array, "n_x n_x"] | None = None
    stress: Float[Array, "n_e"] | None = None
    x: Float[Array, "_p"] | None = None
    e: Float[Array, "_p"] | None = None


class Driven(Record):
    """One function of time and the coordinates or deformations that it drives.

    Attributes:
        quantity: "increment", "force", "moment", "local moment" (about axes that turn with the body), "stress",
            "temperature", "x" or "e".
        at: Indices of the coordinates or deformations; for "x" and "e" among the PRESCRIBED ones; for "temperature"
            rows and columns of the temperatures of the loads.
        value: Function of time that returns one number for each index; a temperature may return one for all.
        of_input: Number of the model's input whose first part this is.
        given: The function of time that the user gave for this input.
    """

    quantity: str = static()
    at: Int[Array, "*k"]
    value: Callable[..., Any]
    of_input: int | None = static(default=None)
    given: Callable[..., Any] | None = None


class Table(Record):
    """Piecewise linear function of time. The steps of a simulation end at its times.

    Attributes:
        times: Ascending times, (n,) [s].
        values: Values at `times`, (n, ...); constant before the first and after the last.
    """

    times: Float[Array, "n"]
    values: Float[Array, "n *k"]

    def __call__(self, t: Float[Array, ""]) -> Float[Array, "*k"]:
        """Return the value at a time.

        Args:
            t: Time [s].
        """
        times, values = jnp.asarray(self.times), jnp.asarray(self.values)
        i = jnp.clip(jnp.searchsorted(times, t, side="right") - 1, 0, times.shape[0] - 2)
        share = (t - times[i]) / (times[i + 1] - times[i])
        inside = values[i] + share * (values[i + 1] - values[i])
        # Compare times, which are exact: each side keeps its own derivative.
        return jnp.where(t < times[0], values[0], jnp.where(t > times[-1], values[-1], inside))


def has_table(value: Any) -> bool:
    """Whether a function of time is a table, or contains one."""
    leaves = jax.tree.leaves(value, is_leaf=lambda leaf: isinstance(leaf, Table))
    return any(isinstance(leaf, Table) for leaf in leaves)


def drive_at(topology: Topology, parameters: Parameters, driven: tuple[Driven, ...], t: Float[Array, ""]) -> Drive:
    """Loads and prescribed values at a time."""
    values = [(drive, jnp.asarray(drive.value(t), float)) for drive in driven]
    increment = sum((value for drive, value in values if drive.quantity == "increment"), start=jnp.array(0.0))
    loads = scaled_loads(parameters, LoadFactors(1.0, increment))
    sums: dict[str, Any] = {"force": None, "turning": None, "stress": None, "x": loads.x, "e": loads.e}
    sizes = {
        "force": (topology.n_x,),
        "turning": (topology.n_x, topology.n_x),
        "stress": (topology.n_e,),
        "x": topology.x.prescribed.shape,
        "e": topology.e.prescribed.shape,
    }
    for drive, value in values:
        if drive.quantity == "increment":
            continue
        if drive.quantity == "temperature":
            temperature: Any = loads.temperature
            warmer = jnp.broadcast_to(value, drive.at.shape[1:])
            loads = dataclasses.replace(loads, temperature=accumulate(temperature, tuple(drive.at), warmer))
            continue
        moment = drive.quantity in MOMENTS
        name = "turning" if moment else drive.quantity
        total = jnp.zeros(sizes[name]) if sums[name] is None else sums[name]
        if moment:
            # f = 2 Lbar(lambda)^T M is linear in lambda; for axes of the body L replaces Lbar.
            matrix = 2 * jnp.einsum("i,ijk->jk", value, MOMENTS[drive.quantity])
            sums[name] = accumulate(total, (drive.at[:, None], drive.at[None, :]), matrix)
        else:
            insert = put if name in ("x", "e") else accumulate
            sums[name] = insert(total, drive.at, _for_each(value, drive.at))
    return Drive(loads, increment, **sums)


def _for_each(value: Float[Array, "*k"], at: Int[Array, "i"]):
    """One number for each index; broadcasting would let one number act on all of them."""
    if value.shape == () and at.shape == (1,):
        return value[None]
    if value.shape != at.shape:
        raise ValueError(f"A function of time returns shape {value.shape}, but must return {at.shape[0]} numbers.")
    return value
