"""Condition files for PsychoPy: one per participant, in the order of presentation."""

from emovid.csv_writer import csv_text
from emovid.kit.exports.texts import Files, template
from emovid.kit.folder import Kit


def psychopy(kit: Kit) -> Files:
    """Return the condition files and a README."""
    header = ["position", "video_code", "video_file", *(["choices"] if kit.choices else [])]
    files = {}
    for name, order in kit.orders.items():
        drawn = ["|".join(kit.choices[name])] if name in kit.choices else []
        rows = [[place, code, f"videos/{code}.mp4", *drawn] for place, code in enumerate(order, start=1)]
        files[f"conditions/{name}.csv"] = csv_text(header, rows)
    answers = "\n".join(f"- {answer.label}: {answer.text}" for answer in kit.manifest.choices.labels)
    readme = template("psychopy.md", title=kit.manifest.title, question=kit.manifest.question, answers=answers)
    return files | {"README.md": readme}
