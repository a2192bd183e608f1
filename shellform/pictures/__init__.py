# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of surfaces and of walks."""
