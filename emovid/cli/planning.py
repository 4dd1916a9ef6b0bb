"""`emovid study power` and `simulate`: plan a study, and rehearse it before anyone watches."""

import json
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from emovid.cli.options import Json, Quiet, RandomSeed, check_file, refuse_beside
from emovid.errors import InputError, nearest

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_ACCURACY = 0.5
_MOST_WEIGHT = 1_000_000


def power(
    rate: Annotated[float, typer.Option(help="The hit rate to be found.")] = 0.4,
    k: Annotated[int, typer.Option("--choices", min=2, max=12, help="Answers to choose from.")] = 6,
    videos: Annotated[int, typer.Option(min=1, max=100, help="Tests that Holm corrects for.")] = 6,
    alpha: Annotated[float, typer.Option(help="Level of the whole.")] = 0.05,
    wished: Annotated[float, typer.Option("--power", help="Wished power.")] = 0.8,
    as_json: Json = False,
) -> None:
    """Plan how many participants a study needs.

    Enough participants to recognize a video above chance with the desired power.

    Examples: emovid study power --rate 0.5 · emovid study power --choices 4 --power 0.9
    """
    from dataclasses import asdict

    from emovid.statistics.power import plan

    try:
        found = plan(rate, k, videos, alpha, wished)
    except ValueError as error:
        raise InputError(str(error)) from None
    if as_json:
        typer.echo(json.dumps(asdict(found), indent=2))
        return
    for what, value in (
        ("exact binomial against chance", found.n_binomial),
        ("goodness of fit", found.n_goodness),
        ("both", found.n),
    ):
        typer.echo(f"{what + ':':<31} {'more than can be planned' if value is None else f'{value} participants'}")


def simulate(
    output: Annotated[Path, typer.Option("--output", "-o", help="The CSV to write.")] = Path("responses.csv"),
    participants: Annotated[int, typer.Option(min=1, max=1_000_000, help="Model participants.")] = 45,
    accuracy: Annotated[
        float | None, typer.Option(min=0, max=1, help="Probability of a right answer.", show_default=f"{_ACCURACY}")
    ] = None,
    matrix: Annotated[
        Path | None, typer.Option("--matrix", help="Answer as in this confusion matrix, instead.", show_default=False)
    ] = None,
    bias: Annotated[
        list[str] | None,
        typer.Option("--bias", metavar="LABEL=WEIGHT", help="Weight of a wrong answer.", show_default=False),
    ] = None,
    elimination: Annotated[float, typer.Option(min=0, max=1, help="Share who give each label once.")] = 0.0,
    dropout: Annotated[float, typer.Option(min=0, max=1, help="Probability to leave after a video.")] = 0.0,
    seed: RandomSeed = 0,
    quiet: Quiet = False,
) -> None:
    """Simulate the responses of participants.

    The table rehearses the analysis of a study before anyone takes part.

    Examples: emovid study simulate -o responses.csv --participants 60 · emovid study simulate --bias anger=2
    """
    import numpy as np

    from emovid.atomic_io import make_folder, writing
    from emovid.responses.responses import EMOTIONS
    from emovid.responses.results_files import read_matrix
    from emovid.statistics.confusion import percent
    from emovid.statistics.simulated_participants import Responders, rehearse, responders

    check_file(output, f"-o {output}")
    if matrix:
        refuse_beside("--matrix", {"--accuracy": accuracy, "--bias": bias})
        counts, labels, signalled = read_matrix(matrix)
        model = Responders(np.nan_to_num(percent(counts) / 100, nan=1 / len(labels)), elimination, dropout)
    else:
        labels = signalled = EMOTIONS
        weights = _weights(bias or [], labels)
        right = np.full(len(signalled), _ACCURACY if accuracy is None else accuracy)
        model = responders(right, len(labels), weights, elimination, dropout)
    table = rehearse(model, labels, signalled, participants, seed)
    make_folder(output.parent)
    with writing(output) as file:
        file.write(table.to_csv(index=False, lineterminator="\n").encode())
    if not quiet:
        typer.echo(f"{output}: {len(table)} answers of {participants} model participants", err=True)


def _weights(pairs: list[str], labels: tuple[str, ...]) -> "NDArray[np.float64]":
    """Return the weight of each label among wrong answers."""
    import numpy as np

    weights = np.ones(len(labels))
    for pair in pairs:
        label, _, value = pair.partition("=")
        if label not in labels:
            raise InputError(f"--bias {pair}: expected one of {', '.join(labels)}{nearest(label, labels)}")
        try:
            weight = float(value)
        except ValueError:
            weight = nan
        if not 0 <= weight <= _MOST_WEIGHT:
            raise InputError(f"--bias {pair}: expected LABEL=WEIGHT, a weight from 0 to {_MOST_WEIGHT}")
        weights[labels.index(label)] = weight
    return weights
