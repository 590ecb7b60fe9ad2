"""Results of isolation efficiency: what acts on the body, what reaches the ground, their ratio."""

from collections.abc import Iterator

from vibecalc.core.results.record import PEAK, RMS, SPECTRUM, Entry, Headline, entry

ROOT = "isolation/efficiency"
FORCES, COUPLES = f"{ROOT}/force", f"{ROOT}/couple"
AXES = {
    "component": ("", "component, or the length of the vector"),
    "frequency": ("Hz", "frequency"),
}


def _of_vector(path: str, what: str, unit: str, about: str = "") -> Iterator[Entry]:
    orders = "half_order coordinate"
    for name, words in (
        ("held", f"{what}{about} that the body held still would send into the ground"),
        ("ground", f"{what}{about} of all mounts on the ground"),
    ):
        yield entry(f"{path}/{name}", orders, unit, words, PEAK)
        yield entry(f"{path}/{name}_rms", "", unit, f"{words}, over the cycle", RMS)
        yield entry(f"{path}/{name}_peak", "", unit, f"{words}, largest over the cycle", PEAK)
    yield entry(
        f"{path}/by_order",
        "half_order component",
        "",
        f"1 - {what} on the ground over that of the body held still",
    )
    for name, words in (("rms", "r.m.s."), ("peak", "peak")):
        yield entry(
            f"{path}/{name}",
            "",
            "",
            f"the same of the {words} of all orders",
            headline=Headline(f"isolation of the {what}, {words}") if name == "rms" else None,
        )
        yield entry(
            f"{path}/{name}_level",
            "",
            "dB",
            f"held still over on the ground, {words} of all orders",
            exempt=SPECTRUM,
        )


EFFICIENCY_ENTRIES = (
    *_of_vector(FORCES, "force", "N"),
    *_of_vector(COUPLES, "couple", "N*m", " about the mass centre"),
    entry(f"{ROOT}/by_direction", "coordinate", "", "efficiency of the r.m.s. in each direction"),
    entry(
        f"{ROOT}/transmissibility",
        "coordinate frequency",
        "",
        "load on the ground over a load of one size at all frequencies",
    ),
)
