"""One machine told in another way: from elsewhere, along other axes, in other parts or units."""

from collections.abc import Callable, Mapping
from copy import deepcopy
from typing import Any

import numpy as np
from random_machines import Table

Vector = Callable[[np.ndarray], np.ndarray]
XYZ = ("x", "y", "z")
COORDINATES = (*XYZ, "rx", "ry", "rz")


def one_by_one(case: Table) -> Table:
    """Mounts with names and all properties of their own instead of equal ones by their places."""
    other = deepcopy(case)
    for mounts in (other["machine"]["mounts"], other.get("foundation", {}).get("springs")):
        if mounts is not None:
            each = mounts.pop("each")
            places = enumerate(mounts.pop("positions", ()), start=1)
            rows = mounts.get("individual") or [{"name": str(n), "position": p} for n, p in places]
            mounts["individual"] = [{**each, **row} for row in rows]
    return other


# ----------------------------------------------------------------------------
# From another origin, along other axes.
# ----------------------------------------------------------------------------


def moved(case: Table, by: np.ndarray) -> Table:
    """All places measured from an origin elsewhere."""
    other = one_by_one(case)
    machine = other["machine"]
    places = [(machine["crank_train"], "origin"), (other.get("foundation", {}), "position")]
    places += [(one, "centre") for one in machine["body"]["parts"]]
    places += [(one, "position") for one in machine["mounts"]["individual"]]
    places += [(one, "position") for one in other.get("point", ())]
    if "base_motion" in other:
        places.append((other["base_motion"], "point"))
    if "datum" in machine["mounts"]:
        places = [one for one in places if one[0] not in machine["mounts"]["individual"]]
        places.append((machine["mounts"], "datum"))
    for row, key in places:
        if key in row or key == "origin":
            row[key] = (np.array(row.get(key, np.zeros(3))) + by).tolist()
    return other


def turned(case: Table) -> Table:
    """What was along x is along y, y is z and z is x."""
    other = one_by_one(case)
    machine = other["machine"]
    train = machine["crank_train"]
    for row, key in ((train, "axis"), (train, "stroke"), (other["isolation"], "up")):
        row[key] = _next(row[key])
    _turn(train, "origin")
    for shaft in train.get("balance_shafts", ()):
        _turn(shaft, "position")
    _body(machine["body"])
    _springs(machine["mounts"])
    for point in other.get("point", ()):
        _turn(point, "position", "direction")
        if "axes" in point:
            point["axes"] = [_rolled(axis) for axis in point["axes"]]
    foundation = other.get("foundation", {})
    _turn(foundation, "position")
    for one in foundation.get("flexibilities", ()):
        one["direction"] = _next(one["direction"])
    if "springs" in foundation:
        _body(foundation["body"])
        _springs(foundation["springs"])
    base = other.get("base_motion", {})
    _turn(base, "point")
    for one in base.get("harmonics", ()):
        _turn(one, *(key for key, value in one.items() if isinstance(value, list)))
    for one in base.get("spectra", ()):
        one["direction"] = _next(one["direction"])
    return other


def _next(name: str) -> str:
    """The direction, or the turn about it, that follows."""
    return name[:-1] + XYZ[(XYZ.index(name[-1]) + 1) % 3]


def _rolled(vector: Any) -> Any:
    return np.roll(vector, 1).tolist()


def _turn(row: Table, *keys: str) -> None:
    for key in keys:
        if key in row:
            row[key] = _rolled(row[key])


def _body(body: Table) -> None:
    for part in body.get("parts", [body]):
        _turn(part, "centre", "inertia")
        if "inertia_products" in part:
            xy, xz, yz = part["inertia_products"]
            part["inertia_products"] = [xz, yz, xy]
        if "box" in part:
            edges = _rolled([part["box"][key] for key in ("length", "width", "height")])
            part["box"] = dict(zip(("length", "width", "height"), edges, strict=True))


def _springs(mounts: Table) -> None:
    _turn(mounts, "datum")
    swap = np.roll(np.eye(3), 1, axis=0)
    for one in mounts["individual"]:
        _turn(one, "position")
        for key in ("stiffness", "damping"):
            if isinstance(one.get(key), list):
                _turn(one, key)
        if "orientation" in one:
            matrix = swap @ _rotation(one["orientation"]) @ swap.T
            one["orientation"] = [
                float(np.arctan2(matrix[2, 1], matrix[2, 2])),
                float(-np.arcsin(matrix[2, 0])),
                float(np.arctan2(matrix[1, 0], matrix[0, 0])),
            ]


def _rotation(angles: Any) -> np.ndarray:
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)


# ----------------------------------------------------------------------------
# In another order, in halves.
# ----------------------------------------------------------------------------


def shuffled(case: Table) -> Table:
    """Cylinders, parts, mounts and points in the reverse order."""
    other = one_by_one(case)
    machine = other["machine"]
    for rows in (
        machine["crank_train"]["cylinders"],
        machine["body"]["parts"],
        machine["mounts"]["individual"],
        other.get("point", []),
    ):
        rows.reverse()
    return other


def with_halves(case: Table) -> Table:
    """The first mount as two halves at its place, the first part as two of half its mass."""
    other = one_by_one(case)
    mounts = other["machine"]["mounts"]["individual"]
    first = mounts[0]
    half = _halved(first)
    mounts[:1] = [{**half, "name": f"{first['name']}{end}"} for end in ("", " again")]
    rows = other.get("foundation", {}).get("flexibilities", [])
    for one in [row for row in rows if row.get("at") != "whole"]:
        names = [mount["name"] for mount in mounts]
        key = next(key for key in one if "stiffness" in key or "impedance" in key)
        soft = {part: (0.5 * np.array(one[key][part])).tolist() for part in ("real", "imaginary")}
        rows.append({**one, "mounts": names[:2], key: {**one[key], **soft}})
        one["mounts"] = names[2:]
    parts = other["machine"]["body"]["parts"]
    part = parts[0]
    mass, centre = 0.5 * part["mass"], np.array(part["centre"])
    inertia = _inertia(part)
    # both halves off the middle: what their places add, they have less about themselves
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    squares, axes = np.linalg.eigh(second)
    away = 0.6 * np.sqrt(squares[1] / part["mass"]) * axes[:, 1]
    second = 0.5 * (second - part["mass"] * np.outer(away, away))
    own = np.trace(second) * np.eye(3) - second
    parts[:1] = [
        {
            "name": f"{part['name']} {sign:+}",
            "mass": mass,
            "centre": (centre + sign * away).tolist(),
            "inertia": np.diag(own).tolist(),
            "inertia_products": (-own[[0, 0, 1], [1, 2, 2]]).tolist(),
        }
        for sign in (-1, 1)
    ]
    return other


def _halved(mount: Table) -> Table:
    """Half a mount: half its load at the same deflection."""
    half = deepcopy(mount)
    rows = [(half, "stiffness"), (half, "damping")]
    static = half.get("static", {})
    rows += [(static, "cubic_stiffness"), (static.get("stops", {}), "stiffness")]
    rows += [(static.get("load_deflection", {}), "load"), (half.get("over_load", {}), "load")]
    for row, key in rows:
        if key in row:
            row[key] = (0.5 * np.array(row[key])).tolist()
    return half


def _inertia(part: Table) -> np.ndarray:
    if "box" in part:
        edges = np.array([part["box"][key] for key in ("length", "width", "height")])
        return np.asarray(np.diag(part["mass"] / 12.0 * (edges @ edges - edges**2)))
    xy, xz, yz = part["inertia_products"]
    return np.diag(part["inertia"]) - np.array([[0, xy, xz], [xy, 0, yz], [xz, yz, 0]])


# ----------------------------------------------------------------------------
# In other units.
# ----------------------------------------------------------------------------

#: exponents of length, mass and time
DIMENSIONS: Mapping[str, tuple[int, int, int]] = {
    "": (0, 0, 0),
    "rad": (0, 0, 0),
    "dB": (0, 0, 0),
    "m": (1, 0, 0),
    "m/s": (1, 0, -1),
    "m/s^2": (1, 0, -2),
    "m^2/s^3": (2, 0, -3),
    "m^2/s": (2, 0, -1),
    "rad^2/s^3": (0, 0, -3),
    "m^3": (3, 0, 0),
    "m^3/s": (3, 0, -1),
    "kg": (0, 1, 0),
    "kg*m": (1, 1, 0),
    "kg*m^2": (2, 1, 0),
    "rad/s": (0, 0, -1),
    "rad/s^2": (0, 0, -2),
    "N": (1, 1, -2),
    "Pa": (-1, 1, -2),
    "N*m": (2, 1, -2),
    "J": (2, 1, -2),
    "W": (2, 1, -3),
    "N/m": (0, 1, -2),
    "N/m^3": (-2, 1, -2),
    "N*s/m": (0, 1, -1),
    "N*m/rad": (2, 1, -2),
    "N*m*s/rad": (2, 1, -1),
}
KEYS: Mapping[str, str] = {
    **dict.fromkeys(("crank_radius", "rod_length", "wrist_pin_offset", "position", "origin"), "m"),
    **dict.fromkeys(("length", "width", "height", "positions", "lever", "reference_length"), "m"),
    **dict.fromkeys(("crank_pin_to_mass_centre", "centre", "datum", "bore", "point"), "m"),
    **dict.fromkeys(("down", "up", "deflection", "displacement"), "m"),
    **dict.fromkeys(("mass", "reciprocating_mass", "rotating_mass", "piston_mass"), "kg"),
    **dict.fromkeys(("pin_mass",), "kg"),
    **dict.fromkeys(("inertia", "inertia_products"), "kg*m^2"),
    **dict.fromkeys(("speed", "from", "to", "frequency", "band", "angular_velocity"), "rad/s"),
    **dict.fromkeys(("suction_pressure", "discharge_pressure", "outside_pressure"), "Pa"),
    **dict.fromkeys(("bulk_modulus", "pressure"), "Pa"),
    **dict.fromkeys(("load", "force"), "N"),
    "dead_volume": "m^3",
    "velocity": "m/s",
    "acceleration": "m/s^2",
    "angular_acceleration": "rad/s^2",
    "unbalance": "kg*m",
    "gravity": "m/s^2",
    "stiffness": "N/m",
    "cubic_stiffness": "N/m^3",
    "damping": "N*s/m",
}
#: of columns in tables over frequency, by the key of the table
COLUMNS: Mapping[str, tuple[str, str]] = {
    "dynamic_stiffness": ("real imaginary", "N/m"),
    "impedance": ("real imaginary", "N*s/m"),
    "angular_dynamic_stiffness": ("real imaginary", "N*m/rad"),
    "angular_impedance": ("real imaginary", "N*m*s/rad"),
    "acceleration": ("density", "m^2/s^3"),
    "velocity": ("density", "m^2/s"),
    "angular_acceleration": ("density", "rad^2/s^3"),
}


def in_units(
    value: Any, factors: tuple[float, float, float], key: str = "", table: str = ""
) -> Any:
    """A case in other units; the factors are those of length, mass and time."""
    if isinstance(value, dict):
        return {name: in_units(item, factors, name, key) for name, item in value.items()}
    if isinstance(value, list):
        return [in_units(item, factors, key, table) for item in value]
    columns, unit = COLUMNS.get(table, ("", ""))
    unit = unit if key in columns.split() else KEYS.get(key, "")
    if isinstance(value, str | bool) or not unit:
        return value
    return value * factor_of(unit, factors)


def factor_of(unit: str, factors: tuple[float, float, float]) -> float:
    """What a number in this unit is multiplied by."""
    return float(np.prod([f**e for f, e in zip(factors, DIMENSIONS[unit], strict=True)]))
