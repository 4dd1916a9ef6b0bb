"""A kit for the tools that labs already use: `emovid study export`."""

import os
from collections.abc import Callable, Sequence
from pathlib import Path

from emovid.atomic_io import make_folder, whole_file
from emovid.errors import InputError, reason
from emovid.kit.exports.checklist import checklist
from emovid.kit.exports.export import Files
from emovid.kit.exports.jspsych import jspsych
from emovid.kit.exports.limesurvey import limesurvey
from emovid.kit.exports.prereg import prereg
from emovid.kit.exports.psychds import psych_ds
from emovid.kit.exports.psychopy import psychopy
from emovid.kit.exports.qualtrics import qualtrics
from emovid.kit.folders import TIME, write_text
from emovid.kit.read import Kit
from emovid.kit.seeded_random import is_code
from emovid.responses.read import read_responses
from emovid.responses.responses import Responses

_WITH_VIDEOS = ("jspsych", "psychopy", "qualtrics", "limesurvey")
_TOOLS: dict[str, Callable[[Kit, str, Responses | None], Files]] = {
    "jspsych": lambda kit, *_: jspsych(kit),
    "psychopy": lambda kit, *_: psychopy(kit),
    "qualtrics": lambda kit, video_url, _: qualtrics(kit, video_url),
    "limesurvey": lambda kit, video_url, _: limesurvey(kit, video_url),
    "psych-ds": lambda kit, _, responses: psych_ds(kit, responses),
    "prereg": lambda kit, *_: prereg(kit),
    "checklist": lambda kit, *_: checklist(kit),
}
TOOLS = tuple(_TOOLS)


def export(
    kit: Kit, tool: str, folder: Path | None = None, video_url: str = "videos", responses: Sequence[Path] = ()
) -> list[Path]:
    """Write a kit for one of the `TOOLS` and return the files.

    Args:
        kit: a finished one.
        tool: to write for.
        folder: to write into; None is that of the tool among the kit's exports, where audits look.
        video_url: where the tool finds the videos.
        responses: exports of the survey, for the data set.

    Raises:
        InputError: for a kit without orders or videos, or responses that cannot be read.
        EmovidError: if something cannot be written.
    """
    kit.need_orders()
    answers = None
    if responses:
        mapping = kit.folder.map if kit.folder.map.is_file() else None
        answers = read_responses(list(responses), key=kit.folder.key, mapping=mapping)
    target = folder or kit.folder.exports / tool
    written = []
    for name, text in _TOOLS[tool](kit, video_url, answers).items():
        make_folder((target / name).parent)
        write_text(target / name, text)
        written.append(target / name)
    return written + (_copied(kit, target / "videos") if tool in _WITH_VIDEOS else [])


def _copied(kit: Kit, folder: Path) -> list[Path]:
    """Copy the videos, with the time they have, and remove those of a former kit."""
    make_folder(folder)
    targets = {folder / f"{code}.mp4": kit.folder.video(code) for code in kit.manifest.codes}
    for path in folder.glob("*.mp4"):
        if is_code(path.stem) and path not in targets:
            path.unlink()
    for target, source in targets.items():
        try:
            data = source.read_bytes()
        except OSError as error:
            raise InputError(f"{source}: {reason(error)}; expected a video of the kit: build it again") from None
        with whole_file(target) as part:
            part.write_bytes(data)
            os.utime(part, (TIME, TIME))
    return list(targets)
