// Playback of a result: the moving time, the values at it, and the reader's actions at it.
import { byId, make } from "./dom.js";
import { digits, quantity } from "./format.js";

const SPEEDS = [["1/1000", 1e-3], ["1/100", 1e-2], ["1/10", 0.1], ["1/4", 0.25], ["1", 1], ["4", 4]];
/** Preferred duration of a playback, s. */
const PLAYBACK_S = 4;
const MOMENTS = 1000;

export class Live {
  #running = 0;
  #listeners = [];

  constructor(scope) {
    this.scope = scope;
    this.slider = byId("time");
    byId("speed").replaceChildren(...SPEEDS.map(([name, value]) => make("option", { value }, `${name} ×`)));
    this.slider.addEventListener("input", () => {
      this.pause();
      const [from, to] = this.scope.ends;
      this.goto(from + ((to - from) * Number(this.slider.value)) / MOMENTS);
    });
    byId("play").addEventListener("click", () => (this.#running ? this.pause() : this.play()));
    byId("in").addEventListener("click", () => this.#zoom(0.4));
    byId("out").addEventListener("click", () => this.#zoom(2.5));
    const pointed = (event) => {
      if (!this.scope.data || (event.type === "pointermove" && event.buttons !== 1)) return;
      const box = this.scope.canvas.getBoundingClientRect(), [from, to] = this.scope.shown;
      const part = (event.clientX - box.left - 58) / (box.width - 68);
      this.pause();
      this.goto(Math.max(from, Math.min(to, from + part * (to - from))));
    };
    this.scope.canvas.addEventListener("pointerdown", pointed);
    this.scope.canvas.addEventListener("pointermove", pointed);
  }

  /** Adds a listener that is called with every time that is shown. */
  listen(listener) {
    this.#listeners.push(listener);
  }

  /** Returns the time at which a result is of interest: the middle of the last ON window, or the end. */
  #rest() {
    const windows = this.scope.data.on_s ?? [], [on, off] = windows.at(-1) ?? [], end = this.scope.ends[1];
    return windows.length ? (on + Math.min(off, end)) / 2 : end;
  }

  /** Shows a result at a time, or at its time of interest. */
  show(data, from = null) {
    this.pause();
    const speed = (data.time_s.at(-1) - data.time_s[0]) / PLAYBACK_S;
    const best = SPEEDS.reduce((best, [, value]) => (Math.abs(Math.log(value / speed)) < Math.abs(Math.log(best / speed)) ? value : best), 1);
    const kept = this.scope.data && from !== null ? [...this.scope.shown] : null;
    this.scope.show(data);
    if (kept && kept[1] <= this.scope.ends[1]) this.scope.shown = kept;
    else byId("speed").value = best;
    this.#events(data.events);
    this.goto(from ?? this.#rest());
    byId("out").disabled = this.scope.isWhole;
  }

  #zoom(factor) {
    this.scope.zoom(factor);
    byId("out").disabled = this.scope.isWhole;
  }

  goto(moment) {
    const { scope } = this;
    scope.goto(moment);
    const [from, to] = scope.ends;
    this.slider.value = Math.round((MOMENTS * (moment - from)) / (to - from));
    const text = to < 1 ? `${(moment * 1e3).toFixed(to < 0.01 ? 4 : 2)} ms` : `${moment.toFixed(3)} s`;
    byId("clock").textContent = text;
    this.slider.setAttribute("aria-valuetext", text);
    this.#values();
    for (const listener of this.#listeners) listener(moment);
  }

  play() {
    const [from, to] = this.scope.ends;
    const start = this.scope.moment >= to - 1e-9 * (to - from) ? from : this.scope.moment;
    const began = performance.now();
    byId("play").textContent = "Pause";
    const tick = (now) => {
      const moment = start + ((now - began) / 1e3) * Number(byId("speed").value);
      this.goto(Math.min(to, moment));
      if (moment >= to) this.pause(); else this.#running = requestAnimationFrame(tick);
    };
    this.#running = requestAnimationFrame(tick);
    byId("speed").onchange = () => { if (this.#running) { this.pause(); this.play(); } };
  }

  pause() {
    cancelAnimationFrame(this.#running);
    this.#running = 0;
    byId("play").textContent = "Play";
  }

  get isPlaying() {
    return this.#running !== 0;
  }

  #values() {
    const { data } = this.scope, at = this.scope.index();
    const rows = data.lanes.map(({ label, unit, signals }) => {
      const of = (role) => signals.findLast((signal) => signal.role === role)?.values[at];
      const cell = (value) => make("td", { class: "number" }, value === undefined || value === null ? "–" : unit === "Hz" ? `${digits(value, 7)} Hz` : quantity(value, unit));
      return make("tr", {}, make("th", { scope: "row" }, label), cell(of("command")), cell(of("estimate") ?? of("sensor")), cell(of("truth")));
    });
    byId("now").tBodies[0].replaceChildren(...rows);
    const last = data.events.findLast(([time]) => time <= this.scope.moment + 1e-9);
    byId("mode").textContent = last ? `since ${quantity(last[0], "s", 5)}: ${last[1]}` : "";
  }

  #events(events) {
    byId("events").hidden = events.length === 0;
    byId("event-list").replaceChildren(...events.map(([time, words]) =>
      make("li", {}, make("button", { type: "button", class: "text", onclick: () => { this.pause(); this.goto(time); } }, quantity(time, "s", 6)), ` ${words}`)));
  }
}

/** Returns the ON windows with the drive switched at a time: unchanged before it, inverted after it. */
export function switched({ on_s, off_s, period_s }, moment, end) {
  const pairs = period_s ? [] : on_s.map((on, place) => [on, off_s[place] ?? end]);
  // Without a schedule the drive is always ON.
  const windows = pairs.length ? pairs : [[0, end]];
  const isOn = windows.some(([on, off]) => on <= moment && moment < off);
  const before = windows.filter(([on]) => on < moment).map(([on, off]) => [on, Math.min(off, moment)]);
  const after = isOn ? before : [...before, [moment, end]];
  // At least one window: from the end on nothing is ON.
  const kept = (after.length ? after : [[end, end * 1.001]]).slice(-8);
  return { isOn, on_s: kept.map(([on]) => on), off_s: kept.map(([, off]) => off) };
}
