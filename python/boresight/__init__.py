"""Boresight angles and lever arms of survey sensors by least-squares adjustment, with standard deviations that hold.

>>> import boresight as bs
>>> simulated = bs.simulate(bs.demo("usbl"))
>>> result = bs.calibrate(simulated.survey)
>>> result.usable, list(result.parameters)[:3]
(True, ['pitch', 'roll', 'yaw'])
"""

from . import adjust
from ._apply import Applied, apply
from ._budget import Budget, Plan, budget, plan
from ._campaign import Campaign
from ._core import VERSION as __version__
from ._errors import AdjustmentError, BoresightError, Fault, InputError, InternalError, LedgerError
from ._observe import (
    Extra,
    Face,
    LaserNoise,
    LaserScan,
    Mounting,
    Pose,
    SonarNoise,
    Soundings,
    Target,
    Trajectory,
    TrajectoryNoise,
    Utm,
)
from ._progress import Progress, bar
from ._result import Finding, FoundMounting, Parameter, Result, Solution, read_result
from ._survey import (
    Cloud,
    Preview,
    Residuals,
    Simulated,
    SoundSpeed,
    Survey,
    calibrate,
    check,
    cloud,
    demo,
    georeference,
    read_survey,
    residuals,
    simulate,
)
from ._trials import Cell, Trials, read_trials

__all__ = [
    "AdjustmentError",
    "Applied",
    "BoresightError",
    "Budget",
    "Campaign",
    "Cell",
    "Cloud",
    "Extra",
    "Face",
    "Fault",
    "Finding",
    "FoundMounting",
    "InputError",
    "InternalError",
    "LaserNoise",
    "LaserScan",
    "LedgerError",
    "Mounting",
    "Parameter",
    "Plan",
    "Pose",
    "Preview",
    "Progress",
    "Residuals",
    "Result",
    "Simulated",
    "Solution",
    "SonarNoise",
    "SoundSpeed",
    "Soundings",
    "Survey",
    "Target",
    "Trajectory",
    "TrajectoryNoise",
    "Trials",
    "Utm",
    "__version__",
    "adjust",
    "apply",
    "bar",
    "budget",
    "calibrate",
    "check",
    "cloud",
    "demo",
    "georeference",
    "plan",
    "read_result",
    "read_survey",
    "read_trials",
    "residuals",
    "simulate",
]
