// How densely the soundings cover each plane of the target.

/** Soundings by square metre in the cells of a plane: { side, low, columns, rows, density }. Samples stand for as many soundings as were thinned. */
function densityOf(plane) {
  const [right, up] = mapAxes(plane), { low, high } = plane.bounds, area = (high[0] - low[0]) * (high[1] - low[1]);
  const widest = Math.min(high[0] - low[0], high[1] - low[1]) / 4, side = roundUp(Math.min(widest, Math.max(0.05, Math.sqrt(12 * area / plane.soundings.length))), [1, 2, 2.5, 5, 10]);
  const columns = Math.ceil((high[0] - low[0]) / side), rows = Math.ceil((high[1] - low[1]) / side), density = new Float64Array(columns * rows);
  const position = SOUNDINGS.position[COVERAGE_PATH.key], all = plane.faces.reduce((sum, face) => sum + (SAMPLES.face_statistics.find(entry => entry.face === face) || { soundings: 0 }).soundings, 0);
  const each = all / plane.soundings.length / (side * side);
  for (const i of plane.soundings) {
    const p = position.subarray(3 * i, 3 * i + 3), column = Math.floor((dot(right, p) - low[0]) / side), row = Math.floor((dot(up, p) - low[1]) / side);
    if (column >= 0 && column < columns && row >= 0 && row < rows) density[row * columns + column] += each;
  }
  return { side, columns, rows, density, all };
}

/** The path whose positions count: the joint one where there is one. */
const COVERAGE_PATH = [...PATHS].reverse().sort((a, b) => (b.key === "joint") - (a.key === "joint")).find(path => SOUNDINGS.position[path.key]);

function densityMap(plane, grid, end, scale) {
  const [right, up] = mapAxes(plane), { low, high } = plane.bounds, width = Math.round((high[0] - low[0]) * scale), height = Math.round((high[1] - low[1]) * scale);
  const canvas = el("canvas", { width: 2 * width, height: 2 * height, style: `width:${width}px`, role: "img", "aria-label": `soundings per square metre, ${planeTitle(plane)}` }), pen = canvas.getContext("2d"), edge = 2 * scale * grid.side;
  grid.density.forEach((value, k) => {
    if (!value) return;
    pen.fillStyle = css(shade(value / end));
    pen.fillRect(edge * (k % grid.columns), 2 * height - edge * (Math.floor(k / grid.columns) + 1), edge + 0.5, edge + 0.5);
  });
  pen.strokeStyle = "#4a5a66";
  pen.lineWidth = 1.5;
  for (const face of plane.faces) {
    pen.beginPath();
    SAMPLES.faces[face].vertices_m.forEach(corner => pen.lineTo(2 * scale * (dot(right, corner) - low[0]), 2 * scale * (high[1] - dot(up, corner))));
    pen.closePath();
    pen.stroke();
  }
  const filled = grid.density.filter(value => value).length;
  return el("div", { class: "map" }, el("h3", {}, planeTitle(plane), el("small", {}, `${grouped(grid.all)} soundings, cells of ${short(grid.side)} m`)),
    el("figure", {}, canvas, ruler(width, scale, low[0], "m"), el("figcaption", {}, `${short(grid.all / Math.max(1, filled * grid.side * grid.side))} per m\u00b2 where there are any`)));
}

function buildCoverage() {
  if (!COVERAGE_PATH) return;
  const list = planes().filter(plane => plane.soundings.length > 30);
  if (!list.length) return;
  for (const plane of list) {
    const [right, up] = mapAxes(plane), position = SOUNDINGS.position[COVERAGE_PATH.key];
    plane.bounds = bounds(plane.soundings.map(i => position.subarray(3 * i, 3 * i + 3)).map(p => [dot(right, p), dot(up, p)]));
  }
  const order = ["P2", "P1", "P3", "other", "horizontal"];
  list.sort((a, b) => order.indexOf(a.role) - order.indexOf(b.role));
  const grids = list.map(densityOf), values = grids.flatMap(grid => Array.from(grid.density.filter(value => value))).sort((a, b) => a - b);
  const end = roundUp(values[Math.floor(0.98 * (values.length - 1))] || 1, [1, 1.5, 2, 3, 4, 5, 6, 8, 10]);
  add("coverage", "Coverage of the faces", densityLegend(end, "soundings per m\u00b2"), el("div", { class: "maps" }, list.map((plane, k) => densityMap(plane, grids[k], end, mapScale(list, [COVERAGE_PATH])))),
    note("Soundings that the calibration used, placed with the mounting found. Where the soundings of a face lie in one spot, they say little about its tilt."));
}
