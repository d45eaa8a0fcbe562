// Samples that all parts of the pool's section share.

const SAMPLES = DATA.page;

/** Little-endian 32-bit floats from base64; null stays null. */
function floats(packed) {
  if (!packed) return null;
  const raw = atob(packed), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return new Float32Array(bytes.buffer);
}

const SOUNDINGS = {
  count: SAMPLES.soundings.count,
  nominal: floats(SAMPLES.soundings.nominal),
  nominalResidual: floats(SAMPLES.soundings.nominal_residual),
  position: Object.fromEntries(PATHS.map(path => [path.key, floats(SAMPLES.soundings.position[path.key])])),
  residual: Object.fromEntries(PATHS.map(path => [path.key, floats(SAMPLES.soundings.residual[path.key])])),
  face: floats(SAMPLES.soundings.face),
  used: floats(SAMPLES.soundings.used),
  across: floats(SAMPLES.soundings.across_deg),
  range: floats(SAMPLES.soundings.range_m),
  time: floats(SAMPLES.soundings.time_s),
  sigma: floats(SAMPLES.soundings.stated_sigma_m),
};

const RETURNS = {
  count: SAMPLES.returns.count,
  position: floats(SAMPLES.returns.position),
  residual: floats(SAMPLES.returns.residual),
  used: floats(SAMPLES.returns.used),
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
