// How far the lines differ: over the ground, by beam, line by line.

const SEA = DATA.page, VIEWS = SEA.views, DEGREE = 180 / Math.PI;
const SOLUTION_NAMES = { before: "before", reference: "reference path", joint: "joint path" };
const SOLUTION_COLOURS = { before: "var(--soft)", reference: "var(--reference)", joint: "var(--joint)" };
function lineName(k) { return SEA.layout.tracks[k].name; }

/** Largest difference that is coloured, mm: three times the smallest RMS of the pairs by any solution. */
function differenceEnd() {
  const all = VIEWS.pairs.flatMap(pair => pair.rms_m.filter(rms => !missing(rms)));
  return all.length ? roundUp(Math.max(1, 3e3 * Math.min(...all))) : 1;
}

/** Cells turned so that the first line of the pair runs to the right: of each its middle and differences. */
function turnedCells(pair) {
  const course = SEA.layout.tracks[pair.lines[0]].course_deg / DEGREE, [s, c] = [Math.sin(course), Math.cos(course)];
  return pair.cells.map(([east, north, off]) => ({ right: east * s + north * c, up: north * s - east * c, off }));
}

function cellBounds(cells) {
  const ends = key => cells.reduce(([low, high], cell) => [Math.min(low, cell[key]), Math.max(high, cell[key])], [Infinity, -Infinity]);
  return { right: ends("right"), up: ends("up") };
}

function differenceMap(pair, cells, solution, end) {
  const { right, up } = cellBounds(cells), side = VIEWS.cell_m, span = range => range[1] - range[0] + 2 * side;
  const size = Math.min((ROOM - 6) / span(right), 230 / span(up)), width = Math.round(span(right) * size), height = Math.round(span(up) * size);
  const name = SOLUTION_NAMES[VIEWS.solutions[solution]], course = SEA.layout.tracks[pair.lines[0]].course_deg / DEGREE;
  const canvas = el("canvas", { width: 2 * width, height: 2 * height, style: `width:${width}px`, role: "img", "aria-label": `difference of lines ${pair.lines.map(lineName).join(" and ")}, ${name}` });
  const pen = canvas.getContext("2d"), edge = 2 * size * side;
  for (const cell of cells) {
    if (missing(cell.off[solution])) continue;
    pen.setTransform(1, 0, 0, 1, 2 * size * (cell.right - right[0] + side), 2 * size * (up[1] - cell.up + side));
    pen.rotate(Math.PI / 2 - course);
    pen.fillStyle = css(diverging(cell.off[solution] / end));
    pen.fillRect(-edge / 2, -edge / 2, edge + 0.5, edge + 0.5);
  }
  const rms = pair.rms_m[solution];
  return el("figure", {}, canvas, solution === VIEWS.solutions.length - 1 ? ruler(width, size, right[0] - side - right[0], "m along the first line") : "", el("figcaption", {}, el("b", { style: `color:${SOLUTION_COLOURS[VIEWS.solutions[solution]]}` }, name), missing(rms) ? "" : `  RMS ${digits(1e3 * rms, 1)} mm`));
}

function pairMaps(pair, end) {
  const cells = turnedCells(pair), kind = SEA.layout.pairs.find(p => p.lines.join() === pair.lines.join()).kind;
  return el("div", { class: "map" }, el("h3", {}, `line ${lineName(pair.lines[0])} less line ${lineName(pair.lines[1])}`, el("small", {}, `${kind}; ${grouped(pair.cells.length)} cells of ${digits(VIEWS.cell_m, 1)} m`)),
    VIEWS.solutions.map((_, k) => differenceMap(pair, cells, k, end)));
}

function differenceLegend(end) {
  const width = 260, bar = Array.from({ length: 52 }, (_, i) => svg("rect", { x: i * 5, y: 0, width: 5.5, height: 12, fill: css(diverging((i + 0.5) / 26 - 1)) }));
  return el("div", { class: "legend" }, `-${end} mm, deeper`, picture(width, 12, "colours of the differences", bar), `${end} mm, higher`);
}

function buildDifferences() {
  const pairs = VIEWS.pairs.filter(pair => pair.cells.length);
  if (!pairs.length) return;
  const end = differenceEnd();
  add("differences", "Lines against each other over the ground", differenceLegend(end), pairs.map(pair => pairMaps(pair, end)),
    note("Height of the first line's surface less the second's, in cells with a plane of each line; the first line runs to the right. Of each kind of pair the one with the most common ground. The heights of the lines that the joint path estimates are not taken off."));
}

// BY BEAM

function beamPlot(curves, line, x) {
  const series = curves.filter(c => c.line === line).map(c => ({ name: SOLUTION_NAMES[VIEWS.solutions[c.solution]], colour: SOLUTION_COLOURS[VIEWS.solutions[c.solution]], points: c.points, dash: VIEWS.solutions[c.solution] === "before" ? "5 4" : null }));
  return plot({ title: `line ${lineName(line)}`, x: { label: x }, y: { label: "mm over the others" }, series, marks: [{ y: 0, name: "", colour: "var(--mark)" }], width: 380, height: 220 });
}

function buildBeams() {
  if (!VIEWS.by_angle.length) return;
  const lines = VIEWS.lines.map((_, k) => k).filter(line => VIEWS.by_angle.some(c => c.line === line));
  add("beams", "Lines over the others by beam: the smile and the frown", keys(VIEWS.solutions.map(name => ({ name: SOLUTION_NAMES[name], colour: SOLUTION_COLOURS[name], dash: name === "before" ? "5 4" : "" }))),
    el("h3", {}, "by beam angle"), el("div", { class: "row3" }, lines.map(line => beamPlot(VIEWS.by_angle, line, "beam angle, deg, starboard positive"))),
    el("h3", {}, "by distance across the track, after calibration"), el("div", { class: "row3" }, lines.map(line => beamPlot(VIEWS.by_distance.filter(c => VIEWS.solutions[c.solution] !== "before"), line, "m, starboard positive"))),
    note("Mean height of a line's soundings over the surfaces of the other lines under them. A roll error tilts the curve, a wrong sound speed bends its ends up (smile) or down (frown), a tide lifts it."));
}

function buildHeights() {
  if (!VIEWS.lines.length) return;
  const mm = value => number(missing(value) ? "-" : digits(1e3 * value, 1)), estimated = VIEWS.lines.some(line => !missing(line.height_m));
  const head = ["line", ...VIEWS.solutions.map(name => number(SOLUTION_NAMES[name])), ...(estimated ? [number("height of the line, joint path")] : [])];
  add("heights", "Line by line, mm over the others", table(head, VIEWS.lines.map((line, k) => [lineName(k), ...line.over_m.map(mm), ...(estimated ? [mm(line.height_m)] : [])])),
    note("Mean over all common ground. The joint path estimates one height of each line (tide, datum) about zero; it is not taken off here."));
}
