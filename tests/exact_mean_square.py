"""Mean squares with many digits, from moments instead of the package's multiplied-out forms.

With r_j the integral of x^(2 j) / |D(ix)|^2 over all x, the integrals of s^j / D(-s) along the
imaginary axis, closed to the left where D(-s) has no root, give n linear equations for the n
moments: zero for j < n - 1, and half a turn at infinity for j = n - 1.
"""

from mpmath import matrix, mp, mpf


def integral(above: list[mpf], below: list[mpf]) -> mpf:
    """Integral of |N(ix) / D(ix)|^2 over all x; coefficients lowest power first, degree N < D."""
    n = len(below) - 1
    system, right = matrix(n, n), matrix(n, 1)
    for j in range(n):
        for power, value in enumerate(below):
            if (power + j) % 2 == 0:
                half = (power + j) // 2
                system[j, half] += (-1) ** half * value
    right[n - 1] = (-1) ** (n + 1) * mp.pi / below[n]
    moments = mp.lu_solve(system, right)
    total = mpf(0)
    for i, first in enumerate(above):
        for j, second in enumerate(above):
            if (i + j) % 2 == 0:
                total += (-1) ** ((i - j) // 2) * first * second * moments[(i + j) // 2]
    return total


def product(first: list[mpf], second: list[mpf]) -> list[mpf]:
    """Coefficients of a product of polynomials."""
    result = [mpf(0)] * (len(first) + len(second) - 1)
    for i, a in enumerate(first):
        for j, b in enumerate(second):
            result[i + j] += a * b
    return result


def plus(first: list[mpf], second: list[mpf]) -> list[mpf]:
    """Coefficients of a sum of polynomials."""
    size = max(len(first), len(second))
    pad = [list(p) + [mpf(0)] * (size - len(p)) for p in (first, second)]
    return [a + b for a, b in zip(*pad, strict=True)]


def exact_mean_square(kind: str, z1: float, m: float, k: mpf | float, z: mpf | float) -> mpf:
    """Mean square of one kind of response, from the determinant of the equations of motion.

    Kinds: "displacement", "velocity", "transmitted" (of a white force), "base" (force on the
    ground by white ground acceleration), "travel" and "base travel" (secondary against primary).
    """
    z1, m, k, z = (mpf(value) for value in (z1, m, k, z))
    link, drag = [k, 2 * z], [mpf(1), 2 * z1]
    inner = plus([mpf(0), mpf(0), m], link)
    outer = plus(plus([mpf(0), mpf(0), mpf(1)], drag), link)
    below = plus(product(outer, inner), [-c for c in product(link, link)])
    above = {
        "displacement": inner,
        "velocity": [mpf(0), *inner],
        "transmitted": product(drag, inner),
        "base": product(drag, plus(inner, [m * c for c in link])),
        "travel": [mpf(0), mpf(0), m],
        "base travel": product(drag, [m]),
    }[kind]
    while below[0] == 0 and above[0] == 0:
        below, above = below[1:], above[1:]
    return integral(above, below)
