"""A survey for Qualtrics in its "Advanced Format TXT"."""

from collections.abc import Iterable

from emovid.kit.exports.design import (
    CHECKS,
    CHOICES,
    CODE,
    DECLINED,
    LANGUAGE,
    LINK,
    ORDERS,
    QUESTIONS,
    RECRUITMENT,
    REQUIREMENTS,
    RETURNS,
    REVISION,
    SETS,
    WATCHING,
    Limits,
    by_hand,
    design_of,
    listed,
)
from emovid.kit.exports.texts import Files, consent, escaped, paragraphs, template, thanks, video_element
from emovid.kit.folder import Kit
from emovid.kit.manifest import PublicCheck
from emovid.kit.orders import Order, sets_of
from emovid.kit.study import Question, Rating, Requirements

_LONGEST_ROW = 11  # choices side by side; longer scales become a menu


def limits(kit: Kit) -> Limits:
    """Return the parts of the design that the file for Qualtrics cannot contain."""
    manifest = kit.manifest
    sets = sets_of(kit.orders.values())
    randomizer = f"Survey flow: put the blocks named by codes into a Randomizer that shows all {manifest.videos_shown}"
    found = {
        ORDERS: by_hand(f"{randomizer}. Qualtrics draws its own orders, balanced only on average."),
        QUESTIONS: by_hand(f"Select {_required(kit)}, and choose Response requirements, Force response."),
        DECLINED: by_hand(
            f"Survey flow: after the block Consent, add a branch for the answer {manifest.consent.decline!r} that ends "
            f"the survey with a custom message: {manifest.consent.declined!r}"
        ),
        WATCHING: by_hand(
            f"Add a Timing question to each block, and show the Next button after {manifest.videos[0].duration:g} s."
        ),
        REVISION: by_hand("Look and feel: switch on the Back button. It is off in a new survey."),
        LANGUAGE: by_hand(f"Survey options, General: set the language to {manifest.language}."),
    }
    if len(sets) > 1:
        groups = ", ".join(f"{code} in group {_numbers(code, sets)}" for code in manifest.codes)
        found[ORDERS] = by_hand("In each group of the next item, put the blocks into a Randomizer that shows all.")
        found[SETS] = by_hand(
            f"Survey flow: add a Randomizer that shows 1, evenly, of {len(sets)} groups, and put the blocks into these "
            f"groups: {groups}."
        )
    if manifest.checks:
        places = ", ".join(f"{check.name} after {check.after} videos" for check in manifest.checks)
        found[CHECKS] = by_hand(f"Survey flow: place the blocks named by the checks between Randomizers: {places}.")
    if manifest.recruitment:
        names = ", ".join(manifest.recruitment.names)
        note = f"Survey flow: add Embedded data {names}. In the return link, write ${{e://Field/NAME}} for {{NAME}}."
        found[RECRUITMENT] = by_hand(note)
    if any(word for back in (kit.server.declined, kit.server.failed) for _, word in back):
        found[RETURNS] = by_hand(f"End the survey with them: {_returns(kit)}.")
    if manifest.requirements != Requirements(text=manifest.requirements.text):
        found[REQUIREMENTS] = by_hand("Add the question type Meta info, and a branch on it that ends the survey.")
    if numbers := [item.name for item in (*manifest.demographics, *manifest.questions_after) if item.number]:
        note = (
            f"Response requirements, Content validation, Number, for {', '.join(numbers)}, with the range in the text."
        )
        found[QUESTIONS] = by_hand(f"{found[QUESTIONS].note} {note}")
    if manifest.choices.order == "random":
        found[CHOICES] = by_hand("Select the questions named by codes, and choose Randomization, all choices.")
    if manifest.thanks.code or manifest.thanks.link:
        seen = by_hand("It is in the block End: without the branch for declining, all participants see it.")
        found |= {CODE: seen, LINK: seen}
    return found


def qualtrics(kit: Kit, video_url: str) -> Files:
    """Return the survey, with the videos at an address, a map, and a README."""
    manifest = kit.manifest
    agreement = [manifest.consent.agree, manifest.consent.decline]
    blocks = [
        _block("Consent", _choice("consent", consent(manifest, _escaped), agreement)),
        *([_block("About you", *map(_question, manifest.demographics))] if manifest.demographics else []),
        _block("Instructions", _text("instructions", paragraphs(manifest.instructions, _escaped))),
        *_practice(kit, video_url),
        *(_block(code, *_video(kit, code, video_url)) for code in manifest.codes),
        *(_check(check, video_url) for check in manifest.checks),
        *([_block("Last questions", *map(_question, manifest.questions_after))] if manifest.questions_after else []),
        _block("End", _text("end", thanks(manifest, _escaped))),
    ]
    numbers = {str(number): choice.label for number, choice in enumerate(manifest.choices.labels, start=1)}
    return {
        "survey.txt": "[[AdvancedFormat]]\n\n" + "\n".join(blocks),
        "map.yaml": manifest.map_yaml(numbers),
        "README.md": template("qualtrics.md", title=manifest.title, left=listed(design_of(kit, limits(kit)))),
    }


def _numbers(code: str, sets: Iterable[Order]) -> str:
    return " and ".join(str(number) for number, codes in enumerate(sets, start=1) if code in codes)


def _required(kit: Kit) -> str:
    optional = [question.name for question in kit.manifest.demographics if not question.required]
    return f"all questions except {', '.join(optional)}" if optional else "all questions"


def _block(name: str, *questions: str) -> str:
    return f"[[Block:{name}]]\n\n" + "\n".join(questions)


def _text(name: str, text: str) -> str:
    return f"[[Question:DB]]\n[[ID:{name}]]\n{text}\n"


def _choice(name: str, text: str, choices: list[str], layout: str = "SingleAnswer:Vertical") -> str:
    choices_in_lines = "\n".join(map(_escaped, choices))
    return f"[[Question:MC:{layout}]]\n[[ID:{name}]]\n{text}\n[[Choices]]\n{choices_in_lines}\n"


def _practice(kit: Kit, video_url: str) -> list[str]:
    practice, manifest = kit.manifest.practice, kit.manifest
    if practice is None:
        return []
    text = f"{_escaped(manifest.texts.practice_note)}<br>{video_element(practice.code, video_url, _escaped)}"
    choices = [choice.text for choice in manifest.choices.labels]
    return [_block("Practice", _choice("practice", f"{text}<br>{_escaped(manifest.question)}", choices))]


def _check(check: PublicCheck, video_url: str) -> str:
    text = f"{video_element(check.video.code, video_url, _escaped)}<br>{_escaped(check.question)}"
    return _block(f"Check {check.name}", _choice(check.name, text, list(check.choices)))


def _returns(kit: Kit) -> str:
    """Return the codes and links for participants who decline or fail an attention check."""
    cases = {"after declining": kit.server.declined, "after a failed check": kit.server.failed}
    return "; ".join(f"{who}: {back.code or ''} {back.link or ''}".strip() for who, back in cases.items())


def _question(question: Question) -> str:
    text = _escaped(question.question)
    if question.choices is None:
        layout = "Essay" if question.long else "SingleLine"
        ends = f" ({question.number.low} to {question.number.high})" if question.number else ""
        return f"[[Question:TE:{layout}]]\n[[ID:{question.name}]]\n{text}{ends}\n"
    layout = "MultipleAnswer:Vertical" if question.several else "SingleAnswer:Vertical"
    return _choice(question.name, text, list(question.choices), layout)


def _video(kit: Kit, code: str, video_url: str) -> list[str]:
    manifest = kit.manifest
    text = f"{video_element(code, video_url, _escaped)}<br>{_escaped(manifest.question)}"
    questions = [_choice(code, text, [choice.text for choice in manifest.choices.labels])]
    questions += [_rating(f"{code}_{rating.name}", rating) for rating in manifest.ratings]
    return [*questions, "[[PageBreak]]\n"]


def _rating(name: str, rating: Rating) -> str:
    """Return a rating as a choice of numbers: the file cannot contain sliders."""
    ends = f"(1: {_escaped(rating.low)}, {rating.steps}: {_escaped(rating.high)})"
    layout = "SingleAnswer:Horizontal" if rating.steps <= _LONGEST_ROW else "Dropdown"
    numbers = [str(number) for number in range(1, rating.steps + 1)]
    return _choice(name, f"{_escaped(rating.question)} {ends}", numbers, layout)


def _escaped(text: str) -> str:
    """Return text as HTML that Qualtrics shows as written: ${...} is piped text, [[...]] a tag of the format."""
    return escaped(text, "$[")
