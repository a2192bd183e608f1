# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs as one HTML file that opens without a network: numbers, curves, the walk in 3-D."""
