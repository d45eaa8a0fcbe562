// Solutions and their parameters, in the order in which every picture and table shows them.

const PATHS = [
  { key: "reference", name: "Reference", colour: "var(--reference)" },
  { key: "joint", name: "Joint", colour: "var(--joint)" },
  { key: "joint_simple", name: "Simple joint", colour: "var(--simple)" },
].map(path => ({ ...path, solution: RESULT.solutions[path.key] || null })).filter(path => path.solution);

/** Paths whose numbers may be shown. */
const ESTIMATED = PATHS.filter(path => path.solution.usable && path.solution.parameters.length);

/** The parameters of the fullest solution. */
const SOUGHT = ESTIMATED.reduce((all, path) => path.solution.parameters.length > all.length ? path.solution.parameters : all, []);

function parameterOf(solution, name) { return solution.parameters.find(p => p.name === name) || null; }

/** Metres are shown in millimetres where they are small: corrections, sigmas, differences. */
function inShown(value, unit) { return missing(value) ? null : unit === "m" ? 1e3 * value : value; }

function shownUnit(unit) { return unit === "m" ? "mm" : unit === "1" ? "" : unit; }

function titled(name, unit, positive) { return `${name}${positive ? ` (${positive})` : ""}${shownUnit(unit) ? `, ${shownUnit(unit)}` : ""}`; }

/** A correction with its sigma, or without one. */
function correctionText(p) {
  if (!p || missing(p.correction)) return p && p.note ? p.note : "-";
  const value = inShown(p.correction, p.unit);
  return missing(p.sigma) ? (p.unit === "1" ? short(value) : plain(value, p.unit)) + (p.note ? ` (${p.note})` : "") : withSigma(value, inShown(p.sigma, p.unit));
}

function truthOf(name) { return DATA.against_truth ? DATA.against_truth.rows.find(row => row.name === name) || null : null; }

function differenceOf(name) { return RESULT.comparison ? RESULT.comparison.differences.find(d => d.name === name) || null : null; }

function statusWords(solution) {
  const words = solution.status.replaceAll("_", " ");
  return solution.usable ? words : `${words}, not usable`;
}

function testVerdict(test) { return test.void_because ? `not valid: ${test.void_because}` : test.passed ? "passed" : "failed"; }

function pathKeys() { return keys(ESTIMATED.map(path => ({ name: path.name, colour: path.colour }))); }
