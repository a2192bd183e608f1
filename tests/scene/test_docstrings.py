# SPDX-License-Identifier: LGPL-3.0-or-later
"""Examples in the docstrings of scenes' parts and of surfaces give what they say."""

import doctest

import pytest

import meshes.surface
import meshes.validity
from shellform.scene import parts


@pytest.mark.parametrize("module", [parts, meshes.surface, meshes.validity])
def test_examples_run(module):
    outcome = doctest.testmod(module, optionflags=doctest.ELLIPSIS)
    assert outcome.failed == 0
    assert outcome.attempted >= 3
