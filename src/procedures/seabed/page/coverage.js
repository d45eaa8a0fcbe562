// How densely the lines cover the seabed, and how many lie over one another.

/** A map of cells east and north: of each its middle and a part from 0 to 1. */
function cellMap(label, cells, part) {
  const ends = k => cells.reduce(([low, high], cell) => [Math.min(low, cell.at_m[k]), Math.max(high, cell.at_m[k])], [Infinity, -Infinity]);
  const [east, north] = [ends(0), ends(1)], side = VIEWS.cell_m, size = Math.min(Math.min(540, ROOM - 6) / (east[1] - east[0] + side), 420 / (north[1] - north[0] + side));
  const width = Math.round((east[1] - east[0] + side) * size), height = Math.round((north[1] - north[0] + side) * size);
  const canvas = el("canvas", { width: 2 * width, height: 2 * height, style: `width:${width}px`, role: "img", "aria-label": label }), pen = canvas.getContext("2d"), edge = 2 * size * side;
  for (const cell of cells) {
    pen.fillStyle = css(shade(part(cell)));
    pen.fillRect(2 * size * (cell.at_m[0] - east[0]), 2 * size * (north[1] - cell.at_m[1]), edge + 0.5, edge + 0.5);
  }
  return el("div", { class: "map" }, el("h3", {}, label), el("figure", {}, canvas, ruler(width, size, east[0] - side / 2, "m east")));
}

function buildCoverage() {
  const cells = VIEWS.coverage || [];
  if (!cells.length) return;
  const sorted = cells.map(cell => cell.per_m2).sort((a, b) => a - b), end = roundUp(sorted[Math.floor(0.98 * (sorted.length - 1))] || 1, [1, 1.5, 2, 3, 4, 5, 6, 8, 10]);
  const most = Math.max(...cells.map(cell => cell.lines)), both = cells.filter(cell => cell.lines > 1).length;
  const levels = Array.from({ length: most }, (_, k) => ({ name: `${k + 1} line${k ? "s" : ""}`, colour: css(shade((k + 1) / most)) }));
  add("coverage", "Coverage of the seabed", el("div", { class: "row2" },
    el("div", {}, densityLegend(end, "soundings per m\u00b2"), cellMap("Density", cells, cell => cell.per_m2 / end)),
    el("div", {}, keys(levels), cellMap("Lines over one another", cells, cell => cell.lines / most))),
  note(`Seen from above, north up; cells of ${digits(VIEWS.cell_m, 1)} m. ${percent(both / cells.length)} of the covered ground is seen by two lines or more: only there the lines can be compared.`));
}
