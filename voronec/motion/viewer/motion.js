// A motion of the page: from DATA, `program` and `integrate` to what is drawn.  Without a document,
// so that Node can run it too.
"use strict";

const POSE = 15;

function numbers(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Float64Array(bytes.buffer);
}

// The motion with these values of parameters from this start: times, states, where the shapes are
// and the integrals; `why` says what ended it early.
function motionOf(start, parameters) {
  const times = Array.from(numbers(DATA.times));
  const found = DATA.recorded ? recordedStates(times.length) : integrate(program.rhs, times, start, parameters);
  const count = found.states.length, shapes = DATA.shapes.length;
  const poses = new Float64Array(count * shapes * POSE), rows = [];
  for (let k = 0; k < count; k++) {
    const extras = program.extras(times[k], found.states[k], parameters);
    poses.set(extras.slice(0, shapes * POSE), k * shapes * POSE);
    rows.push(extras.slice(shapes * POSE));
  }
  const quartic = DATA.quartic ? rows.map((row) => row.slice(2 * DATA.integrals.length)) : null;
  return { quartic, times: times.slice(0, count), whole: times.length, states: found.states, poses, shapes, why: found.why,
    steps: found.steps, integrals: DATA.integrals.map((name, i) => changes(name, i, rows)) };
}

function recordedStates(count) {
  const all = numbers(DATA.recorded), width = all.length / count;
  return { states: Array.from({ length: count }, (_, k) => Array.from(all.subarray(k * width, (k + 1) * width))), why: "", steps: 0 };
}

// How an integral changes along the motion, in parts of the largest size of its terms.
function changes(name, place, rows) {
  const first = rows[0][place], terms = rows.map((row) => Math.abs(row[place + DATA.integrals.length]));
  const size = terms.reduce((most, x) => (x > most ? x : most), 0) || Math.abs(first) || 1;
  const along = rows.map((row) => (row[place] - first) / size);
  return { name, value: first, size, along, drift: along.reduce((most, x) => (Math.abs(x) > most ? Math.abs(x) : most), 0) };
}

const LETTERS = { alpha: "α", beta: "β", gamma: "γ", delta: "δ", epsilon: "ε", zeta: "ζ", eta: "η", theta: "θ", iota: "ι", kappa: "κ", lambda: "λ", mu: "μ", nu: "ν", xi: "ξ", pi: "π", rho: "ρ", sigma: "σ", tau: "τ", upsilon: "υ", phi: "φ", chi: "χ", psi: "ψ", omega: "ω", Gamma: "Γ", Delta: "Δ", Theta: "Θ", Lambda: "Λ", Xi: "Ξ", Pi: "Π", Sigma: "Σ", Phi: "Φ", Psi: "Ψ", Omega: "Ω" };

// A name as it is written by hand: theta1 is θ₁, phidot is φ with a dot; words stay as they are.
function letters(name) {
  const [, bare, dots] = /^(.+?)((?:dot)*)$/.exec(name), [, stem, index, digits] = /^([A-Za-z]+?)(_[A-Za-z]+)?_?(\d*)$/.exec(bare) || [null, bare, "", ""];
  const letter = LETTERS[stem] || (stem.length === 1 ? stem : "");
  if (!letter) return name;
  return letter + "\u0307".repeat(dots.length / 3) + (index || "") + [...digits].map((d) => String.fromCharCode(0x2080 + Number(d))).join("");
}

// An address holds the instant, and what differs from the motion of the page: #t=2&m=3.
function addressOf(time, start, parameters) {
  const parts = time === null ? [] : [`t=${time}`];
  for (const [entries, values] of [[DATA.start, start], [DATA.parameters, parameters]]) {
    for (const entry of entries) if (entry.slides && values[entry.place] !== entry.value) parts.push(`${encodeURIComponent(entry.name)}=${values[entry.place]}`);
  }
  return `#${parts.join("&")}`;
}

// What an address says; `wrong` names what the page does not take.
function readAddress(hash) {
  const found = { time: null, start: DATA.start.map((e) => e.value), parameters: DATA.parameters.map((e) => e.value), wrong: "" };
  for (const part of hash.replace(/^#/, "").split("&").filter(Boolean)) {
    const [name, text] = [part.slice(0, part.indexOf("=")), part.slice(part.indexOf("=") + 1)], value = text.trim() ? Number(text) : NaN;
    let own = "";
    try { own = decodeURIComponent(name); } catch { own = name; }
    const [values, entry] = [[found.start, DATA.start], [found.parameters, DATA.parameters]].map(([v, entries]) => [v, entries.find((e) => e.slides && e.name === own)]).find(([, e]) => e) || [null, null];
    if (own === "t" && Number.isFinite(value)) found.time = value;
    else if (entry && Number.isFinite(value) && !(entry.positive && value <= 0)) values[entry.place] = value;
    else found.wrong = found.wrong || part;
  }
  return found;
}

// The quartic with these values at -1, -1/2, 0, 1/2, 1, at x (Lagrange).
function quarticAt(values, x) {
  const places = [-1, -0.5, 0, 0.5, 1];
  return values.reduce((sum, value, i) => sum + places.reduce((part, p, j) => (i === j ? part : (part * (x - p)) / (places[i] - p)), value), 0);
}

// Centre, attitude (rows) and contact of shape `i` at the place `at` between instants: straight lines
// between these, and the attitude made orthogonal again.
function poseAt(motion, i, at) {
  const k = Math.min(Math.floor(at), motion.times.length - 1), next = Math.min(k + 1, motion.times.length - 1);
  const share = at - k, a = (k * motion.shapes + i) * POSE, b = (next * motion.shapes + i) * POSE;
  const pose = new Array(POSE);
  for (let j = 0; j < POSE; j++) pose[j] = motion.poses[a + j] * (1 - share) + motion.poses[b + j] * share;
  const x = [pose[3], pose[6], pose[9]], y = [pose[4], pose[7], pose[10]];
  const unit = (v) => { const n = Math.hypot(...v) || 1; return v.map((c) => c / n); };
  const ex = unit(x), along = ex[0] * y[0] + ex[1] * y[1] + ex[2] * y[2];
  const ey = unit(y.map((c, j) => c - along * ex[j]));
  const ez = [ex[1] * ey[2] - ex[2] * ey[1], ex[2] * ey[0] - ex[0] * ey[2], ex[0] * ey[1] - ex[1] * ey[0]];
  for (let j = 0; j < 3; j++) { pose[3 + 3 * j] = ex[j]; pose[4 + 3 * j] = ey[j]; pose[5 + 3 * j] = ez[j]; }
  return pose;
}
