// The live signals of a board: tiles, scope with cursor and mark, admittance of a scan, recording.
import { byId, download, make } from "../dom.js";
import { digits, quantity } from "../format.js";
import { drawPath } from "../path.js";
import { Scope } from "../scope.js";
import { Recorder } from "./recorder.js";

/** Interval of the drawings, ms, and number of dots in the admittance plane. */
const DRAW_MS = 100, MAX_DOTS = 3000;
/** Part of the ordered voltage from which a measured admittance is drawn; below it, noise dominates. */
const MIN_VOLTAGE_PART = 0.5;

export class LiveView {
  constructor() {
    this.scope = new Scope(byId("b-scope"));
    this.twin = null;
    this.clear();
    byId("b-pause").addEventListener("click", () => this.pause(!this.paused));
    byId("b-time").addEventListener("input", () => { this.pause(true); this.#cursor(); });
    byId("b-mark").addEventListener("click", () => { this.mark = this.recorder.at([this.scope.moment])[0]; this.#cursor(); });
    byId("b-record").addEventListener("click", () => this.#record());
    setInterval(() => this.#draw(), DRAW_MS);
  }

  clear() {
    this.recorder = new Recorder();
    this.mark = null;
    this.fresh = this.ended = false;
    this.beginScan();
    this.pause(false);
  }

  /** Marks the last report as that of a connection that has ended. */
  end() { this.fresh = this.ended = true; }

  get isEmpty() { return this.recorder.reports.length === 0; }

  /** Forgets the dots of the last scan. */
  beginScan() {
    this.dots = [];
    this.circle = null;
  }

  /** Draws the loop of a scan's result, a CSV file of the command line. */
  showLoop(csv) {
    const rows = csv.trim().split("\n").map((row) => row.split(","));
    this.circle = rows.filter(([series]) => series === "admittance_identified").map((row) => row.slice(2).map(Number));
  }

  take(report) {
    this.recorder.take(report);
    const strong = report.drive_v > 0 && report.voltage_v > MIN_VOLTAGE_PART * report.drive_v;
    if (strong && report.admittance_s && report.mode !== "run" && report.mode !== "idle") this.dots.push(report.admittance_s.map((siemens) => 1e3 * siemens));
    if (this.dots.length > MAX_DOTS) this.dots.splice(0, this.dots.length - MAX_DOTS);
    this.fresh = true;
  }

  pause(paused) {
    this.paused = paused;
    byId("b-pause").textContent = paused ? "Continue" : "Pause";
    byId("b-pause").setAttribute("aria-pressed", paused);
    if (!paused) byId("b-time").value = 1000;
  }

  #record() {
    const begins = this.recorder.recorded === null;
    if (!begins) download("board.csv", this.recorder.csv(), "text/csv");
    this.recorder.recorded = begins ? [] : null;
    byId("b-record").textContent = begins ? "Stop and save CSV" : "Record";
    byId("b-record").setAttribute("aria-pressed", begins);
  }

  #draw() {
    const report = this.recorder.reports.at(-1);
    if (!report || !this.fresh || byId("board").hidden) return;
    this.fresh = false;
    byId("b-mode").textContent = `${report.mode}${report.locked ? ", locked" : ""}`;
    const tiles = [[this.ended ? "mode in the last report" : "mode", byId("b-mode").textContent], ["frequency", `${digits(report.frequency_hz, 7)} Hz`], ["voltage, peak", quantity(report.voltage_v, "V")], ["current, peak", quantity(report.current_a, "A")], ["power", quantity(report.power_w, "W")], ["limit", report.limit_text ?? "none"]];
    byId("b-tiles").replaceChildren(...tiles.map(([label, value]) => make("div", {}, make("dt", {}, label), make("dd", {}, value))));
    this.#drawLoop();
    if (this.paused) return;
    this.scope.show(this.recorder.scope(this.twin));
    byId("b-legend").replaceChildren(...[["estimate", "board"], ...(this.twin ? [["truth", "twin"]] : [])].map(([role, words]) => make("span", {}, make("i", { class: role }), words)));
    this.#cursor();
  }

  #drawLoop() {
    byId("b-loop-panel").hidden = this.dots.length < 3;
    if (this.dots.length < 3) return;
    const curve = (name, style, points) => ({ name, style, x: points.map(([g]) => g), columns: [points.map(([, b]) => b)] });
    const series = [...(this.circle ? [curve("identified", "line", this.circle)] : []), curve("measured", "points", this.dots)];
    drawPath(byId("b-loop"), { equal: true, x: { label: "conductance [mS]" }, y: { label: "susceptance [mS]" }, plots: [{ series, markers: [] }] });
  }

  #cursor() {
    const { data, ends } = this.scope;
    if (!data || !data.time_s.length) return;
    const at = ends[0] + (Number(byId("b-time").value) / 1000) * (ends[1] - ends[0]);
    this.scope.goto(at);
    byId("b-clock").textContent = `${digits(at, 5)} s`;
    const place = this.scope.index(at);
    byId("b-values").replaceChildren(...data.lanes.map(({ id, label, unit, signals }) => {
      const [board, twin] = signals.map(({ values }) => values[place]);
      const apart = twin === undefined || twin === null ? null : board - twin, since = this.mark ? board - (this.mark[id] ?? NaN) : null;
      return make("tr", {}, make("th", { scope: "row" }, label), ...[board, twin, apart, since].map((value) => make("td", { class: "number" }, quantity(value, unit))));
    }));
  }
}
