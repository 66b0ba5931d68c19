"""Sphinx configuration: `sphinx-build -W docs site`."""

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[1] / "src"), str(Path(__file__).parent)]

import parakin  # noqa: E402

project = "parakin"
author = "the parakin developers"
copyright = "2026, the parakin developers"
release = parakin.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.viewcode", "gallery"]
myst_enable_extensions = ["deflist"]
html_theme = "furo"
html_title = "parakin"
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_preserve_defaults = True
exclude_patterns = ["README.md"]
html_extra_path = ["recorded"]
nitpicky = True
# Of other projects, whose inventories would have to be fetched.
nitpick_ignore = [
    *(
        ("py:class", f"numpy.{name}")
        for name in ("ndarray", "dtype", "float64", "complex128", "int64", "int8", "bool")
    ),
    ("py:class", "collections.abc.Callable"),
    ("py:class", "collections.abc.Mapping"),
    ("py:class", "parakin.algebra.spatial.S_co"),  # a type variable, known to type checkers alone
]
