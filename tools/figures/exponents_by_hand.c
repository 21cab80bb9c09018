/* Six Lyapunov exponents of the non-symmetric gyroscopic ball on a sphere, as one writes it by hand:
 *     gamma' = e gamma x omega,   G' = (G + kappa) x omega,   omega = A (G + c gamma),
 *     c = D (gamma, A G) / (1 - D (gamma, A gamma)),   A = (I + D)^-1,   D = m R2^2,
 * one Jacobian a stage, its product with the columns, DOP853, whose tables are handed in, and Gram
 * and Schmidt after every fourth step.
 */
#include <math.h>
#define N 6
#define M (N + N*N)

static void cross(const double *a, const double *b, double *r)
{
    r[0] = a[1]*b[2] - a[2]*b[1];
    r[1] = a[2]*b[0] - a[0]*b[2];
    r[2] = a[0]*b[1] - a[1]*b[0];
}

/* p: R1 R2 m I1 I2 I3 kappa1 kappa2 kappa3 */
static void slope(const double *z, const double *p, double *f)
{
    const double *g = z, *G = z + 3, D = p[2]*p[1]*p[1], e = p[0]/(p[0] + p[1]);
    double A[3], ag[3], w[3], H[3], J[N][N], GA = 0.0, gA = 0.0;
    for (int i = 0; i < 3; i++) {
        A[i] = 1.0/(p[3 + i] + D);
        ag[i] = A[i]*g[i];
        GA += G[i]*ag[i];
        gA += g[i]*ag[i];
        H[i] = G[i] + p[6 + i];
    }
    const double low = 1.0/(1.0 - D*gA), c = D*GA*low;
    for (int i = 0; i < 3; i++) w[i] = A[i]*(G[i] + c*g[i]);
    cross(g, w, f);
    for (int i = 0; i < 3; i++) f[i] *= e;
    cross(H, w, f + 3);
    for (int j = 0; j < 3; j++) {
        const double by_g = D*(A[j]*G[j] + 2.0*c*ag[j])*low, by_G = D*ag[j]*low;
        double dw[3], eG[3], a[3], b[3], unit[3] = {0.0, 0.0, 0.0};
        unit[j] = 1.0;
        for (int i = 0; i < 3; i++) {
            dw[i] = A[i]*(by_g*g[i] + c*unit[i]);
            eG[i] = A[i]*(by_G*g[i] + unit[i]);
        }
        cross(unit, w, a);
        cross(g, dw, b);
        for (int i = 0; i < 3; i++) J[i][j] = e*(a[i] + b[i]);
        cross(H, dw, b);
        for (int i = 0; i < 3; i++) J[3 + i][j] = b[i];
        cross(g, eG, b);
        for (int i = 0; i < 3; i++) J[i][3 + j] = e*b[i];
        cross(H, eG, b);
        for (int i = 0; i < 3; i++) J[3 + i][3 + j] = a[i] + b[i];
    }
    for (int i = 0; i < N; i++)
        for (int k = 0; k < N; k++) {
            double s = 0.0;
            for (int j = 0; j < N; j++) s += J[i][j]*z[N + j*N + k];
            f[N + i*N + k] = s;
        }
}

static void orthogonalise(double *y, double *logs)
{
    for (int c = 0; c < N; c++) {
        for (int b = 0; b < c; b++) {
            double dot = 0.0;
            for (int i = 0; i < N; i++) dot += y[i*N + b]*y[i*N + c];
            for (int i = 0; i < N; i++) y[i*N + c] -= dot*y[i*N + b];
        }
        double size = 0.0;
        for (int i = 0; i < N; i++) size += y[i*N + c]*y[i*N + c];
        size = sqrt(size);
        for (int i = 0; i < N; i++) y[i*N + c] /= size;
        logs[c] += log(size);
    }
}

/* a: 12 rows of weights and that of the step; e5, e3: errors; the motion from 0 to T */
long long by_hand(double *z, double *logs, const double *p, const double *a, const double *e5,
                  const double *e3, double T, double tol)
{
    double k[13][M], y[M], t = 0.0, h = 0.01;
    long long steps = 0;
    slope(z, p, k[0]);
    while (t < T) {
        if (t + h > T) h = T - t;
        for (int s = 1; s <= 12; s++) {
            for (int i = 0; i < M; i++) y[i] = 0.0;
            for (int j = 0; j < s; j++) {
                const double w = a[s*12 + j];
                if (w != 0.0)
                    for (int i = 0; i < M; i++) y[i] += w*k[j][i];
            }
            for (int i = 0; i < M; i++) y[i] = z[i] + h*y[i];
            slope(y, p, k[s]);
        }
        double five = 0.0, three = 0.0;
        for (int i = 0; i < M; i++) {
            double x5 = 0.0, x3 = 0.0;
            for (int j = 0; j < 12; j++) { x5 += e5[j]*k[j][i]; x3 += e3[j]*k[j][i]; }
            const double scale = tol*(1.0 + fmax(fabs(z[i]), fabs(y[i])));
            five += x5*x5/(scale*scale);
            three += x3*x3/(scale*scale);
        }
        const double error = h*five/sqrt((five + 0.01*three)*M);
        const double grow = error > 0.0 ? 0.9*pow(error, -0.125) : 10.0;
        if (error < 1.0) {
            t += h;
            for (int i = 0; i < M; i++) { z[i] = y[i]; k[0][i] = k[12][i]; }
            if (++steps % 4 == 0 || t >= T) { orthogonalise(z + N, logs); slope(z, p, k[0]); }
        }
        h *= fmin(10.0, fmax(0.2, grow));
    }
    return steps;
}
