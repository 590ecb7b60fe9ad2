"""A range of crank speeds."""

from pydantic import ConfigDict, Field

from vibecalc.case.fields import AngularSpeed, Table


class RunUp(Table):
    """A range of speeds passed slowly: at each speed the peak over the cycle."""

    model_config = ConfigDict(validate_by_alias=True, validate_by_name=False)

    start: AngularSpeed = Field(0.0, alias="from", ge=0, description="lowest speed")
    stop: AngularSpeed = Field(alias="to", gt=0, description="highest speed")
