// The page from top to bottom.

function pathChip(path) {
  const good = path.solution.status === "converged";
  return chip(`${path.name}: ${statusWords(path.solution)}`, !path.solution.usable ? "bad" : good ? "good" : "warn");
}

function testChip() {
  const joint = RESULT.solutions.joint, test = joint && joint.usable && joint.quality && joint.quality.global_test;
  return test ? [chip(`Global test: ${testVerdict(test)}`, test.void_because ? "" : test.passed ? "good" : "warn")] : [];
}

function buildHead() {
  section("version").textContent = RESULT.software.version;
  section("title").textContent = DATA.title;
  section("headline").textContent = DATA.headline;
  if (!RESULT.usable) section("headline").classList.add("refused");
  section("chips").append(...PATHS.map(pathChip), ...testChip());
  section("footer").textContent = `${RESULT.software.name} ${RESULT.software.version}, seed ${RESULT.seed}. The numbers of this page, in full precision, are in result.json and parameters.csv beside it.`;
}

buildHead();
buildCard();
buildVerdict();
OWN.forEach(build => build());
[buildSolution, buildCorrections, buildDetermined, buildConvergence, buildQuality, buildConventions, buildCounts, buildConfiguration, buildContents].forEach(build => build());

document.documentElement.dataset.ready = "yes";
