"""Claim: a body of parts weighs and turns as its points of mass do, wherever the datum stands."""

import numpy as np
import pytest
from mounted_sets import ran, tables

from vibecalc.core.case.load import validate
from vibecalc.parts.body import build_body


def points_of(part: dict[str, object]) -> tuple[np.ndarray, np.ndarray]:
    """Masses and places of points that have mass, centre and principal inertia of a part.

    Two points at +-d along each principal axis, a sixth of the mass each, where the second moment
    of mass along the axis is m d^2 / 3.
    """
    mass, centre = float(part["mass"]), np.array(part["centre"], dtype=float)
    if "box" in part:
        edges = np.array([part["box"][key] for key in ("length", "width", "height")])
        second = np.diag(mass * edges**2 / 12.0)
    else:
        xx, yy, zz = part["inertia"]
        xy, xz, yz = part["inertia_products"]
        second = np.array([[yy + zz - xx, 0, 0], [0, xx + zz - yy, 0], [0, 0, xx + yy - zz]]) / 2.0
        second += np.array([[0, xy, xz], [xy, 0, yz], [xz, yz, 0]])
    squares, axes = np.linalg.eigh(second)
    away = axes * np.sqrt(3.0 * squares / mass)
    places = np.concatenate([centre + away.T, centre - away.T])
    return np.full(6, mass / 6.0), places


def moved(data: dict[str, object], by: np.ndarray) -> dict[str, object]:
    """The same machine with all places measured from elsewhere."""
    machine = data["machine"]
    for part in machine["body"]["parts"]:
        part["centre"] = (np.array(part["centre"]) + by).tolist()
    machine["crank_train"]["origin"] = (np.array(machine["crank_train"]["origin"]) + by).tolist()
    machine["mounts"]["datum"] = by.tolist()
    return data


def test_parts_are_what_their_points_of_mass_are() -> None:
    data = tables()
    masses, places = map(
        np.concatenate, zip(*map(points_of, data["machine"]["body"]["parts"]), strict=True)
    )
    centre = masses @ places / masses.sum()

    def about(point: np.ndarray) -> np.ndarray:
        r = places - point
        return np.einsum(
            "n,nij->ij", masses, (r**2).sum(-1)[:, None, None] * np.eye(3)
        ) - np.einsum("n,ni,nj->ij", masses, r, r)

    body = build_body(validate(data).machine.body)
    assert body.mass == pytest.approx(masses.sum(), rel=1e-15)
    assert body.centre == pytest.approx(centre, abs=1e-14)
    inertia = about(centre)
    assert np.abs(body.inertia - inertia).max() < 1e-13 * inertia.max()
    # kinetic energy of any motion of the reference point, of the points one by one
    motion = np.array([0.3, -0.2, 0.7, 1.1, -0.4, 0.9])
    velocity = motion[:3] + np.cross(motion[3:], places)
    energy = 0.5 * masses @ (velocity**2).sum(-1)
    assert 0.5 * motion @ body.mass_matrix @ motion == pytest.approx(energy, rel=1e-14)

    record = ran(data)
    assert record["body/mass"].values == pytest.approx(710.0)
    principal = record["body/principal_moments"].values
    assert principal == pytest.approx(np.linalg.eigvalsh(inertia), rel=1e-13)
    axes = record["body/principal_axes"].values
    assert np.abs(axes @ inertia @ axes.T - np.diag(principal)).max() < 1e-12 * principal[-1]


@pytest.mark.parametrize("by", [[0.9, 0.1, -0.4], [-30.0, 200.0, 60.0]])
def test_the_datum_changes_nothing_beyond_the_errors_stated(by: list[float]) -> None:
    here, there = ran(tables()), ran(moved(tables(), np.array(by)))
    for path in (
        "isolation/modes/natural_frequency",
        "isolation/modes/damping_ratio",
        "isolation/support_displacement/static",
        "isolation/support_force/static",
        "isolation/support_force/steady_peak",
        "body/moments",
        "body/principal_moments",
    ):
        one, other = here[path], there[path]
        allowed = one.error_estimate + other.error_estimate
        assert np.abs(one.values - other.values).max() <= allowed, path
        assert other.error_estimate < 1e-3 * np.abs(other.values).max(), path


def test_mass_and_centre_given_are_a_body_of_one_part_and_a_block_another() -> None:
    data = tables()
    parts = data["machine"]["body"]["parts"]
    block, rest = parts[2], parts[1]
    data["machine"]["body"] = {"parts": [rest, block]}
    given = {key: rest[key] for key in ("mass", "centre", "inertia", "inertia_products")}
    position = {"mass": block["mass"], "box": block["box"], "position": block["centre"]}
    assembled = build_body(validate(data).machine.body)
    data["machine"]["body"] = {**given, "inertia_block": position}
    body = build_body(validate(data).machine.body)
    for name in ("mass", "centre", "mass_matrix", "inertia"):
        assert getattr(body, name) == pytest.approx(getattr(assembled, name), rel=1e-13, abs=1e-12)
