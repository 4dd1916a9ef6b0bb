"""All descriptors of a run."""

from emovid.measure.arrangement import CROWDING, SHAPE, crowding, shape
from emovid.measure.convergence import CONVERGENCE, convergence
from emovid.measure.kinematics import SMOOTHNESS, SPEED, smoothness, speed
from emovid.measure.trace import TRACE, trace
from emovid.measure.window import WINDOW, Descriptor, window_of
from emovid.swarm.trajectory import Trajectory

# By family, in the order of docs/descriptors.md, which has a row for each.
FAMILIES: dict[str, tuple[Descriptor, ...]] = {
    "Window": WINDOW,
    "Speed": SPEED,
    "Angularity of the trace": TRACE,
    "Smoothness": SMOOTHNESS,
    "Size and roundness": SHAPE,
    "Crowding and order": CROWDING,
    "Convergence": CONVERGENCE,
}
DESCRIPTORS: dict[str, Descriptor] = {each.name: each for family in FAMILIES.values() for each in family}


def describe(trajectory: Trajectory, start: float = 0.0, end: float | None = None) -> dict[str, float]:
    """Return the value of each of the `DESCRIPTORS`, in their order; NaN where a run has none.

    Args:
        trajectory: of any scene; its `video` has no influence.
        start: of the window that is measured [s].
        end: of the window [s]; by default the last of the scene's `snapshots`, else of the paper's for its emotion; the
            run's end without either, or if that comes first.

    Raises:
        InputError: if the window is empty or not within the run.
    """
    window = window_of(trajectory, start, end)
    return {
        "window": window.length,
        **speed(window),
        **trace(window),
        **smoothness(window),
        **shape(window),
        **crowding(window),
        **convergence(window),
    }
