"""Descriptors of what changes in the course of a window: its mean, both ends and its growth."""

from emovid.measure.descriptor import Descriptor
from emovid.swarm.arrays import Array, Mask


def series(name: str, unit: str, what: str, source: str = "") -> tuple[Descriptor, ...]:
    """Return the four descriptors of a quantity in time."""
    return (
        Descriptor(f"{name}_mean", unit, f"{what}; mean over time", source),
        Descriptor(f"{name}_start", unit, f"{what}, at the window's start", source),
        Descriptor(f"{name}_end", unit, f"{what}, at its end", source),
        Descriptor(
            f"{name}_growth", "1/s", f"slope of the least-squares line through {name} in time, over its mean", source
        ),
    )


def in_time(name: str, times: Array, values: Array) -> dict[str, float]:
    """Return the values of the descriptors that `series` names, of `values` (F,) at even `times` (F,) [s]."""
    mean = float(values.mean())
    since = times - times.mean()
    slope = float(since @ values / (since @ since))
    return {
        f"{name}_mean": mean,
        f"{name}_start": float(values[0]),
        f"{name}_end": float(values[-1]),
        f"{name}_growth": slope / mean if mean != 0 else float("nan"),
    }


def mean_where(values: Array, defined: Mask) -> float:
    """Return the mean of those values that are defined, NaN if none is."""
    return float(values[defined].mean()) if defined.any() else float("nan")
