# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whatever warns must be asked for with `pytest.warns`."""

import warnings

import pytest


@pytest.fixture(autouse=True)
def _warnings_are_errors():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield
