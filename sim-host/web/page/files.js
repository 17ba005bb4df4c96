// Files to open, files of a result, and texts to copy.
import { SimulatorError } from "./core.js";
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

/** Reads a file as a scene to open; a measured admittance becomes the scene of its fitted circuit. */
export async function sceneOf(file, core) {
  const { name } = file, text = await file.text(), has = (heading) => heading.test(text.slice(0, 2000));
  if (!/\.(csv|tsv|txt|dat|s[12]p)$/i.test(name) || has(/^\s*(\[|base\s*=)/m)) return { name, text };
  const fit = await core.ask("fit", { name, text }).catch((error) => {
    // The heading decides only about a file that is not an admittance.
    const other = has(/force|friction|slip|\bmu\b/i) ? "import friction" : has(/\btime|^"?t\b/im) ? "spectrum" : null;
    throw other ? new SimulatorError(`Use the command \`sim-host ${other} ${name}\` for this file.`) : error;
  });
  if (fit.scene === null) throw new SimulatorError(`No scene can be made of ${name}${fit.warnings.map((why) => `: ${why}`)[0] ?? ""}.`);
  return { name: name.replace(/\.\w+$/, ".toml"), text: fit.scene, fit: { ...fit, name } };
}

/** Shows the numbers and the warnings of a fit, or nothing. */
export function showFit(fit) {
  const notes = (fit?.warnings ?? []).map((words) => make("p", { class: "caption" }, `Note: ${words}.`));
  byId("fit").hidden = !fit;
  if (fit) byId("fit").replaceChildren(make("h3", {}, `Circuit fitted to ${fit.name}`), ...fit.tables.map(table), ...notes);
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
