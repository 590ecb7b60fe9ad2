"""Settings of the site: pages of docs/ and, in docs/generated/, what `generate.py` has written."""

import re
import sys
from fnmatch import fnmatch
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


def _leave_out_what_is_not_there(app: Any, page: str, source: list[str]) -> None:
    """Patterns of the start page for pages that some checkouts lack."""
    if page == "index":
        docs = app.env.found_docs
        kept = (
            line
            for line in source[0].split("\n")
            if not re.fullmatch(r"[\w/]+\*", line) or any(fnmatch(doc, line) for doc in docs)
        )
        source[0] = "\n".join(kept)


def _parameters(*_of: Any) -> None:
    lines = _of[-1]
    lines[:] = as_numpydoc(lines)


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.connect("source-read", _link_to_what_was_taken)
    app.connect("source-read", _leave_out_what_is_not_there)
    app.connect("autodoc-process-docstring", _parameters, priority=100)
