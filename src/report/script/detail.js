// What the reader points at: the cell, its figures, and the command that runs it again.

let shown = null;

function showDetail(at) {
  shown = at;
  const cell = data.cells[at];
  const place = [figure(at, "site"), figure(at, "filter"), cell.renderer, cell.scene, cell.device].filter(Boolean);
  const parts = [
    element("p", { class: "cell-name", title: cell.full }, element("b", {}, figure(at, "codec")), ` ${settingsOf(at)}`),
    element("p", { class: "place" }, `${cell.volume}: ${place.join(", ")}`),
  ];
  if (cell.failed !== null) parts.push(element("p", { class: "why" }, `Failed: ${cell.failed}`));
  const axes = ["x", "y"].map((which) => data.quantities[axisOf(which).quantity].field);
  const fields = distinct([...axes, ...columns.filter((c) => c.main).map((c) => c.field)]);
  parts.push(figures([at], fields));
  const others = sharing(at);
  if (others.length) {
    parts.push(element("p", { class: "repeat" }, "at the same place (click to choose):"));
    const items = others.map((other) => element(
      "li",
      { "data-cell": other, role: "button", tabindex: 0 },
      data.cells[other].name,
    ));
    parts.push(element("ul", { class: "twins" }, ...items));
  }
  if (cell.command !== null) {
    parts.push(element("p", { class: "repeat" }, "runs this cell alone:"));
    parts.push(element("pre", { class: "command" }, cell.command));
  }
  byId("detail").replaceChildren(...parts);
}

/** The settings that differ among the cells of the codec; all of them stand in titles. */
function settingsOf(at) {
  const settings = figure(at, "settings");
  return settings === "–" ? "" : settings;
}

/** Other cells whose marks lie where this one's does: sites that draw the same picture from the same file. */
function sharing(at) {
  const points = Array.from(plot.querySelectorAll(".pt"));
  const own = points.find((pt) => pt.dataset.cell === String(at));
  const there = points.filter((pt) => own && pt !== own && pt.getAttribute("transform") === own.getAttribute("transform"));
  return there.map((pt) => Number(pt.dataset.cell)).sort((a, b) => a - b);
}

/** A table of figures: one column per cell, one line per field that any of them has. */
function figures(cells, fields, heads = []) {
  const body = element("tbody");
  for (const field of fields) {
    const texts = cells.map((at) => figure(at, field));
    const column = columns.find((c) => c.field === field);
    if (!column || texts.every((text) => text === "–")) continue;
    const numbers = texts.map((text) => element("td", { class: "n" }, text));
    body.append(element("tr", {}, element("th", { scope: "row" }, column.heading), ...numbers));
  }
  const made = element("table", { class: "figures" });
  if (heads.length) {
    const names = ["", ...heads].map((name) => element("th", { scope: "col", class: name ? "n" : null }, name));
    made.append(element("thead", {}, element("tr", {}, ...names)));
  }
  made.append(body);
  return made;
}

