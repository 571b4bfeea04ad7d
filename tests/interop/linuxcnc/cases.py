"""Programs that both interpreters run. Those of the second dictionary are translated by hand."""

CASES: dict[str, str] = {
    "lines": "G1 X10 Y0 F600\nX20 Y5\nZ-3\nX0 Y0 Z0",
    "rapids": "G0 X10 Y20 Z30\nX0\nG1 X5 F100\nG0 Z0",
    "modal words stay": "G1 F600\nX1\nY1\nG0\nX0\nG1\nY0",
    "small and large numbers": "G1 F600 X0.0001 Y-0.0001\nX123456.789 Y-98765.4321\nX.5 Y-.5\nX+3.",
    "incremental": "G91 G1 X5 Y-2 F600\nX5\nY2 Z1\nG90 X0\nG91 Z-1",
    "arc by its centre": "G1 X10 F600\nG2 X20 Y10 I10 J0\nG3 X10 Y20 I-10 J0",
    "quarter arcs": (
        "G1 X10 F600\nG3 X0 Y10 I-10 J0\nX-10 Y0 I0 J-10\nX0 Y-10 I10 J0\nX10 Y0 I0 J10"
    ),
    "half circle": "G2 X10 Y0 I5 J0 F600",
    "three quarters": "G1 X10 F600\nG3 X0 Y-10 I-10 J0\nG2 X10 Y0 I0 J10",
    "full circle": "G1 X10 F600\nG2 X10 Y0 I-10 J0\nG3 X10 Y0 I5 J5",
    "full circle without ends": "G1 X10 F600\nG3 I-4 J3",
    "radius": "G2 X10 Y0 B10 F600\nG3 X20 Y0 B10\nX20 Y12 U6",
    "negative radius": "G2 X10 Y0 B-10 F600\nG3 X20 Y5 U-30",
    "half circle by radius": "G2 X10 Y0 B5 F600\nG3 X0 Y0 B5",
    "helix": "G1 X10 F600\nG2 X20 Y10 Z5 I10 J0\nG3 X10 Y20 Z-5 B10",
    "full turn of a helix": "G1 X10 F600\nG2 X10 Y0 Z5 I5 J0\nG3 X10 Y0 Z0 I0 J-7",
    "incremental arcs": "G91 G1 X10 F600\nG2 X10 Y10 I10 J0\nG3 X-10 Y10 Z1 B10",
    "arcs in ZX": "G18 G1 X10 F600\nG3 X20 Z10 I0 K10\nG2 X10 Z20 I-10 K0",
    "arcs in YZ": "G19 G1 Y10 F600\nG2 Y20 Z10 J10 K0\nG3 Y10 Z20 J-10 K0",
    "helices in ZX and YZ": "G18 G1 X10 F600\nG3 X20 Z10 Y4 I0 K10\nG19 G2 Y14 Z20 X5 J10 K0",
    "radius in ZX": "G18 G2 X10 Z10 B10 F600\nG3 X20 Z20 B-15",
    "radius in YZ": "G19 G2 Y10 Z10 B10 F600\nG3 Y20 Z20 B-15",
    "half circle in ZX": "G18 G2 X0 Z10 I0 K5 F600",
    "planes change": (
        "G17 G2 X10 Y10 I10 J0 F600\nG18 G2 X20 Z10 I10 K0\nG19 G2 Y20 Z20 J10 K0\nG17 G1 X0"
    ),
    "inches": "G70 G1 X1 Y2 F60\nG2 X2 Y3 I1 J0\nG71 G1 X10",
    "inches and feed": "G700 G1 X1 F10\nG91 X0.5 Y-0.25\nG710 X10",
    "zero shift": "G54\nG1 X1 Y1 Z1 F600\nG2 X11 Y11 I10 J0\nG53 G1 X0 Y0 Z0",
    "each zero shift": (
        "G1 F600 X1 Y1 Z1\nG54\nX1 Y1\nG55\nX1 Z1\nG56\nY1 Z1\nG57\nX1 Y1 Z1\nG53 X1"
    ),
    "a shift moves named axes only": "G1 X1 Y2 Z3 F600\nG54\nX4\nY4\nG55\nZ4\nG53 X0",
    "zero shift and increments": "G54\nG1 X1 Y1 Z1 F600\nG91 X5\nG55\nG90 X1 Y1 Z1\nG91 Y5",
    "programmed shift": "G54\nG58 X100 Y50 Z5\nG1 X1 Y1 Z1 F600\nG58 X0 Y0 Z0\nX1 Y1 Z1",
    "rotation": "ROT Z30\nG1 X10 Y0 F600\nX10 Y10\nG2 X20 Y10 I5 J0\nROT Z0\nG1 X0 Y0",
    "rotation about a zero shift": "G54\nROT Z45\nG1 X10 Y0 Z0 F600\nG3 X0 Y10 I-10 J0\nG1 X0 Y0",
    "rotation by quarters": "ROT Z90\nG1 X10 Y5 F600\nROT Z-90\nX10 Y5\nROT Z180\nX10 Y5",
    "rotation and helix": "ROT Z20\nG1 X5 Y5 F600\nG2 X15 Y15 Z5 I10 J0\nG91 X5 Y5 Z1 B8",
    "formulas": "R1=3+4*5 R2=2.5\nG1 X=R1 Y=R2*2 F600\nR3=R1-R2/0.5\nX=R3 Y=-R3",
    "formulas with functions": "R1=SIN(30)*20\nR2=COS(60)+SQRT(16)\nG1 X=R1 Y=R2 F600\nX=ABS(-7)",
    "arcs by formulas": "R1=10\nG1 X=R1 F600\nG2 X=R1+10 Y=R1 I=R1 J0\nG3 X=R1 Y=R1*2 B=R1",
    "dwell": "G1 X1 F600\nG04 X0.5\nX2",
    "exact stop": "G60 G1 X1 F600\nG09 X2\nG08 X3",
}

COMPENSATED: dict[str, str] = {
    "left, all kinds of corners": (
        "G1 X0 Y0 F600\nG41 D1 X10 Y10\nX30\nY30\nG2 X40 Y40 I10 J0\nG1 X60\nY20\nG40 X80 Y20"
    ),
    "right": "G1 X0 Y0 F600\nG42 D1 X10 Y10\nX30\nY-30\nX60 Y-40\nX80\nG40 X90 Y0",
    "outside of a square": (
        "G0 X-20 Y-20\nG1 F600\nG41 D1 X0 Y-5\nY40\nX40\nY0\nX-10\nG40 X-20 Y-20"
    ),
    "inside of a square": (
        "G0 X20 Y20\nG1 F600\nG41 D1 X20 Y0\nX40\nY40\nX0\nY0\nX22\nG40 X20 Y20"
    ),
    "acute corners": "G1 F600\nG41 D1 X10 Y0\nX40 Y2\nX10 Y8\nX40 Y30\nG40 X60",
    "obtuse corners": "G1 F600\nG42 D1 X10 Y0\nX20 Y1\nX30 Y3\nX40 Y2\nX50 Y0\nG40 X60 Y0",
    "tangential arcs": (
        "G1 F600\nG41 D1 X10 Y0\nX30\nG3 X40 Y10 I0 J10\nG1 Y30\nG2 X50 Y40 I10 J0\nG1 X70\nG40 X90"
    ),
    "arc meets line, outer": (
        "G1 F600\nG41 D1 X10 Y0\nG2 X30 Y0 I10 J0\nG1 X50\nG2 X70 Y0 I10 J0\nG1 X90 Y-5\nG40 X95 Y0"
    ),
    "arc meets arc, outer": (
        "G1 F600\nG41 D1 X10 Y10\nG2 X30 Y10 I10 J0\nX20 Y-5 B10\nG1 X0\nG40 X-10 Y0"
    ),
    "line meets arc, inner": ("G1 F600\nG42 D1 X10 Y0\nX40\nG3 X60 Y0 I10 J0\nG1 X90\nG40 X95 Y5"),
    "arcs outside and inside": (
        "G1 F600\nG42 D1 X10 Y0\nX20\nG3 X30 Y10 I0 J10\nG2 X40 Y20 I10 J0\nG1 Y40\nG40 X60"
    ),
    "with infeed": (
        "G1 F600\nG41 D1 X10 Y0\nX20 Z-1\nY20 Z-2\nG3 X0 Y40 Z-4 I-20 J0\nG1 X-20\nG40 X-30"
    ),
    "in ZX": "G18 G1 F600\nG41 D1 X10 Z0\nX30 Z10\nG3 X40 Z20 I10 K0\nG1 X60\nG40 X80 Z0",
    "incremental": "G91 G1 F600\nG41 D1 X10 Y0\nX20\nY-20\nX-30 Y-10\nG40 X-10",
    "rapids": "G0 X-5 Y-5\nG42 D1 X0 Y0\nG1 X20 F600\nG0 X40 Y-20\nG40 X60 Y0",
}

BY_HAND: dict[str, tuple[str, str]] = {
    "loop": (
        "F600\nR1=0\nN10 @151 R1 K4 K50\nG91 X1 Y=R1\n@620 R1\n@100 K-10\nN50 G90 X0",
        "F600\n#101=0\no1 while [#101 LE 4]\nG91 G1 X1 Y#101\n"
        "#101=[#101+1]\no1 endwhile\nG90 X0\nM2",
    ),
    "repeat": (
        "F600\nR1=0\nN10 G91 X2\n@620 R1\n@143 R1 K2 K-10\nN50 G90 Y1",
        "F600\n#1=0\no1 do\nG91 G1 X2\n#1=[#1+1]\no1 while [#1 LE 2]\nG90 Y1\nM2",
    ),
    "branch": (
        "F600\nR1=5\n@126 R1 K3 K20\nX1\nN20 Y1\n@123 R1 K3 K30\nX2\nN30 Y2",
        "F600\n#1=5\no1 if [#1 LE 3]\nG1 X1\no1 endif\n"
        "G1 Y1\no2 if [#1 GT 3]\nX2\no2 endif\nY2\nM2",
    ),
    "subroutine": (
        "F600\nL10 P3\nG90 G1 X0 Y0\nM30\nL10\nG91 G1 X5\nG2 X5 Y5 I5 J0\nM17",
        "o10 sub\nG91 G1 X5\nG2 X5 Y5 I5 J0\no10 endsub\nF600\no10 call\no10 call\no10 call\n"
        "G90 G1 X0 Y0\nM2",
    ),
    "angle of a line": (
        "G1 X1 Y2 F600\nX11 ANG=30\nY20 ANG=60",
        "G1 X1 Y2 F600\nX11 Y[2+10*TAN[30]]\nX[11+[20-2-10*TAN[30]]/TAN[60]] Y20\nM2",
    ),
    "circle through three points": (
        "G1 X10 F600\nCIP X20 Y10 I2.928932188 J7.071067812\nCIP X40 Y10 I10 J-10",
        "G1 X10 F600\nG2 X20 Y10 I10 J0\nG3 X40 Y10 I10 J0\nM2",
    ),
    "mirror": (
        "F600\nMIRROR X\nG1 X10 Y0\nG2 X20 Y10 I10 J0\nMIRROR\nG1 X1 Y1",
        "F600\nG1 X-10 Y0\nG3 X-20 Y10 I-10 J0\nG1 X1 Y1\nM2",
    ),
    "additive rotation": (
        "ROT Z20\nAROT Z25\nG1 X10 Y0 F600\nX0 Y0",
        "G10 L2 P1 R45\nG1 X10 Y0 F600\nX0 Y0\nM2",
    ),
    "two programmed shifts": (
        "G54\nG58 X100\nG59 X20 Y5\nG1 X1 Y1 Z1 F600",
        "G55\nG52 X120 Y5\nG1 X1 Y1 Z1 F600\nM2",
    ),
    "tool length": (
        "G17 D2 G1 X1 Z5 F600\nG17 P-1 D2 Z5\nD0 Z5",
        "G1 X1 Z55 F600\nZ-45\nZ5\nM2",
    ),
}
