from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import settings

from emovid.scene.load import Setting, load_scene
from emovid.scene.model import Scene

# How long an example takes says more of the machine than of the code.
settings.register_profile("emovid", deadline=None)
settings.load_profile("emovid")

MakeScene = Callable[..., Scene]


@pytest.fixture(scope="session")
def make_scene() -> MakeScene:
    """Make a shipped scene with keys replaced: make_scene("fear", {"robots": 3})."""

    def make(emotion: str = "happiness", keys: dict[str, Any] | None = None) -> Scene:
        return load_scene(emotion, [Setting(key, value, f"test {key}") for key, value in (keys or {}).items()])

    return make
