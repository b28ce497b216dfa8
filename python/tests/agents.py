"""Agents in a file, for the command line."""

import os
import time

from openbench import Action, Briefing, GiveUp, Observation

print("what an agent prints")


class Ahead:
    """Drives ahead for two seconds, then gives up."""

    def begin(self, briefing: Briefing) -> None:
        pass

    def act(self, observation: Observation) -> Action:
        if observation.time >= 2.0:
            return GiveUp("enough", cause="door_not_found")
        return 0.3, 0.0


class Raises(Ahead):
    def act(self, observation: Observation) -> Action:
        raise ZeroDivisionError("in an agent")


class Exits(Ahead):
    def act(self, observation: Observation) -> Action:
        os._exit(7)


class Sleeps(Ahead):
    def act(self, observation: Observation) -> Action:
        time.sleep(60)
        return 0.0, 0.0
