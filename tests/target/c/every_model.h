// Made by `ballrace bake` from the scene "every model \u{5c} of C \u{3f}?/". Do not edit: bake the scene again.
//
// `ballrace verify` computes these fields and all constants again from the scene at the end of this file.
//: ballrace certificate begin
// program: ballrace 0.1.0
// language: c
// bearings: all
// scene: every model \u{5c} of C \u{3f}?/
// scene file: every_model.toml
// scene SHA-256: 124c039793a352b5111829be9548ba0e04b83596077d0a59494011a72b3adf4d
// poses from: simulation
// core: cortex-m4f
// arithmetic: f32, exact
// bearing_radial bearing: radial
// bearing_radial model: lumped, 9 elements
// bearing_radial poses: 1024, checksum
// bearing_radial reference: lumped, f64
// bearing_radial largest load: 1.564e0 N
// bearing_radial largest error: 3.2e-6 N
// bearing_radial largest relative error: 2.1e-6
// bearing_radial instructions: ~354
// bearing_radial cycles: ~696
// bearing_radial stack: ~180 bytes
// bearing_radial flash of code: ~1232 bytes
// bearing_radial flash of table: 0 bytes
// bearing_radial flash of other constants: 172 bytes
// bearing_radial checksum samples: 1024, 928 without contact, 0 outside the table
// bearing_radial checksum: 0xdc9e2bbd75c81242
// bearing_mixed bearing: mixed
// bearing_mixed model: lumped, 12 elements
// bearing_mixed poses: 512, simulation
// bearing_mixed reference: lumped, f64
// bearing_mixed largest load: 8.967e1 N
// bearing_mixed largest error: 9.3e-3 N
// bearing_mixed largest relative error: 1.1e-4
// bearing_mixed instructions: not counted
// bearing_mixed cycles: not counted
// bearing_mixed stack: not counted
// bearing_mixed flash of code: not counted
// bearing_mixed flash of table: 0 bytes
// bearing_mixed flash of other constants: 428 bytes
// bearing_mixed checksum samples: 1024, 85 without contact, 0 outside the table
// bearing_mixed checksum: 0x0828fda82f19f4a3
// bearing_lines bearing: lines
// bearing_lines model: lumped, 12 elements
// bearing_lines poses: 512, simulation
// bearing_lines reference: lumped, f64
// bearing_lines largest load: 5.605e1 N
// bearing_lines largest error: 5.8e-5 N
// bearing_lines largest relative error: 1.1e-6
// bearing_lines instructions: not counted
// bearing_lines cycles: not counted
// bearing_lines stack: not counted
// bearing_lines flash of code: not counted
// bearing_lines flash of table: 0 bytes
// bearing_lines flash of other constants: 424 bytes
// bearing_lines checksum samples: 1024, 615 without contact, 0 outside the table
// bearing_lines checksum: 0x3db5b51abc2498ed
// bearing_angular bearing: angular
// bearing_angular model: angular, 14 elements
// bearing_angular poses: 512, simulation
// bearing_angular reference: quasi-static, centrifugal, gyroscopic, f64
// bearing_angular largest load: 1.330e1 N
// bearing_angular largest error: 1.2e1 N
// bearing_angular largest relative error: 8.4e-1
// bearing_angular instructions: ~815
// bearing_angular cycles: ~1925
// bearing_angular stack: ~90 bytes
// bearing_angular flash of code: ~562 bytes
// bearing_angular flash of table: 0 bytes
// bearing_angular flash of other constants: 272 bytes
// bearing_angular checksum samples: 1024, 331 without contact, 0 outside the table
// bearing_angular checksum: 0xdd49449121949481
// bearing_springs bearing: springs
// bearing_springs model: linear, 9 elements
// bearing_springs poses: 1024, checksum
// bearing_springs reference: quasi-static, centrifugal, gyroscopic, f64
// bearing_springs largest load: 0.000e0 N
// bearing_springs largest error: 0.0e0 N
// bearing_springs largest relative error: -
// bearing_springs instructions: ~210
// bearing_springs cycles: ~369
// bearing_springs stack: ~72 bytes
// bearing_springs flash of code: ~726 bytes
// bearing_springs flash of table: 0 bytes
// bearing_springs flash of other constants: 140 bytes
// bearing_springs checksum samples: 1024, 0 without contact, 0 outside the table
// bearing_springs checksum: 0x25f9b93c55a6b325
// bearing_friction bearing: friction
// bearing_friction model: tabulated, 9 elements
// bearing_friction poses: 512, simulation
// bearing_friction reference: quasi-static, centrifugal, gyroscopic, film, f64
// bearing_friction largest load: 3.491e1 N
// bearing_friction largest error: 2.8e0 N
// bearing_friction largest relative error: 8.0e-2
// bearing_friction instructions: not counted
// bearing_friction cycles: not counted
// bearing_friction stack: not counted
// bearing_friction flash of code: not counted
// bearing_friction flash of table: 3024 bytes
// bearing_friction flash of other constants: 260 bytes
// bearing_friction checksum samples: 1024, 0 without contact, 0 outside the table
// bearing_friction checksum: 0xeb6d34dba6bd3e30
// bearing_balls bearing: balls
// bearing_balls model: tabulated, 11 elements
// bearing_balls poses: 512, simulation
// bearing_balls reference: quasi-static, centrifugal, gyroscopic, f64
// bearing_balls largest load: 3.461e1 N
// bearing_balls largest error: 9.1e0 N
// bearing_balls largest relative error: 2.7e-1
// bearing_balls instructions: ~3429
// bearing_balls cycles: ~6590
// bearing_balls stack: ~328 bytes
// bearing_balls flash of code: ~2118 bytes
// bearing_balls flash of table: 792 bytes
// bearing_balls flash of other constants: 292 bytes
// bearing_balls checksum samples: 1024, 24 without contact, 0 outside the table
// bearing_balls checksum: 0x7634b9aa123bb647
//: ballrace certificate end

#ifndef EVERY_MODEL_H
#define EVERY_MODEL_H

#include "ballrace.h"
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// Bearing "radial".

// Along Z from the rotor's centre of mass, m.
#define BEARING_RADIAL_STATION (-0.1f)
// Cage, ball and outer ring over shaft.
#define BEARING_RADIAL_CAGE_RATIO (0.4)
#define BEARING_RADIAL_BALL_RATIO (-0.0)
#define BEARING_RADIAL_OUTER_RATIO (0.0)
// Checksum of 1024 forces, computed on the desktop.
#define BEARING_RADIAL_CHECKSUM UINT64_C(0xdc9e2bbd75c81242)

// By preload, to be added to every displacement.
extern const float bearing_radial_offset[5];
// The bearing: `&bearing_radial.head` is the argument of all calls.
extern const ballrace_lumped_radial bearing_radial;
// Computes the checksum; every target returns BEARING_RADIAL_CHECKSUM. For start-up: 1024 forces.
uint64_t bearing_radial_checksum(void);

// Bearing "mixed".

// Along Z from the rotor's centre of mass, m.
#define BEARING_MIXED_STATION (-0.05f)
// Cage, ball and outer ring over shaft.
#define BEARING_MIXED_CAGE_RATIO (0.4)
#define BEARING_MIXED_BALL_RATIO (-0.0)
#define BEARING_MIXED_OUTER_RATIO (0.0)
// Checksum of 1024 forces, computed on the desktop.
#define BEARING_MIXED_CHECKSUM UINT64_C(0x0828fda82f19f4a3)

// By preload, to be added to every displacement.
extern const float bearing_mixed_offset[5];
// The bearing: `&bearing_mixed.head` is the argument of all calls.
extern const ballrace_lumped_radial_axial bearing_mixed;
// Computes the checksum; every target returns BEARING_MIXED_CHECKSUM. For start-up: 1024 forces.
uint64_t bearing_mixed_checksum(void);

// Bearing "lines".

// Along Z from the rotor's centre of mass, m.
#define BEARING_LINES_STATION (-0.05f)
// Cage, ball and outer ring over shaft.
#define BEARING_LINES_CAGE_RATIO (0.4)
#define BEARING_LINES_BALL_RATIO (-0.0)
#define BEARING_LINES_OUTER_RATIO (0.0)
// Checksum of 1024 forces, computed on the desktop.
#define BEARING_LINES_CHECKSUM UINT64_C(0x3db5b51abc2498ed)

// By preload, to be added to every displacement.
extern const float bearing_lines_offset[5];
// The bearing: `&bearing_lines.head` is the argument of all calls.
extern const ballrace_lumped_radial_axial bearing_lines;
// Computes the checksum; every target returns BEARING_LINES_CHECKSUM. For start-up: 1024 forces.
uint64_t bearing_lines_checksum(void);

// Bearing "angular".

// Along Z from the rotor's centre of mass, m.
#define BEARING_ANGULAR_STATION (0.05f)
// Cage, ball and outer ring over shaft.
#define BEARING_ANGULAR_CAGE_RATIO (0.4176083829966682)
#define BEARING_ANGULAR_BALL_RATIO (-2.6753278359233392)
#define BEARING_ANGULAR_OUTER_RATIO (0.0)
// Checksum of 1024 forces, computed on the desktop.
#define BEARING_ANGULAR_CHECKSUM UINT64_C(0xdd49449121949481)

// By preload, to be added to every displacement.
extern const float bearing_angular_offset[5];
// The bearing: `&bearing_angular.head` is the argument of all calls.
extern const ballrace_angular bearing_angular;
// Computes the checksum; every target returns BEARING_ANGULAR_CHECKSUM. For start-up: 1024 forces.
uint64_t bearing_angular_checksum(void);

// Bearing "springs".

// Along Z from the rotor's centre of mass, m.
#define BEARING_SPRINGS_STATION (0.1f)
// Checksum of 1024 forces, computed on the desktop.
#define BEARING_SPRINGS_CHECKSUM UINT64_C(0x25f9b93c55a6b325)

// By preload, to be added to every displacement.
extern const float bearing_springs_offset[5];
// The bearing: `&bearing_springs.head` is the argument of all calls.
extern const ballrace_linear bearing_springs;
// Computes the checksum; every target returns BEARING_SPRINGS_CHECKSUM. For start-up: 1024 forces.
uint64_t bearing_springs_checksum(void);

// Bearing "friction".

// Along Z from the rotor's centre of mass, m.
#define BEARING_FRICTION_STATION (0.12f)
// Cage, ball and outer ring over shaft.
#define BEARING_FRICTION_CAGE_RATIO (0.4176083829966682)
#define BEARING_FRICTION_BALL_RATIO (-2.6753278359233392)
#define BEARING_FRICTION_OUTER_RATIO (0.0)
// Checksum of 1024 forces, computed on the desktop.
#define BEARING_FRICTION_CHECKSUM UINT64_C(0xeb6d34dba6bd3e30)

// By preload, to be added to every displacement.
extern const float bearing_friction_offset[5];
// The bearing: `&bearing_friction.head` is the argument of all calls.
extern const ballrace_tabulated bearing_friction;
// Computes the checksum; every target returns BEARING_FRICTION_CHECKSUM. For start-up: 1024 forces.
uint64_t bearing_friction_checksum(void);

// Bearing "balls".

// Along Z from the rotor's centre of mass, m.
#define BEARING_BALLS_STATION (0.13f)
// Cage, ball and outer ring over shaft.
#define BEARING_BALLS_CAGE_RATIO (0.4176083829966682)
#define BEARING_BALLS_BALL_RATIO (-2.6753278359233392)
#define BEARING_BALLS_OUTER_RATIO (0.0)
// Checksum of 1024 forces, computed on the desktop.
#define BEARING_BALLS_CHECKSUM UINT64_C(0x7634b9aa123bb647)

// By preload, to be added to every displacement.
extern const float bearing_balls_offset[5];
// The bearing: `&bearing_balls.head` is the argument of all calls.
extern const ballrace_tabulated bearing_balls;
// Computes the checksum; every target returns BEARING_BALLS_CHECKSUM. For start-up: 1024 forces.
uint64_t bearing_balls_checksum(void);

#ifdef __cplusplus
}
#endif

#endif

// Text of the scene.
//: ballrace scene begin
// name = "every model \u{5c}\u{5c} of C \u{3f}?/"
// [shaft]
// speed = "3000 rpm"
// [rotor]
// mass = "6 kg"
// diametral_inertia = 0.03
// polar_inertia = 0.006
// damping = [400, 400, 400, 0.4, 0.4]
// load = [0, "-90 N", 60, 0, 0]
// [[bearing]]
// name = "radial"
// station = "-100 mm"
// facing = "-z"
// model = "lumped"
// elements = 9
// cage_ratio = 0.4
// stiffness = 8e9
// radial_play = "2 um"
// [[bearing]]
// name = "mixed"
// station = "-50 mm"
// model = "lumped"
// elements = 12
// cage_ratio = 0.4
// stiffness = 3e8
// exponent = 1.1111
// radial_play = "1 um"
// axial = { stiffness = 1e9, exponent = 1.4, play = "0 um", radius = "20 mm" }
// [[bearing]]
// name = "lines"
// station = "-50 mm"
// facing = "-z"
// model = "lumped"
// elements = 12
// cage_ratio = 0.4
// stiffness = 3e8
// exponent = 1.1111
// radial_play = "1 um"
// axial = { stiffness = 1e9, exponent = 1.1111, play = "0 um", radius = "20 mm" }
// [[bearing]]
// name = "angular"
// station = "50 mm"
// facing = "-z"
// model = "angular"
// elements = 14
// ball_diameter = "7 mm"
// pitch_diameter = "38.5 mm"
// inner_conformity = 0.52
// outer_conformity = 0.52
// contact_angle = "25 deg"
// [[bearing]]
// name = "springs"
// station = "100 mm"
// model = "linear"
// linearise = "angular"
// elements = 9
// ball_diameter = "7.94 mm"
// pitch_diameter = "39.04 mm"
// inner_conformity = 0.52
// outer_conformity = 0.52
// diametral_clearance = "10 um"
// [[bearing]]
// name = "friction"
// station = "120 mm"
// facing = "-z"
// model = "tabulated"
// elements = 9
// ball_diameter = "7 mm"
// pitch_diameter = "38.5 mm"
// inner_conformity = 0.52
// outer_conformity = 0.52
// contact_angle = "25 deg"
// effects = ["centrifugal", "gyroscopic", "film"]
// friction_sharing = "proportional"
// lubricant = { viscosity = "0.04 Pa s", pressure_viscosity = "2.2e-8 1/Pa" }
// table = { intervals = [6, 4, 3], approach = ["-5 um", "20 um"] }
// preload = { force = "50 N" }
// [[bearing]]
// name = "balls"
// station = "130 mm"
// facing = "+z"
// model = "quasi-static"
// elements = 11
// ball_diameter = "7 mm"
// pitch_diameter = "38.5 mm"
// inner_conformity = 0.52
// outer_conformity = 0.52
// contact_angle = "25 deg"
// table = { intervals = [8, 6, 2] }
//
//: ballrace scene end
