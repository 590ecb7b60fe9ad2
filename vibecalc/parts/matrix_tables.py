"""Matrices of a body and of its suspension, given as a whole, as a case writes them."""

from typing import ClassVar

from vibecalc.core.case.fields import Name, Number, Table, key

SixNumbers = tuple[Number, Number, Number, Number, Number, Number]


class BlockMatrix(Table):
    """A symmetric 6 x 6 matrix in the order x y z rx ry rz, one unit for each kind of block."""

    #: SI units of the blocks, an angle counting as a plain number
    SI: ClassVar[tuple[str, str, str]]

    values: tuple[SixNumbers, SixNumbers, SixNumbers, SixNumbers, SixNumbers, SixNumbers] = key(
        "six rows of six numbers, in the order x y z rx ry rz"
    )
    units: tuple[Name, Name, Name] | None = key(
        "units of the blocks: translation, coupling, rotation; default SI", None
    )
    RULES = ("vibecalc.parts.rules:matrix_units",)


class MassMatrix(BlockMatrix):
    """Mass matrix of the body about its reference point."""

    SI: ClassVar[tuple[str, str, str]] = ("kg", "kg*m", "kg*m^2")


class StiffnessMatrix(BlockMatrix):
    """Stiffness of the whole suspension at the reference point."""

    SI: ClassVar[tuple[str, str, str]] = ("N/m", "N", "N*m")


class DampingMatrix(BlockMatrix):
    """Viscous damping of the whole suspension at the reference point."""

    SI: ClassVar[tuple[str, str, str]] = ("N*s/m", "N*s", "N*m*s")
