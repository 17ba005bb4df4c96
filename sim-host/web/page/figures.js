// Tables and figures of a result, as in a report.
import { byId, download, make, table } from "./dom.js";
import { drawMap, drawPath } from "./path.js";

const watched = new ResizeObserver((entries) => entries.forEach(({ target }) => target.draw?.()));
let plots = [];

/** Creates the legend of a path figure. */
export function pathLegend(curves) {
  return make("p", { class: "legend" }, ...curves.map(([name, tone, style]) => make("span", {}, make("i", { class: `${tone} ${style}` }), name)));
}

/** Creates a canvas that is drawn again when its width changes. */
export function pathCanvas(figure, draw = drawPath) {
  const canvas = make("canvas", { role: "img", "aria-label": `${figure.title}: ${figure.plots[0]?.series.map((curve) => curve.name).join(", ") ?? ""}` });
  const legend = make("div");
  canvas.draw = () => {
    if (canvas.clientWidth === 0) return;
    const curves = draw(canvas, figure);
    if (curves) legend.replaceChildren(pathLegend(curves));
  };
  watched.observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", canvas.draw);
  return [canvas, legend];
}

function zoomable(figure) {
  const card = make("div", { class: "card" });
  for (const plot of figure.plots) {
    const xs = plot.series.flatMap((curve) => [curve.x[0], curve.x.at(-1)]).filter((x) => x !== undefined);
    if (!xs.length) continue;
    plot.x.range ??= [Math.min(...xs), Math.max(...xs)];
    const place = make("div", { role: "img", "aria-label": `${figure.title}: ${plot.y.label} over ${plot.x.label}` });
    card.append(place);
    plots.push(() => globalThis.sonoglidePlot(plot, place));
  }
  card.append(make("p", { class: "hint" }, "Drag to zoom, double-click to reset; click a name to hide its curve."));
  return [card];
}

function section(figure, csv) {
  const body = figure.map ? pathCanvas(figure, drawMap) : figure.path ? pathCanvas(figure) : zoomable(figure);
  const save = make("button", { type: "button", class: "text", onclick: async () => download(`${figure.id}.csv`, await csv(`${figure.id}.csv`), "text/csv") }, "CSV");
  save.setAttribute("aria-label", `${figure.title} as CSV`);
  return make("figure", { class: "panel" },
    make("h3", {}, figure.title), ...body, make("figcaption", {}, make("p", {}, figure.caption), save));
}

/** Shows figures in an element; `csv` returns the data of one by the name of its file. */
export function showFigures(place, figures, csv) {
  plots = [];
  place.replaceChildren(...figures.filter((figure) => figure.map || figure.plots.some((plot) => plot.series.length)).map((figure) => section(figure, csv)));
  // The library measures the element, so it must be in the page first.
  for (const plot of plots) plot();
}

/** Shows tables and figures of a result. Figures are drawn when they become visible. */
export function showReport(result, core) {
  byId("title").textContent = result.title;
  byId("headline").replaceChildren(...result.headline.map(([label, value]) => make("div", {}, make("dt", {}, label), make("dd", {}, value))));
  const blocks = result.tables.map((block) => make("section", { class: "panel" }, make("h3", {}, block.title), table(block)));
  const words = make("section", { class: "panel" }, make("h3", {}, "About this scene"), result.subtitle ? make("p", {}, result.subtitle) : null, ...result.paragraphs.map((text) => make("p", {}, text)));
  byId("tables").replaceChildren(...blocks, words);
  byId("appendix").replaceChildren(...result.appendix.map((block) => make("section", {}, make("h3", {}, block.title), table(block))));
  showFigures(byId("figures"), result.figures, (name) => core.ask("file", name));
}

/** Shows the admittance loop next to the scope, if the run has identified its transducer. */
export function showLoop(result) {
  const loop = result.figures.find((figure) => figure.id === "admittance");
  byId("loop").replaceChildren(...(loop ? [make("h4", {}, loop.title), ...pathCanvas(loop)] : []));
}
