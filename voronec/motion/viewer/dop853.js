// The method of Dormand and Prince of order 8, with Hairer's estimate of its error from two others,
// of orders 5 and 3 (Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, II.10).
"use strict";

const A = [
  [],
  [0.05260015195876773],
  [0.0197250569845379, 0.0591751709536137],
  [0.02958758547680685, 0.0, 0.08876275643042054],
  [0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792],
  [0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242],
  [0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125],
  [0.03709200011850479, 0.0, 0.0, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402, 0.008273789163814023],
  [0.6241109587160757, 0.0, 0.0, -3.3608926294469414, -0.868219346841726, 27.59209969944671, 20.154067550477894, -43.48988418106996],
  [0.47766253643826434, 0.0, 0.0, -2.4881146199716677, -0.590290826836843, 21.230051448181193, 15.279233632882423, -33.28821096898486, -0.020331201708508627],
  [-0.9371424300859873, 0.0, 0.0, 5.186372428844064, 1.0914373489967295, -8.149787010746927, -18.52006565999696, 22.739487099350505, 2.4936055526796523, -3.0467644718982196],
  [2.273310147516538, 0.0, 0.0, -10.53449546673725, -2.0008720582248625, -17.9589318631188, 27.94888452941996, -2.8589982771350235, -8.87285693353063, 12.360567175794303, 0.6433927460157636],
];
const B = [0.054293734116568765, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003, -5.801203960010585, 0.3111643669578199, -0.1521609496625161, 0.20136540080403034, 0.04471061572777259];
const C = [0.0, 0.05260015195876773, 0.0789002279381516, 0.1183503419072274, 0.2816496580927726, 0.3333333333333333, 0.25, 0.3076923076923077, 0.6512820512820513, 0.6, 0.8571428571428571, 1.0];
const E3 = [-0.18980075407240762, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003, -5.801203960010585, -0.4226823213237919, -0.1521609496625161, 0.20136540080403034, 0.02265179219836082, 0.0];
const E5 = [0.01312004499419488, 0.0, 0.0, 0.0, 0.0, -1.2251564463762044, -0.4957589496572502, 1.6643771824549864, -0.35032884874997366, 0.3341791187130175, 0.08192320648511571, -0.022355307863886294, 0.0];
// The states at `times`, of y' = rhs(t, y, parameters) that is `start` at the first of them: an
// array of arrays, shorter than `times` where the motion cannot go on, with `why`.
function integrate(rhs, times, start, parameters, tolerance = 1e-13, most = 200000) {
  const n = start.length, slopes = Array.from({ length: 12 }, () => new Array(n));
  const direction = times[times.length - 1] < times[0] ? -1 : 1;
  const states = [Array.from(start)], found = { states, steps: 0, evaluations: 1, why: "" };
  let t = times[0], y = Array.from(start), first = rhs(t, y, parameters);
  if (!first.every(Number.isFinite)) { found.why = "the rates are not finite at the start"; return found; }
  let size = firstStep(rhs, t, y, first, parameters, tolerance, direction);
  const middle = new Array(n);
  for (let k = 1; k < times.length; k++) {
    while ((times[k] - t) * direction > 0) {
      if (found.steps >= most) { found.why = `more than ${most} steps, at t = ${t.toPrecision(6)}`; return found; }
      const left = Math.abs(times[k] - t), last = size >= left * (1 - 1e-12);
      const h = direction * (last ? left : size);
      slopes[0] = first;
      for (let s = 1; s < 12; s++) {
        for (let i = 0; i < n; i++) {
          let sum = 0;
          for (let j = 0; j < s; j++) if (A[s][j] !== 0) sum += A[s][j] * slopes[j][i];
          middle[i] = y[i] + h * sum;
        }
        slopes[s] = rhs(t + C[s] * h, middle, parameters);
      }
      const next = y.map((x, i) => x + h * B.reduce((sum, b, j) => sum + b * slopes[j][i], 0));
      const error = estimate(slopes, y, next, h, tolerance);
      found.evaluations += 12;
      found.steps += 1;
      if (error <= 1) {
        t = last ? times[k] : t + h;
        y = next;
        first = rhs(t, y, parameters);
        const larger = Math.min(10, 0.9 * Math.pow(Math.max(error, 1e-14), -1 / 8));
        size = last ? Math.max(size, Math.abs(h) * larger) : Math.abs(h) * larger;
      } else {
        size = Math.abs(h) * (Number.isFinite(error) ? Math.max(0.2, 0.9 * Math.pow(error, -1 / 8)) : 0.2);
      }
      if (size < 1e-14 * Math.max(1, Math.abs(t))) {
        found.why = `no step is small enough at t = ${t.toPrecision(6)}`;
        return found;
      }
    }
    states.push(y);
  }
  return found;
}

// The error of a step by the tolerance: one is as much as is allowed; NaN where there is no value.
function estimate(slopes, y, next, h, tolerance) {
  let five = 0, three = 0;
  for (let i = 0; i < y.length; i++) {
    const scale = tolerance * (1 + Math.max(Math.abs(y[i]), Math.abs(next[i])));
    let a = 0, b = 0;
    for (let j = 0; j < 12; j++) { a += E5[j] * slopes[j][i]; b += E3[j] * slopes[j][i]; }
    five += (a / scale) ** 2;
    three += (b / scale) ** 2;
  }
  if (five === 0 && three === 0) return 0;
  return (Math.abs(h) * five) / Math.sqrt((five + 0.01 * three) * y.length);
}

// Hairer's first step, from the rates and how they change.
function firstStep(rhs, t, y, first, parameters, tolerance, direction) {
  const norm = (x) => Math.sqrt(x.reduce((sum, v, i) => sum + (v / (tolerance * (1 + Math.abs(y[i])))) ** 2, 0) / y.length);
  const size = norm(y), rate = norm(first);
  const small = size < 1e-5 || rate < 1e-5 ? 1e-6 : (0.01 * size) / rate;
  const moved = y.map((x, i) => x + direction * small * first[i]);
  const bend = norm(rhs(t + direction * small, moved, parameters).map((x, i) => x - first[i])) / small;
  const most = Math.max(rate, bend);
  return Math.min(100 * small, most <= 1e-15 ? Math.max(1e-6, small * 1e-3) : Math.pow(0.01 / most, 1 / 8));
}
