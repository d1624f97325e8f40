/*
 * ballrace: forces of rolling bearings and motion of rotors in fixed time.
 *
 * Frame: X, Y radial, Z along the shaft, right-handed. SI units. Angles are 2^-64 revolutions.
 * Made by cbindgen from kernel/c/src; the tests compare it with the source.
 */

#ifndef BALLRACE_H
#define BALLRACE_H

#include <stddef.h>
#include <stdint.h>

struct ballrace_bearing;

/**
 * Version of the structs in the header.
 *
 * The states of the library store it: a state of another version is rejected with `BALLRACE_STATE_INVALID`.
 */
#define BALLRACE_ABI_VERSION 1

/**
 * Zero displacement: the rings just touch the balls at the contact angle. For angular-contact bearings.
 */
#define BALLRACE_DATUM_TOUCHING 0

/**
 * Zero displacement: the rings are concentric and centred axially. For deep-groove bearings.
 */
#define BALLRACE_DATUM_CENTRED 1

/**
 * No flag.
 */
#define BALLRACE_OK 0

/**
 * An input is NaN or infinite; the result is the last valid value.
 */
#define BALLRACE_INPUT_NOT_FINITE 1

/**
 * The inputs are finite and the result is not; the result is the last valid value.
 */
#define BALLRACE_RESULT_NOT_FINITE 2

/**
 * No element carries load.
 */
#define BALLRACE_CONTACT_LOST 4

/**
 * An element has not reached equilibrium; the force is inaccurate.
 */
#define BALLRACE_NOT_CONVERGED 8

/**
 * The friction that balances the gyroscopic moment exceeds the traction limit of a contact.
 */
#define BALLRACE_GYROSCOPIC_SLIP 16

/**
 * The state of an element is outside the domain of the table.
 */
#define BALLRACE_OUT_OF_TABLE 32

/**
 * The normalised innovation squared exceeds the gate of the observer; the sample corrects nothing.
 */
#define BALLRACE_INNOVATION_REJECTED 64

/**
 * A state was not initialised, or by another version of the library. The call has no effect.
 */
#define BALLRACE_STATE_INVALID 256

/**
 * A parameter is outside its range, or a pointer is NULL. The call has no effect.
 */
#define BALLRACE_INVALID_ARGUMENT 512

/**
 * Angles and speeds of the components of a bearing. Unused angles and speeds are 0.
 */
typedef struct ballrace_kinematic_state {
    /**
     * Angle of the cage, 2^-64 revolutions.
     */
    uint64_t cage;
    /**
     * Angle of the inner ring, 2^-64 revolutions.
     */
    uint64_t inner;
    /**
     * Angle of the outer ring, 2^-64 revolutions.
     */
    uint64_t outer;
    /**
     * Angle of the balls about their own axes, 2^-64 revolutions.
     */
    uint64_t ball;
    /**
     * Speed of the inner ring about +Z, rad/s.
     */
    float inner_speed;
    /**
     * Speed of the outer ring about +Z, rad/s.
     */
    float outer_speed;
} ballrace_kinematic_state;

/**
 * Functions of one bearing model. The library exports one constant per model; a program uses only their addresses.
 */
typedef struct ballrace_model {
    /**
     * Implementation of `ballrace_force`.
     */
    uint32_t (*force)(const struct ballrace_bearing *bearing,
                      const float *displacement,
                      uint64_t cage_phase,
                      float *wrench);
    /**
     * Implementation of `ballrace_force_at`.
     */
    uint32_t (*force_at)(const struct ballrace_bearing *bearing,
                         const float *displacement,
                         const struct ballrace_kinematic_state *state,
                         float *wrench);
    /**
     * Implementation of `ballrace_force_and_stiffness`.
     */
    uint32_t (*force_and_stiffness)(const struct ballrace_bearing *bearing,
                                    const float *displacement,
                                    const struct ballrace_kinematic_state *state,
                                    float *wrench,
                                    float *stiffness);
    /**
     * Implementation of `ballrace_element_loads`.
     */
    uint32_t (*element_loads)(const struct ballrace_bearing *bearing,
                              const float *displacement,
                              const struct ballrace_kinematic_state *state,
                              float *loads);
} ballrace_model;

/**
 * One rolling element: cosine and sine of its azimuth with the cage at angle 0, and that azimuth in 2^-64 revolutions.
 */
typedef struct ballrace_element {
    /**
     * Cosine of the azimuth.
     */
    float cos;
    /**
     * Sine of the azimuth.
     */
    float sin;
    /**
     * Azimuth, 2^-64 revolutions.
     */
    uint64_t azimuth;
} ballrace_element;

/**
 * First member of every bearing. `&bearing.head` is the argument of all calls.
 *
 * A bearing and its elements are constant: they may be in flash and shared by threads and interrupts.
 */
typedef struct ballrace_bearing {
    /**
     * Model of the struct that this is the first member of: `&ballrace_..._model`.
     */
    const struct ballrace_model *model;
    /**
     * Elements, in the frame rotated by pi about X for a mirrored model; NULL for `ballrace_linear`.
     */
    const struct ballrace_element *elements;
    /**
     * Number of elements, 3 to 32; 0 for `ballrace_linear`.
     */
    uint32_t element_count;
} ballrace_bearing;

/**
 * A ball bearing whose contact angles follow the displacement.
 *
 * Models: `ballrace_angular_model`, and `ballrace_angular_mirrored_model` for a bearing that carries thrust towards -Z.
 */
typedef struct ballrace_angular {
    /**
     * Head.
     */
    struct ballrace_bearing head;
    /**
     * K_n, stiffness of both contacts in series, N/m^1.5.
     */
    float stiffness;
    /**
     * A, distance of the groove centres with the rings just touching the balls, m.
     */
    float distance;
    /**
     * A^2, m^2.
     */
    float distance_squared;
    /**
     * A_r, radial distance of the groove centres at zero displacement, m.
     */
    float unloaded_radial;
    /**
     * A_z, axial distance of the groove centres at zero displacement, m.
     */
    float unloaded_axial;
    /**
     * A_r^2 + A_z^2 - A^2, m^2.
     */
    float excess;
    /**
     * R_i, lever arm, m.
     */
    float arm;
} ballrace_angular;

/**
 * Elastic constants of one body.
 */
typedef struct ballrace_material {
    /**
     * Young's modulus, Pa; 206e9 for bearing steel.
     */
    double youngs_modulus;
    /**
     * Poisson's ratio; 0.3 for bearing steel.
     */
    double poissons_ratio;
} ballrace_material;

/**
 * Geometry and material of a ball bearing.
 */
typedef struct ballrace_geometry {
    /**
     * D, ball diameter, m.
     */
    double ball_diameter;
    /**
     * d_m, pitch diameter, m.
     */
    double pitch_diameter;
    /**
     * f_i, inner groove radius divided by D, above 0.5.
     */
    double inner_conformity;
    /**
     * f_o, outer groove radius divided by D, above 0.5.
     */
    double outer_conformity;
    /**
     * alpha_0, free contact angle, 0 to pi/3 rad.
     */
    double contact_angle;
    /**
     * Material of the balls.
     */
    struct ballrace_material ball;
    /**
     * Material of both races.
     */
    struct ballrace_material race;
} ballrace_geometry;

/**
 * Report of a parameter outside its range. The texts are not terminated by NUL: print them with `%.*s`.
 */
typedef struct ballrace_invalid_parameter {
    /**
     * Name of the parameter.
     */
    const char *name;
    /**
     * Allowed range.
     */
    const char *allowed;
    /**
     * Length of the name.
     */
    uint32_t name_length;
    /**
     * Length of the allowed range.
     */
    uint32_t allowed_length;
    /**
     * Value found.
     */
    double found;
} ballrace_invalid_parameter;

/**
 * Displacements and speeds of the 1024 evaluations of a checksum. `ballrace bake --language c` writes it.
 */
typedef struct ballrace_checksum_range {
    /**
     * Centre of the displacements, m and rad.
     */
    float centre[5];
    /**
     * Largest deviation from the centre, m and rad.
     */
    float amplitude[5];
    /**
     * Speed of the inner ring at the first sample and its increment per sample, rad/s.
     */
    float inner_speed[2];
    /**
     * Speed of the outer ring at the first sample and its increment per sample, rad/s.
     */
    float outer_speed[2];
} ballrace_checksum_range;

/**
 * Last valid force and number of samples answered with it. Opaque: `ballrace_last_valid_init` writes it.
 */
typedef struct ballrace_last_valid {
    /**
     * Private.
     */
    uint64_t words[4];
} ballrace_last_valid;

/**
 * A radial ball or roller bearing: `F = K delta^n` of each element.
 *
 * Models: `ballrace_lumped_radial_model` (n = 3/2, balls), `ballrace_lumped_radial_line_model` (n = 10/9, rollers),
 * `ballrace_lumped_radial_power_model` (n = `exponent`).
 */
typedef struct ballrace_lumped_radial {
    /**
     * Head.
     */
    struct ballrace_bearing head;
    /**
     * K, N/m^n.
     */
    float stiffness;
    /**
     * n, 1 or more; only the model `power` reads it.
     */
    float exponent;
    /**
     * Radial play, half the diametral clearance, m; negative is preload.
     */
    float play;
} ballrace_lumped_radial;

/**
 * One coordinate of the grid of a table.
 */
typedef struct ballrace_axis {
    /**
     * Number of nodes.
     */
    uint32_t count;
    /**
     * Coordinate of node 0.
     */
    float origin;
    /**
     * Nodes per unit.
     */
    float density;
    /**
     * Least coordinate of the domain.
     */
    float least;
    /**
     * Greatest coordinate of the domain.
     */
    float greatest;
} ballrace_axis;

/**
 * Springs about a reference state: `f = force - stiffness (u - reference)`. The head has no elements.
 */
typedef struct ballrace_linear {
    /**
     * Head with `&ballrace_linear_model`, NULL, 0.
     */
    struct ballrace_bearing head;
    /**
     * Stiffness row by row: entry `5 i + j` is the force or moment `i` per unit of displacement `j`, SI units.
     */
    float stiffness[25];
    /**
     * Displacement of the reference state, m and rad.
     */
    float reference[5];
    /**
     * Force in the reference state, N and N m.
     */
    float force[5];
} ballrace_linear;

/**
 * Separate radial and axial contacts.
 *
 * Models: `ballrace_lumped_radial_axial_model` (n = 3/2 in both directions), `ballrace_lumped_radial_axial_line_model`
 * (n = 10/9 in both), `ballrace_lumped_radial_axial_power_model` (n = `exponent` and `axial_exponent`), each also
 * `mirrored`.
 */
typedef struct ballrace_lumped_radial_axial {
    /**
     * Head.
     */
    struct ballrace_bearing head;
    /**
     * Radial K, N/m^n.
     */
    float stiffness;
    /**
     * Radial n, 1 or more; only the model `power` reads it.
     */
    float exponent;
    /**
     * Radial play, half the diametral clearance, m; negative is preload.
     */
    float play;
    /**
     * Axial K, N/m^n.
     */
    float axial_stiffness;
    /**
     * Axial n, 1 or more; only the model `power` reads it.
     */
    float axial_exponent;
    /**
     * Axial play, m; negative is preload.
     */
    float axial_play;
    /**
     * Radius at which the axial contacts act, m.
     */
    float radius;
} ballrace_lumped_radial_axial;

/**
 * A ball bearing with interpolated ball forces. `ballrace bake --language c` writes it.
 *
 * Models: `ballrace_tabulated_model` (two numbers per node), `ballrace_tabulated_friction_model` (three numbers per node,
 * with friction at the inner race), each also `mirrored` for a bearing that carries thrust towards -Z.
 *
 * A table over several speeds needs `ballrace_force_at`: `ballrace_force` evaluates it at speed 0 and reports
 * `BALLRACE_OUT_OF_TABLE`, unless the domain contains 0.
 */
typedef struct ballrace_tabulated {
    /**
     * Head.
     */
    struct ballrace_bearing head;
    /**
     * Lever of the friction couple divided by the lever arm.
     */
    float couple;
    /**
     * A, distance of the groove centres with the rings just touching the balls, m.
     */
    float distance;
    /**
     * Cosine of the angle of the line of groove centres with the rings just touching the ball.
     */
    float axis_cos;
    /**
     * Sine of that angle.
     */
    float axis_sin;
    /**
     * Radial displacement of the inner groove centres at zero displacement, m.
     */
    float offset;
    /**
     * R_i, lever arm, m.
     */
    float arm;
    /**
     * Axis of the signed square root of the approach, sqrt(m); varies fastest.
     */
    struct ballrace_axis approach;
    /**
     * Axis of the sine of the angle of the line of groove centres.
     */
    struct ballrace_axis angle;
    /**
     * Axis of the speed, rad/s; varies slowest.
     */
    struct ballrace_axis speed;
    /**
     * 1 if the table is over the speed of the outer ring, 0 for the inner ring.
     */
    uint32_t by_outer_speed;
    /**
     * Number of nodes: the product of the counts of the axes.
     */
    uint32_t node_count;
    /**
     * Nodes, each of two or three numbers: half the load in N, sine of the angle from the line of groove centres to the
     * contact, and, in a model with friction, the friction at the inner race in N.
     */
    const float *nodes;
} ballrace_tabulated;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Model of `ballrace_angular`, which carries thrust where the inner ring moves towards +Z.
 */
extern const struct ballrace_model ballrace_angular_model;

/**
 * As `ballrace_angular_model` for a bearing that carries thrust towards -Z.
 */
extern const struct ballrace_model ballrace_angular_mirrored_model;

/**
 * Model of `ballrace_linear`.
 */
extern const struct ballrace_model ballrace_linear_model;

/**
 * Model of `ballrace_lumped_radial` with point contacts, n = 3/2.
 */
extern const struct ballrace_model ballrace_lumped_radial_model;

/**
 * Model of `ballrace_lumped_radial` with line contacts, n = 10/9.
 */
extern const struct ballrace_model ballrace_lumped_radial_line_model;

/**
 * Model of `ballrace_lumped_radial` with any exponent.
 */
extern const struct ballrace_model ballrace_lumped_radial_power_model;

/**
 * Model of `ballrace_lumped_radial_axial` with point contacts, n = 3/2, loaded where the inner ring moves towards +Z.
 */
extern const struct ballrace_model ballrace_lumped_radial_axial_model;

/**
 * As `ballrace_lumped_radial_axial_model` for a bearing that carries thrust towards -Z.
 */
extern const struct ballrace_model ballrace_lumped_radial_axial_mirrored_model;

/**
 * Model of `ballrace_lumped_radial_axial` with line contacts, n = 10/9.
 */
extern const struct ballrace_model ballrace_lumped_radial_axial_line_model;

/**
 * As `ballrace_lumped_radial_axial_line_model` for a bearing that carries thrust towards -Z.
 */
extern const struct ballrace_model ballrace_lumped_radial_axial_line_mirrored_model;

/**
 * Model of `ballrace_lumped_radial_axial` with any exponents.
 */
extern const struct ballrace_model ballrace_lumped_radial_axial_power_model;

/**
 * As `ballrace_lumped_radial_axial_power_model` for a bearing that carries thrust towards -Z.
 */
extern const struct ballrace_model ballrace_lumped_radial_axial_power_mirrored_model;

/**
 * Model of `ballrace_tabulated` with two numbers per node.
 */
extern const struct ballrace_model ballrace_tabulated_model;

/**
 * As `ballrace_tabulated_model` for a bearing that carries thrust towards -Z.
 */
extern const struct ballrace_model ballrace_tabulated_mirrored_model;

/**
 * Model of `ballrace_tabulated` with three numbers per node: with friction at the inner race.
 */
extern const struct ballrace_model ballrace_tabulated_friction_model;

/**
 * As `ballrace_tabulated_friction_model` for a bearing that carries thrust towards -Z.
 */
extern const struct ballrace_model ballrace_tabulated_friction_mirrored_model;

/**
 * Initialises a bearing from its geometry, with `&ballrace_angular_model`. For set-up: uses `double`; about 1000
 * operations. `datum` is `BALLRACE_DATUM_TOUCHING` or `BALLRACE_DATUM_CENTRED`.
 *
 * For a bearing that carries thrust towards -Z, mirror the elements with `ballrace_elements_mirror` and set `head.model`
 * to `&ballrace_angular_mirrored_model` afterwards.
 *
 * Returns `BALLRACE_INVALID_ARGUMENT` and fills `invalid`, if it is not NULL, for a parameter outside its range; the
 * bearing is then unchanged.
 *
 * Preconditions:
 * `bearing` and `geometry` point to structs, `elements` to `element_count` entries that exist as long as the bearing,
 * `invalid` to a struct or is NULL.
 */
uint32_t ballrace_angular_init(struct ballrace_angular *bearing,
                               const struct ballrace_geometry *geometry,
                               uint32_t datum,
                               const struct ballrace_element *elements,
                               uint32_t element_count,
                               struct ballrace_invalid_parameter *invalid);

/**
 * Computes the force and moment on the inner ring.
 *
 * `displacement` is that of the inner relative to the outer ring: `u v w` along X, Y, Z in m, tilts about X and Y in rad.
 * `wrench` receives `FX FY FZ` in N and `MX MY` in N m. `cage_phase` is the angle of the cage in 2^-64 revolutions; all
 * speeds are 0.
 *
 * Returns status bits. The displacement must be finite; `ballrace_sample` also takes others. Constant number of
 * instructions for one bearing.
 *
 * Preconditions:
 * `bearing` is the head of a struct of its model; the arrays have five entries.
 */
uint32_t ballrace_force(const struct ballrace_bearing *bearing,
                        const float displacement[5],
                        uint64_t cage_phase,
                        float wrench[5]);

/**
 * Computes the force as `ballrace_force` for components at these angles and speeds: for tables over the speed.
 *
 * Preconditions:
 * As `ballrace_force`; `state` points to a state.
 */
uint32_t ballrace_force_at(const struct ballrace_bearing *bearing,
                           const float displacement[5],
                           const struct ballrace_kinematic_state *state,
                           float wrench[5]);

/**
 * Computes the force and the tangent stiffness `-d(wrench)/d(displacement)`: row by row, `stiffness[5 * i + j]` is the
 * negative derivative of entry `i` of the wrench by entry `j` of the displacement.
 *
 * Preconditions:
 * As `ballrace_force_at`; `stiffness` has 25 entries.
 */
uint32_t ballrace_force_and_stiffness(const struct ballrace_bearing *bearing,
                                      const float displacement[5],
                                      const struct ballrace_kinematic_state *state,
                                      float wrench[5],
                                      float stiffness[25]);

/**
 * Computes the load on each element in N: `element_count` entries of `loads`; of a radial and axial bearing, the radial
 * loads. A linear bearing writes nothing.
 *
 * Preconditions:
 * As `ballrace_force_at`; `loads` has `element_count` entries.
 */
uint32_t ballrace_element_loads(const struct ballrace_bearing *bearing,
                                const float displacement[5],
                                const struct ballrace_kinematic_state *state,
                                float *loads);

/**
 * Computes `count` evenly spaced elements, the first at the azimuth `first` in 2^-64 revolutions. For set-up: uses
 * `double`.
 *
 * Preconditions:
 * `elements` has `count` entries.
 */
uint32_t ballrace_elements_evenly_spaced(struct ballrace_element *elements,
                                         uint32_t count,
                                         uint64_t first);

/**
 * Changes elements to those in the frame rotated by pi about X, for a mirrored model.
 *
 * Preconditions:
 * `elements` has `count` entries.
 */
uint32_t ballrace_elements_mirror(struct ballrace_element *elements, uint32_t count);

/**
 * Computes the checksum of 1024 forces by `ballrace_sample_at`: FNV-1a with 64 bits over the bits of force, moment and
 * status. For start-up: a value other than that of `ballrace bake` shows a damaged image. A NULL pointer gives 0.
 *
 * Preconditions:
 * `bearing` is the head of a struct of its model, `range` points to a range; both may be NULL.
 */
uint64_t ballrace_checksum(const struct ballrace_bearing *bearing,
                           const struct ballrace_checksum_range *range);

/**
 * Sets the free contact angle to that of a diametral clearance `s` in m: `cos(alpha_0) = 1 - s/(2 A)`. For set-up.
 *
 * Returns `BALLRACE_INVALID_ARGUMENT` and fills `invalid`, if it is not NULL, for a clearance below 0 or above A.
 *
 * Preconditions:
 * `geometry` points to a struct, `invalid` to one or is NULL.
 */
uint32_t ballrace_geometry_set_clearance(struct ballrace_geometry *geometry,
                                         double diametral_clearance,
                                         struct ballrace_invalid_parameter *invalid);

/**
 * Initialises the state before the first sample; an invalid first sample gives the zero force.
 *
 * Preconditions:
 * `last_valid` points to a struct.
 */
uint32_t ballrace_last_valid_init(struct ballrace_last_valid *last_valid);

/**
 * Returns the number of samples answered with an earlier force (saturating); 0 for a state that is not initialised.
 *
 * Preconditions:
 * `last_valid` points to a struct.
 */
uint32_t ballrace_held_count(const struct ballrace_last_valid *last_valid);

/**
 * Computes the force for one sample of a stream.
 *
 * As `ballrace_force`, but a sample that is NaN, infinite or overflows is flagged, counted and answered with the last
 * valid force. Same number of instructions for every sample. For an interrupt: one state per stream.
 *
 * Preconditions:
 * As `ballrace_force`; `last_valid` points to an initialised state that no other thread or interrupt uses.
 */
uint32_t ballrace_sample(const struct ballrace_bearing *bearing,
                         struct ballrace_last_valid *last_valid,
                         const float displacement[5],
                         uint64_t cage_phase,
                         float wrench[5]);

/**
 * As `ballrace_sample` for components at these angles and speeds.
 *
 * Preconditions:
 * As `ballrace_sample`; `state` points to a state.
 */
uint32_t ballrace_sample_at(const struct ballrace_bearing *bearing,
                            struct ballrace_last_valid *last_valid,
                            const float displacement[5],
                            const struct ballrace_kinematic_state *state,
                            float wrench[5]);

/**
 * Initialises a radial ball bearing (n = 3/2) with `&ballrace_lumped_radial_model` and checks its parameters. For set-up;
 * a `const` struct needs no call.
 *
 * Returns `BALLRACE_INVALID_ARGUMENT` and fills `invalid`, if it is not NULL, for a stiffness that is not above 0, a play
 * that is not finite, or fewer than 3 or more than 32 elements.
 *
 * Preconditions:
 * `bearing` points to a struct, `elements` to `element_count` entries that exist as long as the bearing, `invalid` to a
 * struct or is NULL.
 */
uint32_t ballrace_lumped_radial_init(struct ballrace_lumped_radial *bearing,
                                     double stiffness,
                                     double play,
                                     const struct ballrace_element *elements,
                                     uint32_t element_count,
                                     struct ballrace_invalid_parameter *invalid);

/**
 * Converts revolutions; drops whole revolutions. NaN and infinity give 0. For set-up: uses `double`.
 */
uint64_t ballrace_phase_from_revolutions(double revolutions);

/**
 * Returns the angle in revolutions, 0 to 1. For set-up: uses `double`.
 */
double ballrace_phase_to_revolutions(uint64_t phase);

/**
 * Returns the shorter signed difference from `earlier` to `phase`, 2^-64 revolutions.
 */
int64_t ballrace_phase_since(uint64_t phase, uint64_t earlier);

/**
 * Returns the angle advanced by `delta`.
 */
uint64_t ballrace_phase_advance(uint64_t phase, int64_t delta);

/**
 * Returns `n` times the angle: the angle of the n-th harmonic.
 */
uint64_t ballrace_phase_multiple(uint64_t phase, int32_t n);

/**
 * Returns the angle of one count of an encoder with `counts_per_revolution`, for `ballrace_phase_advance_counts`. For
 * set-up: one division. It is rounded down by less than 2^-64 revolution. 0 counts give 0.
 */
uint64_t ballrace_phase_per_count(uint32_t counts_per_revolution);

/**
 * Returns the angle advanced by `counts` of an encoder, negative counts backwards. `phase_per_count` is the result of
 * `ballrace_phase_per_count`.
 */
uint64_t ballrace_phase_advance_counts(uint64_t phase,
                                       int32_t counts,
                                       uint64_t phase_per_count);

/**
 * Converts the ratio of two speeds, between -128 and 128, for `ballrace_speed_ratio_apply`; saturates outside. For set-up:
 * uses `double`.
 */
int64_t ballrace_speed_ratio(double ratio);

/**
 * Returns `ratio * delta`: the rotation of the cage for a rotation `delta` of the shaft, wrapped beyond half a revolution.
 */
int64_t ballrace_speed_ratio_apply(int64_t ratio,
                                   int64_t delta);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* BALLRACE_H */
