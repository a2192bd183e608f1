# SPDX-License-Identifier: LGPL-3.0-or-later
"""What differs between versions of dolfinx, and nothing else."""

import logging

from dolfinx import fem

# a rank that waits for another rank's compiler must not give up
JIT = {"timeout": 600}


def compiled(groups, **jit):
    """Compile tuples of UFL forms; all signatures first: compiling one changes those of others."""
    for form in (form for group in groups for form in group):
        form.signature()
    before = logging.root.manager.disable
    logging.disable(logging.INFO)  # or the C compiler's command lines reach the terminal
    try:
        return [tuple(fem.form(form, jit_params=JIT | jit) for form in group) for group in groups]
    finally:
        logging.disable(before)
