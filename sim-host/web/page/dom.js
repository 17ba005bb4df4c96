// Helper functions for elements.

/** Returns the element with this id. */
export const byId = (id) => document.getElementById(id);

/** Creates an element with attributes and children; strings become text nodes. */
export function make(name, attributes = {}, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else node.setAttribute(key, value === true ? "" : value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

/** Returns a colour of the style sheet. */
export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

/** Prepares a canvas with the width of its container and this height, cleared, in CSS pixels. */
export function sheet(canvas, height) {
  const ratio = Math.min(3, window.devicePixelRatio || 1);
  const width = canvas.clientWidth;
  const [across, down] = [Math.round(width * ratio), Math.round(height * ratio)];
  canvas.style.height = `${height}px`;
  if (canvas.width !== across || canvas.height !== down) [canvas.width, canvas.height] = [across, down];
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

/** Creates a table with a caption; columns of numbers are aligned to the right. */
export function table({ title, caption, header, rows }) {
  const numeric = header.map((_, column) => rows.length > 0 && rows.every((row) => /^[-+−±<>≤≥≈.\s]*\d|^[-–—]?$/.test(row[column] ?? "")));
  const cell = (text, column) => make("td", { class: text.startsWith("PASS") ? "pass" : text.startsWith("MISS") ? "miss" : numeric[column] ? "number" : null }, text);
  const first = (text) => make("th", { scope: "row" }, text);
  const line = (row) => make("tr", {}, ...row.map((text, column) => (column === 0 && !text.match(/^(PASS|MISS|holds|does not hold)$/) ? first(text) : cell(text, column))));
  const head = header.some((text) => text) ? make("thead", {}, make("tr", {}, ...header.map((text, column) => (text ? make("th", { scope: "col", class: numeric[column] ? "number" : null }, text) : make("td"))))) : null;
  return make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": title },
    make("table", { class: "data" }, make("caption", { class: "hidden" }, title), head, make("tbody", {}, ...rows.map(line))),
    caption ? make("p", { class: "caption" }, caption) : null);
}

/** Offers a text for download as a file. */
export function download(name, text, type = "text/plain") {
  const address = URL.createObjectURL(new Blob([text], { type }));
  make("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}
