"""What the reference is made of: docstrings name every parameter and every error."""

import ast
import dataclasses
import inspect
import re
from pathlib import Path

import pytest

import exudyn_inext
from docs.extensions.docstrings import items, sections

FOLDERS = (
    "element",
    "cable",
    "constraints",
    "loads",
    "integrators",
    "statics",
    "scene",
    "run",
    "items",
    "native",
    "advice",
    "exudyn_binding",
)


def public_functions():
    """(folder, name, AST node) of all public functions and classes in the source, and methods of these."""
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, DEFINITIONS) and not node.name.startswith("_"):
                name = f"{path.relative_to(PACKAGE).with_suffix('')}.{node.name}"
                yield path.relative_to(PACKAGE).parts[0], name, node
                for method in node.body if isinstance(node, ast.ClassDef) else ():
                    if isinstance(method, ast.FunctionDef) and not method.name.startswith("_"):
                        yield path.relative_to(PACKAGE).parts[0], f"{name}.{method.name}", method


PACKAGE = Path(exudyn_inext.__file__).parent
DEFINITIONS = ast.FunctionDef | ast.ClassDef
PUBLIC = list(public_functions())


def own_nodes(function):
    """AST nodes of a function's body, without those of functions within it."""
    todo = list(function.body)
    while todo:
        node = todo.pop()
        yield node
        if not isinstance(node, ast.FunctionDef | ast.Lambda | ast.ClassDef):
            todo.extend(ast.iter_child_nodes(node))


def raised(function):
    """Names of the errors that a function raises itself."""
    calls = [node.exc for node in own_nodes(function) if isinstance(node, ast.Raise) and node.exc]
    names = [call.func.id for call in calls if isinstance(call, ast.Call) and isinstance(call.func, ast.Name)]
    return {name for name in names if name.endswith("Error")}


def implements_a_protocol(node):
    """Whether it is registered by a decorator that names the protocol, which describes it."""
    calls = [ast.unparse(one.func) for one in node.decorator_list if isinstance(one, ast.Call)]
    return any(call in ("implements", "calls", "by_address") or call.endswith(".register") for call in calls)


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_public_function_and_class_has_a_docstring_or_implements_a_protocol(folder):
    mine = [(name, node) for where, name, node in PUBLIC if where == folder]
    assert len(mine) > 2
    bare = [
        name
        for name, node in mine
        if name.count(".") == 1 and not (ast.get_docstring(node) or implements_a_protocol(node))
    ]
    assert bare == []


def test_every_error_that_a_public_function_raises_is_in_its_docstring():
    missing = [
        (name, error)
        for _, name, node in PUBLIC
        if isinstance(node, ast.FunctionDef)
        for error in raised(node)
        if error not in (ast.get_docstring(node) or "")
    ]
    assert missing == []


def described(text):
    """Names of the parameters that a docstring describes."""
    lines = inspect.cleandoc(text).splitlines()
    named = {name for _, body in sections(lines) for name, _ in items(body)}
    return named | set(re.findall(r"\b([A-Za-z_]\w*)(?=: )", text))


def parameters(thing):
    """What a user may give."""
    if inspect.isclass(thing) and issubclass(thing, BaseException):
        return []
    if dataclasses.is_dataclass(thing):
        return [field.name for field in dataclasses.fields(thing) if field.init]
    return [name for name in inspect.signature(thing).parameters if name != "self"]


@pytest.mark.parametrize("name", exudyn_inext.__all__)
def test_everything_offered_has_a_docstring_that_describes_each_parameter(name):
    thing = getattr(exudyn_inext, name)
    text = inspect.getdoc(thing)
    assert text
    assert set(parameters(thing)) - described(text) - {"name"} == set()
    if inspect.isfunction(thing) and name != "WarnOfExplicitTraps":
        assert "Raises:" in text
    if inspect.isfunction(thing) and inspect.signature(thing).return_annotation is not None:
        assert "Returns:" in text


@pytest.mark.parametrize("name", exudyn_inext.__all__)
def test_errors_and_names_in_docstrings_exist(name):
    text = inspect.cleandoc(getattr(exudyn_inext, name).__doc__)
    for header, body in sections(text.splitlines()):
        if header == "Raises":
            for error, _ in items(body):
                assert error in exudyn_inext.__all__
