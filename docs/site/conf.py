"""Configuration of the documentation site; `make site` builds it (`tools/site.py`)."""

project = "Acromovi"
html_title = "Acromovi"
extensions = ["myst_parser"]
myst_heading_anchors = 6
myst_links_external_new_tab = True
html_theme = "furo"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_extra_path = ["repository"]
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
pygments_style = "friendly"
pygments_dark_style = "github-dark"
suppress_warnings = ["misc.highlighting_failure"]  # outputs of programs that are shown as JSON with "..." in them
html_theme_options = {
    "navigation_with_keys": True,
    "light_css_variables": {"color-brand-primary": "#2f6fd0", "color-brand-content": "#2a63ba"},
    "dark_css_variables": {"color-brand-primary": "#7fb0ff", "color-brand-content": "#7fb0ff"},
}
