"""What cannot be asked of an engine's shaft line: the text of each case, and the words for it."""

from engine_cases import DESIGN, ENGINE, GEARED, replaced

E, G, D = ENGINE, GEARED, DESIGN


def limited(speed: str, stress: str, more: str = "") -> str:
    """The engine with a limit over speeds."""
    return f"{E}limits = [{{ curve = {{ speed = {speed}, stress = {stress} }}{more} }}]\n"


RING = next(line for line in E.splitlines() if line.startswith("dampers"))
PENDULUM = (
    'dampers = [{ name = "ring", on = "a", kind = "pendulum", order = 1.5, mass = "0.6 kg", '
    'arm_radius = "90 mm", count = 4 }]'
)
BOUNDS = 'bounds = { inertia = ["0.1 kg*m^2", "0.5 kg*m^2"] }\n'
TWO, SPEEDS = '["30 MPa", "30 MPa"]', '["500 rpm", "2000 rpm"]'

#: name -> text
REFUSED: dict[str, str] = {
    "half orders": G + "orders = { step = 0.5, count = 12 }\n",
    "third orders": E.replace("highest = 6", "step = 0.3, highest = 6"),
    "count+highest": E.replace("highest = 6", "count = 3, highest = 6"),
    "misfire unk": E + 'misfire = ["4"]\n',
    "limit mod": limited(SPEEDS, TWO, ', sections = ["rear"]'),
    "limit tensile": E + 'limits = [{ rule = "iacs_m68" }]\n',
    "limit of nothing": replaced(limited(SPEEDS, TWO), (', diameter = "70 mm"', "")),
    "limit unk": E + 'limits = [{ rule = "iacs_m68", sections = ["reer"] }]\n',
    "limit desc": limited('["2500 rpm", "2000 rpm"]', TWO),
    "limit len": limited('["2000 rpm", "2500 rpm"]', '["30 MPa", "30 MPa", "1 MPa"]'),
    "design on": E + D.replace('"a"', '"z"'),
    "design inertia": E + '[damper_design]\non = "a"\n',
    "design speeds": G + D,
    "design stress": replaced(E, (', diameter = "70 mm"', "")) + D + 'objective = "stress"\n',
    "no line": E[: E.index("[machine.shaft")] + "[response.torsion]\n",
    "run back": E
    + 'transient = { kind = "run_up", from = "900 rpm", to = "800 rpm", duration = "3 s" }\n',
    "run no rate": E + 'transient = { kind = "run_up", from = "600 rpm", to = "800 rpm" }\n',
    "step no st": E + 'transient = { kind = "load_step", torque = "3 N*m" }\n',
    "step on": E + 'transient = { kind = "load_step", on = "q", torque = "3 N*m" }\n',
    "speeds back": replaced(E, ('from = "800', 'from = "2800')),
    "rayleigh": E + 'damping_model = { kind = "rayleigh", ratios = [0.1] }\n',
    "modal": E + 'damping_model = { kind = "modal", ratios = [0,0.1,0.1,0.1,0.1,0.1] }\n',
    "limit of one point": limited('["500 rpm"]', TWO),
    "run for ever": E
    + 'transient = { kind = "run_up", from = 60, to = 90, acceleration = 1e-9 }\n',
    "watched for ever": E
    + 'transient = { kind = "load_step", on = "a", torque = 3, after = "90 h" }\n',
    "orders without end": replaced(E, ("highest = 6", "highest = 1e5")),
    "no order": replaced(E, ("highest = 6", "highest = 0.3")),
    "onset of none": E
    + 'misfire = ["2"]\ntransient = { kind = "misfire_onset", cylinder = "2" }\n',
    "mode of none": E
    + 'damping_model = { kind = "rayleigh", modes = [2, 9], ratios = [0.1, 0.1] }\n',
    "limit by diameter": replaced(E, ('diameter = "70 mm"', 'section_modulus = "60 cm^3"'))
    + 'limits = [{ rule = "iacs_m68", tensile_strength = "600 MPa" }]\n',
    "design of a pendulum": replaced(E, (RING, PENDULUM)) + D.replace('"a"', '"ring"'),
    "design without end": E + '[damper_design]\non = "a"\nfind = ["inertia", "damping"]\n',
    "design given twice": E + D + 'find = ["inertia", "damping"]\n' + BOUNDS,
    "design bounds of nothing": E + D + BOUNDS,
}
