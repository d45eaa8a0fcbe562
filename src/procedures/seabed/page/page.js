// A seabed calibration's own sections.

/** A list of equal objects as a table. */
function listed(list) {
  if (!list || !list.length) return null;
  const heads = Object.keys(list[0]), cell = value => typeof value === "number" ? String(+value.toPrecision(5)) : Array.isArray(value) ? value.join(", ") : String(value);
  return el("table", {}, el("tr", {}, heads.map(head => el("th", {}, head.replaceAll("_", " ")))), list.map(row => el("tr", {}, heads.map(head => el("td", {}, cell(row[head]))))));
}

function buildSeabed() {
  const details = DATA.page, joint = details.joint, patch = details.patch_test;
  add("lines", "Lines and pairs of lines", listed(details.layout.tracks), listed(details.layout.pairs));
  if (joint) add("information", "Where the information comes from", listed(joint.sigmas), note("Standard deviations of the model, of the tiles' scatter, from the relief alone and from the boat's motion alone; angles in radians. What comes from motion alone is as true as the heave channel."));
  if (joint) add("passes", "Passes of the joint adjustment", listed(joint.passes));
  if (patch) add("patch", "Steps of the patch test", listed(patch), note("Each parameter where the surfaces of its two lines differ least, the others held; changes in radians or seconds."));
}

OWN.push(buildSeabed);
