"""Write the generated pages of the site into docs/generated/, which git does not keep.

References, the gallery, notebooks as pages. The pictures that tutorials and guides draw go into
docs/pictures/drawn/, which git keeps for those who read in a clone.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import api_reference
import case_reference
import command_reference
import gallery
import notebooks
import page_run
import result_reference

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
GENERATED = DOCS / "generated"
#: pictures that pages draw while they run
DRAWN = DOCS / "pictures" / "drawn"
#: what is no page of docs/ and is shown on the site
TAKEN = {"changes": ROOT / "CHANGELOG.md", "benchmarks": ROOT / "benchmarks" / "RESULTS.md"}


def references() -> dict[str, str]:
    """The pages that need no drawing, by their path below docs/generated."""
    found = command_reference.pages() | {"python": api_reference.page()}
    found |= {f"case/{name}": text for name, text in case_reference.pages().items()}
    found |= {f"results/{name}": text for name, text in result_reference.pages().items()}
    return found | {name: path.read_text(encoding="utf-8") for name, path in TAKEN.items()}


def scripts() -> Iterator[Path]:
    """Pages that draw pictures while they run."""
    for path in sorted((*DOCS.glob("*.md"), *DOCS.glob("tutorials/*"), *DOCS.glob("how_to/*"))):
        if path.suffix == ".md" and page_run.pictures_of(path, DRAWN):
            yield path


def main(workers: int = 2) -> None:
    """Write all of them, drawing in some processes; a page that did not change keeps its time."""
    written = references()
    written["gallery"] = gallery.page(GENERATED / "pictures", workers)
    for path in sorted(DOCS.glob("*.ipynb")):
        written[path.stem] = notebooks.page(path, GENERATED / "notebook_pictures")
    for name, text in written.items():
        page = GENERATED / f"{name}.md"
        page.parent.mkdir(parents=True, exist_ok=True)
        if not page.is_file() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")
    for page in GENERATED.rglob("*.md"):
        if str(page.relative_to(GENERATED).with_suffix("")) not in written:
            page.unlink()
    for path in scripts():
        page_run.run_to_draw(path, DRAWN)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
