"""A whole case: the machine, the stages asked for, the numbers it is held against."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, model_validator

from vibecalc.core.case.fields import AngularSpeed, Number, Table, Whole, later
from vibecalc.core.case.rules import Row, unique
from vibecalc.core.results.named import named
from vibecalc.errors import Problem
from vibecalc.parts.body_tables import Body, Mounts
from vibecalc.parts.tables import NEEDED_BY_KIND, CrankTrain, Cycle

if TYPE_CHECKING:
    from vibecalc.absorber.asked_tables import Tuning
    from vibecalc.absorber.tables import (
        Flywheel,
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
                "vibecalc.absorber.tables": "Flywheel Gap Oil OilCatalogue Pendulum Primary Ring "
                "Rod Secondaries Secondary SpringCatalogue Springs StockDampers StockOils "
                "StockSprings",
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
KindName = Literal["generator", "compressor", "plate", "absorber", "engine", "pump", "drive_train"]


class Machine(Table):
    """A machine: its kind says which parts it needs, and nothing else."""

    kind: KindName = Field(description="kind of machine")
    cycle: Cycle | None = Field(None, description="of an engine: 720 or 360 degrees")
    # None stands for a part that the kind does without (kinds.py); ask has_crank_train and
    # has_speed there before reading one of these two where that may be.
    speed: AngularSpeed = Field(
        NEEDED_BY_KIND,
        gt=0,
        description="operating speed of the crankshaft; not where the motor finds it",
    )
    crank_train: CrankTrain = Field(NEEDED_BY_KIND, description="cylinders, rods and cranks")
    body: Body | None = Field(None, description="the rigid machine")
    mounts: Mounts | None = Field(None, description="what the body stands on")
    motor: Motor | None = Field(None, description="the motor on the crankshaft")
    joints: Joints | None = Field(None, description="bearings with play")
    rotor: Rotor | None = Field(
        None,
        description="all that turns with the crankshaft; without it the crank turns steadily",
    )
    shell: Shell | None = Field(None, description="what turns about the crank axis, as one body")
    friction: Friction | None = Field(None, description="between shell, crankshaft and pistons")
    primary: Primary | None = Field(None, description="a system that an absorber is to keep still")
    secondary: Secondary | None = Field(None, description="the absorber on the primary")
    secondaries: Secondaries = Field((), description="several absorbers, instead of one")
    rod: Rod | None = Field(None, description="the rod that is the primary's spring")
    flywheel: Flywheel | None = Field(None, description="on the end of the rod, for its bending")
    springs: Springs | None = Field(None, description="helical springs of the absorber")
    ring: Ring | None = Field(None, description="the seismic mass of the absorber")
    gap: Gap | None = Field(None, description="full of oil, around the seismic mass")
    oil: Oil | None = Field(None, description="in the gap, as built")
    stock_springs: StockSprings = Field((), description="that can be bought")
    stock_oils: StockOils = Field((), description="that can be bought")
    stock_dampers: StockDampers = Field((), description="that can be bought, in translation")
    spring_catalogue: SpringCatalogue | None = Field(
        None, description="springs that can be bought, also as a file"
    )
    oil_catalogue: OilCatalogue | None = Field(
        None, description="oils that can be bought, also as a file"
    )
    pendulum: Pendulum | None = Field(None, description="pendulums on a rotor")
    shaft_line: ShaftLine | None = Field(
        None, description="of an engine or a drive train: what turns and twists"
    )

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

    rtol: Number = Field(
        1e-9, ge=1e-14, le=0.1, description="of the largest magnitude of each quantity"
    )


def _limits(row: Row) -> Iterator[Problem]:
    if "limit" in row:
        yield from named("vibecalc.core.case.tables:contradictions")(row)


class Case(Table):
    """One scene; a table that is absent is not computed."""

    schema_: Annotated[Literal[1], Whole] = Field(
        alias="schema", description="version of the case format"
    )
    title: str = Field(min_length=1, max_length=200, description="one line for reports and plots")
    source: str = Field("", description="where the machine is described")
    document: Document | None = Field(None, description="title block of the report")
    machine: Machine = Field(description="the machine and its parts")
    kinematics: Kinematics | None = Field(None, description="motion of the pistons")
    excitation: Excitation | None = Field(None, description="forces and couples on the body")
    balance: Balance | None = Field(None, description="weights for the least force and couple")
    response: Response | None = Field(None, description="motion of the body, energies, impacts")
    isolation: Isolation | None = Field(None, description="the body on its mounts")
    foundation: Foundation | None = Field(None, description="what the mounts stand on, if it moves")
    point: Points = Field((), description="places on the body where vibration is measured")
    vibration_severity: VibrationSeverity | None = Field(
        None, description="band and zones for the vibration at the points"
    )
    base_motion: BaseMotion | None = Field(None, description="how what carries the machine moves")
    bearing_loads: BearingLoads | None = Field(
        None, description="loads on crank pins, wrist pins and main bearings over a cycle"
    )
    measurement: Measurement | None = Field(None, description="readings on a rigid plate")
    tuning: Tuning | None = Field(None, description="the best spring and damper of an absorber")
    damper_design: DamperDesign | None = Field(None, description="the best damper of an engine")
    optimisation: Optimisation | None = Field(None, description="a search over keys of this case")
    fit: Fit | None = Field(None, description="keys of this case that fit what was measured")
    sweep: Sweep | None = Field(None, description="the same case at many points; `sweep` reads it")
    find: tuple[Find, ...] = Field((), description="searches for what brings a wanted result")
    accuracy: Accuracy = Field(default_factory=Accuracy, description="tolerance of the results")
    reference: tuple[Reference, ...] = Field((), description="published and measured numbers")
    reference_table: tuple[ReferenceTable, ...] = Field(
        (), description="published numbers in tables"
    )
    limit: tuple[Limit, ...] = Field((), description="bounds that results have to keep")
    RULES = (unique("find", "searches"), unique("point", "points"), _limits)
