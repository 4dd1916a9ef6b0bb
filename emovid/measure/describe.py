"""All descriptors of a run: the door of this room."""

from emovid.measure.convergence import CONVERGENCE, convergence
from emovid.measure.crowding import CROWDING, crowding
from emovid.measure.descriptor import Descriptor
from emovid.measure.shape import SHAPE, shape
from emovid.measure.smoothness import SMOOTHNESS, smoothness
from emovid.measure.speed import SPEED, speed
from emovid.measure.stage_geometry import ground_of
from emovid.measure.trace import TRACE, trace
from emovid.measure.window import WINDOW, window_of
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
            run's end without either, or where that comes first.

    Raises:
        InputError: if the window is empty or not within the run.
    """
    window = window_of(trajectory, start, end)
    ground = ground_of(trajectory.scene.stage)
    return {
        "window": window.length,
        **speed(window, ground),
        **trace(window),
        **smoothness(window),
        **shape(window, ground),
        **crowding(window, ground),
        **convergence(window),
    }
