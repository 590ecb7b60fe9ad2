"""Claim: what `make package` builds is small, whole, the same every time, and works by itself.

The wheel is installed as pipx does it: into an environment with what its metadata ask for and
nothing else, here links to the packages of this environment. The commands run in an empty folder.
"""

import email
import gzip
import json
import os
import re
import shlex
import subprocess
import sys
import tarfile
import zipfile
from collections.abc import Iterator, Sequence
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from trove_classifiers import classifiers

import vibecalc
from vibecalc.cli.starters import examples

ROOT = Path(__file__).resolve().parents[1]
VERSION = vibecalc.__version__
#: bytes; the code alone is 2.0 MB in a wheel, which deflates each file by itself
LARGEST_SDIST, LARGEST_WHEEL = 2_000_000, 2_500_000


class Built(NamedTuple):
    """What `make package` has written."""

    sdist: Path
    wheel: Path


class Ended(NamedTuple):
    """How a command of the installed program ended."""

    code: int
    out: str
    err: str


class Installed(NamedTuple):
    """An environment with the wheel in it, and a folder to work in."""

    environment: Path
    folder: Path

    def __call__(self, *arguments: str) -> Ended:
        ended = subprocess.run(
            [self.environment / "bin" / "vibecalc", *arguments], cwd=self.folder, env=plain(),
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        return Ended(ended.returncode, ended.stdout, ended.stderr)

    def each(self, *lines: Sequence[str]) -> list[Ended]:
        """Commands one after the other in one process of the installed Python."""
        said = self.python(ONE_PROCESS, json.dumps(lines))
        return [Ended(*one) for one in json.loads(said)]

    def python(self, code: str, given: str = "") -> str:
        return subprocess.run(
            [self.environment / "bin" / "python", "-c", code], input=given, cwd=self.folder,
            env=plain(), capture_output=True, text=True, check=True,
        ).stdout  # fmt: skip


#: what the script of the wheel does, for several lines, without starting anew
ONE_PROCESS = """
import contextlib, io, json, sys
from vibecalc.__main__ import main
said = []
for words in json.load(sys.stdin):
    out, err, code = io.StringIO(), io.StringIO(), 0
    sys.argv = ["vibecalc", *words]
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main()
        except SystemExit as stop:
            code = stop.code or 0
    said.append([code, out.getvalue(), err.getvalue()])
json.dump(said, sys.stdout)
"""


def plain() -> dict[str, str]:
    """The surroundings without what make, an editor or a shell put into them for Python."""
    left_out = ("PYTHON", "MAKE", "MFLAGS", "VIRTUAL_ENV")
    return {name: value for name, value in os.environ.items() if not name.startswith(left_out)}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    folder = tmp_path_factory.mktemp("dist")
    environment = Path(sys.prefix)
    subprocess.run(
        ["make", "-s", "-o", str(environment / ".ready"), "package", f"VENV={environment}",
         f"DIST={folder}"],
        cwd=ROOT, env=plain(), check=True, capture_output=True,
    )  # fmt: skip
    (sdist,), (wheel,) = folder.glob("*.tar.gz"), folder.glob("*.whl")
    return Built(sdist, wheel)


@pytest.fixture(scope="module")
def installed(built: Built, tmp_path_factory: pytest.TempPathFactory) -> Installed:
    environment = empty_environment(tmp_path_factory.mktemp("environment"))
    (packages,) = environment.glob("lib/python*/site-packages")
    for source in needed(built.wheel):
        (packages / source.name).symlink_to(source)
    install(environment, "--no-index", "--no-deps", str(built.wheel))
    return Installed(environment, tmp_path_factory.mktemp("work"))


def empty_environment(folder: Path) -> Path:
    """An environment in `folder` without any package."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
    return folder


def install(environment: Path, *what: str) -> None:
    """Let pip install, and say whether all that is required is there."""
    pip = (sys.executable, "-m", "pip", "--disable-pip-version-check")
    there = (*pip, "--python", str(environment / "bin" / "python"))
    subprocess.run([*there, "install", "--quiet", "--no-compile", *what], env=plain(), check=True)
    subprocess.run([*there, "check"], env=plain(), check=True, capture_output=True)


def needed(wheel: Path) -> Iterator[Path]:
    """Files and folders in this environment of all that the wheel requires without an extra."""
    known: set[str] = set()
    left = information(wheel).get_all("Requires-Dist", [])
    while left:
        requirement = Requirement(left.pop())
        name = canonicalize_name(requirement.name)
        marker = requirement.marker
        if name in known or (marker is not None and not marker.evaluate({"extra": ""})):
            continue
        known.add(name)
        found = metadata.distribution(name)
        left += found.requires or []
        tops = {path.parts[0] for path in found.files or ()} - {"..", "__pycache__"}
        yield from (Path(str(found.locate_file(top))) for top in sorted(tops))


def information(wheel: Path) -> "email.message.Message[str, str]":
    """The metadata of a wheel."""
    with zipfile.ZipFile(wheel) as file:
        text = file.read(f"vibecalc-{VERSION}.dist-info/METADATA").decode("utf-8")
    return email.message_from_string(text)


def tree(folder: str) -> set[str]:
    """Files of a folder of the checkout, without what Python made of them."""
    paths = (path for path in (ROOT / folder).rglob("*") if path.is_file())
    return {path.relative_to(ROOT).as_posix() for path in paths if path.parts[-2] != "__pycache__"}


# ----------------------------------------------------------------------------
# What is in it
# ----------------------------------------------------------------------------


def test_the_wheel_has_the_package_its_cases_and_its_first_page(built: Built) -> None:
    about = f"vibecalc-{VERSION}.dist-info"
    with zipfile.ZipFile(built.wheel) as wheel:
        names = set(wheel.namelist())
    files = ("METADATA", "WHEEL", "RECORD", "entry_points.txt", "licenses/LICENSE")
    assert names == {
        *tree("vibecalc"),
        *(f"vibecalc/{name}" for name in tree("cases")),
        "vibecalc/docs/start.md",
        *(f"{about}/{name}" for name in files),
    }
    assert "vibecalc/py.typed" in names and "vibecalc/starters/generator.toml" in names
    assert built.wheel.stat().st_size < LARGEST_WHEEL


def test_the_source_distribution_has_what_the_wheel_is_made_of(built: Built) -> None:
    with tarfile.open(built.sdist) as sdist:
        names = {name.removeprefix(f"vibecalc-{VERSION}/") for name in sdist.getnames()}
    others = (
        "pyproject.toml",
        "LICENSE",
        "CHANGELOG.md",
        "docs/start.md",
        "PKG-INFO",
        ".gitignore",
    )
    assert names == {*tree("vibecalc"), *tree("cases"), *others}
    assert built.sdist.stat().st_size < LARGEST_SDIST


def test_it_is_built_the_same_again(built: Built, tmp_path: Path) -> None:
    """From the checkout, whose files have other dates than those out of the source distribution."""
    build = [sys.executable, "-m", "hatchling", "build", "-d", str(tmp_path)]
    subprocess.run(build, cwd=ROOT, env=plain(), check=True, capture_output=True)
    assert (tmp_path / built.wheel.name).read_bytes() == built.wheel.read_bytes()
    again = gzip.decompress((tmp_path / built.sdist.name).read_bytes())
    assert again == gzip.decompress(built.sdist.read_bytes())


def test_the_metadata_say_whose_it_is_and_under_which_licence(built: Built) -> None:
    said = information(built.wheel)
    assert said["Name"] == "vibecalc" and said["Version"] == VERSION
    assert said["License-Expression"] == "BSD-3-Clause" and said["License-File"] == "LICENSE"
    assert said["Author"] == "the vibecalc developers" and said["Project-URL"] is None
    assert "the vibecalc developers" in (ROOT / "LICENSE").read_text(encoding="utf-8")
    assert set(said.get_all("Classifier", [])) <= classifiers
    assert {"Typing :: Typed", "Operating System :: OS Independent"} <= set(
        said.get_all("Classifier", [])
    )
    page = said.get_payload()
    assert page == (ROOT / "docs" / "start.md").read_text(encoding="utf-8")
    assert "](" not in page, "a link leads nowhere from the page of the package"


# ----------------------------------------------------------------------------
# What it does where nothing else is
# ----------------------------------------------------------------------------


def test_the_commands_of_the_first_page_work(installed: Installed) -> None:
    page = (ROOT / "docs" / "start.md").read_text(encoding="utf-8")
    lines = [
        line for block in re.findall(r"```sh\n(.*?)```", page, re.S) for line in block.splitlines()
    ]
    commands = [shlex.split(line, comments=True)[1:] for line in lines]
    said = {}
    for words, ended in zip(commands, installed.each(*commands), strict=True):
        assert ended.code == 0, (words, ended.err)
        said[" ".join(words[:2])] = ended.out
    assert said["new --example"].split("\n")[-2].startswith("gallery/v8 ")
    assert len(said["new --example"].splitlines()) == len(examples())
    for name in ("generator.toml", "outputs/generator.h5", "outputs/generator.txt", "mine.toml"):
        assert (installed.folder / name).is_file()
    shipped = (ROOT / "cases" / "generator.toml").read_bytes()
    assert (installed.folder / "generator.toml").read_bytes() == shipped
    code = "import vibecalc; print(vibecalc.__file__, vibecalc.__version__)"
    place, version = installed.python(code).split()
    assert version == VERSION and Path(place).is_relative_to(installed.environment)
    assert installed("--version").out == f"vibecalc {VERSION}\n"

    # what was computed here is what golden files hold; matplotlib is an extra
    golden, rules = (
        str(ROOT / "tests" / "golden" / name) for name in ("generator.h5", "rules.toml")
    )
    helped, first, same, other, *drawn = installed.each(
        ["--help"],
        ["help", "start"],
        ["diff", golden, "outputs/generator.h5", "--rules", rules],
        ["diff", golden, "outputs/mine.h5"],
        ["plot", "outputs/generator.h5"],
        ["report", "--html", "outputs/generator.h5"],
    )
    assert helped.code == 0 and "verify" in helped.out and first.out == page
    assert same.code == 0, same.out
    assert other.code == 1
    for ended in drawn:
        assert ended.code == 2
        assert "matplotlib, which is not installed" in ended.err and "vibecalc[plot]" in ended.err


def test_an_example_brings_the_files_that_it_names(installed: Installed) -> None:
    ended = installed("new", "--example", "genset_coupling", "-o", "line")
    assert ended.code == 0
    assert {path.name for path in (installed.folder / "line").rglob("*.*")} == {
        "genset_coupling.toml", "genset_stations.csv", "couplings.toml",
    }  # fmt: skip
    assert installed("check", "line/genset_coupling.toml").code == 0


@pytest.mark.long
def test_pip_installs_it_with_what_it_requires(built: Built, tmp_path: Path) -> None:
    """The same with packages of their own, as `make` gets them for this environment."""
    environment = empty_environment(tmp_path / "environment")
    install(environment, "-c", str(ROOT / "constraints.txt"), str(built.wheel))
    installed = Installed(environment, tmp_path)
    test_the_commands_of_the_first_page_work(installed)
    test_an_example_brings_the_files_that_it_names(installed)
