"""Results of the body on its suspension, and of the change between two operations."""

from vibecalc.core.results.record import (
    CANCELS,
    ORDERS,
    PEAK,
    PLACE,
    RESONANCE,
    TURN,
    Headline,
    entry,
)

# ----------------------------------------------------------------------------
# Results of the body on its suspension: modes, motion, energies.
# ----------------------------------------------------------------------------

_LEADING = ("kinetic", "reversal")
#: with mounts at known places the force on each says more than the sum
_SUPPORTS = "isolation/support_force/steady_peak"


def _leading(which: str, *rest: str) -> Headline | None:
    """Of a family of results the one that stands in the first table."""
    return Headline(*rest) if which in _LEADING else None


RESPONSE_ENTRIES = (
    entry("response/modes/natural_frequency", "mode", "rad/s", "undamped natural frequency",
          headline=Headline("natural frequency", "Hz", pick="ends",
                            unless="isolation/modes/natural_frequency")),
    entry("response/modes/damping_ratio", "mode", "", "modal damping ratio"),
    entry(
        "response/modes/shape", "mode coordinate", "",
        "mode shape at the reference point, metres and radians, of unit modal mass",
    ),
    entry(
        "response/modes/energy_fraction", "mode coordinate", "",
        "share of the kinetic energy of a mode, about the mass centre",
    ),
    entry(
        "response/modes/assurance", "mode other_mode", "",
        "modal assurance criterion, rotations times their radius of inertia",
    ),
    entry(
        "response/modes/nearest_order", "mode", "",
        "excited order nearest to a mode at operating speed",
    ),
    entry(
        "response/modes/distance", "mode", "",
        "frequency of that order over the natural frequency, less 1",
    ),
    entry(
        "response/translation_harmonics", "order direction", "m",
        "displacement of the reference point", PEAK,
    ),
    entry("response/rotation_harmonics", "order direction", "rad", "rotation", PEAK),
    entry("response/translation_peak", "direction", "m", "largest over a turn", PEAK,
          headline=Headline("motion of the body, peak", "mm")),
    entry("response/rotation_peak", "direction", "rad", "largest over a turn", PEAK,
          headline=Headline("rotation of the body, peak", "mrad")),
    entry("response/ground_force", "order direction", "N", "force on the ground", PEAK),
    entry("response/ground_couple", "order direction", "N*m", "couple on the ground", PEAK),
    entry("response/ground_force_peak", "direction", "N", "largest over a turn", PEAK,
          headline=Headline("force on the ground, peak", "N", unless=_SUPPORTS)),
    entry("response/ground_couple_peak", "direction", "N*m", "largest over a turn", PEAK,
          headline=Headline("couple on the ground, peak", "N*m", unless=_SUPPORTS)),
    *(
        item
        for kind in ("kinetic", "potential")
        for item in (
            entry(
                f"response/{kind}_energy/mean_by_order", "order", "J",
                f"mean {kind} energy of one order over its cycle",
            ),
            entry(
                f"response/{kind}_energy/peak_by_order", "order", "J",
                f"largest {kind} energy of one order alone",
            ),
            entry(f"response/{kind}_energy/mean", "", "J", f"mean {kind} energy over a turn",
                  headline=_leading(kind, "kinetic energy, mean", "J")),
            entry(f"response/{kind}_energy/peak", "", "J", f"largest {kind} energy over a turn",
                  headline=_leading(kind, "kinetic energy, peak", "J")),
            entry(
                f"response/operations/{kind}_energy/mean", "operation balance", "J",
                f"mean {kind} energy over a turn",
            ),
            entry(
                f"response/operations/{kind}_energy/peak", "operation balance", "J",
                f"largest {kind} energy over a turn",
            ),
            entry(
                f"response/operations/{kind}_energy/mean_low", "operation balance", "J",
                f"mean {kind} energy, weights at the best angle to the pistons",
            ),
            entry(
                f"response/operations/{kind}_energy/mean_high", "operation balance", "J",
                f"mean {kind} energy, weights at the worst angle to the pistons",
            ),
            entry(
                f"response/operations/{kind}_energy/peak_low", "operation balance", "J",
                f"largest {kind} energy, weights at the best angle to the pistons",
            ),
            entry(
                f"response/operations/{kind}_energy/peak_high", "operation balance", "J",
                f"largest {kind} energy, weights at the worst angle to the pistons",
            ),
            entry(
                f"response/operations/{kind}_energy/rotating_mean", "operation balance", "J",
                f"mean {kind} energy of throws and balance weights, without pistons, "
                "counterweights and shafts",
            ),
            entry(
                f"response/operations/{kind}_energy/rotating_peak", "operation balance", "J",
                f"largest {kind} energy of throws and balance weights, without pistons, "
                "counterweights and shafts",
            ),
            entry(
                f"response/operations/{kind}_energy/difference", "balance", "J",
                f"largest less smallest mean {kind} energy of the operations",
            ),
            entry(
                f"response/operations/{kind}_energy/weighted", "balance", "J",
                f"mean {kind} energy, weighted over the operations",
            ),
            entry(
                f"response/run_up/{kind}_energy", "speed", "J",
                f"mean {kind} energy over a turn at each speed",
            ),
        )
    ),
    entry("response/masked/low", "masked", "rad/s", "last speed computed below"),
    entry("response/masked/centre", "masked", "rad/s", "speed of the undamped resonance"),
    entry("response/masked/high", "masked", "rad/s", "first speed computed above"),
    entry("response/masked/order", "masked", "", "order in resonance"),
    entry("response/masked/mode", "masked", "", "mode in resonance"),
)  # fmt: skip

# ----------------------------------------------------------------------------
# Results of the change between two operations.
# ----------------------------------------------------------------------------

SWITCHING_ENTRIES = (
    *(
        item
        for way, how in (("instant", "at once"), ("reversal", "by reversal"))
        for item in (
            entry(
                f"response/switching/{way}/translation_peak", "change direction", "m",
                "largest displacement of the reference point on the way", PEAK,
                headline=Headline(f"motion in a change {how}, peak", "mm"),
            ),
            entry(
                f"response/switching/{way}/rotation_peak", "change direction", "rad",
                "largest rotation on the way", PEAK,
            ),
            entry(
                f"response/switching/{way}/ground_force_peak", "change direction", "N",
                "largest force on the ground on the way", PEAK,
                headline=_leading(way, "force on the ground in it, peak", "N"),
            ),
            entry(
                f"response/switching/{way}/ground_couple_peak", "change direction", "N*m",
                "largest couple on the ground on the way", PEAK,
            ),
            entry(
                f"response/switching/{way}/kinetic_energy_peak", "change", "J",
                "largest kinetic energy on the way",
            ),
            entry(
                f"response/switching/{way}/potential_energy_peak", "change", "J",
                "largest potential energy on the way",
            ),
            entry(
                f"response/switching/{way}/peak_time", "change", "s",
                "time of the largest kinetic energy", exempt=PLACE,
            ),
            entry(
                f"response/switching/{way}/peak_speed", "change", "rad/s",
                "crank speed at that time, negative after reversal", exempt=PLACE,
            ),
            entry(
                f"response/switching/{way}/settle_time", "change", "s",
                "time from the end of the change until the motion has settled",
            ),
            entry(
                f"response/switching/{way}/kinetic_energy_high", f"change {way}_time", "J",
                "largest sample of the kinetic energy in each interval of time",
            ),
            entry(
                f"response/switching/{way}/translation_high", f"change direction {way}_time", "m",
                "largest sample of the displacement in each interval of time",
            ),
            entry(
                f"response/switching/{way}/translation_low", f"change direction {way}_time", "m",
                "smallest sample of the displacement in each interval of time",
            ),
        )
    ),
    entry(
        "response/switching/reversal/speed", "change reversal_time", "rad/s",
        "crank speed, negative after reversal",
    ),
    entry(
        "response/switching/reversal/slow_kinetic_energy", "change", "J",
        "largest kinetic energy if the same speeds were passed infinitely slowly",
    ),
    entry("response/switching/passage/change", "passage", "", "number of the change, from 1"),
    entry("response/switching/passage/mode", "passage", "", "mode that is met"),
    entry("response/switching/passage/order", "passage", "", "order that meets it"),
    entry("response/switching/passage/speed", "passage", "rad/s", "crank speed there"),
    entry("response/switching/passage/time", "passage", "s", "time from the start of the change"),
    entry(
        "response/switching/passage/haste", "passage", "",
        "order times acceleration over (damping ratio times frequency) squared; above 1 the "
        "resonance has no time to build up",
    ),
    entry(
        "response/switching/steady_energy", "operation", "J",
        "largest kinetic energy of the steady state",
    ),
    entry(
        "response/switching/instant/worst_angle", "change", "rad",
        "crank angle of the change that gives the largest kinetic energy", exempt=PLACE,
        circle=TURN),
    entry(
        "response/switching/instant/worst_kinetic_energy_peak", "change", "J",
        "largest kinetic energy over all crank angles of the change",
    ),
)  # fmt: skip

#: axis name -> (unit, long name)
AXES = {
    "other_mode": ("", "mode it is held against"),
    "operation": ("", "cylinders that work"),
    "balance": ("", "throws that weights cancel"),
    "change": ("", "from one operation to the other"),
    "instant_time": ("s", "end of an interval of time"),
    "reversal_time": ("s", "end of an interval of time"),
    "passage": ("", "meeting of an order and a mode, the first is 1"),
}
ENTRIES = (
    *RESPONSE_ENTRIES,
    *SWITCHING_ENTRIES,
)
HELPS = {
    "response/": (ORDERS, RESONANCE),
    "response/modes/": (CANCELS,),
    "response/switching/": (ORDERS,),
}
