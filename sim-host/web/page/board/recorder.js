// Reports of a board over time: the data of the scope, and a recording as CSV.

/** Signals of the scope: field of a report, label and unit. */
const LANES = [
  ["frequency_hz", "frequency", "Hz"], ["voltage_v", "voltage", "V"], ["current_a", "current", "A"],
  ["motional_current_a", "motional current", "A"], ["power_w", "power", "W"], ["friction_ratio", "friction, of that without drive", ""],
];
const COLUMNS = ["time_s", "block", "mode", "locked", ...LANES.map(([field]) => field), "resonance_hz", "drive_v", "envelope", "current_lead_degrees", "limit", "fault"];
/** Longest time in the scope, s, and number of points. */
const SPAN_S = 60, MAX_POINTS = 2400;
/** Shortest time between two points of the scope, s; a recording has all reports. */
const MIN_STEP_S = 0.01;
/** Time without a report that interrupts the curves, s. */
const GAP_S = 0.3;
/** Modes in which the board drives. */
const SILENT = new Set(["idle", "fault"]);

export class Recorder {
  constructor() {
    this.reports = [];
    this.recorded = null;
  }

  /** Adds a report. A board that has restarted begins again. */
  take(report) {
    const last = this.reports.at(-1);
    if (last && report.time_s < last.time_s) this.reports = [];
    this.recorded?.push(report);
    if (last && report.mode === last.mode && report.fault === last.fault && report.time_s - last.time_s < MIN_STEP_S) return;
    // Between two commands a board may report nothing: there the curves have a gap.
    if (last && report.time_s - last.time_s > GAP_S) this.reports.push({ time_s: last.time_s + 1e-6, mode: "idle" });
    this.reports.push(report);
    while (this.reports.length > MAX_POINTS || report.time_s - this.reports[0].time_s > SPAN_S) this.reports.shift();
  }

  /** Returns the data for a scope, with the reports of a twin, if there is one. */
  scope(twin) {
    const reports = this.reports, time_s = reports.map(({ time_s: s }) => s);
    const others = twin ? twin.at(time_s) : null;
    const lanes = LANES.filter(([field]) => reports.some((report) => report[field] !== undefined)).map(([field, label, unit]) => {
      const signals = [{ role: "estimate", values: reports.map((report) => report[field] ?? null) }];
      if (others) signals.push({ role: "truth", values: others.map((report) => report?.[field] ?? null) });
      return { id: field, label, unit, signals, range: field === "frequency_hz" ? Recorder.#around(signals) : null };
    });
    return { time_s, lanes, on_s: this.#drives(), events: [] };
  }

  static #around(signals) {
    const values = signals.flatMap(({ values: list }) => list.filter((value) => value > 0));
    if (!values.length) return [0, 1];
    const low = values.reduce((a, b) => Math.min(a, b)), high = values.reduce((a, b) => Math.max(a, b));
    const room = Math.max(1, 0.1 * (high - low));
    return [low - room, high + room];
  }

  #drives() {
    const spans = [];
    let on = null;
    for (const { mode, time_s: s } of this.reports) {
      if (on === null && !SILENT.has(mode)) on = s;
      if (on !== null && SILENT.has(mode)) { spans.push([on, s]); on = null; }
    }
    return on === null ? spans : [...spans, [on, this.reports.at(-1).time_s]];
  }

  /** Returns the latest report at each of these times since the newest one; null before the first. */
  at(times) {
    const shift = (this.reports.at(-1)?.time_s ?? 0) - (times.at(-1) ?? 0);
    let next = 0;
    return times.map((time) => {
      while (next < this.reports.length && this.reports[next].time_s <= time + shift + 1e-9) next += 1;
      return this.reports[next - 1] ?? null;
    });
  }

  /** Returns the recording as CSV. */
  csv() {
    const cell = (value) => (value === undefined || value === null ? "" : String(value));
    return [COLUMNS, ...this.recorded.map((report) => COLUMNS.map((column) => cell(report[column])))].map((row) => `${row.join(",")}\n`).join("");
  }
}
