// Convergence, corrections with error bars, correlations, weak directions.

// CONVERGENCE

/** A line chart with a logarithmic or linear ordinate. Series: { name, colour, points: [[x, y]] }. */
function lineChart({ title, x, y, log, series, marks }) {
  const width = 370, height = 250;
  const shown = series.map(s => ({ ...s, points: s.points.filter(p => !missing(p[1]) && (!log || p[1] > 0)) })).filter(s => s.points.length);
  if (!shown.length) return el("figure", {}, el("p", { class: "note" }, `${title}: no iterations recorded.`));
  const turn = log ? Math.log10 : v => v, all = shown.flatMap(s => s.points.map(p => turn(p[1])));
  let low = Math.min(...all), high = Math.max(...all);
  [low, high] = log ? [Math.floor(low - 1e-9), Math.ceil(high + 1e-9)] : low === high ? [low - 1, high + 1] : [low - 0.05 * (high - low), high + 0.05 * (high - low)];
  const levels = ordinateTicks(low, high, log), box = { left: besideLabels(levels, 68), right: 10, top: 12, bottom: 42 };
  const places = shown.flatMap(s => s.points.map(p => p[0])), first = Math.min(1, ...places), last = Math.max(2, ...places);
  const at = { x: v => box.left + (v - first) / (last - first) * (width - box.left - box.right), y: v => height - box.bottom - (v - low) / (high - low) * (height - box.top - box.bottom) };
  const parts = [...ordinate(levels, at, box, width), ...abscissa(first, last, at, box, height), ...outerMarks(marks || [], at, box, height)];
  parts.push(text(11, (box.top + height - box.bottom) / 2, y, { transform: `rotate(-90 11 ${(box.top + height - box.bottom) / 2})`, "text-anchor": "middle", class: "soft" }),
    text((box.left + width - box.right) / 2, height - 6, x, { "text-anchor": "middle", class: "soft" }));
  const lines = shown.map(s => seriesLine(s, turn, at));
  const names = el("div", { class: "keys" }, shown.filter(s => s.name).map(s => el("span", {}, el("i", { style: `background:${s.colour}` }), s.name)));
  return el("figure", {}, el("h3", {}, title), names, picture(width, height, title, parts, lines));
}

/** Places and labels of an ordinate. */
function ordinateTicks(low, high, log) {
  const step = log ? Math.max(1, Math.ceil((high - low) / 6)) : tickStep(low, high, 5);
  const places = log ? Array.from({ length: Math.floor((high - low) / step) + 1 }, (_, i) => low + i * step) : ticks(low, high, 5);
  return places.map(v => [v, log ? powerLabel(v) : tickLabel(v, step)]);
}

function ordinate(levels, at, box, width) {
  return levels.flatMap(([v, label]) => [
    svg("line", { x1: box.left, x2: width - box.right, y1: at.y(v), y2: at.y(v), stroke: INK.line }),
    text(box.left - 7, at.y(v) + 4, label, { "text-anchor": "end", class: "soft" })]);
}

function abscissa(first, last, at, box, height) {
  const step = Math.max(1, Math.ceil((last - first) / 12)), list = [];
  for (let v = first; v <= last; v += step) list.push(text(at.x(v), height - box.bottom + 16, String(v), { "text-anchor": "middle", class: "soft" }));
  return list;
}

function outerMarks(marks, at, box, height) {
  return marks.flatMap(({ place, name }) => [
    svg("line", { x1: at.x(place), x2: at.x(place), y1: box.top, y2: height - box.bottom, stroke: INK.mark, "stroke-dasharray": "3 3" }),
    text(at.x(place) + (place === 1 ? 4 : -4), box.top + 9, name, { class: "soft", "text-anchor": place === 1 ? "start" : "end" })]);
}

function seriesLine(s, turn, at) {
  const places = s.points.map(([x, y]) => [at.x(x), at.y(turn(y))].map(v => v.toFixed(1)));
  return [svg("polyline", { points: places.map(p => p.join(",")).join(" "), fill: "none", stroke: s.colour, "stroke-width": 1.8 }),
    ...places.map(([cx, cy]) => svg("circle", { cx, cy, r: 3, fill: s.colour }))];
}

function jointCharts(path) {
  const steps = path.solution.convergence, last = steps[steps.length - 1].outer;
  const marks = steps.map((step, i) => ({ place: i + 1, name: String(step.outer) })).filter((_, i) => last > 1 && (!i || steps[i].outer !== steps[i - 1].outer));
  const x = last > 1 ? "iteration; dashed: round of assignment" : "iteration", series = of => [{ name: path.name, colour: path.colour, points: steps.map((step, i) => [i + 1, of(step)]) }];
  const costs = costByRound(path, steps);
  return [
    lineChart({ title: `${path.name} path: largest step`, x, y: "in sigmas of the parameter", log: true, marks, series: series(step => step.largest_step_in_sigma) }),
    ...(costs.some(round => round.points.length > 1) ? [lineChart({ title: `${path.name} path: robust cost`, x, y: "cost / first cost of its round", log: false, marks, series: costs })] : []),
  ];
}

/** The cost of each round of assignment by its first one, a line per round: costs of different ties do not compare. */
function costByRound(path, steps) {
  const rounds = [...new Set(steps.map(step => step.outer))];
  return rounds.map((outer, k) => {
    const own = steps.map((step, i) => [i + 1, step]).filter(([, step]) => step.outer === outer), first = own[0][1].cost || 1;
    return { name: k ? "" : path.name, colour: path.colour, points: own.map(([place, step]) => [place, step.cost / first]) };
  });
}

/** Charts of a procedure's own reference path, put here by its scripts. */
const OWN_CONVERGENCE = [];

function buildConvergence() {
  const charts = [...OWN_CONVERGENCE, ...PATHS.filter(path => path.solution.convergence.length).flatMap(jointCharts)];
  if (charts.length) add("convergence", "Convergence", el("div", { class: "row3" }, charts));
}

// CORRECTIONS

function correctionChart(parameter) {
  const width = 380, row = 26, top = 8, left = 12;
  const rows = ESTIMATED.map(path => ({ path, p: parameterOf(path.solution, parameter.name) })).filter(({ p }) => p && !missing(p.correction))
    .map(({ path, p }) => ({ path, value: inShown(p.correction, p.unit), sigma: inShown(p.sigma, p.unit), words: correctionText(p) }));
  const truthRow = truthOf(parameter.name), truth = truthRow ? inShown(truthRow.correction, parameter.unit) : null;
  if (!rows.length) return [];
  const height = top + row * rows.length + 30;
  const ends = rows.flatMap(r => [r.value - 2.4 * (r.sigma || 0), r.value + 2.4 * (r.sigma || 0)]).concat(missing(truth) ? [] : [truth]);
  let low = Math.min(...ends), high = Math.max(...ends);
  const pad = 0.08 * (high - low) || Math.abs(high) * 0.1 || 1;
  [low, high] = [low - pad, high + pad];
  const at = v => left + (v - low) / (high - low) * (width - 2 * left), step = tickStep(low, high, 6), bottom = top + row * rows.length;
  const grid = ticks(low, high, 6).flatMap(v => [svg("line", { x1: at(v), x2: at(v), y1: top, y2: bottom, stroke: INK.line }),
    text(at(v), bottom + 16, tickLabel(v, step), { "text-anchor": "middle", class: "soft" })]);
  const known = missing(truth) ? [] : [svg("line", { x1: at(truth), x2: at(truth), y1: top - 4, y2: bottom + 2, stroke: "var(--good)", "stroke-width": 1.6, "stroke-dasharray": "5 3" })];
  const values = rows.map(r => el("div", { style: `color:${r.path.colour}` }, `${r.path.name}: ${r.words} ${shownUnit(parameter.unit)}`));
  return el("figure", {}, el("h3", {}, parameter.name, el("small", {}, `  ${[parameter.positive ? `positive: ${parameter.positive}` : "", shownUnit(parameter.unit)].filter(w => w).join(", ")}`)),
    picture(width, height, `correction of ${parameter.name}`, grid, known, rows.map((r, i) => errorBar(r, at, top + row * (i + 0.5)))), el("figcaption", {}, values));
}

/** Thick to one sigma, thin to two; a bare ring where there is no covariance. */
function errorBar({ path, value, sigma }, at, y) {
  const bar = (count, thick) => svg("line", { x1: at(value - count * sigma), x2: at(value + count * sigma), y1: y, y2: y, stroke: path.colour, "stroke-width": thick });
  const spot = svg("circle", { cx: at(value), cy: y, r: 4.5, fill: sigma ? path.colour : "var(--paper)", stroke: path.colour, "stroke-width": 2 });
  return sigma ? [bar(2, 1.4), bar(1, 4), spot] : [spot];
}

function buildCorrections() {
  if (!ESTIMATED.length) return;
  const legend = pathKeys();
  if (DATA.against_truth) legend.append(el("span", {}, el("i", { style: "background:var(--good);height:3px;border-radius:0;vertical-align:3px" }), "truth of the simulation"));
  add("corrections", "Corrections", legend, el("div", { class: "grid3" }, SOUGHT.map(correctionChart)),
    note("Added to what was known before; angles about the body axes. Bars: one sigma (thick) and two (thin); a ring has no covariance."));
}

// WHAT THE DATA DETERMINE

function heatMap(matrix, title, names) {
  const small = names.length > 8, cell = small ? 38 : 56, left = 10 + 7.2 * Math.max(...names.map(name => name.length)), turned = left > cell, top = turned ? left : 24, size = cell * names.length;
  const cells = matrix.flatMap((row, i) => row.flatMap((value, j) => {
    const dark = Math.abs(value) > 0.75 && i !== j, place = small ? 1 : Math.abs(value) > 0.95 && i !== j ? 3 : 2;
    return [svg("rect", { x: left + j * cell, y: top + i * cell, width: cell - 1.5, height: cell - 1.5, fill: i === j ? "var(--wash)" : css(diverging(value)) }),
      text(left + (j + 0.5) * cell, top + (i + 0.5) * cell + 4, digits(value, place), { "text-anchor": "middle", style: dark ? "fill:#fff" : i === j ? null : "fill:#1c2730" })];
  }));
  const above = (name, i) => { const x = left + (i + 0.5) * cell; return turned ? text(x + 4, top - 6, name, { transform: `rotate(-90 ${x + 4} ${top - 6})` }) : text(x, top - 8, name, { "text-anchor": "middle" }); };
  const labels = names.flatMap((name, i) => [text(left - 7, top + (i + 0.5) * cell + 4, name, { "text-anchor": "end" }), above(name, i)]);
  return el("figure", {}, el("h3", {}, title), picture(left + size, top + size, title, cells, labels));
}

/** The names stand on the left, each bar on its side of the zero. */
function combination(weak) {
  const entries = Object.entries(weak.combination), names = 8 + 6.5 * Math.max(...entries.map(([name]) => name.length));
  const width = names + 250, mid = names + 125, row = 20, sizes = Math.max(1, ...entries.map(entry => Math.abs(entry[1])));
  return picture(width, row * entries.length + 4, "components of the weak direction", svg("line", { x1: mid, x2: mid, y1: 0, y2: row * entries.length, stroke: INK.mark }),
    entries.map(([name, value], i) => {
      const length = Math.abs(value) / sizes * 80, x = value < 0 ? mid - length : mid, y = i * row + 14;
      return [text(names - 8, y, name, { "text-anchor": "end" }), svg("rect", { x, y: i * row + 4, width: length, height: row - 8, fill: css(diverging(Math.sign(value) * 0.7)) }),
        text(value < 0 ? x - 5 : x + length + 5, y, digits(value, 2), { "text-anchor": value < 0 ? "end" : "start" })];
    }));
}

function weakList(observability) {
  const facts = el("p", {}, `Rank ${observability.rank} of ${observability.unknowns} unknowns; condition number of their scaled normal matrix ${observability.condition_number.toExponential(1)}.`);
  if (!observability.weak.length) return [facts, el("p", {}, "No direction is weakly determined.")];
  return [facts, el("ul", { class: "weak" }, observability.weak.map(weak =>
    el("li", {}, weak.text, missing(weak.sigma) ? "" : ` (sigma along it, scaled: ${short(weak.sigma)})`, combination(weak))))];
}

function buildDetermined() {
  const path = PATHS.find(candidate => candidate.key === "joint") || PATHS.find(candidate => candidate.key === "joint_simple");
  const quality = path && path.solution.quality;
  if (!path || (!quality && !path.solution.correlation)) return;
  const words = el("div", {}, el("h3", {}, "Weakly determined, and what would help"), quality ? weakList(quality.observability) : []);
  const map = path.solution.usable && path.solution.correlation ? [heatMap(path.solution.correlation, `Correlations, ${path.name.toLowerCase()} solution`, path.solution.parameters.map(p => p.name))] : [];
  add("determined", "What the data determine", el("div", { class: map.length ? "grid2" : "" }, map, words));
}
