"""`emovid study schema`: the formats of study.yaml, map.yaml and results.json.

A separate module, since study.yaml needs the models of scenes and results.json needs pandas.
"""

import json
from typing import Annotated

import typer

from emovid.kit.study import study_schema
from emovid.report.results_json import results_schema
from emovid.responses.mapping import map_schema


def schema(
    results: Annotated[bool, typer.Option("--results", help="Of results.json, instead of study.yaml.")] = False,
    of_map: Annotated[bool, typer.Option("--map", help="Of map.yaml, instead of study.yaml.")] = False,
) -> None:
    """Print the JSON Schema of study.yaml, of map.yaml or of results.json.

    Examples: emovid study schema > study.schema.json · emovid study schema --map · emovid study schema --results
    """
    found = results_schema() if results else map_schema() if of_map else study_schema()
    typer.echo(json.dumps(found, indent=2))
