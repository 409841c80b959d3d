"""Posterior distribution of fitted parameters, by the sampler NUTS of numpyro."""

import dataclasses
import importlib
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_number, check_whole
from ..design.designs import Designs
from ..design.evaluate import Answers, flat_function, named_answers
from ..design.sweep import sweep
from ..design.swept import Sweep
from ..display import Result, Summary
from ..errors import printable, warn
from ..numerical_limits import FEW_DRAWS, NOT_MIXED
from .problem import GOOD, FitProblem, prediction_of

# Largest number of parameters for forward differentiation, which compiles faster.
FORWARD = 6
# Least distance of a start from a bound, as a share of the distance of the bounds.
ASIDE = 0.01


@dataclasses.dataclass(frozen=True, repr=False)
class Posterior(Result):
    """Samples of the posterior distribution of parameters.

    Attributes:
        parameters: Samples by name, all chains one after the other, (samples, ...) [SI].
        labels: Names of all parameters, "height[3]" for an entry of an array.
        mixing: Split R-hat by label: 1 if all chains have the same distribution [-].
        draws: Effective number of independent samples by label [-].
        divergences: Number of samples at which the sampler failed.
        problem: The least-squares problem.
    """

    parameters: dict[str, np.ndarray]
    labels: tuple[str, ...]
    mixing: dict[str, float]
    draws: dict[str, float]
    divergences: int
    problem: FitProblem

    @property
    def rows(self) -> np.ndarray:
        """Samples of all parameters in the order of ``labels``, (samples, n) [SI]."""
        return np.concatenate([v.reshape(len(v), -1) for v in self.parameters.values()], axis=1)

    def interval(self, name: str, level: float = 0.95) -> tuple[float, float]:
        """Return the credible interval of a parameter, with equal probabilities beyond both ends [SI].

        Args:
            name: Name of a parameter; "height[3]" for an entry of an array.
            level: Probability of the interval [-].

        Raises:
            KeyError: No such parameter.
            ValueError: The level is not between 0 and 1.
        """
        check_number("level", level, above=0, most=1)
        if name not in self.labels:
            raise KeyError(f"There is no parameter '{printable(name)}': parameters are {', '.join(self.labels)}.")
        column = self.rows[:, self.labels.index(name)]
        lower, upper = np.quantile(column, [(1 - level) / 2, (1 + level) / 2])
        return float(lower), float(upper)

    def predict(self, answers: Answers, *, samples: int = 200) -> Sweep:
        """Compute answers of mechanisms with sampled parameters.

        Args:
            answers: Functions of the model, or questions such as "frequency 4".
            samples: Number of samples, evenly spaced over all samples.

        Returns:
            Sweep over the samples.
        """
        count = len(self.rows)
        rows = np.unique(np.linspace(0, count - 1, min(check_whole("samples", samples, 1), count)).astype(int))
        problem = self.problem

        def build(**parameters: Any) -> Any:
            return problem.build(**parameters)[0]

        return sweep(build, named_answers(answers), Designs({n: v[rows] for n, v in self.parameters.items()}))

    def summary(self) -> Summary:
        """Return mean and credible interval of each parameter."""
        rows = {}
        for i, name in enumerate(self.labels):
            lower, upper = self.interval(name)
            mean = float(np.mean(self.rows[:, i]))
            rows[name] = f"{mean:.6g}, 95 % within {lower:.6g} to {upper:.6g}, {self.draws[name]:.0f} independent"
        return Summary(f"Posterior, {len(self.rows)} samples", rows)


def sampled_posterior(fit: Any, count: int, warmup: int, chains: int, seed: int) -> Posterior:
    """Sample the posterior, starting at the parameters of a :class:`flexmb.identification.Fit`.

    The coordinates of the sampler are whitened logits of the scaled parameters, which have no bounds.
    """
    mcmc, diagnostics = _numpyro()
    problem: FitProblem = fit.problem
    slopes = problem.residuals(fit.unit)[1] / (fit.noise or 1.0)
    at = np.clip(fit.unit, ASIDE, 1 - ASIDE)
    logit, change = np.log(at / (1 - at)), at * (1 - at)
    # The logit of a uniform random number has the variance pi^2/3.
    precision = (slopes * change).T @ (slopes * change) + 3 / np.pi**2 * np.eye(len(at))
    root: Any = np.linalg.inv(np.linalg.cholesky(precision)).T
    log_density = _log_density(problem, known=bool(np.isfinite(fit.chi_squared)))

    def potential(white: Any):
        return -log_density(logit + root @ white)

    kernel = mcmc.NUTS(potential_fn=potential, forward_mode_differentiation=len(at) <= FORWARD)
    run = mcmc.MCMC(
        kernel, num_warmup=warmup, num_samples=count, num_chains=chains, chain_method="sequential", progress_bar=False
    )
    first = np.zeros(len(at)) if chains == 1 else np.zeros((chains, len(at)))
    # numpyro mixes types of numbers. A user's setting may forbid this.
    with jax.numpy_dtype_promotion("standard"):
        run.run(jax.random.PRNGKey(seed), init_params=jnp.asarray(first), extra_fields=("diverging",))
    white = np.asarray(run.get_samples(group_by_chain=True))
    units = 1 / (1 + np.exp(-(logit + white @ root.T)))
    flat = np.asarray(problem.scaling.to_dimensions(units))
    labels = tuple(problem.layout.labels)
    posterior = Posterior(
        problem.layout.stacked(flat.reshape(-1, len(at))),
        labels,
        dict(zip(labels, np.asarray(diagnostics.split_gelman_rubin(flat)).tolist(), strict=True)),
        dict(zip(labels, np.asarray(diagnostics.effective_sample_size(flat)).tolist(), strict=True)),
        int(np.sum(np.asarray(run.get_extra_fields()["diverging"]))),
        problem,
    )
    _tell(posterior)
    return posterior


def _numpyro() -> tuple[Any, Any]:
    try:
        return importlib.import_module("numpyro.infer"), importlib.import_module("numpyro.diagnostics")
    except ImportError:
        raise ImportError("Sampling needs numpyro: pip install 'flexmb[bayes]'.") from None


def _log_density(problem: FitProblem, *, known: bool) -> Callable[[Float[Array, "n"]], Float[Array, ""]]:
    """Return the logarithm of the posterior density as a function of the logits of the scaled parameters."""
    answers = {item.name: prediction_of(item) for item in problem.items}
    function, _ = flat_function(problem.build, answers, problem.layout, problem.models)
    measured, scaling = jnp.asarray(problem.measured), problem.scaling

    def log_density(logit: Float[Array, "n"]):
        unit = jax.nn.sigmoid(logit)
        values, code = function(scaling.to_dimensions(unit))
        square = jnp.sum(problem.weighted(values - measured) ** 2)
        total = -square / 2 if known else -len(problem.measured) / 2 * jnp.log(square)
        # Density of the logit of a scaled parameter that is uniform between its bounds. A prior multiplies it below.
        total += jnp.sum(jax.nn.log_sigmoid(logit) + jax.nn.log_sigmoid(-logit))
        flat = scaling.to_dimensions(unit)
        for i, prior in problem.priors.items():
            total -= ((flat[i] - prior.mean) / prior.deviation) ** 2 / 2
            if scaling.log[i]:
                total += jnp.log(flat[i])
        # Mechanisms without an answer are impossible.
        good = jnp.any(code == jnp.array([int(result) for result in GOOD]))
        return jnp.where(good, total, -jnp.inf)

    return log_density


def _tell(found: Posterior) -> None:
    """Warn of samples that do not represent the posterior."""
    if found.divergences:
        warn(
            f"The sampler failed at {found.divergences} of {len(found.rows)} samples, which may leave out a part of the"
            " posterior. Narrow the bounds, or add a prior."
        )
    bad = [n for n in found.labels if not (found.mixing[n] <= NOT_MIXED and found.draws[n] >= FEW_DRAWS)]
    if bad:
        names = ", ".join(f"'{n}' (R-hat {found.mixing[n]:.3g}, {found.draws[n]:.0f} independent)" for n in bad)
        warn(f"The samples do not yet represent the posterior of {names}. Draw more, or add a prior.")
