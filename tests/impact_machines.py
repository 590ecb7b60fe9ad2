"""The compressor of Ong (2000, chapter 5) in SI, and its parts with play, for tests."""

import numpy as np

from vibecalc.impact.linkage import Drive, GasForce, Joint, Linkage, Starts, slider_crank_drive

POUND_FORCE, INCH, POUND = 4.4482216152605, 0.0254, 0.45359237
RADIUS, LENGTH, SPEED = 0.5 * INCH, 2.375 * INCH, 361.0
ROD_MASS = 0.131 * 0.625 / 2.375 * POUND
MASS = (0.659 + 0.075) * POUND + ROD_MASS
STIFFNESS, DAMPING = 1e6 * POUND_FORCE / INCH, 0.1 * POUND_FORCE / INCH
CLEARANCE = 1.5e-3 * INCH

# table 5.1, psi every 10 degrees
PRESSURE = np.array(
    [221, 143.1442235, 59.57198292, 22.13792913, 5.926086272]
    + [0] * 14
    + [0.11504243, 0.468925102, 1.089180276, 2.026246059, 3.361576261, 5.222086775, 7.805573134]
    + [11.42632639, 16.6000612, 24.20993436, 35.85102598, 54.5976863, 86.86022257, 147.3088118]
    + [221] * 4
)  # fmt: skip
AREA = np.pi * (1.625 * INCH) ** 2 / 4


def compressor_drive(**options: bool) -> Drive:
    return slider_crank_drive(RADIUS, LENGTH, SPEED, **options)  # type: ignore[arg-type]


def gas_towards(sense: str) -> GasForce:
    """Gas that pushes the piston towards the crank, as gas does, or the head, as printed."""
    sign = {"crank": 1.0, "head": -1.0}[sense]
    force = sign * PRESSURE * POUND_FORCE / INCH**2 * AREA
    return GasForce(np.radians(10.0 * np.arange(37)), force)


def no_gas() -> GasForce:
    return GasForce(np.array([]), np.array([]))


def source_joint(law: str = "continuous", **changes: float) -> Joint:
    values = {
        "clearance": CLEARANCE,
        "stiffness": STIFFNESS,
        "contact_damping": DAMPING,
        "film_damping": DAMPING,
    }
    return Joint(**{k: np.asarray(v) for k, v in (values | changes).items()}, law=law)


def near(count: int, seed: int = 1) -> np.ndarray:
    """Starts a little inside the gap, at rest."""
    return 1e-8 * np.random.default_rng(seed).random(count)


def states(gap: object, velocity: object = 0.0) -> Starts:
    """Starts (B, G), or (B,) of one gap."""
    first = np.asarray(gap, dtype=float)
    both = [np.broadcast_to(one, first.shape) for one in (first, np.asarray(velocity, float))]
    return Starts(*(one[:, None] if one.ndim == 1 else one for one in both))


def source_linkage(sense: str = "crank", joint: Joint | None = None, **parts: object) -> Linkage:
    drive = compressor_drive(with_rod_tangent="bore" in parts)
    rest = {"drive": drive, "gas": gas_towards(sense), "mass": MASS, **parts}
    return Linkage(wrist_pin=joint or source_joint(), **rest)  # type: ignore[arg-type]
