"""Figures of simulations and the page that replays one."""
