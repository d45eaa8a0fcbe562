// The budget's page from top to bottom, and its tables.

function buildHead() {
  section("version").textContent = RESULT.software.version;
  section("title").textContent = RESULT.scenario;
  section("headline").textContent = DATA.headline;
  const joint = RESULT.paths.find(p => p.path === "joint"), together = joint && joint.together, reported = together && together.reported, chips = [];
  chips.push(chip(RESULT.trials ? `${grouped(RESULT.trials)} trials of all sources` : "no trials"));
  if (RESULT.single_trials) chips.push(chip(`${grouped(RESULT.single_trials)} of each alone`));
  if (RESULT.paths.some(p => p.shares.some(s => s.origin === "analytic"))) chips.push(chip("analytic propagation"));
  if (RESULT.paths.some(p => p.agreement && p.agreement.length)) chips.push(agreementChip());
  if (together && together.trials) chips.push(chip(`joint path: ${grouped(together.usable)} usable`, together.usable === together.trials ? "good" : together.usable ? "warn" : "bad"));
  if (reported && reported.nees) {
    const n = reported.nees, inside = n.mean >= n.interval.lower && n.mean <= n.interval.upper;
    chips.push(chip(`NEES ${digits(n.mean, 2)} of ${n.parameters}: reported uncertainty ${inside ? "true" : "not true"} within chance`, inside ? "good" : "warn"));
  }
  section("chips").append(...chips);
  section("footer").textContent = `${RESULT.software.name} ${RESULT.software.version}, first seed ${RESULT.first_seed}. The numbers of this page, in full precision, are in result.json beside it.`;
}

function agreementChip() {
  const all = RESULT.paths.flatMap(p => p.agreement || []), outside = all.reduce((sum, a) => sum + a.outside.length, 0), of = all.reduce((sum, a) => sum + Object.keys(a.variance_ratio).length, 0);
  return chip(outside ? `analytic and Monte Carlo differ in ${outside} of ${of} comparisons` : `analytic and Monte Carlo agree in all ${of} comparisons`, outside ? "warn" : "good");
}

// TABLES

const UNITS = SOUGHT.map(p => number(`${p.name}, ${p.unit}`));

function cellsOf(six, show = short) { return shownOf(six) ? shownOf(six).map(v => number(show(v))) : SOUGHT.map(() => number("-")); }

function withError(value, error) { const v = shownOf(value), e = shownOf(error); return v ? v.map((x, i) => number(e && e[i] > 0 ? withSigma(x, e[i]) : short(x))) : SOUGHT.map(() => number("-")); }

/** At most 1: no path does better than the bound; counted over trials an interval. */
function efficiency(path, i) {
  const value = path.efficiency[i], s = path.together, ends = s && s.usable >= TELLING && s.standard_deviation_interval;
  const end = factor => digits(Math.min(1, value / factor ** 2), 2);
  return missing(value) ? "-" : ends ? `${end(ends.upper)} to ${end(ends.lower)}` : digits(Math.min(1, value), 2);
}

function buildFigures() {
  const rows = RESULT.paths.flatMap(path => {
    const s = path.together, name = el("b", {}, pathName(path)), list = [];
    if (s) list.push(["bias", ...withError(s.bias, s.bias_standard_error)], ["standard deviation", ...cellsOf(s.standard_deviation)], ["root mean square", ...cellsOf(s.rms)]);
    if (s && s.reported) list.push(["reported standard deviation", ...cellsOf(s.reported.standard_deviation)]);
    if (path.predicted) list.push(["bias, propagated", ...cellsOf(path.predicted.bias)], ["standard deviation, propagated", ...cellsOf(path.predicted.standard_deviation)]);
    if (path.claimed) list.push(["stated before any trial", ...cellsOf(path.claimed)]);
    if (path.bound) list.push(["Cramer-Rao bound", ...cellsOf(path.bound)]);
    if (path.efficiency) list.push(["efficiency", ...SOUGHT.map((_, i) => number(efficiency(path, i)))]);
    return list.map((row, i) => [i ? "" : name, ...row]);
  });
  if (!rows.length) return;
  const interval = RESULT.paths.map(p => p.together && p.together.standard_deviation_interval).find(i => i);
  add("figures", "All sources together", table(["path", "figure", ...UNITS], rows),
    interval ? note(`Standard deviations are known to a factor of ${digits(interval.lower, 3)} to ${digits(interval.upper, 3)} (${percent(RESULT.confidence)}, chi-square).`) : "");
}

/** Each source's way and what `of` says of it, one row each, sources without any left out. */
function shareRows(path, of) {
  return ORIGINS.flatMap(([origin, way]) => path.shares.filter(s => s.origin === origin && of(s)).map(s => [
    el("span", {}, titleOf(s.source), s.note && s.source !== "nothing" ? el("div", {}, el("small", {}, s.note)) : ""), way, ...of(s).map(v => number(v)), number(s.trials ? `${grouped(s.usable)} of ${grouped(s.trials)}` : "-")]));
}

const deviations = s => s.standard_deviation ? shownOf(s.standard_deviation).map(short) : null;
const percents = s => s.share ? SOUGHT.map((_, i) => missing(s.share[i]) ? "-" : digits(100 * s.share[i], 1)) : null;

function biasRows(path) {
  return path.shares.filter(s => s.bias && Math.max(...shownOf(s.bias).map(Math.abs)) > 0).map(s => [titleOf(s.source), ORIGINS.find(o => o[0] === s.origin)[1], ...withError(s.bias, s.bias_standard_error)]);
}

function buildSourceTables() {
  const paths = RESULT.paths.filter(path => path.shares.length);
  if (!paths.length) return;
  const heads = [["standard deviation", UNITS, deviations], ["share of the variance, %", SOUGHT.map(p => number(p.name)), percents]];
  add("alone", "Source by source", paths.flatMap(path => [
    ...heads.flatMap(([words, columns, of]) => shareRows(path, of).length ? [folded(`${pathName(path)}: ${words}`, table(["source", "way", ...columns, number("usable")], shareRows(path, of)))] : []),
    ...(biasRows(path).length ? [folded(`${pathName(path)}: bias`, table(["source", "way", ...UNITS], biasRows(path)))] : [])]));
}

function buildSources() {
  if (!RESULT.sources.length) return;
  const sizes = s => Object.entries(s.size || {}).map(([key, value]) => el("div", { class: "mono" }, `${key} = ${value}`));
  const defaults = s => Object.entries(s.default || {}).map(([key, value]) => `${key} ${value}`).join(", ") || "-";
  const columns = [["source", s => el("b", {}, s.title)], ["distribution", s => s.description], ["size in this scenario", s => el("span", {}, sizes(s)), s => sizes(s).length], ["default", defaults, s => defaults(s) !== "-"], ["reference", s => el("small", {}, s.reference), s => s.reference]];
  const filled = columns.filter(([, , has]) => !has || RESULT.sources.some(has));
  add("sources", "Sources in this scenario", table(filled.map(([name]) => name), RESULT.sources.map(s => filled.map(([, of]) => of(s)))));
}

function buildAgreement() {
  const rows = RESULT.paths.flatMap(path => (path.agreement || []).map(a => [pathName(path), a.source === "together" ? "all together" : titleOf(a.source),
    ...SOUGHT.map(p => number(missing(a.variance_ratio[p.name]) ? "-" : `${digits(a.variance_ratio[p.name], 3)}${a.outside.includes(p.name) ? " !" : ""}`)),
    number(`${digits(a.interval.lower, 3)} to ${digits(a.interval.upper, 3)}`), a.note || ""]));
  if (!rows.length) return;
  const comparisons = RESULT.paths.flatMap(p => p.agreement || []).map(a => a.comparisons)[0];
  add("agreement", "Analytic propagation against Monte Carlo", table(["path", "source", ...SOUGHT.map(p => number(p.name)), number("interval"), "why, where they differ"], rows),
    note(`Variance of the trials divided by analytic variance. Interval: chi-square, for ${comparisons} comparisons at once (Sidak). An exclamation mark: outside it.`));
}

function buildSweepTable() {
  const sweep = RESULT.sweep;
  if (!sweep) return;
  const rows = sweep.points.flatMap(point => point.paths.map(s => [...point.values.map(v => number(String(v))), BUDGET_PATHS[s.path].name, number(s.trials ? `${s.usable} of ${s.trials}` : "-"), ...cellsOf(s.rms), number(s.reported && s.reported.nees ? digits(s.reported.nees.mean, 2) : "-")]));
  add("sweep-table", "Sweep: root mean square error", table([...sweep.keys.map(key => number(keyWords(key))), "path", number("usable"), ...UNITS, number("NEES")], rows));
}

function buildSwathTable() {
  if (!RESULT.swath || !RESULT.swath.paths.length) return;
  const both = u => number(`${short(u.horizontal_m)} / ${short(u.vertical_m)}`);
  const rows = swathPaths().flatMap(path => path.depths.flatMap(d => d.beams.filter(b => Math.abs(b.angle_deg % 20) < 1e-9 || Math.abs(b.angle_deg) === 70).map(b => [BUDGET_PATHS[path.path].name, number(short(d.depth_m)), number(short(b.angle_deg)), both(b.calibration), both(b.sensors), both(b.total), b.order || "none"])));
  add("swath-table", "Soundings: horizontal / vertical uncertainty, 95 %, m", folded("Beam by beam", table(["calibration by", number("depth, m"), number("beam, deg"), number("calibration"), number("INS and sonar"), number("total"), "order kept"], rows)));
}

function buildRefusals() {
  if (!RESULT.refusals.length) return;
  add("refusals", "Trials without a usable result", table(["path", number("trials"), "seeds", "reason given by the first"], RESULT.refusals.map(r => [BUDGET_PATHS[r.path].name, number(grouped(r.count)), r.seeds.join(", ") + (r.count > r.seeds.length ? ", ..." : ""), r.example])));
}

function buildEnd() {
  const notes = RESULT.notes || [];
  if (notes.length) add("notes", "Notes", el("ul", { class: "weak" }, notes.map(words => el("li", {}, words))));
  add("configuration", "Configuration", RESULT.command ? [el("h3", {}, "Command"), el("pre", {}, RESULT.command)] : [], folded("Configuration of both paths", el("pre", {}, JSON.stringify(RESULT.configuration, null, 2))),
    note(`Scenario SHA-256 (without its seed): ${RESULT.scenario_sha256}`));
}

[buildHead, buildSweep, buildShares, buildTornado, buildPaths, buildSwath, buildHonesty, buildFigures, buildSourceTables, buildAgreement, buildSweepTable, buildSwathTable, buildSources, buildRefusals, buildEnd, buildContents].forEach(build => build());

document.documentElement.dataset.ready = "yes";
