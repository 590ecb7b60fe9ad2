"""The parts of a machine whose shell turns about the crank axis: rotor, shell, friction."""

from pydantic import Field

from vibecalc.case.fields import AngularDamping, AngularStiffness, Force, Inertia, Moment, Table


class Rotor(Table):
    """All that turns with the crankshaft, besides the rotating masses of the crank train."""

    inertia: Inertia = Field(gt=0, description="about the crank axis, with coupling and flywheel")


class Shell(Table):
    """Stator, housing and baseplate as one rigid body that turns about the crank axis."""

    inertia: Inertia = Field(gt=0, description="about the crank axis, without what moves in it")
    stiffness: AngularStiffness = Field(
        0.0, ge=0, description="of the mounts against roll; with a damping of zero too: no mounts"
    )
    damping: AngularDamping = Field(
        0.0, ge=0, description="of the mounts against roll; a negative one would feed energy in"
    )


class Friction(Table):
    """What opposes the motion of crankshaft and pistons in the shell."""

    torque: Moment = Field(
        0.0, ge=0, description="constant, on the crankshaft; a negative one would drive it"
    )
    viscous: AngularDamping = Field(
        0.0, ge=0, description="on the crankshaft; a negative one would feed energy in"
    )
    piston_force: Force = Field(
        0.0, ge=0, description="constant, at each piston; a negative one would drive it"
    )
