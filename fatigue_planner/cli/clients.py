"""`fatplan live rehearse`, `ur`, `lsl` and `recognise`: processes of their own that talk to a server of a shift."""

import threading
from collections.abc import Mapping
from dataclasses import asdict
from datetime import datetime
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.live import ConditionName, PolicyName, need_server, policy_of, task_of
from fatigue_planner.cli.progress import progress, talk
from fatigue_planner.cli.shift_report import write_report
from fatigue_planner.core.errors import ExitCode, MissingExtraError, OutputFolderError, SelectionError, listed

if TYPE_CHECKING:
    from fatigue_planner.live.rehearsal.fault import Fault
    from fatigue_planner.live.rehearsal.rehearse import Rehearsal

NO_FAULT = "none"


def rehearse(
    experiment: options.ExperimentFile,
    journal: Annotated[Path, typer.Option("--journal", help="The journal to write; there must be none yet.")] = Path(
        "rehearsal.fatplan"
    ),
    cycles: Annotated[int, typer.Option("--cycles", min=1, max=100_000, help="How many cycles.")] = 1800,
    faults: Annotated[
        list[str] | None,
        typer.Option(
            "--fault",
            metavar="NAME[=RATE]",
            help="Only this fault, in this share of the cycles (repeatable); none: without. Default: all.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of the worker and the faults.")] = 1,
    speed: Annotated[
        float, typer.Option("--speed", min=0, help="How many times faster than real time; 0: as fast as it goes.")
    ] = 0.0,
    condition: ConditionName = None,
    policy: PolicyName = None,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Rehearse a shift of an EXPERIMENT: a real server, a simulated worker and robot, simulated time, and faults.

    The table says how often each fault came and what the server did. Exit code 3: it did not do what is right. The
    shift's report is written beside the journal.
    """
    need_server()
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.live.rehearsal.registry import FAULTS
    from fatigue_planner.live.rehearsal.rehearse import rehearse
    from fatigue_planner.live.rules import DEFAULT_POLICY
    from fatigue_planner.output.reports.page import REPORT_FILE
    from fatigue_planner.planners.registry import policy as policy_settings

    rates = {name: fault.rate for name, fault in FAULTS.items()} if faults is None else _rates(faults, FAULTS)
    if journal.exists():
        raise OutputFolderError(f"{journal}: is there already; a rehearsal begins a journal.")
    loaded = load_experiment(experiment)
    settings = policy_of(loaded, "policy", policy) or policy_settings(DEFAULT_POLICY)
    task = task_of(loaded, condition, cache, options.command_line("simulate", experiment, cache))
    words = [str(experiment), "--condition", task.name, "--cache", str(cache)]
    words += [] if policy is None else ["--policy", policy]
    words += [word for file in plugins or () for word in ("--plugin", str(file))]
    with progress("Rehearsed", cycles) as done:
        came = rehearse(
            journal, task, settings, words, cycles, rates, seed, speed,
            started=lambda page: talk().print(f"The operators' page: {page}", markup=False),
            advance=lambda number: done.advance(number, number),
        )  # fmt: skip
    report, _ = write_report(journal, experiment=experiment, cache=cache)
    document = {"journal": journal, "right": came.is_right, "report": report, **asdict(came)}
    options.present(document, f"{_table(came, journal)}\nThe shift's report: {report / REPORT_FILE}", as_json)
    if not came.is_right:
        raise typer.Exit(ExitCode.FAILED_PARTS)


Server = Annotated[str, typer.Option("--server", help="Address of `fatplan live serve`.")]
TokenFile = Annotated[Path, typer.Option("--token-file", help="File with the token to act: JOURNAL.act-token.")]
Authority = Annotated[
    Path | None, typer.Option("--authority", help="Certificates to trust, for https. Default: the system's.")
]


def ur(
    robot: Annotated[str, typer.Argument(metavar="ROBOT", help="Address of the robot's controller.")],
    poses: Annotated[
        str,
        typer.Option("--poses", help="The actions by their numbers in the robot's program, from 1, as high,low."),
    ],
    token_file: TokenFile,
    server: Server = "http://127.0.0.1:8765",
    authority: Authority = None,
    grace_s: Annotated[
        float,
        typer.Option("--grace", min=0, help="Seconds for the tracker when the robot asks for a new cycle."),
    ] = 0.5,
    silence_s: Annotated[
        float, typer.Option("--silence", min=0, help="Seconds without an echo after which the robot is unreachable.")
    ] = 60.0,
) -> None:
    """Tell a ROBOT of Universal Robots the poses, by RTDE, and a server what the robot does. Ctrl-C ends.

    Input registers: 42 the pose's number, then 43 the cycle's. Output registers: 36 the number of the pose that is
    executed (0: none), 37 its cycle's, 38 the cycle that the program asks for. The program keeps its own timer and
    default pose.
    """
    if find_spec("rtde_receive") is None:
        raise MissingExtraError("fatplan live ur needs ur-rtde: pip install 'fatigue-planner[ur]'.")
    from fatigue_planner.live.clients.connection import Address
    from fatigue_planner.live.clients.robot import RobotClient
    from fatigue_planner.live.clients.ur import UrLink

    names = [name.strip() for name in poses.split(",")]
    address = Address(server, token_file, authority)
    address.token()
    RobotClient(address, UrLink(robot), names, _say, grace_s, silence_s).run(threading.Event())


def lsl(
    stream: Annotated[str, typer.Argument(metavar="STREAM", help="Name of the recogniser's stream.")],
    token_file: TokenFile,
    server: Server = "http://127.0.0.1:8765",
    authority: Authority = None,
    out: Annotated[str, typer.Option("--out", help="Name of the stream of decisions.")] = "fatplan decisions",
    early_s: Annotated[
        float, typer.Option("--early", min=0, help="Samples stamped so soon after a cycle began are of the one before.")
    ] = 2.0,
) -> None:
    """Bring what a recogniser says by Lab Streaming Layer to a server, and its decisions back as markers. Ctrl-C ends.

    The STREAM has a sample per cycle: one text, the reaction; or a number per reaction, labelled, how likely what was
    measured is under it. Nobody is authenticated in such a network: it should be the cell's own.
    """
    _need_pylsl("lsl")
    from fatigue_planner.live.clients.connection import Address
    from fatigue_planner.live.clients.lsl import LslClient

    address = Address(server, token_file, authority)
    address.token()
    LslClient(address, stream, out, _say, early_s).run(threading.Event())


def recognise(
    recogniser: Annotated[Path, typer.Argument(metavar="RECOGNISER", help="File of `fatplan record recognise`.")],
    token_file: TokenFile,
    stream: Annotated[str, typer.Option("--stream", help="Name of the tracker's stream of joint angles.")],
    server: Server = "http://127.0.0.1:8765",
    authority: Authority = None,
    unit: Annotated[
        Literal["deg", "rad"] | None, typer.Option("--unit", help="Of all angles. Default: what the channels say.")
    ] = None,
    out: Annotated[
        str, typer.Option("--out", help="Name of the stream of likelihoods of the cycle going on.")
    ] = "fatplan likelihoods",
) -> None:
    """Recognise reactions in a tracker's stream of joint angles, and tell a server how likely each is. Ctrl-C ends.

    The tracker's stream (Lab Streaming Layer) has a number per channel, labelled as the digital human's degrees of
    freedom, with its unit. The server is told at the end of a cycle; what is known earlier goes out as text.
    """
    _need_pylsl("recognise")
    import pylsl

    from fatigue_planner.live.clients.angle_stream import AngleStream, outlet
    from fatigue_planner.live.clients.connection import Address
    from fatigue_planner.live.clients.recogniser import RecogniserClient
    from fatigue_planner.recordings.recognition.stored import load_recogniser

    known = load_recogniser(recogniser).recogniser()
    address = Address(server, token_file, authority)
    address.token()
    tracker = AngleStream(stream, unit, known.joints, known.least_rate_hz)
    client = RecogniserClient(address, known, tracker, pylsl.local_clock, outlet(out), _say)
    client.run(threading.Event())


def _need_pylsl(command: str) -> None:
    if find_spec("pylsl") is None:
        raise MissingExtraError(f"fatplan live {command} needs pylsl: pip install 'fatigue-planner[lsl]'.")


def _say(message: str) -> None:
    talk().print(f"{datetime.now():%H:%M:%S} {message}", markup=False)


def _rates(asked: list[str], known: "Mapping[str, Fault]") -> dict[str, float]:
    """By name, in which share of the cycles each fault is to happen. Raises SelectionError."""
    rates: dict[str, float] = {}
    for word in asked:
        name, _, text = word.partition("=")
        if name == NO_FAULT and len(asked) == 1 and not text:
            return {}
        if name not in known:
            raise SelectionError(f"--fault {word}: there is no such fault; available: {listed([*known, NO_FAULT])}.")
        try:
            rates[name] = float(text) if text else known[name].rate
        except ValueError:
            rates[name] = -1.0
        if not 0 <= rates[name] <= 1:
            raise SelectionError(f"--fault {word}: should be {name}=RATE with a rate from 0 to 1.")
    if sum(rates.values()) > 1:
        raise SelectionError(f"--fault: the rates' sum is {sum(rates.values()):g}; at most 1 fault comes per cycle.")
    return rates


def _table(came: "Rehearsal", journal: Path) -> str:
    """The rehearsal's table: fault, how often it came, what the server did, whether that is right."""
    lines = [("fault", "times", "what the server did", "right")]
    for row in came.rows:
        did = [f"{what} ({times})" for what, times in row.did.items()] or ["-"]
        right = f"no ({row.wrong})" if row.wrong else "yes" if row.times else "-"
        lines.append((row.fault, str(row.times), did[0], right))
        lines += [("", "", one, "") for one in did[1:]]
    name, times, what = (max(len(line[column]) for line in lines) for column in range(3))
    text = [f"{one:{name}}  {two:>{times}}  {three:{what}}  {four}".rstrip() for one, two, three, four in lines]
    wrong = len(came.wrong_inputs)
    said = f"{wrong} of {came.inputs} inputs are not what was said" if wrong else f"all {came.inputs} inputs are right"
    belief = "the belief is that of a shift without faults" if came.belief_is_right else "the belief is wrong"
    text += ["", f"{journal}: a rehearsal, {came.cycles} cycles, {came.seconds / 3600:.1f} h; {said}; {belief}."]
    return "\n".join([*text, *came.wrong_inputs[:3]])
