import numpy as np
import pytest

from sonoglide import MeasurementError, RunError, Scene, SceneError, compare, spectrum, validate


class Bar:
    total = None

    def __init__(self):
        self.moves = []

    def update(self, n):
        self.moves.append(n)


def test_advice_is_that_of_the_command_line():
    advice = Scene.load("lock").advise()
    assert "[controller" in advice["settings"]["snippet"]
    small, large = (Scene.load("lock").advise_amplifier(tip_m=tip) for tip in (1e-7, 2e-7))
    assert large != small
    with pytest.raises(ValueError, match="not both"):
        Scene.load("lock").advise_amplifier(tip_m=1e-7, tip_m_per_s=0.1)
    with pytest.raises(ValueError, match="from 1e-12"):
        Scene.load("lock").advise_amplifier(tip_m=-1e-6)
    with pytest.raises(SceneError):
        Scene.load("contact").advise()


def test_results_are_compared(tmp_path):
    contact = Scene.load("contact-kinematic", {"grid": False})
    contact.run(output=tmp_path / "a")
    contact.with_values({"excitation.velocity_ratio": 0.51}).run(output=tmp_path / "b")
    assert compare(tmp_path / "a", tmp_path / "a").holds
    assert not compare(tmp_path / "a", tmp_path / "b", metrics=["friction_ratio"]).holds
    assert compare(tmp_path / "a", tmp_path / "b", {"friction_ratio": 0.1}, metrics=["friction_ratio"]).holds
    with pytest.raises(RunError):
        compare(tmp_path / "a", tmp_path / "none")


def test_a_spectrum_has_the_tone(tmp_path):
    time_s = np.arange(4000) * 1e-6
    np.savetxt(tmp_path / "tone.csv", np.column_stack([time_s, np.sin(2 * np.pi * 40e3 * time_s)]), delimiter=",", header="time_s,v", comments="")
    found = spectrum(tmp_path / "tone.csv", "v")
    assert found.power.shape == (len(found.time_s), len(found.frequency_hz))
    assert abs(found.frequency_hz[found.power.mean(axis=0).argmax()] - 40e3) < 2e3
    with pytest.raises(MeasurementError):
        spectrum(tmp_path / "none.csv")
    with pytest.raises(ValueError, match="there is no method"):
        spectrum(tmp_path / "tone.csv", method="fourier")


def test_a_suite_is_judged(tmp_path):
    (tmp_path / "suite.toml").write_text(
        """title = "one contact"
scene = "contact-kinematic"

[[case]]
name = "half"
set = ["grid=false"]

[[target]]
metric = "friction_ratio"
max = 0.5
source = "chosen here"
"""
    )
    suite = validate(tmp_path / "suite.toml")
    assert not suite.passed and "friction_ratio" in suite.missed[0]


def test_bars_move_to_their_end():
    run, sweep = Bar(), Bar()
    Scene.load("lock", {"duration_s": 0.5}).run(progress=run)
    assert run.total == 0.5 and sum(run.moves) == pytest.approx(0.5)
    Scene.load("contact-kinematic").sweep({"excitation.velocity_ratio": "0.1:0.9:9"}, metrics=["friction_ratio"], progress=sweep)
    assert sweep.total == 9 and sum(sweep.moves) == 9
