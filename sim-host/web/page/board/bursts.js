// Bursts on a timeline: bars that are moved and drawn out by mouse, finger and keyboard. Their times
// are the stored windows of the board, exact to the sample.
import { byId, make } from "../dom.js";
import { plain, quantity } from "../format.js";

/** Largest number of windows of a board. */
const MAX_BURSTS = 8;
/** Lengths of the timeline, s. */
const SPANS_S = [0.02, 0.1, 0.5, 2, 10];
/** Steps of a key and of a small key, parts of the timeline; a pointer moves in small steps. */
const BIG_STEPS = 100, SMALL_STEPS = 1000;
/** Bursts before the first edit, s: start and end. */
const FIRST_S = [[0.005, 0.025], [0.04, 0.06], [0.075, 0.095]];

/** Times are integers of this unit, so that steps do not accumulate rounding. */
const UNIT_S = 1e-6;
const units = (seconds) => Math.round(seconds / UNIT_S);
const seconds = (time) => plain(time * UNIT_S);
/** Names of the settings of the bursts, in pairs of start and end. */
const WINDOWS = Array.from({ length: MAX_BURSTS }, (_, n) => [`burst.on_${n + 1}_s`, `burst.off_${n + 1}_s`]);

export class Bursts {
  constructor(store) {
    this.bars = FIRST_S.map((bar) => bar.map(units));
    this.stored = this.edited = false;
    this.chosen = 0;
    byId("b-span").replaceChildren(...SPANS_S.map((span) => make("option", { value: span, selected: span === SPANS_S[1] }, quantity(span, "s"))));
    byId("b-span").addEventListener("change", () => this.#fit(Number(byId("b-span").value)));
    byId("b-add").addEventListener("click", () => this.#add());
    byId("b-remove").addEventListener("click", () => this.#splice(this.chosen, 1));
    byId("b-burst").addEventListener("submit", (event) => {
      event.preventDefault();
      const lines = WINDOWS.flatMap((names, n) => names.map((name, end) => `settings set ${name} ${seconds(this.bars[n]?.[end] ?? 0)}`));
      store(["stop", ...lines, "settings store", "reset", "lock"].join("\n"));
    });
    this.#draw();
  }

  /** Shows the bursts that the board has set, or else examples, unless they are being edited here. */
  show(parameters) {
    const set = (name) => units(Number(parameters.find((one) => one.name === name)?.set ?? 0));
    const bars = WINDOWS.map((names) => names.map(set)).filter(([on, off]) => off > on);
    if (this.edited) return;
    this.bars = bars.length ? bars.sort(([a], [b]) => a - b) : FIRST_S.map((bar) => bar.map(units));
    this.stored = bars.length > 0;
    this.#fit(0);
  }

  /** Shows the shortest timeline from a length on that contains all bars. */
  #fit(least) {
    byId("b-span").value = SPANS_S.find((span) => span >= least && units(span) >= (this.bars.at(-1)?.[1] ?? 0)) ?? SPANS_S.at(-1);
    this.#draw();
  }

  /** Returns the length of the timeline, which contains all bars. */
  get #span() { return Math.max(units(Number(byId("b-span").value)), this.bars.at(-1)?.[1] ?? 0); }

  /** Returns the room of a bar: the end of the one before, and the start of the next. */
  #room(n) { return [this.bars[n - 1]?.[1] ?? 0, this.bars[n + 1]?.[0] ?? this.#span]; }

  /** Moves both ends of a bar, or one, by a time, within its room. A burst has at least a small step. */
  #shift(n, which, by) {
    const bar = this.bars[n], [low, high] = this.#room(n), least = Math.min(Math.round(this.#span / SMALL_STEPS), bar[1] - bar[0]);
    const within = (time, from, to) => Math.max(from, Math.min(to, time));
    if (which === "move") {
      const moved = within(bar[0] + by, low, high - (bar[1] - bar[0])) - bar[0];
      bar[0] += moved;
      bar[1] += moved;
    } else if (which === "start") bar[0] = within(bar[0] + by, low, bar[1] - least);
    else bar[1] = within(bar[1] + by, bar[0] + least, high);
    this.#edit();
    this.#place();
  }

  /** Returns the length of the longest gap, the place of a burst in it, and its start. */
  get #gap() {
    const starts = [0, ...this.bars.map(([, off]) => off)], ends = [...this.bars.map(([on]) => on), this.#span];
    return ends.map((end, n) => [end - starts[n], n, starts[n]]).reduce((best, gap) => (gap[0] > best[0] ? gap : best));
  }

  /** Adds a burst to the longest gap. */
  #add() {
    const [length, n, from] = this.#gap, third = units(Number(((length * UNIT_S) / 3).toPrecision(2)));
    this.#splice(n, 0, [from + third, from + 2 * third]);
  }

  #splice(n, removed, ...added) {
    this.bars.splice(n, removed, ...added);
    this.chosen = Math.max(0, Math.min(n, this.bars.length - 1));
    this.#edit();
    this.#draw();
  }

  #edit() { [this.edited, this.stored] = [true, false]; }

  /** Creates the elements of all bars. */
  #draw() {
    const part = (n, which, name) => {
      const node = make("span", { role: "slider", tabindex: "0", class: which === "move" ? "move" : "end", "aria-label": `Burst ${n + 1}, ${name}` });
      node.addEventListener("focus", () => { this.chosen = n; this.#place(); });
      node.addEventListener("keydown", (event) => this.#key(event, n, which));
      node.addEventListener("pointerdown", (event) => this.#drag(event, node, n, which));
      return node;
    };
    this.parts = this.bars.map((_, n) => [part(n, "move", "position"), part(n, "start", "start"), part(n, "end", "end")]);
    byId("b-timeline").replaceChildren(...this.parts.flat());
    byId("b-remove").disabled = !this.bars.length;
    byId("b-add").disabled = this.bars.length >= MAX_BURSTS || this.#gap[0] < (10 * this.#span) / SMALL_STEPS;
    this.#place();
  }

  /** Puts the elements at the times of the bars. */
  #place() {
    const percent = (time) => `${(100 * time) / this.#span}%`;
    this.bars.forEach(([on, off], n) => {
      const [low, high] = this.#room(n), [move, start, end] = this.parts[n];
      const set = (node, now, least, most) => {
        for (const [name, value] of [["valuemin", least], ["valuemax", most], ["valuenow", now]]) node.setAttribute(`aria-${name}`, seconds(value));
        node.setAttribute("aria-valuetext", node === move ? `${quantity(on * UNIT_S, "s", 6)} to ${quantity(off * UNIT_S, "s", 6)}` : quantity(now * UNIT_S, "s", 6));
        node.style.left = percent(now);
        node.classList.toggle("chosen", n === this.chosen);
      };
      set(move, on, low, high - (off - on));
      set(start, on, low, off);
      set(end, off, on, high);
      move.style.width = percent(off - on);
    });
    byId("b-bursts").textContent = (this.stored ? "" : "not stored: ") + this.bars.map(([on, off]) => `${plain(on * UNIT_S * 1e3)} to ${plain(off * UNIT_S * 1e3)}`).join(", ") + (this.bars.length ? " ms" : "always on");
  }

  #key(event, n, which) {
    if (byId("b-acts").disabled) return;
    const step = Math.round(this.#span / (event.shiftKey ? SMALL_STEPS : BIG_STEPS)), far = this.#span;
    const by = { ArrowRight: step, ArrowUp: step, ArrowLeft: -step, ArrowDown: -step, PageUp: 10 * step, PageDown: -10 * step, Home: -far, End: far }[event.key];
    if (by !== undefined) this.#shift(n, which, by);
    else if (event.key === "Delete" || event.key === "Backspace") {
      this.#splice(n, 1);
      this.parts[this.chosen]?.[0].focus();
    } else return;
    event.preventDefault();
  }

  #drag(event, node, n, which) {
    if (byId("b-acts").disabled) return;
    node.setPointerCapture(event.pointerId);
    node.focus();
    event.preventDefault();
    const small = Math.round(this.#span / SMALL_STEPS), width = byId("b-timeline").clientWidth, from = event.clientX, before = [...this.bars[n]];
    node.onpointermove = ({ clientX }) => {
      this.bars[n].splice(0, 2, ...before);
      this.#shift(n, which, small * Math.round(((clientX - from) / width) * SMALL_STEPS));
    };
    node.onpointerup = node.onpointercancel = () => { node.onpointermove = null; };
  }
}
