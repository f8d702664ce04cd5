"""Random damage to YAML files and tables, such as typing errors and bad exports; repeatable by its seed."""

import copy
import datetime
import math
import random
import string

import yaml

# The fast versions, if PyYAML has them.
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)

# Values that a person, a script or an attacker may write in the wrong place.
ODD_VALUES = [
    None, True, False, "", " ", "abc", "yes", "1e5", "0x1F", "1_000", "١٢", "12 mm", "\0", "💥", "../../etc/passwd",
    "/etc/passwd", "config/mills", "a" * 5000, "~", "NaN", "-0", math.nan, math.inf, -math.inf, 0, -1, 1, 2, 0.5,
    -0.0, 1e308, 1e-308, 5e-324, 1e9, 1e-9, 1e12, 1e-3, 1e3, 10**9, 10**19, 10**400, [], {}, [[]], [None], [1, 2, 3],
    [0, 0, 0], ["x"] * 1000, {"a": 1}, {1: 2}, {None: None}, datetime.date(2020, 1, 1), b"\x00\xff",
]  # fmt: skip

BOMB = "a0: &a0 [x]\n" + "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 12))
ODD_TEXTS = [
    "!!python/object/apply:os.system ['true']\n", "!!python/name:os.system\n", "&a [*a]\n", BOMB, "[" * 5000,
    "{a: " * 3000, "- a\n- b\n", "text", "", "\t", "%YAML 9.9\n---\n", "--- 1\n--- 2\n", "a: 1\na: 2\n",
    "? [a, b]\n: 1\n", "? {a: 1}\n: 2\n", "<<: *missing\n", "<<: 3\n", "x: !!binary '@@'\n",
    "x: !!timestamp nothing\n", "x: !!int abc\n", "x: !!float ''\n", "x: !!set {a, b}\n", "x: 2020-99-99\n",
    "x: 1:99:99\n", "\ufeff", "\u2028", "x: &y\n  <<: *y\n", "0x" + "f" * 5000 + ": 1\n", "x: " + "9" * 6000 + "\n",
]  # fmt: skip


def places(tree, place=()):
    """Every path into nested mappings and lists."""
    inner = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in inner:
        yield (*place, key)
        yield from places(value, (*place, key))


def _parent(tree, place):
    for key in place[:-1]:
        tree = tree[key]
    return tree


def _misspelled(word: str, rng: random.Random) -> str:
    k = rng.randrange(len(word) + 1)
    letter = rng.choice(string.ascii_lowercase + "_ ")
    return rng.choice([word[:k] + letter + word[k:], word[:k] + word[k + 1 :], word.upper(), word + " ", letter])


def _other_number(value: float, rng: random.Random) -> float:
    factor = rng.choice([-1, 0, 1e-12, 1e-6, 1e-3, 0.1, 0.5, 1.01, 2, 10, 1e3, 1e6, 1e9, 1e15])
    # A file may be damaged more than once: such an integer has more digits than a float.
    return type(value)(max(-(10**290), min(value, 10**290)) * factor) if isinstance(value, int) else value * factor


def change_one(tree, rng: random.Random):
    """The tree with one thing changed."""
    tree = copy.deepcopy(tree)
    everywhere = list(places(tree))
    if not everywhere:
        return rng.choice(ODD_VALUES)
    place = rng.choice(everywhere)
    parent, key = _parent(tree, place), place[-1]
    value, kind = parent[key], rng.random()
    if kind < 0.35:
        parent[key] = rng.choice(ODD_VALUES)
    elif kind < 0.6 and isinstance(value, (int, float)) and not isinstance(value, bool):
        parent[key] = _other_number(value, rng)
    elif kind < 0.7:
        del parent[key]
    elif kind < 0.8 and isinstance(parent, dict) and isinstance(key, str):
        parent[_misspelled(key, rng)] = parent.pop(key)
    elif kind < 0.85:
        parent[key] = rng.choice([[value], {"value": value}, str(value), [value, value]])
    elif kind < 0.92 and isinstance(value, list) and value:
        value.append(copy.deepcopy(rng.choice(value)))
    else:
        other = rng.choice(everywhere)
        parent[key] = copy.deepcopy(_parent(tree, other)[other[-1]])
    return tree


def change_text(text: str, rng: random.Random) -> str:
    """The text with a piece lost, doubled, moved or put in."""
    a, b = sorted(rng.randrange(len(text) + 1) for _ in range(2))
    b = min(b, a + rng.choice([1, 3, 30, 300]))
    odd = rng.choice([*ODD_TEXTS, *"\t\0:#&*!|>'\"%@`{}[],-?é\u200b\u202e\x1b\x85", "\r\n", "  ", "- ", "nan", "1e999"])
    return rng.choice(
        [text[:a] + text[b:], text[:b] + text[a:], text[:a], text[:a] + odd + text[a:], odd, text + odd, odd + text,
         text.replace("\n", "\r"), text.replace("  ", "\t", 3)]
    )  # fmt: skip


def mutate_yaml(text: str, rng: random.Random) -> str:
    """A YAML file with one to three faults."""
    if rng.random() < 0.2:
        return change_text(text, rng)
    tree = yaml.load(text, Loader=LOADER)
    for _ in range(rng.choice([1, 1, 1, 2, 3])):
        tree = change_one(tree, rng) if isinstance(tree, (dict, list)) else tree
    return yaml.dump(tree, Dumper=DUMPER, allow_unicode=True, sort_keys=False)


def mutate_table(text: str, rng: random.Random) -> str:
    """A table of tab-separated values with one to three faults."""
    if rng.random() < 0.3:
        return change_text(text, rng)
    rows = [line.split("\t") for line in text.splitlines()]
    for _ in range(rng.choice([1, 1, 2, 3])):
        row = rng.choice(rows)
        k, kind = rng.randrange(len(row)), rng.random()
        if kind < 0.5:
            row[k] = str(rng.choice(ODD_VALUES))
        elif kind < 0.6:
            del row[k]
            row = row or [""]
        elif kind < 0.7:
            row.insert(k, "1")
        elif kind < 0.8:
            rows.append(list(row))
        elif kind < 0.9:
            rng.shuffle(rows)
        else:
            rows.remove(row)
        rows = [row for row in rows if row] or [[""]]
    return "\n".join("\t".join(row) for row in rows) + "\n"
