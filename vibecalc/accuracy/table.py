"""Which modules have the topics of a stage; each is imported when it is asked for."""

#: stage as the plan names it -> modules of `topics/`, each with `topics(scene)`
TOPICS: dict[str, tuple[str, ...]] = {
    "kinematics": ("kinematics_harmonics", "kinematics_motion"),
    "excitation": ("excitation_force",),
    "motor": ("motor_force",),
    "pump": ("pump_torque",),
    "response": ("response_steady", "response_modes"),
    "speeds": ("response_speeds",),
    "operations": ("operations",),
    "switching": ("switching",),
    "impact": ("impact",),
    "torsion": ("torsion_modes", "torsion_forced", "torsion_cycle"),
    "torsion_speeds": ("torsion_speeds",),
    "variable inertia": ("torsion_variable",),
    "transient": ("torsion_transient",),
    "modal route as published": ("torsion_modal_route",),
    "damper design": ("damper_design",),
    "roll": ("roll",),
    "start-up": ("start_up",),
    "control": ("control",),
    "isolation": ("isolation_steady",),
    "run_up": ("run_up", "run_up_curve"),
    "torque reaction": ("torque_reaction",),
    "measurement": ("measurement",),
    "tuning": ("absorber_tuning",),
    "absorber": ("absorber_curves",),
    "hardware": ("absorber_parts",),
    "pendulum": ("absorber_pendulum",),
}

#: studies above the pipeline -> modules with `study_topics(loaded)`
STUDIES: dict[str, tuple[str, ...]] = {
    "optimisation": ("optimisation",),
    "find": ("find",),
}

#: what the tolerance of the case costs, asked of every case
WHOLE_CASE = "whole case"
