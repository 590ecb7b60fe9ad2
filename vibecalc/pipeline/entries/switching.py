"""Results of the change between two operations."""

from vibecalc.pipeline.entries.entry import PEAK, entry

ENTRIES = (
    *(
        item
        for way, axes in (("instant", "change"), ("reversal", "change"))
        for item in (
            entry(
                f"response/switching/{way}/translation_peak", f"{axes} direction", "m",
                "largest displacement of the reference point on the way", PEAK,
            ),
            entry(
                f"response/switching/{way}/rotation_peak", f"{axes} direction", "rad",
                "largest rotation on the way", PEAK,
            ),
            entry(
                f"response/switching/{way}/ground_force_peak", f"{axes} direction", "N",
                "largest force on the ground on the way", PEAK,
            ),
            entry(
                f"response/switching/{way}/ground_couple_peak", f"{axes} direction", "N*m",
                "largest couple on the ground on the way", PEAK,
            ),
            entry(
                f"response/switching/{way}/kinetic_energy_peak", axes, "J",
                "largest kinetic energy on the way",
            ),
            entry(
                f"response/switching/{way}/potential_energy_peak", axes, "J",
                "largest potential energy on the way",
            ),
            entry(
                f"response/switching/{way}/peak_time", axes, "s",
                "time of the largest kinetic energy",
            ),
            entry(
                f"response/switching/{way}/peak_speed", axes, "rad/s",
                "crank speed at that time, negative after reversal",
            ),
            entry(
                f"response/switching/{way}/settle_time", axes, "s",
                "time from the end of the change until the motion has settled",
            ),
            entry(
                f"response/switching/{way}/kinetic_energy_high", f"{axes} {way}_time", "J",
                "largest sample of the kinetic energy in each interval of time",
            ),
            entry(
                f"response/switching/{way}/translation_high", f"{axes} direction {way}_time", "m",
                "largest sample of the displacement in each interval of time",
            ),
            entry(
                f"response/switching/{way}/translation_low", f"{axes} direction {way}_time", "m",
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
        "crank angle of the change that gives the largest kinetic energy",
    ),
    entry(
        "response/switching/instant/worst_kinetic_energy_peak", "change", "J",
        "largest kinetic energy over all crank angles of the change",
    ),
)  # fmt: skip
