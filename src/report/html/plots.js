// Plots that the budget's and the plan's page share.

/** Colours of things without an order. */
const WHEEL = ["#2a6fbb", "#e07b00", "#2f9e5f", "#c0392b", "#7d4fb3", "#8c6239", "#d64f96", "#17a2a8", "#a3a300", "#4b5bd1", "#e0a899", "#6f8f3a", "#1f4e5f", "#b08bd6"];

/** The widest picture that a section has room for without being made smaller, px. */
const ROOM = Math.min(1146, document.documentElement.clientWidth - 46);

/** A section that is made when it has something to show. */
function add(id, heading, ...children) {
  const node = el("section", { id }, el("h2", {}, heading), ...children);
  section("main").append(node);
  return node;
}

/** Links to every section. */
function buildContents() {
  const links = [...document.querySelectorAll("main section")].map(home => el("a", { href: `#${home.id}` }, home.querySelector("h2").textContent));
  section("contents").append(...links);
}

/** Details that few readers need, folded. */
function folded(title, ...content) { return el("details", {}, el("summary", {}, title), ...content); }

function note(...content) { return el("p", { class: "note" }, ...content); }

function chip(content, kind) { return el("span", { class: `chip ${kind || ""}` }, content); }

/** The legend of a set of plots. Entries: { name, colour, dash, band }. */
function keys(entries) {
  return el("div", { class: "keys" }, entries.map(entry => el("span", {}, keyMark(entry), entry.name)));
}

function keyMark({ colour, dash, hatch, diamond }) {
  if (diamond) return svg("svg", { width: 18, height: 10, style: "display:inline-block;margin-right:4px" }, svg("path", { d: "M9 0 L13 5 L9 10 L5 5 Z", fill: colour }));
  if (hatch || dash === undefined) return el("i", { style: `background:${colour};border-radius:2px` });
  return svg("svg", { width: 26, height: 10, style: "display:inline-block;margin-right:6px" },
    svg("line", { x1: 0, x2: 26, y1: 5, y2: 5, stroke: colour, "stroke-width": 2.2, "stroke-dasharray": dash || null }));
}

/** A scale from values to places: { low, high, at, ticks: [[value, label]] }. */
function scale(values, log, from, to, count) {
  const turn = log ? Math.log10 : v => v, all = values.filter(v => !missing(v) && Number.isFinite(v) && (!log || v > 0)).map(turn);
  let low = Math.min(...all), high = Math.max(...all);
  if (!all.length) [low, high] = [0, 1];
  if (high - low < 1e-9 * Math.max(1, Math.abs(high))) { const pad = log ? 0.3 : Math.abs(high) * 0.1 || 1; [low, high] = [low - pad, high + pad]; }
  const pad = 0.04 * (high - low);
  [low, high] = [log || low < 0 ? low - pad : Math.max(0, low - pad), high + pad];
  const at = v => from + (turn(v) - low) / (high - low) * (to - from);
  return { at, low, high, ticks: log ? logTicks(low, high, count) : ticks(low, high, count).map(v => [v, tickLabel(v, tickStep(low, high, count))]) };
}

/** Powers of ten, with 2 and 5 between where there is room. */
function logTicks(low, high, count) {
  const span = high - low, steps = span > count ? [1] : span > 1.2 ? [1, 3] : span > 0.55 ? [1, 2, 5] : [1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9];
  const every = Math.max(1, Math.ceil(span / (count + 1))), list = [];
  for (let power = Math.floor(low); power <= Math.ceil(high); power++) {
    if (steps.length === 1 && power % every) continue;
    for (const step of steps) {
      const v = step * 10 ** power, place = Math.log10(v);
      if (place >= low && place <= high) list.push([v, power < -4 || power > 5 ? v.toExponential(0) : String(Number(v.toPrecision(2)))]);
    }
  }
  return list;
}

/** Where an axis stands that has its labels on the left and its name beside them: at least `least`. */
const besideLabels = (labels, least) => Math.max(least, 26 + 7.2 * Math.max(0, ...labels.map(([, label]) => label.length)));

/** A plot of curves. x, y: { label, log, words, whole, also }; series: { name, colour, dash, points, dots, line, size }; marks: level lines { y, name }. */
function plot({ title, sub, x, y, series, marks = [], width: asked = 380, height = 260 }) {
  const width = Math.max(300, Math.min(asked, ROOM));
  const seen = series.map(s => ({ ...s, points: s.points.filter(p => !missing(p[0]) && !missing(p[1]) && (!y.log || p[1] > 0)) })).filter(s => s.points.length);
  const head = el("h3", {}, title, sub ? el("small", {}, `  ${sub}`) : "");
  if (!seen.length) return el("figure", {}, head, note("nothing to show"));
  const flat = seen.flatMap(s => s.points.flatMap(p => p[2] ? [p, [p[0], p[2][0]], [p[0], p[2][1]]] : [p]));
  const box = { right: 14, top: 12, bottom: 42 }, up = scale([...flat.map(p => p[1]), ...marks.map(m => m.y), ...(y.also || [])], y.log, height - box.bottom, box.top, 5);
  box.left = besideLabels(up.ticks, 62);
  const across = scale([...flat.map(p => p[0]), ...(x.also || [])], x.log, box.left, width - box.right, 6);
  const parts = [...frame(box, width, height, x, y, across, up), ...levels(marks, up, box, width)];
  return el("figure", {}, head, picture(width, height, title, parts, seen.map(s => curve(s, across, up))));
}

function frame(box, width, height, x, y, across, up) {
  const middle = (box.top + height - box.bottom) / 2, places = x.words ? x.words.map((word, i) => [i, word]) : x.whole ? across.ticks.filter(([v]) => Number.isInteger(v)).map(([v]) => [v, String(v)]) : across.ticks;
  return [
    ...up.ticks.flatMap(([v, label]) => [svg("line", { x1: box.left, x2: width - box.right, y1: up.at(v), y2: up.at(v), stroke: INK.line }),
      text(box.left - 6, up.at(v) + 4, label, { "text-anchor": "end", class: "soft" })]),
    ...places.flatMap(([v, label]) => [svg("line", { x1: across.at(v), x2: across.at(v), y1: height - box.bottom, y2: height - box.bottom + 4, stroke: INK.mark }),
      text(across.at(v), height - box.bottom + 17, label, { "text-anchor": "middle", class: "soft" })]),
    text(12, middle, y.label, { transform: `rotate(-90 12 ${middle})`, "text-anchor": "middle", class: "soft" }),
    text((box.left + width - box.right) / 2, height - 6, x.label, { "text-anchor": "middle", class: "soft" })];
}

/** Level lines with their names; a name that would cover the one before it stands further to the left. */
function levels(marks, up, box, width) {
  let before = null, shift = 0;
  return [...marks].sort((a, b) => a.y - b.y).flatMap(mark => {
    const y = up.at(mark.y), colour = mark.colour || "var(--good)";
    shift = before !== null && before - y < 13 ? shift + 92 : 0;
    before = y;
    return [svg("line", { x1: box.left, x2: width - box.right, y1: y, y2: y, stroke: colour, "stroke-width": 1.3, "stroke-dasharray": "6 3" }),
      text(width - box.right - 2 - shift, y - 4, mark.name, { "text-anchor": "end", class: "over", style: `fill:${colour};font-size:11px` })];
  });
}

function curve(s, across, up) {
  const places = s.points.map(([x, y]) => [across.at(x).toFixed(1), up.at(y).toFixed(1)]);
  const line = s.line === false ? [] : [svg("polyline", { points: places.map(p => p.join(",")).join(" "), fill: "none", stroke: s.colour, "stroke-width": s.thin ? 1.2 : 2, "stroke-dasharray": s.dash || null })];
  const dots = s.dots === false ? [] : places.map(([cx, cy]) => svg("circle", { cx, cy, r: s.size || 2.6, fill: s.colour, "fill-opacity": s.size < 4 ? 0.55 : null, stroke: s.size >= 4 ? INK.paper : null }));
  return [...line, ...dots, ...s.points.filter(p => p[2]).map(([x, , [low, high]]) => svg("line", { x1: across.at(x), x2: across.at(x), y1: up.at(low), y2: up.at(high), stroke: s.colour, "stroke-width": 1.2 }))];
}

/** The colours of a density from 0 to `end`. */
function densityLegend(end, words) {
  const width = 260, steps = 52, cells = Array.from({ length: steps }, (_, i) => svg("rect", { x: i * width / steps, y: 0, width: width / steps + 0.5, height: 12, fill: css(shade((i + 0.5) / steps)) }));
  const labels = [0, 0.25, 0.5, 0.75, 1].map(part => text(part * width, 26, short(part * end), { "text-anchor": part === 0 ? "start" : part === 1 ? "end" : "middle", class: "soft" }));
  return el("div", { class: "legend" }, picture(width, 30, `colour scale, ${words}`, cells, labels), words);
}

/** A ruler under a map: `size` pixels for a metre, `low` at the left edge. Where not all labels have room, the first and the last stand. */
function ruler(width, size, low, unit) {
  const high = low + width / size, count = Math.max(3, Math.min(8, width / 60)), step = tickStep(low, high, count), places = ticks(low, high, count), labels = places.map(v => tickLabel(v, step));
  const crowded = 8 * labels.join(" ").length > width, shown = k => !crowded || k === 0 || k === places.length - 1;
  const marks = places.flatMap((v, k) => { const x = (v - low) * size; return [svg("line", { x1: x, x2: x, y1: 0, y2: 5, stroke: INK.mark }), shown(k) ? text(Math.max(9, Math.min(width - 9, x)), 18, labels[k], { "text-anchor": "middle", class: "soft" }) : null]; });
  return picture(width, 34, `axis in ${unit}`, svg("line", { x1: 0, x2: width, y1: 0.5, y2: 0.5, stroke: INK.mark }), marks, text(width / 2, 32, unit, { "text-anchor": "middle", class: "soft" }));
}

// AGAINST THE NORMAL CURVE

const NORMAL_KEY = { name: "normal curve as stated", colour: "var(--good)", dash: "6 3" };

/** How residuals in their stated sigmas are spread, against the normal curve that they follow if what is stated is right. Groups: { name, colour, values }. */
function againstNormal(title, sub, groups, size = {}) {
  const reach = 4, width = 0.25, places = Array.from({ length: 2 * reach / width }, (_, i) => -reach + (i + 0.5) * width);
  const density = values => {
    const counts = places.map(() => 0);
    values.forEach(v => { const place = Math.floor((v + reach) / width); if (place >= 0 && place < counts.length) counts[place] += 1; });
    return places.map((x, i) => [x, counts[i] / Math.max(1, values.length) / width]);
  };
  const curve = Array.from({ length: 81 }, (_, i) => -reach + i * reach / 40).map(x => [x, Math.exp(-x * x / 2) / Math.sqrt(2 * Math.PI)]);
  const series = [{ ...NORMAL_KEY, dots: false, points: curve }, ...groups.map(group => ({ name: group.name, colour: group.colour, points: density(group.values) }))];
  return plot({ title, sub, x: { label: "residual / stated sigma" }, y: { label: "density" }, series, ...size });
}

/** The values of one key as abscissae: numbers where all are, places in the list otherwise. */
function abscissae(values) {
  const numeric = values.every(v => typeof v === "number");
  if (!numeric) return { places: values.map((_, i) => i), log: false, words: values.map(String) };
  const low = Math.min(...values), high = Math.max(...values);
  return { places: values, log: low > 0 && high / low >= 20 && values.length > 2, words: null };
}

/** Light to dark for 0 to 1. */
function shade(part) {
  const stops = [[240, 246, 250], [158, 202, 225], [66, 146, 198], [8, 69, 148], [3, 25, 66]], place = 4 * Math.max(0, Math.min(1, part)), low = Math.min(3, Math.floor(place));
  return stops[low].map((from, i) => Math.round(from + (place - low) * (stops[low + 1][i] - from)));
}

/** A heat map over two keys; value(row, column) in the unit shown, coloured by its logarithm between two ends. */
function pairMap({ title, sub, rows, columns, value, low, high, name }) {
  const cell = { width: Math.max(44, Math.min(70, 300 / columns.length)), height: 30 }, left = 6.5 * Math.max(3, ...rows.map(row => String(row).length)) + 10, top = 8, width = left + cell.width * columns.length + 4, height = top + cell.height * rows.length + 44;
  const cells = rows.flatMap((row, i) => columns.flatMap((column, j) => {
    const v = value(i, j), part = missing(v) || !(v > 0) ? null : high > low ? Math.log(v / low) / Math.log(high / low) : 0.3;
    return [svg("rect", { x: left + j * cell.width, y: top + i * cell.height, width: cell.width - 1.5, height: cell.height - 1.5, fill: part === null ? "var(--line)" : css(shade(part)) }),
      text(left + (j + 0.5) * cell.width, top + (i + 0.5) * cell.height + 4, short(v), { "text-anchor": "middle", style: `font-size:11px${part > 0.5 ? ";fill:#fff" : ""}` })];
  }));
  const bottom = top + cell.height * rows.length;
  const labels = [...rows.map((row, i) => text(left - 6, top + (i + 0.5) * cell.height + 4, String(row), { "text-anchor": "end", class: "soft" })),
    ...columns.map((column, j) => text(left + (j + 0.5) * cell.width, bottom + 15, String(column), { "text-anchor": "middle", class: "soft" })),
    text(left + cell.width * columns.length / 2, bottom + 34, name, { "text-anchor": "middle", class: "soft" })];
  return el("figure", {}, el("h3", {}, title, el("small", {}, `  ${sub || ""}`)), picture(width, height, title, cells, labels));
}
