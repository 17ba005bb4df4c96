// The crash view, as in a report.
import { byId } from "./dom.js";

/** Shows a crash, or removes the last one. */
export function showCrash(crash) {
  const where = byId("crash");
  where.replaceChildren();
  if (!crash) return;
  where.append(byId("crash-markup").content.cloneNode(true));
  globalThis.sonoglideCrash(crash, where.querySelector(".card"));
}
