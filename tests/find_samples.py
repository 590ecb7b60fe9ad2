"""The generator with rows of [[find]], and what is known of it in closed form."""

from pathlib import Path

GENERATOR = Path(__file__).resolve().parents[1] / "cases" / "generator.toml"
HEAD = GENERATOR.read_text(encoding="utf-8").split("[[limit]]")[0]
STIFFNESS, DAMPING = "machine.mounts.each.stiffness", "machine.mounts.each.damping"
RADIUS, ROD = "machine.crank_train.crank_radius", "machine.crank_train.rod_length"
PHASE = "machine.crank_train.cylinders[1].crank_phase"
FREQUENCY, FORCE = (
    "isolation/pitch/natural_frequency",
    "isolation/couple_over_lever/steady_peak",
)
RIGID = "isolation/couple_over_lever/blocked_peak"
#: of the uniform block about its pitch axis; four mounts at 0.4 m on both sides
INERTIA, ARMS = 100.0 * (0.8**2 + 0.35**2) / 12.0, 4.0 * 0.4**2


def row(name: str, key: str, lower: str, upper: str, quantity: str, *more: str) -> str:
    lines = [f'name = "{name}"', f'key = "{key}"', f'min = "{lower}"', f'max = "{upper}"']
    lines += [f'quantity = "{quantity}"', *more]
    return "\n[[find]]\n" + "\n".join(lines) + "\n"


def undamped() -> str:
    """The generator without damping and run-up; at speed 500 rad/s."""
    head = HEAD.replace('damping = "50 N*s/m"', "damping = 0").replace("4900 rpm", "500 rad/s", 1)
    return head.split("run_up =")[0] + "\n"
