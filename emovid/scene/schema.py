"""The JSON Schema of scenes, from the models that validate them."""

from typing import Any

from emovid.scene.model import Scene


def scene_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a scene: editors complete keys and show the descriptions from it."""
    schema = Scene.model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "emovid scene"}
