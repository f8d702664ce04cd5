"""The plan of a run as a person reads it."""

from collections.abc import Iterable, Sequence

from millprint.plan.costs import measured_when
from millprint.plan.estimate import Estimate, Part, target_parts
from millprint.plan.jobs import PlannedCase, PlannedJob, stage_title
from millprint.progress import duration

# Longer lists of values are cut.
LISTED = 8
WIDTH = 38


def plan_text(estimate: Estimate, targets: dict[str, int], cores: int, results: str, free_mb: float, again: str) -> str:
    """The plan in lines.

    targets: places of the targets in the plan, by name; free_mb: of the disk of the folder `results`; again: the
    command that runs the plan.
    """
    whole = estimate.whole
    lines = [f"Plan of {', '.join(targets)} in {results}/", "", *_simulations(estimate.jobs), ""]
    lines += _stages(estimate)
    if len(targets) > 1:
        lines += ["", *_targets(estimate, targets, cores)]
    lines.append("")
    if not estimate.costs:
        lines.append("Everything is done; a run has nothing to do.")
        return "\n".join(lines)
    others = [number for number in estimate.wall if number != cores]
    walls = ", ".join(f"{duration(estimate.wall[number].wall_s)} on {number}" for number in others)
    lines += [
        f"time    about {duration(estimate.wall[cores].wall_s)} on {_count(cores, 'core')}"
        f" ({duration(whole.processor_s)} of one processor{'; ' if walls else ''}{walls})",
        f"        the longest job: {_longest(estimate, whole)}",
        f"memory  up to {_megabytes(estimate.wall[cores].memory_mb)} for all jobs at the same time, "
        f"{_megabytes(max(cost.memory_mb for cost in estimate.costs.values()))} for the largest",
        f"disk    about {_megabytes(whole.disk_mb)} more; {_megabytes(estimate.present_mb)} are there, "
        f"{_megabytes(free_mb)} are free",
    ]
    if whole.disk_mb > free_mb:
        lines.append("        THE DISK IS TOO SMALL")
    lines += ["", *_basis(estimate), f"To run it: {again}"]
    return "\n".join(lines)


def _simulations(jobs: Sequence[PlannedJob]) -> list[str]:
    """The mills, conditions, balls and seeds of the simulations, and how many of them are done."""
    planned = list({each.case.path: each for job in jobs for each in job.cases}.values())
    if not planned:
        return ["simulations   none"]
    to_run = {each.case.path for job in jobs for each in job.cases_to_run}
    running = [each for each in planned if each.case.path in to_run]
    new = sum(not each.exists for each in running)
    parts = {"done": len(planned) - len(running), "new": new, "again": len(running) - new}
    cases = [each.case for each in planned]
    speeds = sorted({case.speed_rpm for case in cases})
    fills = sorted({case.fill_ratio for case in cases})
    sizes = dict.fromkeys(case.mixture.name if case.mixture else f"{case.ball_diameter_mm:g} mm" for case in cases)
    balls = sorted(each.balls for each in planned)
    return [
        f"mills         {_listed(dict.fromkeys(case.mill for case in cases))}",
        f"contact sets  {_listed(dict.fromkeys(case.contact for case in cases))}",
        f"conditions    {len({each.condition for each in planned})}: balls of {_listed(sizes)}; "
        f"fill ratio {_range(fills)}; {_range(speeds)} rpm",
        f"balls         {_range(balls)} in a mill; {_steps(running)}",
        f"seeds         {_seeds(planned)}",
        f"simulations   {len(planned)}: " + ", ".join(f"{count} {what}" for what, count in parts.items() if count),
    ]


def _steps(running: Sequence[PlannedCase]) -> str:
    return f"{sum(each.balls * each.steps for each in running) / 1e9:.2g} billion steps of a ball to compute"


def _seeds(planned: Sequence[PlannedCase]) -> str:
    counts: dict[str, int] = {}
    for each in planned:
        counts[each.condition] = counts.get(each.condition, 0) + 1
    return f"{_range(sorted(counts.values()))} for each condition"


def _stages(estimate: Estimate) -> list[str]:
    lines = [f"{'stage':{WIDTH}} {'new':>5} {'again':>5} {'done':>5} {'processor':>12} {'disk':>8}"]
    for stage, part in estimate.stages.items():
        lines.append(_row(stage_title(stage), part))
    return [*lines, _row("together", estimate.whole)]


def _row(title: str, part: Part) -> str:
    times = (duration(part.processor_s), _megabytes(part.disk_mb)) if part.new + part.again else ("", "")
    return f"{title:{WIDTH}} {part.new:5} {part.again:5} {part.done:5} {times[0]:>12} {times[1]:>8}".rstrip()


def _targets(estimate: Estimate, targets: dict[str, int], cores: int) -> list[str]:
    """What each target takes by itself; what two of them share counts for both."""
    lines = [f"{'each by itself':{WIDTH}} {'new':>5} {'again':>5} {'done':>5} {'processor':>12} {'disk':>8}  time"]
    for name, (part, table) in target_parts(estimate, targets, cores).items():
        lines.append(f"{_row(name, part):78} {duration(table.wall_s) if part.new + part.again else ''}".rstrip())
    return lines


def _longest(estimate: Estimate, part: Part) -> str:
    if part.longest is None:
        return "none"
    job, cost = estimate.jobs[part.longest], estimate.costs[part.longest]
    return f"{job.rule}{f' {job.name}' if job.name != job.rule else ''}, {duration(cost.processor_s)} of one processor"


def _basis(estimate: Estimate) -> list[str]:
    speed = f"{estimate.ball_step_s * 1e9:.0f} ns for a ball and a step"
    own = "as in the finished simulations here" if estimate.own_speed else "as measured for the thesis"
    unknown = sorted({estimate.jobs[place].rule for place, cost in estimate.costs.items() if not cost.measured})
    lines = [
        f"Simulations: {speed}, {own}; a window that has to grow takes longer.",
        f"Other jobs: {measured_when()}. Another machine may take half or twice as long.",
    ]
    return [*lines, f"Not measured yet, and guessed: {_listed(unknown)}."] if unknown else lines


def _listed(values: Iterable[str]) -> str:
    listed = list(values)
    more = f" and {len(listed) - LISTED} more" if len(listed) > LISTED else ""
    return ", ".join(listed[:LISTED]) + more


def _range(values: Sequence[float]) -> str:
    return f"{values[0]:g}" if values[0] == values[-1] else f"{values[0]:g} to {values[-1]:g}"


def _count(number: int, unit: str) -> str:
    return f"{number} {unit}" if number == 1 else f"{number} {unit}s"


def _megabytes(value: float) -> str:
    return f"{value:.0f} MB" if value < 1000 else f"{value / 1000:.1f} GB"
