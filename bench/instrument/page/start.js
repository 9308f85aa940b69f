// Draws the plots and makes the tables sortable.

const kinds = { intervals: drawIntervals, scatter: drawScatter };

function drawInto(figure, plot) {
  const holder = figure.querySelector(".plot");
  const width = Math.max(320, Math.round(holder.clientWidth || 860));
  if (Number(holder.dataset.width) === width) return;
  holder.dataset.width = width;
  holder.textContent = "";
  try {
    const drawn = kinds[plot.kind](plot, width);
    if (drawn.legend) holder.append(drawn.legend);
    holder.append(drawn.svg);
    // The cursor's tip is placed relative to the drawing, so both get a holder of their own.
    const box = html("div", { style: "position:relative" });
    drawn.svg.replaceWith(box);
    box.append(drawn.svg);
    addCursor(box, drawn.svg, drawn.marks);
    figure.dataset.drawn = drawn.marks.length;
  } catch (error) {
    figure.classList.add("broken");
    holder.textContent = "This plot could not be drawn; its numbers are below.";
    console.error(`plot "${plot.title}":`, error);
  }
}

// What a cell sorts by: its number, else its text. Missing numbers come last either way.
function sortKey(row, column) {
  const cell = row.cells[column];
  if (cell.dataset.value !== undefined) return Number(cell.dataset.value);
  return cell.classList.contains("number") ? NaN : cell.textContent;
}

function compareKeys(a, b, direction) {
  const missing = (key) => typeof key === "number" && Number.isNaN(key);
  if (missing(a) || missing(b)) return missing(a) - missing(b);
  if (typeof a === "number" && typeof b === "number") return direction * (a - b);
  return direction * String(a).localeCompare(String(b), "en", { numeric: true });
}

function makeSortable(table) {
  const headers = [...table.tHead.rows[0].cells];
  headers.forEach((header, column) => {
    const button = html("button", { type: "button", title: "Sort by this column" }, ...header.childNodes);
    header.append(button);
    button.addEventListener("click", () => {
      const direction = header.getAttribute("aria-sort") === "ascending" ? -1 : 1;
      for (const other of headers) other.removeAttribute("aria-sort");
      header.setAttribute("aria-sort", direction > 0 ? "ascending" : "descending");
      const keyed = [...table.tBodies[0].rows].map((row) => [sortKey(row, column), row]);
      keyed.sort((a, b) => compareKeys(a[0], b[0], direction));
      table.tBodies[0].append(...keyed.map((pair) => pair[1]));
    });
  });
}

function start() {
  const plots = JSON.parse(document.getElementById("plots").textContent);
  const figures = plots.map((plot, index) => [document.getElementById("plot-" + index), plot]);
  const drawAll = () => { for (const [figure, plot] of figures) drawInto(figure, plot); };
  drawAll();
  let waiting = 0;
  window.addEventListener("resize", () => {
    cancelAnimationFrame(waiting);
    waiting = requestAnimationFrame(drawAll);
  });
  document.querySelectorAll("table.sortable").forEach(makeSortable);
  document.body.dataset.plots = figures.length;
}

start();
