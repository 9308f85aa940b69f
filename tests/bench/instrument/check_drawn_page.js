// check_drawn_page.js PAGE DOM: compares what the browser made of a page (DOM, by --dump-dom) with the
// JSON that the page holds. Places are checked against the ticks of the axis, which carry their values:
// so a scale that is wrong is found without asking the scale.
"use strict";
const fs = require("fs");
const [page, dom] = process.argv.slice(2).map((file) => fs.readFileSync(file, "utf8"));

let failures = 0;
function check(holds, what) {
  if (holds) return;
  console.error("check_drawn_page: " + what);
  ++failures;
}

const start = '<script type="application/json" id="plots">';
const first = page.indexOf(start) + start.length;
const plots = JSON.parse(page.slice(first, page.indexOf("</script", first)));
check(plots.length > 0, "expected plots");
check(dom.includes(`data-plots="${plots.length}"`), "expected the script to have run to its end");
check(!dom.includes("data-broken"), "hostile text has run as a script");
check(!/class="broken"/.test(dom), "a plot says that it could not be drawn");

// The attributes of each tag with this name, or with this class, in a piece of HTML.
function tags(text, pattern) {
  return [...text.matchAll(/<(\w+)((?:\s+[\w-]+="[^"]*")*)\s*\/?>/g)]
    .map((match) => ({ tag: match[1], ...Object.fromEntries([...match[2].matchAll(/([\w-]+)="([^"]*)"/g)].map((pair) => [pair[1], pair[2]])) }))
    .filter(pattern);
}

const finite = (value) => typeof value === "number";
const near = (a, b, size) => Math.abs(a - b) <= size;

// From the grid lines of an axis: a function from a value to its place, between two ticks.
function placeByTicks(ticks, scale) {
  const map = scale === "log" ? Math.log : (value) => value;
  const [a, b] = [ticks[0], ticks[ticks.length - 1]];
  return (value) => a.at + ((map(value) - map(a.value)) / (map(b.value) - map(a.value))) * (b.at - a.at);
}

plots.forEach((plot, index) => {
  const from = dom.indexOf(`id="plot-${index}"`);
  const figure = dom.slice(dom.lastIndexOf("<figure", from), dom.indexOf("</figure>", from));
  const name = `plot ${index} (${plot.kind})`;
  const drawing = figure.slice(figure.indexOf('class="drawing"'), figure.indexOf("</svg>", figure.indexOf('class="drawing"')));
  check(drawing.length > 100, `${name}: expected a drawing`);
  const drawn = Number((figure.match(/data-drawn="(\d+)"/) || [])[1]);
  const vertical = tags(drawing, (tag) => tag.class === "grid" && tag.x1 === tag.x2).map((tag) => ({ at: Number(tag.x1), value: Number(tag["data-tick"]) }));
  check(vertical.length >= 2, `${name}: expected at least two ticks, found ${vertical.length}`);
  if (vertical.length < 2) return;
  const xOf = placeByTicks(vertical, plot.x.scale);
  if (plot.kind === "intervals") {
    const values = plot.points.filter((point) => finite(point.value));
    const marks = tags(drawing, (tag) => "data-value" in tag);
    check(marks.length === values.length && drawn === values.length, `${name}: expected ${values.length} marks, found ${marks.length}`);
    const sorted = (numbers) => [...numbers].sort((a, b) => a - b).join(" ");
    check(sorted(marks.map((tag) => Number(tag["data-value"]))) === sorted(values.map((point) => point.value)), `${name}: expected the JSON's values`);
    for (const tag of marks)
      check(near(Number(tag["data-x"]), xOf(Number(tag["data-value"])), 0.6), `${name}: ${tag["data-value"]} is drawn at ${tag["data-x"]}, expected ${xOf(Number(tag["data-value"]))}`);
  } else {
    const points = plot.points.filter((point) => finite(point.x) && finite(point.y));
    const marks = tags(drawing, (tag) => "data-x" in tag && "data-y" in tag);
    check(marks.length === points.length, `${name}: expected ${points.length} points, found ${marks.length}`);
    const text = (list) => list.map((pair) => pair.join(",")).sort().join(" ");
    check(text(marks.map((tag) => [tag["data-x"], tag["data-y"]])) === text(points.map((point) => [point.x, point.y])), `${name}: expected the JSON's coordinates`);
    const front = points.filter((point) => point.front).length;
    check(marks.filter((tag) => tag.class === "mark").length === front, `${name}: expected ${front} points of the front`);
  }
});

// Sorting buttons are on every heading.
const headings = (dom.match(/<th scope="col"/g) || []).length;
const buttons = (dom.match(/<th scope="col"[^>]*><button/g) || []).length;
check(headings > 0 && headings === buttons, `expected a button on each of ${headings} headings, found ${buttons}`);

// A report holds its findings twice: as JSON, and as the first plot's numbers.
const data = page.match(/id="report">(.*?)<\/script/s);
if (data) {
  const report = JSON.parse(data[1]);
  const ratios = new Set(plots.filter((plot) => plot.kind === "intervals").flatMap((plot) => plot.points.map((point) => point.value)));
  for (const cell of report.cells)
    if (cell.ratio && ratios.size) check(ratios.has(cell.ratio.value), `the ratio ${cell.ratio.value} of ${cell.name} is in no plot`);
  check(dom.includes('class="failed"') === report.failed || !report.failed, "expected a red page for a failed report");
}
process.exit(failures ? 1 : 0);
