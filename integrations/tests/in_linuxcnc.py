#!/usr/bin/python3
"""What `.ci/linuxcnc` starts in the place of a user interface: it opens programs as one does, through the
filter that the INI file names, hands them to the running LinuxCNC, and reads the notices that come.
ROOM is a folder with programs and answers."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
import traceback
from pathlib import Path

import linuxcnc

ROOM = Path(os.environ["ROOM"])
PROGRESS = re.compile(r"^FILTER_PROGRESS=(\d*)$")

INI = linuxcnc.ini(os.environ["INI_FILE_NAME"])


def filtered(program: Path) -> tuple[int, bytes, list[int], str]:
    """A program through the filter of its ending: exit code, output, progress, what else was said."""
    filter_ = INI.find("FILTER", program.suffix[1:])
    done = subprocess.run(["sh", "-c", f"{filter_} '{program}'"], capture_output=True, check=False)
    lines = done.stderr.decode().splitlines()
    found = [PROGRESS.match(line) for line in lines]
    said = [line for line, match in zip(lines, found, strict=True) if not match]
    return done.returncode, done.stdout, [int(match[1]) for match in found if match], "\n".join(said)


def notices(channel: linuxcnc.error_channel) -> list[str]:
    """What LinuxCNC shows its user."""
    time.sleep(0.5)
    found = []
    while message := channel.poll():
        found.append(message[1])
    return found


def main() -> None:
    """All of it."""
    control, state, channel = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
    notices(channel)
    answer = (ROOM / "answer").read_text()
    for name in ("good.ngc", "bad.ngc"):
        code, out, progress, said = filtered(ROOM / name)
        assert code == 0 and out == (ROOM / name).read_bytes(), (name, code, said)
        assert progress and progress[-1] == 100 and progress == sorted(progress), progress
        told = notices(channel)
        if name == "good.ngc":
            assert "within tolerance" in said and not told, (said, told)
        else:
            assert "OUT OF tolerance" in said and answer in said, (answer, said)
            assert told == [said.splitlines()[0]], (told, said)
        # LinuxCNC takes what came out.
        ready = ROOM / f"filtered-{name}"
        ready.write_bytes(out)
        control.mode(linuxcnc.MODE_AUTO)
        control.wait_complete()
        control.program_open(str(ready))
        control.wait_complete()
        time.sleep(0.2)
        state.poll()
        assert state.file == str(ready), state.file
    # The other ending stops: nothing comes out, and the user is told.
    code, out, _, said = filtered((ROOM / "bad.ngc").rename(ROOM / "bad.nc"))
    assert code == 1 and out == b"" and "is not loaded" in said, said
    # What cannot be judged is loaded with a notice, and refused where it has to be within tolerance.
    code, out, _, said = filtered(ROOM / "wrong.ngc")
    told = notices(channel)
    assert code == 0 and out and len(told) == 1 and "not checked" in told[0], (code, told, said)
    code, out, _, said = filtered((ROOM / "wrong.ngc").rename(ROOM / "wrong.nc"))
    assert code == 2 and out == b"" and "wrong.nc" in said, said
    print("linuxcnc: programs go through the filter into the running LinuxCNC", flush=True)
    (ROOM / "done").touch()


try:
    main()
except BaseException:  # noqa: BLE001 - whatever it is, it is told and ends the program
    traceback.print_exc()
    sys.exit(1)
