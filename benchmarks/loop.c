/* The benchmark's closed loop by hand: P control at 1 kHz of the non-rotating actuator, Dormand-Prince with the
   same step control as workbench/simulation/steppers.py. Built and timed by benchmarks/closed_loop.py. */
#include <math.h>

enum { N = 5 };

typedef struct {
    double coulomb, stribeck, viscous, stribeck_velocity, stiffness, damping;
} LuGre;

typedef struct {
    double area_1, area_2, stroke, hose_volume, bulk_modulus, supply, tank, flow_gain, position_gain, tau, spool_limit,
        voltage_limit, share, valve_overlap, leakage_coefficient, valve_overlap_negative, external_leakage_1,
        external_leakage_2;
    double mass, load, stop_stiffness, stop_damping;
    LuGre positive, negative;
} Parameters;

static double sign(double x) { return (x > 0) - (x < 0); }

static void rates(const double *y, double voltage, const Parameters *p, double *out)
{
    double x = y[0], v = y[1], pl = y[2], z = y[3], xs = y[4];
    const LuGre *f = v >= 0 ? &p->positive : &p->negative;
    double stiffness = z >= 0 ? p->positive.stiffness : p->negative.stiffness;
    double ratio = v / f->stribeck_velocity;
    double level = f->coulomb + f->stribeck * exp(-ratio * ratio);
    level = fmax(level, 0.01 * (f->coulomb + f->stribeck) + 1e-12);
    double dz = v - stiffness * fabs(v) * z / level;
    double friction = stiffness * z + f->damping * dz + f->viscous * v;
    double area = 0.5 * (p->area_1 + p->area_2);
    double volume = 2 * p->hose_volume + area * p->stroke;
    double drop = p->supply - p->tank - sign(xs) * pl;
    double flow = p->flow_gain * xs * sqrt(fmax(p->share * drop, 0));
    double dp = 4 * p->bulk_modulus / volume * (flow - area * v);
    if (pl >= p->supply) dp = fmin(dp, 0);
    else if (pl <= -p->supply) dp = fmax(dp, 0);
    double total = p->supply + p->tank;
    double force = 0.5 * (total + pl) * p->area_1 - 0.5 * (total - pl) * p->area_2;
    double side = sign(x), depth = fmax(fabs(x) - 0.5 * p->stroke, 0);
    double stop = -side * p->stop_stiffness * depth * fmax(1 + p->stop_damping * side * v, 0);
    double target = fmin(fmax(p->position_gain * voltage, -p->spool_limit), p->spool_limit);
    out[0] = v;
    out[1] = (force - friction - p->load + stop) / p->mass;
    out[2] = dp;
    out[3] = dz;
    out[4] = (target - xs) / p->tau;
}

static double factor(double worst) { return worst < 1e-4 ? 5 : fmin(5, fmax(0.1, 0.9 * pow(worst, -0.2))); }

/* Runs `samples` samples from rest; positions at the sample instants into `log`; returns the steps taken. */
long run(const Parameters *p, double gain, const double *reference, long samples, double h, double tolerance,
         const double *scale, double *log)
{
    double y[N] = {0}, k1[N], k2[N], k3[N], k4[N], k5[N], k6[N], k7[N], w[N];
    double step = h;
    long steps = 0;
    for (long k = 0; k < samples; k++) {
        double u = fmin(fmax(gain * (reference[k] - y[0]), -p->voltage_limit), p->voltage_limit);
        for (int j = 0; j < N; j++) log[k * N + j] = y[j];
        if (k + 1 == samples) break;
        double t = k * h, end = (k + 1) * h;
        rates(y, u, p, k1);
        while (t < end) {
            double left = end - t;
            int last = step >= left * (1 - 1e-9);
            double d = last ? left : fmin(step, 0.5 * left);
            steps++;
            for (int j = 0; j < N; j++) w[j] = y[j] + d * (1.0 / 5 * k1[j]);
            rates(w, u, p, k2);
            for (int j = 0; j < N; j++) w[j] = y[j] + d * (3.0 / 40 * k1[j] + 9.0 / 40 * k2[j]);
            rates(w, u, p, k3);
            for (int j = 0; j < N; j++) w[j] = y[j] + d * (44.0 / 45 * k1[j] - 56.0 / 15 * k2[j] + 32.0 / 9 * k3[j]);
            rates(w, u, p, k4);
            for (int j = 0; j < N; j++)
                w[j] = y[j] + d * (19372.0 / 6561 * k1[j] - 25360.0 / 2187 * k2[j] + 64448.0 / 6561 * k3[j]
                                   - 212.0 / 729 * k4[j]);
            rates(w, u, p, k5);
            for (int j = 0; j < N; j++)
                w[j] = y[j] + d * (9017.0 / 3168 * k1[j] - 355.0 / 33 * k2[j] + 46732.0 / 5247 * k3[j]
                                   + 49.0 / 176 * k4[j] - 5103.0 / 18656 * k5[j]);
            rates(w, u, p, k6);
            for (int j = 0; j < N; j++)
                w[j] = y[j] + d * (35.0 / 384 * k1[j] + 500.0 / 1113 * k3[j] + 125.0 / 192 * k4[j]
                                   - 2187.0 / 6784 * k5[j] + 11.0 / 84 * k6[j]);
            rates(w, u, p, k7);
            double worst = 0;
            for (int j = 0; j < N; j++) {
                double e = d * (71.0 / 57600 * k1[j] - 71.0 / 16695 * k3[j] + 71.0 / 1920 * k4[j]
                                - 17253.0 / 339200 * k5[j] + 22.0 / 525 * k6[j] - 1.0 / 40 * k7[j]);
                worst = fmax(worst, fabs(e) / (tolerance * (scale[j] + fmax(fabs(y[j]), fabs(w[j])))));
            }
            if (worst <= 1) {
                if (!last || step < 5 * d) {
                    double next = d * factor(worst);
                    step = last ? fmax(step, next) : next;
                }
                t = last ? end : t + d;
                for (int j = 0; j < N; j++) {
                    y[j] = w[j];
                    k1[j] = k7[j];
                }
            } else {
                step = d * factor(worst);
            }
        }
    }
    return steps;
}
