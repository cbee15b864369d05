// Every row, sorted by any column; a press on a row opens its picture on side B.

const share = (row) => (row.reference === "bvh" ? prices.get(configuration(row)) : undefined) ?? null;
const prices = new Map(report.answers.prices.map((price) => [price.configuration, price.share]));
const onFront = new Set(report.answers.pareto.map((point) => point.configuration));

// `value` sorts, `show` is what is read; numbers start with the smallest, or the best.
const COLUMNS = [
  { name: "tracer", value: (row) => row.tracer },
  { name: "denoiser", value: (row) => row.denoiser },
  { name: "upsampler", value: (row) => row.upsampler },
  { name: "spp", value: (row) => row.spp },
  { name: "grid", value: (row) => row.grid, show: (row) => (row.grid === null ? "–" : String(row.grid)) },
  { name: "knobs", value: (row) => knobsOf(row) || null, show: knobsOf },
  { name: "against", value: (row) => row.reference },
  { name: "ms", value: (row) => row.total_ms?.median ?? null, show: (row) => timeOf(row.total_ms), title: "median of whole frames ± half the distance between quartiles" },
  { name: "stages", value: (row) => row.stages_ms.trace?.median ?? null, show: stagesOf, title: "where the time goes; sorts by tracing" },
  ...METRICS.filter((metric) => metricsMeasured.includes(metric)).map(({ id, name, better }) => ({ name, value: (row) => row[id], show: (row) => digits(row[id]), down: better === "higher" })),
  { name: "bias", value: (row) => (row.bias ? Math.max(...row.bias.map((b) => Math.abs(b - 1))) : null), show: (row) => (row.bias ? row.bias.map((b) => b.toFixed(3)).join(" ") : "–"), title: "mean over the reference's mean: red, green, blue; sorts by the worst" },
  { name: "voxels cost", value: share, show: (row) => (share(row) === null ? "–" : `${(share(row) * 100).toFixed(0)} %`), title: "share of the squared error that is the gap between voxels and triangles" },
  { name: "NaN", value: (row) => row.nan_count, show: (row) => (row.nan_count === null ? "–" : String(row.nan_count)) },
  { name: "MB", value: (row) => row.bytes, show: (row) => (row.bytes === null ? "–" : digits(row.bytes / 1e6)) },
].filter(({ value }) => report.rows.some((row) => value(row) !== null));

const sorting = { column: COLUMNS.find(({ name }) => name === "ms") ?? COLUMNS[0], down: false };

function knobsOf(row) {
  const equal = row.equal_time ? ["equal time"] : [];
  return [...Object.entries(row.knobs).map(([knob, value]) => `${knob}=${value}`), ...equal].join(" ");
}

function timeOf(timing) {
  return timing ? `${digits(timing.median)} ± ${digits(0.5 * timing.spread)}` : "–";
}

/** A bar whose parts are the stages' shares. */
function stagesOf(row) {
  const stages = Object.entries(row.stages_ms).filter(([, timing]) => timing && timing.median > 0);
  const words = stages.map(([stage, timing]) => `${stage} ${milliseconds(timing)}`).join(", ");
  return element("span", { class: "bar", role: "img", "aria-label": words, title: words },
    ...stages.map(([stage, timing]) => element("span", { class: `stage-${stage}`, style: `flex-grow: ${timing.median}` })));
}

const stagesMeasured = Object.keys(report.rows[0]?.stages_ms ?? {}).filter((stage) => report.rows.some((row) => row.stages_ms[stage]?.median > 0));
byId("stages").replaceChildren(...stagesMeasured.map((stage) => element("li", {}, element("span", { class: `stage-${stage}` }), stage)));

const headers = COLUMNS.map((column) => {
  const button = element("button", { type: "button", title: column.title }, column.name);
  button.addEventListener("click", () => {
    sorting.down = sorting.column === column ? !sorting.down : Boolean(column.down);
    sorting.column = column;
    drawTable();
  });
  return element("th", { scope: "col" }, button);
});
byId("rows").tHead.replaceChildren(element("tr", {}, ...headers));

options(byId("table-reference"), [["", "both references"], ...referencesMeasured.map((kind) => [kind, referenceWords[kind]])]);
byId("table-reference").value = referencesMeasured[0] ?? "";
byId("table-reference").addEventListener("change", drawTable);
byId("filter").addEventListener("input", drawTable);

function drawTable() {
  const { column, down } = sorting;
  const reference = byId("table-reference").value;
  const words = byId("filter").value.toLowerCase().split(/\s+/).filter(Boolean);
  const rows = report.rows
    .filter((row) => !reference || row.reference === reference)
    .filter((row) => words.every((word) => configuration(row).toLowerCase().includes(word)));
  rows.sort((a, b) => {
    const [x, y] = [column.value(a), column.value(b)];
    // What was not measured stays at the end, whichever way.
    if (x === null || y === null) return (x === null) - (y === null);
    return (typeof x === "string" ? x.localeCompare(y) : x - y) * (down ? -1 : 1);
  });
  headers.forEach((th, i) => {
    const sorted = COLUMNS[i] === column ? (down ? "descending" : "ascending") : "none";
    th.setAttribute("aria-sort", sorted);
  });
  byId("rows").tBodies[0].replaceChildren(...rows.map(line));
  byId("count").textContent = `${rows.length} of ${report.rows.length} rows; a dot marks the Pareto front of relMSE against time.`;
}

function line(row) {
  const cells = COLUMNS.map(({ value, show }) => {
    const content = show ? show(row) : String(value(row));
    return element("td", { class: typeof value(row) === "number" ? "number" : null }, content);
  });
  const tr = element("tr", { class: onFront.has(configuration(row)) ? "on-front" : null }, ...cells);
  if (pictureOfRow(row)) {
    tr.tabIndex = 0;
    tr.addEventListener("click", () => showPicture(row));
    tr.addEventListener("keydown", (event) => event.key === "Enter" && showPicture(row));
  }
  return tr;
}

drawTable();
