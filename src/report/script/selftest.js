// report.html#selftest: the page uses itself as a reader would, and writes down what went wrong.

const problems = [];
if (location.hash === "#selftest") {
  addEventListener("error", (event) => problems.push(`error: ${event.message}`));
  addEventListener("securitypolicyviolation", (event) => problems.push(`refused by policy: ${event.violatedDirective}`));
}

function selftest() {
  let checks = 0;
  const check = (holds, what) => {
    checks += 1;
    if (!holds) problems.push(what);
  };
  const change = (id, set) => {
    set(byId(id));
    byId(id).dispatchEvent(new Event("change", { bubbles: true }));
  };
  const press = (target, key) => target.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
  try {
    check(!byId("explore").hidden, "the chart is hidden");
    testAxes(check, change);
    testPair(check, change, press);
    check(document.documentElement.scrollWidth <= innerWidth, "the page is wider than the window");
  } catch (error) {
    problems.push(`stopped: ${error.message}`);
  }
  const result = problems.length ? `FAILED: ${problems.join("; ")}` : `passed: ${checks} checks`;
  document.body.append(element("pre", { id: "selftest", hidden: "" }, result));
}

/** Every choice, every quantity, both scales: each cell with a place has one mark, and no label touches another. */
function testAxes(check, change) {
  const texts = () => Array.from(plot.querySelectorAll("text.tick, text.label"), (t) => [t.textContent, t.getBoundingClientRect()]);
  const touch = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
  const look = (what) => {
    const [x, y] = [axisOf("x"), axisOf("y")];
    const has = (at, axis) => hasPlace(value(at, axis.quantity), axis.log);
    const expected = chosenCells().filter((at) => has(at, x) && has(at, y));
    const marks = Array.from(plot.querySelectorAll(".pt"), (pt) => pt.getAttribute("transform"));
    check(marks.length === expected.length, `${what}: ${marks.length} marks for ${expected.length} cells`);
    check(marks.every((place) => !/NaN|Infinity/.test(place)), `${what}: a mark has no place`);
    const all = texts();
    all.forEach(([text, box], i) => all.slice(i + 1).forEach(([other, second]) => {
      if (touch(box, second)) check(false, `${what}: "${text}" touches "${other}"`);
    }));
  };
  for (const key of Object.keys(choice)) {
    for (const option of Array.from(byId(`choose-${key}`).options, (o) => o.value)) {
      change(`choose-${key}`, (list) => { list.value = option; });
      look(option);
    }
  }
  const first = ["x-axis", "y-axis"].map((id) => byId(id).selectedIndex);
  const logs = ["x-log", "y-log"].map((id) => byId(id).checked);
  for (const log of [false, true]) {
    for (const which of ["x", "y"]) change(`${which}-log`, (box) => { box.checked = log; });
    for (let at = 0; at < byId("x-axis").options.length; at += 1) {
      for (const which of ["x", "y"]) change(`${which}-axis`, (list) => { list.selectedIndex = at; });
      look(`${byId("x-axis").selectedOptions[0].textContent}${log ? ", logarithmic" : ""}`);
    }
  }
  ["x", "y"].forEach((which, i) => {
    change(`${which}-axis`, (list) => { list.selectedIndex = first[i]; });
    change(`${which}-log`, (box) => { box.checked = logs[i]; });
  });
}

/** Pointing, keys, choosing two points and two rows, the slider and every picture. */
function testPair(check, change, press) {
  const points = () => Array.from(plot.querySelectorAll(".pt"));
  if (points().length < 2) return;
  const pointed = points()[points().length - 1];
  pointed.dispatchEvent(new PointerEvent("pointerover", { bubbles: true }));
  const at = Number(pointed.dataset.cell);
  const { name, command } = data.cells[at];
  check(name.startsWith(figure(at, "codec")), "figures stand in another row");
  check(byId("detail").textContent.includes(settingsOf(at)), "pointing shows no settings");
  if (command) check(byId("detail").textContent.includes(command), "pointing shows no command");

  const start = plot.querySelector('.pt[tabindex="0"]');
  start.focus();
  press(start, "ArrowRight");
  const second = document.activeElement;
  check(second !== start && plot.contains(second), "the arrow key leads nowhere");
  check(shown === Number(second.dataset.cell), "focus shows no cell");
  press(start, "Enter");
  check(!byId("chosen").hidden && byId("compare").hidden, "one cell is a comparison");
  press(second, "Enter");
  check(!byId("compare").hidden, "two cells are no comparison");
  check(byId("compare-figures").querySelectorAll("tbody tr").length > 2, "the comparison has no figures");
  clearPair();
  check(byId("compare").hidden, "the comparison does not close");
  rows[0].click();
  rows[rows.length - 1].click();
  check(!byId("compare").hidden && rows[0].dataset.chosen === "A", "two rows are no comparison");

  byId("slider").value = 25;
  byId("slider").dispatchEvent(new Event("input", { bubbles: true }));
  check(byId("left-image").style.clipPath.includes("75%"), "the slider cuts nothing");
  for (let i = 0; i < byId("left-picture").options.length; i += 1) {
    change("left-picture", (list) => { list.selectedIndex = i; });
    const source = byId("left-image").getAttribute("src");
    const shownAbove = Array.from(document.querySelectorAll(".group img")).find((img) => img.getAttribute("src") === source);
    check(shownAbove && shownAbove.naturalWidth > 0, `no picture: ${byId("left-label").textContent}`);
  }
  change("left-picture", (list) => { list.selectedIndex = 0; });
}

