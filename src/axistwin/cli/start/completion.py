"""`axistwin completion`: the scripts that complete commands, options, models and files in a shell."""

import click
from click.shell_completion import ShellComplete, get_completion_class

PROGRAM, VARIABLE = "axistwin", "_AXISTWIN_COMPLETE"
SHELLS = ("bash", "zsh", "fish", "powershell")


@click.command()
@click.argument("shell", type=click.Choice(SHELLS))
def completion(shell: str) -> None:
    """Print the completion script for SHELL: bash, zsh, fish or powershell.

    The script completes commands, options, models, scenes and programs.

    Add the line for your shell to its start-up file (in PowerShell: $PROFILE).

    \b
    Examples:
      bash          eval "$(axistwin completion bash)"
      zsh           eval "$(axistwin completion zsh)"
      fish          axistwin completion fish | source
      PowerShell    axistwin completion powershell | Out-String | Invoke-Expression
    """
    from axistwin.cli.program import axistwin  # An import at the top of the file would be circular.

    kind = get_completion_class(shell)
    assert kind is not None
    click.echo(ShellComplete.source(kind(axistwin, {}, PROGRAM, VARIABLE)))
