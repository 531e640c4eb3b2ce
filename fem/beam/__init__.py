"""The field of a finite aperture in three dimensions, from the section's charges and guided modes.

charges (of the electrodes) - line_source (modes sent by a line of charge) - lateral (integral over k_y) - own_aperture
(a transducer's response to its own charges) - reception (of beams by other transducers) - faces (reflecting ends) -
surface_beam (where the charges become a beam) - rows, mutual_admittance, crossed_beam (turned transducers).
"""
