// Residuals of the joint solution: by profiler, along the profile, by position, by element.

function mean(list) { return list.reduce((sum, v) => sum + v, 0) / list.length; }
function rms(list) { return Math.sqrt(list.reduce((sum, v) => sum + v * v, 0) / list.length); }

function ofProfiler(k) { return SAMPLES.residuals.filter(r => r.profiler === k); }

/** Means of the residuals of a profiler, with their number's own scatter, in bins along the profile. */
function alongProfile(k) {
  const width = 5, bins = new Map();
  ofProfiler(k).forEach(r => { const bin = Math.floor(r.along_mm / width); bins.set(bin, [...(bins.get(bin) || []), r]); });
  return [...bins].filter(([, own]) => own.length > 5).sort((a, b) => a[0] - b[0]).map(([, own]) => {
    const value = mean(own.map(r => r.joint_mm)), sigma = rms(own.map(r => r.stated_mm)) / Math.sqrt(own.length);
    return [mean(own.map(r => r.along_mm)), value, [value - 2 * sigma, value + 2 * sigma]];
  });
}

function byPosition(k) {
  const places = [...new Set(SAMPLES.residuals.map(r => r.position))].sort((a, b) => a - b);
  return places.map(p => [p + 1, ofProfiler(k).filter(r => r.position === p).map(r => r.joint_mm)]).filter(([, own]) => own.length > 5).map(([p, own]) => [p, mean(own)]);
}

/** Elements with their residuals, in the order of the profile. */
function byElement() {
  return SAMPLES.outline_mm.map((e, k) => ({ name: e.name, own: SAMPLES.residuals.filter(r => r.element === k) })).filter(r => r.own.length > 5);
}

/** Mean (dot) and RMS (bar) of the residuals of each element, and the RMS to expect (mark). */
function elementChart(rows, end) {
  const width = 430, left = 10 + 6.4 * Math.max(...rows.map(r => r.name.length)), right = 16, row = 18, top = 6, bottom = top + row * rows.length, at = v => left + (v + end) / (2 * end) * (width - left - right);
  const grid = ticks(-end, end, 5).flatMap(v => [svg("line", { x1: at(v), x2: at(v), y1: top, y2: bottom, stroke: INK.line }), text(at(v), bottom + 16, tickLabel(v, tickStep(-end, end, 5)), { "text-anchor": "middle", class: "soft" })]);
  const marks = rows.flatMap(({ name, own }, k) => {
    const y = top + (k + 0.5) * row, all = own.map(r => r.joint_mm), m = mean(all), size = rms(all), stated = rms(own.map(r => r.stated_mm));
    const tick = x => svg("line", { x1: at(x), x2: at(x), y1: y - 5, y2: y + 5, stroke: "var(--good)", "stroke-width": 1.6 });
    return [text(left - 6, y + 4, name, { "text-anchor": "end", style: "font-size:11px" }), svg("line", { x1: at(m - size), x2: at(m + size), y1: y, y2: y, stroke: "var(--joint)", "stroke-width": 2.4 }), tick(-stated), tick(stated), svg("circle", { cx: at(m), cy: y, r: 3.2, fill: "var(--joint)" })];
  });
  return el("figure", {}, picture(width, bottom + 36, "residuals by element", grid, marks, text((left + width - right) / 2, bottom + 32, "distance from the element, mm", { "text-anchor": "middle", class: "soft" })));
}

function buildResiduals() {
  const all = SAMPLES.residuals;
  if (!all.length) return;
  const size = { width: 430, height: 260 }, each = of => NAMES.map((name, k) => ({ name, colour: WHEEL[k], ...of(k) }));
  add("residuals", "Residuals of the joint solution", keys([...NAMES.map((name, k) => ({ name, colour: WHEEL[k], dash: "" })), NORMAL_KEY]),
    el("div", { class: "row2" }, againstNormal("By profiler", `${grouped(all.length)} points`, each(k => ({ values: ofProfiler(k).map(r => r.joint_mm / r.stated_mm) })), size),
      plot({ title: "Along the profile", sub: "means, bars: two sigmas of them", x: { label: "length along the standard profile, mm" }, y: { label: "mean distance, mm", also: [0] }, series: each(k => ({ points: alongProfile(k), line: false })), marks: [{ y: 0, name: "", colour: INK.mark }], ...size }),
      plot({ title: "Mean at each position", x: { label: "position of the table", whole: true }, y: { label: "mean distance, mm" }, series: each(k => ({ points: byPosition(k) })), marks: [{ y: 0, name: "", colour: INK.mark }], ...size })),
    note("Means off zero along a piece of the profile: the rail is worn or not the one that the survey names; off zero at some positions: the table's turns or the INS."));
  const rows = byElement(), end = roundUp(1.2 * Math.max(...rows.map(({ own }) => Math.abs(mean(own.map(r => r.joint_mm))) + rms(own.map(r => r.joint_mm)))), [1, 1.5, 2, 3, 4, 5, 7, 10]), half = Math.ceil(rows.length / 2);
  add("elements", "Residuals by element of the rail", keys([{ name: "mean (dot) and RMS (bar)", colour: "var(--joint)", dash: "" }, { name: "RMS to expect from the stated noise (marks)", colour: "var(--good)" }]),
    el("div", { class: "row2" }, [rows.slice(0, half), rows.slice(half)].filter(part => part.length).map(part => elementChart(part, end))),
    folded("The same as a table", table(["element", number("points shown"), number("mean, mm"), number("RMS, mm"), number("stated, mm")], rows.map(({ name, own }) => { const values = own.map(r => r.joint_mm); return [name, number(grouped(own.length)), number(digits(mean(values), 4)), number(digits(rms(values), 4)), number(digits(rms(own.map(r => r.stated_mm)), 4))]; }))));
}

OWN.push(buildProfiles, buildSweeps, buildResiduals, buildAlong, buildStand);
