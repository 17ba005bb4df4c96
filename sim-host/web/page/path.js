// Figures whose curves are paths in a plane, such as an admittance loop, and maps of values as
// colours: drawn on a canvas.
import { colour, sheet } from "./dom.js";
import { digits } from "./format.js";

const MARGIN = { left: 74, right: 14, top: 12, bottom: 40 };

/** Returns about `most` round values between two ends. */
export function ticks(low, high, most) {
  const raw = (high - low) / most, unit = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((digit) => digit * unit >= raw) * unit;
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, place) => (first + place) * step);
}

/** Returns the scale of an axis; a logarithmic axis uses logarithms. */
const scaled = (axis) => (value) => (axis.log ? Math.log10(value) : value);

/** Returns the ends of some values, with room on both sides relative to their range. */
export function extent(values, room) {
  let low = Infinity, high = -Infinity;
  for (const value of values) if (Number.isFinite(value)) [low, high] = [Math.min(low, value), Math.max(high, value)];
  if (low > high) return [0, 1];
  const more = (high - low || Math.abs(high) || 1) * room;
  return [low - more, high + more];
}

function frame(context, { left, top, right, bottom }, [x0, x1], [y0, y1], figure) {
  const ink = colour("muted"), grid = colour("grid");
  context.font = "12px system-ui, sans-serif";
  context.lineWidth = 1;
  const X = (x) => left + ((x - x0) / (x1 - x0)) * (right - left), Y = (y) => bottom - ((y - y0) / (y1 - y0)) * (bottom - top);
  const label = (axis, value) => (axis.log ? digits(10 ** value, 2) : digits(value, 3));
  context.fillStyle = ink;
  for (const x of ticks(x0, x1, Math.max(2, (right - left) / 90))) {
    context.strokeStyle = grid;
    context.beginPath(); context.moveTo(X(x), top); context.lineTo(X(x), bottom); context.stroke();
    context.textAlign = "center"; context.textBaseline = "top";
    context.fillText(label(figure.x, x), X(x), bottom + 5);
  }
  for (const y of ticks(y0, y1, Math.max(2, (bottom - top) / 50))) {
    context.strokeStyle = grid;
    context.beginPath(); context.moveTo(left, Y(y)); context.lineTo(right, Y(y)); context.stroke();
    context.textAlign = "right"; context.textBaseline = "middle";
    context.fillText(label(figure.y, y), left - 6, Y(y));
  }
  context.textAlign = "center"; context.textBaseline = "bottom";
  context.fillText(figure.x.label, (left + right) / 2, bottom + 38);
  context.save();
  context.translate(12, (top + bottom) / 2); context.rotate(-Math.PI / 2); context.textBaseline = "middle";
  context.fillText(figure.y.label, 0, 0);
  context.restore();
  return [X, Y];
}

/** Draws a path figure. */
export function drawPath(canvas, figure) {
  const { series, markers } = figure.plots[0];
  const { context, width, height } = sheet(canvas, Math.round(Math.min(420, Math.max(240, canvas.clientWidth * 0.8))));
  const box = { left: MARGIN.left, right: width - MARGIN.right, top: MARGIN.top, bottom: height - MARGIN.bottom };
  const [sx, sy] = [scaled(figure.x), scaled(figure.y)];
  const real = (value) => (value === null ? NaN : value);
  const line = series.filter((curve) => curve.style !== "points");
  // Distant dots must not shrink the curves.
  const seen = line.length ? line : series;
  let xs = figure.x.range?.map(sx) ?? extent([...seen.flatMap((curve) => curve.x.map(sx)), ...markers.map(([x]) => sx(x))], 0.08);
  let ys = figure.y.range?.map(sy) ?? extent([...seen.flatMap((curve) => curve.columns[0].map((y) => sy(real(y)))), ...markers.map(([, y]) => sy(y))], 0.08);
  if (figure.equal) {
    const unit = Math.max((xs[1] - xs[0]) / (box.right - box.left), (ys[1] - ys[0]) / (box.bottom - box.top));
    const widen = ([low, high], pixels) => { const more = (unit * pixels - (high - low)) / 2; return [low - more, high + more]; };
    [xs, ys] = [widen(xs, box.right - box.left), widen(ys, box.bottom - box.top)];
  }
  const [X, Y] = frame(context, box, xs, ys, figure);
  context.save();
  context.beginPath(); context.rect(box.left, box.top, box.right - box.left, box.bottom - box.top); context.clip();
  const others = ["command", "sensor", "ink", "estimate", "truth"];
  const tones = series.map(({ name }, place) => (/\btru/.test(name) ? "truth" : /identified|estimate/.test(name) ? "estimate" : others[place % others.length]));
  series.forEach((curve, place) => {
    context.strokeStyle = context.fillStyle = colour(tones[place]);
    context.setLineDash(curve.style === "dashed" ? [6, 4] : []);
    context.lineWidth = 1.8;
    context.beginPath();
    let down = false;
    curve.x.forEach((x, n) => {
      const y = curve.columns[0][n];
      if (y === null) { down = false; return; }
      const [px, py] = [X(sx(x)), Y(sy(y))];
      if (curve.style === "points") { context.moveTo(px + 2, py); context.arc(px, py, 2, 0, 7); }
      else if (down) context.lineTo(px, py);
      else context.moveTo(px, py);
      down = true;
    });
    if (curve.style === "points") context.fill(); else context.stroke();
  });
  context.setLineDash([]);
  for (const [x, y, text] of markers) {
    context.fillStyle = colour("ink");
    context.beginPath(); context.arc(X(sx(x)), Y(sy(y)), 4.5, 0, 7); context.fill();
    context.textAlign = X(sx(x)) > (box.left + box.right) / 2 ? "right" : "left"; context.textBaseline = "bottom";
    context.fillText(text, X(sx(x)) + (context.textAlign === "right" ? -8 : 8), Y(sy(y)) - 4);
  }
  context.restore();
  return series.map((curve, place) => [curve.name, tones[place], curve.style]);
}

const STOPS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
function shade(part) {
  const at = Math.max(0, Math.min(1, part)) * (STOPS.length - 1), from = Math.min(STOPS.length - 2, Math.floor(at));
  return STOPS[from].map((tone, n) => Math.round(tone + (STOPS[from + 1][n] - tone) * (at - from)));
}

/** Draws a map of values as colours. */
export function drawMap(canvas, figure) {
  const { map } = figure;
  const { context, width, height } = sheet(canvas, Math.round(Math.min(420, Math.max(240, canvas.clientWidth * 0.55))));
  const box = { left: MARGIN.left, right: width - 70, top: MARGIN.top, bottom: height - MARGIN.bottom };
  const columns = map.columns.length, rows = map.columns[0].length;
  const image = new ImageData(columns, rows);
  const part = (value) => (value === null ? 0 : (value - map.range[0]) / (map.range[1] - map.range[0]));
  map.columns.forEach((column, x) => column.forEach((value, y) => image.data.set([...shade(part(value)), 255], 4 * ((rows - 1 - y) * columns + x))));
  const small = new OffscreenCanvas(columns, rows);
  small.getContext("2d").putImageData(image, 0, 0);
  frame(context, box, map.x.map(scaled(figure.x)), map.y.map(scaled(figure.y)), figure);
  context.imageSmoothingEnabled = false;
  context.drawImage(small, box.left, box.top, box.right - box.left, box.bottom - box.top);
  const steps = 64, high = (box.bottom - box.top) / steps;
  for (let n = 0; n < steps; n += 1) {
    context.fillStyle = `rgb(${shade(n / (steps - 1)).join(",")})`;
    context.fillRect(box.right + 12, box.bottom - (n + 1) * high, 14, high + 0.5);
  }
  context.fillStyle = colour("muted");
  context.textAlign = "left"; context.textBaseline = "middle";
  for (const value of ticks(...map.range, 4)) context.fillText(digits(value, 3), box.right + 30, box.bottom - part(value) * (box.bottom - box.top));
}
