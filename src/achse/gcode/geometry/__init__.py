"""Where the path is: circles, contours, the cutter beside them, the frame of the workpiece."""
