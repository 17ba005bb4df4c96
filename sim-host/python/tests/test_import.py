import numpy as np
import pytest

from sonoglide import MeasurementError, import_admittance, import_conditions, import_friction


def sweep(path, noise=1e-3, second_ohm=np.inf):
    hz = np.linspace(39.5e3, 40.5e3, 201)
    branch = 50 * (1 + 1j * 120 * (hz / 40e3 - 40e3 / hz))
    second = 1 / second_ohm / (1 + 1j * 400 * (hz / 40.2e3 - 40.2e3 / hz))
    z = 1 / (1 / branch + second + 2j * np.pi * hz * 4e-9)
    random = np.random.default_rng(1)
    z *= 1 + noise * (random.standard_normal(hz.size) + 1j * random.standard_normal(hz.size))
    np.savetxt(path, np.column_stack([hz, z.real, z.imag]), delimiter=",", header="f [Hz],R [ohm],X [ohm]", comments="")
    return path


def test_an_admittance_is_a_circuit_with_deviations_and_a_scene(tmp_path):
    found = import_admittance(sweep(tmp_path / "mine.csv"))
    q, rm = found.circuit["q"], found.circuit["rm_ohm"]
    assert abs(q.value - 120) < 4 * q.sd and abs(rm.value - 50) < 4 * rm.sd and float(q) == q.value
    assert found.frequency_hz.shape == found.measured_s.shape == found.fitted_s.shape == found.residual.shape == (201,)
    assert np.max(np.abs(found.fitted_s / found.measured_s - 1)) < 0.01 and 0.8 < np.std(found.residual.real) < 1.2
    matrix = found.correlation.matrix
    assert found.correlation.names == list(found.circuit) and matrix.shape == (9, 9)
    assert np.allclose(matrix, matrix.T) and np.allclose(np.diag(matrix), 1) and np.all(np.linalg.eigvalsh(matrix) > -1e-6)
    assert found.modes[0]["working"] and found.scene().to_dict()["stack"]["bvd"]["rm_ohm"] == pytest.approx(rm.value, rel=1e-3)


def test_a_mode_is_chosen_and_a_misfit_has_a_scene_by_force_only(tmp_path):
    path = sweep(tmp_path / "two.csv", second_ohm=200)
    assert import_admittance(path, mode=40.2e3).circuit["rm_ohm"].value == pytest.approx(200, rel=0.05)
    assert import_admittance(path, modes=1).scene_toml is None and import_admittance(path, modes=1, force=True).scene() is not None


def test_a_friction_log_is_a_contact(tmp_path):
    time = np.arange(600) * 0.01
    friction = np.where((time >= 2) & (time < 4), 0.5, 1.5) * (1 + 0.01 * np.random.default_rng(2).standard_normal(time.size))
    path = tmp_path / "log.csv"
    np.savetxt(path, np.column_stack([time, 1e-2 * time, friction]), delimiter=",", header="t [s],x [m],F [N]", comments="")
    found = import_friction(path, normal_n=5, on_s=[(2, 4)], frequency_hz=40e3)
    mu = found.contact.parameters["mu"]
    assert mu.value == pytest.approx(0.3, rel=0.02) and found.on_fit["conditions"][0]["measured"] == pytest.approx(1 / 3, rel=0.02)
    assert import_friction(path, normal_n=5).scene_toml is None
    off = ~found.on
    assert found.on.sum() == 200 and np.sqrt(np.mean(found.residual_n[off] ** 2)) == pytest.approx(found.contact.rms_n, rel=1e-6)
    assert found.scene().to_dict()["excitation"] and {model.model for model in found.models} >= {"coulomb", "dahl"}


def test_several_files_are_conditions(tmp_path):
    # Coulomb friction under vibration along the sliding: 2 / pi asin(v / tip).
    for speed in (0.05, 0.1, 0.15):
        for state, ratio in (("off", 1.0), ("on", 2 / np.pi * np.arcsin(speed / 0.25))):
            noise = 1 + 0.01 * np.random.default_rng(int(1000 * speed)).standard_normal(40)
            rows = "\n".join(f"{3 * ratio * factor}" for factor in noise)
            (tmp_path / f"speed={speed}mps_{state}.csv").write_text(f"F [N]\n{rows}\n")
    files = sorted(tmp_path.glob("*.csv"))
    found = import_conditions(files, normal_n=10, frequency_hz=40e3, predict=["speed=0.12"])
    assert found.fit["mu"]["value"] == pytest.approx(0.3, rel=0.03) and len(found.conditions) == 3
    assert found.predictions[0]["fit"]["value"] == pytest.approx(2 / np.pi * np.arcsin(0.12 / 0.25), rel=0.1)
    with pytest.raises(ValueError, match="predict"):
        import_conditions(files, normal_n=10, predict=["colour=red"])
    with pytest.raises(MeasurementError, match="ON"):
        import_conditions([file for file in files if "off" in file.name], normal_n=10)


def test_refusals_match_the_command_line(tmp_path):
    path = sweep(tmp_path / "mine.csv")
    with pytest.raises(MeasurementError, match="cannot be read"):
        import_admittance(tmp_path / "none.csv")
    text = path.read_text().splitlines()
    (tmp_path / "equal.csv").write_text("\n".join([text[0], text[1], text[1], text[1], *text[2:]]))
    with pytest.raises(MeasurementError, match="equal.csv: neighbouring frequencies are equal: lines 2 and 3"):
        import_admittance(tmp_path / "equal.csv")
    with pytest.raises(MeasurementError, match="unit missing"):
        import_friction(tmp_path / "mine.csv", columns="t [s], x, F [N]")
    with pytest.raises(ValueError, match="furlong"):
        import_admittance(path, units=["furlong"])
    with pytest.raises(ValueError, match="mode: give the number of a mode"):
        import_admittance(path, mode=9)
    with pytest.raises(ValueError, match="one-port"):
        import_admittance(path, topology="both")
