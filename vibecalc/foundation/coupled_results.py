"""Results of machine and foundation in six freedoms, and of a foundation of tables."""

from collections.abc import Iterator

from vibecalc.core.results.record import PEAK, RMS, Entry, Headline, entry

COUPLED = "foundation/coupled"
AXES = {
    "coupled_mode": ("", "mode of machine and foundation, lowest first"),
    "foundation_frequency": ("Hz", "frequency"),
}
_ORDERS = "half_order direction"


def _loads() -> Iterator[Entry]:
    for name, where in (("ground", "on the ground"), ("rigid", "on a rigid foundation")):
        for what, unit in (("force", "N"), ("couple", "N*m")):
            words = f"{what} {where}"
            yield entry(f"{COUPLED}/{name}/{what}", _ORDERS, unit, words, PEAK)
            head = Headline(f"{words}, r.m.s.", unit) if what == "force" else None
            yield entry(
                f"{COUPLED}/{name}/{what}_rms", "", unit, f"{words}, all orders", RMS, headline=head
            )
            about = "" if what == "force" else " about the origin"
            yield entry(
                f"{COUPLED}/{name}/{what}_efficiency",
                "",
                "",
                f"1 - r.m.s. of the {words}{about} over that of the machine held still",
                headline=Headline(
                    f"isolation of the {what}{about}, r.m.s.",
                    unless=f"isolation/efficiency/{what}/rms",
                )
                if name == "ground"
                else None,
            )
            yield entry(
                f"{COUPLED}/{name}/{what}_by_order",
                "half_order",
                "",
                f"1 - {words} over that of the machine held still",
            )
        yield entry(
            f"{COUPLED}/{name}/transmissibility",
            "coordinate foundation_frequency",
            "",
            f"load {where} over a load of one size on the machine",
        )


ENTRIES = (
    entry(
        f"{COUPLED}/modes/natural_frequency",
        "coupled_mode",
        "rad/s",
        "of machine and foundation, undamped",
        headline=Headline("natural frequency, machine on foundation", "Hz", pick="ends"),
    ),
    entry(f"{COUPLED}/modes/damping_ratio", "coupled_mode", "", "modal damping ratio"),
    entry(
        f"{COUPLED}/modes/machine_share",
        "coupled_mode",
        "",
        "share of the kinetic energy that is in the machine",
    ),
    entry(f"{COUPLED}/body/translation", _ORDERS, "m", "foundation at its reference point", PEAK),
    entry(f"{COUPLED}/body/rotation", _ORDERS, "rad", "rotation of the foundation", PEAK),
    entry(
        f"{COUPLED}/foot",
        "mount direction half_order",
        "m",
        "motion of what a mount stands on",
        PEAK,
    ),
    entry(
        f"{COUPLED}/foot_velocity_rms",
        "mount",
        "m/s",
        "velocity of what a mount stands on, length of the vector, all orders",
        RMS,
        headline=Headline("velocity of the foundation at a mount, r.m.s.", "mm/s"),
    ),
    entry(
        f"{COUPLED}/power",
        "half_order",
        "W",
        "mean power through the mounts into the foundation",
        headline=Headline("power into the foundation, largest order", "W"),
    ),
    *_loads(),
)
