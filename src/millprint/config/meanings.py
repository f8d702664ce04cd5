"""What each key of a section means: the docstring under it in the class.

Only references, schemas and `--help` show it. pydantic would read the source of every class whenever it is imported, in
every job.
"""

import ast
import inspect
import textwrap
from functools import cache

from pydantic import BaseModel


@cache
def _docstrings(model: type[BaseModel]) -> dict[str, str]:
    """The docstrings under the keys that this class defines itself."""
    (own,) = ast.parse(textwrap.dedent(inspect.getsource(model))).body
    assert isinstance(own, ast.ClassDef)
    found = {}
    for key, text in zip(own.body, own.body[1:], strict=False):
        value = text.value.value if isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant) else None
        if isinstance(key, ast.AnnAssign) and isinstance(key.target, ast.Name) and isinstance(value, str):
            found[key.target.id] = inspect.cleandoc(value)
    return found


def source_of_meaning(model: type[BaseModel], key: str) -> type[BaseModel]:
    """The nearest class that has a docstring for a key; without any, the one that is the first to have the key."""
    classes = [each for each in model.__mro__ if issubclass(each, BaseModel) and key in each.model_fields]
    return next((each for each in classes if key in _docstrings(each)), classes[-1])


def meaning_of(model: type[BaseModel], key: str) -> str:
    """The docstring of a key, of the nearest class that has one, or the description of its type; empty without any."""
    return _docstrings(source_of_meaning(model, key)).get(key) or model.model_fields[key].description or ""
