"""Results of the body on its suspension: modes, motion, energies."""

from vibecalc.pipeline.entries.entry import PEAK, entry

ENTRIES = (
    entry("response/modes/natural_frequency", "mode", "rad/s", "undamped natural frequency"),
    entry("response/modes/damping_ratio", "mode", "", "modal damping ratio"),
    entry(
        "response/modes/shape", "mode coordinate", "",
        "mode shape, metres and radians, of unit modal mass",
    ),
    entry(
        "response/modes/energy_fraction", "mode coordinate", "",
        "share of the kinetic energy of a mode",
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
    entry("response/translation_peak", "direction", "m", "largest over a turn", PEAK),
    entry("response/rotation_peak", "direction", "rad", "largest over a turn", PEAK),
    entry("response/ground_force", "order direction", "N", "force on the ground", PEAK),
    entry("response/ground_couple", "order direction", "N*m", "couple on the ground", PEAK),
    entry("response/ground_force_peak", "direction", "N", "largest over a turn", PEAK),
    entry("response/ground_couple_peak", "direction", "N*m", "largest over a turn", PEAK),
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
            entry(f"response/{kind}_energy/mean", "", "J", f"mean {kind} energy over a turn"),
            entry(f"response/{kind}_energy/peak", "", "J", f"largest {kind} energy over a turn"),
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
