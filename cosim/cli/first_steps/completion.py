"""``cohaptic completion``: what makes a shell complete commands, scenarios, runs and signals."""

from __future__ import annotations

import click

from cosim.cli.support.command import JsonCommand

SHELLS = ("bash", "zsh", "fish")


@click.command("completion", cls=JsonCommand)
@click.argument("shell", type=click.Choice(SHELLS))
@click.pass_context
def command(ctx: click.Context, shell: str) -> None:
    """Print the completion script of SHELL.

    bash: eval "$(cohaptic completion bash)" in ~/.bashrc; zsh: the same in ~/.zshrc, after
    compinit; fish: cohaptic completion fish > ~/.config/fish/completions/cohaptic.fish
    """
    from click.shell_completion import get_completion_class

    found = get_completion_class(shell)
    assert found is not None
    click.echo(found(ctx.find_root().command, {}, "cohaptic", "_COHAPTIC_COMPLETE").source())
