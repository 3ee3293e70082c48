"""A shift beside a robot: decide, observe, rest. Run again, it goes on where the journal stops.

Run with: python examples/beside_a_robot.py
"""

import fatigue_planner as fp

experiment = fp.load("paper")
scenario = fp.scenario(experiment, fp.simulate(experiment), "multiple_novice")
with fp.Session.open("shift.fatplan", scenario, deadline_s=0.05) as session:
    decision = session.worker("w-7f3a")  # a pseudonym, never a name
    for seen in ("arm", "back", None, "arm"):  # what the tracker recognised; None: nothing
        print(f"cycle {decision.cycle}: present it {decision.action} ({decision.reason})")
        decision = session.observe(decision.cycle, observation=seen, duration_s=16)
    # a recogniser that is not sure, of a cycle in which the robot did something else than it was told
    decision = session.observe(decision.cycle, executed="low", likelihood={"arm": 0.9, "back": 0.2}, duration_s=17.5)
    decision = session.rest(seconds=300)  # a pause of five minutes
    print(f"cycle {decision.cycle}: {decision.action}; on the disk up to event {decision.durable_up_to}")
    print(session.counts)
