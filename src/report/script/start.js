// Where the reader's hands meet the parts above.

function start() {
  const options = data.quantities.map((quantity, at) => {
    const measured = data.cells.some((_, cell) => value(cell, at) !== null);
    return measured ? element("option", { value: at }, quantity.name) : null;
  }).filter(Boolean);
  for (const which of ["x", "y"]) {
    byId(`${which}-axis`).append(...options.map((option) => option.cloneNode(true)));
  }
  byId("x-axis").value = String(quantityOf("bits_per_voxel"));
  byId("y-axis").value = String(quantityOf("image_psnr_db"));
  if (options.length === 0) return;
  for (const which of ["x", "y"]) {
    if (byId(`${which}-axis`).selectedIndex < 0) byId(`${which}-axis`).selectedIndex = 0;
  }
  byId("x-log").checked = wide(axisOf("x").quantity);
  byId("explore").hidden = false;

  for (const key of Object.keys(choice)) {
    byId(`choose-${key}`).addEventListener("change", (event) => {
      choice[key] = event.target.value;
      fillChoices();
      drawChart();
    });
  }
  for (const id of ["x-axis", "y-axis", "x-log", "y-log"]) byId(id).addEventListener("change", drawChart);
  let width = 0;
  new ResizeObserver(([entry]) => {
    // Height follows from width, so that only width counts.
    if (Math.round(entry.contentRect.width) === width) return;
    width = Math.round(entry.contentRect.width);
    if (!plot.contains(document.activeElement)) drawChart();
  }).observe(plot.parentElement);

  const cellOf = (target) => (target.closest ? target.closest("[data-cell]") : null);
  for (const kind of ["pointerover", "focusin"]) {
    plot.addEventListener(kind, (event) => {
      const found = cellOf(event.target);
      if (found) showDetail(Number(found.dataset.cell));
    });
  }
  document.addEventListener("click", (event) => {
    const found = cellOf(event.target);
    // Whoever marks text in the table does not choose its row.
    if (found && !String(getSelection())) choosePlace(found);
  });
  document.addEventListener("keydown", (event) => {
    const found = cellOf(event.target);
    if (!found || (event.key !== "Enter" && event.key !== " ")) return;
    event.preventDefault();
    choosePlace(found);
  });
  if (table) roving(table.tBodies[0], rows);
  byId("chosen-clear").addEventListener("click", clearPair);
  byId("compare-close").addEventListener("click", clearPair);
  byId("slider").addEventListener("input", showPictures);
  for (const side of ["left", "right"]) byId(`${side}-picture`).addEventListener("change", showPictures);
  for (const kind of ["pointerdown", "pointermove"]) byId("stage").addEventListener(kind, slide);

  fillChoices();
  drawChart();
}

/** Whether values span more than a decade, so that a logarithm shows more. */
function wide(quantity) {
  const values = data.cells.map((_, at) => value(at, quantity)).filter((v) => v > 0 && v < Infinity);
  return values.length > 0 && Math.max(...values) > 10 * Math.min(...values);
}

function choosePlace(place) {
  choose(Number(place.dataset.cell));
  if (pair.length === 2 && !byId("explore").contains(place)) byId("compare").scrollIntoView({ block: "nearest" });
}

start();
if (location.hash === "#selftest") addEventListener("load", selftest);
