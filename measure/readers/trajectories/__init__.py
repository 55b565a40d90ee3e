"""Trajectories as other programs write them: markers of motion capture, and the table of a video tracker."""
