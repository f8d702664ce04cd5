"""What the rules of any mill share: the cases of every sweep, the large mill, and where files lie."""

from millprint.fingerprint.mill_cases import large_case, mill_cases
from millprint.fingerprint.similarity import enlarged

MILL = f"{RESULTS}/mills/{{mill}}"
SCALE_UP = f"{RESULTS}/scale_up"
BOX = CONFIG.mills.box
SWEPT_MILLS = list(dict.fromkeys([CONFIG.mill, *CONFIG.mills.named]))

# The large mill is one like any other, but made from the small one and not from a file.
LARGE, LARGE_FACTOR = enlarged(
    MILLS[CONFIG.mills.scale_up.mill], CONFIG.mills.scale_up.volume_l, f"{CONFIG.mills.scale_up.mill}_large"
)
MILLS[LARGE.name] = LARGE

MILL_CASES = {name: mill_cases(MILLS[name], CONFIG.mills) for name in SWEPT_MILLS}
LARGE_CASE = large_case(LARGE, LARGE_FACTOR, CONFIG.mills)
# A case that a sweep of the configuration simulates already is taken as it is there.
OTHER_CASES.update({case.path: case for cases in MILL_CASES.values() for case in cases})
OTHER_CASES[LARGE_CASE.path] = LARGE_CASE


def mill_summaries(name: str) -> list[str]:
    """Summaries of every case of a mill's sweep."""
    return [f"{RESULTS}/dem/{case.path}/summary.json" for case in MILL_CASES[name]]


def described(name: str) -> str:
    """The fingerprint of a mill."""
    return f"{RESULTS}/mills/{name}/fingerprint.json"


def dumped(mill) -> dict:
    """A mill as plain values, without its sweep: another sweep changes no picture."""
    return mill.model_dump(mode="json", exclude={"sweep"})
