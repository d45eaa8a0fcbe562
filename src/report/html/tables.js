// Tables: solution, conventions, quality, counts, configuration, inputs.

// SOLUTION

function statusWords(solution) {
  const words = solution.status.replaceAll("_", " ");
  return solution.usable ? words : `${words}, not usable`;
}

function correctionRows() {
  const sigmas = RESULT.comparison && RESULT.comparison.in_joint_sigmas;
  return PARAMETERS.map(parameter => [`${parameter.name} (${parameter.sense}), ${parameter.unit}`,
    ...ESTIMATED.map(path => {
      const value = correction(path.solution, parameter), sigma = sigmaOf(path.solution, parameter);
      return number(sigma ? withSigma(value, sigma) : plain(value, parameter.unit));
    }),
    ...(sigmas ? [number(digits(sigmas[parameter.key], 1))] : []),
    ...(DATA.truth ? [number(plain(correction(DATA.truth, parameter), parameter.unit))] : [])]);
}

function mountingRows() {
  const angle = key => ESTIMATED.map(path => number(digits(path.solution.mounting_deg && path.solution.mounting_deg[key], 4)));
  const arm = axis => ESTIMATED.map(path => number(digits(path.solution.lever_arm_m && path.solution.lever_arm_m[axis], 4)));
  return [["roll (starboard down), deg", ...angle("roll")], ["pitch (bow up), deg", ...angle("pitch")], ["heading (clockwise), deg", ...angle("heading")],
    ["lever arm x (right), m", ...arm(0)], ["lever arm y (forward), m", ...arm(1)], ["lever arm z (up), m", ...arm(2)]];
}

function buildSolution() {
  const home = section("solution"), names = ESTIMATED.map(path => number(path.name));
  home.append(table(["path", "end", "remark"], PATHS.map(path => [path.name + (path.solution.variant ? ` (${path.solution.variant})` : ""), statusWords(path.solution), path.solution.message || ""])));
  if (!ESTIMATED.length) return;
  const compared = RESULT.comparison ? [number("sequential - joint, in sigmas of joint")] : [];
  home.append(el("h3", {}, "Corrections, one sigma"), table(["", ...names, ...compared, ...(DATA.truth ? [number("truth")] : [])], correctionRows()));
  if (RESULT.comparison) home.append(comparisonNote(RESULT.comparison));
  home.append(el("h3", {}, "Mounting"), table(["", ...names], mountingRows()));
  const pose = RESULT.target_pose;
  if (pose) home.append(el("p", { class: "note" }, `Target pose, refined minus given: ${pose.offset_m.map(v => digits(v, 4)).join(", ")} m in target axes, azimuth ${digits(pose.azimuth_correction_deg, 4)} deg.`));
}

function comparisonNote(comparison) {
  const rms = comparison.residual_rms_m, simple = missing(rms.joint_simple) ? "" : `, simple joint ${digits(1e3 * rms.joint_simple, 1)} mm`;
  return el("p", { class: "note" }, `Chi-square of the difference in the joint covariance: ${digits(comparison.chi_square, 1)} on 6 degrees of freedom, probability of more by chance `,
    `${probability(comparison.p_value)} (significant below ${DATA.significance}). RMS distance of the soundings from the target: sequential ${digits(1e3 * rms.sequential, 1)} mm, joint ${digits(1e3 * rms.joint, 1)} mm${simple}.`);
}

// CONVENTIONS

function fieldLines(fields, places, unit) {
  return fields.map(field => el("div", {}, `${field.name}${missing(field.value) ? ": left out" : `  ${digits(field.value, places)} ${unit}`}`, el("small", {}, `  + ${field.positive}`)));
}

function buildConventions() {
  if (!DATA.conventions.length) { hide("conventions"); return; }
  section("conventions").append(
    el("p", { class: "note" }, "The same mounting in other programs' senses. Lever arms run from the INS centre to the sonar; a program that counts from another reference point needs the INS's own offset added. ",
      "What no public document settles is left out, not guessed."),
    table(["software", "lever arm", "mounting angles", "signs, order, source"], DATA.conventions.map(entry => [
      el("span", {}, el("b", {}, entry.software), el("div", {}, el("small", {}, entry.axes))),
      el("span", { style: "white-space:nowrap" }, fieldLines(entry.lever_arm_m, 4, "m")),
      el("span", { style: "white-space:nowrap" }, fieldLines(entry.angles_deg, 4, "deg")),
      el("span", {}, entry.remark, entry.sources.map(source => el("div", {}, el("small", {}, source))))])),
    el("p", { class: "note" }, "Ours: body x right, y forward, z up; R = Rz(-heading) Rx(pitch) Ry(roll), sonar to body."));
}

// QUALITY

function testVerdict(test) { return test.void_because ? `void: ${test.void_because}` : test.passed ? "passed" : "failed"; }

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
  const effect = entry => PARAMETERS.filter(p => entry.effect[p.sigma]).map(p => `${p.name} ${short(entry.effect[p.sigma] * (p.angle ? 1 : 1e3))} ${p.unit}`).join(", ");
  return table(["condition", number("normalised residual"), number("minimal detectable bias, mm"), "its effect"],
    reliability.worst.map(entry => [entry.observation, number(digits(entry.w, 2)), number(digits(1e3 * entry.minimal_detectable_bias_m, 1)), effect(entry)]));
}

function qualityOf(path) {
  const quality = path.solution.quality, reliability = quality.reliability, parts = [el("h3", {}, `${path.name} solution`), qualityFacts(quality)];
  if (quality.groups.length) parts.push(el("h3", {}, "Groups of observations"), table(["group", number("observations"), number("redundancy"), number("variance component"), "remark"],
    quality.groups.map(group => [group.name, number(grouped(group.observations)), number(digits(group.redundancy, 1)),
      number(missing(group.variance_component) ? "held at 1" : withSigma(group.variance_component, group.standard_deviation)), group.note || ""])));
  if (quality.priors.length) parts.push(el("h3", {}, "Priors that entered as observations"), table(["prior", number("one sigma"), "unit"],
    quality.priors.map(prior => [prior.name, number(short(prior.standard_deviation)), prior.unit])));
  if (reliability.tests && reliability.tests.length) parts.push(el("h3", {}, "Data snooping"), table(["level", number("significance"), number("critical |w|"), number("delta0"), number("flagged")],
    reliability.tests.map(test => [test.name, number(percent(test.significance)), number(digits(test.critical_value, 2)), number(digits(test.non_centrality, 2)), number(grouped(test.flagged))])));
  if (reliability.worst.length) parts.push(el("h3", {}, "Largest normalised residuals"), worstTable(reliability),
    el("p", { class: "note" }, `Minimal detectable bias: along the face's normal, at ${percent(reliability.significance)} significance and ${percent(reliability.power)} power. Range and angles of a sounding share one condition; which of them is faulty cannot be told.`));
  return parts;
}

function buildQuality() {
  const paths = PATHS.filter(path => path.solution.quality);
  if (!paths.length) { hide("quality"); return; }
  section("quality").append(...paths.flatMap(qualityOf));
}

// COUNTS, CONFIGURATION

function buildFaces() {
  const entries = DATA.face_statistics.filter(entry => entry.soundings);
  if (!entries.length) { hide("faces"); return; }
  const paths = PATHS.filter(path => entries.some(entry => !missing(entry.rms_m[path.key]))), mm = value => number(missing(value) ? "-" : digits(1e3 * value, 1));
  section("faces").append(table(["face", "role", number("soundings"), ...paths.flatMap(path => [number(`${path.name}: mean, mm`), number("RMS, mm")])],
    entries.map(entry => [DATA.faces[entry.face].name, DATA.faces[entry.face].role, number(grouped(entry.soundings)), ...paths.flatMap(path => [mm(entry.mean_m[path.key]), mm(entry.rms_m[path.key])])])),
  el("p", { class: "note" }, "All used soundings, distances along the outward normal: positive in front of the face."));
}

function buildCounts() {
  const rows = Object.entries({ soundings: "soundings", returns: "laser returns" }).flatMap(([key, name]) => {
    const counts = RESULT.counts[key];
    return [[el("b", {}, name), "read", number(grouped(counts.read))], ["", "used", number(grouped(counts.used))],
      ...Object.entries(counts.rejected).sort((a, b) => b[1] - a[1]).map(([reason, count]) => ["", `rejected: ${reason}`, number(grouped(count))])];
  });
  section("counts").append(table(["", "", number("count")], rows));
}

function buildConfiguration() {
  section("configuration").append(el("h3", {}, "Configuration as it took effect"), el("pre", {}, JSON.stringify(RESULT.configuration, null, 2)),
    el("h3", {}, "Inputs"), table(["file", "SHA-256"], RESULT.inputs.map(file => [file.path, mono(file.sha256)])), el("p", { class: "note" }, `Seed ${RESULT.seed}.`));
}
