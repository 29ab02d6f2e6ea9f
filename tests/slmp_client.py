#!/usr/bin/env python3
"""Reads the emulated CPU with an SLMP client that is none of ours.

    tests/slmp_client.py [--scanbound PATH]

Starts `scanbound serve` on a port that is free, reads scan times, words, bits and the CPU's name with pymcprotocol in binary
and in ASCII, and sees that what writes is refused. Exit code 1 if anything differs. Needs: pip install pymcprotocol.
"""
import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

PROGRAM = "LD X0\nMOV K7 D0\nLD SM400\nINC D5\nEND\n"


def check(what, got, expected):
    """Tells of a difference, and whether there is one."""
    if got != expected:
        print(f"{what}: {got!r}, not {expected!r}")
    return got == expected


def refused(call):
    """The text of the error that a call ends in."""
    try:
        call()
    except Exception as error:  # the client has an error class for each family of end codes
        return str(error)
    return ""


def asked(address, code):
    """Whether all that is asked for comes as it is."""
    import pymcprotocol

    plc = pymcprotocol.Type3E(plctype="Q")
    plc.setaccessopt(commtype=code)
    host, port = address.rsplit(":", 1)
    plc.connect(host, int(port))
    good = check("name", plc.read_cputype()[0], "Q26UDV")
    words = plc.batchread_wordunits(headdevice="SD520", readsize=8)
    ms, us = words[0], words[1]
    # END processing and the like take 0.43 ms by the table.
    good &= check("scan time", ms == 0 and us in (400, 500), True)
    good &= check("D0", plc.batchread_wordunits(headdevice="D0", readsize=1), [7])
    good &= check("X0", plc.batchread_bitunits(headdevice="X0", readsize=3), [1, 0, 0])
    good &= check("X0 as a word", plc.batchread_wordunits(headdevice="X0", readsize=1), [1])
    first = plc.batchread_wordunits(headdevice="D5", readsize=1)[0]
    good &= check("D5 is counted", plc.batchread_wordunits(headdevice="D5", readsize=1)[0] >= first, True)
    write = refused(lambda: plc.batchwrite_wordunits(headdevice="D0", values=[1]))
    good &= check("writing is refused", "not supported" in write, True)
    beyond = refused(lambda: plc.batchread_wordunits(headdevice="D999999", readsize=2))
    good &= check("beyond the end", "C056" in beyond, True)
    plc.close()
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scanbound", default="target/release/scanbound")
    scanbound = Path(parser.parse_args().scanbound).resolve()
    with tempfile.TemporaryDirectory() as directory:
        Path(directory, "a.il").write_text(PROGRAM)
        command = [scanbound, "serve", "a.il", "--dialect", "melsec-list", "--cpu", "Q26UDV", "--slmp", "0", "--set", "X0=1"]
        server = subprocess.Popen(command, cwd=directory, stderr=subprocess.PIPE, text=True)
        try:
            line = next(line for line in server.stderr if line.startswith("listening"))
            address = line.split()[-1]
            good = all([asked(address, code) for code in ("binary", "ascii")])
        finally:
            server.terminate()
    print("the client reads what the emulated CPU holds" if good else "they differ")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
