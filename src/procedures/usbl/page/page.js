// A USBL calibration's own sections.

const SAMPLES = DATA.page, DETAILS = RESULT.details, BEACONS = DETAILS.beacons;
const REFERENCE = RESULT.solutions.reference, JOINT = RESULT.solutions.joint;
const COLOURS = { reference: "var(--reference)", joint: "var(--joint)", check: "var(--good)" };
const PATH_NAMES = { reference: "Reference", joint: "Joint" };
const shownPaths = ["reference", "joint"].filter(path => DETAILS.verification.some(v => v[path]));

// LAYOUT

/** The beacons seen from above or from the side; axes are indices of east, north, up. */
function layoutView(title, across, up, names) {
  const width = 430, height = 400, pad = 46, places = [...BEACONS.map(b => b.position_m), [0, 0, 0]];
  const values = axis => places.map(p => p[axis]), span = axis => Math.max(...values(axis)) - Math.min(...values(axis));
  const size = Math.min((width - 2 * pad) / Math.max(span(across), 1), (height - 2 * pad) / Math.max(span(up), 1));
  const middle = axis => (Math.max(...values(axis)) + Math.min(...values(axis))) / 2;
  const at = p => [width / 2 + (p[across] - middle(across)) * size, height / 2 - (p[up] - middle(up)) * size];
  const means = DETAILS.verification.flatMap(v => shownPaths.map(path => v[path] && v[path].mean_m)).filter(m => m);
  const longest = Math.max(1e-6, ...means.map(m => Math.hypot(m[across], m[up]))), unit = roundUp(longest), stretch = 60 / unit;
  const lines = BEACONS.map(b => { const [x, y] = at(b.position_m), [x0, y0] = at([0, 0, 0]); return svg("line", { x1: x0, y1: y0, x2: x, y2: y, stroke: INK.line }); });
  const marks = BEACONS.map((b, k) => {
    const [x, y] = at(b.position_m), colour = b.role === "check" ? COLOURS.check : INK.ink, v = DETAILS.verification[k];
    const arrows = shownPaths.filter(path => v && v[path]).map(path => arrow(x, y, v[path].mean_m[across] * stretch, -v[path].mean_m[up] * stretch, COLOURS[path]));
    return svg("g", {}, svg("title", {}, `${b.name}, ${b.role}`), b.role === "check" ? svg("rect", { x: x - 6, y: y - 6, width: 12, height: 12, fill: INK.paper, stroke: colour, "stroke-width": 2 }) : svg("circle", { cx: x, cy: y, r: 6, fill: INK.paper, stroke: colour, "stroke-width": 2 }), arrows, text(x + 10, y - 9, b.name));
  });
  const [tx, ty] = at([0, 0, 0]), transducer = [svg("path", { d: `M${tx - 8} ${ty + 6} h16 l-8 -13 Z`, fill: COLOURS.joint }), tx < 90 ? text(tx + 11, ty + 3, "transducer") : text(tx - 11, ty + 3, "transducer", { "text-anchor": "end" })];
  const metre = roundUp(Math.max(span(across), span(up)) / 5), bar = metre * size;
  const rulers = [svg("line", { x1: 12, x2: 12 + bar, y1: height - 12, y2: height - 12, stroke: INK.ink, "stroke-width": 2 }), text(12, height - 18, `${short(metre)} m`),
    ...(means.length ? [svg("line", { x1: width - 72, x2: width - 12, y1: height - 12, y2: height - 12, stroke: INK.soft, "stroke-width": 2 }), text(width - 72, height - 18, `${short(1e3 * unit)} mm`)] : [])];
  const compass = [text(width - 12, 16, `${names[0]} to the right, ${names[1]} to the top`, { "text-anchor": "end", class: "soft" })];
  return el("figure", {}, el("h3", {}, title), picture(width, height, title, lines, transducer, marks, rulers, compass));
}

function arrow(x, y, dx, dy, colour) {
  const length = Math.hypot(dx, dy);
  if (length < 1.5) return svg("circle", { cx: x, cy: y, r: 2, fill: colour });
  const [ux, uy] = [dx / length, dy / length], [ex, ey] = [x + dx, y + dy], head = Math.min(7, length);
  return [svg("line", { x1: x, y1: y, x2: ex - ux * head * 0.7, y2: ey - uy * head * 0.7, stroke: colour, "stroke-width": 2.2 }),
    svg("path", { d: `M${ex} ${ey} L${ex - ux * head - uy * head * 0.45} ${ey - uy * head + ux * head * 0.45} L${ex - ux * head + uy * head * 0.45} ${ey - uy * head - ux * head * 0.45} Z`, fill: colour })];
}

function pathLegend() {
  return keys([...shownPaths.map(path => ({ name: `${PATH_NAMES[path]} path`, colour: COLOURS[path], dash: "" })), { name: "check beacon (square)", colour: COLOURS.check }]);
}

function buildLayout() {
  add("layout", "Beacons, and where the corrected sensor puts them", pathLegend(),
    el("div", { class: "row3" }, layoutView("From above", 0, 1, ["east", "north"]), layoutView("From the south", 0, 2, ["east", "height"])),
    shownPaths.length ? note("Arrows: mean of predicted minus surveyed position of each beacon, enlarged by the scale at the lower right; positions by the scale at the lower left. The check beacon took no part.") : note("The beacons as surveyed; there is no correction to verify."));
}

// RESIDUALS

function scatter(beacon, k) {
  const own = SAMPLES.fixes.filter(f => f.beacon === k), width = 300, height = 260, pad = 18;
  const good = own.filter(f => !f.outlier), all = good.flatMap(f => shownPaths.map(path => f[`${path}_m`])).filter(m => m);
  if (!all.length) return [];
  const end = roundUp(1e3 * Math.max(1e-6, ...all.map(m => Math.max(Math.abs(m[0]), Math.abs(m[1])))), [1, 1.5, 2, 3, 4, 5, 7, 10]);
  const at = m => [width / 2 + 1e3 * m[0] / end * (width / 2 - pad), height / 2 - 1e3 * m[1] / end * (height / 2 - pad)];
  const axes = [svg("line", { x1: pad, x2: width - pad, y1: height / 2, y2: height / 2, stroke: INK.line }), svg("line", { x1: width / 2, x2: width / 2, y1: pad, y2: height - pad, stroke: INK.line }),
    text(width - 4, height / 2 + 14, `${short(end)} mm east`, { "text-anchor": "end", class: "soft" }), text(width / 2 + 5, pad + 4, `${short(end)} mm north`, { class: "soft" })];
  const points = shownPaths.flatMap(path => good.filter(f => f[`${path}_m`]).map(f => { const [x, y] = at(f[`${path}_m`]); return svg("circle", { cx: x.toFixed(1), cy: y.toFixed(1), r: 1.8, fill: COLOURS[path], "fill-opacity": 0.5 }); }));
  const v = DETAILS.verification[k], means = shownPaths.filter(path => v[path]).map(path => { const [x, y] = at(v[path].mean_m); return svg("path", { d: `M${x - 7} ${y} H${x + 7} M${x} ${y - 7} V${y + 7}`, stroke: COLOURS[path], "stroke-width": 2.5 }); });
  return el("figure", {}, el("h3", {}, `${beacon.name}`, el("small", {}, `  ${beacon.role}`)), picture(width, height, `residuals of ${beacon.name}`, axes, points, means));
}

function buildScatter() {
  if (!SAMPLES.fixes.length || !shownPaths.length) return;
  add("scatter", "Residuals of the fixes, from above", pathLegend(), el("div", { class: "row4" }, BEACONS.map(scatter)),
    note("Predicted minus surveyed beacon, fix by fix; crosses: means. Fixes beyond five standard deviations are left out."));
}

function series(beacon, k) {
  const path = shownPaths[shownPaths.length - 1], own = SAMPLES.fixes.filter(f => f.beacon === k && f[`${path}_m`] && !f.outlier);
  const one = (axis, name, colour) => ({ name, colour, points: own.map(f => [f.time_s, 1e3 * f[`${path}_m`][axis]]) });
  return plot({ title: beacon.name, sub: beacon.role, x: { label: "s" }, y: { label: "mm" }, width: 380, height: 220, series: [one(0, "east", WHEEL[0]), one(1, "north", WHEEL[1]), one(2, "up", WHEEL[2])], marks: [{ y: 0, name: "" }] });
}

function buildSeries() {
  if (!SAMPLES.fixes.length || !shownPaths.length) return;
  add("series", `Residuals in time, ${PATH_NAMES[shownPaths[shownPaths.length - 1]].toLowerCase()} path`, keys([["east", 0], ["north", 1], ["up", 2]].map(([name, i]) => ({ name, colour: WHEEL[i], dash: "" }))),
    el("div", { class: "row3" }, BEACONS.map(series)));
}

// TABLES

/** The patent's angles beside those of this program: other signs, other order. */
function buildPrinted() {
  const rows = [], four = value => number(digits(value, 4)), mounted = (name, p, m) => rows.push([name, four(p.h), four(p.p), four(p.r), ...(m ? [four(m.heading), four(m.pitch), four(m.roll)] : [number(""), number(""), number("")])]);
  if (REFERENCE && REFERENCE.details) {
    mounted("adjusted attitude of the transducer", REFERENCE.details.adjusted_printed_deg);
    mounted("attitude sensor, mean (patent's signs)", REFERENCE.details.measured_printed_deg);
    mounted("reference: adjusted minus measured", REFERENCE.details.difference_printed_deg, REFERENCE.mountings[0].mounting_deg);
  }
  if (JOINT && JOINT.details) mounted("joint: the mounting as a rotation", JOINT.details.printed_deg, JOINT.mountings[0].mounting_deg);
  if (!rows.length) return;
  add("printed", "The patent's printed angles beside the mounting angles, deg", table(["", number("H"), number("P, bow down"), number("R, starboard up"), number("heading"), number("pitch, bow up"), number("roll, starboard down")], rows),
    note("The patent's matrix is Rz(-H) Ry(-R) Rx(-P); a mounting here is Rz(-heading) Rx(pitch) Ry(roll). The patent subtracts angles; the mounting is the difference as a rotation. The two agree for small angles only."));
}

function buildVerification() {
  if (!shownPaths.length) return;
  const three = (r, key) => r ? number(r[key].map(x => digits(1e3 * x, 1)).join("  ")) : number("-");
  const rows = DETAILS.verification.map((v, k) => [v.beacon, v.role, number(grouped(BEACONS[k].fixes)), number(`${(v.joint || v.reference || {}).outliers || 0}`), ...shownPaths.flatMap(path => [three(v[path], "mean_m"), number(v[path] ? digits(1e3 * v[path].rms_m, 1) : "-")]),
    three(v.joint, "mean_standard_deviation_m"), number(v.joint && !missing(v.joint.test_statistic) ? digits(v.joint.test_statistic, 1) : ""), number(v.joint && !missing(v.joint.p_value) ? probability(v.joint.p_value) : "")]);
  add("verification", "Verification: predicted minus surveyed beacons, mm",
    table(["beacon", "role", number("fixes"), number("outliers"), ...shownPaths.flatMap(path => [number(`${PATH_NAMES[path].toLowerCase()} e, n, u`), number("rms")]), number("sigma of mean"), number("chi-square (3)"), number("p")], rows),
    note("The correction is applied to the sensor's attitude, the beacons are predicted from each fix and compared with the total station. Only the check beacon's test is a test: the others have helped to find the correction."));
}

OWN.push(buildLayout, buildScatter, buildVerification, buildSeries, buildPrinted);
