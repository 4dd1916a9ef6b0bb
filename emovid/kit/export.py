"""Exports of a kit for other tools: `emovid study export`."""

import os
from collections.abc import Callable, Sequence
from pathlib import Path

from emovid.atomic_io import make_folder, whole_file
from emovid.errors import InputError, nearest, reason
from emovid.kit.exports.checklist import checklist
from emovid.kit.exports.jspsych import jspsych
from emovid.kit.exports.limesurvey import limesurvey
from emovid.kit.exports.prereg import prereg
from emovid.kit.exports.psych_ds import psych_ds
from emovid.kit.exports.psychopy import psychopy
from emovid.kit.exports.qualtrics import qualtrics
from emovid.kit.exports.texts import Files
from emovid.kit.folder import TIME, Kit, write_text
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
    """Write the files of a kit for one of the `TOOLS` and return their paths.

    Args:
        kit: a finished kit.
        tool: name of the tool.
        folder: output folder; None for that of the tool in the kit, which audits include.
        video_url: address of the videos.
        responses: exports of the survey, for the data set.

    Raises:
        InputError: for an unknown tool, a kit without orders or videos, and invalid responses.
        EmovidError: if something cannot be written.
    """
    if tool not in TOOLS:
        raise InputError(f"--to {tool}: expected one of {', '.join(TOOLS)}{nearest(tool, TOOLS)}")
    if folder is not None and folder.exists() and not folder.is_dir():
        raise InputError(f"-o {folder}: is a file; expected a folder")
    if responses and tool != "psych-ds":
        raise InputError(f"--responses: {tool} contains no answers; expected --to psych-ds")
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
    """Copy the videos with their times, and remove those of a former kit."""
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
