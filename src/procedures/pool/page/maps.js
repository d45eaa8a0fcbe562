// Residual maps: one per plane of the target, every path beside the others, one colour scale for all.

/** Outward normal of a polygon after Newell. */
function normal(polygon) {
  const sum = [0, 0, 0];
  polygon.forEach((a, i) => {
    const c = cross(a, polygon[(i + 1) % polygon.length]);
    sum.forEach((_, k) => { sum[k] += c[k]; });
  });
  return unit(sum);
}

/** Upright faces in one plane and of one role belong in one map; a horizontal face has its own. */
function planes() {
  const list = [];
  SAMPLES.faces.forEach((face, index) => {
    const n = normal(face.vertices_m), offset = dot(n, face.vertices_m[0]);
    const same = list.find(plane => plane.role === face.role && Math.abs(n[2]) < 0.7 && Math.abs(dot(plane.n, n)) > 0.9999 && Math.abs(plane.offset - Math.sign(dot(plane.n, n)) * offset) < 0.05);
    if (same) same.faces.push(index); else list.push({ n, offset, role: face.role, faces: [index], soundings: [] });
  });
  const of = new Map(list.flatMap(plane => plane.faces.map(face => [face, plane])));
  for (let i = 0; i < SOUNDINGS.count; i++) {
    const plane = of.get(SOUNDINGS.face[i]);
    if (plane && SOUNDINGS.used[i]) plane.soundings.push(i);
  }
  return list;
}

/** Axes of a map: right and up as seen from the boat, or from above with the wall on top. */
function mapAxes(plane) {
  if (Math.abs(plane.n[2]) > 0.7) return [[0, -1, 0], [1, 0, 0]];
  const right = unit(cross([0, 0, 1], plane.n));
  return [right, cross(plane.n, right)];
}

const ROLES = { P1: "column at -Y (P1)", P2: "wall (P2)", P3: "column at +Y (P3)", horizontal: "horizontal", other: "" };

function planeTitle(plane) {
  const names = plane.faces.map(face => SAMPLES.faces[face].name), height = SAMPLES.faces[plane.faces[0]].vertices_m[0][2];
  if (plane.role === "horizontal") return `${names.join(", ")}, z ${digits(height, 2)} m`;
  return ROLES[plane.role] || names.join(", ");
}

function bounds(points) {
  const low = [Infinity, Infinity], high = [-Infinity, -Infinity];
  for (const p of points) for (const k of [0, 1]) { low[k] = Math.min(low[k], p[k]); high[k] = Math.max(high[k], p[k]); }
  return { low: low.map(x => x - 0.1), high: high.map(x => x + 0.1) };
}

function drawMap(plane, path, scale) {
  const position = SOUNDINGS.position[path.key], residual = SOUNDINGS.residual[path.key], [right, up] = mapAxes(plane);
  const flat = p => [dot(right, p), dot(up, p)];
  const points = plane.soundings.map(i => flat(position.subarray(3 * i, 3 * i + 3)));
  const { low, high } = plane.bounds || (plane.bounds = bounds(points));
  const width = Math.round((high[0] - low[0]) * scale), height = Math.round((high[1] - low[1]) * scale);
  const canvas = el("canvas", { width: 2 * width, height: 2 * height, style: `width:${width}px`, role: "img", "aria-label": `residuals, ${planeTitle(plane)}, ${path.name}` });
  const pen = canvas.getContext("2d"), place = ([u, v]) => [2 * scale * (u - low[0]), 2 * scale * (high[1] - v)];
  points.forEach((p, k) => {
    pen.fillStyle = css(diverging(residual[plane.soundings[k]] / SCALE_M));
    pen.beginPath();
    pen.arc(...place(p), 2.6, 0, 7);
    pen.fill();
  });
  pen.strokeStyle = "#4a5a66";
  pen.lineWidth = 1.5;
  for (const face of plane.faces) {
    pen.beginPath();
    SAMPLES.faces[face].vertices_m.forEach(corner => pen.lineTo(...place(flat(corner))));
    pen.closePath();
    pen.stroke();
  }
  return el("figure", {}, canvas, ruler(width, scale, low[0], "m"), el("figcaption", {}, el("b", { style: `color:${path.colour}` }, path.name), el("span", {}, rmsOf(plane, path))));
}

/** RMS of a plane of one face, as the result states it; several faces have theirs in the table. */
function rmsOf(plane, path) {
  const figures = SAMPLES.face_statistics.filter(entry => plane.faces.includes(entry.face));
  return figures.length === 1 && !missing(figures[0].rms_m[path.key]) ? `RMS ${digits(1e3 * figures[0].rms_m[path.key], 1)} mm` : "";
}

/** Pixels per metre, so that the widest map of all paths fits the page. */
function mapScale(list, paths) {
  const widest = Math.max(...list.map(plane => plane.bounds.high[0] - plane.bounds.low[0]));
  const beside = ROOM < 700 ? 1 : Math.min(3, paths.length);
  return Math.min(60, (ROOM - 16 * beside) / beside / widest);
}

function buildMaps() {
  const paths = PATHS.filter(path => SOUNDINGS.residual[path.key] && SOUNDINGS.position[path.key]);
  const all = planes(), list = all.filter(plane => plane.soundings.length);
  if (!paths.length || !list.length) return;
  for (const plane of list) {
    const [right, up] = mapAxes(plane), position = SOUNDINGS.position[paths[paths.length - 1].key];
    plane.bounds = bounds(plane.soundings.map(i => position.subarray(3 * i, 3 * i + 3)).map(p => [dot(right, p), dot(up, p)]));
  }
  const order = ["P2", "P1", "P3", "other", "horizontal"], scale = mapScale(list, paths);
  list.sort((a, b) => order.indexOf(a.role) - order.indexOf(b.role));
  const empty = all.filter(plane => !plane.soundings.length).flatMap(plane => plane.faces).map(face => SAMPLES.faces[face].name);
  add("maps", "Residuals of the soundings on the faces", residualLegend(), el("div", { class: "maps" }, list.map(plane => el("div", { class: "map" },
    el("h3", {}, planeTitle(plane), el("small", {}, `${grouped(plane.soundings.length)} soundings shown`)),
    el("div", { class: "pair" }, paths.map(path => drawMap(plane, path, scale)))))),
  el("p", { class: "note" }, `All maps in one scale. Upright faces as seen from the boat, horizontal ones from above with the wall on top. ${empty.length ? `No soundings on: ${empty.join(", ")}.` : ""}`));
}
