"""A small study with 8 participants and 6 videos in the export format of each tool, with typical irregularities."""

import csv
import io
import json
from dataclasses import dataclass, field

import pandas as pd

EMOTIONS = ("happiness", "surprise", "anger", "fear", "disgust", "sadness")
CODES = dict(zip(("z8r4", "k2m9", "p5t1", "w7c3", "h6x8", "q4n2"), EMOTIONS, strict=True))
PEOPLE = tuple(f"P{i:02}" for i in range(1, 9))
GENDER = {person: "Female" if i % 3 == 0 else "Male" for i, person in enumerate(PEOPLE)}
KEY = "video_code,true_emotion\n" + "".join(f"{code},{emotion}\n" for code, emotion in CODES.items())
QUESTION = "Which emotion best describes the movement of the robots in the video?"


def answer(i: int, j: int) -> str:
    """Return the answer of participant i to video j: mostly right, otherwise a neighboring label."""
    return EMOTIONS[j if (i + j) % 3 else (j + i + 1) % 6]


ANSWERS = {p: {code: answer(i, j) for j, code in enumerate(CODES)} for i, p in enumerate(PEOPLE)}
ORDER = {p: [list(CODES)[(i + k) % 6] for k in range(6)] for i, p in enumerate(PEOPLE)}
COUNTS = [
    [sum(ANSWERS[p][code] == label for p in PEOPLE) for code in CODES] for label in EMOTIONS
]  # rows perceived, columns signaled
ADJECTIVES = dict(zip(EMOTIONS, ("Happy", "Surprised", "angry ", "Afraid", "DISGUSTED", "Sad"), strict=True))
NUMBERS = {label: str(i) for i, label in enumerate(EMOTIONS, start=1)}


@dataclass
class Export:
    """Files of an export, the map and options they need, and the expected result."""

    files: dict[str, bytes]
    dialect: str
    map: str = ""
    dropped: dict[str, int] = field(default_factory=dict)
    gender: str = "gender"
    positions: bool = False
    skipped: int = 0
    left_out: dict[str, int] = field(default_factory=dict)


def table(rows, delimiter=",", eol="\r\n", quoting=csv.QUOTE_MINIMAL) -> str:
    out = io.StringIO(newline="")
    csv.writer(out, delimiter=delimiter, lineterminator=eol, quoting=quoting).writerows(rows)
    return out.getvalue()


def quoted(rows, **how) -> str:
    return table(rows, quoting=csv.QUOTE_ALL, **how)


def map_of(labels: dict[str, str]) -> str:
    return "answers:\n" + "".join(f"  {cell!r}: {label}\n" for label, cell in labels.items())


IN_ORDER = f"videos: [{', '.join(CODES)}]\n"


def wide(head, row, titles, spell=lambda label: label):
    """Return header and rows: the first columns of the tool, gender, and the answers."""
    rows = [[*head, "What is your gender?", *titles]]
    rows += [[*row(i, p), GENDER[p], *(spell(ANSWERS[p][code]) for code in CODES)] for i, p in enumerate(PEOPLE)]
    return rows


def own() -> Export:
    rows = [["participant", "video", "position", "response", "gender", "status"]]
    for p in PEOPLE:
        rows += [[p, code, k, ANSWERS[p][code], GENDER[p], "complete"] for k, code in enumerate(ORDER[p], start=1)]
    rows += [["X1", "z8r4", 1, "fear", "Male", "test"], ["X2", "z8r4", 1, "fear", "Male", "partial"]]
    return Export({"own.csv": table(rows).encode()}, "emovid survey", "", {"test run": 1, "partial": 1}, positions=True)


def generic_long() -> Export:
    rows = [["clip file", "who", "felt", "Gender", "seconds"]]
    for p in PEOPLE:
        rows += [[f"videos/{c}.mp4", p, ADJECTIVES[ANSWERS[p][c]], GENDER[p], "3,2"] for c in ORDER[p]]
    data = ("sep=;\n" + table(rows, delimiter=";", eol="\r")).encode("cp1252")
    return Export({"long.csv": data}, "long table", "participant: who\n")


def generic_wide() -> Export:
    rows = wide(["id", "Grüße"], lambda _, p: [p, "né"], [f"video {c}" for c in CODES], ADJECTIVES.get)
    rows[0] += [f"{c}_rt" for c in CODES] + [f"{c}_position" for c in CODES]
    for p, row in zip(PEOPLE, rows[1:], strict=True):
        row.extend([str(1000 + j) for j in range(6)] + [str(ORDER[p].index(c) + 1) for c in CODES])
    return Export({"wide.csv": table(rows, delimiter="\t").encode("cp1252")}, "wide table", positions=True)


def google_sheets() -> Export:
    rows = wide(["Timestamp"], lambda i, _: [f"3/{i + 1}/2026 9:19:47"], [QUESTION] * 6)
    return Export({"form.csv": table(rows).encode()}, "Google Forms", IN_ORDER)


def google_direct() -> Export:
    titles = [f"{QUESTION[:-1]} {code}?" for code in CODES]
    rows = wide(["Timestamp"], lambda i, _: [f"2026/03/0{i + 1} 9:19:47 AM GMT-5"], titles, str.title)
    rows[0].append("Which robots do you know?")
    rows[1:] = [[*row, "Roomba;Spot"] for row in rows[1:]]
    return Export({"form.csv": quoted(rows).encode()}, "Google Forms")


def microsoft() -> Export:
    head = ["ID", "Start time", "Completion time", "Email", "Name"]
    titles = [QUESTION + (str(j) if j > 1 else "") + "\u00a0" for j in range(1, 7)]
    row = lambda i, _: [i + 1, f"3/2/26 9:1{i}:00", f"3/2/26 9:2{i}:00", "anonymous", ""]  # noqa: E731
    rows = wide(head, row, titles, lambda label: label + ";")
    return Export({"forms.csv": table(rows, delimiter=";").encode("utf-8-sig")}, "Microsoft Forms", IN_ORDER)


QUALTRICS = ["StartDate", "EndDate", "Status", "IPAddress", "Progress", "Finished", "RecordedDate", "ResponseId"]


def _qualtrics_rows(titles, texts, status, finished, spell, extra=lambda _: []):
    def meta(i, kind, progress, done):
        return ["2026-03-02 09:00:00", "2026-03-02 09:10:00", kind, "1.2.3.4", progress, done, "2026-03-02", f"R_{i}"]

    ids = [json.dumps({"ImportId": f"QID{j}"}) for j in range(len(QUALTRICS) + 1 + len(titles))]
    ids[0] = json.dumps({"ImportId": "startDate", "timeZone": "America/Denver"})
    rows = [[*QUALTRICS, "Q1", *titles], ["Startdatum", *QUALTRICS[1:], "What is your\ngender?", *texts], ids]
    for i, p in enumerate(PEOPLE):
        row = [*meta(i, status[0], 100, finished[0]), GENDER[p], *(spell(ANSWERS[p][c]) for c in CODES)]
        rows.append([*row, *extra(p)])
    fill = ["Male", *([spell("fear")] * 6), *extra("P01")]
    rows += [[*meta(90, status[1], 100, finished[0]), *fill], [*meta(91, status[0], 40, finished[1]), *fill]]
    return rows


def qualtrics() -> Export:
    titles, texts = [f"Q{j + 2}" for j in range(6)] + ["FL_7_DO"], [f"{QUESTION} [{c}]" for c in CODES] + ["FL_7"]
    rows = _qualtrics_rows(
        titles, texts, ("IP Address", "Survey Preview"), ("True", "False"), str, lambda p: ["|".join(ORDER[p])]
    )
    data = table(rows, eol="\n").encode("utf-8-sig")
    return Export({"q.csv": data}, "Qualtrics", "groups: {gender: Q1}\n", {"preview": 1, "partial": 1}, positions=True)


def qualtrics_numeric_tsv() -> Export:
    titles = [f"Q{j + 2}" for j in range(6)] + [f"FL_7_DO_{c}" for c in CODES]
    texts = [f"{QUESTION} [{c}]" for c in CODES] + ["FL_7"] * 6
    rows = _qualtrics_rows(
        titles, texts, ("0", "1"), ("1", "0"), NUMBERS.get, lambda p: [ORDER[p].index(c) + 1 for c in CODES]
    )
    data = table(rows, delimiter="\t", eol="\n").encode("utf-16")
    said = map_of(NUMBERS) + "groups: {gender: Q1}\n"
    return Export({"q.tsv": data}, "Qualtrics", said, {"preview": 1, "partial": 1}, positions=True)


def qualtrics_loop() -> Export:
    titles = [f"{j + 1}_Q5" for j in range(6)] + ["Q5_DO"]
    texts = [f"{c} - {QUESTION}" for c in CODES] + ["order"]
    loop = lambda p: ["|".join(str(list(CODES).index(c) + 1) for c in ORDER[p])]  # noqa: E731
    rows = _qualtrics_rows(titles, texts, ("IP Address", "Survey Preview"), ("True", "False"), str, loop)
    data = table(rows, eol="\n").encode()
    return Export({"q.csv": data}, "Qualtrics", "groups: {gender: Q1}\n", {"preview": 1, "partial": 1}, positions=True)


def qualtrics_legacy() -> Export:
    head = ["ResponseID", "ResponseSet", "Name", "StartDate", "EndDate", "Status", "Finished"]
    rows = [[*(f"V{i}" for i in range(1, 8)), "Q1", *(f"Q{j}" for j in range(2, 8)), ""]]
    rows.append([*head, "gender", *(f"{c}: {QUESTION}" for c in CODES), ""])
    for i, p in enumerate(PEOPLE):
        rows.append([f"R_{i}", "Default", "Anonymous", "2016", "2016", "0", "1", GENDER[p], *ANSWERS[p].values(), ""])
    rows.append(["R_9", "Default", "Anonymous", "2016", "2016", "0", "0", "Male", *["fear"] * 6, ""])
    return Export({"q.csv": table(rows).encode("utf-8-sig")}, "Qualtrics", "groups: {gender: Q1}\n", {"partial": 1})


def _lime(head, titles, spell, delimiter=",", timing=()):
    rows = [[*head, *titles, *timing]]
    for i, p in enumerate(PEOPLE):
        answers = [spell(ANSWERS[p][c]) for c in CODES]
        seconds = [f"{j}.5" for j in range(len(timing))]
        rows.append([str(i + 1), "1980-01-01 00:00:00", "3", "en", "123456", GENDER[p], *answers, *seconds])
    rows.append(["9", "", "1", "en", "123", "Male", *["-oth-"] * 6, *["1"] * len(timing)])
    return "\ufeff" + quoted(rows, delimiter=delimiter).replace('""', "") + "\r\n"


def limesurvey() -> Export:
    head = ["Response ID", "Date submitted", "Last page", "Start language", "Seed", "What is your gender?"]
    text = _lime(head, [f"{QUESTION} [{c}]" for c in CODES], str.capitalize)
    return Export({"results.csv": text.encode()}, "LimeSurvey", "", {"partial": 1})


def limesurvey_codes() -> Export:
    head = ["id", "submitdate", "lastpage", "startlanguage", "seed", "gender"]
    codes = {label: f"A{i}" for label, i in NUMBERS.items()}
    timing = ["interviewtime", "groupTime1", *(f"{c}Time" for c in CODES)]
    text = _lime(head, CODES, codes.get, ";", timing)
    return Export({"results.csv": text.encode()}, "LimeSurvey", map_of(codes), {"partial": 1})


def limesurvey_both() -> Export:
    head = ["id. Response ID", "submitdate. Date submitted", "lastpage. Last page", "startlanguage. Start language"]
    head += ["seed. Seed", "gender. What is your gender?"]
    text = _lime(head, [f"V[{c}]. {QUESTION} [{c}]" for c in CODES], lambda label: NUMBERS[label] + ".0000000000")
    return Export({"results.csv": text.encode()}, "LimeSurvey", map_of(NUMBERS), {"partial": 1})


MONKEY = ["Respondent ID", "Collector ID", "Date Created", "Date Modified", "IP Address", "Email Address"]


def surveymonkey() -> Export:
    row = lambda i, _: [f"1180{i}", "44", "03/02/2026", "03/02/2026", "", ""]  # noqa: E731
    rows = wide(MONKEY, row, [f"Video {c}: {QUESTION}" for c in CODES])
    rows.insert(1, [""] * len(MONKEY) + ["Response"] * 7)
    return Export({"monkey.csv": table(rows).encode()}, "SurveyMonkey")


def surveymonkey_expanded() -> Export:
    heads, options = [*MONKEY], [""] * len(MONKEY)
    for title, choices in [("gender", ("Female", "Male"))] + [(f"Video {c}", EMOTIONS) for c in CODES]:
        heads += [title] + [""] * (len(choices) - 1)
        options += choices
    rows = [heads, options]
    for i, p in enumerate(PEOPLE):
        ticks = [g if GENDER[p] == g else "" for g in ("Female", "Male")]
        ticks += [label if ANSWERS[p][c] == label else "" for c in CODES for label in EMOTIONS]
        rows.append([f"1180{i}", "44", "03/02/2026", "03/02/2026", "", "", *ticks])
    return Export({"monkey.csv": table(rows).encode()}, "SurveyMonkey")


def _js_trials(p, named):
    base = {"subject": p} if named else {}
    trials = [{"trial_type": "html-button-response", "stimulus": "<p>Welcome, friend</p>", "response": "0"}]
    trials.append({"trial_type": "survey-multi-choice", "rt": "null", "response": {"gender": GENDER[p]}})
    for c in ORDER[p]:
        response = EMOTIONS.index(ANSWERS[p][c])
        trials.append({"trial_type": "video-button-response", "stimulus": [f"videos/{c}.mp4"], "response": response})
    trials.append({"trial_type": "html-keyboard-response", "stimulus": "Thanks", "response": None})
    return [{"trial_index": i, **trial, **base} for i, trial in enumerate(trials)]


def _js_csv(trials):
    names = list(dict.fromkeys(name for trial in trials for name in trial))
    text = lambda v: v if isinstance(v, str) else json.dumps(v, separators=(",", ":"))  # noqa: E731
    rows = [names] + [[text(trial[name]) if name in trial else "" for name in names] for trial in trials]
    return quoted(rows).encode()


JS_MAP = "answers:\n" + "".join(f"  {i}: {label}\n" for i, label in enumerate(EMOTIONS))


def jspsych() -> Export:
    trials = [trial for p in PEOPLE for trial in _js_trials(p, True)]
    return Export({"all.csv": _js_csv(trials)}, "jsPsych", JS_MAP, positions=True)


def jspsych_files() -> Export:
    files = {f"{p}.csv": _js_csv(_js_trials(p, False)) for p in PEOPLE}
    files["P01.json"] = json.dumps(_js_trials("P01", False)).encode()
    files["P99.csv"] = b""
    return Export(files, "jsPsych", JS_MAP, positions=True, skipped=2)


def jspsych_json() -> Export:
    lists = [json.dumps(_js_trials(p, True)) for p in PEOPLE]
    return Export({"jatos.txt": "\n".join(lists).encode()}, "jsPsych", JS_MAP, positions=True)


def _psychopy(trailing, bom, eol, last_eol):
    files = {}
    head = ["videoFile", "trials.thisRepN", "trials.thisTrialN", "trials.thisN", "trials.thisIndex", "mouse.clicks"]
    head += ["key_resp.keys", "key_resp.rt", "participant", "gender", "date", "expName", "psychopyVersion", "frameRate"]
    for p in PEOPLE:
        info = [p, GENDER[p], "2026-03-02_09h", "emotions", "2026.2.5", "60.0"]
        rows = [["", "", "", "", "", "", "None", "", *info]]
        for n, c in enumerate(ORDER[p]):
            keys = NUMBERS[ANSWERS[p][c]]
            rows.append([f"stim/{c}.mp4", "0", str(n), str(n), str(n), '["a","b"]', keys, "1.5", *info])
        lines = [",".join(f'"{cell}"' if "," in cell else cell for cell in row) + trailing for row in [head, *rows]]
        text = eol.join(lines) + (eol if last_eol else "")
        files[f"{p}_emotions_2026.csv"] = text.encode("utf-8-sig" if bom else "utf-8")
    return files


def psychopy() -> Export:
    said = map_of(NUMBERS)
    return Export(_psychopy(",", True, "\n", True), "PsychoPy or Pavlovia", said, positions=True)


def pavlovia() -> Export:
    said = map_of(NUMBERS)
    return Export(_psychopy("", True, "\n", False), "PsychoPy or Pavlovia", said, positions=True)


OTREE = ["participant.id_in_session", "participant.code", "participant._is_bot", "participant._index_in_pages"]
OTREE += ["participant._max_page_index", "session.is_demo"]


def otree_wide() -> Export:
    head = [*OTREE, "intro.1.player.id_in_group", "intro.1.player.gender"]
    for n in range(1, 7):
        head += [f"study.{n}.player.id_in_group", f"study.{n}.player.video", f"study.{n}.player.response"]
    rows = [head]
    for i, p in enumerate(PEOPLE):
        cells = [cell for c in ORDER[p] for cell in (1, c, ANSWERS[p][c])]
        rows.append([i + 1, p, 0, 9, 9, 0, 1, GENDER[p], *cells])
    other = [1, "Male", *[1, "z8r4", "fear"] * 6]
    rows += [[9, "b1", 1, 9, 9, 0, *other], [10, "u1", 0, 3, 9, 0, *other], [11, "d1", 0, 9, 9, 1, *other]]
    dropped = {"bot": 1, "partial": 1, "test run": 1}
    return Export({"all_apps_wide.csv": table(rows).encode()}, "oTree", "", dropped, positions=True)


def otree_app() -> Export:
    rows = [
        [*OTREE, "player.id_in_group", "player.video", "player.response", "player.gender", "group.id_in_subsession"]
    ]
    rows[0].append("subsession.round_number")
    for i, p in enumerate(PEOPLE):
        rows += [[i + 1, p, 0, 9, 9, 0, 1, c, ANSWERS[p][c], GENDER[p], 1, n] for n, c in enumerate(ORDER[p], start=1)]
    rows.append([9, "b1", 1, 9, 9, 0, 1, "z8r4", "fear", "Male", 1, 1])
    return Export({"study.csv": table(rows).encode()}, "oTree", "", {"bot": 1}, positions=True)


def labjs() -> Export:
    rows = [["duration", "gender", "meta", "participant", "response", "sender", "sender_type", "timestamp", "video"]]
    for p in PEOPLE:
        meta = json.dumps({"labjs_version": "23.0", "url": "x,y"})
        rows.append([10, GENDER[p], meta, p, "", "Start", "html.Form", "2026-03-02T09:00:00", ""])
        for k, c in enumerate(ORDER[p]):
            rows.append([900, GENDER[p], "", p, ANSWERS[p][c], "Q", "html.Form", f"2026-03-02T09:0{k + 1}:00", c])
            rows.append([950, GENDER[p], "", p, "", "Trial", "flow.Sequence", f"2026-03-02T09:0{k + 1}:30", c])
        rows.append([9000, GENDER[p], "'=1+1", p, "", "Loop", "flow.Loop", "2026-03-02T09:09:00", ""])
    return Export({"labjs.csv": table(rows).removesuffix("\r\n").encode()}, "lab.js", positions=True)


def psiturk() -> Export:
    trials, questions, events = [], [], []
    for p in [*PEOPLE, "debugA"]:
        person = f"{p}:A{p}"
        trials.append([person, 0, 1700000000, json.dumps({"phase": "INSTRUCTIONS"})])
        for k, c in enumerate(ORDER.get(p, ORDER["P01"]), start=1):
            data = {"phase": "TEST", "video": c, "response": ANSWERS.get(p, ANSWERS["P01"])[c]}
            trials.append([person, k, 1700000000 + k, json.dumps(data)])
        questions.append([person, "gender", GENDER.get(p, "Male")])
        events.append([person, "focus", 12, "on", 1700000000])
    files = {"trialdata.csv": trials, "questiondata.csv": questions, "eventdata.csv": events}
    encoded = {name: table(rows, eol="\n").encode() for name, rows in files.items()}
    export = Export(encoded, "psiTurk", "", {"test run": 1}, positions=True, skipped=1)
    export.left_out = {"practice": 8}
    return export


def pymushra() -> Export:
    rows = [["responses_time", "questionnaire_gender", "responses_stimulus", "session_uuid", "responses_response"]]
    rows += [[1.5, GENDER[p], c, f"uuid-{p}", ANSWERS[p][c]] for p in PEOPLE for c in CODES]
    return Export({"mushra.csv": table(rows, delimiter=";", eol="\n").encode()}, "pymushra")


def formr() -> Export:
    rows = [["session", "session_id", "created", "modified", "ended", "expired", "gender", *CODES]]
    for p in PEOPLE:
        numbers = [NUMBERS[ANSWERS[p][c]] for c in CODES]
        rows.append([f"tok{p}", "1", "2026-03-02", "2026-03-02", "2026-03-02", "", GENDER[p], *numbers])
    rows.append(["tokU", "1", "2026-03-02", "2026-03-02", "", "2026-03-03", "Male", *"222222"])
    rows.append(["KindFoxXXX1", "1", "2026-03-02", "2026-03-02", "2026-03-02", "", "Male", *"222222"])
    data = quoted(rows, delimiter=";", eol="\n").encode()
    return Export({"formr.csv": data}, "formr", map_of(NUMBERS), {"partial": 1, "test run": 1})


def revisit() -> Export:
    rows = [["participantId", "trialId", "trialOrder", "responseId", "answer", "correctAnswer", "status"]]
    for p in [*PEOPLE, "X9"]:
        status = "in-progress" if p == "X9" else "completed"
        rows.append([p, "demographics", "0", "gender", GENDER.get(p, "Male"), "", status])
        for k, c in enumerate(ORDER.get(p, ORDER["P01"]), start=1):
            rows.append([p, c, k, "emotion", ANSWERS.get(p, ANSWERS["P01"])[c], CODES[c], status])
            rows.append([p, c, k, "confidence", "4", "", status])
    return Export({"tidy.csv": table(rows, eol="\n").encode()}, "reVISit", "", {"partial": 1}, positions=True)


def jspsych_6() -> Export:
    head = ["rt", "stimulus", "button_pressed", "trial_type", "trial_index", "internal_node_id", "subject", "responses"]
    rows = [head]
    for p in PEOPLE:
        rows.append(["900", "<p>Hi</p>", "0", "html-button-response", "0", "0.0-0.0", p, ""])
        rows.append(["9000", "", "", "survey-multi-choice", "1", "0.0-1.0", p, json.dumps({"gender": GENDER[p]})])
        for k, c in enumerate(ORDER[p], start=2):
            pressed, node = EMOTIONS.index(ANSWERS[p][c]), f"0.0-2.0-{k}.0"
            rows.append(["1700.4", f'["videos/{c}.mp4"]', pressed, "video-button-response", k, node, p, ""])
    return Export({"all.csv": quoted(rows).encode()}, "jsPsych", JS_MAP, positions=True)


def opensesame() -> Export:
    head = ["count_experimental_loop", "correct_response", "gender", "live_row", "opensesame_version", "practice"]
    head += ["response", "response_time", "response_emotion_key", "subject_nr", "subject_parity", "video"]
    files = {}
    for i, p in enumerate(PEOPLE):

        def row(k, c, answer, practice, i=i, p=p):
            key = NUMBERS[answer]
            return [k, "NA", GENDER[p], k, "4.0.13", practice, key, "812", key, i, i % 2, f"{c}.mp4"]

        rows = [head, row(0, "z8r4", "fear", "yes"), row(1, "k2m9", "fear", "yes")]
        rows += [row(k, c, ANSWERS[p][c], "no") for k, c in enumerate(ORDER[p], start=2)]
        files[f"subject-{i}.csv"] = quoted(rows, eol="\n").encode()
    return Export(files, "OpenSesame", map_of(NUMBERS), left_out={"practice": 16}, positions=True)


def eprime() -> Export:
    head = ["ExperimentName", "Subject", "Session", "gender", "Procedure[Block]", "Trial", "Video", "Question.RESP"]
    rows = [[*head, "Question.RT", "Question.CRESP"]]
    for i, p in enumerate(PEOPLE, start=1):
        about = ["emo", i, 1, GENDER[p]]
        rows.append([*about, "PracticeProc", 1, "z8r4.mp4", 5, 900, 1])
        rows += [[*about, "MainProc", k, f"{c}.mp4", NUMBERS[ANSWERS[p][c]], 900, NUMBERS[CODES[c]]]
                 for k, c in enumerate(ORDER[p], start=1)]  # fmt: skip
    data = "C:\\Data\\merged.emrg3\r\n" + table(rows, delimiter="\t")
    export = Export({"merged.txt": data.encode("utf-16")}, "E-Prime", map_of(NUMBERS), positions=True)
    export.left_out = {"practice": 8}
    return export


def gorilla() -> Export:
    head = ["Event Index", "UTC Timestamp", "Participant Public ID", "Participant Private ID", "Participant Status"]
    head += ["Task Name", "Trial Number", "Screen Name", "Zone Type", "Reaction Time", "Response", "Attempt", "Correct"]
    rows = [[*head, "display", "ANSWER", "video", "gender"]]
    for i, p in enumerate([*PEOPLE, "X1", "X2"]):
        status = {"X1": "rejected", "X2": "in progress"}.get(p, "complete")
        about = ["1", "1588000000", "BLIND", str(900 + i), status, "emotions"]
        sex = GENDER.get(p, "Male")
        rows.append(
            [*about, "1", "Screen 1", "response_button_text", "900", "Fear", "1", "0", "practice", "", "z8r4.mp4", sex]
        )
        for k, c in enumerate(ORDER.get(p, ORDER["P01"]), start=1):
            right = [CODES[c], f"{c}.mp4", sex]
            rows.append([*about, k, "Video", "content_video", "3000.1", "VIDEO STARTED", "", "", "main", *right])
            label = ANSWERS.get(p, ANSWERS["P01"])[c].title()
            rows.append([*about, k, "Answer", "response_button_text", "812.5", label, "1", "1", "main", *right])
        rows.append([*about, "END TASK", *[""] * (len(rows[0]) - len(about) - 1)])
    rows.append(["END OF FILE", *[""] * (len(rows[0]) - 1)])
    dropped = {"partial": 1, "rejected": 1}
    export = Export({"data_exp_1-v2_task.csv": table(rows).encode("utf-8-sig")}, "Gorilla", "", dropped, positions=True)
    export.left_out = {"practice": 10}
    return export


def labvanced() -> Export:
    head = [
        "Rec_Session_Id",
        "Exp_Subject_Id",
        "Group_Id",
        "Session_Nr",
        "Block_Nr",
        "Block_Name",
        "Task_Nr",
        "Task_Name",
    ]
    rows = [[*head, "Trial_Nr", "Condition_Id", "Video", "Emotion_Choice", "gender"]]
    for i, p in enumerate(PEOPLE, start=1):
        about = [i, i, 1, 1]
        rows.append([*about, 1, "Practice", 1, "emo", 1, 1, "z8r4.mp4", "Disgust", GENDER[p]])
        rows += [[*about, 2, "Main", 1, "emo", k, k, f"{c}.mp4", ANSWERS[p][c].title(), GENDER[p]]
                 for k, c in enumerate(ORDER[p], start=1)]  # fmt: skip
    export = Export({"experiment_data.csv": quoted(rows).encode()}, "Labvanced", positions=True)
    export.left_out = {"practice": 8}
    return export


def pcibex() -> Export:
    names = [
        "Results reception time",
        "MD5 hash of participant's IP address",
        "Controller name",
        "Order number of item",
    ]
    names += ["Inner element number", "Label", "Latin Square Group", "PennElementType", "PennElementName", "Parameter"]
    names += ["Value", "EventTime"]

    def comments(*more):
        return [f"# {i}. {name}." for i, name in enumerate([*names, *more, "Comments"], start=1)]

    lines = []
    for i, p in enumerate(PEOPLE):
        start = f"{1796033472 + i},9d5ed678fe57{i},PennController"
        lines += ["# Results on Monday, 30 Nov 2026", "# USER AGENT: Mozilla/5.0", "#"]
        lines += ["# Columns below this comment are as follows:", *comments("gender")]
        lines.append(f"{start},0,0,practice,NULL,Scale,emotion,Choice,Fear,1796033400,{GENDER[p]},NULL")
        for k, c in enumerate(ORDER[p], start=1):
            trial = f"{start},{k},0,trial,NULL"
            lines.append(f"{trial},PennController,{k},_Trial_,Start,17960334{k}0,{GENDER[p]},NULL")
            lines.append(f"{trial},Video,{c}.mp4,Play,NULL,17960334{k}1,{GENDER[p]},NULL")
            lines.append(f"{trial},Scale,emotion,Choice,{ANSWERS[p][c].title()},17960334{k}2,{GENDER[p]},Wait success")
            lines.append(f"{trial},PennController,{k},_Trial_,End,17960334{k}3,{GENDER[p]},NULL")
    export = Export({"results.csv": "\n".join(lines).encode()}, "PCIbex", positions=True)
    export.left_out = {"practice": 8}
    return export


SOSCI = ["CASE", "SERIAL", "QUESTNNR", "MODE", "STARTED", "FINISHED", "LASTPAGE", "TIME001", "SD01"]


def sosci() -> Export:
    rows = [[*SOSCI, *(f"E10{j}" for j in range(1, 7))]]
    for i, p in enumerate([*PEOPLE, "X1", "X2"]):
        mode, finished = {"X1": ("pretest", "T"), "X2": ("interview", "F")}.get(p, ("interview", "T"))
        answers = [NUMBERS[label] for label in ANSWERS.get(p, ANSWERS["P01"]).values()]
        sex = GENDER.get(p, "Male")
        rows.append([101 + i, "", "base", mode, "2026-03-02 10:11:12", finished, 8, 12, sex, *answers])
    said = f"videos: {{{', '.join(f'E10{j}: {c}' for j, c in enumerate(CODES, start=1))}}}\n"
    said += "groups: {gender: SD01}\n" + map_of(NUMBERS)
    data = quoted(rows, delimiter=";").encode()
    return Export({"rdata_emo.csv": data}, "SoSci Survey", said, {"test run": 1, "partial": 1})


def unipark() -> Export:
    rows = [
        ["lfdn", "external_lfdn", "tester", "dispcode", "lastpage", "duration", *(f"v_{c}" for c in CODES), "gender"]
    ]
    for i, p in enumerate([*PEOPLE, "X1", "X2"], start=1):
        tester, code = {"X1": (1, 31), "X2": (0, 22)}.get(p, (0, 31))
        answers = [NUMBERS[label] for label in ANSWERS.get(p, ANSWERS["P01"]).values()]
        rows.append([i, 0, tester, code, 9, 120, *answers, GENDER.get(p, "Male")])
    data = table(rows, delimiter=";").encode()
    return Export({"data_project_1.csv": data}, "Unipark", map_of(NUMBERS), {"test run": 1, "partial": 1})


def redcap() -> Export:
    rows = [["record_id", "redcap_survey_identifier", "emotions_timestamp", "gender", *(f"vid_{c}" for c in CODES)]]
    rows[0].append("emotions_complete")
    for i, p in enumerate([*PEOPLE, "X1"], start=1):
        answers = [NUMBERS[label] for label in ANSWERS.get(p, ANSWERS["P01"]).values()]
        rows.append([i, "", "2026-03-02 10:11", GENDER.get(p, "Male"), *answers, 0 if p == "X1" else 2])
    return Export({"Emotions_DATA.csv": table(rows).encode()}, "REDCap", map_of(NUMBERS), {"partial": 1})


def redcap_checkboxes() -> Export:
    head = ["Record ID", "Survey Identifier", "Survey Timestamp", "gender"]
    head += [f"Which emotion in video {c}? (choice={label.title()})" for c in CODES for label in EMOTIONS]
    rows = [[*head, "Complete?"]]
    for i, p in enumerate([*PEOPLE, "X1"], start=1):
        given = ANSWERS.get(p, ANSWERS["P01"])
        ticks = ["Checked" if given[c] == label else "Unchecked" for c in CODES for label in EMOTIONS]
        state = "Incomplete" if p == "X1" else "Complete"
        rows.append([i, "", "2026-03-02 10:11", GENDER.get(p, "Male"), *ticks, state])
    return Export({"Emotions_DATA_LABELS.csv": quoted(rows).encode()}, "REDCap", "", {"partial": 1})


def typeform() -> Export:
    rows = [["#", "gender", *(f"Which emotion does video {c} show?" for c in CODES)]]
    rows[0] += ["Response Type", "Start Date (UTC)", "Stage Date (UTC)", "Submit Date (UTC)", "Network ID", "Tags"]
    for p in [*PEOPLE, "X1"]:
        kind = "started" if p == "X1" else "completed"
        times = [kind, "2026-03-02 10:11:12", "", "2026-03-02 10:14:12", "a1b2c3", ""]
        answers = [label.title() for label in ANSWERS.get(p, ANSWERS["P01"]).values()]
        rows.append([f"tok{p}", GENDER.get(p, "Male"), *answers, *times])
    return Export({"responses.csv": table(rows).encode()}, "Typeform", "", {"partial": 1})


MTURK = ["HITId", "Title", "AssignmentId", "WorkerId", "AssignmentStatus", "AcceptTime", "WorkTimeInSeconds"]


def _mturk(head, cells):
    rows = [[*MTURK, "Input.video_url", *head, "Answer.gender", "Approve", "Reject"]]
    for p in [*PEOPLE, "X1"]:
        for c in ORDER.get(p, ORDER["P01"]):
            label, status = ANSWERS.get(p, ANSWERS["P01"])[c], "Rejected" if p == "X1" else "Approved"
            about = [f"H{c}", "Emotions", f"A{p}{c}", f"W{p}", status, "Mon Mar 02", "60", f"https://x.org/{c}.mp4"]
            rows.append([*about, *cells(label), GENDER.get(p, "Male"), "", ""])
    return Export({"Batch_1_batch_results.csv": quoted(rows).encode()}, "MTurk", left_out={"rejected": 6})


def mturk() -> Export:
    return _mturk(["Answer.emotion.label"], lambda label: [label.title()])


def mturk_choices() -> Export:
    heads = [f"Answer.emotion.{label.title()}" for label in EMOTIONS]
    return _mturk(heads, lambda label: ["true" if label == one else "false" for one in EMOTIONS])


def mturk_json() -> Export:
    return _mturk(["Answer.taskAnswers"], lambda label: [json.dumps([{"emotion": {"label": label.title()}}])])


def choices_long() -> Export:
    rows = [["participant", "video", *(f"felt_{label}" for label in EMOTIONS), "gender"]]
    for p in PEOPLE:
        rows += [[p, f"{c}.mp4", *(int(ANSWERS[p][c] == label) for label in EMOTIONS), GENDER[p]] for c in ORDER[p]]
    return Export({"long.csv": table(rows).encode()}, "long table")


def choices_wide() -> Export:
    rows = [["id", "gender", *(f"{c}[{label}]" for c in CODES for label in EMOTIONS)]]
    rows += [[p, GENDER[p], *(int(ANSWERS[p][c] == e) for c in CODES for e in EMOTIONS)] for p in PEOPLE]
    return Export({"wide.csv": table(rows).encode()}, "wide table")


def workbook() -> Export:
    rows = wide(["id"], lambda i, _: [i + 1], [f"video {c}" for c in CODES], ADJECTIVES.get)
    out = io.BytesIO()
    pd.DataFrame(rows[1:], columns=rows[0]).to_excel(out, index=False)
    return Export({"answers.xlsx": out.getvalue()}, "wide table")


EXPORTS = (
    own,
    generic_long,
    generic_wide,
    google_sheets,
    google_direct,
    microsoft,
    qualtrics,
    qualtrics_numeric_tsv,
    qualtrics_loop,
    qualtrics_legacy,
    limesurvey,
    limesurvey_codes,
    limesurvey_both,
    surveymonkey,
    surveymonkey_expanded,
    jspsych,
    jspsych_files,
    jspsych_json,
    psychopy,
    pavlovia,
    otree_wide,
    otree_app,
    labjs,
    psiturk,
    pymushra,
    formr,
    revisit,
    jspsych_6,
    opensesame,
    eprime,
    gorilla,
    labvanced,
    pcibex,
    sosci,
    unipark,
    redcap,
    redcap_checkboxes,
    typeform,
    mturk,
    mturk_choices,
    mturk_json,
    choices_long,
    choices_wide,
    workbook,
)
