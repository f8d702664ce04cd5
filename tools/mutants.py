"""Changes the code in one place at a time, and lists the changes that no test notices: python tools/mutants.py dose.

Each mutant has another operator, constant, comparison or function (`mutations`): the code of one function is replaced
in a fork of this process. There the tests run that call it, and then the others of their files, up to the first that
fails. Kernels of the parts in INTERPRETED run as Python; a test that takes longer than LONGEST_S is not used. What is
listed is to be read: whether it changes a result, and whether a test of another part, or a whole run, notices it.
"""

import argparse
import ast
import gc
import importlib
import os
import random
import resource
import signal
import sys
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from itertools import groupby
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, NamedTuple

import numpy as np
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
    "counting": (["dem/collisions.py", "dem/turns.py", "dem/ledger.py", "dem/run.py"],
                 ["unit/test_dem_collisions.py", "unit/test_turns.py", "unit/test_dem_records.py",
                  "unit/test_dose_spectra.py", "unit/test_mixtures.py", "physics/test_balance.py",
                  "physics/test_open_balance.py"]),
    "kernel": (["dem/law.py", "dem/laws/*.py", "dem/contact_events.py", "dem/recording.py", "dem/neighbours.py",
                "dem/advance.py"],
               ["unit/test_contact_laws.py", "unit/test_dem_records.py::test_balls_in_free_flight_are_recorded_by_hand",
                "unit/test_dem_records.py::test_what_a_window_counts_and_what_was_before_it_add_up",
                "physics/test_impacts.py::test_the_speeds_at_touch_are_those_of_the_surfaces_along_normal_and_surface",
                "physics/test_over_speed.py::test_a_wall_has_its_own_table_and_friction_follows_the_speed[0.3]",
                "physics/test_over_speed.py::test_two_balls_rebound_by_the_table[4.0]",
                "physics/test_patches.py::test_corners_and_sharp_seams_keep_a_contact_a_face",
                "physics/test_patches.py::test_a_ball_that_rolls_over_a_ridge_keeps_its_contact[0.2]",
                *("physics/test_patches.py::test_a_ball_that_falls_beside_a_shallow_seam_hits_the_nearer_face_alone"
                  f"[{side}]" for side in (-1, 1)),
                "physics/test_near_candidates.py::test_a_crowd_is_listed_and_pushed_as_by_hand",
                "physics/test_threads.py::test_a_crowd_moves_in_threads_as_without",
                "physics/test_bodies.py::test_each_face_of_two_bodies_pushes_and_works_as_by_hand",
                "physics/test_symmetries.py::test_a_vessel_in_uniform_motion_is_a_vessel_at_rest",
                "physics/test_symmetries.py::test_the_order_of_the_balls_does_not_matter",
                "physics/test_symmetries.py::test_neither_parts_of_a_run_nor_its_lists_change_it[0.02-False]",
                "physics/test_contact_cases.py::test_a_case_ends_as_in_its_closed_form["
                "linear_impact-restitution=0.3-balls.0.velocity_m_s=[5, 0, -1]-upright]",
                "physics/test_contact_cases.py::test_a_case_ends_as_in_its_closed_form["
                "rolling_impulse_wall-balls.0.spin_rad_s=[100, -80, 60]-turned]",
                *(f"physics/test_contact_cases.py::test_{what}[oblique_spinning_pair-"
                  "balls.1.spin_rad_s=[300, -200, 100]-balls.1.velocity_m_s=[-0.5, 2, -3]-turned]"
                  for what in ("a_case_ends_as_in_its_closed_form", "the_energy_balance_of_a_case_closes"))]),
    "distance": (["mill/distance.py"],
                 ["unit/test_mill_shapes.py::test_distances_of_shapes_are_those_of_closed_forms",
                  *(f"physics/test_ports.py::test_a_port_is_found_however_it_is_drawn[{port}-24-24-None]"
                    for port in ("oblique port", "port in a cone", "window"))]),
    "walls": (["mill/half_plane.py", "mill/surfaces_about.py"], ["physics/test_recognition.py"]),
}  # fmt: skip
INTERPRETED = ("kernel", "distance")
OPERATORS = {ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*"), ast.Pow: ("**", "*")}
COMPARED = {ast.Lt: ("<", ">="), ast.LtE: ("<=", ">"), ast.Gt: (">", "<="), ast.GtE: (">=", "<"), ast.Eq: ("==", "!=")}
PAIRS = (("min", "max"), ("fmin", "fmax"), ("minimum", "maximum"), ("argmin", "argmax"), ("mean", "sum"),
         ("any", "all"), ("floor", "ceil"), ("sin", "cos"), ("sqrt", ""), ("exp", "abs"))  # fmt: skip
CALLED = {one: other for pair in PAIRS for one, other in (pair, pair[::-1]) if one}
# What a person reads, and what is only looked at.
LEFT_OUT = (ast.JoinedStr, ast.Raise, ast.Assert, ast.AnnAssign)
# Of processor time [s]: a test, the tests of a file, and a test of a mutant beyond thrice its own, which may never end.
LONGEST_S, FILE_S, BEYOND_S = 8, 60, 10
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
        if is_outermost := isinstance(node, ast.FunctionDef) and not within[0]:
            within[0] = node.decorator_list[0].lineno if node.decorator_list else node.lineno
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
        if is_outermost:
            within[0] = 0

    within = [0]
    yield from visit(ast.parse(content))


def interpret() -> None:
    """Let kernels run as Python, with numbers as of IEEE 754: before numba and the library are imported."""
    os.environ["NUMBA_DISABLE_JIT"] = "1"
    from numba import extending, typeof

    np.seterr(all="ignore")

    def chosen(*arguments: Any, maker: Any) -> Any:
        return maker(*map(maker.kind_of, arguments))(*arguments)

    def overload(function: Any, **_: Any) -> Callable:
        def keep(maker: Any) -> Callable:
            maker.kind_of, function.__code__, function.__kwdefaults__ = typeof, chosen.__code__, {"maker": maker}
            return maker

        return keep

    def intrinsic(_: Callable) -> Callable:
        """A number of an array, which is read or, where there is a value, written (dem/law.py)."""
        return lambda array, *at: array.__setitem__(at[:2], at[2]) if at[2:] else array[at]

    vars(extending).update(overload=overload, intrinsic=intrinsic)


def stop_after(limit_s: float) -> None:
    """Raise TimeoutError after a processor time [s]."""

    def stop(*_: Any) -> None:
        raise TimeoutError

    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, limit_s)


class Trial:
    """A session of pytest whose tests run in forks, again for each mutant."""

    def __init__(self, given: argparse.Namespace, part: str, folder: Path) -> None:
        self.given, self.part, self.notes, self.failed = given, part, folder / "notes", False
        self.functions: Functions = defaultdict(list)
        # By file of tests: those that pass, with their times [s]; by place of a function, those that call it.
        self.passing: dict[str, dict[pytest.Item, float]] = defaultdict(dict)
        self.calls: dict[tuple[str, int], list[pytest.Item]] = defaultdict(list)

    def ends_well(self, limit_s: float, run: Callable[..., None], *arguments: Any) -> bool:
        """Whether something ends well in a process of its own, in a processor time [s]."""
        if (child := os.fork()) == 0:
            resource.setrlimit(resource.RLIMIT_CPU, (int(limit_s) + 1,) * 2)
            for stream in (1, 2):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
            try:
                run(*arguments)
            except BaseException:
                os._exit(1)
            os._exit(0)
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0

    def passed(self, tests: list[pytest.Item]) -> Iterator[bool]:
        """Whether each of these tests passes; its fixtures end where the next one does not share them."""
        for item, after in zip(tests, [*tests[1:], None], strict=True):
            self.failed = False
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=after)
            yield not self.failed

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note a failure."""
        self.failed |= report.failed

    def watch(self, tests: list[pytest.Item]) -> None:
        """Run the tests of a file, and note those that pass, with their times and each function that they call."""
        library, found = str(LIBRARY), set()

        def note(frame: Any, event: str, _: Any) -> None:
            if event == "call" and frame.f_code.co_filename.startswith(library):
                found.add((frame.f_code.co_filename, frame.f_code.co_firstlineno))

        stop_after(LONGEST_S)
        # Where kernels run as Python, that takes too long: there every test is taken to call every function.
        profile = None if self.part in INTERPRETED else note
        sys.setprofile(profile)
        start = begin = time.process_time()
        with self.notes.open("a") as notes:
            for item, is_good in zip(tests, self.passed(tests), strict=True):
                seconds = time.process_time() - start
                if self.part in INTERPRETED:
                    found.update(place for place in self.functions if place[0].startswith(library))
                if is_good:
                    notes.writelines(f"{item.nodeid}\t{seconds}\t{name}\t{at}\n" for name, at in found | {("", 0)})
                    notes.flush()
                found.clear()
                # A test that is stopped while a call is noted ends the profile.
                sys.setprofile(profile)
                start = time.process_time()
                if start - begin > FILE_S:
                    return
                stop_after(LONGEST_S)

    def tests_of(self, mutant: Mutant) -> list[pytest.Item]:
        """The tests that call the function of a mutant, or of a constant any function of its file; then the others of
        their files, which may use what another one's fixture made.
        """
        own = {
            item
            for (name, at), items in self.calls.items()
            if name == str(mutant.file) and mutant.within in (0, at)
            for item in items
        }
        seconds = {
            item: own_s for name in {item.location[0] for item in own} for item, own_s in self.passing[name].items()
        }
        return sorted(seconds, key=lambda item: (item not in own, seconds[item]))

    def kill(self, mutant: Mutant, tests: list[pytest.Item]) -> None:
        """Run tests on a mutant; raises at the first that fails."""
        mutant.put(self.functions)
        passed = self.passed(tests)
        for item in tests:
            stop_after(BEYOND_S + 3 * self.passing[item.location[0]][item])
            assert next(passed)

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
        for _, items in groupby(session.items, key=lambda item: item.location[0]):
            self.ends_well(10 * FILE_S, self.watch, list(items))
        named = {item.nodeid: item for item in session.items}
        for line in self.notes.read_text().splitlines():
            test, seconds, name, at = line.split("\t")
            self.passing[named[test].location[0]][named[test]] = float(seconds)
            self.calls[name, int(at)].append(named[test])
        every = [mutant for file in files for mutant in mutations(file)]
        used = sum(map(len, self.passing.values()))
        print(f"{self.part}: {len(every)} mutants; {used} of {len(session.items)} tests are used", flush=True)
        counts = Counter[str]()
        for mutant in random.Random(self.given.seed).sample(every, min(self.given.count, len(every))):
            tests = self.tests_of(mutant)
            limit_s = BEYOND_S + sum(BEYOND_S + 3 * self.passing[item.location[0]][item] for item in tests)
            survives = "survives" if tests else "never called"
            found = survives if self.ends_well(limit_s, self.kill, mutant, tests) else "killed"
            counts[found] += 1
            if found != "killed":
                print(f"  {found}: {mutant.text()}", flush=True)
        print(f"  {dict(counts)}", flush=True)
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
