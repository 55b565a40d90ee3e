"""`unspool completion`: what makes a shell complete the commands' options, tasks and effects; it asks the commands' own help."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from identify.commands.subcommands.tasks import TASKS
from measure.common.command_line import DONE, examples, parser, run

NAME = "unspool completion"
DOES = "Print what makes a shell complete options, tasks and effects. Put it where your shell reads it at its start."
COMMANDS = (
    "unspool",
    "track-video",
    "fit-actuator",
    "simulate-deployment",
    "sweep-deployments",
    "design-control",
    "design-deployment",
    "compare-model",
    "explain-gap",
)

_BASH = """\
_unspool() {
    local word=${COMP_WORDS[COMP_CWORD]} command=${COMP_WORDS[0]} task=
    [[ ${command##*/} == unspool && $COMP_CWORD -gt 1 ]] && task=${COMP_WORDS[1]}
    if [[ ${command##*/} == unspool && $COMP_CWORD -eq 1 && $word != -* ]]; then
        COMPREPLY=($(compgen -W "$("$command" --help 2>/dev/null | sed -n '/^tasks:/,/^$/s/^  \\([a-z]*\\) .*/\\1/p')" -- "$word"))
    elif [[ $word == -* ]]; then
        COMPREPLY=($(compgen -W "$("$command" $task --help 2>/dev/null | grep -oE -- '--[a-z][a-z-]+')" -- "$word"))
    elif [[ $task == effects || ${COMP_WORDS[COMP_CWORD-1]} == --effect ]]; then
        COMPREPLY=($(compgen -W "$(unspool effects 2>/dev/null | sed -n '/^$/q;s/ .*//p')" -- "$word"))
    elif [[ $task == completion ]]; then
        COMPREPLY=($(compgen -W "bash zsh fish" -- "$word"))
    fi
}
complete -o bashdefault -o default -F _unspool {commands}
"""
_FISH = """\
function __unspool_options
    set -l words (commandline -opc)
    set -l task
    test (path basename $words[1]) = unspool; and test (count $words) -gt 1; and set task $words[2]
    $words[1] $task --help 2>/dev/null | string match -ra -- '--[a-z][a-z-]+' | sort -u
end
for name in {commands}
    complete -c $name -a '(string match -q -- "-*" (commandline -ct); and __unspool_options)'
end
complete -c unspool -n '__fish_use_subcommand' -f -a '{tasks}'
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """The task."""
    return run(NAME, _work, arguments)


def _parser() -> Any:
    made = parser(NAME, DOES, output="write it to this file instead")
    made.add_argument("shell", nargs="?", choices=("bash", "zsh", "fish"), default="bash", help="default: %(default)s")
    return examples(made, "unspool completion bash >> ~/.bashrc", "unspool completion fish -o ~/.config/fish/completions/unspool.fish")


def _work(arguments: Sequence[str]) -> int:
    given = _parser().parse_args(arguments)
    text = script(given.shell)
    if given.output is not None:
        from measure.common.file_kinds import TEXT
        from measure.common.output import write_text
        from measure.common.output_gate import Outputs

        with Outputs({"--output": given.output}, kinds={"--output": TEXT}).held():
            write_text(given.output, text)
    elif not given.quiet:
        print(text, end="")
    return DONE


def script(shell: str) -> str:
    """The text that a shell reads.

    Parameters
    ----------
    shell : bash, zsh or fish.
    """
    text = _FISH if shell == "fish" else _BASH
    head = "autoload -U +X bashcompinit && bashcompinit\n" if shell == "zsh" else ""
    return head + text.replace("{commands}", " ".join(COMMANDS)).replace("{tasks}", " ".join(TASKS))
