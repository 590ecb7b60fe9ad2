"""Results of vibration at points: by order, peak and r.m.s., over the run-up, and its severity."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from vibecalc.core.results.described import entries_of, q
from vibecalc.core.results.record import ORDERS, PEAK, RESONANCE, RMS, Entry, Headline, entry

#: the unit of each, in SI and as people read it
UNITS = {
    "displacement": ("m", "um"),
    "velocity": ("m/s", "mm/s"),
    "acceleration": ("m/s^2", "m/s^2"),
}

# ----------------------------------------------------------------------------
# At the operating speed.
# ----------------------------------------------------------------------------


@dataclass(frozen=True)
class AtPoints:
    """Readings at the points, and how severe they are."""

    ROOT: ClassVar[str] = "points"
    displacement: Any = q("sensor order", "m", "displacement at a point, by order", PEAK)
    velocity: Any = q("sensor order", "m/s", "velocity at a point, by order", PEAK)
    acceleration: Any = q("sensor order", "m/s^2", "acceleration at a point, by order", PEAK)
    displacement_peak: Any = q(
        "sensor", "m", "largest displacement over the cycle, all orders", PEAK,
        name="displacement at a point, peak",
    )  # fmt: skip
    velocity_peak: Any = q(
        "sensor", "m/s", "largest velocity over the cycle, all orders", PEAK,
        name="velocity at a point, peak",
    )  # fmt: skip
    acceleration_peak: Any = q(
        "sensor", "m/s^2", "largest acceleration over the cycle, all orders", PEAK,
        name="acceleration at a point, peak",
    )  # fmt: skip
    displacement_rms: Any = q(
        "sensor", "m", "displacement of the orders in the band", RMS,
        name="displacement at a point, r.m.s.",
    )  # fmt: skip
    velocity_rms: Any = q(
        "sensor", "m/s", "velocity of the orders in the band", RMS,
        name="velocity at a point, r.m.s.",
        headline=Headline(
            "velocity at a point, r.m.s.", "mm/s", words="vibecalc.points.report:zone_words"
        ),
    )  # fmt: skip
    acceleration_rms: Any = q(
        "sensor", "m/s^2", "acceleration of the orders in the band", RMS,
        name="acceleration at a point, r.m.s.",
    )  # fmt: skip
    severity: Any = q(
        "sensor", "m/s",
        "velocity whose grade displacement, velocity and acceleration all keep (10 and 250 Hz)",
        RMS, name="severity",
    )  # fmt: skip
    zone: Any = q(
        "sensor", "", "boundaries of zones exceeded by one of the three: 0 in the best zone"
    )


@dataclass(frozen=True)
class Boundaries:
    """Boundaries of the zones."""

    ROOT: ClassVar[str] = "points/zone_boundary"
    displacement: Any = q("zone_limit", "m", "displacement between two zones", RMS)
    velocity: Any = q("zone_limit", "m/s", "velocity between two zones", RMS)
    acceleration: Any = q("zone_limit", "m/s^2", "acceleration between two zones", RMS)


# ----------------------------------------------------------------------------
# In the run-up.
# ----------------------------------------------------------------------------

RUN_UP = "points/run_up"


def _of_run_up(name: str, kind: str) -> Iterator[Entry]:
    """Of one quantity, `kind` of which is its peak or its r.m.s."""
    si, read = UNITS[name]
    amplitude, words = (PEAK, "peak") if kind == "peak" else (RMS, "r.m.s.")
    path, said = f"{RUN_UP}/{name}_{kind}", f"{name} in the run-up, {words}"
    each = f"{'largest ' * (kind == 'peak')}{name} at each speed"
    yield entry(path, "sensor speed", si, each, amplitude, name=said)
    head = Headline("velocity in the run-up, r.m.s.", read, at=f"{path}_largest_speed")
    yield entry(
        f"{path}_largest", "sensor", si, f"largest of the run-up of {name}, {words}", amplitude,
        name=f"{said}, largest", headline=head if (name, kind) == ("velocity", "rms") else None,
    )  # fmt: skip
    yield entry(f"{path}_largest_speed", "sensor", "rad/s", "crank speed of the largest")


@dataclass(frozen=True)
class SeverityInRunUp:
    """Severity over the speed."""

    ROOT: ClassVar[str] = RUN_UP
    severity: Any = q("sensor speed", "m/s", "severity at each speed", RMS)
    severity_largest: Any = q(
        "sensor", "m/s", "largest severity of the run-up", RMS,
        name="severity in the run-up, largest",
    )  # fmt: skip
    severity_largest_speed: Any = q("sensor", "rad/s", "crank speed of the largest")


AXES = {
    "sensor": ("", "sensor"),
    "zone_limit": ("", "between zones, from the best on"),
}
ENTRIES = (
    *entries_of(AtPoints, Boundaries),
    *(one for name in UNITS for kind in ("peak", "rms") for one in _of_run_up(name, kind)),
    *entries_of(SeverityInRunUp),
)
HELPS = {f"{AtPoints.ROOT}/": (ORDERS, RESONANCE)}
