"""`emovid study power` and `simulate`: plan a study, and rehearse it before anyone takes part."""

import json
from pathlib import Path
from typing import Annotated

import typer

from emovid.cli.options import Force, Json, Quiet, RandomSeed, check_file, number, refuse_with, whole
from emovid.report.results_json import as_json
from emovid.workflows.planning import (
    ACCURACY,
    Rehearsal,
    plan_design,
    plan_looks,
    plan_study,
    plan_text,
    planned_design,
    write_rehearsal,
)


def power(
    rate: Annotated[
        float, typer.Option(metavar="SHARE", help="Hit rate to detect.", parser=number("--rate", 0, 1))
    ] = 0.4,
    k: Annotated[
        int,
        typer.Option("--choices", metavar="INTEGER", help="Answers to choose from.", parser=whole("--choices", 2, 12)),
    ] = 6,
    videos: Annotated[
        int,
        typer.Option(metavar="INTEGER", help="Tests that Holm's correction covers.", parser=whole("--videos", 1, 100)),
    ] = 6,
    alpha: Annotated[
        float, typer.Option(metavar="SHARE", help="Level of all tests together.", parser=number("--alpha", 0, 1))
    ] = 0.05,
    desired: Annotated[
        float, typer.Option("--power", metavar="SHARE", help="Desired power.", parser=number("--power", 0, 1))
    ] = 0.8,
    print_json: Json = False,
) -> None:
    """Plan how many participants a study needs.

    Enough participants to recognize a video above chance with the desired power.

    Examples: emovid study power --rate 0.5 · emovid study power --choices 4 --power 0.9
    """
    found = plan_study(rate, k, videos, alpha, desired)
    if print_json:
        typer.echo(json.dumps(as_json(found), indent=2))
        return
    for test, participants in (
        ("exact binomial against chance", found.n_binomial),
        ("goodness of fit", found.n_goodness),
        ("both", found.n),
    ):
        needed = "more than can be planned" if participants is None else f"{participants} participants"
        typer.echo(f"{test + ':':<31} {needed}")


def plan(
    goal: Annotated[
        str, typer.Option(help="h1: all emotions above chance; difference or equivalence: of two groups.")
    ] = "h1",
    rate: Annotated[float, typer.Option(help="Planned hit rate.")] = 0.5,
    k: Annotated[int, typer.Option("--choices", min=2, max=12, help="Answers to choose from.")] = 6,
    emotions: Annotated[int, typer.Option(min=1, max=12, help="Emotions shown.")] = 6,
    exemplars: Annotated[int, typer.Option(min=1, max=20, help="Videos of each emotion.")] = 1,
    participant_sd: Annotated[float, typer.Option(min=0, max=5, help="SD of participants in log odds.")] = 0.5,
    video_sd: Annotated[float, typer.Option(min=0, max=5, help="SD of videos in log odds.")] = 0.0,
    difference: Annotated[float, typer.Option(min=0, max=100, help="Difference to detect, in points.")] = 15.0,
    margin: Annotated[float, typer.Option(min=0, max=100, help="Margin of equivalence, in points.")] = 15.0,
    share: Annotated[float, typer.Option(help="Share of participants in the first group.")] = 0.5,
    alpha: Annotated[float, typer.Option(help="Level of all tests together.")] = 0.05,
    desired: Annotated[float, typer.Option("--power", help="Desired power.")] = 0.8,
    rule: Annotated[
        str | None,
        typer.Option(
            "--sequential",
            metavar="RULE",
            help="Rule of a study with several looks: alpha or bayes.",
            show_default=False,
        ),
    ] = None,
    looks: Annotated[str, typer.Option(help="Participants at each look, separated by commas.")] = "15,30,45",
    seed: RandomSeed = 0,
    print_json: Json = False,
) -> None:
    """Plan a whole study by simulation.

    Finds the participants for a goal, with participants and videos that vary, or the looks of a sequential study with
    their error rates.

    Examples: emovid study plan --rate 0.5 --exemplars 2 · emovid study plan --sequential bayes --looks 20,40,60
    """
    design = planned_design(
        goal, rate, k, emotions, exemplars, participant_sd, video_sd, difference / 100, margin / 100, share, alpha
    )
    found = plan_looks(rule, looks, design, seed) if rule else plan_design(design, desired, seed)
    typer.echo(json.dumps(as_json(found), indent=2) if print_json else plan_text(found))


def simulate(
    output: Annotated[Path, typer.Option("--output", "-o", help="The CSV to write; - prints it.")] = Path(
        "simulated.csv"
    ),
    participants: Annotated[
        int,
        typer.Option(metavar="INTEGER", help="Simulated participants.", parser=whole("--participants", 1, 1_000_000)),
    ] = 45,
    accuracy: Annotated[
        float | None,
        typer.Option(
            metavar="SHARE",
            help="Probability of a right answer.",
            show_default=f"{ACCURACY}",
            parser=number("--accuracy", 0, 1),
        ),
    ] = None,
    matrix: Annotated[
        Path | None,
        typer.Option("--matrix", help="Simulate answers with this confusion matrix instead.", show_default=False),
    ] = None,
    bias: Annotated[
        list[str] | None,
        typer.Option("--bias", metavar="LABEL=WEIGHT", help="Weight among wrong answers.", show_default=False),
    ] = None,
    elimination: Annotated[
        float,
        typer.Option(
            metavar="SHARE",
            help="Share of participants who give each label only once.",
            parser=number("--elimination", 0, 1),
        ),
    ] = 0.0,
    dropout: Annotated[
        float,
        typer.Option(metavar="SHARE", help="Probability of leaving after a video.", parser=number("--dropout", 0, 1)),
    ] = 0.0,
    seed: RandomSeed = 0,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Simulate the responses of participants.

    The table rehearses the analysis of a study before anyone takes part. Each row is marked as simulated, and so is
    everything that is made from it.

    Examples: emovid study simulate --participants 60 · emovid study simulate --bias anger=2
    """
    check_file(output, f"-o {output}", (".csv",))
    if matrix:
        refuse_with("--matrix", {"--accuracy": accuracy, "--bias": bias})
    rehearsal = Rehearsal(participants, accuracy, matrix, bias or [], elimination, dropout, seed)
    answers = write_rehearsal(rehearsal, output, force=force)
    if not quiet:
        typer.echo(f"{output}: {answers} answers of {participants} simulated participants", err=True)
