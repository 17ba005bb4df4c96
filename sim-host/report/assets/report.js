// Draws the zoomable figures of a report from the data in the page.
"use strict";
(() => {
  const FONT = "12px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
  const LABEL_FONT = FONT.replace("12px", "13px");
  const INK = "#222", MUTED = "#555", GRID = "#e8e8e8", SHADE = "#fdf0d0";
  const GROUP = "\u202f", MINUS = "\u2212";

  const raise = (text) => [...text].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("");

  function plain(value, decimals) {
    const digits = Math.abs(value).toFixed(decimals);
    let [whole, fraction] = digits.split(".");
    if (whole.length > 4) whole = whole.replace(/\B(?=(\d{3})+$)/g, GROUP);
    const sign = value < 0 && /[1-9]/.test(digits) ? MINUS : "";
    return sign + whole + (fraction ? "." + fraction : "");
  }

  // Number of decimals that the step needs: a quarter needs two.
  const decimalsOf = (step) => {
    const whole = (x) => Math.abs(x - Math.round(x)) < 1e-6 * x;
    let decimals = 0;
    while (decimals < 12 && !whole(step * 10 ** decimals)) decimals += 1;
    return decimals;
  };

  const power = (mantissa, exponent) => `${mantissa}·10${raise(String(exponent))}`;

  function tickLabels(log) {
    return (u, values, axis, space, step) => {
      const real = values.filter((v) => v != null);
      const largest = Math.max(...real.map(Math.abs));
      const exponent = largest > 0 ? Math.floor(Math.log10(largest)) : 0;
      const far = largest >= 1e5 || Math.min(...real) < 9e-4;
      return values.map((v) => {
        if (v == null) return "";
        if (log) {
          const own = Math.floor(Math.log10(v) + 1e-9);
          if (!far) return plain(v, Math.max(0, -own));
          return power(plain(v / 10 ** own, 0), own).replace(/^1·/, "");
        }
        if (v === 0) return "0";
        return exponent < -3 || exponent > 5
          ? power(plain(v / 10 ** exponent, decimalsOf(step / 10 ** exponent)), exponent)
          : plain(v, decimalsOf(step));
      });
    };
  }

  // Round values of a logarithmic axis: whole decades, with values between them if there is room.
  function logTicks(u, index, low, high) {
    const pixels = (index === 0 ? u.bbox.width : u.bbox.height) / uPlot.pxRatio;
    const room = pixels / (index === 0 ? 80 : 30);
    const decades = Math.log10(high / low);
    const stride = Math.max(1, Math.ceil(decades / room));
    const digits = 9 * decades < room ? [1, 2, 3, 4, 5, 6, 7, 8, 9] : 3 * decades < room ? [1, 2, 5] : [1];
    const ticks = [];
    for (let e = Math.floor(Math.log10(low)); e <= Math.ceil(Math.log10(high)); e++) {
      if (e % stride) continue;
      for (const digit of digits) ticks.push(Number(`${digit}e${e}`));
    }
    return ticks.filter((v) => v >= low && v <= high);
  }

  // Formats a value to a ten-thousandth of its axis, or to five digits on a logarithmic one.
  function reading(v, scale) {
    if (v == null) return "–";
    const own = v === 0 ? 0 : Math.floor(Math.log10(Math.abs(v)));
    const exponent = own < -4 || own > 8 ? own : 0;
    const step = 10 ** (scale.distr === 3 ? own - 4 : Math.floor(Math.log10((scale.max - scale.min) / 1e4)));
    const digits = plain(v / 10 ** exponent, decimalsOf(step / 10 ** exponent));
    return exponent ? power(digits, exponent) : digits;
  }

  function axisSize(u, labels, index, cycle) {
    const axis = u.axes[index];
    if (cycle > 1) return axis._size;
    u.ctx.save();
    u.ctx.font = FONT;
    const widths = (labels ?? []).map((text) => u.ctx.measureText(text).width);
    u.ctx.restore();
    return Math.ceil(axis.ticks.size + axis.gap + 4 + Math.max(10, ...widths));
  }

  function axis(data, vertical) {
    const common = {
      label: data.label, stroke: MUTED, font: FONT, labelFont: LABEL_FONT, labelGap: 4,
      labelSize: 24, gap: 5, values: tickLabels(data.log),
      grid: { stroke: GRID, width: 1 }, ticks: { stroke: "#bbb", width: 1, size: 5 },
      border: { show: true, stroke: "#999", width: 1 },
    };
    if (data.log) Object.assign(common, { splits: logTicks, filter: (u, ticks) => ticks });
    return vertical ? { ...common, size: axisSize, space: 38 } : { ...common, size: 34, space: 80 };
  }

  function yRange(figure) {
    const { y, lines, spans } = figure;
    return (u, low, high) => {
      if (y.range) return y.range;
      if (low == null) return y.log ? [1, 10] : [0, 1];
      for (const [value] of lines) {
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
      if (y.log) {
        const room = Math.max((high / low) ** 0.06, 1.05);
        return [low / room, high * room];
      }
      const extent = high - low;
      if (extent <= 1e-12 * Math.abs(high)) {
        const room = 0.1 * Math.abs(high) || 1;
        return [low - room, high + room];
      }
      const bottom = low >= 0 && low < 0.45 * high ? 0 : low - 0.06 * extent;
      return [bottom, high + (spans.length ? 0.12 : 0.06) * (high - Math.min(bottom, low))];
    };
  }

  function xRange(figure, whole) {
    const shown = figure.x.range;
    // Without a zoom the plot requests the extent of the data.
    return (u, low, high) =>
      low == null || (low <= whole[0] && high >= whole[1]) ? shown : [low, high];
  }

  // Runs `draw` in CSS pixels, clipped to the plot.
  function inPlot(u, draw) {
    const { ctx, bbox } = u;
    const ratio = uPlot.pxRatio;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.scale(ratio, ratio);
    const box = {
      left: bbox.left / ratio, top: bbox.top / ratio,
      right: (bbox.left + bbox.width) / ratio, bottom: (bbox.top + bbox.height) / ratio,
    };
    draw(ctx, box, (v) => u.valToPos(v, "x") + box.left, (v) => u.valToPos(v, "y") + box.top);
    ctx.restore();
  }

  function note(ctx, text, x, y, align, color, plate = "rgba(255, 255, 255, 0.8)") {
    if (!text) return;
    ctx.font = FONT;
    ctx.textAlign = align;
    ctx.textBaseline = "middle";
    const width = ctx.measureText(text).width;
    const left = align === "center" ? x - width / 2 : align === "right" ? x - width : x;
    ctx.fillStyle = plate;
    ctx.fillRect(left - 3, y - 8, width + 6, 16);
    ctx.fillStyle = color;
    ctx.fillText(text, x, y);
  }

  function drawSpans(u, figure) {
    inPlot(u, (ctx, box, x) => {
      ctx.fillStyle = SHADE;
      for (const [from, to] of figure.spans) {
        ctx.fillRect(x(from), box.top, Math.max(0.5, x(to) - x(from)), box.bottom - box.top);
      }
    });
  }

  // Returns the screen positions of the visible samples.
  function samples(figure, u, x, y) {
    const { min, max } = u.scales.x;
    const points = figure.markers.map(([mx, my]) => [x(mx), y(my)]);
    for (const curve of figure.series) {
      curve.x.forEach((value, i) => {
        const other = curve.columns[0][i];
        if (value >= min && value <= max && other != null) points.push([x(value), y(other)]);
      });
    }
    return points;
  }

  // Returns the place next to a marker at which its label covers the fewest samples.
  function labelPlace(x, y, width, box, busy) {
    let best = null;
    for (const [side, shift] of [[1, -1], [-1, -1], [1, 1], [-1, 1], [1, 0], [-1, 0]]) {
      const place = { x: x + 10 * side, y: y + 12 * shift, align: side > 0 ? "left" : "right" };
      const left = side > 0 ? place.x : place.x - width;
      const outside = left < box.left || left + width > box.right
        || place.y - 8 < box.top || place.y + 8 > box.bottom;
      const covers = ([bx, by]) => bx >= left && bx <= left + width && Math.abs(by - place.y) <= 8;
      const cost = busy.filter(covers).length + (outside ? 1e9 : 0);
      if (!best || cost < best.cost) best = { ...place, cost };
    }
    return best;
  }

  function drawMarks(u, figure) {
    inPlot(u, (ctx, box, x, y) => {
      ctx.font = FONT;
      for (const [from, to, label] of figure.spans) {
        const left = Math.max(x(from), box.left), right = Math.min(x(to), box.right);
        if (right - left > ctx.measureText(label).width + 8) {
          note(ctx, label, (left + right) / 2, box.top + 14, "center", MUTED, SHADE);
        }
      }
      for (const [value, label] of figure.lines) {
        ctx.strokeStyle = MUTED;
        ctx.setLineDash([6, 4]);
        ctx.beginPath();
        ctx.moveTo(box.left, y(value));
        ctx.lineTo(box.right, y(value));
        ctx.stroke();
        ctx.setLineDash([]);
        note(ctx, label, box.right - 8, y(value) - 10, "right", MUTED);
      }
      const busy = figure.markers.length ? samples(figure, u, x, y) : [];
      for (const [mx, my, label] of figure.markers) {
        ctx.beginPath();
        ctx.arc(x(mx), y(my), 4.5, 0, 2 * Math.PI);
        ctx.fillStyle = INK;
        ctx.strokeStyle = "#fff";
        ctx.lineWidth = 2;
        ctx.stroke();
        ctx.fill();
        ctx.lineWidth = 1;
        const place = labelPlace(x(mx), y(my), ctx.measureText(label).width, box, busy);
        note(ctx, label, place.x, place.y, place.align, INK);
      }
    });
  }

  // Returns the plot's columns: each curve, with the edges of a band after it.
  function columns(figure) {
    const series = [{ label: figure.x.label, value: (u, v) => reading(v, u.scales.x) }];
    const tables = [], bands = [];
    for (const curve of figure.series) {
      const value = (u, v) => reading(v, u.scales.y);
      const base = { label: curve.name, stroke: curve.color, value, pxAlign: 0, points: { show: false } };
      const dots = { show: true, size: 5, width: 0, fill: curve.color };
      tables.push([curve.x, ...curve.columns]);
      if (curve.style === "points") {
        series.push({ ...base, paths: () => null, points: dots });
      } else {
        series.push({ ...base, width: 1.75, dash: curve.style === "dashed" ? [7, 5] : undefined });
      }
      if (curve.style === "band") {
        const edge = { ...base, stroke: "transparent", tint: curve.color + "55" };
        bands.push({ series: [series.length + 1, series.length], fill: curve.color + "38" });
        const short = curve.name.split(/[:,]/)[0];
        series.push({ ...edge, label: `${short}, lower` });
        series.push({ ...edge, label: `${short}, upper` });
      }
    }
    return { series, bands, data: tables.length ? uPlot.join(tables) : [[]] };
  }

  // Returns the colour of a curve in the legend.
  const marker = (series) => series.tint ?? series.stroke();

  // Draws one plot into its element within a figure.
  function mount(figure, place) {
    const { series, bands, data } = columns(figure);
    const xs = data[0];
    const whole = xs.length ? [xs[0], xs[xs.length - 1]] : [0, 1];
    const size = () => ({
      width: place.clientWidth,
      height: Math.round(Math.max(280, Math.min(440, place.clientWidth * 0.48))),
    });
    const options = {
      ...size(), series, bands,
      scales: {
        x: { time: false, distr: figure.x.log ? 3 : 1, range: xRange(figure, whole) },
        y: { distr: figure.y.log ? 3 : 1, range: yRange(figure) },
      },
      axes: [axis(figure.x, false), axis(figure.y, true)],
      // The plots of one figure share the horizontal axis, the cursor and the zoom.
      cursor: { drag: { x: true, y: false }, points: { size: 7 }, sync: { key: place.closest("figure").id } },
      legend: { live: true, markers: { width: 0, fill: (u, i) => marker(u.series[i]) } },
      hooks: {
        drawClear: [(u) => drawSpans(u, figure)],
        draw: [(u) => drawMarks(u, figure)],
      },
    };
    const plot = new uPlot(options, data, place);
    new ResizeObserver(() => plot.setSize(size())).observe(place);
    // Arrow keys move the cursor from sample to sample; the legend, which is read out, has the values.
    place.querySelector(".u-legend")?.setAttribute("aria-live", "polite");
    place.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1, PageUp: -20, PageDown: 20 }[event.key];
      if (!step || !xs.length) return;
      event.preventDefault();
      const first = plot.valToIdx(plot.scales.x.min), last = plot.valToIdx(plot.scales.x.max);
      const next = Math.min(last, Math.max(first, (plot.cursor.idx ?? first) + step));
      plot.setCursor({ left: plot.valToPos(xs[next], "x"), top: plot.bbox.height / uPlot.pxRatio / 2 });
    });
    return plot;
  }

  const source = document.getElementById("figure-data");
  if (source) JSON.parse(source.textContent).forEach((figure) => mount(figure, document.getElementById("plot-" + figure.id)));
  // A page that loads its figures later calls this itself.
  globalThis.sonoglidePlot = mount;
})();
