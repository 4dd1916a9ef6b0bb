"""How smoothly the robots move, by the speed profiles that an observer takes from their positions.

S. Balasubramanian, A. Melendez-Calderon, A. Roby-Brami and E. Burdet, "On the analysis of movement smoothness",
J. NeuroEng. Rehabil. 12:112, 2015. Of both measures the larger is the smoother. They were made for single movements
from rest to rest; here they compare profiles that the window cuts, with these limits: constant speed over the whole
window reads about -2.4 in SPARC, for the cut ends alone; and the dimensionless jerk grows with the cube of the window's
length, so that only windows of one length compare. Held commands make speed jump, so that jerk has a value only at the
observer's rate, which is fixed.
"""

import numpy as np

from emovid.measure.descriptor import Descriptor
from emovid.measure.window import Window
from emovid.swarm.arrays import Array

_RATE = 30.0  # Hz; of the positions, whatever the video's frame rate: three times SPARC's cut-off
_PADDING = 4  # zeros to 2^4 times the length: SPARC's published defaults, as are the next two
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


def smoothness(window: Window) -> dict[str, float]:
    """Return the descriptors of smoothness; NaN if no robot moves."""
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
    """Return minus the logarithm of the dimensionless jerk of a speed profile (F,), whose rate cancels."""
    bend = np.diff(speed, n=2) / speed.max()
    bend[np.abs(bend) < 1e-9] = 0.0  # rounding of positions
    jerk = len(speed) ** 3 * np.sum(bend**2)  # (F / rate)^3 times a sum of (bend rate^2)^2 / rate
    return -float(np.log(jerk)) if jerk > 0 else float("inf")


def _median(values: list[float]) -> float:
    return float(np.median(values)) if values else float("nan")
