"""What a run records of a machine on its mounts, by path, from the dense model of the same case."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from dense_machine import Moved, OnMounts, arm, longest, over_cycle, peak
from dense_train import SAMPLES, TURN, Curve, Table, Train, integrals, pump_curve

from vibecalc.core.results.record import Record

#: relative to the size of a result, where its stated error is less
TOLERANCE = 1e-9
#: orders, halves where a cycle is two turns, that stand for all
MANY = 240
FORCE_COUPLE = (slice(0, 3), slice(3, 6))
QUANTITIES = ("displacement", "velocity", "acceleration")


class Expected(NamedTuple):
    """Value of the result at `path`, of the entries `at`.

    `size` is what the tolerance is relative to: the largest entry, if nothing is said. With `whole`
    it is of all orders, so that the stated error has to cover those left out. A record may `lack`
    a share of a load that is no measure of what arrives.
    """

    path: str
    value: Any
    size: float = 0.0
    at: Any = ...
    whole: bool = False
    lack: Any = False


class Dense:
    """The dense model of a case with the orders that its run kept.

    `deep`: also with as many orders as count, and with searches over the speeds of a run-up.
    """

    def __init__(self, case: Table, record: Record, deep: bool = True):
        self.case, self.record, self.deep = case, record, deep
        self.speed = case["machine"]["speed"]
        self.train, self.more = Train(case), Train(case)
        self.order = self.axis("isolation/body/translation_harmonics", 0)
        self.train.prepare(self.order)
        if deep:
            step = 0.5 if self.order[0] < 1.0 else 1.0
            self.more.prepare(step * np.arange(1, MANY + 1))
        self.mounted = OnMounts(case)
        self.rigid = OnMounts(case, rigid_ground=True)
        kind = case.get("foundation", {}).get("kind", "")
        self.foundation = kind
        self.moved = self.motion(self.train)
        #: forces and couples (6,) below which they are what rounding leaves of larger ones
        self.nothing = np.repeat(1e-9 * self.speed**2 * self.train.terms, 3)
        #: a train, the motion by its loads, and whether these are all orders
        self.kept_and_all = [(self.train, self.moved, False)]
        if deep:
            self.kept_and_all.append((self.more, self.motion(self.more), True))

    def axis(self, path: str, place: int) -> np.ndarray:
        return np.asarray(self.record[path].axes[place].values, dtype=float)

    def motion(self, train: Train, on: OnMounts | None = None) -> Moved:
        on = self.mounted if on is None else on
        return on.moved(train.order * self.speed, train.loads(self.speed))

    def values(self) -> Iterator[Expected]:
        """Results of the crank train and of the body on its mounts at the operating speed."""
        yield from self.shaking()
        if "parts" in self.case["machine"]["body"]:
            yield from self.body()
        if "rod" in self.case["machine"]["crank_train"]:
            yield from self.rod()
        if "pump_cycle" in self.case["machine"]["crank_train"]:
            yield from self.pump()
        yield from self.at_rest()
        yield from self.steady()
        yield from self.efficiency()
        if self.train.gas_acts:
            yield from self.torque()
        if "point" in self.case:
            yield from self.points()

    # ------------------------------------------------------------------------
    # Loads, rest, motion at the operating speed.
    # ------------------------------------------------------------------------

    def shaking(self) -> Iterator[Expected]:
        order = self.axis("excitation/force", 0)
        every = np.arange(1, MANY + 1)
        load = self.speed**2 * self.train.shaking
        for name, part in (("force", slice(0, 3)), ("couple", slice(3, 6))):
            # what cancels between cylinders is as wrong as these are large
            size = float(self.nothing[part].max()) * 1e9
            yield Expected(f"excitation/{name}", load[order.astype(int), part], size)
            for count, whole in [(order, False), (every, True)][: 1 + self.deep]:
                harmonics = load[count.astype(int), part].T
                value = peak(harmonics, count)
                yield Expected(f"excitation/{name}_peak", value, size, whole=whole)
        given = self.case["excitation"]["residual"]
        square = sum(
            (given[f"{name}_weight"] / length) ** 2
            * np.sum(np.abs(load[order.astype(int), part]) ** 2)
            for name, part, length in (
                ("force", slice(0, 3), 1.0), ("couple", slice(3, 6), given["reference_length"]),
            )
        )  # fmt: skip
        yield Expected("excitation/residual", np.sqrt(square))
        masses = np.array([one[1:] for one in self.train.masses()])
        for name, column in (("reciprocating", 0), ("rotating", 1)):
            yield Expected(f"excitation/mass/{name}", masses[:, column])
        given = self.case["machine"]["crank_train"].get("counterweights")
        if given:
            force = np.array([one["unbalance"] for one in given]) * self.speed**2
            along = self.train.origin @ self.train.axis
            lever = np.abs([along + one.get("position", 0.0) for one in given])
            yield Expected("excitation/counterweight/force", force)
            yield Expected("excitation/counterweight/couple", force * lever)

    def body(self) -> Iterator[Expected]:
        solid = self.rigid.solid
        yield Expected("body/mass", solid.mass)
        yield Expected("body/centre", solid.centre)
        moments = solid.central[3:, 3:]
        yield Expected("body/moments", np.diag(moments))
        yield Expected("body/products", -moments[[0, 0, 1], [1, 2, 2]], size=moments.max())
        yield Expected("body/principal_moments", np.linalg.eigvalsh(moments))

    def rod(self) -> Iterator[Expected]:
        train, given = self.train, self.case["machine"]["crank_train"]["rod"]
        angle = TURN * np.arange(SAMPLES) / SAMPLES
        _, bent = train.piston.lean_slopes(angle)
        place = given["crank_pin_to_mass_centre"]
        points = given["mass"] * place * (train.piston.rod - place)
        yield Expected("excitation/rod/split_inertia", points)
        order = np.arange(1, MANY + 1)
        spectrum = 2.0 / SAMPLES * np.fft.rfft(bent)[order]
        largest = float(peak(spectrum, order)) * self.speed**2
        if "inertia" not in given:
            yield Expected("excitation/rod/couple_bound", points * largest)
            return
        yield Expected("excitation/rod/couple_peak", abs(train.beyond_points) * largest)
        kept = self.axis("excitation/rod/couple", 0).astype(int)
        value = np.where(kept > 0, train.beyond_points * self.speed**2 * spectrum[kept - 1], 0.0)
        yield Expected("excitation/rod/couple", value)

    def pump(self) -> Iterator[Expected]:
        root, given = "excitation/pump", self.case["machine"]["crank_train"]
        piston, cycle = self.train.piston, given["pump_cycle"]
        curve, area = pump_curve(given), 0.25 * np.pi * given["bore"] ** 2
        opens, bottom, gives = curve.ends[1:4]
        swept = area * (piston.place(curve.ends[0]) - piston.place(bottom))
        drawn = area * (piston.place(opens) - piston.place(bottom))
        # the work on the liquid is that of the pressure against the travel of the plunger
        power = Curve(curve.ends, lambda a: curve.value(a) * area * piston.slopes(a)[0])
        work, count = integrals(power, np.ones(1))[1] * TURN, len(given["cylinders"])
        rate = count * self.speed / TURN
        for name, value in (
            ("suction_opens", opens - curve.ends[0]), ("discharge_opens", gives - bottom),
            ("swept_volume", swept), ("volumetric_efficiency", drawn / swept), ("work", work),
            ("flow", rate * drawn), ("power", rate * work), ("mean_torque", -count * work / TURN),
        ):  # fmt: skip
            yield Expected(f"{root}/{name}", value)
        order = self.axis(f"{root}/torque", 0)
        yield Expected(f"{root}/torque", self.train.torque_of_gas(order)[0][1])
        angle = self.axis(f"{root}/pressure", 0)
        turned = curve.ends[0] + np.mod(angle - curve.ends[0], TURN)
        outside = cycle.get("outside_pressure", 101325.0)
        yield Expected(f"{root}/pressure", curve.value(turned) + outside)

    def at_rest(self) -> Iterator[Expected]:
        on, mounts = self.rigid, self.rigid.mounts
        up, root = on.up, "isolation/mounts"
        yield Expected("isolation/support_displacement/static", -(mounts.arms @ on.rest) @ up)
        share = -mounts.rest_force @ up
        yield Expected("isolation/support_force/static", share)
        yield from self._modes("isolation")
        if not mounts.follows_load:
            return
        outer = np.einsum("ni,nij,nj->n", mounts.axis, mounts.stiffness, mounts.axis)
        yield Expected(f"{root}/load", mounts.load)
        yield Expected(f"{root}/deflection", mounts.deflection)
        yield Expected(f"{root}/static_stiffness", mounts.slope)
        yield Expected(f"{root}/stiffness", outer)
        at = self.axis(f"{root}/load_curve", 1)
        yield Expected(f"{root}/load_curve", [[law(u)[0] for u in at] for law in mounts.laws])
        left = mounts.to_stop(mounts.deflection, mounts.deflection)
        yield Expected(f"{root}/clearance_at_rest", left, size=float(np.abs(left).max()))

    def _modes(self, root: str) -> Iterator[Expected]:
        """Of the body on rigid ground."""
        solid = self.rigid.solid
        frequency, shapes, ratio = self.rigid.modes()
        yield Expected(f"{root}/modes/natural_frequency", frequency)
        yield Expected(f"{root}/modes/damping_ratio", ratio)
        # natural frequencies that are nearly one leave the shapes open between them
        if np.min(np.diff(frequency) / frequency[1:]) < 1e-6:
            return
        found = np.asarray(self.record[f"{root}/modes/shape"].values)
        sense = np.sign(np.sum(found * shapes, axis=1, keepdims=True))
        yield Expected(f"{root}/modes/shape", sense * shapes)
        moved = shapes.copy()
        moved[:, :3] += np.cross(shapes[:, 3:], solid.centre)
        yield Expected(f"{root}/modes/energy_fraction", moved * (moved @ solid.central))

    def steady(self) -> Iterator[Expected]:
        moved, order, up = self.moved, self.order, self.rigid.up
        arms = self.rigid.mounts.arms
        yield Expected("isolation/body/translation_harmonics", moved.body[:, :3])
        yield Expected("isolation/body/rotation_harmonics", moved.body[:, 3:])
        at = np.moveaxis((arms @ moved.body[:, None, :, None])[..., 0], 0, -1)
        yield Expected("isolation/support_displacement/steady_harmonics", at)
        path = "isolation/support_force/steady_harmonics"
        yield Expected(path, np.moveaxis(moved.force, 0, -1))
        couple = self.train.mean_couple(self.speed) * self.train.axis
        mean = self.rigid.constant(couple)
        mounts, root = self.rigid.mounts, "isolation/mounts"
        for train, every, whole in self.kept_and_all:
            count = train.order
            force = np.moveaxis(every.force, 0, -1)
            yield Expected("isolation/support_force/steady_peak", longest(force, count),
                           whole=whole)  # fmt: skip
            upwards = np.einsum("nia,ma,i->nm", arms, every.body, up)
            path = "isolation/support_displacement/vertical_peak"
            yield Expected(path, peak(upwards, count), whole=whole)
            down = -np.einsum("mni,i->nm", every.deflection, up)
            still = -(mounts.arms @ self.rigid.rest) @ up - mean[0] @ up
            low, high = over_cycle(down, count)
            excursion = np.maximum(np.abs(still + low), np.abs(still + high))
            yield Expected("isolation/support_displacement/total", excursion, whole=whole)
            load = -np.einsum("mni,i->nm", every.force, up)
            carried = -mounts.rest_force @ up - mean[1] @ up
            low, high = over_cycle(load, count)
            size = float(np.abs(carried).max() + np.abs(high).max())
            for name, end in (("largest_load", high), ("minimum_load", low)):
                path = f"isolation/support_force/{name}"
                yield Expected(path, carried + end, size=size, whole=whole)
            if mounts.follows_load:
                along = -np.einsum("mni,ni->nm", every.deflection, mounts.axis)
                low, high = over_cycle(along, count)
                size = float(np.abs(mounts.deflection).max() + high.max())
                yield Expected(f"{root}/travel", np.maximum(-low, high), whole=whole)
                still = mounts.deflection - np.einsum("ni,ni->n", mean[0], mounts.axis)
                left = mounts.to_stop(still + high, still + low)
                yield Expected(f"{root}/clearance", left, size=size, whole=whole)
        if "over_frequency" in mounts.entries[0]:
            passing = mounts.passing(order * self.speed)
            along = np.einsum("ni,mnij,nj->nm", mounts.axis, passing, mounts.axis)
            damping = np.einsum("ni,nij,nj->n", mounts.axis, mounts.damping, mounts.axis)
            loss = along.imag - np.outer(damping, order * self.speed)
            yield Expected(f"{root}/order_stiffness", along.real)
            yield Expected(f"{root}/order_loss_factor", loss / along.real)

    def torque(self) -> Iterator[Expected]:
        root, axis = "isolation/torque_reaction", self.train.axis
        torque = self.train.torque(self.speed)
        mean = self.train.mean_couple(self.speed)
        yield Expected(f"{root}/couple", torque[:, 3:] @ axis)
        yield Expected(f"{root}/mean_couple", mean, size=float(np.abs(torque).max()))
        force = self.rigid.constant(mean * axis)[1]
        yield Expected("isolation/support_force/mean", force)
        for train, moved, whole in self.kept_and_all:
            roll = moved.body[:, 3:] @ axis
            yield Expected(f"{root}/roll_peak", peak(roll, train.order), whole=whole)
            rate = train.order * self.speed
            by_torque = self.mounted.moved(rate, train.torque(self.speed)).force
            both = np.stack([by_torque, moved.force - by_torque], axis=2)
            value = longest(np.moveaxis(both, 0, -1), train.order)
            yield Expected("isolation/support_force/by_cause", value, whole=whole)
        if self.foundation in ("", "mass"):
            yield from self._nearest()

    def _nearest(self) -> Iterator[Expected]:
        frequency, shapes, _ = self.rigid.modes()
        force = np.abs(self.train.loads(self.speed) @ shapes.T)
        force = np.where(force > np.abs(shapes) @ self.nothing, force, 0.0)
        share = force / np.maximum(force.max(axis=0), np.finfo(float).tiny)
        ratio = self.order[:, None] * self.speed / frequency
        away = np.where(share >= 1e-3, np.abs(ratio - 1.0), np.inf)
        clear = ~np.any((share > 0.9e-3) & (share < 1.1e-3), axis=0)
        place = np.argmin(away, axis=0)[clear]
        nearest = ratio[place, np.flatnonzero(clear)] - 1.0
        none = np.isinf(away.min(axis=0)[clear])
        root, nearest = "isolation/torque_reaction", np.where(none, np.inf, nearest)
        yield Expected(f"{root}/nearest_order", np.where(none, 0.0, self.order[place]), at=clear)
        yield Expected(f"{root}/margin", nearest, at=clear)

    # ------------------------------------------------------------------------
    # Efficiency.
    # ------------------------------------------------------------------------

    def efficiency(self) -> Iterator[Expected]:
        root, on = "isolation/efficiency", self.mounted
        centre = np.eye(6)
        centre[3:, :3] = arm(on.solid.centre)[:, 3:]
        shares = []
        for train, _, whole in self.kept_and_all:
            held = train.loads(self.speed) @ centre.T
            ground = self.motion(train).ground @ centre.T
            passed = centre @ through(on, train.order * self.speed) @ np.linalg.inv(centre)
            own = np.concatenate([alone(held, passed, part) for part in FORCE_COUPLE], axis=-1)
            for name, part in zip(("force", "couple"), FORCE_COUPLE, strict=True):
                each = held[:, part], ground[:, part], own[:, part]
                nothing = float(self.nothing[part].max())
                yield from _of_vector(f"{root}/{name}", *each, train.order, whole, nothing)
            rms = [np.sqrt(0.5 * np.sum(np.abs(one) ** 2, axis=0)) for one in (held, ground, own)]
            shares.append((*rms, whole))
        for held, ground, own, whole in shares:
            largest = np.repeat([held[:3].max(), held[3:].max()], 3)
            acts = (held > 1e-6 * largest) & (held > self.nothing)
            acts &= ~swamped(held, ground, own)
            value = 1.0 - ground[acts] / held[acts]
            size = float(np.max(np.abs(value), initial=1.0)) * 1e6
            yield Expected(f"{root}/by_direction", value, size=size, at=acts, whole=whole)
        rate = TURN * self.axis(f"{root}/transmissibility", 1)
        passed = centre @ through(on, rate) @ np.linalg.inv(centre)
        value = np.abs(np.diagonal(passed, axis1=1, axis2=2)).T
        yield Expected(f"{root}/transmissibility", value)

    # ------------------------------------------------------------------------
    # Points.
    # ------------------------------------------------------------------------

    def rows(self) -> np.ndarray:
        """Readings (r, 6) of the points by the motion of the reference point."""
        found = []
        for one in self.case["point"]:
            own = one.get("axes", [one["direction"]] if "direction" in one else np.eye(3))
            for direction in np.array(own, dtype=float):
                found.append(direction / np.linalg.norm(direction) @ arm(one["position"]))
        return np.array(found)

    def band(self) -> tuple[float, float]:
        given = self.case.get("vibration_severity", {}).get("band", (2.0 * TURN, 1000.0 * TURN))
        return given[0], given[1]

    def signals(self, body: np.ndarray, rate: np.ndarray) -> list[np.ndarray]:
        """Displacement, velocity and acceleration (readings, ..., m) of motions (..., m, 6)."""
        place = np.moveaxis(body @ self.rows().T, -1, 0)
        return [place * (1j * rate) ** n for n in range(3)]

    def points(self) -> Iterator[Expected]:
        for train, moved, whole in self.kept_and_all:
            rate = train.order * self.speed
            signals = self.signals(moved.body, rate)
            inside = (rate >= self.band()[0]) & (rate <= self.band()[1])
            rms = [np.sqrt(0.5 * np.sum(np.abs(one[:, inside]) ** 2, axis=1)) for one in signals]
            for name, signal, square in zip(QUANTITIES, signals, rms, strict=True):
                if not whole:
                    yield Expected(f"points/{name}", signal)
                yield Expected(f"points/{name}_peak", peak(signal, train.order), whole=whole)
                yield Expected(f"points/{name}_rms", square, whole=whole)
            if "vibration_severity" in self.case and np.any(inside[: len(self.order)]):
                yield Expected("points/severity", severity(rms), whole=whole)


def severity(rms: list[np.ndarray]) -> np.ndarray:
    """Velocity of the grade that displacement, velocity and acceleration all keep."""
    factors = (TURN * 10.0, 1.0, 1.0 / (TURN * 250.0))
    return np.asarray(np.max([f * one for f, one in zip(factors, rms, strict=True)], axis=0))


def through(on: OnMounts, rate: np.ndarray) -> np.ndarray:
    """Loads on the ground (m, 6, 6) by unit loads on the body."""
    columns = [on.moved(rate, np.tile(one, (len(rate), 1)) + 0j).ground for one in np.eye(6)]
    return np.stack(columns, axis=-1)


def alone(held: np.ndarray, passed: np.ndarray, part: slice) -> np.ndarray:
    """What arrives (m, 3) of the forces, or of the couples, of loads (m, 6) without the others."""
    return np.einsum("mij,mj->mi", passed[:, part, part], held[:, part])


def swamped(held: Any, ground: Any, own: Any) -> Any:
    """Whether more may arrive than acts, of which the own part may be less than a hundredth.

    Such loads have no share. Twice that is on the safe side.
    """
    return (ground > (1.0 - 1e-9) * held) & (own < 2e-2 * ground)


def by_order(
    path: str, held: np.ndarray, ground: np.ndarray, own: np.ndarray, nothing: float
) -> Expected:
    """Share kept from the ground, of orders that are more than rounding."""
    first, second, third = (np.linalg.norm(one, axis=-1) for one in (held, ground, own))
    acts = first > max(1e-5 * first.max(), nothing)
    acts &= ~swamped(first, second, third)
    value = 1.0 - second[acts] / first[acts]
    return Expected(path, value, size=1e5 * float(np.abs(value).max(initial=1.0)), at=acts)


def _of_vector(
    path: str,
    held: np.ndarray,
    ground: np.ndarray,
    own: np.ndarray,
    order: np.ndarray,
    whole: bool,
    nothing: float,
) -> Iterator[Expected]:
    """What acts and what arrives (orders, 3), over the cycle, and the share that does not.

    Of what arrives the `own` part is by what acts. Less than `nothing` is rounding, of which there
    is no share.
    """
    if not whole:
        yield Expected(f"{path}/held", held, size=max(1e9 * nothing, float(np.abs(held).max())))
        yield Expected(f"{path}/ground", ground)
        resultant = by_order(f"{path}/by_order", held, ground, own, nothing)
        yield resultant._replace(at=(resultant.at, -1))
    sizes = {
        "rms": [np.linalg.norm(one) / np.sqrt(2.0) for one in (held, ground)],
        "peak": [float(longest(one.T, order)) for one in (held, ground)],
    }
    lack = swamped(*(np.linalg.norm(one) for one in (held, ground, own)))
    for name, (first, second) in sizes.items():
        yield Expected(f"{path}/held_{name}", first, whole=whole)
        yield Expected(f"{path}/ground_{name}", second, whole=whole)
        if first <= nothing:
            continue
        share = 1.0 - second / first
        yield Expected(f"{path}/{name}", share, max(1.0, abs(share)), whole=whole, lack=lack)
        level = 20.0 * np.log10(first / second)
        yield Expected(f"{path}/{name}_level", level, 10.0 + abs(level), whole=whole, lack=lack)


def compare(expected: Expected, record: Record) -> str:
    """What is off more than allowed; nothing where all is well."""
    if expected.path not in record:  # kept orders that cancel have no share
        return "" if expected.whole or expected.lack else f"{expected.path}: absent"
    found = record[expected.path]
    values = np.asarray(found.values)[expected.at]
    value = np.asarray(expected.value)
    if values.shape != value.shape:
        return f"{expected.path}: {values.shape} and not {value.shape}"
    same = values == value
    if expected.whole:  # what only orders left out bring has no share
        same |= ~np.isfinite(values)
    size = expected.size or float(np.max(np.abs(value), initial=0.0, where=np.isfinite(value)))
    off = np.abs(np.where(same, 0.0, values - np.where(same, 0.0, value)))
    stated = np.full(off.shape, float(found.error_estimate))
    if found.errors is not None:
        stated = np.asarray(found.errors)[expected.at]
    slack = TOLERANCE * size
    allowed = stated + slack if expected.whole else np.maximum(stated, slack)
    if np.all(off <= allowed):
        return ""
    worst = np.unravel_index(np.argmax(off - allowed), off.shape)
    kind = ", all orders" if expected.whole else ""
    return (
        f"{expected.path}{kind} {worst}: off by {off[worst]:.3g} of {size:.6g}, allowed "
        f"{allowed[worst]:.3g} (stated {stated[worst]:.3g})"
    )
