# SPDX-License-Identifier: LGPL-3.0-or-later
"""What can go wrong in a run, by name: in a file of its own, as naming an error loads no solver."""

from collections.abc import Mapping
from typing import Any


class NotConverged(RuntimeError):
    """No solution at some load level after every cut-back; the last good state is kept.

    Attributes
    ----------
    path : statics.path.Path up to there where a path was followed, else None

    Examples
    --------
    >>> import shellform as sf
    >>> try:
    ...     raise sf.NotConverged("no equilibrium found just beyond level 0.5")
    ... except RuntimeError as error:
    ...     print(error)
    no equilibrium found just beyond level 0.5
    """

    path: Any = None


class Unstable(RuntimeError):
    """A step produced numbers that are not finite, or energy from nothing.

    Explicit steps are cut back and tried again first; the last good state is kept.

    Examples
    --------
    >>> import shellform as sf
    >>> try:
    ...     raise sf.Unstable("node 7 of rectangle has left the finite numbers")
    ... except sf.Unstable as error:
    ...     print(error)
    node 7 of rectangle has left the finite numbers
    """


class CompilerError(RuntimeError):
    """There is no C compiler, or it could not compile, or nowhere to write to; says what to do.

    Examples
    --------
    >>> import shellform as sf
    >>> try:
    ...     raise sf.CompilerError("no C compiler: 'gcc' is not found")
    ... except sf.CompilerError as error:
    ...     print(error)
    no C compiler: 'gcc' is not found
    """


class Stopped(RuntimeError):
    """The run was interrupted; what it had reached is kept, the message says how to go on.

    Examples
    --------
    >>> import shellform as sf
    >>> try:
    ...     sf.run(sf.Scene(), "out/walk")  # doctest: +SKIP
    ... except sf.Stopped:  # Ctrl-C was pressed
    ...     sf.resume("out/walk")
    """


class Mendable(ValueError):
    """What is wrong with an input, and the option that mends it, in the words of the tool in use.

    Parameters
    ----------
    fact : str, what is wrong; mend : str, what to do, with options as `{max_gap}` or, with a value,
        `{unit:mm}`
    words : dict, option -> how the tool spells it, the value as `...`; None: `READ_MOTION`

    Examples
    --------
    >>> error = Mendable("walk.trc: the markers span 1.2 mm", "pass {unit:m}")
    >>> print(error)
    walk.trc: the markers span 1.2 mm; pass unit='m'
    >>> print(error.in_words({"unit": "--unit ..."}))
    walk.trc: the markers span 1.2 mm; pass --unit m
    """

    def __init__(self, fact: str, mend: str = "", words: Mapping[str, str] | None = None):
        super().__init__(fact, mend, words)  # as they are: errors travel between ranks
        self.fact, self.mend, self.words = fact, mend, words

    def in_words(self, words: Mapping[str, str]) -> str:
        """The sentence with options as `words` spell them."""
        said = {key: _Option(word) for key, word in (READ_MOTION | dict(words)).items()}
        return f"{self.fact}; {self.mend.format(**said)}" if self.mend else self.fact

    def __str__(self) -> str:
        return self.in_words(self.words or READ_MOTION)


# options of `shellform.read_motion`
READ_MOTION = {
    "cutoff": "cutoff",
    "map": "map='...'",
    "max_gap": "max_gap=...",
    "static": "static='...'",
    "unit": "unit='...'",
    "up": "up='...'",
    "window": "window=(start, end)",
}


class _Option(str):
    """An option whose value is the format: f"{option:mm}"."""

    def __format__(self, value: str) -> str:
        return self.replace("...", value) if value else _bare(self)


def _bare(word):
    """The option without a value: `unit=` of `unit='...'`."""
    return word.replace("'...'", "").replace('"..."', "").replace("...", "").strip()
