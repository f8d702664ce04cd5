"""Prints the completion of `millprint` for bash. Example, once in a terminal or in ~/.bashrc:

eval "$(millprint completion)"
"""

from millprint.cli.commands import COMMANDS, parser_of
from millprint.run.plan import endings

SCRIPT = """_millprint() {{
    local word="${{COMP_WORDS[COMP_CWORD]}}"
    if [ "$COMP_CWORD" -eq 1 ]; then
        COMPREPLY=($(compgen -W "{commands}" -- "$word"))
    elif [ "${{COMP_WORDS[1]}}" = run ] && [ "$COMP_CWORD" -eq 2 ]; then
        COMPREPLY=($(compgen -W "{targets}" -- "$word"))
    fi
}}
complete -o default -F _millprint millprint"""


def main(arguments: list[str], name: str = "completion") -> None:
    """Print the script."""
    parser_of(name, __doc__).parse_args(arguments)
    print(SCRIPT.format(commands=" ".join(COMMANDS), targets=" ".join(endings())))
