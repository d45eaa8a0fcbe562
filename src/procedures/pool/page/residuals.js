// Residuals against what a beam is: its angle, range and time; and against the noise that the survey states.

/** Soundings with a residual, in the order of a column. */
function residualRows(path) {
  const residual = SOUNDINGS.residual[path.key];
  return Array.from({ length: SOUNDINGS.count }, (_, i) => i).filter(i => SOUNDINGS.used[i] && Number.isFinite(residual[i]));
}

/** Mean and RMS of the residuals, millimetres, in bins of equal counts of a column: [[place, mean, rms], ...]. */
function binned(path, column, bins) {
  const residual = SOUNDINGS.residual[path.key], rows = residualRows(path).sort((a, b) => column[a] - column[b]);
  const size = Math.max(20, Math.ceil(rows.length / bins)), list = [];
  for (let i = 0; i + size / 2 < rows.length; i += size) {
    const part = rows.slice(i, i + size), sum = of => part.reduce((all, k) => all + of(k), 0) / part.length;
    list.push([sum(k => column[k]), 1e3 * sum(k => residual[k]), 1e3 * Math.sqrt(sum(k => residual[k] ** 2))]);
  }
  return list;
}

function residualPlot(paths, title, label, column, bins) {
  const series = paths.flatMap(path => {
    const list = binned(path, column, bins);
    return [{ name: path.name, colour: path.colour, points: list.map(([x, mean]) => [x, mean]) },
      { name: path.name, colour: path.colour, dash: "5 3", thin: true, dots: false, points: list.map(([x, , rms]) => [x, rms]) }];
  });
  return plot({ title, x: { label }, y: { label: "residual, mm", also: [0] }, series, marks: [{ y: 0, name: "", colour: INK.mark }] });
}

/** Residuals in their stated sigmas against the normal curve. */
function histogram(paths) {
  const values = path => { const residual = SOUNDINGS.residual[path.key]; return residualRows(path).filter(i => SOUNDINGS.sigma[i] > 0).map(i => residual[i] / SOUNDINGS.sigma[i]); };
  return againstNormal("Residuals in stated sigmas", "", paths.map(path => ({ name: path.name, colour: path.colour, values: values(path) })));
}

function buildResiduals() {
  const paths = PATHS.filter(path => SOUNDINGS.residual[path.key] && residualRows(path).length > 100);
  if (!paths.length) return;
  add("residuals", "Residuals by beam angle, range and time",
    keys([...paths.map(path => ({ name: `${path.name}: mean`, colour: path.colour, dash: "" })), ...paths.map(path => ({ name: `${path.name}: RMS`, colour: path.colour, dash: "5 3" })), NORMAL_KEY]),
    el("div", { class: "row2" }, residualPlot(paths, "By beam angle", "across-track angle, deg, positive to starboard", SOUNDINGS.across, 30),
      residualPlot(paths, "By range", "slant range, m", SOUNDINGS.range, 25), residualPlot(paths, "By time", "time since the first sounding, s", SOUNDINGS.time, 40), histogram(paths)),
    note("Each dot is the mean of the same number of soundings. A slope over the angle is a roll error or a wrong sound speed; over the range, a scale or a range offset; a wave over time, a drift of the INS, which the joint path estimates and which is still in these residuals. ",
      "A histogram narrower than its curve: the noise is stated too large; wider: too small, or the model does not fit."));
}
