// What is drawn from: cells and quantities out of the page's JSON, and figures as the page's own table words them.
// Nothing here or below writes markup: text from records becomes text nodes and attributes alone.

const data = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);
const table = document.querySelector("table.all");
const rows = table ? Array.from(table.tBodies[0].rows) : [];
const columns = table ? Array.from(table.tHead.rows[0].cells, (head, at) => ({
  at,
  field: head.title,
  heading: head.textContent,
  main: head.classList.contains("n") && !head.classList.contains("secondary"),
})) : [];

/** Value of a quantity, by its number; null where it was not measured. */
const value = (cell, quantity) => {
  const v = data.cells[cell].values[quantity];
  return v === "inf" ? Infinity : v;
};

const quantityOf = (field) => data.quantities.findIndex((q) => q.field === field);

/** A figure of a cell as the table shows it. */
const figure = (cell, field) => {
  const column = columns.find((c) => c.field === field);
  return column ? rows[cell].cells[column.at].textContent : "";
};

const distinct = (values) => Array.from(new Set(values));

/** An element with attributes and children; null attributes are left out. */
function element(name, attributes = {}, ...children) {
  return filled(document.createElement(name), attributes, children);
}

/** The same for drawings; the name space is that of the empty drawing in the page. */
function drawn(name, attributes = {}, ...children) {
  return filled(document.createElementNS(byId("plot").namespaceURI, name), attributes, children);
}

function filled(made, attributes, children) {
  for (const [key, value] of Object.entries(attributes)) {
    if (value !== null) made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

