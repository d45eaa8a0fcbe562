// A USBL calibration's own sections.

const SAMPLES = DATA.page, DETAILS = RESULT.details, BEACONS = DETAILS.beacons;
const REFERENCE = RESULT.solutions.reference, JOINT = RESULT.solutions.joint;
const COLOURS = { reference: "var(--reference)", joint: "var(--joint)", check: "var(--good)" };
const PATH_NAMES = { reference: "Reference", joint: "Joint" };
const shownPaths = ["reference", "joint"].filter(path => DETAILS.verification.some(v => v[path]));

// LAYOUT

/** The beacons and the rays to them, seen from above or from the side; axes are indices of east, north, up. */
function layoutView(title, across, up, names) {
  const width = 430, height = 400, box = { left: 56, right: 14, top: 12, bottom: 42 }, places = [...BEACONS.map(b => b.position_m), [0, 0, 0]];
  const ends = axis => { const all = places.map(p => p[axis]); return [Math.min(...all), Math.max(...all)]; };
  const inner = [width - box.left - box.right, height - box.top - box.bottom], [right, high] = [ends(across), ends(up)];
  const size = 0.8 * Math.min(inner[0] / Math.max(right[1] - right[0], 1), inner[1] / Math.max(high[1] - high[0], 1));
  const axis = ([low, top], length, from, way) => {
    const middle = (low + top) / 2, half = length / size / 2, [a, b] = [middle - half, middle + half], step = tickStep(a, b, 5);
    return { at: v => from + way * (v - middle) * size, ticks: ticks(a, b, 5).map(v => [v, tickLabel(v, step)]) };
  };
  const x = axis(right, inner[0], box.left + inner[0] / 2, 1), y = axis(high, inner[1], box.top + inner[1] / 2, -1), at = p => [x.at(p[across]), y.at(p[up])];
  const means = DETAILS.verification.flatMap(v => shownPaths.map(path => v[path] && v[path].mean_m)).filter(m => m);
  const longest = Math.max(1e-6, ...means.map(m => Math.hypot(m[across], m[up]))), unit = roundUp(longest), stretch = 46 / unit;
  const [x0, y0] = at([0, 0, 0]), lines = BEACONS.map(b => { const [x1, y1] = at(b.position_m); return svg("line", { x1: x0, y1: y0, x2: x1, y2: y1, stroke: INK.mark, "stroke-dasharray": "2 3" }); });
  const scaled = m => [m[across] * stretch, -m[up] * stretch], left = x0 > width / 2, label = [left ? x0 + 12 : x0 - 12 - 7 * 10, y0 - 21, 7 * 10, 14];
  const spots = BEACONS.map((b, k) => ({ name: b.name, place: at(b.position_m), left: meanWay(DETAILS.verification[k], scaled) > 0 })), nameSpots = namePlaces(spots, [label]);
  const marks = BEACONS.map((b, k) => beaconMark(b, DETAILS.verification[k], spots[k].place, scaled, nameSpots[k]));
  const transducer = [svg("path", { d: `M${x0 - 8} ${y0 + 6} h16 l-8 -13 Z`, fill: COLOURS.joint }), text(x0 + (left ? 12 : -12), y0 - 10, "transducer", { "text-anchor": left ? "start" : "end" })];
  const bar = means.length ? [svg("line", { x1: width - 14 - unit * stretch, x2: width - 14, y1: box.top + 16, y2: box.top + 16, stroke: INK.ink, "stroke-width": 2.2 }), text(width - 14, box.top + 10, `arrows: ${short(1e3 * unit)} mm`, { "text-anchor": "end" })] : [];
  return el("figure", {}, el("h3", {}, title), picture(width, height, `${title}: beacons, rays and mean residuals`, frame(box, width, height, { label: `${names[0]}, m` }, { label: `${names[1]}, m` }, x, y), lines, transducer, marks, bar));
}

/** How far the arrows of a beacon point to the right. */
function meanWay(verified, scaled) {
  return shownPaths.filter(path => verified && verified[path]).reduce((sum, path) => sum + scaled(verified[path].mean_m)[0], 0);
}

/** Where names stand: beside their spots, where the arrows do not point if there is room, and never one over another. */
function namePlaces(spots, taken) {
  const boxes = [...taken], apart = (a, b) => a[0] + a[2] < b[0] || b[0] + b[2] < a[0] || a[1] + a[3] < b[1] || b[1] + b[3] < a[1];
  return spots.map(({ name, place: [x, y], left }) => {
    const wide = 7 * name.length + 6, sides = left ? [-10, 10] : [10, -10];
    const all = [18, -10, 32, -24, 46, -38, 60].flatMap(dy => sides.map(dx => ({ x: x + dx, y: y + dy, anchor: dx < 0 ? "end" : "start", box: [dx < 0 ? x + dx - wide : x + dx, y + dy - 11, wide, 14] })));
    const free = all.find(one => boxes.every(box => apart(box, one.box))) || all[0];
    boxes.push(free.box);
    return free;
  });
}

/** A beacon with the arrows of its mean residuals, and its name. */
function beaconMark(beacon, verified, [x, y], scaled, name) {
  const colour = beacon.role === "check" ? COLOURS.check : INK.ink, shown = shownPaths.filter(path => verified && verified[path]), ways = shown.map(path => scaled(verified[path].mean_m));
  const spot = beacon.role === "check" ? svg("rect", { x: x - 6, y: y - 6, width: 12, height: 12, fill: INK.paper, stroke: colour, "stroke-width": 2 }) : svg("circle", { cx: x, cy: y, r: 6, fill: INK.paper, stroke: colour, "stroke-width": 2 });
  return svg("g", {}, svg("title", {}, `${beacon.name}, ${beacon.role}`), spot, shown.map((path, k) => arrow(x, y, ...ways[k], COLOURS[path])), text(name.x, name.y, beacon.name, { "text-anchor": name.anchor }));
}

function arrow(x, y, dx, dy, colour) {
  const length = Math.hypot(dx, dy);
  if (length < 1.5) return svg("circle", { cx: x, cy: y, r: 2, fill: colour });
  const [ux, uy] = [dx / length, dy / length], [ex, ey] = [x + dx, y + dy], head = Math.min(7, length);
  return [svg("line", { x1: x, y1: y, x2: ex - ux * head * 0.7, y2: ey - uy * head * 0.7, stroke: colour, "stroke-width": 2.2 }),
    svg("path", { d: `M${ex} ${ey} L${ex - ux * head - uy * head * 0.45} ${ey - uy * head + ux * head * 0.45} L${ex - ux * head + uy * head * 0.45} ${ey - uy * head - ux * head * 0.45} Z`, fill: colour })];
}

function pathLegend(...more) {
  return keys([...shownPaths.map(path => ({ name: `${PATH_NAMES[path]} path`, colour: COLOURS[path], dash: "" })), ...more]);
}

function buildLayout() {
  add("layout", "Beacons, and where the corrected sensor puts them", pathLegend({ name: "check beacon (square)", colour: COLOURS.check }),
    el("div", { class: "row2" }, layoutView("From above", 0, 1, ["east", "north"]), layoutView("From the south", 0, 2, ["east", "up"])),
    shownPaths.length ? note("Positions relative to the transducer. Dotted: the rays, drawn straight. Arrows: mean of predicted minus surveyed position of each beacon, enlarged (scale: the bar). The check beacon was not used in the calibration.") : note("The beacons as surveyed; there is no correction to verify."));
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
    table(["beacon", "role", number("fixes"), number("gross errors"), ...shownPaths.flatMap(path => [number(`${PATH_NAMES[path].toLowerCase()} e,\u00a0n,\u00a0u`), number("rms")]), number("sigma of mean"), number("chi-square (3)"), number("p")], rows),
    note("The correction is applied to the sensor's attitude, the beacons are predicted from each fix and compared with the total station. Only the check beacon's test is independent: the others were used to find the correction."));
}
