"""A survey for LimeSurvey as a tab-separated structure file: one row per setting, group, question and answer."""

import csv
import io

from emovid.errors import InputError
from emovid.kit.exports.design import (
    CHECKS,
    CHOICES,
    LANGUAGE,
    ORDERS,
    RECRUITMENT,
    REQUIREMENTS,
    REVISION,
    SETS,
    WATCHING,
    Limits,
    by_hand,
    changed,
    design_of,
    listed,
)
from emovid.kit.exports.texts import (
    Files,
    consent,
    escaped,
    paragraphs,
    template,
    thanks,
    video_element,
    way_back,
)
from emovid.kit.folder import Kit
from emovid.kit.manifest import Manifest, PublicCheck
from emovid.kit.orders import sets_of
from emovid.kit.study import Question, Requirements
from emovid.responses.labels import NONE

# Columns of the structure file: https://www.limesurvey.org/manual/Tab_Separated_Value_survey_structure
_COLUMNS = (
    "id", "related_id", "class", "type/scale", "name", "relevance", "text", "help", "language", "validation",
    "mandatory", "encrypted", "other", "default", "same_default", "random_group", "answer_order", "hidden",
    "min_num_value_n", "max_num_value_n", "num_value_int_only",
    "slider_min", "slider_max", "slider_accuracy", "slider_layout", "slider_separator",
)  # fmt: skip
_AGREED = "consent.NAOK == 'Y'"  # in LimeSurvey's ExpressionScript
_SET = "videoset"
# Names of questions that LimeSurvey renames on import, and names of this export's own questions.
_RESERVED = ("self", "that", "this", "practice", _SET)
# Codes of LimeSurvey's languages: the file surveytranslator_helper.php of its source.
_LANGUAGES = (
    "af am ar az be bg bn bs ca ceb ckb cnr cs cy da de el en es et eu fa fi fil fr gl gu he hi hil hr hu hy id ie "
    "ike ilo is it ja ka kal kk kmr kn ko ky lb lt lv mk ml mn mr ms mt mya nb nl nn ny oc pa pl prs ps pt ro roh ru "
    "run rw sah si sk sl smi so sq sr sv swh ta te tg th ti tl tr ug uk ur vi xho yor zu "
    "es-AR es-CL es-CO es-MX pt-BR sr-Latn zh-Hans zh-Hant-HK zh-Hant-TW"
)
_OTHER_CODES = {"zh": "zh-Hans", "zh-TW": "zh-Hant-TW", "zh-Hant": "zh-Hant-TW", "zh-HK": "zh-Hant-HK"}
_OTHER_CODES |= {"no": "nb", "sw": "swh", "ku": "kmr", "my": "mya", "ga": "ie"}

Row = dict[str, object]


def limits(kit: Kit) -> Limits:
    """Return the parts of the design that LimeSurvey does not carry as they are."""
    found = {
        WATCHING: by_hand("LimeSurvey cannot require it: ask for it in the instructions, or add JavaScript."),
        REVISION: changed("Participants can go back page by page."),
    }
    if kit.manifest.order_scheme != "random":
        found[ORDERS] = changed("LimeSurvey draws a random order for each participant: balanced only on average.")
    if len(sets_of(kit.orders.values())) > 1:
        found[SETS] = changed(f"The hidden question {_SET} draws a set for each participant: equal only on average.")
    if len(sets_of(kit.orders.values())) > 1 and kit.manifest.checks:
        found[CHECKS] = changed("Their places count the groups of all sets, of which a participant sees some.")
    language = kit.manifest.language
    if (code := language_code(language)) is None:
        found[LANGUAGE] = by_hand(f"LimeSurvey has no language {language}: its own buttons and messages are English.")
    elif code != language:
        found[LANGUAGE] = changed(f"LimeSurvey's code is {code}.")
    if kit.manifest.recruitment:
        note = "Settings, Panel integration: add the parameters. In the return link, write {PASSTHRU:NAME} for {NAME}."
        found[RECRUITMENT] = by_hand(note)
    if kit.manifest.requirements != Requirements(text=kit.manifest.requirements.text):
        found[REQUIREMENTS] = by_hand("LimeSurvey does not check them: ask for them in the text of the first page.")
    if kit.manifest.choices.order == "random":
        found[CHOICES] = changed("LimeSurvey draws an order for each video, and does not record it.")
    return found


def limesurvey(kit: Kit, video_url: str) -> Files:
    """Return the structure file, with the videos at an address, and a README.

    Raises:
        InputError: if two questions would get the same name, or a question a reserved one.
    """
    manifest = kit.manifest
    rows = [*_settings(kit), *_first_groups(kit), *_practice(manifest, video_url)]
    sets = list(sets_of(kit.orders.values()))
    for place, code in enumerate(manifest.codes):
        rows += [row for check in manifest.checks if check.after == place for row in _check(check, video_url)]
        seen = [str(number) for number, codes in enumerate(sets, start=1) if code in codes]
        shown = _AGREED if len(sets) == 1 else f"{_AGREED} and ({' or '.join(f'{_SET}.NAOK == {n}' for n in seen)})"
        rows.append({"class": "G", "name": code, "relevance": shown, "random_group": "videos"})
        rows += _video(manifest, code, video_url)
    last = len(manifest.codes)
    rows += [row for check in manifest.checks if check.after >= last for row in _check(check, video_url)]
    if manifest.questions_after:
        rows.append({"class": "G", "name": "Last questions", "relevance": _AGREED})
        rows += [row for question in manifest.questions_after for row in _question(question)]
    for question in (*manifest.demographics, *manifest.questions_after):
        if question.name in _RESERVED:
            raise InputError(f"{kit.folder.manifest}: {question.name} is a reserved name in this export; rename it")
    names = [str(row["name"]) for row in rows if row["class"] == "Q"]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{kit.folder.manifest}: two questions would be called {name}; rename that of the study")
    words = {_escaped(choice.text): choice.label for choice in manifest.choices.labels} | _codes(manifest)
    return {
        "survey.txt": _table(rows, language_code(manifest.language) or "en"),
        "map.yaml": manifest.map_yaml(words),
        "README.md": template("limesurvey.md", title=manifest.title, left=listed(design_of(kit, limits(kit)))),
    }


def question_name(name: str) -> str:
    """Return a name in LimeSurvey, which allows only letters and digits: `age_1` becomes ageU1, `age1` stays."""
    return name.replace("_", "U")  # names in studies are lowercase


def language_code(language: str) -> str | None:
    """Return LimeSurvey's code of a language such as zh or pt-BR, or None if it does not have that language."""
    known = {code.casefold(): code for code in _LANGUAGES.split()}
    known |= {code.casefold(): other for code, other in _OTHER_CODES.items()}
    parts = language.casefold().split("-")
    tags = ("-".join(parts[:count]) for count in range(len(parts), 0, -1))
    return next((known[tag] for tag in tags if tag in known), None)


def _settings(kit: Kit) -> list[Row]:
    manifest, server = kit.manifest, kit.server
    agreed = f"'{thanks(manifest, _escaped)}'"
    if server.failed.code or server.failed.link:
        passed = " and ".join(
            f"{question_name(check.name)}.NAOK == '{_right(kit, check)}'" for check in manifest.checks
        )
        failed = paragraphs(manifest.thanks.text, _escaped)
        failed += way_back(manifest, server.failed.code, server.failed.link, _escaped)
        agreed = f"if({passed or 1}, {agreed}, '{failed}')"
    declined = paragraphs(manifest.consent.declined, _escaped)
    declined += way_back(manifest, server.declined.code, server.declined.link, _escaped)
    end = f"{{if({_AGREED}, {agreed}, '{declined}')}}"
    return [
        {"class": "S", "name": "language", "text": language_code(manifest.language) or "en"},
        {"class": "S", "name": "format", "text": "G"},
        {"class": "S", "name": "allowprev", "text": "Y"},
        {"class": "S", "name": "showgroupinfo", "text": "X"},  # groups are named for researchers, in English
        {"class": "SL", "name": "surveyls_title", "text": _escaped(manifest.title)},
        {"class": "SL", "name": "surveyls_endtext", "text": end},
    ]


def _first_groups(kit: Kit) -> list[Row]:
    """Return consent, questions about the participant, the draw of a set, and instructions."""
    manifest = kit.manifest
    agreement = dict(zip("YN", (manifest.consent.agree, manifest.consent.decline), strict=True))
    rows: list[Row] = [
        {"class": "G", "name": "Consent"},
        *_choice("consent", consent(manifest, _escaped), agreement),
    ]
    if manifest.demographics:
        rows.append({"class": "G", "name": "About you", "relevance": _AGREED})
        rows += [row for question in manifest.demographics for row in _question(question)]
    rows.append({"class": "G", "name": "Instructions", "relevance": _AGREED})
    if (sets := len(sets_of(kit.orders.values()))) > 1:
        draw = f"{{if(is_empty({_SET}.NAOK), rand(1, {sets}), {_SET}.NAOK)}}"  # drawn once: pages are evaluated again
        rows.append({"class": "Q", "type/scale": "*", "name": _SET, "text": draw, "mandatory": "N", "hidden": 1})
    text = _named("instructions", paragraphs(manifest.instructions, _escaped))
    return [*rows, {"class": "Q", "type/scale": "X", "name": "instructions", "text": text}]


def _video(manifest: Manifest, code: str, video_url: str) -> list[Row]:
    video = video_element(code, video_url, _escaped)
    order = {"answer_order": "random"} if manifest.choices.order == "random" else {}
    answers = {code: choice.text for code, choice in zip(_codes(manifest), manifest.choices.labels, strict=True)}
    rows = _choice(code, f"{video}{paragraphs(manifest.question, _escaped)}", answers, order=order)
    for rating in manifest.ratings:
        slider = {"slider_min": 1, "slider_max": rating.steps, "slider_accuracy": 1}
        ends = {"slider_layout": 1, "slider_separator": "|"}
        text = _named(f"{code}_{rating.name}", _escaped(rating.question))
        question: Row = {"class": "Q", "type/scale": "K", "name": f"{code}{rating.name}", "text": text}
        rows += [question | {"mandatory": "Y"} | slider | ends]
        rows += [{"class": "SQ", "name": "SQ1", "text": f"|{_escaped(rating.low)}|{_escaped(rating.high)}"}]
    return rows


def _practice(manifest: Manifest, video_url: str) -> list[Row]:
    if manifest.practice is None:
        return []
    note = f"<p>{_escaped(manifest.texts.practice_note)}</p>"
    text = (
        f"{note}{video_element(manifest.practice.code, video_url, _escaped)}{paragraphs(manifest.question, _escaped)}"
    )
    answers = {code: choice.text for code, choice in zip(_codes(manifest), manifest.choices.labels, strict=True)}
    return [{"class": "G", "name": "Practice", "relevance": _AGREED}, *_choice("practice", text, answers)]


def _check(check: PublicCheck, video_url: str) -> list[Row]:
    text = f"{video_element(check.video.code, video_url, _escaped)}{paragraphs(check.question, _escaped)}"
    answers = {f"A{number}": choice for number, choice in enumerate(check.choices, start=1)}
    return [{"class": "G", "name": "Check", "relevance": _AGREED}, *_choice(check.name, text, answers)]


def _right(kit: Kit, check: PublicCheck) -> str:
    """Return the code of the right answer to an attention check."""
    return f"A{check.choices.index(kit.server.answers[check.name]) + 1}"


def _question(question: Question) -> list[Row]:
    if question.choices is not None and question.several:
        text = _named(question.name, _escaped(question.question))
        row: Row = {"class": "Q", "type/scale": "M", "name": question_name(question.name), "text": text}
        listed = enumerate(question.choices, start=1)
        choices: list[Row] = [{"class": "SQ", "name": f"A{number}", "text": _escaped(one)} for number, one in listed]
        return [row | {"mandatory": "Y" if question.required else "N"}, *choices]
    if question.choices is not None:
        answers = {f"A{number}": choice for number, choice in enumerate(question.choices, start=1)}
        return _choice(question.name, _escaped(question.question), answers, needed=question.required)
    needed = "Y" if question.required else "N"
    text = _named(question.name, _escaped(question.question))
    name = question_name(question.name)
    kind = "N" if question.number else "T" if question.long else "S"
    limits: Row = {}
    if question.number:
        ends = {"min_num_value_n": question.number.low, "max_num_value_n": question.number.high}
        limits = {**ends, "num_value_int_only": 1}
    return [{"class": "Q", "type/scale": kind, "name": name, "text": text, "mandatory": needed} | limits]


def _choice(
    name: str, text: str, answers: dict[str, str], *, needed: bool = True, order: dict[str, str] | None = None
) -> list[Row]:
    question: Row = {"class": "Q", "type/scale": "L", "name": question_name(name), "text": _named(name, text)}
    question |= {"mandatory": "Y" if needed else "N"} | (order or {})
    return [question] + [
        {"class": "A", "type/scale": 0, "name": code, "text": _escaped(answer)} for code, answer in answers.items()
    ]


def _named(name: str, text: str) -> str:
    """Return a question's text after its name, which participants do not see, and exports with full texts keep."""
    return f"<span style='display:none'>{name}: </span>{text}"


def _escaped(text: str) -> str:
    r"""Return text as HTML that LimeSurvey shows as written.

    Braces are ExpressionScript, a bar ends the label of a slider, and PHP reads \\" in a table as one character.
    """
    return escaped(text, "{}|\\")


def _codes(manifest: Manifest) -> dict[str, str]:
    """Return the label of each answer code, which has at most five characters."""
    labels = enumerate((choice.label for choice in manifest.choices.labels), start=1)
    return {"AN" if label == NONE else f"A{number}": label for number, label in labels}


def _table(rows: list[Row], language: str) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, _COLUMNS, delimiter="\t", lineterminator="\n", restval="")
    writer.writeheader()
    for number, row in enumerate(rows, start=1):
        writer.writerow({"id": number, "relevance": "1", "language": "" if row["class"] == "S" else language} | row)
    return "\ufeff" + text.getvalue()
