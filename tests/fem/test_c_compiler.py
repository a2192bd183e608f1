# SPDX-License-Identifier: LGPL-3.0-or-later
"""A failed compile is one sentence that says what is missing; what is none comes out as it is."""

import sysconfig

import cffi
import pytest

from shellform.errors import CompilerError
from shellform.fem.c_compiler import failures_as_sentences

# as dolfinx 0.5 to 0.11, FFCx and cffi say it
FAILURES = [
    cffi.VerificationError("CompileError: command '/usr/bin/gcc' failed with exit code 1"),
    OSError(28, "No space left on device"),
    TimeoutError("JIT compilation timed out, probably due to a failed previous compile."),
    RuntimeError("Failed just-in-time compilation of form: CompileError"),
    RuntimeError("Failed JIT compilation of form: CompileError"),
    RuntimeError("JIT compilation failed on rank 0."),
]


def said(error, folder):
    with pytest.raises(CompilerError) as caught, failures_as_sentences(folder):
        raise error
    return str(caught.value)


@pytest.mark.parametrize("error", FAILURES, ids=lambda error: str(error)[:20])
def test_what_is_missing_is_said(error, tmp_path, monkeypatch):
    last = str(error).splitlines()[-1]
    assert said(error, tmp_path).endswith(f"were not compiled into {tmp_path}: {last}")
    (tmp_path / "file").touch()
    assert "cannot be written to" in said(error, tmp_path / "file" / "below")
    with monkeypatch.context() as patch:
        patch.setattr(sysconfig, "get_path", lambda _: str(tmp_path))
        assert said(error, tmp_path).startswith("no Python.h")
    monkeypatch.setenv("CC", "no-such-compiler")
    assert said(error, tmp_path).startswith("no C compiler: 'no-such-compiler'")


@pytest.mark.parametrize("error", [RuntimeError("edges of the mesh"), ValueError("a form of UFL")])
def test_other_errors_come_out_as_they_are(error, tmp_path):
    with pytest.raises(type(error)) as caught, failures_as_sentences(tmp_path):
        raise error
    assert caught.value is error
