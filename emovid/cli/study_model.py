"""`emovid study model`: groups and conditions in a mixed logistic model."""

import json
from math import isnan
from pathlib import Path
from typing import Annotated

import typer

from emovid.cli.options import Json
from emovid.errors import InputError
from emovid.report import apa
from emovid.report.results_json import as_json
from emovid.responses.key import read_factors
from emovid.responses.read import read_responses
from emovid.statistics.mixed import Effect, model_of


def model(
    sources: Annotated[list[Path], typer.Argument(metavar="EXPORT...", help="Exports, or folders of them.")],
    by: Annotated[
        list[str] | None,
        typer.Option("--by", help="A group of participants, named beforehand; can be repeated.", show_default=False),
    ] = None,
    factor: Annotated[
        list[str] | None,
        typer.Option(
            "--factor",
            help="A condition of the videos: a column of --key, such as a factor in stimuli.csv; can be repeated.",
            show_default=False,
        ),
    ] = None,
    key: Annotated[
        Path | None, typer.Option("--key", help="CSV with video_code,true_emotion, and columns of conditions.")
    ] = None,
    mapping: Annotated[Path | None, typer.Option("--map", help="map.yaml.")] = None,
    print_json: Json = False,
) -> None:
    """Compare groups and conditions in a mixed logistic model.

    Participants and videos are crossed random effects, so the result holds for other participants and other videos.

    Examples: emovid study model responses.csv --by gender · emovid study model r.csv --key stimuli.csv --factor speed
    """
    if not by and not factor:
        raise InputError("expected --by with a group of participants, or --factor with a condition of the videos")
    if factor and key is None:
        raise InputError(
            f"--factor {factor[0]}: expected --key with a column of it, such as private/stimuli.csv of a kit"
        )
    try:
        levels = read_factors(key, factor) if key and factor else {}
        found = model_of(read_responses(sources, key, mapping, groups=by or ()), by or (), levels)
    except ValueError as error:
        raise InputError(str(error)) from None
    if print_json:
        typer.echo(json.dumps(as_json(found), indent=2))
        return
    for effect in found.effects:
        typer.echo(_line(effect))
    spreads = f"participants {found.participant_sd:.2f}, videos {found.video_sd:.2f}"
    typer.echo(f"standard deviations in log odds: {spreads}")
    numbers = f"{found.answers} answers of {found.participants} participants to {found.videos} videos"
    typer.echo(numbers + ("" if found.converged else "; the search did not converge, so the numbers are not valid"))


def _line(effect: Effect) -> str:
    """Return an effect in one line."""
    if isnan(effect.error):
        return f"{effect.name}: no estimate, since one level has only right answers or none"
    interval = f"[{effect.ci_low:.2f}, {effect.ci_high:.2f}]"
    error, p = apa.number(effect.error), apa.p_value(effect.p)
    return (
        f"{effect.name}: {apa.number(effect.estimate)} (SE {error}), {p}, odds ratio {effect.odds_ratio:.2f} {interval}"
    )
