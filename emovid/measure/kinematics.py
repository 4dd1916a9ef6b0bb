"""Speed of the robots, and smoothness of their speed profiles.

Speed is exact: a command holds its v from one sample to the next. Smoothness is that of positions sampled at 30 Hz:
S. Balasubramanian, A. Melendez-Calderon, A. Roby-Brami and E. Burdet, "On the analysis of movement smoothness",
J. NeuroEng. Rehabil. 12:112, 2015. The larger value is the smoother. Both measures were made for single movements from
rest to rest. Here the window cuts the profile, with two limits: constant speed over the whole window has a SPARC of
about -2.4, because of the cut ends alone; and the dimensionless jerk grows with the cube of the window's length, so
that only windows of one length compare. Held commands make speed jump, so jerk has a value at a fixed rate only.
"""

import numpy as np

from emovid.measure.trace import path, visible_steps
from emovid.measure.window import Descriptor, Window
from emovid.swarm.arrays import Array

_SPEEDS = {
    "mean": "linear speed, mean over robots and time",
    "p95": "the linear speed that is not exceeded in 95 % of the robots' time",
    "peak": "largest linear speed of any robot",
}

SPEED = (
    *(Descriptor(f"speed_{kind}", "m/s", definition) for kind, definition in _SPEEDS.items()),
    *(
        Descriptor(f"speed_{kind}_diagonals", "diagonals/s", f"speed_{kind} over the stage's diagonal")
        for kind in _SPEEDS
    ),
    Descriptor("distance_travelled", "m", "length of a robot's path with all its detail; mean over robots"),
)

_RATE = 30.0  # Hz; of the positions, for any frame rate of the video: three times SPARC's cut-off
_PADDING = 4  # zeros up to 2^4 times the length: one of SPARC's published defaults, as are the next two
_CUT_OFF = 10.0  # Hz
_THRESHOLD = 0.05  # of the spectrum's largest amplitude

_SAMPLED = "from positions sampled at 30 Hz; median over the robots that move"

SMOOTHNESS = (
    Descriptor(
        "sparc",
        "1",
        "spectral arc length: minus the length of the speed profile's amplitude spectrum, its height and width both 1, "
        f"up to 10 Hz or where it stays below 0.05; {_SAMPLED}",
        "Balasubramanian et al. 2015",
    ),
    Descriptor(
        "log_dimensionless_jerk",
        "1",
        "-ln(T^3 / v_peak^2 times the integral of (d^2 v / dt^2)^2 dt), T the window's length; infinite for constant "
        f"speed; {_SAMPLED}",
        "Balasubramanian et al. 2015",
    ),
)


def speed(window: Window) -> dict[str, float]:
    """Return the descriptors of speed."""
    if window.is_recorded:  # noise would lengthen the path: dividers walk along it, and peaks are unknown
        walks = [visible_steps(path(window, i), window.step) for i in range(window.trajectory.poses.shape[1])]
        distance = window.step * sum(len(walk) - 1 for walk in walks) / len(walks)
        return _speeds(window, (distance / window.length, float("nan"), float("nan")), distance)
    seconds = window.seconds
    held = seconds > 0
    v, seconds = np.abs(window.trajectory.commands[held, :, 0]), seconds[held]
    weights = np.broadcast_to((seconds / seconds.sum())[:, None], v.shape) / v.shape[1]
    values = (float(np.sum(v * weights)), quantile(v.ravel(), weights.ravel(), 0.95), float(v.max()))
    return _speeds(window, values, float((seconds[:, None] * v).sum(axis=0).mean()))


def _speeds(window: Window, values: tuple[float, float, float], distance: float) -> dict[str, float]:
    return {
        **{f"speed_{kind}": value for kind, value in zip(_SPEEDS, values, strict=True)},
        **{
            f"speed_{kind}_diagonals": value / window.stage.diagonal
            for kind, value in zip(_SPEEDS, values, strict=True)
        },
        "distance_travelled": distance,
    }


def quantile(values: Array, weights: Array, share: float) -> float:
    """Return the smallest of the values (M,) that at least a `share` of the weights (M,) does not exceed."""
    order = np.argsort(values)
    reached = np.cumsum(weights[order])
    # Rounding can leave a sum of equal weights just below the share that it should meet.
    return float(values[order[np.searchsorted(reached, share * reached[-1] * (1 - 1e-12))]])


def smoothness(window: Window) -> dict[str, float]:
    """Return the descriptors of smoothness; NaN if no robot moves."""
    if window.is_recorded and np.diff(window.trajectory.t).max() > 1.01 / _RATE:  # sampled too rarely
        return {descriptor.name: float("nan") for descriptor in SMOOTHNESS}
    times = window.start + np.arange(int(window.length * _RATE + 1e-9) + 1) / _RATE
    along = np.diff(window.points(np.minimum(times, window.end)), axis=0)
    profiles = (np.hypot(along[..., 0], along[..., 1]) * _RATE).T
    moving = [profile for profile in profiles if len(profile) > 2 and profile.max() > window.still]
    return {
        "sparc": _median([sparc(profile, _RATE) for profile in moving]),
        "log_dimensionless_jerk": _median([log_dimensionless_jerk(profile) for profile in moving]),
    }


def sparc(speed: Array, rate: float) -> float:
    """Return the spectral arc length of a speed profile (F,) sampled at `rate` [Hz]."""
    padded = 2 ** (int(np.ceil(np.log2(len(speed)))) + _PADDING)
    amplitude = np.abs(np.fft.rfft(speed, padded))[: int(_CUT_OFF * padded / rate) + 1]
    amplitude /= amplitude.max()
    band = amplitude[: np.flatnonzero(amplitude >= _THRESHOLD)[-1] + 1]
    return -float(np.sum(np.hypot(1 / (len(band) - 1), np.diff(band))))


def log_dimensionless_jerk(speed: Array) -> float:
    """Return minus the logarithm of the dimensionless jerk of a speed profile (F,); its rate cancels."""
    bend = np.diff(speed, n=2) / speed.max()
    bend[np.abs(bend) < 1e-9] = 0.0  # rounding of positions
    jerk = len(speed) ** 3 * np.sum(bend**2)  # (F / rate)^3 times a sum of (bend rate^2)^2 / rate
    return -float(np.log(jerk)) if jerk > 0 else float("inf")


def _median(values: list[float]) -> float:
    return float(np.median(values)) if values else float("nan")
