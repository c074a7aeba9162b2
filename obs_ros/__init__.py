"""Live estimation of hidden states and drifting parameters. Imports and runs without ROS."""

from obs_ros.estimate import Estimate, Outcome
from obs_ros.model import Model, Variable
from obs_ros.models import load_model
from obs_ros.observers import load_observer
from obs_ros.record import Record, Sample
from obs_ros.solve import solve_window
from obs_ros.window import SlidingWindow

__all__ = [
    'Estimate',
    'Model',
    'Outcome',
    'Record',
    'Sample',
    'SlidingWindow',
    'Variable',
    'load_model',
    'load_observer',
    'solve_window',
]
