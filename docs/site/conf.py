"""Settings of the site: pages of docs/ and, in docs/generated/, what `generate.py` has written."""

import re
import sys
from pathlib import Path
from typing import Any

import vibecalc

sys.path.insert(0, str(Path(__file__).parent))
from api_reference import as_numpydoc
from generate import TAKEN

project = "vibecalc"
version = release = vibecalc.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "index"
exclude_patterns = ["_build", "site"]
html_theme = "furo"
html_title = f"vibecalc {release}"
html_show_copyright = False
html_copy_source = False
html_show_sourcelink = False
html_static_path = ["static"]
html_css_files = ["site.css"]

myst_heading_anchors = 4
myst_enable_extensions = ["attrs_inline"]
suppress_warnings = ["misc.highlighting_failure"]  # formulas are blocks of no language
highlight_language = "text"
smartquotes = False

autodoc_member_order = "bysource"
autodoc_typehints = "none"
default_role = "code"
napoleon_google_docstring = False


# ----------------------------------------------------------------------------
# Pages link to files of the checkout; some of these are pages of the site under another name.
# ----------------------------------------------------------------------------

_MOVED = {path.name: f"generated/{name}.md" for name, path in TAKEN.items()}


def _link_to_what_was_taken(_app: Any, page: str, source: list[str]) -> None:
    up = "../" * page.count("/")
    for name, place in _MOVED.items():
        source[0] = re.sub(rf"\]\([\w./]*\b{name}(#[\w-]+)?\)", rf"]({up}{place}\1)", source[0])


# ----------------------------------------------------------------------------
# The start page is plain Markdown, whose links work in a clone too. The site's list of pages is
# made from them: a part for each heading, each page where it is linked first.
# ----------------------------------------------------------------------------

_LINK = re.compile(r"\[([^\]]+)\]\(([\w./]+)\.(md|ipynb)\)")
#: what `generate.py` makes of the program, behind the pages of a heading
_GENERATED = {
    "Reference": (
        "generated/case/index",
        "generated/results/index",
        "generated/command_line",
        "generated/exit_codes",
        "generated/python",
        "generated/gallery",
    )
}


def _list_pages(_app: Any, page: str, source: list[str]) -> None:
    if page != "index":
        return
    seen: set[str] = set()
    parts = source[0].split("\n## ")
    for place, part in enumerate(parts[1:], 1):
        heading = part.partition("\n")[0]
        entries = []
        for words, path, kind in _LINK.findall(part):
            name = path if kind == "md" else f"generated/{path}"
            if name not in seen:
                entries.append(f"{words[0].upper()}{words[1:]} <{name}>")
                seen.add(name)
        lines = "\n".join((*entries, *_GENERATED.get(heading, ())))
        options = f":hidden:\n:caption: {heading}"
        parts[place] = f"{part}\n\n```{{toctree}}\n{options}\n\n{lines}\n```\n"
    source[0] = "\n## ".join(parts)


def _parameters(*_of: Any) -> None:
    lines = _of[-1]
    lines[:] = as_numpydoc(lines)


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.connect("source-read", _link_to_what_was_taken)
    app.connect("source-read", _list_pages)
    app.connect("autodoc-process-docstring", _parameters, priority=100)
