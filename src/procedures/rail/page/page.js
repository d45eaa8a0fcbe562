// A rail calibration's own sections.

const SAMPLES = DATA.page;
const PATH_INK = { nominal: "#8a97a1", reference: "var(--reference)", joint: "var(--joint)" };
const PATH_NAMES = { nominal: "nominal", reference: "reference", joint: "joint" };
const JOINT = RESULT.solutions.joint, REFERENCE = RESULT.solutions.reference;
const NAMES = Object.keys(RESULT.counts);

// PROFILES

/** Paths that have points, in the order of drawing. */
function shownPaths() { return ["nominal", "reference", "joint"].filter(path => SAMPLES.profiles.some(p => p.path === path && p.points.length)); }

/** A view of the cross-section between (x1, z1) and (x2, z2), millimetres. */
function crossSection(label, view, width, radius, samples) {
  const [x1, x2, z1, z2] = view, size = width / (x2 - x1), height = (z2 - z1) * size;
  const at = (x, z) => [((x - x1) * size).toFixed(2), ((z2 - z) * size).toFixed(2)], inside = ([x, z]) => x >= x1 && x <= x2 && z >= z1 && z <= z2;
  const outline = SAMPLES.outline_mm.map(e => svg("polyline", { points: e.points.map(p => at(p[0], p[1]).join(",")).join(" "), fill: "none", stroke: e.region ? "#c0392b" : INK.ink, "stroke-width": e.region ? 2.2 : 1.2 }, svg("title", {}, e.name)));
  const dots = samples.map(s => svg("g", { fill: PATH_INK[s.path], "fill-opacity": s.path === "nominal" ? 0.6 : 0.8 }, s.points.filter(inside).map(p => { const [cx, cy] = at(p[0], p[1]); return svg("circle", { cx, cy, r: radius }); })));
  const bar = roundUp((x2 - x1) / 8), [bx, by] = [10, height - 10];
  const scaleBar = [svg("line", { x1: bx, x2: bx + bar * size, y1: by, y2: by, stroke: INK.ink, "stroke-width": 2 }), text(bx, by - 5, `${short(bar)} mm`, { class: "soft" })];
  return svg("svg", { viewBox: `0 0 ${width} ${height.toFixed(1)}`, width, height: height.toFixed(1), role: "img", "aria-label": label, style: "background:var(--wash);border:1px solid var(--line)" }, outline, dots, scaleBar);
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
  add("profiles", "Measured profiles on the standard profile", keys([...paths.map(path => ({ name: PATH_NAMES[path], colour: PATH_INK[path] })), { name: "regions of the reference path", colour: "#c0392b" }]),
    el("div", { style: "display:flex;flex-wrap:wrap;gap:18px" }, el("figure", {}, crossSection("profiles on the standard profile", whole, 460, 1, sorted)), el("div", { style: "display:grid;grid-template-columns:repeat(auto-fit,minmax(min(260px,100%),1fr));gap:4px 16px;align-content:start;flex:1 1 260px" }, zooms)),
    note("Points at the position of the table nearest to level, under the nominal mounting and under the mounting of each path. The joint path stands on the table, rail and INS that it estimated, the others on those as known before."));
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
  add("sweeps", "Hausdorff distance while the table turns", keys([{ name: "distance", colour: PATH_INK.reference, dash: "" }, { name: "its minimum: the reference path", colour: PATH_INK.reference, dash: "5 3" }, { name: "where the joint solution compensates the bias", colour: PATH_INK.joint, dash: "" }]),
    el("div", { class: "row2" }, REFERENCE.details.steps.flatMap((s, k) => [sweepPlot(k, s.heading_sweep, "heading", "straight region, turn about the vertical"), sweepPlot(k, s.pitch_sweep, "pitch", "arc region, turn about the lateral axis")])),
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
    el("div", { class: "row2" }, plot({ title: "Distribution", sub: `${grouped(all.length)} points`, x: { label: "distance from the element, mm" }, y: { label: "density, 1/mm" }, series: [...series, { colour: "#8a97a1", dash: "4 3", dots: false, points: normal }], width: 560, height: 280 }),
      plot({ title: "Mean at each position", x: { label: "position of the table", whole: true }, y: { label: "mean distance, mm" }, series: byPosition, width: 560, height: 280 })),
    table(["element", number("points shown"), number("mean, mm"), number("RMS, mm")], rows.map(({ e, own }) => [e.name, number(String(own.length)), number(digits(mean(own), 4)), number(digits(rms(own), 4))])));
}

// ESTIMATED ALONG

function buildAlong() {
  const all = JOINT && JOINT.details ? JOINT.details.nuisance : [];
  const seen = all.filter(p => !p.name.startsWith("rail ") || p.name.startsWith("rail orientation"));
  if (!seen.length) return;
  add("along", "Estimated along", note("Changes from what was known before: every one of these entered with a prior."),
    table(["quantity", number("change \u00b1 1 sigma"), "unit"], seen.map(p => [p.name, number(correctionText(p)), shownUnit(p.unit)])));
}

function buildStand() {
  const d = RESULT.details;
  add("stand", "The stand", note(`${d.rail}; ${d.positions} positions of the table, turned by ${short(d.turned_deg[0])} deg about the vertical and ${short(d.turned_deg[1])} deg about the lateral axis.`));
}

OWN.push(buildProfiles, buildSweeps, buildResiduals, buildAlong, buildStand);
