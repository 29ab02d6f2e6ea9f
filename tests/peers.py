#!/usr/bin/env python3
"""Holds scanbound's bound and its time against RC2, a MaxSAT solver, on the same questions.

    tests/peers.py [--scanbound PATH] [--limit SECONDS] [--runs N] PROGRAM:TABLE [PROGRAM:TABLE ...]

For each program every group is exported as WCNF and solved by RC2 (stratified, Glucose 4, core exhaustion).
A line a program: scanbound's seconds for the whole audit, RC2's seconds for the solving alone (the medians of so many
runs, one unless told), their ratio, and whether all groups' maxima are equal. Exit code 1 if one differs. Needs: pip install python-sat.
"""
import argparse
import json
import multiprocessing
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def solve(path, answers):
    """RC2's least weight of violated soft clauses and the seconds it took, reading the file not counted."""
    from pysat.examples.rc2 import RC2Stratified
    from pysat.formula import WCNF

    formula = WCNF(from_file=path)
    begin = time.perf_counter()
    with RC2Stratified(formula, solver="g4", adapt=True, exhaust=True, minz=True, trim=5) as rc2:
        rc2.compute()
        answers.put((rc2.cost, time.perf_counter() - begin))


def limited(path, limit):
    """The same, or None where it takes longer than the limit."""
    answers = multiprocessing.Queue()
    process = multiprocessing.Process(target=solve, args=(path, answers))
    process.start()
    try:
        return answers.get(timeout=limit)
    except Exception:  # the queue's Empty
        return None
    finally:
        process.terminate()
        process.join()


def timed(command):
    """What a command prints and the seconds it took."""
    begin = time.perf_counter()
    printed = subprocess.run(command, check=True, capture_output=True).stdout
    return printed, time.perf_counter() - begin


def compare(scanbound, program, table, limit, runs):
    """Prints the program's line; whether no maximum differs."""
    arguments = [program, "--table", table]
    audits = [timed([scanbound, "audit", *arguments, "--format", "json"]) for _ in range(runs)]
    ours = statistics.median(seconds for _, seconds in audits)
    audit = json.loads(audits[0][0])
    theirs, equal, open_groups = 0.0, True, 0
    with tempfile.TemporaryDirectory() as directory:
        for group in audit["groups"]:
            path = str(Path(directory) / "group.wcnf")
            number = str(group["id"])
            subprocess.run([scanbound, "export", *arguments, "--group", number, "--format", "wcnf", "-o", path], check=True)
            found = [limited(path, limit) for _ in range(runs)]
            if None in found:
                open_groups += 1
                theirs += limit
                continue
            cost = found[0][0]
            seconds = statistics.median(seconds for _, seconds in found)
            naive = int(re.search(r"^c (\d+) minus the weight", Path(path).read_text(), re.M).group(1))
            theirs += seconds
            if group["exact"] and group["upper_ps"] != naive - cost:
                equal = False
                print(f"  group {number}: scanbound {group['upper_ps']} ps, RC2 {naive - cost} ps")
    state = "equal" if equal else "DIFFERENT"
    if open_groups:
        state += f", RC2 timed out on {open_groups}"
    if not audit["scan"]["exact"]:
        state += ", scanbound not exact"
    print(f"{Path(program).name:24} scanbound {ours:8.3f} s   RC2 {theirs:8.3f} s   ratio {ours / theirs:6.3f}   {state}", flush=True)
    return equal


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scanbound", default="target/release/scanbound")
    parser.add_argument("--limit", type=float, default=300, help="seconds that RC2 may take for a group")
    parser.add_argument("--runs", type=int, default=1, help="how often each is run, for the medians")
    parser.add_argument("programs", nargs="+", metavar="PROGRAM:TABLE")
    options = parser.parse_args()
    fine = True
    for pair in options.programs:
        program, _, table = pair.rpartition(":")
        fine &= compare(options.scanbound, program, table, options.limit, options.runs)
    sys.exit(0 if fine else 1)


if __name__ == "__main__":
    main()
