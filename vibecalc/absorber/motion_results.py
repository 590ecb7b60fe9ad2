"""Results of an absorber in units: motions and forces by frequency; tunings within a band."""

from collections.abc import Iterator

from vibecalc.absorber.readings import OF_ABSORBER
from vibecalc.core.results.record import CHECK, EXAMINED, PEAK, PLACE, Entry, Headline, entry

# ----------------------------------------------------------------------------
# Motions in m and forces in N, or angles and torques, for an amplitude of the excitation.
# ----------------------------------------------------------------------------

MOTION_ROOT = "response/absorber/motion"
#: what is read -> its name, unit, unit that people read, words; in translation, in torsion
TRANSLATION = {
    "displacement": ("displacement", "m", "mm", "displacement"),
    "velocity": ("velocity", "m/s", "mm/s", "velocity"),
    "acceleration": ("acceleration", "m/s^2", "m/s^2", "acceleration"),
    "deflection": ("deflection", "m", "mm", "deflection"),
    "transmitted_force": ("transmitted_force", "N", "N", "force on the ground"),
    "travel": ("travel", "m", "mm", "travel of the absorber"),
    "spring_force": ("spring_force", "N", "N", "force in the spring of the absorber"),
    "damper_force": ("damper_force", "N", "N", "force in the damper of the absorber"),
}
TORSION = {
    "displacement": ("angle", "rad", "deg", "angle"),
    "velocity": ("angular_velocity", "rad/s", "rad/s", "angular velocity"),
    "acceleration": ("angular_acceleration", "rad/s^2", "rad/s^2", "angular acceleration"),
    "transmitted_force": ("transmitted_torque", "N*m", "N*m", "torque on the ground"),
    "travel": ("twist", "rad", "deg", "twist of the absorber"),
    "spring_force": ("spring_torque", "N*m", "N*m", "torque in the spring of the absorber"),
    "damper_force": ("damper_torque", "N*m", "N*m", "torque in the damper of the absorber"),
}
_FIRST = ("displacement", "deflection", *OF_ABSORBER, "transmitted_force", "acceleration")


#: without the absorber, and with it within the band that it is tuned for
WITHOUT_ROOT, IN_BAND_ROOT = f"{MOTION_ROOT}/without", f"{MOTION_ROOT}/in_band"
_IN_BAND = "within the band of [tuning]"


def _rows(table: dict[str, tuple[str, str, str, str]]) -> Iterator[Entry]:
    for key, (name, unit, read, words) in table.items():
        if key in OF_ABSORBER:
            yield from _entries(key, name, unit, read, words)
            yield from _entries(key, f"each/{name}", unit, read, words, axis="absorber")
        else:
            whose = "" if key == "transmitted_force" else " of the primary"
            yield from _entries(key, name, unit, read, words + whose, bare=True)


def _entries(
    key: str, name: str, unit: str, read: str, words: str, bare: bool = False, axis: str = ""
) -> Iterator[Entry]:
    """A curve, its largest and where that is; also without absorbers, or of each of several."""
    banded, first = f"{IN_BAND_ROOT}/{name}", key in _FIRST
    pick = "each" if axis else "largest"
    for root, without in ((MOTION_ROOT, ""), (WITHOUT_ROOT, ", without the absorber")):
        if without and not bare:
            continue
        yield entry(f"{root}/{name}", f"{axis} excitation_frequency".strip(), unit,
                    f"{words} by frequency, complex{without}", PEAK)  # fmt: skip
        head = Headline(f"{words}, largest", read, pick, at=f"{MOTION_ROOT}/largest_at/{name}",
                        unless=banded)  # fmt: skip
        yield entry(f"{root}/largest/{name}", axis, unit,
                    f"largest {words} over the frequency range{without}", PEAK,
                    headline=head if first and not without else None)  # fmt: skip
        yield entry(f"{root}/largest_at/{name}", axis, "Hz",
                    f"frequency at which that is{without}", exempt=PLACE)  # fmt: skip
    head = Headline(f"{words}, in band", read, pick, at=f"{IN_BAND_ROOT}/at/{name}")
    yield entry(banded, axis, unit, f"largest {words} {_IN_BAND}", PEAK,
                headline=head if first else None)  # fmt: skip
    yield entry(f"{IN_BAND_ROOT}/at/{name}", axis, "Hz", "frequency at which that is",
                exempt=PLACE)  # fmt: skip


# ----------------------------------------------------------------------------
# A tuning within a band, and one that allows for tolerances.
# ----------------------------------------------------------------------------

BAND_ROOT = "tuning/band"
TOLERANCES_ROOT = "tuning/tolerances"
OPTIMUM_ROOT = "tuning/optimum"

_BEST = (
    ("stiffness_ratio", "best stiffness of the absorber over that of the primary"),
    ("damping_over_primary_critical", "best damping of the absorber, c2 / (2 sqrt(K1 J1))"),
)
_WORST = "largest response in the band in the worst case of the tolerances"
BAND_ENTRIES = (
    entry(f"{BAND_ROOT}/from", "", "", "lower end of the band, over the primary's own frequency"),
    entry(f"{BAND_ROOT}/to", "", "", "upper end of the band, over the primary's own frequency"),
    entry(f"{BAND_ROOT}/residual", "", "",
        "remainder of the gradients: 0 for an optimum", exempt=CHECK, diagnostic=True),
    entry(f"{TOLERANCES_ROOT}/nominal_peak", "", "",
        "largest response in the band with nominal parts",
        headline=Headline("largest response with nominal parts")),
    entry(f"{TOLERANCES_ROOT}/worst_peak", "", "", _WORST),
    entry(f"{TOLERANCES_ROOT}/inside_peak", "", "",
        "largest response in the band of parts drawn between the tolerances", exempt=EXAMINED),
    entry(f"{TOLERANCES_ROOT}/deviation", "active toleranced", "",
        "deviations of the states with the governing peaks, relative"),
    *(entry(f"{OPTIMUM_ROOT}/{name}", "", "", f"{words}, next to a given frequency")
        for name, words in (*_BEST, ("peak", "least largest response in the band"))),
    *(entry(f"{TOLERANCES_ROOT}/exact/{name}", "", "", f"{words}, tuned for nominal parts")
        for name, words in (*_BEST, ("nominal_peak", "largest response in the band"),
                            ("worst_peak", _WORST))),
)  # fmt: skip
MOTION_ENTRIES = (*_rows(TRANSLATION), *_rows(TORSION))

AXES = {
    "excitation_frequency": ("Hz", "frequency"),
    "toleranced": ("", "part with a tolerance"),
}
