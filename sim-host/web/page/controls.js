// Sliders and choices of a scene. Each is a key of the scene, and is shown with its meaning.
import { make } from "./dom.js";
import { plain, quantity } from "./format.js";

/** Number of steps of a slider. */
export const STEPS = 400;

/** Converts a value to the scene's form, which may be a list of one, and back. */
const written = ({ list }, value) => (list ? `[${plain(value)}]` : plain(value));
const read = (text) => Number(text.replace(/^\[|\]$/g, ""));

/** Converts a value to its position on the slider, and back. */
export const place = ({ min, max, log }, value) => STEPS * (log ? Math.log(value / min) / Math.log(max / min) : (value - min) / (max - min));
export function valueAt({ min, max, log, whole }, step) {
  const part = step / STEPS;
  const value = log ? min * (max / min) ** part : min + (max - min) * part;
  return whole ? Math.round(value) : Number(value.toPrecision(Math.abs(max - min) < 0.1 * Math.abs(max) ? 7 : 3));
}

/** Returns the present value of a slider. */
export const presentOf = (ask, { key, value }) => (ask.moved.has(key) ? read(ask.moved.get(key).value) : value);

/** Sets the key of a slider. */
export function setKey(ask, given, value) {
  ask.moved.set(given.key, { value: written(given, value), also: given.with });
  // A slider of a burst replaces an earlier switch in the run.
  if (given.list) ask.bursts = null;
}

function slider(given, ask, changed, curves) {
  const id = `slider-${given.key}`;
  const present = presentOf(ask, given);
  const output = make("output", { for: id });
  const input = make("input", {
    type: "range", id, min: 0, max: STEPS, step: 1, value: place(given, present), title: given.meaning, "aria-describedby": `${id}-key`,
  });
  const show = (value) => {
    const text = quantity(value, given.unit);
    output.textContent = text;
    input.setAttribute("aria-valuetext", text);
  };
  show(present);
  input.addEventListener("input", () => {
    const value = valueAt(given, Number(input.value));
    show(value);
    setKey(ask, given, value);
    changed();
  });
  const key = make("small", { id: `${id}-key` }, make("code", {}, given.key));
  return make("div", { class: "control" }, make("label", { for: id }, given.label), output, input, key, ...curves.nodes(given));
}

function choice(given, ask, changed) {
  const id = `choice-${given.key}`;
  const present = ask.moved.has(given.key) ? JSON.parse(ask.moved.get(given.key).value) : given.value;
  const options = given.choices.map(([name, meaning]) => make("option", { value: name, title: meaning, selected: name === present }, name.replaceAll("_", " ")));
  const select = make("select", { id, title: given.meaning, "aria-describedby": `${id}-key` }, ...options);
  select.addEventListener("change", () => {
    ask.moved.set(given.key, { value: `"${select.value}"`, also: [] });
    changed();
  });
  return make("div", { class: "control" }, make("label", { for: id }, given.label), select, make("small", { id: `${id}-key` }, make("code", {}, given.key)));
}

/** Shows the controls of an opened scene, with the curves under its sliders. The focus is kept. */
export function showControls(where, opened, ask, changed, curves) {
  const focused = document.activeElement?.id;
  where.replaceChildren(
    ...opened.sliders.map((given) => slider(given, ask, changed, curves)),
    ...opened.choices.map((given) => choice(given, ask, changed)),
  );
  if (focused && where.querySelector(`[id="${focused}"]`)) document.getElementById(focused).focus({ preventScroll: true });
}
