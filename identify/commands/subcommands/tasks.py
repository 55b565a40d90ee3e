"""The tasks of `unspool`, with what each does; every one is a file beside this."""

TASKS = {
    "init": "write commented templates: model, film, campaign, columns of the bench",
    "demo": "the whole way on shipped data: film and loops in, a named effect out",
    "check": "read files of any kind, report everything that is wrong in them, and what was understood",
    "effects": "list the physical effects that can be missing, or describe one",
    "run": "a whole campaign from raw files: measure films, fit loops, compare, explain",
    "fmu": "the force law of a leg as an FMU, for other simulation tools",
    "completion": "print what makes a shell complete commands and options",
}
