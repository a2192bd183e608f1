# SPDX-License-Identifier: LGPL-3.0-or-later
"""Compiled kernels whose cache on disk is keyed by what they compute, not by when a file was saved.

Numba keeps machine code beside the sources and takes it as fresh while the file of the outermost
function is untouched, although code of all functions it calls, and the constants they read, is
inside. Here the name of a cache file is a hash of all that: byte code, constants, options and
globals of the kernel and of every kernel it calls. A change anywhere gives another name; programs
with other constants have files of their own and coexist.

One file holds one kernel for one signature. It is written under another name and then moved, so
ranks that compile at once replace it by the same thing. Old versions stay until the folder is
emptied (`make clean`). Not kept are kernels that get kernels as arguments (a closure over one is),
and those that use what `numba.vectorize` and `jitclass` made.
"""

import enum
import hashlib
import os
import pickle
import re
import sys
import uuid
import weakref
from collections.abc import Callable
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core import caching, serialize
from numba.core.errors import NumbaError as NumbaError  # of a kernel that does not compile
from numba.core.options import DefaultOptions
from numba.core.sigutils import normalize_signature
from numba.extending import is_jitted

LIBRARIES = ("numpy", "numba", "math", "cmath", "builtins")  # known by their versions
PLAIN = bool, int, float, complex, str, bytes, slice, range
SETTINGS = ("OPT", "BOUNDSCHECK", "LOOP_VECTORIZE", "SLP_VECTORIZE", "DEBUGINFO_DEFAULT")
_first: weakref.WeakKeyDictionary = (
    weakref.WeakKeyDictionary()
)  # function -> its content when first looked at


class Unknown(Exception):
    """A global whose content cannot be told: the kernel is compiled anew in each process."""


def kernel(function: Callable | None = None, makes_arrays: bool = True, **options: Any) -> Any:
    """Compile with numba when first called; division as in numpy unless `options` say otherwise.

    Use as `@kernel` or with options of `numba.njit`: `@kernel(fastmath={"contract"})`.

    makes_arrays : False for a kernel that makes none, nor copies slices: numba then counts no
        references to those it gets. Older versions find most counts to be needless by themselves;
        under 0.68 contact takes up to twice as long with them.
    """
    if function is None:
        return lambda function: kernel(function, makes_arrays, **options)
    if not makes_arrays and hasattr(DefaultOptions, "_nrt"):  # numba's own name, 0.56 to 0.68
        options["_nrt"] = False
    dispatcher = numba.njit(**{"error_model": "numpy"} | options)(function)
    # with NUMBA_DISABLE_JIT a plain function; `_cache` is numba's own name (0.56 to 0.68), and
    # should it go, kernels are compiled in each process
    if is_jitted(dispatcher) and "_cache" in vars(dispatcher):
        dispatcher._cache = ContentCache(dispatcher)
    return dispatcher


def fingerprint(dispatcher: Any) -> str:
    """Hash of all that decides what a kernel computes, that of the kernels it calls included.

    Raises
    ------
    Unknown
        Where a global is of a kind not followed, or was changed since some kernel was compiled:
        numba keeps the old value in the code it has.
    """
    reached, contents, at = [dispatcher], [], 0
    calls: list[Any]
    while at < len(reached):
        function, calls = reached[at], []
        own = repr(_content(function, calls)).encode()
        if _first.setdefault(function, own) != own:
            raise Unknown(f"{function} or a constant it reads was changed while it runs")
        new = [f for i, f in enumerate(calls) if f not in reached and f not in calls[:i]]
        reached += new
        contents.append((hashlib.sha256(own).digest(), [reached.index(f) for f in calls]))
        at += 1
    settings = [getattr(numba.config, name, None) for name in SETTINGS]
    versions = sys.implementation.cache_tag, numba.__version__, llvmlite.__version__, np.__version__
    return hashlib.sha256(repr((versions, settings, contents)).encode()).hexdigest()


def _content(function, calls):
    """Nested tuples of what a function or kernel is by itself; functions it calls join `calls`."""
    options = ()
    if is_jitted(function):
        options = _value(function.targetoptions, (), calls)
        function = function.py_func
    names, code = _code(function.__code__, function.__doc__)
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    free = [(n, function.__globals__[n]) for n in names if n in function.__globals__]
    given = [*cells, function.__defaults__, function.__kwdefaults__]
    return (
        options, code,
        [(name, _value(value, names, calls)) for name, value in free],
        [_value(value, names, calls) for value in given],
    )  # fmt: skip


def _code(code, doc=None):
    """Names that a code object looks up, those of code inside it too, and its instructions.

    Line numbers, file names and the text of documentation do not matter.
    """
    names, constants = list(code.co_names), []
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            inner, constant = _code(constant)
            names += inner
        elif doc is not None and constant is doc:
            constant = None
        constants.append(_value(constant, (), []))
    own = code.co_code, code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars
    counts = code.co_flags, code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount
    return names, (*own, *counts, getattr(code, "co_exceptiontable", b""), constants)


def _value(value, names, calls):
    """What a global, an option or a constant is, such that equal texts mean equal values.

    names : those that may be attributes of modules; calls : list that functions are added to
    """
    kind = type(value)
    if isinstance(value, enum.Enum):
        return kind.__qualname__, value.name, _value(value.value, names, calls)
    if value is None or value is ... or isinstance(value, PLAIN):
        return kind.__name__, repr(value)
    if isinstance(value, np.dtype):
        return "dtype", repr(value), value.itemsize, value.alignment
    if isinstance(value, np.ndarray | np.generic):
        where = () if kind is np.ndarray else (kind.__name__,)
        data = np.asarray(value)
        if data.dtype.hasobject:
            raise Unknown("an array of objects")
        shape = _value(data.dtype, names, calls), data.shape, data.flags.c_contiguous
        return "array", *where, *shape, hashlib.sha256(data.tobytes()).digest()
    if isinstance(value, tuple | list):
        return kind.__qualname__, [_value(item, names, calls) for item in value]
    if isinstance(value, set | frozenset | dict):
        items = value.items() if isinstance(value, dict) else value
        return kind.__name__, sorted(repr(_value(item, names, calls)) for item in items)
    if isinstance(value, ModuleType):
        return _module(value, names, calls)
    if is_jitted(value) or (isinstance(value, FunctionType) and not _of_library(value)):
        calls.append(value)  # a plain function may be known to numba by an overload
        return "calls", len(calls)
    if isinstance(value, type):
        if issubclass(value, enum.Enum):
            return value.__qualname__, [_value(member, (), calls) for member in value]
        kin = *kind.__mro__, *value.__mro__
        if not _of_library(value) and any(_of_library(c, "numba") for c in kin):
            raise Unknown(f"{value} is compiled by other means")
        return "class", value.__module__, value.__qualname__, getattr(value, "_fields", ())
    if isinstance(value, numba.types.Type):
        return "type", repr(value)
    if _of_library(kind, "numba"):
        raise Unknown(f"{value} is compiled by other means")
    # ufuncs and built-in functions go by name; of other objects numba makes no constants
    return kind.__qualname__, getattr(value, "__module__", ""), getattr(value, "__name__", "")


def _of_library(value, *libraries):
    return (getattr(value, "__module__", None) or "").partition(".")[0] in (libraries or LIBRARIES)


def _module(module, names, calls):
    """A module by its name, and by those of its values that the code may look up."""
    if module.__name__.partition(".")[0] in LIBRARIES:
        return "module", module.__name__
    found, held = [], vars(module)
    for name in dict.fromkeys(names):
        if name in held:
            others = [n for n in names if n != name]  # fewer each time: modules may hold each other
            found.append((name, _value(held[name], others, calls)))
    return "module", module.__name__, found


class ContentCache:
    """The cache of one kernel, with the methods that numba calls; nothing is done before the first.

    Numba's own parts find the folder (`NUMBA_CACHE_DIR`, beside the source, the user's) and turn
    machine code into bytes and back.
    """

    def __init__(self, dispatcher: Any):
        self._dispatcher = dispatcher
        self._qualname = dispatcher.py_func.__qualname__
        name = f"{dispatcher.py_func.__module__}.{self._qualname}"
        self._name = re.sub(r"[^\w.]", "", name)

    @cached_property
    def _numba(self):
        try:
            return caching.CompileResultCacheImpl(self._dispatcher.py_func)
        except RuntimeError:  # no folder can be written to
            return None

    @property
    def cache_path(self) -> str | None:
        return self._numba and self._numba.locator.get_cache_path()

    def _place(self, signature, codegen):
        """File of a signature on this processor, and what must stand in it; None if not kept."""
        arguments = normalize_signature(signature)[0]
        if self._numba is None or any(isinstance(a, numba.types.Callable) for a in arguments):
            return None  # a kernel given as an argument is another object in each process
        try:
            content = fingerprint(self._dispatcher)
        except Unknown:
            return None
        key = content, arguments, codegen.magic_tuple()
        short = hashlib.sha256(repr(key).encode()).hexdigest()[:24]
        return Path(self.cache_path, f"{self._name}-{short}.nbc"), key

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Machine code for a signature, None if there is none."""
        context.refresh()
        place = self._place(signature, context.codegen())
        if place is None:
            return None
        path, key = place
        function = self._dispatcher.py_func
        if function.__closure__:
            # Numba names machine code by this and links by name: closures of one function over
            # other values, loaded from files of different processes, would be taken for another.
            function.__qualname__ = f"{self._qualname}_{key[0][:16]}"
        try:
            found, code = pickle.loads(path.read_bytes())
        except (OSError, EOFError, pickle.UnpicklingError):  # none, or cut short by a power cut
            return None
        except (AttributeError, ImportError):  # of a class that another version had elsewhere
            return None
        return self._numba.rebuild(context, code) if found == key else None

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Keep machine code; a full or vanished disk costs no more than the next compilation."""
        place = self._place(signature, compiled.codegen)
        if place is None or not self._numba.check_cachable(compiled):
            return
        path, key = place
        written = path.with_suffix(f".{uuid.uuid4().hex[:12]}.tmp")
        data = serialize.dumps((key, self._numba.reduce(compiled)))
        try:
            self._numba.locator.ensure_cache_path()
            written.write_bytes(data)
            os.replace(written, path)
        except OSError:
            with suppress(OSError):
                written.unlink()

    def flush(self) -> None:
        """Forget all versions, as `recompile` of numba wants."""
        for path in Path(self.cache_path or ".").glob(f"{self._name}-*.nbc"):
            path.unlink(missing_ok=True)
