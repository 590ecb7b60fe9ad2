"""Is there a body with these moments of inertia?"""

import numpy as np

from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, Problem
from vibecalc.machine.body import machine_inertia

BODY: KeyPath = ("machine", "body")
#: Slack of the triangle inequality, relative: flat bodies are on its edge, digits are rounded.
SLACK = 1e-6


def body_problems(case: Case) -> list[Problem]:
    """Problems of the moments and products of inertia."""
    body = case.machine.body
    if body is None or body.inertia is None:
        return []
    names = ("Ixx", "Iyy", "Izz")
    problems = [
        Problem(
            path=(*BODY, "inertia"),
            message=f"the moment of inertia {name} must be positive",
            found=f"{moment:.6g} kg*m^2",
            allowed="> 0 kg*m^2",
        )
        for name, moment in zip(names, body.inertia, strict=True)
        if moment <= 0.0
    ]
    if problems:
        return problems
    with_products = any(body.inertia_products)
    principal = np.linalg.eigvalsh(machine_inertia(body))
    shown = ", ".join(f"{moment:.6g}" for moment in principal)
    if principal[0] <= 1e-12 * principal[2]:
        return [
            Problem(
                path=(*BODY, "inertia_products"),
                message="no body has these products of inertia: they are too large for its moments",
                found=f"principal moments of {shown} kg*m^2",
                allowed="all principal moments > 0",
                also=(*BODY, "inertia"),
            )
        ]
    if principal[2] > (principal[0] + principal[1]) * (1.0 + SLACK):
        what = "principal moments" if with_products else "moments"
        return [
            Problem(
                path=(*BODY, "inertia"),
                message="no body has these moments of inertia: the largest must not exceed the "
                "sum of the other two",
                found=f"{what} of {shown} kg*m^2",
                allowed=f"the largest at most {principal[0] + principal[1]:.6g} kg*m^2",
            )
        ]
    return []
