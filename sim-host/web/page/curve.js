// Curves of the scene's main metric over the key of a slider, with the values at which it has a
// target, computed by a worker of their own.
import { presentOf, setKey, STEPS, valueAt } from "./controls.js";
import { make } from "./dom.js";
import { digits, grouped, prefixed, quantity } from "./format.js";
import { extent, ticks } from "./path.js";

/** Points of a curve over the steps of the slider: first its ends, then finer ones. */
const CURVE_POINTS = [0, 12, 6, 3, 9, 1, 5, 8, 11, 2, 4, 7, 10].map((place) => (place * STEPS) / 12);
/** Longest run of a point with which a curve is computed again after a change, s. */
const FOLLOW_LIMIT_S = 1;
/** Largest number of points of a search for a target. */
const MAX_SEARCH_POINTS = 40;
/** Place of the plot in its picture, and the size of the picture. */
const PLOT = { left: 46, right: 290, top: 22, bottom: 138, width: 300, height: 172 };

/** Creates an element of a picture. */
function shape(name, attributes, ...children) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

/** Returns positions and texts of the marks of an axis. */
function marks([low, high], most, log, factor) {
  const places = ticks(low / factor, high / factor, most), step = places[1] - places[0] || 1;
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const linear = (value) => (decimals > 4 ? digits(value, 2) : grouped(value.toFixed(decimals)));
  const words = (value) => (log ? digits(10 ** value, 2) : linear(value));
  return places.map((value) => [value * factor, words(value)]);
}

class Curve {
  metric = null;
  isOpen = false;
  isStopped = false;
  isOutdated = false;
  isDone = false;
  wall_s = 0;
  /** Number of changes so far. */
  turn = 0;
  /** Values of the key with `value` or, if the run has none, `why`. */
  points = new Map();
  former = [];
  target = null;
  /** Searches for the target, each with its points and, at the end, its result; null before they begin. */
  searches = null;

  constructor(given, all) {
    Object.assign(this, { given, all });
    this.place = make("div", { class: "curve", id: `curve-${given.key}`, hidden: true });
    const id = this.place.id, named = { "aria-label": `Curve: ${given.label}`, "aria-controls": id, "aria-expanded": "false" };
    const attributes = { type: "button", class: "text", id: `${id}-open`, ...named, onclick: () => this.toggle() };
    this.button = make("button", attributes, "Curve");
  }

  get present() { return presentOf(this.all.page.ask(), this.given); }

  /** `true` if there is something to run. */
  get isWaiting() { return this.isOpen && this.metric !== null && !this.isStopped && !this.isOutdated && !this.isDone; }

  toggle() {
    this.isOpen = !this.isOpen;
    this.place.hidden = !this.isOpen;
    this.button.setAttribute("aria-expanded", String(this.isOpen));
    if (!this.isOpen) return this.all.halt(this);
    const main = this.all.page.latest()?.main;
    if (!main) return this.place.replaceChildren(make("p", { class: "mode" }, "The scene has no result to draw yet."));
    if (!this.metric) this.build(main);
    return this.again();
  }

  build([label, name, unit]) {
    this.metric = { label, name, unit };
    this.sign = this.signature();
    this.picture = shape("svg", { viewBox: `0 0 ${PLOT.width} ${PLOT.height}`, role: "img" });
    this.words = make("p", { class: "mode", "aria-live": "polite" });
    this.count = make("span", { class: "mode" });
    const act = () => (this.isWaiting ? this.stop() : this.again());
    this.act = make("button", { type: "button", id: `${this.place.id}-act`, onclick: act });
    this.line = make("div", { class: "row" }, this.act, this.count);
    this.place.replaceChildren(this.picture, this.words, this.line, ...(this.given.whole ? [] : this.questions()));
  }

  questions() {
    const id = `${this.place.id}-target`;
    const box = make("input", { type: "number", step: "any", id, onchange: () => this.seek(box.valueAsNumber) });
    this.roots = make("ul", { class: "roots mode", "aria-live": "polite" });
    return [make("div", { class: "row" }, make("label", { for: id }, "Target"), box, this.metric.unit), this.roots];
  }

  /** Finds the values of the key at which the metric has this value. */
  seek(target) {
    Object.assign(this, { target: Number.isFinite(target) ? target : null, searches: null });
    this.again();
  }

  /** Returns a search between each two neighbouring points with the target between them, or on it. */
  brackets() {
    const sorted = this.sorted().map(([key, { value }]) => [key, value ?? NaN]), searches = [];
    const off = (place) => (sorted[place]?.[1] ?? NaN) - this.target;
    for (let place = 0; place < sorted.length; place += 1) {
      const root = sorted[place][0];
      if (off(place) * off(place + 1) < 0) searches.push({ points: sorted.slice(place, place + 2), end: null });
      if (off(place) !== 0) continue;
      while (off(place + 1) === 0) place += 1;
      searches.push({ points: [], end: { root, to: sorted[place][0] } });
    }
    return searches;
  }

  /** Returns the roots, and the reasons that a search has none. */
  found() {
    const name = this.metric.label, ended = (this.searches ?? []).filter(({ end }) => end).map(({ end }) => end);
    if (this.target === null || this.isOutdated) return [];
    if (this.isDone && ended.length === 0) return [["Not reached in this range.", null]];
    return ended.map(({ root, to, at, why }) => {
      if (why) return [`No result at ${this.keyText(at)}: ${why}.`, null];
      if (root === null) return [`${name} jumps over it at ${this.keyText(at)}.`, null];
      return [to > root ? `${this.keyText(root)} to ${this.keyText(to)}` : this.keyText(root), root];
    });
  }

  listRoots() {
    const found = this.found(), text = JSON.stringify(found);
    if (!this.roots || this.roots.dataset.text === text) return;
    this.roots.dataset.text = text;
    const set = (root, words, place) => {
      const named = { id: `${this.place.id}-root-${place}`, "aria-label": `Set ${this.given.label} to ${words}` };
      return make("button", { type: "button", class: "text", ...named, onclick: () => this.all.page.move(this.given, root) }, "Set");
    };
    const item = ([words, root], place) => make("li", {}, words, " ", root === null ? null : set(root, words, place));
    this.roots.replaceChildren(...found.map(item));
  }

  /** Returns the request with a value of the key. */
  request(value) {
    const ask = this.all.page.ask().copy();
    ask.whole = false;
    setKey(ask, this.given, value);
    return ask.request;
  }

  /** Identifies all other values of the scene. */
  signature() { return JSON.stringify(this.request(0)); }

  /** Computes the missing points, or all if another value has changed. */
  again() {
    Object.assign(this, { isStopped: false, isDone: false, turn: this.turn + 1 });
    if (this.sign !== this.signature()) this.renew();
    this.take();
    this.draw();
    this.all.work();
  }

  renew() {
    Object.assign(this, { former: this.known(), points: new Map(), searches: null, sign: this.signature(), isOutdated: false });
  }

  stop() {
    this.isStopped = true;
    this.all.halt(this);
    this.draw();
  }

  /** Follows a change of the scene. */
  check() {
    if (!this.metric) return;
    Object.assign(this, { isDone: false, turn: this.turn + 1 });
    this.isOutdated = this.sign !== this.signature();
    if (this.isOutdated && this.isOpen && !this.isStopped && this.wall_s <= FOLLOW_LIMIT_S) this.renew();
    this.draw();
  }

  /** Takes the point of the latest run of the page. */
  take() {
    const { page } = this.all, { metrics, sent } = page.latest() ?? {};
    if (!this.metric || this.isOutdated || sent !== JSON.stringify(page.ask().request)) return;
    const value = metrics[this.metric.name], code = page.hasRuns() ? 0 : metrics.fault_code;
    const point = Number.isFinite(value) ? { value } : { why: "the run has no such number" };
    this.points.set(this.present, code ? { why: `the run ends in fault ${code}` } : point);
    this.draw();
  }

  /** Returns the next value of the key to run, and the search that it belongs to; null at the end. */
  async next() {
    const value = this.grid().find((one) => !this.points.has(one));
    if (value !== undefined) return { value };
    if (this.target === null) return null;
    const { target } = this;
    this.searches ??= this.brackets();
    for (const search of this.searches.filter(({ end }) => !end)) {
      const step = await this.all.core.ask("target", { target, points: search.points });
      if (step.next !== null && search.points.length < MAX_SEARCH_POINTS) return { value: step.next, search };
      search.end = step;
    }
    return null;
  }

  grid() { return [...new Set(CURVE_POINTS.map((step) => valueAt(this.given, step)))]; }

  /** Returns the points in order. */
  sorted() { return [...this.points].sort(([a], [b]) => a - b); }

  /** Returns the points with a metric, in order. */
  known() { return this.sorted().filter(([, { value }]) => value !== undefined).map(([key, { value }]) => [key, value]); }

  /** Returns the metric at a value of the key, between points; null if a point next to it has none. */
  at(key) {
    const sorted = this.sorted(), after = sorted.findIndex(([other]) => other >= key);
    if (after < 0) return null;
    const [x1, { value: y1 }] = sorted[after], [x0, { value: y0 }] = sorted[after - 1] ?? sorted[after];
    if (x1 === key) return y1 ?? null;
    return y0 === undefined || y1 === undefined || x0 === x1 ? null : y0 + ((y1 - y0) * (key - x0)) / (x1 - x0);
  }

  /** Formats a value of the key, or of the metric. */
  keyText(value) { return quantity(value, this.given.unit, 5); }
  metricText(value) {
    const size = Math.max(...this.known().map(([, one]) => Math.abs(one)));
    return `${digits(Math.abs(value) < 1e-6 * size ? 0 : value)} ${this.metric.unit}`.trim();
  }

  draw() {
    if (!this.metric || !this.isOpen) return;
    const known = this.known(), here = this.present, now = this.at(here);
    const { log, min, max, label, unit } = this.given, { left, right, top, bottom, width, height } = PLOT;
    const scale = (key) => (log ? Math.log10(key) : key), xs = [scale(min), scale(max)];
    const aim = this.target === null ? [] : [this.target], roots = this.found().map(([, root]) => root).filter((root) => root !== null);
    const ys = extent([...known.map(([, value]) => value), ...this.former.map(([, value]) => value), ...aim], 0.08);
    const X = (key) => left + ((scale(key) - xs[0]) / (xs[1] - xs[0])) * (right - left);
    const Y = (value) => bottom - ((value - ys[0]) / (ys[1] - ys[0])) * (bottom - top);
    const [factor, name] = log ? [1, unit] : prefixed(Math.max(Math.abs(min), Math.abs(max)), unit);
    const named = (words, of) => (of ? `${words}, ${of}` : words);
    const rule = (x1, y1, x2, y2, kind) => shape("line", { x1, y1, x2, y2, class: kind });
    const note = (x, y, anchor, words) => shape("text", { x, y, "text-anchor": anchor }, words);
    const corner = ([key, value]) => `${X(key).toFixed(1)},${Y(value).toFixed(1)}`;
    const path = (points, kind) => shape("polyline", { points: points.map(corner).join(" "), class: kind });
    const dot = (x, y, r, kind) => shape("circle", { cx: x, cy: y, r, class: kind });
    const down = ([x, words]) => [rule(x, top, x, bottom, "grid"), note(x, bottom + 13, "middle", words)];
    const across = ([y, words]) => [rule(left, Y(y), right, Y(y), "grid"), note(left - 5, Y(y) + 3.5, "end", words)];
    // A point without a metric interrupts the line.
    const pieces = [[]];
    for (const [key, { value }] of this.sorted()) if (value === undefined) pieces.push([]); else pieces.at(-1).push([key, value]);
    const hereX = Math.min(right, Math.max(left, X(here))), [side, shift] = hereX > width / 2 ? ["end", -4] : ["start", 4];
    this.picture.replaceChildren(
      ...marks(xs, 4, log, factor).map(([x, words]) => [X(log ? 10 ** x : x), words]).flatMap(down),
      ...marks(ys, 6, false, 1).flatMap(across),
      note(2, 11, "start", named(this.metric.label, this.metric.unit)),
      note((left + right) / 2, height - 5, "middle", named(label, name)),
      path(this.former, "former"), ...pieces.map((piece) => path(piece, "line")),
      ...known.map(([key, value]) => dot(X(key), Y(value), 2.2, "dot")),
      ...aim.map((value) => rule(left, Y(value), right, Y(value), "target")),
      ...roots.map((root) => dot(X(root), Y(this.target), 4.5, "root")),
      rule(hereX, top, hereX, bottom, "here"), ...(now === null ? [] : [dot(hereX, Y(now), 4.5, "here")]),
      note(hereX + shift, top + 9, side, "you are here"),
    );
    this.say(known, now);
    this.listRoots();
  }

  /** Describes the curve in words, for its picture and below it. */
  say(known, now) {
    const grid = this.grid(), run = grid.filter((value) => this.points.has(value)).length;
    const place = ([key, value]) => `${this.metricText(value)} at ${this.keyText(key)}`;
    const missing = this.sorted().filter(([, { why }]) => why);
    const metric = now === null ? "without a result" : `${this.metric.label} ${this.metricText(now)}`;
    const here = `You are here: ${this.keyText(this.present)}, ${metric}.`, words = [here];
    if (missing.length) {
      const [first, { why }] = missing[0], count = `${missing.length} of ${this.points.size} points`;
      words.push(`No result at ${count}; the first at ${this.keyText(first)}: ${why.split("\n")[0]}.`);
    }
    if (this.isOutdated) words.push("Outdated: another value has changed.");
    this.place.classList.toggle("outdated", this.isOutdated);
    const ends = known.length ? ` from ${place(known[0])} to ${place(known.at(-1))}` : "";
    this.picture.setAttribute("aria-label", `${this.metric.label} over ${this.given.label}${ends}. ${here}`);
    if (this.words.textContent !== words.join(" ")) this.words.textContent = words.join(" ");
    this.act.textContent = this.isWaiting ? "Stop" : "Compute again";
    this.count.textContent = `${run} of ${grid.length} points`;
    this.line.hidden = !this.isWaiting && !this.isOutdated && run === grid.length;
    this.place.dataset.state = this.isOutdated ? "outdated" : this.isWaiting ? "busy" : this.isStopped ? "stopped" : "done";
  }
}

/** The curves of all sliders. */
export class Curves {
  #curves = new Map();
  #running = null;

  /** Creates the curves; `core` runs their points, `page` has the state of the page. */
  constructor(core, page) {
    Object.assign(this, { core, page });
  }

  /** Returns the button of a slider's curve, and the element of the curve. */
  nodes(given) {
    if (!this.#curves.has(given.key)) this.#curves.set(given.key, new Curve(given, this));
    const { button, place } = this.#curves.get(given.key);
    return [button, place];
  }

  /** Removes all curves, for another scene. */
  clear() {
    this.#curves.clear();
    this.core.stop();
  }

  check() { for (const curve of this.#curves.values()) curve.check(); }

  take() { for (const curve of this.#curves.values()) curve.take(); }

  /** Ends the run of a curve. */
  halt(curve) { if (this.#running === curve) this.core.stop(); }

  /** Runs the points of open curves, one at a time, while the page itself does not run. */
  async work() {
    if (this.#running) return;
    for (;;) {
      const curve = this.page.isIdle() ? [...this.#curves.values()].find(({ isWaiting }) => isWaiting) : null;
      if (!curve) return;
      this.#running = curve;
      try {
        await this.#step(curve);
      } catch (error) {
        if (error.name !== "AbortError") Object.assign(curve, { isStopped: true });
      } finally {
        this.#running = null;
      }
      curve.draw();
    }
  }

  async #step(curve) {
    const { sign, turn } = curve, next = await curve.next();
    if (turn !== curve.turn) return undefined;
    if (!next) return Object.assign(curve, { isDone: true, former: [] });
    const { value, search } = next;
    const began = performance.now();
    const found = await this.core.ask("point", { ...curve.request(value), metric: curve.metric.name });
    curve.wall_s = (performance.now() - began) / 1e3;
    if (sign !== curve.sign || curve.isOutdated) return undefined;
    curve.points.set(value, found);
    if (search && found.why) search.end = { at: value, ...found };
    else search?.points.push([value, found.value]);
    return undefined;
  }
}
