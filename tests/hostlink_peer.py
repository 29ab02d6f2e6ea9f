#!/usr/bin/env python3
"""Host Link (C-mode) apart from scanbound: frames with a check sum of its own, as host and as PLC.

    tests/hostlink_peer.py frames                  writes tests/data/hostlink-frames.txt, which tests/it/hostlink.rs reads
    tests/hostlink_peer.py ask DEVICE [UNIT]       asks a unit on a serial line, such as that of `scanbound serve --pty`
    tests/hostlink_peer.py check --scanbound FILE  starts `serve --pty`, asks it, and lets `live` ask a PLC played here

Needs nothing but Python. Written after OMRON's W235 (C200HS Operation Manual), section 11-3.
"""

import argparse
import functools
import operator
import os
import pathlib
import pty
import select
import subprocess
import sys
import tempfile
import time
import tty

ROOT = pathlib.Path(__file__).resolve().parent.parent


def frame(text):
    """`@`, text, check sum and terminator."""
    body = "@" + text
    return body + format(functools.reduce(operator.xor, body.encode("ascii"), 0), "02X") + "*\r"


def unframe(data):
    """The text of a frame; raises if the check sum is wrong."""
    if frame(data[1:-4]) != data:
        raise ValueError(f"no frame, or a wrong check sum: {data!r}")
    return data[1:-4]


# A unit whose words hold 7 times their number, whose flags are on where the number can be divided by 3, whose timers and
# counters stand at their numbers in decimal digits, and whose TIM 5 is set to 50; its CNT 6 is set by DM 0007.
def unit_answer(text):
    unit, header, rest = text[:2], text[2:4], text[4:]
    if header == "TS":
        return text
    if header == "MS":
        return f"{unit}MS000200"
    if header in ("RR", "RL", "RH", "RJ", "RD", "RC", "RG"):
        first, count = int(rest[:4]), int(rest[4:])
        numbers = range(first, first + count)
        if header == "RG":
            data = "".join("1" if n % 3 == 0 else "0" for n in numbers)
        elif header == "RC":
            data = "".join(f"{n:04d}" for n in numbers)
        else:
            data = "".join(f"{7 * n:04X}" for n in numbers)
        return f"{unit}{header}00{data}"
    if header == "R#":
        return f"{unit}R#000050" if rest == "TIM 0005" else f"{unit}R#16"
    if header in ("R$", "R%"):
        name = rest[4:] if header == "R$" else rest[6:]
        answers = {"TIM 0005": "CON 0050", "CNT 0006": "DM  0007"}
        return f"{unit}{header}00{answers[name]}" if name in answers else f"{unit}{header}16"
    return f"{unit}{header}16"


REQUESTS = [
    "00RR00000001", "00RR02550001", "10RR00310001", "31RR00100030", "00RH00990001", "00RJ00270001", "00RL00000004",
    "00RD00000030", "00RC00000010", "00RC05110001", "00RG00000120", "00RG05000012", "00R#TIM 0005", "00R#CNT 0006",
    "00R$0000TIM 0005", "00R$0123CNT 0006", "00R%012345CNT 0006", "00R$0000TIMH0005", "00MS", "00TS123456", "05TS",
]


def frames():
    lines = [f"# Made by tests/{pathlib.Path(__file__).name}: request and answer, without their carriage returns."]
    for text in REQUESTS:
        lines.append(f"{frame(text)[:-1]}\t{frame(unit_answer(text))[:-1]}")
    (ROOT / "tests/data/hostlink-frames.txt").write_text("\n".join(lines) + "\n")


def until_return(line, patience=2.0):
    data, end = b"", time.monotonic() + patience
    while not data.endswith(b"\r"):
        left = end - time.monotonic()
        if left <= 0 or not select.select([line], [], [], left)[0]:
            raise TimeoutError(f"no answer; so far {data!r}")
        data += os.read(line, 1)
    return data.decode("ascii")


def asks(line, text):
    os.write(line, frame(text).encode("ascii"))
    return unframe(until_return(line))


def opened(device):
    line = os.open(device, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(line)
    return line


def check(scanbound):
    """Both sides: `serve --pty` asked from here, and `live --hostlink` answered from here."""
    with tempfile.TemporaryDirectory() as directory:
        program = pathlib.Path(directory, "a.il")
        program.write_text("LD 00000\nTIM 005 #0050\nLD TIM005\nOUT 00500\nLD 00000\nMOV(21) #1234 DM 0003\nEND(01)\n")
        link = pathlib.Path(directory, "plc")
        server = subprocess.Popen(
            [scanbound, "serve", str(program), "--dialect", "omron-c200h", "--cpu", "C200H", "--pty", str(link),
             "--unit", "7", "--set", "00000=1", "--for", "60s"], stderr=subprocess.DEVNULL)
        try:
            while not link.exists():
                time.sleep(0.05)
            line = opened(link)
            time.sleep(0.5)
            assert asks(line, "07TShello") == "07TShello"
            assert asks(line, "07MS") == "07MS000200"
            assert asks(line, "07RR00000001") == "07RR000001"
            assert asks(line, "07RD00030001") == "07RD001234"
            assert asks(line, "07R#TIM 0005") == "07R#000050"
            before = asks(line, "07RC00050001")
            time.sleep(1.0)
            after = asks(line, "07RC00050001")
            gone = int(before[6:]) - int(after[6:])
            assert 8 <= gone <= 13, (before, after)
            assert asks(line, "07RG00050001") == "07RG000"
            assert asks(line, "07WD00001234") == "07WD16"
            os.write(line, b"@07MS00*\r")
            assert unframe(until_return(line)) == "07MS13"
            os.write(line, frame("08MS").encode("ascii"))
            try:
                answer = until_return(line, 0.3)
                raise AssertionError(f"another unit's request was answered: {answer!r}")
            except TimeoutError:
                pass
        finally:
            server.kill()
            server.wait()
    own, other = pty.openpty()
    tty.setraw(other)
    live = subprocess.Popen(
        [scanbound, "live", "--hostlink", os.ttyname(other), "--baud", "9600", "--cpu", "C200H", "--for", "1s",
         "--bound", "100ms"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    asked = set()
    while live.poll() is None:
        if select.select([own], [], [], 0.1)[0]:
            text = unframe(until_return(own))
            asked.add(text)
            # AR 26 and AR 27: the longest and the last scan, in tenths of a millisecond, decimal digits.
            answer = {"RJ0026": "00RJ000034", "RJ0027": "00RJ000021"}.get(text[2:8])
            os.write(own, frame(answer or unit_answer(text)).encode("ascii"))
    out, err = live.communicate()
    assert live.returncode == 0, err
    assert "3.4 ms" in out, out
    assert {"00MS", "00RJ00270001", "00RJ00260001"} <= asked, asked
    print("both sides agree with this script")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("frames")
    ask = commands.add_parser("ask")
    ask.add_argument("device")
    ask.add_argument("unit", nargs="?", default="00")
    both = commands.add_parser("check")
    both.add_argument("--scanbound", required=True)
    arguments = parser.parse_args()
    if arguments.command == "frames":
        frames()
    elif arguments.command == "ask":
        line = opened(arguments.device)
        for text in ["MS", "RR00000010", "RC00000010", "RG00000010"]:
            print(asks(line, arguments.unit + text))
    else:
        check(arguments.scanbound)


if __name__ == "__main__":
    sys.exit(main())
