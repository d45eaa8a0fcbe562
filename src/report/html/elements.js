// Data, elements, numbers and colours that every page shares.

const DATA = JSON.parse(document.getElementById("data").textContent);
const RESULT = DATA.result;

// ELEMENTS

function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value !== null && value !== undefined) node.setAttribute(name, value);
  }
  node.append(...children.flat(Infinity).filter(child => child !== null && child !== undefined));
  return node;
}

function el(tag, attributes, ...children) { return fill(document.createElement(tag), attributes, children); }

function svg(tag, attributes, ...children) {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function picture(width, height, label, ...children) {
  return svg("svg", { viewBox: `0 0 ${width} ${height}`, width, height, role: "img", "aria-label": label }, ...children);
}

function text(x, y, content, attributes) { return svg("text", { x, y, ...attributes }, content); }

function section(id) { return document.getElementById(id); }

function hide(id) { section(id).remove(); }

// NUMBERS

function missing(value) { return value === null || value === undefined || Number.isNaN(value); }

function digits(value, count) { return missing(value) ? "-" : value.toFixed(count).replace(/^-(0(\.0*)?)$/, "$1"); }

/** "0.6003 ± 0.0055": the sigma to two significant digits, the value to the same place. */
function withSigma(value, sigma) {
  if (missing(value)) return "-";
  if (!(sigma > 0)) return String(Number(value.toPrecision(6)));
  const places = Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(sigma))));
  return `${digits(value, places)} \u00b1 ${digits(sigma, places)}`;
}

function plain(value, unit) { return digits(value, unit === "deg" ? 4 : 1); }

function grouped(count) { return String(count).replace(/\B(?=(\d{3})+$)/g, "\u202f"); }

function short(value) { return missing(value) ? "-" : String(Number(value.toPrecision(3))); }

function probability(p) {
  if (missing(p)) return "-";
  if (p < 1e-300) return "below 1e-300";
  return p < 1e-3 ? p.toExponential(0) : p.toFixed(3);
}

function percent(fraction) { return `${short(100 * fraction)} %`; }

/** One of the steps times a power of ten, not below the value. */
function roundUp(value, steps = [1, 2, 5, 10]) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * (steps.find(step => step * power >= value * (1 - 1e-9)) || 10);
}

/** Distance of about `count` round places between two values, of three at least. */
function tickStep(low, high, count) {
  const places = step => Math.floor(high / step + 1e-9) - Math.ceil(low / step - 1e-9) + 1;
  let step = roundUp((high - low) / count);
  while (places(step) < 3) step = roundUp(0.4 * step);
  return step;
}

/** About `count` round places between two values. */
function ticks(low, high, count) {
  const step = tickStep(low, high, count), list = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) list.push(i * step);
  return list;
}

function tickLabel(value, step) { return digits(value, Math.max(0, -Math.floor(Math.log10(step) + 1e-9))); }

/** The label of a power of ten. */
function powerLabel(power) { return power >= -3 && power <= 3 ? String(Number((10 ** power).toPrecision(1))) : `1e${power}`; }

// COLOURS

const INK = { soft: "var(--soft)", line: "var(--line)", mark: "var(--mark)", ink: "var(--ink)", paper: "var(--paper)" };

const STOPS = [[33, 102, 172], [103, 169, 207], [222, 222, 218], [239, 138, 98], [178, 24, 43]];

/** Diverging colour of a value from -1 (blue, behind the face) to 1 (red, in front of it), as three numbers to 255. */
function diverging(value) {
  const place = 2 * (Math.max(-1, Math.min(1, value)) + 1), low = Math.min(3, Math.floor(place)), part = place - low;
  return STOPS[low].map((from, i) => Math.round(from + part * (STOPS[low + 1][i] - from)));
}

function css(colour) { return `rgb(${colour.join(",")})`; }

// TABLES

/** Letters from which on a cell is a sentence, which is not squeezed into a word's width on a phone. */
const SENTENCE = 40;

/** Tables that are too wide for a phone: there a row becomes a block of values, each with its heading above it. */
const WIDE_TABLES = new ResizeObserver(entries => requestAnimationFrame(() => entries.forEach(({ target }) => {
  target.classList.remove("stacked");
  target.classList.toggle("stacked", target.scrollWidth > target.clientWidth + 1 && matchMedia("(max-width: 600px)").matches);
})));

/** A table; a cell that is a string starting with "#" is a number and stands to the right. */
function table(head, rows) {
  const isNumber = content => typeof content === "string" && content.startsWith("#"), bare = content => isNumber(content) ? content.slice(1) : content;
  const cell = (tag, content, label) => el(tag, { class: isNumber(content) ? "n" : typeof content === "string" && content.length > SENTENCE ? "words" : null, "data-label": label || null }, bare(content));
  const labels = head.map(content => typeof content === "string" ? bare(content) : "");
  const home = el("div", { class: "scroll" }, el("table", {}, el("thead", {}, el("tr", {}, head.map(content => cell("th", content)))),
    el("tbody", {}, rows.map(row => el("tr", {}, row.map((content, i) => cell("td", content, labels[i])))))));
  WIDE_TABLES.observe(home);
  return home;
}

function number(value) { return `#${value}`; }

function mono(content) { const node = el("span", {}, content); node.className = "mono"; return node; }
