// Tables: solution, conventions, quality, counts, configuration, inputs.

/** What a procedure adds: its scripts put builders here, run in this order after the card. */
const OWN = [];

// SOLUTION

function correctionRows() {
  return SOUGHT.map(p => {
    const difference = differenceOf(p.name), truth = truthOf(p.name);
    return [titled(p.name, p.unit, p.positive), ...ESTIMATED.map(path => number(correctionText(parameterOf(path.solution, p.name)))),
      ...(RESULT.comparison ? [number(difference ? digits(difference.in_joint_sigmas, 1) : "")] : []),
      ...(DATA.against_truth ? [number(truth ? plain(inShown(truth.correction, p.unit), p.unit) : "-"), number(truth ? digits(truth.joint_in_sigmas, 1) : "-")] : [])];
  });
}

function mountingRows(index) {
  const of = (key, field) => ESTIMATED.map(path => { const m = path.solution.mountings[index]; return number(m && m[key] ? digits(m[key][field], 4) : "-"); });
  const rows = [["roll (starboard down), deg", ...of("mounting_deg", "roll")], ["pitch (bow up), deg", ...of("mounting_deg", "pitch")], ["heading (clockwise), deg", ...of("mounting_deg", "heading")]];
  if (!ESTIMATED.some(path => path.solution.mountings[index] && path.solution.mountings[index].lever_arm_m)) return rows;
  return [...rows, ["lever arm x (right), m", ...of("lever_arm_m", 0)], ["lever arm y (forward), m", ...of("lever_arm_m", 1)], ["lever arm z (up), m", ...of("lever_arm_m", 2)]];
}

function buildSolution() {
  const home = add("solution", "Solutions", table(["solution", "outcome", "remark"], PATHS.map(path => [path.name, statusWords(path.solution), path.solution.message || ""])));
  if (RESULT.notes.length) home.append(el("ul", { class: "weak" }, RESULT.notes.map(words => el("li", {}, `${words}.`))));
  if (!ESTIMATED.length) return;
  const names = ESTIMATED.map(path => number(path.name)), compared = RESULT.comparison ? [number("reference - joint, in sigmas of joint")] : [];
  home.append(el("h3", {}, "Corrections, one sigma"), table(["", ...names, ...compared, ...(DATA.against_truth ? [number("truth"), number("joint's error, sigmas")] : [])], correctionRows()));
  if (DATA.difference) home.append(note(DATA.difference));
  ESTIMATED[ESTIMATED.length - 1].solution.mountings.forEach((m, i) => home.append(el("h3", {}, `Mounting of the ${m.name}`), table(["", ...names], mountingRows(i))));
  home.append(rmsTable());
}

/** RMS by solution: it says how well each fits, not which one is right. */
function rmsTable() {
  const rows = Object.entries(RESULT.residual_rms_m || {});
  if (!rows.length) return "";
  return folded("RMS of the residuals", table(["solution", number("RMS, mm")], rows.map(([name, rms]) => [name.replace("_", ", "), number(digits(1e3 * rms, 3))])),
    note("The same observations for every solution. A solution with more freedom always fits better: the RMS does not say which one is right."));
}

// CONVENTIONS

function fieldLines(fields, places, unit) {
  return fields.map(field => el("div", {}, `${field.name}${missing(field.value) ? ": left out" : `  ${digits(field.value, places)} ${unit}`}`, el("small", {}, `  + ${field.positive}`)));
}

/** The program, and which record of it where there are several. */
function programName(entry) {
  const several = RESULT.conventions.some(other => other.software === entry.software && other !== entry);
  return several ? `${entry.software}: ${entry.mounting}` : entry.software;
}

function buildConventions() {
  if (!RESULT.conventions.length) return;
  add("conventions", "Conventions of other software",
    note("The same mounting with other programs' axes and signs. Lever arms run from the INS centre to the sonar; a program that counts from another reference point needs the INS's own offset added. ",
      "What no public document settles is left out, not guessed."),
    table(["software", "lever arm", "mounting angles", "signs, order, source"], RESULT.conventions.map(entry => [
      el("span", {}, el("b", {}, programName(entry)), el("div", {}, el("small", {}, entry.axes))),
      el("span", { style: "white-space:nowrap" }, fieldLines(entry.lever_arm_m, 4, "m")),
      el("span", { style: "white-space:nowrap" }, fieldLines(entry.angles_deg, 4, "deg")),
      el("span", {}, entry.remark, entry.sources.map(source => el("div", {}, el("small", {}, source))))])),
    note("Ours: body x right, y forward, z up; R = Rz(-heading) Rx(pitch) Ry(roll), sonar to body."));
}

// QUALITY

function qualityFacts(quality) {
  const test = quality.global_test, reliability = quality.reliability;
  return table(["figure", number("value"), "remark"], [
    ["variance factor", number(digits(quality.variance_factor, 4)), `a priori 1; ${grouped(quality.degrees_of_freedom)} degrees of freedom`],
    ["global test", number(testVerdict(test)), `${percent(1 - test.significance)} interval ${digits(test.lower, 4)} to ${digits(test.upper, 4)}${missing(test.practical_tolerance) ? "" : `; in practice within ${short(test.practical_tolerance)} of 1`}`],
    ["redundancy number, mean", number(digits(reliability.mean_redundancy_number, 3)), "share of an observation's error that shows in its own residual"],
    ["redundancy number, smallest", number(digits(reliability.smallest_redundancy_number, 3)), ""],
  ]);
}

function worstTable(reliability) {
  const effect = entry => Object.entries(entry.effect).filter(([, size]) => Math.abs(size) > 0).map(([name, size]) => `${name} ${short(size)}`).join(", ");
  return table(["condition", number("normalised residual"), number("minimal detectable bias, mm"), "its effect"],
    reliability.worst.map(entry => [entry.observation, number(digits(entry.w, 2)), number(digits(1e3 * entry.minimal_detectable_bias_m, 1)), effect(entry)]));
}

function qualityOf(path) {
  const quality = path.solution.quality, reliability = quality.reliability, parts = [el("h3", {}, `${path.name} solution`), qualityFacts(quality)];
  if (quality.groups.length) parts.push(el("h3", {}, "Groups of observations"), table(["group", number("observations"), number("redundancy"), number("variance component"), "remark"],
    quality.groups.map(group => [group.name, number(grouped(group.observations)), number(digits(group.redundancy, 1)),
      number(missing(group.variance_component) ? "held at 1" : withSigma(group.variance_component, group.standard_deviation)), group.note || ""])));
  if (quality.priors.length) parts.push(folded("Prior values used as observations", table(["prior", number("one sigma"), "unit"],
    quality.priors.map(prior => [prior.name, number(short(prior.standard_deviation)), prior.unit]))));
  if (reliability.tests && reliability.tests.length) parts.push(el("h3", {}, "Data snooping"), table(["level", number("significance"), number("critical |w|"), number("delta0"), number("flagged")],
    reliability.tests.map(test => [test.name, number(percent(test.significance)), number(digits(test.critical_value, 2)), number(digits(test.non_centrality, 2)), number(grouped(test.flagged))])));
  if (reliability.worst.length) parts.push(el("h3", {}, "Largest normalised residuals"), worstTable(reliability),
    el("p", { class: "note" }, `Minimal detectable bias: along the face's normal, at ${percent(reliability.significance)} significance and ${percent(reliability.power)} power. Range and angles of a sounding share one condition; the data cannot tell which of them is faulty.`));
  return parts;
}

function buildQuality() {
  const paths = PATHS.filter(path => path.solution.quality);
  if (paths.length) add("quality", "Quality figures", ...paths.flatMap(path => path.key === "joint" ? qualityOf(path) : folded(`${path.name} solution`, ...qualityOf(path))));
}

// COUNTS, CONFIGURATION

function buildCounts() {
  const rows = Object.entries(RESULT.counts).flatMap(([name, counts]) => [[el("b", {}, name), "read", number(grouped(counts.read))], ["", "used", number(grouped(counts.used))],
    ...Object.entries(counts.rejected).sort((a, b) => b[1] - a[1]).map(([reason, count]) => ["", `not used: ${reason}`, number(grouped(count))])]);
  add("counts", "Observations", table(["", "", number("count")], rows));
}

function buildConfiguration() {
  add("configuration", "Configuration and inputs", folded("Configuration used", el("pre", {}, JSON.stringify(RESULT.configuration, null, 2))),
    folded("Inputs", table(["file", "SHA-256"], RESULT.inputs.map(file => [file.path, mono(file.sha256)]))), note(`Seed ${RESULT.seed}.`));
}
