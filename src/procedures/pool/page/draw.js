// Paths and samples that all parts of the pool report share.

const PATHS = [
  { key: "sequential", name: "Sequential", colour: "#b45309" },
  { key: "joint", name: "Joint", colour: "#0b63a5" },
  { key: "joint_simple", name: "Simple joint", colour: "#6d5bb0" },
].map(path => ({ ...path, solution: RESULT.solutions[path.key] || null })).filter(path => path.solution);

/** Paths whose numbers may be shown. */
const ESTIMATED = PATHS.filter(path => path.solution.usable && path.solution.correction_deg && path.solution.lever_arm_correction_m);

/** A correction in the unit shown. */
function correction(source, parameter) {
  return parameter.angle ? source.correction_deg[parameter.key] : 1e3 * source.lever_arm_correction_m[parameter.axis];
}

/** One sigma of a correction in the unit shown, or null. */
function sigmaOf(solution, parameter) {
  const sigmas = solution.standard_deviation;
  return sigmas ? sigmas[parameter.sigma] * (parameter.angle ? 1 : 1e3) : null;
}

// SAMPLES

/** Little-endian 32-bit floats from base64; null stays null. */
function floats(packed) {
  if (!packed) return null;
  const raw = atob(packed), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return new Float32Array(bytes.buffer);
}

const SOUNDINGS = {
  count: DATA.soundings.count,
  nominal: floats(DATA.soundings.nominal),
  nominalResidual: floats(DATA.soundings.nominal_residual),
  position: Object.fromEntries(PATHS.map(path => [path.key, floats(DATA.soundings.position[path.key])])),
  residual: Object.fromEntries(PATHS.map(path => [path.key, floats(DATA.soundings.residual[path.key])])),
  face: floats(DATA.soundings.face),
  used: floats(DATA.soundings.used),
};

const RETURNS = {
  count: DATA.returns.count,
  position: floats(DATA.returns.position),
  residual: floats(DATA.returns.residual),
  used: floats(DATA.returns.used),
};

/** End of the shared residual scale, metres: the 98th percentile of all paths' residuals, rounded up. */
const SCALE_M = (() => {
  const sizes = PATHS.flatMap(path => Array.from(SOUNDINGS.residual[path.key] || [])).filter(r => !Number.isNaN(r)).map(Math.abs);
  sizes.sort((a, b) => a - b);
  return roundUp(sizes[Math.floor(0.98 * sizes.length)] || 0.01, [1, 2, 3, 4, 6, 8, 10]);
})();

/** The shared legend of residuals, millimetres. */
function residualLegend() {
  const width = 260, steps = 65, end = 1e3 * SCALE_M;
  const cells = Array.from({ length: steps }, (_, i) => svg("rect", {
    x: i * width / steps, y: 0, width: width / steps + 0.5, height: 12, fill: css(diverging(2 * (i + 0.5) / steps - 1)) }));
  const labels = [-1, -0.5, 0, 0.5, 1].map(t => text((t + 1) / 2 * width, 26, short(t * end),
    { "text-anchor": t === -1 ? "start" : t === 1 ? "end" : "middle", class: "soft" }));
  return el("div", { class: "legend" }, "behind the face", picture(width, 30, "colour scale of residuals", cells, labels),
    "in front of it, mm (larger ones in the end colours)");
}

function pathKeys() {
  return el("div", { class: "keys" }, ESTIMATED.map(path => el("span", {}, el("i", { style: `background:${path.colour}` }), path.name)));
}
