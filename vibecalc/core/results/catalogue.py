"""Every result path with its unit, axes, amplitude kind and long name: said once, here.

Adapters hand over arrays and errors under these paths; the file, the report, references, limits
and `check` read the rest from this table. The entries stand in `entries/`, a file for each group.
"""

from vibecalc.absorber.results import HARDWARE_ENTRIES as absorber_parts_entries
from vibecalc.absorber.results import PENDULUM_ENTRIES as pendulum_entries
from vibecalc.absorber.results import RESPONSE_ENTRIES as absorber_entries
from vibecalc.absorber.results import TUNING_ENTRIES as tuning_entries
from vibecalc.core.results.record import Entry
from vibecalc.excitation.results import EXCITATION_ENTRIES as excitation_entries
from vibecalc.excitation.results import PUMP_ENTRIES as pump_entries
from vibecalc.impact.results import IMPACT_ENTRIES as impact_entries
from vibecalc.isolation.results import ISOLATION_ENTRIES as isolation_entries
from vibecalc.isolation.results import TORQUE_REACTION_ENTRIES as torque_reaction_entries
from vibecalc.kinematics.results import ENTRIES as kinematics_entries
from vibecalc.measurement.results import ENTRIES as measurement_entries
from vibecalc.response.results import RESPONSE_ENTRIES as response_entries
from vibecalc.response.results import SWITCHING_ENTRIES as switching_entries
from vibecalc.roll.results import CONTROL_ENTRIES as roll_control_entries
from vibecalc.roll.results import MOTOR_ENTRIES as roll_motor_entries
from vibecalc.roll.results import ROLL_ENTRIES as roll_entries
from vibecalc.roll.results import START_UP_ENTRIES as start_up_entries
from vibecalc.torsion.results import DAMPER_DESIGN_ENTRIES as damper_design_entries
from vibecalc.torsion.results import TORSION_ENTRIES as torsion_entries
from vibecalc.torsion.results import TORSION_LIMITS_ENTRIES as torsion_limits_entries
from vibecalc.torsion.results import TORSION_SPEEDS_ENTRIES as torsion_speeds_entries
from vibecalc.torsion.results import TORSION_STUDIES_ENTRIES as torsion_studies_entries
from vibecalc.torsion.results import TORSION_VARIANTS_ENTRIES as torsion_beside_entries

#: axis name -> (unit, long name)
AXES: dict[str, tuple[str, str]] = {
    "order": ("", "multiple of crank speed"),
    "direction": ("", "axis of the machine"),
    "cylinder": ("", "cylinder"),
    "counterweight": ("", "counterweight"),
    "mount": ("", "mount"),
    "speed": ("rad/s", "crank speed"),
    "mode": ("", "mode, lowest first"),
    "other_mode": ("", "mode it is held against"),
    "coordinate": ("", "coordinate of the rigid body"),
    "crank_angle": ("rad", "crank angle"),
    "frequency_ratio": ("", "excitation frequency over natural frequency"),
    "masked": ("", "interval of speeds left out"),
    "operation": ("", "cylinders that work"),
    "balance": ("", "throws that weights cancel"),
    "change": ("", "from one operation to the other"),
    "instant_time": ("s", "end of an interval of time"),
    "reversal_time": ("s", "end of an interval of time"),
    "passage": ("", "meeting of an order and a mode, the first is 1"),
    "clearance": ("m", "clearance of the joint"),
    "contact": ("", "contact, the first is 1"),
    "multiplier": ("", "Floquet multiplier, largest first"),
    "interpolant": ("", "way to read the gas tables"),
    "method": ("", "method"),
    "parameter": ("", "parameter of the machine"),
    "start_time": ("s", "end of an interval of time"),
    "turn": ("", "whole turn of the crank, the first is 1"),
    "load_step": ("s", "time from which on the load is constant"),
    "start_angle": ("rad", "crank angle of a start from rest"),
    "start_interval": ("", "interval of crank angles, ascending"),
    "slip": ("rad/s", "slip speed"),
    "cage": ("", "cage of the rotor"),
    "motor_parameter": ("", "parameter of the motor"),
    "combination": ("", "product of powers of the motor's parameters, best told first"),
    "transient": ("", "electrical transient, least damped first"),
    "pole": ("", "pole, rightmost first"),
    "motor_gain": ("N*m*s/rad", "torque of the motor for each unit of slip"),
    "gain": ("", "gain of the controller"),
    "feedback": ("s", "feedback of the shell's acceleration"),
    "locus_gain": ("", "gain of the controller"),
    "branch": ("", "pole that is followed"),
    "bound": ("", "what holds the gains"),
    "tuning_bound": ("", "what may hold a tuning"),
    "position": ("", "point of the plate"),
    "reading": ("", "harmonic and instrument"),
    "signal": ("", "harmonic and instrument"),
    "candidate": ("", "harmonic, and signs of the phases of roll and pitch"),
    "further": ("", "harmonic, and a reading that would tell motions apart"),
    "curve": ("", "absorber that the curve is of"),
    "summit": ("", "maximum, from low to high frequency"),
    "fixed_point": ("", "point that all curves pass"),
    "active": ("", "peak that holds the optimum, from low to high frequency"),
    "absorber": ("", "absorber"),
    "mistuned": ("", "part with an error"),
    "deviation": ("", "relative error of the part"),
    "share": ("", "relative error, of either sign"),
    "ratio": ("", "given ratio"),
    "primary_damping": ("", "damping of the primary, c1 / (2 sqrt(K1 J1))"),
    "mass_ratio": ("", "inertia of the absorber over that of the primary"),
    "stiffness_ratio": ("", "stiffness of the absorber over that of the primary"),
    "secondary_damping": ("", "damping of the absorber, c2 / (2 sqrt(K1 J1))"),
    "stock_spring": ("", "spring that can be bought"),
    "stock_oil": ("", "oil that can be bought"),
    "stock_damper": ("", "damper that can be bought"),
    "temperature": ("K", "temperature of the oil"),
    "swing": ("rad", "angle of swing"),
    "steady_swing": ("rad", "first sine of the swing"),
    "order_ratio": ("", "order of the excitation over the wanted one"),
    "station": ("", "station of the shaft line"),
    "section": ("", "shaft, elastic gear or damper of the line"),
    "freedom": ("", "stations that turn together, or a ring, along the line"),
    "half_order": ("", "multiple of crank speed, also halves"),
    "damper": ("", "damper of the line"),
    "gear": ("", "gear of the line"),
    "hammering": ("", "range of speeds in which a gear hammers"),
    "order_class": ("", "major: the cylinders of each bank in phase; other: not"),
    "bare_mode": ("", "mode of the line without dampers, lowest first"),
    "limit": ("", "limit of the case, the first is 1"),
    "barred": ("", "range of speeds to be passed through, ascending"),
    "exceeded": ("", "range of speeds above a limit, by limit, ascending"),
    "elastic_mode": ("", "number of the mode, the rigid one is 1"),
    "variable_speed": ("rad/s", "crank speed, criticals among the steps"),
    "wedge": ("", "sum resonance of the inertia, widest first"),
    "unstable": ("", "range of speeds in which vibration grows, ascending"),
    "transient_time": ("s", "middle of a whole cycle of the machine"),
    "course_time": ("s", "time"),
    "waterfall_time": ("s", "middle of a window of time"),
    "waterfall_frequency": ("rad/s", "frequency"),
    "design_value": ("", "value of the damper"),
    "basin": ("", "end of a search, the best first"),
    "stiffness_factor": ("", "stiffness over that of the damper found"),
    "damping_factor": ("", "damping over that of the damper found"),
    "chart_stiffness": ("N*m/rad", "stiffness of the damper's springs"),
    "chart_damping": ("N*m*s/rad", "damping of the damper"),
    "ring_inertia": ("kg*m^2", "inertia of the ring"),
    "damper_curve": ("", "damper that the curve is of"),
    "plate_x": ("m", "place on the plate along the crankshaft"),
    "plate_y": ("m", "place on the plate across the crankshaft"),
}

_GROUPS = (
    kinematics_entries,
    excitation_entries,
    response_entries,
    switching_entries,
    impact_entries,
    roll_entries,
    start_up_entries,
    roll_motor_entries,
    roll_control_entries,
    isolation_entries,
    measurement_entries,
    tuning_entries,
    absorber_entries,
    absorber_parts_entries,
    pendulum_entries,
    torsion_entries,
    torsion_speeds_entries,
    torsion_limits_entries,
    torsion_beside_entries,
    torsion_studies_entries,
    damper_design_entries,
    torque_reaction_entries,
    pump_entries,
)
CATALOGUE: dict[str, Entry] = {entry.path: entry for group in _GROUPS for entry in group}
