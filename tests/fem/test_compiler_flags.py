# SPDX-License-Identifier: LGPL-3.0-or-later
"""The flags of the C compiler: set from outside, and never one cache entry for two of them."""

import pytest

import ufl

import meshes
from shellform import Fabric, Shell
from shellform.fem import dolfinx_compat
from shellform.fem.c_compiler import compiler_flags, form_flags
from shellform.fem.dolfinx_compat import Constant, compiled
from shellform.fem.internal_force import InternalForce

PLAIN = {"SHELLFORM_CFLAGS": "-march=x86-64-v2 -mtune=generic"}


def test_the_processor_is_replaced_and_nothing_else():
    native, plain, none = (compiler_flags(e) for e in ({}, PLAIN, {"SHELLFORM_CFLAGS": ""}))
    assert [flag for flag in native if flag not in none] == ["-march=native"]
    assert [flag for flag in plain if flag not in none] == ["-march=x86-64-v2", "-mtune=generic"]
    assert {*none} < {*native} and {*none} < {*plain}


def test_flags_that_are_none_are_refused():
    with pytest.raises(ValueError, match="SHELLFORM_CFLAGS is 'x86-64-v2': give flags"):
        compiler_flags({"SHELLFORM_CFLAGS": "x86-64-v2"})


def test_internal_forces_are_compiled_with_them(monkeypatch):
    surface = meshes.rectangle(1.0, 1.0, (1, 1), triangles=True)
    shell = Shell(surface, Fabric.isotropic(1e6, 0.3, 1e-3, 200.0))
    monkeypatch.setenv("SHELLFORM_CFLAGS", "neither")
    with pytest.raises(ValueError, match="SHELLFORM_CFLAGS"):
        InternalForce(shell)


def test_other_flags_have_a_cache_entry_of_their_own(comm, shared_tmp_path):
    """What is compiled for one processor is never loaded for another."""
    mesh = Shell(meshes.rectangle(1.0, 1.0, (1, 1)), Fabric.isotropic(1e6, 0.3, 1e-3, 200.0)).mesh
    form, counts = Constant(mesh, 2.0) * ufl.dx(mesh), []
    for flags in (["-O0"], ["-O0", "-g0"], ["-O0"]):
        compiled([(form,)], cffi_extra_compile_args=flags, cache_dir=str(shared_tmp_path))
        comm.Barrier()
        counts.append(len(list(shared_tmp_path.glob("*.so"))))
        comm.Barrier()
    assert counts == [1, 2, 2]


def test_flags_of_forms():
    """FFCx's own unless there are others, which forms are then compiled with."""
    assert form_flags({}) is None and form_flags({"SHELLFORM_FORM_CFLAGS": ""}) is None
    assert form_flags({"SHELLFORM_FORM_CFLAGS": "-O0 -g0"}) == ["-O0", "-g0"]
    with pytest.raises(ValueError, match="SHELLFORM_FORM_CFLAGS is 'O0': give flags"):
        form_flags({"SHELLFORM_FORM_CFLAGS": "O0"})


def test_forms_are_compiled_with_their_flags(monkeypatch):
    seen = []
    monkeypatch.setenv("SHELLFORM_FORM_CFLAGS", "-O1 -g0")
    monkeypatch.setattr(
        dolfinx_compat.fem, "form", lambda form, **options: seen.append(options) or "compiled"
    )

    class Form:
        def signature(self):
            return "one"

        def ufl_domain(self):
            return self

        def ufl_cargo(self):
            return self

        comm = None

    assert dolfinx_compat.compiled([(Form(),)]) == [("compiled",)]
    ((options,),) = [one.values() for one in seen]
    assert options["cffi_extra_compile_args"] == ["-O1", "-g0"]
