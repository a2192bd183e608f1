# SPDX-License-Identifier: LGPL-3.0-or-later
"""One list of a capture's options: the arguments of `read_motion`, the keys of a scene, the options
of demos/walk.py and the words of messages are all of it."""

import inspect
from dataclasses import fields

from demos import walk
from shellform.errors import READ_MOTION
from shellform.motion.capture.options import IN_SCENE, OPTIONS, options_of
from shellform.motion.capture.read_motion import read_motion
from shellform.scene.parts import Motion

NAMES = {option.name for option in OPTIONS}


def test_arguments_of_read_motion():
    """Same names and defaults; but the file, its window, and what no scene has as a key."""
    arguments = inspect.signature(read_motion).parameters
    assert set(arguments) == NAMES | {"file", "window", "rigid", "upper"}
    assert {o.name: o.default for o in OPTIONS} == {n: arguments[n].default for n in NAMES}


def test_keys_of_a_scene():
    known = {f.name: f.metadata.get("unit", "") for f in fields(Motion)}
    assert {option.name: option.unit for option in OPTIONS}.items() <= known.items()
    assert options_of(Motion(max_gap=0.2)) == options_of(Motion()) | {"max_gap": 0.2}


def test_options_of_the_walk():
    """Each arrives in the scene; without any, the scene has its defaults."""
    assert options_of(walk.scene_of(walk.arguments([]), "stiff").motion) == options_of(Motion())
    given = {"static": "s.trc", "map": "cmu", "unit": "mm", "up": "z", "cutoff": 5.0}
    given["max_gap"] = 0.3
    words = [part for o in OPTIONS for part in (o.flag, str(given[o.name]))]
    assert options_of(walk.scene_of(walk.arguments(words), "stiff").motion) == given


def test_words_of_messages():
    """What a message may name is spelled by every tool."""
    for words in (READ_MOTION, IN_SCENE, walk.WORDS):
        assert set(words) == NAMES | {"window"}
    for option in OPTIONS:
        assert option.key in IN_SCENE[option.name] and option.flag in walk.WORDS[option.name]
