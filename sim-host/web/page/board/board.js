// The screen of a connected board: read-only until it is armed. Its commands are lines of the script
// grammar, and its answers those of the command line.
import { unpacked } from "../core.js";
import { byId, download, make } from "../dom.js";
import { showFigures } from "../figures.js";
import { Bursts } from "./bursts.js";
import { Connection, openSerial, unsupported } from "./connection.js";
import { LiveView } from "./live-view.js";
import { Recorder } from "./recorder.js";
import { Settings } from "./settings.js";
import { Tabs } from "./tabs.js";

/** Commands that only read, sent after the connection. */
const FIRST_LOOK = ["status", "fault log", "update"];
/** Scene of the simulated board at the start. */
const FIRST_BOARD = "transducer-skymen-60w";
/** Length of the log, characters. */
const MAX_LOG = 400000;
/** Number of lanes of a motor. */
const MOTOR_LANES = 4;

/** Returns the value of a field as one word of a command, with a decimal point. */
const word = (input) => input.value.replace(/[\s#]+/g, "").replace(",", ".");

export class Board {
  constructor(core) {
    this.core = core;
    this.connection = null;
    this.twin = null;
    this.live = new LiveView();
    this.settings = new Settings((name, input) => this.#runField(`settings set ${name} ${word(input)}`).then(() => this.#listSettings()));
    this.tabs = new Tabs({ onreport: (report, name) => this.#foreign(report, name), onstop: () => this.#stop() });
    this.#clear();
    this.#listen();
    this.#shape();
    const why = unsupported({ serial: true });
    byId("b-unsupported").textContent = why ?? "";
    byId("b-unsupported").hidden = why === null;
    byId("b-connect").disabled = why !== null;
    byId("b-simulate").disabled = unsupported({ serial: false }) !== null;
  }

  /** Offers the scenes that have a controller as simulated boards. */
  offer(scenes) {
    byId("b-scene").replaceChildren(...scenes.filter(({ driven }) => driven).map(({ name, title }) => make("option", { value: name, title, selected: name === FIRST_BOARD }, name)));
  }

  #clear() {
    this.live.clear();
    this.armed = false;
    this.commands = [];
    this.files = new Map();
    this.fault = null;
    this.looks = 0;
    if (this.bursts) this.bursts.edited = false;
  }

  #listen() {
    byId("b-connect").addEventListener("click", async () => {
      this.#complain(null);
      byId("b-state").textContent = "Not connected.";
      try {
        this.#open({ port: await openSerial() }, "the serial port");
      } catch (error) {
        this.#complain(error.name === "NotFoundError" ? "No port was chosen." : error.message);
      }
    });
    byId("b-simulate").addEventListener("click", () => this.#open({ scene: { name: byId("b-scene").value, jumper: byId("b-jumper").checked } }, `a simulated board, \`${byId("b-scene").value}\``));
    byId("b-leave").addEventListener("click", () => { this.twin?.connection.leave(); this.connection?.leave(); });
    byId("b-stop").addEventListener("click", () => this.stop());
    // In the capture phase, before any other use of the key.
    document.addEventListener("keydown", (event) => { if (event.key === "Escape") this.stop(); }, true);
    byId("b-arm").addEventListener("click", () => {
      if (this.armed) this.stop();
      this.connection?.ask({ ask: "arm", armed: !this.armed });
    });
    byId("b-commission").addEventListener("submit", (event) => { event.preventDefault(); this.#commission(); });
    byId("b-accept").addEventListener("click", () => this.#accept());
    byId("b-twin").addEventListener("click", () => this.#startTwin());
    for (const button of document.querySelectorAll("[data-run]")) button.addEventListener("click", () => this.run(button.dataset.run));
    for (const form of document.querySelectorAll("[data-form]")) form.addEventListener("submit", (event) => { event.preventDefault(); this.#runField(`${form.dataset.form}${word(form.querySelector("input"))}`); });
    byId("b-command-form").addEventListener("submit", (event) => {
      event.preventDefault();
      const line = byId("b-command").value.trim();
      if (line) this.run(line);
      byId("b-command").value = "";
    });
    byId("b-update").addEventListener("change", () => this.#update());
    byId("b-store").addEventListener("click", () => this.run("settings store\nreset").then(() => this.#listSettings()));
    byId("b-settings-panel").addEventListener("toggle", () => { if (byId("b-settings-panel").open) this.#listSettings(); });
    byId("b-firmware").addEventListener("click", () => download("nucleo.bin", unpacked(byId("firmware").textContent), "application/octet-stream"));
    byId("b-save-log").addEventListener("click", () => download("board-log.txt", byId("b-log").textContent));
    byId("b-save-script").addEventListener("click", () => download("commands.txt", `${this.commands.join("\n")}\n`));
    this.bursts = new Bursts(async (script) => {
      this.bursts.edited = Boolean(await this.run(script));
      this.#listSettings();
    });
  }

  async #open(port, name) {
    if (this.connection || this.opening) return;
    this.opening = true;
    this.#clear();
    this.#complain(null);
    this.name = name;
    byId("b-log").textContent = "";
    byId("b-state").textContent = `Connecting to ${name} …`;
    try {
      this.connection = new Connection(await this.core.spawn(), port, (event) => this.#take(event));
    } catch (error) {
      this.#complain(error.message);
    }
    this.opening = false;
    this.#shape();
  }

  /** Shows what is possible in the present state. */
  #shape() {
    const on = this.connection !== null;
    for (const id of ["b-live", "b-bar", "b-arm-panel", "b-acts"]) byId(id).hidden = !on;
    byId("b-connects").hidden = on;
    byId("b-blank").hidden = on || !byId("firmware").textContent;
    // Next to STOP an error is visible wherever the reader is on the page.
    const place = byId(on ? "b-bar" : "b-errors");
    if (byId("b-error").parentNode !== place) place.prepend(byId("b-error"));
    byId("b-leave").disabled = !on;
    document.body.classList.toggle("connected", on);
    for (const id of ["b-acts", "b-store", "b-accept"]) byId(id).disabled = !this.armed;
    byId("b-arm").textContent = this.armed ? "Stop and disarm" : "Arm";
    byId("b-arm").setAttribute("aria-pressed", this.armed);
    byId("b-armed").textContent = this.armed ? "armed" : "read-only";
    document.body.dataset.board = on ? (this.armed ? "armed" : "connected") : "";
  }

  #complain(text) {
    byId("b-error").hidden = !text;
    byId("b-error").textContent = text ?? "";
  }

  #log(text) {
    const log = byId("b-log"), follows = log.scrollTop + log.clientHeight >= log.scrollHeight - 8;
    log.textContent = (log.textContent + text.replace(/\n?$/, "\n")).slice(-MAX_LOG);
    if (follows) log.scrollTop = log.scrollHeight;
  }

  #take(told) {
    switch (told.event) {
      case "connected":
        byId("b-state").textContent = `Connected to ${this.name}.`;
        byId("b-identity").textContent = told.text;
        byId("b-warnings").replaceChildren();
        byId("b-motor").hidden = told.fields.lanes < MOTOR_LANES;
        for (const line of FIRST_LOOK) this.run(line, false);
        this.#listSettings();
        break;
      case "armed": this.armed = told.armed; this.#shape(); break;
      case "report": this.#report(told.report); break;
      case "answer": this.#answer(told); break;
      case "file": this.#keep(told.name, told.text); break;
      case "figures": this.#showResult(told.figures); break;
      case "parameters":
        this.settings.show(told.parameters);
        this.bursts.show(told.parameters);
        break;
      case "note":
        this.#log(`  ${told.text}`);
        if (told.text.startsWith("warning")) this.#complain(told.text);
        else byId("b-state").textContent = told.text;
        break;
      case "stage": byId("b-state").textContent = `${told.text} …`; break;
      case "stopped": this.#log("stopped: the drive is silent"); byId("b-state").textContent = "Stopped: the drive is silent."; break;
      case "hidden": this.#log("the page was hidden: the drive was stopped, and the connection is disarmed"); this.armed = false; this.#shape(); break;
      case "ended": this.#ended(told.error); break;
      default: break;
    }
  }

  #ended(error) {
    this.twin?.connection.leave();
    this.twin = this.live.twin = null;
    this.connection = null;
    this.armed = false;
    this.tabs.release();
    this.#shape();
    byId("b-live").hidden = this.live.isEmpty;
    this.live.end();
    for (const id of ["b-proposal", "b-result"]) byId(id).hidden = true;
    byId("b-figures").replaceChildren();
    byId("b-state").textContent = error ? "The connection has ended. You can connect again." : "Disconnected.";
    this.#complain(error);
    if (error) this.#log(`error: ${error}`);
  }

  #answer({ line, text, error, fields }) {
    this.#log(`> ${line}\n${error ? `error: ${error}` : text}`);
    if (error) return;
    if (this.looks < FIRST_LOOK.length) {
      this.looks += 1;
      byId("b-identity").textContent += text;
    }
    const warnings = [...(fields.option_bytes_wrong ?? []).map((what) => `option bytes: ${what}`), ...(fields.accepts_development_key ? ["This board accepts updates by the development key, which is public."] : [])];
    for (const words of warnings) if (![...byId("b-warnings").children].some((item) => item.textContent === words)) byId("b-warnings").append(make("li", { class: "warning" }, words));
    if (line.startsWith("commission")) this.#propose(text);
    this.answer = { line, text };
    if (fields.passed === false) this.#complain(`The self-test has failed: ${fields.failures.join("; ")}`);
  }

  /** Shows the last answer with its files and figures; that of a commissioning has its own panel. */
  #showResult(figures) {
    const { line, text } = this.answer, command = line.split(" ")[0], ofIt = [...this.files].filter(([name]) => name.startsWith(`${command}/`));
    byId("b-result").hidden = command === "commission";
    if (command !== "commission") {
      byId("b-result-title").textContent = `Result of \`${command}\``;
      byId("b-answer").textContent = text.split("\n").filter((words) => !words.startsWith("written:")).join("\n");
      this.#showFiles("b-result-files", ofIt);
      byId("b-result").focus();
    }
    showFigures(byId("b-figures"), figures, (file) => this.files.get(`${command}/${file}`));
  }

  /** Runs lines; the first error is shown. */
  async run(text, kept = true) {
    if (!this.connection) return "not connected";
    this.#complain(null);
    if (/^(scan|commission)/.test(text)) this.live.beginScan();
    if (kept) this.commands.push(text);
    byId("b-state").textContent = `\`${text.split("\n")[0]}\` …`;
    const mirrored = this.twin?.mirrors(text);
    const error = await this.connection.run(text);
    await mirrored;
    if (error && error !== "stopped") this.#complain(error);
    if (byId("b-state").textContent.endsWith("…")) byId("b-state").textContent = `Connected to ${this.name}.`;
    return error;
  }

  /** Stops the drive of the board, here or in another tab. */
  stop() {
    this.#stop();
    this.tabs.stop();
  }

  #stop() {
    this.connection?.stop();
    this.twin?.connection.stop();
  }

  /** Runs a command with a typed value; an error is that of the value, without its place in a line. */
  async #runField(line) {
    const error = await this.run(line);
    if (error?.startsWith("error: ")) this.#complain(error.split("\n")[0].replace(/^error: (invalid value '(.*?)' for '.*?':)?/, (_, invalid, value) => (invalid ? `\`${value}\`:` : "")).trim());
    return error;
  }

  async #commission() {
    const [low, high] = ["b-low", "b-high"].map((id) => word(byId(id)));
    const wrong = [low, high].find((kilohertz) => !(Number(kilohertz) > 0));
    if (wrong !== undefined) return this.#complain(`\`${wrong}\` is not a frequency in kHz, such as 40 or 40.5`);
    if (Number(low) >= Number(high)) return this.#complain(`The band begins with the lower frequency: ${low} kHz is not below ${high} kHz`);
    const hertz = (kilohertz) => Math.round(1e6 * kilohertz) / 1e3;
    byId("b-proposal").hidden = true;
    this.files.clear();
    const error = await this.#runField(`commission --band ${hertz(low)}:${hertz(high)} --max-volts=${word(byId("b-volts"))} -o commission`);
    if (!error) byId("b-state").textContent = "Settings are proposed; the board has its former ones.";
  }

  #propose(text) {
    // The settings come first; the page stores them by its own button.
    const lines = text.split("\n").filter((line) => !/^(written|not stored):/.test(line));
    const at = lines.findIndex((line) => line.startsWith("proposed settings"));
    byId("b-proposed").textContent = [...lines.slice(at), ...lines.slice(0, at)].join("\n");
    byId("b-proposal").hidden = false;
    byId("b-proposal").focus();
  }

  /** Keeps a file of a command: the loop of a scan is drawn, and all are offered. */
  #keep(name, text) {
    if (name === "scan/admittance.csv") this.live.showLoop(text);
    this.files.set(name, text);
    if (name.startsWith("commission/")) this.#showFiles("b-files", [...this.files].filter(([one]) => one.startsWith("commission/")));
  }

  async #accept() {
    const script = this.files.get("commission/settings.txt");
    const error = await this.run(script.split("\n").filter((line) => !line.startsWith("#")).join("\n").trim());
    if (error) return;
    byId("b-proposal").hidden = true;
    byId("b-state").textContent = "Stored and active: the board is tuned to this transducer.";
    document.body.dataset.tuned = "yes";
    this.#listSettings();
  }

  #showFiles(place, files) {
    byId(place).replaceChildren(...files.map(([name, text]) => make("button", { type: "button", onclick: () => download(name.replace("/", "-"), text) }, name.split("/").at(-1))));
  }

  async #startTwin() {
    if (this.twin) return;
    const text = this.files.get("commission/twin.toml"), recorder = new Recorder();
    const take = ({ event, report, error }) => {
      if (event === "connected") { connection.ask({ ask: "arm", armed: true }); this.#log("the twin runs next to the board"); }
      if (event === "report") recorder.take(report);
      if (event === "ended") { this.twin = this.live.twin = null; if (error) this.#complain(`The twin: ${error}`); }
    };
    const connection = new Connection(await this.core.spawn(), { scene: { name: "twin.toml", text } }, take);
    this.live.twin = recorder;
    this.twin = { connection, mirrors: (line) => (/^(lock|drive|burst|friction|scan|fault clear|stop)\b/.test(line) ? connection.run(line) : null) };
  }

  async #update() {
    const file = byId("b-update").files[0];
    if (!file) return;
    this.connection.ask({ ask: "file", name: "update.bin", bytes: [...new Uint8Array(await file.arrayBuffer())] });
    await this.run("update update.bin");
    byId("b-update").value = "";
  }

  #listSettings() {
    this.connection?.request({ ask: "parameters" });
  }

  #report(report) {
    this.live.take(report);
    this.tabs.hold(report, this.name);
    if ((report.fault ?? null) !== this.fault) {
      this.fault = report.fault ?? null;
      byId("b-fault").hidden = this.fault === null;
      byId("b-fault").textContent = report.fault_text ?? "";
      if (this.fault !== null) {
        this.#log(report.fault_text);
        if (byId("b-on-fault").checked) this.live.pause(true);
      }
    }
  }

  /** Shows the board that another tab holds. */
  #foreign(report, name) {
    if (this.connection) return;
    byId("b-connects").hidden = name !== null;
    byId("b-live").hidden = byId("b-bar").hidden = name === null;
    document.body.classList.toggle("connected", name !== null);
    byId("b-state").textContent = name === null ? "Not connected." : `Another tab of this page holds ${name}; here it can only be watched, and stopped.`;
    byId("b-armed").textContent = "watched";
    if (report) this.live.take(report);
  }
}
