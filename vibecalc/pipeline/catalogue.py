"""Every result path with its unit, axes, amplitude kind and long name: said once, here.

Adapters hand over arrays and errors under these paths; the file, the report, references, limits
and `check` read the rest from this table.
"""

from typing import NamedTuple

#: axis name -> (unit, long name)
AXES: dict[str, tuple[str, str]] = {
    "order": ("", "multiple of crank speed"),
    "direction": ("", "axis of the machine"),
    "cylinder": ("", "cylinder"),
    "mount": ("", "mount"),
    "speed": ("rad/s", "crank speed"),
    "mode": ("", "mode, lowest first"),
    "coordinate": ("", "coordinate of the rigid body"),
    "crank_angle": ("rad", "crank angle"),
    "frequency_ratio": ("", "excitation frequency over natural frequency"),
    "masked": ("", "interval of speeds left out"),
}


class Entry(NamedTuple):
    """What is known of a quantity before it is computed."""

    path: str
    axes: tuple[str, ...]
    unit: str
    long_name: str
    amplitude: str | None = None


def _entry(path: str, axes: str, unit: str, long_name: str, amplitude: str | None = None) -> Entry:
    return Entry(path, tuple(axes.split()), unit, long_name, amplitude)


PEAK = "0-pk"

_ENTRIES = (
    _entry("kinematics/position_harmonics", "order", "m", "harmonics of piston position", PEAK),
    _entry(
        "kinematics/acceleration_harmonics", "order", "m/s^2",
        "harmonics of piston acceleration at operating speed", PEAK,
    ),
    _entry(
        "kinematics/dropped_acceleration", "", "m/s^2",
        "sum of the acceleration that the chosen series or order leaves out", PEAK,
    ),
    _entry("kinematics/position", "crank_angle", "m", "piston position from the crank axis"),
    _entry("kinematics/velocity", "crank_angle", "m/s", "piston velocity"),
    _entry("kinematics/acceleration", "crank_angle", "m/s^2", "piston acceleration"),
    _entry("excitation/force", "order direction", "N", "force on the body", PEAK),
    _entry("excitation/couple", "order direction", "N*m", "couple on the body", PEAK),
    _entry("excitation/force_peak", "direction", "N", "largest force over a turn", PEAK),
    _entry("excitation/couple_peak", "direction", "N*m", "largest couple over a turn", PEAK),
    _entry("excitation/balance/sine", "order cylinder", "", "sin(n a)"),
    _entry("excitation/balance/cosine", "order cylinder", "", "cos(n a)"),
    _entry("excitation/balance/position_sine", "order cylinder", "m", "z sin(n a)"),
    _entry("excitation/balance/position_cosine", "order cylinder", "m", "z cos(n a)"),
    _entry("excitation/balance/total_sine", "order", "", "sum of sin(n a)"),
    _entry("excitation/balance/total_cosine", "order", "", "sum of cos(n a)"),
    _entry("excitation/balance/total_position_sine", "order", "m", "sum of z sin(n a)"),
    _entry("excitation/balance/total_position_cosine", "order", "m", "sum of z cos(n a)"),
    _entry("excitation/residual", "", "N", "weighted residual of forces and couples", PEAK),
    _entry("isolation/pitch/inertia", "", "kg*m^2", "moment of inertia in pitch"),
    _entry("isolation/pitch/stiffness", "", "N*m/rad", "stiffness of the mounts in pitch"),
    _entry("isolation/pitch/damping", "", "N*m*s/rad", "viscous damping of the mounts in pitch"),
    _entry("isolation/pitch/natural_frequency", "", "rad/s", "undamped natural frequency in pitch"),
    _entry("isolation/pitch/damping_ratio", "", "", "damping ratio in pitch"),
    _entry("isolation/pitch/transmissibility", "order", "", "couple on the ground over couple"),
    _entry(
        "isolation/pitch/transmissibility_curve", "frequency_ratio", "",
        "couple on the ground over couple against frequency",
    ),
    _entry("isolation/pitch/angle_harmonics", "order", "rad", "pitch angle", PEAK),
    _entry("isolation/pitch/angle_peak", "", "rad", "largest pitch angle over a turn", PEAK),
    _entry("isolation/modes/natural_frequency", "mode", "rad/s", "undamped natural frequency"),
    _entry("isolation/modes/damping_ratio", "mode", "", "modal damping ratio"),
    _entry(
        "isolation/modes/shape", "mode coordinate", "",
        "mode shape, metres and radians, of unit modal mass",
    ),
    _entry(
        "isolation/modes/energy_fraction", "mode coordinate", "",
        "share of the kinetic energy of a mode",
    ),
    _entry(
        "isolation/body/translation_harmonics", "order direction", "m",
        "displacement of the reference point", PEAK,
    ),
    _entry("isolation/body/rotation_harmonics", "order direction", "rad", "rotation", PEAK),
    _entry(
        "isolation/lever_force/rigid_harmonics", "order", "N",
        "couple over lever, body held still", PEAK,
    ),
    _entry(
        "isolation/lever_force/rigid_peak", "", "N",
        "largest couple over lever over a turn, body held still", PEAK,
    ),
    _entry(
        "isolation/lever_force/steady_harmonics", "order", "N",
        "couple through the mounts over lever", PEAK,
    ),
    _entry(
        "isolation/lever_force/steady_peak", "", "N",
        "largest couple through the mounts over lever", PEAK,
    ),
    _entry(
        "isolation/lever_force/run_up", "speed", "N",
        "largest couple through the mounts over lever at each speed", PEAK,
    ),
    _entry("isolation/lever_force/run_up_peak", "", "N", "largest of the run-up", PEAK),
    _entry("isolation/lever_force/run_up_peak_speed", "", "rad/s", "crank speed of the largest"),
    _entry("isolation/support_force/static", "mount", "N", "share of the weight on one support"),
    _entry(
        "isolation/support_force/rigid_peak", "mount", "N",
        "largest dynamic force of one support over a turn, body held still", PEAK,
    ),
    _entry(
        "isolation/support_force/steady_harmonics", "mount direction order", "N",
        "dynamic force of one support on the ground", PEAK,
    ),
    _entry(
        "isolation/support_force/steady_peak", "mount", "N",
        "largest dynamic force of one support over a turn", PEAK,
    ),
    _entry(
        "isolation/support_force/run_up", "mount speed", "N",
        "largest dynamic force of one support at each speed", PEAK,
    ),
    _entry("isolation/support_force/run_up_peak", "mount", "N", "largest of the run-up", PEAK),
    _entry(
        "isolation/support_force/run_up_peak_speed", "mount", "rad/s", "crank speed of the largest"
    ),
    _entry("isolation/support_displacement/sag", "mount", "m", "deflection under its own weight"),
    _entry(
        "isolation/support_displacement/steady_harmonics", "mount direction order", "m",
        "displacement of the body at a support", PEAK,
    ),
    _entry(
        "isolation/support_displacement/vertical_peak", "mount", "m",
        "largest vertical displacement at a support over a turn", PEAK,
    ),
    _entry(
        "isolation/support_displacement/excursion", "mount", "m",
        "sag plus largest vertical displacement", PEAK,
    ),
    _entry("isolation/masked/low", "masked", "rad/s", "last speed computed below"),
    _entry("isolation/masked/centre", "masked", "rad/s", "speed of the undamped resonance"),
    _entry("isolation/masked/high", "masked", "rad/s", "first speed computed above"),
    _entry("isolation/masked/order", "masked", "", "order in resonance"),
    _entry("isolation/masked/mode", "masked", "", "mode in resonance"),
)  # fmt: skip

CATALOGUE: dict[str, Entry] = {entry.path: entry for entry in _ENTRIES}
