// What it means for soundings, and how it changes with scenario values.

// SWATH

const ORDER_COLOURS = { Exclusive: "var(--simple)", Special: "var(--good)", "1a": "var(--warn)", "1b": "var(--warn)", 2: "var(--bad)" };
const COVARIANCE_WORDS = { reported: "mean of what the path reports", errors: "errors of the trials, bias included", propagated: "propagated through the derivatives, bias included", predicted: "predicted from one linearisation, without trials" };

/** The paths that are drawn: the projected variant only where the configured one is missing. */
function swathPaths() {
  const all = RESULT.swath.paths;
  return all.filter(p => p.path !== "reference_projected" || !all.some(q => q.path === "reference"));
}

/** Limits not far above what is drawn; equal ones share a line. */
function orderLevels(limits, quantity, highest) {
  const levels = [];
  for (const order of limits.orders) {
    const y = order[quantity], same = levels.find(l => l.y === y);
    if (same) same.name += `, ${order.order}`;
    else levels.push({ y, name: `order ${order.order}`, colour: ORDER_COLOURS[order.order] });
  }
  const near = levels.filter(l => l.y <= 4 * highest);
  return near.length ? near : levels.slice(0, 1);
}

function swathPlot(limits, k, quantity, title) {
  const paths = swathPaths(), line = (path, part) => path.depths[k].beams.map(b => [b.angle_deg, b[part][quantity]]);
  const series = [...paths.flatMap(path => [
    { colour: BUDGET_PATHS[path.path].colour, points: line(path, "total"), dots: false },
    { colour: BUDGET_PATHS[path.path].colour, points: line(path, "calibration"), dots: false, dash: "2 3", thin: true }]),
  ...(paths.length ? [{ colour: "var(--soft)", points: line(paths[0], "sensors"), dots: false, dash: "7 4" }] : [])];
  const highest = Math.max(...series.flatMap(s => s.points.map(p => p[1])));
  return plot({ title: `${title} at ${short(limits.depth_m)} m`, sub: "95 %, m", x: { label: "beam from the vertical, deg" }, y: { label: "m", log: true }, series, marks: orderLevels(limits, quantity, highest), width: 310, height: 250 });
}

function keptOrders(path) {
  return path.depths.map(depth => {
    const beams = depth.beams, orders = [...new Set(beams.map(b => b.order))];
    const words = orders.map(order => `${order ? `order ${order}` : "no order"}: ${beams.filter(b => b.order === order).length} of ${beams.length} beams`);
    return [BUDGET_PATHS[path.path].name, number(short(depth.depth_m)), words.join("; ")];
  });
}

function buildSwath() {
  const swath = RESULT.swath;
  if (!swath || !swath.paths.length) return;
  const paths = swathPaths();
  const entries = [...paths.map(p => ({ name: `${BUDGET_PATHS[p.path].name}: total`, colour: BUDGET_PATHS[p.path].colour, dash: "" })),
    { name: "calibration alone", colour: BUDGET_PATHS[paths[0].path].colour, dash: "2 3" }, { name: "INS and sonar alone", colour: "var(--soft)", dash: "7 4" }];
  const figures = quantity => swath.limits.map((limits, k) => swathPlot(limits, k, quantity, quantity === "vertical_m" ? "Vertical" : "Horizontal"));
  add("swath", "What it means for a sounding", keys(entries), el("div", { class: "row4" }, figures("vertical_m")), el("div", { class: "row4" }, figures("horizontal_m")),
    note(`Limits: ${swath.standard}. Assumed: ${swath.assumptions}. Covariance of the calibration: `, swath.paths.map(p => `${BUDGET_PATHS[p.path].name.toLowerCase()}, ${COVARIANCE_WORDS[p.origin]}`).join("; "), "."),
    table(["calibration by", number("depth, m"), "strictest order kept"], paths.flatMap(keptOrders)));
}

// SWEEP

const KEY_UNITS = [["_m_s", "m/s"], ["_deg", "deg"], ["_hz", "Hz"], ["_m", "m"], ["_s", "s"]];

/** A scenario's key as one would say it. */
function keyWords(key) {
  const unit = KEY_UNITS.find(([end]) => key.endsWith(end)), bare = unit ? key.slice(0, -unit[0].length) : key;
  const words = bare.split(".").map(part => part === "*" ? "of all" : /^\d+$/.test(part) ? String(Number(part) + 1) : part.replaceAll("_", " ")).join(" ");
  return unit ? `${words}, ${unit[1]}` : words;
}

const SWEEP_LINES = [
  { path: "reference", name: "reference: RMS error", colour: "var(--reference)", of: s => s.rms, dash: "" },
  { path: "reference", name: "reference: standard deviation", colour: "var(--reference)", of: s => s.standard_deviation, dash: "2 3", thin: true },
  { path: "reference_projected", name: "reference, projected: RMS error", colour: "var(--simple)", of: s => s.rms, dash: "" },
  { path: "joint", name: "joint: RMS error", colour: "var(--joint)", of: s => s.rms, dash: "" },
  { path: "joint", name: "joint: standard deviation", colour: "var(--joint)", of: s => s.standard_deviation, dash: "2 3", thin: true },
  { path: "joint", name: "joint: what it reports", colour: "var(--good)", of: s => s.reported && s.reported.standard_deviation, dash: "7 4" },
].filter(line => RESULT.paths.some(p => p.path === line.path));

function sweepCurves(sweep) {
  const x = abscissae(sweep.points.map(p => p.values[0]));
  const found = (line, i) => sweep.points.map((point, k) => {
    const s = point.paths.find(p => p.path === line.path), six = s ? shownOf(line.of(s)) : null;
    const ends = s && s.standard_deviation_interval;
    return [x.places[k], six ? six[i] : null, ends && six && !line.thin && !line.dash ? [six[i] * ends.lower, six[i] * ends.upper] : null];
  });
  const all = SOUGHT.map((_, i) => SWEEP_LINES.map(line => ({ ...line, points: found(line, i) })));
  const spread = Math.max(...all.map(lines => { const v = lines.flatMap(l => l.points.map(p => p[1])).filter(y => y > 0); return v.length ? Math.max(...v) / Math.min(...v) : 1; }));
  return SOUGHT.map((parameter, i) => plot({ title: parameter.name, sub: parameter.unit, x: { label: keyWords(sweep.keys[0]), log: x.log, words: x.words }, y: { label: parameter.unit, log: spread >= 5, also: spread >= 5 ? [] : [0] }, series: all[i] }));
}

function sweepMaps(sweep) {
  const distinct = k => { const list = []; for (const p of sweep.points) if (!list.includes(p.values[k])) list.push(p.values[k]); return list; };
  const rows = distinct(0), columns = distinct(1);
  const at = (path, i) => (r, c) => {
    const point = sweep.points.find(p => p.values[0] === rows[r] && p.values[1] === columns[c]), s = point && point.paths.find(p => p.path === path), six = s ? shownOf(s.rms) : null;
    return six ? six[i] : null;
  };
  return SOUGHT.flatMap((parameter, i) => {
    const paths = ["joint", "reference"], values = paths.flatMap(path => rows.flatMap((_, r) => columns.map((_, c) => at(path, i)(r, c)))).filter(v => v > 0);
    return paths.map(path => pairMap({ title: `${parameter.name}, ${BUDGET_PATHS[path].name.toLowerCase()}`, sub: `RMS error, ${parameter.unit}`, rows, columns, value: at(path, i), low: Math.min(...values), high: Math.max(...values), name: keyWords(sweep.keys[1]) }));
  });
}

function buildSweep() {
  const sweep = RESULT.sweep;
  if (!sweep) return;
  const single = sweep.keys.length === 1, lost = sweep.points.flatMap(p => p.refusals.map(r => `${p.values.join(", ")}: ${BUDGET_PATHS[r.path].name.toLowerCase()} ${r.count} (${r.example})`));
  add("sweep", `How it changes with ${sweep.keys.map(keyWords).join(" and ")}`, single ? keys(SWEEP_LINES) : note(`Rows: ${keyWords(sweep.keys[0])}; columns: ${keyWords(sweep.keys[1])}. Colours of a parameter have the same scale for both paths, logarithmic.`),
    el("div", { class: single ? "grid3" : "pairs" }, single ? sweepCurves(sweep) : sweepMaps(sweep)),
    note(sweep.trials ? `${sweep.trials} trials at each point, under the same seeds, so that differences are not noise. Bars: ${percent(RESULT.confidence)} of chance.` : "By propagation, without a trial.", lost.length ? ` Without a usable result: ${lost.join("; ")}.` : ""));
}
