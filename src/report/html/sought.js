// The parameters of a budget or a plan and the paths to them, as they are shown.

/** Units that are shown finer than they are kept. */
const FINER = { m: ["mm", 1e3], s: ["ms", 1e3], 1: ["ppm", 1e6] };

const SOUGHT = RESULT.parameters.map((parameter, index) => {
  const [unit, factor] = FINER[parameter.unit] || [parameter.unit, 1];
  return { name: parameter.name, unit, factor, index };
});

/** Width of the longest name in a picture. */
const NAME_WIDTH = 14 + 6.3 * Math.max(0, ...SOUGHT.map(p => p.name.length));

/** Figures of a result in the units shown, in the parameters' order, null where one is missing; null where there are none. */
function shownOf(figures) { return figures ? SOUGHT.map((p, i) => missing(figures[i]) ? null : figures[i] * p.factor) : null; }

/** The paths of a budget. */
const BUDGET_PATHS = {
  joint: { name: "Joint", colour: "var(--joint)" },
  reference: { name: "Reference", colour: "var(--reference)" },
  reference_projected: { name: "Reference, projected", colour: "var(--simple)" },
};
