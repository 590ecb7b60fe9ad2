"""A whole case: the machine, the stages asked for, the numbers it is held against."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.case.fields import AngularSpeed, Table, Whole
from vibecalc.case.gas_parts import Motor
from vibecalc.case.joint_parts import Joints
from vibecalc.case.parts import Body, CrankTrain, Mounts
from vibecalc.case.response_tables import Response
from vibecalc.case.sweep_tables import Sweep
from vibecalc.case.tables import (
    Accuracy,
    Excitation,
    Isolation,
    Kinematics,
    Limit,
    Optimisation,
    Reference,
    ReferenceTable,
)

SCHEMA_VERSION = 1


class Machine(Table):
    """A machine: its kind says which parts it needs, and nothing else."""

    kind: Literal["generator", "compressor"] = Field(description="kind of machine")
    speed: AngularSpeed = Field(gt=0, description="operating speed of the crankshaft")
    crank_train: CrankTrain = Field(description="cylinders, rods and cranks")
    body: Body | None = Field(None, description="the rigid machine")
    mounts: Mounts | None = Field(None, description="what the body stands on")
    motor: Motor | None = Field(None, description="the motor on the crankshaft")
    joints: Joints | None = Field(None, description="bearings with play")


class Case(Table):
    """One scene. A table that is absent is a stage that is not planned, imported or run."""

    schema_: Annotated[Literal[1], Whole] = Field(
        alias="schema", description="version of the case format"
    )
    title: str = Field(min_length=1, max_length=200, description="one line for reports and plots")
    source: str = Field("", description="where the machine is described")
    machine: Machine = Field(description="the machine and its parts")
    kinematics: Kinematics | None = Field(None, description="motion of the pistons")
    excitation: Excitation | None = Field(None, description="forces and couples on the body")
    response: Response | None = Field(None, description="motion of the body, energies, impacts")
    isolation: Isolation | None = Field(None, description="the body on its mounts")
    optimisation: Optimisation | None = Field(None, description="a search over keys of this case")
    sweep: Sweep | None = Field(None, description="the same case at many points; `sweep` reads it")
    accuracy: Accuracy = Field(
        default_factory=Accuracy.model_construct, description="tolerance of the results"
    )
    reference: tuple[Reference, ...] = Field((), description="published and measured numbers")
    reference_table: tuple[ReferenceTable, ...] = Field(
        (), description="published numbers in tables"
    )
    limit: tuple[Limit, ...] = Field((), description="bounds that results have to keep")
