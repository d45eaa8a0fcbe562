// "Enter these values": the numbers that go into another program, with a choice of that program's own sense.

function copyButton(content) {
  const button = el("button", { type: "button", class: "copy screen", title: `copy ${content}` }, "copy");
  button.addEventListener("click", () => {
    if (navigator.clipboard) navigator.clipboard.writeText(content).then(() => { button.textContent = "copied"; });
  });
  return button;
}

/** A name with its positive sense below it, where no column has room for it. */
function named(words, positive) { return [el("b", {}, words), positive ? el("small", { class: "narrow" }, positive) : ""]; }

function entered(value) { return el("span", { class: "entered" }, el("b", { class: "value" }, value), copyButton(value)); }

function wide(words) { return el("span", { class: "wide" }, words); }

function ownTable(card) {
  return table(["", number("before"), "after", number("sigma"), wide("positive")], card.rows.map(row => [
    el("span", {}, named(row.unit ? `${row.name}, ${row.unit}` : row.name, row.positive)), number(row.before), entered(row.after), number(row.sigma || "-"), wide(row.positive)]));
}

function conventionTable(entry) {
  const value = (field, places) => missing(field.value) ? el("b", { class: "value" }, "left out") : entered(digits(field.value, places));
  const row = (field, places, unit) => [el("span", {}, named(`${field.name}, ${unit}`, field.positive)), value(field, places), wide(field.positive)];
  return [table(["", "enter", wide("positive")], [...entry.angles_deg.map(field => row(field, 4, "deg")), ...entry.lever_arm_m.map(field => row(field, 4, "m"))]),
    note(`${entry.axes}. ${entry.remark}`)];
}

function buildCard() {
  const card = DATA.card;
  if (!card) return;
  const place = el("div", {}), path = PATHS.find(p => p.key === card.solution);
  const choices = [["boresight's survey file", () => ownTable(card)], ...RESULT.conventions.map(entry => [programName(entry), () => conventionTable(entry)])];
  const choose = el("select", { "aria-label": "program" }, choices.map(([name], i) => el("option", { value: i }, name)));
  const show = () => place.replaceChildren(...[choices[choose.value][1]()].flat(Infinity));
  choose.value = "0";
  choose.addEventListener("change", show);
  add("enter", "Enter these values", choices.length > 1 ? el("p", { class: "screen" }, "With the signs of ", choose) : [], place,
    note(`${path ? path.name : card.solution} solution. Body axes: x right, y forward, z up; R = Rz(-heading) Rx(pitch) Ry(roll).`));
  show();
}
