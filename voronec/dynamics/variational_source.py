"""C source of DOP853 for a motion together with its variational equations, re-orthogonalised on
the way.

    x' = f(x),   Y' = J(x) Y,   q' = tr J(x)

stand in one array ``z``: the state x (N), q, and Y (N, K) row by row, so that the products of a
row of J run over neighbouring numbers.  Coefficients and the control of the step are those of
``dop853_source``.
"""

from __future__ import annotations

from collections.abc import Sequence

from voronec.motion.steppers import DOP853, FIRST_GROWTH, growth_source

LAST = len(DOP853.weights)
"""The place of the slope at the end of a step."""
ARRIVAL, LIMIT, NO_STEP = range(3)
"""Why ``drive`` came back: the end is reached, so many steps were made, or no step was short
enough."""


def flow_source(right: str, n: int, k: int, places: Sequence[tuple[int, int]]) -> str:
    """The source of ``drive`` for ``right``, C that gives the rates and then the entries of the
    Jacobian that are not zero, which stand at ``places``; n states, k columns of Y."""
    rows = []
    for i in range(n):
        held = [(place, j) for place, (row, j) in enumerate(places) if row == i]
        total = " + ".join(f"r[{n + place}]*y[{j * k} + c]" for place, j in held) or "0.0"
        rows.append(f"    for (int c = 0; c < K; c++) g[{i * k} + c] = {total};")
    trace = " + ".join(f"r[{n + p}]" for p, (i, j) in enumerate(places) if i == j) or "0.0"
    stages = []
    for s in range(1, LAST):
        stages.append(_each(f"z1[i] = z[i] + h*({_sum(DOP853.weights[s])})"))
        stages.append(f"    slope(t + {DOP853.nodes[s]!r}*h, z1, parameters, k[{s}]);")
    pieces = {
        "right": right, "N": str(n), "K": str(k), "entries": str(n + len(places)),
        "trace": trace, "rows": "\n".join(rows), "stages": "\n".join(stages),
        "step": _sum(DOP853.step), "fifth": _sum(DOP853.fifth), "third": _sum(DOP853.third),
        "slopes": str(LAST + 1), "last": str(LAST), "growth": growth_source(),
        "first_growth": repr(FIRST_GROWTH),
        "ARRIVAL": str(ARRIVAL), "LIMIT": str(LIMIT), "NO_STEP": str(NO_STEP),
    }  # fmt: skip
    text = _SOURCE
    for name, piece in pieces.items():
        text = text.replace(f"<{name}>", piece)
    return text


def _sum(row: dict[int, float]) -> str:
    return " + ".join(f"{c!r}*k[{j}][i]" for j, c in row.items())


def _each(line: str) -> str:
    return f"    for (int i = 0; i < M; i++) {line};"


_SOURCE = """#define rhs static joint
<right>
#undef rhs
<growth>
#define N <N>
#define K <K>
#define M (N + 1 + N*K)
static void slope(double t, const double *z, const double *parameters, double *f)
{
    double r[<entries>];
    const double *restrict y = z + N + 1;
    double *restrict g = f + N + 1;
    joint(t, z, parameters, r);
    for (int i = 0; i < N; i++) f[i] = r[i];
    f[N] = <trace>;
<rows>
}
/* Gram and Schmidt in the metric of the units; the logarithms of the lengths join logs */
static void orthogonalise(double *y, const double *units, double *logs)
{
    for (int c = 0; c < K; c++) {
        for (int b = 0; b < c; b++) {
            double dot = 0.0;
            for (int i = 0; i < N; i++) dot += y[i*K + b]*y[i*K + c]/(units[i]*units[i]);
            for (int i = 0; i < N; i++) y[i*K + c] -= dot*y[i*K + b];
        }
        double size = 0.0;
        for (int i = 0; i < N; i++) size += y[i*K + c]*y[i*K + c]/(units[i]*units[i]);
        size = sqrt(size);
        for (int i = 0; i < N; i++) y[i*K + c] /= size;
        logs[c] += log(size);
    }
}
/* clock: time, length of the next step, growth of the last one; counts: steps, evaluations */
long long drive(double *clock, double *z, const double *parameters, const double *units,
                double *logs, long long *counts, double end, double tol, long long limit,
                long long every)
{
    double k[<slopes>][M], z1[M], t = clock[0], size = clock[1], last = clock[2];
    const double order = end >= t ? 1.0 : -1.0;
    int rejected = 0, outcome = <LIMIT>;
    slope(t, z, parameters, k[0]);
    counts[1]++;
    if (size == 0.0) {
        double below = 0.0, steep = 0.0;
        for (int i = 0; i < M; i++) {
            const double unit = i < N ? units[i] : i == N ? 1.0 : units[(i - N - 1)/K];
            const double share = 1.0/(unit + fabs(z[i]));
            below = fmax(below, fabs(z[i])*share);
            steep = fmax(steep, fabs(k[0][i])*share);
        }
        size = steep > 0.0 ? 0.01*fmax(below, 0.1)/steep : 1.0;
        last = <first_growth>;
    }
    for (long long steps = 0; steps < limit;) {
        if (t == end) { outcome = <ARRIVAL>; break; }
        if (!(size > 4e-16*fabs(t) + 1e-300)) { outcome = <NO_STEP>; break; }
        double ahead = t + order*size, h, five = 0.0, three = 0.0;
        const int cut = order*(ahead - end) >= 0.0;
        if (cut) ahead = end;
        h = ahead - t;
<stages>
        for (int i = 0; i < M; i++) z1[i] = z[i] + h*(<step>);
        slope(ahead, z1, parameters, k[<last>]);
        counts[1] += 12;
        for (int i = 0; i < M; i++) {
            const double unit = i < N ? units[i] : i == N ? 1.0 : units[(i - N - 1)/K];
            const double share = 1.0/(tol*(unit + fmax(fabs(z[i]), fabs(z1[i]))));
            const double a = (<fifth>)*share, b = (<third>)*share;
            five += a*a;
            three += b*b;
        }
        const double wrong = (five + 0.01*three)*M;
        const double error = wrong > 0.0 ? fabs(h)*five/sqrt(wrong) : five + three;
        if (!(error <= 1.0)) {
            /* the step in numbers, h, may be the longer one: size alone is sure to shrink */
            size = fmin(size, fabs(h));
            size *= error == error ? fmax(0.2, 0.9*pow(error, -0.125)) : 0.2;
            rejected = 1;
            continue;
        }
        const double ease = error > 0.0 ? 0.9*pow(error, -0.125) : 10.0;
        const double factor = fmin(rejected ? 1.0 : 10.0, ease);
        const double grown = growth(factor, last, rejected);
        if (!cut || grown < 1.0) size = fabs(h)*grown;
        last = factor;
        rejected = 0;
        steps++;
        counts[0]++;
        t = ahead;
        for (int i = 0; i < M; i++) z[i] = z1[i];
        if (every > 0 && (counts[0] % every == 0 || t == end)) {
            orthogonalise(z + N + 1, units, logs);
            slope(t, z, parameters, k[0]);
            counts[1]++;
        } else
            for (int i = 0; i < M; i++) k[0][i] = k[<last>][i];
    }
    if (t == end) outcome = <ARRIVAL>;
    clock[0] = t;
    clock[1] = size;
    clock[2] = last;
    return outcome;
}
"""
