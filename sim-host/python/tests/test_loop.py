import time

import numpy as np
import pytest

from sonoglide import Board, Controller, Plant, Scene, SceneError


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


def test_orders_and_mistakes():
    controller = Controller(Scene.load("lock"))
    silence = np.zeros(controller.block_samples, np.uint16)
    with pytest.raises(SceneError, match="no \\[controller\\]"):
        Controller(Scene.load("contact"))
    for wrong in [np.zeros(31, np.uint16), np.zeros((2, 16), np.uint16), silence.astype(float), silence.astype(int) - 1, silence.astype(int) + 70000]:
        with pytest.raises(ValueError, match="codes"):
            controller.process(wrong, silence)
    for wrong in [np.zeros((0, 32), np.uint16), np.zeros((2, 32), np.uint16), silence]:
        with pytest.raises(ValueError):
            Plant(Scene.load("lock")).step(wrong)
    for order in [lambda: controller.drive(-1.0), lambda: controller.drive(float("nan")), lambda: controller.drive(1, motional_a=1)]:
        with pytest.raises(ValueError):
            order()
    with pytest.raises(ValueError, match="no \\[controller.friction\\]"):
        controller.set_friction(0.5)
    with pytest.raises(ValueError, match="from 0 to 1"):
        Controller(Scene.load("friction-ratio")).set_friction(1.5)


def test_a_cleared_fault_allows_another_attempt():
    scene = Scene.load("lock", {"controller.burst.on_s": [0.0], "controller.burst.off_s": [9.0]})
    controller, plant = Controller(scene), Plant(scene)
    broken = False

    def sometimes_broken(codes, lane):
        sensed = plant.step(codes, lane)
        return sensed._replace(v=np.full_like(sensed.v, 100)) if broken else sensed

    board = Board(controller, sometimes_broken)
    run = lambda blocks: [board.tick() for _ in range(blocks)][-1].telemetry  # noqa: E731
    assert run(4000).locked
    broken = True
    assert run(100).fault == 20
    broken = False
    controller.stop(clear_fault=True)
    assert run(20).fault == 0
    controller.drive(2.0)
    telemetry = run(4000)
    assert telemetry.fault == 0 and telemetry.locked and telemetry.drive_v == pytest.approx(2.0, rel=0.02)
    controller.drive()
    assert run(200).drive_v == pytest.approx(3.0, rel=0.02)


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
