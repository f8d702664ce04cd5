"""One line for a package that is not installed because it belongs to an extra of millprint."""

import sys
from collections.abc import Sequence
from types import ModuleType, TracebackType

from millprint.config.errors import MillprintError

# The modules of each extra's packages in pyproject.toml.
EXTRAS = {
    "thesis": ("hyperopt", "molmass", "shap", "xgboost"),
    "surrogate": ("torch", "torch_geometric"),
    "dev": ("nbclient", "nbformat", "vtkmodules"),
    "docs": ("latex2mathml", "sphinx"),
}


class MissingExtra(MillprintError, ModuleNotFoundError):
    """A package of an extra is not installed."""


class _Extras:
    """The last finder of modules: asked for those that no other finder has."""

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> None:
        extra = next((extra for extra, modules in EXTRAS.items() if name in modules), None)
        if extra and not _only_asked():
            error = MissingExtra(
                f"no package {name}, which belongs to the extra `{extra}`: pip install 'millprint[{extra}]', or "
                f"pip install '.[{extra}]' in a clone"
            )
            error.name = name
            raise error


def _only_asked() -> bool:
    """Whether `importlib.util.find_spec` asks if the module is there, and nothing imports it."""
    frame = sys._getframe(2)
    while frame.f_back and frame.f_globals["__name__"].startswith("importlib._bootstrap"):
        frame = frame.f_back
    return frame.f_globals["__name__"] == "importlib.util"


def explain_extras() -> None:
    """From now on, the import of a missing package names its extra; at the end of a program, in one line."""
    if _Extras in sys.meta_path:
        return
    sys.meta_path.append(_Extras)
    before = sys.excepthook

    def show(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        if isinstance(error, MissingExtra):
            print(f"error: {error}", file=sys.stderr)
        else:
            before(kind, error, trace)

    sys.excepthook = show
