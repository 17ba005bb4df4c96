"""The firmware's controller finds and tracks a resonator in twenty lines of Python: replace it by your model.

    u = Rm i + Lm di/dt + 1/Cm integral i dt, in parallel with C0; the voltage is held between samples
"""

import numpy as np

from sonoglide import Board, Controller, Scene, Sensed

controller = Controller(Scene.load("lock", {"controller.burst.on_s": [0.0], "controller.burst.off_s": [9.0]}))

hz, q, rm, c0 = 39.6e3, 100.0, 3.08, 300e-9
step_s, lm = 1 / controller.sample_hz, q * rm / (2 * np.pi * hz)
# State: current and voltage of Cm; exact over one sample.
matrix = np.array([[-rm / lm, -1 / lm], [(2 * np.pi * hz) ** 2 * lm, 0.0]])
values, vectors = np.linalg.eig(matrix)
move = (vectors @ np.diag(np.exp(values * step_s)) @ np.linalg.inv(vectors)).real
drive = np.linalg.solve(matrix, (move - np.eye(2)) @ [1 / lm, 0.0])
state, last = np.zeros(2), 0.0


def plant(codes, lane):
    """Plays one block, and returns the codes of voltage and current."""
    global state, last
    volts = controller.to_volts(codes[0])
    current = np.empty_like(volts)
    for n, v in enumerate(volts):
        state = move @ state + drive * v
        current[n] = state[0] + c0 * (v - last) / step_s
        last = v
    return Sensed(*controller.to_codes(volts, current))


board = Board(controller, plant)
for _ in range(6000):
    telemetry = board.tick().telemetry
print(f"{telemetry.mode}: {telemetry.frequency_hz:.1f} Hz, resonance of the model {hz:.1f} Hz")
# The current is sampled half a step after the held voltage, which shifts the zero of the phase.
assert telemetry.mode == "Run" and telemetry.locked and abs(telemetry.frequency_hz - hz) < 0.25 * hz / q
