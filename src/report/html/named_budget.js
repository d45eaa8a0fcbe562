// The budget of named parameters: which source costs how much, by which path, and whether the reported uncertainty is true.

const NAMED_PATHS = { joint: { name: "Joint", colour: "#0b63a5" }, reference: { name: "Reference", colour: "#b45309" } };
const NAMES = RESULT.parameters.map(p => p.name);
const SOURCE_TITLES = Object.fromEntries(RESULT.sources.map(s => [s.source, s.title]));
SOURCE_TITLES.nothing = "the method itself, without any source";
const SOURCE_COLOURS = Object.fromEntries(RESULT.sources.map((s, i) => [s.source, WHEEL[i % WHEEL.length]]));
const WIDE_NAMES = 12 + 6.3 * Math.max(...NAMES.map(n => n.length));

const alone = path => path.shares.filter(s => s.source !== "nothing" && s.share);

function head() {
  section("version").textContent = RESULT.software.version;
  section("title").textContent = RESULT.scenario;
  section("headline").textContent = DATA.headline;
  const joint = RESULT.paths.find(p => p.path === "joint"), chips = [chip(`${grouped(RESULT.trials)} trials of all sources`)];
  if (RESULT.single_trials) chips.push(chip(`${grouped(RESULT.single_trials)} of each alone`));
  if (joint.together) chips.push(chip(`joint path: ${grouped(joint.together.usable)} usable`, joint.together.usable === joint.together.trials ? "good" : "warn"));
  const nees = joint.honesty && joint.honesty.nees;
  if (nees) {
    const inside = nees.mean >= nees.interval.lower && nees.mean <= nees.interval.upper;
    chips.push(chip(`NEES ${digits(nees.mean, 2)} of ${NAMES.length}: reported uncertainty ${inside ? "true" : "not true"} within chance`, inside ? "good" : "warn"));
  }
  section("chips").append(...chips);
  section("footer").textContent = `${RESULT.software.name} ${RESULT.software.version}, first seed ${RESULT.first_seed}. ${RESULT.command}. The numbers of this page, in full precision, are in result.json beside it.`;
}

/** Stacked shares of variance, one bar per parameter. */
function shareBars(path) {
  const shares = alone(path);
  if (!shares.length) return [];
  const row = 26, left = WIDE_NAMES, width = left + 340, right = 20, top = 4, bottom = top + row * NAMES.length;
  const total = i => shares.reduce((sum, s) => sum + (s.share[i] || 0), 0), end = Math.max(1, ...NAMES.map((_, i) => total(i)).filter(Number.isFinite));
  const at = v => left + v / end * (width - left - right);
  const grid = ticks(0, end, 5).flatMap(v => [svg("line", { x1: at(v), x2: at(v), y1: top, y2: bottom, stroke: v === 1 ? "#5b6b78" : INK.line }), text(at(v), bottom + 15, `${Math.round(100 * v)} %`, { "text-anchor": "middle", class: "soft" })]);
  const bars = NAMES.flatMap((name, i) => {
    let from = 0;
    return [text(left - 7, top + (i + 0.5) * row + 4, name, { "text-anchor": "end" }), ...shares.filter(s => s.share[i] > 0).map(s => {
      const rect = svg("rect", { x: at(from), y: top + i * row + 5, width: Math.max(0.3, at(from + s.share[i]) - at(from) - 0.4), height: 16, fill: SOURCE_COLOURS[s.source] },
        svg("title", {}, `${SOURCE_TITLES[s.source]}: ${percent(s.share[i])} of the variance of ${name}`));
      from += s.share[i];
      return rect;
    })];
  });
  return [el("figure", {}, el("h3", {}, NAMED_PATHS[path.path].name), picture(width, bottom + 22, `shares of variance, ${path.path}`, grid, bars))];
}

function buildShareBars() {
  const figures = RESULT.paths.flatMap(shareBars);
  if (!figures.length) return;
  add("shares", "Which source costs how much", keys(RESULT.sources.map(s => ({ name: s.title, colour: SOURCE_COLOURS[s.source] }))), el("div", { class: "grid2" }, figures),
    note("Share of each source, acting alone, in the variance of each parameter with all sources together. Chance and what the sources do to each other make the sum differ from 100 %."));
}

/** Both paths' standard deviations, one row per parameter, in units of the joint path's. */
function buildPaths() {
  const [joint, reference] = RESULT.paths;
  if (!joint.together || !joint.together.standard_deviation || !reference.together || !reference.together.standard_deviation) return;
  const own = joint.together.standard_deviation, row = 24, left = WIDE_NAMES, width = left + 360, top = 6, bottom = top + row * NAMES.length;
  const ratio = (path, i) => path.together.standard_deviation[i] / own[i], rms = (path, i) => Math.hypot(path.together.standard_deviation[i], path.together.bias[i]) / own[i];
  const across = scale([1, 2, ...NAMES.flatMap((_, i) => [ratio(reference, i), rms(reference, i)]).filter(v => Number.isFinite(v) && v > 0)], true, left, width - 16, 5);
  const grid = across.ticks.flatMap(([v, words]) => [svg("line", { x1: across.at(v), x2: across.at(v), y1: top, y2: bottom, stroke: INK.line }), text(across.at(v), bottom + 15, words, { "text-anchor": "middle", class: "soft" })]);
  const dots = NAMES.flatMap((name, i) => [text(left - 8, top + (i + 0.5) * row + 4, name, { "text-anchor": "end" }), ...RESULT.paths.flatMap(path => [
    Number.isFinite(ratio(path, i)) ? svg("circle", { cx: across.at(ratio(path, i)), cy: top + (i + 0.5) * row, r: 4.5, fill: NAMED_PATHS[path.path].colour }) : [],
    Number.isFinite(rms(path, i)) && rms(path, i) > 1.02 * ratio(path, i) ? svg("circle", { cx: across.at(rms(path, i)), cy: top + (i + 0.5) * row, r: 4, fill: "none", stroke: NAMED_PATHS[path.path].colour, "stroke-width": 1.6 }) : []])]);
  add("paths", "The two paths", keys(Object.values(NAMED_PATHS)), el("figure", {}, picture(width, bottom + 22, "standard deviations of both paths", grid, dots),
    el("figcaption", {}, "Standard deviation by that of the joint path. Ring: root mean square error, where bias makes it larger.")));
}

function buildPulls() {
  const honesty = RESULT.paths[0].honesty;
  if (!honesty) return;
  const left = WIDE_NAMES, width = left + 360, right = 16, top = 8, row = 24, bottom = top + row * NAMES.length, ends = honesty.pull_rms_interval;
  const values = [...honesty.pull_rms, ...honesty.pull_mean], reach = Math.max(1.2, ends.upper, ...values) * 1.06, low = Math.min(-0.3, ...values) * 1.1;
  const at = v => left + (v - low) / (reach - low) * (width - left - right);
  const grid = ticks(low, reach, 6).flatMap(v => [svg("line", { x1: at(v), x2: at(v), y1: top, y2: bottom, stroke: INK.line }), text(at(v), bottom + 15, tickLabel(v, roundUp((reach - low) / 6)), { "text-anchor": "middle", class: "soft" })]);
  const band = svg("rect", { x: at(ends.lower), y: top, width: at(ends.upper) - at(ends.lower), height: bottom - top, fill: "#1a7f4b", "fill-opacity": 0.14 });
  const dots = NAMES.flatMap((name, i) => {
    const y = top + (i + 0.5) * row, rms = honesty.pull_rms[i], inside = rms >= ends.lower && rms <= ends.upper;
    return [text(left - 8, y + 4, name, { "text-anchor": "end" }), svg("circle", { cx: at(rms), cy: y, r: 5, fill: inside ? "#0b63a5" : "#b3261e" }), svg("circle", { cx: at(honesty.pull_mean[i]), cy: y, r: 4, fill: "#fff", stroke: "#0b63a5", "stroke-width": 1.6 })];
  });
  add("honesty", "Is the reported uncertainty true?", el("figure", {}, picture(width, bottom + 22, "pulls", grid, band, dots),
    el("figcaption", {}, "Error by reported sigma. Full dot: root mean square, 1 when the reported uncertainty is true; red outside the green interval of chi-square for this number of trials. Ring: mean.")));
}

/** Metres as millimetres, ratios as parts per million. */
const SHOWN = { m: ["mm", 1e3], 1: ["ppm", 1e6] };
const SHOWN_NAMES = RESULT.parameters.map(p => `${p.name}, ${(SHOWN[p.unit] || [p.unit])[0]}`);
function shown(list, i) { return number(list && !missing(list[i]) ? short(list[i] * (SHOWN[RESULT.parameters[i].unit] || ["", 1])[1]) : "-"); }

function buildTables() {
  const rows = RESULT.paths.filter(p => p.together).flatMap(path => NAMES.map((_, i) => {
    const t = path.together, h = path.honesty;
    return [i ? "" : el("b", {}, NAMED_PATHS[path.path].name), SHOWN_NAMES[i], shown(t.bias, i), shown(t.standard_deviation, i), shown(h && h.reported, i), shown(path.claimed, i),
      number(h ? digits(h.pull_mean[i], 3) : "-"), number(h ? digits(h.pull_rms[i], 3) : "-"), number(path.path === "joint" || !path.efficiency ? "-" : short(path.efficiency[i]))];
  }));
  if (rows.length) add("figures", "All sources together", table(["path", "parameter", number("bias"), number("standard deviation"), number("reported"), number("stated before any trial"), number("pull, mean"), number("pull, RMS"), number("joint variance by its own")], rows));
  for (const path of RESULT.paths) {
    const parts = path.shares.filter(s => s.figures && (s.figures.standard_deviation || s.source === "nothing"));
    if (parts.length) add(`alone-${path.path}`, `Source by source, ${NAMED_PATHS[path.path].name.toLowerCase()} path: standard deviation`,
      table(["source", ...SHOWN_NAMES.map(number), number("usable")], parts.map(s => [SOURCE_TITLES[s.source], ...NAMES.map((_, i) => shown(s.figures.standard_deviation || s.figures.bias, i)), number(`${grouped(s.figures.usable)} of ${grouped(s.figures.trials)}`)])), note("Of the method itself: its error without any source."));
  }
  add("sources", "Sources that act", table(["source", "distribution and size"], RESULT.sources.map(s => [el("b", {}, s.title), s.description])));
  const losses = [...RESULT.refusals.map(r => [r.path, number(grouped(r.count)), r.reason, el("small", {}, r.seeds.join(", "))])];
  if (losses.length) add("refusals", "Trials without a result", table(["path", number("trials"), "why", "seeds"], losses));
  if (RESULT.notes.length) add("notes", "Notes", ...RESULT.notes.map(n => el("p", {}, n)));
}

head();
buildShareBars();
buildPaths();
buildPulls();
buildTables();
