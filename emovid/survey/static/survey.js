"use strict";
/* What pages cannot do alone: the player, which tells the server how much of a video was seen, and forms that are sent
   until there is a reply. Nothing is decided here: the server believes no more than its own clock allows. */

const said = document.body.dataset;
const node = (id) => document.getElementById(id);
const pause = (seconds) => new Promise((done) => { setTimeout(done, 1000 * seconds); });

/** Send until there is a reply: a lost connection, or a server that starts again, is waited for. */
async function send(url, options, offline) {
  for (let wait = 0.5; ; wait = Math.min(2 * wait, 8)) {
    try {
      const reply = await fetch(url, { method: "POST", credentials: "same-origin", ...options });
      if (reply.status < 502) return reply; // 502 to 504: a proxy is there, and we are not
    } catch { /* no connection */ }
    offline();
    await pause(wait);
  }
}

/** Show the reply's own page in place of this one's: a message, or a form that something is missing in. */
async function show(reply) {
  const page = new DOMParser().parseFromString(await reply.text(), "text/html");
  document.body.replaceChildren(...page.body.childNodes);
  document.title = page.title;
  node("main").focus();
}

/** Return whether every slider was moved: where nobody put it, it says nothing. */
function complete(form) {
  const untouched = form.querySelector(".untouched");
  if (node("missing")) node("missing").hidden = !untouched;
  untouched?.focus();
  return !untouched;
}

for (const form of document.forms) {
  let sending = false; // a second press sends nothing
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    if (sending || !complete(form)) return;
    sending = true;
    const body = new URLSearchParams(new FormData(form));
    if (event.submitter?.name) body.append(event.submitter.name, event.submitter.value);
    const offline = () => { if (node("state")) node("state").textContent = said.offline; };
    const reply = await send(form.getAttribute("action"), { body }, offline); // form.action may be a question's name
    if (reply.redirected) window.location.assign(reply.url);
    else show(reply);
  });
}

for (const slider of document.querySelectorAll("input[type=range]")) {
  for (const name of ["input", "pointerup", "keyup"]) {
    slider.addEventListener(name, (event) => {
      if (event.key === "Tab" || event.key === "Shift") return;
      slider.name = slider.dataset.name || slider.name;
      slider.classList.remove("untouched");
      if (node("missing")) node("missing").hidden = true;
    });
  }
}

function device() {
  if (!window.matchMedia("(pointer: coarse)").matches) return "desktop";
  return Math.min(window.screen.width, window.screen.height) < 600 ? "phone" : "tablet";
}

/** The player: a button, and reports of each play. A play goes from the beginning to the end, with pauses. */
function watch(player) {
  const [video, button, note] = [player.querySelector("video"), node("play"), node("note")];
  const headers = { "Content-Type": "application/json", "X-Form-Token": player.dataset.token };
  let [play, watched, last, tick, before] = ["", 0, 0, 0, { total: 0, dropped: 0 }];
  let line = Promise.resolve(); // reports go one after the other

  const quality = () => {
    const counts = video.getVideoPlaybackQuality?.();
    return { total: counts?.totalVideoFrames ?? 0, dropped: counts?.droppedVideoFrames ?? 0 };
  };
  const say = (text) => { if (note.textContent !== text) note.textContent = text; };
  const report = (url, facts) => {
    const body = JSON.stringify({ play, ...facts });
    line = line.then(() => send(url, { body, headers, keepalive: true }, () => say(said.offline)));
    return line;
  };
  const seen = () => {
    const now = quality();
    const share = video.duration ? Math.min(watched / video.duration, 1) : 0;
    return { play, share, frames: now.total - before.total, dropped: now.dropped - before.dropped };
  };
  const open = () => {
    node("gate").disabled = node("submit").disabled = false;
    player.dataset.opened = "";
    say(note.dataset.choose);
  };
  const label = () => {
    const name = video.ended || (video.paused && !play && "opened" in player.dataset) ? "again" : "play";
    button.textContent = button.dataset[video.paused || video.ended ? name : "pause"];
  };

  const begin = () => {
    play = [...crypto.getRandomValues(new Uint8Array(8))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
    [watched, last, before] = [0, 0, quality()];
    video.currentTime = 0;
    report(player.dataset.play, { device: device(), width: video.clientWidth, height: video.clientHeight });
  };
  const advance = () => {
    const [step, now] = [video.currentTime - last, performance.now()];
    if (step > 0 && step <= (now - tick) / 1000 + 0.3 && !document.hidden) watched += step; // no faster than the clock
    [last, tick] = [video.currentTime, now];
  };
  const finish = async () => {
    const facts = seen();
    for (;;) {
      const reply = await report(player.dataset.watched, facts);
      if (!reply.ok) return window.location.reload(); // withdrawn or submitted in another tab: the server knows where to
      const answer = await reply.json();
      if (answer.open) return open();
      if (!answer.wait) return say(note.dataset.first);
      say(said.wait);
      await pause(answer.wait + 0.05);
    }
  };

  button.addEventListener("click", () => {
    if (!video.paused && !video.ended) return video.pause();
    if (video.ended || !play) begin();
    tick = performance.now();
    video.play().catch(label);
  });
  video.addEventListener("timeupdate", () => video.seeking || advance());
  video.addEventListener("seeking", () => {
    if (Math.abs(video.currentTime - last) > 0.5) video.currentTime = last; // neither ahead nor back
  });
  video.addEventListener("ratechange", () => { if (video.playbackRate !== 1) video.playbackRate = 1; });
  video.addEventListener("contextmenu", (event) => event.preventDefault());
  video.addEventListener("error", () => say(said.loadError));
  for (const name of ["play", "pause", "ended"]) video.addEventListener(name, label);
  video.addEventListener("ended", () => { advance(); finish(); });
  document.addEventListener("visibilitychange", () => {
    if (!document.hidden || !play || video.ended) return;
    video.pause(); // what is not seen is not watched
    report(player.dataset.watched, seen());
  });
  button.disabled = false;
}

if (node("player")) watch(node("player"));
if (node("code") && window.location.hash) { // an own address, /resume#CODE: what follows # was never sent
  node("code").value = window.location.hash.slice(1);
  window.history.replaceState(null, "", window.location.pathname);
}
if (node("own-code")) node("own-code").title = node("own-code").href;
window.addEventListener("pageshow", (event) => { if (event.persisted) window.location.reload(); }); // as the server has it
