"""Inverse questions: what measurements say about a motor, how its answers depend on its numbers, which motor is best.

``fit`` estimates numbers of a scene from measured curves, says which of them the data cannot tell, and what to measure
next.  Every parameter that is positive is worked with as its logarithm.  Only scipy's solvers are used.
"""

from studies.inverse.fit_result import Fit
from studies.inverse.fitting import fit
from studies.inverse.free_parameters import Parameter, read_measurement, read_parameter
from studies.inverse.residual import Residual
from studies.lab.measurement import Measurement

__all__ = ["Fit", "Measurement", "Parameter", "Residual", "fit", "read_measurement", "read_parameter"]
