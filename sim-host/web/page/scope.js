// The scope: plots below each other over one time axis. The part before the chosen time is bright,
// the part after it pale.
import { colour, sheet } from "./dom.js";
import { digits, quantity } from "./format.js";
import { ticks } from "./path.js";

const LEFT = 58, RIGHT = 10, TOP = 24, BELOW = 26, GAP = 26;

/** Signals of a run over time, with a chosen time and a visible interval. */
export class Scope {
  constructor(canvas) {
    this.canvas = canvas;
    this.data = null;
    this.moment = Infinity;
    new ResizeObserver(() => this.draw()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  /** Shows a result, over its whole time. */
  show(data) {
    this.data = data;
    const time = data.time_s;
    this.ends = [time.length > 1 && time[0] > 0.02 * time.at(-1) ? time[0] : 0, time.at(-1) ?? 1];
    this.shown = [...this.ends];
    this.scales = data.lanes.map((lane) => this.#scale(lane));
    this.moment = this.ends[1];
    this.canvas.setAttribute("aria-label", this.#words());
    this.draw();
  }

  #words() {
    const lanes = this.data.lanes.map(({ label, unit, signals }) => {
      const values = signals.at(-1).values.filter((value) => value !== null);
      return `${label} up to ${quantity(values.reduce((most, value) => Math.max(most, value), 0), unit, 3)}`;
    });
    return `Signals over ${quantity(this.ends[1] - this.ends[0], "s", 3)}: ${lanes.join(", ")}. The table below has their values at the chosen time.`;
  }

  #scale({ range, signals }) {
    if (range) return range;
    let low = 0, high = -Infinity;
    for (const { values, band } of signals) for (const list of [values, ...(band ?? [])]) for (const value of list) {
      if (value === null) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
    if (high <= low) high = low + 1;
    return [low < 0 ? low - 0.06 * (high - low) : 0, high + 0.1 * (high - low)];
  }

  /** Shortens or lengthens the visible interval around the chosen time. */
  zoom(factor) {
    const [from, to] = this.shown, whole = this.ends[1] - this.ends[0];
    const long = Math.min(whole, Math.max(whole / 4000, (to - from) * factor));
    const centre = Math.max(this.ends[0], Math.min(this.ends[1], this.moment));
    const begin = Math.max(this.ends[0], Math.min(this.ends[1] - long, centre - (long * (centre - from)) / (to - from || 1)));
    this.shown = [begin, begin + long];
    this.draw();
  }

  /** Returns true if the whole run is visible. */
  get isWhole() {
    return this.data === null || this.shown[1] - this.shown[0] >= 0.999 * (this.ends[1] - this.ends[0]);
  }

  /** Moves to a time, s; the visible interval follows it. */
  goto(moment) {
    this.moment = moment;
    const [from, to] = this.shown;
    if (moment < from || moment > to) {
      const begin = Math.max(this.ends[0], Math.min(this.ends[1] - (to - from), moment - 0.1 * (to - from)));
      this.shown = [begin, begin + to - from];
    }
    this.draw();
  }

  /** Returns the index of the last point before a time. */
  index(moment = this.moment) {
    const time = this.data.time_s;
    let low = 0, high = time.length;
    while (low < high) { const mid = (low + high) >> 1; if (time[mid] <= moment) low = mid + 1; else high = mid; }
    return Math.max(0, low - 1);
  }

  draw() {
    if (!this.data || this.canvas.clientWidth === 0) return;
    const { lanes } = this.data;
    const high = this.canvas.clientWidth < 560 ? 92 : 108;
    const { context, width, height } = sheet(this.canvas, TOP + lanes.length * (high + GAP) - GAP + BELOW + 12);
    const [from, to] = this.shown;
    const X = (s) => LEFT + ((s - from) / (to - from)) * (width - LEFT - RIGHT);
    context.font = "12px system-ui, sans-serif";
    const bottom = height - BELOW - 6;
    context.fillStyle = colour("shade");
    for (const [begin, end] of this.data.on_s) {
      const left = Math.max(LEFT, X(begin)), right = Math.min(width - RIGHT, X(end));
      if (right > left) context.fillRect(left, TOP, Math.max(0.6, right - left), bottom - TOP - 4);
    }
    lanes.forEach((lane, place) => this.#lane(context, lane, this.scales[place], X, TOP + place * (high + GAP), high, width));
    context.fillStyle = colour("muted");
    context.textBaseline = "top";
    const marks = ticks(from, to, Math.max(2, (width - LEFT - RIGHT) / 110));
    const millis = to < 1;
    marks.forEach((s) => {
      context.textAlign = X(s) > width - 40 ? "right" : "center";
      context.fillText(millis ? `${digits(s * 1e3, 6)} ms` : `${digits(s, 6)} s`, X(s), bottom);
    });
    if (this.moment >= from && this.moment <= to) {
      context.strokeStyle = colour("ink");
      context.lineWidth = 1.2;
      context.beginPath(); context.moveTo(X(this.moment), TOP); context.lineTo(X(this.moment), bottom - 2); context.stroke();
    }
  }

  #lane(context, lane, [low, high], X, top, tall, width) {
    const Y = (value) => top + tall - ((value - low) / (high - low)) * tall;
    const time = this.data.time_s;
    context.lineWidth = 1;
    context.textAlign = "right"; context.textBaseline = "middle";
    for (const value of ticks(low, high, 4)) {
      context.strokeStyle = colour("grid");
      context.beginPath(); context.moveTo(LEFT, Y(value)); context.lineTo(width - RIGHT, Y(value)); context.stroke();
      context.fillStyle = colour("muted");
      context.fillText(digits(value, lane.unit === "Hz" ? 7 : 3), LEFT - 6, Math.max(top + 6, Math.min(top + tall - 4, Y(value))));
    }
    const first = Math.max(0, this.index(this.shown[0]) - 1), last = Math.min(time.length - 1, this.index(this.shown[1]) + 1);
    context.save();
    context.beginPath(); context.rect(LEFT, top, width - LEFT - RIGHT, tall); context.clip();
    for (const { role, values, band } of lane.signals) {
      const tone = colour(role);
      for (const [bright, begin, end] of [[false, this.moment, Infinity], [true, -Infinity, this.moment]]) {
        context.globalAlpha = bright ? 1 : 0.28;
        context.save();
        context.beginPath();
        const left = Math.max(LEFT, begin === -Infinity ? 0 : X(begin)), right = Math.min(width, end === Infinity ? width : X(end));
        context.rect(left, top, Math.max(0, right - left), tall); context.clip();
        if (band) this.#band(context, band, X, Y, [first, last], tone);
        context.strokeStyle = tone;
        context.lineWidth = role === "command" ? 2.6 : 1.7;
        context.setLineDash(role === "truth" && lane.signals.length > 1 ? [6, 3] : []);
        this.#line(context, values, X, Y, [first, last]);
        context.restore();
      }
    }
    context.restore();
    context.globalAlpha = 1;
    context.setLineDash([]);
    context.textAlign = "left"; context.textBaseline = "bottom";
    context.font = "600 12px system-ui, sans-serif";
    context.fillStyle = colour("ink");
    context.fillText(`${lane.label} [${lane.unit}]`, LEFT, top - 4);
    context.font = "12px system-ui, sans-serif";
  }

  #line(context, values, X, Y, [first, last]) {
    const time = this.data.time_s;
    context.beginPath();
    let down = false;
    for (let n = first; n <= last; n += 1) {
      if (values[n] === null) { down = false; continue; }
      if (down) context.lineTo(X(time[n]), Y(values[n])); else context.moveTo(X(time[n]), Y(values[n]));
      down = true;
    }
    context.stroke();
  }

  #band(context, [lower, upper], X, Y, [first, last], tone) {
    const time = this.data.time_s;
    context.fillStyle = tone;
    const alpha = context.globalAlpha;
    context.globalAlpha = alpha * 0.22;
    context.beginPath();
    for (let n = first; n <= last; n += 1) context.lineTo(X(time[n]), Y(upper[n] ?? 0));
    for (let n = last; n >= first; n -= 1) context.lineTo(X(time[n]), Y(lower[n] ?? 0));
    context.fill();
    context.globalAlpha = alpha;
  }
}
