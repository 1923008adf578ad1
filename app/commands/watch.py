"""``flexura watch``: a web page of running campaigns, and messages."""

from pathlib import Path
from typing import Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import PATH, require_campaigns, telling_options
from app.commands.output import Output, output_options

EXAMPLES = """\b
Examples:
  flexura watch my-campaign
  flexura watch left-rig right-rig --notify 'ntfy://$TOPIC' --notify @messages.txt
  flexura watch my-campaign --notify-command 'notify-send --urgency critical Flexura'
  flexura watch my-campaign --host 0.0.0.0 --token-file ~/.flexura-token
"""


@click.command(name="watch", epilog=EXAMPLES, short_help="A web page of running campaigns; messages.")
@click.argument("campaigns", type=PATH, nargs=-1, required=True, metavar="CAMPAIGN...")
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to listen at; others need a token.")
@click.option("--port", type=click.IntRange(1, 65535), help="Port (default: the first free one from 8750 on).")
@click.option(
    "--token-file", type=PATH, metavar="FILE", help="Token that the page asks for; made, mode 600, if not there."
)
@telling_options
@click.option("--wait", is_flag=True, help="Wait for campaigns that have not begun yet.")
@click.option(
    "--beside", is_flag=True, hidden=True, help="End with the campaign, once the standard input has ended."
)
@output_options("the page's address")
@bad_input
def command(
    campaigns: tuple[Path, ...],
    host: str,
    port: int | None,
    token_file: Path | None,
    notify: tuple[str, ...],
    notify_command: tuple[str, ...],
    wait: bool,
    beside: bool,
    output: Output,
) -> None:
    """Show CAMPAIGNs, as flexura acquire records them, on a web page for any browser or telephone.

    Hammer tests too: which hit is waited for, how many count and were rejected.

    Temperatures, set-point and limits, progress and expected end, the last FRF and its coherence, what clips, the
    state of the rig, the log in words. The page needs no internet, and only reads: a campaign is paused or stopped
    in its terminal or with flexura view. /metrics has the numbers for Prometheus, /status.json for scripts.

    It is served to this computer only; with --host to others, who need the token of --token-file or of the
    variable FLEXURA_WATCH_TOKEN.

    --notify and --notify-command tell when a campaign has finished or stopped, when something is NOT AT REST, a
    sweep was given up, a limit is approached, or nothing was written for longer than a sweep and a margin. It ends
    with Ctrl-C; campaigns do not notice.
    """
    require_campaigns(campaigns, wait=wait)
    from app.watch.notifiers import SecretError, notifiers, page_token
    from app.watch.server import is_loopback
    from app.watch.watcher import require_acquired
    from app.watch.watching import CampaignsProcess, Page, Watching

    for one in campaigns:
        if not (wait and not one.exists()):
            require_acquired(one)
    token = page_token(token_file, campaigns)
    if token is None and not is_loopback(host):
        raise SecretError(
            f"--host {host}: others than this computer need a token; name its file, --token-file FILE, or set "
            "FLEXURA_WATCH_TOKEN"
        )
    told = notifiers(notify, notify_command, campaigns)
    started_by = CampaignsProcess() if beside else None
    complain = output.note if started_by is None else started_by.note
    watching = Watching(campaigns, Page(host, port, token), told, complain)
    record: dict[str, Any] = {"url": watching.url, "campaigns": [str(one) for one in campaigns]}
    output.result(lambda: record | {"token": token is not None})
    needs = ", with its token" if token is not None else ""
    output.summary(f"the page: {watching.url}{needs}; Ctrl-C ends it, campaigns go on")
    if started_by is not None:
        started_by.leave_streams()
    watching.run(started_by)
