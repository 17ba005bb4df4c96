/* ODEPACK's LSODAR on the case, as the R package deSolve has it compiled: LSODA with root finding. Nothing of R itself is run.
 *
 * Ways: 0 from reversal to reversal, started afresh there; 1 sign in the right-hand side.
 */
#include "contact.h"

enum { NEQ = 4, LRW = 22 + NEQ * 16 + 3, LIW = 20 + NEQ };

typedef void rates_function(int *, double *, double *, double *, double *, int *);
typedef void jacobian_function(int *, double *, double *, int *, int *, double *, int *, double *, int *);
typedef void root_function(int *, double *, double *, int *, double *, double *, int *);

void dlsodar_(rates_function *, int *, double *, double *, double *, int *, double *, double *, int *, int *, int *, double *, int *,
              int *, int *, jacobian_function *, int *, root_function *, int *, int *, double *, int *);

/* What it has to say goes here, not to R's console, which there is none of; what it returns is an answer. */
void Rprintf(const char *format, ...) { (void)format; }

static struct contact contact;

static void rates(int *n, double *t, double *y, double *out, double *rpar, int *ipar) {
    (void)n, (void)rpar, (void)ipar;
    contact_rates(&contact, *t, y, out);
}

static void jacobian(int *n, double *t, double *y, int *lower, int *upper, double *columns, int *rows, double *rpar, int *ipar) {
    (void)n, (void)t, (void)lower, (void)upper, (void)rows, (void)rpar, (void)ipar;
    contact_jacobian(&contact, y, columns);
}

static void slip(int *n, double *t, double *y, int *roots, double *out, double *rpar, int *ipar) {
    (void)n, (void)t, (void)roots, (void)rpar, (void)ipar;
    out[0] = contact.sliding + y[1];
}

static void solve(const struct request *request, struct answer *answer) {
    static char failure[32];
    double y[NEQ] = {0}, work[LRW] = {0}, t = 0, tolerance = request->tolerance, middle = 0, rpar = 0;
    int integers[LIW] = {0}, neq = NEQ, scalar = 1, task = 4, state = 1, options = 1, lrw = LRW, liw = LIW, given = 1, found = 0, ipar = 0;
    int events = request->way == 0, roots = events ? 1 : 0;
    contact = request->contact;
    contact.sign = events ? 1 : 0;
    work[5] = request->longest > 0 ? request->longest : events ? LONGEST_STEP : 0;
    integers[5] = 100000000; /* steps in a call */
    for (int half = 1; half <= 2;) {
        double stop = clock_until(&contact, 0.5 * half * contact.length);
        work[0] = stop;
        dlsodar_(rates, &neq, y, &t, &stop, &scalar, &tolerance, &tolerance, &task, &state, &options, work, &lrw, integers, &liw, jacobian,
                 &given, slip, &roots, &found, &rpar, &ipar);
        if (state < 0) {
            snprintf(failure, sizeof failure, "LSODAR returns %d", state);
            answer->failure = failure;
            return;
        }
        if (state == 3) {
            clock_advance(&contact, t);
            y[1] = -contact.sliding;
            contact.sign = -contact.sign;
            t = 0;
            state = 1;
        } else {
            if (half == 1) middle = y[3];
            half++;
        }
    }
    finish(&contact, t, y, middle, answer);
}

int main(void) {
    puts("{\"version\": \"ODEPACK LSODAR (of deSolve)\"}");
    fflush(stdout);
    serve(solve);
    return 0;
}
