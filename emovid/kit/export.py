"""Exports of a kit for other tools: `emovid study export`."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from emovid.atomic_io import check_existing, make_folder, whole_file
from emovid.errors import InputError, nearest, reason
from emovid.kit.exports import jspsych, limesurvey, psychopy, qualtrics
from emovid.kit.exports.design import REVISION, DesignPart, Limits, Status, design_of
from emovid.kit.exports.psych_ds import psych_ds
from emovid.kit.exports.reporting import checklist, preregistration
from emovid.kit.exports.texts import Files
from emovid.kit.folder import TIME, Kit, write_text
from emovid.kit.seeded_random import is_code
from emovid.responses.read import read_responses
from emovid.responses.responses import Responses

TOOLS: dict[str, Callable[[Kit, str, Responses | None], Files]] = {
    "jspsych": lambda kit, *_: jspsych.jspsych(kit),
    "psychopy": lambda kit, *_: psychopy.psychopy(kit),
    "qualtrics": lambda kit, video_url, _: qualtrics.qualtrics(kit, video_url),
    "limesurvey": lambda kit, video_url, _: limesurvey.limesurvey(kit, video_url),
    "psych-ds": lambda kit, _, responses: psych_ds(kit, responses),
    "prereg": lambda kit, *_: preregistration(kit),
    "checklist": lambda kit, *_: checklist(kit),
}
_LIMITS: dict[str, Callable[[Kit], Limits]] = {
    "jspsych": jspsych.limits,
    "psychopy": psychopy.limits,
    "qualtrics": qualtrics.limits,
    "limesurvey": limesurvey.limits,
}
_BY_ADDRESS = ("qualtrics", "limesurvey")
_HERE = "videos"
# Parts that do not change what participants see or answer: an export without them is still valid.
_OPTIONAL = (REVISION,)


@dataclass(frozen=True)
class Exported:
    """Files of an export, and warnings about it."""

    files: tuple[Path, ...]
    warnings: tuple[str, ...]


def check_export(kit: Kit, tool: str) -> list[DesignPart]:
    """Return the parts of the design of a kit, and how far a survey tool supports each of them.

    Raises:
        InputError: for an unknown tool, or one that is not a survey tool.
    """
    _check_tool(tool)
    if tool not in _LIMITS:
        raise InputError(f"--check: {tool} runs no survey; expected --to {', '.join(_LIMITS)}")
    kit.need_orders()
    return design_of(kit, _LIMITS[tool](kit))


def is_possible(parts: Sequence[DesignPart]) -> bool:
    """Return whether a tool can carry a design, be it with work by hand."""
    return not _impossible(parts)


def export(
    kit: Kit,
    tool: str,
    folder: Path | None = None,
    video_url: str = _HERE,
    responses: Sequence[Path] = (),
    mapping: Path | None = None,
    *,
    force: bool = False,
) -> Exported:
    """Write the files of a kit for one of the `TOOLS`.

    Args:
        kit: a finished kit.
        tool: name of the tool.
        folder: output folder; None for that of the tool in the kit, which audits include.
        video_url: address of the videos.
        responses: exports of the survey, for the data set.
        mapping: map.yaml of these; None for that of the kit.
        force: whether to overwrite existing files with other content.

    Raises:
        InputError: for an existing file with other content, an unknown tool, a design that it cannot carry, a kit
            without orders or videos, and invalid responses.
        EmovidError: if something cannot be written.
    """
    _check_tool(tool)
    if responses and tool != "psych-ds":
        raise InputError(f"--responses: {tool} contains no answers; expected --to psych-ds")
    if mapping and not responses:
        raise InputError("--map: expected --responses, which it describes")
    kit.need_orders()
    warnings = _warnings(check_export(kit, tool), tool, video_url) if tool in _LIMITS else ()
    answers = None
    if responses:
        mapping = mapping or (kit.folder.map if kit.folder.map.is_file() else None)
        answers = read_responses(list(responses), key=kit.folder.key, mapping=mapping)
    target = folder or kit.folder.exports / tool
    texts = {target / name: text for name, text in TOOLS[tool](kit, video_url, answers).items()}
    videos = _videos(kit, target / "videos") if tool in _LIMITS else {}
    check_existing({file: text.encode() for file, text in texts.items()} | videos, force=force)
    for file, text in texts.items():
        make_folder(file.parent)
        write_text(file, text)
    _write_videos(videos)
    return Exported((*texts, *videos), warnings)


def _check_tool(tool: str) -> None:
    if tool not in TOOLS:
        raise InputError(f"--to {tool}: expected one of {', '.join(TOOLS)}{nearest(tool, TOOLS)}")


def _impossible(parts: Sequence[DesignPart]) -> list[DesignPart]:
    return [part for part in parts if part.support.status is Status.MISSING and part.name not in _OPTIONAL]


def _warnings(parts: Sequence[DesignPart], tool: str, video_url: str) -> tuple[str, ...]:
    """Return the steps that an export leaves to the researcher; refuse an export that cannot carry the design."""
    if impossible := _impossible(parts):
        reasons = "; ".join(f"{part.name} ({part.value}): {part.support.note}" for part in impossible)
        raise InputError(f"--to {tool}: cannot carry the design: {reasons}")
    found = []
    if tool in _BY_ADDRESS and video_url == _HERE:
        found.append(
            "no --video-url: the survey names videos/CODE.mp4, which no server has; export with it and --force"
        )
    for status in (Status.BY_HAND, Status.CHANGED, Status.MISSING):
        names = [part.name for part in parts if part.support.status is status]
        if names:
            found.append(f"{status.value}: {', '.join(names)}; see README.md")
    return tuple(found)


def _videos(kit: Kit, folder: Path) -> dict[Path, bytes]:
    """Return the contents of the copies of a kit's videos, by their path."""
    found = {}
    for code in kit.manifest.all_videos:
        source = kit.folder.video(code)
        try:
            found[folder / f"{code}.mp4"] = source.read_bytes()
        except OSError as error:
            raise InputError(f"{source}: {reason(error)}; expected a video of the kit: build it again") from None
    return found


def _write_videos(videos: Mapping[Path, bytes]) -> None:
    """Write the videos with their times, and remove those of a former kit."""
    for folder in {target.parent for target in videos}:
        make_folder(folder)
        for path in folder.glob("*.mp4"):
            if is_code(path.stem) and path not in videos:
                path.unlink()
    for target, data in videos.items():
        with whole_file(target) as part:
            part.write_bytes(data)
            os.utime(part, (TIME, TIME))
