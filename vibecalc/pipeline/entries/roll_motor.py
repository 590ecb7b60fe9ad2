"""Results of a motor whose fluxes are states: its fit to the slip table, what its transients do."""

from vibecalc.pipeline.entries.entry import entry

ROOT = "response/roll/motor"

#: where the electrical energy of a turn goes
ENERGIES: dict[str, str] = {
    "electrical": "energy from the line in a turn",
    "stator_copper": "heat in the windings of the stator in a turn",
    "rotor_copper": "heat in the cages of the rotor in a turn",
    "mechanical": "work on the crankshaft in a turn",
    "residual": "what is left over; zero for the exact motion",
}

ENTRIES = (
    entry(f"{ROOT}/stator_leakage", "", "H", "leakage inductance of the stator"),
    entry(f"{ROOT}/magnetising_inductance", "", "H", "magnetising inductance"),
    entry(f"{ROOT}/rotor_resistance", "cage", "ohm",
          "resistance of a cage, as seen by the stator"),
    entry(f"{ROOT}/rotor_leakage", "cage", "H", "leakage of a cage, as seen by the stator"),
    entry(
        f"{ROOT}/parameter_spread", "motor_parameter", "",
        "standard error of a parameter's logarithm for 1 % of error in every row of the table, "
        "what is assumed being held",
    ),
    entry(
        f"{ROOT}/parameter_free_spread", "motor_parameter", "",
        "the same with nothing assumed; infinite where the table does not tell the parameter",
    ),
    entry(
        f"{ROOT}/singular_value", "combination", "",
        "answer of the logarithms of the torques to a product of powers of the parameters",
    ),
    entry(f"{ROOT}/combination", "combination motor_parameter", "", "exponents of that product"),
    entry(
        f"{ROOT}/combination_spread", "combination", "",
        "standard error of its logarithm for 1 % of error in every row of the table",
    ),
    entry(f"{ROOT}/table/torque", "slip", "N*m", "torque of the slip table"),
    entry(f"{ROOT}/table/fitted", "slip", "N*m", "steady torque of the fitted motor"),
    entry(f"{ROOT}/table/difference", "slip", "N*m", "steady torque less that of the table"),
    entry(f"{ROOT}/table/relative_difference", "slip", "", "the same over that of the table"),
    entry(f"{ROOT}/table/used", "slip", "", "1 for a row that is fitted, 0 for one that is not"),
    entry(f"{ROOT}/worst_difference", "", "", "largest relative difference from a fitted row"),
    entry(f"{ROOT}/rms_difference", "", "", "root of the mean square of these differences"),
    entry(f"{ROOT}/curve", "slip", "N*m", "steady torque of the fitted motor"),
    entry(f"{ROOT}/breakdown_slip", "", "rad/s", "slip at the largest steady torque"),
    entry(f"{ROOT}/breakdown_torque", "", "N*m", "largest steady torque"),
    entry(f"{ROOT}/locked_rotor_torque", "", "N*m", "torque at standstill"),
    entry(f"{ROOT}/gain", "", "N*m*s/rad", "slope of the steady torque at synchronous speed"),
    entry(f"{ROOT}/stator_time", "", "s", "time constant of the stator, fluxes of the rotor held"),
    entry(f"{ROOT}/rotor_open_time", "cage", "s", "time constant of the rotor, stator open"),
    entry(f"{ROOT}/rotor_short_time", "cage", "s", "time constant of the rotor, stator shorted"),
    entry(
        f"{ROOT}/transient_decay_time", "transient", "s",
        "time in which a transient at the mean slip falls to 1/e, the speed held",
    ),
    entry(
        f"{ROOT}/transient_frequency", "transient", "rad/s",
        "frequency with which it makes the torque pulsate",
    ),
    entry(
        f"{ROOT}/torque_answer", "order", "N*m*s/rad",
        "torque for a small harmonic of the crank's speed about the mean slip, complex",
    ),
    entry(
        f"{ROOT}/static_answer", "", "N*m*s/rad",
        "the same for a slow change: minus the slope of the steady curve",
    ),
    *(entry(f"{ROOT}/energy/{name}", "", "J", words) for name, words in ENERGIES.items()),
    entry(f"{ROOT}/static_speed", "", "rad/s", "mean crank speed with its steady torque"),
    entry(f"{ROOT}/table_speed", "", "rad/s", "mean crank speed with the slip table"),
    entry(
        f"{ROOT}/static_level", "order", "dB",
        "level of the shell acceleration with the steady torque of the same motor at every slip, "
        "dB re 1 rad/s^2 zero-to-peak",
    ),
    entry(
        f"{ROOT}/table_level", "order", "dB",
        "level of the shell acceleration with the slip table as the torque at every slip, "
        "dB re 1 rad/s^2 zero-to-peak",
    ),
    entry(
        f"{ROOT}/dynamics_change", "order", "dB",
        "what the transients of the motor change in the level of the shell acceleration",
    ),
    entry(
        f"{ROOT}/fit_change", "order", "dB",
        "what the fitted curve in place of the table changes in it, without transients",
    ),
    entry(f"{ROOT}/cycle/static_slip", "crank_angle", "rad/s", "slip with its steady torque"),
    entry(f"{ROOT}/cycle/static_torque", "crank_angle", "N*m", "its steady torque over a turn"),
)  # fmt: skip

#: what has to be solved for beside the motion that the case asks for
COMPARED = tuple(
    f"{ROOT}/{name}"
    for name in (
        "static_speed",
        "table_speed",
        "static_level",
        "table_level",
        "dynamics_change",
        "fit_change",
        "cycle/static_slip",
        "cycle/static_torque",
    )
)
