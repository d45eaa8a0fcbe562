// A rail calibration's own sections.

const SAMPLES = DATA.page;
const REGION_INK = "var(--bad)";
const PATH_INK = { nominal: "#8a97a1", reference: "var(--reference)", joint: "var(--joint)" };
const PATH_NAMES = { nominal: "nominal", reference: "reference", joint: "joint" };
const JOINT = RESULT.solutions.joint, REFERENCE = RESULT.solutions.reference;
const NAMES = Object.keys(RESULT.counts);

// PROFILES

/** Paths that have points, in the order of drawing. */
function shownPaths() { return ["nominal", "reference", "joint"].filter(path => SAMPLES.profiles.some(p => p.path === path && p.points.length)); }

/** A view of the cross-section between (x1, z1) and (x2, z2), millimetres, with its axes. */
function crossSection(label, view, width, radius, samples) {
  const [x1, x2, z1, z2] = view, box = { left: 52, right: 8, top: 8, bottom: 40 }, size = (width - box.left - box.right) / (x2 - x1), height = (z2 - z1) * size + box.top + box.bottom;
  const places = (low, high) => ticks(low, high, 5).map(v => [v, tickLabel(v, tickStep(low, high, 5))]);
  const x = { at: v => box.left + (v - x1) * size, ticks: places(x1, x2) }, z = { at: v => box.top + (z2 - v) * size, ticks: places(z1, z2) };
  const at = p => [x.at(p[0]).toFixed(2), z.at(p[1]).toFixed(2)], inside = ([a, b]) => a >= x1 && a <= x2 && b >= z1 && b <= z2, near = ([a, b]) => a >= 2 * x1 - x2 && a <= 2 * x2 - x1 && b >= 2 * z1 - z2 && b <= 2 * z2 - z1;
  const clip = `clip${crossSection.count = (crossSection.count || 0) + 1}`, edge = svg("clipPath", { id: clip }, svg("rect", { x: box.left, y: box.top, width: width - box.left - box.right, height: height - box.top - box.bottom }));
  const outline = SAMPLES.outline_mm.filter(e => e.points.some(near)).map(e => svg("polyline", { points: e.points.map(p => at(p).join(",")).join(" "), fill: "none", stroke: e.region ? REGION_INK : INK.ink, "stroke-width": e.region ? 2.2 : 1.2 }, svg("title", {}, e.name)));
  const dots = samples.map(s => svg("g", { fill: PATH_INK[s.path], "fill-opacity": s.path === "nominal" ? 0.7 : 0.85 }, s.points.filter(inside).map(p => { const [cx, cy] = at(p); return svg("circle", { cx, cy, r: radius }); })));
  return picture(width, Math.round(height), label, edge, frame(box, width, height, { label: "across the rail, mm" }, { label: "height, mm" }, x, z), svg("g", { "clip-path": `url(#${clip})` }, outline, dots));
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
  add("profiles", "Measured profiles on the standard profile", keys([...paths.map(path => ({ name: PATH_NAMES[path], colour: PATH_INK[path] })), { name: "regions of the reference path", colour: REGION_INK }]),
    el("div", { style: "display:flex;flex-wrap:wrap;gap:18px" }, el("figure", { style: "max-width:100%" }, el("h3", {}, "The whole rail"), crossSection("profiles on the standard profile", whole, 480, 1, sorted)), el("div", { style: "display:grid;grid-template-columns:repeat(auto-fit,minmax(min(260px,100%),1fr));gap:4px 16px;align-content:start;flex:1 1 260px" }, zooms)),
    note("Points at the position of the table nearest to level, under the nominal mounting and under the mounting of each path. The joint path is drawn with the table, rail and INS that it estimated, the others with those known before."));
}

// HAUSDORFF CURVES

function upright(x, low, high, colour, dash) { return { colour, dash, dots: false, thin: true, points: [[x, low], [x, high]] }; }

function jointAngle(k, which) { return JOINT && JOINT.mountings.length ? -JOINT.mountings[k].mounting_deg[which] : null; }

function sweepPlot(k, steps, which, title) {
  const values = steps.map(s => s.distance_m * 1e3), low = Math.min(...values), high = Math.max(...values), best = steps[values.indexOf(low)];
  const series = [{ colour: PATH_INK.reference, points: steps.map(s => [s.turn_deg, s.distance_m * 1e3]) }, upright(best.turn_deg, low, high, PATH_INK.reference, "5 3")];
  const joint = jointAngle(k, which);
  if (joint !== null) series.push(upright(joint, low, high, PATH_INK.joint, null));
  return plot({ title: `${NAMES[k]}: ${which}`, sub: title, x: { label: `${which} of the INS against the rail, deg` }, y: { label: "Hausdorff distance, mm" }, series, width: 430, height: 260 });
}

function buildSweeps() {
  if (!REFERENCE || !REFERENCE.usable) return;
  add("sweeps", "Hausdorff distance while the table turns", keys([{ name: "distance", colour: PATH_INK.reference, dash: "" }, { name: "its minimum: the reference path", colour: PATH_INK.reference, dash: "5 3" }, { name: "where the joint solution compensates the bias", colour: PATH_INK.joint, dash: "" }]),
    el("div", { class: "row2" }, REFERENCE.details.steps.flatMap((s, k) => [sweepPlot(k, s.heading_sweep, "heading", "straight region, turn about the vertical"), sweepPlot(k, s.pitch_sweep, "pitch", "arc region, turn about the lateral axis")])),
    note("A minimum stands where the turn cancels the mounting's bias: bias = -(turn at the minimum). A distance that is a maximum over noisy points is flat near its minimum, so its place scatters."));
}

// ESTIMATED ALONG

function buildAlong() {
  const all = JOINT && JOINT.details ? JOINT.details.nuisance : [];
  const seen = all.filter(p => !p.name.startsWith("rail ") || p.name.startsWith("rail orientation"));
  if (!seen.length) return;
  add("along", "Also estimated", note("Changes from what was known before: each of these has a prior."),
    table(["quantity", number("change \u00b1 1 sigma"), "unit"], seen.map(p => [p.name, number(correctionText(p)), shownUnit(p.unit)])));
}

function buildStand() {
  const d = RESULT.details;
  add("stand", "The stand", note(`${d.rail}; ${d.positions} positions of the table, turned by ${short(d.turned_deg[0])} deg about the vertical and ${short(d.turned_deg[1])} deg about the lateral axis.`));
}
