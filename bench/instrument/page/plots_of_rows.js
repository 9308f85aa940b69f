// Plots with a row for each thing: dots with intervals.

const rowHeight = 24;

// The rows under their groups, with labels at the left: [{y, item}] for items in their order.
function layOutRows(items, labelWidth, heightOf) {
  const rows = [];
  let y = 8;
  for (const group of distinct(items.map((item) => item.group))) {
    if (group) rows.push({ y: (y += 22) - 8, group });
    for (const item of items.filter((other) => other.group === group)) {
      const height = heightOf(item);
      rows.push({ y: y + height / 2, item });
      y += height;
    }
    y += 6;
  }
  return { rows, bottom: y, labelWidth };
}

function labelWidthOf(items, width) {
  const longest = Math.max(4, ...items.map((item) => item.name.length));
  return Math.min(longest * 6.6 + 14, width * 0.4);
}

function drawLabels(svg, layout, left) {
  for (const row of layout.rows)
    if (row.group) svg.append(label(row.group, 0, row.y, 600, { class: "group" }));
    else svg.append(label(row.item.name, left - 10, row.y + 4, left - 10, { "text-anchor": "end" }));
}

function drawIntervals(plot, width) {
  const keyOf = (point) => JSON.stringify([point.group, point.name]);
  const items = [];
  const byKey = new Map();
  for (const point of plot.points) {
    if (!byKey.has(keyOf(point))) {
      byKey.set(keyOf(point), []);
      items.push({ group: point.group, name: point.name, points: byKey.get(keyOf(point)) });
    }
    byKey.get(keyOf(point)).push(point);
  }
  const left = labelWidthOf(items, width);
  const right = width - 16;
  const layout = layOutRows(items, left, (item) => Math.max(rowHeight, 11 * item.points.length + 8));
  const values = plot.points.flatMap((point) => [point.value, point.low, point.high]);
  if (plot.reference !== null) values.push(plot.reference);
  const scale = makeScale(plot.x, values, left, right, width / 110);
  const svg = startDrawing(width, layout.bottom + 42, plot.title);
  drawXAxis(svg, plot.x, scale, 4, layout.bottom, left, right);
  drawLabels(svg, layout, left);
  if (plot.reference !== null && scale.shows(plot.reference)) {
    const x = scale.at(plot.reference);
    svg.append(element("line", { class: "reference", x1: x, x2: x, y1: 4, y2: layout.bottom }));
  }
  const marks = [];
  for (const { y, item } of layout.rows) {
    if (!item) continue;
    item.points.forEach((point, index) => {
      if (!scale.shows(point.value)) return;
      const place = y + (index - (item.points.length - 1) / 2) * 11;
      const number = seriesOf(point.name);
      const x = scale.at(point.value);
      const hasInterval = scale.shows(point.low) && scale.shows(point.high);
      if (hasInterval)
        svg.append(element("line", {
          class: "interval", style: `stroke:${colour(number)}`, x1: scale.at(point.low), x2: scale.at(point.high), y1: place, y2: place,
        }));
      const dot = mark(number, x, place, point.hollow, 4.6);
      dot.dataset.value = point.value;
      dot.dataset.x = x;
      svg.append(dot);
      marks.push({
        x, y: place,
        text: [point.group, point.name, point.series].filter(Boolean).join(" · ") + "\n" + readable(point.value, plot.x.unit) +
          (hasInterval ? `  (${readable(point.low, plot.x.unit)} to ${readable(point.high, plot.x.unit)})` : "") + (point.note ? "\n" + point.note : ""),
      });
    });
  }
  return { svg, marks, legend: null };
}
