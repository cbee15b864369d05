// The small tables of what was measured beside whole frames: structures alone, and what voxels get wrong.

byId("measured").replaceChildren(
  ...data.tables.map((table) =>
    element(
      "section",
      { "aria-label": table.title },
      element("h2", {}, table.title),
      element("p", { class: "note" }, table.sentence),
      element(
        "div",
        { class: "scroll", tabindex: 0, role: "region", "aria-label": table.title },
        element(
          "table",
          { class: "small" },
          element("thead", {}, element("tr", {}, ...table.head.map((name) => element("th", { scope: "col" }, name)))),
          element("tbody", {}, ...table.rows.map(measuredRow)),
        ),
      ),
    ),
  ),
);

function measuredRow([name, ...numbers]) {
  return element("tr", {}, element("td", {}, name), ...numbers.map((text) => element("td", { class: "number" }, text)));
}
