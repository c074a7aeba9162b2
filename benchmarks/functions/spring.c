/* The spring's rollout as one would write it in C: RK4 steps of 16 candidates at a time.
   FUNCTION(v) is given where this is compiled. */
#include <math.h>
#define LANES 16
#define MASS 0.7

static inline double interp(double v) {
    static const double x[] = {-2, -1, 0, 1, 2}, y[] = {-1, -0.5, 0, 0.6, 1};
    double found = y[0];
    for (int k = 0; k < 4; k++) {
        double line = y[k] + (y[k + 1] - y[k]) / (x[k + 1] - x[k]) * (v - x[k]);
        found = v >= x[k] ? line : found;
    }
    return v >= x[4] ? y[4] : found;
}

#define RATE(position, speed) \
    ((force - stiffness[l] * (position) - viscous[l] * (speed) - dry[l] * friction(speed)) / MASS)

static inline double friction(double v) { return FUNCTION(v); }

void squares(long samples, long lanes, double h, const double *y, const double *u, const double *x0,
             const double *p, double *out) {
    for (long first = 0; first < lanes; first += LANES) {
        double x[LANES], w[LANES], total[LANES] = {0};
        const double *stiffness = p + first, *viscous = stiffness + lanes, *dry = viscous + lanes;
        for (int l = 0; l < LANES; l++) x[l] = x0[first + l], w[l] = x0[lanes + first + l];
        for (long k = 0; k < samples; k++) {
            double force = k ? u[k - 1] : 0.0;
            for (int l = 0; k && l < LANES; l++) {
                double v1 = w[l], a1 = RATE(x[l], v1);
                double v2 = w[l] + 0.5 * h * a1, a2 = RATE(x[l] + 0.5 * h * v1, v2);
                double v3 = w[l] + 0.5 * h * a2, a3 = RATE(x[l] + 0.5 * h * v2, v3);
                double v4 = w[l] + h * a3, a4 = RATE(x[l] + h * v3, v4);
                x[l] += h / 6.0 * (v1 + 2.0 * (v2 + v3) + v4);
                w[l] += h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4);
            }
            for (int l = 0; l < LANES; l++) total[l] += (x[l] - y[k]) * (x[l] - y[k]);
        }
        for (int l = 0; l < LANES; l++) out[first + l] = total[l];
    }
}
