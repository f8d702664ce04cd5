"""Functions that only kernels may call are called by kernels only: from Python they end the process silently."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2]
LIBRARY = ROOT / "scripts"
COMPILED = {"kernel", "inner", "inlined", "threaded", "array_maker"}


def decorator(node: ast.AST) -> str | None:
    """The maker of a compiled function."""
    for found in getattr(node, "decorator_list", []):
        name = getattr(getattr(found, "func", None), "id", None)
        if name in COMPILED:
            return name
    return None


def module_of(file: Path) -> str:
    folder = LIBRARY if file.is_relative_to(LIBRARY) else ROOT
    return ".".join(file.relative_to(folder).with_suffix("").parts)


TREES = {file: ast.parse(file.read_text()) for place in ("scripts", "tests") for file in (ROOT / place).rglob("*.py")}
INNER = {
    (module_of(file), node.name)
    for file, tree in TREES.items()
    for node in tree.body
    if isinstance(node, ast.FunctionDef) and decorator(node) in ("inner", "inlined")
}


def calls_from_python(tree: ast.Module, module: str, inner: set[tuple[str, str]]) -> list[str]:
    """Calls of such functions outside of compiled ones, with their lines."""
    known = {name: (module, name) for name in (name for place, name in inner if place == module)}
    packages = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                known[alias.asname or alias.name] = (node.module or "", alias.name)
                packages[alias.asname or alias.name] = f"{node.module}.{alias.name}"
    found = []

    def visit(node: ast.AST) -> None:
        for child in ast.iter_child_nodes(node):
            if decorator(child):
                continue
            if isinstance(child, ast.Call):
                called = child.func
                if isinstance(called, ast.Name) and known.get(called.id) in inner:
                    found.append(f"line {child.lineno}: {called.id}")
                owner = called.value if isinstance(called, ast.Attribute) else None
                if isinstance(owner, ast.Name) and (packages.get(owner.id), called.attr) in inner:
                    found.append(f"line {child.lineno}: {called.attr}")
            visit(child)

    visit(tree)
    return found


def test_python_calls_nothing_that_only_kernels_may_call():
    found = {str(file): calls_from_python(tree, module_of(file), INNER) for file, tree in TREES.items()}
    assert {file: calls for file, calls in found.items() if calls} == {}


def test_such_a_call_would_be_found():
    assert ("millprint.mill.walls", "touch") in INNER
    calls = "from millprint.mill.walls import touch\nfrom millprint.dem import lanes\ntouch(1)\nlanes.get(1)\n"
    assert calls_from_python(ast.parse(calls), "a", INNER) == ["line 3: touch", "line 4: get"]
