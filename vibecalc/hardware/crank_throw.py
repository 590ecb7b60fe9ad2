"""Moment of inertia of one crank throw about the axis of the crankshaft, from its dimensions.

Baca (2007, section 4.3.1) sums journal, pin, two webs, rod, piston with gudgeon pin and balance
weight and gives no formula for any of them. Each part is an exact integral over a plain body here;
fillets, oil holes and chamfers are left out. Lengths in m, masses in kg, density in kg/m^3,
inertias in kg m^2; all arguments broadcast.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.closed_form import closed_form, floats
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError


def journal_inertia(
    density: ArrayLike, diameter: ArrayLike, length: ArrayLike, bore: ArrayLike = 0.0
) -> WithError:
    """Of a round journal on the axis: pi rho L (D^4 - d^4) / 32; bore < diameter."""
    heavy, outer, long, inner = floats(density, diameter, length, bore)
    fourth = (outer - inner) * (outer + inner) * (outer * outer + inner * inner)
    return closed_form(math.pi / 32.0 * heavy * long * fourth, 12.0)


def pin_inertia(
    density: ArrayLike,
    diameter: ArrayLike,
    length: ArrayLike,
    crank_radius: ArrayLike,
    bore: ArrayLike = 0.0,
) -> WithError:
    """Of a crank pin whose centre runs at `crank_radius`: m (R^2 + (D^2 + d^2) / 8)."""
    heavy, outer, long, radius, inner = floats(density, diameter, length, crank_radius, bore)
    mass = 0.25 * math.pi * heavy * long * (outer - inner) * (outer + inner)
    return closed_form(mass * (radius**2 + (outer**2 + inner**2) / 8.0), 16.0)


def rectangular_web_inertia(
    density: ArrayLike,
    thickness: ArrayLike,
    width: ArrayLike,
    beyond_journal: ArrayLike,
    beyond_pin: ArrayLike,
    crank_radius: ArrayLike,
) -> WithError:
    """Of one web, a plate `width` across the throw.

    Along the throw it reaches from `beyond_journal` behind the axis of the journal to `beyond_pin`
    past the axis of the pin.
    """
    heavy, thick, wide, behind, past, radius = floats(
        density, thickness, width, beyond_journal, beyond_pin, crank_radius
    )
    top = radius + past
    # integral of y^2 + x^2 over the plate; the cubes of both ends count with the same sign
    along = wide * (top**3 + behind**3) / 3.0
    across = wide**3 * (top + behind) / 12.0
    return closed_form(heavy * thick * (along + across), 16.0)


def disc_ended_web_inertia(
    density: ArrayLike, thickness: ArrayLike, width: ArrayLike, crank_radius: ArrayLike
) -> WithError:
    """Of one web of straight flanks, ended by half discs about the axes of journal and pin."""
    heavy, thick, wide, radius = floats(density, thickness, width, crank_radius)
    end = 0.5 * wide
    straight = wide * radius**3 / 3.0 + wide**3 * radius / 12.0
    half = 0.5 * math.pi * end**2
    # the centre of a half disc lies 4 r / (3 pi) from its flat
    at_pin = half * (radius**2 + 2.0 * radius * 4.0 * end / (3.0 * math.pi) + 0.5 * end**2)
    return closed_form(heavy * thick * (straight + at_pin + half * 0.5 * end**2), 24.0)


def offset_body_inertia(
    mass: ArrayLike, distance: ArrayLike, own_inertia: ArrayLike = 0.0
) -> WithError:
    """Of any body whose mass centre runs at `distance`: m r^2 + J of the body about its centre.

    The rotating part of a rod is a point at the crank radius, with `own_inertia` zero.
    """
    heavy, far, own = floats(mass, distance, own_inertia)
    return closed_form(heavy * far**2 + own, 4.0)


def reciprocating_inertia(
    mass: ArrayLike, crank_radius: ArrayLike, rod_length: ArrayLike, method: str = "mean"
) -> WithError:
    """What a mass that goes up and down adds to the crank, a constant in place of its course.

    `"half"`: m R^2 / 2, as if the rod were endless. `"mean"`: the mean over a turn of
    m (dx / d theta)^2, m R^2 / (1 + sqrt(1 - (R / L)^2)), exact for a centred slider-crank. The
    inertia swings between zero at the dead centres and about twice that.
    """
    heavy, radius, rod = floats(mass, crank_radius, rod_length)
    ratio = radius / rod
    if method == "half":
        return closed_form(0.5 * heavy * radius**2 * np.ones_like(ratio), 3.0)
    if method != "mean":
        raise ValueError(f"unknown method {method!r}; known: half, mean")
    root = np.sqrt((1.0 - ratio) * (1.0 + ratio))
    value = np.asarray(heavy * radius**2 / (1.0 + root))
    # the root loses digits where crank and rod are nearly of one length
    lost = 8.0 + 2.0 / np.maximum(1.0 - ratio, UNIT_ROUNDOFF)
    return WithError(value, np.asarray(value * UNIT_ROUNDOFF * lost))


def throw_inertia(*parts: WithError) -> WithError:
    """Sum of the parts of a throw; a web counts twice where it is handed over twice."""
    value = np.asarray(sum(np.asarray(part.value, dtype=float) for part in parts))
    error = np.asarray(sum(np.asarray(part.error, dtype=float) for part in parts))
    return WithError(value, error + len(parts) * UNIT_ROUNDOFF * np.abs(value))
