"""Results of readings on a rigid plate: its motion, levels anywhere, and how sure they are."""

from vibecalc.core.results.record import (
    CHECK,
    DIFFERENCE,
    EXAMINED,
    PEAK,
    TURN,
    UNCERTAINTY,
    Headline,
    entry,
)

ROOT = "measurement"
_RE = "dB re reference_level of the case"
_RE_ANGULAR = "dB re angular_reference_level of the case"
_PARTS = {
    "standard": "level of the whole motion",
    "no_roll": "level without the roll",
    "no_pitch": "level without the pitch",
    "only_roll": "level of the roll alone",
    "only_pitch": "level of the pitch alone",
    "only_translation": "level of the translation alone",
}

#: axis name -> (unit, long name)
AXES = {
    "position": ("", "point of the plate"),
    "reading": ("", "harmonic and instrument"),
    "signal": ("", "harmonic and instrument"),
    "candidate": ("", "harmonic, and signs of the phases of roll and pitch"),
    "channel": ("", "position of an accelerometer, with the number of its record of several"),
    "block": ("", "block of whole turns of a record"),
    "order_line": ("", "multiple of crank speed, in steps of one over the turns of a block"),
    "further": ("", "harmonic, and a reading that would tell motions apart"),
    "plate_x": ("m", "place on the plate along the crankshaft"),
    "plate_y": ("m", "place on the plate across the crankshaft"),
}
ENTRIES = (
    entry(f"{ROOT}/frequency", "order", "rad/s", "frequency of the harmonics"),
    entry(f"{ROOT}/translation", "order", "m/s^2", "acceleration of the origin along z", PEAK),
    entry(f"{ROOT}/roll", "order", "rad/s^2", "angular acceleration about x", PEAK),
    entry(f"{ROOT}/pitch", "order", "rad/s^2", "angular acceleration about y", PEAK),
    entry(f"{ROOT}/translation_level", "order", "dB", f"level of the origin, {_RE}",
          headline=Headline("translation", "dB", pick="each")),
    entry(f"{ROOT}/roll_level", "order", "dB", f"level of the roll, {_RE_ANGULAR}",
          headline=Headline("roll", "dB", pick="each")),
    entry(f"{ROOT}/pitch_level", "order", "dB", f"level of the pitch, {_RE_ANGULAR}",
          headline=Headline("pitch", "dB", pick="each")),
    *(
        entry(f"{ROOT}/phase/{name}", "order", "rad", words, circle=TURN)
        for name, words in (
            ("translation", "phase of the origin against the reference position"),
            ("roll", "phase of the roll against the reference position"),
            ("pitch", "phase of the pitch against the reference position"),
            ("roll_to_translation", "phase of the roll against the origin"),
            ("pitch_to_translation", "phase of the pitch against the origin"),
        )
    ),
    entry(f"{ROOT}/acceleration", "position order", "m/s^2", "acceleration along z", PEAK),
    *(
        entry(f"{ROOT}/level/{part}", "position order", "dB", f"{words}, {_RE}")
        for part, words in _PARTS.items()
    ),
    entry(f"{ROOT}/level/all_orders", "position", "dB", f"level of all harmonics, {_RE}"),
    *(
        entry(f"{ROOT}/uncertainty/{name}", axes, unit, f"standard uncertainty of {words}",
              exempt=UNCERTAINTY)
        for name, axes, unit, words in (
            ("level", "position order", "dB", "the level at a position"),
            ("translation_level", "order", "dB", "the level of the origin"),
            ("roll_level", "order", "dB", "the level of the roll"),
            ("pitch_level", "order", "dB", "the level of the pitch"),
            ("translation_phase", "order", "rad", "the phase of the origin"),
            ("roll_phase", "order", "rad", "the phase of the roll"),
            ("pitch_phase", "order", "rad", "the phase of the pitch"),
        )
    ),
    entry(
        f"{ROOT}/uncertainty/level_bound", "position order", "dB",
        "how far the level of the motion taken is off at most, all readings within their rounding",
        exempt=UNCERTAINTY),
    entry(f"{ROOT}/fit/motions", "order", "", "motions that the readings leave"),
    entry(f"{ROOT}/fit/decided", "order", "", "1 where the motion taken stands out"),
    entry(
        f"{ROOT}/fit/misfit", "order", "",
        "how many times as far as they are said to be the readings are off, at least; with phases, "
        "root mean square over the stated standard uncertainty", exempt=CHECK),
    entry(f"{ROOT}/reading/order", "reading", "", "harmonic of the reading"),
    entry(f"{ROOT}/reading/read", "reading", "dB", "level read, dB re the reference of its kind"),
    entry(f"{ROOT}/reading/computed", "reading", "dB", "level of the motion, re the same"),
    entry(f"{ROOT}/reading/residual", "reading", "dB", "level computed less level read",
          exempt=CHECK),
    entry(f"{ROOT}/signal/order", "signal", "", "harmonic of a reading with a phase"),
    entry(
        f"{ROOT}/signal/residual", "signal", "",
        "computed less read, in amplitude and phase over their stated uncertainties, as one",
        exempt=CHECK),
    entry(f"{ROOT}/candidate/order", "candidate", "", "harmonic of a motion that levels allow"),
    entry(f"{ROOT}/candidate/chosen", "candidate", "", "1 for the motion taken"),
    entry(
        f"{ROOT}/candidate/worst_residual", "candidate", "dB",
        "largest residual of the readings that choose, or of those that it was found from",
        exempt=CHECK),
    entry(f"{ROOT}/candidate/translation_level", "candidate", "dB", f"level of the origin, {_RE}"),
    entry(f"{ROOT}/candidate/roll_level", "candidate", "dB", f"level of the roll, {_RE_ANGULAR}"),
    entry(f"{ROOT}/candidate/pitch_level", "candidate", "dB", f"level of the pitch, {_RE_ANGULAR}"),
    entry(
        f"{ROOT}/candidate/translation_phase", "candidate", "rad",
        "phase of the origin against the reference position",
        circle=TURN,
    ),
    entry(
        f"{ROOT}/candidate/roll_phase", "candidate", "rad",
        "phase of the roll against the reference position",
        circle=TURN,
    ),
    entry(
        f"{ROOT}/candidate/pitch_phase", "candidate", "rad",
        "phase of the pitch against the reference position",
        circle=TURN,
    ),
    entry(
        f"{ROOT}/candidate/level", "candidate position", "dB", f"level at a position, {_RE}"
    ),
    entry(
        f"{ROOT}/candidate/level_bound", "candidate position", "dB",
        "how far it is off at most if this is the motion, all readings within their rounding",
        exempt=UNCERTAINTY),
    entry(
        f"{ROOT}/further/order", "further", "",
        "harmonic with two motions, and the reading at named positions that best tells them apart",
    ),
    entry(
        f"{ROOT}/further/difference", "further", "dB",
        "level of the motion taken less that of the next one, there",
    ),
    entry(f"{ROOT}/record/acceleration", "channel order", "m/s^2",
          "acceleration of a channel, mean over the blocks", PEAK, exempt=EXAMINED),
    entry(f"{ROOT}/record/phase", "channel order", "rad",
          "phase of it against the first pulse, leading positive", exempt=EXAMINED, circle=TURN),
    entry(f"{ROOT}/record/uncertainty", "channel order", "m/s^2",
          "standard uncertainty of it by scatter of the blocks and of the angle",
          exempt=UNCERTAINTY),
    entry(f"{ROOT}/record/phase_uncertainty", "channel order", "rad",
          "standard uncertainty of the phase by both", exempt=UNCERTAINTY),
    entry(f"{ROOT}/record/pulse_scatter", "channel", "rad",
          "standard deviation of a pulse from a smooth motion of the shaft", exempt=UNCERTAINTY),
    entry(f"{ROOT}/record/speed_correction", "channel", "",
          "of the speed as given, so that phases stand still, relative", exempt=EXAMINED),
    entry(f"{ROOT}/record/block_speed", "channel block", "rad/s", "mean crank speed of a block"),
    entry(f"{ROOT}/record/block_acceleration", "channel block order", "m/s^2",
          "acceleration of a channel in a block", PEAK, exempt=EXAMINED),
    entry(f"{ROOT}/record/spectrum", "channel order_line", "m/s^2",
          "root mean square over the blocks of the amplitudes of all lines", PEAK,
          exempt=EXAMINED),
    entry(f"{ROOT}/map/amplitude", "order plate_y plate_x", "m/s^2", "acceleration along z", PEAK),
    entry(
        f"{ROOT}/map/all_orders", "plate_y plate_x", "m/s^2",
        "root of the sum of the squared amplitudes of all harmonics", PEAK,
    ),
    entry(f"{ROOT}/quiet/x", "order", "m", "place on the plate that moves least"),
    entry(f"{ROOT}/quiet/y", "order", "m", "place on the plate that moves least"),
    entry(f"{ROOT}/quiet/amplitude", "order", "m/s^2", "acceleration of that place", PEAK,
          exempt=DIFFERENCE),
    entry(f"{ROOT}/quiet/all_orders_x", "", "m", "place that moves least in all harmonics"),
    entry(f"{ROOT}/quiet/all_orders_y", "", "m", "place that moves least in all harmonics"),
    entry(
        f"{ROOT}/quiet/all_orders_amplitude", "", "m/s^2",
        "root of the sum of the squared amplitudes of that place", PEAK, exempt=DIFFERENCE),
)  # fmt: skip
