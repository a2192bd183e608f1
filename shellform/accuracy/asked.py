# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is asked for: a relative error, as a number, a percentage or a word."""

WORDS = {"draft": 0.03, "standard": 0.01, "fine": 0.001}
# of torques of a walk, which folds repeat to some percent only
WALK_WORDS = {"draft": 0.10, "standard": 0.08, "fine": 0.06}


def relative_error(asked: float | str, case: str | None = None) -> float:
    """Relative error of a number, a word or 'N%'; ValueError for anything else.

    Parameters
    ----------
    asked : what is asked for; case : of `choice.LEADING`: words say less of a walk

    Examples
    --------
    >>> relative_error("2%"), relative_error("draft"), relative_error("draft", "walk")
    (0.02, 0.03, 0.1)
    """
    words = WALK_WORDS if case == "walk" else WORDS
    if isinstance(asked, str):
        if asked in words:
            return words[asked]
        try:
            error = float(asked.removesuffix("%")) / 100 if asked.endswith("%") else 0.0
        except ValueError:
            error = 0.0
    else:
        error = asked if isinstance(asked, float) else 0.0
    if not 0 < error < 1:
        raise ValueError(f"draft, standard, fine or a percentage as '2%', not {asked!r}")
    return error


def percent(error: float) -> str:
    """An error as a text."""
    return f"{100 * error:.2g} %" if error < 0.995 else f"{100 * error:.0f} %"
