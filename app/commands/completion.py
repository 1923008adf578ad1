"""``flexura completion``: shell completion of verbs, options and file names."""

import click
from click.shell_completion import get_completion_class

EXAMPLES = """\b
Examples:
  flexura completion bash >> ~/.bashrc
  flexura completion zsh >> ~/.zshrc
  flexura completion fish > ~/.config/fish/completions/flexura.fish
"""


@click.command(name="completion", epilog=EXAMPLES, short_help="Make the Tab key complete verbs and options.")
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
@click.pass_context
def command(context: click.Context, shell: str) -> None:
    """Print the lines that make SHELL complete verbs, options and file names.

    They work only where the command flexura is found, so in a shell with the environment active. Open a new shell
    after adding them. In zsh, compinit has to have run before.
    """
    kind = get_completion_class(shell)
    if kind is None:
        raise click.UsageError(f"click has no completion for {shell}")
    click.echo(kind(context.find_root().command, {}, "flexura", "_FLEXURA_COMPLETE").source())
