"""What `.ci/freecad` runs inside FreeCAD, without a window: a job with a profile and a pocket is checked,
and what stands in the document is held against the command. Takes its paths from the environment:
LOSTMOTION is the command, ROOM a folder.
"""

from __future__ import annotations

import csv
import json
import math
import os
import subprocess
import sys
import traceback
from pathlib import Path
from typing import Any

import FreeCAD
import Part

ROOM = Path(os.environ["ROOM"])
TOLERANCE_UM = 45.0
COMMAND = os.environ["LOSTMOTION"]

from lostmotion_freecad import JobError, check_job, program_of
from lostmotion_freecad import document as shown
from lostmotion_freecad.check import COLUMNS


def say(text: str) -> None:
    """Prints past FreeCAD's own console, which keeps what it has at the end."""
    os.write(1, f"\n{text}\n".encode())


def operations() -> tuple[Any, Any, Any]:
    """FreeCAD's own modules of jobs, profiles and pockets, of whatever release."""
    try:
        from PathScripts import PathJob, PathPocketShape, PathProfile

        return PathJob, PathProfile, PathPocketShape
    except ImportError:
        from Path.Main import Job
        from Path.Op import PocketShape, Profile

        return Job, Profile, PocketShape


def make_job(document: Any) -> Any:
    """A plate with a round pocket: a job that cuts its outline and its pocket."""
    job_module, profile_module, pocket_module = operations()
    plate = document.addObject("Part::Box", "Plate")
    plate.Length, plate.Width, plate.Height = 60.0, 40.0, 10.0
    hole = document.addObject("Part::Cylinder", "Hole")
    hole.Radius, hole.Height = 12.0, 6.0
    hole.Placement.Base = FreeCAD.Vector(30.0, 20.0, 4.0)
    part = document.addObject("Part::Cut", "Part")
    part.Base, part.Tool = plate, hole
    document.recompute()
    job = job_module.Create("Job", [part], None)
    tool = job.Tools.Group[0]
    tool.HorizFeed, tool.VertFeed, tool.SpindleSpeed = "1800 mm/min", "300 mm/min", 8000.0
    model = job.Model.Group[0]
    profile_module.Create("Profile")
    pocket = pocket_module.Create("Pocket")
    # Its floor is the plane face at half height.
    floor = next(
        place
        for place, face in enumerate(model.Shape.Faces, 1)
        if math.isclose(face.BoundBox.ZMin, 4.0) and math.isclose(face.BoundBox.ZMax, 4.0)
    )
    pocket.Base = [(model, f"Face{floor}")]
    document.recompute()
    return job


def command_rows(program: str, machine: str, method: str) -> tuple[dict[str, Any], dict[int, dict[str, str]]]:
    """What the command says of the program: its document, and its worst row of each line that cuts."""
    part, out = ROOM / "job.ngc", ROOM / "out"
    part.write_text(program)
    done = subprocess.run(
        [COMMAND, "-q", "simulate", str(part), "-m", machine, "--method", method,
         "--tolerance-um", f"{TOLERANCE_UM}", "--format", "json", "--out", str(out)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode in (0, 1), done.stderr
    worst: dict[int, dict[str, str]] = {}
    with open(out / "blocks.csv", newline="") as file:
        for row in csv.DictReader(file):
            line = int(row["line"])
            if row["rapid"] in {"0", "false"} and (
                line not in worst or abs(float(row["max_um"])) > abs(float(worst[line]["max_um"]))
            ):
                worst[line] = row
    return json.loads(done.stdout), worst


def compare(job: Any, machine: str, method: str) -> None:
    """The document after a run holds what the command says."""
    told: list[float] = []
    result = check_job(job, machine, method=method, tolerance_um=TOLERANCE_UM, on_progress=told.append)
    (path,) = [found for found in job.Document.Objects if hasattr(found, "ErrorsUm")]
    figures, rows = command_rows(path.Program, machine, method)
    answer = figures["result"]
    assert round(result.max_um, 4) == answer["cutting"]["max"], (result.max_um, answer["cutting"])
    assert (path.MaxErrorUm, path.ToleranceUm, path.Method) == (result.max_um, TOLERANCE_UM, method)
    assert [block.line for block in result.blocks] == sorted(rows)
    for block in result.blocks:
        decimals = len(rows[block.line]["max_um"].partition(".")[2])
        assert abs(block.error_um - float(rows[block.line]["max_um"])) <= 0.51 * 10.0**-decimals, block
    # The edges are those of the path: as many, as long, each with its error.
    errors = {block.line: block.error_um for block in result.blocks}
    assert list(path.ErrorsUm) == [errors[line] for line in path.Lines]
    assert len(path.Shape.Edges) == len(path.Lines) == len(result.blocks)
    cut = figures["plan"]["cutting_mm"]
    assert abs(path.Shape.Length - cut) < 1e-4 * cut, (path.Shape.Length, cut)
    # The table has the blocks out of tolerance, the worst first, each with its operation and command.
    sheet, outside = path.Sheet, result.outside
    assert path.BlocksOutside == len(outside) and sheet.get("A1") == result.summary, sheet.get("A1")
    inside = len(result.blocks) - len(outside)
    assert inside > 0 and (len(outside) > 0) == (machine == "vmc3-worn"), result.summary
    assert [sheet.get(shown.cell(place, 4)) for place in range(len(COLUMNS))] == list(COLUMNS)
    by_label = {operation.Label: operation for operation in job.Operations.Group}
    for row, block in enumerate(outside, 5):
        cells = [sheet.get(shown.cell(place, row)) for place in range(len(COLUMNS))]
        assert tuple(cells) == block.cells, (cells, block.cells)
        source = by_label[block.operation].Path.Commands[block.command]
        assert source.Name == block.text.split()[0], (source, block)
        target = source.Parameters.get("X")
        assert target is None or f"X{round(target, 6):g}"[:6] in block.text, (source, block)
    assert {block.operation for block in result.blocks} == {"Profile", "Pocket"}
    assert told and max(told) <= 1.0
    say(f"{machine}, {method}: {result.summary}")


def refused(work: Any, *parts: str) -> None:
    """Something that has to be refused with these words."""
    try:
        work()
    except JobError as error:
        assert all(part in str(error) for part in parts), error
        assert error.hint or "did you mean" in error.message, error
    else:
        raise AssertionError(f"not refused: {parts}")


def main() -> None:
    """All of it."""
    document = FreeCAD.newDocument("Check")
    refused(lambda: shown.job_of(document, []), "no CAM job")
    refused(lambda: shown.job_of(None, []), "No document")
    job = make_job(document)
    assert shown.job_of(document, []) is job
    assert shown.job_of(document, [job.Operations.Group[0]]) is job
    compare(job, "vmc3-worn", "none")
    objects = len(document.Objects)
    compare(job, "vmc3", "fixed")
    assert len(document.Objects) == objects, "a second run takes the place of the first"
    # Of very many blocks the worst are drawn.
    most, shown.MAX_EDGES = shown.MAX_EDGES, 10
    result = check_job(job, "vmc3", method="none")
    (path,) = [found for found in document.Objects if hasattr(found, "ErrorsUm")]
    worst = sorted((abs(block.error_um) for block in result.blocks), reverse=True)[:10]
    assert sorted(map(abs, path.ErrorsUm), reverse=True) == worst and len(path.Shape.Edges) == 10
    assert "the worst 10 are drawn" in path.Remarks[-1]
    shown.MAX_EDGES = most
    # A machine as FreeCAD has it.
    axes = {
        letter: {
            "type": "linear", "role": role, "parent": None, "sequence": 0,
            "joint": {"origin": [0, 0, 0], "axis": [int(letter == other) for other in "XYZ"]},
            "limits": {"min": -150.0, "max": 150.0}, "max_velocity": 9000.0,
        }
        for letter, role in (("X", "table_linear"), ("Y", "table_linear"), ("Z", "head_linear"))
    }  # fmt: skip
    machine = ROOM / "Mill.fcm"
    machine.write_text(json.dumps({"machine": {"name": "Mill", "axes": axes}, "version": 1}))
    result = check_job(job, str(machine), method="none")
    assert result.machine == "Mill" and any("does not say" in remark for remark in result.remarks)
    # Whatever is wrong is said, and leaves the document as it was.
    before = {found.Name for found in document.Objects}
    refused(lambda: check_job(job, str(ROOM / "missing.fcm")), "missing.fcm", "cannot be read")
    refused(lambda: check_job(document.Plate), "no CAM job")
    refused(lambda: check_job(job, "vmc3", method="nome"), "nome")
    feed = job.Tools.Group[0].HorizFeed
    job.Tools.Group[0].HorizFeed = 0.0
    job.Tools.Group[0].VertFeed = 0.0
    document.recompute()
    refused(lambda: check_job(job, "vmc3"), "has no feed", job.Tools.Group[0].Label)
    job.Tools.Group[0].HorizFeed = feed
    job.Tools.Group[0].VertFeed = "300 mm/min"
    document.recompute()
    for operation in job.Operations.Group:
        operation.Active = False
    refused(lambda: program_of(job), "has no active operation")
    for operation in job.Operations.Group:
        operation.Active = True
    document.recompute()
    assert {found.Name for found in document.Objects} == before
    # What was saved is there again.
    compare(job, "vmc3-worn", "none")
    file = str(ROOM / "checked.FCStd")
    document.saveAs(file)
    FreeCAD.closeDocument(document.Name)
    again = FreeCAD.openDocument(file)
    (path,) = [found for found in again.Objects if hasattr(found, "ErrorsUm")]
    assert path.BlocksOutside == sum(abs(error) > path.ToleranceUm for error in path.ErrorsUm)
    assert isinstance(path.Shape, Part.Compound)
    say("freecad: the document holds the command's figures")


try:
    main()
except BaseException:  # noqa: BLE001 - whatever it is, it is told and ends the program
    traceback.print_exc()
    sys.stdout.flush()
    os._exit(1)
os._exit(0)
