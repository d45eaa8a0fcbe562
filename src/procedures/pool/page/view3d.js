// Target and soundings in a view that turns: raw WebGL2, with a still picture where there is none and on paper.

const STATES = [
  { key: "nominal", name: "Before", position: SOUNDINGS.nominal, value: SOUNDINGS.nominalResidual },
  ...PATHS.map(path => ({ key: path.key, name: `After ${path.name.toLowerCase()}${path.solution.usable ? "" : " (not usable)"}`, position: SOUNDINGS.position[path.key],
    value: SOUNDINGS.residual[path.key] })),
].filter(state => state.position);

const POINT_VERTEX = `#version 300 es
in vec3 a_from; in vec3 a_to; in float a_from_value; in float a_to_value; in float a_used;
uniform mat4 u_view; uniform float u_part, u_scale, u_size; uniform bool u_by_residual, u_rejected; uniform vec3 u_colour;
out vec3 v_colour;
const vec3 S[5] = vec3[5](vec3(.13,.40,.67), vec3(.40,.66,.81), vec3(.87,.87,.85), vec3(.94,.54,.38), vec3(.80,.12,.19));
vec3 diverging(float t) { float x = 2.0 * (clamp(t, -1.0, 1.0) + 1.0); int low = min(3, int(x)); return mix(S[low], S[low + 1], x - float(low)); }
void main() {
  gl_Position = u_view * vec4(mix(a_from, a_to, u_part), 1.0);
  float value = mix(a_from_value, a_to_value, u_part);
  bool known = a_from_value < 1e8 && a_to_value < 1e8;
  v_colour = a_used < 0.5 ? vec3(.45) : !u_by_residual ? u_colour : known ? diverging(value / u_scale) : vec3(.55);
  gl_PointSize = a_used < 0.5 ? (u_rejected ? u_size * 0.8 : 0.0) : u_size;
  if (a_used < 0.5 && !u_rejected) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}`;
const POINT_FRAGMENT = `#version 300 es
precision mediump float; in vec3 v_colour; out vec4 colour;
void main() { vec2 d = gl_PointCoord - 0.5; if (dot(d, d) > 0.25) discard; colour = vec4(v_colour, 1.0); }`;
const PLAIN_VERTEX = `#version 300 es
in vec3 a_position; uniform mat4 u_view; void main() { gl_Position = u_view * vec4(a_position, 1.0); }`;
const PLAIN_FRAGMENT = `#version 300 es
precision mediump float; uniform vec4 u_colour; out vec4 colour; void main() { colour = vec4(u_colour.rgb * u_colour.a, u_colour.a); }`;

// CAMERA

const EXTENT = (() => {
  const corners = SAMPLES.faces.flatMap(face => face.vertices_m);
  const points = corners.length ? corners : SAMPLES.trajectory_m.flat();
  const low = [0, 1, 2].map(i => Math.min(...points.map(p => p[i]), Infinity)), high = [0, 1, 2].map(i => Math.max(...points.map(p => p[i]), -Infinity));
  const known = points.length > 0;
  const centre = known ? low.map((l, i) => (l + high[i]) / 2) : [0, 0, 0];
  return { low, high, centre, radius: known ? Math.max(1, Math.hypot(...low.map((l, i) => (high[i] - l) / 2))) : 5 };
})();

const VIEWS = {
  "Oblique": { azimuth: 0.5, elevation: 0.33, distance: 1.75 },
  "From the boat": { azimuth: 0, elevation: 0.02, distance: 1.7 },
  "From above": { azimuth: 0, elevation: 1.55, distance: 2.2 },
  "Along the wall": { azimuth: Math.PI / 2, elevation: 0.12, distance: 2.2 },
};

function startCamera() { return { ...VIEWS["Oblique"], shift: [0, 0, 0] }; }

function cross(a, b) { return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]; }
function dot(a, b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
function unit(a) { const size = Math.hypot(...a) || 1; return a.map(x => x / size); }

/** Eye, axes of the picture (right, up, towards the eye) of a camera. */
function axes(camera) {
  const c = Math.cos(camera.elevation), back = [-c * Math.cos(camera.azimuth), -c * Math.sin(camera.azimuth), Math.sin(camera.elevation)];
  const right = [Math.sin(camera.azimuth), -Math.cos(camera.azimuth), 0], up = cross(back, right);
  const target = EXTENT.centre.map((x, i) => x + camera.shift[i]);
  return { right, up, back, eye: target.map((x, i) => x + camera.distance * EXTENT.radius * back[i]) };
}

/** Column-major projection times view. */
function viewMatrix(camera, aspect) {
  const { right, up, back, eye } = axes(camera), f = 1 / Math.tan(0.42), near = 0.05 * EXTENT.radius, far = 30 * EXTENT.radius;
  const rows = [[...right, -dot(right, eye)], [...up, -dot(up, eye)], [...back, -dot(back, eye)]];
  const fit = Math.min(1, aspect / 1.7);
  const depth = [(far + near) / (near - far), 2 * far * near / (near - far)];
  const m = new Float32Array(16);
  for (let c = 0; c < 4; c++) {
    m[4 * c] = fit * f / aspect * rows[0][c];
    m[4 * c + 1] = fit * f * rows[1][c];
    m[4 * c + 2] = depth[0] * rows[2][c] + (c === 3 ? depth[1] : 0);
    m[4 * c + 3] = -rows[2][c];
  }
  return m;
}

// SHAPES

function fan(polygon) {
  return polygon.slice(2).flatMap((corner, i) => [polygon[0], polygon[i + 1], corner]).flat();
}

function outline(polygon) {
  return polygon.flatMap((corner, i) => [corner, polygon[(i + 1) % polygon.length]]).flat();
}

function waterPolygon() {
  const z = SAMPLES.water_level_m, path = SAMPLES.trajectory_m.flat(), { low, high } = EXTENT;
  if (missing(z) || !SAMPLES.faces.length) return [];
  const near = Math.min(low[0], ...path.map(p => p[0])) - 1;
  return [[near, low[1] - 1, z], [high[0], low[1] - 1, z], [high[0], high[1] + 1, z], [near, high[1] + 1, z]];
}

function known(values, count) {
  const list = new Float32Array(count).fill(1e9);
  if (values) values.forEach((value, i) => { if (!Number.isNaN(value)) list[i] = value; });
  return list;
}

// WEBGL

function program(gl, vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  return made;
}

function buffer(gl, values) {
  const made = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, made);
  gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
  return made;
}

function attribute(gl, of, name, values, size) {
  const place = gl.getAttribLocation(of, name);
  gl.bindBuffer(gl.ARRAY_BUFFER, values);
  gl.enableVertexAttribArray(place);
  gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
}

class Scene {
  constructor(canvas, gl) {
    Object.assign(this, { canvas, gl, camera: startCamera(), from: 0, to: 0, part: 1, byResidual: true });
    this.show = { soundings: true, returns: true, faces: true, trajectory: true, rejected: false };
    this.points = program(gl, POINT_VERTEX, POINT_FRAGMENT);
    this.plain = program(gl, PLAIN_VERTEX, PLAIN_FRAGMENT);
    this.states = STATES.map(state => ({ position: buffer(gl, state.position), value: buffer(gl, known(state.value, SOUNDINGS.count)) }));
    this.used = buffer(gl, SOUNDINGS.used);
    this.laser = { position: buffer(gl, RETURNS.position), value: buffer(gl, known(RETURNS.residual, RETURNS.count)), used: buffer(gl, RETURNS.used) };
    this.shapes = this.makeShapes();
    this.pending = false;
  }

  makeShapes() {
    const shape = (flat, colour, kind, part) => ({ buffer: buffer(this.gl, new Float32Array(flat)), count: flat.length / 3, colour, kind, part });
    const polygons = SAMPLES.faces.map(face => face.vertices_m), water = waterPolygon(), gl = this.gl;
    const paths = SAMPLES.trajectory_m.filter(path => path.length > 1).map(path => shape(path.flat(), [1, 0.82, 0.35, 0.9], gl.LINE_STRIP, "trajectory"));
    return [...paths, shape(polygons.flatMap(outline), [0.75, 0.85, 0.92, 0.75], gl.LINES, "faces"),
      shape(polygons.flatMap(fan), [0.6, 0.75, 0.85, 0.09], gl.TRIANGLES, "faces"),
      shape(fan(water), [0.25, 0.6, 0.85, 0.16], gl.TRIANGLES, "faces")].filter(made => made.count);
  }

  draw() {
    this.pending = false;
    const { gl, canvas } = this, ratio = Math.min(2, window.devicePixelRatio || 1);
    canvas.width = Math.round(canvas.clientWidth * ratio);
    canvas.height = Math.round(canvas.clientHeight * ratio);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0.063, 0.114, 0.149, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    const view = viewMatrix(this.camera, canvas.width / Math.max(1, canvas.height));
    if (this.show.soundings) this.drawSoundings(view, ratio);
    if (this.show.returns) this.drawReturns(view, ratio);
    this.drawShapes(view);
  }

  drawSoundings(view, ratio) {
    const a = this.states[this.from], b = this.states[this.to];
    this.drawPoints(view, { from: a.position, to: b.position, fromValue: a.value, toValue: b.value, used: this.used, colour: [1, 0.55, 0.3],
      size: 3 * ratio, count: SOUNDINGS.count });
  }

  drawReturns(view, ratio) {
    const { position, value, used } = this.laser;
    this.drawPoints(view, { from: position, to: position, fromValue: value, toValue: value, used, colour: [0.35, 0.85, 0.65], size: 2.4 * ratio,
      count: RETURNS.count });
  }

  drawPoints(view, set) {
    const { gl, points } = this, uniform = name => gl.getUniformLocation(points, name);
    gl.useProgram(points);
    gl.disable(gl.BLEND);
    gl.uniformMatrix4fv(uniform("u_view"), false, view);
    gl.uniform1f(uniform("u_part"), this.part);
    gl.uniform1f(uniform("u_scale"), SCALE_M);
    gl.uniform1f(uniform("u_size"), set.size);
    gl.uniform1i(uniform("u_by_residual"), this.byResidual ? 1 : 0);
    gl.uniform1i(uniform("u_rejected"), this.show.rejected ? 1 : 0);
    gl.uniform3fv(uniform("u_colour"), set.colour);
    attribute(gl, points, "a_from", set.from, 3);
    attribute(gl, points, "a_to", set.to, 3);
    attribute(gl, points, "a_from_value", set.fromValue, 1);
    attribute(gl, points, "a_to_value", set.toValue, 1);
    attribute(gl, points, "a_used", set.used, 1);
    gl.drawArrays(gl.POINTS, 0, set.count);
  }

  drawShapes(view) {
    const { gl, plain } = this;
    gl.useProgram(plain);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    gl.uniformMatrix4fv(gl.getUniformLocation(plain, "u_view"), false, view);
    for (const shape of this.shapes.filter(shape => this.show[shape.part])) {
      gl.uniform4fv(gl.getUniformLocation(plain, "u_colour"), shape.colour);
      attribute(gl, plain, "a_position", shape.buffer, 3);
      gl.drawArrays(shape.kind, 0, shape.count);
    }
    gl.depthMask(true);
  }

  redraw() {
    if (!this.pending) { this.pending = true; requestAnimationFrame(() => this.draw()); }
  }

  /** Moves the soundings from where they are to another state within half a second. */
  moveTo(index) {
    this.from = this.to;
    this.to = index;
    const begin = performance.now(), token = this.token = {};
    const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    const step = now => {
      if (token !== this.token) return;
      this.part = still ? 1 : Math.max(0, Math.min(1, (now - begin) / 500));
      this.draw();
      if (this.part < 1) requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  turn(dx, dy) {
    this.camera.azimuth -= dx;
    this.camera.elevation = Math.max(-1.55, Math.min(1.55, this.camera.elevation + dy));
    this.redraw();
  }

  zoom(factor) {
    this.camera.distance = Math.max(0.15, Math.min(8, this.camera.distance * factor));
    this.redraw();
  }

  pan(dx, dy) {
    const { right, up } = axes(this.camera), step = 0.0016 * this.camera.distance * EXTENT.radius;
    this.camera.shift = this.camera.shift.map((s, i) => s + step * (dy * up[i] - dx * right[i]));
    this.redraw();
  }
}

// HANDS

function listen(scene) {
  const { canvas } = scene, fingers = new Map();
  const spread = () => { const [a, b] = [...fingers.values()]; return Math.hypot(a.x - b.x, a.y - b.y); };
  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  canvas.addEventListener("pointermove", event => {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const dx = event.clientX - last.x, dy = event.clientY - last.y, before = fingers.size === 2 ? spread() : 0;
    Object.assign(last, { x: event.clientX, y: event.clientY });
    if (before) { scene.zoom(before / Math.max(1, spread())); scene.pan(dx / 2, dy / 2); }
    else if (event.shiftKey || event.buttons === 2) scene.pan(dx, dy);
    else scene.turn(0.006 * dx, 0.006 * dy);
  });
  for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, event => fingers.delete(event.pointerId));
  canvas.addEventListener("contextmenu", event => event.preventDefault());
  canvas.addEventListener("wheel", event => { event.preventDefault(); scene.zoom(Math.exp(0.0012 * event.deltaY)); }, { passive: false });
  canvas.addEventListener("keydown", event => turnByKey(scene, event));
  new ResizeObserver(() => scene.redraw()).observe(canvas);
}

function turnByKey(scene, event) {
  const turns = { ArrowLeft: [-0.08, 0], ArrowRight: [0.08, 0], ArrowUp: [0, 0.08], ArrowDown: [0, -0.08] };
  if (turns[event.key]) scene.turn(...turns[event.key]);
  else if (event.key === "+" || event.key === "=") scene.zoom(0.9);
  else if (event.key === "-") scene.zoom(1.1);
  else if (event.key === "0") { scene.camera = startCamera(); scene.redraw(); }
  else return;
  event.preventDefault();
}

function choice(names, chosen, act) {
  const buttons = names.map((name, i) => el("button", { type: "button", "aria-pressed": String(i === chosen) }, name));
  buttons.forEach((button, i) => button.addEventListener("click", () => {
    buttons.forEach(other => other.setAttribute("aria-pressed", String(other === button)));
    act(i);
  }));
  return el("span", { class: "group" }, buttons);
}

function tick(scene, part, label) {
  const box = el("input", { type: "checkbox" });
  box.checked = scene.show[part];
  box.addEventListener("change", () => { scene.show[part] = box.checked; scene.redraw(); });
  return el("label", {}, box, ` ${label}`);
}

function controls(scene) {
  const views = el("span", { class: "group" }, Object.entries(VIEWS).map(([name, view]) => {
    const button = el("button", { type: "button" }, name);
    button.addEventListener("click", () => { Object.assign(scene.camera, view, { shift: [0, 0, 0] }); scene.redraw(); });
    return button;
  }));
  const colours = choice(["Colour by residual", "by sensor"], 0, i => { scene.byResidual = i === 0; scene.redraw(); });
  return [
    el("div", { class: "bar screen" }, choice(STATES.map(state => state.name), scene.to, i => scene.moveTo(i)), colours, views),
    el("div", { class: "bar screen" }, tick(scene, "soundings", "soundings"), tick(scene, "returns", "laser returns"), tick(scene, "faces", "target and water"),
      tick(scene, "trajectory", "boat's path"), tick(scene, "rejected", "rejected points (grey)")),
  ];
}

// STILL PICTURE

function projector(width, height) {
  const m = viewMatrix(startCamera(), width / height);
  return (x, y, z) => {
    const w = m[3] * x + m[7] * y + m[11] * z + m[15];
    return [width / 2 * (1 + (m[0] * x + m[4] * y + m[8] * z + m[12]) / w), height / 2 * (1 - (m[1] * x + m[5] * y + m[9] * z + m[13]) / w)];
  };
}

function stillPicture(state) {
  const width = 560, height = 330, project = projector(width, height), path = list => list.map(p => project(...p).map(v => v.toFixed(1)).join(",")).join(" ");
  const faces = SAMPLES.faces.map(face => svg("polygon", { points: path(face.vertices_m), fill: "#dfe8ee", "fill-opacity": 0.35, stroke: "#8fa3b1", "stroke-width": 0.7 }));
  const water = waterPolygon();
  const level = water.length ? [svg("polygon", { points: path(water), fill: "#7fb7dd", "fill-opacity": 0.14 })] : [];
  const boat = SAMPLES.trajectory_m.map(line => svg("polyline", { points: path(line), fill: "none", stroke: "#b58900" }));
  const step = Math.max(1, Math.ceil(SOUNDINGS.count / 2500)), dots = [];
  for (let i = 0; i < SOUNDINGS.count; i += step) {
    if (!SOUNDINGS.used[i] || Number.isNaN(state.position[3 * i])) continue;
    const [x, y] = project(...state.position.subarray(3 * i, 3 * i + 3)), value = state.value ? state.value[i] : NaN;
    dots.push(svg("circle", { cx: x.toFixed(1), cy: y.toFixed(1), r: 1.1, fill: Number.isNaN(value) ? "#888" : css(diverging(value / SCALE_M)) }));
  }
  return el("figure", {}, picture(width, height, `target and soundings, ${state.name}`, level, faces, boat, dots), el("figcaption", {}, el("b", {}, state.name)));
}

function stills(kind) {
  const last = STATES.findIndex(state => state.key === "joint");
  const shown = [STATES[0], STATES[last > 0 ? last : STATES.length - 1]].filter((state, i, all) => all.indexOf(state) === i);
  return el("div", { class: `still ${kind}` }, shown.map(stillPicture));
}

function buildScene() {
  if (!SAMPLES.faces.length && !SOUNDINGS.count) return;
  const home = add("scene", "Target and soundings, before and after");
  const canvas = el("canvas", { tabindex: 0, role: "img", "aria-label": "Target and soundings in three dimensions. Arrow keys turn, plus and minus zoom, 0 resets." });
  const gl = canvas.getContext("webgl2", { antialias: true });
  if (!gl) {
    home.append(el("p", { class: "notice screen" }, "This browser offers no WebGL 2, so the view cannot be turned; two still pictures stand in for it."), stills(""), residualLegend());
    return;
  }
  const scene = new Scene(canvas, gl), last = STATES.findIndex(state => state.key === "joint");
  scene.from = scene.to = last > 0 ? last : STATES.length - 1;
  home.append(...controls(scene), el("div", { class: "stage screen" }, canvas), stills("print"), residualLegend(),
    el("p", { class: "note screen" }, "Drag to turn, shift-drag to move, wheel or two fingers to zoom; with the keyboard: arrows, + and -, 0 to reset. ",
      `${grouped(SOUNDINGS.count)} soundings and ${grouped(RETURNS.count)} laser returns of the survey are shown, evenly thinned. Target frame: x through the wall, y along it, z up.`));
  listen(scene);
  scene.redraw();
}
