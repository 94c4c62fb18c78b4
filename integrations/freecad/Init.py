# Nothing to set up without a window: macros import the package `lostmotion_freecad`.
