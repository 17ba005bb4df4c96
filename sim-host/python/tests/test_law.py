import math

import pytest

from sonoglide import Law, Scene, SceneError


def lugre(k, ratio, vs, s1, fc):
    def rates(v, z, sign, coulomb):
        assert coulomb == pytest.approx(fc)
        rate = v - k * sign * v * z[0] / (fc * (1 + (ratio - 1) * math.exp(-((v / vs) ** 2))))
        return [rate], k * z[0] + s1 * rate

    return Law(rates, [0.0])


LUGRE = {
    "contact.lugre.mu": 0.3,
    "contact.lugre.static_mu": 0.39,
    "contact.lugre.normal_n": 20,
    "contact.lugre.stiffness_n_per_m": 2e6,
    "contact.lugre.stribeck_m_per_s": 0.02,
    "contact.lugre.sigma1": 1.0,
    "grid": False,
}


def test_a_law_in_python_equals_the_built_in_one():
    scene = Scene.load("contact-kinematic", LUGRE)
    own, native = scene.run(law=lugre(2e6, 1.3, 0.02, 1.0, 6.0)), scene.run()
    assert own["friction_ratio"] == pytest.approx(native["friction_ratio"], abs=own["error_estimate"] + native["error_estimate"])
    assert own["tolerance_met"] == 1 and len(own.signals["friction_n"].values) > 90
    with pytest.raises(SceneError, match="without grid"):
        scene.with_values({"contact.lugre.mu": {"value": 0.3, "sd": 0.01}}).run(law=Law(lambda v, z, sign, fc: ([], fc)))


def test_a_mistake_in_a_law_is_the_error():
    scene = Scene.load("contact-kinematic", LUGRE)
    with pytest.raises(ZeroDivisionError):
        scene.run(law=Law(lambda v, z, sign, fc: ([], fc / 0)))
    with pytest.raises(SceneError, match="returns 1 rates, but has 0 states"):
        scene.run(law=Law(lambda v, z, sign, fc: ([0.0], fc)))
    with pytest.raises(TypeError):
        scene.run(law=Law(lambda v, z, sign, fc: None))
