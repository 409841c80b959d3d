"""What depends on time: loads, prescribed motion, and the factor of the incremental loads."""

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
from ..model.parameters import Loads, Parameters
from ..model.topology import Topology

# The tensor of each kind of moment.
MOMENTS = {"moment": LBAR, "local moment": LBODY}


class Drive(NamedTuple):
    """What depends on time, at one time. What a scene does not have is None.

    Attributes:
        loads: Constant and incremental loads together, with the temperatures that depend on time.
        increment: Factor of the incremental loads, () [-].
        force: Nodal forces, (n_x,) [N, N m].
        turning: Nodal forces by coordinates, of moments about fixed axes and axes of bodies, (n_x, n_x) [N m].
        stress: Stress resultants added, (n_e,) [N, N m].
        x: Values of the PRESCRIBED coordinates, from their start, in their order [m, rad].
        e: Values of the PRESCRIBED deformations, in their order [m, rad].
    """

    loads: Loads
    increment: Float[Array, ""]
    force: Float[Array, "n_x"] | None = None
    turning: Float[Array, "n_x n_x"] | None = None
    stress: Float[Array, "n_e"] | None = None
    x: Float[Array, "_p"] | None = None
    e: Float[Array, "_p"] | None = None


class Driven(Record):
    """One function of time and what it drives.

    Attributes:
        quantity: "increment", "force", "moment", "local moment" (about axes that turn with the body), "stress",
            "temperature", "x" or "e".
        at: Indices of the coordinates or deformations; for "x" and "e" among the PRESCRIBED ones; for "temperature"
            rows and columns of that of the loads, (2, k).
        value: Function of time that gives one number for each; of a temperature one may serve all.
        of_input: Number of the model's input that this is, or is the first part of.
        given: Function of time that this input is.
    """

    quantity: str = static()
    at: Int[Array, "*k"]
    value: Callable[..., Any]
    of_input: int | None = static(default=None)
    given: Callable[..., Any] | None = None


class Table(Record):
    """Piecewise linear function of time; a simulation steps onto its times.

    Attributes:
        times: Ascending, (n,) [s].
        values: At those times, (n, ...); constant before the first and after the last.
    """

    times: Float[Array, "n"]
    values: Float[Array, "n *k"]

    def __call__(self, t: Float[Array, ""]) -> Float[Array, "*k"]:
        """Value at a time.

        Args:
            t: Time [s].
        """
        times, values = jnp.asarray(self.times), jnp.asarray(self.values)
        i = jnp.clip(jnp.searchsorted(times, t, side="right") - 1, 0, times.shape[0] - 2)
        share = (t - times[i]) / (times[i + 1] - times[i])
        inside = values[i] + share * (values[i + 1] - values[i])
        # By the times, which no round-off makes equal: a derivative is that of one side.
        return jnp.where(t < times[0], values[0], jnp.where(t > times[-1], values[-1], inside))


def has_table(value: Any) -> bool:
    """Whether a function of time is a table, or a law made of one."""
    tables = jax.tree.leaves(value, is_leaf=lambda one: isinstance(one, Table))
    return any(isinstance(one, Table) for one in tables)


def drive_at(topology: Topology, parameters: Parameters, driven: tuple[Driven, ...], t: Float[Array, ""]) -> Drive:
    """Everything that depends on time, at one time."""
    values = [(one, jnp.asarray(one.value(t), float)) for one in driven]
    increment = sum((value for one, value in values if one.quantity == "increment"), start=jnp.array(0.0))
    loads = scaled_loads(parameters, LoadFactors(1.0, increment))
    found: dict[str, Any] = {"force": None, "turning": None, "stress": None, "x": loads.x, "e": loads.e}
    sizes = {
        "force": (topology.n_x,),
        "turning": (topology.n_x, topology.n_x),
        "stress": (topology.n_e,),
        "x": topology.x.prescribed.shape,
        "e": topology.e.prescribed.shape,
    }
    for one, value in values:
        if one.quantity == "increment":
            continue
        if one.quantity == "temperature":
            temperature: Any = loads.temperature
            warmer = jnp.broadcast_to(value, one.at.shape[1:])
            loads = dataclasses.replace(loads, temperature=accumulate(temperature, tuple(one.at), warmer))
            continue
        moment = one.quantity in MOMENTS
        name = "turning" if moment else one.quantity
        whole = jnp.zeros(sizes[name]) if found[name] is None else found[name]
        if moment:
            # f = 2 Lbar(lambda)^T M is linear in lambda, and so is 2 L(lambda)^T M of axes that turn with the body.
            matrix = 2 * jnp.einsum("i,ijk->jk", value, MOMENTS[one.quantity])
            found[name] = accumulate(whole, (one.at[:, None], one.at[None, :]), matrix)
        elif name in ("x", "e"):
            found[name] = put(whole, one.at, _for_each(value, one.at))
        else:
            found[name] = accumulate(whole, one.at, _for_each(value, one.at))
    return Drive(loads, increment, found["force"], found["turning"], found["stress"], found["x"], found["e"])


def _for_each(value: Float[Array, "*k"], at: Int[Array, "i"]):
    """One number for each index; a number for several would act on all of them."""
    if value.shape == () and at.shape == (1,):
        return value[None]
    if value.shape != at.shape:
        raise ValueError(f"A function of time gives numbers of shape {value.shape} where {at.shape[0]} are driven.")
    return value
