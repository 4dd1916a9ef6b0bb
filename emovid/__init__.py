"""Emotions expressed by a robot swarm: scenes, their simulation and videos, and studies of how people perceive them."""

import time
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from emovid.errors import EmovidError, InputError
    from emovid.measure.describe import describe
    from emovid.responses.read import read_responses
    from emovid.scene.load import load_scene
    from emovid.statistics.analyze import analyze
    from emovid.swarm.dataframe import to_dataframe
    from emovid.swarm.simulate import simulate
    from emovid.swarm.trajectory import Trajectory
    from emovid.version import __version__
    from emovid.video.render import render_video, show
    from emovid.workflows.notebook import build_kit, confusion_table, paper_figure, simulate_responses
    from emovid.workflows.planning import plan_study

__all__ = [
    "EmovidError",
    "InputError",
    "Trajectory",
    "__version__",
    "analyze",
    "build_kit",
    "confusion_table",
    "describe",
    "load_scene",
    "paper_figure",
    "plan_study",
    "read_responses",
    "render_video",
    "show",
    "simulate",
    "simulate_responses",
    "to_dataframe",
]

IMPORTED_AT = time.time_ns()  # a module that was edited later may differ from the code in memory

_HOMES = {
    "EmovidError": "emovid.errors",
    "InputError": "emovid.errors",
    "__version__": "emovid.version",
    "analyze": "emovid.statistics.analyze",
    "build_kit": "emovid.workflows.notebook",
    "confusion_table": "emovid.workflows.notebook",
    "describe": "emovid.measure.describe",
    "Trajectory": "emovid.swarm.trajectory",
    "load_scene": "emovid.scene.load",
    "paper_figure": "emovid.workflows.notebook",
    "plan_study": "emovid.workflows.planning",
    "read_responses": "emovid.responses.read",
    "render_video": "emovid.video.render",
    "show": "emovid.video.render",
    "simulate": "emovid.swarm.simulate",
    "simulate_responses": "emovid.workflows.notebook",
    "to_dataframe": "emovid.swarm.dataframe",
}


def __getattr__(name: str) -> Any:
    """Import the public API on first use, so that `import emovid` stays fast (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module 'emovid' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    """Return the public names, for completion in a notebook."""
    return sorted({*globals(), *__all__})
