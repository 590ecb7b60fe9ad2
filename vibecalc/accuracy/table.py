"""Which functions give the topics of a stage; each is imported when it is asked for."""

#: stage as the plan names it -> functions of a scene
TOPICS: dict[str, tuple[str, ...]] = {
    "kinematics": (
        "vibecalc.kinematics.accuracy:kinematics_harmonics_topics",
        "vibecalc.kinematics.accuracy:kinematics_motion_topics",
    ),
    "excitation": ("vibecalc.excitation.accuracy:excitation_force_topics",),
    "motor": ("vibecalc.excitation.accuracy:motor_force_topics",),
    "pump": ("vibecalc.excitation.accuracy:pump_torque_topics",),
    "response": (
        "vibecalc.response.accuracy.forced:response_steady_topics",
        "vibecalc.response.accuracy.modes:response_modes_topics",
    ),
    "speeds": ("vibecalc.response.accuracy.forced:response_speeds_topics",),
    "operations": ("vibecalc.response.accuracy.operations:operations_topics",),
    "switching": ("vibecalc.response.accuracy.switching:switching_topics",),
    "impact": ("vibecalc.impact.accuracy:impact_topics",),
    "torsion": (
        "vibecalc.torsion.accuracy.modes:torsion_modes_topics",
        "vibecalc.torsion.accuracy.steady:torsion_forced_topics",
        "vibecalc.torsion.accuracy.steady:torsion_cycle_topics",
    ),
    "torsion_speeds": ("vibecalc.torsion.accuracy.speeds:torsion_speeds_topics",),
    "variable inertia": ("vibecalc.torsion.accuracy.studies:torsion_variable_topics",),
    "transient": ("vibecalc.torsion.accuracy.studies:torsion_transient_topics",),
    "modal route as published": ("vibecalc.torsion.accuracy.modes:torsion_modal_route_topics",),
    "damper design": ("vibecalc.torsion.accuracy.speeds:damper_design_topics",),
    "roll": ("vibecalc.roll.accuracy.running:roll_topics",),
    "start-up": ("vibecalc.roll.accuracy.start_up:start_up_topics",),
    "control": ("vibecalc.roll.accuracy.control:control_topics",),
    "isolation": ("vibecalc.isolation.accuracy.steady:isolation_steady_topics",),
    "run_up": (
        "vibecalc.isolation.accuracy.run_up:run_up_topics",
        "vibecalc.isolation.accuracy.run_up:run_up_curve_topics",
    ),
    "torque reaction": ("vibecalc.isolation.accuracy.torque_reaction:torque_reaction_topics",),
    "measurement": ("vibecalc.measurement.accuracy:measurement_topics",),
    "tuning": ("vibecalc.absorber.accuracy.tuning:absorber_tuning_topics",),
    "absorber": ("vibecalc.absorber.accuracy.curves:absorber_curves_topics",),
    "hardware": ("vibecalc.absorber.accuracy.hardware:absorber_parts_topics",),
    "pendulum": ("vibecalc.absorber.accuracy.pendulum:absorber_pendulum_topics",),
}

#: studies above the pipeline -> functions of a loaded case
STUDIES: dict[str, tuple[str, ...]] = {
    "optimisation": ("vibecalc.accuracy.topics.optimisation:study_topics",),
    "find": ("vibecalc.accuracy.topics.find:study_topics",),
}

#: what the tolerance of the case costs, asked of every case
WHOLE_CASE = "whole case"
OF_WHOLE_CASE = "vibecalc.accuracy.topics.whole_case:topics"
