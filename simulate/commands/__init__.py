"""The commands of this room, one file each."""

from measure.common.running.interrupts import watch_while_loading

watch_while_loading()  # before anything that takes time to load
