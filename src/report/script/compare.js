// Two cells that the reader chose, A and B: both pictures under a slider, and their figures side by side.

let pair = [];

/** Pictures of a cell: what was drawn, where it is wrong, and the original; those that there are. */
function pictures(at) {
  const card = document.querySelector(`[data-picture="${at}"]`);
  const source = (found) => (found ? found.getAttribute("src") : null);
  return {
    drawn: source(card && card.querySelector("img.drawn")),
    error: source(card && card.querySelector("img.error")),
    original: source(card && card.closest(".group").querySelector(".original img")),
  };
}

/** Chooses a cell, or takes the choice back; a third cell takes the place of the second. */
function choose(at) {
  if (pair.includes(at)) pair = pair.filter((other) => other !== at);
  else pair = pair.length < 2 ? [...pair, at] : [pair[0], at];
  showChosen();
  showPair();
}

function clearPair() {
  pair = [];
  showChosen();
  showPair();
}

/** Marks the chosen cells wherever they stand. */
function showChosen() {
  for (const marked of document.querySelectorAll("[data-chosen]")) marked.removeAttribute("data-chosen");
  pair.forEach((at, i) => {
    for (const place of document.querySelectorAll(`[data-cell="${at}"]`)) place.setAttribute("data-chosen", "AB"[i]);
  });
  const waiting = pair.length === 1;
  byId("chosen").hidden = !waiting;
  if (waiting) byId("chosen-text").textContent = `A: ${data.cells[pair[0]].name}. Choose another cell to compare it with.`;
}

function showPair() {
  const panel = byId("compare");
  panel.hidden = pair.length < 2;
  if (panel.hidden) return;
  const [a, b] = pair.map(pictures);
  const same = a.original === b.original;
  const options = [
    ["A: picture", a.drawn], ["A: error", a.error], ["B: picture", b.drawn], ["B: error", b.error],
    [same ? "original" : "original of A", a.original], ...(same ? [] : [["original of B", b.original]]),
  ].filter(([, source]) => source !== null);
  const found = (name) => Math.max(0, options.findIndex(([other]) => other === name));
  for (const [side, first] of [["left", "A: picture"], ["right", "B: picture"]]) {
    const list = byId(`${side}-picture`);
    list.replaceChildren(...options.map(([name, source]) => element("option", { value: source }, name)));
    list.selectedIndex = found(first);
  }
  byId("compared").hidden = options.length === 0;
  const names = pair.map((at, i) => {
    const { name, full, volume, scene, renderer } = data.cells[at];
    return element("p", { title: full }, element("b", {}, "AB"[i]), ` ${name} `, element("span", { class: "place" }, `${volume}, ${scene}, ${renderer}`));
  });
  byId("compare-names").replaceChildren(...names);
  const fields = columns.filter((c) => c.main).map((c) => c.field);
  byId("compare-figures").replaceChildren(figures(pair, fields, ["A", "B"]));
  byId("slider").value = 50;
  showPictures();
}

/** The two pictures that the lists name, cut where the slider stands. */
function showPictures() {
  const share = byId("slider").value;
  for (const side of ["left", "right"]) {
    const [image, list] = [byId(`${side}-image`), byId(`${side}-picture`)];
    const option = list.selectedOptions[0];
    if (!option) continue;
    if (image.getAttribute("src") !== option.value) image.src = option.value;
    image.alt = option.textContent;
    byId(`${side}-label`).textContent = option.textContent;
  }
  byId("left-image").style.clipPath = `inset(0 ${100 - share}% 0 0)`;
  byId("cut").style.left = `${share}%`;
}

/** The slider follows a pointer on the pictures too. */
function slide(event) {
  if (event.buttons === 0 && event.type !== "pointerdown") return;
  const box = byId("stage").getBoundingClientRect();
  byId("slider").value = (100 * (event.clientX - box.left)) / box.width;
  showPictures();
}

