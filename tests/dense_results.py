"""What a run records of a machine on its mounts, by path, from the dense model of the same case."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from dense_machine import Moved, OnMounts, arm, longest, over_cycle, peak
from dense_train import SAMPLES, TURN, Curve, Table, Train, integrals, pump_curve
from scipy.optimize import minimize_scalar

from vibecalc.core.results.record import Record

#: relative to the size of a result, where its stated error is less
TOLERANCE = 1e-9
#: orders, halves where a cycle is two turns, that stand for all
MANY = 240
QUANTITIES = ("displacement", "velocity", "acceleration")


class Expected(NamedTuple):
    """Value of the result at `path`, of the entries `at`.

    `size` is what the tolerance is relative to: the largest entry, if nothing is said. With `whole`
    it is of all orders, so that the stated error has to cover those left out.
    """

    path: str
    value: Any
    size: float = 0.0
    at: Any = ...
    whole: bool = False


class Dense:
    """The dense model of a case with the orders that its run kept.

    `deep`: also with as many orders as count, and with searches over the speeds of a run-up.
    """

    def __init__(self, case: Table, record: Record, deep: bool = True):
        self.case, self.record, self.deep = case, record, deep
        self.speed = case["machine"]["speed"]
        self.train, self.more = Train(case), Train(case)
        self.order = self._axis("isolation/body/translation_harmonics", 0)
        self.train.prepare(self.order)
        if deep:
            step = 0.5 if self.order[0] < 1.0 else 1.0
            self.more.prepare(step * np.arange(1, MANY + 1))
        self.mounted = OnMounts(case)
        self.rigid = OnMounts(case, rigid_ground=True)
        kind = case.get("foundation", {}).get("kind", "")
        self.foundation = kind
        if kind == "mass":
            self.mounted = self.rigid
        self.moved = self._moved(self.train)
        #: forces and couples (6,) below which they are what rounding leaves of larger ones
        self.nothing = np.repeat(1e-9 * self.speed**2 * self.train.terms, 3)
        #: a train, the motion by its loads, and whether these are all orders
        self.kept_and_all = [(self.train, self.moved, False)]
        # not yet where twice the kept orders of a torque hold none of cylinders that work evenly:
        # errors have nothing then of what is left out
        cylinders = len(case["machine"]["crank_train"]["cylinders"])
        if deep and not (self.train.gas_acts and 2 * len(self.order) < 3 * cylinders):
            self.kept_and_all.append((self.more, self._moved(self.more), True))

    def _axis(self, path: str, place: int) -> np.ndarray:
        return np.asarray(self.record[path].axes[place].values, dtype=float)

    def _moved(self, train: Train, on: OnMounts | None = None) -> Moved:
        on = self.mounted if on is None else on
        return on.moved(train.order * self.speed, train.loads(self.speed))

    def values(self) -> Iterator[Expected]:
        yield from self.shaking()
        yield from self.body()
        if "rod" in self.case["machine"]["crank_train"]:
            yield from self.rod()
        if "pump_cycle" in self.case["machine"]["crank_train"]:
            yield from self.pump()
        yield from self.at_rest()
        yield from self.steady()
        if self.case["isolation"].get("efficiency"):
            yield from self.efficiency()
        if self.train.gas_acts:
            yield from self.torque()
        if "point" in self.case:
            yield from self.points()
        if self.foundation in ("body", "impedance"):
            yield from self.coupled()
        if self.foundation == "mass":
            yield from self.two_masses()
        if "base_motion" in self.case:
            yield from self.base_motion()
        if "response" in self.case:
            yield from self.response()
        if "run_up" in self.case["isolation"]:
            yield from self.run_up()

    # ------------------------------------------------------------------------
    # Loads, rest, motion at the operating speed.
    # ------------------------------------------------------------------------

    def shaking(self) -> Iterator[Expected]:
        order = self._axis("excitation/force", 0)
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
        kept = self._axis("excitation/rod/couple", 0).astype(int)
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
        order = self._axis(f"{root}/torque", 0)
        yield Expected(f"{root}/torque", self.train.torque_of_gas(order)[0][1])
        angle = self._axis(f"{root}/pressure", 0)
        turned = curve.ends[0] + np.mod(angle - curve.ends[0], TURN)
        outside = cycle.get("outside_pressure", 101325.0)
        yield Expected(f"{root}/pressure", curve.value(turned) + outside)

    def at_rest(self) -> Iterator[Expected]:
        on, mounts = self.rigid, self.rigid.mounts
        up, root = on.up, "isolation/mounts"
        yield Expected("isolation/support_displacement/sag", -(mounts.arms @ on.rest) @ up)
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
        at = self._axis(f"{root}/load_curve", 1)
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
        if np.abs(np.diff(frequency)).min() < 1e-4 * frequency[-1]:
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
            yield Expected("isolation/support_displacement/excursion", excursion, whole=whole)
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
        root, on = "isolation/efficiency", self.rigid
        centre = np.eye(6)
        centre[3:, :3] = arm(on.solid.centre)[:, 3:]
        shares = []
        for train, _, whole in self.kept_and_all:
            held = train.loads(self.speed) @ centre.T
            ground = self._moved(train, on).ground @ centre.T
            for name, part in (("force", slice(0, 3)), ("couple", slice(3, 6))):
                both = held[:, part], ground[:, part]
                nothing = float(self.nothing[part].max())
                yield from _of_vector(f"{root}/{name}", *both, train.order, whole, nothing)
            rms = [np.sqrt(0.5 * np.sum(np.abs(one) ** 2, axis=0)) for one in (held, ground)]
            shares.append((*rms, whole))
        for held, ground, whole in shares:
            largest = np.repeat([held[:3].max(), held[3:].max()], 3)
            acts = (held > 1e-6 * largest) & (held > self.nothing)
            value = 1.0 - ground[acts] / held[acts]
            size = float(np.max(np.abs(value), initial=1.0)) * 1e6
            yield Expected(f"{root}/by_direction", value, size=size, at=acts, whole=whole)
        rate = TURN * self._axis(f"{root}/transmissibility", 1)
        through = centre @ _through(on, rate) @ np.linalg.inv(centre)
        value = np.abs(np.diagonal(through, axis1=1, axis2=2)).T
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

    def _signals(self, body: np.ndarray, rate: np.ndarray) -> list[np.ndarray]:
        """Displacement, velocity and acceleration (readings, ..., m) of motions (..., m, 6)."""
        place = np.moveaxis(body @ self.rows().T, -1, 0)
        return [place * (1j * rate) ** n for n in range(3)]

    def points(self) -> Iterator[Expected]:
        for train, moved, whole in self.kept_and_all:
            rate = train.order * self.speed
            signals = self._signals(moved.body, rate)
            inside = (rate >= self.band()[0]) & (rate <= self.band()[1])
            rms = [np.sqrt(0.5 * np.sum(np.abs(one[:, inside]) ** 2, axis=1)) for one in signals]
            for name, signal, square in zip(QUANTITIES, signals, rms, strict=True):
                if not whole:
                    yield Expected(f"points/{name}", signal)
                yield Expected(f"points/{name}_peak", peak(signal, train.order), whole=whole)
                yield Expected(f"points/{name}_rms", square, whole=whole)
            if "vibration_severity" in self.case and np.any(inside[: len(self.order)]):
                yield Expected("points/severity", _severity(rms), whole=whole)

    # ------------------------------------------------------------------------
    # A foundation that moves.
    # ------------------------------------------------------------------------

    def coupled(self) -> Iterator[Expected]:
        root, on, moved = "foundation/coupled", self.mounted, self.moved
        rate = self.order * self.speed
        if on.springs is not None:
            frequency, shapes, ratio = on.modes()
            yield Expected(f"{root}/modes/natural_frequency", frequency)
            yield Expected(f"{root}/modes/damping_ratio", ratio)
            if np.abs(np.diff(frequency)).min() > 1e-4 * frequency[-1]:
                share = (shapes * (shapes @ on.matrices()[0]))[:, :6].sum(axis=1)
                yield Expected(f"{root}/modes/machine_share", share)
        if on.springs is not None or on.plate:
            yield Expected(f"{root}/body/translation", moved.below[:, :3])
            yield Expected(f"{root}/body/rotation", moved.below[:, 3:])
        yield Expected(f"{root}/foot", np.moveaxis(moved.foot, 0, -1))
        velocity = 1j * rate[:, None, None] * moved.foot
        yield Expected(f"{root}/power", 0.5 * np.sum((velocity * moved.force.conj()).real, (1, 2)))
        for train, every, whole in self.kept_and_all:
            squares = np.abs(train.order[:, None, None] * self.speed * every.foot) ** 2
            value = np.sqrt(0.5 * squares.sum(axis=(0, 2)))
            yield Expected(f"{root}/foot_velocity_rms", value, whole=whole)
            held, still = train.loads(self.speed), self._moved(train, self.rigid).ground
            for name, load in (("ground", every.ground), ("rigid", still)):
                for what, part in (("force", slice(0, 3)), ("couple", slice(3, 6))):
                    path, size = f"{root}/{name}/{what}", np.linalg.norm(held[:, part])
                    arrived = np.linalg.norm(load[:, part])
                    yield Expected(f"{path}_rms", arrived / np.sqrt(2.0), whole=whole)
                    nothing = float(self.nothing[part].max())
                    if size > nothing:
                        value = 1.0 - arrived / size
                        size = max(1.0, abs(value))
                        yield Expected(f"{path}_efficiency", value, size=size, whole=whole)
                    if not whole:
                        yield Expected(path, load[:, part])
                        both = held[:, part], load[:, part]
                        yield _by_order(f"{path}_by_order", *both, nothing)
        rate = TURN * self._axis(f"{root}/ground/transmissibility", 1)
        for name, one in (("ground", on), ("rigid", self.rigid)):
            value = np.abs(np.diagonal(_through(one, rate), axis1=1, axis2=2)).T
            yield Expected(f"{root}/{name}/transmissibility", value)

    def two_masses(self) -> Iterator[Expected]:
        given, on = self.case["foundation"], self.rigid
        order = self._axis("foundation/machine", 0)
        every = np.arange(1, MANY + 1)
        for count, whole in [(order, False), (every, True)][: 1 + self.deep]:
            rate = count * self.speed
            force = self.speed**2 * self.train.shaking[count.astype(int), :3] @ on.up
            mounts = np.einsum("i,mnij,j->m", on.up, on.mounts.passing(rate), on.up)
            under = given["stiffness"] * (1.0 + 1j * given["loss_factor"])
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
            for name, value in results.items():
                if not whole:
                    yield Expected(f"foundation/{name}", value)
                if name != "machine":
                    yield Expected(f"foundation/{name}_peak", peak(value, count), whole=whole)
        stiff = on.mounts.passing(np.zeros(1))[0].real
        k = np.einsum("i,nij,j->", on.up, stiff, on.up)
        matrix = np.array([[k, -k], [-k, k + given["stiffness"]]])
        mass = np.array([on.solid.mass, given["mass"]])
        squares = np.linalg.eigvalsh(matrix / np.sqrt(np.outer(mass, mass)))
        yield Expected("foundation/natural_frequency", np.sqrt(squares))

    # ------------------------------------------------------------------------
    # A base that moves.
    # ------------------------------------------------------------------------

    def base_motion(self) -> Iterator[Expected]:
        given, on, root = self.case["base_motion"], self.mounted, "base_motion"
        place = np.eye(6)
        place[:3] = arm(-np.array(given["point"]))
        rate = TURN * self._axis(f"{root}/transmissibility", 1)
        each = [on.on_base(rate, np.tile(np.eye(6)[n], (len(rate), 1))) for n in range(6)]
        for place_of, name in enumerate(("transmissibility", "relative_transmissibility")):
            value = np.array([np.abs(one[place_of][:, n]) for n, one in enumerate(each)])
            yield Expected(f"{root}/{name}", value)
        yield from self._harmonics(place)
        if "spectra" in given:
            yield from self._spectra(place)

    def _harmonics(self, place: np.ndarray) -> Iterator[Expected]:
        given, on, root = self.case["base_motion"], self.mounted, "base_motion/harmonic"
        rate, base = [], []
        for one in given["harmonics"]:
            w = one.get("frequency", one.get("order", 0.0) * self.speed)
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
        for name, value in (("deflection", deflection), ("mount_force", force)):
            yield Expected(f"{root}/{name}", np.moveaxis(value, 0, -1))
            top = longest(value[..., None], np.ones(1)).sum(axis=0)
            yield Expected(f"{root}/{name}_peak", top)

    def _spectra(self, place: np.ndarray) -> Iterator[Expected]:
        given, root = self.case["base_motion"], "base_motion/spectrum"
        frequency, _, ratio = self.mounted.modes()
        rows = [next(v for k, v in one.items() if k != "direction") for one in given["spectra"]]
        ends = {float(one) for row in rows for one in row["frequency"]}
        near = frequency[:, None] * (1.0 + ratio[:, None] * np.append(0.0, 2.0 ** np.arange(-2, 20)))
        near = np.append(near, 2.0 * frequency[:, None] - near)
        low, high = min(ends), max(ends)
        edge = np.unique([*ends, *near[(near > low) & (near < high)]])
        node, weight = np.polynomial.legendre.leggauss(24)
        half = 0.5 * np.diff(edge)[:, None]
        rate = (0.5 * (edge[1:] + edge[:-1])[:, None] + half * node).ravel()
        power = self._powers(rate, rows, place)
        each = (half * weight).ravel() / TURN
        rms = [np.sqrt(np.tensordot(each, one, axes=(0, 0))) for one in power]
        factor = given.get("peak_factor", 3.0)
        names = ["base_acceleration", *_MOTIONS, "deflection", "mount_force"]
        for name, value in zip(names, rms, strict=True):
            yield Expected(f"{root}/{name}_rms", value)
            if name != names[0]:
                yield Expected(f"{root}/{name}_peak", factor * value)
        drawn = TURN * self._axis(f"{root}/density", 1)
        power = self._powers(drawn, rows, place)
        yield Expected(f"{root}/base_density", power[0].T)
        yield Expected(f"{root}/density", power[1 + _MOTIONS.index("acceleration")].T)

    def _powers(self, rate: np.ndarray, rows: list[Table], place: np.ndarray) -> list[np.ndarray]:
        """Densities (m, ...) for each hertz of all that has an r.m.s. value."""
        given, total = self.case["base_motion"], list[Any]()
        for one, row in zip(given["spectra"], rows, strict=True):
            x, y, at = np.array(row["frequency"]), np.array(row["density"]), rate
            if given.get("interpolation", "logarithmic") == "logarithmic":
                density = np.exp(np.interp(np.log(at), np.log(x), np.log(y)))
            else:
                density = np.interp(at, x, y)
            density = np.where((at >= x[0]) & (at <= x[-1]), density, 0.0)
            density = density * (rate**2 if "velocity" in one else 1.0)
            direction = ["x", "y", "z", "rx", "ry", "rz"].index(one["direction"])
            base = np.tile(place[:, direction], (len(rate), 1)) / -(rate[:, None] ** 2)
            motion, against, deflection, force = self.mounted.on_base(rate, base + 0j)
            column = rate[:, None]
            body = motion[:, :6]
            series = (body, against[:, :6], column * body, column**2 * body)
            found = [column**2 * base[:, :3]]
            found += [part[:, half] for part in series for half in (slice(0, 3), slice(3, 6))]
            found += [deflection, force]
            weighted = [
                density.reshape(-1, *(1,) * (part.ndim - 1)) * np.abs(part) ** 2 for part in found
            ]
            total = [a + b for a, b in zip(total, weighted, strict=True)] if total else weighted
        return total

    # ------------------------------------------------------------------------
    # Energies of the body under the shaking alone.
    # ------------------------------------------------------------------------

    def _shaken(self, speed: float, order: np.ndarray) -> Moved:
        load = speed**2 * self.train.shaking[order.astype(int)]
        return self.rigid.moved(order * speed, load)

    def response(self) -> Iterator[Expected]:
        order = self._axis("response/translation_harmonics", 0)
        on, every = self.rigid, np.arange(1, MANY + 1)
        yield from self._modes("response")
        weights = {"kinetic": on.matrices()[0], "potential": on.matrices()[1]}
        for count, whole in [(order, False), (every, True)][: 1 + self.deep]:
            moved = self._shaken(self.speed, count)
            for name, value, parts in (
                ("", moved.body, ("translation", "rotation")),
                ("ground", moved.ground, ("ground_force", "ground_couple")),
            ):
                for part, half in zip(parts, (slice(0, 3), slice(3, 6)), strict=True):
                    path = f"response/{part}"
                    if not whole:
                        yield Expected(path if name else f"{path}_harmonics", value[:, half])
                    top = peak(value[:, half].T, count)
                    yield Expected(f"{path}_peak", top, whole=whole)
            for name, weight in weights.items():
                rate = count[:, None] * self.speed if name == "kinetic" else 1.0
                state = 1j * rate * moved.body if name == "kinetic" else moved.body
                half_of = np.linalg.cholesky(weight)
                signal = state @ half_of
                mean = 0.25 * np.sum(np.abs(signal) ** 2, axis=1)
                root = f"response/{name}_energy"
                if not whole:
                    yield Expected(f"{root}/mean_by_order", mean)
                    swing = 0.25 * np.abs(np.sum(signal**2, axis=1))
                    yield Expected(f"{root}/peak_by_order", mean + swing)
                yield Expected(f"{root}/mean", mean.sum(), whole=whole)
                top = longest(signal.T, count) ** 2 / 2.0
                yield Expected(f"{root}/peak", top, whole=whole)
        speeds = self._axis("response/run_up/kinetic_energy", 0)
        chosen = _some(len(speeds), self.record["response/run_up/kinetic_energy"].values)
        for name, weight in weights.items():
            value = []
            for speed in speeds[chosen]:
                body = self._shaken(speed, order).body
                rate = order[:, None] * speed if name == "kinetic" else np.ones((len(order), 1))
                value.append(0.25 * np.sum(((rate * body).conj() @ weight * (rate * body)).real))
            size = float(np.max(self.record[f"response/run_up/{name}_energy"].values))
            yield Expected(f"response/run_up/{name}_energy", value, size=size, at=chosen)

    # ------------------------------------------------------------------------
    # Over a run-up.
    # ------------------------------------------------------------------------

    @property
    def of_run_up(self) -> OnMounts:
        return self.mounted if self.foundation == "body" else self.rigid

    def _at(self, speeds: np.ndarray) -> Moved:
        """Motion at speeds (s,), each part (s, m, ...)."""
        rate = np.outer(speeds, self.order)
        load = np.array([self.train.loads(float(speed)) for speed in speeds])
        found = self.of_run_up.moved(rate.ravel(), load.reshape(-1, 6))
        return Moved(*(part.reshape(*rate.shape, *part.shape[1:]) for part in found))

    def run_up(self) -> Iterator[Expected]:
        path = "isolation/support_force/run_up"
        speeds, values = self._axis(path, 1), np.asarray(self.record[path].values)
        chosen = _some(len(speeds), values.max(axis=0))
        moved = self._at(speeds[chosen])
        yield Expected(path, self._forces(moved).T, at=(slice(None), chosen))
        top = np.asarray(self.record[f"{path}_peak"].values)
        where = np.asarray(self.record[f"{path}_peak_speed"].values)
        yield Expected(f"{path}_peak", np.diag(self._forces(self._at(where))))
        mounts, order = self.rigid.mounts, self.order
        if self.deep:
            maximum = self.highest(lambda m: np.moveaxis(m.force, 1, -1), int(np.argmax(top)))
            yield Expected(f"{path}_peak", maximum, at=int(np.argmax(top)))
        if mounts.follows_load:
            root = "isolation/mounts/run_up"
            travel = np.asarray(self.record[f"{root}_travel"].values)
            where = np.asarray(self.record[f"{root}_travel_speed"].values)
            along = np.einsum("smni,ni->snm", self._at(where).deflection, mounts.axis)
            yield Expected(f"{root}_travel", np.diag(peak(along, order)))

            def stretched(m: Moved) -> np.ndarray:
                return np.einsum("smni,ni->snm", m.deflection, mounts.axis)[..., None, :]

            first = int(np.argmax(travel))
            if self.deep:
                yield Expected(f"{root}_travel", self.highest(stretched, first), at=first)
            yield from self._clearance(travel)
        if "isolation/run_up/maxima/force" in self.record:
            root = "isolation/run_up/maxima"
            mount = np.asarray(self.record[f"{root}/mount"].values).astype(int) - 1
            where = np.asarray(self.record[f"{root}/speed"].values)
            force = self._forces(self._at(where))[range(len(where)), mount]
            yield Expected(f"{root}/force", force)
        if "point" in self.case:
            yield from self._points_in_run_up()

    def _forces(self, moved: Moved) -> np.ndarray:
        """Largest force (speeds, mounts) over the cycle."""
        return longest(np.moveaxis(moved.force, 1, -1), self.order)

    def _clearance(self, travel: np.ndarray) -> Iterator[Expected]:
        mounts, given = self.rigid.mounts, self.case["isolation"]["run_up"]
        speeds = [given["from"], given["to"]]
        speeds += [one[0] for one in self.train.gas if speeds[0] < one[0] < speeds[1]]
        left = []
        for speed in speeds:
            moved = self.rigid.constant(self.train.mean_couple(speed) * self.train.axis)[0]
            still = mounts.deflection - np.einsum("ni,ni->n", moved, mounts.axis)
            left.append(mounts.to_stop(still, still))
        path = "isolation/mounts/run_up_clearance"
        value = np.min(left, axis=0) - travel
        yield Expected(path, value, size=float(np.abs(value).max()))

    def _points_in_run_up(self) -> Iterator[Expected]:
        root, order = "points/run_up", self.order

        def signals(speeds: np.ndarray) -> list[np.ndarray]:
            """Each (speeds, readings, m)."""
            found = self._signals(self._at(speeds).body, np.outer(speeds, order))
            return [np.moveaxis(one, 0, 1) for one in found]

        def rms(speeds: np.ndarray) -> list[np.ndarray]:
            rate = np.outer(speeds, order)
            low, high = self.band()
            inside = (rate >= low * (1 - 1e-12)) & (rate <= high * (1 + 1e-12))
            squares = [np.abs(one) ** 2 * inside[:, None] for one in signals(speeds)]
            return [np.sqrt(0.5 * one.sum(axis=-1)) for one in squares]

        for number, name in enumerate(QUANTITIES):
            for kind in ("peak", "rms"):
                path = f"{root}/{name}_{kind}"

                def at(speeds: np.ndarray, n: int = number, k: str = kind) -> np.ndarray:
                    return rms(speeds)[n] if k == "rms" else peak(signals(speeds)[n], order)

                speeds, values = self._axis(path, 1), np.asarray(self.record[path].values)
                chosen = _some(len(speeds), values.max(axis=0))
                size = float(values.max())
                yield Expected(path, at(speeds[chosen]).T, size=size, at=(slice(None), chosen))
                where = np.asarray(self.record[f"{path}_largest_speed"].values)
                yield Expected(f"{path}_largest", np.diag(at(where)))
        if "vibration_severity" in self.case and f"{root}/severity" in self.record:
            speeds = self._axis(f"{root}/severity", 1)
            values = np.asarray(self.record[f"{root}/severity"].values)
            chosen = _some(len(speeds), values.max(axis=0))
            value = _severity(rms(speeds[chosen])).T
            at_chosen = (slice(None), chosen)
            size = float(values.max())
            yield Expected(f"{root}/severity", value, size=size, at=at_chosen)
            where = np.asarray(self.record[f"{root}/severity_largest_speed"].values)
            yield Expected(f"{root}/severity_largest", np.diag(_severity(rms(where))))

        def moved(m: Moved) -> np.ndarray:
            place = np.moveaxis(m.body @ self.rows().T, -1, 1)
            return place[..., None, :]

        path = f"{root}/displacement_peak_largest"
        first = int(np.argmax(self.record[path].values))
        if self.deep:
            yield Expected(path, self.highest(moved, first), at=first)

    def highest(self, vectors: Callable[[Moved], np.ndarray], place: int) -> float:
        """Largest length over cycle and speeds of one of vectors (s, rows, components, m).

        Samples stand close about each speed at which an order meets a mode; what cannot be the
        largest, by the sum of its orders, is left; the highest are followed between neighbours.
        """
        given = self.case["isolation"]["run_up"]
        low, high = given["from"], given["to"]
        frequency, _, ratio = self.of_run_up.modes()
        away = np.array([0.0, 0.3, 0.7, 1.0, 1.6, 3.0, 6.0])
        near = 1.0 + np.clip(ratio, 1e-6, 0.2)[:, None] * np.concatenate([-away, away])
        met = (frequency[:, None] * near)[..., None] / self.order
        speeds = np.unique([*np.linspace(low, high, 160), *met[(met > low) & (met < high)]])
        found = np.concatenate(
            [vectors(self._at(part))[:, place] for part in np.array_split(speeds, 12)]
        )
        bound = np.sqrt(np.square(np.abs(found).sum(axis=-1)).sum(axis=-1))
        heights = np.zeros(len(speeds))
        for n in np.argsort(-bound, kind="stable"):
            if bound[n] < 0.97 * heights.max():
                break
            heights[n] = float(longest(found[n], self.order))

        def height(speed: float) -> float:
            return float(longest(vectors(self._at(np.array([speed])))[0, place], self.order))

        best = float(heights.max())
        for n in np.argsort(-heights)[:12]:
            ends = speeds[max(n - 1, 0)], speeds[min(n + 1, len(speeds) - 1)]
            if heights[n] < max(heights[max(n - 1, 0)], heights[min(n + 1, len(speeds) - 1)]):
                continue
            near_by = minimize_scalar(
                lambda s: -height(s), bounds=ends, method="bounded", options={"xatol": 1e-7 * high}
            )
            best = max(best, -float(near_by.fun))
        return best


_MOTIONS = [
    "translation", "rotation", "relative_translation", "relative_rotation", "velocity",
    "angular_velocity", "acceleration", "angular_acceleration",
]  # fmt: skip


def _some(count: int, values: Any) -> np.ndarray:
    """Places of a curve: its highest, its ends and two between."""
    return np.unique([0, count // 3, int(np.argmax(values)), (2 * count) // 3, count - 1])


def _severity(rms: list[np.ndarray]) -> np.ndarray:
    """Velocity of the grade that displacement, velocity and acceleration all keep."""
    factors = (TURN * 10.0, 1.0, 1.0 / (TURN * 250.0))
    return np.asarray(np.max([f * one for f, one in zip(factors, rms, strict=True)], axis=0))


def _through(on: OnMounts, rate: np.ndarray) -> np.ndarray:
    """Loads on the ground (m, 6, 6) by unit loads on the body."""
    columns = [on.moved(rate, np.tile(one, (len(rate), 1)) + 0j).ground for one in np.eye(6)]
    return np.stack(columns, axis=-1)


def _by_order(path: str, held: np.ndarray, ground: np.ndarray, nothing: float) -> Expected:
    """Share kept from the ground, of orders that are more than rounding."""
    first, second = (np.linalg.norm(one, axis=-1) for one in (held, ground))
    acts = first > max(1e-5 * first.max(), nothing)
    value = 1.0 - second[acts] / first[acts]
    return Expected(path, value, size=1e5 * float(np.abs(value).max(initial=1.0)), at=acts)


def _of_vector(
    path: str, held: np.ndarray, ground: np.ndarray, order: np.ndarray, whole: bool, nothing: float
) -> Iterator[Expected]:
    """What acts and what arrives (orders, 3), over the cycle, and the share that does not.

    Less than `nothing` is rounding, of which there is no share.
    """
    if not whole:
        yield Expected(f"{path}/held", held)
        yield Expected(f"{path}/ground", ground)
        resultant = _by_order(f"{path}/by_order", held, ground, nothing)
        yield resultant._replace(at=(resultant.at, -1))
    sizes = {
        "rms": [np.linalg.norm(one) / np.sqrt(2.0) for one in (held, ground)],
        "peak": [float(longest(one.T, order)) for one in (held, ground)],
    }
    for name, (first, second) in sizes.items():
        yield Expected(f"{path}/held_{name}", first, whole=whole)
        yield Expected(f"{path}/ground_{name}", second, whole=whole)
        if first <= nothing:
            continue
        share = 1.0 - second / first
        yield Expected(f"{path}/{name}", share, size=max(1.0, abs(share)), whole=whole)
        level = 20.0 * np.log10(first / second)
        yield Expected(f"{path}/{name}_level", level, size=10.0 + abs(level), whole=whole)


def compare(expected: Expected, record: Record) -> str:
    """What is off more than allowed; nothing where all is well."""
    if expected.path not in record:
        return f"{expected.path}: absent"
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
    allowed = max(TOLERANCE * size, float(found.error_estimate))
    if expected.whole:
        allowed = float(found.error_estimate) + TOLERANCE * size
    worst = float(np.max(off, initial=0.0))
    if worst <= allowed:
        return ""
    kind = ", all orders" if expected.whole else ""
    return (
        f"{expected.path}{kind}: off by {worst:.3g} of {size:.6g}, allowed {allowed:.3g} "
        f"(stated {float(found.error_estimate):.3g})"
    )
