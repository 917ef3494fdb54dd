// The chart of two quantities that the reader chose.

const plot = byId("plot");
const choice = { volume: null, scene: null, renderer: null, device: null };
const ALL = "*";

const axisOf = (which) => ({
  quantity: Number(byId(`${which}-axis`).value),
  log: byId(`${which}-log`).checked,
});

/** Cells of what is chosen but for `except`: what a choice offers depends on the others before it. */
function chosenCells(upTo = null) {
  const keys = Object.keys(choice);
  const used = upTo === null ? keys : keys.slice(0, keys.indexOf(upTo));
  const fits = (cell) => used.every((key) => choice[key] === ALL || cell[key] === choice[key]);
  return data.cells.map((_, at) => at).filter((at) => fits(data.cells[at]));
}

/** Fills the lists, first to last; what was chosen stays where it is still there. */
function fillChoices() {
  for (const key of Object.keys(choice)) {
    const list = byId(`choose-${key}`);
    const options = distinct(chosenCells(key).map((at) => data.cells[at][key]));
    const all = options.length > 1 && (key === "renderer" || key === "device") ? [ALL] : [];
    const offered = [...all, ...options];
    if (!offered.includes(choice[key])) choice[key] = offered[0];
    list.replaceChildren(...offered.map((name) => element("option", { value: name }, name === ALL ? "all" : name)));
    list.value = choice[key];
    const single = distinct(data.cells.map((cell) => cell[key])).length < 2;
    list.parentElement.hidden = single;
  }
}

/** Draws the chart anew. Returns the cells that have a mark. */
function drawChart() {
  const [x, y] = [axisOf("x"), axisOf("y")];
  const cells = chosenCells();
  const placed = cells.filter(
    (at) => hasPlace(value(at, x.quantity), x.log) && hasPlace(value(at, y.quantity), y.log),
  );
  const width = Math.max(300, Math.min(760, plot.parentElement.clientWidth || 600));
  const height = Math.round(Math.max(300, width * 0.62));
  const infinity = "identical";
  const scale = (axis) => range(placed.map((at) => value(at, axis.quantity)), axis.log, infinity);
  const [xs, ys] = [scale(x), scale(y)];
  const widest = Math.max(...ys.ticks.map((tick) => tick.text.length));
  const frame = { left: 34 + 7.6 * widest, right: width - 22, top: 14, bottom: height - 54 };
  const across = (share) => frame.left + share * (frame.right - frame.left);
  const up = (share) => frame.bottom - share * (frame.bottom - frame.top);

  plot.setAttribute("viewBox", `0 0 ${width} ${height}`);
  const names = [x, y].map((axis) => data.quantities[axis.quantity].name);
  plot.setAttribute("aria-label", `${names[1]} over ${names[0]}: ${placed.length} cells`);
  plot.replaceChildren(...axes(xs, ys, names, frame, across, up));
  const last = (at) => (data.cells[at].failed !== null ? 2 : data.marks[data.cells[at].mark].letter ? 1 : 0);
  const order = [...placed].sort((a, b) => last(a) - last(b) || a - b);
  for (const at of order) {
    const place = [across(xs.place(value(at, x.quantity))), up(ys.place(value(at, y.quantity)))];
    plot.append(point(at, place));
  }
  // One stop of the tab key; arrows go on from the left to the right.
  const points = Array.from(plot.querySelectorAll(".pt"));
  points.sort((a, b) => Number(a.dataset.x) - Number(b.dataset.x));
  roving(plot, points);
  drawLegend(placed);
  const lost = cells.filter((at) => !placed.includes(at));
  const failed = lost.filter((at) => data.cells[at].failed !== null).length;
  const { volume, ...rest } = choice;
  const view = [volume, ...distinct(Object.values(rest)).filter((name) => name && name !== ALL)].join(", ");
  byId("plot-note").textContent = lost.length
    ? `${view}: ${placed.length} cells; ${lost.length} more have no value on these axes${failed ? `, ${failed} of them failed` : ""}.`
    : `${view}: ${placed.length} cells.`;
  showChosen();
  return placed;
}

function axes(xs, ys, names, frame, across, up) {
  const parts = [];
  const line = (x1, y1, x2, y2, colour) =>
    drawn("line", { x1, y1, x2, y2, stroke: `var(--${colour})`, "shape-rendering": "crispEdges" });
  let free = Infinity;
  for (const tick of [...xs.ticks].reverse()) {
    const at = across(tick.at);
    parts.push(line(at, frame.top, at, frame.bottom, "grid"));
    // A label that would touch the one to its right is left out; the last, which may be a word, always stands.
    const half = 3.9 * tick.text.length + 5;
    const middle = Math.min(at, frame.right + 20 - half);
    if (middle + half > free) continue;
    free = middle - half;
    parts.push(drawn("text", { x: middle, y: frame.bottom + 22, class: "tick", "text-anchor": "middle" }, tick.text));
  }
  for (const tick of ys.ticks) {
    const at = up(tick.at);
    parts.push(line(frame.left, at, frame.right, at, "grid"));
    parts.push(drawn("text", { x: frame.left - 8, y: at + 4.5, class: "tick", "text-anchor": "end" }, tick.text));
  }
  parts.push(line(frame.left, frame.top, frame.left, frame.bottom, "axis"));
  parts.push(line(frame.left, frame.bottom, frame.right, frame.bottom, "axis"));
  const middle = (frame.left + frame.right) / 2;
  parts.push(drawn("text", { x: middle, y: frame.bottom + 45, class: "label", "text-anchor": "middle" }, names[0]));
  const half = (frame.top + frame.bottom) / 2;
  const turned = { transform: `translate(15,${half}) rotate(-90)`, class: "label", "text-anchor": "middle" };
  parts.push(drawn("text", turned, names[1]));
  return parts;
}

function point(at, [x, y]) {
  const cell = data.cells[at];
  const group = drawn("g", {
    class: "pt",
    transform: `translate(${x.toFixed(2)},${y.toFixed(2)})`,
    role: "button",
    "aria-label": `${cell.name}${cell.failed !== null ? ", failed" : ""}`,
    "data-cell": at,
    "data-x": x,
  });
  group.append(drawn("circle", { r: 11, class: "halo" }), ...mark(data.marks[cell.mark]));
  return group;
}

function mark({ d, fill, stroke, width, letter }) {
  const path = drawn("path", { d, fill, stroke, "stroke-width": width });
  if (!letter) return [path];
  const text = { y: 4.2, "font-size": 12, "font-weight": "bold", "text-anchor": "middle", fill: stroke };
  return [path, drawn("text", text, letter)];
}

function drawLegend(placed) {
  const entries = new Map();
  for (const at of placed) {
    const cell = data.cells[at];
    const entry = data.marks[cell.mark];
    if (!entries.has(entry.label) || cell.filled) entries.set(entry.label, entry);
  }
  const both = distinct(placed.map((at) => data.cells[at].filled)).length > 1;
  const lines = [...entries.values(), ...(both ? data.filters : [])];
  byId("plot-legend").replaceChildren(
    ...lines.map((entry) => element(
      "li",
      {},
      drawn("svg", { class: "mark", viewBox: "-10 -10 20 20", "aria-hidden": "true" }, ...mark(entry)),
      entry.label,
    )),
  );
}

/** Makes a group of elements one stop of the tab key, with arrow keys, Home and End within. */
function roving(group, items) {
  items.forEach((item, at) => item.setAttribute("tabindex", at === 0 ? 0 : -1));
  group.onkeydown = (event) => {
    const at = items.indexOf(event.target.closest("[data-cell]"));
    const steps = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1, Home: -items.length, End: items.length };
    if (at < 0 || !(event.key in steps)) return;
    event.preventDefault();
    const next = items[Math.max(0, Math.min(items.length - 1, at + steps[event.key]))];
    items[at].setAttribute("tabindex", -1);
    next.setAttribute("tabindex", 0);
    next.focus();
  };
}

