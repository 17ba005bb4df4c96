// Bursts on a timeline: three sliders for mouse and keyboard, drawn to scale.
import { byId, make } from "../dom.js";
import { quantity } from "../format.js";

const FIELDS = ["b-on", "b-off", "b-bursts"];

/** Returns the times of the sliders, s, and the number of bursts. The sliders are logarithmic: 1 ms to 1 s. */
function schedule() {
  const [on, off, count] = FIELDS.map((id) => Number(byId(id).value));
  const seconds = (place) => Number((10 ** (place / 100 - 3)).toPrecision(2));
  return { on: seconds(on), off: seconds(off), count };
}

/** Draws the timeline, and runs the bursts of its button. */
export function bursts(run) {
  const show = () => {
    const { on, off, count } = schedule(), whole = count * (on + off);
    byId("b-timeline").replaceChildren(...Array.from({ length: count }, () => [
      make("i", { style: `flex: ${on / whole}` }), make("b", { style: `flex: ${off / whole}` })]).flat());
    byId("b-timeline").setAttribute("aria-label", `${count} bursts of ${quantity(on, "s", 2)}, pauses of ${quantity(off, "s", 2)}`);
    for (const [id, text] of [["b-on", quantity(on, "s", 2)], ["b-off", quantity(off, "s", 2)], ["b-bursts", String(count)]]) {
      byId(`${id}-is`).textContent = text;
      byId(id).setAttribute("aria-valuetext", text);
    }
  };
  for (const id of FIELDS) byId(id).addEventListener("input", show);
  byId("b-burst").addEventListener("submit", (event) => {
    event.preventDefault();
    const { on, off, count } = schedule();
    run(`burst --on ${on} --off ${off} --count ${count}`);
  });
  show();
}
