"""SciPy's solve_ivp on the case, as a server: one JSON request a line on standard input, one JSON answer a line on standard output.

A request holds the scaled coefficients (scaled.rs), the length of the run, the method, whether reversals are events, the longest step
and the tolerance. An answer holds the mean, the state at the end, and the wall time of the loop around solve_ivp, most of which is
Python: the right-hand side, events and step control. The first line, before any request, says which version answers.

With events, an integration ends at a reversal: the sign flips as a discrete state, the slip is set to zero exactly, and the next one
begins on a clock of its own, with the step that the last one had. Without, the sign is in the right-hand side.
"""

import json
import sys
from math import copysign, cos, exp, pi
from time import perf_counter_ns

import numpy
import scipy
from scipy.integrate import solve_ivp

TURN = 2 * pi
# No step may hold two reversals, which would go unnoticed, nor the first one after a reversal a further one.
LONGEST, FIRST = TURN / 6, TURN / 8
IMPLICIT = {"LSODA", "Radau", "BDF"}


class Contact:
    """The equations, with the sign of the slip held while it is not None."""

    def __init__(self, scaled, sign):
        for name, value in scaled.items():
            setattr(self, name, value)
        self.sign, self.phase, self.frequency, self.passed = sign, 0.0, self.start, 0.0

    def level(self, slip):
        """Stribeck level and its slope."""
        if self.excess == 0:
            return 1.0, 0.0
        part = slip / self.stribeck
        peak = self.excess * exp(-part * part)
        return 1.0 + peak, -2.0 * part / self.stribeck * peak

    def bristle(self, slip, f):
        """Rate of the bristles."""
        sign = copysign(1.0, slip) if self.sign is None else self.sign
        return self.kappa * slip * (1.0 - sign * f / self.level(slip)[0])

    def force(self, y):
        """Friction over Fc."""
        slip = self.sliding + y[1]
        return y[2] + self.damping * self.bristle(slip, y[2]) + self.viscous * slip

    def rates(self, time, y):
        x, v, f, _ = y.tolist()
        slip = self.sliding + v
        bristle = self.bristle(slip, f)
        force = f + self.damping * bristle + self.viscous * slip
        phase = self.phase + time * (self.frequency + 0.5 * self.rate * time)
        return (v, self.forcing * cos(phase) - self.spring * x - self.friction * force, bristle, self.share * force)

    def jacobian(self, _time, y):
        _, v, f, _ = y.tolist()
        slip = self.sliding + v
        sign = copysign(1.0, slip) if self.sign is None else self.sign
        level, slope = self.level(slip)
        by_slip = self.kappa * (1.0 - sign * f / level * (1.0 - slip * slope / level))
        by_bristle = -self.kappa * sign * slip / level
        force_by_slip, force_by_bristle = self.damping * by_slip + self.viscous, 1.0 + self.damping * by_bristle
        return numpy.array((
            (0.0, 1.0, 0.0, 0.0),
            (-self.spring, -self.friction * force_by_slip, -self.friction * force_by_bristle, 0.0),
            (0.0, by_slip, by_bristle, 0.0),
            (0.0, self.share * force_by_slip, self.share * force_by_bristle, 0.0),
        ))

    def advance(self, time):
        """Start the next leg later by this time."""
        self.phase = (self.phase + time * (self.frequency + 0.5 * self.rate * time)) % TURN
        self.passed += time
        self.frequency = self.start + self.rate * self.passed


def solve(request):
    """The contact at the end, and the states at the middle and there."""
    events = request["events"]
    contact = Contact(request["scaled"], 1.0 if events else None)
    common = {"method": request["method"], "rtol": request["tolerance"], "atol": request["tolerance"]}
    if request["method"] in IMPLICIT:
        common["jac"] = contact.jacobian
    if events or request["longest"]:
        common["max_step"] = request["longest"] or LONGEST

    def slip(_time, y):
        return contact.sliding + y[1]

    slip.terminal = True
    y, step, states = numpy.zeros(4), None, []
    for mark in (0.5 * request["length"], request["length"]):
        while True:
            # At zero slip only the next reversal counts, which goes the other way.
            slip.direction = -contact.sign if events else 0.0
            left = mark - contact.passed
            first = min(step, left) if step else None
            leg = solve_ivp(contact.rates, (0.0, left), y, events=slip if events else None, first_step=first, **common)
            if leg.status < 0:
                raise ArithmeticError(leg.message)
            y = leg.y[:, -1].copy()
            contact.advance(leg.t[-1])
            if leg.status == 0:
                break
            y[1] = -contact.sliding
            contact.sign = -contact.sign
            # The last step was cut by the reversal.
            steps = numpy.diff(leg.t)
            step = min(steps[-2] if len(steps) > 1 else steps[-1], FIRST)
        states.append(y.copy())
    return contact, states


def answer(request):
    """One run."""
    began = perf_counter_ns()
    contact, (middle, end) = solve(request)
    wall = perf_counter_ns() - began
    return {"mean": 2 * (end[3] - middle[3]), "end": [end[0], end[1], contact.force(end)], "wall_ns": wall}


def main():
    """Answers until standard input ends."""
    print(json.dumps({"version": f"SciPy {scipy.__version__}"}), flush=True)
    for line in sys.stdin:
        try:
            reply = answer(json.loads(line))
        except (ArithmeticError, ValueError) as error:
            reply = {"failure": str(error)}
        print(json.dumps(reply), flush=True)


if __name__ == "__main__":
    main()
