"""How fast the robots are: exact, since a command's v is held from one sample to the next."""

import numpy as np

from emovid.measure.descriptor import Descriptor
from emovid.measure.stage_geometry import Ground
from emovid.measure.window import Window
from emovid.swarm.arrays import Array

_KINDS = {
    "mean": "linear speed, mean over robots and time",
    "p95": "the linear speed that is not exceeded in 95 % of the robots' time",
    "peak": "largest linear speed of any robot",
}

SPEED = (
    *(Descriptor(f"speed_{kind}", "m/s", definition) for kind, definition in _KINDS.items()),
    *(
        Descriptor(f"speed_{kind}_diagonals", "diagonals/s", f"speed_{kind} over the stage's diagonal")
        for kind in _KINDS
    ),
    Descriptor("distance_travelled", "m", "length of a robot's path, all its detail included; mean over robots"),
)


def speed(window: Window, ground: Ground) -> dict[str, float]:
    """Return the descriptors of speed."""
    seconds = window.seconds
    held = seconds > 0
    v, seconds = np.abs(window.trajectory.commands[held, :, 0]), seconds[held]
    share = np.broadcast_to((seconds / seconds.sum())[:, None], v.shape) / v.shape[1]
    found = (float(np.sum(v * share)), quantile(v.ravel(), share.ravel(), 0.95), float(v.max()))
    distance = seconds @ v
    return {
        **{f"speed_{kind}": value for kind, value in zip(_KINDS, found, strict=True)},
        **{f"speed_{kind}_diagonals": value / ground.diagonal for kind, value in zip(_KINDS, found, strict=True)},
        "distance_travelled": float(distance.mean()),
    }


def quantile(values: Array, weights: Array, share: float) -> float:
    """Return the smallest of the values (M,) that at least a `share` of the weights (M,) does not exceed."""
    order = np.argsort(values)
    reached = np.cumsum(weights[order])
    # Sums of equal weights miss a share that they ought to meet by a rounding.
    return float(values[order[np.searchsorted(reached, share * reached[-1] * (1 - 1e-12))]])
