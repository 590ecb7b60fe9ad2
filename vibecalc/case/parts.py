"""The parts of a machine as a case writes them. The kinds of machine share them all."""

import math
from typing import Annotated, Literal

from pydantic import Field

from vibecalc.case.engine_parts import GasCard, GasCycle
from vibecalc.case.fields import (
    Angle,
    DampingOrThree,
    Inertia,
    Length,
    Mass,
    Name,
    Number,
    Point,
    StiffnessOrThree,
    Table,
    Unbalance,
    Whole,
)
from vibecalc.case.gas_parts import GasForce, GasInterpolation, GasPressure
from vibecalc.case.matrix_parts import DampingMatrix, MassMatrix, StiffnessMatrix
from vibecalc.case.pump_parts import PumpCycle

AxisName = Literal["x", "y", "z"]


class Rod(Table):
    """A connecting rod as two point masses: one with the wrist pin, one with the crank pin."""

    mass: Mass = Field(gt=0, description="mass of one connecting rod")
    crank_pin_to_mass_centre: Length | None = Field(
        None, ge=0, description="distance from the crank pin to the mass centre of the rod"
    )
    reciprocating_fraction: Number | None = Field(
        None, ge=0, le=1, description="share of the rod mass that moves with the piston"
    )
    inertia: Inertia | None = Field(
        None, ge=0, description="about its own mass centre; default: that of the two point masses"
    )


class Cylinder(Table):
    """One cylinder and its throw."""

    name: Name = Field(description="label used in tables and in `where`")
    position: Length = Field(0.0, description="along the crankshaft, from the train's origin")
    crank_phase: Angle = Field(0.0, description="angle by which this throw leads crank angle zero")
    bank_angle: Angle = Field(0.0, description="tilt of the cylinder about the crank axis")
    reciprocating_mass: Mass | None = Field(
        None, ge=0, description="overrides the train's reciprocating mass for this cylinder"
    )
    rotating_mass: Mass | None = Field(
        None, ge=0, description="overrides the train's rotating mass for this throw"
    )
    firing_angle: Angle | None = Field(
        None, ge=0, description="crank angle at which it fires, of an engine; or firing_order"
    )
    pressure_scale: Number | None = Field(
        None, ge=0, le=3, description="of the gas pressure of an engine, 0.9: weak; default: 1"
    )
    gas_force: GasForce | None = Field(
        None, description="of the gas over one turn, instead of pressure and bore: a table or a CSV"
    )


class Counterweight(Table):
    """A weight fixed to the crankshaft."""

    name: Name = Field("counterweight", description="label")
    unbalance: Unbalance = Field(ge=0, description="mass times radius")
    phase: Angle = Field(0.0, description="angle by which it leads crank angle zero")
    position: Length = Field(0.0, description="along the crankshaft, from the train's origin")


class BalanceShaft(Table):
    """An extra shaft with an unbalance, geared to the crankshaft."""

    name: Name = Field("balance shaft", description="label")
    unbalance: Unbalance = Field(ge=0, description="mass times radius")
    speed_ratio: Annotated[Literal[-2, -1, 1, 2], Whole] = Field(
        description="shaft speed over crank speed; negative turns the other way"
    )
    phase: Angle = Field(0.0, description="angle of the unbalance from the stroke at crank angle 0")
    position: Point = Field((0.0, 0.0, 0.0), description="from the train's origin, along x, y, z")


class CrankTrain(Table):
    """Cylinders, rods and cranks, and what is put in to balance them."""

    axis: AxisName = Field("x", description="direction of the crankshaft")
    stroke: AxisName = Field("z", description="direction of a cylinder at bank angle zero")
    origin: Point = Field(
        (0.0, 0.0, 0.0), description="origin of the train, from the body's reference point"
    )
    crank_radius: Length = Field(gt=0, description="half the stroke")
    rod_length: Length = Field(gt=0, description="between the centres of the rod's bearings")
    wrist_pin_offset: Length = Field(
        0.0, description="of the cylinder axis from the crank axis, towards a crank angle of 90 deg"
    )
    reciprocating_mass: Mass | None = Field(
        None, ge=0, description="of one cylinder; or give piston_mass, pin_mass and rod"
    )
    piston_mass: Mass | None = Field(None, gt=0, description="of one piston with its rings")
    pin_mass: Mass | None = Field(None, ge=0, description="of one wrist pin")
    rod: Rod | None = Field(None, description="the connecting rod, split into two point masses")
    rotating_mass: Mass = Field(
        0.0, ge=0, description="unbalanced mass at the crank pin of each cylinder, without the rod"
    )
    bore: Length | None = Field(None, gt=0, description="diameter of the cylinders")
    gas_pressure: GasPressure | None = Field(
        None,
        description="pressure over one turn of a cylinder, from its top dead centre; of an engine "
        "over one cycle, from the firing one",
    )
    gas_cards: tuple[GasCard, ...] = Field(
        (), max_length=64, description="of an engine, at several speeds, instead of gas_pressure"
    )
    gas_cycle: GasCycle | None = Field(
        None, description="of an engine, computed, instead of gas_pressure"
    )
    pump_cycle: PumpCycle | None = Field(
        None, description="of a pump: the pressure on its plungers over a turn"
    )
    firing_order: Annotated[tuple[Name, ...], Field(max_length=64)] = Field(
        (), description="names of the cylinders of an engine, as they fire"
    )
    firing_intervals: Annotated[tuple[Angle, ...], Field(max_length=64)] = Field(
        (), description="from each of firing_order to the next; default: even ones"
    )
    gas_interpolation: GasInterpolation | None = Field(
        None,
        description="between the rows of gas tables, for the roll of the machine, linear if not "
        "said",
    )
    cylinders: tuple[Cylinder, ...] = Field(
        min_length=1, max_length=64, description="one entry for each cylinder"
    )
    counterweights: tuple[Counterweight, ...] = Field(
        (), max_length=64, description="weights on the crankshaft"
    )
    balance_shafts: tuple[BalanceShaft, ...] = Field(
        (), max_length=64, description="shafts geared to the crankshaft"
    )

    @property
    def has_banks(self) -> bool:
        """Whether cylinders push along different lines, so that only vectors of them add."""
        first = self.cylinders[0].bank_angle
        away = [math.remainder(c.bank_angle - first, 2.0 * math.pi) for c in self.cylinders]
        return any(abs(angle) > 1e-9 for angle in away)


class Box(Table):
    """A uniform block, edges along x, y and z."""

    length: Length = Field(gt=0, description="edge along x")
    width: Length = Field(gt=0, description="edge along y")
    height: Length = Field(gt=0, description="edge along z")


class InertiaBlock(Table):
    """A block bolted to the body: its mass, inertia and weight count."""

    mass: Mass = Field(ge=0, description="mass of the block")
    box: Box = Field(description="its edges, for its own inertia")
    position: Point = Field(
        (0.0, 0.0, 0.0), description="of its mass centre, from the body's reference point"
    )


class Body(Table):
    """The rigid machine. Its reference point is its mass centre without the inertia block."""

    mass: Mass | None = Field(None, gt=0, description="of the whole machine")
    box: Box | None = Field(None, description="inertia from a uniform block; or give inertia")
    inertia: tuple[Inertia, Inertia, Inertia] | None = Field(
        None, description="moments Ixx, Iyy, Izz about the mass centre"
    )
    inertia_products: tuple[Inertia, Inertia, Inertia] = Field(
        (0.0, 0.0, 0.0), description="products Ixy, Ixz, Iyz: sums of m x y, m x z, m y z"
    )
    inertia_block: InertiaBlock | None = Field(None, description="a block added to the machine")
    mass_matrix: MassMatrix | None = Field(
        None, description="of the whole machine, instead of all of these"
    )


class MountProperties(Table):
    """Stiffness and damping, one number for all directions or three along the mount's own axes."""

    stiffness: StiffnessOrThree | None = Field(
        None, description="one number, or three along the mount's own axes"
    )
    damping: DampingOrThree | None = Field(
        None, description="viscous, one number or three along the mount's own axes"
    )
    loss_factor: Number | None = Field(
        None, ge=0, le=10, description="of a complex stiffness k (1 + i loss_factor)"
    )


class Mount(MountProperties):
    """One mount; what it does not say comes from `each`."""

    name: Name = Field(description="label used in tables and in `where`")
    position: Point = Field(description="from the body's reference point")
    orientation: tuple[Angle, Angle, Angle] = Field(
        (0.0, 0.0, 0.0), description="rotations of the mount's axes about x, then y, then z"
    )


class Mounts(Table):
    """What the body stands on."""

    each: MountProperties | None = Field(None, description="common to all mounts")
    positions: tuple[Point, ...] | None = Field(
        None, min_length=1, max_length=256, description="of equal mounts, named 1, 2, 3 ..."
    )
    individual: tuple[Mount, ...] | None = Field(
        None, min_length=1, max_length=256, description="mounts one by one, instead of positions"
    )
    stiffness_matrix: StiffnessMatrix | None = Field(
        None, description="of the whole suspension, instead of mounts"
    )
    damping_matrix: DampingMatrix | None = Field(
        None, description="of the whole suspension, with stiffness_matrix"
    )
    loss_factor: Number | None = Field(
        None, ge=0, le=10, description="of a complex stiffness_matrix K (1 + i loss_factor)"
    )
    modal_damping: Number | None = Field(
        None, ge=0, le=10, description="damping ratio of every mode, added to what else damps"
    )
