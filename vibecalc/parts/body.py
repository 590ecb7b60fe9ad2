"""The rigid machine in its axes, with its inertia block, and whether such a body exists."""

import functools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibecalc.errors import KeyPath, Problem, listing
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.leading import side_by_side
from vibecalc.numerics.rounding import DATA_ROUNDINGS, UNIT_ROUNDOFF, BoolArray
from vibecalc.parts import body_tables as parts
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Directions of a crank train in the body's axes x, y, z.
# ----------------------------------------------------------------------------

DIRECTIONS = ("x", "y", "z")
#: of a rigid body about its reference point, as all matrices have them
COORDINATES = (*DIRECTIONS, "rx", "ry", "rz")


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Frame:
    """Right-handed unit vectors (3,): the crank turns right-handed about `axis`.

    `stroke` points up a cylinder at bank angle zero and `across = stroke x axis`, so that a throw
    that has turned by 90 degrees from the stroke points along `-across`.
    """

    axis: NDArray[np.float64]
    stroke: NDArray[np.float64]
    across: NDArray[np.float64]


def unit_vector(name: str) -> NDArray[np.float64]:
    """Unit vector (3,) along the body axis called `x`, `y` or `z`."""
    vector = np.zeros(3)
    vector[DIRECTIONS.index(name)] = 1.0
    return vector


def dofs_of_model(model: str, axis: str) -> NDArray[np.intp]:
    """All six of `rigid_body`; of `planar` the two translations and the turn in the crank plane.

    The crank plane is square to the crankshaft `axis`: pistons, rods and throws move in it.
    """
    if model != "planar":
        return np.arange(6)
    along = DIRECTIONS.index(axis)
    return np.array([*(place for place in range(3) if place != along), 3 + along])


@functools.lru_cache(maxsize=9)
def build_frame(axis: str, stroke: str) -> Frame:
    """Frame of a train from the names of its crankshaft axis and stroke, which differ."""
    along, up = unit_vector(axis), unit_vector(stroke)
    frame = Frame(axis=along, stroke=up, across=np.cross(up, along))
    for vector in (frame.axis, frame.stroke, frame.across):
        vector.flags.writeable = False  # every machine of these directions shares them
    return frame


# ----------------------------------------------------------------------------
# The rigid machine, with or without an inertia block bolted to it.
# ----------------------------------------------------------------------------

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class RigidBody:
    """A rigid body, seen from its reference point.

    `mass` in kg; `centre` (3,) of all the mass, in m from the reference point; `mass_matrix`
    (6, 6) about the reference point in the order x y z rx ry rz; `inertia` (3, 3) in kg m^2 about
    `centre`. Where numbers of the case are arrays (points,), so are these with a leading axis.
    Errors are absolute, of what is left where terms of several parts cancel; None: of rounding.
    """

    mass: float
    centre: Array
    mass_matrix: Array
    inertia: Array
    centre_error: Array | None = None
    mass_error: Array | None = None
    inertia_error: Array | None = None

    def bounded_mass(self) -> Bounded:
        """The mass matrix with its error, of rounding where it has none of its own."""
        if self.mass_error is not None:
            return Bounded(self.mass_matrix, self.mass_error)
        return rounded(self.mass_matrix, DATA_ROUNDINGS)


def cross_matrix(vector: Array) -> Array:
    """Matrix (..., 3, 3) of the product `vector x`, for vectors (..., 3)."""
    x, y, z = np.moveaxis(vector, -1, 0)
    none = np.zeros(np.shape(x))
    rows = ([none, -z, y], [z, none, -x], [-y, x, none])
    return side_by_side([side_by_side(row) for row in rows], own=1)


def _diagonal(entries: Sequence[float | Array]) -> Array:
    """Matrix (..., 3, 3) of three numbers or arrays (...) on its diagonal."""
    return np.asarray(side_by_side(entries)[..., None, :] * np.eye(3))


def _sums_of_squares(x: Any, y: Any, z: Any) -> Array:
    return _diagonal([y * y + z * z, x * x + z * z, x * x + y * y])


def point_inertia(mass: float | Array, position: Array) -> Array:
    """Inertia (..., 3, 3) in kg m^2 of point masses about the origin (Huygens, Steiner)."""
    products = position[..., :, None] * position[..., None, :] * (1.0 - np.eye(3))
    squares = _sums_of_squares(*np.moveaxis(position, -1, 0))
    return np.asarray(np.asarray(mass)[..., None, None] * (squares - products))


def box_inertia(mass: float | Array, box: parts.Box) -> Array:
    """Inertia (..., 3, 3) in kg m^2 of a uniform block about its own centre."""
    twelfth = np.asarray(mass / 12.0)[..., None, None]
    return np.asarray(_sums_of_squares(box.length, box.width, box.height) * twelfth)


def inertia_of(given: parts.Body | parts.BodyPart) -> Array:
    """Inertia (..., 3, 3) in kg m^2 of a body without its block, or a part, about its centre."""
    if given.inertia is None:
        if given.box is None or given.mass is None:
            raise ValueError("a body needs a box or moments of inertia")
        return box_inertia(given.mass, given.box)
    xy, xz, yz = given.inertia_products
    rows = ([0.0, xy, xz], [xy, 0.0, yz], [xz, yz, 0.0])
    off_diagonal = side_by_side([side_by_side(row) for row in rows], own=1)
    return np.asarray(_diagonal(given.inertia) - off_diagonal)


def build_body(body: parts.Body) -> RigidBody:
    """The rigid body of a validated one: of its parts, or of the machine and its inertia block.

    The kinetic energy is m v.v/2 + v.(w x S) + w.J w/2 with v of the reference point, the static
    moment S and the inertia J about that point (Goldstein, Classical Mechanics, ch. 5); the
    theorem of parallel axes is taken from the reference point and from the common centre.
    """
    given: list[tuple[Any, Any, Array]] = [
        (one.mass, one.centre, inertia_of(one)) for one in body.parts or ()
    ]
    if not given:
        given.append((body.mass, body.centre or (0.0, 0.0, 0.0), inertia_of(body)))
    block = body.inertia_block
    if block is not None:
        given.append((block.mass, block.position, box_inertia(block.mass, block.box)))
    masses = side_by_side([mass for mass, _, _ in given])
    places = rounded(side_by_side([side_by_side(centre) for _, centre, _ in given], own=1), 1)
    own = side_by_side([inertia for _, _, inertia in given], own=2)
    mass = masses.sum(axis=-1)
    moments = places * masses[..., None]
    static_moment = moments.sum(axis=-2)
    centre = static_moment / mass[..., None]
    away = places - centre[..., None, :]
    about_reference = (own + point_inertia(masses, places.value)).sum(axis=-3)
    about_centre = (own + point_inertia(masses, away.value)).sum(axis=-3)
    # what is left of terms that cancel is as wrong as they are large
    rounding = (DATA_ROUNDINGS + len(given)) * UNIT_ROUNDOFF
    large, apart = (
        rounding * np.abs(np.abs(own) + point_inertia(-masses, np.abs(at))).sum(axis=-3)
        for at in (places.value, away.value)
    )
    moved = 2.0 * (masses * (np.abs(away.value) * away.error).sum(axis=-1)).sum(axis=-1)
    matrix = _mass_matrix(mass, static_moment.value, about_reference)
    error = np.abs(_mass_matrix(rounding * mass, static_moment.error, large))
    return RigidBody(
        mass=mass,
        centre=centre.value,
        mass_matrix=matrix,
        inertia=about_centre,
        centre_error=centre.error,
        mass_error=error,
        inertia_error=apart + moved[..., None, None],
    )


def _mass_matrix(mass: Array, static_moment: Array, inertia: Array) -> Array:
    """Matrix (..., 6, 6) of a mass (...), its static moment (..., 3) and inertia (..., 3, 3)."""
    points = np.broadcast_shapes(mass.shape, static_moment.shape[:-1], inertia.shape[:-2])
    matrix = np.zeros((*points, 6, 6))
    matrix[..., :3, :3] = mass[..., None, None] * np.eye(3)
    matrix[..., :3, 3:] = -cross_matrix(static_moment)
    matrix[..., 3:, :3] = np.swapaxes(matrix[..., :3, 3:], -1, -2)
    matrix[..., 3:, 3:] = inertia
    return matrix


# ----------------------------------------------------------------------------
# Is there a body with these moments of inertia?
# ----------------------------------------------------------------------------

BODY: KeyPath = ("machine", "body")
#: Slack of the triangle inequality, relative: flat bodies are on its edge, digits are rounded.
SLACK = 1e-6


@listing
def body_problems(case: Case) -> Iterator[Problem]:
    """Problems of the moments and products of inertia, of the body or of its parts."""
    if case.machine.body is not None:
        yield from moment_problems(BODY, case.machine.body)


def moment_problems(path: KeyPath, body: parts.Body) -> Iterator[Problem]:
    """The same of one body, which stands at `path`."""
    problems = list(_moments(path, body, 1e-12))
    for place, part in enumerate(body.parts or ()):
        problems += _moments((*path, "parts", place), part, -1e-12)
    yield from problems
    if not body.parts or problems:
        return
    built = build_body(body)
    principal = np.linalg.eigvalsh(built.inertia)
    extent = np.abs([part.centre for part in body.parts]).max()
    if not principal[0] > 1e-12 * max(principal[2], built.mass * extent**2):
        shown = ", ".join(f"{moment:.6g}" for moment in principal)
        yield Problem(
            path=(*path, "parts"),
            message="the parts have no moment of inertia about some axis: they are points in a "
            "line, or too small beside their distance from the reference point",
            found=f"principal moments of {shown} kg*m^2",
            allowed="all principal moments > 0",
        )


def _moments(path: KeyPath, given: parts.Body | parts.BodyPart, least: float) -> Iterator[Problem]:
    """Problems of one set of moments, whose principal ones are above `least` times the largest."""
    if given.inertia is None:
        return
    with_products = any(given.inertia_products)
    principal = np.linalg.eigvalsh(inertia_of(given))
    shown = ", ".join(f"{moment:.6g}" for moment in principal)
    if (principal[0] < 0.0 and principal[2] <= 0.0) or principal[0] <= least * principal[2] != 0.0:
        yield Problem(
            path=(*path, "inertia_products"),
            message="impossible products of inertia: they are too large for its moments",
            found=f"principal moments of {shown} kg*m^2",
            allowed="all principal moments > 0",
            also=(*path, "inertia"),
        )
    elif principal[2] > (principal[0] + principal[1]) * (1.0 + SLACK):
        what = "principal moments" if with_products else "moments"
        yield Problem(
            path=(*path, "inertia"),
            message="impossible moments of inertia: the largest must not exceed the "
            "sum of the other two",
            found=f"{what} of {shown} kg*m^2",
            allowed=f"the largest at most {principal[0] + principal[1]:.6g} kg*m^2",
        )


def body_suspects(case: Case) -> BoolArray:
    """Points (...) of a case with arrays that `body_problems` may refuse: its bounds, narrower."""
    body = case.machine.body
    if body is None or (body.inertia is None and not body.parts):
        return np.zeros((), dtype=bool)
    if not body.parts:
        return _suspect(inertia_of(body), 1e-11)
    found = _suspect(build_body(body).inertia, 1e-9)
    for part in body.parts:
        if part.inertia is not None:
            found = found | _suspect(inertia_of(part), -1e-13)
    return found


def _suspect(matrix: Array, least: float) -> BoolArray:
    finite = np.asarray(np.isfinite(matrix).all(axis=(-2, -1)))
    principal = np.linalg.eigvalsh(np.where(finite[..., None, None], matrix, np.eye(3)))
    low, middle, high = np.moveaxis(principal, -1, 0)
    diagonal = np.diagonal(matrix, axis1=-2, axis2=-1)
    positive = np.all(diagonal > 0.0 if least > 0.0 else diagonal >= 0.0, axis=-1)
    flat = high <= (low + middle) * (1.0 + 0.9 * SLACK)
    return np.asarray(~(finite & positive & (low > least * high) & flat))
