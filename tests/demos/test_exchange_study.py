# SPDX-License-Identifier: LGPL-3.0-or-later
"""The exchange of a sheet that meets itself: all nodes, in the order of the ranks."""

import numpy as np

from demos.studies.self_contact import exchange
from shellform import SelfContact


def test_everywhere_is_what_ranks_have():
    stepper = exchange.stepper_of(5)
    cloth, comm = stepper.add(SelfContact()), stepper.shell.comm
    rng = np.random.default_rng(comm.rank)
    own = [rng.normal(size=(stepper.n_owned, 3)) for _ in range(3)]
    for one, whole in zip(own, cloth.everywhere(*own), strict=True):
        assert np.array_equal(whole, np.concatenate(comm.allgather(one)))
        assert whole.flags.c_contiguous


def test_the_table(capsys):
    exchange.main(["--cells", "2"])
    said = capsys.readouterr().out
    assert "9 nodes: exchange" in said or exchange.COMM.rank
