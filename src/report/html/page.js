// The data, and how text and numbers get onto the page. Scripts share one scope, in the order report/page.rs lists them.

const data = JSON.parse(document.getElementById("data").textContent);
const report = data.report;
const byId = (id) => document.getElementById(id);

/** A new element with attributes and children; strings become text, never markup. */
function element(name, attributes = {}, ...children) {
  return filled(document.createElement(name), attributes, children);
}

/** The same for a drawing. */
function drawn(name, attributes = {}, ...children) {
  return filled(document.createElementNS("http://www.w3.org/2000/svg", name), attributes, children);
}

function filled(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== undefined && value !== null) node.setAttribute(name, value);
  }
  node.append(...children);
  return node;
}

/** Fills a select with [value, text] pairs. */
function options(select, pairs) {
  select.replaceChildren(...pairs.map(([value, text]) => element("option", { value }, text)));
}

/** Three significant digits, as the sentences have them; a dash for what was not measured. */
function digits(value) {
  if (value === null || value === undefined) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-4 || size >= 1e5) return value.toExponential(2);
  return value.toFixed(Math.max(0, 2 - Math.floor(Math.log10(size))));
}

const milliseconds = (timing) => (timing ? `${digits(timing.median)} ms` : "–");
const referenceWords = { bvh: "triangles (true error)", voxel: "voxels (sampling and filter)" };

/** All of a row's identity but scene and reference, as Row::configuration in report/row.rs. */
function configuration(row) {
  return `${row.tracer} + ${row.denoiser} + ${row.upsampler}, ${row.spp} spp${details(row)}`;
}

/** The configuration but for its samples: one curve. */
function curveOf(row) {
  return `${row.tracer} + ${row.denoiser} + ${row.upsampler}${details(row)}`;
}

function details(row) {
  const knobs = Object.entries(row.knobs).map(([knob, value]) => `, ${knob}=${value}`);
  return (row.grid === null ? "" : `, grid ${row.grid}`) + knobs.join("");
}

/** Rows that no other beats in both time and error; fastest first. */
function paretoFront(rows, time, error) {
  let best = Infinity;
  return [...rows]
    .sort((a, b) => time(a) - time(b) || error(a) - error(b))
    .filter((row) => error(row) < best && ((best = error(row)), true));
}

/** Which references rows were measured against, the true one first. */
const referencesMeasured = ["bvh", "voxel"].filter((kind) => report.rows.some((row) => row.reference === kind));
