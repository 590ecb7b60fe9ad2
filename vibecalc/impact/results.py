"""Results of impacts in joints with play: statistics over members and revolutions."""

from typing import Any

from vibecalc.core.results.record import CHECK, PEAK, STATISTIC, Headline, entry, exempt

#: axis name -> (unit, long name)
AXES = {
    "clearance": ("m", "clearance of the joint"),
    "contact": ("", "contact, the first is 1"),
}
_PEAK = {"amplitude": PEAK}
_STATISTICS: tuple[tuple[str, str, str, str, dict[str, Any]], ...] = (
    ("mean_force", "clearance", "N",
     "mean magnitude of the joint force, over members and revolutions",
     {"headline": Headline("joint force, mean", "N", pick="ends")}),
    ("mean_force_standard_error", "clearance", "N",
     "standard error of that mean, from the scatter of members", {}),
    ("mean_force_low", "clearance", "N",
     "5 % quantile of the mean magnitude of one revolution", {}),
    ("mean_force_high", "clearance", "N",
     "95 % quantile of the mean magnitude of one revolution", {}),
    ("spectrum", "clearance order", "N",
     "amplitude of the joint force in one revolution, mean over revolutions", _PEAK),
    ("spectrum_low", "clearance order", "N", "5 % quantile of the amplitude", _PEAK),
    ("spectrum_high", "clearance order", "N", "95 % quantile of the amplitude", _PEAK),
    ("average_amplitude", "clearance", "N",
     "mean of the spectrum over its orders, from 1 to the last",
     {**_PEAK, "name": "mean harmonic amplitude of the joint force"}),
    ("added_force", "clearance order", "N",
     "amplitude of the force on the body added by play, mean over revolutions", _PEAK),
    ("peak_force", "clearance", "N",
     "largest magnitude of the joint force in a revolution, mean over revolutions",
     {"headline": Headline("joint force, mean peak per turn", "N")}),
    ("peak_force_high", "clearance", "N",
     "95 % quantile of the largest magnitude in a revolution", {}),
    ("impacts", "clearance", "", "contacts made per revolution",
     {"headline": Headline("impacts per turn", pick="ends")}),
    ("contact_share", "clearance", "", "share of the time in contact", {}),
    ("dissipated", "clearance", "J",
     "energy lost per revolution in contacts and films, event by event", {}),
    ("energy_residual", "clearance", "",
     "largest energy imbalance / energy exchanged, event by event",
     {"exempt": CHECK, "diagnostic": True}),
    ("parting", "clearance", "",
     "revolutions until two nearly equal starts are a tenth of the clearance apart, median; "
     "infinite: not within the run", {}),
    ("divergence", "clearance", "",
     "Lyapunov exponent per revolution, median", {}),
    ("first_contacts", "clearance contact", "rad",
     "crank angles of the first contacts after a start at crank angle 0 at rest in the middle "
     "of the play; infinite: none within three turns", {}),
    ("first_turn_force", "clearance crank_angle", "N",
     "joint force over the first turn from that start, positive when it pulls the piston "
     "towards the crank", {}),
    ("crank_pin/mean_force", "clearance", "N", "mean magnitude of the force at the crank end", {}),
    ("crank_pin/impacts", "clearance", "", "contacts made per revolution at the crank end", {}),
    ("bore/mean_force", "clearance", "N", "mean magnitude of the force on the cylinder wall", {}),
    ("bore/impacts", "clearance", "", "contacts with the cylinder wall per revolution", {}),
    ("shaking", "order", "N",
     "inertia force of the piston without play, with which impacts are compared", _PEAK),
    ("motor", "order", "N",
     "axial force of the motor, for comparison; 0 at orders missing in its torque", _PEAK),
    ("dominant", "clearance order", "",
     "largest amplitude: 0 the piston's inertia force, 1 force added by play, 2 the motor", {}),
    ("dominant_from", "clearance", "",
     "lowest order from which the force added by play is largest, 0 without one",
     {"name": "order from which the force added by impacts is largest"}),
)  # fmt: skip
#: a chaotic motion: what counts of its statistics is their standard error
ENTRIES = tuple(
    exempt(
        STATISTIC,
        (
            entry(f"response/impact/{name}", axes, unit, words, **more)
            for name, axes, unit, words, more in _STATISTICS
        ),
    )
)
