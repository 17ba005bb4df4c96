"""heyoka's adaptive Taylor integrator on the case, by its Python binding: one JSON request a line in, one JSON answer a line out.

The equations are compiled by heyoka (LLVM); Python only asks for two stretches of time and answers events, by a callback each. A
reversal is a terminal event whose callback flips the held sign, a parameter. Compiled integrators are kept: `jit_ns` says what one cost,
and is not in `wall_ns`. `events` chooses what is measured:

    flip      the case itself
    idle      callbacks that do nothing: what events cost without the flip (not a solution)
    far     an event that is never reached: what looking for it costs (not a solution)
    none      no events (not a solution)

With a Stribeck curve, `edges` adds terminal events where the slip is so many Stribeck velocities: a step that begins there sees the
narrow peak ahead in its series, and does not leap over it.
"""

import json
import sys
from math import exp
from time import perf_counter, perf_counter_ns

import heyoka as hy

KEPT = {}
# A velocity that nothing ever has.
FAR = 50.0


def equations(c, phasor):
    """Rates of x, v, f, q and, as a phasor, of cosine and sine of the forcing; scaled.rs has the equations."""
    x, v, f, q, cosine, sine = hy.make_vars("x", "v", "f", "q", "c", "s")
    slip = c["sliding"] + v
    frequency = c["start"] + c["rate"] * hy.time if c["rate"] else c["start"]
    phase = (c["start"] + 0.5 * c["rate"] * hy.time) * hy.time if c["rate"] else c["start"] * hy.time
    bounded = hy.par[0] * f
    if c["excess"]:
        bounded = bounded / (1.0 + c["excess"] * hy.exp(-((slip / c["stribeck"]) ** 2)))
    bristle = c["kappa"] * slip * (1.0 - bounded)
    force = f
    if c["damping"]:
        force = force + c["damping"] * bristle
    if c["viscous"]:
        force = force + c["viscous"] * slip
    forcing = cosine if phasor else hy.cos(phase)
    rates = [(x, v), (v, c["forcing"] * forcing - c["spring"] * x - c["friction"] * force), (f, bristle), (q, c["share"] * force)]
    if phasor:
        rates += [(cosine, -frequency * sine), (sine, frequency * cosine)]
    return rates, slip


def integrator(request):
    """The compiled integrator for a request, the initial state, and the cost of making it."""
    key = json.dumps({name: request[name] for name in ("scaled", "tolerance", "phasor", "events", "edges", "high_accuracy")})
    if key in KEPT:
        return KEPT[key]
    began = perf_counter_ns()
    c, phasor = request["scaled"], request["phasor"]
    rates, slip = equations(c, phasor)
    sign = [None]

    def flip(_integrator, _direction):
        held = sign[0]
        held[0] = -held[0]
        return True

    def idle(_integrator, _direction):
        return True

    events = []
    if request["events"] == "far":
        events.append(hy.t_event(slip + FAR, callback=idle))
    elif request["events"] != "none":
        events.append(hy.t_event(slip, callback=flip if request["events"] == "flip" else idle))
    if request["edges"]:
        edge = request["edges"] * c["stribeck"]
        events.append(hy.t_event(slip * slip - edge * edge, callback=idle))
    start = [0.0] * 4 + ([1.0, 0.0] if phasor else [])
    taylor = hy.taylor_adaptive(
        rates,
        start,
        tol=request["tolerance"],
        pars=[1.0],
        t_events=events,
        compact_mode=False,
        fast_math=True,
        high_accuracy=request["high_accuracy"],
    )
    sign[0] = memoryview(taylor.pars)
    KEPT[key] = taylor, start, perf_counter_ns() - began
    return KEPT[key]


def answer(request):
    """One run."""
    taylor, start, jit_ns = integrator(request)
    taylor.time = 0.0
    taylor.state[:] = start
    taylor.pars[0] = 1.0
    if taylor.with_events:
        taylor.reset_cooldowns()
    longest = request["longest"] or float("inf")
    began = perf_counter_ns()
    taylor.propagate_until(0.5 * request["length"], max_delta_t=longest)
    middle = taylor.state[3]
    outcome = taylor.propagate_until(request["length"], max_delta_t=longest)
    wall_ns = perf_counter_ns() - began
    if outcome[0] != hy.taylor_outcome.time_limit:
        raise ArithmeticError(f"heyoka stopped: {outcome[0]}")
    x, v, f, q = taylor.state[:4].tolist()
    end = [x, v, friction(request["scaled"], taylor.pars[0], v, f)]
    return {"mean": 2 * (q - middle), "end": end, "wall_ns": wall_ns, "jit_ns": jit_ns}


def friction(c, sign, v, f):
    """Friction over Fc in a state, with the sign that the slip has."""
    slip = c["sliding"] + v
    level = 1 + c["excess"] * exp(-((slip / c["stribeck"]) ** 2))
    return f + c["damping"] * c["kappa"] * slip * (1 - sign * f / level) + c["viscous"] * slip


def callback_ns():
    """What one call of such a callback takes in Python by itself."""
    held = memoryview(bytearray(8)).cast("d")

    def flip(_integrator, _direction):
        held[0] = -held[0]
        return True

    count = 100_000
    began = perf_counter()
    for _ in range(count):
        flip(None, 1)
    return 1e9 * (perf_counter() - began) / count


def main():
    """Answers until standard input ends."""
    print(json.dumps({"version": f"heyoka {hy.__version__}", "callback_ns": min(callback_ns() for _ in range(5))}), flush=True)
    for line in sys.stdin:
        try:
            reply = answer(json.loads(line))
        except (ArithmeticError, ValueError) as error:
            reply = {"failure": str(error)}
        print(json.dumps(reply), flush=True)


if __name__ == "__main__":
    main()
