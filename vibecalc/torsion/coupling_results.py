"""Results of elastic couplings of a shaft line: what they bear, next to what makers permit."""

from collections.abc import Iterator

from vibecalc.core.results.record import PLACE, Entry, Headline, entry, under
from vibecalc.torsion.study_results import ROOT

# ----------------------------------------------------------------------------
# What elastic couplings bear, next to what their makers permit.
# ----------------------------------------------------------------------------

COUPLING, HEALTHY = f"{ROOT}/coupling", f"{ROOT}/healthy/coupling"
_CONDITIONS = f"{ROOT}/conditions"
_HERE, _HALF = "at the operating speed", "half range of all orders"
_LIMITED = "coupling coupling_limit"
_USE = "load / permitted by the manufacturer; 0: no such limit"
_BORNE = (
    ("mean_torque", "N*m", "steady torque"),
    ("peak_torque", "N*m", "largest magnitude over the cycle, mean torque included"),
    ("vibratory_torque", "N*m", _HALF),
    ("torque_by_orders", "N*m",
     "root of the sum of squares of the orders, each times its frequency factor"),
    ("main_frequency", "rad/s", "of the order of the largest torque"),
    ("power_loss", "W", "mean, of all orders"),
    ("temperature", "K", "of the element, where it is known"),
)  # fmt: skip
#: of what a coupling bears, that of which the largest at any speed is searched
LARGEST = tuple(name for name, *_ in _BORNE if name not in ("mean_torque", "main_frequency"))


def _borne(place: str, axes: str, words: str) -> Iterator[Entry]:
    for name, unit, long_name in _BORNE:
        exempt = PLACE if name == "main_frequency" else ""
        if name in LARGEST or not place.startswith("largest"):
            yield entry(f"{place}{name}", axes, unit, f"{long_name}, {words}", exempt=exempt)


def _largest_use(axes: str, words: str, of: str = "", place: str = "") -> Iterator[Entry]:
    at = f"{place}/largest_utilisation_speed"
    headline = Headline(f"coupling utilisation{of}", at=at) if of else None
    yield entry("largest_utilisation", axes, "", words, headline=headline, share=True)
    yield entry("largest_utilisation_speed", axes, "rad/s", "where that is", exempt=PLACE)


COUPLING_ENTRIES = (
    *under(
        COUPLING,
        *_borne("", "coupling", _HERE),
        entry("stiffness", "coupling order", "N*m/rad",
              f"dynamic, at the frequency of the order, {_HERE}"),
        entry("loss_factor", "coupling order", "",
              f"relative damping over 2 pi, at the frequency of the order, {_HERE}"),
        entry("mode_stiffness", "coupling mode", "N*m/rad",
              f"dynamic, at the undamped natural frequency of the mode, {_HERE}"),
        entry("utilisation", _LIMITED, "", f"{_USE}, {_HERE}",
              share=True, headline=Headline("coupling utilisation at operating speed")),
        *_borne("speeds/", "coupling speed", "over the speeds"),
        *_borne("largest/", "coupling", "the largest at any speed"),
        *(entry(f"largest/{one}_speed", "coupling", "rad/s", "where that is", exempt=PLACE)
          for one in LARGEST),
        entry("speeds/utilisation", f"{_LIMITED} speed", "", _USE),
        *_largest_use(_LIMITED, f"{_USE}, the largest at any speed", ", speed range",
                      COUPLING),
    ),
    *under(
        HEALTHY,
        entry("utilisation", _LIMITED, "", f"{_USE}, {_HERE}, all cylinders firing"),
        *_largest_use(_LIMITED, f"{_USE}, the largest at any speed, all cylinders firing"),
    ),
    *under(
        f"{_CONDITIONS}/coupling",
        entry("utilisation", f"condition {_LIMITED}", "", f"{_USE}, {_HERE}"),
        *_largest_use(f"condition {_LIMITED}", f"{_USE}, the largest at any speed",
                      ", worst condition", f"{_CONDITIONS}/coupling"),
    ),
)  # fmt: skip
