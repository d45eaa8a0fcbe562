// The page of a rail calibration.

const SAMPLES = RESULT.samples;
const PATH_INK = { nominal: "#8a97a1", reference: "#b45309", joint: "#0b63a5", truth: "#1a7f4b" };
const PATH_NAMES = { nominal: "nominal", reference: "patent's path", joint: "joint" };
const NAMES = RESULT.counts.map(c => c.profiler);
const JOINT = RESULT.solutions.joint, REFERENCE = RESULT.solutions.reference;

function buildHead() {
  section("title").textContent = SAMPLES.title;
  section("version").textContent = `${RESULT.software.version}`;
  const head = section("headline");
  head.textContent = DATA.headline;
  if (!RESULT.usable) head.className = "refused";
  const used = RESULT.counts.reduce((sum, c) => sum + c.used, 0), read = RESULT.counts.reduce((sum, c) => sum + c.read, 0);
  section("footer").textContent = `${RESULT.software.name} ${RESULT.software.version}. The numbers of this page, in full precision, are in result.json beside it.`;
  section("chips").append(chip(RESULT.usable ? "usable" : "not usable", RESULT.usable ? "good" : "bad"), chip(RESULT.rail), chip(`${NAMES.length} profilers`),
    chip(`${RESULT.positions} positions, turned by ${short(RESULT.turned_deg[0])} and ${short(RESULT.turned_deg[1])} deg`), chip(`${grouped(used)} of ${grouped(read)} points used`));
}

// PROFILES

/** Paths that have points, in the order of drawing. */
function shownPaths() { return ["nominal", "reference", "joint"].filter(path => SAMPLES.profiles.some(p => p.path === path && p.points.length)); }

/** A view of the cross-section between (x1, z1) and (x2, z2), millimetres. */
function crossSection(label, view, width, radius, samples) {
  const [x1, x2, z1, z2] = view, size = width / (x2 - x1), height = (z2 - z1) * size;
  const at = (x, z) => [((x - x1) * size).toFixed(2), ((z2 - z) * size).toFixed(2)], inside = ([x, z]) => x >= x1 && x <= x2 && z >= z1 && z <= z2;
  const outline = SAMPLES.outline_mm.map(e => svg("polyline", { points: e.points.map(p => at(p[0], p[1]).join(",")).join(" "), fill: "none", stroke: e.region ? "#c0392b" : "#1c2730", "stroke-width": e.region ? 2.2 : 1.2 }, svg("title", {}, e.name)));
  const dots = samples.map(s => svg("g", { fill: PATH_INK[s.path], "fill-opacity": s.path === "nominal" ? 0.6 : 0.8 }, s.points.filter(inside).map(p => { const [cx, cy] = at(p[0], p[1]); return svg("circle", { cx, cy, r: radius }); })));
  const bar = roundUp((x2 - x1) / 8), [bx, by] = [10, height - 10];
  const scaleBar = [svg("line", { x1: bx, x2: bx + bar * size, y1: by, y2: by, stroke: "#1c2730", "stroke-width": 2 }), text(bx, by - 5, `${short(bar)} mm`, { class: "soft" })];
  return svg("svg", { viewBox: `0 0 ${width} ${height.toFixed(1)}`, width, height: height.toFixed(1), role: "img", "aria-label": label, style: "background:#f7f9fa;border:1px solid #d5dde3" }, outline, dots, scaleBar);
}

/** The region's middle on the side that a profiler sees. */
function regionMiddle(profiler, region) {
  const own = SAMPLES.profiles.find(p => p.profiler === profiler && p.path === (JOINT && JOINT.usable ? "joint" : "nominal"));
  if (!own || !own.points.length) return null;
  const mean = own.points.reduce((sum, p) => sum + p[0], 0) / own.points.length;
  const middles = SAMPLES.outline_mm.filter(e => e.region === region).map(e => e.points[Math.floor(e.points.length / 2)]);
  return middles.sort((a, b) => Math.abs(a[0] - mean) - Math.abs(b[0] - mean))[0];
}

function buildProfiles() {
  const paths = shownPaths(), all = SAMPLES.outline_mm.flatMap(e => e.points), xs = all.map(p => p[0]), zs = all.map(p => p[1]);
  const whole = [Math.min(...xs) - 12, Math.max(...xs) + 12, Math.min(...zs) - 6, Math.max(...zs) + 8];
  const sorted = paths.flatMap(path => SAMPLES.profiles.filter(p => p.path === path));
  const zooms = NAMES.flatMap((name, k) => [["line", "straight region"], ["arc", "arc region"]].map(([region, words]) => {
    const middle = regionMiddle(k, region);
    if (!middle) return null;
    const view = [middle[0] - 5, middle[0] + 5, middle[1] - 4, middle[1] + 4];
    return el("figure", {}, el("h3", {}, name, el("small", {}, `  ${words}`)), crossSection(`${name}, ${words}`, view, 310, 1.7, sorted.filter(s => s.profiler === k)));
  }));
  add("profiles", "Measured profiles on the standard profile", keys([...paths.map(path => ({ name: PATH_NAMES[path], colour: PATH_INK[path] })), { name: "regions of the patent's path", colour: "#c0392b" }]),
    el("div", { style: "display:flex;flex-wrap:wrap;gap:18px" }, el("figure", {}, crossSection("profiles on the standard profile", whole, 460, 1, sorted)), el("div", { style: "display:grid;grid-template-columns:310px 310px;gap:4px 16px;align-content:start" }, zooms)),
    note("Points at the position of the table nearest to level, under the nominal mounting and under the mounting of each path. The joint path stands on the table, rail and INS that it estimated, the others on those as known before."),
    table(["RMS distance of all points used", number("mm")], ["nominal", "reference", "joint"].filter(path => path in RESULT.residual_rms_m).map(path => [path, RESULT.residual_rms_m[path]]).map(([path, m]) => [PATH_NAMES[path] || path, number(digits(m * 1e3, 4))])));
}

// HAUSDORFF CURVES

function upright(x, low, high, colour, dash) { return { colour, dash, dots: false, thin: true, points: [[x, low], [x, high]] }; }

function jointAngle(k, which) { return JOINT && JOINT.mountings.length ? -JOINT.mountings[k].mounting_deg[which] : null; }

function sweepPlot(k, steps, which, title) {
  const values = steps.map(s => s.distance_m * 1e3), low = Math.min(...values), high = Math.max(...values), best = steps[values.indexOf(low)];
  const series = [{ colour: PATH_INK.reference, points: steps.map(s => [s.turn_deg, s.distance_m * 1e3]) }, upright(best.turn_deg, low, high, PATH_INK.reference, "5 3")];
  const joint = jointAngle(k, which);
  if (joint !== null) series.push(upright(joint, low, high, PATH_INK.joint, null));
  return plot({ title: `${NAMES[k]}: ${which}`, sub: title, x: { label: `${which} of the INS against the rail, deg` }, y: { label: "Hausdorff distance, mm" }, series, width: 560, height: 280 });
}

function buildSweeps() {
  if (!REFERENCE || !REFERENCE.usable) return;
  add("sweeps", "Hausdorff distance while the table turns", keys([{ name: "distance", colour: PATH_INK.reference, dash: "" }, { name: "its minimum: the patent's path", colour: PATH_INK.reference, dash: "5 3" }, { name: "where the joint solution compensates the bias", colour: PATH_INK.joint, dash: "" }]),
    el("div", { class: "grid2", style: "grid-template-columns:1fr 1fr" }, REFERENCE.steps.flatMap((s, k) => [sweepPlot(k, s.heading_sweep, "heading", "straight region, turn about the vertical"), sweepPlot(k, s.pitch_sweep, "pitch", "arc region, turn about the lateral axis")])),
    note("A minimum stands where the turn cancels the mounting's bias: bias = -(turn at the minimum). A distance that is a maximum over noisy points is flat near its minimum, so its place scatters."));
}

// RESIDUALS

function histogram(values, width) {
  const bins = 41, span = width * 2 / bins, counts = new Array(bins).fill(0);
  values.forEach(v => { const k = Math.floor((v + width) / span); if (k >= 0 && k < bins) counts[k]++; });
  return counts.map((count, k) => [-width + (k + 0.5) * span, count / (values.length * span)]);
}

function buildResiduals() {
  const all = SAMPLES.residuals;
  if (!all.length) return;
  const spread = Math.sqrt(all.reduce((sum, r) => sum + r.joint_mm ** 2, 0) / all.length), width = 5 * spread;
  const series = NAMES.map((name, k) => ({ colour: WHEEL[k], dots: false, points: histogram(all.filter(r => r.profiler === k).map(r => r.joint_mm), width) }));
  const normal = Array.from({ length: 101 }, (_, i) => { const x = -width + i * width / 50; return [x, Math.exp(-0.5 * (x / spread) ** 2) / (spread * Math.sqrt(2 * Math.PI))]; });
  const rows = SAMPLES.outline_mm.map((e, k) => ({ e, own: all.filter(r => r.element === k).map(r => r.joint_mm) })).filter(r => r.own.length > 5);
  const rms = list => Math.sqrt(list.reduce((sum, v) => sum + v * v, 0) / list.length), mean = list => list.reduce((sum, v) => sum + v, 0) / list.length;
  const places = [...new Set(all.map(r => r.position))].sort((a, b) => a - b);
  const byPosition = NAMES.map((name, k) => ({ colour: WHEEL[k], points: places.map(p => [p + 1, all.filter(r => r.position === p && r.profiler === k).map(r => r.joint_mm)]).filter(([, own]) => own.length > 5).map(([p, own]) => [p, mean(own)]) }));
  add("residuals", "Residuals of the joint solution", keys([...NAMES.map((name, k) => ({ name, colour: WHEEL[k], dash: "" })), { name: "normal of the same RMS", colour: "#8a97a1", dash: "4 3" }]),
    el("div", { class: "grid2", style: "grid-template-columns:1fr 1fr" }, plot({ title: "Distribution", sub: `${grouped(all.length)} points`, x: { label: "distance from the element, mm" }, y: { label: "density, 1/mm" }, series: [...series, { colour: "#8a97a1", dash: "4 3", dots: false, points: normal }], width: 560, height: 280 }),
      plot({ title: "Mean at each position", x: { label: "position of the table", whole: true }, y: { label: "mean distance, mm" }, series: byPosition, width: 560, height: 280 })),
    table(["element", number("points shown"), number("mean, mm"), number("RMS, mm")], rows.map(({ e, own }) => [e.name, number(String(own.length)), number(digits(mean(own), 4)), number(digits(rms(own), 4))])));
}

// TABLES

const inMillimetres = p => p.unit === "m" ? 1e3 : 1, shownUnit = p => p.unit === "m" ? "mm" : p.unit;
const scaled = (v, p) => missing(v) ? null : v * inMillimetres(p);

function buildParameters() {
  const first = JOINT && JOINT.parameters.length ? JOINT.parameters : REFERENCE ? REFERENCE.parameters : [];
  if (!first.length) return;
  const truth = SAMPLES.truth, old = k => REFERENCE && REFERENCE.parameters[k], fresh = k => JOINT && JOINT.parameters[k];
  const cell = p => p ? number(missing(p.standard_deviation) ? digits(scaled(p.value, p), 4) : withSigma(scaled(p.value, p), scaled(p.standard_deviation, p))) : number("-");
  const rows = first.map((p, k) => {
    const d = RESULT.comparison && RESULT.comparison.differences[k], f = fresh(k);
    const row = [`${p.name}, ${shownUnit(p)}`, cell(old(k)), cell(f), number(d ? digits(d.in_reference_sigmas, 1) : "-")];
    return truth ? [...row, number(digits(scaled(truth.corrections[k], p), 4)), number(f && !missing(f.standard_deviation) ? digits(truth.joint_errors[k] / f.standard_deviation, 1) : "-")] : row;
  });
  add("parameters", "Corrections to the nominal mountings", table(["correction", number("patent's path"), number("joint \u00b1 1 sigma"), number("difference, sigmas of joint"), ...(truth ? [number("truth"), number("joint's error, sigmas")] : [])], rows),
    RESULT.comparison ? note(`All differences together: chi-square ${short(RESULT.comparison.chi_square)} on ${RESULT.comparison.degrees_of_freedom} degrees of freedom, p ${probability(RESULT.comparison.p_value)}.`) : [],
    mountings());
}

function mountings() {
  const path = JOINT && JOINT.mountings.length ? JOINT : REFERENCE;
  if (!path || !path.mountings.length) return [];
  const row = m => [m.profiler, ...["roll", "pitch", "heading"].map(k => number(digits(m.mounting_deg[k], 4))), ...m.lever_arm_m.map(v => number(digits(v * 1e3, 3)))];
  return [el("h3", {}, `Mountings to enter (${path === JOINT ? "joint" : "patent's path"})`), table(["profiler", number("roll, deg"), number("pitch, deg"), number("heading, deg"), number("x right, mm"), number("y forward, mm"), number("z up, mm")], path.mountings.map(row))];
}

function buildAlong() {
  if (!JOINT || !JOINT.nuisance.length) return;
  const seen = JOINT.nuisance.filter(p => !p.name.startsWith("rail ") || p.name.startsWith("rail orientation"));
  add("along", "Estimated along", note("Changes from what was known before: every one of these entered with a prior. Lever arms along the rail (ly) are seen only through the table's turns."),
    table(["quantity", number("change \u00b1 1 sigma"), "unit"], seen.map(p => [p.name, number(withSigma(scaled(p.value, p), scaled(p.standard_deviation, p))), shownUnit(p)])));
}

function buildQuality() {
  const q = JOINT && JOINT.quality;
  if (!q) return;
  const t = q.global_test;
  add("quality", "Tests of the joint solution",
    table(["test", "value"], [["variance factor", number(digits(q.variance_factor, 4))], ["interval", number(`${digits(t.lower, 4)} to ${digits(t.upper, 4)}`)], ["verdict", t.void_because ? `void: ${t.void_because}` : t.passed ? "passed" : "failed"], ["degrees of freedom", number(grouped(q.degrees_of_freedom))]]),
    el("h3", {}, "Observations"), table(["group", number("conditions"), number("redundancy"), number("variance component"), "how"], q.groups.map(g => [g.name, number(grouped(g.observations)), number(digits(g.redundancy, 1)), number(withSigma(g.variance_component, g.standard_deviation)), g.note || ""])),
    el("h3", {}, "Largest normalised residuals"), table(["observation", number("|w|"), number("detectable bias, mm")], q.reliability.worst.slice(0, 10).map(w => [w.observation, number(digits(Math.abs(w.w), 2)), number(digits(w.minimal_detectable_bias_m * 1e3, 3))])),
    q.observability.weak.length ? [el("h3", {}, "Weakly determined"), el("ul", { class: "weak" }, q.observability.weak.map(w => el("li", {}, w.text)))] : []);
}

function buildEnd() {
  const rejected = c => Object.entries(c.rejected).map(([why, n]) => `${grouped(n)} ${why}`).join(", ");
  add("notes", "Data and notes", table(["profiler", number("read"), number("used"), "left out"], RESULT.counts.map(c => [c.profiler, number(grouped(c.read)), number(grouped(c.used)), rejected(c)])),
    el("ul", { class: "weak" }, RESULT.notes.map(words => el("li", {}, words))),
    [REFERENCE, JOINT].filter(s => s && s.message).map(s => el("p", {}, s.message)),
    table(["input", "SHA-256"], RESULT.inputs.map(i => [i.path, mono(i.sha256)])));
}

[buildHead, buildProfiles, buildSweeps, buildResiduals, buildParameters, buildAlong, buildQuality, buildEnd].forEach(build => build());

document.documentElement.dataset.ready = "yes";
