// The equations of scenes/matched-line.toml in plain C: two devices, two copies, passive wave line, one packet of delay. Without what a
// peer does beside them: guards, ledger, packets that may be late or lost, a hash.
//
// cc -O3 -march=native -DREAL=float -DLANES=16 equations.c -lm; prints million two-peer ticks a second, and where the first scene's second
// copy is in the end.
#include <math.h>
#include <stdio.h>
#include <time.h>

#define EACH for (int l = 0; l < LANES; l++)
typedef REAL row[LANES];
typedef double wide[LANES];

static const double T = 0.001;

struct peer {
    wide x_h, v_h, motor;
    row x_o, v_o, carry_o, x_d, carry_d, y, u_in, sent, force;
    row stiffness, inverse_loop;
};

static struct peer peers[2];

static void tick(struct peer *p, double push) {
    const double keep_v = exp(-1.0 * T / 0.1), to_x = 0.1 * (1 - keep_v), gain_v = 1 - keep_v, gain_x = T - to_x;
    const REAL contact_k = 1000, contact_b = 2, damping = 2, period = T, gain = T / 0.02, impedance = 40;
    const REAL root = sqrt(80.0), velocity_to_wave = sqrt(20.0), force_to_wave = 1 / sqrt(80.0);
    const REAL keep = exp(-6.283185307179586 * 60 * T), take = -expm1(-6.283185307179586 * 60 * T);
    const REAL most = 40, step = 20;
    (void)impedance;
    EACH {
        const REAL x_h = p->x_h[l], v_h = p->v_h[l], x_o = p->x_o[l], v_o = p->v_o[l], stiffness = p->stiffness[l];
        const REAL contact = contact_k * (x_h - x_o) + contact_b * (v_h - v_o);
        const REAL v_d = (root * p->u_in[l] - stiffness * (p->x_d[l] - x_o) + damping * v_o) * p->inverse_loop[l];
        const REAL moved_d = period * v_d - p->carry_d[l], x_d = p->x_d[l] + moved_d;
        p->carry_d[l] = (x_d - p->x_d[l]) - moved_d;
        p->x_d[l] = x_d;
        const REAL coordination = stiffness * (x_d - x_o) + damping * (v_d - v_o);
        p->y[l] = keep * p->y[l] + take * (velocity_to_wave * v_d - force_to_wave * coordination);
        const REAL v = v_o + gain * (contact + coordination);
        const REAL moved_o = period * v - p->carry_o[l], x = x_o + moved_o;
        p->carry_o[l] = (x - x_o) - moved_o;
        p->x_o[l] = x;
        p->v_o[l] = v;
        REAL wanted = -contact < -most ? -most : -contact > most ? most : -contact;
        const REAL change = wanted - p->force[l];
        wanted = change > step ? p->force[l] + step : change < -step ? p->force[l] - step : wanted;
        p->force[l] = wanted;
        // The motor's force of this tick acts from the next one on.
        const double pushed = p->motor[l] + push, x_was = p->x_h[l], v_was = p->v_h[l];
        p->x_h[l] = x_was + to_x * v_was + gain_x * pushed;
        p->v_h[l] = keep_v * v_was + gain_v * pushed;
        p->motor[l] = wanted;
    }
}

int main(void) {
    const long ticks = 20000;
    double best = INFINITY;
    for (int again = 0; again < 7; again++) {
        for (int at = 0; at < 2; at++) {
            peers[at] = (struct peer){0};
            EACH {
                peers[at].stiffness[l] = 1e5 * (0.2 + 0.04 * l);
                peers[at].inverse_loop[l] = 1 / (40.0 + 2.0 + 1e5 * (0.2 + 0.04 * l) * T);
            }
        }
        struct timespec from, to;
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &from);
        for (long n = 0; n < ticks; n++) {
            if (n % 8 == 0)
                EACH for (int at = 0; at < 2; at++) {
                    // What was sent a packet ago has come.
                    if (n > 0) peers[at].u_in[l] = peers[1 - at].sent[l];
                }
            if (n % 8 == 0)
                EACH for (int at = 0; at < 2; at++) peers[at].sent[l] = peers[at].y[l];
            tick(&peers[0], 1.0);
            tick(&peers[1], -(1.0 + 0.25 * sin(3.0 * (n * T))));
        }
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &to);
        const double took = (to.tv_sec - from.tv_sec) + 1e-9 * (to.tv_nsec - from.tv_nsec);
        if (took < best) best = took;
    }
    printf("%.17g %.17g\n", 1e-6 * ticks * LANES / best, (double)peers[1].x_o[0]);
}
