# SPDX-License-Identifier: LGPL-3.0-or-later
"""Settings of Sphinx: pages in Markdown, a gallery that is run, reference from the docstrings."""

import os
import sys
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy loads its BLAS

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "demos"), str(HERE.parent)]

import docstrings  # noqa: E402
import formulas  # noqa: E402
import rooms  # noqa: E402

import shellform  # noqa: E402

project = "shellform"
author = "the authors of shellform"
copyright = "the authors of shellform, LGPL-3.0-or-later"
release = version = shellform.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "gallery", "sg_execution_times.rst"]
html_theme = "furo"
html_title = "shellform"
html_math_renderer = "mathml"
html_static_path = ["style"]
html_css_files = ["wide.css"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"members": True, "show-inheritance": True}
# names of types that stand in signatures without a page of their own
nitpick_ignore_regex = [("py:.*", ".*")]

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "gallery_pages",
    "filename_pattern": r"/plot_",
    "within_subsection_order": "FileNameSortKey",
    "plot_gallery": "True",
    "abort_on_example_error": False,
    "download_all_examples": False,
    "show_signature": False,
    "min_reported_time": 0,
    "run_stale_examples": True,  # the code they call may have changed
    "remove_config_comments": True,
    "copyfile_regex": r".*\.toml",
    "reset_modules": ("matplotlib",),
    "show_memory": False,
    "capture_repr": (),
    "write_computation_times": False,
}
# the backend of the gallery is matplotlib's Agg, as there is no screen
os.environ["MPLBACKEND"] = "Agg"


def setup(app):
    docstrings.setup(app)
    formulas.setup(app)
    rooms.setup(app)
