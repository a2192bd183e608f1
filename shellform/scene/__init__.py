# SPDX-License-Identifier: LGPL-3.0-or-later
"""Scenes: their files and checks, the wearer and the garment they describe."""
