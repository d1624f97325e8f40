//! Every model, rotor step and the twin, in `f32` with the math backend `Exact`.

use crate::Sample;
use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::flexible::{FlexibleRing, HousingPoint};
use ballrace::bearing::geometry::InvalidParameter;
use ballrace::bearing::linear::Linear;
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::quasi_static::QuasiStatic;
use ballrace::bearing::quasi_static::film::{HamrockDowson, Lubricant};
use ballrace::bearing::quasi_static::inertia::{FrictionSharing, Gyroscopic, InertiaParams, RaceControl};
use ballrace::bearing::surface::{BearingComponent, Feature, Spall, SpallShape, SurfaceDeviation};
use ballrace::bearing::{
    ElementPositions, LastValidWrench, Mirrored, OpposedPairs, Reaction, evenly_spaced, evenly_spaced_pairs,
};
use ballrace::contact::law::{LineContactLaw, PointContactLaw, PowerLaw};
use ballrace::phase::SpeedRatio;
use ballrace::rotor::{Integrator, Newmark, RotorState, RungeKuttaNystrom, ShaftMotion};
use ballrace::{Bearing, BearingKinematicState, Displacement, Exact, Math, Phase, Stiffness};
use rig::{Ball, CAGE_RATIO, Rig, machine};

/// FNV-1a over the bits of results.
#[derive(Clone, Copy)]
pub struct Checksum(pub u64);

impl Checksum {
    pub const EMPTY: Self = Self(0xcbf2_9ce4_8422_2325);

    fn add(&mut self, results: impl IntoIterator<Item = f32>) {
        for x in results {
            self.add_bits(x.to_bits());
        }
    }

    pub fn add_bits(&mut self, bits: u32) {
        for byte in bits.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

#[path = "../../baked/src/bearings.rs"]
#[rustfmt::skip]
pub mod baked;

type Nine = ElementPositions<f32, 9>;
type Solved = QuasiStatic<f32, Exact, Nine, Gyroscopic<f32>, HamrockDowson<f32>>;
type Both = Combined<Radial<f32, Exact, PointContactLaw<f32>, Nine>, Axial<f32, Exact, PointContactLaw<f32>, Nine>>;

/// The bearings of all models.
struct Bearings {
    linear: Linear<f32>,
    balls: Radial<f32, Exact, PointContactLaw<f32>, Nine>,
    preloaded: Radial<f32, Exact, PointContactLaw<f32>, Nine>,
    pairs: Radial<f32, Exact, PointContactLaw<f32>, OpposedPairs<f32, 4>>,
    rollers: Radial<f32, Exact, LineContactLaw<f32>, Nine>,
    power: Radial<f32, Exact, PowerLaw<f32>, Nine>,
    axial: Axial<f32, Exact, PointContactLaw<f32>, Nine>,
    angular: Ball<f32>,
    angular_pairs: Angular<f32, Exact, OpposedPairs<f32, 4>>,
    spalled: Angular<f32, Exact, Nine, SurfaceDeviation<Exact, [Feature<f32>; 1]>>,
    facing_back: Mirrored<Ball<f32>>,
    solved: Solved,
    looked_up: baked::bearing_nde::Baked,
}

const COUNT: usize = 12;

impl Bearings {
    fn try_new() -> Result<Self, InvalidParameter> {
        let places: Nine = evenly_spaced(Phase(0x0123_4567_89ab_cdef));
        let point = PointContactLaw { stiffness: 8e9 };
        let geometry = rig::geometry()?;
        let angular = Angular::try_new(geometry, places, DisplacementDatum::Centred)?;
        let spall =
            Spall::new(BearingComponent::Outer, Phase::from_revolutions(-0.25), 0.05, 3e-6, SpallShape::HalfSine);
        let (_, tangent) =
            angular.reaction_and_stiffness(&Displacement { w: 60e-6, ..Displacement::default() }, &Phase(0).into());
        let inertia = InertiaParams {
            density: 7800.0,
            centrifugal: true,
            gyroscopic: true,
            race_control: RaceControl::Inner,
            friction_sharing: FrictionSharing::Proportional,
        };
        let oil = Lubricant { viscosity: 0.04, pressure_viscosity: 2.2e-8 };
        Ok(Self {
            solved: QuasiStatic::try_new(geometry, places, DisplacementDatum::Centred)?
                .with_inertia(&inertia)?
                .with_film(oil)?,
            looked_up: baked::bearing_nde::bearing(),
            linear: Linear::new(tangent),
            balls: Radial::try_new(places, point, 5e-7)?,
            preloaded: Radial::try_new(places, point, -2e-6)?,
            pairs: Radial::try_new(evenly_spaced_pairs(Phase::ZERO), point, 5e-7)?,
            rollers: Radial::try_new(places, LineContactLaw { stiffness: 3e8 }, 5e-7)?,
            power: Radial::try_new(places, PowerLaw { stiffness: 2e9, exponent: 1.4 }, 5e-7)?,
            axial: Axial::try_new(places, point, 5e-6, 0.02)?,
            angular,
            angular_pairs: Angular::try_new(geometry, evenly_spaced_pairs(Phase::ZERO), DisplacementDatum::Centred)?,
            spalled: angular.with_surface(SurfaceDeviation::new([Feature::Spall(spall)])),
            facing_back: Mirrored(angular),
        })
    }

    fn flexible(&self) -> Both {
        Combined(self.balls, self.axial)
    }

    fn named<'a>(&'a self, combined: &'a Both) -> [(&'static str, &'a dyn Bearing<f32>); COUNT] {
        [
            ("linear", &self.linear),
            ("radial 3/2", &self.balls),
            ("radial 3/2, preload", &self.preloaded),
            ("radial 3/2, pairs", &self.pairs),
            ("radial 10/9", &self.rollers),
            ("radial, any power", &self.power),
            ("axial 3/2", &self.axial),
            ("radial and axial 3/2", combined),
            ("angular", &self.angular),
            ("angular, pairs", &self.angular_pairs),
            ("angular, spall", &self.spalled),
            ("angular, mirrored", &self.facing_back),
        ]
    }
}

/// The rotor, its twin along the recording, and what is summed up so far.
pub struct Subjects {
    bearings: Bearings,
    machine: Rig<f32>,
    held: [LastValidWrench<f32>; COUNT],
    forces: [Checksum; COUNT],
    flexible: Checksum,
    solved: Checksum,
    looked_up: Checksum,
    cage_angle: Checksum,
    runge_kutta: (RotorState<f32, 5, 2>, Checksum),
    newmark: (RotorState<f32, 5, 2>, Checksum),
    residual: Checksum,
    cage: Phase,
    last: Option<Sample>,
    taken: u32,
}

/// Tangents, loads and the flexible ring are summed up at every so many samples: they cost most without an FPU.
const SPARSE: u32 = 16;
/// s between samples.
const STEP: f32 = 1.0 / 12_800.0;

impl Subjects {
    /// Nothing taken yet.
    ///
    /// # Errors
    /// None with the parameters above; constructors can always fail.
    pub fn try_new() -> Result<Self, InvalidParameter> {
        let bearings = Bearings::try_new()?;
        let start =
            RotorState::stationary(Displacement { w: 60e-6, ..Displacement::default() }, Phase::ZERO, [Phase::ZERO; 2]);
        Ok(Self {
            machine: machine(bearings.angular)?,
            bearings,
            held: [LastValidWrench::new(); COUNT],
            forces: [Checksum::EMPTY; COUNT],
            flexible: Checksum::EMPTY,
            solved: Checksum::EMPTY,
            looked_up: Checksum::EMPTY,
            cage_angle: Checksum::EMPTY,
            runge_kutta: (start, Checksum::EMPTY),
            newmark: (start, Checksum::EMPTY),
            residual: Checksum::EMPTY,
            cage: Phase::ZERO,
            last: None,
            taken: 0,
        })
    }

    /// The next sample.
    pub fn take(&mut self, sample: &Sample) {
        let turned = self.last.map_or(ballrace::phase::PhaseDelta::ZERO, |last| sample.shaft.since(last.shaft));
        self.cage = self.cage.advanced(SpeedRatio::new(CAGE_RATIO).apply(turned));
        let (sin, cos): (f32, f32) = Exact::sin_cos(self.cage);
        self.cage_angle.add([sin, cos]);
        self.take_forces(sample);
        if self.taken.is_multiple_of(SPARSE) && sample.displacement.is_finite() {
            self.take_balls(sample, turned.radians::<f32>() / STEP);
        }
        self.take_steps(sample, turned.radians::<f32>() / STEP);
        self.last = Some(*sample);
        self.taken += 1;
    }

    fn take_forces(&mut self, sample: &Sample) {
        let u = &sample.displacement;
        let sparse = self.taken.is_multiple_of(SPARSE) && u.is_finite();
        let combined = self.bearings.flexible();
        let bearings = self.bearings.named(&combined);
        for (((_, bearing), held), sum) in bearings.into_iter().zip(&mut self.held).zip(&mut self.forces) {
            let (wrench, status) = bearing.sample(held, u, &self.cage.into());
            sum.add(wrench.to_array());
            sum.add_bits(u32::from(status.bits()));
            if sparse {
                let (reaction, tangent): (_, Stiffness<f32>) = bearing.reaction_and_stiffness(u, &self.cage.into());
                let mut loads = [0.0; 9];
                bearing.element_loads(u, &self.cage.into(), &mut loads);
                sum.add(reaction.wrench.to_array().into_iter().chain(tangent.iter().copied()).chain(loads));
            }
        }
        if sparse {
            let point = HousingPoint { displacement: [1e-6, -2e-6, 5e-7], ..HousingPoint::default() };
            let mut housing = [point; 9];
            let (reaction, tangent) = combined.reaction_and_stiffness_flexible(u, &self.cage.into(), &mut housing);
            self.flexible.add(reaction.wrench.to_array().into_iter().chain(tangent.iter().copied()));
            self.flexible.add(housing.into_iter().flat_map(|point| point.reaction));
        }
    }

    /// The models whose balls are in equilibrium, in few of the samples: they cost most of all.
    fn take_balls(&mut self, sample: &Sample, speed: f32) {
        let at = BearingKinematicState {
            cage: self.cage,
            inner: sample.shaft,
            inner_speed: speed,
            ..BearingKinematicState::default()
        };
        let u = &sample.displacement;
        let add = |sum: &mut Checksum, (reaction, tangent): (Reaction<f32>, Stiffness<f32>)| {
            sum.add(reaction.wrench.to_array().into_iter().chain(tangent.iter().copied()));
            sum.add_bits(u32::from(reaction.status.bits()));
        };
        add(&mut self.looked_up, self.bearings.looked_up.reaction_and_stiffness(u, &at));
        if self.taken.is_multiple_of(4 * SPARSE) {
            add(&mut self.solved, self.bearings.solved.reaction_and_stiffness(u, &at));
        }
    }

    /// One step of both integrators along the recording's shaft angle, and what the twin leaves of the sample.
    fn take_steps(&mut self, sample: &Sample, speed: f32) {
        let drive = ShaftMotion { angle: sample.shaft, speed, acceleration: 0.0 };
        let (state, sum) = &mut self.runge_kutta;
        let status = RungeKuttaNystrom { step: STEP }.step(&self.machine, state, &drive);
        let twin = state.q;
        sum.add(twin);
        sum.add_bits(u32::from(status.bits()));
        if sample.displacement.is_finite() {
            let measured = sample.displacement.to_array();
            self.residual.add(measured.into_iter().zip(twin).map(|(measured, twin)| measured - twin));
        }
        let (state, sum) = &mut self.newmark;
        let status = Newmark { step: STEP, newton_steps: 3 }.step(&self.machine, state, &drive);
        sum.add(state.q);
        sum.add_bits(u32::from(status.bits()));
    }

    /// Returns each subject's name and checksum.
    pub fn tell(&self, mut line: impl FnMut(&str, u64)) {
        let combined = self.bearings.flexible();
        for ((name, _), sum) in self.bearings.named(&combined).into_iter().zip(self.forces) {
            line(name, sum.0);
        }
        line("flexible ring", self.flexible.0);
        line("quasi-static, gyroscopic, film", self.solved.0);
        line("tabulated", self.looked_up.0);
        line("sine and cosine", self.cage_angle.0);
        line("Runge-Kutta-Nystrom", self.runge_kutta.1.0);
        line("Newmark", self.newmark.1.0);
        line("twin's residual", self.residual.0);
    }
}
