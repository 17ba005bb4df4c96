import os
import signal
import threading
import time

import numpy as np
import pytest

import sonoglide
from sonoglide import RunError, Scene, SceneError


def test_a_contact_has_its_metrics_signals_and_figures():
    result = Scene.load("contact").run()
    assert result.passed and result["friction_ratio"] == pytest.approx(0.674942, abs=1e-6)
    time_s, friction_n = (result.signals[name].values for name in ("time_s", "friction_n"))
    assert time_s.shape == friction_n.shape and np.all(np.diff(time_s) > 0)
    assert result.signals["friction_n"].unit == "N" and not friction_n.flags.writeable
    figure = next(iter(result.figures.values()))
    assert figure.svg.startswith("<svg") and len(figure.data) >= 2
    assert "<svg" in result._repr_html_()


def test_a_driven_scene_locks_and_its_values_can_be_changed():
    lock = Scene.load("lock")
    slow = lock.with_values({"stack.bvd.q": 100, "controller.tracking.mode": "zero_phase"})
    assert slow.to_dict()["stack"]["bvd"]["q"] == 100 and lock.to_dict()["stack"]["bvd"]["q"] != 100
    result = slow.run()
    assert result["fault_code"] == 0 and result.summary["drive_hash"]
    assert set(result.signals["mode"].values) >= {"Scan", "Run"}
    assert result.signals["time_s"].values.size == result.signals["mode"].values.size


def test_a_scene_from_a_dictionary_or_text():
    scene = Scene.load("contact-kinematic")
    again = Scene.from_dict(scene.to_dict())
    assert again.to_dict() == scene.to_dict() == Scene.from_toml(scene.to_toml()).to_dict()
    assert again.run().metrics == scene.run().metrics


def test_errors_name_their_place():
    with pytest.raises(SceneError, match=r"contact\.dahl\.mu"):
        Scene.load("contact", {"contact.dahl.mux": 0.1})
    with pytest.raises(SceneError, match="experiment-1"):
        Scene.load("experiment-11")
    with pytest.raises(SceneError, match="no_such_key"):
        Scene.from_toml('base = "contact"\nno_such_key = 1\n')
    with pytest.raises(ValueError):
        Scene.from_dict({"base": "contact", "duration_s": "long"})
    with pytest.raises(TypeError, match="object"):
        Scene.load("contact", {"duration_s": object()})
    with pytest.raises(KeyError, match="friction_ratio"):
        Scene.load("contact-kinematic").run()["frictoin_ratio"]


def test_numpy_values_are_accepted():
    scene = Scene.load("contact", {"excitation.velocity_ratio": np.float64(0.25), "integrator.window_periods": np.array([10, 20])})
    assert scene.to_dict()["excitation"]["velocity_ratio"] == 0.25
    assert scene.to_dict()["integrator"]["window_periods"] == [10, 20]


def test_a_folder_matches_the_command_line(tmp_path):
    folder = tmp_path / "run"
    Scene.load("contact-kinematic").run(folder)
    assert {"manifest.json", "summary.json", "report.html", "trace.csv"} <= {path.name for path in folder.iterdir()}
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "manifest.json").write_text("{}")
    with pytest.raises(RunError, match="is not a manifest of sim-host"):
        Scene.load("contact-kinematic").run(tmp_path / "other")


def test_other_threads_run_during_a_scene():
    ticks, done = 0, threading.Event()

    def run() -> None:
        Scene.load("lock").run()
        done.set()

    thread = threading.Thread(target=run)
    thread.start()
    while not done.is_set():
        ticks += 1
        time.sleep(0.001)
    thread.join()
    assert ticks > 10


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_a_forked_child_runs_and_sweeps_after_its_parent():
    scene = Scene.load("contact")
    ratio = scene.run()["friction_ratio"]
    child = os.fork()
    if child == 0:
        signal.alarm(60)  # ends a child that waits for ever
        sweep = Scene.load("contact-kinematic").sweep({"contact.dahl.mu": [0.1, 0.2]}, metrics=["friction_ratio"])
        os._exit(0 if scene.run()["friction_ratio"] == ratio and len(sweep["friction_ratio"]) == 2 else 1)
    assert os.waitpid(child, 0)[1] == 0


def test_a_signal_ends_a_run():
    def raised(*_: object) -> None:
        raise KeyboardInterrupt

    former = signal.signal(signal.SIGALRM, raised)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        began = time.monotonic()
        with pytest.raises(KeyboardInterrupt):
            Scene.load("lock", {"duration_s": 60}).run()
        assert time.monotonic() - began < 5
    finally:
        signal.signal(signal.SIGALRM, former)


def test_a_kinematic_scene_has_little_overhead():
    scene = Scene.load("contact-kinematic")
    scene.run()
    began = time.process_time()
    for _ in range(20):
        scene.run()
    # Includes tables and the data of figures, on a machine that may be busy.
    assert (time.process_time() - began) / 20 < 0.05


def test_several_runs_have_their_statistics():
    result = Scene.load("lock-cold", {"runs": 3}).run()
    assert result["runs_completed"] == 3 and result["lock_time_20hz_ms_p95"] >= result["lock_time_20hz_ms"]


def test_names_are_explained():
    assert "experiment-1" in sonoglide.scenes()
    assert {"friction_ratio", "lock_time_20hz_ms"} <= {metric.name for metric in sonoglide.metrics()}
    assert "friction_ratio: metric" in sonoglide.explain("friction_ratio")
    with pytest.raises(KeyError, match="friction_ratio"):
        sonoglide.explain("frictoin_ratio")
