// Which source costs how much: stacked bars and tornado.

const ORIGINS = [["analytic", "analytic"], ["monte_carlo", "Monte Carlo"]];
/** Trials below which their variance says little of a share: one sigma of it is above a fifth. */
const TELLING = 50;
const fewTrials = RESULT.paths.flatMap(path => path.shares).filter(s => s.origin === "monte_carlo" && s.source !== "nothing" && s.share && s.usable < TELLING);
fewTrials.forEach(s => { s.share = null; });

const APART = ["nothing", "remainder", "interaction"];
const TITLES = Object.fromEntries(RESULT.sources.map(s => [s.source, s.title]));
TITLES.remainder = "remainder (together minus the sum)";
TITLES.interaction = "interaction of the sources";
TITLES.nothing = "the method itself, without any source";
const titleOf = source => TITLES[source] || source.replaceAll("_", " ");
const pathName = path => BUDGET_PATHS[path.path].name + (path.variant && path.path === "reference" ? ` (${path.variant})` : "");

/** Shares of a path by one way, without what is no source. */
function sourcesOf(path, origin) { return path.shares.filter(s => s.origin === origin && !APART.includes(s.source)); }

function largestShare(source) {
  return Math.max(0, ...RESULT.paths.flatMap(path => path.shares.filter(s => s.source === source && s.share)).flatMap(s => s.share.map(v => v || 0)));
}

/** Sources from the largest share to the smallest; those that reach 2 % of something have a colour of their own. */
const RANKED = [...new Set(RESULT.paths.flatMap(path => path.shares.map(s => s.source)))].filter(s => !APART.includes(s))
  .map(source => [source, largestShare(source)]).sort((a, b) => b[1] - a[1]);
const COLOURS = Object.fromEntries(RANKED.filter(([, share]) => share >= 0.02).slice(0, WHEEL.length).map(([source], i) => [source, WHEEL[i]]));
const OTHERS = "#c9d1d6";
const REST = "#eceff1";

/** The parts of one bar from left to right: [colour, size, words]. */
function barParts(path, origin, parameter) {
  const shares = path.shares.filter(s => s.origin === origin && s.share);
  const size = source => { const found = shares.find(s => s.source === source); return found ? found.share[parameter.index] || 0 : 0; };
  const own = Object.keys(COLOURS).map(source => [COLOURS[source], size(source), titleOf(source)]);
  const others = RANKED.filter(([source]) => !COLOURS[source]).reduce((sum, [source]) => sum + size(source), 0);
  return [...own, [OTHERS, others, "smaller sources"], [REST, size("remainder"), titleOf("remainder")]].filter(part => part[1] > 0);
}

function stackedBars(path) {
  const ways = ORIGINS.filter(([origin]) => path.shares.some(s => s.origin === origin && s.share && !APART.includes(s.source)));
  if (!ways.length) return [];
  const bar = 15, row = ways.length * (bar + 3) + 12, left = Math.max(48, NAME_WIDTH), width = left + 332, right = 26, top = 4, bottom = top + row * SOUGHT.length;
  const end = Math.max(1, ...SOUGHT.flatMap(p => ways.map(([origin]) => barParts(path, origin, p).reduce((sum, part) => sum + part[1], 0))));
  const at = v => left + v / end * (width - left - right);
  const grid = ticks(0, end, 5).flatMap(v => [svg("line", { x1: at(v), x2: at(v), y1: top, y2: bottom, stroke: v === 1 ? "var(--soft)" : INK.line }),
    text(at(v), bottom + 15, `${Math.round(100 * v)} %`, { "text-anchor": "middle", class: "soft" })]);
  const bars = SOUGHT.flatMap((parameter, i) => [text(left - 7, top + (i + 0.5) * row + 1, parameter.name, { "text-anchor": "end" }),
    ...ways.flatMap(([origin, way], k) => {
      let from = 0;
      const y = top + i * row + 5 + k * (bar + 3);
      return [...barParts(path, origin, parameter).map(([colour, size, words]) => {
        const rect = svg("rect", { x: at(from), y, width: Math.max(0.3, at(from + size) - at(from) - 0.4), height: bar, fill: colour, stroke: colour === REST ? "var(--mark)" : null, "stroke-dasharray": colour === REST ? "2 2" : null },
          svg("title", {}, `${words}: ${percent(size)} of the variance of ${parameter.name}, ${way}`));
        from += size;
        return rect;
      }), ways.length > 1 ? text(left + 3, y + 11, k ? "MC" : "an.", { style: "font-size:9px;fill:#fff" }) : []];
    })]);
  const words = ways.length > 1 ? "upper bar analytic, lower trials" : ways[0][1];
  return [el("figure", {}, el("h3", {}, pathName(path), el("small", {}, `  ${words}`)), picture(width, bottom + 22, `shares of variance, ${pathName(path)}`, grid, bars))];
}

function buildShares() {
  const figures = RESULT.paths.flatMap(stackedBars);
  if (!figures.length) return;
  const entries = Object.keys(COLOURS).map(source => ({ name: titleOf(source), colour: COLOURS[source] }));
  add("shares", "Which source costs how much", keys([...entries, { name: "smaller sources", colour: OTHERS }, { name: titleOf("remainder"), colour: REST }]), el("div", { class: "row3" }, figures),
    note("Share of the variance of each parameter. 100 % is the variance of all sources together; the parts can add up to more where sources compensate each other; simulated parts also vary by chance. Without bias.", fewTrials.length ? ` Shares by trials are left out: ${TELLING} of each source are needed.` : ""));
}

// TORNADO

/** What one source does to one parameter by a path: simulated where it was, analytic otherwise. */
function effect(path, source, i) {
  const found = ["monte_carlo", "analytic"].map(origin => path.shares.find(s => s.source === source && s.origin === origin)).find(s => s && s.standard_deviation);
  const sigma = found ? shownOf(found.standard_deviation)[i] : null;
  return missing(sigma) ? null : { sigma, bias: found.bias ? shownOf(found.bias)[i] || 0 : 0, origin: found.origin };
}

const TORNADO_PATHS = RESULT.paths.filter(path => ["joint", RESULT.paths.some(p => p.path === "reference" && p.shares.some(s => s.standard_deviation)) ? "reference" : "reference_projected"].includes(path.path));

function tornado(parameter, i) {
  const rows = RANKED.map(([source]) => ({ source, effects: TORNADO_PATHS.map(path => effect(path, source, i)) })).filter(row => row.effects.some(e => e));
  const size = row => Math.max(...row.effects.filter(e => e).map(e => Math.hypot(e.sigma, e.bias)));
  const largest = rows.sort((a, b) => size(b) - size(a)).slice(0, 7).filter(row => size(row) > 0);
  if (!largest.length) return [];
  const width = 380, name = 132, row = 32, top = 4, bottom = top + row * largest.length, end = 1.05 * Math.max(...largest.flatMap(r => r.effects.filter(e => e).map(e => Math.max(e.sigma, Math.abs(e.bias)))));
  const at = v => name + 10 + (v + end) / (2 * end) * (width - name - 22), marks = ticks(-end, end, 4);
  const grid = marks.flatMap(v => [svg("line", { x1: at(v), x2: at(v), y1: top, y2: bottom, stroke: Math.abs(v) < 1e-12 ? "var(--soft)" : INK.line }),
    text(at(v), bottom + 15, tickLabel(v, roundUp(2 * end / 4)), { "text-anchor": "middle", class: "soft" })]);
  const bars = largest.flatMap((r, k) => [label(titleOf(r.source), name, top + (k + 0.5) * row + 4), ...r.effects.flatMap((e, p) => {
    if (!e) return [];
    const y = top + k * row + 4 + p * 12, colour = BUDGET_PATHS[TORNADO_PATHS[p].path].colour, x = at(e.bias);
    return [svg("rect", { x: at(-e.sigma), y, width: Math.max(0.6, at(e.sigma) - at(-e.sigma)), height: 10, fill: colour, "fill-opacity": 0.75 },
      svg("title", {}, `${titleOf(r.source)}: sigma ${short(e.sigma)} ${parameter.unit}, bias ${short(e.bias)} ${parameter.unit}, ${e.origin.replace("_", " ")}`)),
      Math.abs(e.bias) > 0.01 * end ? svg("path", { d: `M${x} ${y} l4 5 l-4 5 l-4 -5 Z`, fill: "var(--ink)", stroke: "var(--paper)", "stroke-width": 0.7 }) : []];
  })]);
  return [el("figure", {}, el("h3", {}, parameter.name, el("small", {}, `  one sigma, ${parameter.unit}`)), picture(width, bottom + 20, `effects on ${parameter.name}`, grid, bars))];
}

/** A name to the left of a bar, in two lines where it is long. */
function label(words, right, y) {
  const max = 21;
  if (words.length <= max) return text(right, y, words, { "text-anchor": "end", style: "font-size:11px" });
  const space = words.lastIndexOf(" ", max), cut = space > 0 ? space : max, rest = words.slice(cut).trim();
  return [text(right, y - 6, words.slice(0, cut), { "text-anchor": "end", style: "font-size:11px" }), text(right, y + 6, rest.length > max + 2 ? `${rest.slice(0, max)}\u2026` : rest, { "text-anchor": "end", style: "font-size:11px" })];
}

function buildTornado() {
  const figures = SOUGHT.flatMap(tornado);
  if (!figures.length) return;
  add("tornado", "Largest effects on each parameter", keys([...TORNADO_PATHS.map(path => ({ name: pathName(path), colour: BUDGET_PATHS[path.path].colour })), { name: "bias", colour: "var(--ink)", diamond: true }]),
    el("div", { class: "grid3" }, figures), note("Each source acting alone: one standard deviation to both sides, and the mean error that it adds. Simulated where it was simulated, analytic otherwise."));
}
