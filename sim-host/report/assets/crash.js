// Draws the crash view of a report from the data in the page. Nothing moves on its own.
"use strict";
(() => {
function draw(data, stage) {
  const frames = data.instants, last = frames.length - 1;
  if (last < 1) return;
  stage.hidden = false;

  const SVG = stage.querySelector("svg").namespaceURI;
  const PASSIVE = "#b34700", SWITCHED = "#0072b2", INK = "#222", GREY = "#8a949d", PALE = "#d8dee3";
  const colours = [PASSIVE, SWITCHED];
  const make = (parent, name, attributes = {}, text = "") => {
    const node = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    if (text) node.textContent = text;
    parent.append(node);
    return node;
  };
  const set = (node, attributes) => { for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value); };
  const largest = (value) => Math.max(...frames.map(value));
  const kilonewton = (newton) => (newton / 1000).toFixed(2) + " kN";

  const farthest = Math.max(largest((f) => f.mm[0]), largest((f) => f.mm[1]));
  const strongest = Math.max(largest((f) => f.newton[0]), largest((f) => f.newton[1]));
  // Pixels per millimetre, two to three times the scale of the rest of the picture, so that the
  // motion is visible.
  const scale = Math.min(0.55, 78 / farthest);

  // ---- one belt, from the side; the car drives to the right
  const RING = { x: 92, y: 92 }, REEL = { x: 92, y: 262 }, HIP = { x: 186, y: 246 }, LONG = 118;
  function belt(svg, side) {
    make(svg, "text", { x: 8, y: 22, class: "title", style: `fill:${colours[side]}` }, side ? "With the controller" : "Today's belt");
    const status = make(svg, "text", { x: 8, y: 43, class: "quiet" });
    make(svg, "path", { d: "M0 296H400", stroke: PALE, "stroke-width": 3 });
    make(svg, "path", { d: "M92 60V296", stroke: PALE, "stroke-width": 9, "stroke-linecap": "round" });
    make(svg, "text", { x: RING.x - 14, y: 180, "text-anchor": "end", class: "quiet" }, "pillar");
    // The seat.
    make(svg, "path", { d: "M138 120L150 262H232", fill: "none", stroke: "#c3ccd3", "stroke-width": 20, "stroke-linecap": "round", "stroke-linejoin": "round" });
    // Initial position of the chest, and its displacement.
    const chest0 = 206;
    make(svg, "path", { d: `M${chest0} 84V306`, stroke: GREY, "stroke-width": 1, "stroke-dasharray": "3 4" });
    const way = make(svg, "path", { stroke: colours[side], "stroke-width": 2.5, fill: "none" });
    const wayText = make(svg, "text", { y: 324, "text-anchor": "middle" });
    // The person: the legs stay, the torso leans about the hip.
    make(svg, "path", { d: `M${HIP.x} ${HIP.y}H262L292 292`, fill: "none", stroke: "#5b6f80", "stroke-width": 25, "stroke-linecap": "round", "stroke-linejoin": "round" });
    const torso = make(svg, "path", { fill: "none", stroke: "#7d93a6", "stroke-width": 46, "stroke-linecap": "round" });
    const head = make(svg, "circle", { r: 23, fill: "#e3c4a4" });
    // Belt: reel to ring, ring to shoulder, across the chest to the buckle.
    const down = make(svg, "path", { d: `M${REEL.x} ${REEL.y}V${RING.y}`, fill: "none", "stroke-width": 5 });
    const up = make(svg, "path", { fill: "none", "stroke-linejoin": "round" });
    const marks = make(svg, "path", { fill: "none", stroke: "#fff", "stroke-width": 2, "stroke-dasharray": "2 10" });
    make(svg, "circle", { cx: HIP.x + 4, cy: HIP.y + 8, r: 6, fill: "#444" });
    const halo = [15, 20, 25].map((r) => make(svg, "circle", { cx: RING.x, cy: RING.y, r, fill: "none", stroke: SWITCHED, "stroke-width": 2 }));
    const ring = make(svg, "circle", { cx: RING.x, cy: RING.y, r: 10, fill: "#fff", "stroke-width": 5 });
    make(svg, "text", { x: RING.x - 31, y: RING.y + 5, "text-anchor": "end", class: "quiet" }, "D-ring");
    const reel = make(svg, "g");
    make(reel, "circle", { cx: REEL.x, cy: REEL.y, r: 20, fill: "#eef2f5", stroke: GREY, "stroke-width": 3 });
    const spoke = make(reel, "path", { d: "M-15 0H15M0 -15V15", stroke: GREY, "stroke-width": 3 });
    make(svg, "text", { x: REEL.x - 28, y: REEL.y + 5, "text-anchor": "end", class: "quiet" }, "reel");
    // Force as a bar.
    const BASE = 296, TALL = 216, X = 412;
    make(svg, "rect", { x: X, y: BASE - TALL, width: 30, height: TALL, fill: "#f0f3f5", rx: 3 });
    const bar = make(svg, "rect", { x: X, width: 30, fill: colours[side], rx: 3 });
    const peak = make(svg, "path", { stroke: INK, "stroke-width": 2 });
    make(svg, "text", { x: X + 32, y: BASE - TALL - 34, "text-anchor": "end", class: "quiet" }, "force at shoulder");
    const force = make(svg, "text", { x: X + 32, y: BASE - TALL - 12, "text-anchor": "end", class: "big", style: `fill:${colours[side]}` });
    const peakText = make(svg, "text", { x: X - 6, "text-anchor": "end", class: "quiet" });

    return (index) => {
      const f = frames[index], mm = f.mm[side], newton = f.newton[side];
      const low = side === 1 ? f.low : 0;
      const dx = mm * scale;
      // The torso turns about the hip, so that the shoulder moves as far forward as the arrow
      // shows.
      const sine = (dx - 12) / LONG, cosine = Math.sqrt(1 - sine * sine);
      const from = (along, ahead) => ({ x: HIP.x - 4 + along * sine + ahead * cosine, y: HIP.y - 8 - along * cosine + ahead * sine });
      const top = from(LONG - 22, 0), shoulder = from(LONG - 2, 2), front = from(LONG - 34, 24), neck = from(LONG + 34, 8);
      set(torso, { d: `M${HIP.x - 4} ${HIP.y - 10}L${top.x} ${top.y}` });
      set(head, { cx: neck.x, cy: neck.y });
      const tension = Math.min(1, newton / strongest);
      const colour = newton < 60 ? GREY : colours[side];
      const width = 4 + 6 * tension;
      const line = `M${RING.x} ${RING.y}L${shoulder.x} ${shoulder.y - 6}L${front.x} ${front.y}L${HIP.x + 4} ${HIP.y + 8}`;
      set(up, { d: line, stroke: colour, "stroke-width": width });
      set(marks, { d: line, "stroke-dashoffset": -f.payout_mm[side] * scale });
      set(down, { stroke: colour, "stroke-width": 4 + 3 * tension });
      set(spoke, { transform: `translate(${REEL.x} ${REEL.y}) rotate(${-f.payout_mm[side] * 3})` });
      halo.forEach((circle, n) => set(circle, { opacity: low * (0.8 - 0.22 * n) }));
      set(ring, { stroke: low > 0.5 ? SWITCHED : "#444" });
      status.textContent = low > 0.5 ? "drive ON: the ring is slippery" : "drive OFF: the ring has full friction";
      const end = chest0 + dx;
      set(way, { d: `M${chest0} 304H${end}` + (dx > 8 ? `m-6 -4l6 4l-6 4` : "") });
      set(wayText, { x: Math.max(chest0 + 40, (chest0 + end) / 2) });
      wayText.textContent = `${Math.max(0, mm).toFixed(0)} mm forward`;
      const height = TALL * newton / strongest;
      set(bar, { y: BASE - height, height });
      const most = Math.max(...frames.slice(0, index + 1).map((g) => g.newton[side]));
      const mark = BASE - TALL * most / strongest;
      set(peak, { d: `M${X - 4} ${mark}H${X + 34}` });
      set(peakText, { y: Math.max(mark + 5, BASE - TALL + 5) });
      peakText.textContent = most > 60 ? `peak ${kilonewton(most)}` : "";
      force.textContent = kilonewton(newton);
    };
  }

  // ---- force as bars over time
  function bars(svg) {
    const L = 58, R = 930, T = 34, B = 210, end = frames[last].ms;
    const x = (ms) => L + (R - L) * ms / end, y = (newton) => B - (B - T) * newton / (1.05 * strongest);
    make(svg, "text", { x: L, y: 18, class: "title" }, "Force at the shoulder over time");
    [["Today's belt", PASSIVE, 0], ["With the controller", SWITCHED, 1]].forEach(([name, colour, n]) => {
      make(svg, "rect", { x: 560 + 190 * n, y: 7, width: 14, height: 12, fill: colour, opacity: n ? 1 : 0.35 });
      make(svg, "text", { x: 580 + 190 * n, y: 18 }, name);
    });
    for (let newton = 0; newton <= strongest; newton += 1000) {
      make(svg, "path", { d: `M${L} ${y(newton)}H${R}`, stroke: "#e8e8e8" });
      make(svg, "text", { x: L - 8, y: y(newton) + 5, "text-anchor": "end", class: "quiet" }, `${newton / 1000} kN`);
    }
    for (let ms = 0; ms <= end; ms += 20) make(svg, "text", { x: x(ms), y: B + 20, "text-anchor": "middle", class: "quiet" }, `${ms} ms`);
    if (data.low_ms !== null && data.low_ms > 0) {
      make(svg, "path", { d: `M${x(data.low_ms)} ${T}V${B}`, stroke: SWITCHED, "stroke-width": 1.5, "stroke-dasharray": "4 3" });
      make(svg, "text", { x: x(data.low_ms) - 6, y: T + 12, "text-anchor": "end", class: "quiet" }, "drive ON");
    }
    const WIDTH = 2, all = [];
    for (let from = 0; from < end; from += WIDTH) {
      const within = frames.map((f, n) => [f, n]).filter(([f]) => f.ms >= from && f.ms < from + WIDTH);
      if (!within.length) continue;
      const mean = (side) => within.reduce((sum, [f]) => sum + f.newton[side], 0) / within.length;
      const wide = x(from + WIDTH) - x(from) - 1;
      const draw = (side, opacity, inset) =>
        make(svg, "rect", { x: x(from) + inset, y: y(mean(side)), width: wide - 2 * inset, height: B - y(mean(side)), fill: colours[side], "data-opacity": opacity });
      all.push({ index: within[0][1], nodes: [draw(0, 0.35, 0), draw(1, 1, 2)] });
    }
    const cursor = make(svg, "path", { stroke: INK, "stroke-width": 1.5 });
    make(svg, "text", { x: (L + R) / 2, y: B + 38, "text-anchor": "middle", class: "quiet" }, "time since the crash began");
    return (index) => {
      for (const bar of all) for (const node of bar.nodes) node.setAttribute("opacity", bar.index <= index ? node.dataset.opacity : 0.08);
      set(cursor, { d: `M${x(frames[index].ms)} ${T}V${B}` });
    };
  }

  // ---- descriptions of the important moments
  const first = (holds) => { const n = frames.findIndex(holds); return n < 0 ? last : n; };
  const top = (side) => largest((f) => f.newton[side]), way = (side) => largest((f) => f.mm[side]);
  const same = Math.abs(top(1) / top(0) - 1) < 0.005;
  const per = (part) => `${Math.abs(100 * part).toFixed(0)} %`;
  const moments = [
    { at: 0, text: `The car hits something and begins to brake. ${data.occupant[0].toUpperCase() + data.occupant.slice(1)}, a torso of ${data.torso_kg.toFixed(0)} kg. ` +
      `Nothing holds it yet: there are ${data.slack_mm.toFixed(0)} mm of slack between it and the belt.` },
    { at: first((f) => f.newton[0] > 150), text: "The slack is taken up. The belt begins to pull, and webbing begins to slide over the ring." },
    ...(data.low_ms > 0 ? [{ at: first((f) => f.ms >= data.low_ms), text: "The belt force shows that this is a crash. The seat had reported a light person, " +
      "so the controller switches the ultrasound on, once. The ring on the right becomes slippery within 3 ms." }] : []),
    ...(data.low_ms === null ? [{ at: first((f) => f.newton[0] > 400), text: "The belt force shows that this is a crash. The seat has not reported a light person, " +
      "so the controller does not change the ring: this person needs the full force." }] : []),
    ...(same ? [] : [{ at: first((f) => f.newton[1] > 0.97 * top(1)), text: `Right: the reel yields, and only ${kilonewton(top(1))} reaches the shoulder. ` +
      "Left: the reel still holds, because friction at the ring takes part of the pull; the force continues to rise." }]),
    { at: first((f) => f.newton[0] >= 0.999 * top(0)), text: `${same ? "Both belts pull" : "Left: the belt pulls"} with ${kilonewton(top(0))}, the largest force in this crash` +
      (same ? "." : `; on the right it was never more than ${kilonewton(top(1))}, ${per(1 - top(1) / top(0))} less.`) },
    { at: first((f) => f.mm[0] >= 0.9999 * way(0)), text: `${same ? "The torso is" : "Left: the torso is"} at its most forward position, ${way(0).toFixed(0)} mm.` },
    ...(same ? [] : [{ at: first((f) => f.mm[1] >= 0.9999 * way(1)), text: `Right: the most forward position, ${way(1).toFixed(0)} mm, ${(way(1) - way(0)).toFixed(0)} mm further than on the left. ` +
      "That is the price of the lower force; the car must have room for it." }]),
    { at: last, text: same ? "The torso moves back. Both belts did exactly the same." : `The torso moves back. In short: ${per(1 - top(1) / top(0))} less force at the shoulder, for ${(way(1) - way(0)).toFixed(0)} mm more displacement.` },
  ].sort((a, b) => a.at - b.at);

  // ---- controls
  const [left, right] = stage.querySelectorAll(".crash-pair svg");
  const draws = [belt(left, 0), belt(right, 1), bars(stage.querySelector(".crash-bars"))];
  const slider = stage.querySelector("input"), clock = stage.querySelector("output"), story = stage.querySelector(".crash-story");
  const play = stage.querySelector("[data-play]");
  slider.max = last;
  let index = -1, running = 0;
  function show(next) {
    index = Math.max(0, Math.min(last, next));
    draws.forEach((draw) => draw(index));
    slider.value = index;
    clock.textContent = frames[index].ms.toFixed(1) + " ms";
    const moment = moments.filter((moment) => moment.at <= index).at(-1);
    const text = `${frames[moment.at].ms.toFixed(0)} ms: ${moment.text}`;
    if (story.textContent !== text) story.textContent = text;
    stage.querySelector("[data-go='-1']").disabled = index === 0;
    stage.querySelector("[data-go='1']").disabled = index === last;
  }
  function stop() {
    cancelAnimationFrame(running);
    running = 0;
    play.textContent = "Play, 80 times slower";
  }
  function start() {
    const from = index >= last ? 0 : index, began = performance.now(), perFrame = 80 * (frames[1].ms - frames[0].ms);
    play.textContent = "Pause";
    const tick = (now) => {
      const next = from + Math.floor((now - began) / perFrame);
      show(next);
      if (next >= last) stop(); else running = requestAnimationFrame(tick);
    };
    running = requestAnimationFrame(tick);
  }
  play.addEventListener("click", () => (running ? stop() : start()));
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) play.hidden = true;
  slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
  stage.querySelectorAll("[data-go]").forEach((button) => button.addEventListener("click", () => {
    stop();
    const to = Number(button.dataset.go) > 0 ? moments.find((m) => m.at > index) : moments.filter((m) => m.at < index).at(-1);
    if (to) show(to.at);
  }));
  // By default show the moment of the largest force; a fragment such as #crash-ms=40 selects
  // another moment.
  const asked = /crash-ms=(\d+)/.exec(location.hash);
  show(asked ? first((f) => f.ms >= Number(asked[1])) : first((f) => f.newton[0] >= 0.999 * top(0)));
}

const source = document.getElementById("crash-data");
if (source) draw(JSON.parse(source.textContent), document.getElementById("crash-stage"));
// A page that loads its crash later calls this itself.
globalThis.sonoglideCrash = draw;
})();
