"""What is no element is refused by name, one law a time; what is one passes, at any size."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar, spatial


def distance(p: fm.Point2, q: fm.Point2, *, ref):
    """Change of the distance of two points [m]."""
    return (jnp.linalg.norm(q - p) - jnp.linalg.norm(ref.q - ref.p))[None]


def at_p(p: fm.Point2, rot_p: fm.Angle, *, ref):
    return jnp.zeros(0)


def still(e):
    return jax.lax.stop_gradient(e)


def bend(p):
    return (p.rot_q - p.ref.rot_q) - (p.rot_p - p.ref.rot_p)


WRONG = {
    "not zero": (
        lambda p: jnp.linalg.norm(p.q - p.p)[None],
        "deformation 1 is .* in the undeformed mechanism, given as",
    ),
    "not objective": (lambda p: (p.q - p.p - p.ref.q + p.ref.p)[:1], "deformation 1 changes by .* in a rigid motion"),
    "a kink": (
        lambda p: jnp.maximum(bend(p), 0.0),
        "its second derivatives are not those of .* in the undeformed mechanism: it may",
    ),
    "a root": (lambda p: jnp.sqrt(bend(p) ** 2), "a first derivative of its deformations is not finite in the und"),
    "not its derivative": (lambda p: still(bend(p)) + 0.1 * bend(p), "derivative of deformation 1 is not that of its"),
    "nothing": (lambda p: 0 * p.rot_p, "deformation 1 is zero for all coordinates"),
}


class Given(dict):
    __getattr__ = dict.__getitem__


@pytest.mark.slow("not zero")
@pytest.mark.parametrize("case", WRONG)
def test_deformations_that_are_none_are_refused_by_what_is_wrong(case):
    own, message = WRONG[case]

    def made(p: fm.Point2, rot_p: fm.Angle, q: fm.Point2, rot_q: fm.Angle, *, ref):
        return own(Given(p=p, rot_p=rot_p, q=q, rot_q=rot_q, ref=ref))

    with pytest.raises(fm.ModelError, match=f"Element type 'made': .*{message}"):
        fm.check_element(made)


COMPANIONS = {
    "energy": ({"energy": lambda e, *, ref: e[0] * still(e[0])}, "the derivative of its energy is not"),
    "skew": ({"stiffness": lambda *, ref: jnp.array([[1.0, 2.0], [0.0, 1.0]])}, "its stiffness is not symmetric"),
}


@pytest.mark.parametrize("case", COMPANIONS)
def test_stress_that_has_no_such_energy_is_refused(case):
    companions, message = COMPANIONS[case]

    def both(p: fm.Point2, rot_p: fm.Angle, q: fm.Point2, rot_q: fm.Angle, *, ref):
        return jnp.concatenate([distance(p, q, ref=ref), rot_q - ref.rot_q - rot_p + ref.rot_p])

    with pytest.raises(fm.ModelError, match=message):
        fm.check_element(fm.Element(both, **companions))


MASSES = {
    "negative": (lambda p, rot_p, *, ref: (p[None], -jnp.eye(1)), "its mass matrix is not positive semidefinite"),
    "one way": (lambda p, rot_p, *, ref: (p[None] * jnp.array([1.0, 0]), jnp.eye(1)), "kinetic energy changes"),
    "skew": (lambda p, rot_p, *, ref: (jnp.stack([p, p]), jnp.array([[1.0, 2], [0, 9]])), "matrix H .* not symmetric"),
}


@pytest.mark.parametrize("case", MASSES)
def test_mass_that_no_body_has_is_refused(case):
    inertia, message = MASSES[case]
    with pytest.raises(fm.ModelError, match=message):
        fm.check_element(fm.Element(at_p, inertia=inertia))


def test_elements_pass_and_tell_how_nearly():
    found = fm.check_element(planar.rigid_body, apart=0.01, section=fm.Rigidity(mass=2.0))
    assert (found.element, found.deformations) == ("rigid_body", 3)
    assert max(found.deviations.values()) < 1e-8
    text = repr(found)
    assert text.startswith("ElementCheck: rigid_body with 3 deformations passes")
    assert "unchanged by rigid motion: within" in text
    assert "kinetic energy is unchanged by rigid motion: within" in text
    # Angles that count, an axis, a law with a kink of its own; a potential.
    fm.check_element(spatial.hinge, axis=(0.0, 0.6, 0.8), stiffness=2.0)
    fm.check_element(planar.spring_damper, law=lambda e, ed, *, k: k * jnp.maximum(e, 0.0), k=3.0)
    fm.check_element(fm.Element(distance, energy=lambda e, *, ref, k: k * e[0] ** 4), k=fm.Rigidity(EA=1.0).EA)
    with pytest.raises(fm.ModelError, match="needs the property 'axis'"):
        fm.check_element(spatial.hinge)
    with pytest.raises(fm.ModelError, match="Element type 'hinge' has an axis of zero length"):
        fm.check_element(spatial.hinge, axis=np.zeros(3))
