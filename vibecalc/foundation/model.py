"""The foundation of a case as arrays, and whether machine and foundation can stand like that."""

from collections.abc import Iterator

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import KeyPath, Problem
from vibecalc.foundation.systems import (
    Curve,
    FlexibleFoundation,
    on_guided_mass,
    on_second_body,
    on_second_mass,
)
from vibecalc.foundation.tables import CURVES, Flexibility, Foundation
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.parts import body_tables as parts
from vibecalc.parts.body import COORDINATES, DIRECTIONS, RigidBody, build_body, moment_problems
from vibecalc.parts.mount_needs import foundation_kind, moves_with_machine
from vibecalc.parts.mounts import Mounts, build_mounts, free_motions, mount_entries
from vibecalc.schema import Case

FOUNDATION: KeyPath = ("foundation",)


def on_mass(scene: Scene) -> tuple[OnMounts, OnMounts]:
    """Machine and foundation as two masses that move up and down, and the machine alone."""
    case, body, mounts = scene.case, scene.parts.body, scene.parts.mounts
    given, options = case.foundation, case.isolation
    assert given is not None and options is not None and body is not None and mounts is not None
    assert given.mass is not None and given.stiffness is not None
    spring = given.stiffness, given.damping, given.loss_factor * given.stiffness
    return on_second_mass(body, mounts, DIRECTIONS.index(options.up), given.mass, spring)


def on_floor(scene: Scene, freedoms: np.ndarray) -> OnMounts:
    """The machine in its motions on a foundation of one mass, which moves up and down only."""
    case, body, mounts = scene.case, scene.parts.body, scene.parts.mounts
    given, options = case.foundation, case.isolation
    assert given is not None and options is not None and body is not None and mounts is not None
    assert given.mass is not None and given.stiffness is not None
    spring = given.stiffness, given.damping, given.loss_factor * given.stiffness
    up = DIRECTIONS.index(options.up)
    return on_guided_mass(body, mounts, freedoms, up, given.mass, spring)


def on_body(given: Foundation, body: RigidBody, mounts: Mounts) -> OnMounts:
    """Machine and foundation as two rigid bodies."""
    assert given.body is not None and given.springs is not None
    second, springs = build_body(given.body), build_mounts(given.springs)
    return on_second_body(body, mounts, second, _position(given), springs)


def _position(given: Foundation) -> np.ndarray:
    return np.zeros(3) if given.position is None else np.asarray(given.position)


def flexible_foundation(given: Foundation, names: tuple[str, ...]) -> FlexibleFoundation:
    """Tables of a foundation by mounts and directions; of several that fit the last counts."""
    feet, plate = {}, {}
    for one in given.flexibilities or ():
        curve, direction = _curve(one), COORDINATES.index(one.direction)
        if one.at == "whole":
            plate[direction] = curve
            continue
        for place, name in enumerate(names):
            if one.mounts is None or name in one.mounts:
                feet[place, direction] = curve
    return FlexibleFoundation(feet, plate, _position(given))


def _curve(one: Flexibility) -> Curve:
    name = _key(one)
    found = getattr(one, name)
    value = np.asarray(found.real) + 1j * np.asarray(found.imaginary)
    return Curve(np.asarray(found.frequency), value, name.endswith("impedance"))


def _key(one: Flexibility) -> str:
    return next(key for key in CURVES if getattr(one, key) is not None)


# ----------------------------------------------------------------------------
# Can machine and foundation stand like that?
# ----------------------------------------------------------------------------


def coupled_problems(case: Case) -> Iterator[Problem]:
    """Problems of a foundation with six freedoms, or of tables."""
    given, options, mounts = case.foundation, case.isolation, case.machine.mounts
    assert given is not None and options is not None and mounts is not None
    kind = foundation_kind(case)
    if kind == "mass":
        return
    if options.model != "rigid_body":
        yield Problem(
            path=("isolation", "model"),
            message=f"a foundation of kind {kind!r} needs a machine with six degrees of freedom",
            found=f"model = '{options.model}'",
            allowed="model = 'rigid_body'",
            also=FOUNDATION,
        )
    elif given.body is not None and given.springs is not None:
        yield from moment_problems((*FOUNDATION, "body"), given.body)
        yield from _springs(given.springs)
    else:
        yield from _flexibilities([one.name for one in mount_entries(mounts)], given)


def foundation_cautions(case: Case) -> list[str]:
    """What is not computed on the foundation."""
    kind = foundation_kind(case)
    run_up = case.isolation is not None and case.isolation.run_up is not None
    texts = {
        "the run-up is that of the machine on a rigid foundation: a [foundation] of tables counts "
        "at the operating speed only; one mass or a body counts in both": (
            run_up and kind == "impedance"
        ),
        "[isolation] model = 'pitch' is computed on rigid ground: a [foundation] of one mass moves "
        "up and down only, which pitching does not excite": (
            kind == "mass" and not moves_with_machine(case)
        ),
    }
    return [text for text, holds in texts.items() if holds]


def _springs(springs: parts.Mounts) -> Iterator[Problem]:
    if motions := free_motions(build_mounts(springs)):
        yield Problem(
            path=(*FOUNDATION, "springs"),
            message="the springs do not restrain the foundation",
            found="nothing resists " + ", ".join(motions),
            allowed="a stiffness against each of the six motions",
            hint="give stiffness in three directions, and spread the springs",
        )


def _flexibilities(names: list[str], given: Foundation) -> Iterator[Problem]:
    """Mounts that are not there, directions that two curves tell, and curves that feed the machine.

    With exp(i w t) the part that takes energy is positive.
    """
    seen: dict[tuple[str, str], int] = {}
    for place, one in enumerate(given.flexibilities or ()):
        path, key, curve = (*FOUNDATION, "flexibilities", place), _key(one), _curve(one)
        for number, name in enumerate(one.mounts or ()):
            if name not in names:
                yield Problem(
                    path=(*path, "mounts", number),
                    message=f"no mount is named {name[:60]!r}",
                    allowed=", ".join(repr(one) for one in names[:12]),
                )
        where = ["whole"] if one.at == "whole" else [f"mount {n}" for n in one.mounts or names]
        firsts = [seen.setdefault((name, one.direction), place) for name in where]
        twice = next((i for i, first in enumerate(firsts) if first != place), None)
        if twice is not None:
            yield Problem(
                path=path,
                message="the foundation has two flexibilities for one direction: "
                f"{where[twice]}, {one.direction}",
                allowed="each direction once for each mount and for the whole",
                also=(*FOUNDATION, "flexibilities", firsts[twice]),
            )
        part, column = (
            (curve.value.real, "real") if curve.by_velocity else (curve.value.imag, "imaginary")
        )
        if np.any(part < 0.0):
            row = int(np.argmax(part < 0.0))
            yield Problem(
                path=(*path, key, column, row),
                message="the foundation would feed energy into the machine",
                found=f"{part[row]:.6g} in row {row + 1}",
                allowed=">= 0: dissipation is positive",
                hint="with motion as exp(i w t); conjugate data of the other sign",
            )
