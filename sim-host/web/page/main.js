// The page: choice of the scene, its runs, and the display of the result.
import { Core, SimulatorError } from "./core.js";
import { setKey, showControls } from "./controls.js";
import { showCrash } from "./crash.js";
import { Curves } from "./curve.js";
import { Board } from "./board/board.js";
import { byId, make } from "./dom.js";
import { showLoop, showReport } from "./figures.js";
import { copies, sceneOf, showFiles, showFit } from "./files.js";
import { digits, plain, quantity } from "./format.js";
import { Live, switched } from "./live.js";
import { MotorView } from "./motor.js";
import { Ask, fromFragment, toFragment } from "./request.js";
import { Scope } from "./scope.js";

/** Waiting time after a change of a slider before a run, ms. */
const SLIDER_DELAY_MS = 180;
/** Longest run that is repeated automatically after a change, s. */
const AUTO_RUN_LIMIT_S = 4;

const core = new Core(byId("wasm").textContent, byId("worker-text").textContent);
const hosts = JSON.parse(byId("hosts").textContent);
const scope = new Scope(byId("scope"));
const live = new Live(scope);
const motor = new MotorView(byId("ring"));
const board = new Board(core);
live.listen((moment) => motor.goto(moment));
live.listen(() => showSwitch());

const curves = new Curves(new Core(null, null, core), {
  ask: () => ask, latest: () => latest, isIdle: () => !running,
  move: (given, value) => { setKey(ask, given, value); controls(); run({ keep: true }); },
});

let scenes = [];
let ask = null;
let opened = null;
let running = false;
let again = null;
let lastWall = 0;
let calm = 0;
let first = true;
let latest = null;

const say = (words) => { byId("status").textContent = words; };
const entryOf = (name) => scenes.find((entry) => entry.name === name);

/** Shows an error: that of a text in the editor below its line, any other above the result. */
function showError(error, text = null) {
  if (error instanceof DOMException && error.name === "AbortError") return say("Stopped.");
  if (!(error instanceof SimulatorError)) console.error(error);
  const place = text === null ? null : /--> .*?:(\d+):\d+/.exec(error.message);
  const box = byId(place ? "toml-error" : "error");
  box.textContent = error.message;
  box.hidden = false;
  byId("shown").classList.add("stale");
  if (place) {
    const editor = byId("toml"), lines = text.split("\n"), at = Number(place[1]) - 1;
    const start = lines.slice(0, at).reduce((sum, line) => sum + line.length + 1, 0);
    byId("editor").open = true;
    if (editor.value !== text) editor.value = text;
    editor.focus();
    editor.setSelectionRange(start, start + (lines[at]?.length ?? 0));
    editor.scrollTop = (editor.scrollHeight * (at - 3)) / Math.max(1, lines.length);
  }
  say("There is an error; see below.");
  document.body.dataset.state = "error";
}

function hideError() {
  byId("shown").classList.remove("stale");
  for (const box of [byId("error"), byId("toml-error")]) {
    box.hidden = true;
    box.textContent = "";
  }
}

/** Opens a scene, and runs it. */
async function openScene(given) {
  live.pause();
  core.stop();
  document.body.dataset.state = "busy";
  const next = new Ask(given);
  next.whole = Boolean(given.whole);
  hideError();
  try {
    opened = await core.ask("open", next.request);
  } catch (error) {
    return showError(error, given.text ?? null);
  }
  ask = next;
  ask.faultCount = opened.fault_count;
  byId("scene").value = ask.text === null ? ask.name : "";
  byId("scene-title").textContent = opened.title;
  byId("toml").value = opened.toml;
  byId("resolved").textContent = opened.resolved;
  byId("whole").checked = ask.whole;
  byId("whole").closest("label").hidden = !opened.has_cells;
  byId("fault").replaceChildren(...opened.faults.map((fault) => make("option", { value: fault.fault, title: fault.meaning }, fault.label)));
  byId("fault").closest(".faults").hidden = opened.faults.length === 0;
  byId("switch").hidden = !opened.burst;
  byId("acts").hidden = opened.faults.length === 0 && !opened.burst;
  latest = null;
  showFit(given.fit, openFile);
  curves.clear();
  controls();
  lastWall = 0;
  return run();
}

function controls() {
  showControls(byId("sliders"), opened, ask, () => {
    chips();
    clearTimeout(calm);
    if (lastWall > AUTO_RUN_LIMIT_S) {
      curves.work();
      return say(`Changed. The last run took ${digits(lastWall, 2)} s: press Run to run it again.`);
    }
    calm = setTimeout(() => run({ keep: true }), SLIDER_DELAY_MS);
    return undefined;
  }, curves);
  chips();
}

/** Shows the changes, each with a button that undoes it. */
function chips() {
  const chip = (words, back, reopen) => make("li", {}, make("code", {}, words),
    make("button", { type: "button", "aria-label": `undo: ${words}`, onclick: () => { back(); if (reopen) openScene({ name: ask.name, text: ask.text, sets: ask.base, whole: ask.whole }); else { controls(); run({ keep: true }); } } }, "×"));
  byId("changes").replaceChildren(
    ...ask.base.map((set) => chip(set, () => { ask.base = ask.base.filter((other) => other !== set); }, true)),
    ...[...ask.moved].map(([key, { value }]) => chip(`${key}=${value}`, () => ask.moved.delete(key))),
    ...(ask.bursts ? [chip(`ON at ${ask.bursts.on_s.map(plain).join(", ")} s, OFF at ${ask.bursts.off_s.map(plain).join(", ")} s`, () => { ask.bursts = null; })] : []),
    ...ask.faults.map((fault) => chip(`${fault.label} at ${quantity(fault.at_s, "s", 5)}`, () => { ask.faults = ask.faults.filter((other) => other !== fault); })),
  );
  byId("reset").disabled = !ask.changed;
  curves.check();
}

/** Runs the scene with its present changes, after any run in progress. */
async function run({ from = null, keep = false } = {}) {
  clearTimeout(calm);
  if (running) { again = { from, keep }; return; }
  running = true;
  byId("stop").disabled = false;
  document.body.dataset.state = "busy";
  hideError();
  say(`Running ${ask.name} …`);
  const end = opened.kind === "runs" ? Number(ask.moved.get("runs")?.value ?? opened.sliders.find(({ key }) => key === "runs")?.value ?? 1) : opened.duration_s;
  core.onprogress = (reached) => { byId("bar").style.width = `${Math.min(100, (100 * reached) / end)}%`; };
  const asked = ask, sent = JSON.stringify(ask.request), began = performance.now();
  try {
    const result = await core.ask("run", sent);
    lastWall = (performance.now() - began) / 1e3;
    if (asked === ask && again === null) {
      latest = { ...result, sent };
      curves.take();
      await show(result, from, keep);
    }
  } catch (error) {
    if (asked === ask) showError(error);
  } finally {
    running = false;
    byId("stop").disabled = true;
    byId("bar").style.width = "0";
  }
  if (again) {
    const next = again;
    again = null;
    run(next);
  } else {
    curves.work();
  }
}

async function show(result, from, keep) {
  byId("shown").hidden = false;
  const before = scope.data && keep && scope.moment < scope.ends[1] ? scope.moment : null;
  const playing = live.isPlaying;
  byId("live").hidden = !result.scope;
  if (result.scope) {
    legend(result.scope);
    live.show(result.scope, from ?? before);
  } else {
    live.pause();
  }
  motor.show(result.motor);
  showCrash(result.crash);
  showLoop(result);
  showReport(result, core);
  showFiles(ask, result, core);
  hashes(result);
  byId("command").value = ask.command;
  const fragment = await toFragment(ask);
  if (!byId("simulator").hidden) history.replaceState(null, "", fragment);
  byId("link").value = location.href;
  const headline = result.headline.slice(0, 3).map(([label, value]) => `${label} ${value}`).join(", ");
  const missed = result.passes ? "" : " An expectation is not met.";
  say(`Done in ${digits(lastWall, 2)} s${headline ? `: ${headline}` : ""}.${missed} ${byId("hash-verdict").textContent}`);
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  if (result.scope) {
    motor.goto(scope.moment);
    if (from !== null || playing) live.play();
    else if (first && !still) { live.goto(scope.ends[0]); live.play(); }
  }
  first = false;
  document.body.dataset.state = "done";
  document.body.dataset.hash = result.drive_hash ?? "";
  document.body.dataset.wall = String(lastWall);
}

function legend({ lanes, on_s }) {
  const roles = [["command", "command"], ["estimate", "controller's estimate"], ["sensor", "load cell"], ["truth", "truth: the simulated plant"]];
  const present = roles.filter(([role]) => lanes.some(({ signals }) => signals.some((signal) => signal.role === role)));
  byId("legend").replaceChildren(...present.map(([role, words]) => make("span", {}, make("i", { class: role }), words)),
    on_s.length ? make("span", {}, make("i", { class: "shade" }), "drive ON") : "");
}

function hashes(result) {
  const { drive_hash } = result;
  byId("same").hidden = !drive_hash;
  const entry = ask.text === null ? entryOf(ask.name) : null;
  const sets = JSON.stringify(ask.sets);
  const host = entry && hosts[ask.name] && (sets === "[]" ? hosts[ask.name].whole : sets === JSON.stringify(entry.sets) ? hosts[ask.name].opened : null);
  byId("hash-here").textContent = drive_hash ?? "";
  byId("hash-host").textContent = host ?? "unknown for a changed scene: the command below prints it";
  const verdict = host && drive_hash ? (host === drive_hash ? "Equal to the host's, bit for bit." : "NOT equal to the host's.") : "";
  byId("hash-verdict").textContent = verdict;
  byId("hash-verdict").className = host === drive_hash ? "pass" : "miss";
}

/** Labels the button with its action at this time. */
function showSwitch() {
  if (!opened?.burst) return;
  const { isOn } = switched(ask.burst(opened.burst), scope.moment, opened.duration_s);
  byId("switch").textContent = isOn ? "Switch OFF here" : "Switch ON here";
  byId("switch").dataset.on = isOn;
}

function fill({ scenes: list, version }) {
  scenes = list;
  board.offer(list);
  byId("version").textContent = `Version ${version}`;
  const groups = new Map();
  for (const entry of scenes) groups.set(entry.group, [...(groups.get(entry.group) ?? []), entry]);
  byId("scene").replaceChildren(
    ...[...groups].map(([group, entries]) => make("optgroup", { label: group }, ...entries.map((entry) => make("option", { value: entry.name, title: entry.title }, entry.name)))),
    make("option", { value: "" }, "my own text"),
  );
}

function ownText() {
  byId("editor").open = true;
  byId("toml").focus();
}

byId("scene").addEventListener("change", () => {
  const entry = entryOf(byId("scene").value);
  return entry ? openScene({ name: entry.name, sets: entry.sets }) : ownText();
});
byId("run").addEventListener("click", () => run({ keep: true }));
byId("stop").addEventListener("click", () => { again = null; core.stop(); });
byId("reset").addEventListener("click", () => openScene({ name: ask.name, text: ask.text, sets: ask.text === null ? (entryOf(ask.name)?.sets ?? []) : [] }));
byId("whole").addEventListener("change", () => { ask.whole = byId("whole").checked; run({ keep: true }); });
byId("apply").addEventListener("click", () => {
  const text = byId("toml").value;
  const same = scenes.find((entry) => entry.text === text);
  return same ? openScene({ name: same.name, sets: same.sets }) : openScene({ name: "my-scene.toml", text });
});
/** Opens a file. A fit without a scene is shown above the last result. */
async function openFile(file, options) {
  if (!file) return;
  try {
    const scene = await sceneOf(file, core, options);
    if (scene.text !== null) return void openScene(scene);
    hideError();
    showFit(scene.fit, openFile);
    throw new SimulatorError(scene.fit.why);
  } catch (error) {
    showError(error);
  }
}
byId("open").addEventListener("change", () => openFile(byId("open").files[0]));
for (const kind of ["dragover", "drop"]) {
  document.addEventListener(kind, (event) => {
    if (byId("simulator").hidden || !event.dataTransfer?.types.includes("Files")) return;
    event.preventDefault();
    if (kind === "drop") openFile(event.dataTransfer.files[0]);
  });
}
byId("switch").addEventListener("click", () => {
  const { on_s, off_s } = switched(ask.burst(opened.burst), scope.moment, opened.duration_s);
  ask.bursts = { on_s, off_s };
  act();
});
byId("break").addEventListener("click", () => {
  const { fault, label } = opened.faults.find((one) => one.fault === byId("fault").value);
  ask.faults.push({ fault, label, at_s: scope.moment });
  act();
});
/** Runs the scene from this time on. The part before it is unchanged, bit for bit. */
function act() {
  chips();
  run({ from: scope.moment });
}
document.addEventListener("keydown", (event) => {
  if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) byId(event.target === byId("toml") ? "apply" : "run").click();
});
window.addEventListener("hashchange", async () => {
  const given = await fromFragment(location.hash);
  if (given) openScene(given);
});
/** Shows the simulator or the board. */
function view(name) {
  for (const one of ["simulator", "board"]) {
    byId(one).hidden = one !== name;
    byId(`view-${one}`).setAttribute("aria-pressed", one === name);
  }
}
for (const one of ["simulator", "board"]) byId(`view-${one}`).addEventListener("click", () => view(one));
if (location.hash === "#board") view("board");
copies("copy", "command");
copies("copy-link", "link");

async function begin() {
  // On a narrow screen the result comes before the sliders.
  byId("numbers").open = !matchMedia("(max-width: 60rem)").matches;
  try {
    const catalogue = await core.ask("catalogue");
    fill(catalogue);
    const given = await fromFragment(location.hash);
    const entry = entryOf(catalogue.first);
    await openScene(given ?? { name: entry.name, sets: entry.sets });
  } catch (error) {
    showError(error);
  }
}
begin();
