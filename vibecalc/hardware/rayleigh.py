"""Rayleigh's quotient for the bending of a rod on two supports with a mass on its free end.

The rod is assumed to bend as b(x) = sin(pi x / L), L the distance of the supports, beyond the
second one too (Baca 2007, section 3.16):

    w^2 = E I int b''^2 dx / (m int b^2 dx + M b(e)^2 [+ Jd b'(e)^2])

with integrals from 0 to the end e = L + a, and m the mass of the rod *per length*. The printed
frequencies come from the whole mass of the rod in its place, which has another dimension. A
quotient lies above the lowest frequency; this shape is bent at the free end, where a rod with a
point mass is straight, and how far above is not known from the quotient: see `overhung_rod`.
"""

import math

import numpy as np

from vibecalc.hardware.overhung_parts import EndBody, OverhungRod
from vibecalc.numerics.closed_form import closed_form, floats
from vibecalc.numerics.rounding import WithError


def rayleigh_frequency(rod: OverhungRod, body: EndBody) -> WithError:
    """Angular frequency in rad/s; broadcasts. With the rotary inertia of the body if it has one.

    A body whose mass centre lies off the end moves there with b(e) + offset * b'(e).
    """
    stiff, line, span, overhang = floats(*rod)
    mass, diametral, offset = floats(body.mass, body.diametral_inertia, body.offset)
    wave = math.pi / span
    reach = span + overhang
    beyond = wave * overhang
    # sin^2 over the whole rod: half its length less sin(2 pi e / L) / (4 pi / L)
    square = 0.5 * reach - np.sin(2.0 * beyond) / (4.0 * wave)
    end, slope = -np.sin(beyond), -wave * np.cos(beyond)
    moved = np.square(end + offset * slope)
    kinetic = line * square + mass * moved + diametral * slope**2
    found = closed_form(wave**2 * np.sqrt(stiff * square / kinetic), 20.0)
    # the two parts of the motion of the mass may cancel
    lost = mass * (np.square(end) + np.square(offset * slope)) / kinetic
    return found._replace(error=np.asarray(found.error * (1.0 + lost)))
