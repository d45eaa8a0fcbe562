// The pool's own sections.

function buildFaces() {
  const entries = SAMPLES.face_statistics.filter(entry => entry.soundings);
  if (!entries.length) return;
  const paths = PATHS.filter(path => entries.some(entry => !missing(entry.rms_m[path.key]))), mm = value => number(missing(value) ? "-" : digits(1e3 * value, 1));
  add("faces", "Residuals by face", table(["face", "role", number("soundings"), number("per m2"), ...paths.flatMap(path => [number(`${path.name}: mean, mm`), number("RMS, mm")])],
    entries.map(entry => [SAMPLES.faces[entry.face].name, SAMPLES.faces[entry.face].role, number(grouped(entry.soundings)), number(short(entry.soundings / areaOf(SAMPLES.faces[entry.face].vertices_m))), ...paths.flatMap(path => [mm(entry.mean_m[path.key]), mm(entry.rms_m[path.key])])])),
  note("All used soundings, distances along the outward normal: positive in front of the face. Per m2: of the whole face, above water too."), notSounded());
}

/** Area of a plane polygon, square metres. */
function areaOf(vertices) {
  const sum = [0, 0, 0];
  vertices.forEach((a, i) => cross(a, vertices[(i + 1) % vertices.length]).forEach((v, k) => { sum[k] += v / 2; }));
  return Math.sqrt(dot(sum, sum));
}

/** Faces that no sounding is tied to. */
function notSounded() {
  const seen = new Set(SAMPLES.face_statistics.filter(entry => entry.soundings).map(entry => entry.face)), names = SAMPLES.faces.filter((_, i) => !seen.has(i)).map(face => face.name);
  return names.length ? note(`Without soundings: ${names.join(", ")}.`) : [];
}

function buildPose() {
  const pose = RESULT.details.target_pose;
  if (pose) add("pose", "The target's pose", note(`Refined minus given: ${pose.offset_m.map(v => digits(v, 4)).join(", ")} m in target axes, azimuth ${digits(pose.azimuth_correction_deg, 4)} deg.`));
}

const PLANE_COLOURS = { P1: "#7c3aed", P2: "#b45309", P3: "#0f766e", P4: "#be185d" };

/** The reference path's own convergence: angles between the scanner's and the multibeam's normals. */
function referenceChart(solution) {
  const passes = solution.details.passes, names = [...new Set(passes.flatMap(pass => Object.keys(pass.angle_deg)))].sort();
  return lineChart({ title: `Reference path (${solution.details.variant}): angles between normals`, x: "pass", y: "deg", log: true,
    series: names.map(name => ({ name, colour: PLANE_COLOURS[name] || INK.soft, points: passes.map(pass => [pass.pass, pass.angle_deg[name]]) })) });
}

const reference = RESULT.solutions.reference;
if (reference && reference.details && reference.details.passes.length) OWN_CONVERGENCE.push(referenceChart(reference));

function buildPoolDrift() { buildDrift(SAMPLES.drift, "Axes of the target; the passes stand apart."); }

OWN.push(buildScene, buildMaps, buildCoverage, buildResiduals, buildFaces, buildPoolDrift, buildPose);
