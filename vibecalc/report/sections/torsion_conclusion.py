"""One sentence on a shaft line: what it keeps, where it has to be passed, what breaks a limit."""

from collections.abc import Iterator

import numpy as np

from vibecalc.report.lookup import having
from vibecalc.report.sections.torsion_case_checks import (
    hammering,
    hammering_at,
    separation_rule,
    separations,
)
from vibecalc.report.sections.torsion_limits import (
    BROKEN,
    PASSING,
    barred_ranges,
    exceeded_rows,
    verdicts,
)
from vibecalc.report.sections.torsion_scenes import own_entry
from vibecalc.report.sections.torsion_terms import (
    TORSION,
    asked,
    elastic_modes,
    entry,
    joined,
    order_text,
    range_words,
    turns,
    vector,
    worst_section,
)
from vibecalc.results.record import Record, Result


def conclusion(result: Result) -> str:
    """One sentence: what the line keeps, where it has to be passed, and what breaks a limit."""
    record = result.record
    clauses = list(_of_limits(record))
    if not clauses:
        clauses = list(_of_torque(result))
    clauses += _of_gears(record)
    clauses += _of_majors(result)
    if f"{TORSION}masked/from" in record and record[f"{TORSION}masked/from"].values.size:
        clauses.append("at some critical speeds nothing damps the line")
    silent = asked(result).get("misfire")
    if isinstance(silent, list | tuple) and silent:
        clauses.append(f"all this with misfire of cylinder {joined(map(str, silent))}")
    text = "; ".join(clauses)
    return f"{text[:1].upper()}{text[1:]}." if text else "The line was not driven."


def _of_limits(record: Record) -> Iterator[str]:
    found = verdicts(record)
    if not found:
        return
    broken = [str(i + 1) for i, word in enumerate(found) if word == BROKEN]
    if broken:
        plural = "limits" if len(broken) > 1 else "limit"
        yield f"the stress breaks {plural} {joined(broken)}" + _where_broken(record)
    else:
        what = "limits" if len(found) > 1 else "limit"
        yield f"at the operating speed the stress keeps the {what}"
    barred = barred_ranges(record)
    if barred:
        yield f"{joined(barred)} {'are' if len(barred) > 1 else 'is'} barred for lasting operation"
    elif not broken and PASSING not in found:
        yield "no range of speeds is barred"


def _where_broken(record: Record) -> str:
    """At the operating speed, or above what is allowed for passing through, or both."""
    here, passing = (
        vector(record, f"limit/{name}_use", "limit") for name in ("operating", "transient")
    )
    words = []
    if here is not None and np.any(here > 1.0):
        words.append("at the operating speed")
    if passing is not None and np.any(passing > 1.0):
        words.append("even for passing through")
    if any(not one.permitted for one in exceeded_rows(record)):
        words.append("where the rule lets no range of speeds be barred")
    return f" {joined(words)}"


def _of_torque(result: Result) -> Iterator[str]:
    """Without a limit: the most loaded section."""
    record = result.record
    name = worst_section(record)
    if name is None:
        return
    for path, words in (("largest/torque_half_range", f"at {{}} within {range_words(result)}"),
                        ("torque_half_range", "at the operating speed")):  # fmt: skip
        quantity = having(record, TORSION + path, "section")
        if not np.isfinite(own_entry(record, path, name) or np.inf):
            continue
        speed = own_entry(record, "largest/speed", name)
        at = words.format("" if speed is None else f"{turns(speed)} rpm")
        value = entry(quantity, name)
        yield f"section {name!r} carries most, {value} N*m half range {at}"
        yield "the case has no limit of the stress"
        return


def _of_majors(result: Result) -> Iterator[str]:
    """The mode that a major order meets nearly at the operating speed, if one does."""
    rule = separation_rule(result)
    for row in separations(result, elastic_modes(result)):
        if rule is not None and row.kind == "major" and row.close:
            yield (
                f"mode {row.mode + 1} lies {100.0 * row.margin:.1f} % from major order "
                f"{order_text(row.order)} of the operating speed, less than {rule.rule.name} asks"
            )


def _of_gears(record: Record) -> Iterator[str]:
    """Gears whose torque reverses: at the operating speed, and in which ranges."""
    for found, at in ((hammering(record), "at the operating speed"), (hammering_at(record), "")):
        for name, where in found or ():
            if where:
                yield f"gear {name!r} hammers {at or f'from {where}'}"
