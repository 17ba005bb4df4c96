import time

import numpy as np
import pytest

from sonoglide import Board, Controller, Plant, Scene, SceneError, Sensed


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("lock", {}),
        ("burst", {}),
        ("friction-ratio", {"duration_s": 0.6}),
        ("usm", {"duration_s": 0.05, "controller.burst.on_s": [0.03], "controller.burst.off_s": [0.05]}),
        ("lock", {"fault": [{"kind": "open", "at_s": 0.1}]}),
        ("belt-stop", {"duration_s": 0.25}),
    ],
)
def test_a_loop_plays_the_codes_of_the_run(name, changes):
    scene = Scene.load(name, changes)
    controller, plant = Controller(scene), Plant(scene)
    board = Board(controller, plant.step)
    blocks = int(np.ceil(scene.to_dict()["duration_s"] * controller.sample_hz / controller.block_samples))
    for _ in range(blocks):
        processed = board.tick()
    result = scene.run()
    assert plant.drive_hash == result.summary["drive_hash"]
    assert processed.telemetry.fault == result["fault_code"] and processed.codes.shape == (controller.lanes, controller.block_samples)


def test_a_plant_of_your_own_is_found_and_tracked():
    """A resonator of 39.6 kHz and Q 100 in twenty lines, with exact steps between samples."""
    scene = Scene.load("lock", {"controller.burst.on_s": [0.0], "controller.burst.off_s": [9.0]})
    controller = Controller(scene)
    hz, q, rm, c0 = 39.6e3, 100.0, 3.08, 300e-9
    w, lm = 2 * np.pi * hz, q * rm / (2 * np.pi * hz)
    step_s = 1 / controller.sample_hz
    matrix = np.array([[-rm / lm, -1 / lm], [w**2 * lm, 0.0]])
    values, vectors = np.linalg.eig(matrix)
    move = (vectors @ np.diag(np.exp(values * step_s)) @ np.linalg.inv(vectors)).real
    drive = np.linalg.solve(matrix, (move - np.eye(2)) @ [1 / lm, 0.0])
    state, last = np.zeros(2), 0.0

    def plant(codes, _listen):
        nonlocal state, last
        volts = controller.to_volts(codes[0])
        current = np.empty_like(volts)
        for n, v in enumerate(volts):
            state = move @ state + drive * v
            current[n] = state[0] + c0 * (v - last) / step_s
            last = v
        return Sensed(*controller.to_codes(volts, current))

    board = Board(controller, plant)
    controller.drive(2.0)
    for _ in range(6000):
        telemetry = board.tick().telemetry
    assert telemetry.fault == 0 and telemetry.locked and telemetry.mode == "Run"
    # Half a sample between voltage and current is a part of this plant, and shifts the zero of the phase.
    assert abs(telemetry.frequency_hz - hz) < 0.25 * hz / q
    controller.stop()
    for _ in range(8):
        processed = board.tick()
    assert processed.telemetry.mode == "Idle" and np.array_equal(processed.codes, controller.silence())


def test_orders_and_mistakes():
    controller = Controller(Scene.load("lock"))
    with pytest.raises(SceneError, match="no \\[controller\\]"):
        Controller(Scene.load("contact"))
    with pytest.raises(ValueError, match="31 codes are given, but a block has 32"):
        controller.process(np.zeros(31, np.uint16), np.zeros(32, np.uint16))
    with pytest.raises(ValueError, match="from 0 to 1"):
        controller.friction(1.5)


def test_a_block_takes_less_than_ten_microseconds():
    """The blocks of a run, recorded and processed again, until well after the lock."""
    scene = Scene.load("lock", {"controller.burst.on_s": [0.0], "controller.burst.off_s": [9.0]})
    plant, sensed = Plant(scene), []

    def recorded(codes, lane):
        sensed.append(plant.step(codes, lane))
        return sensed[-1]

    board = Board(Controller(scene), recorded)
    last = [board.tick() for _ in range(5000)][-1]
    assert last.telemetry.locked and last.telemetry.mode == "Run"

    def seconds():
        controller = Controller(scene)
        began = time.perf_counter()
        for v, i, slow in sensed:
            again = controller.process(v, i, slow)
        assert np.array_equal(again.codes, last.codes)
        return time.perf_counter() - began

    best = min(seconds() for _ in range(8)) / len(sensed)
    print(f"{1 / best:.0f} blocks a second")
    assert best < 10e-6
