"""Force of a deep-groove ball bearing by the shared library: python3 example.py libballrace_c.so"""

import ctypes
import sys
from ctypes import POINTER, Structure, byref, c_double, c_float, c_uint32, c_uint64, c_void_p


class Element(Structure):
    _fields_ = [("cos", c_float), ("sin", c_float), ("azimuth", c_uint64)]


class Bearing(Structure):
    _fields_ = [("model", c_void_p), ("elements", POINTER(Element)), ("element_count", c_uint32)]


class Angular(Structure):
    _fields_ = [("head", Bearing), ("constants", c_float * 7)]


class Material(Structure):
    _fields_ = [("youngs_modulus", c_double), ("poissons_ratio", c_double)]


class Geometry(Structure):
    _fields_ = [
        ("ball_diameter", c_double),
        ("pitch_diameter", c_double),
        ("inner_conformity", c_double),
        ("outer_conformity", c_double),
        ("contact_angle", c_double),
        ("ball", Material),
        ("race", Material),
    ]


COUNT = 9
DATUM_CENTRED = 1

library = ctypes.CDLL(sys.argv[1])
library.ballrace_phase_from_revolutions.argtypes = [c_double]
library.ballrace_phase_from_revolutions.restype = c_uint64
library.ballrace_geometry_set_clearance.argtypes = [POINTER(Geometry), c_double, c_void_p]
library.ballrace_sample.argtypes = [c_void_p, c_void_p, c_float * 5, c_uint64, c_float * 5]

elements = (Element * COUNT)()
steel = Material(206e9, 0.3)
geometry = Geometry(7.94e-3, 39.04e-3, 0.52, 0.52, 0.0, steel, steel)
bearing = Angular()
last_valid = (c_uint64 * 4)()

status = library.ballrace_elements_evenly_spaced(elements, COUNT, c_uint64(0))
status |= library.ballrace_geometry_set_clearance(byref(geometry), 10e-6, None)
status |= library.ballrace_angular_init(byref(bearing), byref(geometry), DATUM_CENTRED, elements, COUNT, None)
status |= library.ballrace_last_valid_init(last_valid)
if status:
    sys.exit(f"error: set-up failed: status {status}")

for i in range(4):
    wrench = (c_float * 5)()
    displacement = (c_float * 5)(8e-6 * i, -2e-6, 30e-6, 0.0, 0.0)
    cage = library.ballrace_phase_from_revolutions(0.1 * i)
    status = library.ballrace_sample(byref(bearing.head), last_valid, displacement, cage, wrench)
    print(status, *(f"{x:.9g}" for x in wrench))
