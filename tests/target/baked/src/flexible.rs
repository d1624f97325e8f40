//! Made by `ballrace bake` from the scene "flexible". Do not edit: bake the scene again.
#![allow(dead_code, unused_imports, clippy::excessive_precision, clippy::unreadable_literal)]

// `ballrace verify` computes these fields and all constants again from the scene at the end of this file.
//: ballrace certificate begin
// program: ballrace 0.1.0
// language: rust
// bearings: all
// scene: flexible
// scene file: scene.toml
// scene SHA-256: 2c63617aa0aa7abd796e6e001684b4dc8d85d86dbcf0318991e45c44c1213eeb
// motion.csv SHA-256: absent
// poses from: simulation
// core: cortex-m4f
// arithmetic: f32, exact
// bearing_de bearing: DE
// bearing_de model: angular, 9 elements
// bearing_de poses: 512, simulation
// bearing_de reference: quasi-static, no effects, f64
// bearing_de largest load: 4.606e1 N
// bearing_de largest error: 7.5e-5 N
// bearing_de largest relative error: 1.7e-6
// bearing_de instructions: 619
// bearing_de cycles: 1399
// bearing_de stack: 144 bytes
// bearing_de flash of code: 980 bytes
// bearing_de flash of table: 0 bytes
// bearing_de flash of other constants: 192 bytes
// bearing_de checksum samples: 1024, 634 without contact, 0 outside the table
// bearing_de checksum: 0x837e8d6297070636
// bearing_nde bearing: NDE
// bearing_nde model: angular, 9 elements
// bearing_nde poses: 512, simulation
// bearing_nde reference: quasi-static, no effects, f64
// bearing_nde largest load: 4.119e1 N
// bearing_nde largest error: 8.4e-5 N
// bearing_nde largest relative error: 2.1e-6
// bearing_nde instructions: 619
// bearing_nde cycles: 1399
// bearing_nde stack: 144 bytes
// bearing_nde flash of code: 980 bytes
// bearing_nde flash of table: 0 bytes
// bearing_nde flash of other constants: 192 bytes
// bearing_nde checksum samples: 1024, 632 without contact, 0 outside the table
// bearing_nde checksum: 0xfabdc0dd91950924
//: ballrace certificate end

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

    use ballrace::bearing::checksum::ChecksumRange;

    /// Displacements and speeds of the checksum.
    pub const CHECKSUM_RANGE: ChecksumRange = ChecksumRange {
        centre: Displacement { u: -1.9e-12, v: -3.87e-7, w: 3.2e-5, thu: 3.71e-5, thv: 3.51e-11 },
        amplitude: Displacement { u: 3.52e-6, v: 3.52e-6, w: 3.52e-5, thu: 0.00018, thv: 0.00018 },
        inner_speed: [283.0, 0.0614],
        outer_speed: [0.0, 0.0],
    };
    /// Checksum of 1024 forces, computed on the desktop.
    pub const CHECKSUM: u64 = 0x837e8d6297070636;

    /// Computes the checksum; every target returns [`CHECKSUM`]. For start-up: 1024 forces.
    #[must_use]
    pub fn checksum() -> u64 {
        CHECKSUM_RANGE.checksum(&bearing())
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

    use ballrace::bearing::checksum::ChecksumRange;

    /// Displacements and speeds of the checksum.
    pub const CHECKSUM_RANGE: ChecksumRange = ChecksumRange {
        centre: Displacement { u: -8.05e-12, v: -6.6e-8, w: 3.2e-5, thu: -3.11e-5, thv: -2.86e-11 },
        amplitude: Displacement { u: 3.52e-6, v: 3.52e-6, w: 3.52e-5, thu: 0.00018, thv: 0.00018 },
        inner_speed: [283.0, 0.0614],
        outer_speed: [0.0, 0.0],
    };
    /// Checksum of 1024 forces, computed on the desktop.
    pub const CHECKSUM: u64 = 0xfabdc0dd91950924;

    /// Computes the checksum; every target returns [`CHECKSUM`]. For start-up: 1024 forces.
    #[must_use]
    pub fn checksum() -> u64 {
        CHECKSUM_RANGE.checksum(&bearing())
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
            position: [[0.010141449, 0.010367616, 0.0012270939, 0.031545356, -0.030359427, 0.002383011, 0.0023689854, -0.0013456177, -0.0016011401], [-0.009559233, 0.011014523, 0.0012166514, 0.032564394, 0.029390587, -0.0019263113, 0.002855223, 0.000973384, -0.0020165357], [0.011598114, 0.01343501, 0.0011323462, -0.14071634, 0.1017393, -0.0032277063, -0.005591904, 0.031631984, 0.047529973], [-0.0107191345, 0.014395161, 0.0011214282, -0.13957801, -0.10265187, 0.0037105666, -0.00504598, -0.03182209, 0.047244493], [1.1199318e-5, 0.0005975312, 0.09336713, -0.00015448136, -8.6216465e-7, 2.4121007e-6, -0.0007048831, 4.412619e-6, -0.00044314933]],
            rate: [[0.9830178, 1.7721015, 0.7265193, 4.761343, -4.2772036, 0.3593418, 0.79331964, -0.2691371, -0.5967757], [-1.693576, 1.0620539, 0.7161468, 5.684509, 3.5185723, -0.6850148, 0.48024166, 0.15656498, -0.7693905], [4.8609123, 8.773526, 1.2513258, -63.4875, 33.650764, -0.68636495, -1.4641526, 12.174166, 24.098658], [-5.1850514, 8.431573, 1.245996, -63.61092, -33.39771, 0.5841046, -1.5652035, -12.225823, 23.997807], [0.017892186, 1.6062181, 58.53976, -0.86937046, -0.0027992213, 0.0067379684, -0.034259327, 0.003142836, 0.24593967]],
            load: [[581258.75, 625236.56, -3468.433, 125070.57, -122926.06, -1388070.6, -1487028.6, 0.0, 0.0], [-625229.94, 583678.56, -2819.3599, 122266.71, 125167.55, 1487096.3, -1392857.0, 0.0, 0.0], [609417.94, 630119.06, -913.4682, -145662.45, 146188.3, -1222264.5, -1268436.0, 0.0, 0.0], [-636125.0, 600865.44, -661.3065, -145190.03, -147117.0, 1280470.0, -1204218.9, 0.0, 0.0], [504.51248, 2339.3762, 841464.56, 635.9189, -41.27703, -1149.3717, -5706.1455, 0.0, 0.0]],
            rotating_load: [[9650.534, 3874.0322, 0.0, 29.74352, -100.15135, 4795.9033, 1876.7263, 0.0, 0.0], [-4029.5884, 9686.821, 0.0, 93.879, 23.799784, -1918.9862, 4783.107, 0.0, 0.0], [9051.8125, -2139.0938, 0.0, 245.95917, 1328.7229, -2098.1472, 180.34253, 0.0, 0.0], [1306.6348, 8307.18, 0.0, -1176.9572, 288.31793, -750.3884, -1728.6682, 0.0, 0.0], [12.343585, -237.22693, 0.0, 9.166494, -1.0484154, 10.401504, -63.973812, 0.0, 0.0]],
            whitening: [[19839800.0, 0.0, 0.0, 0.0, 0.0], [-6267.6084, 19839626.0, 0.0, 0.0, 0.0], [-13878.2, 6901.3545, 19364860.0, 0.0, 0.0], [41.08251, -14077.44, -194200.86, 19366220.0, 0.0], [-25774.605, -25555.266, -23784.473, -23555.145, 19043454.0]],
        },
    ];
}

// Text of the scene.
//: ballrace scene begin
// name = "flexible"
// [shaft]
// speed = "3000 rpm"
// [rotor]
// sections = [{ from = "0 mm", to = "500 mm", outer_diameter = "30 mm" }]
// disks = [{ station = "200 mm", mass = "3 kg", diametral_inertia = 0.005, polar_inertia = 0.009 }]
// proportional_damping = { mass = "200 1/s", stiffness = "2e-6 s" }
// coordinates = 7
// load = [0, 0, 60, 0, 0]
// unbalance = [{ moment = "50 g mm", angle = "30 deg", station = "200 mm" }]
// [integration]
// method = "verlet"
// [[bearing]]
// name = "DE"
// station = "30 mm"
// model = "angular"
// facing = "both"
// elements = 9
// ball_diameter = "7.94 mm"
// pitch_diameter = "39.04 mm"
// inner_conformity = 0.52
// outer_conformity = 0.52
// diametral_clearance = "10 um"
// [[bearing]]
// name = "NDE"
// station = "470 mm"
// model = "angular"
// facing = "both"
// elements = 9
// ball_diameter = "7.94 mm"
// pitch_diameter = "39.04 mm"
// inner_conformity = 0.52
// outer_conformity = 0.52
// diametral_clearance = "10 um"
// support = { mass = "2 kg", stiffness_x = 3e7, stiffness_y = 2e7, damping = 400 }
// [recording]
// file = "motion.csv"
// rate = "12.8 kHz"
// probes = [
//   { column = "DE_X", unit = "um", station = "65 mm", angle = "45 deg", noise = "0.05 um" },
//   { column = "DE_Y", unit = "um", station = "65 mm", angle = "135 deg", noise = "0.05 um" },
//   { column = "NDE_X", unit = "um", station = "435 mm", angle = "45 deg", noise = "0.05 um" },
//   { column = "NDE_Y", unit = "um", station = "435 mm", angle = "135 deg", noise = "0.05 um" },
//   { column = "axial", unit = "um", axial = true, noise = "0.05 um" },
// ]
// keyphasor = { column = "keyphasor", pulses_per_turn = 1 }
// [observer]
// process_noise = 5
//
//: ballrace scene end
