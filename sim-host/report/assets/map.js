// Shows the values of a cell of a heat map at the pointer or by arrow keys, and zooms the map.
"use strict";
for (const card of document.querySelectorAll(".map")) {
  const { names, units, log, x, y, columns } = JSON.parse(card.querySelector("script").textContent);
  const [svg, image, output, hint] = ["svg", "image", "output", ".hint"].map((part) => card.querySelector(part));
  const [left, top, width, height] = ["x", "y", "width", "height"].map((name) => Number(image.getAttribute(name)));
  const create = (name) => document.createElementNS(svg.namespaceURI, name), whole = [0, x.length, 0, y.length];
  const set = (node, values) => Object.entries(values).forEach(([name, value]) => node.setAttribute(name, value));
  const usage = "Drag to zoom, double-click to reset; arrow keys read cells.";
  // The axes are drawn before the cells, the contours after them, and then the bar at the right.
  const nodes = [...svg.children], axes = nodes.slice(0, nodes.indexOf(image)).filter((node) => node.matches("polyline, [fill='#555555']"));
  const [labels, rules] = ["text", "polyline"].map((name) => axes.filter((node) => node.matches(name)));
  const plot = create("svg"), frame = create("rect"), zoomed = create("g");
  const parts = nodes.slice(nodes.indexOf(image)).filter((node) => node.getBBox().x < left + width).map((node) => [node, node.cloneNode()]);
  set(plot, { x: left, y: top, width, height, viewBox: [left, top, width, height].join(" ") });
  image.before(plot);
  plot.append(...parts.map(([node]) => node), frame);
  svg.append(zoomed);
  // The ends of the columns and of the rows in view.
  let view = whole, cell = null, start = null;
  hint.textContent = usage;

  const raise = (e, n) => "·10" + [...n].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("");
  const digits = (v) => String(Math.abs(v) >= 1e6 ? v.toExponential() : v).replace(/^-/, "−").replace(/e\+?(.+)/, raise);
  const text = (n, v) => `${names[n]}: ${v == null ? "no value" : `${digits(v)} ${units[n]}`.trim()}`;
  const nearest = (i, j) => [Math.max(view[0], Math.min(view[1] - 1, i)), Math.max(view[2], Math.min(view[3] - 1, j))];
  const X = (column) => left + (column - view[0]) / (view[1] - view[0]) * width;
  const Y = (row) => top + height - (row - view[2]) / (view[3] - view[2]) * height;

  function pointed(event) {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    const along = (part, from, to) => Math.floor(from + part * (to - from));
    return nearest(along((at.x - left) / width, view[0], view[1]), along((top + height - at.y) / height, view[2], view[3]));
  }

  // Frames the cells from one to another; returns the ends of its columns and rows.
  function surround(a, b) {
    const [i, k, j, l] = [0, 1].flatMap((n) => [Math.min(a[n], b[n]), Math.max(a[n], b[n]) + 1]);
    set(frame, { x: X(i), y: Y(l), width: X(k) - X(i), height: Y(j) - Y(l) });
    return [i, k, j, l];
  }

  // Returns the ticks of an axis between two ends of its cells: the place among the cells, and the label.
  function ticks(n, from, to, most) {
    const keys = n ? y : x, at = (value) => (log[n] ? Math.log10(value) : value), back = (place) => (log[n] ? 10 ** place : place);
    const zero = at(keys[0]), step = (at(keys.at(-1)) - zero) / (keys.length - 1), place = (value) => (at(value) - zero) / step + 0.5;
    const [low, high] = [from, to].map((edge) => back(zero + (edge - 0.5) * step)), decades = log[n] ? Math.log10(high / low) : 0;
    const rough = (high - low) / most, unit = 10 ** Math.floor(Math.log10(rough)), jump = [1, 2, 5, 10].find((k) => k * unit >= 0.999 * rough) * unit;
    const decimals = Math.max(0, -Math.floor(Math.log10(jump) + 1e-9));
    const even = (_, k) => (Math.ceil(low / jump - 1e-6) + k) * jump, powers = (decades < 2 ? [1, 2, 5] : [1]);
    const every = (_, k) => powers[k % powers.length] * 10 ** (Math.floor(Math.log10(low)) + Math.floor(k / powers.length));
    const values = Array.from({ length: 60 }, decades < 0.7 ? even : every).filter((value) => place(value) >= from - 1e-6 && place(value) <= to + 1e-6);
    const isPlain = decades < 0.7 && Math.max(Math.abs(low), Math.abs(high)) < 1e6 && decimals < 6;
    return values.map((value) => [place(value), isPlain ? value.toFixed(decimals).replace("-", "−") : digits(Number(value.toPrecision(6)))]);
  }

  // Draws the axes of the cells in view, in the style of the others.
  function relabel() {
    axes.forEach((node) => set(node, { visibility: view === whole ? "visible" : "hidden" }));
    zoomed.replaceChildren();
    if (view === whole) return;
    const draw = (node, values, text = "") => {
      const copy = zoomed.appendChild(node.cloneNode());
      set(copy, { ...values, visibility: "visible" });
      copy.textContent = text;
    };
    const mark = (points) => draw(rules[0], { points: points.join(" ") }), end = top + height;
    const [below, across] = ["middle", "end"].map((anchor) => labels.find((node) => node.matches(`[text-anchor=${anchor}]`)));
    for (const [at, text] of ticks(0, view[0], view[1], 10)) mark([X(at), end, X(at), end + 24]), draw(below, { x: X(at) }, text);
    for (const [at, text] of ticks(1, view[2], view[3], 8)) mark([left - 24, Y(at), left, Y(at)]), draw(across, { y: Y(at) }, text);
    mark([left, top, left, end, left + width, end]);
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

  // Shows some of the cells. Texts and lines keep their size.
  function show(next) {
    view = next;
    const across = (value) => X((value - left) / width * x.length), down = (value) => Y((top + height - value) / height * y.length);
    for (const [node, old] of parts) {
      const [x0, y0, w, h] = ["x", "y", "width", "height"].map((name) => Number(old.getAttribute(name)));
      const points = old.getAttribute("points")?.match(/[\d.-]+/g)?.map((value, n) => (n % 2 ? down(value) : across(value))).join(" ");
      if (node === image) set(node, { x: X(0), y: Y(y.length), width: X(x.length) - X(0), height: Y(0) - Y(y.length) });
      else set(node, points ? { points } : { x: across(x0 + w / 2) - w / 2, y: down(y0 + h / 2) - h / 2 });
    }
    relabel();
    hint.textContent = view === whole ? usage : "Double-click to reset.";
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
    show(surround(from, to));
  };
  svg.ondblclick = () => show(whole);
  svg.onpointerleave = svg.onpointercancel = card.onblur = clear;
  card.onkeydown = (event) => {
    const move = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!move) return;
    event.preventDefault();
    read(cell ? nearest(cell[0] + move[0], cell[1] + move[1]) : nearest((view[0] + view[1]) >> 1, (view[2] + view[3]) >> 1));
  };
}
