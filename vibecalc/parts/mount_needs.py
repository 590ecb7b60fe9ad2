"""What the mounts of a case depend on, read from their tables: nothing is computed."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vibecalc.parts import body_tables as parts
    from vibecalc.schema import Case


def mount_properties(mounts: "parts.Mounts") -> "list[parts.MountProperties]":
    """All tables with properties of mounts, that of `each` first."""
    each = [] if mounts.each is None else [mounts.each]
    return [*each, *(mounts.individual or ())]


def loads_count(mounts: "parts.Mounts") -> bool:
    """Whether properties of a mount depend on what it carries, or its stiffness at rest differs."""
    return any(
        one.static is not None or one.over_load is not None for one in mount_properties(mounts)
    )


def frequency_counts(mounts: "parts.Mounts") -> bool:
    """Whether properties of a mount depend on the frequency of its vibration."""
    return any(one.over_frequency is not None for one in mount_properties(mounts))


def has_stops(mounts: "parts.Mounts") -> bool:
    """Whether a mount has stops."""
    return any(
        one.static is not None and one.static.stops is not None for one in mount_properties(mounts)
    )


def why_alone(case: "Case") -> str:
    """Why the points of a sweep go through one by one, "" where they need not."""
    mounts = case.machine.mounts
    if mounts is None or not (loads_count(mounts) or frequency_counts(mounts)):
        return ""
    return "mounts that follow load or frequency are solved point by point"


# ----------------------------------------------------------------------------
# What the mounts stand on.
# ----------------------------------------------------------------------------


def foundation_kind(case: "Case") -> str:
    """What the foundation is; nothing without one."""
    return "" if case.foundation is None else case.foundation.kind or "mass"


def moves_with_machine(case: "Case") -> bool:
    """Whether machine and foundation are solved together, in all motions of the machine.

    A machine that only pitches does not move a mass that goes up and down.
    """
    kind, options = foundation_kind(case), case.isolation
    if kind == "mass":
        return options is not None and options.model != "pitch"
    return kind != ""


def run_up_on_foundation(case: "Case") -> bool:
    """Whether a run-up is that of machine and foundation; tables count at the speed only."""
    return moves_with_machine(case) and foundation_kind(case) != "impedance"
