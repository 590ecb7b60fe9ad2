"""Claim: the generated pages of the site have an entry for everything they are about."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import api_reference
import case_reference
import command_reference
import gallery
import generate
import pytest
import result_reference
from fuzzing import command
from shipped_cases import CASES, ROOT

import vibecalc
from vibecalc.core.case.walk import keys_of, shape_of
from vibecalc.core.report.plots import every_picture
from vibecalc.core.results.catalogue import AXES, CATALOGUE
from vibecalc.errors import EXIT_CODES
from vibecalc.units import parse_quantity


def test_every_key_of_the_schema_has_an_entry_with_an_example() -> None:
    known, shown, pages = case_reference.places(), case_reference.examples(), case_reference.pages()
    assert set(pages) == {place.page for place in known.values()} - {"case"} | {"index"}
    for model, place in known.items():
        page = pages["index" if place.page == "case" else place.page]
        _, found, section = page.partition(f"({place.anchor})=\n")
        section = section.split("\n(case-")[0] if found else page
        rows = dict(re.findall(r"^\| `(\w+)` \| (.*) \|$", section, re.M))
        assert list(rows) == list(keys_of(model)), place.headers
        for key, field in keys_of(model).items():
            takes, default, about = re.split(r"(?<!\\) \| ", rows[key].replace("|  |", "| - |"))
            assert takes, (place.headers, key)
            assert case_reference.cell(field.description or "") in about
            assert (default == "*needed*") == field.is_required()
            if case_reference.table_of(shape_of(field))[0] is None:
                assert shown[model, key].startswith(f"{key} = ")
                assert case_reference.code(shown[model, key]) in about


def test_examples_are_toml_and_may_stand_at_their_keys() -> None:
    for (model, key), line in case_reference.examples().items():
        (value,) = tomllib.loads(line).values()
        shape = shape_of(keys_of(model)[key])
        if shape.kind == "number" and isinstance(value, int | float | str):
            number = parse_quantity(value, shape.unit or "") if isinstance(value, str) else value
            for sign, bound in shape.bounds:
                held = {"gt": number > bound, "ge": number >= bound,
                        "lt": number < bound, "le": number <= bound}  # fmt: skip
                assert held[sign], (model, line)
        if shape.kind == "choice":
            assert value in shape.choices, (model, line)


def test_every_result_and_axis_has_an_entry() -> None:
    pages = result_reference.pages()
    text = "\n".join(pages.values())
    rows = re.findall(r"^\| `([\w/]+)`<br>(.+?) \| (.*?) \| (.*?) \| (.*?) \|$", text, re.M)
    found = {path: (axes, unit, kind) for path, _, axes, unit, kind in rows}
    for path, one in CATALOGUE.items():
        axes, unit, kind = found[path]
        assert tuple(re.findall(r"`(\w+)`", axes)) == one.axes
        assert (unit.strip("`"), kind) == (one.unit, one.amplitude or "")
    assert len(rows) == len(CATALOGUE)
    assert set(re.findall(r"^\| `(\w+)` \|", pages["index"], re.M)) == set(AXES)


def test_every_command_option_and_exit_code_has_an_entry() -> None:
    pages = command_reference.pages()
    sections = re.split(r"^## `vibecalc (\w+)`$", pages["command_line"], flags=re.M)[1:]
    named = dict(zip(sections[::2], sections[1::2], strict=True))
    assert set(named) == set(command_reference.commands())
    assert set(named) <= set(re.findall(r"│ (\w+)", command("--help").out))
    for name, one in command_reference.commands().items():
        for parameter in one.params:
            for option in parameter.opts if parameter.param_type_name == "option" else ():
                assert option in named[name], (name, option)
    codes = re.findall(r"^\| `(\d+)` \| (.*?) \|", pages["exit_codes"], re.M)
    assert {int(code): words for code, words in codes} == EXIT_CODES


def test_every_public_name_has_an_entry_and_parameters_are_read_as_such() -> None:
    page = api_reference.page()
    assert sorted(re.findall(r"^\.\. auto\w+:: vibecalc\.(\w+)$", page, re.M)) == sorted(
        vibecalc.__all__
    )
    lines = ["Run.", "", "Parameters", "----------", "a, b : two", "    of them.", "", "The end."]
    assert api_reference.as_numpydoc(lines) == [
        *lines[:4], "a, b", "    two", "    of them.", "", "Notes", "-----", "The end.",
    ]  # fmt: skip


def test_the_gallery_has_every_case_and_names_pictures_that_there_are() -> None:
    assert set(gallery.TELLING) <= set(every_picture())
    assert set(CASES.values()) < set(gallery.CASES)
    for case in gallery.CASES:
        text = gallery.entry(case, ["a.png"])
        title, path, *rest = text.split("\n\n")
        assert title.startswith("### ") and path == f"`{case.relative_to(ROOT)}`"
        assert rest[-1].startswith("![") and gallery.part_of(case)


def test_terms_of_the_glossary_are_in_order_and_once() -> None:
    text = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8")
    terms = [
        term.lower()
        for term in re.findall(r"^\| ([^|]+?) \|", text, re.M)[1:]
        if "-" * 3 not in term
    ]
    assert terms == sorted(set(terms)) and len(terms) > 40


@pytest.mark.long
def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    pytest.importorskip("sphinx")
    pytest.importorskip("furo")
    pytest.importorskip("matplotlib")
    generate.main()
    docs = ROOT / "docs"
    words = ["-m", "sphinx", "-q", "-W", "-c", str(docs / "site"), str(docs), str(tmp_path)]
    done = subprocess.run([sys.executable, *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert len([*tmp_path.rglob("*.html")]) >= len([*docs.rglob("*.md")])
