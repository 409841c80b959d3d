"""The results of a SPACAR Light run, with the names of SPACAR Light, from the linearisation at every load step."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import jax.numpy as jnp
import numpy as np

from .. import __version__
from ..build.builder import Builder
from ..display import Result, Summary, counted, span
from ..linear.buckling import multipliers_about
from ..linear.compliance import compliance
from ..linear.linearize import Linearization
from ..linear.modes import modes
from ..linear.spectrum import general_spectrum, to_frequency
from ..linear.stress import Stress, has_stress, stress
from ..math.rotation import initial_frame, rotation_matrix
from ..model.model import Model
from ..numerical_limits import LARGEST_MULTIPLIER
from .light_fields import Script, field_value
from .light_model import Releases, beam_names, node_name

if TYPE_CHECKING:
    import control


class LightResults(Result):
    """Results of :func:`spacar_light`. In arrays over the load steps, the last axis counts the steps.

    Attributes:
        version: Version of flexmb.
        model: Mechanism, for derivatives and for other functions of flexmb such as ``path``.
        builder: Builder of the mechanism. Node 3 is "n3"; the beams of element 2 are "e2.1", "e2.2" and so on.
        ndof: Number of degrees of freedom.
        load_factors: Factors of the initial and of the incremental loads, (2, steps) [-].
        linearizations: Linearised equations of motion at every step.
        freq: Natural frequencies, negative if a motion grows, infinite for a motion without mass, (ndof, steps) [Hz].
        buck: Multipliers of the total load at each step, sorted by magnitude, with sign, infinite if no load acts,
            (ndof, steps) [-]; None without ``calcbuck``.
        stressmax: Largest von Mises stress, (steps,) [Pa]; None without flexible elements.
        statespace: State-space model about the last step; None without ``transfer``.
        overconstraints: Released deformations of the last beam of each element, in the form of ``opt.rls``.
        warnings: Unusual inputs, and inputs without effect.
    """

    def __init__(
        self,
        script: Script,
        builder: Builder,
        model: Model,
        releases: Releases,
        load_factors: Sequence[tuple[float, float]],
        linearizations: Sequence[Linearization],
    ):
        self.version = __version__
        self.script, self.builder, self.model = script, builder, model
        self.ndof = model.topology.n_q
        self.overconstraints = dict(releases)
        self.warnings = script.warnings
        self.load_factors = np.reshape(np.asarray(load_factors, float), (-1, 2)).T
        self.linearizations: Sequence[Linearization] = linearizations
        self.statespace: control.StateSpace | None = None
        self._spectra = [light_spectrum(lin) for lin in linearizations]
        self.freq = _columns([hertz for hertz, _ in self._spectra], self.ndof)
        self._stresses = _stresses(linearizations)
        self.stressmax = None
        if self._stresses is not None:
            self.stressmax = np.array([float(results.maximum) for results in self._stresses])
        self.buck = None
        if script.opt.get("calcbuck"):
            results = [
                multipliers_about(lin.model.topology, lin.model.parameters, lin.matrices) for lin in linearizations
            ]
            self.buck = _columns(results, self.ndof)
            self.buck[np.abs(self.buck) > LARGEST_MULTIPLIER] = np.inf

    def summary(self) -> Summary:
        """Return extremes over the load steps."""
        rows = {"frequencies": span(self.freq, "Hz")}
        if self.buck is not None:
            rows["load multipliers"] = span(self.buck)
        if self.stressmax is not None:
            rows["largest stress"] = span(self.stressmax, "Pa")
        rows |= {"released": str(self.overconstraints or "nothing"), "warnings": str(len(self.warnings))}
        return Summary(f"LightResults of {counted(len(self.linearizations), 'load step')}, ndof {self.ndof}", rows)

    def node(self, number: int) -> "LightNode":
        """Return results of a node at all steps.

        Args:
            number: Number of the node, from 1.
        """
        return LightNode(self, number, None)

    def element(self, number: int) -> "LightElement":
        """Return results of an element at all steps.

        Args:
            number: Number of the element, from 1.
        """
        return LightElement(self, number, None)

    def step(self, number: int) -> "LightStep":
        """Return results of one load step.

        Args:
            number: Number of the step, from 1.
        """
        return LightStep(self, number)

    def values(self, name: str) -> np.ndarray:
        """Return one of the arrays of all linearisations.

        Args:
            name: Name such as "x", "e", "sigma" or "reactions".

        Returns:
            (steps, n) [SI].
        """
        return np.stack([np.asarray(getattr(lin.matrices, name)) for lin in self.linearizations])


def _columns(vectors: Sequence, size: int) -> np.ndarray:
    """Vectors as columns, (size, n)."""
    return np.reshape(np.array([np.asarray(v) for v in vectors]), (len(vectors), size)).T


def _stresses(linearizations: Sequence[Linearization]) -> list[Stress] | None:
    """Stress at every step; None if no flexible element has a section with a shape."""
    if not linearizations:
        return None
    model = linearizations[0].model
    return [stress(lin.model, at=lin) for lin in linearizations] if has_stress(model) else None


def light_spectrum(lin: Linearization) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies and mode shapes, also if moments make the stiffness unsymmetric.

    Frequencies have the sign of the eigenvalue's real part, infinite without mass, (ndof,) [Hz]. Shapes in the degrees
    of freedom, (ndof, ndof), are zero without mass.
    """
    n = lin.matrices.M0.shape[0]
    hertz, shapes = np.full(n, np.inf), np.zeros((n, n))
    if lin.matrices.symmetric:
        eigenmodes = modes(lin)
        values, vectors = np.asarray(eigenmodes.frequencies), np.asarray(eigenmodes.q_shapes)
    else:
        mass = np.asarray(lin.matrices.M0)
        eigenvalues, vectors = general_spectrum(np.asarray(lin.matrices.K), mass)
        values = to_frequency(eigenvalues.real[np.isfinite(eigenvalues)])
        vectors = np.real(vectors[:, : len(values)])
        mass = np.einsum("iv,ij,jv->v", vectors, mass, vectors)
        vectors = vectors / np.sqrt(np.where(mass > 0, mass, 1.0))
    hertz[: len(values)], shapes[:, : len(values)] = values, vectors
    return hertz, shapes


class _Numbered:
    """A node or an element, at one step or at all steps."""

    def __init__(self, light: LightResults, number: int, step: int | None):
        count = len(light.script.nodes) if isinstance(self, LightNode) else len(light.script.elements)
        if not 1 <= number <= count:
            kind = type(self).__name__[5:]
            raise IndexError(f"{kind} {number} does not exist. {kind}s are numbered from 1 to {count}.")
        self._light, self.number, self._step = light, number, step

    def _at(self, every: np.ndarray) -> np.ndarray:
        """Steps on the last axis, or one step."""
        return np.moveaxis(every, 0, -1) if self._step is None else every[self._step]


class LightNode(_Numbered):
    """Results of a node; arrays of one step have no last axis."""

    @property
    def name(self) -> str:
        """Name in the Builder."""
        return node_name(self.number)

    def _values(self, quantity: str, part: str) -> np.ndarray:
        return self._light.values(quantity)[:, self._light.model.labels.known(part)]

    @property
    def p(self) -> np.ndarray:
        """Position, (3, steps) [m]."""
        return self._at(self._values("x", self.name))

    @property
    def r_quat(self) -> np.ndarray:
        """Euler parameters, the scalar first, (4, steps) [-]."""
        return self._at(self._values("x", f"{self.name}.rotation"))

    @property
    def r_axang(self) -> np.ndarray:
        """Rotation as an angle up to a full turn and its axis, (4, steps) [rad, -]; axis x for zero rotation."""
        lam = self._values("x", f"{self.name}.rotation")
        size = np.linalg.norm(lam[:, 1:], axis=1)
        axes = np.where(size[:, None] > 0, lam[:, 1:] / np.where(size > 0, size, 1.0)[:, None], np.eye(3)[0])
        return self._at(np.concatenate([2 * np.arctan2(size, lam[:, 0])[:, None], axes], axis=1))

    @property
    def r_eulzyx(self) -> np.ndarray:
        """Rotations about z, the turned y and the turned x, one after the other, (3, steps) [rad]."""
        r = np.stack([np.asarray(rotation_matrix(jnp.asarray(q))) for q in self._values("x", f"{self.name}.rotation")])
        about_y = np.arcsin(np.clip(-r[:, 2, 0], -1, 1))
        angles = [np.arctan2(r[:, 1, 0], r[:, 0, 0]), about_y, np.arctan2(r[:, 2, 1], r[:, 2, 2])]
        return self._at(np.stack(angles, axis=1))

    @property
    def Freac(self) -> np.ndarray:
        """Force of the support on the node, zero if it is free, (3, steps) [N]."""
        return self._at(self._values("reactions", self.name))

    @property
    def Mreac(self) -> np.ndarray:
        """Moment of the support on the node about global axes, zero if it is free, (3, steps) [N m]."""
        # The moment of a prescribed rotation acts on the frame of its hinge. Neither this frame nor a FIXED rotation
        # ever turns: the forces dual to its Euler parameters are (0, 2 M).
        parts = [f"{self.name}.rotation", f"frame of {self.name}"]
        existing = [part for part in parts if self._light.model.labels.coordinates(part)]
        return self._at(np.sum([self._values("reactions", part)[:, 1:] for part in existing], axis=0) / 2)

    @property
    def CMglob(self) -> np.ndarray | None:
        """Compliance, displacements and rotations by forces and moments, (6, 6, steps); None without calccompl."""
        return self._compliance(False)

    @property
    def CMloc(self) -> np.ndarray | None:
        """Compliance in axes that turn with the node, (6, 6, steps); None without calccompl."""
        return self._compliance(True)

    def _compliance(self, local: bool) -> np.ndarray | None:
        if not field_value(self._light.script.opt, "opt", "calccompl"):
            return None
        lins = self._light.linearizations if self._step is None else [self._light.linearizations[self._step]]
        compliances = [np.asarray(compliance(lin, self.name, local=local)) for lin in lins]
        return compliances[0] if self._step is not None else np.stack(compliances, axis=-1)


class LightElement(_Numbered):
    """Results of an element; arrays of one step have no last axis."""

    @property
    def names(self) -> list[str]:
        """Names of its beams, or of its hinge, in the Builder."""
        return beam_names(self._light.script, self.number)

    @property
    def L0(self) -> float:
        """Undeformed length, () [m]."""
        p, q = self._ends()
        return float(np.linalg.norm(q - p))

    @property
    def Ri(self) -> np.ndarray:
        """Local axes in the undeformed mechanism as columns, the first along the beam or hinge, (3, 3) [-]."""
        properties = self._light.builder.members[self.names[0]].properties
        (p, q), across = self._ends(), properties.get("y")
        if "axis" in properties:
            p, q = np.zeros(3), np.asarray(properties["axis"])
        across = None if across is None else jnp.asarray(across)
        return np.asarray(initial_frame(jnp.asarray(p), jnp.asarray(q), across))

    def _ends(self) -> tuple[np.ndarray, np.ndarray]:
        p, q = self._light.script.ends(self.number)
        return np.asarray(self._light.script.nodes[p - 1]), np.asarray(self._light.script.nodes[q - 1])

    @property
    def e(self) -> np.ndarray:
        """Deformations, one row per beam, (beams, 6, steps) [m]; for a hinge (1, 3, steps) [rad]."""
        entries, every = self._light.model.labels.e, self._light.values("e")
        # Warping deformations are left out.
        rows = [[i for i, entry in enumerate(entries) if entry.of == name][:6] for name in self.names]
        return self._at(every[:, np.array(rows)])

    @property
    def stressmax(self) -> np.ndarray | None:
        """Largest von Mises stress in its beams, (steps,) [Pa]; None if the script has no flexible element."""
        every = self._light._stresses
        if every is None:
            return None
        rows = [i for i, name in enumerate(every[0].names) if name in self.names]
        largest = [np.max(np.asarray(step.by_element)[rows], initial=0.0) for step in every]
        return self._at(np.array(largest))


class LightStep:
    """Results of one load step, with its linearisation ``lin``."""

    def __init__(self, light: LightResults, number: int):
        if not 1 <= number <= len(light.linearizations):
            count = len(light.linearizations)
            raise IndexError(f"Step {number} does not exist. Steps are numbered from 1 to {count}.")
        self._light, self.number = light, number
        self.lin = light.linearizations[number - 1]

    def node(self, number: int) -> LightNode:
        """Results of a node, by its number from 1, at this step."""
        return LightNode(self._light, number, self.number - 1)

    def element(self, number: int) -> LightElement:
        """Results of an element, by its number from 1, at this step."""
        return LightElement(self._light, number, self.number - 1)

    @property
    def freq(self) -> np.ndarray:
        """Natural frequencies, (ndof,) [Hz]."""
        return self._light.freq[:, self.number - 1]

    @property
    def freqmodes(self) -> np.ndarray:
        """Mass-normalised mode shapes in the degrees of freedom, one per column, (ndof, ndof)."""
        return self._light._spectra[self.number - 1][1]

    @property
    def buck(self) -> np.ndarray | None:
        """Load multipliers, (ndof,) [-]."""
        return None if self._light.buck is None else self._light.buck[:, self.number - 1]

    @property
    def stressmax(self) -> float | None:
        """Largest von Mises stress, () [Pa]."""
        return None if self._light.stressmax is None else float(self._light.stressmax[self.number - 1])
