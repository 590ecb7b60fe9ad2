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
    """A machine; its kind decides which parts it needs."""

    kind: KindName = key("kind of machine")
    cycle: Cycle | None = key("of an engine: 720 or 360 degrees", None)
    # None stands for a part that the kind does without (kinds.py); ask has_crank_train and
    # has_speed there before reading one of these two where that may be.
    speed: AngularSpeed = key(
        "operating speed of the crankshaft, unless the motor determines it", NEEDED_BY_KIND, gt=0
    )
    crank_train: CrankTrain = key("cylinders, rods and cranks", NEEDED_BY_KIND)
    body: Body | None = key("rigid body of the machine", None)
    mounts: Mounts | None = key("mounts below the body", None)
    motor: Motor | None = key("motor on the crankshaft", None)
    joints: Joints | None = key("bearings with clearance", None)
    rotor: Rotor | None = key("rotating parts; without it the crank turns at constant speed", None)
    shell: Shell | None = key("stator, housing and baseplate that roll about the crank axis", None)
    friction: Friction | None = key("between shell, crankshaft and pistons", None)
    primary: Primary | None = key("primary system of an absorber", None)
    secondary: Secondary | None = key("absorber on the primary", None)
    secondaries: Secondaries = key("several absorbers, instead of one", ())
    rod: Rod | None = key("round rod as the primary's spring", None)
    flywheel: Flywheel | None = key("on the free end of the rod, for bending", None)
    springs: Springs | None = key("helical springs of the absorber", None)
    ring: Ring | None = key("seismic mass of the absorber", None)
    gap: Gap | None = key("oil-filled gap around the seismic mass", None)
    oil: Oil | None = key("oil in the gap", None)
    stock_springs: StockSprings = key("stock springs to choose from", ())
    stock_oils: StockOils = key("stock oils to choose from", ())
    stock_dampers: StockDampers = key("stock dampers to choose from, in translation", ())
    spring_catalogue: SpringCatalogue | None = key("stock springs as a table or a CSV", None)
    oil_catalogue: OilCatalogue | None = key("stock oils as a table or a CSV", None)
    friction_damper: FrictionDamper | None = key(
        "Lanchester damper on the primary, with dry friction", None
    )
    pendulum: Pendulum | None = key("centrifugal pendulums on a rotor", None)
    shaft_line: ShaftLine | None = key("shaft line of an engine or a drive train", None)

    RULES = ("vibecalc.kinds:check_kinds",)

    @model_validator(mode="before")
    @classmethod
    def _phases(cls, data: Any) -> Any:
        """Where no throw of an engine says its phase, the order of firing does."""
        if isinstance(data, dict) and data.get("kind") == "engine":
            return named("vibecalc.parts.firing:with_phases")(data)
        return data


class Accuracy(Table):
    """Tolerance of the results."""

    rtol: Number = key("relative to the largest magnitude of each quantity", 1e-9, ge=1e-14, le=0.1)


def _limits(row: Row) -> Iterator[Problem]:
    if "limit" in row:
        yield from named("vibecalc.core.case.tables:contradictions")(row)


class Case(Table):
    """A case; tables that are absent are not computed."""

    schema_: Annotated[Literal[1], Whole] = key("version of the case format", alias="schema")
    title: str = key("one line, for reports and plots", min_length=1, max_length=200)
    source: str = key("origin of the machine data", "")
    document: Document | None = key("title block of the report to hand in", None)
    machine: Machine = key("the machine and its parts")
    kinematics: Kinematics | None = key("motion of the pistons", None)
    excitation: Excitation | None = key("forces and couples on the body", None)
    balance: Balance | None = key("balance weights that minimise force and couple", None)
    response: Response | None = key("motion of the body, energies, impacts", None)
    isolation: Isolation | None = key("the body on its mounts", None)
    foundation: Foundation | None = key("flexible support below the mounts", None)
    point: Points = key("measuring points on the body", ())
    vibration_severity: VibrationSeverity | None = key(
        "band and zones for vibration at the points", None
    )
    base_motion: BaseMotion | None = key("motion of the base below the mounts", None)
    bearing_loads: BearingLoads | None = key(
        "loads on crank pins, wrist pins and main bearings", None
    )
    measurement: Measurement | None = key("readings on a rigid plate", None)
    tuning: Tuning | None = key("optimum spring and damper of an absorber", None)
    damper_design: DamperDesign | None = key("optimum damper of an engine", None)
    optimisation: Optimisation | None = key("optimise keys of this case", None)
    fit: Fit | None = key("fit keys of this case to measurements", None)
    sweep: Sweep | None = key("grid of points, for `vibecalc sweep`", None)
    find: tuple[Find, ...] = key("find the value of a key that gives a wanted result", ())
    accuracy: Accuracy = key("tolerance of the results", default_factory=Accuracy)
    reference: tuple[Reference, ...] = key("published and measured numbers", ())
    reference_table: tuple[ReferenceTable, ...] = key("published numbers in tables", ())
    limit: tuple[Limit, ...] = key("limits on results", ())
    RULES = (unique("find", "searches"), unique("point", "points"), _limits)
