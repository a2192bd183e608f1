# SPDX-License-Identifier: LGPL-3.0-or-later
"""What tests of several files share."""

import pytest

from demos.studies.extremes import motion_cases as motion
from demos.studies.extremes.sheet_cases import strip


@pytest.fixture(scope="module")
def flight():
    """The flight that all units and places must repeat."""
    return motion.tumbled(strip(1e-3), steps=400)["places"]
