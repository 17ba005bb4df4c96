// The settings of a board as a table: search, changes against the defaults or a file, and export as a
// script of the command line.
import { byId, download, make } from "../dom.js";

/** Reads the `settings set` lines of a script. */
export const settingsOf = (script) => new Map([...script.matchAll(/^\s*settings\s+set\s+(\S+)\s+(\S+)/gm)].map(([, name, value]) => [name, value]));

/** Returns a script that stores these settings. */
export function settingsScript(parameters) {
  const lines = parameters.map(({ name, set }) => `settings set ${name} ${set}`);
  return `# Settings of a board: \`sim-host link PORT script\` with this file stores them.\n${[...lines, "settings store", "reset"].join("\n")}\n`;
}

export class Settings {
  constructor(change) {
    this.change = change;
    this.parameters = [];
    this.file = null;
    byId("b-search").addEventListener("input", () => this.#draw());
    byId("b-differ").addEventListener("change", () => this.#draw());
    byId("b-export").addEventListener("click", () => download("settings.txt", settingsScript(this.parameters.filter(({ set, default: usual, range }) => set !== usual && range !== "fixed by the image"))));
    byId("b-compare").addEventListener("change", async () => {
      const file = byId("b-compare").files[0];
      if (!file) return;
      this.file = settingsOf(await file.text());
      byId("b-differ").value = "file";
      this.#draw();
    });
  }

  show(parameters) {
    this.parameters = parameters;
    this.#draw();
  }

  #draw() {
    const wanted = byId("b-search").value.trim().toLowerCase(), differ = byId("b-differ").value;
    const other = ({ name, default: usual }) => (differ === "file" ? this.file?.get(name) : usual);
    const differs = (one) => differ === "all" || (other(one) !== undefined && other(one) !== one.set && Number(other(one)) !== Number(one.set));
    const found = this.parameters.filter((one) => `${one.name} ${one.meaning ?? ""}`.toLowerCase().includes(wanted) && differs(one));
    byId("b-count").textContent = differ === "file" && !this.file ? "Open a file of settings to compare with." : `${found.length} of ${this.parameters.length} settings`;
    byId("b-settings").replaceChildren(...found.map((one) => this.#row(one, differ === "file" ? other(one) : one.default)));
  }

  #row(one, other) {
    const input = make("input", { type: "text", value: one.set, "aria-label": `${one.name}, set value`, disabled: one.range === "fixed by the image" });
    input.addEventListener("change", () => this.change(one.name, input));
    return make("tr", {}, make("th", { scope: "row" }, make("code", {}, one.name), make("small", {}, one.meaning ?? "")),
      make("td", { class: "number" }, one.active), make("td", {}, input), make("td", { class: "number" }, other ?? "–"), make("td", {}, one.range));
  }
}
