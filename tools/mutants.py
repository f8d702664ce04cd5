"""Changes the code in one place at a time, and lists the changes that no test notices: python tools/mutants.py dose.

Each mutant has another operator, constant, comparison or function (`mutations`): the code of one function is replaced
in a fork of this process. There the tests run that call it, and then the others of their files, up to the first that
fails. Kernels of the parts in INTERPRETED run as Python. What takes longer than LONGEST_S is left out.

A change that no test notices counts where it changes a result: where in some call by these tests the function returns
or leaves in its arguments something else, to nine digits, or where no test runs its line. The others are listed as
`same`.
"""

import argparse
import ast
import gc
import importlib
import os
import random
import re
import resource
import signal
import sys
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, NamedTuple

import numba
import numba.extending
import numpy as np
import pandas as pd
import pytest

ROOT = Path(__file__).parents[1]
LIBRARY = ROOT / "src/millprint"
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
    "claims": (["thesis/claims/tabulate.py", "thesis/claims/conclusions.py", "thesis/claims/evidence.py"],
               ["unit/test_claims.py", "unit/test_fingerprint_claims.py", "unit/test_stored_verdicts.py",
                "unit/test_intervals.py"]),
    "dose": (["dose/*.py"], ["unit/test_dose_*.py", "unit/test_heat.py", "physics/test_heat.py", "physics/test_wear.py",
             "unit/test_own_power.py", "unit/test_sheets.py"]),
    "yields": (["thesis/yields/*.py"], ["unit/test_yield_*.py"]),
    "doe": (["thesis/doe/*.py", "thesis/regimes.py", "thesis/scaling.py"],
            ["unit/test_doe_*.py", "unit/test_partition.py", "unit/test_fingerprint_[cdi]*.py",
             "unit/test_intervals.py", "unit/test_convergence.py", "unit/test_fit.py", "unit/test_dose_wear.py"]),
    "counting": (["dem/collisions.py", "dem/ledger.py", "dem/run.py"],
                 ["unit/test_dem_collisions.py", "unit/test_turns.py", "unit/test_dem_records.py",
                  "unit/test_dose_spectra.py", "unit/test_mixtures.py", "physics/test_balance.py",
                  "physics/test_open_balance.py"]),
    "kernel": (["dem/law.py", "dem/laws/*.py", "dem/contact_events.py", "dem/recording.py", "mill/distance.py"],
               ["unit/test_contact_laws.py", "unit/test_dem_records.py::test_balls_in_free_flight_are_recorded_by_hand",
                "physics/test_impacts.py::test_the_speeds_at_touch_are_those_of_the_surfaces_along_normal_and_surface",
                "physics/test_over_speed.py", "physics/test_cohesion.py",
                "physics/test_patches.py::test_corners_and_sharp_seams_keep_a_contact_a_face",
                "physics/test_patches.py::test_a_ball_that_rolls_over_a_ridge_keeps_its_contact",
                "unit/test_mill_shapes.py::test_distance_from_a_box_is_that_of_the_closed_form",
                "unit/test_mill_vessel.py::test_signed_distance_agrees_with_the_mesh"]),
    "walls": (["mill/half_plane.py"], ["physics/test_recognition.py"]),
}  # fmt: skip
INTERPRETED = ("kernel",)
OPERATORS = {ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*"), ast.Pow: ("**", "*")}
COMPARED = {ast.Lt: ("<", ">="), ast.LtE: ("<=", ">"), ast.Gt: (">", "<="), ast.GtE: (">=", "<"), ast.Eq: ("==", "!=")}
PAIRS = (("min", "max"), ("fmin", "fmax"), ("minimum", "maximum"), ("argmin", "argmax"), ("mean", "sum"),
         ("any", "all"), ("floor", "ceil"), ("sin", "cos"), ("sqrt", ""), ("exp", "abs"))  # fmt: skip
CALLED = {one: other for pair in PAIRS for one, other in (pair, pair[::-1]) if one}
# What a person reads, and what is only looked at.
LEFT_OUT = (ast.JoinedStr, ast.Raise, ast.Assert, ast.AnnAssign)
# Of processor time [s]: a test, the tests of a file, and a mutant beyond its tests, since one may never end.
LONGEST_S, FILE_S, BEYOND_S = 6, 60, 20
Functions = dict[tuple[str, int], list[FunctionType]]


class Mutant(NamedTuple):
    """Bytes of a file, from `start` to `end`, and what takes their place; within: where the outermost function around
    them begins, or 0.
    """

    file: Path
    within: int
    line: int
    start: int
    end: int
    new: bytes

    def content(self) -> bytes:
        """The changed file."""
        content = self.file.read_bytes()
        return content[: self.start] + self.new + content[self.end :]

    def text(self) -> str:
        """The lines before and after."""
        content, changed = self.file.read_bytes(), self.content()
        begin, stop = content.rfind(b"\n", 0, self.start) + 1, content.find(b"\n", self.end)
        new = changed[begin : stop + len(changed) - len(content)]
        place = f"{self.file.relative_to(LIBRARY)}:{self.line}"
        return f"{place}: {content[begin:stop].decode().strip()}  ->  {new.decode().strip()}"

    def put(self, functions: Functions) -> None:
        """Change this process: the code of the function, or a constant wherever it was imported."""
        if self.within:
            to_read = [compile(self.content(), str(self.file), "exec")]
            while to_read:
                code = to_read.pop()
                for function in functions[str(self.file), self.within] if code.co_firstlineno == self.within else []:
                    if code.co_name == function.__code__.co_name:
                        function.__code__ = code
                to_read += [each for each in code.co_consts if isinstance(each, CodeType)]
            return
        modules = [vars(each) for name, each in sys.modules.items() if name.split(".")[0] in ("millprint", "tests")]
        own = next(each for each in modules if each.get("__file__") == str(self.file))
        before, changed = dict(own), dict(own)
        body = ast.parse(self.content()).body
        statement = next(each for each in body if each.lineno <= self.line <= (each.end_lineno or 0))
        exec(compile(ast.Module([statement], []), str(self.file), "exec"), changed)
        for module in modules:
            for name, old in before.items():
                if changed[name] is not old and module.get(name) is old:
                    module[name] = changed[name]


def mutations(file: Path) -> Iterator[Mutant]:
    """All mutants of a file, but for what only its import evaluates: classes, decorators and default arguments."""
    content = file.read_bytes()
    begins = [0, *(place + 1 for place, byte in enumerate(content) if byte == 10)]

    def at(node: Any) -> tuple[int, int]:
        return begins[node.lineno - 1] + node.col_offset, begins[node.end_lineno - 1] + node.end_col_offset

    def between(one: Any, other: Any, old: str, new: str) -> Iterator[Mutant]:
        place = content.find(old.encode(), at(one)[1], at(other)[0])
        yield Mutant(file, within[0], one.lineno, place, place + len(old), new.encode())

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
            yield Mutant(file, within[0], node.lineno, *at(node), repr(new).encode())
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
            start = at(node)[0]
            yield Mutant(file, within[0], node.lineno, start, start + (1 if isinstance(node.op, ast.USub) else 4), b"")
        elif isinstance(node, ast.Call):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if name in CALLED and (CALLED[name] or node.args):
                stop = at(node.func)[1]
                start = stop - len(name) if CALLED[name] else at(node.func)[0]
                yield Mutant(file, within[0], node.lineno, start, stop, CALLED[name].encode())
        if is_function := isinstance(node, ast.FunctionDef):
            within.insert(len(within) - 1, min(each.lineno for each in (node, *node.decorator_list)))
        skipped = [getattr(node, name, None) for name in ("annotation", "returns", "decorator_list")]
        for name, inner in ast.iter_fields(node):
            is_default = isinstance(node, ast.arguments) and name.endswith("defaults")
            if not is_default and (inner not in skipped or name == "body"):
                for child in inner if isinstance(inner, list) else [inner]:
                    # Of the body of a class, only its functions.
                    if isinstance(child, ast.AST) and not (
                        isinstance(node, ast.ClassDef) and not isinstance(child, ast.FunctionDef)
                    ):
                        yield from visit(child)
        if is_function:
            within.pop(-2)

    within = [0]
    yield from visit(ast.parse(content))


def interpret() -> None:
    """Let kernels run as Python, with numbers as of IEEE 754: before the library is imported."""
    numba.config.DISABLE_JIT = True
    np.seterr(all="ignore")

    def chosen(*arguments: Any, maker: Callable, kind_of: Callable) -> Any:
        return maker(*map(kind_of, arguments))(*arguments)

    def overload(function: Any, **_: Any) -> Callable:
        def keep(maker: Callable) -> Callable:
            function.__code__ = chosen.__code__
            function.__kwdefaults__ = {"maker": maker, "kind_of": numba.typeof}
            return maker

        return keep

    def intrinsic(_: Callable) -> Callable:
        """A number of an array, which is read or, where there is a value, written (dem/law.py)."""
        return lambda array, *at: array.__setitem__(at[:2], at[2]) if at[2:] else array[at]

    numba.extending.overload, numba.extending.intrinsic = overload, intrinsic


def in_text(value: Any) -> str:
    """A value to nine digits."""
    text = repr(vars(value) if type(value).__repr__ is object.__repr__ and hasattr(value, "__dict__") else value)
    return re.sub(r"-?\d+\.\d*(e[+-]\d+)?", lambda found: f"{float(found[0]):.9g}", re.sub(r"0x[0-9a-f]+", "", text))


class Trial:
    """A session of pytest whose tests run in forks, all for each mutant."""

    def __init__(self, given: argparse.Namespace, part: str, folder: Path) -> None:
        self.given, self.part, self.counts = given, part, Counter[str]()
        self.notes = folder
        self.functions: Functions = defaultdict(list)
        # By file of tests: those that pass, with their times [s]; and which functions they call.
        self.passing: dict[str, dict[pytest.Item, float]] = defaultdict(dict)
        self.calls: dict[tuple[str, int], list[pytest.Item]] = defaultdict(list)

    def forked(self, run: Callable[[], None], limit_s: float) -> bool:
        """Whether something ends well in a process of its own, in a processor time [s]."""
        if (child := os.fork()) == 0:
            resource.setrlimit(resource.RLIMIT_CPU, (int(limit_s) + 1,) * 2)
            os.dup2(nothing := os.open(os.devnull, os.O_WRONLY), 1)
            os.dup2(nothing, 2)
            try:
                run()
            except BaseException:
                os._exit(1)
            os._exit(0)
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0

    def passes(self, item: pytest.Item, after: pytest.Item | None) -> bool:
        """Whether a test passes, with its fixtures; what the next one does not share of them ends."""
        self.failed = False
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=after)
        return not self.failed

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note a failure."""
        self.failed |= report.failed

    def watch(self, items: list[pytest.Item]) -> None:
        """Run the tests of a file; a row of the notes for each that passes, and for each function that it calls."""

        def too_long(*_: Any) -> None:
            raise TimeoutError

        signal.signal(signal.SIGPROF, too_long)
        begin = time.process_time()
        with (self.notes / "called").open("a") as notes:
            for item, after in pairwise([*items, None]):
                found, start = set(), time.process_time()

                def note(frame: Any, event: str, _: Any, found: set = found) -> None:
                    if event == "call" and frame.f_code.co_filename.startswith(str(LIBRARY)):
                        found.add((frame.f_code.co_filename, frame.f_code.co_firstlineno))

                signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
                # That takes too long where kernels run as Python: there every test is taken to call every function.
                if self.part in INTERPRETED:
                    found = {place for place in self.functions if place[0].startswith(str(LIBRARY))}
                else:
                    sys.setprofile(note)
                passed = self.passes(item, after)
                sys.setprofile(None)
                signal.setitimer(signal.ITIMER_PROF, 0)
                if passed:
                    seconds = time.process_time() - start
                    notes.writelines(f"{item.nodeid}\t{seconds}\t{name}\t{at}\n" for name, at in found | {("", 0)})
                    notes.flush()
                if time.process_time() - begin > FILE_S:
                    return

    def tests_of(self, mutant: Mutant) -> list[pytest.Item]:
        """The tests that call the function of a mutant, or of a constant any function of its file, and the others of
        their files: they may use what another one's fixture made.
        """
        places = [
            place
            for place in self.calls
            if place[0] == str(mutant.file) and (not mutant.within or place[1] == mutant.within)
        ]
        first = dict.fromkeys(item for place in places for item in self.calls[place])
        files = dict.fromkeys(item.location[0] for item in first)
        seconds = {item: time for file in files for item, time in self.passing[file].items()}
        return sorted(seconds, key=lambda item: (item not in first, seconds[item]))

    def kill(self, mutant: Mutant, tests: list[pytest.Item]) -> None:
        """Run tests on a mutant; raises for the first that fails."""
        mutant.put(self.functions)
        for item, after in pairwise([*tests, None]):
            assert self.passes(item, after)

    def look(self, tests: list[pytest.Item], mutant: Mutant, is_changed: bool) -> None:
        """Write what the function of a mutant returns, and leaves in its arguments, in each call; changed or not."""
        if is_changed:
            mutant.put(self.functions)
        place = str(mutant.file), mutant.within
        np.set_printoptions(threshold=sys.maxsize, precision=12)
        pd.set_option("display.max_rows", None, "display.max_columns", None, "display.precision", 12)
        with (self.notes / f"returned_{is_changed}").open("w") as returned:
            run = []

            def trace(frame: Any, event: str, value: Any) -> Any:
                if frame.f_code.co_filename != place[0]:
                    return None
                if event == "line" and frame.f_lineno == mutant.line and not run:
                    run.append(returned.write("run\n"))
                if event == "return" and frame.f_code.co_firstlineno == place[1]:
                    names = frame.f_code.co_varnames[: frame.f_code.co_argcount + frame.f_code.co_kwonlyargcount]
                    left = [frame.f_locals.get(name) for name in names]
                    returned.write(" ".join(map(in_text, [value, *left])).replace("\n", " ") + "\n")
                return trace

            for item, after in pairwise([*tests, None]):
                sys.settrace(trace)
                self.passes(item, after)
                sys.settrace(None)

    def judge(self, mutant: Mutant) -> str:
        """What becomes of a mutant."""
        tests = self.tests_of(mutant)
        limit_s = BEYOND_S + 3 * sum(self.passing[item.location[0]][item] for item in tests)
        if not tests:
            return "never called"
        if not self.forked(lambda: self.kill(mutant, tests), limit_s):
            return "killed"
        if not mutant.within:
            return "survives"
        written = []
        for is_changed in (False, True):
            self.forked(lambda changed=is_changed: self.look(tests, mutant, changed), 20 * limit_s)
            written.append((self.notes / f"returned_{is_changed}").read_text())
        if "run\n" not in written[0]:
            return "never run"
        return "same" if written[0] == written[1] else "survives"

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Try the mutants of a part in place of the tests of a session."""
        files = [file for pattern in PARTS[self.part][0] for file in sorted(LIBRARY.glob(pattern))]
        for file in files:
            importlib.import_module(".".join(file.relative_to(LIBRARY.parent).with_suffix("").parts))
        gc.unfreeze()
        for each in gc.get_objects():
            if isinstance(each, FunctionType):
                self.functions[each.__code__.co_filename, each.__code__.co_firstlineno].append(each)
        gc.freeze()
        by_file: dict[str, list[pytest.Item]] = defaultdict(list)
        for item in session.items:
            by_file[item.location[0]].append(item)
        for items in by_file.values():
            self.forked(lambda items=items: self.watch(items), 20 * FILE_S)
        named = {item.nodeid: item for item in session.items}
        for line in (self.notes / "called").read_text().splitlines():
            test, seconds, name, at = line.split("\t")
            item = named[test]
            self.passing[item.location[0]][item] = float(seconds)
            self.calls[name, int(at)].append(item)
        every = [mutant for file in files for mutant in mutations(file)]
        tests = sum(map(len, self.passing.values()))
        print(f"{self.part}: {len(every)} mutants; {tests} of {len(session.items)} tests are used", flush=True)
        for mutant in random.Random(self.given.seed).sample(every, min(self.given.count, len(every))):
            found = self.judge(mutant)
            self.counts[found] += 1
            if found != "killed":
                print(f"  {found}: {mutant.text()}", flush=True)
        print(f"  {dict(self.counts)}", flush=True)
        return True


def run(part: str, given: argparse.Namespace, folder: Path) -> int:
    """Try mutants of a part, in a process that has not imported the library."""
    if part in INTERPRETED:
        interpret()
    tests = []
    for pattern in PARTS[part][1]:
        name, *one = pattern.split("::")
        tests += ["::".join((str(path), *one)) for path in sorted((ROOT / "tests").glob(name))]
    options = ["-s", "-q", "--no-header", "-p", "no:cacheprovider", "-m", "not browser", "--rootdir", str(ROOT)]
    return int(pytest.main([*options, "--basetemp", str(folder / "tests"), *tests], [Trial(given, part, folder)]))


def main() -> int:
    """Try mutants of some parts, drawn at random, and print those that no test notices."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="+", choices=PARTS, help="parts of the library")
    parser.add_argument("--count", type=int, default=20, help="number of mutants of each part")
    parser.add_argument("--seed", type=int, default=0, help="of the draw")
    given = parser.parse_args()
    sys.path[:0] = [str(ROOT)]
    for part in given.parts:
        with tempfile.TemporaryDirectory(prefix="mutants") as folder:
            if os.fork() == 0:
                os._exit(run(part, given, Path(folder)))
            os.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())
