"""When a function's own import takes place: for which cases, read from the case alone.

Key: the module that imports and what it imports; value: whether a run of a case comes there. None
is "perhaps": it hangs on what is computed. An import without a row would not be foreseen, so that
a test asks for one row for every import below a stage.
"""

from typing import TYPE_CHECKING

from vibecalc.case.engine_mounted import torque_reaches_mounts
from vibecalc.pipeline import needs_when as when
from vibecalc.pipeline.needs_imports import PACKAGE, brought_in, imports_of

if TYPE_CHECKING:
    from vibecalc.case.schema import Case


def modules_needed(case: "Case", roots: tuple[str, ...]) -> tuple[frozenset[str], frozenset[str]]:
    """Modules that the modules `roots` bring into a run of `case`: surely, and perhaps."""
    sure = _reached(case, roots, (True,))
    return sure, _reached(case, roots, (True, None)) - sure


def _reached(
    case: "Case", roots: tuple[str, ...], counted: tuple[bool | None, ...]
) -> frozenset[str]:
    found: set[str] = set()
    waiting = list(roots)
    while waiting:
        fresh = brought_in(waiting.pop()) - found
        found |= fresh
        waiting += [
            later
            for module in fresh
            for later in imports_of(module).later - found
            if needed_later(case, module, later) in counted
        ]
    return frozenset(found)


def needed_later(case: "Case", module: str, later: str) -> bool | None:
    """Whether a run of `case` comes to the import of `later` by a function of `module`."""
    rule = LAZY.get((module.removeprefix(f"{PACKAGE}."), later.removeprefix(f"{PACKAGE}.")))
    return False if rule is None else rule(case)


_STAGES = "pipeline.stages"
#: rows of one condition: (condition, importing module, what it imports)
_ROWS: tuple[tuple[when.Rule, str, tuple[str, ...]], ...] = (
    (when.has_curves, f"{_STAGES}.kinematics", ("kinematics.slider_crank",)),
    (when.bears_torque, "pipeline.crank_forces", ("excitation.inertia_torque",)),
    (
        when.rod_has_inertia,
        "pipeline.crank_forces",
        ("excitation.rod_inertia", "kinematics.rod_angle"),
    ),
    (
        when.rod_is_placed,
        f"{_STAGES}.excitation",
        ("excitation.rod_inertia", "kinematics.rod_angle"),
    ),
    (when.rod_has_inertia, f"{_STAGES}.train_excitation", ("excitation.rod_inertia",)),
    (when.rod_has_inertia, f"{_STAGES}.torsion.drive", ("pipeline.stages.train_excitation",)),
    (torque_reaches_mounts, f"{_STAGES}.run_up", (f"{_STAGES}.run_up_torque",)),
    (
        when.turns_with_the_engine,
        f"{_STAGES}.run_up_torque",
        ("machine.shaft_line", "response.torsion.modes"),
    ),
    (when.computes_cycle, f"{_STAGES}.torque_reaction_couple", ("excitation.gas_cycle",)),
    (
        when.turns_with_the_engine,
        f"{_STAGES}.torque_reaction_couple",
        ("machine.shaft_line", "machine.shaft_line_spin"),
    ),
    (when.computes_cycle, f"{_STAGES}.torsion.drive", ("excitation.gas_cycle",)),
    (when.has_limits, f"{_STAGES}.torsion.steady", (f"{_STAGES}.torsion.limit_table",)),
    (when.always, f"{_STAGES}.torsion.variable_speeds", (f"{_STAGES}.torsion.variable",)),
    (when.always, f"{_STAGES}.roll", ("pipeline.stage_plan",)),
    (when.has_several, f"{_STAGES}.absorber", (f"{_STAGES}.absorber_several_response",)),
    (when.has_several, f"{_STAGES}.absorber_tuning", (f"{_STAGES}.absorber_several",)),
    (when.warms, f"{_STAGES}.absorber_parts", (f"{_STAGES}.absorber_warming",)),
    (when.has_matrices, "machine.checks", ("machine.matrix_checks",)),
    (when.has_mass_matrix, "machine.crank_train_checks", ("machine.system",)),
    (when.has_parts, "machine.system", ("isolation.rigid_body",)),
    (when.computes_cycle, "machine.engine", ("excitation.gas_cycle",)),
    (when.has_pump_cycle, "machine.engine", ("machine.pump",)),
    (when.is_planar, "machine.isolation_checks", ("machine.planar_checks",)),
    (when.has_line, "machine.engine_checks", ("machine.engine",)),
    (when.has_impact, "machine.joint_cost", ("response.impact.setup", "response.impact.series")),
    (when.has_primary, "machine.absorber", ("response.absorber.model",)),
    (
        when.has_pendulum,
        "machine.absorber_pendulum_checks",
        ("machine.absorber_pendulum", "response.pendulum.order"),
    ),
    (when.has_measurement, "machine.measurement_checks", ("machine.measurement_places",)),
    (
        when.speed_is_found,
        "machine.roll_cautions",
        (
            *("machine.crank_train", "machine.roll", "excitation.slip_torque"),
            "machine.dynamic_checks",
        ),
    ),
    (when.perhaps_if(when.is_dynamic), "machine.dynamic_checks", ("machine.roll_motor",)),
    (
        when.has_line,
        "machine.shaft_line_checks",
        ("machine.crank_train", "machine.shaft_line_elements"),
    ),
    (
        when.perhaps_if(when.has_transient),
        "machine.transient_checks",
        ("response.torsion.transient_pieces",),
    ),
    (when.perhaps_if(when.speed_is_found), "pipeline.targets", ("machine.roll",)),
    (when.perhaps_if(when.has_primary), "pipeline.targets", ("machine.absorber_hardware",)),
    (when.perhaps_if(when.has_line), "pipeline.targets", ("machine.shaft_sections",)),
    (when.never, "excitation.gas_card", ("scipy.interpolate",)),
    (when.gas_is_cubic, "excitation.gas_force", ("scipy.interpolate",)),
    (when.slip_is_monotone, "excitation.slip_torque", ("scipy.interpolate",)),
    (when.perhaps_if(when.is_dynamic), "excitation.induction_motor_curve", ("scipy.optimize",)),
    (when.perhaps_if(when.is_dynamic), "excitation.induction_motor_search", ("scipy.optimize",)),
    (when.always, "response.roll.steady", ("numerics.periodic_multipliers",)),
    (when.marches, "response.roll.march", ("response.roll.march_scipy",)),
    (when.always, "response.roll.march_scipy", ("scipy.integrate",)),
    (when.perhaps, "response.roll_control.delay_starts", ("scipy.special",)),
    (when.perhaps, "response.roll_control.locus", ("scipy.optimize",)),
    (when.long_line, "response.torsion.modes_qd", ("scipy.linalg",)),
    (when.always, "response.torsion.transient_system", ("scipy.sparse.csgraph",)),
    (when.always, "response.torsion.variable_inertia_balance", ("scipy.linalg.lapack",)),
    (when.perhaps, "measurement.level_family", ("scipy.optimize",)),
    (when.perhaps, "optimisation.damper.descend", ("scipy.optimize",)),
    (when.perhaps, "optimisation.evolution", ("scipy.optimize",)),
    (when.perhaps, "optimisation.local_search", ("scipy.optimize",)),
    (when.perhaps, "numerics.nonnegative", ("scipy.optimize",)),
    (when.perhaps, "optimisation.planes", ("scipy.optimize",)),
    (
        when.perhaps,
        "study.optimise",
        ("optimisation.constrained", "optimisation.starts", "optimisation.variables"),
    ),
    (when.perhaps, "study.balancing", ("optimisation.least_norm",)),
    (when.has_methods, "study.optimise", ("optimisation.methods",)),
    (when.has_methods, "study.compare_methods", ("optimisation.methods",)),
    (when.has_front, "study.pareto", ("optimisation.pareto",)),
    (when.has_sensitivity, "study.sensitivity", ("optimisation.sensitivity",)),
    (when.has_study, "study.execute", ("study.optimise", "study.optimise_paths")),
    (when.has_finds, "study.execute", ("study.find", "study.find_paths")),
    (when.unless(when.has_study), "study.execute", ("pipeline.run",)),
    (when.always, "study.execute", ("pipeline.plan",)),
    (when.always, "study.load", ("machine.checks", "pipeline.targets")),
    (when.has_study, "study.load", ("study.optimise_checks", "study.optimise_paths")),
    (when.has_finds, "study.load", ("study.find_paths",)),
    (when.has_axes, "study.load", ("study.sweep.early",)),
    (when.perhaps, "study.find_extremes", ("scipy.optimize",)),
    (when.perhaps, "study.find_roots", ("scipy.optimize",)),
    (
        when.perhaps,
        "study.early_checks",
        ("machine.crank_train_checks", "pipeline.catalogue", "pipeline.targets"),
    ),
    (when.has_impact, "pipeline.plan_response", ("machine.joint_cost",)),
    (when.always, "pipeline.numeric_entries", ("pipeline.plan_torsion",)),
)
LAZY: dict[tuple[str, str], when.Rule] = {
    (module, later): rule for rule, module, names in _ROWS for later in names
}
