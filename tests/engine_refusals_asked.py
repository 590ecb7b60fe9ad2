"""What cannot be asked of an engine's shaft line: the text of each case, and the words for it."""

from engine_cases import DESIGN, ENGINE, GEARED, replaced

E, G, D = ENGINE, GEARED, DESIGN

#: name -> (text, line of the problem, words of the message)
REFUSED: dict[str, tuple[str, int, tuple[str, ...]]] = {
    "half orders": (
        G + "orders = { step = 0.5, count = 12 }\n",
        36,
        ("a two-stroke engine repeats itself every turn and has no hal", "found step = 0.5"),
    ),
    "third orders": (
        E.replace("highest = 6", "step = 0.3, highest = 6"),
        30,
        ("an engine excites half orders and whole orders, no others", "found step = 0.3"),
    ),
    "count+highest": (
        E.replace("highest = 6", "count = 3, highest = 6"),
        30,
        ("highest and count exclude each other",),
    ),
    "misfire unk": (E + 'misfire = ["4"]\n', 31, ("no cylinder is named '4'",)),
    "limit mod": (
        E
        + 'limits = [{ curve = { speed = ["500 rpm", "2000 rpm"], stress = ["30 MPa", "30 MPa"] }, sections = ["rear"] }]\n',  # noqa: E501
        31,
        ("shaft 'rear' has no section modulus for a stress",),
    ),
    "limit tensile": (
        E + 'limits = [{ rule = "iacs_m68" }]\n',
        31,
        ("the rule needs the tensile strength of shaft 'a - b'",),
    ),
    "limit unk": (
        E + 'limits = [{ rule = "iacs_m68", sections = ["reer"] }]\n',
        31,
        ("no shaft is named 'reer'",),
    ),
    "limit desc": (
        E
        + 'limits = [{ curve = { speed = ["2500 rpm", "2000 rpm"], stress = ["30 MPa", "30 MPa"] } }]\n',  # noqa: E501
        31,
        ("the entries of speed have to ascend", "found 261.799 rad/s, then 209.44 rad/s"),
    ),
    "limit len": (
        E
        + 'limits = [{ curve = { speed = ["2000 rpm", "2500 rpm"], stress = ["30 MPa", "30 MPa", "1 MPa"] } }]\n',  # noqa: E501
        31,
        ("the columns of curve are not of one length", "found 2 of speed, 3 of stress"),
    ),
    "design on": (E + D.replace('"a"', '"z"'), 32, ("no station or damper is named 'z'",)),
    "design inertia": (
        E + '[damper_design]\non = "a"\n',
        31,
        ("the new damper has no inertia, and it is not looked for",),
    ),
    "design speeds": (G + D, 36, ("[damper_design] does not say over which speeds",)),
    "design stress": (
        replaced(E, (', diameter = "70 mm"', "")) + D + 'objective = "stress"\n',
        34,
        ("no shaft that counts has a section modulus for a stress",),
    ),
    "no line": (
        E[: E.index("[machine.shaft")] + "[response.torsion]\n",
        15,
        ("[response.torsion] needs [machine.shaft_line]",),
    ),
    "run back": (
        E + 'transient = { kind = "run_up", from = "900 rpm", to = "800 rpm", duration = "3 s" }\n',
        31,
        ("a run-up goes from a lower speed to a higher one", "found from 900 rpm to 800 rpm"),
    ),
    "run no rate": (
        E + 'transient = { kind = "run_up", from = "600 rpm", to = "800 rpm" }\n',
        31,
        ("[response.torsion.transient] has neither acceleration nor du",),
    ),
    "step no st": (
        E + 'transient = { kind = "load_step", torque = "3 N*m" }\n',
        31,
        ("a change of kind 'load_step' needs on",),
    ),
    "step on": (
        E + 'transient = { kind = "load_step", on = "q", torque = "3 N*m" }\n',
        31,
        ("no station is named 'q'",),
    ),
    "speeds back": (
        replaced(E, ('from = "800', 'from = "2800')),
        29,
        ("speeds go from a lower one to a higher one", "found from 2800 rpm to 2000 rpm"),
    ),
    "rayleigh": (
        E + 'damping_model = { kind = "rayleigh", ratios = [0.1] }\n',
        31,
        ("Rayleigh damping goes through the ratios of two modes",),
    ),
    "modal": (
        E + 'damping_model = { kind = "modal", ratios = [0,0.1,0.1,0.1,0.1,0.1] }\n',
        31,
        ("there are more ratios than modes", "found 6 ratios"),
    ),
    "lossy": (
        replaced(E, ('damping = "5 N*m*s/rad"', "loss_factor = 0.1"))
        + 'transient = { kind = "run_up", from = "600 rpm", to = "800 rpm", duration = "3 s" }\n',
        31,
        ("a loss factor is of a steady vibration and has no meaning in",),
    ),
    "limit of one point": (
        E + 'limits = [{ curve = { speed = ["500 rpm"], stress = ["30 MPa", "30 MPa"] } }]\n',
        31,
        ("speed is too short", "found a list of one entry"),
    ),
    "run for ever": (
        E + 'transient = { kind = "run_up", from = 60, to = 90, acceleration = 1e-9 }\n',
        31,
        ("too many steps in time", "found 6.75e+12 steps or more, for 3.58e+11 turns"),
    ),
    "watched for ever": (
        E + 'transient = { kind = "load_step", on = "a", torque = 3, after = "90 h" }\n',
        31,
        ("too many steps in time", "allowed: 4e+06 steps"),
    ),
}
