/* Three tanks as one would write them by hand for speed: RK4 steps and squared residuals of two
 * outputs, structure of arrays, chunks of 16 candidates with the candidate loop innermost.
 *
 * y is (samples, 2), u (samples, 2), x0 (3, lanes), p (3, lanes), out (2, lanes); lanes is a
 * multiple of 16 and samples lie h seconds apart. */

#include <math.h>

#define LANES 16

static const double FLOW = 0.6 * 0.6 / 100.0;
static const double TWICE_GRAVITY = 2.0 * 981.0;
static const double AREA = 100.0;

static inline double jet_speed(double head)
{
    return copysign(sqrt(TWICE_GRAVITY * fabs(head)), head);
}

static inline void rates(const double *u, double h1, double h2, double h3,
                         double p1, double p2, double p3, double *d1, double *d2, double *d3)
{
    const double q13 = p1 * FLOW * jet_speed(h1 - h3);
    const double q32 = p3 * FLOW * jet_speed(h3 - h2);
    const double q20 = p2 * FLOW * jet_speed(h2);
    *d1 = u[0] / AREA - q13;
    *d2 = u[1] / AREA + q32 - q20;
    *d3 = q13 - q32;
}

static inline void add_squares(const double *y, const double *x, double *total)
{
    for (int i = 0; i < LANES; i++) {
        const double r1 = x[i] - y[0], r2 = x[LANES + i] - y[1];
        total[i] += r1 * r1;
        total[LANES + i] += r2 * r2;
    }
}

static inline void step(double h, const double *u, const double *p, double *x)
{
    for (int i = 0; i < LANES; i++) {
        const double h1 = x[i], h2 = x[LANES + i], h3 = x[2 * LANES + i];
        const double p1 = p[i], p2 = p[LANES + i], p3 = p[2 * LANES + i];
        double a1, a2, a3, b1, b2, b3, c1, c2, c3, d1, d2, d3;
        rates(u, h1, h2, h3, p1, p2, p3, &a1, &a2, &a3);
        rates(u, h1 + 0.5 * h * a1, h2 + 0.5 * h * a2, h3 + 0.5 * h * a3, p1, p2, p3,
              &b1, &b2, &b3);
        rates(u, h1 + 0.5 * h * b1, h2 + 0.5 * h * b2, h3 + 0.5 * h * b3, p1, p2, p3,
              &c1, &c2, &c3);
        rates(u, h1 + h * c1, h2 + h * c2, h3 + h * c3, p1, p2, p3, &d1, &d2, &d3);
        x[i] = h1 + h / 6.0 * (a1 + 2.0 * (b1 + c1) + d1);
        x[LANES + i] = h2 + h / 6.0 * (a2 + 2.0 * (b2 + c2) + d2);
        x[2 * LANES + i] = h3 + h / 6.0 * (a3 + 2.0 * (b3 + c3) + d3);
    }
}

void squares(long samples, long lanes, double h, const double *y, const double *u,
             const double *x0, const double *p, double *out)
{
    for (long first = 0; first < lanes; first += LANES) {
        double x[3 * LANES], q[3 * LANES], total[2 * LANES] = {0.0};
        for (int j = 0; j < 3; j++)
            for (int i = 0; i < LANES; i++) {
                x[j * LANES + i] = x0[j * lanes + first + i];
                q[j * LANES + i] = p[j * lanes + first + i];
            }
        add_squares(y, x, total);
        for (long k = 1; k < samples; k++) {
            step(h, u + 2 * (k - 1), q, x);
            add_squares(y + 2 * k, x, total);
        }
        for (int j = 0; j < 2; j++)
            for (int i = 0; i < LANES; i++)
                out[j * lanes + first + i] = total[j * LANES + i];
    }
}
