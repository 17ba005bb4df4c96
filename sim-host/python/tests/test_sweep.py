import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from sonoglide import RunError, Scene, SceneError

OVER = {"excitation.velocity_ratio": "0.1:0.9:9", "contact.dahl.mu": [0.1, 0.2, 0.3]}
KINEMATIC = Scene.load("contact-kinematic")


def test_a_point_equals_a_single_run():
    sweep = KINEMATIC.sweep(OVER, metrics=["friction_ratio"])
    assert sweep.shape == (9, 3) and sweep.keys_swept == list(OVER) and sweep.units["friction_ratio"] == "1"
    ratio = sweep["friction_ratio"].reshape(sweep.shape)
    assert np.all(np.diff(ratio, axis=0) > 0)
    alone = KINEMATIC.with_values({"excitation.velocity_ratio": 0.5, "contact.dahl.mu": 0.2}).run()
    assert ratio[4, 1] == pytest.approx(alone["friction_ratio"], rel=1e-13)


def test_tables_agree_across_libraries():
    sweep = KINEMATIC.sweep(OVER, metrics=["friction_ratio", "power_ratio"])
    for ratio in (
        sweep.to_arrow()["friction_ratio"].to_numpy(),
        sweep.to_pandas()["friction_ratio"].to_numpy(),
        sweep.to_polars()["friction_ratio"].to_numpy(),
    ):
        assert np.array_equal(ratio, sweep["friction_ratio"])


def test_points_may_be_given_or_sampled():
    points = {"contact.dahl.mu": [0.1, 0.25], "excitation.velocity_ratio": [0.3, 0.6]}
    assert np.array_equal(KINEMATIC.sweep(points=points, metrics=["friction_ratio"])["contact.dahl.mu"], [0.1, 0.25])
    sampled = KINEMATIC.sweep({"contact.dahl.mu": "0.1:0.3", "excitation.velocity_ratio": "0.2:0.8"}, draws=16, metrics=["friction_ratio"])
    assert sampled.shape == (64,) and (sampled.folder / "indices.csv").exists()


def test_a_point_without_a_result_has_its_reason():
    sweep = KINEMATIC.sweep({"duration_s": [0.0005, 0.01]}, metrics=["friction_ratio"])
    assert np.isnan(sweep["friction_ratio"][0]) and not np.isnan(sweep["friction_ratio"][1])
    assert sweep.failures[0][0] == 0 and "window_periods" in sweep.failures[0][1]


def test_errors_come_before_any_run(tmp_path: Path):
    for over, metrics, why in [
        ({"contact.dahl.mux": [0.1, 0.2]}, ["friction_ratio"], "contact.dahl.mu"),
        ({"contact.dahl.mu": [0.1, 0.2]}, ["frictoin_ratio"], "friction_ratio"),
        ({"contact.dahl.mu": "0.2:0.1:5"}, ["friction_ratio"], "backwards"),
        ({"contact.dahl.mu": "0:1:1e12"}, ["friction_ratio"], "points"),
    ]:
        with pytest.raises(SceneError, match=why):
            KINEMATIC.sweep(over, metrics=metrics)
    with pytest.raises(ValueError, match="either keys"):
        KINEMATIC.sweep()
    for jobs in (-1, 1025, 10**30):
        with pytest.raises(ValueError, match="1024"):
            KINEMATIC.sweep(OVER, metrics=["friction_ratio"], jobs=jobs)
    KINEMATIC.sweep(OVER, metrics=["friction_ratio"], output=tmp_path / "sweep")
    with pytest.raises(RunError, match="different points"):
        KINEMATIC.sweep({"contact.dahl.mu": [0.1]}, metrics=["friction_ratio"], output=tmp_path / "sweep")


def test_a_scene_can_be_sent_to_another_process():
    scene = pickle.loads(pickle.dumps(KINEMATIC.with_values({"contact.dahl.mu": 0.25})))
    assert scene.to_dict()["contact"]["dahl"]["mu"] == 0.25


def test_a_cluster_that_loses_a_worker_gives_the_same_bytes(tmp_path: Path):
    """Runs in a separate process: a real scheduler and two worker processes on this machine, one of which is killed midway."""
    pytest.importorskip("distributed")
    script = Path(__file__).with_name("cluster.py")
    done = subprocess.run([sys.executable, script, tmp_path], capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "a worker was killed" in done.stdout
    one, cluster = (tmp_path / name for name in ("one", "cluster"))
    for file in ("sweep.parquet", "sweep.csv", "failures.csv", "plan.json"):
        assert (one / file).read_bytes() == (cluster / file).read_bytes(), file
