# SPDX-License-Identifier: LGPL-3.0-or-later
"""Trousers, sleeves, skirts; preparing a garment of the user's own."""
