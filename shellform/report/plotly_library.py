# SPDX-License-Identifier: LGPL-3.0-or-later
"""The drawing library that a report carries in itself: plotly.js, from the Python package plotly.

It is an option: only a report needs it. MIT licence; the text stands at the head of the script.
"""

HOW = "a report needs the package plotly: pip install plotly, or shellform[report]"


def is_there() -> bool:
    """Whether plotly is installed; it is not loaded."""
    from importlib.util import find_spec

    return find_spec("plotly") is not None


def script() -> str:
    """Text of plotly.min.js.

    Raises
    ------
    ImportError where plotly is not installed, with how to get it
    """
    # only here: it is an option, and large
    try:
        from plotly.offline import get_plotlyjs
    except ImportError as error:
        raise ImportError(HOW) from error
    return get_plotlyjs()
