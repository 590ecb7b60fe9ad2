"""Settings of the site: pages of docs/ and, in docs/generated/, what `generate.py` has written."""

import sys
from pathlib import Path

import vibecalc

sys.path.insert(0, str(Path(__file__).parent))

project = "vibecalc"
version = release = vibecalc.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "index"
exclude_patterns = ["_build", "site", "build"]
html_theme = "furo"
html_title = f"vibecalc {release}"
html_show_copyright = False
html_copy_source = False
html_show_sourcelink = False

myst_heading_anchors = 4
myst_enable_extensions = ["attrs_block"]
suppress_warnings = ["misc.highlighting_failure"]  # formulas of the theory are blocks of no language
highlight_language = "text"

autodoc_member_order = "bysource"
autodoc_typehints = "none"
default_role = "code"
napoleon_google_docstring = False
