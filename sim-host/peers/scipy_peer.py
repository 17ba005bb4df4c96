"""SciPy's solve_ivp on the case, as a server: one JSON request a line on standard input, one JSON answer a line on standard output.

A request holds the coefficients of the case (case.rs), the number of periods, the method, whether reversals are events, and the
tolerance. An answer holds the mean, friction at quarter periods, and the wall time of the loop around solve_ivp. The first line,
before any request, says which version answers.

With events, an integration ends at a reversal: the sign flips as a discrete state, the slip is set to zero exactly, whole turns are
taken off the clock, and the next one begins with the step that the last one had. Without, the sign is in the right-hand side.
"""

import json
import sys
from math import copysign, cos, pi
from time import perf_counter

import numpy
import scipy
from scipy.integrate import solve_ivp

TURN = 2 * pi
QUARTER = 0.5 * pi
# No step may hold two reversals, which would go unnoticed, nor the first one after a reversal a further one.
LONGEST, FIRST = TURN / 6, TURN / 8
IMPLICIT = {"LSODA", "Radau", "BDF"}


class Contact:
    """The equations, with the sign of the slip held while it is not None."""

    def __init__(self, scaled, sign):
        self.sliding, self.kappa, self.spring = scaled["sliding"], scaled["kappa"], scaled["spring"]
        self.forcing, self.friction, self.share = scaled["forcing"], scaled["friction"], scaled["share"]
        self.sign = sign

    def rates(self, phase, y):
        x, v, f, _ = y.tolist()
        slip = self.sliding + v
        sign = copysign(1.0, slip) if self.sign is None else self.sign
        acceleration = self.forcing * cos(phase) - self.spring * x - self.friction * f
        return (v, acceleration, self.kappa * slip * (1.0 - sign * f), self.share * f)

    def jacobian(self, _phase, y):
        _, v, f, _ = y.tolist()
        slip = self.sliding + v
        sign = copysign(1.0, slip) if self.sign is None else self.sign
        return numpy.array((
            (0.0, 1.0, 0.0, 0.0),
            (-self.spring, 0.0, -self.friction, 0.0),
            (0.0, self.kappa * (1.0 - sign * f), -self.kappa * slip * sign, 0.0),
            (0.0, 0.0, self.share, 0.0),
        ))


def options(contact, request):
    """What every call has in common."""
    common = {"method": request["method"], "rtol": request["tolerance"], "atol": request["tolerance"]}
    if request["method"] in IMPLICIT:
        common["jac"] = contact.jacobian
    return common


def plain(request):
    """Samples with the sign in the right-hand side: one integration."""
    contact = Contact(request["scaled"], None)
    last = 4 * request["periods"]
    moments = QUARTER * numpy.arange(last + 1)
    solution = solve_ivp(contact.rates, (0.0, moments[-1]), numpy.zeros(4), t_eval=moments, **options(contact, request))
    if not solution.success:
        raise ArithmeticError(solution.message)
    return solution.y[2], solution.y[3]


def from_reversal_to_reversal(request):
    """Samples by one integration from each reversal to the next."""
    contact = Contact(request["scaled"], 1.0)
    common = options(contact, request)

    def slip(_phase, y):
        return contact.sliding + y[1]

    slip.terminal = True
    last = 4 * request["periods"]
    force, share = numpy.zeros(last + 1), numpy.zeros(last + 1)
    y, start, turns, done, step = numpy.zeros(4), 0.0, 0, 0, None
    while True:
        # At zero slip only the next reversal counts, which goes the other way. It comes within a turn.
        slip.direction = -contact.sign
        span = (start, start + 1.5 * TURN)
        leg = solve_ivp(contact.rates, span, y, events=slip, dense_output=True, first_step=step, max_step=LONGEST, **common)
        if leg.status != 1:
            raise ArithmeticError(leg.message)
        end = leg.t[-1]
        # Quarter periods in the leg; one that falls on its end belongs to it.
        upto = min(last, int((end + TURN * turns) / QUARTER + 1e-12))
        if upto > done:
            inside = leg.sol(QUARTER * (numpy.arange(done + 1, upto + 1) - 4 * turns))
            force[done + 1 : upto + 1], share[done + 1 : upto + 1] = inside[2], inside[3]
            done = upto
            if done == last:
                return force, share
        y = leg.y[:, -1].copy()
        y[1] = -contact.sliding
        contact.sign = -contact.sign
        # The last step was cut by the reversal.
        steps = numpy.diff(leg.t)
        step = min(steps[-2] if len(steps) > 1 else steps[-1], FIRST)
        start = end
        if end >= TURN:
            start, turns = end - TURN, turns + 1


def answer(request):
    """One run."""
    began = perf_counter()
    force, share = (from_reversal_to_reversal if request["events"] else plain)(request)
    wall = perf_counter() - began
    middle = 2 * request["periods"]
    return {"mean": 2 * (share[-1] - share[middle]), "forces": force.tolist(), "wall_ns": 1e9 * wall}


def main():
    """Answers until standard input ends."""
    print(json.dumps({"scipy": scipy.__version__, "python": sys.version.split()[0]}), flush=True)
    for line in sys.stdin:
        try:
            reply = answer(json.loads(line))
        except (ArithmeticError, ValueError) as error:
            reply = {"failure": str(error)}
        print(json.dumps(reply), flush=True)


if __name__ == "__main__":
    main()
