// Numbers as text, and scales from numbers to places on the screen.

// Three significant digits, never with an exponent between a thousandth and a billion.
function significant(value, digits = 3) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e9 || size < 1e-4) return value.toExponential(digits - 1);
  if (size >= 1000) return Math.round(value).toLocaleString("en-US");
  return String(Number(value.toPrecision(digits)));
}

// A prefix such as "Mi", and what it stands for.
function prefixOf(size, unit) {
  if (unit === "s") {
    if (size >= 1 || size === 0) return [1, "s"];
    if (size >= 1e-3) return [1e-3, "ms"];
    return size >= 1e-6 ? [1e-6, "µs"] : [1e-9, "ns"];
  }
  const step = unit === "B" ? 1024 : unit === "B/s" ? 1000 : 0;
  if (!step) return [1, unit];
  const names = ["", "K", "M", "G", "T", "P"];
  let at = 0;
  while (at + 1 < names.length && size >= step ** (at + 1)) ++at;
  return [step ** at, names[at] + (at && unit === "B" ? "i" : "") + unit];
}

// A value as a person reads it. Units: s, B (powers of 1024), B/s (powers of 1000), x (a factor),
// % (of 1), or any text that follows the number.
function readable(value, unit) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (unit === "x") return value < 100 ? value.toFixed(2) + " ×" : significant(value) + " ×";
  if (unit === "%") {
    const text = (100 * value).toFixed(value > 0.99 && value < 1 ? 6 : 1);
    return (text.includes(".") ? text.replace(/\.?0+$/, "") : text) + " %";
  }
  const [factor, name] = prefixOf(Math.abs(value), unit);
  return significant(value / factor) + (name ? " " + name : "");
}

// Round numbers from low to high, about as many as wanted: 1, 2 or 5 times a power of ten.
function roundNumbers(low, high, wanted) {
  const rough = (high - low) / Math.max(1, wanted);
  if (!(rough > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= rough * 0.999);
  const numbers = [];
  for (let at = Math.ceil(low / step - 1e-9); at * step <= high + step * 1e-9; ++at) numbers.push(at * step);
  return numbers;
}

function powersOfTen(low, high, wanted) {
  const numbers = [];
  const decades = Math.log10(high / low);
  const factors = decades > wanted / 2 ? [1] : decades > 1.2 ? [1, 3] : [1, 2, 5];
  const stride = Math.max(1, Math.ceil(decades / Math.max(2, wanted)));
  for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power += stride)
    for (const factor of factors) {
      const number = factor * 10 ** power;
      if (number >= low * 0.999 && number <= high * 1.001) numbers.push(number);
    }
  return numbers.length > 2 ? numbers : roundNumbers(low, high, wanted);
}

// A scale from values to pixels. axis.scale: "linear" or "log". `ticks` are values.
function makeScale(axis, values, from, to, wanted) {
  let kind = axis.scale;
  values = values.filter((value) => Number.isFinite(value));
  if (kind === "log") {
    const positive = values.filter((value) => value > 0);
    if (positive.length) values = positive;
    else kind = "linear";
  }
  let low = values.length ? values.reduce((a, b) => Math.min(a, b)) : 0;
  let high = values.length ? values.reduce((a, b) => Math.max(a, b)) : 1;
  let place = (value) => value;
  let ticks;
  if (kind === "log") {
    if (low === high) [low, high] = [low / 2, high * 2];
    else [low, high] = [low / 1.08, high * 1.08];
    place = Math.log;
    ticks = powersOfTen(low, high, wanted);
  } else {
    if (axis.zero && low > 0) low = 0;
    if (low === high) [low, high] = [low - (low ? Math.abs(low) / 2 : 0), high + (high ? Math.abs(high) / 2 : 1)];
    const room = (high - low) * 0.04;
    if (!(axis.zero && low === 0)) low -= room;
    high += room;
    const factor = axis.unit === "%" ? 0.01 : prefixOf(Math.max(Math.abs(low), Math.abs(high)), axis.unit)[0];
    ticks = roundNumbers(low / factor, high / factor, wanted).map((tick) => tick * factor);
  }
  const first = place(low);
  const span = place(high) - first || 1;
  const at = (value) => from + ((place(value) - first) / span) * (to - from);
  return { at, ticks, low, high, kind, shows: (value) => Number.isFinite(value) && (kind !== "log" || value > 0) };
}
