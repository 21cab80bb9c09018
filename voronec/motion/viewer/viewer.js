// The page: bodies in space, the controls, the curves of the integrals.
"use strict";

const one = (id) => document.getElementById(id);
const INK = 0x1f4e8c, MARK = 0xc2371c;
const COLOURS = { body: [0xe6eef7, 0x9dbbdc], ground: [0xf7f2e8, 0xe9dfcb] };
const now = { parameters: [], start: [], motion: null, at: 0, playing: true, pace: 1, spent: 0, frames: 0, dirty: true };
const tone = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const camera = { turn: 0.9, height: 0.45, far: 5, middle: [0, 0, 0] };
let home = null;
// Whether bodies are of glass, since from everywhere they would hide most of the traces.
let through = false;

function fail(text) {
  one("message").textContent = text;
  one("message").hidden = !text;
}
window.addEventListener("error", (event) => {
  document.documentElement.dataset.error = event.message;
  fail(event.message);
});

// --- shapes -------------------------------------------------------------------------------------

function extent(motion) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  const hold = (x, y, z, r) => [x, y, z].forEach((c, j) => {
    if (c - r < low[j]) low[j] = c - r;
    if (c + r > high[j]) high[j] = c + r;
  });
  DATA.shapes.forEach((shape, i) => {
    if (shape.patches.some((patch) => !patch)) return;
    const size = sizeOf(i);
    for (let k = 0; k < motion.times.length; k++) {
      const p = (k * motion.shapes + i) * POSE;
      hold(motion.poses[p], motion.poses[p + 1], motion.poses[p + 2], size);
    }
  });
  if (low[0] === Infinity) hold(0, 0, 0, 1);
  const sides = low.map((c, j) => high[j] - c);
  return { low, high, size: Math.max(...sides), radius: Math.hypot(...sides) / 2 };
}

function pointsOf(place) {
  return (a, b) => mesh.extras(0, [a, b], now.parameters).slice(3 * place, 3 * place + 3);
}

const first = [];
DATA.shapes.reduce((sum, shape) => (first.push(sum), sum + shape.patches.length), 0);

function sizeOf(i) {
  let most = 0;
  DATA.shapes[i].patches.forEach((ranges, p) => {
    const point = pointsOf(first[i] + p);
    for (let a = 0; a <= 8; a++) for (let b = 0; b <= 8; b++) {
      const at = point(ranges[0][0] + ((ranges[0][1] - ranges[0][0]) * a) / 8, ranges[1][0] + ((ranges[1][1] - ranges[1][0]) * b) / 8);
      most = Math.max(most, Math.hypot(...at));
    }
  });
  return most;
}

// The largest of 1, 2, 5 times a power of ten that is not above `most`.
function roundNumber(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return power * [5, 2, 1].find((digit) => digit * power <= most * (1 + 1e-9));
}

// A patch as triangles, chequered so that one sees it turn.
function patchGeometry(place, ranges, box, colours, turns) {
  const point = pointsOf(place);
  let spans = ranges, cells = [], every = [];
  if (!ranges) {
    const step = roundNumber(box.size / 4);
    const ends = [0, 1].map((j) => [Math.floor(box.low[j] / step) - 1, Math.ceil(box.high[j] / step) + 1]);
    const most = Math.max(...ends.flat().map(Math.abs));
    spans = ends.map((pair) => (turns ? [-most, most] : pair).map((n) => n * step));
    cells = spans.map((s) => 6 * Math.round((s[1] - s[0]) / step));
    every = [3, 3];
  } else {
    cells = ranges.map(([from, to]) => (to - from > 6 ? 48 : to - from > 3 ? 24 : 12));
    every = cells.map((count) => (count === 48 ? 4 : 3));
  }
  const grid = [];
  for (let i = 0; i <= cells[0]; i++) for (let j = 0; j <= cells[1]; j++) {
    grid.push(point(spans[0][0] + ((spans[0][1] - spans[0][0]) * i) / cells[0], spans[1][0] + ((spans[1][1] - spans[1][0]) * j) / cells[1]));
  }
  const smooth = new THREE.BufferGeometry(), index = [], width = cells[1] + 1;
  for (let i = 0; i < cells[0]; i++) for (let j = 0; j < cells[1]; j++) {
    const c = i * width + j;
    index.push(c, c + width, c + 1, c + 1, c + width, c + width + 1);
  }
  smooth.setAttribute("position", new THREE.BufferAttribute(new Float32Array(grid.flat()), 3));
  smooth.setIndex(index);
  smooth.computeVertexNormals();
  const flat = smooth.toNonIndexed(), paint = new Float32Array(index.length * 3);
  const tones = colours.map((c) => new THREE.Color(c));
  for (let i = 0; i < cells[0]; i++) for (let j = 0; j < cells[1]; j++) {
    const tone = tones[(Math.floor(i / every[0]) + Math.floor(j / every[1])) % 2];
    for (let v = 0; v < 6; v++) paint.set([tone.r, tone.g, tone.b], ((i * cells[1] + j) * 6 + v) * 3);
  }
  flat.setAttribute("color", new THREE.BufferAttribute(paint, 3));
  return flat;
}

// A thin tube along points; SEGMENT of its indices belong to each pair of neighbours.
const SIDES = 5, SEGMENT = 6 * SIDES;
function tubeGeometry(points, radius) {
  const count = points.length, where = new Float32Array(count * SIDES * 3), index = [];
  let normal = [0, 0, 1];
  for (let k = 0; k < count; k++) {
    const a = points[Math.max(k - 1, 0)], b = points[Math.min(k + 1, count - 1)];
    const d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]], length = Math.hypot(...d);
    const t = length > 0 ? d.map((c) => c / length) : [1, 0, 0];
    const cross = (p, q) => [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    let side = cross(t, normal), n = Math.hypot(...side);
    if (n < 1e-3) { side = cross(t, Math.abs(t[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]); n = Math.hypot(...side); }
    side = side.map((c) => c / n);
    normal = cross(side, t);
    for (let s = 0; s < SIDES; s++) {
      const c = radius * Math.cos((2 * Math.PI * s) / SIDES), z = radius * Math.sin((2 * Math.PI * s) / SIDES);
      where.set(points[k].map((x, j) => x + c * side[j] + z * normal[j]), (k * SIDES + s) * 3);
      if (k + 1 < count) {
        const p = k * SIDES + s, q = k * SIDES + ((s + 1) % SIDES);
        index.push(p, q, p + SIDES, q, q + SIDES, p + SIDES);
      }
    }
  }
  const tube = new THREE.BufferGeometry();
  tube.setAttribute("position", new THREE.BufferAttribute(where, 3));
  tube.setIndex(index);
  return tube;
}

// --- the scene ----------------------------------------------------------------------------------

const scene = new THREE.Scene(), eye = new THREE.PerspectiveCamera(35, 1, 0.1, 100);
const sun = new THREE.DirectionalLight(0xffffff, 1.5), sky = new THREE.HemisphereLight(0xffffff, 0xb8ae9c, 1.7);
eye.up.set(0, 0, 1);
scene.add(sky, sun);
let renderer = null, drawn = [];

function begin() {
  try {
    renderer = new THREE.WebGLRenderer({ canvas: one("view"), antialias: true });
  } catch (error) {
    document.documentElement.dataset.webgl = "none";
    fail("This browser draws nothing in space (no WebGL); time and integrals are shown all the same.");
    return;
  }
  renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
}

// Light or dark, as the reader's system has it at first.
function theme(dark) {
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  if (renderer) renderer.setClearColor(new THREE.Color(tone("paper")));
  drawCurves();
  now.dirty = true;
}

// The instant at which the first sight is chosen: five units of time after the start, or the last.
function firstInstant(motion) {
  const after = motion.times.findIndex((t) => Math.abs(t - motion.times[0]) > 5 * (1 + 1e-9));
  return after < 0 ? motion.times.length - 1 : after - 1;
}

// Points of the traces up to an instant, as they lie then, on the bodies and in space.
function tracePoints(motion, last) {
  const points = [], step = Math.max(1, Math.floor(last / 120));
  const pose = (k, i) => motion.poses.subarray((k * motion.shapes + i) * POSE, (k * motion.shapes + i + 1) * POSE);
  DATA.shapes.forEach((shape, i) => {
    if (!shape.contact) return;
    const end = pose(last, i);
    for (let k = 0; k <= last; k += step) {
      const c = pose(k, i), own = onBody(c);
      points.push([0, 1, 2].map((j) => end[j] + end[3 + 3 * j] * own[0] + end[4 + 3 * j] * own[1] + end[5 + 3 * j] * own[2]), [c[12], c[13], c[14]]);
    }
  });
  return points;
}

// Where the point of contact lies on the body itself.
function onBody(c) {
  const away = [c[12] - c[0], c[13] - c[1], c[14] - c[2]];
  return [0, 1, 2].map((j) => c[3 + j] * away[0] + c[6 + j] * away[1] + c[9 + j] * away[2]);
}

// How much of the picture's height the points span that are in it, from a place of the eye.
function spanFrom({ turn, height, far, middle }, points) {
  const flat = Math.cos(height), back = [flat * Math.cos(turn), flat * Math.sin(turn), Math.sin(height)];
  const up = [-Math.sin(height) * Math.cos(turn), -Math.sin(height) * Math.sin(turn), flat], right = [-Math.sin(turn), Math.cos(turn), 0];
  const half = Math.tan((eye.fov * Math.PI) / 360);
  let low = 1, high = -1;
  for (const point of points) {
    const d = point.map((c, j) => c - middle[j] - far * back[j]), dot = (v) => v[0] * d[0] + v[1] * d[1] + v[2] * d[2];
    const depth = -dot(back) * half, y = dot(up) / depth;
    if (depth <= 0 || Math.abs(y) > 1 || Math.abs(dot(right) / depth) > SMALL[0] / SMALL[1]) continue;
    low = Math.min(low, y);
    high = Math.max(high, y);
  }
  return (high - low) / 2;
}

// The part of the traces that bodies do not hide from where the eye stands, counted on a small
// picture: all of the traces in red, and what is in front in green.
const SMALL = [240, 160];
function shareSeen() {
  const bytes = new Uint8Array(4 * SMALL[0] * SMALL[1]), gl = renderer.getContext();
  renderer.render(scene, eye);
  gl.readPixels(0, 0, ...SMALL, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  let all = 0, seen = 0;
  for (let k = 0; k < bytes.length; k += 4) if (bytes[k] > 127) { all += 1; if (bytes[k + 1] > 127) seen += 1; }
  return all ? seen / all : 0;
}

// Everything drawn as `shareSeen` counts it; what is given back undoes that.
function inTwoColours() {
  const before = [], plain = { color: 0, side: THREE.DoubleSide }, ADDITIVE = 2;
  const dark = new THREE.MeshLambertMaterial({ ...plain, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
  const [whole, front] = [0xff0000, 0x00ff00].map((emissive) => new THREE.MeshLambertMaterial({ ...plain, emissive, transparent: true, blending: ADDITIVE }));
  whole.depthTest = false;
  drawn.forEach(({ group, beside, traces, spot }) => [...group.children, ...beside].forEach((mesh) => {
    before.push([mesh, mesh.material, mesh.visible]);
    const trace = traces.includes(mesh.geometry);
    mesh.visible = mesh !== spot && (trace || !mesh.material.transparent);
    mesh.material = !trace ? dark : mesh.material.depthTest ? front : whole;
  }));
  const ratio = renderer.getPixelRatio();
  renderer.setPixelRatio(1);
  renderer.setSize(...SMALL, false);
  renderer.setClearColor(new THREE.Color(0));
  return () => {
    before.forEach(([mesh, material, visible]) => Object.assign(mesh, { material, visible }));
    [dark, whole, front].forEach((material) => material.dispose());
    renderer.setPixelRatio(ratio);
    renderer.setClearColor(new THREE.Color(tone("paper")));
    resize();
  };
}

// Places of the eye all about, each as near as the traces need to span a third of the height, and
// moved towards their middle by as much; those from afar come first. None is nearer than 0.3 of the
// distance that shows all of the motion: there one would see traces, and no bodies.
function placesAbout(place, points) {
  const ends = [0, 1, 2].map((j) => points.map((at) => at[j])).map((xs) => (Math.min(...xs) + Math.max(...xs)) / 2);
  const found = [];
  for (const height of [0.45, 0.8, 0.2, 1.2]) for (const k of [0, 4, 2, 6, 1, 5, 3, 7]) {
    const stands = (near) => ({ turn: place.turn + (k * Math.PI) / 4, height, far: near * place.far, middle: one("follow").checked ? place.middle : place.middle.map((c, j) => near * c + (1 - near) * ends[j]) });
    let near = 1;
    while (near > 0.3 && spanFrom(stands(near), points) < 0.36) near *= 0.9;
    found.push({ near: Math.min(near, 0.6), ...stands(near) });
  }
  return found.sort((a, b) => b.near - a.near);
}

// Where the eye stands at first: the first place whose worth is 2, as the traces span a third of the
// height from there and most of them is seen, else the best.
function firstPlace(motion, place, points) {
  const undo = inTwoColours(), at = now.at;
  now.at = firstInstant(motion);
  placeBodies();
  eye.aspect = SMALL[0] / SMALL[1];
  eye.updateProjectionMatrix();
  let best = { ...place, worth: 0 };
  for (const there of placesAbout(place, points)) {
    if (best.worth === 2) break;
    stand(there);
    const worth = Math.min(spanFrom(there, points) / 0.36, 1) + Math.min(shareSeen() / 0.65, 1);
    if (worth > best.worth) best = { ...there, worth };
  }
  now.at = at;
  undo();
  return best;
}

// Whether a body holds what it rolls on within, or is held by it: what is outside is of glass.
function holds(i, motion, sizes) {
  return DATA.shapes.some((other, j) => {
    if (i === j || !sizes[j] || !(sizes[i] > sizes[j])) return false;
    if ((DATA.shapes[i].role === "ground") === (other.role === "ground")) return false;
    const p = i * POSE, q = j * POSE, c = motion.poses;
    return Math.hypot(c[p] - c[q], c[p + 1] - c[q + 1], c[p + 2] - c[q + 2]) < sizes[i];
  });
}

function glaze(mesh) {
  Object.assign(mesh.material, { transparent: true, opacity: 0.3, depthWrite: false, needsUpdate: true });
  mesh.renderOrder = 2;
}

function build(motion) {
  drawn.forEach((thing) => {
    scene.remove(thing.group, ...thing.beside);
    [...thing.group.children, ...thing.beside].forEach((m) => { m.geometry.dispose(); m.material.dispose(); });
  });
  const box = extent(motion);
  const sizes = DATA.shapes.map((shape, i) => (shape.patches.some((p) => !p) ? 0 : sizeOf(i)));
  const largest = Math.max(...sizes.filter((_, i) => DATA.shapes[i].role === "body"));
  const thin = Math.min(box.size / 330, largest / 30);
  eye.near = box.size / 200;
  eye.far = 60 * box.size;
  drawn = DATA.shapes.map((shape, i) => {
    const group = new THREE.Group(), beside = [], traces = [];
    group.matrixAutoUpdate = false;
    const glass = holds(i, motion, sizes) || (through && shape.role === "body"), last = motion.times.length - 1;
    const turns = [3, 4, 5, 6].some((j) => motion.poses[i * POSE + j] !== motion.poses[((last >> 1) * motion.shapes + i) * POSE + j]);
    shape.patches.forEach((ranges, p) => {
      const look = { vertexColors: true, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
      const part = new THREE.Mesh(patchGeometry(first[i] + p, ranges, box, COLOURS[shape.role], turns), new THREE.MeshLambertMaterial(look));
      if (glass) glaze(part);
      group.add(part);
    });
    if (shape.contact) {
      const own = [], space = [];
      for (let k = 0; k < motion.times.length; k++) {
        const c = motion.poses.subarray((k * motion.shapes + i) * POSE, (k * motion.shapes + i + 1) * POSE);
        space.push([c[12], c[13], c[14]]);
        own.push(onBody(c));
      }
      const line = (points, colour) => {
        const made = new THREE.Mesh(tubeGeometry(points, thin), new THREE.MeshLambertMaterial({ color: colour, side: THREE.DoubleSide }));
        const faint = new THREE.Mesh(made.geometry, new THREE.MeshLambertMaterial({ color: colour, side: THREE.DoubleSide, transparent: true, opacity: 0.22, depthTest: false }));
        faint.renderOrder = 5;
        made.frustumCulled = faint.frustumCulled = false;
        traces.push(made.geometry);
        return [made, faint];
      };
      const spot = new THREE.Mesh(new THREE.SphereGeometry(2.6 * thin, 16, 12), new THREE.MeshLambertMaterial({ color: MARK }));
      group.add(...line(own, INK));
      beside.push(spot, ...line(space, MARK));
    }
    scene.add(group, ...beside);
    return { group, beside, traces, spot: beside[0] };
  });
  if (!home) {
    home = { turn: 0.9, height: 0.45, far: ((DATA.shapes.some((shape) => shape.patches.some((p) => !p)) ? 0.95 : 0.75) * box.radius) / Math.sin((eye.fov * Math.PI) / 360), middle: box.low.map((c, j) => (c + box.high[j]) / 2) };
    const bounded = DATA.shapes.some((shape) => shape.role === "ground" && shape.patches.every(Boolean));
    if (12 * largest < box.radius && !bounded) {
      one("follow").checked = true;
      home.far = 14 * largest;
      const last = firstInstant(motion), body = DATA.shapes.findIndex((shape) => shape.role === "body");
      home.middle = [...motion.poses.subarray((last * motion.shapes + body) * POSE, (last * motion.shapes + body) * POSE + 3)];
    }
    const points = tracePoints(motion, firstInstant(motion));
    if (points.length) home = firstPlace(motion, home, points);
    if (home.worth < 1.5 && !through) {
      [home, through] = [null, true];
      build(motion);
      return;
    }
    Object.assign(camera, home);
  }
}

function look() {
  const moving = DATA.shapes.findIndex((shape) => shape.role === "body");
  const middle = one("follow").checked && moving >= 0 ? poseAt(now.motion, moving, now.at).slice(0, 3) : camera.middle;
  stand({ ...camera, middle });
}

function stand({ turn, height, far, middle }) {
  const aside = far * Math.cos(height);
  eye.position.set(middle[0] + aside * Math.cos(turn), middle[1] + aside * Math.sin(turn), middle[2] + far * Math.sin(height));
  eye.lookAt(...middle);
  sun.position.copy(eye.position).add(new THREE.Vector3(-far * Math.sin(turn), far * Math.cos(turn), far));
}

function placeBodies() {
  const k = Math.floor(now.at);
  drawn.forEach((thing, i) => {
    const c = poseAt(now.motion, i, now.at);
    thing.group.matrix.set(c[3], c[4], c[5], c[0], c[6], c[7], c[8], c[1], c[9], c[10], c[11], c[2], 0, 0, 0, 1);
    thing.group.matrixWorldNeedsUpdate = true;
    thing.traces.forEach((trace) => trace.setDrawRange(0, SEGMENT * k));
    if (thing.spot) thing.spot.position.set(c[12], c[13], c[14]);
  });
}

function resize() {
  const stage = one("stage"), wide = stage.clientWidth, high = stage.clientHeight;
  if (renderer) renderer.setSize(wide, high, false);
  eye.aspect = wide / Math.max(high, 1);
  eye.updateProjectionMatrix();
  drawCurves();
  draw(); // at once: what is sized anew is empty
}

// --- curves -------------------------------------------------------------------------------------

let curves = null;
const ROW = 64;

function drawCurves() {
  const canvas = one("curves"), motion = now.motion;
  if (!motion) return;
  const rows = curveRows(), wide = canvas.clientWidth || 800, high = ROW * rows.length, ratio = window.devicePixelRatio || 1;
  canvas.style.height = `${high}px`;
  canvas.width = wide * ratio;
  canvas.height = Math.max(high * ratio, 1);
  curves = document.createElement("canvas");
  curves.width = canvas.width;
  curves.height = canvas.height;
  const pen = curves.getContext("2d");
  pen.scale(ratio, ratio);
  pen.font = "13px system-ui, sans-serif";
  rows.forEach(({ text, along }, i) => {
    const top = ROW * i, middle = top + 40;
    pen.fillStyle = tone("text");
    pen.fillText(text, 4, top + 15);
    pen.strokeStyle = tone("edge");
    pen.strokeRect(0.5, top + 20.5, wide - 1, ROW - 25);
    pen.strokeStyle = tone("line");
    pen.beginPath();
    along.forEach((x, k) => pen.lineTo((wide * k) / Math.max(motion.whole - 1, 1), middle - 17 * x));
    pen.stroke();
  });
}

// What is drawn below one another, each between -1 and 1: what is chosen, and the integrals.
function curveRows() {
  const { integrals, states } = now.motion, place = Number(one("chosen").value);
  const rows = integrals.map((integral) => ({
    text: `${integral.name} = ${integral.value.toPrecision(8)}; ${integral.drift ? `changes by ${integral.drift.toExponential(1)} of ${integral.size.toPrecision(3)}, the size of its terms` : "does not change"}`,
    along: integral.along.map((x) => x / (integral.drift || 1)),
  }));
  if (!(place >= 0)) return rows;
  const values = states.map((state) => state[place]), low = values.reduce((a, b) => Math.min(a, b)), high = values.reduce((a, b) => Math.max(a, b));
  const text = `${letters(DATA.start[place].name)} from ${low.toPrecision(6)} to ${high.toPrecision(6)}`;
  return [{ text, along: values.map((x) => (high > low ? (2 * x - low - high) / (high - low) : 0)) }, ...rows];
}

function drawCursor() {
  const canvas = one("curves"), pen = canvas.getContext("2d");
  const count = curves ? Math.round(canvas.clientHeight / ROW) : 0;
  if (!count || !canvas.height) return;
  pen.clearRect(0, 0, canvas.width, canvas.height);
  pen.drawImage(curves, 0, 0);
  pen.fillStyle = tone("mark");
  const row = canvas.height / count, wide = Math.max(1, canvas.width / 900);
  for (let i = 0; i < count; i++) {
    pen.fillRect((canvas.width * now.at) / Math.max(now.motion.whole - 1, 1), row * (i + 20 / ROW), wide, (row * (ROW - 24)) / ROW);
  }
}

// --- the quartic of a motion by quadratures -----------------------------------------------------

const PLOT = 150;

// f(x) about where the motion runs, with the point (x, f(x)) that moves there and back.
function drawQuartic() {
  const rows = now.motion.quartic, canvas = one("quartic");
  one("quartic-box").hidden = !rows;
  if (!rows) return;
  const wide = canvas.clientWidth || 800, ratio = window.devicePixelRatio || 1, pen = canvas.getContext("2d");
  canvas.style.height = `${PLOT}px`;
  canvas.width = wide * ratio;
  canvas.height = PLOT * ratio;
  pen.scale(ratio, ratio);
  const values = rows[0].slice(1), value = (x) => quarticAt(values, x);
  const xs = rows.map((row) => row[0]), low = Math.min(...xs), high = Math.max(...xs), margin = 0.35 * (high - low) || 0.1;
  const from = low - margin, span = high - low + 2 * margin, top = Math.max(...xs.map(value), 1e-12);
  const across = (x) => (wide * (x - from)) / span, down = (y) => PLOT * 0.72 - (PLOT * 0.45 * y) / top;
  pen.strokeStyle = tone("edge");
  pen.strokeRect(0.5, 0.5, wide - 1, PLOT - 1);
  pen.beginPath();
  pen.moveTo(0, down(0));
  pen.lineTo(wide, down(0));
  pen.stroke();
  const trace = (a, b, colour, width) => {
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.beginPath();
    for (let i = 0; i <= 200; i++) pen.lineTo(across(a + ((b - a) * i) / 200), down(value(a + ((b - a) * i) / 200)));
    pen.stroke();
  };
  trace(from, from + span, "#8fa3b8", 1);
  trace(low, high, tone("line"), 2.5);
  const k = Math.floor(now.at), next = Math.min(k + 1, rows.length - 1), x = xs[k] + (now.at - k) * (xs[next] - xs[k]);
  pen.fillStyle = tone("mark");
  pen.beginPath();
  pen.arc(across(x), down(value(x)), 5, 0, 2 * Math.PI);
  pen.fill();
  pen.fillStyle = tone("text");
  pen.font = "13px system-ui, sans-serif";
  const same = [...now.start, ...now.parameters].every((v, i) => v === [...DATA.start, ...DATA.parameters][i].value);
  const classes = same && DATA.quartic.classes ? `.  ${DATA.quartic.classes}` : "";
  pen.fillText(`the square of the rate of ${DATA.quartic.variable}, a quartic in it, from ${low.toPrecision(4)} to ${high.toPrecision(4)}${classes}`, 6, 16);
}

// --- motion and controls ------------------------------------------------------------------------

function recompute() {
  const motion = motionOf(now.start, now.parameters);
  now.motion = motion;
  document.documentElement.dataset.computed = Number(document.documentElement.dataset.computed || 0) + 1;
  fail(motion.why ? `The motion ends early: ${motion.why}.` : now.wrong ? `The page takes no '${now.wrong}' from its address.` : "");
  one("time").max = motion.times.length - 1;
  now.at = Math.min(now.at, motion.times.length - 1);
  if (renderer) build(motion);
  drawCurves();
  now.dirty = true;
}

let waiting = false;
function changed() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => { waiting = false; now.wrong = ""; recompute(); link(); });
}

function slider(box, entry, values) {
  const label = document.createElement("label"), said = document.createElement("span");
  const range = document.createElement("input"), number = document.createElement("input");
  label.className = "slider";
  const written = letters(entry.name), value = values[entry.place];
  said.textContent = entry.meaning ? `${written}: ${entry.meaning}` : written;
  Object.assign(range, { type: "range", min: Math.min(entry.low, value), max: Math.max(entry.high, value), step: "any", value });
  Object.assign(number, { type: "number", step: "any", value: Number(value.toPrecision(6)) });
  const set = (value, other) => {
    if (!Number.isFinite(value) || (entry.positive && value <= 0)) return;
    values[entry.place] = value;
    other.value = other === number ? Number(value.toPrecision(6)) : value;
    changed();
  };
  range.addEventListener("input", () => set(Number(range.value), number));
  number.addEventListener("input", () => set(Number(number.value), range));
  label.append(said, range, number);
  box.append(label);
}

function controls() {
  one("title").textContent = DATA.title;
  one("caption").textContent = DATA.caption;
  one("source").textContent = DATA.source;
  for (const [name, values] of [["start", now.start], ["parameters", now.parameters]]) {
    const box = one(name);
    box.replaceChildren();
    DATA[name].filter((entry) => entry.slides).forEach((entry) => slider(box, entry, values));
    box.parentElement.hidden = !box.children.length;
  }
  one("restore").hidden = Boolean(DATA.recorded);
  const chosen = one("chosen");
  if (!chosen.options.length) {
    [[-1, "integrals"], ...DATA.start.map((entry, i) => [i, letters(entry.name)])].forEach(([value, text]) => chosen.add(new Option(text, value)));
  }
  chosen.value = -1;
}

// The motion of an address; without one, that of the page.
function restart(hash = "") {
  const found = readAddress(hash);
  now.start = found.start;
  now.parameters = found.parameters;
  now.wrong = found.wrong;
  controls();
  return found.time;
}

// The address that opens the page at this motion, and at this instant where it is asked for.
function link(time = null) {
  try {
    history.replaceState(null, "", addressOf(time, now.start, now.parameters));
  } catch { /* a frame has no address of its own */ }
}

function play(on) {
  now.playing = on;
  if (on && now.at >= now.motion.times.length - 1) now.at = 0;
  one("play").textContent = on ? "Pause" : "Play";
}

function step(count) {
  play(false);
  now.at = Math.max(0, Math.min(now.motion.times.length - 1, Math.round(now.at) + count));
  now.dirty = true;
}

function turn(across, up) {
  camera.turn -= across;
  camera.height = Math.max(-1.5, Math.min(1.5, camera.height + up));
  now.dirty = true;
}

function zoom(factor) {
  camera.far *= factor;
  now.dirty = true;
}

const KEYS = {
  " ": () => play(!now.playing), ArrowLeft: () => step(-1), ArrowRight: () => step(1),
  a: () => turn(-0.1, 0), d: () => turn(0.1, 0), w: () => turn(0, 0.08), s: () => turn(0, -0.08),
  q: () => zoom(0.9), e: () => zoom(1 / 0.9), "+": () => faster(0.1), "-": () => faster(-0.1),
};

function faster(by) {
  one("speed").value = Number(one("speed").value) + by;
  pace();
}

function pace() {
  now.pace = DATA.pace * 10 ** Number(one("speed").value);
  one("pace").textContent = `${Number(now.pace.toPrecision(3))} / s`;
}

function listen() {
  const view = one("view"), fingers = new Map();
  one("play").addEventListener("click", () => play(!now.playing));
  one("restore").addEventListener("click", () => { restart(); recompute(); link(); });
  one("link").addEventListener("click", () => {
    link(Number(timeAt(now.at).toPrecision(6)));
    if (navigator.clipboard) navigator.clipboard.writeText(location.href).catch(() => {});
    one("link").textContent = "Link in the address bar";
    setTimeout(() => { one("link").textContent = "Link"; }, 2500);
  });
  window.addEventListener("hashchange", () => { const time = restart(location.hash); recompute(); arrive(time); });
  one("theme").addEventListener("click", () => theme(document.documentElement.dataset.theme !== "dark"));
  one("chosen").addEventListener("change", () => { drawCurves(); now.dirty = true; });
  one("whole").hidden = !document.fullscreenEnabled;
  one("whole").addEventListener("click", () => (document.fullscreenElement ? document.exitFullscreen() : document.querySelector("main").requestFullscreen()));
  one("home").addEventListener("click", () => { Object.assign(camera, home); now.dirty = true; });
  one("speed").addEventListener("input", pace);
  one("follow").addEventListener("change", () => { now.dirty = true; });
  one("time").addEventListener("input", (event) => { play(false); now.at = Number(event.target.value); now.dirty = true; });
  document.addEventListener("keydown", (event) => {
    const busy = ["INPUT", "BUTTON", "SUMMARY", "SELECT"].includes(event.target.tagName);
    if (busy || event.ctrlKey || event.metaKey || event.altKey || !KEYS[event.key]) return;
    KEYS[event.key]();
    event.preventDefault();
  });
  view.addEventListener("wheel", (event) => { zoom(Math.exp(event.deltaY / 800)); event.preventDefault(); }, { passive: false });
  view.addEventListener("pointerdown", (event) => { fingers.set(event.pointerId, [event.clientX, event.clientY]); view.setPointerCapture(event.pointerId); });
  for (const end of ["pointerup", "pointercancel"]) view.addEventListener(end, (event) => fingers.delete(event.pointerId));
  view.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const at = [event.clientX, event.clientY], other = [...fingers].find(([id]) => id !== event.pointerId);
    if (other) zoom(Math.hypot(before[0] - other[1][0], before[1] - other[1][1]) / Math.max(1, Math.hypot(at[0] - other[1][0], at[1] - other[1][1])));
    else turn((at[0] - before[0]) / 150, (at[1] - before[1]) / 150);
    fingers.set(event.pointerId, at);
  });
  new ResizeObserver(resize).observe(one("stage"));
}

function timeAt(at) {
  const times = now.motion.times, k = Math.floor(at), next = Math.min(k + 1, times.length - 1);
  return times[k] + (at - k) * (times[next] - times[k]);
}

// The place among the instants that lies `span` of time later.
function later(at, span) {
  const times = now.motion.times;
  let k = Math.min(Math.floor(at), times.length - 2), left = span + (at - k) * Math.abs(times[k + 1] - times[k]);
  while (k < times.length - 2 && left > Math.abs(times[k + 1] - times[k])) { left -= Math.abs(times[k + 1] - times[k]); k += 1; }
  return Math.min(k + left / Math.abs(times[k + 1] - times[k]), times.length - 1);
}

// Of an address with t=12.5 the page stands at that instant.
function arrive(wanted) {
  if (wanted === null) return;
  play(false);
  now.at = later(0, Math.abs(wanted - now.motion.times[0]));
  draw();
}

let before = 0;
function frame(stamp) {
  requestAnimationFrame(frame);
  const began = performance.now(), span = Math.min(stamp - before, 100) / 1000;
  before = stamp;
  if (now.playing && now.motion.times.length > 1) {
    now.at = later(now.at, span * now.pace);
    now.dirty = true;
    if (now.at >= now.motion.times.length - 1) play(false);
  }
  if (!now.dirty) return;
  draw();
  now.spent += performance.now() - began;
  document.documentElement.dataset.script = (now.spent / now.frames).toFixed(3);
}

function draw() {
  now.dirty = false;
  one("time").value = now.at;
  one("clock").textContent = `t = ${timeAt(now.at).toFixed(2)}`;
  drawCursor();
  drawQuartic();
  if (renderer) {
    placeBodies();
    look();
    renderer.render(scene, eye);
  }
  now.frames += 1;
  document.documentElement.dataset.drawn = now.frames;
}

const asked = restart(location.hash);
begin();
theme(window.matchMedia("(prefers-color-scheme: dark)").matches);
recompute();
pace();
resize();
listen();
arrive(asked);
requestAnimationFrame(frame);
