"""The result in the document: the path with coloured edges, and a spreadsheet of what is out of
tolerance. Works without a window; colours are kept with the path and shown where there is one."""

from __future__ import annotations

import math
import os
from typing import Any

import FreeCAD
import Part

from .check import COLUMNS, Block, Result
from .errors import JobError
from .machine import find_machine
from .program import JobProgram, Move

__all__ = ["attach_view", "colour", "job_of", "machine_of_job", "show"]

PATH = "ContourError"
SHEET = "ContourErrorTable"

MAX_ROWS = 1000
"""Most blocks in the spreadsheet and the panel: more than anyone reads."""

MAX_EDGES = 200_000
"""Most blocks that are drawn: an edge takes some 50 us to be made and shown."""

Colour = tuple[float, float, float]

COLOURS: list[tuple[float, Colour]] = [
    (0.5, (0.17, 0.48, 0.71)),
    (1.0, (0.0, 0.62, 0.60)),
    (2.0, (0.96, 0.55, 0.14)),
    (math.inf, (0.84, 0.10, 0.11)),
]
"""Colours up to that many times the tolerance: blue, green, orange, red."""

GROUP = "lostmotion"
"""Group of the properties."""

PROPERTIES = {
    "Job": ("App::PropertyLink", "The job"),
    "Machine": ("App::PropertyString", "Preset or file of the machine"),
    "Method": ("App::PropertyString", "Compensation method"),
    "ToleranceUm": ("App::PropertyFloat", "Tolerance of the contour error, um"),
    "MaxErrorUm": ("App::PropertyFloat", "Largest contour error of cutting moves, um"),
    "DurationS": ("App::PropertyFloat", "Length of the motion, s"),
    "BlocksOutside": ("App::PropertyInteger", "Blocks out of tolerance"),
    "Lines": ("App::PropertyIntegerList", "Line of the program of each edge"),
    "ErrorsUm": ("App::PropertyFloatList", "Contour error of each edge, um"),
    "Summary": ("App::PropertyString", "The answer"),
    "Remarks": ("App::PropertyStringList", "What to know of it"),
    "Program": ("App::PropertyString", "G-code that was simulated"),
}


class PathProxy:
    """Behaviour of the path: it is as it was made; another run makes another one."""

    def __init__(self, path: Any) -> None:
        path.Proxy = self

    def execute(self, path: Any) -> None:
        """Nothing to compute."""

    def onDocumentRestored(self, path: Any) -> None:
        """Colours are shown again where the document is opened in a window."""
        attach_view(path)

    def dumps(self) -> None:
        """No state of its own."""

    def loads(self, state: object) -> None:
        """No state of its own."""

    __getstate__ = dumps
    __setstate__ = loads


class ViewProxy:
    """Shows the path."""

    def __init__(self, view: Any) -> None:
        view.Proxy = self

    def getIcon(self) -> str:
        """The picture in the tree."""
        return os.path.join(os.path.dirname(os.path.dirname(__file__)), "Resources", "lostmotion.svg")

    def dumps(self) -> None:
        """No state of its own."""

    def loads(self, state: object) -> None:
        """No state of its own."""

    __getstate__ = dumps
    __setstate__ = loads


def colour(error_um: float, tolerance_um: float) -> Colour:
    """The colour of an error."""
    share = abs(error_um) / tolerance_um
    return next(shown for most, shown in COLOURS if share <= most)


def job_of(document: Any, selected: list[Any]) -> Any:
    """The job that is meant: the one that is selected, or that an operation of is; the only one of the
    document where none is.

    Raises `JobError` where there is none, or more than one.
    """
    if document is None:
        raise JobError("No document is open.", "Open one with a CAM job.")
    jobs = [found for found in document.Objects if is_job(found)]
    for chosen in selected:
        if is_job(chosen):
            return chosen
        for job in jobs:
            if chosen in job.Operations.Group:
                return job
    if len(jobs) == 1:
        return jobs[0]
    if jobs:
        names = ", ".join(job.Label for job in jobs)
        raise JobError(f"The document has {len(jobs)} jobs: {names}.", "Select one in the tree.")
    raise JobError(
        "The document has no CAM job.",
        "Make one: workbench CAM (Path before FreeCAD 1.0), New Job.",
    )


def is_job(thing: Any) -> bool:
    """Whether an object is a CAM job, of whatever release of FreeCAD."""
    names = ("Operations", "Tools", "Fixtures", "Model", "Stock")
    return all(hasattr(thing, name) for name in names)


def machine_of_job(job: Any) -> str:
    """Path of the file of the machine that a job names; empty where it names none, as before FreeCAD
    1.2. Raises `JobError` where there is no such file."""
    name = str(getattr(job, "Machine", "") or "")
    if name in {"", "<any>"}:
        return ""
    folders = machine_folders()
    found = find_machine(name, folders)
    if found is None:
        raise JobError(
            f"There is no file of the job's machine {name}.",
            "Name a machine or its file here. Searched: " + ", ".join(folders),
        )
    return found


def machine_folders() -> list[str]:
    """Where FreeCAD and its add-ons keep machines."""
    folders = []
    try:
        from Machine.models.machine import MachineFactory

        folders.append(str(MachineFactory.get_config_directory()))
    except ImportError:
        pass  # before FreeCAD 1.2
    folders.append(os.path.join(FreeCAD.getUserAppDataDir(), "Mod"))
    folders.append(os.path.join(FreeCAD.getHomePath(), "Mod", "CAM", "Machine"))
    return [folder for folder in folders if os.path.isdir(folder)]


def show(job: Any, program: JobProgram, result: Result) -> Any:
    """Puts a result into the document of the job, in place of an earlier one; answers the path."""
    document = job.Document
    document.openTransaction("Contour error")
    try:
        path, sheet = path_and_sheet(document, job)
        draw(path, job, program, result)
        fill(sheet, result)
    except Exception:
        document.abortTransaction()
        raise
    document.commitTransaction()
    document.recompute([path, sheet])
    attach_view(path)
    return path


def path_and_sheet(document: Any, job: Any) -> tuple[Any, Any]:
    """Those of an earlier run of the job, or new ones."""
    for path in document.Objects:
        if getattr(path, "Job", None) is job and hasattr(path, "ErrorsUm"):
            sheet = path.Sheet
            if sheet is not None:
                return path, sheet
    path = document.addObject("Part::FeaturePython", PATH)
    PathProxy(path)
    for name, (kind, told) in PROPERTIES.items():
        path.addProperty(kind, name, GROUP, told)
        # What a run found is not for editing.
        path.setEditorMode(name, 1)
    path.addProperty("App::PropertyLink", "Sheet", GROUP, "Blocks out of tolerance")
    path.Sheet = document.addObject("Spreadsheet::Sheet", SHEET)
    path.Job = job
    path.Label = f"Contour error of {job.Label}"
    path.Sheet.Label = f"Contour errors of {job.Label}"
    return path, path.Sheet


def draw(path: Any, job: Any, program: JobProgram, result: Result) -> None:
    """The path, an edge for each move that was judged."""
    blocks = result.blocks
    if len(blocks) > MAX_EDGES:
        blocks = sorted(blocks, key=lambda block: -abs(block.error_um))[:MAX_EDGES]
        result.remarks.append(f"Of {len(result.blocks)} blocks the worst {MAX_EDGES} are drawn.")
    errors = {block.line: block.error_um for block in blocks}
    edges, lines = [], []
    for move in program.moves:
        if move.line not in errors:
            continue
        edge = edge_of(move)
        if edge is not None:
            edges.append(edge)
            lines.append(move.line)
    path.Shape = Part.makeCompound(edges)
    path.Lines = lines
    path.ErrorsUm = [errors[line] for line in lines]
    path.Machine = result.source
    path.Method = result.method
    path.ToleranceUm = result.tolerance_um
    path.MaxErrorUm = result.max_um
    path.DurationS = result.duration_s
    path.BlocksOutside = len(result.outside)
    path.Summary = result.summary
    path.Remarks = result.remarks
    path.Program = program.text


def edge_of(move: Move) -> Any:
    """A move as an edge; none where it goes nowhere."""
    start, end = FreeCAD.Vector(*move.start), FreeCAD.Vector(*move.end)
    if move.centre is None:
        return Part.makeLine(start, end) if start.distanceToPoint(end) > 1e-7 else None
    centre, normal = FreeCAD.Vector(*move.centre), FreeCAD.Vector(*move.normal)
    out = start - centre
    radius = out.Length
    if radius < 1e-7:
        return Part.makeLine(start, end) if start.distanceToPoint(end) > 1e-7 else None
    across = normal.cross(out)
    there = end - centre
    angle = math.atan2(there.dot(across), there.dot(out))
    # An arc that ends where it starts is a full turn.
    if angle <= 1e-9:
        angle += 2.0 * math.pi
    rise = (end - start).dot(normal)

    def at(share: float) -> Any:
        turned = out * math.cos(share * angle) + across * math.sin(share * angle)
        return centre + turned + normal * (share * rise)

    if abs(rise) > 1e-7:
        # A helix, as a chain of chords short enough for the eye.
        count = max(4, math.ceil(angle / math.radians(7.5)))
        curve = Part.BSplineCurve()
        curve.interpolate([at(step / count) for step in range(count + 1)])
        return curve.toShape()
    if angle > 2.0 * math.pi - 1e-6:
        return Part.Circle(centre, normal, radius).toShape()
    return Part.Arc(start, at(0.5), at(1.0)).toShape()


def fill(sheet: Any, result: Result) -> None:
    """The spreadsheet: the answer, and the blocks out of tolerance, the worst first."""
    sheet.clearAll()
    outside = result.outside
    sheet.set("A1", result.summary)
    shown = outside[:MAX_ROWS]
    sheet.set(
        "A2", f"The {len(shown)} worst of {len(outside)} are listed." if len(shown) < len(outside) else ""
    )
    head = 4
    for place, name in enumerate(COLUMNS):
        sheet.set(cell(place, head), name)
    sheet.setStyle(f"A{head}:{cell(len(COLUMNS) - 1, head)}", "bold", "add")
    for row, block in enumerate(shown, head + 1):
        for place, value in enumerate(block.cells):
            # A quote makes a text of what could be read as a formula.
            sheet.set(cell(place, row), f"'{value}" if isinstance(value, str) else repr(value))
    for row, remark in enumerate(result.remarks, head + 2 + len(shown)):
        sheet.set(cell(0, row), f"'{remark}")


def cell(place: int, row: int) -> str:
    """Name of a cell: 0, 1 gives A1."""
    return f"{chr(ord('A') + place)}{row}"


def attach_view(path: Any) -> None:
    """Shows the colours where there is a window."""
    view = getattr(path, "ViewObject", None)
    if not FreeCAD.GuiUp or view is None:
        return
    if not isinstance(view.Proxy, ViewProxy):
        # Made without a window, or just now: later on it is hidden where the user has hidden it.
        ViewProxy(view)
        view.DisplayMode = "Wireframe"
        view.LineWidth = 4.0
        view.Visibility = True
    view.LineColorArray = [colour(error, path.ToleranceUm) for error in path.ErrorsUm]


def edge_name(path: Any, block: Block) -> str:
    """Name of the edge of a block; empty where it has none."""
    lines = list(path.Lines)
    return f"Edge{lines.index(block.line) + 1}" if block.line in lines else ""
