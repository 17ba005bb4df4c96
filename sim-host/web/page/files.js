// Files to open, files of a result, and texts to copy.
import { byId, download, make, table } from "./dom.js";

const FILES = [
  ["summary.json", "Metrics, JSON", "application/json"],
  ["trace.csv", "Signals over time, CSV", "text/csv"],
  ["scene.toml", "Scene with all keys, TOML", "text/plain"],
];

/** Shows buttons for the files of the last run, which are byte for byte those of the command line. */
export function showFiles(ask, result, core) {
  const traced = result.scope !== null;
  byId("files").replaceChildren(...FILES.filter(([file]) => traced || file !== "trace.csv").map(([file, words, type]) =>
    make("button", { type: "button", "data-file": file, onclick: async () => download(`${ask.name.replace(/\.toml$/, "")}-${file}`, await core.ask("file", file), type) }, words)));
}

/** Options of a friction fit that no file may contain. */
const OPTIONS = [
  ["normal_n", "Normal force, N (--normal-n)"],
  ["frequency_hz", "Frequency of the vibration, Hz (--frequency-hz)"],
  ["tip_m_per_s", "Peak velocity of the vibration, m/s (--tip-m-per-s)"],
];

/** Reads a file as a scene to open; a measurement becomes the scene of its fit, and a time series is compared with the last run. */
export async function sceneOf(file, core, given = {}) {
  const { name } = file, { text, fit, sets } = await core.ask("read", { name, ...given }, new Uint8Array(await file.arrayBuffer()));
  return fit ? { name: name.replace(/\.\w+$/, ".toml"), text, sets, fit: { ...fit, file, given } } : { name, text };
}

/** Shows the numbers and the notes of a fit, or nothing. `again` opens its file with other options. */
export function showFit(fit, again) {
  byId("fit").hidden = !fit;
  if (!fit) return;
  const field = ([key, words]) => make("div", { class: "row" }, make("label", { for: `fit-${key}` }, words),
    make("input", { type: "number", step: "any", id: `fit-${key}`, value: fit.given[key] }));
  const onclick = () => again(fit.file, Object.fromEntries(OPTIONS.map(([key]) => [key, byId(`fit-${key}`).valueAsNumber || null])));
  const form = fit.is_friction ? [...OPTIONS.map(field), make("button", { type: "button", id: "fit-again", onclick }, "Fit again")] : [];
  byId("fit").replaceChildren(make("h3", {}, fit.title), ...form, ...fit.tables.map(table), ...fit.notes.map((words) => make("p", { class: "caption" }, words)));
}

/** Makes a button copy the text of a field. */
export function copies(button, field) {
  byId(button).addEventListener("click", async () => {
    byId(field).select();
    try { await navigator.clipboard.writeText(byId(field).value); } catch { document.execCommand("copy"); }
    byId(button).textContent = "Copied";
    setTimeout(() => { byId(button).textContent = "Copy"; }, 1500);
  });
}
