; what slicers write
M140 S60
M104 S210
M82 ; absolute extrusion
G21
G28 X Y
G92 E0
M117 Printing "part 1"
G1 X10.5 Y10.5 E0.75 F1800
G1 X20 E1.5
M106 S255
G4 P100
G1 E-0.8 F2400
M84
