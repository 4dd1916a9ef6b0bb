"use strict";
/* Forms that are sent until there is a reply, a warning before unsent text is lost, and videos fetched ahead.
   Nothing is decided here: the server checks everything. */

const byId = (id) => document.getElementById(id);
const words = () => document.body.dataset; // texts of the study for messages of this script
const pause = (seconds) => new Promise((done) => { setTimeout(done, 1000 * seconds); });
let unsent = false; // text that was typed and not yet sent

/** Send until there is a reply: wait for a lost connection, a server that restarts, and a locked database. */
async function send(url, options, say) {
  for (let wait = 0.5; ; wait = Math.min(2 * wait, 8)) {
    let message = words().offline;
    try {
      const reply = await fetch(url, { method: "POST", credentials: "same-origin", ...options });
      if (reply.status < 502) return reply; // 502 to 504: a proxy without the survey behind it, or a locked database
      if (reply.headers.get("X-Survey") === "busy") message = words().busy;
    } catch { /* no connection */ }
    say(message);
    await pause(wait);
  }
}

function parse(text) {
  return new DOMParser().parseFromString(text, "text/html");
}

/** Show a page of the server in place of the current one. */
function show(page) {
  unsent = false;
  document.body.replaceChildren(...page.body.childNodes);
  document.title = page.title;
  activate();
  byId("main").focus();
}

/** Go to another page of the survey. */
function go(url) {
  unsent = false;
  window.location.assign(url);
}

/** Return whether every slider was moved; one that was not moved has no value. */
function complete(form) {
  const untouched = form.querySelector(".untouched");
  if (byId("missing")) byId("missing").hidden = !untouched;
  untouched?.focus();
  return !untouched;
}

function activateForm(form) {
  let sending = false; // a second press sends nothing
  const opened = performance.now();
  const say = (text) => { if (byId("state")) byId("state").textContent = text; };
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    if (sending || !complete(form)) return;
    sending = true;
    const body = new URLSearchParams(new FormData(form));
    if (event.submitter?.name) body.append(event.submitter.name, event.submitter.value);
    if (form.id === "consent") {
      body.append("device", device());
      body.append("width", window.innerWidth);
    }
    if (form.id === "answer") body.append("response-ms", Math.round(performance.now() - (Number(form.dataset.opened) || opened)));
    const headers = { "X-Survey-Script": "form" };
    const reply = await send(form.getAttribute("action"), { body, headers }, say); // form.action may be a question's name
    const next = reply.headers.get("X-Next");
    if (next) return go(next);
    const page = parse(await reply.text());
    if (reply.status !== 413 && reply.status < 500) return show(page);
    say(page.querySelector("main p")?.textContent ?? ""); // the form stays as it is, to be sent again
    sending = false;
  });
}

function activateSlider(slider) {
  for (const name of ["input", "pointerup", "keyup"]) {
    slider.addEventListener(name, (event) => {
      if (event.key === "Tab" || event.key === "Shift") return;
      slider.name = slider.dataset.name || slider.name;
      slider.classList.remove("untouched");
      if (byId("missing")) byId("missing").hidden = true;
    });
  }
}

/** Fill in a code that follows # in the address: /resume#CODE. No server ever receives that part. */
function activateCode() {
  if (byId("code") && window.location.hash) {
    byId("code").value = window.location.hash.slice(1);
    window.history.replaceState(null, "", window.location.pathname);
  }
  if (byId("own-code")) byId("own-code").title = byId("own-code").href;
}

/** Fetch the participant's next videos into the browser's cache, one after the other. */
async function fetchAhead() {
  const { folder, codes } = byId("ahead")?.dataset ?? {};
  for (const code of codes?.split(" ") ?? []) {
    try {
      const reply = await fetch(`${folder}${code}.mp4`, { credentials: "same-origin", priority: "low" });
      await reply.blob();
    } catch { return; } // the page of the video loads it itself, and says so
  }
}

/** Follow a link by itself after its seconds: back to the recruitment service, or to the next person at a kiosk. */
function followLinks() {
  for (const link of document.querySelectorAll("a[data-seconds]")) {
    setTimeout(() => go(link.href), 1000 * Number(link.dataset.seconds));
  }
}

/** At a kiosk, forget a participant who has left, and show the first page to the next person. */
function leaveWhenIdle() {
  let timer = null;
  const restart = () => {
    const form = byId("leave");
    clearTimeout(timer);
    if (form) timer = setTimeout(() => form.requestSubmit(), 1000 * Number(form.dataset.seconds));
  };
  for (const name of ["pointerdown", "pointermove", "keydown", "scroll", "timeupdate"]) document.addEventListener(name, restart, true);
  restart();
}

function device() {
  if (!window.matchMedia("(pointer: coarse)").matches) return "desktop";
  return Math.min(window.screen.width, window.screen.height) < 600 ? "phone" : "tablet";
}

/** Set up the elements of the page that is shown. */
function activate() {
  for (const form of document.forms) activateForm(form);
  for (const slider of document.querySelectorAll("input[type=range]")) activateSlider(slider);
  activateCode();
  followLinks();
  if (!byId("player")) fetchAhead();
  else if (typeof activatePlayer === "function") activatePlayer(byId("player")); // fetches ahead once its video is loaded
}

document.addEventListener("input", (event) => {
  if (event.target.matches("textarea, input[type=text]:not(#code), input[type=number]")) unsent = true;
});
window.addEventListener("beforeunload", (event) => { if (unsent) event.preventDefault(); });
window.addEventListener("pageshow", (event) => { if (event.persisted) window.location.reload(); }); // as the server has it
document.addEventListener("DOMContentLoaded", activate);
document.addEventListener("DOMContentLoaded", leaveWhenIdle);
