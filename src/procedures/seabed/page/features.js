// Features that the paper's path matched between the lines.

/** Places of the matches as the first line has them, an arrow to where the second has them, enlarged. */
function matchMap(pair) {
  const first = SEA.layout.tracks.find(t => t.name === pair.lines[0]), course = first.course_deg / DEGREE, [s, c] = [Math.sin(course), Math.cos(course)];
  const turn = (east, north) => [east * s + north * c, north * s - east * c];
  const arrows = pair.places_m.map(([e1, n1, e2, n2]) => ({ at: turn(e1, n1), by: turn(e2 - e1, n2 - n1) }));
  const ends = k => arrows.reduce(([low, high], a) => [Math.min(low, a.at[k]), Math.max(high, a.at[k])], [Infinity, -Infinity]);
  const [right, up] = [ends(0), ends(1)], pad = 26, size = Math.min((ROOM - 66) / Math.max(right[1] - right[0], 1), 260 / Math.max(up[1] - up[0], 1));
  const width = Math.max(300, (right[1] - right[0]) * size + 2 * pad), height = (up[1] - up[0]) * size + 2 * pad;
  const longest = Math.max(1e-3, ...arrows.map(a => Math.hypot(...a.by))), stretch = 24 / longest;
  const marks = arrows.map(({ at, by }) => {
    const [x, y] = [pad + (at[0] - right[0]) * size, pad + (up[1] - at[1]) * size].map(v => Number(v.toFixed(1)));
    return svg("g", {}, svg("circle", { cx: x, cy: y, r: 2.4, fill: "var(--reference)" }), svg("line", { x1: x, y1: y, x2: (x + by[0] * stretch).toFixed(1), y2: (y - by[1] * stretch).toFixed(1), stroke: "var(--reference)", "stroke-width": 1.3 }));
  });
  return el("figure", {}, el("h3", {}, `lines ${pair.lines.join(" and ")}`, el("small", {}, `  ${grouped(pair.kept)} matches${pair.places_m.length < pair.kept ? `, ${pair.places_m.length} drawn` : ""}; longest arrow ${digits(longest, 2)} m`)),
    picture(width, height, `matched features of lines ${pair.lines.join(" and ")}`, marks));
}

function buildFeatures() {
  const found = SEA.features;
  if (!found) return;
  const three = values => number(values.map(v => digits(v, 3)).join("  ")), ms = value => digits(1e3 * value, 2);
  add("features", "Features matched between the lines", found.pairs.filter(pair => pair.places_m.length).map(matchMap),
    table(["lines", number("keypoints"), number("matched"), number("one shift"), number("within 2 sigma"), number("mean north, east, down, m"), number("sigma, m")],
      found.pairs.map(pair => [pair.lines.join(", "), number(pair.keypoints.map(grouped).join("  ")), number(grouped(pair.matched)), number(grouped(pair.agreeing)), number(grouped(pair.kept)), three(pair.mean_m), three(pair.sigma_m)])),
    note(`Cells of ${digits(found.cell_m, 2)} m. Dots: features on the first line; arrows: to the same features on the second, enlarged. Latency: ${ms(found.latency_s.bounded)} ms bounded as the paper has it, ${ms(found.latency_s.free)} ms free.`));
}
