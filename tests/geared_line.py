"""The geared engine of cases/engine_geared.toml on openTorsion, from the text of the case alone.

Units are read here, the torque of a cylinder is a discrete Fourier transform of pressure and piston
speed, gears and response are openTorsion's. Of the package only the computed pressure card is used.

openTorsion numbers its nodes; rigid gears strike nodes out (`Assembly.T` leads back), the stiffness
of elastic teeth is that of a spring on the parent's axis, and `C_func` takes the loss factors.
"""

import tomllib
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import opentorsion as ot

from vibecalc.core.case.load import load_case
from vibecalc.excitation.gas_tables import pressure_at
from vibecalc.excitation.model import gas_cards

CASE = Path(__file__).resolve().parents[1] / "cases" / "engine_geared.toml"
SAMPLES = 1 << 15
UNITS = {
    "kg*m^2": 1.0, "kg": 1.0, "N*m*s/rad": 1.0, "kN*m*s/rad": 1e3, "MN*m/rad": 1e6, "GN/m": 1e9,
    "kN*m": 1e3, "mm": 1e-3, "rpm": np.pi / 30.0,
}  # fmt: skip


def number(text: Any) -> float:
    """A value in SI units; what is not said is zero."""
    value, _, unit = str(text or "0 kg").partition(" ")
    return float(value) * UNITS[unit]


class Geared(NamedTuple):
    """Own angles (stations, orders) and torques (sections, orders) at one speed, in rad and N m."""

    angle: np.ndarray
    torque: np.ndarray


def rows(name: str) -> list[dict[str, Any]]:
    """The lines of a file of stations or shafts, as a case would write them."""
    text = (CASE.parent / name).read_text(encoding="utf-8")
    head, *lines = [line.split(",") for line in text.splitlines() if not line.startswith("#")]
    keys = [one.strip().rstrip("]").split(" [") for one in head]
    found = []
    for line in lines:
        row: dict[str, Any] = {}
        for (key, *unit), cell in zip(keys, line, strict=True):
            if cell.strip():
                row[key] = " ".join([cell.strip(), *unit])
        row["loss_factor"] = float(row.get("loss_factor", 0.0))
        row["between"] = [end.strip() for end in row.get("between", "").split(";")]
        found.append(row)
    return found


@cache
def parts() -> dict[str, Any]:
    machine = tomllib.loads(CASE.read_text(encoding="utf-8"))["machine"]
    for key in ("stations", "shafts"):
        machine["shaft_line"][key] = rows(machine["shaft_line"][key])
    return machine


def names() -> list[str]:
    return [station["name"] for station in parts()["shaft_line"]["stations"]]


def sections() -> list[tuple[str, int, int, complex, float]]:
    """Name, ends, complex stiffness and damping of the shafts, on their own axes."""
    at = {name: place for place, name in enumerate(names())}
    return [
        (
            one["name"],
            at[one["between"][0]],
            at[one["between"][1]],
            number(one["stiffness"]) * (1.0 + 1j * one.get("loss_factor", 0.0)),
            number(one.get("damping")),
        )
        for one in parts()["shaft_line"]["shafts"]
    ]


@cache
def assembly() -> ot.Assembly:
    line, at = parts()["shaft_line"], {name: place for place, name in enumerate(names())}
    discs = [
        ot.Disk(at[one["name"]], number(one["inertia"]), c=number(one.get("absolute_damping")))
        for one in line["stations"]
    ]
    shafts = [ot.Shaft(a, b, k=k.real, c=c) for _, a, b, k, c in sections()]
    rigid, elastic = line["gears"]
    pinion = ot.Gear(at["pinion"], 0.0, rigid["teeth"][0])
    wheel = ot.Gear(at["wheel"], 0.0, rigid["teeth"][1], parent=pinion)
    first = ot.ElasticGear(at["pinion"], 0.0, elastic["teeth"][0], k=0.0, c=0.0)
    second = ot.ElasticGear(
        at["take-off"], 0.0, elastic["teeth"][1], k=mesh_stiffness(), c=0.0, parent=first
    )
    return ot.Assembly(
        shafts, disk_elements=discs, gear_elements=[pinion, wheel],
        elastic_gear_elements=[first, second],
    )  # fmt: skip


def mesh_stiffness() -> float:
    """Of the elastic teeth, as a spring on the pinion's axis, N m/rad."""
    gear = parts()["shaft_line"]["gears"][1]
    return number(gear["mesh_stiffness"]) * number(gear["pitch_radius"]) ** 2


def frequencies() -> np.ndarray:
    """Natural frequencies in rad/s, the rigid one as rounding leaves it."""
    square, _ = assembly().undamped_modal_analysis()
    return np.sqrt(np.sort(np.abs(square)))


@cache
def cylinder() -> tuple[np.ndarray, np.ndarray, float]:
    """Harmonics of orders 1/2 to 12: gas in N m, inertia over speed squared; mean of the gas."""
    train = parts()["crank_train"]
    radius, length = number(train["crank_radius"]), number(train["rod_length"])
    angle = 4.0 * np.pi * np.arange(SAMPLES) / SAMPLES
    root = np.sqrt(length**2 - (radius * np.sin(angle)) ** 2)
    lever = radius * np.sin(angle) * (1.0 + radius * np.cos(angle) / root)
    wave = np.fft.rfft(lever)
    slope = np.fft.irfft(0.5j * np.arange(len(wave)) * wave, SAMPLES)
    (card,) = gas_cards(load_case(CASE).case.machine)[1]
    gas = pressure_at(card, angle) * np.pi / 4.0 * number(train["bore"]) ** 2 * lever
    inertia = -number(train["reciprocating_mass"]) * lever * slope

    def harmonics(values: np.ndarray) -> np.ndarray:
        return np.fft.rfft(values)[1:25] * 2.0 / SAMPLES

    return harmonics(gas), harmonics(inertia), float(gas.mean())


def loads(speed: float) -> np.ndarray:
    """Torques (stations, orders) of the cylinders at a speed in rad/s, N m."""
    order = 0.5 * np.arange(1, 25)
    gas, inertia, _ = cylinder()
    fires = {
        name: 2.0 * np.pi * place / 3.0
        for place, name in enumerate(parts()["crank_train"]["firing_order"])
    }
    load = np.zeros((len(names()), len(order)), dtype=complex)
    for place, station in enumerate(parts()["shaft_line"]["stations"]):
        if "cylinder" in station:
            turned = np.exp(-1j * order * fires[station["cylinder"]])
            load[place] = (gas + speed**2 * inertia) * turned
    return load


def response(speed: float) -> Geared:
    """All 24 half orders at one speed in rad/s."""
    order, load = 0.5 * np.arange(1, 25), loads(speed)
    line = assembly()
    transform = line.T(line.E())
    loss = np.zeros((len(names()), len(names())))
    for _, a, b, k, _ in sections():
        loss[np.ix_([a, b], [a, b])] += k.imag * np.array([[1.0, -1.0], [-1.0, 1.0]])
    loss = transform.T @ loss @ transform
    found, _ = line.ss_response(
        transform.T @ load, order * speed, C_func=lambda w: line.C + loss / w
    )
    angle = transform @ found
    torque = [(k + 1j * order * speed * c) * (angle[a] - angle[b]) for _, a, b, k, c in sections()]
    teeth, at = parts()["shaft_line"]["gears"][1]["teeth"], names().index
    give = angle[at("pinion")] + teeth[1] / teeth[0] * angle[at("take-off")]
    return Geared(angle, np.array([*torque, mesh_stiffness() * give]))


def half_range(amplitude: np.ndarray) -> np.ndarray:
    """(highest - lowest) / 2 over the cycle of signals (..., orders), by sampling."""
    spectrum = np.zeros((*amplitude.shape[:-1], (1 << 17) + 1), dtype=complex)
    spectrum[..., 1 : 1 + amplitude.shape[-1]] = amplitude / 2.0
    signal = np.fft.irfft(spectrum, axis=-1) * (1 << 18)
    return np.asarray((signal.max(axis=-1) - signal.min(axis=-1)) / 2.0)
