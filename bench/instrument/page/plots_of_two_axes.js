// Points with two coordinates.

function frame(plot, width, xs, ys) {
  const height = Math.round(Math.min(400, Math.max(240, width * 0.46)));
  const left = 74;
  const right = width - 18;
  const bottom = height - 42;
  const x = makeScale(plot.x, xs, left, right, width / 110);
  const y = makeScale(plot.y, ys, bottom, 26, 6);
  const svg = startDrawing(width, height, plot.title);
  drawYAxis(svg, plot.y, y, left, right);
  drawXAxis(svg, plot.x, x, 22, bottom, left, right);
  svg.append(element("text", { class: "axis-label", x: 0, y: 11 }, axisTitle(plot.y)));
  return { svg, x, y, left, right };
}

function drawScatter(plot, width) {
  const reach = (axis) => plot.points.flatMap((point) => [point[axis], point[axis + "_low"], point[axis + "_high"]]);
  const { svg, x, y, right } = frame(plot, width, reach("x"), reach("y"));
  const series = distinct(plot.points.map((point) => point.series));
  const shown = plot.points.filter((point) => x.shows(point.x) && y.shows(point.y));
  const front = shown.filter((point) => point.front).sort((a, b) => a.x - b.x);
  if (front.length > 1)
    svg.append(element("path", { class: "front", d: "M" + front.map((point) => `${x.at(point.x)} ${y.at(point.y)}`).join("L") }));
  const marks = [];
  for (const point of [...shown].sort((a, b) => a.front - b.front)) {
    const number = seriesOf(point.series);
    const px = x.at(point.x);
    const py = y.at(point.y);
    const style = `stroke:${colour(number)}`;
    if (x.shows(point.x_low) && x.shows(point.x_high))
      svg.append(element("line", { class: "interval", style, x1: x.at(point.x_low), x2: x.at(point.x_high), y1: py, y2: py }));
    if (y.shows(point.y_low) && y.shows(point.y_high))
      svg.append(element("line", { class: "interval", style, x1: px, x2: px, y1: y.at(point.y_low), y2: y.at(point.y_high) }));
    const dot = mark(number, px, py, !point.front, point.front ? 5.4 : 4);
    dot.dataset.x = point.x;
    dot.dataset.y = point.y;
    svg.append(dot);
    marks.push({
      x: px, y: py,
      text: point.name +
        `\n${plot.x.label}: ${readable(point.x, plot.x.unit)}\n${plot.y.label}: ${readable(point.y, plot.y.unit)}` + (point.note ? "\n" + point.note : ""),
    });
  }
  // Names of the front's points, each where it covers no other name.
  const taken = [];
  for (const point of front) {
    const wide = point.name.length * 6.4;
    const px = x.at(point.x);
    for (const [dx, dy] of [[9, -8], [9, 17], [-9 - wide, -8], [-9 - wide, 17]]) {
      const box = [px + dx, y.at(point.y) + dy - 11, px + dx + wide, y.at(point.y) + dy + 3];
      if (box[0] < 74 || box[2] > right + 12) continue;
      if (taken.some((other) => box[0] < other[2] && other[0] < box[2] && box[1] < other[3] && other[1] < box[3])) continue;
      taken.push(box);
      svg.append(element("text", { x: box[0], y: box[1] + 11 }, point.name));
      break;
    }
  }
  marks.sort((a, b) => a.x - b.x);
  return { svg, marks, legend: series.length > 1 ? legend(series) : null };
}
