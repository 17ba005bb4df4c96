"""Map a contact: how much does friction drop, over the velocity ratio and the stiffness of the contact? At which velocity ratio is it halved?"""

import numpy as np

from sonoglide import Scene

contact = Scene.load("contact-kinematic", {"contact.dahl.mu": 0.2})
sweep = contact.sweep(
    {
        "excitation.velocity_ratio": np.linspace(0.05, 0.95, 37),
        "contact.dahl.stiffness_n_per_m": "1e4:1e9:16:log",
    },
    metrics=["friction_ratio"],
)
ratio = sweep["friction_ratio"].reshape(sweep.shape)
speed, stiffness = (np.unique(sweep[key]) for key in sweep.keys_swept)

print("contact stiffness [N/m]   velocity ratio at half the friction")
for column, stiffness_n_per_m in enumerate(stiffness):
    # The friction ratio grows with the sliding speed, so the inverse can be interpolated.
    halved = np.interp(0.5, ratio[:, column], speed, left=np.nan, right=np.nan)
    print(f"{stiffness_n_per_m:24.3g}   {halved:.3f}")

# A contact that is stiff against the vibration follows Coulomb's law: r = (2 / pi) asin(velocity ratio).
coulomb = 2 / np.pi * np.arcsin(speed)
off = np.max(np.abs(ratio[:, -1] - coulomb))
print(f"the stiffest contact is within {off:.3f} of Coulomb's law")
assert off < 0.02, "the limit of a stiff contact is Coulomb's law"
print(f"rows, figures and report: {sweep.folder} (deleted when this program ends; output='my-map' keeps them)")
