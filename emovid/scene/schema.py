"""The JSON Schema of scenes, from the models that validate them."""

from typing import Any

from emovid.scene.model import Scene
from emovid.scene.robot_files import shipped_robots
from emovid.scene.robots import schema_with


def scene_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a scene: editors complete keys and show the descriptions from it."""
    schema = Scene.model_json_schema()
    schema_with(shipped_robots(), schema["$defs"]["Robot"])
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "emovid scene"}
