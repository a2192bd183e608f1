# SPDX-License-Identifier: LGPL-3.0-or-later
"""Every public function and method says what it takes and gives, by type."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FILES = sorted(
    path.relative_to(ROOT).as_posix()
    for package in ("shellform", "contact", "meshes")
    for path in (ROOT / package).rglob("*.py")
)


def public_functions(tree):
    """Public functions of a file and public methods, `__init__` included, of its public classes."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            yield node, False
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            for part in node.body:
                if isinstance(part, ast.FunctionDef):
                    if part.name in ("__init__", "__call__") or not part.name.startswith("_"):
                        plain = any(ast.unparse(d) == "staticmethod" for d in part.decorator_list)
                        yield part, not plain


def untyped(function, bound):
    """Names of arguments without a hint, and 'return'."""
    given = function.args
    named = [*given.posonlyargs, *given.args][int(bound) :] + given.kwonlyargs
    named += [one for one in (given.vararg, given.kwarg) if one]
    missing = [one.arg for one in named if one.annotation is None]
    if function.returns is None and function.name != "__init__":
        missing.append("return")
    return missing


@pytest.mark.parametrize("file", FILES)
def test_public_functions_have_type_hints(file):
    lacking = {
        f"{function.name}, line {function.lineno}": missing
        for function, bound in public_functions(ast.parse((ROOT / file).read_text()))
        if (missing := untyped(function, bound))
    }
    assert not lacking
