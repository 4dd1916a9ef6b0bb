"""A mixed logistic model of right answers, with participants and videos as crossed random effects.

The Laplace approximation of the maximum likelihood, as in R's `lme4::glmer` with its default `nAGQ = 1` (D. Bates et
al., J. Statistical Software 67, 2015). Answers of participants and answers to videos may depend on each other, and
videos count as a sample of the videos that could have been made. Groups of participants, and conditions or factors of
videos, are fixed effects.

A Bayesian library such as bambi gives the same model with priors, but its dependencies are larger than all of ours and
sampling takes minutes; generalized estimating equations take only one kind of cluster, so they treat answers to one
video as independent. Tests compare this fit with lme4, and with equations of statsmodels where both say the same.
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
# Ours: log odds beyond which an effect has no estimate: some level has only hits, or none (separation).
_SEPARATED = 12.0


@dataclass(frozen=True)
class Effect:
    """A fixed effect, in log odds.

    Attributes:
        name: "(intercept)", or column and level, as in "gender: male"; the first level of a column is the reference.
        estimate: log odds, or a log odds ratio against the reference.
        error: its standard error; NaN where there is no estimate, since a level has only hits or none.
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


def model_of(
    responses: Responses, by: Sequence[str] = (), factors: Mapping[str, Mapping[str, str]] | None = None
) -> MixedModel:
    """Return the model of a study; participants who say nothing of a column of `by` are left out.

    Args:
        responses: the answers.
        by: groups of participants.
        factors: level of each video by its code, for each factor of the videos.

    Raises:
        ValueError: as `mixed_model`, and for a video without a level.
    """
    answers = responses.answers.merge(responses.participants[list(by)], left_on="participant", right_index=True)
    answers = answers[(answers[list(by)] != "").all(axis=1)]
    hits = (answers["signalled"] == answers["perceived"]).to_numpy()
    columns = {column: answers[column].tolist() for column in by}
    for name, levels in (factors or {}).items():
        if missing := sorted(set(answers["video"]) - set(levels)):
            raise ValueError(f"{name}: no level of video {missing[0]}; expected one for each video")
        columns[name] = [levels[video] for video in answers["video"]]
    return mixed_model(hits, answers["participant"].tolist(), answers["video"].tolist(), columns)


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
        ValueError: where all answers are right or all wrong, a column has one level, or the columns say the same.
    """
    if hits.all() or not hits.any():
        raise ValueError("all answers are right or all are wrong; a model needs both")
    names, fixed = _fixed(groups, len(hits))
    if np.linalg.matrix_rank(fixed) < len(names):
        raise ValueError(f"{', '.join(groups)}: one follows from the others; expected columns that vary apart")
    y, crossed = hits.astype(np.float64), _crossed(participants, videos)

    def deviance(parameters: Vector) -> float:
        return _laplace(y, fixed @ parameters[2:], crossed, parameters[:2])

    start = np.concatenate([[0.5, 0.5, np.log(y.mean() / (1 - y.mean()))], np.zeros(len(names) - 1)])
    bounds = [(0.0, 20.0)] * 2 + [(-30.0, 30.0)] * len(names)
    found = minimize(deviance, start, method="L-BFGS-B", bounds=bounds, options={"ftol": 1e-12, "gtol": 1e-6})
    errors = np.where(np.abs(found.x[2:]) < _SEPARATED, _errors(deviance, found.x)[2:], np.nan)
    return MixedModel(
        effects=tuple(map(_effect, names, found.x[2:].tolist(), errors.tolist())),
        participant_sd=float(found.x[0]),
        video_sd=float(found.x[1]),
        deviance=float(found.fun),
        answers=len(hits),
        participants=crossed.people,
        videos=crossed.shown,
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


@dataclass(frozen=True, eq=False)
class _Crossed:
    """Crossed random effects: the participant and the video (answers,) of each answer, and how many there are."""

    person: NDArray[np.int64]
    video: NDArray[np.int64]
    people: int
    shown: int

    def sums(self, values: Vector) -> tuple[Vector, Vector]:
        """Return sums of values (answers,) by participant and by video."""
        by_person, by_video = np.zeros(self.people), np.zeros(self.shown)
        np.add.at(by_person, self.person, values)
        np.add.at(by_video, self.video, values)
        return by_person, by_video

    def table(self, values: Vector) -> Vector:
        """Return sums of values (answers,) as (participants, videos)."""
        cells = np.zeros((self.people, self.shown))
        np.add.at(cells, (self.person, self.video), values)
        return cells


def _crossed(participants: Sequence[str], videos: Sequence[str]) -> _Crossed:
    people, person = np.unique(np.asarray(participants, dtype=str), return_inverse=True)
    shown, video = np.unique(np.asarray(videos, dtype=str), return_inverse=True)
    return _Crossed(person, video, len(people), len(shown))


def _laplace(y: Vector, offset: Vector, crossed: _Crossed, sd: Vector) -> float:
    """Return the deviance with standard normal random effects, times `sd` (participants, videos), integrated out."""
    a, b = np.zeros(crossed.people), np.zeros(crossed.shown)

    def eta(a: Vector, b: Vector) -> Vector:
        return offset + sd[0] * a[crossed.person] + sd[1] * b[crossed.video]

    def penalized(a: Vector, b: Vector) -> float:
        now = eta(a, b)
        return float(-2 * (y * log_expit(now) + (1 - y) * log_expit(-now)).sum() + a @ a + b @ b)

    value = penalized(a, b)
    for _ in range(100):
        step_a, step_b, _ = _newton(y, expit(eta(a, b)), a, b, crossed, sd)
        scale = 1.0
        for _ in range(_HALVINGS):
            now = penalized(a + scale * step_a, b + scale * step_b)
            if now <= value:
                break
            scale /= 2
        a, b, before, value = a + scale * step_a, b + scale * step_b, value, now
        if before - value < _CONVERGED:
            break
    return value + _newton(y, expit(eta(a, b)), a, b, crossed, sd)[2]


def _newton(
    y: Vector, mean: Vector, a: Vector, b: Vector, crossed: _Crossed, sd: Vector
) -> tuple[Vector, Vector, float]:
    """Return Newton's step of both kinds of effects, and the log determinant of the Hessian.

    The Hessian is diagonal for participants and for videos; only their table couples them, so that participants are
    eliminated first (Schur's complement).
    """
    weights = mean * (1 - mean)
    by_person, by_video = crossed.sums(weights)
    of_people, of_videos = sd[0] ** 2 * by_person + 1, np.diag(sd[1] ** 2 * by_video + 1)
    table = sd[0] * sd[1] * crossed.table(weights)
    left = table.T / of_people
    schur = of_videos - left @ table
    slopes_a, slopes_b = crossed.sums(y - mean)
    slopes_a, slopes_b = sd[0] * slopes_a - a, sd[1] * slopes_b - b
    step_b = np.linalg.solve(schur, slopes_b - left @ slopes_a)
    step_a = (slopes_a - table @ step_b) / of_people
    return step_a, step_b, float(np.log(of_people).sum() + np.linalg.slogdet(schur)[1])


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
