// Residuals of the fixes: by beacon, against the noise that the survey states, over time.

/** Fixes of a beacon within five standard deviations. */
function kept(k) { return SAMPLES.fixes.filter(f => f.beacon === k && !f.outlier); }

function hasFixes() { return SAMPLES.fixes.length > 0 && shownPaths.length > 0; }

/** The path whose residuals are shown where there is room for one. */
const SHOWN_PATH = shownPaths[shownPaths.length - 1];

/** One end of both axes for all beacons, so that their clouds compare. */
function scatterEnd() {
  const all = SAMPLES.fixes.filter(f => !f.outlier).flatMap(f => shownPaths.map(path => f[`${path}_m`])).filter(m => m).flatMap(m => [Math.abs(m[0]), Math.abs(m[1])]);
  return roundUp(1e3 * Math.max(1e-6, ...all), [1, 1.5, 2, 3, 4, 5, 7, 10]);
}

function scatter(beacon, k, end) {
  const place = m => [1e3 * m[0], 1e3 * m[1]], v = DETAILS.verification[k];
  const clouds = shownPaths.map(path => ({ colour: COLOURS[path], line: false, size: 1.7, points: kept(k).map(f => f[`${path}_m`]).filter(m => m).map(place) }));
  const means = shownPaths.filter(path => v[path]).map(path => ({ colour: COLOURS[path], line: false, size: 5, points: [place(v[path].mean_m)] }));
  return plot({ title: beacon.name, sub: beacon.role, x: { label: "east, mm", also: [-end, end] }, y: { label: "north, mm", also: [-end, end] }, series: [...clouds, ...means], marks: [{ y: 0, name: "", colour: INK.line }], width: 300, height: 290 });
}

function buildScatter() {
  if (!hasFixes()) return;
  const end = scatterEnd();
  add("scatter", "Residuals of the fixes by beacon, from above", pathLegend(), el("div", { class: "row4" }, BEACONS.map((beacon, k) => kept(k).length ? scatter(beacon, k, end) : [])),
    note("Predicted minus surveyed beacon, fix by fix; large dots: means. Fixes beyond five standard deviations are left out. All clouds turned the same way: an error of the heading is left; all outwards or all inwards: a range scale."));
}

/** Mean of a component, millimetres, in bins of equal counts. */
function smoothed(own, of) {
  const size = Math.max(8, Math.ceil(own.length / 25)), list = [];
  for (let i = 0; i + size / 2 < own.length; i += size) {
    const part = own.slice(i, i + size);
    list.push([part.reduce((sum, f) => sum + f.time_s, 0) / part.length, part.reduce((sum, f) => sum + of(f), 0) / part.length]);
  }
  return list;
}

function series(beacon, k) {
  const own = kept(k).filter(f => f[`${SHOWN_PATH}_m`]), of = axis => f => 1e3 * f[`${SHOWN_PATH}_m`][axis];
  const cloud = axis => ({ colour: WHEEL[axis], line: false, size: 1.3, points: own.map(f => [f.time_s, of(axis)(f)]) }), mean = axis => ({ colour: WHEEL[axis], dots: false, points: smoothed(own, of(axis)) });
  return plot({ title: beacon.name, sub: beacon.role, x: { label: "time since the first fix, s" }, y: { label: "residual, mm" }, width: 380, height: 230, series: [0, 1, 2].map(cloud).concat([0, 1, 2].map(mean)), marks: [{ y: 0, name: "", colour: INK.mark }] });
}

function buildSeries() {
  if (!hasFixes()) return;
  add("series", `Residuals over time, ${PATH_NAMES[SHOWN_PATH].toLowerCase()} path`, keys(["east", "north", "up"].map((name, i) => ({ name, colour: WHEEL[i], dash: "" }))),
    el("div", { class: "row3" }, BEACONS.map(series)), note("Dots: single fixes; lines: means of as many fixes each. A slow wave that all beacons share comes from the attitude sensor; one that only one beacon shows is its own."));
}

function buildNoise() {
  if (!hasFixes()) return;
  const all = SAMPLES.fixes.filter(f => f.in_sigmas), colour = COLOURS[SHOWN_PATH], of = (title, which, i) => againstNormal(title, which, [{ name: "", colour, values: all.map(f => f.in_sigmas[i]) }]);
  add("noise", "Residuals against the stated noise", keys([{ name: `${PATH_NAMES[SHOWN_PATH]} path`, colour, dash: "" }, NORMAL_KEY]),
    el("div", { class: "row3" }, of("Range", "", 0), of("Bearing", "first component of the direction", 1), of("Bearing", "second component of the direction", 2)),
    note(`${grouped(all.length)} fixes, gross errors among them; stated: noise of the fix and of the attitude. Narrower than the curve: the noise is stated too large; wider: too small; off to one side: something turns or stretches all fixes.`));
}

OWN.push(buildLayout, buildVerification, buildScatter, buildNoise, buildSeries, buildPrinted);
