// The verdict: everything that was found, gravest first, with what to try.

const SEVERITIES = { finding: "worth a look", withdraws: "not usable", refuses: "no result" };

function severityChip(finding) {
  if (finding.accepted) return chip("accepted", "warn");
  return chip(SEVERITIES[finding.severity] || finding.severity, finding.severity === "finding" ? "warn" : "bad");
}

/** The parameter that the finding would move most, in its sigmas. */
function effectWords(finding) {
  const effects = Object.entries(finding.effect_in_sigmas || {});
  if (!effects.length) return "";
  const [name, sigmas] = effects.reduce((most, one) => Math.abs(one[1]) > Math.abs(most[1]) ? one : most);
  return `moves ${name} by ${short(sigmas)} sigma`;
}

/** What was tested for and not found: how large it could be. */
function bounds() {
  const all = RESULT.verdict.bounds || [];
  if (!all.length) return [];
  const rows = all.map(bound => [el("code", {}, bound.code), bound.estimate, number(digits(bound.chi_square, 1)), number(bound.degrees_of_freedom), number(probability(bound.p_value)), number(short(bound.largest_effect_in_sigmas))]);
  return el("details", {}, el("summary", {}, `${all.length} other possible errors were tested for`),
    table(["code", "one-step estimate", number("chi-square"), number("degrees of freedom"), number("p"), number("would move, sigma")], rows));
}

function buildVerdict() {
  const { state, findings } = RESULT.verdict;
  if (!findings.length) return add("verdict", `Verdict: ${state}`, note("Nothing was found against the result."), bounds());
  const rows = findings.map(finding => [severityChip(finding), el("code", {}, finding.code), finding.seen, finding.advice || "-", effectWords(finding), finding.threshold || "-"]);
  const refused = findings.some(finding => finding.severity === "refuses");
  const known = !refused && findings.find(finding => finding.severity === "withdraws" && !finding.accepted);
  const list = table(["", "code", "what was seen", "what to try", "effect", "limit"], rows);
  list.classList.add("findings");
  add("verdict", `Verdict: ${state}`, list,
    known ? note(`To accept a finding that you know: [verdict] accept = ["${known.code}"] in the survey file. It stays listed.`) : [], bounds());
}
