// Data, elements, numbers and colours that all parts of the page share.

const DATA = JSON.parse(document.getElementById("data").textContent);
const RESULT = DATA.result;

const PATHS = [
  { key: "sequential", name: "Sequential", colour: "#b45309" },
  { key: "joint", name: "Joint", colour: "#0b63a5" },
  { key: "joint_simple", name: "Simple joint", colour: "#6d5bb0" },
].map(path => ({ ...path, solution: RESULT.solutions[path.key] || null })).filter(path => path.solution);

/** Paths whose numbers may be shown. */
const ESTIMATED = PATHS.filter(path => path.solution.usable && path.solution.correction_deg && path.solution.lever_arm_correction_m);

const PARAMETERS = [
  { key: "pitch", sigma: "pitch_deg", name: "pitch", sense: "bow up", unit: "deg", angle: true },
  { key: "roll", sigma: "roll_deg", name: "roll", sense: "starboard down", unit: "deg", angle: true },
  { key: "yaw", sigma: "yaw_deg", name: "yaw", sense: "counter-clockwise", unit: "deg", angle: true },
  { key: "lx", sigma: "lx_m", name: "lever arm x", sense: "right", unit: "mm", axis: 0 },
  { key: "ly", sigma: "ly_m", name: "lever arm y", sense: "forward", unit: "mm", axis: 1 },
  { key: "lz", sigma: "lz_m", name: "lever arm z", sense: "up", unit: "mm", axis: 2 },
];

/** A correction in the unit shown. */
function correction(source, parameter) {
  return parameter.angle ? source.correction_deg[parameter.key] : 1e3 * source.lever_arm_correction_m[parameter.axis];
}

/** One sigma of a correction in the unit shown, or null. */
function sigmaOf(solution, parameter) {
  const sigmas = solution.standard_deviation;
  return sigmas ? sigmas[parameter.sigma] * (parameter.angle ? 1 : 1e3) : null;
}

// ELEMENTS

function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value !== null && value !== undefined) node.setAttribute(name, value);
  }
  node.append(...children.flat(Infinity).filter(child => child !== null && child !== undefined));
  return node;
}

function el(tag, attributes, ...children) { return fill(document.createElement(tag), attributes, children); }

function svg(tag, attributes, ...children) {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function picture(width, height, label, ...children) {
  return svg("svg", { viewBox: `0 0 ${width} ${height}`, width, height, role: "img", "aria-label": label }, ...children);
}

function text(x, y, content, attributes) { return svg("text", { x, y, ...attributes }, content); }

function section(id) { return document.getElementById(id); }

function hide(id) { section(id).remove(); }

// NUMBERS

function missing(value) { return value === null || value === undefined || Number.isNaN(value); }

function digits(value, count) { return missing(value) ? "-" : value.toFixed(count).replace(/^-(0(\.0*)?)$/, "$1"); }

/** "0.6003 ± 0.0055": the sigma to two significant digits, the value to the same place. */
function withSigma(value, sigma) {
  if (missing(value)) return "-";
  if (!(sigma > 0)) return String(Number(value.toPrecision(6)));
  const places = Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(sigma))));
  return `${digits(value, places)} \u00b1 ${digits(sigma, places)}`;
}

function plain(value, unit) { return digits(value, unit === "deg" ? 4 : 1); }

function grouped(count) { return String(count).replace(/\B(?=(\d{3})+$)/g, "\u202f"); }

function short(value) { return missing(value) ? "-" : String(Number(value.toPrecision(3))); }

function probability(p) {
  if (missing(p)) return "-";
  if (p < 1e-300) return "below 1e-300";
  return p < 1e-3 ? p.toExponential(0) : p.toFixed(3);
}

function percent(fraction) { return `${short(100 * fraction)} %`; }

/** Little-endian 32-bit floats from base64; null stays null. */
function floats(packed) {
  if (!packed) return null;
  const raw = atob(packed), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return new Float32Array(bytes.buffer);
}

/** One of the steps times a power of ten, not below the value. */
function roundUp(value, steps = [1, 2, 5, 10]) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * (steps.find(step => step * power >= value * (1 - 1e-9)) || 10);
}

/** About `count` round places between two values. */
function ticks(low, high, count) {
  const step = roundUp((high - low) / count), list = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) list.push(i * step);
  return list;
}

function tickLabel(value, step) { return digits(value, Math.max(0, -Math.floor(Math.log10(step) + 1e-9))); }

// COLOURS

const STOPS = [[33, 102, 172], [103, 169, 207], [222, 222, 218], [239, 138, 98], [178, 24, 43]];

/** Diverging colour of a value from -1 (blue, behind the face) to 1 (red, in front of it), as three numbers to 255. */
function diverging(value) {
  const place = 2 * (Math.max(-1, Math.min(1, value)) + 1), low = Math.min(3, Math.floor(place)), part = place - low;
  return STOPS[low].map((from, i) => Math.round(from + part * (STOPS[low + 1][i] - from)));
}

function css(colour) { return `rgb(${colour.join(",")})`; }

// SAMPLES

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
