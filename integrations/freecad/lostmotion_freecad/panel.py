"""The panel: what to simulate, a progress bar, and the table of what is out of tolerance."""

from __future__ import annotations

import os
from typing import Any

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

from . import document
from .check import COLUMNS, Result, check
from .errors import JobError, lostmotion
from .machine import PRESET, Taken, machine_of
from .program import program_of

__all__ = ["CheckJob", "Panel"]

SETTINGS = "User parameter:BaseApp/Preferences/Mod/lostmotion"
"""Where the last choice is kept."""

SHOWN = (0, 1, 4, 8, 2)
"""Columns of the table that fit into a panel: operation, command, error, cause, G-code."""

MACHINES = "Machines (*.toml *.fcm *.ini);;All files (*)"


class CheckJob:
    """The command: opens the panel for a job."""

    NAME = "Lostmotion_CheckJob"

    def GetResources(self) -> dict[str, str]:
        """Name, hint and picture."""
        return {
            "MenuText": "Contour error of a job",
            "ToolTip": "Simulates a CAM job on your machine, and shows the blocks that are out of tolerance",
            "Pixmap": os.path.join(os.path.dirname(os.path.dirname(__file__)), "Resources", "lostmotion.svg"),
        }

    def IsActive(self) -> bool:
        """Whether there is a document."""
        return FreeCAD.ActiveDocument is not None

    def Activated(self) -> None:
        """Opens the panel, or says why not."""
        try:
            selected = FreeCADGui.Selection.getSelection()
            panel = Panel(document.job_of(FreeCAD.ActiveDocument, selected))
        except JobError as error:
            complain(error)
            return
        FreeCADGui.Control.closeDialog()
        FreeCADGui.Control.showDialog(panel)


def complain(error: JobError) -> None:
    """Shows an error, and writes it into the report view."""
    FreeCAD.Console.PrintError(f"lostmotion: {error}\n")
    QtGui.QMessageBox.warning(FreeCADGui.getMainWindow(), "lostmotion", str(error))


class Panel:
    """A task panel for a job."""

    def __init__(self, job: Any) -> None:
        """Raises `JobError` where the Python package is missing."""
        package = lostmotion()
        self.job = job
        self.taken: Taken | None = None
        self.result: Result | None = None
        self.path: Any = None
        self.stopped = False
        self.running = False
        settings = FreeCAD.ParamGet(SETTINGS)

        self.form = QtGui.QWidget()
        self.form.setWindowTitle(f"Contour error of {job.Label}")
        layout = QtGui.QFormLayout(self.form)
        self.machine = QtGui.QComboBox()
        self.machine.setEditable(True)
        self.machine.addItems([*own_machine(job), *package.presets()])
        chosen = settings.GetString("Machine", PRESET)
        self.machine.setEditText(own_machine(job)[0] if own_machine(job) else chosen)
        browse = QtGui.QPushButton("File...")
        browse.clicked.connect(self.browse)
        row = QtGui.QHBoxLayout()
        row.addWidget(self.machine, 1)
        row.addWidget(browse)
        layout.addRow("Machine", row)
        self.method = QtGui.QComboBox()
        self.method.addItem("(of the machine)", "")
        for name, told in package.methods().items():
            self.method.addItem(name, name)
            self.method.setItemData(self.method.count() - 1, told, QtCore.Qt.ToolTipRole)
        self.method.setCurrentIndex(max(0, self.method.findData(settings.GetString("Method", ""))))
        layout.addRow("Method", self.method)
        self.tolerance = QtGui.QDoubleSpinBox()
        self.tolerance.setRange(0.0, 10000.0)
        self.tolerance.setSuffix(" um")
        self.tolerance.setSpecialValueText("(of the machine)")
        self.tolerance.setValue(settings.GetFloat("ToleranceUm", 0.0))
        layout.addRow("Tolerance", self.tolerance)
        self.preamble = QtGui.QLineEdit(settings.GetString("Preamble", ""))
        self.preamble.setPlaceholderText("G64 P0.01")
        layout.addRow("G-code before", self.preamble)
        self.run_button = QtGui.QPushButton("Simulate")
        self.run_button.clicked.connect(self.run)
        self.stop_button = QtGui.QPushButton("Stop")
        self.stop_button.setEnabled(False)
        self.stop_button.clicked.connect(self.stop)
        self.save_button = QtGui.QPushButton("Save machine...")
        self.save_button.setEnabled(False)
        self.save_button.clicked.connect(self.save)
        row = QtGui.QHBoxLayout()
        for button in (self.run_button, self.stop_button, self.save_button):
            row.addWidget(button)
        layout.addRow(row)
        self.bar = QtGui.QProgressBar()
        self.bar.setRange(0, 1000)
        layout.addRow(self.bar)
        self.answer = QtGui.QLabel()
        self.answer.setWordWrap(True)
        layout.addRow(self.answer)
        self.table = QtGui.QTableWidget(0, len(SHOWN))
        self.table.setHorizontalHeaderLabels([COLUMNS[place] for place in SHOWN])
        self.table.setEditTriggers(QtGui.QAbstractItemView.NoEditTriggers)
        self.table.setSelectionBehavior(QtGui.QAbstractItemView.SelectRows)
        self.table.setMinimumHeight(260)
        self.table.verticalHeader().hide()
        self.table.itemSelectionChanged.connect(self.pick)
        layout.addRow(self.table)

    def getStandardButtons(self) -> int:
        """A button to close."""
        close = QtGui.QDialogButtonBox.Close
        # A number of Qt 5, a flag with a number of Qt 6.
        return int(getattr(close, "value", close))

    def reject(self) -> bool:
        """Closes the panel, and ends a run."""
        self.stopped = True
        if not self.running:
            FreeCADGui.Control.closeDialog()
        return True

    def browse(self) -> None:
        """Asks for the file of a machine."""
        chosen = QtGui.QFileDialog.getOpenFileName(self.form, "Machine", "", MACHINES)[0]
        if chosen:
            self.machine.setEditText(chosen)

    def stop(self) -> None:
        """Ends the run."""
        self.stopped = True

    def progress(self, share: float) -> bool:
        """Shows how far the run is; the window stays alive."""
        self.bar.setValue(int(1000.0 * share))
        QtGui.QApplication.processEvents()
        return not self.stopped

    def run(self) -> None:
        """Simulates, and shows what came of it."""
        if self.running:
            return
        self.running, self.stopped = True, False
        self.run_button.setEnabled(False)
        self.stop_button.setEnabled(True)
        try:
            program = program_of(self.job, self.preamble.text())
            self.taken = machine_of(self.machine.currentText())
            method = self.method.itemData(self.method.currentIndex()) or ""
            self.result = check(program, self.taken, method, self.tolerance.value() or None, self.progress)
            self.path = document.show(self.job, program, self.result)
            self.tell(self.result)
            self.remember()
        except JobError as error:
            self.answer.setText(str(error))
            if not self.stopped:
                complain(error)
        finally:
            self.running = False
            self.run_button.setEnabled(True)
            self.stop_button.setEnabled(False)
            self.save_button.setEnabled(self.taken is not None)
            self.bar.reset()

    def tell(self, result: Result) -> None:
        """The answer, and the table."""
        self.answer.setText("\n".join([result.summary, *result.remarks]))
        FreeCAD.Console.PrintMessage(f"lostmotion: {result.summary}\n")
        outside = result.outside[: document.MAX_ROWS]
        self.table.setRowCount(len(outside))
        for row, block in enumerate(outside):
            shown = document.colour(block.error_um, result.tolerance_um)
            for column, place in enumerate(SHOWN):
                item = QtGui.QTableWidgetItem(str(block.cells[place]))
                if COLUMNS[place] == "Error um":
                    item.setForeground(QtGui.QBrush(QtGui.QColor.fromRgbF(*shown)))
                self.table.setItem(row, column, item)
        self.table.resizeColumnsToContents()

    def pick(self) -> None:
        """Selects the edge of the chosen row in the view."""
        if self.result is None or self.path is None:
            return
        rows = {item.row() for item in self.table.selectedItems()}
        outside = self.result.outside
        FreeCADGui.Selection.clearSelection()
        for row in sorted(rows):
            name = document.edge_name(self.path, outside[row])
            if name:
                FreeCADGui.Selection.addSelection(self.path.Document.Name, self.path.Name, name)

    def save(self) -> None:
        """Writes the machine as a machine file, to be edited."""
        if self.taken is None:
            return
        suggested = f"{self.taken.machine.name}.toml"
        chosen = QtGui.QFileDialog.getSaveFileName(
            self.form, "Machine file", suggested, "Machine files (*.toml)"
        )[0]
        if not chosen:
            return
        try:
            with open(chosen, "w", encoding="utf-8") as file:
                file.write(self.taken.toml or self.taken.machine.to_toml())
        except OSError as error:
            complain(JobError(f"{chosen} cannot be written: {error}.", "Choose another folder."))
            return
        self.machine.setEditText(chosen)

    def remember(self) -> None:
        """Keeps the choice for the next time."""
        settings = FreeCAD.ParamGet(SETTINGS)
        settings.SetString("Machine", self.machine.currentText())
        settings.SetString("Method", self.method.itemData(self.method.currentIndex()) or "")
        settings.SetFloat("ToleranceUm", self.tolerance.value())
        settings.SetString("Preamble", self.preamble.text())


def own_machine(job: Any) -> list[str]:
    """The file of the job's machine, if it names one that there is."""
    try:
        path = document.machine_of_job(job)
    except JobError as error:
        FreeCAD.Console.PrintWarning(f"lostmotion: {error}\n")
        return []
    return [path] if path else []
