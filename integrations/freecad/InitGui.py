"""The workbench, with one command. FreeCAD runs this file at its start, in a scope of its own: what its
functions need is imported inside them."""

import FreeCADGui


class LostmotionWorkbench(FreeCADGui.Workbench):
    """Contour errors of CAM jobs."""

    MenuText = "lostmotion"
    ToolTip = "Contour errors of CAM jobs on your machine"

    def __init__(self):
        import os

        import lostmotion_freecad

        folder = os.path.dirname(os.path.dirname(lostmotion_freecad.__file__))
        self.__class__.Icon = os.path.join(folder, "Resources", "lostmotion.svg")

    def Initialize(self):
        from lostmotion_freecad.panel import CheckJob

        FreeCADGui.addCommand(CheckJob.NAME, CheckJob())
        self.appendToolbar("lostmotion", [CheckJob.NAME])
        self.appendMenu("lostmotion", [CheckJob.NAME])

    def GetClassName(self):
        return "Gui::PythonWorkbench"


FreeCADGui.addWorkbench(LostmotionWorkbench())
