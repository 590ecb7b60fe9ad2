"""What is said of a result by a field: of families by the words of each class."""

from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.described import entries_of, paths_of, q
from vibecalc.core.results.record import Headline


@dataclass(frozen=True)
class Load:
    """A family of two."""

    ROOT: ClassVar[str]
    peak: Any = q(
        "{member} order", "{unit}", "largest {what}", headline=Headline("{what}, peak", "{unit}")
    )
    mean: Any = q("{member}", "{unit}", "mean {what}")


class Force(Load):
    """One of them."""

    ROOT = "a/force"
    WORDS: ClassVar = {"member": "mount", "unit": "N", "what": "force"}


@dataclass(frozen=True)
class Couple(Load):
    """The other, which says one field in its own words and has one more."""

    ROOT: ClassVar[str] = "a/couple"
    WORDS: ClassVar = {"member": "pin", "unit": "N*m", "what": "couple"}
    peak: Any = q("{member} order", "{unit}", "{what} at its largest")
    rms: Any = q("{member}", "{unit}", "r.m.s. of the {what}")


def test_words_of_a_class_stand_in_all_that_is_said() -> None:
    peak, mean = entries_of(Force)
    assert (peak.path, peak.axes, peak.unit) == ("a/force/peak", ("mount", "order"), "N")
    assert peak.long_name == "largest force"
    assert peak.headline == Headline("force, peak", "N")
    assert (mean.path, mean.axes, mean.headline) == ("a/force/mean", ("mount",), None)


def test_a_class_may_say_a_field_in_its_own_words() -> None:
    found = list(entries_of(Couple))
    assert [one.path for one in found] == ["a/couple/peak", "a/couple/mean", "a/couple/rms"]
    assert [one.long_name for one in found] == [
        "couple at its largest", "mean couple", "r.m.s. of the couple",
    ]  # fmt: skip
    assert found[0].headline is None


def test_names_without_words_and_unknown_fields_are_refused() -> None:
    class Nameless(Load):
        ROOT = "a/nothing"

    with pytest.raises(KeyError):
        list(entries_of(Nameless))
    with pytest.raises(ValueError, match="Force has no rms"):
        paths_of(Force, "rms")


def test_no_name_in_braces_is_left_in_a_result() -> None:
    assert not [path for path, one in CATALOGUE.items() if "{" in f"{path} {one}"]
