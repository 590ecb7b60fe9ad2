"""Rules between the tables of an absorber: each number in one way, all in one kind of motion."""

import functools
from collections.abc import Iterator

from vibecalc.absorber.asked_tables import AMPLITUDES, excitation_and_response
from vibecalc.absorber.tables import MOTIONS, WAYS, WIRE, Secondary
from vibecalc.core.case.raw import Data, table_at
from vibecalc.core.case.rules import Row, Rule, needs, one_of, refuse, row_at, unique
from vibecalc.errors import KeyPath, Problem, dotted

# ----------------------------------------------------------------------------
# Primary and secondaries: in torsion, in translation, or in ratios alone.
# ----------------------------------------------------------------------------

PRIMARY: KeyPath = ("machine", "primary")
MASSES, STIFFNESSES, DAMPERS = WAYS.values()
#: keys of a friction damper by the motion of the primary
_RUBBED = {
    "torsion": ("inertia", "friction_torque", "torque"),
    "translation": ("mass", "friction_force", "force"),
}


def _from_rod(machine: Data) -> bool:
    return {"length", "shear_modulus"} <= set(table_at(machine, "rod"))


def _motion(machine: Data) -> str:
    """What the primary's units say: torsion, translation or "" for ratios."""
    primary = table_at(machine, "primary")
    if "modes" in primary or ("natural_frequency" in primary and "inertia" not in primary):
        return "translation"
    for motion, keys in MOTIONS.items():
        if not primary.keys().isdisjoint(keys):
            return motion
    return "torsion" if _from_rod(machine) else ""


def _mixes(table: Data) -> bool:
    return not any(table.keys().isdisjoint(keys) for keys in MOTIONS.values())


def _primary(row: Row) -> Iterator[Problem]:
    """A primary with units has both mass and spring, each said once."""
    primary, motion = row.below("primary"), _motion(row.data)
    if primary is None or not primary.data or not motion or _mixes(primary.data):
        return
    if "modes" in primary:
        return
    heavy, stiff, _ = MOTIONS[motion]
    rod = _from_rod(row.data)
    half = {"length", "shear_modulus"} & table_at(row.data, "rod").keys()  # reported there
    for twice in primary.said(stiff, "natural_frequency") if rod else ():
        yield primary.problem(
            twice,
            f"the primary's stiffness is given twice: [machine.rod] and {twice} give it",
            allowed=f"{twice}, or a rod with length and shear_modulus, not both",
            also=("machine", "rod"),
        )
    for key in (heavy, stiff):
        if primary.lacks(key, "natural_frequency" if key == stiff else key) and not (
            key == stiff and half
        ):
            instead = ", or [machine.rod] with length and shear_modulus" if key == stiff else ""
            yield primary.problem(
                "",
                f"the primary has units, and no {key}",
                found=", ".join(key for key in primary.data if key != "damping_ratio") or "a rod",
                allowed=f"{heavy} and {stiff} or natural_frequency{instead}",
                hint="give damping_ratio alone to work in ratios, without units" if not rod else "",
            )


def _secondaries(row: Row) -> Iterator[Problem]:
    """One absorber, or several, each with mass, spring and damper of the primary's motion."""
    one = row.below("secondary")
    if row.below("primary") is None:
        return
    springs = table_at(row.data, "springs")
    built = {
        part
        for part, there in (
            ("ring", "ring" in row),
            ("springs", not springs.keys().isdisjoint({"rate", *WIRE})),
            ("oil", "oil" in row and "gap" in row),
        )
        if there
    }
    if one is not None and one.data:
        yield from _secondary(row, one, built)
    elif "ring" in row and "secondaries" not in row:
        yield from _secondary(row, Row({}, (*row.path, "ring"), row.case, Secondary), built)
    for several in row.each("secondaries"):
        yield from _secondary(row, several, set())


def _secondary(machine: Row, one: Row, built: set[str]) -> Iterator[Problem]:
    name = one.header() if len(one.path) == 2 else dotted(one.path[1:])
    motion, tuned = _motion(machine.data), isinstance(machine.case.get("tuning"), dict)
    for other, keys in MOTIONS.items():
        foreign = one.said(*keys)
        if foreign and other != motion and not _mixes(one.data):
            yield one.problem(
                foreign[0],
                f"{foreign[0]} belongs to {other}, and the primary is "
                + (f"in {motion}" if motion else "given by ratios alone"),
                allowed=", ".join(
                    (*MOTIONS.get(motion, ()), MASSES[0], STIFFNESSES[0], DAMPERS[0])
                ),
                also=PRIMARY,
            )
    for what, alternatives, part in (
        ("mass", MASSES, "ring"),
        ("spring", STIFFNESSES, "springs"),
        ("damper", DAMPERS, "oil"),
    ):
        given, hardware = one.said(*alternatives), f"[machine.{part}]"
        sought = tuned and what != "mass"
        if sought and given:
            yield one.problem(
                given[0],
                f"{given[0]} is given, but [tuning] finds the {what}",
                allowed=f"no {', '.join(alternatives)} next to [tuning], or no [tuning]",
                hint=f"what is built stands in {hardware}, next to the tuning; tuning.kind and "
                "tuning.bounds hold a value",
                also=("tuning",),
            )
        elif given and part in built:
            yield one.problem(
                given[0],
                f"the {what} is given twice: {hardware} gives it",
                allowed=f"{given[0]}, or {hardware}, not both",
                also=("machine", part),
            )
        elif not sought and part not in built and one.lacks(*alternatives):
            least, tuning = (" (0 for none)", ", or [tuning]") if what != "mass" else ("", "")
            yield one.problem(
                "",
                f"{name} has no {what}" + ", and no [tuning] finds one" * (what != "mass"),
                allowed=f"one of {', '.join(alternatives)}{least}, {hardware}{tuning}",
            )


# ----------------------------------------------------------------------------
# What an absorber is built of: what goes with what.
# ----------------------------------------------------------------------------

#: part -> the part that it goes with
_NEEDS = {
    "flywheel": "rod",
    "oil": "gap",
    "stock_oils": "gap",
    "oil_catalogue": "gap",
    "stock_springs": "springs",
    "stock_dampers": "secondary",
    "spring_catalogue": "springs",
    "rod": "primary",
    "springs": "secondary",
    "gap": "secondary",
    "ring": "primary",
}
_NO_PARTS = "several absorbers have no parts as built"


def _of_one(part: str) -> bool:
    """Whether a part is, at the end, one of a single absorber."""
    while part in _NEEDS:
        part = _NEEDS[part]
    return part == "secondary"


def _parts(row: Row) -> Iterator[Problem]:
    for part, other in _NEEDS.items():
        if part in row and row.lacks(other) and not (other == "secondary" and "ring" in row):
            yield row.problem(
                part,
                f"[machine.{part}] needs [machine.{other}]",
                hint=_NO_PARTS if "secondaries" in row and _of_one(part) else "",
            )
    rod = row.below("rod")
    if rod is not None and "flywheel" in row:
        for key in ("mass density", "total_length", "span", "elastic_modulus"):
            yield from needs("", key, "for the bending that [machine.flywheel] asks")(rod)
    elif rod is not None and rod.lacks("length", "shear_modulus"):
        yield rod.problem(
            "",
            "the rod has neither torsion nor bending data",
            allowed="length and shear_modulus, or [machine.flywheel] on its end",
        )


def _springs(row: Row) -> Iterator[Problem]:
    springs, motion = row.below("springs"), _motion(row.data)
    if springs is None:
        return
    if "tuning" not in row.case and springs.lacks("rate", *WIRE):
        yield springs.problem(
            "",
            "the springs have no rate, and no [tuning] finds one",
            allowed=f"rate, or {', '.join(WIRE)}, or [tuning]",
        )
    if motion == "torsion" and springs.lacks("radius"):
        yield springs.problem(
            "",
            "springs of a mass in torsion need the radius of their attachment",
            allowed="radius = '140 mm', for example",
        )
    elif motion == "translation" and "radius" in springs:
        yield springs.problem(
            "radius",
            "springs of a mass that moves in a line have no radius",
            allowed="count, angle and rate",
            also=PRIMARY,
        )


def _units(row: Row) -> Iterator[Problem]:
    """Parts have units, so that the primary needs them; what turns needs torsion."""
    turning = [part for part in ("rod", "ring", "gap") if part in row]
    moving = ["stock_dampers"] if "stock_dampers" in row else []
    placed = [part for part in (*turning, *moving, "springs") if part in row and part != "rod"]
    motion, primary = _motion(row.data), row.below("primary")
    if primary is None or not primary.data:
        return
    part, words, allowed = "", "", "a primary with inertia and stiffness"
    if not motion and placed:
        part, words = placed[0], "has units, and the primary is given by ratios alone"
    elif motion == "torsion" and moving:
        part, words = moving[0], "are for translation, and the primary is in torsion"
        allowed = "[machine.gap] with oils in stock, or a primary with mass and linear_stiffness"
    elif motion == "translation" and turning:
        part, words = turning[0], "is for torsion, and the primary is in translation"
    if part:
        yield row.problem(part, f"[machine.{part}] {words}", allowed=allowed, also=PRIMARY)


# ----------------------------------------------------------------------------
# Which tables go together, and what is asked of them.
# ----------------------------------------------------------------------------


def _nearby_a_pendulum(place: str) -> Rule:
    *above, key = place.split(".")
    return refuse(
        (*above, key),
        f"[{place}] needs [machine.primary] and its absorber",
        lambda t: key in table_at(t.case, *above) and "pendulum" in t and "primary" not in t,
        "[machine.primary] with [machine.secondary]",
        hint="the tuning of a pendulum is its order, which [machine.pendulum] has",
    )


def _readable(row: Row) -> bool:
    """Whether the parts are tables; otherwise the schema says so, and the rest is guessed."""
    return all(isinstance(row.data.get(part, {}), dict) for part in ("primary", "secondary"))


def _amplitude(row: Row) -> Iterator[Problem]:
    """An amplitude is of the motion of the primary, and what only it shows needs one."""
    asked, motion = row_at(row.case, "response", "absorber"), _motion(row.data)
    primary = row.below("primary")
    if asked is None or primary is None or not primary.data:
        return
    said = asked.said(*AMPLITUDES)
    other = "torsion" if motion == "translation" else "translation"
    known = [key for key in AMPLITUDES if (key == "torque") == (motion == "torsion")]
    for key in said:
        if not motion or key not in known:
            yield asked.problem(
                key,
                f"{key} needs a primary with units, and this one is given by ratios alone"
                if not motion
                else f"{key} belongs to {other}, and the primary is in {motion}",
                allowed=", ".join(known) if motion else "a primary with mass and natural_frequency",
                also=PRIMARY,
            )
    modal, tuning = "modes" in primary, table_at(row.case, "tuning")
    by, what = excitation_and_response(asked.data, tuning)
    of_ground = by == "base_acceleration" or what == "deflection"
    if (modal or of_ground) and not said:
        yield asked.problem(
            "",
            "the motion of several modes, or against the ground, is read in m and N, without an "
            "amplitude it is not known",
            allowed=f"one of {', '.join(known)}" if motion else "base_acceleration",
            hint="" if motion else "and a primary with mass and natural_frequency",
        )
    where = "of several modes" if modal else "against a ground that moves"
    ratios = ("vary", "limits", "response", *("frequency_ratios",) * modal)
    for key in asked.said(*ratios) if modal or of_ground else ():
        yield asked.problem(
            key,
            f"{where} all motions are read in units, without {key}",
            allowed="an amplitude and frequencies",
            hint="excitation = 'base' has it in ratios" if key != "response" and not modal else "",
            also=(*PRIMARY, "modes") if modal else (),
        )


def _gap_in_band(row: Row) -> Iterator[Problem]:
    tuning = table_at(row.case, "tuning")
    ground = tuning.get("excitation") == "base_acceleration"
    if "gap" in row and (ground or not {"band", "band_ratios"}.isdisjoint(tuning)):
        yield row.problem(
            "gap",
            "oils in a gap are chosen over all frequencies, and the tuning counts in a band or on "
            "a ground only",
            allowed="springs and dampers in stock, or [tuning] without band and base_acceleration",
            also=("tuning",),
        )


def _modes(row: Row) -> Iterator[Problem]:
    """Several modes have no rod; a moving ground drives them by their participation."""
    primary = row.below("primary")
    if primary is None or "modes" not in primary:
        return
    if "rod" in row:
        yield row.problem(
            "rod",
            "[machine.rod] is for a primary of a single mode",
            allowed="modal masses alone",
            also=(*PRIMARY, "modes"),
        )
    asked, tuning = table_at(row.case, "response", "absorber"), table_at(row.case, "tuning")
    ground = str(tuning.get("excitation", "")).startswith("base") or not {
        "base_displacement", "base_acceleration"}.isdisjoint(asked)  # fmt: skip
    for mode in primary.each("modes") if ground else ():
        if mode.lacks("participation"):
            yield mode.problem(
                "",
                "base excitation needs the participation of each mode",
                allowed="participation, the sum of mass times shape over modal_mass",
            )


def _friction_damper(row: Row) -> Iterator[Problem]:
    """Dry friction acts on a single mode, in its motion; what is linear is not asked of it."""
    damper, primary, motion = row.below("friction_damper"), row.below("primary"), _motion(row.data)
    if damper is None:
        return
    if primary is None or "modes" in primary:
        yield damper.problem(
            "",
            "a friction damper is on a primary of a single mode",
            allowed="[machine.primary] with a damping_ratio, or with a mass and its spring",
            also=(*PRIMARY, "modes") if primary is not None else (),
        )
        return
    for other, keys in _RUBBED.items():
        for key in damper.said(*keys) if other != motion else ():
            yield damper.problem(
                key,
                f"{key} belongs to {other}, and the primary is "
                + (f"in {motion}" if motion else "given by ratios alone"),
                allowed=", ".join((*_RUBBED.get(motion, ()), "mass_ratio", "friction_ratio")),
                also=PRIMARY,
            )
    for path in (("tuning",), ("response", "absorber")):
        if path[-1] in table_at(row.case, *path[:-1]):
            yield damper.problem(
                path,
                f"[{dotted(path)}] is for an absorber with a spring or a viscous damper",
                allowed="[machine.friction_damper] alone, whose best friction is found with it",
                also=damper.path,
            )


def _without_hertz(place: tuple[str, ...], key: str, row: Row) -> bool:
    """Whether a table asks for frequencies of a primary of ratios alone."""
    asked = key in table_at(row.case, *place)
    return asked and row.below("primary") is not None and not _motion(row.data)


OF_ABSORBER = (
    unique("secondaries", "absorbers"),
    one_of("primary", "pendulum"),
    one_of(
        "secondary",
        "secondaries",
        "friction_damper",
        when=lambda t: "primary" in t and "ring" not in t,
    ),
    *(_nearby_a_pendulum(place) for place in ("tuning", "response.absorber", "machine.secondary")),
    refuse(
        "secondary",
        "[machine.secondary] is empty",
        lambda t: t["secondary"] == {},
        "a mass_ratio, for example; with [machine.ring] no [machine.secondary] is needed",
    ),
    refuse(
        "ring",
        "[machine.ring] is the mass of one absorber, and there are several",
        lambda t: "ring" in t and "secondaries" in t,
        "an inertia or a mass_ratio for each",
        also="secondaries",
    ),
    *(
        refuse(
            (*place, key),
            "the primary is given by ratios alone and has no frequency in Hz",
            functools.partial(_without_hertz, place, key),
            f"{instead}, or a primary with mass and natural_frequency",
            also=PRIMARY,
        )
        for place, key, instead in (
            (("response", "absorber"), "frequencies", "frequency_ratios"),
            (("tuning",), "band", "band_ratios"),
        )
    ),
    *(
        lambda t, rule=rule: rule(t) if _readable(t) else ()
        for rule in (
            _primary,
            _secondaries,
            _parts,
            _springs,
            _units,
            _amplitude,
            _modes,
            _gap_in_band,
            _friction_damper,
        )
    ),
)
