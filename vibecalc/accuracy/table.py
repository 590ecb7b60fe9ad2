"""Which functions give the topics of a stage; each is imported when it is asked for."""

#: stage as the plan names it -> functions of a scene
TOPICS: dict[str, tuple[str, ...]] = {
    "kinematics": (
        "vibecalc.accuracy.topics.kinematics_harmonics:topics",
        "vibecalc.accuracy.topics.kinematics_motion:topics",
    ),
    "excitation": ("vibecalc.accuracy.topics.excitation_force:topics",),
    "motor": ("vibecalc.accuracy.topics.motor_force:topics",),
    "pump": ("vibecalc.accuracy.topics.pump_torque:topics",),
    "response": (
        "vibecalc.accuracy.topics.response_steady:topics",
        "vibecalc.accuracy.topics.response_modes:topics",
    ),
    "speeds": ("vibecalc.accuracy.topics.response_speeds:topics",),
    "operations": ("vibecalc.accuracy.topics.operations:topics",),
    "switching": ("vibecalc.accuracy.topics.switching:topics",),
    "impact": ("vibecalc.accuracy.topics.impact:topics",),
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
    "roll": ("vibecalc.accuracy.topics.roll:topics",),
    "start-up": ("vibecalc.accuracy.topics.start_up:topics",),
    "control": ("vibecalc.accuracy.topics.control:topics",),
    "isolation": ("vibecalc.accuracy.topics.isolation_steady:topics",),
    "run_up": (
        "vibecalc.accuracy.topics.run_up:topics",
        "vibecalc.accuracy.topics.run_up_curve:topics",
    ),
    "torque reaction": ("vibecalc.accuracy.topics.torque_reaction:topics",),
    "measurement": ("vibecalc.accuracy.topics.measurement:topics",),
    "tuning": ("vibecalc.accuracy.topics.absorber_tuning:topics",),
    "absorber": ("vibecalc.accuracy.topics.absorber_curves:topics",),
    "hardware": ("vibecalc.accuracy.topics.absorber_parts:topics",),
    "pendulum": ("vibecalc.accuracy.topics.absorber_pendulum:topics",),
}

#: studies above the pipeline -> functions of a loaded case
STUDIES: dict[str, tuple[str, ...]] = {
    "optimisation": ("vibecalc.accuracy.topics.optimisation:study_topics",),
    "find": ("vibecalc.accuracy.topics.find:study_topics",),
}

#: what the tolerance of the case costs, asked of every case
WHOLE_CASE = "whole case"
OF_WHOLE_CASE = "vibecalc.accuracy.topics.whole_case:topics"
