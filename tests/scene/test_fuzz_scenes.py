# SPDX-License-Identifier: LGPL-3.0-or-later
"""Damaged scenes and fabric cards: a value or one sentence that names the file.

hypothesis chooses the damage from the test itself (derandomize); FUZZ_EXAMPLES asks for more.
"""

import os
import warnings

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from shellform.__main__ import TEMPLATE
from shellform.material.card import CARDS, read_fabric
from shellform.scene.scene_file import read_scene

pytestmark = pytest.mark.serial  # files are damaged the same way on every rank

EXAMPLES = int(os.environ.get("FUZZ_EXAMPLES", "60"))
FULL = "\n".join(
    line.removeprefix("# ") for line in TEMPLATE.splitlines()[1:] if "=" in line or "[" in line
)
ODD = (
    "nan", "inf", "-1", "1e308", "0", "true", '""', '"x"', "[]", "{}", "[1, 2]", "1979-05-27",
    "'\\0'",
    "9" * 30, "\ufeff", "= =", "[", '"""', "[garment]", "{ a = 1 }", '"\\u0000"', "[[1]]",
)  # fmt: skip
DAMAGE = st.lists(
    st.tuples(
        st.sampled_from(["value", "value", "value", "cut", "key", "line", "insert"]),
        st.floats(0.0, 1.0),
        st.sampled_from(ODD),
    ),
    min_size=1,
    max_size=3,
)


def damaged(text, what, a, odd):
    lines = text.splitlines()
    k = int(a * (len(lines) - 1))
    if what == "cut":
        return text[: int(a * len(text))]
    if what == "insert":
        return text[: int(a * len(text))] + odd + text[int(a * len(text)) :]
    if what == "line":
        del lines[k]
    elif "=" in lines[k]:
        key, _, value = lines[k].partition("=")
        lines[k] = f"{key}= {odd}" if what == "value" else f"{key.strip()}{odd} ={value}"
    return "\n".join(lines)


def one_sentence(read, path):
    try:
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            read(path)
    except (ValueError, OSError) as error:
        said = str(error)
        assert "\n" not in said and said.strip() and len(said) < 1000, said


def fuzz(test):
    return settings(
        max_examples=EXAMPLES,
        derandomize=True,
        deadline=None,
        database=None,
        suppress_health_check=[HealthCheck.function_scoped_fixture],
    )(test)


@fuzz
@given(damage=DAMAGE)
def test_damaged_scenes(tmp_path, damage):
    text = FULL
    for step in damage:
        text = damaged(text, *step) or "x"
    (tmp_path / "x.toml").write_bytes(text.encode("utf-8", "surrogatepass"))
    one_sentence(read_scene, tmp_path / "x.toml")


@fuzz
@given(damage=DAMAGE, card=st.sampled_from(["compliant", "stiff"]))
def test_damaged_cards(tmp_path, damage, card):
    text = (CARDS / f"{card}.toml").read_text()
    for step in damage:
        text = damaged(text, *step) or "x"
    (tmp_path / "card.toml").write_bytes(text.encode("utf-8", "surrogatepass"))
    one_sentence(read_fabric, tmp_path / "card.toml")
