/* SUNDIALS on the case: CVODE, and the explicit Runge-Kutta methods of ARKODE (ERKStep).
 *
 * Ways: 0 Adams, 1 BDF, each from reversal to reversal with its own root finding, started afresh there; 2 Adams, 3 BDF with the sign in
 * the right-hand side; 4 to 6 ERKStep of order 5, 6, 8 from reversal to reversal, which keeps its step there. Adams iterates on a fixed
 * point, BDF by Newton's method with the Jacobian matrix.
 */
#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_types.h>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "contact.h"

enum { MOST_STEPS = 100000000 };

static int rates(realtype t, N_Vector y, N_Vector out, void *data) {
    contact_rates(data, t, NV_DATA_S(y), NV_DATA_S(out));
    return 0;
}

static int jacobian(realtype t, N_Vector y, N_Vector fy, SUNMatrix matrix, void *data, N_Vector a, N_Vector b, N_Vector c) {
    (void)t, (void)fy, (void)a, (void)b, (void)c;
    contact_jacobian(data, NV_DATA_S(y), SM_DATA_D(matrix));
    return 0;
}

static int slip(realtype t, N_Vector y, realtype *out, void *data) {
    (void)t;
    out[0] = ((struct contact *)data)->sliding + NV_Ith_S(y, 1);
    return 0;
}

static void quiet(int code, const char *module, const char *function, char *message, void *data) {
    (void)code, (void)module, (void)function, (void)message, (void)data;
}

static void solve_cvode(const struct request *request, struct answer *answer, SUNContext context) {
    struct contact contact = request->contact;
    int events = request->way < 2, adams = request->way % 2 == 0;
    double longest = request->longest > 0 ? request->longest : events ? LONGEST_STEP : 0;
    N_Vector y = N_VNew_Serial(4, context);
    N_VConst(0, y);
    contact.sign = events ? 1 : 0;
    void *cvode = CVodeCreate(adams ? CV_ADAMS : CV_BDF, context);
    CVodeInit(cvode, rates, 0, y);
    CVodeSetErrHandlerFn(cvode, quiet, NULL);
    CVodeSetUserData(cvode, &contact);
    CVodeSStolerances(cvode, request->tolerance, request->tolerance);
    CVodeSetMaxNumSteps(cvode, MOST_STEPS);
    if (longest > 0) CVodeSetMaxStep(cvode, longest);
    SUNNonlinearSolver iteration = NULL;
    SUNLinearSolver linear = NULL;
    SUNMatrix matrix = NULL;
    if (adams) {
        iteration = SUNNonlinSol_FixedPoint(y, 0, context);
        CVodeSetNonlinearSolver(cvode, iteration);
    } else {
        matrix = SUNDenseMatrix(4, 4, context);
        linear = SUNLinSol_Dense(y, matrix, context);
        CVodeSetLinearSolver(cvode, linear, matrix);
        CVodeSetJacFn(cvode, jacobian);
    }
    int direction = -1;
    if (events) {
        CVodeRootInit(cvode, 1, slip);
        CVodeSetRootDirection(cvode, &direction);
    }
    double middle = 0, t = 0;
    for (int half = 1; half <= 2 && !answer->failure;) {
        double stop = clock_until(&contact, 0.5 * half * contact.length);
        CVodeSetStopTime(cvode, stop);
        int code = CVode(cvode, stop, y, &t, CV_NORMAL);
        if (code == CV_ROOT_RETURN) {
            clock_advance(&contact, t);
            NV_Ith_S(y, 1) = -contact.sliding;
            contact.sign = -contact.sign;
            direction = -direction;
            CVodeSetRootDirection(cvode, &direction);
            CVodeReInit(cvode, 0, y);
        } else if (code < 0) {
            answer->failure = CVodeGetReturnFlagName(code);
        } else {
            if (half == 1) middle = NV_Ith_S(y, 3);
            half++;
        }
    }
    finish(&contact, t, NV_DATA_S(y), middle, answer);
    CVodeFree(&cvode);
    if (iteration) SUNNonlinSolFree(iteration);
    if (linear) SUNLinSolFree(linear);
    if (matrix) SUNMatDestroy(matrix);
    N_VDestroy(y);
}

static void solve_erk(const struct request *request, struct answer *answer, SUNContext context) {
    static const int orders[] = {5, 6, 8};
    struct contact contact = request->contact;
    N_Vector y = N_VNew_Serial(4, context);
    N_VConst(0, y);
    contact.sign = 1;
    void *erk = ERKStepCreate(rates, 0, y, context);
    ERKStepSetErrHandlerFn(erk, quiet, NULL);
    ERKStepSetUserData(erk, &contact);
    ERKStepSetOrder(erk, orders[request->way - 4]);
    ERKStepSStolerances(erk, request->tolerance, request->tolerance);
    ERKStepSetMaxNumSteps(erk, MOST_STEPS);
    ERKStepSetMaxStep(erk, request->longest > 0 ? request->longest : LONGEST_STEP);
    int direction = -1;
    ERKStepRootInit(erk, 1, slip);
    ERKStepSetRootDirection(erk, &direction);
    double middle = 0, t = 0;
    for (int half = 1; half <= 2 && !answer->failure;) {
        double stop = clock_until(&contact, 0.5 * half * contact.length);
        ERKStepSetStopTime(erk, stop);
        int code = ERKStepEvolve(erk, stop, y, &t, ARK_NORMAL);
        if (code == ARK_ROOT_RETURN) {
            clock_advance(&contact, t);
            NV_Ith_S(y, 1) = -contact.sliding;
            contact.sign = -contact.sign;
            direction = -direction;
            ERKStepSetRootDirection(erk, &direction);
            ERKStepReset(erk, 0, y);
        } else if (code < 0) {
            answer->failure = ERKStepGetReturnFlagName(code);
        } else {
            if (half == 1) middle = NV_Ith_S(y, 3);
            half++;
        }
    }
    finish(&contact, t, NV_DATA_S(y), middle, answer);
    ERKStepFree(&erk);
    N_VDestroy(y);
}

static SUNContext context;

static void solve(const struct request *request, struct answer *answer) {
    (request->way < 4 ? solve_cvode : solve_erk)(request, answer, context);
}

int main(void) {
    char version[32] = "";
    SUNDIALSGetVersion(version, sizeof version);
    printf("{\"version\": \"SUNDIALS %s\"}\n", version);
    fflush(stdout);
    SUNContext_Create(NULL, &context);
    serve(solve);
    SUNContext_Free(&context);
    return 0;
}
