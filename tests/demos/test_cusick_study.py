# SPDX-License-Identifier: LGPL-3.0-or-later
"""The study of Cusick's drape: its fit, its cloth, its table; drapes themselves in tests/bench."""

import json

import numpy as np
import pytest

from demos.studies.cusick import run as cusick
from shellform.bench.drape import Drape

pytestmark = pytest.mark.serial  # a study of one rank


@pytest.mark.parametrize("wanted", [16.0, 50.0, 78.0])
def test_the_fit(wanted):
    """A coefficient that rises with log B, with the roughness of one start."""

    def coefficient(B):
        return 100 / (1 + np.exp(-(np.log(B / 1.3e-5)))) + 0.2 * np.sin(40 * np.log(B))

    B, found = cusick.fit(coefficient, wanted, 1e-5)
    assert found == coefficient(B) and abs(found - wanted) < cusick.CLOSE


def test_the_cloth():
    """Loops in proportion to suiting, only where friction is asked for."""
    plain, rubbing = (cusick.cloth(0.2, 1e-5, friction) for friction in (False, True))
    assert plain.friction is None and rubbing.friction.bend_weft[0][1] == pytest.approx(2.29e-4)
    assert np.allclose(plain.bending.diagonal()[:2], 1e-5)


def test_the_table(tmp_path, capsys, monkeypatch):
    def fallen(fabric, start, cells, lowering):
        part = 0.701 + 0.01 * start
        return Drape(part, 7 + start % 2, np.full(8, 0.1), 1.0, True, None, None)

    monkeypatch.setattr(cusick, "drape", fallen)
    cusick.main(["--fabrics", "cotton_blue", "--starts", "3", "--out", str(tmp_path)])
    said = capsys.readouterr().out.splitlines()
    assert said[1].split() == ["cotton_blue", "no", *said[1].split()[2:]]
    assert said[1].split()[-7:] == ["70.1", "+-", "6.4", "71.1", "1.0", "7.6", "7.3"]
    rows = json.loads((tmp_path / "summary.json").read_text())["results"]["rows"]
    assert [row["friction"] for row in rows] == [False, True]
    assert rows[0]["folds"] == [7, 8, 7]
