import pytest

from sonoglide import Scene, SceneError


def test_solve_finds_the_roots_of_the_command_line():
    contact = Scene.load("contact-kinematic")
    found = contact.solve({"friction_ratio": 0.5}, by={"excitation.velocity_ratio": "0.05:0.95"})
    (root,) = found["roots"]
    again = contact.with_values({"excitation.velocity_ratio": root["value"]}).run()
    assert again["friction_ratio"] == pytest.approx(0.5, abs=1e-9) == root["metrics"]["friction_ratio"]
    with pytest.raises(SceneError, match="there is no metric"):
        contact.solve({"friction_ration": 0.5}, by={"excitation.velocity_ratio": "0.05:0.95"})
    with pytest.raises(ValueError, match="`by` has 2 entries"):
        contact.solve({"friction_ratio": 0.5}, by={"a": "0:1", "b": "0:1"})


def test_optimise_of_a_design_meets_its_limit():
    found = Scene.load("langevin").optimise(
        minimise="drive_power_w",
        over={"design.element.0.length_m": "0.02:0.03", "design.element.3.length_m": "0.04:0.06"},
        subject_to=["series_resonance_hz>=28e3"],
        runs=400,
    )
    assert found["within_limits"] and found["best"]["metrics"]["series_resonance_hz"] == pytest.approx(28e3, rel=1e-4)
    with pytest.raises(ValueError, match="either"):
        Scene.load("langevin").optimise(over={})


def test_signals_become_tables():
    signals = Scene.load("contact").run().signals
    pandas = pytest.importorskip("pandas")
    frame = signals.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and frame.attrs["units"]["friction_n"] == "N" and list(frame) == list(signals)
    xarray = pytest.importorskip("xarray")
    data = signals.to_xarray()
    assert isinstance(data, xarray.Dataset) and data["friction_n"].attrs["units"] == "N" and data["friction_n"].dims == ("time_s",)


def test_a_plot_is_drawn_on_given_axes():
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot

    axes = matplotlib.pyplot.subplots()[1]
    assert Scene.load("contact").run().plot("friction_n", axes=axes) is axes
    assert axes.get_xlabel() == "time_s [s]" and axes.get_ylabel() == "[N]" and len(axes.lines) == 1
