/* Motions of Lagrange's equations with multipliers, in extended precision.
 *
 *   M wdot = f + A^T lambda,   A wdot = b,   qdot = rates(q, w, t)
 *
 * What is generated for one system stands above this text: REAL and its functions, the numbers
 *   NQ coordinates, NW velocities, NC rows of A, NR relations, NV independent velocities,
 *   NS switches, NG = max(NS, 1)
 * and the functions
 *   parts(t, y, p, g, M, f, A, b, qd), switches(t, y, p, g, s), slopes(t, y, p, g, ds)
 * where y = (q, w), g are the signs of the switches, and ds holds the derivatives of each switch
 * by t and y.  Gragg's midpoint rule is extrapolated (Bulirsch and Stoer); where a switch changes
 * its sign the step ends, and where the fields of both sides point to the surface the motion
 * slides along it (Filippov): the sign is then the number that keeps the switch at zero.
 */
#include <stdlib.h>
#include <string.h>

#define NY (NQ + NW)
#define NK (NW + NC)
#define COLUMNS 8
#define SUBSTEPS (2 * COLUMNS)

enum { DONE = 0, SINGULAR = 1, STUCK = 2, BUDGET = 3, AMBIGUOUS = 4 };

static const REAL *par;
static REAL mode[NG];
static int sliding[NG];
static long evaluations;
static REAL worst_pivot;

/* A x = rhs by elimination with full pivoting; rows are scaled first, and rows that vanish
 * (dependent constraints) are left out.  Returns the smallest pivot against the largest. */
static REAL solve(int n, REAL *A, REAL *rhs, REAL *x)
{
    int column[NK > 0 ? NK : 1], rank = n;
    REAL largest = 0, smallest = 0;
    for (int i = 0; i < n; i++) {
        REAL size = 0;
        for (int j = 0; j < n; j++) if (FABS(A[i * n + j]) > size) size = FABS(A[i * n + j]);
        if (size > 0) { for (int j = 0; j < n; j++) A[i * n + j] /= size; rhs[i] /= size; }
        column[i] = i;
    }
    for (int k = 0; k < n; k++) {
        int r = k, c = k;
        REAL best = -1;
        for (int i = k; i < n; i++)
            for (int j = k; j < n; j++)
                if (FABS(A[i * n + j]) > best) { best = FABS(A[i * n + j]); r = i; c = j; }
        if (k == 0) largest = best;
        if (!(best > largest * NEGLIGIBLE)) { rank = k; break; }
        smallest = best;
        if (r != k) {
            for (int j = 0; j < n; j++) { REAL v = A[k*n+j]; A[k*n+j] = A[r*n+j]; A[r*n+j] = v; }
            REAL v = rhs[k]; rhs[k] = rhs[r]; rhs[r] = v;
        }
        if (c != k) {
            for (int i = 0; i < n; i++) { REAL v = A[i*n+k]; A[i*n+k] = A[i*n+c]; A[i*n+c] = v; }
            int v = column[k]; column[k] = column[c]; column[c] = v;
        }
        for (int i = k + 1; i < n; i++) {
            REAL factor = A[i * n + k] / A[k * n + k];
            if (factor == 0) continue;
            for (int j = k; j < n; j++) A[i * n + j] -= factor * A[k * n + j];
            rhs[i] -= factor * rhs[k];
        }
    }
    REAL z[NK > 0 ? NK : 1];
    for (int i = n - 1; i >= 0; i--) {
        if (i >= rank) { z[i] = 0; continue; }
        REAL sum = rhs[i];
        for (int j = i + 1; j < n; j++) sum -= A[i * n + j] * z[j];
        z[i] = sum / A[i * n + i];
    }
    for (int i = 0; i < n; i++) x[column[i]] = z[i];
    return largest > 0 ? smallest / largest : 0;
}

static void kkt(REAL t, const REAL *y, const REAL *g, REAL *K, REAL *rhs, REAL *qd)
{
    REAL M[NW * NW], f[NW], A[(NC > 0 ? NC : 1) * NW], b[NC > 0 ? NC : 1];
    parts(t, y, par, g, M, f, A, b, qd);
    memset(K, 0, sizeof(REAL) * NK * NK);
    for (int i = 0; i < NW; i++) {
        for (int j = 0; j < NW; j++) K[i * NK + j] = M[i * NW + j];
        for (int k = 0; k < NC; k++) K[i * NK + NW + k] = K[(NW + k) * NK + i] = A[k * NW + i];
        rhs[i] = f[i];
    }
    for (int k = 0; k < NC; k++) rhs[NW + k] = b[k];
}

static void smooth_field(REAL t, const REAL *y, const REAL *g, REAL *dy)
{
    REAL K[NK * NK], rhs[NK], x[NK];
    kkt(t, y, g, K, rhs, dy);
    REAL pivot = solve(NK, K, rhs, x);
    if (pivot < worst_pivot) worst_pivot = pivot;
    for (int i = 0; i < NW; i++) dy[NQ + i] = x[i];
    evaluations++;
}

/* The rate of switch k along the field with signs g. */
static REAL switch_rate(int k, REAL t, const REAL *y, const REAL *g, const REAL *dy)
{
    REAL ds[NG * (NY + 1)];
    slopes(t, y, par, g, ds);
    REAL sum = ds[k * (NY + 1)];
    for (int i = 0; i < NY; i++) sum += ds[k * (NY + 1) + 1 + i] * dy[i];
    return sum;
}

/* The field; signs of surfaces slid along are solved for, and left in g. */
static void field_with(REAL t, const REAL *y, REAL *g, const int *slide, REAL *dy)
{
    int which[NG], n = 0;
    for (int k = 0; k < NS; k++) if (slide[k]) which[n++] = k;
    if (!n) { smooth_field(t, y, g, dy); return; }
    REAL B[NK * NK], rhs[NK], x[NK], base[NG];
    for (int i = 0; i < n; i++) g[which[i]] = 0;
    smooth_field(t, y, g, dy);
    for (int i = 0; i < n; i++) base[i] = switch_rate(which[i], t, y, g, dy);
    for (int j = 0; j < n; j++) {
        REAL d[NY];
        g[which[j]] = 1;
        smooth_field(t, y, g, d);
        for (int i = 0; i < n; i++) B[i * n + j] = switch_rate(which[i], t, y, g, d) - base[i];
        g[which[j]] = 0;
    }
    for (int i = 0; i < n; i++) rhs[i] = -base[i];
    solve(n, B, rhs, x);
    for (int i = 0; i < n; i++) g[which[i]] = x[i];
    smooth_field(t, y, g, dy);
}

static void field(REAL t, const REAL *y, REAL *dy) { field_with(t, y, mode, sliding, dy); }

/* One extrapolated step; trail holds the points of the finest midpoint rule. */
static REAL step(REAL t, const REAL *y, REAL h, REAL tol, REAL *end, REAL *trail)
{
    static REAL table[COLUMNS][COLUMNS][NY];
    REAL first[NY], d[NY];
    field(t, y, first);
    for (int k = 0; k < COLUMNS; k++) {
        int n = 2 * (k + 1);
        REAL s = h / n, before[NY], now[NY];
        for (int i = 0; i < NY; i++) { before[i] = y[i]; now[i] = y[i] + s * first[i]; }
        for (int m = 1; m < n; m++) {
            field(t + m * s, now, d);
            if (k == COLUMNS - 1) memcpy(trail + (m - 1) * NY, now, sizeof(now));
            for (int i = 0; i < NY; i++) {
                REAL next = before[i] + 2 * s * d[i];
                before[i] = now[i];
                now[i] = next;
            }
        }
        field(t + h, now, d);
        for (int i = 0; i < NY; i++) table[k][0][i] = (now[i] + before[i] + s * d[i]) / 2;
        for (int j = 1; j <= k; j++) {
            REAL ratio = (REAL)n / (2 * (k - j + 1));
            for (int i = 0; i < NY; i++)
                table[k][j][i] = table[k][j - 1][i]
                    + (table[k][j - 1][i] - table[k - 1][j - 1][i]) / (ratio * ratio - 1);
        }
    }
    REAL error = 0;
    for (int i = 0; i < NY; i++) {
        end[i] = table[COLUMNS - 1][COLUMNS - 1][i];
        REAL size = FABS(y[i]) > FABS(end[i]) ? FABS(y[i]) : FABS(end[i]);
        REAL moved = FABS(h * first[i]);
        REAL scale = tol * ((moved > size ? moved : size) + (REAL)1 / 1000);
        REAL e = FABS(table[COLUMNS - 1][COLUMNS - 1][i] - table[COLUMNS - 1][COLUMNS - 2][i]);
        if (!(e / scale <= error)) error = e / scale;
        if (!(FABS(end[i]) < 1e30)) return 1e30;
    }
    memcpy(trail + (SUBSTEPS - 1) * NY, end, sizeof(REAL) * NY);
    return error;
}

/* Whether the motion has left the piece of the field it was on: a sign changed, or what holds it
 * on a surface gave way. */
static const REAL STILL = 1e-17;
static int left(REAL t, const REAL *y)
{
    REAL s[NG], g[NG], dy[NY];
    if (!NS) return 0;
    memcpy(g, mode, sizeof(g));
    switches(t, y, par, g, s);
    for (int k = 0; k < NS; k++) if (!sliding[k] && s[k] * mode[k] < -STILL) return 1;
    int any = 0;
    for (int k = 0; k < NS; k++) any |= sliding[k];
    if (!any) return 0;
    field_with(t, y, g, sliding, dy);
    for (int k = 0; k < NS; k++) if (sliding[k] && FABS(g[k]) > 1) return 1;
    return 0;
}

/* Choose the signs and the surfaces slid along at a point; switches within ON count as zero. */
static const REAL ON = 1e-12;
static int choose(REAL t, const REAL *y, int direction)
{
    REAL s[NG], dy[NY];
    int on[NG], n = 0;
    if (!NS) return DONE;
    for (int pass = 0; pass < 2; pass++) {  /* switches may hold the signs of others */
        switches(t, y, par, mode, s);
        for (int k = 0; k < NS; k++) if (FABS(s[k]) > ON) mode[k] = s[k] > 0 ? 1 : -1;
    }
    for (int k = 0; k < NS; k++) { sliding[k] = 0; if (FABS(s[k]) <= ON) on[n++] = k; }
    if (!n) return DONE;
    if (n > 4) return AMBIGUOUS;
    int total = 1, found = 0;
    REAL best_mode[NG];
    int best_sliding[NG];
    for (int i = 0; i < n; i++) total *= 3;
    for (int code = 0; code < total; code++) {  /* each -1, 1, or sliding: which is consistent? */
        REAL g[NG];
        int slide[NG], rest = code, good = 1, slides = 0;
        memcpy(g, mode, sizeof(g));
        memset(slide, 0, sizeof(slide));
        for (int i = 0; i < n; i++, rest /= 3) {
            slide[on[i]] = rest % 3 == 2;
            g[on[i]] = rest % 3 == 0 ? -1 : 1;
            slides += slide[on[i]];
        }
        field_with(t, y, g, slide, dy);
        for (int i = 0; i < n && good; i++) {
            int k = on[i];
            if (slide[k]) {  /* stable, and the signs of both sides point here */
                REAL up[NG], du[NY], dd[NY];
                if (!(FABS(g[k]) < 1)) { good = 0; break; }
                memcpy(up, g, sizeof(up));
                up[k] = 1; smooth_field(t, y, up, du);
                up[k] = -1; smooth_field(t, y, up, dd);
                REAL a = direction * switch_rate(k, t, y, g, du);
                REAL b = direction * switch_rate(k, t, y, g, dd);
                if (!(a < -1e-9 && b > 1e-9)) good = 0;
            } else {
                REAL rate = direction * switch_rate(k, t, y, g, dy);
                if (!(rate * g[k] > 1e-9)) good = 0;
            }
        }
        if (!good) continue;
        if (found++) return AMBIGUOUS;
        memcpy(best_mode, g, sizeof(g));
        memcpy(best_sliding, slide, sizeof(slide));
    }
    if (!found) return AMBIGUOUS;
    memcpy(mode, best_mode, sizeof(best_mode));
    memcpy(sliding, best_sliding, sizeof(best_sliding));
    return DONE;
}

/* After a surface was reached: choose anew, or let go of what gave way. */
static int turn_over(REAL t, REAL *y, int direction)
{
    REAL g[NG], dy[NY];
    memcpy(g, mode, sizeof(g));
    field_with(t, y, g, sliding, dy);
    int released = 0;
    for (int k = 0; k < NS; k++)
        if (sliding[k] && FABS(g[k]) > 1 - (REAL)1e-9) {
            sliding[k] = 0;
            mode[k] = g[k] > 0 ? 1 : -1;
            released = 1;
        }
    if (released) return DONE;
    return choose(t, y, direction);
}

static void state_in(const double *hi, const double *lo, REAL *y)
{
    for (int i = 0; i < NY; i++) y[i] = (REAL)hi[i] + (REAL)lo[i];
}

/* The motion at the instants given; out holds high and low parts.  Returns how it ended;
 * report = (time reached, smallest pivot ratio, steps, evaluations, crossings, slides, and the
 * instant of the steps at which the velocities are largest). */
int motion(const double *p, const double *hi, const double *lo, double t0, int count,
           const double *times, double tolerance, double longest, long budget,
           double *out, double *report)
{
    REAL parameters[NP > 0 ? NP : 1], y[NY], end[NY];
    static REAL trail[SUBSTEPS * NY];
    for (int i = 0; i < NP; i++) parameters[i] = p[i];
    par = parameters;
    state_in(hi, lo, y);
    REAL t = t0, tol = tolerance, h = 0;
    long steps = 0, crossings = 0, slides = 0;
    int outcome = DONE, at = 0;
    evaluations = 0;
    worst_pivot = 1;
    int direction = count && times[count - 1] < t0 ? -1 : 1;
    for (int k = 0; k < NG; k++) { mode[k] = 1; sliding[k] = 0; }
    outcome = choose(t, y, direction);
    REAL dy[NY], fastest = 0, speed = 0, swift = t0;
    field(t, y, dy);
    for (int i = 0; i < NY; i++) if (FABS(dy[i]) > fastest) fastest = FABS(dy[i]);
    h = direction * (REAL)0.1 / (1 + fastest);
    while (outcome == DONE && at < count) {
        REAL goal = times[at];
        if (t == goal || direction * (goal - t) <= 0) {
            for (int i = 0; i < NY; i++) {
                out[2 * (at * NY + i)] = (double)y[i];
                out[2 * (at * NY + i) + 1] = (double)(y[i] - (REAL)(double)y[i]);
            }
            at++;
            continue;
        }
        int last = direction * (t + h - goal) >= 0;
        REAL now = last ? goal - t : h;
        REAL error = step(t, y, now, tol, end, trail);
        steps++;
        if (evaluations > budget) { outcome = BUDGET; break; }
        REAL factor = error > 1e-20 ? POW(error, -(REAL)1 / (2 * COLUMNS - 1)) * 9 / 10 : 4;
        if (!(factor > 0.1)) factor = 0.1;
        if (factor > 4) factor = 4;
        if (!(error <= 1)) {
            h = now * (factor < 0.9 ? factor : 0.9);
            if (FABS(h) < 1e-12 * (1 + FABS(t)) * EPSILON_RATIO) outcome = STUCK;
            continue;
        }
        int crossed = -1;
        for (int m = 0; NS && m < SUBSTEPS && crossed < 0; m++)
            if (left(t + now * (m + 1) / SUBSTEPS, trail + m * NY)) crossed = m;
        if (crossed >= 0) {
            REAL low = now * crossed / SUBSTEPS, high = now * (crossed + 1) / SUBSTEPS, other[NY];
            static REAL unused[SUBSTEPS * NY];
            /* the trail is rough: widen the bracket until it holds */
            step(t, y, high, tol, end, unused);
            if (!left(t + high, end)) {
                if (crossed < SUBSTEPS - 1) { h = high; if (direction * h < 0) h = -h;
                    memcpy(y, end, sizeof(y)); t += high; continue; }
                crossed = -1;
            } else {
                step(t, y, low, tol, other, unused);
                if (low == 0 || left(t + low, other)) low = 0;
                for (int n = 0; n < 90 && FABS(high - low) > 4 * EPSILON * (FABS(t) + FABS(high)); n++) {
                    REAL middle = (low + high) / 2;
                    step(t, y, middle, tol, other, unused);
                    if (left(t + middle, other)) { high = middle; memcpy(end, other, sizeof(end)); }
                    else low = middle;
                }
                t += high;
                memcpy(y, end, sizeof(y));
                outcome = turn_over(t, y, direction);
                crossings++;
                for (int k = 0; k < NS; k++) slides += sliding[k];
                if (crossings > 2000) outcome = AMBIGUOUS;
                h = direction * (REAL)0.01 < 0 ? -(REAL)0.01 : (REAL)0.01;
                continue;
            }
        }
        t = last ? goal : t + now;
        memcpy(y, end, sizeof(y));
        for (int i = NQ; i < NY; i++) if (FABS(y[i]) > speed) { speed = FABS(y[i]); swift = t; }
        if (!last || factor < 1) h = now * factor;
        if (longest > 0 && FABS(h) > longest) h = h > 0 ? longest : -longest;
    }
    report[0] = (double)t;
    report[1] = (double)worst_pivot;
    report[2] = steps;
    report[3] = evaluations;
    report[4] = crossings;
    report[5] = slides;
    report[6] = (double)swift;
    return outcome;
}

/* The matrix of the multiplier equations at a point, for its condition number. */
void matrix_at(const double *p, double t, const double *hi, const double *lo, double *K)
{
    REAL parameters[NP > 0 ? NP : 1], y[NY], L[NK * NK], rhs[NK], qd[NQ], g[NG];
    for (int i = 0; i < NP; i++) parameters[i] = p[i];
    par = parameters;
    state_in(hi, lo, y);
    for (int k = 0; k < NG; k++) g[k] = 1;
    kkt(t, y, g, L, rhs, qd);
    for (int i = 0; i < NK * NK; i++) K[i] = (double)L[i];
}
