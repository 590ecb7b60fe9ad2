"""Claim: a machine that is described in another way has the same results.

Other units of length, mass and time, other names of the axes, a mirror image, mounts and cylinders
in another order: every result of a whole run, phases included, changes as it has to and not
otherwise; estimates too.
"""

import copy
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from long_but import long_but
from random_machines import Table, random_machine

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Quantity, Record
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.run import run_case

MODELS = ("pitch", "rigid_body")
#: two machines; two more with the long tests
SEEDS = long_but(range(4), 1, 2)
XYZ = ("x", "y", "z")
CURVES = ("isolation/lever_force/run_up", "isolation/support_force/run_up")
#: exponents of length, mass and time
DIMENSIONS: Mapping[str, tuple[int, int, int]] = {
    "": (0, 0, 0),
    "rad": (0, 0, 0),
    "m": (1, 0, 0),
    "m/s": (1, 0, -1),
    "m/s^2": (1, 0, -2),
    "kg": (0, 1, 0),
    "kg*m": (1, 1, 0),
    "kg*m^2": (2, 1, 0),
    "rad/s": (0, 0, -1),
    "N": (1, 1, -2),
    "N*m": (2, 1, -2),
    "N/m": (0, 1, -2),
    "N*s/m": (0, 1, -1),
    "N*m/rad": (2, 1, -2),
    "N*m*s/rad": (2, 1, -1),
}
KEYS: Mapping[str, str] = {
    **dict.fromkeys(("crank_radius", "rod_length", "wrist_pin_offset", "position", "origin"), "m"),
    **dict.fromkeys(("length", "width", "height", "positions", "lever", "reference_length"), "m"),
    **dict.fromkeys(("crank_pin_to_mass_centre",), "m"),
    **dict.fromkeys(("mass", "reciprocating_mass", "rotating_mass", "piston_mass"), "kg"),
    **dict.fromkeys(("pin_mass",), "kg"),
    **dict.fromkeys(("inertia", "inertia_products"), "kg*m^2"),
    **dict.fromkeys(("speed", "from", "to"), "rad/s"),
    "unbalance": "kg*m",
    "gravity": "m/s^2",
    "stiffness": "N/m",
    "damping": "N*s/m",
}


def machine(seed: int, model: str) -> Table:
    """A random machine with gravity and orders written out."""
    case = random_machine(seed, model, gravity=9.80665)
    case["accuracy"] = {"rtol": 1e-9}
    return case


def run(case: Table) -> Record:
    """All results but the curves of the run-up, which sample where they like."""
    checked = validate(copy.deepcopy(case))
    paths = [path for path in planned_quantities(checked) if path not in CURVES]
    return run_case(checked, wanted=frozenset(paths))


def train_of(case: Table) -> Table:
    train: Table = case["machine"]["crank_train"]
    return train


def individual(case: Table) -> list[Table]:
    """The mounts one by one, each with everything of its own."""
    mounts = case["machine"]["mounts"]
    each = mounts.pop("each", {})
    named = mounts.pop("individual", None)
    if named is None:
        places = mounts.pop("positions")
        named = [{"name": str(n), "position": p} for n, p in enumerate(places, start=1)]
    mounts["individual"] = [{**each, **mount} for mount in named]
    found: list[Table] = mounts["individual"]
    return found


def scaled(value: Any, factors: tuple[float, float, float], key: str = "") -> Any:
    """A case in other units; the factors are those of length, mass and time."""
    if isinstance(value, dict):
        return {name: scaled(item, factors, name) for name, item in value.items()}
    if isinstance(value, list):
        return [scaled(item, factors, key) for item in value]
    if key not in KEYS or isinstance(value, str):
        return value
    return value * factor_of(KEYS[key], factors)


def factor_of(unit: str, factors: tuple[float, float, float]) -> float:
    return float(np.prod([f**e for f, e in zip(factors, DIMENSIONS[unit], strict=True)]))


def agree(
    one: Record,
    other: Record,
    expected: Callable[[Quantity], Any],
    *,
    rounding: float = 1e-10,
    skip: tuple[str, ...] = (),
) -> None:
    """Hold every result of `other` against what becomes of that of `one`.

    The two cases differ in the last bits of their data, which `rounding` allows for.
    """
    reported = {path for path in one if not path.startswith(skip)}
    assert reported == {path for path in other if not path.startswith(skip)}
    compared = 0
    for path, quantity in one.quantities.items():
        if path.startswith(skip):
            continue
        want, have = np.asarray(expected(quantity)), other[path].values
        assert want.shape == have.shape, path
        size = float(np.max(np.abs(want), initial=0.0))
        stretch = size / float(np.max(np.abs(quantity.values), initial=0.0)) if size else 1.0
        error = stretch * quantity.error_estimate + other[path].error_estimate
        off = float(np.max(np.abs(have - want), initial=0.0))
        assert off <= rounding * size + 2.0 * error, f"{path}: {off:.3g} of {size:.3g}"
        compared += 1
    assert compared > 10


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("powers", long_but([(17, -23, 11), (-20, 30, -13)], (17, -23, 11)))
def test_units_of_length_mass_and_time(seed: int, model: str, powers: tuple[int, ...]) -> None:
    """Powers of two round nothing, so that even error estimates follow."""
    factors = (2.0 ** powers[0], 2.0 ** powers[1], 2.0 ** powers[2])
    case = machine(seed, model)
    one, other = run(case), run(scaled(case, factors))

    def expected(quantity: Quantity) -> Any:
        if quantity.path == "isolation/modes/shape":
            turn = factors[0] ** -1.0
            return quantity.values * factors[1] ** -0.5 * np.array([1, 1, 1, turn, turn, turn])
        return quantity.values * factor_of(quantity.unit, factors)

    agree(one, other, expected, rounding=1e-12)
    for path, quantity in one.quantities.items():
        if quantity.path == "isolation/modes/shape" or quantity.error_estimate == 0.0:
            continue
        want = quantity.error_estimate * factor_of(quantity.unit, factors)
        assert other[path].error_estimate == pytest.approx(want, rel=0.1), path


def turned(case: Table) -> Table:
    """The same machine with x called y, y called z and z called x."""
    new = copy.deepcopy(case)
    train, body = train_of(new), new["machine"]["body"]
    following = dict(zip(XYZ, "yzx", strict=True))
    train["axis"], train["stroke"] = following[train["axis"]], following[train["stroke"]]
    new["isolation"]["up"] = following[new["isolation"]["up"]]

    def vector(v: Any) -> list[float]:
        return [v[2], v[0], v[1]]

    for place in (train, *train.get("balance_shafts", ()), body.get("inertia_block", {})):
        for key in ("origin", "position"):
            if key in place:
                place[key] = vector(place[key])
    for holder in (body, body.get("inertia_block", {})):
        if "box" in holder:
            edges = vector([holder["box"][edge] for edge in ("length", "width", "height")])
            holder["box"] = dict(zip(("length", "width", "height"), edges, strict=True))
    if "inertia" in body:
        body["inertia"] = vector(body["inertia"])
        xy, xz, yz = body.get("inertia_products", (0.0, 0.0, 0.0))
        body["inertia_products"] = [xz, yz, xy]
    rename = np.eye(3)[[2, 0, 1]]
    for mount in individual(new):
        mount["position"] = vector(mount["position"])
        reorient(mount, rename)
    return new


def reorient(mount: Table, change: np.ndarray) -> None:
    """Turn or mirror the axes of a mount by the orthogonal matrix `change`."""
    from scipy.spatial.transform import Rotation

    axes = change @ Rotation.from_euler("xyz", mount.get("orientation", (0, 0, 0))).as_matrix()
    axes[:, 2] *= np.linalg.det(axes)  # a principal direction has no sense
    mount["orientation"] = Rotation.from_matrix(axes).as_euler("xyz").tolist()


def over(quantity: Quantity, name: str) -> int | None:
    names = [axis.name for axis in quantity.axes]
    return names.index(name) if name in names else None


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("seed", SEEDS)
def test_names_of_the_axes(seed: int, model: str) -> None:
    case = machine(seed, model)
    one, other = run(case), run(turned(case))

    def expected(quantity: Quantity) -> Any:
        values = quantity.values
        direction, coordinate = over(quantity, "direction"), over(quantity, "coordinate")
        if direction is not None and values.shape[direction] == 3:
            values = values.take([2, 0, 1], axis=direction)
        if coordinate is not None:
            values = values.take([2, 0, 1, 5, 3, 4], axis=coordinate)
        return values

    agree(one, other, expected, skip=("isolation/modes/shape",))


SIGN_OF = {"excitation/force": 1, "excitation/couple": -1, "isolation/body/translation": 1,
           "isolation/body/rotation": -1, "isolation/support_force/steady_harmonics": 1,
           "isolation/support_displacement/steady_harmonics": 1}  # fmt: skip


def image_of(quantity: Quantity, mirror: np.ndarray) -> Any:
    """A vector in a mirror; couples and rotations are axial and turn the other way round."""
    for start, sign in SIGN_OF.items():
        if quantity.path.startswith(start) and not quantity.path.endswith("_peak"):
            place = over(quantity, "direction")
            assert place is not None
            shape = [1] * quantity.values.ndim
            shape[place] = 3
            return quantity.values * (sign * mirror).reshape(shape)
    return quantity.values


def mirrored(case: Table, direction: str) -> Table:
    """Body and mounts in a mirror across `direction`; the crank train is left."""
    new = copy.deepcopy(case)
    body, place = new["machine"]["body"], XYZ.index(direction)
    mirror = np.where(np.arange(3) == place, -1.0, 1.0)
    if "inertia_products" in body:
        signs = [mirror[0] * mirror[1], mirror[0] * mirror[2], mirror[1] * mirror[2]]
        body["inertia_products"] = (np.array(body["inertia_products"]) * signs).tolist()
    if "position" in body.get("inertia_block", {}):
        block = body["inertia_block"]
        block["position"] = (mirror * block["position"]).tolist()
    for mount in individual(new):
        mount["position"] = (mirror * mount["position"]).tolist()
        reorient(mount, np.diag(mirror))
    train = train_of(new)
    for holder, key in ((train, "origin"), *((s, "position") for s in _shafts(train))):
        if key in holder:
            holder[key] = (mirror * holder[key]).tolist()
    return new


def _shafts(train: Table) -> list[Table]:
    return list(train.get("balance_shafts", ()))


@pytest.mark.parametrize("seed", SEEDS)
def test_mirror_across_the_crankshaft(seed: int) -> None:
    """A mirror at right angles to the shaft keeps the sense of rotation."""
    case = machine(seed, "rigid_body")
    axis = train_of(case).get("axis", "x")
    new = mirrored(case, axis)
    for part in (*train_of(new)["cylinders"], *train_of(new).get("counterweights", ())):
        part["position"] = -part.get("position", 0.0)
    mirror = np.where(np.arange(3) == XYZ.index(axis), -1.0, 1.0)
    root = "excitation/balance"
    balance = (f"{root}/position", f"{root}/total_position", f"{root}/banks/position_sum")

    def expected(quantity: Quantity) -> Any:
        if quantity.path.startswith(balance):
            return -quantity.values
        return image_of(quantity, mirror)

    agree(run(case), run(new), expected, skip=("isolation/modes/shape",))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("seed", SEEDS)
def test_order_of_mounts_and_cylinders(seed: int, model: str) -> None:
    case = machine(seed, model)
    mounts = individual(case)
    new = copy.deepcopy(case)
    generator = np.random.default_rng(seed)
    cylinders = train_of(case)["cylinders"]
    places = {
        "mount": generator.permutation(len(mounts)),
        "cylinder": generator.permutation(len(cylinders)),
    }
    new["machine"]["mounts"]["individual"] = [copy.deepcopy(mounts[n]) for n in places["mount"]]
    train_of(new)["cylinders"] = [copy.deepcopy(cylinders[n]) for n in places["cylinder"]]

    def expected(quantity: Quantity) -> Any:
        values = quantity.values
        for name, order in places.items():
            axis = over(quantity, name)
            values = values if axis is None else values.take(order, axis=axis)
        return values

    agree(run(case), run(new), expected, skip=("isolation/modes/shape",))
