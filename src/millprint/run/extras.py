"""One line for a package that is not installed because it belongs to an extra of millprint."""

import sys
from types import TracebackType

# The modules of each extra's packages in pyproject.toml.
EXTRAS = {
    "thesis": ("hyperopt", "molmass", "shap", "xgboost"),
    "surrogate": ("torch",),
    "dev": ("nbclient", "nbformat", "vtkmodules"),
    "docs": ("latex2mathml", "sphinx"),
}


def explain_extras() -> None:
    """From now on, a program that ends for want of a package of an extra says so in one line that names the extra."""
    before = sys.excepthook

    def show(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        name = error.name if isinstance(error, ModuleNotFoundError) else None
        extra = next((extra for extra, modules in EXTRAS.items() if name in modules), None)
        if extra is None:
            before(kind, error, trace)
        else:
            print(
                f"error: no package {name}, which belongs to the extra `{extra}`: pip install 'millprint[{extra}]', or "
                f"pip install '.[{extra}]' in a clone",
                file=sys.stderr,
            )

    sys.excepthook = show
