"""Condition files for PsychoPy: one for each participant, in the order of presentation."""

from emovid.kit.exports.export import Files
from emovid.kit.folders import csv_text
from emovid.kit.read import Kit

_README = """# {title}

`conditions/PARTICIPANT.csv` lists a participant's videos in their order, `videos/` holds them.

In the Builder: a loop around one routine, its type *sequential*, its conditions
`$"conditions/" + expInfo["participant"] + ".csv"`. In the routine

- a Movie component with `$video_file`, *set every repeat*;
- a Text component with the question, and one Mouse or Button component for each answer, named by its label, or a Slider
  with the labels as its ticks: their start condition `movie.isFinished`, so that a video is watched to its end.

Question: {question}

Answers, by label:

{answers}

Keep the label in the data (`clicked_name`, `keys` or `response`). Save the answers as CSV, one row for a trial:

    emovid study analyze data/ --key key.csv --map map.yaml
"""


def psychopy(kit: Kit) -> Files:
    """Return the condition files and how to use them."""
    header = ["position", "video_code", "video_file", *(["choices"] if kit.choices else [])]
    files = {}
    for name, order in kit.orders.items():
        drawn = ["|".join(kit.choices[name])] if name in kit.choices else []
        rows = [[place, code, f"videos/{code}.mp4", *drawn] for place, code in enumerate(order, start=1)]
        files[f"conditions/{name}.csv"] = csv_text(header, rows)
    answers = "\n".join(f"- {answer.label}: {answer.text}" for answer in kit.manifest.choices.labels)
    said = {"title": kit.manifest.title, "question": kit.manifest.question, "answers": answers}
    return files | {"README.md": _README.format(**said)}
