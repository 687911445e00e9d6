# SPDX-License-Identifier: Apache-2.0
"""Sphinx's configuration of the site; build_site.py stages the pages and calls it."""

project = "evcot"
author = "The evcot authors"
copyright = author
extensions = ["myst_parser"]
exclude_patterns = ["extra"]
html_theme = "furo"
html_title = "evcot"
html_extra_path = ["extra"]
html_static_path = ["../static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
myst_heading_anchors = 6  # as on GitHub, so that a link to a heading works in both
myst_enable_extensions = ["html_image"]  # with a width, which Markdown has no word for
# A part of a file, shown as an example, need not parse; lists of files are linked to, and stand in no navigation.
suppress_warnings = ["misc.highlighting_failure", "toc.not_included"]
nitpicky = True
