# SPDX-License-Identifier: LGPL-3.0-or-later
"""Putting a garment on, the belt, dressed states kept in files. Fig. 7."""
