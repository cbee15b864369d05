// Error against time: one curve per configuration over its sample counts, the Pareto front, a tooltip per point.

const METRICS = [
  { id: "rel_mse", name: "relMSE", log: true },
  { id: "rmse", name: "RMSE", log: true },
  { id: "smape", name: "SMAPE", log: true },
  { id: "hdr_flip", name: "HDR-FLIP", log: true },
  { id: "flip", name: "FLIP", log: true },
  { id: "temporal", name: "temporal error", log: true },
  { id: "psnr", name: "PSNR, dB", better: "higher" },
  { id: "ssim", name: "SSIM", better: "higher" },
];
const metricsMeasured = METRICS.filter(({ id }) => report.rows.some((row) => row[id] !== null));

// Colour tells the denoiser, shape the tracer. What is unfiltered comes first: the grey one.
const plainFirst = (a, b) => (b === "identity") - (a === "identity") || a.localeCompare(b);
const denoisers = [...new Set(report.rows.map((row) => row.denoiser))].sort(plainFirst);
const tracers = [...new Set(report.rows.map((row) => row.tracer))].sort().reverse();
const COLORS = 10;
const colorOf = (row) => `color-${denoisers.indexOf(row.denoiser) % COLORS}`;
const SHAPES = [
  (r) => `M${-r},0a${r},${r} 0 1,0 ${2 * r},0a${r},${r} 0 1,0 ${-2 * r},0z`,
  (r) => `M${-r},${-r}h${2 * r}v${2 * r}h${-2 * r}z`,
  (r) => `M0,${-1.3 * r}L${1.2 * r},${0.9 * r}H${-1.2 * r}z`,
  (r) => `M0,${-1.4 * r}L${1.4 * r},0L0,${1.4 * r}L${-1.4 * r},0z`,
];
const shapeOf = (tracer, r) => SHAPES[tracers.indexOf(tracer) % SHAPES.length](r);
const hidden = new Set();

options(byId("metric"), metricsMeasured.map(({ id, name }) => [id, name]));
options(byId("reference"), referencesMeasured.map((kind) => [kind, referenceWords[kind]]));
for (const id of ["metric", "reference"]) byId(id).addEventListener("change", drawCurves);
let drawnWidth = 0;
// A frame later, and only for another width: drawing changes the height, which must not call for drawing again.
new ResizeObserver(() => requestAnimationFrame(() => byId("chart").clientWidth !== drawnWidth && drawCurves())).observe(byId("chart"));

function drawCurves() {
  const metric = metricsMeasured.find(({ id }) => id === byId("metric").value);
  const time = (row) => row.total_ms?.median;
  const error = (row) => row[metric.id];
  const fits = (value, log) => Number.isFinite(value) && (!log || value > 0);
  const timed = metric
    ? report.rows.filter((row) => row.reference === byId("reference").value && fits(time(row), true) && fits(error(row), metric.log))
    : [];
  drawnWidth = byId("chart").clientWidth;
  drawLegend(timed);
  const rows = timed.filter((row) => !hidden.has(row.denoiser) && !hidden.has(row.tracer));
  if (!rows.length) {
    byId("chart").replaceChildren(element("p", { class: "note" }, "No row here has both a time and this error."));
    return;
  }
  const width = Math.max(280, byId("chart").clientWidth), height = Math.min(460, Math.max(300, width * 0.5));
  const box = { left: 54, right: width - 14, top: 28, bottom: height - 44 };
  const x = scaleOf(rows.map(time), [box.left, box.right], true);
  const y = scaleOf(rows.map(error), [box.bottom, box.top], metric.log);
  const at = (row) => [x.at(time(row)), y.at(error(row))];
  const better = metric.better === "higher" ? "higher is better" : "lower is better";
  const svg = drawn("svg", { viewBox: `0 0 ${width} ${height}`, width, height, role: "group", "aria-label": `${metric.name} against time` });
  svg.append(axes(x, y, box, { x: "ms a frame", y: `${metric.name}, ${better}` }));
  const front = paretoFront(rows, time, (row) => (metric.better === "higher" ? -error(row) : error(row)));
  svg.append(drawn("path", { class: "front", d: steps(front.map(at), box) }));
  for (const curve of Map.groupBy(rows, curveOf).values()) {
    const points = curve.sort((a, b) => time(a) - time(b)).map(at);
    const dash = tracers.indexOf(curve[0].tracer) % SHAPES.length;
    svg.append(drawn("path", { class: `curve ${colorOf(curve[0])} dash-${dash}`, d: "M" + points.map((p) => p.map((v) => v.toFixed(1))).join("L") }));
  }
  for (const row of rows) svg.append(point(row, at(row), metric, front.includes(row)));
  byId("chart").replaceChildren(svg);
}

/** Along the front: right at one error, then down to the next. */
function steps(points, box) {
  const [[x, y], ...others] = points;
  return `M${x.toFixed(1)},${y.toFixed(1)}` + others.map(([a, b]) => `H${a.toFixed(1)}V${b.toFixed(1)}`).join("") + `H${box.right}`;
}

function point(row, [x, y], metric, onFront) {
  const words = `${configuration(row)}: ${milliseconds(row.total_ms)}, ${metric.name} ${digits(row[metric.id])}`;
  const mark = drawn(
    "g",
    { class: `point ${colorOf(row)}${onFront ? " on-front" : ""}`, transform: `translate(${x.toFixed(1)},${y.toFixed(1)})`, tabindex: 0, role: "button", "aria-label": words },
    // Large enough for a finger.
    drawn("circle", { r: 13, class: "reach" }),
    drawn("path", { d: shapeOf(row.tracer, 4.5) }),
  );
  const show = () => showTip(mark, row);
  mark.addEventListener("pointerenter", show);
  mark.addEventListener("focus", show);
  for (const leave of ["pointerleave", "blur"]) mark.addEventListener(leave, () => (byId("tip").hidden = true));
  mark.addEventListener("click", () => showPicture(row));
  mark.addEventListener("keydown", (event) => event.key === "Enter" && showPicture(row));
  return mark;
}

function showTip(mark, row) {
  const tip = byId("tip");
  const line = (name, value) => (value ? [element("dt", {}, name), element("dd", {}, value)] : []);
  const stages = Object.entries(row.stages_ms).filter(([, timing]) => timing && timing.median > 0);
  tip.replaceChildren(
    element("b", {}, configuration(row)),
    ...(row.equal_time ? [element("p", {}, `in the time of ${row.equal_time}`)] : []),
    element(
      "dl",
      {},
      ...line("time", `${milliseconds(row.total_ms)} ± ${digits(0.5 * row.total_ms.spread)}`),
      ...stages.flatMap(([stage, timing]) => line(`· ${stage}`, milliseconds(timing))),
      ...metricsMeasured.filter(({ id }) => row[id] !== null).slice(0, 6).flatMap(({ id, name }) => line(name, digits(row[id]))),
      ...line("memory", row.bytes === null ? null : `${digits(row.bytes / 1e6)} MB`),
    ),
  );
  tip.hidden = false;
  const place = mark.getBoundingClientRect(), size = tip.getBoundingClientRect();
  const { clientWidth, clientHeight } = document.documentElement;
  // Beside the point, on the side that has room; on a phone, over what is left.
  const left = place.right + 4 + size.width < clientWidth ? place.right + 4 : place.left - 4 - size.width;
  tip.style.left = `${Math.max(6, left)}px`;
  tip.style.top = `${Math.max(6, Math.min(place.top - size.height / 3, clientHeight - size.height - 6))}px`;
}

/** Denoisers by colour, tracers by shape; a press hides or shows. */
function drawLegend(rows) {
  const sample = (attributes, shape) =>
    drawn("svg", { viewBox: "-8 -8 16 16", width: 16, height: 16, "aria-hidden": "true" }, drawn("path", { ...attributes, d: shape }));
  const entry = (name, mark) => {
    const button = element("button", { type: "button", "aria-pressed": String(!hidden.has(name)) }, mark, name);
    button.addEventListener("click", () => {
      if (!hidden.delete(name)) hidden.add(name);
      drawCurves();
    });
    return element("li", {}, button);
  };
  const has = (key) => (name) => rows.some((row) => row[key] === name);
  byId("legend").replaceChildren(
    ...denoisers.filter(has("denoiser")).map((name) => entry(name, sample({ class: `swatch ${colorOf({ denoiser: name })}` }, "M-7,-2.5h14v5h-14z"))),
    ...tracers.filter(has("tracer")).map((name) => entry(name, sample({ class: "shape" }, shapeOf(name, 4.5)))),
  );
}
