// Files of a result, and texts to copy.
import { byId, download, make } from "./dom.js";

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

/** Makes a button copy the text of a field. */
export function copies(button, field) {
  byId(button).addEventListener("click", async () => {
    byId(field).select();
    try { await navigator.clipboard.writeText(byId(field).value); } catch { document.execCommand("copy"); }
    byId(button).textContent = "Copied";
    setTimeout(() => { byId(button).textContent = "Copy"; }, 1500);
  });
}
