; what a slicer puts first, and a layer
M73 P0 R12
M201 X9000 Y9000 Z500 E10000 ; sets maximum accelerations, mm/sec^2
M203 X500 Y500 Z12 E120
M204 P2000 R1500 T2000
M205 X10.00 Y10.00 Z0.20 E2.50
M107
;TYPE:Custom
G90 ; use absolute coordinates
M83 ; extruder relative mode
M104 S215
M140 S60
G28 W ; home all without mesh bed level
G80 ; mesh bed leveling
G1 Z0.2 F720
G92 E0.0
G1 X60.0 E9.0 F1000.0 ; intro line
G21 ; set units to millimeters
M900 K0.05
;LAYER_CHANGE
;Z:0.2
G1 Z.2 F7200
G1 E-.8 F2100
G1 X90.1 Y92.3 F7200
G1 E.8 F2100
M204 S800
G1 X119.9 Y92.3 E.93 F1200
G1 X119.9 Y117.7 E.79
G4 S1
M117 Layer 2
M104 S0 ; turn off temperature
M84 ; disable motors
M73 P100 R0
