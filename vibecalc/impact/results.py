"""Results of impacts in joints with play: statistics over members and revolutions."""

from vibecalc.core.results.record import CHECK, PEAK, STATISTIC, Headline, entry, exempt

#: axis name -> (unit, long name)
AXES = {
    "clearance": ("m", "clearance of the joint"),
    "contact": ("", "contact, the first is 1"),
}
_RESULTS = (
    entry(
        "response/impact/mean_force", "clearance", "N",
        "mean magnitude of the joint force, over members and revolutions",
        headline=Headline("mean force in the joint", "N", pick="ends")),
    entry(
        "response/impact/mean_force_standard_error", "clearance", "N",
        "standard error of that mean, from the scatter of members"),
    entry(
        "response/impact/mean_force_low", "clearance", "N",
        "mean magnitude of one revolution that 5 % of them stay below"),
    entry(
        "response/impact/mean_force_high", "clearance", "N",
        "mean magnitude of one revolution that 5 % of them exceed"),
    entry(
        "response/impact/spectrum", "clearance order", "N",
        "amplitude of the joint force in one revolution, mean over revolutions", PEAK),
    entry(
        "response/impact/spectrum_low", "clearance order", "N",
        "amplitude that 5 % of revolutions stay below", PEAK),
    entry(
        "response/impact/spectrum_high", "clearance order", "N",
        "amplitude that 5 % of revolutions exceed", PEAK),
    entry(
        "response/impact/average_amplitude", "clearance", "N",
        "mean of the spectrum over its orders, from 1 to the last", PEAK),
    entry(
        "response/impact/added_force", "clearance order", "N",
        "amplitude of what play adds to the inertia force on the body, mean over revolutions",
        PEAK),
    entry(
        "response/impact/peak_force", "clearance", "N",
        "largest magnitude of the joint force in a revolution, mean over revolutions",
        headline=Headline("largest force in a revolution, mean", "N")),
    entry(
        "response/impact/peak_force_high", "clearance", "N",
        "largest magnitude in a revolution that 5 % of them exceed"),
    entry("response/impact/impacts", "clearance", "", "contacts made per revolution",
          headline=Headline("impacts in a revolution", pick="ends")),
    entry("response/impact/contact_share", "clearance", "", "share of the time in contact"),
    entry(
        "response/impact/dissipated", "clearance", "J",
        "energy lost per revolution in contacts and films, event by event"),
    entry(
        "response/impact/energy_residual", "clearance", "",
        "largest imbalance of energy over the energy exchanged, event by event", exempt=CHECK,
        diagnostic=True),
    entry(
        "response/impact/parting", "clearance", "",
        "revolutions until two neighbours are a tenth of the clearance apart, median; "
        "infinite: not within the run"),
    entry(
        "response/impact/divergence", "clearance", "",
        "growth of the logarithm of their distance per revolution until then, median"),
    entry(
        "response/impact/first_contacts", "clearance contact", "rad",
        "crank angles of the first contacts after a start at crank angle 0 at rest in the middle "
        "of the play; infinite: none within three turns"),
    entry(
        "response/impact/first_turn_force", "clearance crank_angle", "N",
        "joint force over the first turn from that start, positive when it pulls the piston "
        "towards the crank"),
    entry(
        "response/impact/crank_pin/mean_force", "clearance", "N",
        "mean magnitude of the force at the crank end"),
    entry(
        "response/impact/crank_pin/impacts", "clearance", "",
        "contacts made per revolution at the crank end"),
    entry(
        "response/impact/bore/mean_force", "clearance", "N",
        "mean magnitude of the force on the cylinder wall"),
    entry(
        "response/impact/bore/impacts", "clearance", "",
        "contacts with the cylinder wall per revolution"),
    entry(
        "response/impact/shaking", "order", "N",
        "inertia force of the piston without play, with which impacts are compared", PEAK),
    entry(
        "response/impact/motor", "order", "N",
        "axial force of the motor, for comparison, zero at orders that its torque lacks", PEAK),
    entry(
        "response/impact/dominant", "clearance order", "",
        "largest amplitude: 0 the piston's inertia force, 1 what play adds to it, 2 the motor"),
    entry(
        "response/impact/dominant_from", "clearance", "",
        "lowest order from which on what play adds is largest, 0 if it is not at the last order"),
)  # fmt: skip
#: a chaotic motion: what counts of its statistics is their standard error
ENTRIES = tuple(exempt(STATISTIC, _RESULTS))
