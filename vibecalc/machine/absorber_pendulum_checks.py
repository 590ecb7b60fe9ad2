"""Does a pendulum swing about a stable place, on a path that reaches as far as it is asked?"""

from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, NumericalFailure, Problem

PENDULUM: KeyPath = ("machine", "pendulum")


def pendulum_problems(case: Case) -> list[Problem]:
    """Problems of the path, of the swing and of the angles asked for."""
    given = case.machine.pendulum
    if given is None:
        return []
    # these load what solves the motion
    from vibecalc.machine.absorber_pendulum import placed
    from vibecalc.response.pendulum.order import largest_swing

    problems = []
    if given.damping_ratio >= 1.0:
        problems.append(
            Problem(
                path=(*PENDULUM, "damping_ratio"),
                message="so damped a pendulum creeps and does not swing",
                found=f"{given.damping_ratio:.6g}",
                allowed="< 1, of critical damping",
            )
        )
    try:
        pendulum = placed(given)
    except NumericalFailure as failure:
        told = "path_radius" if given.path_radius is not None else "order"
        also = "vertex_distance" if given.vertex_distance is not None else "arm_radius"
        return [*problems, Problem(path=(*PENDULUM, told), message=str(failure),
                                   also=(*PENDULUM, also))]  # fmt: skip
    end = float(largest_swing(pendulum))
    if given.swings is not None and given.swings.to >= end:
        problems.append(
            Problem(
                path=(*PENDULUM, "swings", "to"),
                message="the swing leaves the path, which ends there in a cusp"
                if given.path != "circular"
                else "the swing goes round: it is half a turn to each side",
                found=f"{given.swings.to:.6g} rad",
                allowed=f"< {end:.6g} rad",
                hint="angles without a unit are in radians: '20 deg'",
                also=(*PENDULUM, "path") if given.path != "circular" else None,
            )
        )
    return problems
