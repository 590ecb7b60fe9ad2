"""A whole case: the machine, the stages asked for, the numbers it is held against."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import model_validator

from vibecalc.core.case.fields import AngularSpeed, Number, Table, Whole, key, later
from vibecalc.core.case.rules import Row, unique
from vibecalc.core.results.named import named
from vibecalc.errors import Problem
from vibecalc.parts.body_tables import Body, Mounts
from vibecalc.parts.tables import NEEDED_BY_KIND, CrankTrain, Cycle

if TYPE_CHECKING:
    from vibecalc.absorber.asked_tables import Tuning
    from vibecalc.absorber.tables import (
        Flywheel,
        FrictionDamper,
        Gap,
        Oil,
        OilCatalogue,
        Pendulum,
        Primary,
        Ring,
        Rod,
        Secondaries,
        Secondary,
        SpringCatalogue,
        Springs,
        StockDampers,
        StockOils,
        StockSprings,
    )
    from vibecalc.balance.tables import Balance
    from vibecalc.base_motion.tables import BaseMotion
    from vibecalc.bearings.tables import BearingLoads
    from vibecalc.core.case.study_tables import Find, Fit, Optimisation, Sweep
    from vibecalc.core.case.tables import Document, Limit, Reference, ReferenceTable
    from vibecalc.excitation.tables import Excitation
    from vibecalc.foundation.tables import Foundation
    from vibecalc.isolation.tables import Isolation
    from vibecalc.kinematics.tables import Kinematics
    from vibecalc.measurement.tables import Measurement
    from vibecalc.parts.motor_tables import Joints, Motor
    from vibecalc.points.tables import Points, VibrationSeverity
    from vibecalc.response.tables import Response
    from vibecalc.roll.tables import Friction, Rotor, Shell
    from vibecalc.torsion.shaft_line_tables import ShaftLine
    from vibecalc.torsion.tables import DamperDesign
else:
    globals().update(
        later(
            {
                "vibecalc.absorber.asked_tables": "Tuning",
                "vibecalc.absorber.tables": "Flywheel FrictionDamper Gap Oil OilCatalogue "
                "Pendulum Primary Ring Rod Secondaries Secondary SpringCatalogue Springs "
                "StockDampers StockOils StockSprings",
                "vibecalc.base_motion.tables": "BaseMotion",
                "vibecalc.balance.tables": "Balance",
                "vibecalc.bearings.tables": "BearingLoads",
                "vibecalc.core.case.study_tables": "Find Fit Optimisation Sweep",
                "vibecalc.core.case.tables": "Document Limit Reference ReferenceTable",
                "vibecalc.excitation.tables": "Excitation",
                "vibecalc.foundation.tables": "Foundation",
                "vibecalc.isolation.tables": "Isolation",
                "vibecalc.kinematics.tables": "Kinematics",
                "vibecalc.measurement.tables": "Measurement",
                "vibecalc.parts.motor_tables": "Joints Motor",
                "vibecalc.points.tables": "Points VibrationSeverity",
                "vibecalc.response.tables": "Response",
                "vibecalc.roll.tables": "Friction Rotor Shell",
                "vibecalc.torsion.shaft_line_tables": "ShaftLine",
                "vibecalc.torsion.tables": "DamperDesign",
            }
        )
    )

SCHEMA_VERSION = 1


#: each has a row in `kinds.KINDS`, which says what parts it needs
KindName = Literal["machine", "compressor", "plate", "absorber", "engine", "pump", "drive_train"]


class Machine(Table):
    """A machine: its kind says which parts it needs, and nothing else."""

    kind: KindName = key("kind of machine")
    cycle: Cycle | None = key("of an engine: 720 or 360 degrees", None)
    # None stands for a part that the kind does without (kinds.py); ask has_crank_train and
    # has_speed there before reading one of these two where that may be.
    speed: AngularSpeed = key(
        "operating speed of the crankshaft; not where the motor finds it", NEEDED_BY_KIND, gt=0
    )
    crank_train: CrankTrain = key("cylinders, rods and cranks", NEEDED_BY_KIND)
    body: Body | None = key("the rigid machine", None)
    mounts: Mounts | None = key("what the body stands on", None)
    motor: Motor | None = key("the motor on the crankshaft", None)
    joints: Joints | None = key("bearings with play", None)
    rotor: Rotor | None = key(
        "all that turns with the crankshaft; without it the crank turns steadily", None
    )
    shell: Shell | None = key("what turns about the crank axis, as one body", None)
    friction: Friction | None = key("between shell, crankshaft and pistons", None)
    primary: Primary | None = key("a system that an absorber is to keep still", None)
    secondary: Secondary | None = key("the absorber on the primary", None)
    secondaries: Secondaries = key("several absorbers, instead of one", ())
    rod: Rod | None = key("the rod that is the primary's spring", None)
    flywheel: Flywheel | None = key("on the end of the rod, for its bending", None)
    springs: Springs | None = key("helical springs of the absorber", None)
    ring: Ring | None = key("the seismic mass of the absorber", None)
    gap: Gap | None = key("full of oil, around the seismic mass", None)
    oil: Oil | None = key("in the gap, as built", None)
    stock_springs: StockSprings = key("that can be bought", ())
    stock_oils: StockOils = key("that can be bought", ())
    stock_dampers: StockDampers = key("that can be bought, in translation", ())
    spring_catalogue: SpringCatalogue | None = key(
        "springs that can be bought, also as a file", None
    )
    oil_catalogue: OilCatalogue | None = key("oils that can be bought, also as a file", None)
    friction_damper: FrictionDamper | None = key(
        "a mass that dry friction drags along, on the primary", None
    )
    pendulum: Pendulum | None = key("pendulums on a rotor", None)
    shaft_line: ShaftLine | None = key("of an engine or a drive train: what turns and twists", None)

    RULES = ("vibecalc.kinds:check_kinds",)

    @model_validator(mode="before")
    @classmethod
    def _phases(cls, data: Any) -> Any:
        """Where no throw of an engine says its phase, the order of firing does."""
        if isinstance(data, dict) and data.get("kind") == "engine":
            return named("vibecalc.parts.firing:with_phases")(data)
        return data


class Accuracy(Table):
    """The one setting between speed and accuracy."""

    rtol: Number = key("of the largest magnitude of each quantity", 1e-9, ge=1e-14, le=0.1)


def _limits(row: Row) -> Iterator[Problem]:
    if "limit" in row:
        yield from named("vibecalc.core.case.tables:contradictions")(row)


class Case(Table):
    """One scene; a table that is absent is not computed."""

    schema_: Annotated[Literal[1], Whole] = key("version of the case format", alias="schema")
    title: str = key("one line for reports and plots", min_length=1, max_length=200)
    source: str = key("where the machine is described", "")
    document: Document | None = key("title block of the report", None)
    machine: Machine = key("the machine and its parts")
    kinematics: Kinematics | None = key("motion of the pistons", None)
    excitation: Excitation | None = key("forces and couples on the body", None)
    balance: Balance | None = key("weights for the least force and couple", None)
    response: Response | None = key("motion of the body, energies, impacts", None)
    isolation: Isolation | None = key("the body on its mounts", None)
    foundation: Foundation | None = key("what the mounts stand on, if it moves", None)
    point: Points = key("places on the body where vibration is measured", ())
    vibration_severity: VibrationSeverity | None = key(
        "band and zones for the vibration at the points", None
    )
    base_motion: BaseMotion | None = key("how what carries the machine moves", None)
    bearing_loads: BearingLoads | None = key(
        "loads on crank pins, wrist pins and main bearings over a cycle", None
    )
    measurement: Measurement | None = key("readings on a rigid plate", None)
    tuning: Tuning | None = key("the best spring and damper of an absorber", None)
    damper_design: DamperDesign | None = key("the best damper of an engine", None)
    optimisation: Optimisation | None = key("a search over keys of this case", None)
    fit: Fit | None = key("keys of this case that fit what was measured", None)
    sweep: Sweep | None = key("the same case at many points; `sweep` reads it", None)
    find: tuple[Find, ...] = key("searches for what brings a wanted result", ())
    accuracy: Accuracy = key("tolerance of the results", default_factory=Accuracy)
    reference: tuple[Reference, ...] = key("published and measured numbers", ())
    reference_table: tuple[ReferenceTable, ...] = key("published numbers in tables", ())
    limit: tuple[Limit, ...] = key("bounds that results have to keep", ())
    RULES = (unique("find", "searches"), unique("point", "points"), _limits)
