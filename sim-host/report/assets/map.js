// Shows the values of a cell of a heat map at the pointer or by arrow keys, and zooms the map.
"use strict";
for (const card of document.querySelectorAll(".map")) {
  const { names, units, x, y, columns } = JSON.parse(card.querySelector("script").textContent);
  const [svg, image, output, hint] = ["svg", "image", "output", ".hint"].map((part) => card.querySelector(part));
  const [left, top, width, height] = ["x", "y", "width", "height"].map((name) => Number(image.getAttribute(name)));
  const frame = svg.appendChild(document.createElementNS(svg.namespaceURI, "rect"));
  const whole = svg.getAttribute("viewBox"), usage = "Drag to zoom, double-click to reset; arrow keys read cells.";
  let cell = null, start = null;
  hint.textContent = usage;

  const raise = (e, n) => "·10" + [...n].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("");
  const digits = (v) => String(Math.abs(v) >= 1e6 ? v.toExponential() : v).replace(/^-/, "−").replace(/e\+?(.+)/, raise);
  const text = (n, ...v) => `${names[n]}: ${v[0] == null ? "no value" : `${v.map(digits).join(" to ")} ${units[n]}`.trim()}`;
  const nearest = (i, j) => [Math.max(0, Math.min(x.length - 1, i)), Math.max(0, Math.min(y.length - 1, j))];

  function pointed(event) {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    return nearest(Math.floor((at.x - left) / width * x.length), Math.floor((top + height - at.y) / height * y.length));
  }

  // Frames the cells from one to another; returns the frame, and the ends of its columns and rows.
  function surround(a, b) {
    const [i, k, j, l] = [0, 1].flatMap((n) => [Math.min(a[n], b[n]), Math.max(a[n], b[n])]);
    const w = width / x.length, h = height / y.length;
    const box = [left + i * w, top + height - (l + 1) * h, (k - i + 1) * w, (l - j + 1) * h];
    ["x", "y", "width", "height"].forEach((name, n) => frame.setAttribute(name, box[n]));
    return [box.join(" "), [x[i], x[k]], [y[j], y[l]]];
  }

  function read(next) {
    cell = next;
    surround(start ?? cell, cell);
    output.textContent = [text(0, x[cell[0]]), text(1, y[cell[1]]), text(2, columns[cell[0]][cell[1]])].join("\n");
    const outer = card.getBoundingClientRect(), box = frame.getBoundingClientRect();
    const flip = box.right - outer.left > outer.width / 2;
    const [across, below] = [(flip ? box.left : box.right) - outer.left, box.bottom - outer.top];
    output.style.transform = `translate(${across}px, ${below}px)${flip ? " translateX(-100%)" : ""}`;
  }

  function clear() {
    cell = start = null;
    output.textContent = "";
    frame.setAttribute("width", 0);
  }

  function show(view, text) {
    svg.setAttribute("viewBox", view);
    hint.textContent = text;
    clear();
  }

  svg.onpointerdown = (event) => {
    if (event.button || event.pointerType === "touch") return;
    start = pointed(event);
    svg.setPointerCapture(event.pointerId);
  };
  svg.onpointermove = (event) => read(pointed(event));
  svg.onpointerup = (event) => {
    const [from, to] = [start, pointed(event)];
    start = null;
    if (!from || from[0] === to[0] || from[1] === to[1]) return;
    // The axes are out of sight in a zoomed map.
    const [box, xs, ys] = surround(from, to);
    show(box, `${text(0, ...xs)}; ${text(1, ...ys)}. Double-click to reset.`);
  };
  svg.ondblclick = () => show(whole, usage);
  svg.onpointerleave = svg.onpointercancel = card.onblur = clear;
  card.onkeydown = (event) => {
    const move = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!move) return;
    event.preventDefault();
    read(cell ? nearest(cell[0] + move[0], cell[1] + move[1]) : [x.length >> 1, y.length >> 1]);
  };
}
