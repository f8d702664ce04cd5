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


def meaning_of(model: type[BaseModel], key: str) -> str:
    """The docstring of a key, of the nearest class that has one, or the description of its type; empty without any."""
    classes = [each for each in model.__mro__ if issubclass(each, BaseModel) and each is not BaseModel]
    own = next((docs[key] for docs in map(_docstrings, classes) if key in docs), None)
    return own or model.model_fields[key].description or ""
