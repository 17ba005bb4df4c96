// Shows the values of a cell of a heat map at the pointer or by arrow keys.
"use strict";
for (const card of document.querySelectorAll(".map")) {
  const { names, units, x, y, columns } = JSON.parse(card.querySelector("script").textContent);
  const [svg, image, output, hint] = ["svg", "image", "output", ".hint"].map((part) => card.querySelector(part));
  const [left, top, width, height] = ["x", "y", "width", "height"].map((name) => Number(image.getAttribute(name)));
  const frame = svg.appendChild(document.createElementNS(svg.namespaceURI, "rect"));
  let cell = null;
  hint.textContent = "Point at a cell to read it, or use the arrow keys.";

  const raise = (e, n) => "·10" + [...n].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("");
  const digits = (v) => String(Math.abs(v) >= 1e6 ? v.toExponential() : v).replace(/^-/, "−").replace(/e\+?(.+)/, raise);
  const text = (n, v) => `${names[n]}: ${v == null ? "no value" : `${digits(v)} ${units[n]}`.trim()}`;
  const nearest = (i, j) => [Math.max(0, Math.min(x.length - 1, i)), Math.max(0, Math.min(y.length - 1, j))];

  function pointed(event) {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    return nearest(Math.floor((at.x - left) / width * x.length), Math.floor((top + height - at.y) / height * y.length));
  }

  function read(next) {
    cell = next;
    const w = width / x.length, h = height / y.length;
    const place = { x: left + cell[0] * w, y: top + height - (cell[1] + 1) * h, width: w, height: h };
    for (const [name, value] of Object.entries(place)) frame.setAttribute(name, value);
    output.textContent = [text(0, x[cell[0]]), text(1, y[cell[1]]), text(2, columns[cell[0]][cell[1]])].join("\n");
    const outer = card.getBoundingClientRect(), box = frame.getBoundingClientRect();
    const flip = box.right - outer.left > outer.width / 2;
    const [across, below] = [(flip ? box.left : box.right) - outer.left, box.bottom - outer.top];
    output.style.transform = `translate(${across}px, ${below}px)${flip ? " translateX(-100%)" : ""}`;
  }

  function clear() {
    cell = null;
    output.textContent = "";
    frame.setAttribute("width", 0);
  }

  svg.onpointermove = (event) => read(pointed(event));
  svg.onpointerleave = svg.onpointercancel = card.onblur = clear;
  card.onkeydown = (event) => {
    const move = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!move) return;
    event.preventDefault();
    read(cell ? nearest(cell[0] + move[0], cell[1] + move[1]) : [x.length >> 1, y.length >> 1]);
  };
}
