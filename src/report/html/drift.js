// How the trajectory drifted, where an adjustment estimates it along.

/** A plot for each drifting quantity, with one stated sigma on either side. Parts are set apart where the survey paused. */
function driftPlot(drift) {
  const series = drift.parts.filter(part => part.length).map(points => ({ colour: "var(--joint)", points, dots: points.length < 3 }));
  const level = sign => ({ y: sign * drift.sigma, name: sign > 0 ? "stated sigma" : "", colour: INK.mark });
  return plot({ title: drift.name, x: { label: "time since the first record, s" }, y: { label: drift.unit }, series, marks: [level(1), level(-1)], width: 380, height: 220 });
}

function buildDrift(list, kind) {
  if (!list || !list.length) return;
  add("drift", "Drift of the INS as estimated", el("div", { class: "row3" }, list.map(driftPlot)),
    note(`How far the INS was off as the joint path estimates it, apart from its noise from record to record. ${kind} A curve that stays outside the dashed lines: the INS drifts more than the survey states.`));
}
