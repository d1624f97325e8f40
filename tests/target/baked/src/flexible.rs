//! Made by `ballrace bake` from the scene "flexible". Do not edit: bake the scene again.
#![allow(dead_code, unused_imports, clippy::excessive_precision, clippy::unreadable_literal)]

/// Bearing "DE".
pub mod bearing_de {
    use ballrace::bearing::ElementPosition;
    use ballrace::bearing::angular::{Angular, AngularConstants};
    use ballrace::{Displacement, Exact, Phase};

    /// Along Z from the rotor's centre of mass, m.
    pub const STATION: f32 = -0.19394362;
    /// Cage, ball and outer ring over shaft.
    pub const CAGE_RATIO: f64 = 0.39991034836065575;
    /// See [`CAGE_RATIO`].
    pub const BALL_RATIO: f64 = -2.3599243542114006;
    /// See [`CAGE_RATIO`].
    pub const OUTER_RATIO: f64 = 0.0;
    /// By preload, to be added to every displacement.
    pub const OFFSET: Displacement<f32> = Displacement { u: 0.0, v: 0.0, w: 0.0, thu: 0.0, thv: 0.0 };
    /// The elements.
    pub const POSITIONS: [ElementPosition<f32>; 9] = [
        ElementPosition::from_constants(1.0, 0.0, Phase(0x0000000000000000)),
        ElementPosition::from_constants(0.76604444, 0.64278764, Phase(0x1c71c71c71c71c71)),
        ElementPosition::from_constants(0.17364818, 0.9848077, Phase(0x38e38e38e38e38e3)),
        ElementPosition::from_constants(-0.5, 0.8660254, Phase(0x5555555555555555)),
        ElementPosition::from_constants(-0.9396926, 0.34202015, Phase(0x71c71c71c71c71c7)),
        ElementPosition::from_constants(-0.9396926, -0.34202015, Phase(0x8e38e38e38e38e38)),
        ElementPosition::from_constants(-0.5, -0.8660254, Phase(0xaaaaaaaaaaaaaaaa)),
        ElementPosition::from_constants(0.17364818, -0.9848077, Phase(0xc71c71c71c71c71c)),
        ElementPosition::from_constants(0.76604444, -0.64278764, Phase(0xe38e38e38e38e38e)),
    ];
    const CONSTANTS: AngularConstants<f32> = AngularConstants { stiffness: 9215408000.0, distance: [0.0003176, 1.0086976e-7], unloaded: [0.0003126, 0.0], excess: -3.151e-9, arm: 0.0196763 };
    /// The bearing's type.
    pub type Baked = Angular<f32, Exact, [ElementPosition<f32>; 9]>;

    /// The bearing, ready for the hot path.
    #[must_use]
    pub fn bearing() -> Baked {
        Angular::from_constants(POSITIONS, CONSTANTS)
    }
}

/// Bearing "NDE".
pub mod bearing_nde {
    use ballrace::bearing::ElementPosition;
    use ballrace::bearing::angular::{Angular, AngularConstants};
    use ballrace::{Displacement, Exact, Phase};

    /// Along Z from the rotor's centre of mass, m.
    pub const STATION: f32 = 0.24605638;
    /// Cage, ball and outer ring over shaft.
    pub const CAGE_RATIO: f64 = 0.39991034836065575;
    /// See [`CAGE_RATIO`].
    pub const BALL_RATIO: f64 = -2.3599243542114006;
    /// See [`CAGE_RATIO`].
    pub const OUTER_RATIO: f64 = 0.0;
    /// By preload, to be added to every displacement.
    pub const OFFSET: Displacement<f32> = Displacement { u: 0.0, v: 0.0, w: 0.0, thu: 0.0, thv: 0.0 };
    /// The elements.
    pub const POSITIONS: [ElementPosition<f32>; 9] = [
        ElementPosition::from_constants(1.0, 0.0, Phase(0x0000000000000000)),
        ElementPosition::from_constants(0.76604444, 0.64278764, Phase(0x1c71c71c71c71c71)),
        ElementPosition::from_constants(0.17364818, 0.9848077, Phase(0x38e38e38e38e38e3)),
        ElementPosition::from_constants(-0.5, 0.8660254, Phase(0x5555555555555555)),
        ElementPosition::from_constants(-0.9396926, 0.34202015, Phase(0x71c71c71c71c71c7)),
        ElementPosition::from_constants(-0.9396926, -0.34202015, Phase(0x8e38e38e38e38e38)),
        ElementPosition::from_constants(-0.5, -0.8660254, Phase(0xaaaaaaaaaaaaaaaa)),
        ElementPosition::from_constants(0.17364818, -0.9848077, Phase(0xc71c71c71c71c71c)),
        ElementPosition::from_constants(0.76604444, -0.64278764, Phase(0xe38e38e38e38e38e)),
    ];
    const CONSTANTS: AngularConstants<f32> = AngularConstants { stiffness: 9215408000.0, distance: [0.0003176, 1.0086976e-7], unloaded: [0.0003126, 0.0], excess: -3.151e-9, arm: 0.0196763 };
    /// The bearing's type.
    pub type Baked = Angular<f32, Exact, [ElementPosition<f32>; 9]>;

    /// The bearing, ready for the hot path.
    #[must_use]
    pub fn bearing() -> Baked {
        Angular::from_constants(POSITIONS, CONSTANTS)
    }
}

/// The rotor without its bearings: `M q'' + (B + w G) q' + K q`.
pub mod rotor {
    use ballrace::Exact;
    use ballrace::rotor::{Attachment, InvalidMatrix, LinearSystem, SystemMatrices};

    /// Number of coordinates: u, v, w, thu, thv, bending_1_x, bending_1_y, NDE_support_u, NDE_support_v.
    pub const COORDINATES: usize = 9;
    /// Columns of the mass matrix M, SI units.
    #[rustfmt::skip]
    pub static MASS: [[f64; 9]; 9] = [[5.75674755352504, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 5.75674755352504, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 5.75674755352504, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.06617885079571342, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.06617885079571342, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 5.75674755352504, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 5.75674755352504, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0]];
    /// Columns of the damping matrix B, SI units.
    #[rustfmt::skip]
    pub static DAMPING: [[f64; 9]; 9] = [[1151.349510705008, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 1151.349510705008, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1151.349510705008, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 13.235770159142685, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 13.235770159142685, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 1232.0287561812333, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1232.0287561812333, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 400.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 400.0]];
    /// Columns of the gyroscopic matrix G, to be multiplied by the speed, SI units.
    #[rustfmt::skip]
    pub static GYROSCOPIC: [[f64; 9]; 9] = [[0.0, -5.421010862427522e-19, 0.0, -2.710505431213761e-20, 0.0, 0.0, -4.336808689942018e-19, 0.0, 0.0], [5.421010862427522e-19, 0.0, 0.0, 0.0, -2.710505431213761e-20, 4.336808689942018e-19, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [-8.32850649396733e-20, 0.0, 0.0, 0.0, -0.009310134099771574, -0.07835061062100675, 0.0, 0.0, 0.0], [0.0, -8.32850649396733e-20, 0.0, 0.009310134099771574, 0.0, 0.0, -0.07835061062100675, 0.0, 0.0], [0.0, -4.690831032377838e-19, 0.0, 0.07835061062100679, 0.0, 0.0, -0.7494555598414674, 0.0, 0.0], [4.690831032377838e-19, 0.0, 0.0, 0.0, 0.07835061062100679, 0.7494555598414674, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]];
    /// Columns of the stiffness matrix K without the bearings, SI units.
    #[rustfmt::skip]
    pub static STIFFNESS: [[f64; 9]; 9] = [[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 40339622.73811267, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 40339622.73811267, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 30000000.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 20000000.0]];
    /// Weight and constant load on each coordinate, N or N m.
    #[rustfmt::skip]
    pub static LOAD: [f64; 9] = [0.0, -56.454408395776326, 60.0, 0.0, 0.0, 0.0, 0.0, 0.0, -19.6133];
    /// Unbalance on each coordinate, kg m: factors of the cosine and of the sine of the shaft angle.
    #[rustfmt::skip]
    pub static UNBALANCE: [[f64; 2]; 9] = [[4.330127018922193e-5, -2.4999999999999994e-5], [2.4999999999999994e-5, 4.330127018922193e-5], [0.0, 0.0], [5.98590507898193e-7, 1.03678917260813e-6], [-1.03678917260813e-6, 5.98590507898193e-7], [2.424258330054914e-5, -1.399646199442397e-5], [1.399646199442397e-5, 2.424258330054914e-5], [0.0, 0.0], [0.0, 0.0]];
    /// Rows `u v w thu thv` of each bearing's displacement per unit of each coordinate: DE, NDE.
    #[rustfmt::skip]
    pub static ATTACHMENTS: [[[f64; 9]; 5]; 2] = [[[1.0, 0.0, 0.0, 0.0, -0.19394362031592774, -2.3731828444081855, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.19394362031592774, 0.0, 0.0, -2.3731828444081855, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -21.10115609156506, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0, 21.10115609156506, 0.0, 0.0, 0.0]], [[1.0, 0.0, 0.0, 0.0, 0.2460563796840723, -2.0003947304290057, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -0.2460563796840723, 0.0, 0.0, -2.0003947304290057, 0.0, -1.0], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 18.194502985011173, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0, -18.194502985011173, 0.0, 0.0, 0.0]]];

    /// Returns the matrices.
    #[must_use]
    pub fn matrices() -> SystemMatrices<9> {
        SystemMatrices {
            mass: MASS.into(),
            damping: DAMPING.into(),
            gyroscopic: GYROSCOPIC.into(),
            stiffness: STIFFNESS.into(),
            load: LOAD,
            unbalance: UNBALANCE,
        }
    }

    /// Returns the rotor, with set-up arithmetic in `f64`.
    ///
    /// # Errors
    /// None with these matrices.
    pub fn rotor() -> Result<LinearSystem<f32, Exact, 9>, InvalidMatrix> {
        LinearSystem::try_new(&matrices())
    }

    /// Returns the attachment of each bearing.
    #[must_use]
    pub fn attachments() -> [Attachment<f32, 9>; 2] {
        ATTACHMENTS.each_ref().map(Attachment::new)
    }
}

/// The observer of the module `rotor` by the scene's probes.
pub mod observer {
    use ballrace::twin::SpeedGain;

    /// From sample to sample, s.
    pub const PERIOD: f32 = 7.8125e-5;
    /// Steps of the integrator in it.
    pub const SUBSTEPS: u32 = 7;
    /// Decay factor of the unknown load over one period.
    pub const MEMORY: f32 = 0.9999922;
    /// Largest normalised innovation squared that still corrects the state.
    pub const GATE: f32 = 53.344574;
    /// Speed of the first gain, rad/s, gains per rad/s.
    pub const SPEEDS: [f32; 2] = [314.15927, 0.0];
    /// Reading of each probe per unit of each coordinate: DE_X, DE_Y, NDE_X, NDE_Y, axial.
    pub const PROBES: [[f32; 9]; 5] = [[0.70710677, 0.70710677, 0.0, 0.11239011, -0.11239011, -1.1586552, -1.1586552, 0.0, 0.0], [-0.70710677, 0.70710677, 0.0, 0.11239011, 0.11239011, 1.1586552, -1.1586552, 0.0, 0.0], [0.70710677, 0.70710677, 0.0, -0.14923939, 0.14923939, -0.9665634, -0.9665634, 0.0, 0.0], [-0.70710677, 0.70710677, 0.0, -0.14923939, -0.14923939, 0.9665634, -0.9665634, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]];
    /// By speed.
    pub static GAINS: [SpeedGain<f32, 9, 5>; 1] = [
        SpeedGain {
            position: [[0.008814041, 0.009679669, 0.0012350796, 0.03128925, -0.029167674, 0.0016649382, 0.0021253512, -0.0011021176, -0.0017197733], [-0.008823803, 0.009711233, 0.0012267588, 0.031269178, 0.029184744, -0.0016681034, 0.002138219, 0.0011039025, -0.0017108013], [0.010662579, 0.013576587, 0.0011314914, -0.14066412, 0.10276901, -0.0036896924, -0.0054680924, 0.031776816, 0.047444575], [-0.010723591, 0.013557473, 0.0011277131, -0.1406203, -0.10264678, 0.0036517165, -0.005476626, -0.03174471, 0.047436077], [8.575605e-6, 0.0006301784, 0.09336708, -0.00011884692, -1.0645498e-5, 2.67546e-6, -0.00068931043, 5.7108156e-7, -0.00044786595]],
            rate: [[1.1368093, 1.2092097, 0.7250445, 4.9549575, -4.318215, 0.43128085, 0.5783753, -0.2685137, -0.76050925], [-1.1349784, 1.2170056, 0.71754086, 5.6926074, 3.5955777, -0.46280745, 0.5502134, 0.27203, -0.7574523], [4.7384615, 8.442958, 1.250123, -63.77848, 33.710556, -0.7355713, -1.6170769, 12.162672, 24.124643], [-4.8637257, 8.358775, 1.2462807, -63.707077, -33.62313, 0.72791785, -1.5979729, -12.2310505, 24.008104], [0.0061774007, 1.6085019, 58.5401, -0.8695613, -0.0012694682, 0.0021313555, -0.03415045, 0.0012491032, 0.2477229]],
            load: [[605424.06, 612751.44, -3060.484, 123132.89, -122411.53, -1441012.6, -1457809.0, 0.0, 0.0], [-611443.9, 606683.56, -3171.7205, 122019.52, 123532.695, 1455259.5, -1443462.5, 0.0, 0.0], [613255.0, 616909.56, -623.5891, -147572.5, 146247.14, -1230690.1, -1237639.6, 0.0, 0.0], [-624277.44, 605823.44, -685.1293, -145011.08, -148780.05, 1252891.3, -1215322.1, 0.0, 0.0], [-133.16092, 2102.4902, 841464.75, 666.96234, 8.66964, 301.4798, -5209.198, 0.0, 0.0]],
            rotating_load: [[8651.311, 2936.9517, 0.0, 664.1247, -1719.3524, -20566.291, -7050.0063, 0.0, 0.0], [-2968.1897, 8699.216, 0.0, 1711.4729, 657.59845, 7113.478, -20665.432, 0.0, 0.0], [9744.533, -2196.8071, 0.0, 412.73523, 2353.1802, -19530.635, 4502.762, 0.0, 0.0], [2344.8167, 8728.853, 0.0, -2068.592, 539.9163, -4721.9414, -17528.25, 0.0, 0.0], [413.7311, 0.12923428, 0.0, 20.513191, -61.25303, -965.7725, -17.665174, 0.0, 0.0]],
            whitening: [[19844574.0, 0.0, 0.0, 0.0, 0.0], [-6422.489, 19844472.0, 0.0, 0.0, 0.0], [-8075.4624, 2733.596, 19365770.0, 0.0, 0.0], [3057.0251, -8398.135, -194894.48, 19366994.0, 0.0], [-25942.344, -25767.568, -23766.516, -23687.154, 19043454.0]],
        },
    ];
}
