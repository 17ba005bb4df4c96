"""Compare with a measurement: which stiffness of the contact fits measured friction best, and is the fit as good as the measurement?

The measurement is synthetic: friction ratios at seven sliding speeds of a contact with an unknown stiffness, with a noise of 0.01.
Replace it by your own columns.
"""

import numpy as np

from sonoglide import Scene

KEY = "contact.dahl.stiffness_n_per_m"
SD = 0.01

contact = Scene.load("contact-kinematic")
velocity_ratio = np.array([0.1, 0.2, 0.3, 0.45, 0.6, 0.75, 0.9])
secret = contact.with_values({KEY: 83e3}).sweep({"excitation.velocity_ratio": velocity_ratio}, metrics=["friction_ratio"])
measured = secret["friction_ratio"] + SD * np.random.default_rng(1).standard_normal(velocity_ratio.size)

# Every stiffness at every measured point, in one sweep.
sweep = contact.sweep({KEY: "1e4:1e6:401:log", "excitation.velocity_ratio": velocity_ratio}, metrics=["friction_ratio"])
predicted = sweep["friction_ratio"].reshape(sweep.shape)
stiffness = np.unique(sweep[KEY])
chi_squared = np.sum(((predicted - measured) / SD) ** 2, axis=1)
best = int(np.argmin(chi_squared))

# One parameter: all stiffnesses whose chi squared is within 1 of the minimum are within one
# standard deviation.
within = stiffness[chi_squared <= chi_squared[best] + 1]
print(f"stiffness {stiffness[best]:.3g} N/m, one standard deviation from {within[0]:.3g} to {within[-1]:.3g}")
print("velocity ratio   measured   predicted   difference over sd")
for x, m, p in zip(velocity_ratio, measured, predicted[best]):
    print(f"{x:14.2f}   {m:8.3f}   {p:9.3f}   {(m - p) / SD:18.2f}")
freedom = velocity_ratio.size - 1
print(f"chi squared {chi_squared[best]:.1f} for {freedom} degrees of freedom")
assert chi_squared[best] < freedom + 4 * np.sqrt(2 * freedom), "the model does not describe the measurement"
assert np.max(np.abs(np.log(within / 83e3))) < 1.0
