"""Geometry of the path: circles, contours, compensation of the cutter, frame of the workpiece."""
