// Curves of the scene's main metric over the key of a slider, with the values at which it has a
// target and its interval for an uncertain key, computed by a worker of their own.
import { place, presentOf, setKey, STEPS, valueAt } from "./controls.js";
import { SimulatorError } from "./core.js";
import { make } from "./dom.js";
import { digits, grouped, prefixed, quantity } from "./format.js";
import { extent, ticks } from "./path.js";
import { Ask } from "./request.js";

/** Steps of the slider at which a curve has points: first its ends, then finer ones. */
const CURVE_STEPS = [0, 12, 6, 3, 9, 1, 5, 8, 11, 2, 4, 7, 10].map((place) => (place * STEPS) / 12);
/** Longest run of a point with which a curve is computed again after a change, s. */
const FOLLOW_LIMIT_S = 1;
/** Points for an uncertain key, in units of the half-width that contains 95 % of its values. */
const BAND_POINTS = [-1.25, -1, -0.75, -0.5, -0.25, 0.25, 0.5, 0.75, 1, 1.25];
/** Place of the plot in its picture, and the size of the picture. */
const PLOT = { left: 46, right: 290, top: 30, bottom: 146, width: 300, height: 180 };

/** Creates an element of a picture. */
function shape(name, attributes, ...children) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

/** Returns positions and texts of the marks of an axis, in a unit of this size. */
function marks(low, high, most, log, factor) {
  if (log) {
    const all = Array.from({ length: 60 }, (_, n) => [[1, 2, 5][n % 3] * 10 ** (Math.floor(n / 3) - 9), n % 3]);
    const inside = all.filter(([value]) => value >= low && value <= high);
    return inside.filter(([, digit]) => digit === 0 || inside.length <= 6).map(([value]) => [value, digits(value / factor, 2)]);
  }
  const places = ticks(low / factor, high / factor, most), step = places[1] - places[0] || 1;
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return places.map((value) => [value * factor, decimals > 4 ? digits(value, 2) : grouped(value.toFixed(decimals))]);
}

/** Replaces a text that has changed, so that a screen reader reads it once. */
const rewrite = (node, words) => { if (node.textContent !== words) node.textContent = words; };

class Curve {
  /** Values of the key with `value` or, if the run has none, `why`. */
  points = new Map();
  target = null;
  /** Searches for the target, each with its points and, at the end, its result; null before they begin. */
  searches = null;
  /** Half-width that contains 95 % of the values of the key, as a function of the value. */
  width = () => 0;

  constructor(given, all) {
    Object.assign(this, { given, all, id: `curve-${given.key}`, wall_s: 0, turn: 0, isOpen: false });
    this.place = make("div", { class: "curve", id: this.id, hidden: true });
    const named = { "aria-label": `Curve: ${given.label}`, "aria-controls": this.id, "aria-expanded": "false" };
    const onclick = () => this.toggle();
    this.button = make("button", { type: "button", class: "text", id: `${this.id}-open`, ...named, onclick }, "Curve");
  }

  get present() { return presentOf(this.all.page.ask(), this.given); }
  get isWaiting() { return this.isOpen && this.metric && !this.isStopped && !this.isOutdated && !this.isDone; }

  toggle() {
    this.isOpen = !this.isOpen;
    this.place.hidden = !this.isOpen;
    this.button.setAttribute("aria-expanded", String(this.isOpen));
    return this.isOpen ? this.start() : this.all.halt(this);
  }

  /** Computes the curve, if the scene has a result. */
  start() {
    const main = this.all.page.latest()?.main;
    if (!main) return this.place.replaceChildren(make("p", { class: "mode" }, "The scene has no result to draw yet."));
    if (!this.metric) this.build(main);
    return this.again();
  }

  build([label, name, unit]) {
    Object.assign(this, { metric: { label, name, unit }, sign: this.signature() });
    const words = () => make("p", { class: "mode", "aria-live": "polite" });
    const number = (id, onchange) => make("input", { type: "number", step: "any", id, onchange });
    const row = (id, label, ...fields) => make("div", { class: "row" }, make("label", { for: id }, label), ...fields);
    this.picture = shape("svg", { viewBox: `0 0 ${PLOT.width} ${PLOT.height}`, role: "img" });
    const onclick = () => (this.isWaiting ? this.all.halt(this) : this.again());
    this.act = make("button", { type: "button", id: `${this.id}-act`, onclick });
    Object.assign(this, { words: words(), bandWords: words(), count: make("span", { class: "mode" }) });
    this.line = make("div", { class: "row" }, this.act, this.count);
    this.roots = make("ul", { class: "roots mode", "aria-live": "polite" });
    this.place.replaceChildren(this.picture, this.words, this.line);
    if (this.given.whole) return;
    const target = number(`${this.id}-target`, () => {
      Object.assign(this, { target: Number.isFinite(target.valueAsNumber) ? target.valueAsNumber : null, searches: null });
      this.again();
    });
    const blur = () => {
      const amount = Math.max(0, width.valueAsNumber || 0);
      this.width = (value) => (percent.value === "%" ? Math.abs(value * amount) / 100 : amount);
      this.again();
    };
    const width = number(`${this.id}-band`, blur), units = [...new Set([this.given.unit, "%"])];
    const choices = units.map((name) => make("option", { value: name }, name));
    const named = { id: `${width.id}-unit`, "aria-label": "Unit of the uncertainty" };
    const percent = make("select", { ...named, onchange: blur }, ...choices);
    const below = [this.roots, row(width.id, "Uncertainty ±", width, percent), this.bandWords];
    this.place.append(row(target.id, "Target", target, unit), ...below);
  }

  /** Returns the request with a value of the key. */
  request(value) {
    const ask = this.all.page.ask(), other = Object.assign(new Ask(ask), ask, { moved: new Map(ask.moved), whole: false });
    setKey(other, this.given, value);
    return other.request;
  }

  /** Identifies all other values of the scene. */
  signature() { return JSON.stringify(this.request(0)); }
  renew() { Object.assign(this, { points: new Map(), searches: null, sign: this.signature(), isOutdated: false }); }

  /** Computes the missing points, or all if another value has changed. */
  again() {
    Object.assign(this, { isStopped: false, isDone: false, turn: this.turn + 1 });
    if (this.sign !== this.signature()) this.renew();
    this.take();
    this.draw();
    this.all.work();
  }

  /** Follows a change of the scene. */
  check() {
    if (!this.metric) return;
    Object.assign(this, { isDone: false, turn: this.turn + 1, isOutdated: this.sign !== this.signature() });
    if (this.isOutdated && this.isOpen && !this.isStopped && this.wall_s <= FOLLOW_LIMIT_S) this.renew();
    this.draw();
  }

  /** Takes the point of the latest run of the page. */
  take() {
    // A curve that was opened before the first result begins with it.
    if (this.isOpen && !this.metric) return void this.start();
    const { page } = this.all, { metrics, fault, sent } = page.latest() ?? {};
    if (!this.metric || this.isOutdated || sent !== JSON.stringify(page.ask().request)) return;
    const value = metrics[this.metric.name], why = fault ? `the run ends in fault ${fault}` : "the run has no such number";
    this.points.set(this.present, fault || !Number.isFinite(value) ? { why } : { value });
    this.draw();
  }

  /** Returns the values of the key for the curve and for its uncertainty. */
  grid() {
    const { given, present } = this, half = this.width(present);
    const near = BAND_POINTS.map((part) => present + part * half).filter((value) => value >= given.min && value <= given.max);
    return [...new Set([...CURVE_STEPS.map((step) => valueAt(given, step)), ...(half > 0 ? near : [])])];
  }

  /** Returns the next value of the key to run, and the search that it belongs to; null at the end. */
  async next() {
    const value = this.grid().find((one) => !this.points.has(one)), { target } = this;
    if (value !== undefined || target === null) return value === undefined ? null : { value };
    this.searches ??= this.brackets();
    for (const search of this.searches.filter(({ end }) => !end)) {
      const step = await this.all.core.ask("target", { target, points: search.points });
      if (step.next !== null) return { value: step.next, search };
      search.end = step;
    }
    return null;
  }

  /** Returns the points in order; a point without a metric is NaN. */
  sorted() { return [...this.points].map(([key, { value }]) => [key, value ?? NaN]).sort(([a], [b]) => a - b); }

  /** Returns the metric at a value of the key, between points; NaN if a point next to it has none. */
  at(key) {
    const sorted = this.sorted(), after = sorted.findIndex(([other]) => other >= key), [x1, y1] = sorted[after] ?? [NaN, NaN];
    const [x0, y0] = sorted[after - 1] ?? [NaN, NaN];
    return x1 === key ? y1 : y0 + ((y1 - y0) * (key - x0)) / (x1 - x0);
  }

  /** Returns a search between each two neighbouring points with the target between them, or on it. */
  brackets() {
    const sorted = this.sorted(), off = (place) => (sorted[place]?.[1] ?? NaN) - this.target, searches = [];
    for (let place = 0; place < sorted.length; place += 1) {
      const root = sorted[place][0];
      if (off(place) * off(place + 1) < 0) searches.push({ points: sorted.slice(place, place + 2), end: null });
      if (off(place) !== 0) continue;
      while (off(place + 1) === 0) place += 1;
      searches.push({ points: [], end: { root, to: sorted[place][0] } });
    }
    return searches;
  }

  /** Returns the roots in words with their values, and the reasons that a search has none. */
  found() {
    const ended = (this.searches ?? []).filter(({ end }) => end).map(({ end }) => end);
    if (this.target === null || this.isOutdated) return [];
    if (this.isDone && ended.length === 0) return [["Not reached in this range.", null]];
    return ended.map(({ root = null, to, at, why }) => {
      if (root === null) return [`${why ? "No result" : "A jump over the target"} at ${this.keyText(at)}.`, null];
      return [to > root ? `${this.keyText(root)} to ${this.keyText(to)}` : this.keyText(root), root];
    });
  }

  listRoots(found) {
    if (this.listed === (this.listed = JSON.stringify(found))) return;
    const item = ([words, root], place) => {
      const named = { id: `${this.id}-root-${place}`, "aria-label": `Set ${this.given.label} to ${words}` };
      const onclick = () => this.all.page.move(this.given, root);
      const set = root === null ? null : make("button", { type: "button", class: "text", ...named, onclick }, "Set");
      return make("li", {}, words, " ", set);
    };
    this.roots.replaceChildren(...found.map(item));
  }

  /** Returns the interval with 95 % of the metric for a normally distributed key, and its description; null without one. */
  band() {
    const { given: { min, max }, metric: { label }, present } = this, half = this.width(present), found = [];
    if (!(half > 0) || this.isOutdated || !this.grid().every((value) => this.points.has(value))) return null;
    let all = 0, kept = 0;
    for (let z = -3.5; z <= 3.5; z += 0.01) {
      // 95 % are within 1.96 standard deviations.
      const weight = Math.exp(-z * z / 2), key = present + (z * half) / 1.96;
      const value = key < min || key > max ? NaN : this.at(key);
      all += weight;
      if (Number.isNaN(value)) continue;
      kept += weight;
      found.push([value, weight]);
    }
    if (!found.length) return null;
    found.sort(([a], [b]) => a - b);
    const quantile = (part) => { let sum = 0; return found.find(([, weight]) => (sum += weight) >= part * kept)[0]; };
    const [low, high] = [0.025, 0.975].map(quantile), without = 1 - kept / all;
    const about = `for a normal distribution with 95 % within ± ${this.keyText(half)}.`;
    const words = [`${label} from ${this.metricText(low)} to ${this.metricText(high)} (95 %), ${about}`];
    if (without > 1e-3) words.push(`${digits(100 * without, 2)} % of it are left out: outside the slider, or without a result.`);
    return { low, high, half, words: words.join(" ") };
  }

  keyText(value) { return quantity(value, this.given.unit, 5); }
  metricText(value) { return `${digits(Number(value.toFixed(12)))} ${this.metric.unit}`.trim(); }

  draw() {
    if (!this.metric || !this.isOpen) return;
    const { log, min, max, label, unit } = this.given, { left, right, top, bottom, width, height } = PLOT;
    const here = this.present, now = this.at(here), sorted = this.sorted(), band = this.band(), found = this.found();
    const known = sorted.filter(([, value]) => !Number.isNaN(value)), aim = this.target === null ? [] : [this.target];
    const ys = extent([...known.map(([, value]) => value), ...aim], 0.08);
    const X = (key) => left + (place(this.given, Math.min(max, Math.max(min, key))) / STEPS) * (right - left);
    const Y = (value) => bottom - ((value - ys[0]) / (ys[1] - ys[0])) * (bottom - top);
    const [factor, name] = prefixed(Math.max(Math.abs(min), Math.abs(max)), unit);
    const rule = (x1, y1, x2, y2, kind) => shape("line", { x1, y1, x2, y2, class: kind });
    const note = (x, y, anchor, words) => shape("text", { x, y, "text-anchor": anchor }, words);
    const dot = (x, y, r, kind) => shape("circle", { cx: x, cy: y, r, class: kind });
    const strip = ([x0, y0, x1, y1]) => shape("rect", { x: x0, y: y0, width: x1 - x0, height: y1 - y0, class: "band" });
    // A point without a metric interrupts the line.
    const letter = (place) => (sorted[place - 1]?.[1] >= -Infinity ? "L" : "M");
    const path = sorted.map(([key, value], place) => (Number.isNaN(value) ? "" : `${letter(place)}${X(key)} ${Y(value)}`));
    const down = ([x, words]) => [rule(X(x), top, X(x), bottom, "grid"), note(X(x), bottom + 13, "middle", words)];
    const across = ([y, words]) => [rule(left, Y(y), right, Y(y), "grid"), note(left - 5, Y(y) + 3.5, "end", words)];
    const wide = ({ low, high, half }) => [[X(here - half), top, X(here + half), bottom], [left, Y(high), right, Y(low)]];
    const named = (...words) => words.filter(Boolean).join(", ");
    const [side, shift] = X(here) > width / 2 ? ["end", -4] : ["start", 4];
    this.picture.replaceChildren(
      ...(band ? wide(band).map(strip) : []),
      ...marks(min, max, 4, log, factor).flatMap(down), ...marks(...ys, 6, false, 1).flatMap(across),
      note(2, 10, "start", named(this.metric.label, this.metric.unit)),
      note((left + right) / 2, height - 5, "middle", named(label, name)),
      shape("path", { d: path.join("") }), ...known.map(([key, value]) => dot(X(key), Y(value), 2.2, "dot")),
      ...aim.map((value) => rule(left, Y(value), right, Y(value), "target")),
      ...found.filter(([, root]) => root !== null).map(([, root]) => dot(X(root), Y(this.target), 4.5, "target")),
      rule(X(here), top, X(here), bottom, "here"), ...(Number.isNaN(now) ? [] : [dot(X(here), Y(now), 4.5, "here")]),
      note(X(here) + shift, top - 4, side, "you are here"),
    );
    this.say(known, now);
    this.listRoots(found);
    rewrite(this.bandWords, band?.words ?? "");
  }

  /** Describes the curve in words, for its picture and below it. */
  say(known, now) {
    const grid = this.grid(), run = grid.filter((value) => this.points.has(value)).length, { label } = this.metric;
    const end = ([key, value]) => `${this.metricText(value)} at ${this.keyText(key)}`;
    const [first, ...others] = [...this.points].filter(([, { why }]) => why).sort(([a], [b]) => a - b);
    const result = Number.isNaN(now) ? "without a result" : `${label} ${this.metricText(now)}`;
    const here = `You are here: ${this.keyText(this.present)}, ${result}.`, words = [here];
    const count = `No result at ${1 + others.length} of ${this.points.size} points`;
    if (first) words.push(`${count}; the first at ${this.keyText(first[0])}: ${first[1].why.split("\n")[0]}.`);
    if (this.isOutdated) words.push("Outdated: another value has changed.");
    rewrite(this.words, words.join(" "));
    const ends = known.length ? ` from ${end(known[0])} to ${end(known.at(-1))}` : "";
    this.picture.setAttribute("aria-label", `${label} over ${this.given.label}${ends}. ${here}`);
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
  constructor(core, page) { Object.assign(this, { core, page }); }

  /** Returns the button of a slider's curve, and the element of the curve. */
  nodes(given) {
    const curve = this.#curves.get(given.key) ?? new Curve(given, this);
    this.#curves.set(given.key, curve);
    return [curve.button, curve.place];
  }

  /** Removes all curves, for another scene. */
  clear() { this.#curves.clear(); this.core.stop(); }

  check() { this.#curves.forEach((curve) => curve.check()); }
  take() { this.#curves.forEach((curve) => curve.take()); }

  /** Stops a curve. */
  halt(curve) {
    curve.isStopped = true;
    if (this.#running === curve) this.core.stop();
    curve.draw();
  }

  /** Runs the points of open curves, one at a time, while the page itself does not run. */
  async work() {
    while (!this.#running && this.page.isIdle()) {
      const curve = [...this.#curves.values()].find(({ isWaiting }) => isWaiting);
      if (!curve) return;
      this.#running = curve;
      await this.#step(curve).catch(() => { curve.isStopped = true; });
      this.#running = null;
      curve.draw();
    }
  }

  async #step(curve) {
    const { sign, turn } = curve, next = await curve.next(), began = performance.now();
    if (turn !== curve.turn) return;
    curve.isDone = !next;
    if (!next) return;
    const asked = this.core.ask("point", { ...curve.request(next.value), metric: curve.metric.name });
    const refused = (error) => { if (error instanceof SimulatorError) return { why: error.message }; throw error; };
    const found = await asked.then((value) => ({ value }), refused);
    curve.wall_s = (performance.now() - began) / 1e3;
    if (sign !== curve.sign || curve.isOutdated) return;
    curve.points.set(next.value, found);
    if (found.why && next.search) next.search.end = { at: next.value, ...found };
    else next.search?.points.push([next.value, found.value]);
  }
}
