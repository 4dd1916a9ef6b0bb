"""When a video counts as watched, by the server's own clock."""

from collections.abc import Iterable
from dataclasses import dataclass

WATCHED = 0.98  # of a video's length; a player may stop a frame or two before the end


@dataclass(frozen=True)
class Play:
    """One playing of a video, as the server knows it.

    Attributes:
        started: when the report of its beginning came [s], by the server's clock.
        share: of the video's length that was watched, at most what the time since then allows.
    """

    started: float
    share: float


def credited(share: float, started: float, now: float, duration: float) -> float:
    """Return the share of a video that a report is believed: no more than could be played since it began.

    Args:
        share: as reported.
        started: of this play [s].
        now: by the same clock [s].
        duration: of the video [s].
    """
    return min(max(share, 0.0), max(now - started, 0.0) / duration, 1.0)


def is_open(plays: Iterable[Play], now: float, duration: float) -> bool:
    """Return whether a video may be answered: played to its end once, and that long after it was first begun."""
    known = list(plays)
    watched = any(play.share >= WATCHED for play in known)
    return watched and now - min(play.started for play in known) >= WATCHED * duration


def wait(share: float, started: float, now: float, duration: float) -> float:
    """Return how long [s] a report must wait to be believed enough; 0 if waiting does not help."""
    return max(started + WATCHED * duration - now, 0.0) if share >= WATCHED else 0.0
