"""Claim: docs/validation_roll_measured.md shows what the case gives and what the source prints."""

import re
from functools import cache

import numpy as np
from shipped_cases import CASES, ROOT, result_of
from test_docs import rows, shows

from vibecalc.core.case.load import load_case
from vibecalc.core.results.record import Record
from vibecalc.core.results.select import scalar
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked
from vibecalc.units import convert

PAGE = (ROOT / "docs" / "validation_roll_measured.md").read_text(encoding="utf-8")
BLOCKS = PAGE.split("\n\n")
LEVELS = ("standard", "no_roll", "only_roll", "only_pitch")
IN_PLACE = ('measurement.readings[2].at="5"', 'measurement.readings[4].between=["1", "5"]')
ALL_EIGHT = tuple(f'measurement.readings[{n}].use="solve"' for n in (5, 6, 7))
VARIANTS = {
    "5 at the corner": (),
    "5 in its place": IN_PLACE,
    "all eight readings": (*IN_PLACE, *ALL_EIGHT),
}


RESIDUAL, CHOSEN = "measurement/reading/residual", "measurement/candidate/chosen"


@cache
def fit_of(variant: str) -> Record:
    """What the page tells of the readings in another place, or of more of them."""
    if not VARIANTS[variant]:
        return result_of("roll_measured").record
    (loaded,) = load_checked([CASES["roll_measured"]], VARIANTS[variant])
    return run_case(loaded.case, wanted=frozenset({RESIDUAL, CHOSEN}))


def table(first: str) -> list[list[str]]:
    """Rows below the head whose cells begin with these words."""
    for block in BLOCKS:
        found = rows(block)
        if found and " | ".join(found[0]).startswith(first):
            return found[2:]
    raise LookupError(first)


def computed(path: str, where: dict[str, object], unit: str, *settings: str) -> float:
    quantity = result_of("roll_measured", *settings).record[path]
    return convert(float(scalar(quantity, where)), quantity.unit, unit)  # type: ignore[arg-type]


@cache
def printed() -> dict[tuple[str, str], tuple[str, str]]:
    """(quantity, picks) -> digits and whether the case knows a difference or a reading."""
    found = {}
    for row in load_case(CASES["roll_measured"]).case.reference:
        picks = ", ".join(str(row.where[key]) for key in sorted(row.where))
        kind = "read" if row.kind == "measured" else "reproduced"
        kind = "compatible" if row.known_difference else kind
        found[row.quantity + ("!" if kind == "read" else ""), picks] = (
            str(row.value).split()[0],
            kind,
        )
    return found


def test_readings_of_table_1() -> None:
    cells = table("reading | harmonic")
    assert len(cells) == 18
    for _, order, shown, name, value, verdict in cells:
        name = name.strip("`")
        assert name.startswith(f"{order}: ")
        known = printed().get(("measurement/reading/computed!", name))
        assert known == ((shown, "read") if verdict == "read; it chooses" else None)
        assert (verdict == "read; determines the motion") == (known is None)
        where: dict[str, object] = {"reading": name}
        assert shows(shown, computed("measurement/reading/read", where, "dB"))
        assert shows(value, computed("measurement/reading/computed", where, "dB"))
        residual = computed("measurement/reading/residual", where, "dB")
        assert (abs(residual) < 1e-9) == (known is None)


def test_no_reference_compares_a_reading_with_itself() -> None:
    """What was read and determines the motion comes out as read whatever the model is."""
    record = result_of("roll_measured").record
    every = load_case(CASES["roll_measured"]).case.reference
    measured = [row for row in every if row.kind == "measured"]
    assert len(measured) == 15
    for row in measured:
        value = float(scalar(record[row.quantity], dict(row.where)).real)
        assert abs(value - float(str(row.value).split()[0])) > 1e-6


def test_what_table_1_derives() -> None:
    cells = table("symbol | harmonic")
    assert len(cells) == 30
    for _, order, shown, quantity, value, verdict in cells:
        digits, unit = shown.split()
        path, *picked = re.findall(r"`([^`]+)`", quantity)
        where: dict[str, object] = {"order": int(order)}
        if picked:
            where = {"candidate": picked[0], "position": "corner 6"}
        picks = ", ".join(str(where[key]) for key in sorted(where))
        assert printed()[path, picks] == (digits, verdict)
        assert shows(value.split()[0], computed(path, where, unit))


def test_tables_2_to_5() -> None:
    cells = table("position | harmonic |  | read")
    assert len(cells) == 36
    seen = 0
    for above, below in zip(cells[::2], cells[1::2], strict=True):
        position, order, _, read, *shown = above
        where = {"position": position, "order": int(order)}
        known = printed().get(("measurement/level/standard!", f"{order}, {position}"))
        if position in "12":
            where_read: dict[str, object] = {"reading": f"{order}: {position}"}
            assert known is None
            assert shows(read, computed("measurement/reading/read", where_read, "dB"))
        else:
            assert known is not None and known[0] == read
        for part, digits, value in zip(LEVELS, shown, below[4:], strict=True):
            path = f"measurement/level/{part}"
            verdict = "compatible" if digits.startswith("(") else "reproduced"
            assert printed()[path, f"{order}, {position}"] == (digits.strip("()"), verdict)
            assert shows(value, computed(path, where, "dB"))
            seen += 1
    assert seen == 72


def test_residuals_of_the_variants() -> None:
    cells = table(" | harmonic | 3 | 4 | 6")
    assert len(cells) == 9
    name = ""
    for row in cells:
        name = row[0] or name
        residual = fit_of(name)[RESIDUAL]
        for position, shown in zip("346", row[2:5], strict=True):
            value = scalar(residual, {"reading": f"{row[1]}: {position}"})
            assert shows(shown.lstrip("+"), float(value.real))
        if row[5]:
            every = [
                scalar(residual, {"reading": f"{order}: {position}"})
                for order in (1, 2, 3)
                for position in "346"
            ]
            assert shows(row[5], float(np.sqrt(np.mean(np.square(every)))))


def test_uncertainties_and_quiet_places() -> None:
    for order, deviation, bound in table("harmonic | standard uncertainty"):
        where: dict[str, object] = {"position": "6", "order": int(order)}
        assert shows(deviation, computed("measurement/uncertainty/level", where, "dB"))
        assert shows(bound, computed("measurement/uncertainty/level_bound", where, "dB"))
    for order, *cells in table("harmonic | x in m"):
        every = order == "all"
        picks: dict[str, object] = {} if every else {"order": int(order)}
        for name, unit, shown in zip(
            ("x", "y", "amplitude"), ("m", "m", "m/s^2"), cells, strict=True
        ):
            path = f"measurement/quiet/{'all_orders_' if every else ''}{name}"
            assert shows(shown, computed(path, picks, unit))
    total = result_of("roll_measured").record["measurement/level/all_orders"]
    six = np.asarray(total.values)[:6]
    assert str(total.axes[0].values[int(np.argmin(six))]) == "5"


def test_every_test_that_the_page_names_is_there() -> None:
    text = (ROOT / "tests/published/test_published_plate.py").read_text(encoding="utf-8")
    for name in re.findall(r"`(test_\w+)`", PAGE):
        assert f"def {name}(" in text
