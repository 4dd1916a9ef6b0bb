"""`emovid study`: make what a study shows and show it; analyse it; plan and rehearse one."""

import typer

from emovid.cli import analysis, kit, planning, survey

app = typer.Typer(help="Analyse a study, plan one, rehearse one; make what it shows.", no_args_is_help=True)
for command in (
    kit.new, kit.build, kit.audit, kit.export,
    survey.serve, survey.responses, survey.progress, survey.withdraw,
    analysis.analyze, analysis.columns, analysis.compare,
    planning.power, planning.simulate,
):  # fmt: skip
    app.command()(command)
