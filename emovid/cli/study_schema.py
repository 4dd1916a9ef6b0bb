"""`emovid study schema`: the formats of study.yaml and results.json.

A module of its own, since study.yaml needs the models of scenes and results.json needs pandas.
"""

import json
from typing import Annotated

import typer

from emovid.kit.study import Study
from emovid.report.results_json import results_schema


def schema(
    results: Annotated[bool, typer.Option("--results", help="Of results.json, instead of study.yaml.")] = False,
) -> None:
    """Print the JSON Schema of study.yaml or of results.json.

    Examples: emovid study schema > study.schema.json · emovid study schema --results
    """
    typer.echo(json.dumps(results_schema() if results else Study.model_json_schema(), indent=2))
