# SPDX-License-Identifier: LGPL-3.0-or-later
"""Virtual specimens: what a fabric card gives back in the tests of textile laboratories."""
