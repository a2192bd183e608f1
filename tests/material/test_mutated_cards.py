# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cards gone wrong: 300 mutations of good ones make a fabric or one sentence, never a traceback."""

import copy
import random
import warnings

import numpy as np
import pytest

from shellform.material.card import fabric_from_card, read_fabric
from shellform.material.fabric import Fabric, FabricError
from tests.material.test_measurements import LOOP, SUITING, without

KES = {
    "tensile_warp_N_per_m": 8100, "tensile_weft_N_per_m": 5000,
    "shear_N_per_m_per_radian": 54.4, "bending_warp_N_m": 1.33e-5, "bending_weft_N_m": 0.9e-5,
    "areal_mass_kg_per_m2": 0.2635, "thickness_m": 0.746e-3,
}  # fmt: skip
CURVES = without("EMT", "LT", "G_", "2HG", "B_warp", "2HB_warp") | LOOP | {
    "stretch_warp_percent": [0, 1, 3, 5], "load_warp_N_per_m": [0, 10, 60, 300.0],
    "unload_warp_N_per_m": [0, 5, 40, 300.0],
    "stretch_weft_percent": [0, 2, 5], "load_weft_N_per_m": [0, 20, 140.0],
    "curvature_warp_per_cm": [0, 1, 2.5], "moment_warp_gf_cm_per_cm": [0, 0.1, 0.2],
}  # fmt: skip
FAST = {
    "E5_warp_percent": 0.4, "E20_warp_percent": 1.2, "E100_warp_percent": 3.0,
    "E5_weft_percent": 0.5, "E20_weft_percent": 1.5, "E100_weft_percent": 4.0,
    "EB5_percent": 3.0, "bending_length_warp_mm": 17.2, "bending_length_weft_cm": 1.5,
    "weight_g_per_m2": 263.5, "thickness_mm": 0.7,
}  # fmt: skip
ISOTROPIC = {
    "youngs_modulus_Pa": 1e6, "poisson_ratio": 0.3, "thickness_m": 1e-3, "density_kg_per_m3": 300.0,
}  # fmt: skip
PLY = {
    "E1_Pa": 8e6, "E2_Pa": 5e6, "nu12": 0.2, "G12_Pa": 1e5, "G13_Pa": 2e5, "G23_Pa": 1.5e5,
    "density_kg_per_m3": 300.0, "thickness_m": 1e-3, "angle_degrees": 0,
}  # fmt: skip
GOOD = [
    {"name": "kes", "kes": KES},
    {"measured": SUITING},
    {"measured": SUITING | {"RT_warp_percent": 60.0}},
    {"measured": CURVES},
    {"measured": FAST},
    {"isotropic": ISOTROPIC, "law": "compressible-neo-hookean"},
    {"isotropic": ISOTROPIC, "law": {"kind": "fung", "stiffening_load_N_per_m": 40.0}},
    {"ply": [PLY, PLY | {"angle_degrees": 90}]},
]
WRONG = [
    None, True, "", "stiff", "0.1", [], {}, [[]], [1.0, "a"], [0.0, 1.0], float("nan"), {"a": 1},
    float("inf"), 0, -1, 1e-30, 1e30, 10**400,
]  # fmt: skip


def leaves(table, path=()):
    """Paths of all values of a card, tables and lists included."""
    entries = table.items() if isinstance(table, dict) else enumerate(table)
    for key, value in entries:
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from leaves(value, (*path, key))


def mutated(rng):
    """A card with one to three faults."""
    card = copy.deepcopy(rng.choice(GOOD))
    for _ in range(rng.choice([1, 1, 2, 3])):
        paths = list(leaves(card))
        if not paths:
            break
        *way, key = rng.choice(paths)
        at = card
        for step in way:
            at = at[step]
        kind = rng.randrange(7)
        if kind == 0:
            del at[key]
        elif kind == 1:
            at[key] = copy.deepcopy(rng.choice(WRONG))
        elif kind == 2 and isinstance(at[key], float):
            at[key] *= rng.choice([-1, 1e3, 1e-3, 98.0665, 0.5, 0])
        elif kind == 3 and isinstance(at[key], list):
            rng.shuffle(at[key])
        elif kind == 4 and isinstance(at, dict):
            at[rng.choice([str(key) + "_", str(key)[:-1], "gf", str(key).upper()])] = at.pop(key)
        elif kind == 5 and isinstance(at, dict):
            at[rng.choice([*SUITING, *CURVES, *FAST])] = rng.choice([1.0, [0, 1.0], 0.05])
        elif isinstance(at[key], list) and at[key]:
            at[key].append(rng.choice([at[key][-1], 0.0, "x"]))
    return card


def test_mutations_make_fabrics_or_sentences():
    rng, made, said = random.Random(14), 0, 0
    for _ in range(300):
        card = mutated(rng)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                fabric = fabric_from_card(card, "cloth.toml")
            except FabricError as error:
                words = str(error)
                assert words.startswith("cloth.toml") and "\n" not in words, (card, words)
                assert len(words) < 500, (card, words)
                said += 1
                continue
        assert isinstance(fabric, Fabric), card
        assert np.isfinite(fabric.membrane).all() and np.isfinite(fabric.bending).all(), card
        made += 1
    assert made > 30 and said > 150


def test_mutated_files(tmp_path):
    """Bytes of a file changed at random: the same."""
    lines = ["name = 'cloth'", "[measured]", *(f'"{k}" = {v}' for k, v in CURVES.items())]
    good, rng = "\n".join(lines).encode(), random.Random(3)
    path = tmp_path / "cloth.toml"
    for _ in range(100):
        data = bytearray(good)
        for _ in range(rng.choice([1, 2, 5])):
            data[rng.randrange(len(data))] = rng.choice(b"\x00\xff=[]\"'#.-e9 \n_g")
        path.write_bytes(bytes(data))
        try:
            read_fabric(path)
        except FabricError as error:
            assert str(error).startswith(str(path)) and "\n" not in str(error), bytes(data)


@pytest.mark.parametrize("card", GOOD)
def test_cards_that_are_mutated_are_good(card):
    assert isinstance(fabric_from_card(card), Fabric)
