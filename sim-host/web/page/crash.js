// The crash, as a report shows it.
import { byId } from "./dom.js";

/** Shows a crash, or takes the last one away. */
export function showCrash(crash) {
  const where = byId("crash");
  where.replaceChildren();
  if (!crash) return;
  where.append(byId("crash-markup").content.cloneNode(true));
  globalThis.sonoglideCrash(crash, where.querySelector(".card"));
}
