"""Changes the code in one place at a time, and lists the changes that no test notices: python tools/mutants.py dose.

Each mutant has another operator, constant, comparison or function (`mutations`) in a copy of the project. Of the tests
of its part, those files run that call its function, in a fork of this process, which has imported the libraries: the
fast ones first, and the slow ones if these pass.
"""

import argparse
import ast
import contextlib
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

ROOT = Path(__file__).parents[1]
# Of each part of the library, its files and the tests that concern them.
PARTS = {
    "estimate": (["estimate/*.py"],
                 ["unit/test_estimate.py", "unit/test_intervals.py", "unit/test_turns.py", "unit/test_quantiles.py",
                  "unit/test_claims.py", "unit/test_own_power.py", "unit/test_gaussian_process.py",
                  "unit/test_yield_averaging.py"]),
    "uncertainty": (["uncertainty/*.py", "fingerprint/bands.py", "fingerprint/coverage.py"],
                    ["unit/test_uncertainty.py", "unit/test_fingerprint_[bcm]*.py", "unit/test_contact_intervals.py",
                     "unit/test_intervals.py", "unit/test_uncertain_shape.py", "unit/test_emulator.py",
                     "unit/test_rows.py"]),
    "observables": (["observables/*.py", "fingerprint/descriptors.py", "fingerprint/predicted_values.py"],
                    ["unit/test_fingerprint_[bcdm]*.py", "unit/test_turns.py", "unit/test_dem_collisions.py",
                     "unit/test_conditions.py", "unit/test_sheets.py"]),
    "dose": (["dose/*.py"], ["unit/test_dose_*.py", "unit/test_heat.py", "physics/test_heat.py", "physics/test_wear.py",
             "unit/test_own_power.py", "unit/test_sheets.py"]),
    "yields": (["thesis/yields/*.py"], ["unit/test_yield_*.py"]),
    "doe": (["thesis/doe/*.py", "thesis/regimes.py", "thesis/scaling.py"],
            ["unit/test_doe_*.py", "unit/test_partition.py", "unit/test_fingerprint_[cdi]*.py",
             "unit/test_intervals.py", "unit/test_convergence.py", "unit/test_fit.py", "unit/test_dose_wear.py"]),
    "counting": (["dem/collisions.py", "dem/ledger.py", "dem/run.py"],
                 ["unit/test_dem_collisions.py", "unit/test_turns.py", "unit/test_dem_records.py",
                  "unit/test_dose_spectra.py", "unit/test_mixtures.py", "physics/test_balance.py"]),
    "kernel": (["dem/law.py", "dem/laws/[hl]*.py"],
               ["unit/test_contact_laws.py", "physics/test_drop.py", "physics/test_impacts.py",
                "physics/test_contact_cases.py", "physics/test_cohesion.py", "physics/test_over_speed.py"]),
}  # fmt: skip
LIBRARIES = ("numpy", "pandas", "scipy.stats", "scipy.optimize", "numba", "h5py", "sklearn.gaussian_process",
             "pydantic", "statsmodels.api", "yaml", "trimesh", "matplotlib.pyplot", "snakemake.utils")  # fmt: skip
OPERATORS = {ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*"), ast.Pow: ("**", "*")}
COMPARED = {ast.Lt: ("<", ">="), ast.LtE: ("<=", ">"), ast.Gt: (">", "<="), ast.GtE: (">=", "<"), ast.Eq: ("==", "!=")}
PAIRS = (("min", "max"), ("fmin", "fmax"), ("minimum", "maximum"), ("argmin", "argmax"), ("mean", "sum"),
         ("any", "all"), ("floor", "ceil"), ("sin", "cos"), ("sqrt", ""), ("exp", "abs"))  # fmt: skip
CALLED = {one: other for pair in PAIRS for one, other in (pair, pair[::-1]) if one}
# What a person reads, and what is only looked at.
LEFT_OUT = (ast.JoinedStr, ast.Raise, ast.Assert, ast.AnnAssign)
# Of processor time [s]: a mutant that never ends is found too.
LONGEST_S = 240


class Mutant(NamedTuple):
    """Bytes of a file, from `start` to `end`, and what takes their place; within: where its function begins, or 0."""

    file: Path
    within: int
    line: int
    start: int
    end: int
    new: bytes

    def text(self) -> str:
        """The line before and after."""
        content = self.file.read_bytes()
        begin, stop = content.rfind(b"\n", 0, self.start) + 1, content.find(b"\n", self.end)
        changed = content[begin : self.start] + self.new + content[self.end : stop]
        return f"{content[begin:stop].decode().strip()}  ->  {changed.decode().strip()}"


def mutations(file: Path) -> Iterator[Mutant]:
    """All mutants of a file."""
    content = file.read_bytes()
    begins = [0, *(place + 1 for place, byte in enumerate(content) if byte == 10)]

    def at(node: Any) -> tuple[int, int]:
        return begins[node.lineno - 1] + node.col_offset, begins[node.end_lineno - 1] + node.end_col_offset

    def between(one: Any, other: Any, old: str, new: str) -> Iterator[Mutant]:
        low, high = at(one)[1], at(other)[0]
        place = content.find(old.encode(), low, high)
        yield Mutant(file, within[-1], one.end_lineno, place, place + len(old), new.encode())

    def visit(node: Any) -> Iterator[Mutant]:
        if isinstance(node, LEFT_OUT) or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)):
            return
        if (
            isinstance(node, ast.BinOp)
            and type(node.op) in OPERATORS
            and not isinstance(node.left, ast.Constant | ast.JoinedStr)
        ):
            yield from between(node.left, node.right, *OPERATORS[type(node.op)])
        elif isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in COMPARED:
            yield from between(node.left, node.comparators[0], *COMPARED[type(node.ops[0])])
        elif isinstance(node, ast.Constant) and type(value := node.value) in (int, float):
            new: Any = value + 1 if isinstance(value, int) else float(repr(value)) * 1.5 or 1.0
            yield Mutant(file, within[-1], node.lineno, *at(node), repr(new).encode())
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
            start = at(node)[0]
            yield Mutant(file, within[-1], node.lineno, start, start + (1 if isinstance(node.op, ast.USub) else 4), b"")
        elif isinstance(node, ast.Call):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if name in CALLED and (CALLED[name] or node.args):
                stop = at(node.func)[1]
                start = stop - len(name) if CALLED[name] else at(node.func)[0]
                yield Mutant(file, within[-1], node.lineno, start, stop, CALLED[name].encode())
        if is_function := isinstance(node, ast.FunctionDef):
            within.append(min(each.lineno for each in (node, *node.decorator_list)))
        skipped = [getattr(node, name, None) for name in ("annotation", "returns", "decorator_list")]
        for name, inner in ast.iter_fields(node):
            if inner not in skipped or name == "body":
                for child in inner if isinstance(inner, list) else [inner]:
                    if isinstance(child, ast.AST):
                        yield from visit(child)
        del within[len(within) - is_function :]

    within = [0]
    yield from visit(ast.parse(content))


class Called:
    """Notes which functions the tests of a file call, by their file and first line, each once in a row of `path`."""

    def __init__(self, folder: Path, path: Path) -> None:
        self.library, self.path = str(folder / "src"), path

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Watch one test with its fixtures."""
        found = set()

        def watch(frame: Any, event: str, argument: Any) -> None:
            if frame.f_code.co_filename.startswith(self.library):
                found.add((frame.f_code.co_filename, frame.f_code.co_firstlineno))

        sys.setprofile(watch)
        yield
        sys.setprofile(None)
        with self.path.open("a") as file:
            file.writelines(f"{item.location[0]}\t{name}\t{line}\n" for name, line in found)


def passes(folder: Path, tests: list[str], called: Path | None = None) -> bool:
    """Whether the tests pass in a copy of the project, in a process of its own; called: a file for `Called`."""
    for marked in ("not slow and not browser", "slow and not browser"):
        if (child := os.fork()) == 0:
            resource.setrlimit(resource.RLIMIT_CPU, (LONGEST_S, LONGEST_S))
            os.chdir(folder)
            for name in [name for name in sys.modules if name.split(".")[0] in ("tests", "millprint", "tools")]:
                del sys.modules[name]
            sys.path[:] = [str(folder), *(path for path in sys.path if not path.startswith(str(ROOT / "src")) and path)]
            with (
                open(os.devnull, "w") as nothing,
                contextlib.redirect_stdout(nothing),
                contextlib.redirect_stderr(nothing),
            ):
                watched = [Called(folder, called)] if called else []
                os._exit(pytest.main(["-x", "-q", "-p", "no:cacheprovider", "-m", marked, *tests], watched))
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        if status not in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED):
            return False
    return True


def main() -> int:
    """Try mutants of some parts, drawn at random, and print those that no test notices."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="+", choices=PARTS, help="parts of the library")
    parser.add_argument("--count", type=int, default=20, help="number of mutants of each part")
    parser.add_argument("--seed", type=int, default=0, help="of the draw")
    given, folder = parser.parse_args(), Path(tempfile.mkdtemp(prefix="mutants"))
    tried, survived = Counter[str](), Counter[str]()
    for name in subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split(
        "\n"
    ):
        if name and (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
    for library in LIBRARIES:
        __import__(library)
    for part in given.parts:
        files, patterns = PARTS[part]
        tests = [str(path.relative_to(folder)) for each in patterns for path in sorted((folder / "tests").glob(each))]
        every = [
            each for one in files for file in sorted((folder / "src/millprint").glob(one)) for each in mutations(file)
        ]
        print(f"{part}: {len(every)} mutants, {len(tests)} files of tests", flush=True)
        called = folder / f"called_{part}"
        assert passes(folder, tests, called), f"{part}: the tests do not pass as they are"
        callers: dict[tuple[str, str], set[str]] = defaultdict(set)
        for line in called.read_text().splitlines():
            test, *function = line.split("\t")
            callers[tuple(function)].add(test)
        for number, mutant in enumerate(random.Random(given.seed).sample(every, min(given.count, len(every)))):
            content, text = mutant.file.read_bytes(), mutant.text()
            mutant.file.write_bytes(content[: mutant.start] + mutant.new + content[mutant.end :])
            # Python compares the date of what it has compiled with that of the source, in seconds.
            os.utime(mutant.file, (10_000 + number,) * 2)
            # Compiled kernels, and what is outside of functions, are not seen to be called.
            own = callers.get((str(mutant.file), str(mutant.within)), set(tests))
            survives = passes(folder, sorted(own, key=tests.index))
            mutant.file.write_bytes(content)
            tried[part] += 1
            survived[part] += survives
            if survives:
                print(f"  {mutant.file.relative_to(folder / 'src/millprint')}:{mutant.line}: {text}", flush=True)
        print(f"  {survived[part]} of {tried[part]} survive", flush=True)
    print(f"{survived.total()} of {tried.total()} mutants survive")
    return 0


if __name__ == "__main__":
    sys.exit(main())
