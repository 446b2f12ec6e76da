"""How Sphinx builds the site: from the pages that pages.py has written."""

project = "CANopen SDO conformance suite"
html_title = project
extensions = ["myst_parser", "sphinx_copybutton"]
# So that a link may lead to a heading of another page.
myst_heading_anchors = 3
# A block of code names no language where it is a command.
highlight_language = "none"
html_theme = "furo"
html_show_sourcelink = False
html_show_copyright = False
html_static_path = ["static"]
html_css_files = ["site.css"]
