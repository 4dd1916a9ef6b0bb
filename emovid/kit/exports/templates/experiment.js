"use strict";
/* The procedure of the study as trials of jsPsych: consent, questions about the participant, instructions, the videos in
   the participant's order, and the last page. Participants must watch a video to its end before they answer, and can
   repeat it. jsPsych cannot return to an earlier trial. All texts and orders are in the element "kit" of the page. */

const KIT = JSON.parse(document.getElementById("kit").textContent);
const TEXTS = KIT.texts;

/** Offers the answers for download; change this function to send them to a server instead. */
function save(csv, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([csv], { type: "text/csv" }));
  link.download = name;
  link.click();
}

function escaped(text) {
  const node = document.createElement("span");
  node.textContent = text;
  return node.innerHTML.replaceAll('"', "&quot;");
}

function paragraphs(text) {
  return text.trim().split(/\n\s*\n/).map((part) => `<p>${escaped(part)}</p>`).join("");
}

/** Returns the participant and the row of the orders, both from ?participant=...; without it, a random name and a random
    row. */
function participant() {
  const given = new URLSearchParams(window.location.search);
  const rows = Object.keys(KIT.orders);
  const asked = given.get("participant");
  const chance = Math.floor(Math.random() * rows.length);
  const name = asked || `web-${crypto.getRandomValues(new Uint32Array(2)).join("")}`;
  return { name, row: rows.includes(asked) ? asked : rows[chance] };
}

/** Shows one video, and enables the question about it after the end of the video. */
class VideoQuestion {
  static info = {
    name: "emovid-video-question",
    version: "1.0.0",
    parameters: {
      code: { type: jsPsychModule.ParameterType.STRING },
      file: { type: jsPsychModule.ParameterType.STRING },
      choices: { type: jsPsychModule.ParameterType.COMPLEX, array: true },
      place: { type: jsPsychModule.ParameterType.INT },
      question: { type: jsPsychModule.ParameterType.STRING },
      heading: { type: jsPsychModule.ParameterType.HTML_STRING, default: "" },
      kind: { type: jsPsychModule.ParameterType.STRING, default: "video" }, // or practice, or the name of a check
    },
    data: {
      video_code: { type: jsPsychModule.ParameterType.STRING },
      position: { type: jsPsychModule.ParameterType.INT },
      response: { type: jsPsychModule.ParameterType.STRING },
      rt: { type: jsPsychModule.ParameterType.INT },
      plays: { type: jsPsychModule.ParameterType.INT },
      watched_seconds: { type: jsPsychModule.ParameterType.FLOAT },
    },
  };

  constructor(jsPsych) {
    this.jsPsych = jsPsych;
  }

  trial(display, trial) {
    display.innerHTML = VideoQuestion.page(trial);
    const [stage, video] = [display.querySelector(".stage"), display.querySelector("video")];
    const [play, again] = [display.querySelector(".play"), display.querySelector(".again")];
    const [form, answers, note] = ["form", "fieldset", ".note"].map((name) => display.querySelector(name));
    const start = performance.now();
    let [plays, furthest, watched, last] = [0, 0, 0, 0];
    video.src = this.jsPsych.pluginAPI.getVideoBuffer(trial.file) || trial.file;

    const begin = () => {
      plays += 1;
      [furthest, last] = [0, 0];
      video.currentTime = 0;
      stage.classList.add("playing");
      again.hidden = true;
      video.play().catch(stop);
    };
    const stop = () => {
      stage.classList.remove("playing");
      play.hidden = answers.disabled === false;
      again.hidden = !play.hidden;
    };
    const advance = () => {
      const step = video.currentTime - last;
      if (step > 0 && step < 1) watched += step;
      last = video.currentTime;
      furthest = Math.max(furthest, video.currentTime);
    };
    play.addEventListener("click", begin);
    again.addEventListener("click", begin);
    video.addEventListener("timeupdate", () => video.seeking || advance());
    video.addEventListener("seeking", () => {
      if (video.currentTime > furthest + 0.5) video.currentTime = furthest; // no skipping ahead
    });
    video.addEventListener("ratechange", () => { if (video.playbackRate !== 1) video.playbackRate = 1; });
    video.addEventListener("contextmenu", (event) => event.preventDefault());
    video.addEventListener("pause", () => {
      if (!video.ended && !document.hidden) video.play().catch(stop);
    });
    const hidden = () => {
      if (document.hidden && !video.ended) [video.pause(), stop()]; // restart what was hidden
    };
    document.addEventListener("visibilitychange", hidden);
    video.addEventListener("error", () => { note.textContent = TEXTS.load_error; });
    video.addEventListener("ended", () => {
      advance();
      answers.disabled = false;
      note.textContent = TEXTS.choose;
      stop();
    });

    const complete = () => {
      const moved = [...form.querySelectorAll("input[type=range]")].every((slider) => slider.dataset.moved);
      form.querySelector("button[type=submit]").disabled = !(form.querySelector("input:checked") && moved);
    };
    for (const slider of form.querySelectorAll("input[type=range]")) {
      for (const name of ["input", "pointerup", "keyup"]) {
        slider.addEventListener(name, (event) => {
          if (event.key === "Tab") return;
          slider.dataset.moved = "yes";
          slider.classList.remove("untouched");
          complete();
        });
      }
    }
    form.addEventListener("change", complete);
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const data = new FormData(form);
      const answer = data.get("response");
      const said = {
        video: { video_code: trial.code, position: trial.place, response: answer },
        practice: { practice_response: answer },
      }[trial.kind] || { check: trial.kind, check_response: answer };
      const result = {
        ...said,
        rt: Math.round(performance.now() - start),
        plays,
        watched_seconds: Math.round(watched * 10) / 10,
      };
      for (const rating of ratingsOf(trial)) {
        if (trial.kind === "video") result[rating.name] = Number(data.get(rating.name));
      }
      if (trial.kind === "video" && KIT.choices.order === "random") result.choices = trial.choices.map((choice) => choice.label).join("|");
      document.removeEventListener("visibilitychange", hidden);
      display.innerHTML = "";
      this.jsPsych.finishTrial(result);
    });
  }

  static page(trial) {
    const choices = trial.choices.map((choice) =>
      `<label><input type="radio" name="response" value="${escaped(choice.label)}">${escaped(choice.text)}</label>`);
    const ratings = ratingsOf(trial).map((rating) =>
      `<div class="rating"><label class="question" for="${rating.name}">${escaped(rating.question)}</label>
       <input class="untouched" type="range" id="${rating.name}" name="${rating.name}" min="1" max="${rating.steps}">
       <div class="ends"><span>${escaped(rating.low)}</span><span>${escaped(rating.high)}</span></div></div>`);
    return `${trial.heading}<div class="stage"><video playsinline preload="auto" disablepictureinpicture></video>
      <button type="button" class="play">${escaped(TEXTS.play)}</button></div>
      <div class="below"><p class="note" aria-live="polite">${escaped(TEXTS.watch_first)}</p>
      <button type="button" class="again plain" hidden>${escaped(TEXTS.again)}</button></div>
      <form><fieldset disabled>
      <fieldset role="radiogroup"><legend class="question">${escaped(trial.question)}</legend>
      <div class="choices">${choices.join("")}</div></fieldset>
      ${ratings.join("")}
      <button type="submit" disabled>${escaped(TEXTS.submit)}</button></fieldset></form>`;
  }
}

/** Returns the ratings on the page of a trial: attention checks have none. */
function ratingsOf(trial) {
  return ["video", "practice"].includes(trial.kind) ? KIT.ratings : [];
}

function questions(title, list) {
  const items = list.map((item) => {
    const mark = item.required ? "" : ` <span class="optional">${escaped(TEXTS.optional)}</span>`;
    const needed = item.required ? "required" : "";
    if (item.long) {
      return `<p><label class="question" for="${item.name}">${escaped(item.question)}${mark}</label><br>
        <textarea id="${item.name}" name="${item.name}" rows="6" maxlength="5000" ${needed}></textarea></p>`;
    }
    if (item.number) {
      return `<p><label class="question" for="${item.name}">${escaped(item.question)}${mark}</label><br>
        <input type="number" id="${item.name}" name="${item.name}" min="${item.number.low}" max="${item.number.high}"
        step="1" ${needed}></p>`;
    }
    if (!item.choices) {
      return `<p><label class="question" for="${item.name}">${escaped(item.question)}${mark}</label><br>
        <input type="text" id="${item.name}" name="${item.name}" autocomplete="off" ${needed}></p>`;
    }
    const several = item.several ? `<p class="note">${escaped(TEXTS.several)}</p>` : "";
    const choices = item.choices.map((choice, i) => item.several
      ? `<label><input type="checkbox" name="${item.name}_${i + 1}" value="${escaped(choice)}">${escaped(choice)}</label>`
      : `<label><input type="radio" name="${item.name}" value="${escaped(choice)}" ${needed}>${escaped(choice)}</label>`);
    return `<fieldset><legend>${escaped(item.question)}${mark}</legend>${several}
      <div class="choices">${choices.join("")}</div></fieldset>`;
  });
  return {
    type: jsPsychSurveyHtmlForm,
    html: `<h1>${escaped(title)}</h1>${items.join("")}`,
    button_label: escaped(TEXTS.next),
  };
}

/** Returns a return link with the values of the address in the place of {NAME}. */
function filled(link) {
  const given = new URLSearchParams(window.location.search);
  return link.replace(/\{([\w-]+)\}/g, (_, name) => encodeURIComponent(given.get(name) || ""));
}

function thanks(csv, name) {
  const { text, code, link } = KIT.thanks;
  const parts = [`<h1>${escaped(KIT.title)}</h1>`, paragraphs(text), KIT.debriefing ? paragraphs(KIT.debriefing) : ""];
  if (code) parts.push(`<p>${escaped(TEXTS.code)}<br><span class="code">${escaped(code)}</span></p>`);
  if (link) parts.push(`<p><a href="${escaped(filled(link))}">${escaped(TEXTS.back)}</a></p>`);
  parts.push(`<p><button type="button" class="plain" id="save">${escaped(TEXTS.save)}</button></p>`);
  const content = document.querySelector(".jspsych-content");
  content.innerHTML = `<div class="page">${parts.join("")}</div>`;
  content.querySelector("#save").addEventListener("click", () => save(csv, name));
}

const file = (code) => `videos/${code}.mp4`;
const me = participant();
const leaving = (event) => event.preventDefault(); // leaving the page loses the answers
const jsPsych = initJsPsych({
  show_progress_bar: true,
  message_progress_bar: escaped(TEXTS.progress),
  on_finish: () => {
    window.removeEventListener("beforeunload", leaving);
    const data = jsPsych.data.get();
    if (!data.filter({ trial_type: VideoQuestion.info.name }).count()) return; // no consent
    save(data.csv(), `${me.name}.csv`);
    thanks(data.csv(), `${me.name}.csv`);
  },
});
jsPsych.data.addProperties({ participant: me.name });
for (const name of KIT.parameters) {
  jsPsych.data.addProperties({ [name]: new URLSearchParams(window.location.search).get(name) || "" });
}

const screen = (text, ...buttons) => ({
  type: jsPsychHtmlButtonResponse,
  stimulus: `<div class="page">${text}</div>`,
  choices: buttons.map(escaped),
});
const timeline = [];
timeline.push({
  type: jsPsychPreload,
  video: [ // those of this participant
    ...(KIT.practice ? [KIT.practice] : []),
    ...KIT.preload.filter((name) => KIT.orders[me.row].map(file).includes(name)),
    ...KIT.checks.map((check) => check.file),
  ],
  message: paragraphs(TEXTS.loading),
  error_message: paragraphs(TEXTS.load_error),
});
timeline.push({
  ...screen(`<h1>${escaped(KIT.title)}</h1>${KIT.requirements.text ? paragraphs(KIT.requirements.text) : ""}${paragraphs(KIT.consent.text)}`, KIT.consent.agree, KIT.consent.decline),
  data: { consent_version: KIT.consent.version, order_index: me.row },
  on_finish: (data) => {
    if (data.response === 1) return jsPsych.abortExperiment(`<div class="page">${paragraphs(KIT.consent.declined)}</div>`);
    window.addEventListener("beforeunload", leaving);
  },
});
if (KIT.demographics.length) {
  timeline.push(questions(TEXTS.about_you, KIT.demographics));
}
timeline.push(screen(paragraphs(KIT.instructions), TEXTS.next));
const labels = KIT.choices.labels;
const drawn = KIT.choice_orders[me.row];
const choices = drawn ? drawn.map((label) => labels.find((answer) => answer.label === label)) : labels;
const shown = { type: VideoQuestion, question: KIT.question, choices, code: "", place: 0 };
if (KIT.practice) {
  const heading = `<h1>${escaped(TEXTS.practice)}</h1>${paragraphs(TEXTS.practice_note)}`;
  timeline.push({ ...shown, kind: "practice", file: KIT.practice, heading });
}
function checks(place, last) {
  const due = KIT.checks.filter((check) => check.after === place || (last && check.after > place));
  for (const { name, question, choices: texts, file: video } of due) {
    const answers = texts.map((text) => ({ label: text, text }));
    timeline.push({ ...shown, kind: name, file: video, question, choices: answers });
  }
}
KIT.orders[me.row].forEach((code, i) => {
  checks(i, false);
  timeline.push({ ...shown, code, file: file(code), place: i + 1 });
});
checks(KIT.orders[me.row].length, true);
if (KIT.questions_after.length) timeline.push(questions(TEXTS.more_questions, KIT.questions_after));
jsPsych.run(timeline);
