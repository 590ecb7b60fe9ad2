"""Claim: a case that cannot be read, or cannot be, is refused with words that help.

Each file in `bad_cases/` holds what its name says. The message names the place (line and column),
what was found, what is allowed and, where there is one, the way out; all problems come at once.
"""

import errno
import os
import re
import threading
from pathlib import Path

import pytest
from refused import hold, refused
from shipped_cases import CASES

from vibecalc.core.case.load import load_case
from vibecalc.core.results.visible import hidden, visible
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import EXIT_USAGE, CaseError, UsageError

FOLDER = Path(__file__).parent / "bad_cases"
GOOD = CASES["generator"]

MESSAGES = {
    path.stem: lambda _, path=path: refused(path).replace(f"{FOLDER}/", "")
    for path in sorted(FOLDER.glob("*.toml"))
}


def refusal(path: Path, *overrides: str) -> str:
    """Return the message with which a case is refused."""
    with pytest.raises(CaseError) as caught:
        load_checked([path], overrides)
    assert caught.value.exit_code == EXIT_USAGE
    assert caught.value.problems
    return str(caught.value)


@pytest.mark.parametrize("name", MESSAGES)
def test_words(name: str, tmp_path: Path) -> None:
    hold("bad_cases", name, MESSAGES[name], tmp_path)


def test_a_folder(tmp_path: Path) -> None:
    assert "is a folder\n  help: name a file in it" in refusal(tmp_path)


def test_a_name_that_is_nearly_right(tmp_path: Path) -> None:
    (tmp_path / "generator.toml").write_text("schema = 1\n")
    message = refusal(tmp_path / "generater.toml")
    assert "does not exist" in message
    assert "did you mean " in message
    assert "generator.toml'?" in message


def test_unreadable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "secret.toml"
    path.write_text("schema = 1\n")

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    assert "cannot be read: permission denied" in refusal(path)


def test_fifty_megabytes(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    with path.open("wb") as file:
        file.truncate(50_000_000)
    assert "is larger than 1 MB" in refusal(path)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"title = '\xff\xfe'\n", "is not text in UTF-8 (line 1)\n  help: save it in UTF-8"),
        (b"\x89HDF\r\n\x1a\n\x00\x00", "is a result file (HDF5), which `vibecalc report` reads"),
        ("schema = 1\n".encode("utf-16"), "is encoded in UTF-16\n  help: save it in UTF-8"),
        (b"schema = 1\n# \0", "is not a text file: null character in line 2"),
        (b"x = " + b"[" * 200_000, "nested beyond reason"),
        (b"a" + b".a" * 200_000 + b" = 1\n", "a key of more than 40 parts"),
        (b"x = " + b"9" * 9_000, "thousands of digits"),
        (b"schema = 1\n[machine]\n[machine]\n", "a table that is given twice"),
        (b"x = {a = 1, a = 2}\n", "a key that is given twice"),
        (b"speed = fast\n", "a value that cannot be read"),
        (b"[[machine]]\nspeed = 1\n", "machine cannot be a list"),
        (b"limit = [1, 2]\n", "limit[0] cannot be a number"),
        (b"schema = 1979-05-27\n", "not a whole number"),
        (b"'' = 1\n", "unknown key ''"),
    ],
)
def test_nasty_bytes(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "nasty.toml"
    path.write_bytes(content)
    assert words in refusal(path)


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("machine.speed", "needs key=value"),
        ("=3", "has to start with the name of a table"),
        ("machine..speed=3", "not a key"),
        ("machine.speed=[", "is not TOML"),
        ("machine.speed.x=3", "no table, so it has no key 'x'"),
        ("machine.crank_train.cylinders[9].position=3", "has 3 entries, [0] to [2], so no [9]"),
        ("machine.crank_train.cylinders.position=3", "say which entry"),
        ("machine[0]=3", "machine is no list"),
        ("machine.speed=__import__('os')", "is not TOML"),
    ],
)
def test_overrides_that_cannot_be_applied(override: str, words: str) -> None:
    with pytest.raises(UsageError, match=re.escape(words)):
        load_case(GOOD, [override])


def test_a_pipe_and_a_device_are_read_and_nothing_is_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pipe = tmp_path / "pipe.toml"
    os.mkfifo(pipe)
    monkeypatch.setattr("vibecalc.core.results.text_files._PATIENCE", 0.1)
    assert "is a pipe that nobody writes to" in refusal(pipe)
    assert "is larger than 1 MB" in refusal(Path("/dev/zero"))
    assert "is empty" in refusal(Path("/dev/null"))
    content = GOOD.read_bytes()
    writer = threading.Thread(target=pipe.write_bytes, args=(content,))
    writer.start()
    assert load_case(pipe).text == content.decode()
    writer.join()


HIDING = "\u00ad\u061c\u180e\u200b\u200e\u200f\u202a\u202e\u2060\u2069\ufeff\ufff9\U000e0041"


def test_what_hides_or_moves_text_is_refused() -> None:
    assert [hidden(f"a{character}b") for character in HIDING] == [*HIDING]
    character = HIDING[0]
    with pytest.raises(CaseError, match="title has an unprintable character"):
        load_case(GOOD, [("title", f"a{character}b")])
    with pytest.raises(UsageError, match="--set has an unprintable character"):
        load_case(GOOD, [f"title=a{character}b"])


#: Persian, Marathi, an emoji of two joined ones, an Arabic number sign, an ideographic space
JOINED = (
    "\u0645\u06cc\u200c\u062e",
    "\u0930\u094d\u200d\u092f",
    "\U0001f469\u200d\U0001f527",
    "\u06004",
    "\u8a66\u3000\u9a13",
)


def test_what_joins_letters_is_printed() -> None:
    assert load_case(GOOD, [f"title={JOINED[0]}"]).case.title == JOINED[0]
    assert [visible(title) for title in JOINED] == [*JOINED]
