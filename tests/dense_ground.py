"""Results of what a machine stands on, from the dense model: foundations, and a base that moves."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from dense_machine import arm, longest, peak
from dense_results import (
    FORCE_COUPLE,
    MANY,
    QUANTITIES,
    Dense,
    Expected,
    alone,
    by_order,
    swamped,
    through,
)
from dense_train import TURN, Table

_MOTIONS = [
    "translation", "rotation", "relative_translation", "relative_rotation", "velocity",
    "angular_velocity", "acceleration", "angular_acceleration",
]  # fmt: skip


# ----------------------------------------------------------------------------
# A foundation that moves.
# ----------------------------------------------------------------------------


def coupled_results(dense: Dense) -> Iterator[Expected]:
    root, on, moved = "foundation/coupled", dense.mounted, dense.moved
    rate = dense.order * dense.speed
    if on.springs is not None:
        frequency, shapes, ratio = on.modes()
        yield Expected(f"{root}/modes/natural_frequency", frequency)
        yield Expected(f"{root}/modes/damping_ratio", ratio)
        if np.min(np.diff(frequency) / frequency[1:]) > 1e-6:
            share = (shapes * (shapes @ on.matrices()[0]))[:, :6].sum(axis=1)
            yield Expected(f"{root}/modes/machine_share", share)
    if on.springs is not None or on.plate:
        yield Expected(f"{root}/body/translation", moved.below[:, :3])
        yield Expected(f"{root}/body/rotation", moved.below[:, 3:])
    yield Expected(f"{root}/foot", np.moveaxis(moved.foot, 0, -1))
    velocity = 1j * rate[:, None, None] * moved.foot
    yield Expected(f"{root}/power", 0.5 * np.sum((velocity * moved.force.conj()).real, (1, 2)))
    for train, every, whole in dense.kept_and_all:
        squares = np.abs(train.order[:, None, None] * dense.speed * every.foot) ** 2
        value = np.sqrt(0.5 * squares.sum(axis=(0, 2)))
        yield Expected(f"{root}/foot_velocity_rms", value, whole=whole)
        held, still = train.loads(dense.speed), dense.motion(train, dense.rigid).ground
        for name, load, model in (("ground", every.ground, on), ("rigid", still, dense.rigid)):
            passed = through(model, train.order * dense.speed)
            for what, part in zip(("force", "couple"), FORCE_COUPLE, strict=True):
                own = alone(held, passed, part)
                path, size = f"{root}/{name}/{what}", np.linalg.norm(held[:, part])
                arrived = np.linalg.norm(load[:, part])
                yield Expected(f"{path}_rms", arrived / np.sqrt(2.0), whole=whole)
                nothing = float(dense.nothing[part].max())
                if size > nothing:
                    value = 1.0 - arrived / size
                    lack = swamped(size, arrived, np.linalg.norm(own))
                    size = max(1.0, abs(value))
                    yield Expected(f"{path}_efficiency", value, size, whole=whole, lack=lack)
                if not whole:
                    yield Expected(path, load[:, part])
                    both = held[:, part], load[:, part]
                    yield by_order(f"{path}_by_order", *both, own, nothing)
    rate = TURN * dense.axis(f"{root}/ground/transmissibility", 1)
    for name, one in (("ground", on), ("rigid", dense.rigid)):
        value = np.abs(np.diagonal(through(one, rate), axis1=1, axis2=2)).T
        yield Expected(f"{root}/{name}/transmissibility", value)


def two_mass_results(dense: Dense) -> Iterator[Expected]:
    given, on = dense.case["foundation"], dense.rigid
    order = dense.axis("foundation/machine", 0)
    every = np.arange(1, MANY + 1)
    for count, whole in [(order, False), (every, True)][: 1 + dense.deep]:
        rate = count * dense.speed
        force = dense.speed**2 * dense.train.shaking[count.astype(int), :3] @ on.up
        mounts = np.einsum("i,mnij,j->m", on.up, on.mounts.passing(rate), on.up)
        under = given["stiffness"] * (1.0 + 1j * given["loss_factor"])
        under = under + 1j * rate * given["damping"]
        system = np.zeros((len(rate), 2, 2), dtype=complex)
        system[:, 0, 0] = mounts - rate**2 * on.solid.mass
        system[:, 1, 1] = mounts + under - rate**2 * given["mass"]
        system[:, 0, 1] = system[:, 1, 0] = -mounts
        load = np.stack([force, 0.0 * force], axis=-1)
        machine, below = np.linalg.solve(system, load[..., None])[..., 0].T
        rigid = force * mounts / (mounts - rate**2 * on.solid.mass)
        results = {
            "machine": machine, "motion": below, "ground_force": under * below,
            "rigid_force": rigid,
        }  # fmt: skip
        # what cancels between cylinders is as wrong as these are large
        terms = 1e9 * float(dense.nothing[:3] @ np.abs(on.up))
        for name, value in results.items():
            with np.errstate(divide="ignore", invalid="ignore"):
                size = terms * float(np.nanmax(np.abs(value / force), initial=0.0))
            if not whole:
                yield Expected(f"foundation/{name}", value, size)
            if name != "machine":
                yield Expected(f"foundation/{name}_peak", peak(value, count), size, whole=whole)
    stiff = on.mounts.passing(np.zeros(1))[0].real
    k = np.einsum("i,nij,j->", on.up, stiff, on.up)
    matrix = np.array([[k, -k], [-k, k + given["stiffness"]]])
    mass = np.array([on.solid.mass, given["mass"]])
    squares = np.linalg.eigvalsh(matrix / np.sqrt(np.outer(mass, mass)))
    yield Expected("foundation/natural_frequency", np.sqrt(squares))


# ----------------------------------------------------------------------------
# A base that moves.
# ----------------------------------------------------------------------------


def base_results(dense: Dense) -> Iterator[Expected]:
    given, on, root = dense.case["base_motion"], dense.mounted, "base_motion"
    place = np.eye(6)
    place[:3] = arm(-np.array(given["point"]))
    rate = TURN * dense.axis(f"{root}/transmissibility", 1)
    each = [on.on_base(rate, np.tile(np.eye(6)[n], (len(rate), 1))) for n in range(6)]
    for place_of, name in enumerate(("transmissibility", "relative_transmissibility")):
        value = np.array([np.abs(one[place_of][:, n]) for n, one in enumerate(each)])
        yield Expected(f"{root}/{name}", value)
    yield from _harmonics(dense, place)
    if "spectra" in given:
        yield from _spectra(dense, place)


def _harmonics(dense: Dense, place: np.ndarray) -> Iterator[Expected]:
    given, on, root = dense.case["base_motion"], dense.mounted, "base_motion/harmonic"
    rate, base = [], []
    for one in given["harmonics"]:
        w = one.get("frequency", one.get("order", 0.0) * dense.speed)
        said = []
        for names, phase in (
            (("displacement", "velocity", "acceleration"), "phase"),
            (("angle", "angular_velocity", "angular_acceleration"), "angular_phase"),
        ):
            power = next(n for n, name in enumerate(names) if name in one)
            turned = np.exp(1j * np.array(one.get(phase, np.zeros(3))))
            said.append(np.array(one[names[power]]) / (1j * w) ** power * turned)
        rate.append(w)
        base.append(place @ np.concatenate(said))
    rates = np.array(rate)
    motion, against, deflection, force = on.on_base(rates, np.array(base))
    column = rates[:, None]
    yield Expected(f"{root}/frequency", rates)
    for along, about, value in (
        ("translation", "rotation", motion[:, :6]),
        ("relative_translation", "relative_rotation", against[:, :6]),
        ("velocity", "angular_velocity", 1j * column * motion[:, :6]),
        ("acceleration", "angular_acceleration", -(column**2) * motion[:, :6]),
    ):
        yield Expected(f"{root}/{along}", value[:, :3])
        yield Expected(f"{root}/{about}", value[:, 3:])
    if on.springs is not None:
        yield Expected(f"{root}/foundation_translation", motion[:, 6:9])
        yield Expected(f"{root}/foundation_rotation", motion[:, 9:])
    total = np.abs(column**2 * motion[:, :3]).sum(axis=0)
    yield Expected(f"{root}/acceleration_peak", total)
    if "point" in dense.case:
        for name, value in zip(QUANTITIES, dense.signals(motion[:, :6], rates), strict=True):
            yield Expected(f"{root}/point_{name}", value)
            yield Expected(f"{root}/point_{name}_peak", np.abs(value).sum(axis=1))
    for name, value in (("deflection", deflection), ("mount_force", force)):
        yield Expected(f"{root}/{name}", np.moveaxis(value, 0, -1))
        top = longest(value[..., None], np.ones(1)).sum(axis=0)
        yield Expected(f"{root}/{name}_peak", top)


def _spectra(dense: Dense, place: np.ndarray) -> Iterator[Expected]:
    given, root = dense.case["base_motion"], "base_motion/spectrum"
    frequency, _, ratio = dense.mounted.modes()
    rows = [next(v for k, v in one.items() if k != "direction") for one in given["spectra"]]
    ends = {float(one) for row in rows for one in row["frequency"]}
    near = frequency[:, None] * (1.0 + ratio[:, None] * np.append(0.0, 2.0 ** np.arange(-2, 20)))
    near = np.append(near, 2.0 * frequency[:, None] - near)
    low, high = min(ends), max(ends)
    # curves of mounts bend at their rows
    for one in dense.mounted.mounts.entries:
        ends |= {w for w in one.get("over_frequency", {}).get("frequency", ()) if low < w < high}
    edge = np.unique([*ends, *near[(near > low) & (near < high)]])
    node, weight = np.polynomial.legendre.leggauss(24)
    half = 0.5 * np.diff(edge)[:, None]
    rate = (0.5 * (edge[1:] + edge[:-1])[:, None] + half * node).ravel()
    power = _powers(dense, rate, rows, place)
    each = (half * weight).ravel() / TURN
    rms = [np.sqrt(np.tensordot(each, one, axes=(0, 0))) for one in power]
    factor = given.get("peak_factor", 3.0)
    names = ["base_acceleration", *_MOTIONS, "deflection", "mount_force"]
    if "point" in dense.case:
        names += [f"point_{name}" for name in QUANTITIES]
    for name, value in zip(names, rms, strict=True):
        yield Expected(f"{root}/{name}_rms", value)
        if name != names[0]:
            yield Expected(f"{root}/{name}_peak", factor * value)
    drawn = TURN * dense.axis(f"{root}/density", 1)
    power = _powers(dense, drawn, rows, place)
    yield Expected(f"{root}/base_density", power[0].T)
    yield Expected(f"{root}/density", power[1 + _MOTIONS.index("acceleration")].T)


def _powers(
    dense: Dense, rate: np.ndarray, rows: list[Table], place: np.ndarray
) -> list[np.ndarray]:
    """Densities (m, ...) for each hertz of all that has an r.m.s. value."""
    given, total = dense.case["base_motion"], list[Any]()
    for one, row in zip(given["spectra"], rows, strict=True):
        x, y, at = np.array(row["frequency"]), np.array(row["density"]), rate
        if given.get("interpolation", "logarithmic") == "logarithmic":
            density = np.exp(np.interp(np.log(at), np.log(x), np.log(y)))
        else:
            density = np.interp(at, x, y)
        inside = (at >= x[0] * (1.0 - 1e-12)) & (at <= x[-1] * (1.0 + 1e-12))
        density = np.where(inside, density, 0.0)
        density = density * (rate**2 if "velocity" in one else 1.0)
        direction = ["x", "y", "z", "rx", "ry", "rz"].index(one["direction"])
        base = np.tile(place[:, direction], (len(rate), 1)) / -(rate[:, None] ** 2)
        motion, against, deflection, force = dense.mounted.on_base(rate, base + 0j)
        column = rate[:, None]
        body = motion[:, :6]
        series = (body, against[:, :6], column * body, column**2 * body)
        found = [column**2 * base[:, :3]]
        found += [part[:, half] for part in series for half in (slice(0, 3), slice(3, 6))]
        found += [deflection, force]
        if "point" in dense.case:
            found += [signal.T for signal in dense.signals(body, rate)]
        weighted = [
            density.reshape(-1, *(1,) * (part.ndim - 1)) * np.abs(part) ** 2 for part in found
        ]
        total = [a + b for a, b in zip(total, weighted, strict=True)] if total else weighted
    return total
