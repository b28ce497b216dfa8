"""Benchmark and baseline of delivery robots that find the right front door."""

from openbench import _openbench
from openbench._openbench import (
    InputError,
    OpenBenchError,
    PlanningError,
    ProtocolError,
    __version__,
)
from openbench.agent import (
    Action,
    Address,
    Agent,
    Briefing,
    Deliver,
    Drive,
    GiveUp,
    Observation,
    Scan,
)
from openbench.evaluation import evaluate
from openbench.registration import make, register_environments
from openbench.results import deliveries, to_pandas, to_polars

__all__ = [
    "Action",
    "Address",
    "Agent",
    "Briefing",
    "Deliver",
    "Drive",
    "GiveUp",
    "InputError",
    "Observation",
    "OpenBenchError",
    "PlanningError",
    "ProtocolError",
    "Scan",
    "__version__",
    "deliveries",
    "evaluate",
    "make",
    "to_pandas",
    "to_polars",
]

_openbench.set_module(_openbench.__file__)
register_environments()
