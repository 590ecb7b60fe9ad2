"""Every result of the elastic couplings of a shaft line: path, unit, axes, long name."""

from vibecalc.core.results.record import PLACE, Entry, Headline, entry

# ----------------------------------------------------------------------------
# What couplings bear, next to what their makers permit. Torques are of the coupling's own shaft.
# ----------------------------------------------------------------------------

COUPLING = "response/torsion/coupling"
HEALTHY = "response/torsion/healthy/coupling"
CONDITIONS = "response/torsion/conditions/coupling"
_EACH, _HERE = "coupling coupling_limit", "at the operating speed"
_USE = "share of what the maker permits; 0: the coupling has no such limit"


#: of what a coupling bears, that of which the largest at any speed is searched
LARGEST = ("peak_torque", "vibratory_torque", "torque_by_orders", "power_loss", "temperature")


def _borne(place: str, axes: str, words: str, only: tuple[str, ...] = ()) -> tuple[Entry, ...]:
    rows = (
        ("mean_torque", "N*m", "steady torque"),
        ("peak_torque", "N*m", "largest magnitude over the cycle, mean torque in it"),
        ("vibratory_torque", "N*m", "half range of all orders"),
        ("torque_by_orders", "N*m",
         "root of the sum of squares of the orders, each times its frequency factor"),
        ("main_frequency", "rad/s", "of the order of the largest torque"),
        ("power_loss", "W", "mean, of all orders"),
        ("temperature", "K", "of the element, 0: not known"),
    )  # fmt: skip
    return tuple(
        entry(f"{place}/{name}", axes, unit, f"{long_name}, {words}",
              exempt=PLACE if name == "main_frequency" else "")
        for name, unit, long_name in rows
        if name in (only or (name,))
    )  # fmt: skip


COUPLING_ENTRIES = (
    *_borne(COUPLING, "coupling", _HERE),
    entry(f"{COUPLING}/stiffness", "coupling half_order", "N*m/rad",
          f"dynamic, at the frequency of the order, {_HERE}"),
    entry(f"{COUPLING}/loss_factor", "coupling half_order", "",
          f"relative damping over 2 pi, at the frequency of the order, {_HERE}"),
    entry(f"{COUPLING}/mode_stiffness", "coupling mode", "N*m/rad",
          f"dynamic, at the undamped natural frequency of the mode, {_HERE}"),
    entry(f"{COUPLING}/use", _EACH, "", f"{_USE}, {_HERE}",
          headline=Headline("use of a coupling at speed, largest")),
    *_borne(f"{COUPLING}/speeds", "coupling speed", "over the speeds"),
    *_borne(f"{COUPLING}/largest", "coupling", "the largest at any speed", LARGEST),
    *(
        entry(f"{COUPLING}/largest/{one}_speed", "coupling", "rad/s", "where that is", exempt=PLACE)
        for one in LARGEST
    ),
    entry(f"{COUPLING}/speeds/use", f"{_EACH} speed", "", _USE),
    entry(f"{COUPLING}/largest_use", _EACH, "", f"{_USE}, the largest at any speed",
          headline=Headline("use of a coupling over the speeds, largest",
                            at=f"{COUPLING}/largest_use_speed")),
    entry(f"{COUPLING}/largest_use_speed", _EACH, "rad/s", "where that is", exempt=PLACE),
    entry(f"{HEALTHY}/use", _EACH, "", f"{_USE}, {_HERE}, all cylinders firing"),
    entry(f"{HEALTHY}/largest_use", _EACH, "",
          f"{_USE}, the largest at any speed, all cylinders firing"),
    entry(f"{HEALTHY}/largest_use_speed", _EACH, "rad/s", "where that is", exempt=PLACE),
    entry(f"{CONDITIONS}/use", f"condition {_EACH}", "", f"{_USE}, {_HERE}"),
    entry(f"{CONDITIONS}/largest_use", f"condition {_EACH}", "",
          f"{_USE}, the largest at any speed",
          headline=Headline("use of a coupling, worst condition",
                            at=f"{CONDITIONS}/largest_use_speed")),
    entry(f"{CONDITIONS}/largest_use_speed", f"condition {_EACH}", "rad/s", "where that is",
          exempt=PLACE),
)  # fmt: skip

#: axis name -> (unit, long name)
COUPLING_AXES = {
    "coupling": ("", "elastic coupling of the line"),
    "coupling_limit": ("", "limit of a coupling by DIN 740-2"),
}
