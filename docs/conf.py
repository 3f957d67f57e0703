"""The site that `make docs` builds: the Markdown of this folder, and pages that docs/builder makes of the program."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

project = "Friction Workbench"
html_title = project
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "builder.extension"]
exclude_patterns = ["plugin_example"]

myst_enable_extensions = ["dollarmath"]
myst_fence_as_directive = ["math"]
myst_heading_anchors = 4

default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "none"
add_module_names = False

html_theme = "furo"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_show_sphinx = False
html_show_copyright = False
html_copy_source = False
html_show_sourcelink = False
