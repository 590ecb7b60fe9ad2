"""Pictures of absorbers in units: motions and forces by frequency, with and without."""

from vibecalc.absorber.motion_results import MOTION_ROOT, WITHOUT_ROOT
from vibecalc.core.report.canvas import COLOURS
from vibecalc.core.report.curves import Curve, Curves, Panel

_FORCES = ("spring_force", "damper_force", "spring_torque", "damper_torque")


def _panel(label: str, *names: str, height: float = 1.0) -> Panel:
    lines = tuple(
        Curve(f"{root}/{name}", words, {"marker": "", "color": color})
        for name in names
        for root, words, color in (
            (MOTION_ROOT, "with absorber", COLOURS[0]), (WITHOUT_ROOT, "without", COLOURS[1]),
        )
    )  # fmt: skip
    return Panel(label, lines, log="y", height=height, legend={"loc": "best"})


ABSORBER_MOTION = Curves(
    "motions and forces by frequency",
    (
        _panel("primary", "displacement", "angle", height=1.5),
        _panel("primary against ground", "deflection", height=1.5),
        _panel("acceleration", "acceleration", "angular_acceleration"),
        _panel("on the ground", "transmitted_force", "transmitted_torque"),
        Panel(
            "travel",
            tuple(Curve(f"{MOTION_ROOT}/{name}", "", {"marker": ""}) for name in (
                "travel", "twist")),
        ),
        Panel(
            "absorber",
            tuple(
                Curve(f"{MOTION_ROOT}/{name}", name.split("_")[0],
                      {"marker": "", "color": COLOURS[1 + i % 2]})
                for i, name in enumerate(_FORCES)
            ),
            legend={"loc": "best"},
            below="frequency in Hz",
        ),
    ),
)  # fmt: skip
