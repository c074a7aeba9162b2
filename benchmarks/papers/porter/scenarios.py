"""The plants of Porter & Passino 1995 under a constant input (section 4.2, last paragraph)."""

from dataclasses import replace

from plant_sim.scenarios.glycolytic_oscillator import BASE
from plant_sim.scenarios.linear_second_order import TWO_COSINES
from plant_sim.signals import constant

FEED = constant(0.999)  # 1/s
LINEAR = replace(TWO_COSINES, name='linear_second_order_constant', inputs=FEED)
OSCILLATOR = replace(BASE, name='glycolytic_oscillator_constant', inputs=FEED)
