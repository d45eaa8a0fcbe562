// A seabed calibration's own sections.

/** Objects as a table: of each column its title, and what stands in it. */
function listed(columns, list) {
  if (!list || !list.length) return [];
  const rows = list.map(row => Object.values(columns).map(cell => cell(row)));
  return table(Object.keys(columns).map((title, k) => String(rows[0][k]).startsWith("#") ? number(title) : title), rows);
}

/** A number with its digits; angles in radians as degrees. */
function measured(value, unit) { return number(missing(value) ? "-" : short(unit === "rad" ? value * DEGREE : value)); }
function unitWords(name, unit) { return `${name.replaceAll("_", " ")}${unit === "rad" ? ", deg" : unit === "1" ? "" : `, ${unit}`}`; }

function linesOf(layout) {
  const name = k => layout.tracks[k].name;
  return [
    listed({ line: t => t.name, "course, deg": t => number(digits(Math.round(t.course_deg) % 360, 0)), "length, m": t => number(digits(t.length_m, 0)), "speed, m/s": t => number(digits(t.speed_m_s, 2)) }, layout.tracks),
    listed({ "pair of lines": p => p.lines.map(name).join(", "), kind: p => p.kind, "apart, m": p => number(digits(p.apart_m, 1)), "ratio of speeds": p => number(digits(p.speed_ratio, 2)), "common tiles": p => number(p.tiles) }, layout.pairs),
  ];
}

function sigmasOf(sigmas) {
  const column = key => s => measured(s[key], s.unit);
  return listed({ "sigma of": s => unitWords(s.name, s.unit), model: column("model"), "tiles' scatter": column("scatter"), "relief alone": column("relief"), "motion alone": column("motion") }, sigmas);
}

function passesOf(passes) {
  return listed({ pass: p => p.phase, tiles: p => number(p.tiles), soundings: p => number(p.soundings), dropped: p => number(p.dropped), "sum of squares / degrees of freedom": p => number(digits(p.omega_over_freedom, 3)), "largest step, sigmas": p => number(short(p.step_sigmas)) }, passes);
}

function stepsOf(steps) {
  const unit = step => step.parameter === "latency" ? "s" : "rad";
  return listed({ step: s => unitWords(s.parameter, unit(s)), lines: s => s.lines.join(", "), cells: s => number(s.cells), "difference before, m": s => number(digits(s.before_m, 4)), "after, m": s => number(digits(s.after_m, 4)), change: s => measured(s.change, unit(s)) }, steps);
}

/** What was estimated of the seabed and the noise. */
function groundOf(joint) {
  return table(["", number("estimate")], [["relief about the tiles' planes, m", number(digits(joint.field.relief_m, 3))], ["its correlation length, m", number(digits(joint.field.length_m, 1))],
    ["noise / claimed noise", number(digits(joint.field.noise_factor, 2))], ["tiles", number(joint.tiles)], ["sum of squares / degrees of freedom", number(digits(joint.omega_over_freedom, 3))]]);
}

function buildSeabed() {
  const details = SEA, joint = details.joint, patch = details.patch_test;
  add("lines", "Lines and pairs of lines", linesOf(details.layout));
  if (joint) add("information", "Where the information comes from", sigmasOf(joint.sigmas), note("Standard deviations by the model, from the scatter of the tiles, and what relief alone and the boat's motion alone would give. What comes from motion is only as good as the heave channel."));
  if (joint) add("ground", "Seabed and noise as estimated", groundOf(joint));
  if (joint) add("passes", "Passes of the joint adjustment", passesOf(joint.passes));
  if (patch) add("patch", "Steps of the patch test", stepsOf(patch), note("Each parameter where the surfaces of its two lines differ least, the others held."));
}

function buildSeabedDrift() { buildDrift(VIEWS.drift, "A curve for each line."); }

OWN.push(buildDifferences, buildCoverage, buildBeams, buildHeights, buildFeatures, buildSeabedDrift, buildSeabed);
