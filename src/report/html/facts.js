// The head of the page, the answers, and how it was measured.

byId("scene").textContent = report.scene;
byId("setting").textContent =
  `${report.adapter} · traced at ${report.trace_size.join("×")}, shown at ${report.display_size.join("×")} · ` +
  `${report.rows.length} rows`;

const sentences = data.sentences.length ? data.sentences : ["The rows hold no times or errors to compare."];
byId("answers").replaceChildren(...sentences.map((sentence) => element("li", {}, ...emphasized(sentence))));

/** Ratios and percentages stand out. */
function emphasized(sentence) {
  return sentence
    .split(/([\d.]+(?:e-?\d+)? (?:times|%))/)
    .map((part, i) => (i % 2 ? element("strong", {}, part) : part));
}

const references = report.references.map((info) => {
  const words = [`${info.spp} samples per pixel`];
  if (info.grid !== null) words.push(`grid ${info.grid}`);
  if (info.noise_rel_mse !== null) words.push(`its own noise is relMSE ${digits(info.noise_rel_mse)}`);
  if (info.gap_rmse !== null) words.push(`RMSE ${digits(info.gap_rmse)} from triangles`);
  return element("li", {}, `Reference ${info.kind}: ${words.join(", ")}.`);
});
byId("about").replaceChildren(
  element(
    "ul",
    {},
    element("li", {}, "Times are medians of whole frames on the adapter; ± is half the distance between the quartiles."),
    element("li", {}, "relMSE is the mean of (x − r)² / (r² + 0.01) over linear radiance."),
    element(
      "li",
      {},
      "Error against triangles is the true one. Error against voxels leaves out what voxels cost; " +
        "the gap between the two is the price of voxels.",
    ),
    ...references,
  ),
  ...report.commands.map((command) => element("pre", {}, command)),
);
