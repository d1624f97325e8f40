//! Made by `ballrace bake` from the scene "board". Do not edit: bake the scene again.
#![allow(dead_code, unused_imports, clippy::excessive_precision, clippy::unreadable_literal)]

// `ballrace verify` computes these fields and all constants again from the scene at the end of this file.
//: ballrace certificate begin
// program: ballrace 0.1.0
// language: rust
// bearings: all
// scene: board
// scene file: scene.toml
// scene SHA-256: 3284b2b1b3416d2d2abfc490ec8f0a39c6e27056c67f5fbf0dc91b9e4e8542e9
// mass.mtx SHA-256: 2d80a219dc8fcdcb8cef35c4e1964cd3109a0c9b59a40bac2867bdf41a186882
// damping.mtx SHA-256: d889fe561ad828154cef5c89c10bc792c04e06c920133aca907ed2a65d8f5cb1
// stiffness.mtx SHA-256: 14aa35dca0a0175e2d5857369b2a01fec11771433a161bf81da4a63557dd8be5
// load.mtx SHA-256: 1d40cc9617561f6ed0b155773291b13f3c7f9e599c7c5898de122ea6bc8af122
// board.frames SHA-256: absent
// poses from: simulation
// core: cortex-m4f
// arithmetic: f32, exact
// bearing_de bearing: DE
// bearing_de model: lumped, 9 elements
// bearing_de poses: 512, simulation
// bearing_de reference: quasi-static, no effects, f64
// bearing_de largest load: 2.427e2 N
// bearing_de largest error: 2.0e-4 N
// bearing_de largest relative error: 8.0e-7
// bearing_de instructions: 354
// bearing_de cycles: 696
// bearing_de stack: 180 bytes
// bearing_de flash of code: 1232 bytes
// bearing_de flash of table: 0 bytes
// bearing_de flash of other constants: 172 bytes
// bearing_de checksum samples: 1024, 448 without contact, 0 outside the table
// bearing_de checksum: 0x1cc47bcb34e4e8df
//: ballrace certificate end

/// Bearing "DE".
pub mod bearing_de {
    use ballrace::bearing::ElementPosition;
    use ballrace::bearing::lumped::{Axial, Combined, Radial};
    use ballrace::contact::law::{LineContactLaw, PointContactLaw, PowerLaw};
    use ballrace::{Displacement, Exact, Phase};

    /// Along Z from the rotor's centre of mass, m.
    pub const STATION: f32 = 0.0;
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
    /// The bearing's type.
    pub type Baked = Radial<f32, Exact, PointContactLaw<f32>, [ElementPosition<f32>; 9]>;

    /// The bearing, ready for the hot path.
    #[must_use]
    pub fn bearing() -> Baked {
        Radial::from_constants(POSITIONS, PointContactLaw { stiffness: 9215408000.0 }, 5e-6)
    }

    use ballrace::bearing::checksum::ChecksumRange;

    /// Displacements and speeds of the checksum.
    pub const CHECKSUM_RANGE: ChecksumRange = ChecksumRange {
        centre: Displacement { u: 2.46e-8, v: -5.7e-6, w: 0.0, thu: 0.0, thv: 0.0 },
        amplitude: Displacement { u: 6.27e-7, v: 6.27e-6, w: 6.27e-7, thu: 3.21e-5, thv: 3.21e-5 },
        inner_speed: [141.0, 0.0307],
        outer_speed: [0.0, 0.0],
    };
    /// Checksum of 1024 forces, computed on the desktop.
    pub const CHECKSUM: u64 = 0x1cc47bcb34e4e8df;

    /// Computes the checksum; every target returns [`CHECKSUM`]. For start-up: 1024 forces.
    #[must_use]
    pub fn checksum() -> u64 {
        CHECKSUM_RANGE.checksum(&bearing())
    }
}

// Text of the scene.
//: ballrace scene begin
// # A 6205 bearing with half of a rotor of 8 kg and the pull of a belt. The log of the board is the recording.
// name = "board"
//
// [shaft]
// speed = "1500 rpm"
//
// # Motion of the bearing along X and Y.
// [system]
// mass = "mass.mtx"
// damping = "damping.mtx"
// stiffness = "stiffness.mtx"
// load = "load.mtx"
// unbalance = [{ moment = "50 g mm", angle = "0 deg", x = 1, y = 2 }]
//
// [[bearing]]
// name = "DE"
// coordinates = [1, 2, 0, 0, 0]
// facing = "both"
// model = "lumped"
// elements = 9
// ball_diameter = "7.94 mm"
// pitch_diameter = "39.04 mm"
// inner_conformity = 0.52
// outer_conformity = 0.52
// diametral_clearance = "10 um"
//
// [recording]
// file = "board.frames"
// rate = "6.4 kHz"
// probes = [
//   { column = "DE_X", unit = "m", coordinates = [1, 2, 0, 0, 0], angle = "0 deg", noise = "0.1 um" },
//   { column = "DE_Y", unit = "m", coordinates = [1, 2, 0, 0, 0], angle = "90 deg", noise = "0.1 um" },
// ]
// sensors = [{ column = "DE_acceleration", unit = "m/s^2", bearing = "DE" }]
// speed = { column = "speed", unit = "rad/s" }
//
//: ballrace scene end
