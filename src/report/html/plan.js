// The plan's page: what each pass gains, candidates compared, the courses from above, values compared, tables.

const COLOURS = SOUGHT.map((_, i) => WHEEL[i % WHEEL.length]);
const WANTED = shownOf(RESULT.wanted);
const inWanted = six => { const shown = shownOf(six); return shown ? shown.map((v, i) => missing(v) ? null : v / WANTED[i]) : null; };
const parameterKeys = () => keys(SOUGHT.map((p, i) => ({ name: p.name, colour: COLOURS[i], dash: "" })));

function buildHead() {
  section("version").textContent = RESULT.software.version;
  section("title").textContent = RESULT.scenario;
  section("headline").textContent = DATA.headline;
  const needed = RESULT.passes_needed, chips = [chip(missing(needed) ? "wanted accuracy not reached" : `${needed} to sail`, missing(needed) ? "warn" : "good"),
    chip(`${RESULT.sailed.length} sailed`), chip(`${RESULT.candidates.length} candidates`), chip(`${RESULT.criterion.toUpperCase()}-optimal, greedy`)];
  section("chips").append(...chips, ...RESULT.unreachable.map(name => chip(`${name}: not within reach of these passes`, "bad")));
  section("footer").textContent = `${RESULT.software.name} ${RESULT.software.version}. The numbers of this page, in full precision, are in plan.json beside it.`;
}

// WHAT EACH PASS GAINS

function buildGain() {
  const begin = RESULT.sailed.length, steps = [...(RESULT.sailed_standard_deviation ? [[begin, inWanted(RESULT.sailed_standard_deviation)]] : []), ...RESULT.chosen.map((step, k) => [begin + k + 1, inWanted(step.standard_deviation)])];
  if (steps.length < 2) return;
  const series = SOUGHT.map((p, i) => ({ name: p.name, colour: COLOURS[i], points: steps.map(([n, six]) => [n, six[i]]) }));
  const floor = inWanted(RESULT.floor), levels = (floor || []).flatMap((f, i) => f > 0.02 ? [{ colour: COLOURS[i], dash: "3 4", thin: true, dots: false, points: [[steps[0][0], f], [steps[steps.length - 1][0], f]] }] : []);
  add("gain", "Standard deviations with the number of passes", parameterKeys(),
    plot({ title: "In units of the wanted accuracy", x: { label: "passes in all", whole: true }, y: { label: "sigma / wanted sigma", log: true }, series: [...levels, ...series], marks: [{ y: 1, name: "wanted" }], width: 620, height: 310 }),
    note("Each pass is the best of the candidates at that point. Dotted: the limit that no number of these passes goes below", floor && floor.every(f => f <= 0.02) ? " (here too low to be drawn)." : "."));
}

// CANDIDATES

const OFFERED = RESULT.candidates.map((c, k) => ({ pass: c.pass, six: shownOf(c.standard_deviation_if_next), k })).filter(c => c.six);
const differ = of => new Set(RESULT.candidates.map(c => of(c.pass))).size > 1;

/** Only what tells the candidates apart. */
function shortName(pass) {
  return [`${short(pass.distance_m)} m`, differ(p => p.speed_m_s) ? `${short(pass.speed_m_s)} m/s` : "", differ(p => Math.sign(p.to_m - p.from_m)) && OFFERED.some(c => c.pass.to_m < c.pass.from_m) ? (pass.to_m > pass.from_m ? "+Y" : "-Y") : "",
    pass.crab_deg ? `crab ${short(pass.crab_deg)}` : ""].filter(part => part).join(", ");
}

/** Candidates without figures, by their reason. */
function notOffered() {
  const reasons = {};
  RESULT.candidates.filter(c => c.refusal).forEach(c => (reasons[c.refusal] = reasons[c.refusal] || []).push(c.pass.name));
  return Object.entries(reasons).map(([reason, names]) => note(`Not offered: ${names.slice(0, 3).join("; ")}${names.length > 3 ? ` and ${names.length - 3} more` : ""}: ${reason}.`));
}

function candidateBars(parameter, i) {
  const rows = OFFERED.map(({ pass, six, k }) => ({ name: RESULT.faces_from_above_m.length ? shortName(pass) : pass.name, six, k })).filter(r => !missing(r.six[i])), chosen = RESULT.chosen.length ? RESULT.chosen[0].candidate : -1;
  const sailed = shownOf(RESULT.sailed_standard_deviation), width = 380, left = Math.max(60, 6.3 * Math.max(...rows.map(r => r.name.length)) + 10), right = 56, row = 17, top = 4, bottom = top + row * rows.length;
  const values = rows.filter(r => r.six).map(r => r.six[i]), end = 1.05 * Math.max(...values, sailed && !missing(sailed[i]) ? sailed[i] : 0, 1e-12), at = v => left + v / end * (width - left - right);
  const bars = rows.flatMap((r, k) => [text(left - 6, top + (k + 0.5) * row + 4, r.name, { "text-anchor": "end", style: `font-size:11px${r.k === chosen ? ";font-weight:700" : ""}` }),
    svg("rect", { x: left, y: top + k * row + 3, width: Math.max(0.5, at(r.six[i]) - left), height: row - 5, fill: COLOURS[i], "fill-opacity": r.k === chosen ? 1 : 0.5 }),
    text(width - 2, top + (k + 0.5) * row + 4, short(r.six[i]), { "text-anchor": "end", class: "soft", style: "font-size:11px" })]);
  const lines = [[WANTED[i], "var(--good)"], ...(sailed && !missing(sailed[i]) ? [[sailed[i], "var(--soft)"]] : [])].filter(([v]) => v <= end).map(([v, colour]) => svg("line", { x1: at(v), x2: at(v), y1: top, y2: bottom, stroke: colour, "stroke-width": 1.5, "stroke-dasharray": "5 3" }));
  return el("figure", {}, el("h3", {}, parameter.name, el("small", {}, `  sigma, ${parameter.unit}`)), picture(width, bottom + 6, `candidates, ${parameter.name}`, lines, bars));
}

function buildCandidates() {
  if (!RESULT.candidates.length) return;
  add("candidates", "If one of the candidates were sailed next", keys([{ name: "chosen", colour: "#2a6fbb" }, { name: "wanted", colour: "var(--good)", dash: "5 3" }, ...(RESULT.sailed_standard_deviation ? [{ name: "as sailed so far", colour: "var(--soft)", dash: "5 3" }] : [])]),
    OFFERED.length ? el("div", { class: "grid3" }, SOUGHT.map(candidateBars)) : [], notOffered());
}

// COURSES FROM ABOVE

/** Without a target: the courses on the map, north up, metres about the first begin. */
function buildChart(passes, colours) {
  const placed = passes.filter(({ pass }) => pass.begin_deg && pass.end_deg);
  if (!placed.length) return;
  const [lat0, lon0] = placed[0].pass.begin_deg, metres = ([lat, lon]) => [(lon - lon0) * 111320 * Math.cos(lat0 * Math.PI / 180), (lat - lat0) * 110870];
  const ends = placed.map(({ pass }) => [metres(pass.begin_deg), metres(pass.end_deg)]), all = ends.flat(), span = k => [Math.min(...all.map(p => p[k])), Math.max(...all.map(p => p[k]))];
  const [[west, east], [south, north]] = [span(0), span(1)], size = Math.min(Math.min(700, ROOM - 120) / Math.max(east - west, 1), 480 / Math.max(north - south, 1)), left = 60, top = 20, width = left + (east - west) * size + 60, height = top + (north - south) * size + 60;
  const at = ([x, y]) => [left + (x - west) * size, top + (north - y) * size], same = {};
  const drawn = placed.map(({ pass, kind }, k) => {
    const [[x1, y1], [x2, y2]] = ends[k].map(at), key = [x1 + x2, y1 + y2].map(v => v.toFixed(0)).join(), n = same[key] = (same[key] || 0) + 1, far = Math.hypot(x2 - x1, y2 - y1) || 1, [u, v] = [(x2 - x1) / far, (y2 - y1) / far], off = 6 * (n - 1) * (u + v < 0 ? -1 : 1), [dx, dy] = [-v * off, u * off];
    return svg("g", {}, svg("title", {}, `${kind}: ${pass.name}`), svg("line", { x1: x1 + dx, y1: y1 + dy, x2: x2 + dx, y2: y2 + dy, stroke: colours[kind], "stroke-width": kind === "candidate" ? 1.4 : 2.4 }),
      svg("path", { d: `M${x2 + dx} ${y2 + dy} l${-8 * u - 3.5 * v} ${-8 * v + 3.5 * u} l${7 * v} ${-7 * u} Z`, fill: colours[kind] }));
  });
  const across = ticks(west, east, 5).map(x => text(at([x, south])[0], height - 20, short(x), { "text-anchor": "middle", class: "soft" })), up = ticks(south, north, 6).map(y => text(left - 8, at([west, y])[1] + 4, short(y), { "text-anchor": "end", class: "soft" }));
  add("courses", "The courses from above", keys([...(RESULT.sailed.length ? [{ name: "sailed", colour: colours.sailed, dash: "" }] : []), { name: "chosen", colour: colours.chosen, dash: "" }, { name: "other candidates", colour: colours.candidate, dash: "" }]),
    picture(width, height, "courses from above", drawn, across, up, text((left + width) / 2, height - 3, "east, m", { "text-anchor": "middle", class: "soft" }), text(12, height / 2, "north, m", { transform: `rotate(-90 12 ${height / 2})`, "text-anchor": "middle", class: "soft" })),
    note("North is up. Courses on one track are drawn side by side."));
}

/** Seen from above with the wall at the top, the target's +Y runs to the left. */
function buildCourses() {
  const passes = [...RESULT.sailed.map(pass => ({ pass, kind: "sailed" })), ...RESULT.candidates.map((c, k) => ({ refusal: c.refusal, pass: c.pass, kind: RESULT.chosen.some(s => s.candidate === k) ? "chosen" : "candidate", times: RESULT.chosen.filter(s => s.candidate === k).length })).filter(c => !c.refusal)];
  if (!passes.length) return;
  const colours = { sailed: "var(--ink)", chosen: "var(--joint)", candidate: "var(--mark)" };
  if (!RESULT.faces_from_above_m.length) return buildChart(passes, colours);
  const faces = RESULT.faces_from_above_m, along = [...faces.flat().map(p => p[0]), ...passes.flatMap(({ pass }) => [pass.from_m, pass.to_m])], far = Math.max(...passes.map(({ pass }) => pass.distance_m));
  const low = Math.min(...along) - 1, high = Math.max(...along) + 1, behind = Math.max(0.6, ...faces.flat().map(p => p[1])) + 0.4;
  const size = Math.min(Math.min(860, ROOM - 202) / (high - low), 520 / (far + behind + 1.4)), left = 52, top = 12, width = left + (high - low) * size + 150, height = top + (far + behind + 1.2) * size + 34;
  const at = (y, x) => [left + (high - y) * size, top + (behind - x) * size];
  const wall = faces.map(face => svg("polygon", { points: face.map(p => at(p[0], p[1]).map(v => v.toFixed(1)).join(",")).join(" "), fill: "#d9c9a8", "fill-opacity": 0.55, stroke: "#8a7443", "stroke-width": 0.8 }));
  const depth = ticks(0, far, 5).flatMap(d => [svg("line", { x1: left, x2: at(low, 0)[0], y1: at(0, -d)[1], y2: at(0, -d)[1], stroke: INK.line }), text(left - 6, at(0, -d)[1] + 4, short(d), { "text-anchor": "end", class: "soft" })]);
  const across = ticks(low, high, Math.max(3, Math.min(8, (high - low) * size / 50))).map(y => text(at(y, 0)[0], height - 20, short(y), { "text-anchor": "middle", class: "soft" }));
  const groups = {};
  passes.forEach(one => { const key = one.pass.distance_m; (groups[key] = groups[key] || []).push(one); });
  const courses = Object.values(groups).flatMap(list => list.sort((a, b) => "candidate chosen sailed".indexOf(a.kind) - "candidate chosen sailed".indexOf(b.kind)).flatMap((one, k) => course(one, k, list.length, at, colours)));
  const counted = Object.values(groups).flatMap(list => {
    const chosen = list.filter(one => one.times), words = chosen.map(one => `${one.times} x ${shortName(one.pass).replace(/^[^,]*,? ?/, "") || "straight"}`);
    return words.map((word, k) => text(at(low, 0)[0] + 6, at(0, -list[0].pass.distance_m)[1] + 4 + 13 * (k - (words.length - 1) / 2), word, { style: `font-size:11px;fill:${colours.chosen}` }));
  });
  add("courses", "The courses from above, before the wall", keys([...(RESULT.sailed.length ? [{ name: "sailed", colour: colours.sailed, dash: "" }] : []), { name: "chosen", colour: colours.chosen, dash: "" }, { name: "other candidates", colour: colours.candidate, dash: "" }]),
    picture(width, height, "courses from above", depth, wall, courses, counted, across, text((left + at(low, 0)[0]) / 2, height - 3, "Y along the wall, m", { "text-anchor": "middle", class: "soft" }),
      text(12, height / 2, "distance from the wall, m", { transform: `rotate(-90 12 ${height / 2})`, "text-anchor": "middle", class: "soft" })),
    note("Passes at the same distance are drawn side by side. Short strokes show the heading where it is not the course."));
}

function course({ pass, kind }, k, count, at, colours) {
  const [x1, y] = at(pass.from_m, -pass.distance_m), x2 = at(pass.to_m, 0)[0], shift = (k - (count - 1) / 2) * 7, way = Math.sign(x2 - x1), colour = colours[kind], Y = y + shift;
  const arrow = svg("path", { d: `M${x2} ${Y} l${-8 * way} -3.5 l0 7 Z`, fill: colour }), line = svg("line", { x1, x2: x2 - 5 * way, y1: Y, y2: Y, stroke: colour, "stroke-width": kind === "candidate" ? 1.4 : 2.4 });
  const turn = pass.crab_deg * Math.PI / 180, middle = (x1 + x2) / 2 + (k - (count - 1) / 2) * 26;
  const bow = pass.crab_deg ? [svg("line", { x1: middle, y1: Y, x2: middle + 18 * way * Math.cos(turn), y2: Y + 18 * way * Math.sin(turn), stroke: colour, "stroke-width": 2 })] : [];
  return [svg("g", {}, svg("title", {}, `${kind}: ${pass.name}`), line, arrow, bow)];
}

// VALUES COMPARED

function buildVariations() {
  const all = RESULT.variations;
  if (!all) return;
  const single = all.keys.length === 1, home = add("variations", `The scenario's own passes with other values of ${all.keys.join(" and ")}`);
  if (single) {
    const x = abscissae(all.points.map(p => p.values[0])), series = SOUGHT.map((p, i) => ({ colour: COLOURS[i], points: all.points.map((point, k) => [x.places[k], point.standard_deviation ? inWanted(point.standard_deviation)[i] : null]) }));
    home.append(parameterKeys(), plot({ title: "In units of the wanted accuracy", x: { label: all.keys[0], log: x.log, words: x.words }, y: { label: "sigma / wanted sigma", log: true }, series, marks: [{ y: 1, name: "wanted" }], width: 860, height: 340 }));
  } else {
    const distinct = k => all.points.map(p => p.values[k]).filter((v, i, list) => list.indexOf(v) === i), rows = distinct(0), columns = distinct(1);
    const value = i => (r, c) => { const point = all.points.find(p => p.values[0] === rows[r] && p.values[1] === columns[c]); return point && point.standard_deviation ? shownOf(point.standard_deviation)[i] : null; };
    home.append(note(`Rows: ${all.keys[0]}; columns: ${all.keys[1]}.`), el("div", { class: "grid3" }, SOUGHT.map((p, i) => { const found = rows.flatMap((_, r) => columns.map((_, c) => value(i)(r, c))).filter(v => v > 0); return pairMap({ title: p.name, sub: `sigma, ${p.unit}`, rows, columns, value: value(i), low: Math.min(...found), high: Math.max(...found), name: all.keys[1] }); })));
  }
  home.append(note("These cannot be mixed in one survey, so they are compared, not combined."),
    table([...all.keys.map(number), ...UNITS, ""], all.points.map(p => [...p.values.map(v => number(String(v))), ...cells(p.standard_deviation), p.refusal || ""])));
}

// TABLES

const UNITS = SOUGHT.map(p => number(`${p.name}, ${p.unit}`));
const cells = six => { const shown = shownOf(six); return shown ? shown.map(v => number(missing(v) ? "-" : short(v))) : SOUGHT.map(() => number("-")); };

function buildTables() {
  const pass = p => [p.name, number(`${short(p.from_m)} to ${short(p.to_m)}`)];
  add("tables", "Standard deviations",
    table(["with", ...UNITS], [["wanted", ...cells(RESULT.wanted)], [RESULT.sailed.length ? "as sailed so far" : "nothing sailed", ...cells(RESULT.sailed_standard_deviation)], ...(RESULT.floor ? [["a million of each (limit)", ...cells(RESULT.floor)]] : [])]),
    RESULT.chosen.length ? [el("h3", {}, "Order to sail"), table([number("#"), "pass", ...UNITS], RESULT.chosen.map((s, k) => [number(String(k + 1)), s.name, ...cells(s.standard_deviation)]))] : [],
    el("details", {}, el("summary", {}, "Candidates, if sailed next"), table([number("#"), "pass", number("Y, m"), number("soundings"), number("returns"), ...UNITS], RESULT.candidates.map((c, k) => [number(String(k + 1)), ...pass(c.pass), number(grouped(c.soundings)), number(grouped(c.returns)), ...cells(c.standard_deviation_if_next)]).filter((_, k) => !RESULT.candidates[k].refusal))));
}

function buildEnd() {
  add("notes", "Notes", el("ul", { class: "weak" }, RESULT.notes.map(words => el("li", {}, words))), RESULT.command ? [el("h3", {}, "Command"), el("pre", {}, RESULT.command)] : []);
}

[buildHead, buildGain, buildCandidates, buildCourses, buildVariations, buildTables, buildEnd, buildContents].forEach(build => build());

document.documentElement.dataset.ready = "yes";
