/* The contact in scaled units (scaled.rs), and how these programs are asked and answer.
 *
 * A request is one line of numbers: way, longest step (0: none), tolerance, then the coefficients in the order of `read_request`. An
 * answer is one line of JSON. The time is taken around the integration only. The first line says which version answers.
 *
 * A leg runs from one reversal to the next on a clock of its own, which begins at zero: what locates a root is then as fine as the leg is
 * short. `clock_` keeps the phase of the forcing, and the time that has passed as a sum of two numbers.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#define TURN 6.283185307179586
/* No step may hold two reversals, which would go unnoticed. */
#define LONGEST_STEP (TURN / 6)

struct contact {
    double sliding, kappa, spring, forcing, friction, share;
    double excess, stribeck, damping, viscous;
    double start, rate, length;
    double sign; /* held; zero: taken from the slip */
    double phase, frequency, passed, rest;
};

struct request {
    int way;
    double longest, tolerance;
    struct contact contact;
};

struct answer {
    double mean, end[3];
    const char *failure;
};

/* Rates of x, v, f, q at a time of the leg: scaled.rs has the equations. */
static inline double contact_rates(const struct contact *c, double t, const double *y, double *rates) {
    double slip = c->sliding + y[1];
    double sign = c->sign != 0 ? c->sign : copysign(1.0, slip);
    double level = 1;
    if (c->excess != 0) {
        double part = slip / c->stribeck;
        level += c->excess * exp(-part * part);
    }
    double bristle = c->kappa * slip * (1 - sign * y[2] / level);
    double force = y[2] + c->damping * bristle + c->viscous * slip;
    rates[0] = y[1];
    rates[1] = c->forcing * cos(c->phase + t * (c->frequency + 0.5 * c->rate * t)) - c->spring * y[0] - c->friction * force;
    rates[2] = bristle;
    rates[3] = c->share * force;
    return force;
}

/* Columns of the Jacobian matrix, four by four. */
static inline void contact_jacobian(const struct contact *c, const double *y, double *columns) {
    double slip = c->sliding + y[1];
    double sign = c->sign != 0 ? c->sign : copysign(1.0, slip);
    double level = 1, slope = 0;
    if (c->excess != 0) {
        double part = slip / c->stribeck, peak = c->excess * exp(-part * part);
        level += peak;
        slope = -2 * part / c->stribeck * peak;
    }
    double by_slip = c->kappa * (1 - sign * y[2] / level * (1 - slip * slope / level));
    double by_bristle = -c->kappa * sign * slip / level;
    double force_by_slip = c->damping * by_slip + c->viscous, force_by_bristle = 1 + c->damping * by_bristle;
    memset(columns, 0, 16 * sizeof *columns);
    columns[1] = -c->spring;
    columns[4] = 1;
    columns[5] = -c->friction * force_by_slip;
    columns[6] = by_slip;
    columns[7] = c->share * force_by_slip;
    columns[9] = -c->friction * force_by_bristle;
    columns[10] = by_bristle;
    columns[11] = c->share * force_by_bristle;
}

/* The next leg begins so much later. */
static inline void clock_advance(struct contact *c, double t) {
    c->phase = fmod(c->phase + t * (c->frequency + 0.5 * c->rate * t), TURN);
    double sum = c->passed + t, added = sum - c->passed;
    c->rest += (c->passed - (sum - added)) + (t - added);
    c->passed = sum;
    c->frequency = c->start + c->rate * (sum + c->rest);
}

/* From the beginning of this leg to a moment of the run. */
static inline double clock_until(const struct contact *c, double moment) { return (moment - c->passed) - c->rest; }

static int read_request(struct request *r) {
    char line[1024];
    struct contact *c = &r->contact;
    memset(r, 0, sizeof *r);
    if (!fgets(line, sizeof line, stdin)) return 0;
    int count = sscanf(line, "%d %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf", &r->way, &r->longest, &r->tolerance,
                       &c->sliding, &c->kappa, &c->spring, &c->forcing, &c->friction, &c->share, &c->excess, &c->stribeck, &c->damping,
                       &c->viscous, &c->start, &c->rate, &c->length);
    c->frequency = c->start;
    return count == 16;
}

static double now_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * t.tv_sec + t.tv_nsec;
}

/* Answers requests until standard input ends. */
static void serve(void (*solve)(const struct request *, struct answer *)) {
    struct request request;
    while (read_request(&request)) {
        struct answer a = {0};
        double began = now_ns();
        solve(&request, &a);
        double wall = now_ns() - began;
        if (a.failure)
            printf("{\"failure\": \"%s\"}\n", a.failure);
        else
            printf("{\"mean\": %.17g, \"end\": [%.17g, %.17g, %.17g], \"wall_ns\": %.0f}\n", a.mean, a.end[0], a.end[1], a.end[2], wall);
        fflush(stdout);
    }
}

/* At the end: friction is read with the sign that the leg has. */
static void finish(const struct contact *c, double t, const double *y, double middle, struct answer *a) {
    double rates[4];
    a->mean = 2 * (y[3] - middle);
    a->end[0] = y[0];
    a->end[1] = y[1];
    a->end[2] = contact_rates(c, t, y, rates);
}
