// "Enter these values": the numbers that go into another program, with a choice of that program's own sense.

function copyButton(content) {
  const button = el("button", { type: "button", class: "copy screen", title: `copy ${content}` }, "copy");
  button.addEventListener("click", () => {
    if (navigator.clipboard) navigator.clipboard.writeText(content).then(() => { button.textContent = "copied"; });
  });
  return button;
}

function ownTable(card) {
  return table(["", number("before"), number("after"), "", number("sigma"), "positive"], card.rows.map(row => [
    el("b", {}, row.unit ? `${row.name}, ${row.unit}` : row.name), number(row.before), el("b", { class: "value" }, row.after), copyButton(row.after), number(row.sigma || "-"), row.positive]));
}

function conventionTable(entry) {
  const row = (field, places, unit) => [el("b", {}, `${field.name}, ${unit}`), el("b", { class: "value" }, missing(field.value) ? "left out" : digits(field.value, places)), missing(field.value) ? "" : copyButton(digits(field.value, places)), field.positive];
  return [table(["", "enter", "", "positive"], [...entry.angles_deg.map(field => row(field, 4, "deg")), ...entry.lever_arm_m.map(field => row(field, 4, "m"))]),
    note(`${entry.axes}. ${entry.remark}`)];
}

function buildCard() {
  const card = DATA.card;
  if (!card) return;
  const place = el("div", {}), path = PATHS.find(p => p.key === card.solution);
  const choices = [["boresight's survey file", () => ownTable(card)], ...RESULT.conventions.map(entry => [entry.software, () => conventionTable(entry)])];
  const choose = el("select", { "aria-label": "program" }, choices.map(([name], i) => el("option", { value: i }, name)));
  const show = () => place.replaceChildren(...[choices[choose.value][1]()].flat(Infinity));
  choose.value = "0";
  choose.addEventListener("change", show);
  add("enter", "Enter these values", choices.length > 1 ? el("p", { class: "screen" }, "In the sense of ", choose) : [], place,
    note(`${path ? path.name : card.solution} solution. Body axes: x right, y forward, z up; R = Rz(-heading) Rx(pitch) Ry(roll).`));
  show();
}
