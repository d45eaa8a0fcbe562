// Whether the reported uncertainty is true, and how near the paths come to the bound.

function pullPlot(reported) {
  const left = Math.max(92, NAME_WIDTH), width = left + 348, right = 16, top = 8, row = 26, bottom = top + row * SOUGHT.length, ends = reported.pull_rms_interval;
  const values = [...reported.pull_rms, ...reported.pull_mean], reach = Math.max(1.2, ends.upper, ...values) * 1.06, low = Math.min(-0.3, ...values) * 1.1;
  const at = v => left + (v - low) / (reach - low) * (width - left - right);
  const grid = ticks(low, reach, 6).flatMap(v => [svg("line", { x1: at(v), x2: at(v), y1: top, y2: bottom, stroke: INK.line }), text(at(v), bottom + 15, tickLabel(v, roundUp((reach - low) / 6)), { "text-anchor": "middle", class: "soft" })]);
  const band = [svg("rect", { x: at(ends.lower), y: top, width: at(ends.upper) - at(ends.lower), height: bottom - top, fill: "var(--good)", "fill-opacity": 0.14 }),
    svg("line", { x1: at(1), x2: at(1), y1: top, y2: bottom, stroke: "var(--good)" })];
  const rows = SOUGHT.flatMap((p, i) => {
    const y = top + (i + 0.5) * row, rms = reported.pull_rms[i], inside = rms >= ends.lower && rms <= ends.upper;
    return [text(left - 8, y + 4, p.name, { "text-anchor": "end" }), svg("circle", { cx: at(rms), cy: y, r: 5, fill: inside ? "var(--joint)" : "var(--bad)" }), svg("circle", { cx: at(reported.pull_mean[i]), cy: y, r: 4, fill: "#fff", stroke: "var(--joint)", "stroke-width": 1.6 })];
  });
  return el("figure", {}, el("h3", {}, "Pulls of the joint path"), picture(width, bottom + 22, "pulls", grid, band, rows),
    el("figcaption", {}, "Error divided by reported sigma. Full dot: root mean square, 1 when the reported uncertainty is right; red outside the green interval (chi-square, for this number of trials). Ring: mean."));
}

/** Standard deviations by the bound, one row per parameter. */
function boundPlot() {
  const paths = RESULT.paths.filter(p => p.bound && p.efficiency);
  if (!paths.length) return [];
  const left = Math.max(92, NAME_WIDTH), width = left + 348, right = 16, top = 8, row = 26, bottom = top + row * SOUGHT.length;
  const ratio = (path, p) => 1 / Math.sqrt(path.efficiency[p.index]), values = paths.flatMap(path => SOUGHT.map(p => ratio(path, p))).filter(Number.isFinite);
  const across = scale([...values, 1, 1.6], true, left, width - right, 4);
  const grid = across.ticks.flatMap(([v, words]) => [svg("line", { x1: across.at(v), x2: across.at(v), y1: top, y2: bottom, stroke: INK.line }), text(across.at(v), bottom + 15, words, { "text-anchor": "middle", class: "soft" })]);
  const rows = SOUGHT.flatMap((p, i) => [text(left - 8, top + (i + 0.5) * row + 4, p.name, { "text-anchor": "end" }),
    ...paths.filter(path => Number.isFinite(ratio(path, p))).map((path, k) => svg("circle", { cx: across.at(ratio(path, p)), cy: top + (i + 0.5) * row + 6 * (k - (paths.length - 1) / 2), r: 4.5, fill: BUDGET_PATHS[path.path].colour }))]);
  return [el("figure", {}, el("h3", {}, "Standard deviation / Cramer-Rao bound"), keys(paths.map(path => ({ name: pathName(path), colour: BUDGET_PATHS[path.path].colour }))),
    picture(width, bottom + 22, "standard deviation / bound", grid, svg("line", { x1: across.at(1), x2: across.at(1), y1: top, y2: bottom, stroke: "var(--good)", "stroke-width": 1.6 }), rows),
    el("figcaption", {}, "1 is the best that any unbiased path could do with these observations; the efficiency is the inverse square."))];
}

function honestyTable(reported) {
  const ends = reported.pull_rms_interval, rows = SOUGHT.map((p, i) => [p.name, number(digits(reported.pull_mean[i], 3)), number(digits(reported.pull_rms[i], 3)), number(`${digits(ends.lower, 3)} to ${digits(ends.upper, 3)}`)]);
  const nees = reported.nees, further = [];
  if (nees) further.push(["NEES, mean", number(digits(nees.mean, 3)), `${digits(nees.interval.lower, 3)} to ${digits(nees.interval.upper, 3)} when true (${nees.parameters} expected), ${grouped(nees.trials)} trials`]);
  if (!missing(reported.variance_factor)) further.push(["variance factor, mean", number(digits(reported.variance_factor, 4)), "1 expected"]);
  return el("div", {}, table(["parameter", number("pull, mean"), number("pull, RMS"), number("RMS expected")], rows), further.length ? table(["figure", number("value"), ""], further) : "");
}

/** Standard deviations of every path in units of the joint path's, one row per parameter. */
function buildPaths() {
  const paths = RESULT.paths.filter(p => p.together && p.together.standard_deviation), joint = paths.find(p => p.path === "joint");
  if (!joint || paths.length < 2) return;
  const own = joint.together.standard_deviation, row = 24, left = Math.max(92, NAME_WIDTH), width = left + 360, top = 6, bottom = top + row * SOUGHT.length;
  const ratio = (path, i) => path.together.standard_deviation[i] / own[i], rms = (path, i) => path.together.rms ? path.together.rms[i] / own[i] : NaN;
  const all = paths.flatMap(path => SOUGHT.flatMap((_, i) => [ratio(path, i), rms(path, i)])).filter(v => Number.isFinite(v) && v > 0);
  const across = scale([1, 2, ...all], true, left, width - 16, 5);
  const grid = across.ticks.flatMap(([v, words]) => [svg("line", { x1: across.at(v), x2: across.at(v), y1: top, y2: bottom, stroke: INK.line }), text(across.at(v), bottom + 15, words, { "text-anchor": "middle", class: "soft" })]);
  const dot = (v, y, path, ring) => Number.isFinite(v) && v > 0 ? svg("circle", { cx: across.at(v), cy: y, r: ring ? 4 : 4.5, fill: ring ? "none" : BUDGET_PATHS[path.path].colour, stroke: BUDGET_PATHS[path.path].colour, "stroke-width": 1.6 }) : [];
  const rows = SOUGHT.flatMap((p, i) => {
    const y = top + (i + 0.5) * row;
    return [text(left - 8, y + 4, p.name, { "text-anchor": "end" }), ...paths.flatMap(path => [dot(ratio(path, i), y, path), rms(path, i) > 1.02 * ratio(path, i) ? dot(rms(path, i), y, path, true) : []])];
  });
  add("paths", "The paths against each other", keys(paths.map(path => ({ name: pathName(path), colour: BUDGET_PATHS[path.path].colour }))), el("figure", {}, picture(width, bottom + 22, "standard deviations of the paths", grid, rows),
    el("figcaption", {}, "Standard deviation divided by that of the joint path. Ring: root mean square error, where bias makes it larger.")));
}

function buildHonesty() {
  const joint = RESULT.paths.find(p => p.path === "joint"), reported = joint && joint.together && joint.together.reported, bound = boundPlot();
  if (!reported && !bound.length) return;
  add("honesty", "Is the reported uncertainty right, and how near is the bound?", el("div", { class: "grid2" }, reported ? pullPlot(reported) : [], bound, reported ? honestyTable(reported) : []));
}
