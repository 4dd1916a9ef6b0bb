"""A mixed logistic model of right answers, with participants and videos as crossed random effects.

The Laplace approximation of the maximum likelihood, as in R's `lme4::glmer` with its default `nAGQ = 1` (D. Bates et
al., J. Statistical Software 67, 2015). Answers of participants and answers to videos may depend on each other, and
videos count as a sample of the videos that could have been made.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import expit, log_expit, ndtr, ndtri

from emovid.responses.responses import Responses

Vector = NDArray[np.float64]

_STEP = 1e-4  # of numerical derivatives
_HALVINGS = 30
_CONVERGED = 1e-10


@dataclass(frozen=True)
class Effect:
    """A fixed effect, in log odds.

    Attributes:
        name: "(intercept)", or column and level, as in "gender: male"; the first level of a column is the reference.
        estimate: log odds, or a log odds ratio against the reference.
        error: its standard error; NaN where the data do not tell.
        p: two-sided, of Wald's z.
        odds_ratio, ci_low, ci_high: with its 95 % interval.
    """

    name: str
    estimate: float
    error: float
    p: float
    odds_ratio: float
    ci_low: float
    ci_high: float


@dataclass(frozen=True)
class MixedModel:
    """A fitted model.

    Attributes:
        effects: the fixed ones.
        participant_sd, video_sd: standard deviations of the random effects, in log odds.
        deviance: minus twice the log likelihood, by Laplace's approximation.
        answers, participants, videos: numbers of them.
        converged: whether the search ended at a minimum.
    """

    effects: tuple[Effect, ...]
    participant_sd: float
    video_sd: float
    deviance: float
    answers: int
    participants: int
    videos: int
    converged: bool


def model_of(responses: Responses, by: Sequence[str]) -> MixedModel:
    """Return the model of a study; participants without a value in a column of `by` are excluded.

    Raises:
        ValueError: as `mixed_model`.
    """
    answers = responses.answers.merge(responses.participants[list(by)], left_on="participant", right_index=True)
    answers = answers[(answers[list(by)] != "").all(axis=1)]
    hits = (answers["signalled"] == answers["perceived"]).to_numpy()
    groups = {column: answers[column].tolist() for column in by}
    return mixed_model(hits, answers["participant"].tolist(), answers["video"].tolist(), groups)


def mixed_model(
    hits: NDArray[np.bool_], participants: Sequence[str], videos: Sequence[str], groups: Mapping[str, Sequence[str]]
) -> MixedModel:
    """Return the model of the hits of single answers.

    Args:
        hits: (answers,) whether each is right.
        participants: of each answer.
        videos: of each answer.
        groups: levels of each column, for each answer.

    Raises:
        ValueError: where all answers are right or all wrong, or a column has one level.
    """
    if hits.all() or not hits.any():
        raise ValueError("all answers are right or all are wrong; a model needs both")
    names, fixed = _fixed(groups, len(hits))
    people, shown = _indicators(participants), _indicators(videos)
    y = hits.astype(np.float64)

    def deviance(parameters: Vector) -> float:
        sd, beta = parameters[:2], parameters[2:]
        return _laplace(y, fixed @ beta, np.hstack([sd[0] * people, sd[1] * shown]))

    start = np.concatenate([[0.5, 0.5, np.log(y.mean() / (1 - y.mean()))], np.zeros(len(names) - 1)])
    bounds = [(0.0, 20.0)] * 2 + [(-30.0, 30.0)] * len(names)
    found = minimize(deviance, start, method="L-BFGS-B", bounds=bounds, options={"ftol": 1e-12, "gtol": 1e-6})
    errors = _errors(deviance, found.x)[2:]
    return MixedModel(
        effects=tuple(map(_effect, names, found.x[2:].tolist(), errors.tolist())),
        participant_sd=float(found.x[0]),
        video_sd=float(found.x[1]),
        deviance=float(found.fun),
        answers=len(hits),
        participants=people.shape[1],
        videos=shown.shape[1],
        converged=bool(found.success),
    )


def _fixed(groups: Mapping[str, Sequence[str]], answers: int) -> tuple[list[str], Vector]:
    """Return the names and the columns (answers, effects) of the fixed effects."""
    names, columns = ["(intercept)"], [np.ones(answers)]
    for column, levels in groups.items():
        known = sorted(set(levels))
        if len(known) < 2:
            raise ValueError(f"{column}: one level, {known[0]}; a model compares two or more")
        names += [f"{column}: {level}" for level in known[1:]]
        columns += [np.array([mine == level for mine in levels], dtype=np.float64) for level in known[1:]]
    return names, np.array(columns).T


def _indicators(names: Sequence[str]) -> Vector:
    known, places = np.unique(np.asarray(names, dtype=str), return_inverse=True)
    return np.eye(len(known))[places]


def _laplace(y: Vector, offset: Vector, design: Vector) -> float:
    """Return the deviance with random effects (design columns times standard normal ones) integrated out."""
    u = np.zeros(design.shape[1])

    def penalized(effects: Vector) -> float:
        eta = offset + design @ effects
        return float(-2 * (y * log_expit(eta) + (1 - y) * log_expit(-eta)).sum() + effects @ effects)

    value = penalized(u)
    hessian = np.eye(len(u))
    for _ in range(100):
        mean = expit(offset + design @ u)
        hessian = design.T @ (design * (mean * (1 - mean))[:, None]) + np.eye(len(u))
        step = np.linalg.solve(hessian, design.T @ (y - mean) - u)
        scale = 1.0
        for _ in range(_HALVINGS):
            now = penalized(u + scale * step)
            if now <= value:
                break
            scale /= 2
        u, before, value = u + scale * step, value, now
        if before - value < _CONVERGED:
            break
    mean = expit(offset + design @ u)
    hessian = design.T @ (design * (mean * (1 - mean))[:, None]) + np.eye(len(u))
    return value + float(np.linalg.slogdet(hessian)[1])


def _errors(deviance: Callable[[Vector], float], at: Vector) -> Vector:
    """Return standard errors from the numerical Hessian; NaN for a random effect at 0, which has none."""
    free = np.flatnonzero((np.arange(len(at)) > 1) | (at > 10 * _STEP))
    steps = _STEP * np.eye(len(at))[free]
    hessian = np.array(
        [
            [deviance(at + a + b) - deviance(at + a - b) - deviance(at - a + b) + deviance(at - a - b) for b in steps]
            for a in steps
        ]
    ) / (4 * _STEP**2)
    errors = np.full(len(at), np.nan)
    with np.errstate(invalid="ignore"):
        errors[free] = np.sqrt(np.diag(2 * np.linalg.pinv(hessian)))
    return errors


def _effect(name: str, estimate: float, error: float) -> Effect:
    p = float(2 * ndtr(-abs(estimate / error))) if error > 0 else float("nan")
    half = float(ndtri(0.975)) * error
    low, middle, high = (
        float(np.exp(np.clip(value, -700, 700))) for value in (estimate - half, estimate, estimate + half)
    )
    return Effect(name, estimate, error, p, middle, low, high)
