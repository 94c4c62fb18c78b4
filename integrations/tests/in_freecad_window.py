"""What `.ci/freecad` runs in FreeCAD's window: the workbench, the command and its panel, and a picture.
ROOM is a folder with the document that `in_freecad.py` has left."""

from __future__ import annotations

import os
import sys
import traceback
from pathlib import Path

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

ROOM = Path(os.environ["ROOM"])
TOLERANCE_UM = 45.0


def settle(seconds: float = 0.5) -> None:
    """Lets the window draw."""
    loop = QtCore.QEventLoop()
    QtCore.QTimer.singleShot(int(1000 * seconds), loop.quit)
    loop.exec_()


def main() -> None:
    """All of it."""
    from lostmotion_freecad import document as shown
    from lostmotion_freecad.panel import CheckJob, Panel

    assert "LostmotionWorkbench" in FreeCADGui.listWorkbenches(), "the workbench is not there"
    FreeCADGui.activateWorkbench("LostmotionWorkbench")
    assert CheckJob.NAME in FreeCADGui.listCommands()
    window = FreeCADGui.getMainWindow()
    window.resize(1180, 860)
    document = FreeCAD.openDocument(str(ROOM / "checked.FCStd"))
    (path,) = [found for found in document.Objects if hasattr(found, "ErrorsUm")]
    # Made without a window, it is shown here, with its colours.
    assert path.ViewObject.Visibility and path.ViewObject.LineWidth == 4.0
    colours = [tuple(round(part, 2) for part in one[:3]) for one in path.ViewObject.LineColorArray]
    wanted = [shown.colour(error, path.ToleranceUm) for error in path.ErrorsUm]
    assert colours == [tuple(round(part, 2) for part in one) for one in wanted], colours[:3]
    FreeCADGui.runCommand(CheckJob.NAME)
    settle()
    dialogs = [
        found
        for found in window.findChildren(QtGui.QWidget)
        if found.windowTitle().startswith("Contour error of")
    ]
    assert dialogs, "the command has opened no panel"
    FreeCADGui.Control.closeDialog()
    panel = Panel(shown.job_of(document, []))
    FreeCADGui.Control.showDialog(panel)
    panel.machine.setEditText("vmc3-worn")
    panel.method.setCurrentIndex(panel.method.findData("none"))
    panel.tolerance.setValue(TOLERANCE_UM)
    panel.run_button.click()
    settle()
    result = panel.result
    assert result is not None and result.summary in panel.answer.text()
    assert panel.table.rowCount() == len(result.outside) > 0
    assert panel.table.item(0, 0).text() == result.outside[0].operation
    panel.table.selectRow(0)
    settle()
    (selected,) = FreeCADGui.Selection.getSelectionEx()
    assert selected.SubElementNames == (shown.edge_name(path, result.outside[0]),)
    FreeCADGui.Selection.clearSelection()
    for found in document.Objects:
        if (
            found.ViewObject is not None
            and found.Name != path.Name
            and hasattr(found.ViewObject, "Visibility")
        ):
            found.ViewObject.Visibility = found.Name == "Part"
    document.getObject("Part").ViewObject.Transparency = 70
    view = FreeCADGui.activeDocument().activeView()
    view.viewIsometric()
    FreeCADGui.SendMsgToActiveView("ViewFit")
    settle(1.0)
    # The panel needs some width.
    for dock in window.findChildren(QtGui.QDockWidget):
        if dock.objectName() == "Combo View":
            window.resizeDocks([dock], [560], QtCore.Qt.Horizontal)
        elif dock.objectName() in {"Report view", "Python console"}:
            dock.hide()
    FreeCADGui.SendMsgToActiveView("ViewFit")
    settle(1.0)
    view.saveImage(str(ROOM / "path.png"), 900, 640, "White")
    screen = QtGui.QApplication.primaryScreen()
    assert screen.grabWindow(0).save(str(ROOM / "window.png"))
    # A run that is ended leaves what there was.
    panel.bar.valueChanged.connect(lambda _: panel.stop())
    panel.run_button.click()
    assert panel.answer.text().startswith(("The run was ended", result.summary))
    os.write(1, b"\nfreecad: the window shows the path and the table\n")


try:
    main()
except BaseException:  # noqa: BLE001 - whatever it is, it is told and ends the program
    traceback.print_exc()
    sys.stdout.flush()
    os._exit(1)
os._exit(0)
