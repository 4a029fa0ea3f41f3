#!/usr/bin/env python3
"""Compares two folders of results byte for byte: same_answers.py BEFORE AFTER [--except MEMBER ...]

Every `result.json` under BEFORE has to be under AFTER and hold the same text, but for what says when and by whom it was
made: `match`, `sketch`, `mesh`, `version` and `timings_ms`, and the members named by --except (`confidence` names every
member of that name, at any depth). Numbers are compared as they are written, so that no last digit is lost. Prints
each result that differs with the first places where it does; exits 1 where one differs or is missing, or none is there.
"""
import argparse
import json
import sys
from pathlib import Path

INCIDENTAL = ("match", "sketch", "mesh", "version", "timings_ms")
SHOWN = 5


class Number(str):
    """A number as it is written."""


def load(path, excepted):
    """The result without what may differ; of the top level the incidental members are left out, of all the excepted."""

    def kept(members):
        return {name: value for name, value in members if name not in excepted}

    with open(path, encoding="utf-8") as file:
        result = json.load(file, parse_float=Number, parse_int=Number, parse_constant=Number, object_pairs_hook=kept)
    return {name: value for name, value in result.items() if name not in INCIDENTAL}


def differences(before, after, place=""):
    """Every place where two values differ, with both."""
    if type(before) is not type(after):
        yield f"{place}: {before!r:.60} became {after!r:.60}"
    elif isinstance(before, dict):
        for name in [*before, *(name for name in after if name not in before)]:
            if name not in before or name not in after:
                yield f"{place}/{name}: {'added' if name in after else 'gone'}"
            else:
                yield from differences(before[name], after[name], f"{place}/{name}")
    elif isinstance(before, list):
        if len(before) != len(after):
            yield f"{place}: {len(before)} elements became {len(after)}"
        for i, (one, other) in enumerate(zip(before, after)):
            yield from differences(one, other, f"{place}/{i}")
    elif before != after:
        yield f"{place}: {before} became {after}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--except", dest="excepted", metavar="MEMBER", nargs="*", default=[])
    options = parser.parse_args()
    names = sorted(path.relative_to(options.before) for path in options.before.rglob("result.json"))
    same = 0
    for name in names:
        before, after = (folder / name for folder in (options.before, options.after))
        if not after.exists():
            print(f"{name.parent}: missing")
            continue
        found = list(differences(load(before, options.excepted), load(after, options.excepted)))
        same += not found
        if found:
            print(f"{name.parent}: {len(found)} places differ", *found[:SHOWN], sep="\n  ")
    print(f"{same} of {len(names)} results are the same")
    return 0 if names and same == len(names) else 1


if __name__ == "__main__":
    sys.exit(main())
