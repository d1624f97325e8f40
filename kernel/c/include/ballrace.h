/*
 * ballrace: forces of rolling bearings and motion of rotors, in fixed time on a core with a single-precision FPU; software floats
 * branch on their values.
 *
 * Frame: X, Y radial, Z along the shaft, right-handed. SI units. Angles are 2^-64 revolutions.
 * Made by cbindgen from kernel/c/src; the tests compare it with the source.
 */

#ifndef BALLRACE_H
#define BALLRACE_H

#include <stddef.h>
#include <stdint.h>

struct ballrace_bearing;
struct ballrace_observer;
struct ballrace_rotor;

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
 * Largest number of orders of a force tracker.
 */
#define BALLRACE_MAX_FORCE_ORDERS 8

/**
 * Largest number of probes of an observer.
 */
#define BALLRACE_MAX_PROBES 8

/**
 * Alignment of all structs of the library, bytes.
 */
#define BALLRACE_ALIGNMENT 8

/**
 * Size of `ballrace_last_valid`, bytes.
 */
#define BALLRACE_LAST_VALID_SIZE 32

/**
 * Size of `ballrace_rotor`, bytes.
 */
#define BALLRACE_ROTOR_SIZE 488

/**
 * Size of `ballrace_rotor_state`, bytes.
 */
#define BALLRACE_ROTOR_STATE_SIZE 192

/**
 * Size of `ballrace_observer`, bytes.
 */
#define BALLRACE_OBSERVER_SIZE 696

/**
 * Size of `ballrace_observer_state`, bytes.
 */
#define BALLRACE_OBSERVER_STATE_SIZE 240

/**
 * Size of `ballrace_order_tracker`, bytes.
 */
#define BALLRACE_ORDER_TRACKER_SIZE 80

/**
 * Size of `ballrace_order_sums`, bytes.
 */
#define BALLRACE_ORDER_SUMS_SIZE 16

/**
 * Size of `ballrace_statistics`, bytes.
 */
#define BALLRACE_STATISTICS_SIZE 64

/**
 * Size of `ballrace_envelope`, bytes.
 */
#define BALLRACE_ENVELOPE_SIZE 88

/**
 * Size of `ballrace_probe`, bytes.
 */
#define BALLRACE_PROBE_SIZE 44

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
 * A reading is outside the linear range of its probe or does not change; the probe has its last valid displacement.
 */
#define BALLRACE_INPUT_NOT_OK 128

/**
 * A state was not initialised, or by another version of the library. The call has no effect.
 */
#define BALLRACE_STATE_INVALID 256

/**
 * A parameter is outside its range, or a pointer is NULL. The call has no effect.
 */
#define BALLRACE_INVALID_ARGUMENT 512

/**
 * A block is complete and its results are written.
 */
#define BALLRACE_BLOCK_COMPLETE 1024

/**
 * Not the beginning of a blob at an address that is a multiple of 8, a blob of another version, or a length that does not fit.
 */
#define BALLRACE_BLOB_FORMAT 2048

/**
 * Damaged blob: another CRC-32.
 */
#define BALLRACE_BLOB_CHECKSUM 4096

/**
 * No bearing of this name in the blob.
 */
#define BALLRACE_BLOB_BEARING 8192

/**
 * The bearing in the blob has another model.
 */
#define BALLRACE_BLOB_MODEL 16384

/**
 * The check of a blob or of forces has more parts.
 */
#define BALLRACE_INCOMPLETE 32768

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
 * Last valid force and number of samples that it replaced. Opaque: `ballrace_last_valid_init` writes it.
 */
typedef struct ballrace_last_valid {
    /**
     * Private.
     */
    uint64_t words[4];
} ballrace_last_valid;

/**
 * Constants of the struct of a model in a blob.
 */
typedef struct ballrace_blob_shape {
    /**
     * Code of the model.
     */
    uint32_t code;
    /**
     * Number of members of 4 bytes after the head.
     */
    uint32_t words;
    /**
     * Offset in the struct of the pointer to its table or laminae, bytes; 0 where it has none.
     */
    uint32_t array;
    /**
     * Numbers of a node or lamina.
     */
    uint32_t numbers;
} ballrace_blob_shape;

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
     * Implementation of `ballrace_sample`.
     */
    uint32_t (*sample)(const struct ballrace_bearing *bearing,
                       struct ballrace_last_valid *last_valid,
                       const float *displacement,
                       uint64_t cage_phase,
                       float *wrench);
    /**
     * Implementation of `ballrace_sample_at`.
     */
    uint32_t (*sample_at)(const struct ballrace_bearing *bearing,
                          struct ballrace_last_valid *last_valid,
                          const float *displacement,
                          const struct ballrace_kinematic_state *state,
                          float *wrench);
    /**
     * As `force_at`, with `BALLRACE_CONTACT_LOST` where no element carries load: for rotors.
     */
    uint32_t (*force_and_contact)(const struct ballrace_bearing *bearing,
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
    /**
     * Constants of the struct in a blob.
     */
    struct ballrace_blob_shape blob;
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
     * Expected range.
     */
    const char *expected;
    /**
     * Length of the name.
     */
    uint32_t name_length;
    /**
     * Length of the expected range.
     */
    uint32_t expected_length;
    /**
     * Value found.
     */
    double found;
} ballrace_invalid_parameter;

/**
 * State of the check of a blob; 0 before it.
 */
typedef struct ballrace_blob_check_state {
    /**
     * Number of checked bytes.
     */
    uint32_t checked;
    /**
     * Their CRC-32.
     */
    uint32_t crc;
} ballrace_blob_check_state;

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
 * Constants of a bearing in a blob besides those of its struct.
 */
typedef struct ballrace_blob_constants {
    /**
     * Angle of the cage over that of the shaft.
     */
    double cage_ratio;
    /**
     * Angle of a ball about its axis over that of the shaft.
     */
    double ball_ratio;
    /**
     * Angle of the outer ring over that of the shaft.
     */
    double outer_ratio;
    /**
     * `ballrace_checksum` of the bearing, as the desktop computes it.
     */
    uint64_t checksum;
    /**
     * Displacements and speeds of the checksum.
     */
    struct ballrace_checksum_range checksum_range;
    /**
     * Displacement by preload, to be added to every displacement, m and rad.
     */
    float offset[5];
    /**
     * Station along Z from the rotor's centre of mass, m.
     */
    float station;
} ballrace_blob_constants;

/**
 * Parameters and state of one probe. Opaque: `ballrace_probe_init` writes it.
 */
typedef struct ballrace_probe {
    /**
     * Private.
     */
    uint32_t words[11];
} ballrace_probe;

/**
 * A bearing whose displacement channels measure, and where its shaft and cage are.
 */
typedef struct ballrace_probed_bearing {
    /**
     * Head of the bearing.
     */
    const struct ballrace_bearing *bearing;
    /**
     * Last valid force.
     */
    struct ballrace_last_valid *last_valid;
    /**
     * Initialised probes in the order in which the buffer has their channels; not read where the buffer has metres.
     */
    struct ballrace_probe *probes;
    /**
     * Displacement of the bearing per metre of each channel, five floats a channel: the probe along X has 1 and four times 0.
     */
    const float *directions;
    /**
     * Number of channels.
     */
    uint32_t channel_count;
    /**
     * Displacement where all channels read 0, such as that by preload.
     */
    float offset[5];
    /**
     * Speed of the cage by that of the shaft, from `ballrace_speed_ratio`.
     */
    int64_t cage_ratio;
    /**
     * Angle of the shaft at the last sample, 2^-64 revolutions.
     */
    uint64_t shaft;
    /**
     * Angle of the cage at the last sample, 2^-64 revolutions.
     */
    uint64_t cage;
} ballrace_probed_bearing;

/**
 * A checksum that is computed in parts. Opaque: `ballrace_checksum_begin` writes it.
 */
typedef struct ballrace_checksum_state {
    /**
     * Private.
     */
    uint64_t words[17];
} ballrace_checksum_state;

/**
 * A radial bearing on counts. Opaque: `ballrace_fixed_radial_init` writes it.
 */
typedef struct ballrace_fixed_radial {
    /**
     * Private.
     */
    uint64_t words[118];
} ballrace_fixed_radial;

/**
 * A bearing of radial elements between rigid rings.
 */
typedef struct ballrace_fixed_radial_params {
    /**
     * K, N/m^n.
     */
    double stiffness;
    /**
     * n, 1 to 2: 3/2 of balls, 10/9 of rollers.
     */
    double exponent;
    /**
     * Radial play, m: half the diametral clearance; negative is preload.
     */
    double radial_play;
    /**
     * Displacement of 2^31 counts, m: the largest that the converter delivers.
     */
    double range;
    /**
     * Azimuth of the first element with the cage at angle 0, 2^-64 revolutions.
     */
    uint64_t first;
    /**
     * Number of evenly spaced elements, 3 to 32.
     */
    uint32_t element_count;
} ballrace_fixed_radial_params;

/**
 * Force on the inner ring, in counts.
 */
typedef struct ballrace_fixed_radial_counts {
    /**
     * Force along X.
     */
    int32_t fx;
    /**
     * Force along Y.
     */
    int32_t fy;
    /**
     * Sum of the element loads.
     */
    int32_t load;
} ballrace_fixed_radial_counts;

/**
 * Axial elements on counts. Opaque: `ballrace_fixed_axial_init` writes it.
 */
typedef struct ballrace_fixed_axial {
    /**
     * Private.
     */
    uint64_t words[120];
} ballrace_fixed_axial;

/**
 * Axial elements between rigid rings, loaded where the inner ring moves towards +Z.
 */
typedef struct ballrace_fixed_axial_params {
    /**
     * K, N/m^n.
     */
    double stiffness;
    /**
     * n, 1 to 2: 3/2 of balls, 10/9 of rollers.
     */
    double exponent;
    /**
     * Axial play, m; negative is preload.
     */
    double axial_play;
    /**
     * Radius at which the elements act, m.
     */
    double radius;
    /**
     * Displacement of 2^31 counts, m.
     */
    double range;
    /**
     * Azimuth of the first element with the cage at angle 0, 2^-64 revolutions.
     */
    uint64_t first;
    /**
     * Number of evenly spaced elements, 3 to 32.
     */
    uint32_t element_count;
} ballrace_fixed_axial_params;

/**
 * Force and moment of axial elements on the inner ring, in counts; a count of a moment is that of the force times the radius.
 */
typedef struct ballrace_fixed_axial_counts {
    /**
     * Force along Z.
     */
    int32_t fz;
    /**
     * Moment about X.
     */
    int32_t mx;
    /**
     * Moment about Y.
     */
    int32_t my;
} ballrace_fixed_axial_counts;

/**
 * A bearing with a table, on counts. Opaque: `ballrace_fixed_tabulated_init` writes it.
 */
typedef struct ballrace_fixed_tabulated {
    /**
     * Private.
     */
    uint64_t words[56];
} ballrace_fixed_tabulated;

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
     * Approach up to which the nodes are close, m.
     */
    float scale;
    /**
     * b, rad/s.
     */
    float speed_scale;
    /**
     * Axis of the coordinate of the approach, `sqrt(|e| / (|e| + scale))` with the sign of `e = s (1 + s / (2 distance))`, `s` the
     * approach; varies fastest.
     */
    struct ballrace_axis approach;
    /**
     * Axis of the sine of the angle of the line of groove centres.
     */
    struct ballrace_axis angle;
    /**
     * Axis of the coordinate of the speed `w`, `w (w + speed_scale)`, (rad/s)^2; varies slowest.
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
     * Nodes, each of two or three numbers: half of the load along the line of groove centres over `(|e| + scale)^1.5` in
     * N/m^1.5, tangent of the angle from that line to the contact, and, in a model with friction, the friction at the inner
     * race across that line in N.
     */
    const float *nodes;
} ballrace_tabulated;

/**
 * A bearing with a table, on counts.
 */
typedef struct ballrace_fixed_tabulated_params {
    /**
     * Speed of the ring over whose speed the table is, rad/s: the nodes are those of this speed.
     */
    double speed;
    /**
     * Displacement of 2^31 counts, m: the largest that the converter delivers, 2 to 100 times the distance of the groove centres.
     */
    double range;
    /**
     * Nodes, which belong to the bearing from its set-up on: two numbers each, with friction at the inner race three, for the nodes along approach
     * and angle, `approach.count * angle.count` of the table.
     */
    int32_t *nodes;
    /**
     * Number of numbers of the nodes.
     */
    uint32_t number_count;
} ballrace_fixed_tabulated_params;

/**
 * One line of the full spectrum of a force in the frame of a component.
 *
 * At the angle `p` of its fundamental the line of order `k` is `F e^(i k p) + B e^(-i k p)`.
 */
typedef struct ballrace_force_line {
    /**
     * F, amplitude of forward precession, N: real and imaginary part.
     */
    float forward[2];
    /**
     * B, amplitude of backward precession, N: real and imaginary part.
     */
    float backward[2];
} ballrace_force_line;

/**
 * Functions of a force tracker with a number of orders. The library exports one constant per number; a program uses only
 * their addresses.
 */
typedef struct ballrace_force_tracker_model {
    /**
     * Number of orders.
     */
    uint32_t order_count;
    /**
     * Implementation of `ballrace_force_tracker_init`.
     */
    uint32_t (*init)(uint64_t *words,
                     uint32_t elements,
                     uint32_t turns,
                     const struct ballrace_kinematic_state *at);
    /**
     * Implementation of `ballrace_force_tracker_add`.
     */
    uint32_t (*add)(uint64_t *words, float fx, float fy, const struct ballrace_kinematic_state *at);
    /**
     * Implementation of `ballrace_force_tracker_close`.
     */
    uint32_t (*close)(uint64_t *words,
                      struct ballrace_force_line *outer,
                      struct ballrace_force_line *inner,
                      struct ballrace_force_line *element);
} ballrace_force_tracker_model;

/**
 * Force tracker. Opaque: `ballrace_force_tracker_init` writes it.
 */
typedef struct ballrace_force_tracker {
    /**
     * Private.
     */
    const struct ballrace_force_tracker_model *model;
    /**
     * Private: as many words as `ballrace_force_tracker_init` demands.
     */
    uint64_t *words;
} ballrace_force_tracker;

/**
 * State of the statistics. Opaque: `ballrace_statistics_init` writes it.
 */
typedef struct ballrace_statistics {
    /**
     * Private.
     */
    uint64_t words[8];
} ballrace_statistics;

/**
 * Statistics of one block.
 */
typedef struct ballrace_block_statistics {
    /**
     * Mean.
     */
    float mean;
    /**
     * Root mean square about the mean.
     */
    float rms;
    /**
     * Greatest less least value.
     */
    float peak_to_peak;
    /**
     * Greatest distance from the mean divided by the rms; 0 for a constant signal.
     */
    float crest_factor;
    /**
     * Fourth moment divided by the squared second; 0 for a constant signal.
     */
    float kurtosis;
} ballrace_block_statistics;

/**
 * Envelope of a frequency band. Opaque: `ballrace_envelope_init` writes it.
 */
typedef struct ballrace_envelope {
    /**
     * Private.
     */
    uint64_t words[11];
} ballrace_envelope;

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
 * An unbalance in one plane.
 */
typedef struct ballrace_unbalance {
    /**
     * Mass times eccentricity, kg m.
     */
    double moment;
    /**
     * Angle from the keyphasor mark in the direction of positive rotation, rad.
     */
    double angle;
    /**
     * Station along Z from the centre of mass, m.
     */
    double station;
} ballrace_unbalance;

/**
 * Parameters of a rigid rotor. Coordinates: displacement of the centre of mass, `u v w` in m and tilts about X and Y in
 * rad.
 */
typedef struct ballrace_rotor_params {
    /**
     * Mass, kg.
     */
    double mass;
    /**
     * I_d, moment of inertia about X and Y, kg m^2.
     */
    double diametral_inertia;
    /**
     * I_p, moment of inertia about Z, kg m^2.
     */
    double polar_inertia;
    /**
     * B, symmetric damping matrix, row by row: N s/m, N s, N m s.
     */
    double damping[25];
    /**
     * Stiffness of springs on the rotor: N/m (three), N m/rad (two).
     */
    double stiffness[5];
    /**
     * Gravity, m/s^2.
     */
    double gravity[3];
    /**
     * Constant force and moment, N and N m.
     */
    double load[5];
    /**
     * Unbalances; NULL without.
     */
    const struct ballrace_unbalance *unbalances;
    /**
     * Number of unbalances.
     */
    uint32_t unbalance_count;
} ballrace_rotor_params;

/**
 * A bearing on a rotor.
 */
typedef struct ballrace_rotor_bearing {
    /**
     * Head of the bearing, which exists as long as the rotor.
     */
    const struct ballrace_bearing *bearing;
    /**
     * Speed of the cage divided by that of the shaft.
     */
    double cage_ratio;
    /**
     * Speed of the balls about their own axes divided by that of the shaft; 0 where no result depends on it.
     */
    double ball_ratio;
    /**
     * Speed of the outer ring divided by that of the shaft; 0 for a fixed ring.
     */
    double outer_ratio;
    /**
     * Station along Z from the centre of mass, m.
     */
    float station;
} ballrace_rotor_bearing;

/**
 * Parameters of an observer beside its rotor. `ballrace bake --language c` writes them.
 */
typedef struct ballrace_observer_params {
    /**
     * Readings of each probe per unit of each coordinate: five entries per probe.
     */
    const float *probes;
    /**
     * Gains at each speed: for `P` probes `20 P + P^2` floats, of which five per probe for displacement, for velocity, for
     * the constant load and for the rotating load, then the whitening matrix row by row.
     */
    const float *gains;
    /**
     * Number of speeds with gains, 1 or more.
     */
    uint32_t gain_count;
    /**
     * Time steps per sample, 1 or more.
     */
    uint32_t substeps;
    /**
     * Time step, s.
     */
    float step;
    /**
     * Speed of the first gains, rad/s.
     */
    float first_speed;
    /**
     * Gains per rad/s.
     */
    float speed_density;
    /**
     * Factor of the unmodelled load from sample to sample without correction, at most 1.
     */
    float load_retention;
    /**
     * Largest normalised innovation squared of a sample that corrects the state; infinity for any.
     */
    float gate;
} ballrace_observer_params;

/**
 * State of an observer. Opaque: `ballrace_observer_state_init` writes it.
 */
typedef struct ballrace_observer_state {
    /**
     * Private.
     */
    uint64_t words[30];
} ballrace_observer_state;

/**
 * Motion of the shaft at the start of a step; the acceleration is constant during it.
 */
typedef struct ballrace_shaft {
    /**
     * Angle of the keyphasor mark, 2^-64 revolutions.
     */
    uint64_t angle;
    /**
     * Speed about +Z, rad/s.
     */
    float speed;
    /**
     * Angular acceleration, rad/s^2.
     */
    float acceleration;
} ballrace_shaft;

/**
 * Result of one sample.
 */
typedef struct ballrace_estimate {
    /**
     * Readings less predictions, m; 0 for a missing reading. As many as there are probes.
     */
    float innovation[8];
    /**
     * Normalised innovation squared.
     */
    float nis;
} ballrace_estimate;

/**
 * Functions of an observer with a number of bearings and probes. The library exports one constant per pair of numbers; a
 * program uses only their addresses.
 */
typedef struct ballrace_observer_model {
    /**
     * Number of bearings.
     */
    uint32_t bearing_count;
    /**
     * Number of probes.
     */
    uint32_t probe_count;
    /**
     * Implementation of `ballrace_observer_init`.
     */
    uint32_t (*init)(struct ballrace_observer *observer,
                     const struct ballrace_rotor_params *rotor,
                     const struct ballrace_rotor_bearing *bearings,
                     const struct ballrace_observer_params *params,
                     struct ballrace_invalid_parameter *invalid);
    /**
     * Implementation of `ballrace_observer_state_init`.
     */
    uint32_t (*state_init)(struct ballrace_observer_state *state,
                           const float *displacement,
                           uint64_t shaft_angle,
                           const uint64_t *cage_angles);
    /**
     * Implementation of `ballrace_observer_sample`.
     */
    uint32_t (*sample)(const struct ballrace_observer *observer,
                       struct ballrace_observer_state *state,
                       const struct ballrace_shaft *shaft,
                       const float *readings,
                       struct ballrace_estimate *estimate);
    /**
     * Implementation of `ballrace_observer_motion`.
     */
    uint32_t (*motion)(const struct ballrace_observer_state *state,
                       float *displacement,
                       float *velocity,
                       float *load,
                       float *rotating_load);
} ballrace_observer_model;

/**
 * An observer: constant after `ballrace_observer_init`, which writes it. Opaque.
 */
typedef struct ballrace_observer {
    /**
     * Private.
     */
    const struct ballrace_observer_model *model;
    /**
     * Private.
     */
    uint64_t words[86];
} ballrace_observer;

/**
 * Order tracker of one signal. Opaque: `ballrace_order_tracker_init` writes it.
 */
typedef struct ballrace_order_tracker {
    /**
     * Private.
     */
    uint64_t words[10];
} ballrace_order_tracker;

/**
 * Angle of a spectral line as a sum of multiples of the angles of the shaft, the cage and the balls: 1X is `{1, 0, 0}`, the
 * outer ball pass of N balls `{0, N, 0}`, the inner ball pass `{N, -N, 0}`, a defect of a ball `{0, 0, 2}`.
 */
typedef struct ballrace_order_line {
    /**
     * Multiple of the shaft angle.
     */
    int32_t shaft;
    /**
     * Multiple of the cage angle.
     */
    int32_t cage;
    /**
     * Multiple of the angle of the balls about their own axes.
     */
    int32_t ball;
} ballrace_order_line;

/**
 * Accumulators of one line. Opaque: `ballrace_order_tracker_init` writes them.
 */
typedef struct ballrace_order_sums {
    /**
     * Private.
     */
    uint32_t words[4];
} ballrace_order_sums;

/**
 * Scale and limits of a probe.
 */
typedef struct ballrace_probe_params {
    /**
     * Displacement at the count 0, m.
     */
    float at_zero;
    /**
     * Displacement per count, m; its sign is the direction in which the count rises.
     */
    float per_count;
    /**
     * Smallest and largest count of the linear range of the transducer, both inside the rails of the converter.
     */
    uint32_t linear_range[2];
    /**
     * Samples without any change of the count after which the channel is stuck; 0: it may stand still.
     */
    uint32_t stuck_after;
} ballrace_probe_params;

/**
 * State of a rotor. Opaque: `ballrace_rotor_state_init` writes it.
 */
typedef struct ballrace_rotor_state {
    /**
     * Private.
     */
    uint64_t words[24];
} ballrace_rotor_state;

/**
 * Functions of a rotor with a number of bearings. The library exports one constant per number; a program uses only their
 * addresses.
 */
typedef struct ballrace_rotor_model {
    /**
     * Number of bearings.
     */
    uint32_t bearing_count;
    /**
     * Implementation of `ballrace_rotor_init`.
     */
    uint32_t (*init)(struct ballrace_rotor *rotor,
                     const struct ballrace_rotor_params *params,
                     const struct ballrace_rotor_bearing *bearings,
                     float step,
                     struct ballrace_invalid_parameter *invalid);
    /**
     * Implementation of `ballrace_rotor_state_init`.
     */
    uint32_t (*state_init)(struct ballrace_rotor_state *state,
                           const float *displacement,
                           uint64_t shaft_angle,
                           const uint64_t *cage_angles);
    /**
     * Implementation of `ballrace_rotor_step`.
     */
    uint32_t (*step)(const struct ballrace_rotor *rotor,
                     struct ballrace_rotor_state *state,
                     const struct ballrace_shaft *shaft);
    /**
     * Implementation of `ballrace_rotor_motion`.
     */
    uint32_t (*motion)(const struct ballrace_rotor_state *state,
                       float *displacement,
                       float *velocity);
} ballrace_rotor_model;

/**
 * A rotor with its bearings: constant after `ballrace_rotor_init`, which writes it. Opaque.
 */
typedef struct ballrace_rotor {
    /**
     * Private.
     */
    const struct ballrace_rotor_model *model;
    /**
     * Private.
     */
    uint64_t words[60];
} ballrace_rotor;

/**
 * One lamina of a roller.
 */
typedef struct ballrace_lamina {
    /**
     * Position of its centre along the axis of the roller, m.
     */
    float position;
    /**
     * Profile drop at both contacts together, m.
     */
    float drop;
} ballrace_lamina;

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
 * A cylindrical, needle or tapered roller bearing by laminae.
 *
 * Models: `ballrace_roller_model`, and `ballrace_roller_mirrored_model` for a bearing that carries thrust towards -Z.
 */
typedef struct ballrace_roller {
    /**
     * Head.
     */
    struct ballrace_bearing head;
    /**
     * K/n, stiffness of one lamina with both contacts in series, N/m^(10/9).
     */
    float stiffness;
    /**
     * R, pitch radius, m.
     */
    float arm;
    /**
     * Cosine of the contact angle.
     */
    float axis_cos;
    /**
     * Sine of the contact angle.
     */
    float axis_sin;
    /**
     * Radial play times the cosine of the contact angle, m; negative is preload.
     */
    float play;
    /**
     * Number of laminae.
     */
    uint32_t lamina_count;
    /**
     * Laminae of each roller.
     */
    const struct ballrace_lamina *laminae;
} ballrace_roller;

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
 * Force tracker of 1 order per component.
 */
extern const struct ballrace_force_tracker_model ballrace_force_tracker_of_1_order;

/**
 * Force tracker of 2 orders per component.
 */
extern const struct ballrace_force_tracker_model ballrace_force_tracker_of_2_orders;

/**
 * Force tracker of 3 orders per component.
 */
extern const struct ballrace_force_tracker_model ballrace_force_tracker_of_3_orders;

/**
 * Force tracker of 4 orders per component.
 */
extern const struct ballrace_force_tracker_model ballrace_force_tracker_of_4_orders;

/**
 * Force tracker of 5 orders per component.
 */
extern const struct ballrace_force_tracker_model ballrace_force_tracker_of_5_orders;

/**
 * Force tracker of 6 orders per component.
 */
extern const struct ballrace_force_tracker_model ballrace_force_tracker_of_6_orders;

/**
 * Force tracker of 7 orders per component.
 */
extern const struct ballrace_force_tracker_model ballrace_force_tracker_of_7_orders;

/**
 * Force tracker of 8 orders per component.
 */
extern const struct ballrace_force_tracker_model ballrace_force_tracker_of_8_orders;

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
 * Observer of a rotor on 1 bearing by 1 probe.
 */
extern const struct ballrace_observer_model ballrace_observer_of_1_bearing_1_probe;

/**
 * Observer of a rotor on 1 bearing by 2 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_1_bearing_2_probes;

/**
 * Observer of a rotor on 1 bearing by 3 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_1_bearing_3_probes;

/**
 * Observer of a rotor on 1 bearing by 4 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_1_bearing_4_probes;

/**
 * Observer of a rotor on 1 bearing by 5 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_1_bearing_5_probes;

/**
 * Observer of a rotor on 1 bearing by 6 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_1_bearing_6_probes;

/**
 * Observer of a rotor on 1 bearing by 7 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_1_bearing_7_probes;

/**
 * Observer of a rotor on 1 bearing by 8 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_1_bearing_8_probes;

/**
 * Observer of a rotor on 2 bearings by 1 probe.
 */
extern const struct ballrace_observer_model ballrace_observer_of_2_bearings_1_probe;

/**
 * Observer of a rotor on 2 bearings by 2 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_2_bearings_2_probes;

/**
 * Observer of a rotor on 2 bearings by 3 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_2_bearings_3_probes;

/**
 * Observer of a rotor on 2 bearings by 4 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_2_bearings_4_probes;

/**
 * Observer of a rotor on 2 bearings by 5 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_2_bearings_5_probes;

/**
 * Observer of a rotor on 2 bearings by 6 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_2_bearings_6_probes;

/**
 * Observer of a rotor on 2 bearings by 7 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_2_bearings_7_probes;

/**
 * Observer of a rotor on 2 bearings by 8 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_2_bearings_8_probes;

/**
 * Observer of a rotor on 3 bearings by 1 probe.
 */
extern const struct ballrace_observer_model ballrace_observer_of_3_bearings_1_probe;

/**
 * Observer of a rotor on 3 bearings by 2 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_3_bearings_2_probes;

/**
 * Observer of a rotor on 3 bearings by 3 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_3_bearings_3_probes;

/**
 * Observer of a rotor on 3 bearings by 4 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_3_bearings_4_probes;

/**
 * Observer of a rotor on 3 bearings by 5 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_3_bearings_5_probes;

/**
 * Observer of a rotor on 3 bearings by 6 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_3_bearings_6_probes;

/**
 * Observer of a rotor on 3 bearings by 7 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_3_bearings_7_probes;

/**
 * Observer of a rotor on 3 bearings by 8 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_3_bearings_8_probes;

/**
 * Observer of a rotor on 4 bearings by 1 probe.
 */
extern const struct ballrace_observer_model ballrace_observer_of_4_bearings_1_probe;

/**
 * Observer of a rotor on 4 bearings by 2 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_4_bearings_2_probes;

/**
 * Observer of a rotor on 4 bearings by 3 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_4_bearings_3_probes;

/**
 * Observer of a rotor on 4 bearings by 4 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_4_bearings_4_probes;

/**
 * Observer of a rotor on 4 bearings by 5 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_4_bearings_5_probes;

/**
 * Observer of a rotor on 4 bearings by 6 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_4_bearings_6_probes;

/**
 * Observer of a rotor on 4 bearings by 7 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_4_bearings_7_probes;

/**
 * Observer of a rotor on 4 bearings by 8 probes.
 */
extern const struct ballrace_observer_model ballrace_observer_of_4_bearings_8_probes;

/**
 * Model of `ballrace_roller`, which carries thrust where the inner ring moves towards +Z.
 */
extern const struct ballrace_model ballrace_roller_model;

/**
 * As `ballrace_roller_model` for a bearing that carries thrust towards -Z.
 */
extern const struct ballrace_model ballrace_roller_mirrored_model;

/**
 * Rotor on one bearing.
 */
extern const struct ballrace_rotor_model ballrace_rotor_on_1_bearing;

/**
 * Rotor on two bearings.
 */
extern const struct ballrace_rotor_model ballrace_rotor_on_2_bearings;

/**
 * Rotor on three bearings.
 */
extern const struct ballrace_rotor_model ballrace_rotor_on_3_bearings;

/**
 * Rotor on four bearings.
 */
extern const struct ballrace_rotor_model ballrace_rotor_on_4_bearings;

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
 * Returns status bits. The displacement must be finite; `ballrace_sample` also takes others, and reports lost contact.
 * Constant number of instructions for one bearing.
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
 * Computes the force for one sample of a stream.
 *
 * As `ballrace_force`, but a sample that is NaN, infinite or overflows is flagged, counted and replaced by the last
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
 * Checks `count` further bytes of a blob in `length` bytes, which may be more than its own: the page of flash that it lies in. Returns
 * `BALLRACE_INCOMPLETE` until all are checked, so that a watchdog can be reset between the calls; then `BALLRACE_OK`, `BALLRACE_BLOB_FORMAT`
 * or `BALLRACE_BLOB_CHECKSUM`. A CRC-32 tells damage, not intent: the signature of a blob is the bootloader's.
 *
 * Preconditions:
 * `blob` points to `length` bytes, `check` to a state that is 0 before the first call.
 */
uint32_t ballrace_blob_check(const uint8_t *blob,
                             uint32_t length,
                             struct ballrace_blob_check_state *check,
                             uint32_t count);

/**
 * Reads the bearing of this name from a blob that `ballrace_blob_check` found right. `bearing->model` is set before the call:
 * `BALLRACE_BLOB_MODEL` for a bearing of another model. The blob must exist as long as the bearing, which uses its elements and its table.
 *
 * Preconditions:
 * `blob` points to `length` bytes, `name` to a text, `bearing` to the head of a struct of its model, `constants` to a struct or nothing.
 */
uint32_t ballrace_blob_bearing(const uint8_t *blob,
                               uint32_t length,
                               const char *name,
                               struct ballrace_bearing *bearing,
                               struct ballrace_blob_constants *constants);

/**
 * Computes force and status of every sample of a buffer of unsigned counts: `channel_count` of them a sample, in the order of the probes. The
 * shaft turns by `turned` (2^-64 revolutions) before each sample, at `inner_speed` (rad/s). Writes five floats a sample to `wrenches` and the
 * status bits, as of `ballrace_sample_at` and of the probes, to `statuses`; returns the bits of all samples.
 *
 * Every sample takes the same number of instructions.
 *
 * Preconditions:
 * `end` points to a struct with valid pointers that no other thread or interrupt uses; `buffer` has `sample_count * channel_count` entries,
 * `wrenches` five times and `statuses` once `sample_count`.
 */
uint32_t ballrace_block_u16(struct ballrace_probed_bearing *end,
                            const uint16_t *buffer,
                            uint32_t sample_count,
                            int64_t turned,
                            float inner_speed,
                            float *wrenches,
                            uint32_t *statuses);

/**
 * As `ballrace_block_u16`, for a converter with a sign: a probe takes its counts in offset binary, in which -32768 is the count 0 and 0 the
 * count 32768.
 *
 * Preconditions:
 * As `ballrace_block_u16`.
 */
uint32_t ballrace_block_i16(struct ballrace_probed_bearing *end,
                            const int16_t *buffer,
                            uint32_t sample_count,
                            int64_t turned,
                            float inner_speed,
                            float *wrenches,
                            uint32_t *statuses);

/**
 * As `ballrace_block_u16`, for readings that are metres already. A reading that is not finite is flagged by the bearing.
 *
 * Preconditions:
 * As `ballrace_block_u16`; the probes are not read.
 */
uint32_t ballrace_block_metres(struct ballrace_probed_bearing *end,
                               const float *buffer,
                               uint32_t sample_count,
                               int64_t turned,
                               float inner_speed,
                               float *wrenches,
                               uint32_t *statuses);

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
 * Begins a checksum that `ballrace_checksum_advance` computes in parts, so that a watchdog can be reset between them.
 *
 * Preconditions:
 * `checksum` and `range` point to structs.
 */
uint32_t ballrace_checksum_begin(struct ballrace_checksum_state *checksum,
                                 const struct ballrace_checksum_range *range);

/**
 * Takes further `samples` forces. Returns `BALLRACE_INCOMPLETE` until all 1024 are taken, then `BALLRACE_OK`, with the value of
 * `ballrace_checksum` in `value`.
 *
 * Preconditions:
 * `checksum` points to a struct that `ballrace_checksum_begin` wrote, `bearing` is the head of a struct of its model, `value` points to a number.
 */
uint32_t ballrace_checksum_advance(struct ballrace_checksum_state *checksum,
                                   const struct ballrace_bearing *bearing,
                                   uint32_t samples,
                                   uint64_t *value);

/**
 * Initialises a bearing. For set-up: uses `double`. `invalid` may be NULL. Writes what a count of the displacement is in m, and a count of the
 * force in N.
 *
 * Preconditions:
 * `bearing` and `params` point to structs, `invalid` to a struct or nothing, `metres_per_count` and `newtons_per_count` to numbers.
 */
uint32_t ballrace_fixed_radial_init(struct ballrace_fixed_radial *bearing,
                                    const struct ballrace_fixed_radial_params *params,
                                    double *metres_per_count,
                                    double *newtons_per_count,
                                    struct ballrace_invalid_parameter *invalid);

/**
 * Computes the force on the inner ring at the displacement `u` along X and `v` along Y, in counts; any counts are valid. `BALLRACE_CONTACT_LOST`
 * where no element carries load. Without floating-point numbers: a constant number of instructions on every core.
 *
 * Preconditions:
 * `bearing` points to an initialised bearing, `force` to a struct.
 */
uint32_t ballrace_fixed_radial_force(const struct ballrace_fixed_radial *bearing,
                                     int32_t u,
                                     int32_t v,
                                     uint64_t cage_phase,
                                     struct ballrace_fixed_radial_counts *force);

/**
 * Initialises axial elements, as `ballrace_fixed_radial_init`.
 *
 * Preconditions:
 * As `ballrace_fixed_radial_init`.
 */
uint32_t ballrace_fixed_axial_init(struct ballrace_fixed_axial *bearing,
                                   const struct ballrace_fixed_axial_params *params,
                                   double *metres_per_count,
                                   double *newtons_per_count,
                                   struct ballrace_invalid_parameter *invalid);

/**
 * Computes force and moment on the inner ring at the displacement `w` along Z and the tilts about X and Y times the radius, in counts; any counts
 * are valid. As `ballrace_fixed_radial_force`.
 *
 * Preconditions:
 * `bearing` points to initialised elements, `force` to a struct.
 */
uint32_t ballrace_fixed_axial_force(const struct ballrace_fixed_axial *bearing,
                                    int32_t w,
                                    int32_t tilt_x,
                                    int32_t tilt_y,
                                    uint64_t cage_phase,
                                    struct ballrace_fixed_axial_counts *force);

/**
 * Initialises a bearing from the table in floats of `of`, which is not read afterwards. For set-up: uses `double`. `invalid` may be NULL. Writes what
 * a count of the displacement is in m, and a count of the force in N.
 *
 * Preconditions:
 * `bearing`, `params` and `of`, which has one of its models, point to structs, `invalid` to a struct or nothing, `metres_per_count` and
 * `newtons_per_count` to numbers; the nodes outlive the bearing.
 */
uint32_t ballrace_fixed_tabulated_init(struct ballrace_fixed_tabulated *bearing,
                                       const struct ballrace_tabulated *of,
                                       const struct ballrace_fixed_tabulated_params *params,
                                       double *metres_per_count,
                                       double *newtons_per_count,
                                       struct ballrace_invalid_parameter *invalid);

/**
 * Computes force and moment on the inner ring, `fx`, `fy`, `fz` and the moments about X and Y over the lever arm `of->arm`, at a displacement along
 * X, Y, Z and the tilts about X and Y times that arm, all in counts; any counts are valid. `BALLRACE_OUT_OF_TABLE` where a ball is outside the
 * table, `BALLRACE_CONTACT_LOST` where none carries load. Without floating-point numbers: a constant number of instructions on every core.
 *
 * Preconditions:
 * `bearing` points to an initialised bearing; the arrays have five entries.
 */
uint32_t ballrace_fixed_tabulated_force(const struct ballrace_fixed_tabulated *bearing,
                                        const int32_t displacement[5],
                                        uint64_t cage_phase,
                                        int32_t wrench[5]);

/**
 * Initialises a force tracker for a bearing of `elements` rolling elements and blocks of `turns` revolutions of the inner
 * relative to the outer ring, starting at `at`. For set-up.
 *
 * `model` is one of `&ballrace_force_tracker_of_..._orders`, `words` is memory of `12 n + 8` words for n orders, aligned to
 * 8 bytes.
 *
 * Each sample is turned into the frame of the outer ring, of the inner ring and of the cage, and demodulated at orders of
 * the ball pass of the outer ring, of the inner ring, and of -2 times the angle of the balls.
 *
 * Preconditions:
 * All pointers are valid; `words` exists as long as the tracker, and nothing else uses it.
 */
uint32_t ballrace_force_tracker_init(struct ballrace_force_tracker *tracker,
                                     const struct ballrace_force_tracker_model *model,
                                     uint64_t *words,
                                     uint32_t elements,
                                     uint32_t turns,
                                     const struct ballrace_kinematic_state *at);

/**
 * Adds a force in N in the fixed frame; returns `BALLRACE_BLOCK_COMPLETE` where it ends a block, which
 * `ballrace_force_tracker_close` must read before the next sample. Constant number of instructions.
 *
 * Preconditions:
 * `tracker` points to an initialised tracker that no other thread or interrupt uses, `at` to a state.
 */
uint32_t ballrace_force_tracker_add(const struct ballrace_force_tracker *tracker,
                                    float fx,
                                    float fy,
                                    const struct ballrace_kinematic_state *at);

/**
 * Ends the block and writes its lines of the outer ring, the inner ring and the rolling elements: one entry per order in
 * each array. Each pointer may be NULL.
 *
 * Preconditions:
 * As `ballrace_force_tracker_add`; the arrays have one entry per order or are NULL.
 */
uint32_t ballrace_force_tracker_close(const struct ballrace_force_tracker *tracker,
                                      struct ballrace_force_line *outer,
                                      struct ballrace_force_line *inner,
                                      struct ballrace_force_line *element);

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
 * Initialises statistics over blocks of `length` samples, 1 or more.
 *
 * Preconditions:
 * `statistics` points to a struct.
 */
uint32_t ballrace_statistics_init(struct ballrace_statistics *statistics, uint32_t length);

/**
 * Adds a sample; returns `BALLRACE_BLOCK_COMPLETE` where it ends a block and has written `block`.
 *
 * Preconditions:
 * `statistics` points to an initialised state that no other thread or interrupt uses, `block` to a struct.
 */
uint32_t ballrace_statistics_add(struct ballrace_statistics *statistics,
                                 float sample,
                                 struct ballrace_block_statistics *block);

/**
 * Initialises the envelope of the band `centre` plus and minus `half_width` at the sampling rate `rate`, all in Hz; the
 * band must be below half the rate. For set-up: uses `double`.
 *
 * Preconditions:
 * `envelope` points to a struct.
 */
uint32_t ballrace_envelope_init(struct ballrace_envelope *envelope,
                                double centre,
                                double half_width,
                                double rate);

/**
 * Adds a sample and writes the envelope: for a sine in the band, its amplitude. Constant number of instructions.
 *
 * Preconditions:
 * `envelope` points to an initialised state that no other thread or interrupt uses, `amplitude` to a float.
 */
uint32_t ballrace_envelope_add(struct ballrace_envelope *envelope,
                               float sample,
                               float *amplitude);

/**
 * Initialises the state before the first sample; an invalid first sample gives the zero force.
 *
 * Preconditions:
 * `last_valid` points to a struct.
 */
uint32_t ballrace_last_valid_init(struct ballrace_last_valid *last_valid);

/**
 * Returns the number of samples replaced by an earlier force (saturating); 0 for a state that is not initialised.
 *
 * Preconditions:
 * `last_valid` points to a struct.
 */
uint32_t ballrace_held_count(const struct ballrace_last_valid *last_valid);

/**
 * Writes a frame of `4 (count + 2)` bytes: the sequence number, the readings, and the CRC-32 (IEEE 802.3, as in zlib) of the bytes before it,
 * all little-endian.
 *
 * The readings are those of the columns of a recording in the order probes, sensors, keyphasor or speed, in the units of the scene; one that is
 * not finite is missing. The number counts samples and wraps. The number of instructions depends on `count` only.
 *
 * Preconditions:
 * `readings` has `count` entries, `frame` has `4 (count + 2)` bytes.
 */
uint32_t ballrace_log_frame(uint32_t number,
                            const float *readings,
                            uint32_t count,
                            uint8_t *frame);

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
 * Initialises an observer. For set-up: uses `double`.
 *
 * `model` is one of `&ballrace_observer_of_..._bearings_..._probes`. `bearings` has one entry per bearing; parameters and
 * bearings are copied, the gains are not.
 *
 * Returns `BALLRACE_INVALID_ARGUMENT` and fills `invalid`, if it is not NULL, for a parameter outside its range.
 *
 * Preconditions:
 * `invalid` points to a struct or is NULL; all other pointers, also those in structs, are valid; the gains exist as long as
 * the observer.
 */
uint32_t ballrace_observer_init(struct ballrace_observer *observer,
                                const struct ballrace_observer_model *model,
                                const struct ballrace_rotor_params *rotor,
                                const struct ballrace_rotor_bearing *bearings,
                                const struct ballrace_observer_params *params,
                                struct ballrace_invalid_parameter *invalid);

/**
 * Initialises the state of an observer without velocity and unmodelled loads; as `ballrace_rotor_state_init`.
 *
 * Preconditions:
 * `observer` is initialised, `cage_angles` has one entry per bearing.
 */
uint32_t ballrace_observer_state_init(const struct ballrace_observer *observer,
                                      struct ballrace_observer_state *state,
                                      const float displacement[5],
                                      uint64_t shaft_angle,
                                      const uint64_t *cage_angles);

/**
 * Processes one sample: `shaft` is the motion of the shaft at the last sample, `readings` are the present readings of the
 * probes in m. Constant number of instructions for one observer.
 *
 * A reading that is not finite corrects nothing; the others do. A sample above the gate corrects nothing at all. Returns
 * status bits. `estimate` may be NULL.
 *
 * Preconditions:
 * `observer` is initialised, `readings` has one entry per probe, all other pointers are valid or NULL.
 */
uint32_t ballrace_observer_sample(const struct ballrace_observer *observer,
                                  struct ballrace_observer_state *state,
                                  const struct ballrace_shaft *shaft,
                                  const float *readings,
                                  struct ballrace_estimate *estimate);

/**
 * Reads the estimated displacement (m, rad) and velocity of the centre of mass, the unmodelled constant load and the
 * unmodelled load that rotates with the shaft (N, N m). Each pointer may be NULL.
 *
 * Preconditions:
 * `observer` is initialised; all pointers are valid or NULL.
 */
uint32_t ballrace_observer_motion(const struct ballrace_observer *observer,
                                  const struct ballrace_observer_state *state,
                                  float displacement[5],
                                  float velocity[5],
                                  float load[5],
                                  float rotating_load[5]);

/**
 * Initialises a tracker for blocks of `turns` revolutions, starting at the shaft angle `shaft`. For set-up.
 *
 * The signal at a line is `c cos p + s sin p` with the angle `p` of the line; `amplitudes` receives `c` and `s` of every
 * line at the end of each block. A Hann window separates lines that differ by more than two cycles per block.
 *
 * Preconditions:
 * `lines` and `sums` have `line_count` entries, `amplitudes` twice as many; all exist as long as the tracker, and nothing
 * else uses `sums`.
 */
uint32_t ballrace_order_tracker_init(struct ballrace_order_tracker *tracker,
                                     const struct ballrace_order_line *lines,
                                     struct ballrace_order_sums *sums,
                                     float *amplitudes,
                                     uint32_t line_count,
                                     uint32_t turns,
                                     uint64_t shaft);

/**
 * Adds a sample at the angles of the shaft, the cage and the balls; returns `BALLRACE_BLOCK_COMPLETE` where it ends a block
 * and has written the amplitudes over it.
 *
 * Constant number of instructions, more at the end of a block. A sample that is not finite spoils its block, not the next
 * one.
 *
 * Preconditions:
 * `tracker` points to an initialised tracker that no other thread or interrupt uses.
 */
uint32_t ballrace_order_tracker_add(struct ballrace_order_tracker *tracker,
                                    float sample,
                                    uint64_t shaft,
                                    uint64_t cage,
                                    uint64_t ball);

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

/**
 * Initialises a probe before its first sample. For set-up. `invalid` may be NULL.
 *
 * Preconditions:
 * `probe` and `params` point to structs, `invalid` to a struct or nothing.
 */
uint32_t ballrace_probe_init(struct ballrace_probe *probe,
                             const struct ballrace_probe_params *params,
                             struct ballrace_invalid_parameter *invalid);

/**
 * Writes the displacement at this count, m, or the last valid one with `BALLRACE_INPUT_NOT_OK` where the channel is not OK: a count outside
 * the linear range, or one that does not change. Before a first valid sample the displacement is 0. Constant number of instructions.
 *
 * Preconditions:
 * `probe` points to an initialised probe that no other thread or interrupt uses, `displacement` to a float.
 */
uint32_t ballrace_probe_sample(struct ballrace_probe *probe,
                               uint32_t counts,
                               float *displacement);

/**
 * Returns the age of the displacement in samples: 0 where the last one was valid (saturating), or where the probe is not initialised.
 *
 * Preconditions:
 * `probe` points to a struct.
 */
uint32_t ballrace_probe_held_in_a_row(const struct ballrace_probe *probe);

/**
 * Returns the number of samples since the start or the last reset that were not OK (saturating); 0 for a probe that is not initialised.
 *
 * Preconditions:
 * `probe` points to a struct.
 */
uint32_t ballrace_probe_held_count(const struct ballrace_probe *probe);

/**
 * Forgets samples and counters, after a repair of the channel.
 *
 * Preconditions:
 * `probe` points to a struct.
 */
uint32_t ballrace_probe_reset(struct ballrace_probe *probe);

/**
 * Initialises a rotor. For set-up: uses `double`.
 *
 * `model` is one of `&ballrace_rotor_on_..._bearings`, `bearings` has that number of entries, which are copied. `step` is
 * the time step in s; the integrator is stable up to 2 divided by the largest natural angular frequency.
 *
 * Returns `BALLRACE_INVALID_ARGUMENT` and fills `invalid`, if it is not NULL, for a parameter outside its range.
 *
 * Preconditions:
 * `invalid` points to a struct or is NULL; all other pointers, also those in structs, are valid.
 */
uint32_t ballrace_rotor_init(struct ballrace_rotor *rotor,
                             const struct ballrace_rotor_model *model,
                             const struct ballrace_rotor_params *params,
                             const struct ballrace_rotor_bearing *bearings,
                             float step,
                             struct ballrace_invalid_parameter *invalid);

/**
 * Initialises the state of a rotor without velocity at `displacement`, with these angles of the shaft and of the cage of
 * each bearing in 2^-64 revolutions.
 *
 * Preconditions:
 * `rotor` is initialised, `cage_angles` has one entry per bearing.
 */
uint32_t ballrace_rotor_state_init(const struct ballrace_rotor *rotor,
                                   struct ballrace_rotor_state *state,
                                   const float displacement[5],
                                   uint64_t shaft_angle,
                                   const uint64_t *cage_angles);

/**
 * Advances the state by one step, with the shaft motion at its start. Constant number of instructions.
 *
 * A shaft motion or result that is not finite leaves displacement and velocity unchanged and is flagged. Returns status
 * bits; `BALLRACE_STATE_INVALID` for a rotor or state that is not initialised, or for another number of bearings.
 *
 * Preconditions:
 * `rotor` is initialised; all pointers are valid.
 */
uint32_t ballrace_rotor_step(const struct ballrace_rotor *rotor,
                             struct ballrace_rotor_state *state,
                             const struct ballrace_shaft *shaft);

/**
 * Reads displacement (m, rad) and velocity (m/s, rad/s) of the centre of mass. Either pointer may be NULL.
 *
 * Preconditions:
 * `rotor` is initialised; all pointers are valid or NULL.
 */
uint32_t ballrace_rotor_motion(const struct ballrace_rotor *rotor,
                               const struct ballrace_rotor_state *state,
                               float displacement[5],
                               float velocity[5]);

/**
 * Returns the shaft motion after the time `dt` in s: at most half a revolution.
 *
 * Preconditions:
 * `shaft` points to a struct.
 */
struct ballrace_shaft ballrace_shaft_after(const struct ballrace_shaft *shaft, float dt);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* BALLRACE_H */
