"use strict";
/* The player: it loads a video whole before it plays, and reports to the server how much of it was watched.
   The server credits no more than its own clock allows. */

const SLACK = 0.5; // seconds that a player's clock may be ahead of the page's, once in each playback
const SILENCE = 20; // seconds without a byte after which a download is started again

/** Load a file whole; call `progress` with the share that has arrived. */
async function load(url, progress, retry) {
  const control = new AbortController();
  let timer = setTimeout(() => control.abort(), 1000 * SILENCE);
  const how = { credentials: "same-origin", signal: control.signal, cache: retry ? "reload" : "default" };
  try {
    const reply = await fetch(url, how);
    if (!reply.ok) throw new Error(`status ${reply.status}`);
    const [size, reader, parts] = [Number(reply.headers.get("Content-Length")), reply.body.getReader(), []];
    for (let received = 0; ;) {
      const { done, value } = await reader.read();
      clearTimeout(timer);
      if (done && size && received < size) throw new Error("incomplete");
      if (done) return new Blob(parts, { type: "video/mp4" });
      timer = setTimeout(() => control.abort(), 1000 * SILENCE);
      parts.push(value);
      received += value.length;
      if (size) progress(received / size);
    }
  } finally {
    clearTimeout(timer);
  }
}

/** Add the range [from, to] to sorted, disjoint ranges; return their union. */
function union(ranges, from, to) {
  const merged = [];
  for (const [start, end] of [...ranges, [from, to]].sort((a, b) => a[0] - b[0])) {
    const last = merged.at(-1);
    if (last && start <= last[1]) last[1] = Math.max(last[1], end);
    else merged.push([start, end]);
  }
  return merged;
}

const total = (ranges) => ranges.reduce((sum, [start, end]) => sum + end - start, 0);

/** How much of a video one playback has shown: the union of the ranges of its own time that were played,
    no longer than the time for which it was playing and visible. */
class Watch {
  constructor(video) {
    this.video = video;
    this.name = [...crypto.getRandomValues(new Uint8Array(8))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
    this.ranges = [];
    this.position = 0; // up to which everything was counted [s of the video]
    this.allowed = 0; // time for which it could play: not paused, and visible [s]
    this.playing = 0; // the same from the first frame on
    this.tick = null; // when these times were last counted; null while paused or hidden
    this.stalls = 0;
    this.stalled = 0; // time for which it stood still, waiting for data [s]
    this.waiting = null; // when it began to stand still
    this.started = false; // whether the first frame has been shown
    this.finished = false; // whether the end was reported
    this.before = this.quality();
  }

  quality() {
    const counts = this.video.getVideoPlaybackQuality?.();
    return { total: counts?.totalVideoFrames ?? 0, dropped: counts?.droppedVideoFrames ?? 0 };
  }

  /** Count what was played since the last call. A position that runs back is a late reading, not a step back. */
  advance() {
    const now = performance.now();
    const elapsed = this.tick === null ? 0 : (now - this.tick) / 1000;
    this.allowed += elapsed;
    if (this.started) this.playing += elapsed;
    this.tick = !this.video.paused && !document.hidden ? now : null;
    const here = this.video.ended ? this.video.duration : this.video.currentTime; // which can be a late reading
    if (this.video.seeking || here <= this.position) return;
    const credit = Math.max(this.allowed + SLACK - total(this.ranges), 0);
    this.ranges = union(this.ranges, this.position, Math.min(here, this.position + credit));
    this.position = here;
    if (this.waiting !== null && !this.video.paused) this.resume();
  }

  /** Start the clock: the events of the player can be late by more than the slack. */
  run() {
    if (this.tick === null && !document.hidden) this.tick = performance.now();
  }

  begin() {
    this.advance();
    this.started = true;
    this.run();
    this.resume();
  }

  stall() {
    if (!this.started || this.waiting !== null || this.video.ended || this.video.seeking) return;
    this.stalls += 1;
    this.waiting = performance.now();
  }

  resume() {
    if (this.waiting !== null) this.stalled += (performance.now() - this.waiting) / 1000;
    this.waiting = null;
  }

  report() {
    const now = this.quality();
    return {
      share: this.video.duration ? Math.min(total(this.ranges) / this.video.duration, 1) : 0,
      frames: now.total - this.before.total,
      dropped: now.dropped - this.before.dropped,
      stalls: this.stalls,
      "stalled-ms": Math.round(1000 * this.stalled),
      "play-ms": Math.round(1000 * this.playing),
    };
  }
}

/** The player of a page: a button, and reports of each playback, which goes from the beginning to the end. */
function activatePlayer(player) {
  const [video, button, note] = [player.querySelector("video"), byId("play"), byId("note")];
  const headers = { "Content-Type": "application/json", "X-Form-Token": player.dataset.token };
  const source = video.dataset.source ??= video.getAttribute("src");
  let watch = null; // the playback in progress
  let [ready, wanted] = [false, false]; // whether the video is loaded; whether the button was pressed before that
  let retry = () => {}; // ends the rest before the next attempt to load
  let line = Promise.resolve(); // reports are sent one after the other

  const say = (text) => { if (note.textContent !== text) note.textContent = text; };
  const hint = () => say("opened" in player.dataset ? note.dataset.choose : note.dataset.first);
  const report = (url, name, facts) => {
    const body = JSON.stringify({ play: name, ...facts });
    line = line.then(() => send(url, { body, headers, keepalive: true }, say));
    return line;
  };
  const label = () => {
    const again = video.ended || (video.paused && !watch && "opened" in player.dataset);
    button.textContent = button.dataset[video.paused || video.ended ? (again ? "again" : "play") : "pause"];
  };
  const open = () => {
    byId("gate").disabled = byId("submit").disabled = false;
    byId("answer").dataset.opened = performance.now();
    player.dataset.opened = "";
    hint();
  };

  /** Wait before the next attempt, until the button is pressed or the connection is back. */
  const rest = (seconds) => Promise.race([pause(seconds), new Promise((done) => { retry = done; })]);

  /** Load the video whole, again and again until it is there. */
  const fetchVideo = async () => {
    video.removeAttribute("src");
    video.load();
    for (let attempt = 0; ; attempt += 1) {
      try {
        const percent = (share) => { if (!attempt || share > 0) say(`${words().loading} ${Math.floor(100 * share)} %`); };
        const blob = await load(source, percent, attempt);
        video.src = URL.createObjectURL(blob);
        ready = true;
        hint();
        if (wanted && !document.hidden) start();
        return fetchAhead();
      } catch {
        say(words().videoError);
        await rest(Math.min(2 ** attempt, 15));
      }
    }
  };

  const start = () => {
    wanted = false;
    if (video.ended || !watch) {
      end();
      watch = new Watch(video);
      if (video.currentTime) video.currentTime = 0;
      const shown = { device: device(), width: video.clientWidth, height: video.clientHeight };
      report(player.dataset.play, watch.name, shown);
    }
    hint();
    video.play().catch(label);
    watch.run();
  };
  const finish = async ({ name }, facts) => {
    for (;;) {
      const reply = await report(player.dataset.watched, name, facts);
      if (!reply.ok) return go(window.location.href); // withdrawn or submitted in another tab: the server knows where to
      const answer = await reply.json();
      if (answer.open) return open();
      if (!answer.wait) return say(note.dataset.first);
      say(words().wait);
      await pause(answer.wait + 0.05);
    }
  };
  const end = () => {
    if (!watch || watch.finished || !video.ended) return;
    watch.advance();
    watch.finished = true;
    finish(watch, watch.report());
  };
  const hide = () => {
    if (!watch || video.ended) return;
    watch.advance();
    watch.tick = null;
    video.pause(); // a video that cannot be seen is not watched
    report(player.dataset.watched, watch.name, watch.report());
  };

  button.addEventListener("click", () => {
    if (!ready) {
      wanted = true; // it starts once it can play through
      retry();
    } else if (video.paused || video.ended) {
      start();
    } else {
      video.pause();
    }
  });
  window.addEventListener("online", () => retry());
  video.addEventListener("timeupdate", () => watch?.advance());
  video.addEventListener("playing", () => watch?.begin());
  video.addEventListener("waiting", () => watch?.stall());
  video.addEventListener("seeking", () => { // neither ahead nor back
    if (watch && Math.abs(video.currentTime - watch.position) > SLACK) video.currentTime = watch.position;
  });
  video.addEventListener("ratechange", () => { if (video.playbackRate !== 1) video.playbackRate = 1; });
  video.addEventListener("contextmenu", (event) => event.preventDefault());
  video.addEventListener("error", () => { // of a video that was loaded and cannot be played
    if (!video.getAttribute("src")) return;
    [ready, watch] = [false, null];
    say(words().videoError);
    rest(10).then(fetchVideo);
  });
  for (const name of ["play", "pause", "ended"]) video.addEventListener(name, label);
  video.addEventListener("pause", () => { watch?.advance(); watch?.resume(); });
  video.addEventListener("ended", end);
  document.addEventListener("visibilitychange", () => {
    if (document.hidden) hide();
    else if (ready && wanted) start();
  });
  for (const element of document.querySelectorAll(".without-script")) element.remove();
  button.disabled = false;
  fetchVideo();
}
