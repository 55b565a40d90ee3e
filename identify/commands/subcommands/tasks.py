"""The tasks of `unspool`, with what each does; every one is a file beside this."""

TASKS = {
    "demo": "the whole way on shipped data: film and loops in, a named effect out",
    "effects": "list the physical effects that can be missing, or describe one",
    "completion": "print what makes a shell complete commands and options",
}
