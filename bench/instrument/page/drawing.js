// What all plots share: SVG elements, axes, legends, and a cursor that the pointer and the arrow keys
// move from mark to mark.

function element(name, attributes = {}, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

function html(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

// A name has one colour and one shape on the whole page: its place among all names.
const seriesNames = [];
function seriesOf(name) {
  if (!seriesNames.includes(name)) seriesNames.push(name);
  return seriesNames.indexOf(name);
}

const colour = (series) => `var(--s${series % 8})`;

// Each series has a shape too, for those who do not see its colour.
function shape(series, x, y, size = 5) {
  const p = (dx, dy) => `${(x + dx * size).toFixed(2)} ${(y + dy * size).toFixed(2)}`;
  const outlines = [
    null,
    [[-0.85, -0.85], [0.85, -0.85], [0.85, 0.85], [-0.85, 0.85]],
    [[0, -1.2], [1.2, 0], [0, 1.2], [-1.2, 0]],
    [[0, -1.15], [1.1, 0.85], [-1.1, 0.85]],
    [[-1.1, -0.85], [1.1, -0.85], [0, 1.15]],
  ];
  const outline = outlines[series % outlines.length];
  if (!outline) return element("circle", { cx: x.toFixed(2), cy: y.toFixed(2), r: size });
  return element("path", { d: "M" + outline.map(([dx, dy]) => p(dx, dy)).join("L") + "Z" });
}

function mark(series, x, y, hollow, size) {
  const made = shape(series, x, y, size);
  made.setAttribute("class", hollow ? "mark hollow" : "mark");
  made.style[hollow ? "stroke" : "fill"] = colour(series);
  return made;
}

// A label that is cut where it has no room.
function label(text, x, y, room, attributes = {}) {
  const most = Math.max(3, Math.floor(room / 6.4));
  const short = text.length > most ? text.slice(0, most - 1) + "…" : text;
  const made = element("text", { x, y, ...attributes }, short);
  if (short !== text) made.append(element("title", {}, text));
  return made;
}

function legend(names) {
  const list = html("ul", { class: "legend" });
  names.forEach((name) => {
    const series = seriesOf(name);
    const key = element("svg", { width: 12, height: 12, "aria-hidden": "true" });
    key.append(mark(series, 6, 6, false, 4.5));
    list.append(html("li", {}, key, name));
  });
  return list;
}

function axisTitle(axis) {
  return axis.label + (axis.scale === "log" ? " (log scale)" : "");
}

// Vertical grid lines with numbers below, and the axis' label under them.
function drawXAxis(svg, axis, scale, top, bottom, from, to) {
  let last = -Infinity;
  for (const tick of scale.ticks) {
    const x = scale.at(tick);
    if (x < from - 1 || x > to + 1) continue;
    svg.append(element("line", { class: "grid", x1: x, x2: x, y1: top, y2: bottom, "data-tick": tick }));
    if (x - last < 46) continue;
    last = x;
    svg.append(element("text", { class: "tick", x, y: bottom + 15, "text-anchor": "middle" }, readable(tick, axis.unit)));
  }
  svg.append(element("text", { class: "axis-label", x: (from + to) / 2, y: bottom + 33, "text-anchor": "middle" }, axisTitle(axis)));
}

function drawYAxis(svg, axis, scale, from, to) {
  for (const tick of scale.ticks) {
    const y = scale.at(tick);
    svg.append(element("line", { class: "grid", x1: from, x2: to, y1: y, y2: y, "data-tick": tick }));
    svg.append(element("text", { class: "tick", x: from - 7, y: y + 4, "text-anchor": "end" }, readable(tick, axis.unit)));
  }
}

// marks: [{x, y, text}] in the order of the arrow keys. The nearest mark to the pointer is shown.
function addCursor(holder, svg, marks) {
  svg.dataset.marks = marks.length;
  if (!marks.length) return;
  const ring = element("circle", { class: "cursor", r: 8, visibility: "hidden" });
  svg.append(ring);
  const tip = html("div", { class: "tip", role: "status", "aria-live": "polite", hidden: "" });
  holder.append(tip);
  let current = -1;
  const hide = () => {
    ring.setAttribute("visibility", "hidden");
    tip.hidden = true;
  };
  const show = (index) => {
    current = Math.max(0, Math.min(marks.length - 1, index));
    const { x, y, text } = marks[current];
    ring.setAttribute("cx", x);
    ring.setAttribute("cy", y);
    ring.setAttribute("visibility", "visible");
    tip.textContent = text;
    tip.hidden = false;
    const scale = svg.getBoundingClientRect().width / svg.viewBox.baseVal.width || 1;
    const left = x * scale + 14;
    const fits = left + tip.offsetWidth <= holder.clientWidth;
    tip.style.left = (fits ? left : Math.max(0, x * scale - tip.offsetWidth - 14)) + "px";
    tip.style.top = Math.max(0, y * scale - tip.offsetHeight - 6) + "px";
  };
  svg.addEventListener("pointermove", (event) => {
    const box = svg.getBoundingClientRect();
    const scale = svg.viewBox.baseVal.width / box.width;
    const x = (event.clientX - box.left) * scale;
    const y = (event.clientY - box.top) * scale;
    let best = -1;
    let least = 60 ** 2;
    marks.forEach((place, index) => {
      const distance = (place.x - x) ** 2 + (place.y - y) ** 2;
      if (distance < least) [best, least] = [index, distance];
    });
    if (best < 0) hide();
    else show(best);
  });
  svg.addEventListener("pointerleave", hide);
  svg.addEventListener("blur", hide);
  svg.addEventListener("focus", () => { if (svg.matches(":focus-visible")) show(Math.max(0, current)); });
  svg.addEventListener("keydown", (event) => {
    const steps = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 };
    if (event.key in steps) show(current + steps[event.key]);
    else if (event.key === "Home") show(0);
    else if (event.key === "End") show(marks.length - 1);
    else if (event.key === "Escape") hide();
    else return;
    event.preventDefault();
  });
}

function startDrawing(width, height, title) {
  return element("svg", {
    class: "drawing", viewBox: `0 0 ${width} ${height}`, tabindex: 0, role: "group",
    "aria-label": title + ". Arrow keys go from value to value.",
  });
}

const distinct = (values) => [...new Set(values)];
