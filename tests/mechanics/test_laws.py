"""Laws of whole mechanisms, at a few dimensions and loads; what they are compared with is written here in numpy.

Two mechanisms, each compiled once: a planar chain with a hinge, a truss and gravity, and a spatial one with two beams,
a hinge and an offset body. They are soft (P l^2/EI up to 1), so that geometric stiffness matters.
"""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.math.rotation import lbar
from flexmb.mechanics.deformation import deformation_jacobian
from flexmb.mechanics.inertia import mass_matrix, weight
from flexmb.mechanics.stress_resultants import element_damping

EPS = np.finfo(float).eps
TENSOR = np.array([0.05, 0.01, -0.005, 0.06, 0.008, 0.07])


@dataclasses.dataclass
class Numbers:
    """Shifts of the nodes, factors of the rigidities, and loads."""

    places: np.ndarray
    factors: list[float]
    force: np.ndarray
    gravity: np.ndarray


def drawn(draw) -> Numbers:
    """Numbers of which each is drawn by a function of the shape, between minus one and one."""
    return Numbers(
        places=0.2 * draw((3, 3)),
        factors=(2.0 ** draw(4)).tolist(),
        # Never zero: the geometric stiffness is a part of what is compared.
        force=0.3 * draw(3) + np.array([0.3, -0.4, 0.35]),
        gravity=0.5 * draw(3),
    )


# The same whatever else is imported, which hypothesis's own are not: at the bounds, and between them.
BOUNDS, BETWEEN = np.random.default_rng(1), np.random.default_rng(2)
EXAMPLES = [
    drawn(lambda shape: BOUNDS.choice([-1.0, 1.0], shape)),
    *(drawn(lambda shape: np.round(BETWEEN.uniform(-1, 1, shape), 3)) for _ in range(2)),
]


def section(factor, extensible=True) -> fm.Rigidity:
    return fm.Rigidity(
        EA=100.0 * factor if extensible else 0.0,
        EIy=2.0 * factor,
        EIz=3.0 / factor,
        GIt=1.5 * factor,
        shear_z=0.02,
        shear_y=0.03 * factor,
        mass=0.4,
        Jx=0.05,
        Jy=0.02,
        Jz=0.03,
    )


def planar_chain(n: Numbers) -> fm.Builder:
    b = fm.Builder()
    places = {"A": (0.0, 0.0), "B": (1.0, 0.3), "C": (1.8, -0.2), "D": (1.5, 1.0)}
    for (name, place), shift in zip(places.items(), [np.zeros(3), *n.places], strict=True):
        b.node(name, [place[0] + shift[0], place[1] + shift[1]])
    b.rotation("B2")
    b.rotation("C.rotation")
    b.add(planar.beam, "A", "B", name="first", section=section(n.factors[0]))
    b.add(planar.hinge, "B.rotation", "B2", name="hinge", stiffness=n.factors[1])
    b.add(planar.beam, "B", "B2", "C", "C.rotation", name="second", section=section(n.factors[2]), released=(2, 3))
    b.add(planar.truss, "C", "D", name="truss", section=fm.Rigidity(EA=3.0 * n.factors[3], mass=0.2))
    b.fix("A")
    b.fix("D")
    b.mass("C", 0.3, inertia=0.02)
    b.force("C", n.force[:2])
    b.moment("B", 0.3 * n.force[2])
    b.gravity(n.gravity[:2])
    b.dof("first", 1, 2, 3)
    b.dof("hinge", 1)
    b.dof("second", 2, 3)
    return b


def spatial_chain(n: Numbers) -> fm.Builder:
    b = fm.Builder()
    places = {"A": (0.0, 0.0, 0.0), "B": (0.9, 0.2, -0.1), "C": (1.5, 0.9, 0.3), "D": (1.7, 1.1, 0.8)}
    for (name, place), shift in zip(places.items(), [np.zeros(3), *n.places], strict=True):
        b.node(name, [p + s for p, s in zip(place, shift, strict=True)])
    b.rotation("C2")
    b.add(spatial.beam, "A", "B", name="first", section=section(n.factors[0]), y=(0.1, 0.2, 1.0))
    b.add(spatial.beam, "B", "C", name="second", section=section(n.factors[1]), released=(2, 3, 4, 5, 6))
    b.add(spatial.hinge, "C.rotation", "C2", name="hinge", axis=(0.2, 1.0, -0.4), stiffness=n.factors[2])
    b.add(spatial.rigid_beam, "C", "C2", "D", name="arm", section=fm.Rigidity(mass=0.2 * n.factors[3]))
    b.fix("A")
    b.mass("C", 0.1)
    b.inertia("C2", TENSOR)
    b.mass("D", 0.2)
    # With four times as much some numbers within the bounds lie beyond a limit point, as a path tells.
    b.force("D", 0.25 * n.force)
    b.gravity(0.25 * n.gravity)
    b.dof("first", 1, 2, 3, 4, 5, 6)
    b.dof("second", 2, 3, 4, 5, 6)
    b.dof("hinge", 1)
    return b


CHAINS = {"planar": planar_chain, "spatial": spatial_chain}
every_chain = pytest.mark.parametrize("chain", CHAINS.values(), ids=CHAINS)


# -- independent evaluation -----------------------------------------------------------------------------------------


def triad(x: np.ndarray) -> np.ndarray:
    """Rotation matrix of an angle or of Euler parameters."""
    if x.size == 1:
        c, s = np.cos(x[0]), np.sin(x[0])
        return np.array([[c, -s], [s, c]])
    a, v = x[0], x[1:]
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return (a**2 - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * a * cross


class Whole:
    """A mechanism evaluated member by member."""

    def __init__(self, builder: fm.Builder):
        self.members = builder.members
        self.model = builder.build(dofs="named")
        self.labels, self.topology = self.model.labels, self.model.topology
        self.reference = np.asarray(self.model.parameters.reference)
        loads = self.model.parameters.loads
        self.force = np.zeros(self.reference.size) if loads.force is None else np.asarray(loads.force)
        self.gravity = np.zeros(builder.dimension or 2) if loads.gravity is None else np.asarray(loads.gravity)
        roles = self.topology.e
        self.held = np.concatenate([roles.fixed, roles.prescribed, roles.dof])
        self.stiffness = np.zeros((roles.size, roles.size))
        for name, member in self.members.items():
            element, at = member.element, self.deformations_of(name)
            chosen = element.arguments(element.stiffness, member.properties)
            if chosen is not None:
                ref = element.reference(self.coordinates(member, self.reference))
                self.stiffness[np.ix_(at, at)] = element.stiffness(ref=ref, **chosen)

    def deformations_of(self, name: str) -> list[int]:
        return [i for i, entry in enumerate(self.labels.e) if entry.of == name and entry.kind == "deformation"]

    def coordinates(self, member, x: np.ndarray) -> list[np.ndarray]:
        return [x[self.labels.coordinates(node)] for node in member.nodes]

    def deformations(self, x: np.ndarray) -> np.ndarray:
        e = np.zeros(self.topology.n_e)
        for name, member in self.members.items():
            element = member.element
            at, own = self.deformations_of(name), element.arguments(element.deformation, member.properties)
            if not at:
                continue
            near = {"near": np.zeros(len(at))} if element.tracks_angle else {}
            ref = element.reference(self.coordinates(member, self.reference))
            e[at] = element.deformation(*self.coordinates(member, x), ref=ref, **(own or {}), **near)
        for i, entry in enumerate(self.labels.e):
            if entry.kind == "norm":
                lam = x[self.labels.coordinates(entry.of)]
                e[i] = lam @ lam - 1
        return e

    def configuration(self, q: np.ndarray, start: np.ndarray) -> np.ndarray:
        """Newton's method on D(x) = e for given DOF deformations; only where it ends matters."""
        x, free = np.array(start), np.asarray(self.topology.x.dependent)
        wanted = np.zeros(self.topology.n_e)
        wanted[np.asarray(self.topology.e.dof)] = q
        near = np.zeros(self.topology.n_e)
        for _ in range(6):
            e, jacobian = deformation_jacobian(self.topology, self.model.parameters, x, near)
            excess = (np.asarray(e) - wanted)[self.held]
            x[free] -= np.linalg.solve(np.asarray(jacobian)[np.ix_(self.held, free)], excess)
            if np.max(np.abs(excess)) < 1e-9:  # the step just taken squares it
                return x
        raise AssertionError("no configuration for these degrees of freedom")

    def masses(self, x: np.ndarray) -> list[tuple[float, np.ndarray]]:
        """Mass and centre of mass of every member that has some."""
        found = []
        for member in self.members.values():
            parts, start = self.coordinates(member, x), self.coordinates(member, self.reference)
            if "mass" in member.properties:
                found.append((member.properties["mass"], parts[0]))
            elif member.properties.get("section") is not None:
                places = [i for i, part in enumerate(parts) if part.size == self.gravity.size]
                arm = start[places[1]] - start[places[0]]
                l0, centre = np.linalg.norm(arm), (parts[places[0]] + parts[places[1]]) / 2
                if len(parts) == 4:
                    # Of a cubic with the end directions: (p + q)/2 + l (t_p - t_q)/12.
                    tangents = [triad(parts[i]) @ triad(start[i]).T @ arm for i in (1, 3)]
                    centre = centre + (tangents[0] - tangents[1]) / 12
                found.append((float(member.properties["section"].mass) * l0, centre))
        return found

    def potential(self, x: np.ndarray) -> float:
        e, _ = deformation_jacobian(self.topology, self.model.parameters, x, np.zeros(self.topology.n_e))
        e = np.asarray(e)
        falling = sum(m * self.gravity @ centre for m, centre in self.masses(x))
        return float(0.5 * e @ self.stiffness @ e - self.force @ (x - self.reference) - falling)


@functools.cache
def wholes(chain):
    return [Whole(chain(n)) for n in EXAMPLES]


@functools.cache
def balanced(chain):
    """Each example with its equilibrium."""
    return [(whole, fm.equilibrium(whole.model)) for whole in wholes(chain)]


@functools.cache
def linearised(chain):
    """Each example with its linearisation."""
    return [(whole, fm.linearize(whole.model)) for whole in wholes(chain)]


# -- equilibrium ----------------------------------------------------------------------------------------------------


@pytest.mark.slow
@every_chain
def test_equilibrium_satisfies_its_constraints(chain):
    for whole, found in balanced(chain):
        # Coordinates up to 3; rounded products.
        np.testing.assert_allclose(whole.deformations(np.asarray(found.x)), found.e, atol=200 * EPS)
        # FIXED deformations and unit norms; Newton's last step of 1e-9 leaves its square.
        np.testing.assert_allclose(np.asarray(found.e)[np.asarray(whole.topology.e.fixed)], 0, atol=200 * EPS)
        fixed = np.asarray(whole.topology.x.fixed)
        np.testing.assert_array_equal(np.asarray(found.x)[fixed], whole.reference[fixed])
        free = np.setdiff1d(np.arange(whole.topology.n_e), np.asarray(whole.topology.e.fixed))
        # sigma = S e; the stiffness is up to 200.
        expected = whole.stiffness @ np.asarray(found.e)
        np.testing.assert_allclose(np.asarray(found.sigma)[free], expected[free], atol=200 * 200 * EPS)


@pytest.mark.slow("spatial")
@every_chain
def test_reactions_balance_the_loads(chain):
    for whole, found in balanced(chain):
        x, pushes = np.asarray(found.x), np.asarray(found.reactions) + whole.force
        size = whole.gravity.size
        total, turning = np.zeros(3), np.zeros(3)

        def act(force, at, size=size):
            nonlocal total, turning
            force, at = np.pad(force, (0, 3 - size)), np.pad(at, (0, 3 - size))
            total, turning = total + force, turning + np.cross(at, force)

        for node in dict.fromkeys(entry.of for entry in whole.labels.x):
            at = whole.labels.coordinates(node)
            if len(at) == size and whole.labels.x[at[0]].kind == "position":
                act(pushes[at], x[at])
            elif len(at) == 1:
                turning = turning + np.pad(pushes[at], (2, 0))
            else:
                # The dual of a moment M is 2 lbar^T M, and lbar lbar^T = I.
                turning = turning + np.asarray(lbar(x[at])) @ pushes[at] / 2
        for mass, centre in whole.masses(x):
            act(mass * whole.gravity, centre)
        # Forces out of balance: the last step, 1e-9 squared, and the round-off of x, times the stiffness of 200.
        np.testing.assert_allclose(total, 0, atol=1e-12)
        np.testing.assert_allclose(turning, 0, atol=1e-12)


@pytest.mark.slow("spatial")
@every_chain
def test_weight_is_mass_times_gravity(chain):
    for whole, at in balanced(chain):
        x = np.asarray(at.x)
        found = np.asarray(weight(whole.topology, whole.model.parameters, x, whole.gravity))
        total = sum(mass for mass, _ in whole.masses(x))
        by_axis = found[np.asarray(whole.topology.axes)].sum(axis=1)
        np.testing.assert_allclose(by_axis, total * whole.gravity, atol=20 * EPS)
        # And through the mass matrix: the force that accelerates the whole, and the energy of its translation.
        motion = np.zeros(x.size)
        motion[np.asarray(whole.topology.axes)] = whole.gravity[:, None]
        mass = np.asarray(mass_matrix(whole.topology, whole.model.parameters, x))
        np.testing.assert_allclose(mass @ motion, found, atol=20 * EPS)
        np.testing.assert_allclose(mass, mass.T, atol=20 * EPS)


# -- linearisation --------------------------------------------------------------------------------------------------


@pytest.mark.slow
@every_chain
def test_tangent_is_the_second_difference_of_the_potential(chain):
    """K0 + G0, DFx, DFe and the second transfer function, by differences over configurations solved for here."""
    whole, lin = linearised(chain)[0]
    x0, dof = np.asarray(lin.x), np.asarray(whole.topology.e.dof)
    q0, size = np.asarray(lin.e)[dof], dof.size
    step = 2e-4
    unit = step * np.eye(size)

    @functools.cache
    def at(i, a, j, b):
        x = whole.configuration(q0 + a * unit[i] + b * unit[j], x0)
        return whole.potential(x), x

    stiffness, second = np.zeros((size, size)), np.zeros((size, size, x0.size))
    first, slope = np.zeros((size, x0.size)), np.zeros(size)
    v0 = whole.potential(x0)
    for i in range(size):
        (v_p, x_p), (v_m, x_m) = at(i, 1, i, 0), at(i, -1, i, 0)
        slope[i], first[i] = (v_p - v_m) / (2 * step), (x_p - x_m) / (2 * step)
        stiffness[i, i], second[i, i] = (v_p - 2 * v0 + v_m) / step**2, (x_p - 2 * x0 + x_m) / step**2
        for j in range(i):
            pp, pm, mp, mm = (at(i, a, j, b) for a in (1, -1) for b in (1, -1))
            stiffness[i, j] = stiffness[j, i] = (pp[0] - pm[0] - mp[0] + mm[0]) / (4 * step**2)
            second[i, j] = second[j, i] = (pp[1] - pm[1] - mp[1] + mm[1]) / (4 * step**2)

    # Truncation step^2/12 times a fourth derivative of up to 100 k; round-off eps V/step^2 = 1e-8.
    found = np.asarray(lin.K0 + lin.G0)
    scale = np.sqrt(np.outer(np.diagonal(lin.K0), np.diagonal(lin.K0)))
    np.testing.assert_allclose(stiffness / scale, found / scale, rtol=0, atol=2e-6)
    assert np.max(np.abs(np.asarray(lin.G0)) / scale) > 1e-4  # or the geometric part would not be tested
    # An equilibrium: the slope of the potential vanishes but for round-off eps V/step and step^2 of a third one.
    np.testing.assert_allclose(slope / np.sqrt(np.diagonal(scale)), 0, atol=2e-6)
    # Configurations of size one; truncation step^2/6 times a third derivative of about 10; round-off eps/step^2.
    np.testing.assert_allclose(first.T, lin.DFx, rtol=0, atol=1e-6)
    d2x, d2e = fm.linear.second_transfer(lin)
    np.testing.assert_allclose(np.moveaxis(second, 2, 0), d2x, rtol=0, atol=1e-5)
    np.testing.assert_allclose(np.asarray(lin.DFe)[dof], np.eye(size), atol=200 * EPS)
    np.testing.assert_allclose(np.asarray(d2e)[whole.held], 0, atol=1e-11)


@pytest.mark.slow
@every_chain
def test_reduced_matrices_are_projections(chain):
    """M0 of the assembled mass matrix, K0 of the stiffness assembled member by member; D0 vanishes without damping."""
    for whole, lin in linearised(chain):
        mass = np.asarray(mass_matrix(whole.topology, whole.model.parameters, lin.x))
        dfx, dfe = np.asarray(lin.DFx), np.asarray(lin.DFe)
        np.testing.assert_allclose(lin.M0, dfx.T @ mass @ dfx, atol=1000 * EPS)
        np.testing.assert_allclose(lin.K0, dfe.T @ whole.stiffness @ dfe, atol=200 * 1000 * EPS)
        assert not np.any(np.asarray(element_damping(whole.topology, whole.model.parameters)))
        assert not np.any(np.asarray(lin.D0))
        assert not np.any(np.asarray(lin.N0))
        assert not np.any(np.asarray(lin.C0))
        assert np.linalg.eigvalsh(lin.M0)[0] > 0


# -- derivatives of the equilibrium ---------------------------------------------------------------------------------


def spatial_arm(n: Numbers) -> fm.Builder:
    """A spatial cantilever with an offset body: what the derivatives need of the spatial chain, in half the time."""
    b = fm.Builder()
    for name, place in {"A": (0.0, 0.0, 0.0), "B": (0.9, 0.2, -0.1), "D": (1.2, 0.6, 0.3)}.items():
        b.node(name, [p + s for p, s in zip(place, n.places[0] if name == "B" else np.zeros(3), strict=True)])
    b.add(spatial.beam, "A", "B", name="first", section=section(n.factors[0]))
    b.add(spatial.rigid_beam, "B", "D", name="arm", section=fm.Rigidity(mass=0.2))
    b.fix("A")
    b.force("D", n.force)
    # About a fixed axis: no potential, and a tangent that is not symmetric.
    b.moment("B", n.force * np.array([0.5, 0.5, -0.5]))
    b.gravity(n.gravity)
    b.dof("first", 1, 2, 3, 4, 5, 6)
    return b


@pytest.mark.slow
def test_derivatives_of_the_equilibrium():
    """By two forces, which scale a moment too, a rigidity and a node's position."""
    base = Numbers(np.zeros((3, 3)), [1.0, 1.2, 0.9, 1.1], np.zeros(3), np.array([0.1, -0.4, 0.2]))

    def configuration(theta):
        force = jnp.stack([theta[0], theta[1], 0.1 * theta[2]])
        places = jnp.zeros((3, 3)).at[0, 1].set(theta[3])
        n = dataclasses.replace(base, force=force, factors=[theta[2], *base.factors[1:]], places=places)
        return fm.equilibrium(spatial_arm(n).build(dofs="named")).x

    start, along = np.array([0.3, -0.4, 1.0, 0.02]), np.array([0.7, -0.3, 0.4, 0.5])
    weights = np.linspace(1, 2, configuration(start).size)

    @fm.jit
    def derivatives(theta):
        forward = jax.jvp(configuration, (theta,), (jnp.asarray(along),))[1]
        return forward, jax.grad(lambda t: weights @ configuration(t))(theta)

    forward, reverse = map(np.asarray, derivatives(start))
    step = EPS ** (1 / 3)

    def difference(direction):
        ends = [np.asarray(configuration(start + sign * step * direction)) for sign in (1, -1)]
        return (ends[0] - ends[1]) / (2 * step)

    # Truncation step^2 = 4e-11 times third derivatives below 100; round-off of x, 1e-15, over the step.
    np.testing.assert_allclose(difference(along), forward, rtol=0, atol=1e-8)
    by_each = [weights @ difference(direction) for direction in np.eye(4)]
    np.testing.assert_allclose(by_each, reverse, rtol=0, atol=1e-8 * np.sum(weights))
    # The two modes against each other: the tangent's condition number, below 1e4, times eps.
    assert reverse @ along == approx(weights @ forward, rel=1e-10)


@pytest.mark.slow
def test_a_builder_under_a_batched_derivative():
    """Numbers of which one is stacked and another is not, batched: as any jacfwd over a builder has them."""

    def reference(theta):
        b = spatial_arm(Numbers(np.zeros((3, 3)), [theta[1]], theta[0] * np.array([0.3, 0.2, 0.1]), np.ones(3)))
        return b.build(dofs="named").parameters.loads.force[-1]

    assert np.all(np.isfinite(jax.jacfwd(reference)(jnp.array([1.0, 2.0]))))


@pytest.mark.slow
def test_displacement_under_a_force_is_the_compliance_of_the_tangent():
    """dx/df = DFx (K0 + G0)^-1 DFx^T, with a moment about a fixed axis too, whose tangent is not symmetric."""
    n = Numbers(np.zeros((3, 3)), [1.0, 1.2, 0.9, 1.1], np.array([0.3, -0.4, 0.1]), np.array([0.1, -0.4, 0.2]))
    model = spatial_arm(n).build(dofs="named")
    lin = fm.linearize(model)
    at = model.labels.coordinates("D")
    dfx = np.asarray(lin.DFx)
    expected = dfx @ np.linalg.solve(np.asarray(lin.K), dfx[at].T)
    step, parameters = 1e-5, model.parameters
    difference = np.zeros_like(expected)
    for k in range(3):
        ends = []
        for sign in (1, -1):
            loads = dataclasses.replace(parameters.loads, force=parameters.loads.force.at[at[k]].add(sign * step))
            changed = dataclasses.replace(model, parameters=dataclasses.replace(parameters, loads=loads))
            ends.append(np.asarray(fm.equilibrium(changed).x))
        difference[:, k] = (ends[0] - ends[1]) / (2 * step)
    # Truncation step^2, round-off 1e-15/step.
    np.testing.assert_allclose(difference, expected, rtol=0, atol=1e-8)
    k = np.asarray(lin.K)
    assert np.max(np.abs(k - k.T)) > 1e-3  # the moment's part is there


# -- free bodies and other closed forms -----------------------------------------------------------------------------


def test_mass_matrix_of_a_free_planar_body():
    b = fm.Builder()
    b.node("P", (0.3, 0.4))
    b.node("Q", (1.3, 0.9))
    b.add(planar.rigid_beam, "P", "Q")
    b.mass("P", 2.0, inertia=0.7)
    b.mass("Q", 3.0)
    b.dof("P", "x", "y", "phi")
    lin = fm.linearize(b.build(dofs="named"))
    # v_Q = v_P + phi_dot (-0.5, 1).
    expected = [[5, 0, -1.5], [0, 5, 3], [-1.5, 3, 0.7 + 3 * 1.25]]
    np.testing.assert_allclose(lin.M0, expected, atol=20 * EPS)
    np.testing.assert_allclose(lin.K0, 0, atol=EPS)


def test_mass_matrix_of_a_free_spatial_body():
    b = fm.Builder()
    arm, tensor = np.array([1.0, 0.5, -0.3]), np.array([0.4, 0.1, -0.05, 0.5, 0.07, 0.6])
    b.node("P", (0.3, 0.4, 0.1))
    b.node("Q", np.array([0.3, 0.4, 0.1]) + arm)
    b.add(spatial.rigid_beam, "P", "Q")
    b.mass("P", 2.0, inertia=tensor)
    b.mass("Q", 3.0)
    b.dof("P", "x", "y", "z")
    b.dof("P.rotation", "l1", "l2", "l3")
    lin = fm.linearize(b.build(dofs="named"))
    j = np.zeros((3, 3))
    j[np.triu_indices(3)] = tensor
    j = j + np.triu(j, 1).T + 3 * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    cross = np.array([[0, -arm[2], arm[1]], [arm[2], 0, -arm[0]], [-arm[1], arm[0], 0]])
    # Unturned: omega = 2 (l1, l2, l3)_dot, v_Q = v_P - arm x omega.
    expected = np.block([[5 * np.eye(3), -2 * 3 * cross], [2 * 3 * cross, 4 * j]])
    np.testing.assert_allclose(lin.M0, expected, atol=100 * EPS)


def embedded(space: bool, force) -> fm.Model:
    """A bent cantilever of two beams, its plane that of x and y, with a tip mass."""
    room = spatial if space else planar
    b = fm.Builder()
    for name, place in {"A": (0.0, 0.0), "B": (1.0, 0.2), "C": (1.5, 1.1)}.items():
        b.node(name, (*place, 0.0) if space else place)
    # Local z in the plane, so that EIy bends in it.
    extra = {"y": (0.0, 0.0, 1.0)} if space else {}
    b.add(room.beam, "A", "B", name="1", section=section(1.0), **extra)
    b.add(room.beam, "B", "C", name="2", section=section(1.3), **extra)
    b.fix("A")
    if space:
        for node in ("B", "C"):
            b.fix(node, "z")
            b.fix(f"{node}.rotation", "l1", "l2")
    b.mass("C", 0.5, inertia=np.array([0.1, 0, 0, 0.1, 0, 0.2]) if space else 0.2)
    b.force("C", (*force, 0.0) if space else force)
    for element in ("1", "2"):
        b.dof(element, *((1, 3, 4) if space else (1, 2, 3)), kind="element")
    return b.build(dofs="named")


@pytest.mark.slow
def test_plane_in_space():
    flat, deep = (fm.linearize(embedded(space, (0.5, -0.4))) for space in (False, True))
    # Local z of the spatial beam is minus y of the planar one: its bendings have the other sign.
    sign = np.array([1.0, -1, -1, 1, -1, -1])
    for name, size in (("M0", 1), ("K0", 200), ("G0", 1)):
        expected = np.asarray(getattr(flat, name)) * np.outer(sign, sign)
        # Round-off, and the last Newton step; entries up to this size.
        np.testing.assert_allclose(getattr(deep, name), expected, rtol=0, atol=size * 1e-11, err_msg=name)
    np.testing.assert_allclose(fm.modes(deep).frequencies, fm.modes(flat).frequencies, rtol=1e-10)
    x = np.asarray(deep.x)
    for node in ("B", "C"):
        place = x[deep.labels.coordinates(node)]
        np.testing.assert_allclose(place[:2], np.asarray(flat.x)[flat.labels.coordinates(node)], atol=1e-13)
        turned = x[deep.labels.coordinates(f"{node}.rotation")]
        angle = np.asarray(flat.x)[flat.labels.coordinates(f"{node}.rotation")]
        np.testing.assert_allclose(turned, [np.cos(angle[0] / 2), 0, 0, np.sin(angle[0] / 2)], atol=1e-13)


def strained(kind: str) -> fm.Model:
    b = fm.Builder()
    b.node("A", (0.0, 0.0))
    b.node("B", (1.0, 0.0))
    b.add(planar.beam, "A", "B", name="beam", section=section(1.0))
    b.fix("A")
    b.dof("beam", 1, 2, 3)
    strain = np.array([0.01, 0.2, -0.1])
    if kind == "strain":
        b.strain("beam", *strain)
    else:
        ref = planar.beam.reference([np.zeros(2), np.zeros(1), np.array([1.0, 0]), np.zeros(1)])
        b.prestress("beam", *(-np.asarray(planar.beam.stiffness(ref=ref, section=section(1.0))) @ strain))
    return b.build(dofs="named")


@pytest.mark.slow
def test_free_strain_and_the_prestress_that_is_its_like():
    found = {kind: fm.equilibrium(strained(kind)) for kind in ("strain", "prestress")}
    for equilibrium in found.values():
        # Nothing holds it: it takes the strain and is free of stress, but for round-off times the stiffness of 100.
        np.testing.assert_allclose(equilibrium.e, [0.01, 0.2, -0.1], atol=100 * EPS)
        np.testing.assert_allclose(equilibrium.sigma, 0, atol=1e4 * EPS)
    np.testing.assert_allclose(found["strain"].x, found["prestress"].x, atol=100 * EPS)


@pytest.mark.slow
def test_prescribed_rotation_past_full_turns():
    """An unloaded beam on a spatial hinge is carried round, more than two turns."""
    angle = -14.0
    b = fm.Builder()
    b.node("A", (0.0, 0.0, 0.0))
    b.node("B", (1.0, 0.0, 0.0))
    b.rotation("A.rotation")
    b.rotation("A2")
    b.rotation("B.rotation")
    b.add(spatial.hinge, "A.rotation", "A2", name="hinge", axis=(0.0, 0.0, 1.0))
    b.add(spatial.beam, "A", "A2", "B", "B.rotation", name="beam", section=section(1.0))
    b.fix("A")
    b.prescribe("hinge", 1, angle)
    b.dof("beam", *range(1, 7))
    found = fm.equilibrium(b.build(dofs="named"))
    hinge = [i for i, entry in enumerate(found.labels.e) if entry.of == "hinge"]
    np.testing.assert_allclose(np.asarray(found.e)[hinge], [angle, 0, 0], atol=100 * EPS * 14)
    np.testing.assert_allclose(found.at("B"), [np.cos(angle), np.sin(angle), 0], atol=1e-12)
    np.testing.assert_allclose(found.sigma, 0, atol=1e-10)
