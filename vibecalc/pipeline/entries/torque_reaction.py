"""Results of an engine on its mounts under the torque of its cylinders, with what shakes it."""

from vibecalc.pipeline.entries.entry import PEAK, entry

ROOT = "isolation/torque_reaction"

ENTRIES = (
    entry(
        f"{ROOT}/couple", "half_order", "N*m",
        "couple on the body about the crankshaft by gas and inertia torque", PEAK,
    ),
    entry(f"{ROOT}/mean_couple", "", "N*m", "its mean; 0 where the driven machine is on the body"),
    entry(
        f"{ROOT}/translation", "half_order direction", "m",
        "displacement of the reference point, with the shaking", PEAK,
    ),
    entry(f"{ROOT}/rotation", "half_order direction", "rad", "rotation, with the shaking", PEAK),
    entry(
        f"{ROOT}/roll_peak", "", "rad",
        "largest angle about the crankshaft over the cycle, without the mean", PEAK,
    ),
    entry(
        f"{ROOT}/support_force", "mount direction half_order", "N",
        "dynamic force of one support on the ground, with the shaking", PEAK,
    ),
    entry(
        f"{ROOT}/support_force_peak", "mount", "N",
        "largest dynamic force of one support over the cycle, with the shaking", PEAK,
    ),
    entry(
        f"{ROOT}/support_force_of_torque", "mount", "N",
        "the same by the couple of the torque alone", PEAK,
    ),
    entry(
        f"{ROOT}/mean_support_force", "mount direction", "N",
        "force of one support on the ground by the mean torque",
    ),
    entry(
        f"{ROOT}/largest_load", "mount", "N",
        "largest load on a support over the cycle: weight, mean torque and dynamic force",
    ),
    entry(
        f"{ROOT}/least_load", "mount", "N",
        "least load over the cycle; negative: the support is pulled",
    ),
    entry(
        f"{ROOT}/nearest_order", "mode", "",
        "half order nearest to a mode of the body of those that drive it; 0: none does",
    ),
    entry(
        f"{ROOT}/margin", "mode", "",
        "frequency of that order over the natural frequency, less 1",
    ),
)  # fmt: skip
