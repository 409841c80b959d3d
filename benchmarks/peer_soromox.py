"""The soft rod of peers.py in SoRoMoX, with piecewise constant strains; needs the extra ``peers``."""

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np


def rod(scene: Any, space: bool, gauss: int = 5) -> Any:
    """The rod as constant-strain segments with shear, held at its first end.

    Args:
        scene: As ``peers.SCENE``.
        space: Whether in space, else in the plane.
        gauss: Places of quadrature in a segment; 5 is SoRoMoX's own number.
    """
    import soromox
    from soromox.systems.components import LinkSpec

    # Order of the strains: twist and curvatures, then stretch and shears.
    fields = ("GIt", "EIy", "EIz", "EA", "GAy", "GAz") if space else ("EIy", "EA", "GAz")
    straight = [float(name == "EA") for name in fields]
    length = scene.length / scene.segments
    stiffness, damping = (
        length * np.diag([getattr(of, name) for name in fields]) for of in (scene.stiffness, scene.damping)
    )
    link = LinkSpec.circular(
        length=length,
        radius=scene.radius,
        density=scene.density,
        reference_strain=straight,
        stiffness=jnp.asarray(stiffness),
        damping=jnp.asarray(damping),
    )
    gravity = jnp.asarray(scene.gravity if space else scene.gravity[:2])
    kind, pose = (soromox.PCS, [0, 0, 0, 1, 0, 0, 0]) if space else (soromox.PlanarPCS, [0, 0, 0])
    structure = (soromox.PCSStructure if space else soromox.PlanarPCSStructure)(num_gauss_points=gauss)
    return kind.from_links(
        [link] * scene.segments, structure=structure, gravity=gravity, base_pose=jnp.asarray(pose, float)
    )


def tip(system: Any, space: bool, strains: Any) -> Any:
    """Place of the last end [m].

    Args:
        system: As from :func:`rod`.
        space: Whether in space.
        strains: Coordinates.
    """
    pose = system.forward_kinematics_tips(strains)[-1]
    return pose[:3, 3] if space else pose[1:]


def motion(unscaled: Any, space: bool, rtol: float, share: Any, times: Any) -> Any:
    """Places of the tip at the times, from rest and straight, by Tsit5 with adaptive steps.

    Args:
        unscaled: As from :func:`rod`.
        space: Whether in space.
        rtol: Relative tolerance; the absolute one is a thousandth of it.
        share: Factor of the stiffness.
        times: (n_t,) [s].
    """
    import diffrax
    import soromox

    system = unscaled.update_link_params(stiffness=share * unscaled.params.link.stiffness)
    start = soromox.SystemState(t=jnp.asarray(0.0), y=jnp.zeros(system.state_size))
    steps = diffrax.PIDController(rtol=rtol, atol=1e-3 * rtol)
    found = system.rollout_to(
        start, t1=times[-1], solver_dt=1e-4, save_ts=times, stepsize_controller=steps, max_steps=16**5
    )
    strains = found.y[:, : system.num_coordinates]
    return jax.vmap(functools.partial(tip, system, space))(strains)


def compiled(scene: Any, space: bool, gauss: int = 5) -> Any:
    """Compiled function of tolerance, factor of the stiffness and times, which gives places of the tip."""
    return jax.jit(functools.partial(motion, rod(scene, space, gauss), space))


def gradient(scene: Any, space: bool) -> Any:
    """Compiled derivative of the height of the tip at the last time by the factor of the stiffness."""
    system = rod(scene, space)

    def end(rtol: Any, share: Any, times: Any) -> Any:
        return motion(system, space, rtol, share, times)[-1, 1]

    return jax.jit(jax.grad(end, argnums=1))


def statics(scene: Any, tolerance: float) -> Any:
    """Compiled function that gives the place of the tip at rest in space.

    SoRoMoX has no static solver: Newton's method on its forces, from the straight rod, with the load in steps.

    Args:
        scene: As ``peers.SCENE``.
        tolerance: Of a correction of the strains, relative.
    """
    system, steps = rod(scene, True), 4

    def corrected(state: Any) -> Any:
        strains, _, load, count = state
        at = system.stiffness_matrix() @ strains + load * system.gravitational_force(strains)
        by = system.stiffness_matrix() + load * jax.jacfwd(system.gravitational_force)(strains)
        change = jnp.linalg.solve(by, at)
        return strains - change, jnp.max(jnp.abs(change)) / (1 + jnp.max(jnp.abs(strains))), load, count + 1

    def goes_on(state: Any) -> Any:
        return (state[1] > tolerance) & (state[3] < 30)

    @jax.jit
    def found(share: Any) -> Any:
        strains = jnp.zeros(system.num_coordinates)
        for load in jnp.linspace(0, 1, steps + 1)[1:]:
            strains, last, _, _ = jax.lax.while_loop(goes_on, corrected, (strains, 1.0, load * share, 0))
        return jnp.where(last <= tolerance, tip(system, True, strains), jnp.nan)

    return found
