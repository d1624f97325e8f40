//! Every hot-path function of the kernel, with inputs that are opaque to the compiler.
#![no_std]
#![no_main]

use ballrace::bearing::angular::Angular;
use ballrace::bearing::batch::radial_batch;
use ballrace::bearing::checksum::{Checksum, ChecksumRange};
use ballrace::bearing::flexible::{FlexibleRing, HousingPoint};
use ballrace::bearing::linear::Linear;
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::quasi_static::film::{Dry, Film, HamrockDowson};
use ballrace::bearing::quasi_static::inertia::{Centrifugal, Gyroscopic, Inertia, Massless, OuterControlled};
use ballrace::bearing::quasi_static::{BallPosition, BallState, QuasiStatic};
use ballrace::bearing::roller::{Lamina, LaminaRoller};
use ballrace::bearing::surface::{Feature, SurfaceDeviation};
use ballrace::bearing::tabulated::{Node, Tabulated};
use ballrace::bearing::{CageFrame, ElementPosition, ElementPositions, LastValidWrench, Mirrored, OpposedPairs};
use ballrace::blob::{Blob, BlobBearing, BlobCheck, FromBlob};
use ballrace::block::{Channel, Metres, ProbedBearing};
use ballrace::contact::law::{LineContactLaw, LoadDeflectionLaw, PointContactLaw, PowerLaw};
use ballrace::frame::{mirrored_stiffness, stiffness_from_station};
use ballrace::phase::{PhaseDelta, SpeedRatio};
use ballrace::probe::Probe;
use ballrace::rotor::{
    AttachedBearing, BearingAtStation, ForceElement, Integrator, LinearSystem, MovingBalls, Newmark, RigidRotor,
    RotorBearingSystem, RotorState, RungeKuttaNystrom, SecondOrderSystem, ShaftMotion, SteadyVerlet, Verlet,
};
use ballrace::twin::{
    DamageDetector, Envelope, ForceOrderTracker, Life, Observer, ObserverState, OrderTracker, SpeedGain, Statistics,
};
use ballrace::{
    Bearing, BearingKinematicState, Displacement, Exact, Fast, Math, Phase, Scalar, Status, Stiffness, Wrench,
};
use core::hint::black_box;
use panic_never as _;

/// A value of any type that the compiler has to take as it is. Nothing runs this image: it is linked, not called.
fn given<T>() -> T {
    match black_box(None) {
        Some(value) => value,
        None => loop {
            core::hint::spin_loop();
        },
    }
}

fn bearing<T: Scalar, B: Bearing<T>>() {
    let (bearing, u, at, mut held): (B, Displacement<T>, BearingKinematicState<T>, LastValidWrench<T>) = given();
    black_box(bearing.reaction(&u, &at));
    black_box(bearing.reaction_and_stiffness(&u, &at));
    black_box(bearing.sample(&mut held, &u, &at));
    bearing.element_loads(&u, &at, given::<&mut [T]>());
    black_box(bearing.reaction_and_loads(&u, &at, given::<&mut [T]>()));
    black_box(held.held_count());
}

fn block<T: Scalar, R: Copy + 'static, C: Channel<T, R>, B: Bearing<T>>() {
    let mut probed: ProbedBearing<T, B, C, 3> = given();
    let (buffer, results): (&[R], &mut [(Wrench<T>, Status)]) = given();
    black_box(probed.samples(buffer, given(), given(), results));
}

fn in_cage<T: Scalar, B: CageFrame<T> + Bearing<T>>() {
    let (bearing, u, cage): (B, Displacement<T>, Phase) = given();
    black_box(bearing.reaction_in_cage_frame(&u, &cage.into()));
    black_box(bearing.reaction_and_stiffness_in_cage_frame(&u, &cage.into(), given()));
    bearing.element_loads_in_cage_frame(&u, &given(), given::<&mut [T]>());
    black_box(bearing.reaction_and_loads_in_cage_frame(&u, &given(), given::<&mut [T]>()));
    self::bearing::<T, B>();
    self::bearing::<T, Mirrored<B>>();
}

fn flexible<T: Scalar, B: FlexibleRing<T>>() {
    let (bearing, u, cage): (B, Displacement<T>, Phase) = given();
    black_box(bearing.reaction_flexible(&u, &cage.into(), given::<&mut [HousingPoint<T>]>()));
    black_box(bearing.reaction_and_stiffness_flexible(&u, &cage.into(), given::<&mut [HousingPoint<T>]>()));
}

fn lumped<T: Scalar, M: Math<T>, L: LoadDeflectionLaw<T, M>>() {
    type Slice<T> = &'static [ElementPosition<T>];
    in_cage::<T, Radial<T, M, L, ElementPositions<T, 9>>>();
    in_cage::<T, Radial<T, M, L, ElementPositions<T, 9>, SurfaceDeviation<M, [Feature<T>; 2]>>>();
    in_cage::<T, Radial<T, M, L, Slice<T>>>();
    in_cage::<T, Radial<T, M, L, OpposedPairs<T, 4>>>();
    in_cage::<T, Axial<T, M, L, ElementPositions<T, 9>>>();
    in_cage::<T, Axial<T, M, L, OpposedPairs<T, 4>>>();
    in_cage::<T, Combined<Radial<T, M, L, ElementPositions<T, 9>>, Axial<T, M, L, ElementPositions<T, 9>>>>();
    flexible::<T, Radial<T, M, L, Slice<T>>>();
    flexible::<T, Combined<Radial<T, M, L, ElementPositions<T, 9>>, Axial<T, M, L, ElementPositions<T, 9>>>>();
    radial_batch(&given::<Radial<T, M, L, Slice<T>>>(), given(), given(), given());
}

fn steps<T: Scalar, R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const D: usize>() {
    let (machine, mut state, drive): (RotorBearingSystem<R, C, 2>, RotorState<T, D, 2>, ShaftMotion<T>) = given();
    black_box(given::<RungeKuttaNystrom<T>>().step(&machine, &mut state, &drive));
    black_box(given::<Newmark<T>>().step(&machine, &mut state, &drive));
    black_box(given::<Verlet<T>>().step(&machine, &mut state, &drive));
    black_box(given::<SteadyVerlet<T, D>>().step(&machine, &mut state, &drive));
    black_box((state, drive.after(given())));
}

fn rotor<T: Scalar, M: Math<T>, B: Bearing<T>>() {
    steps::<T, RigidRotor<T, M>, BearingAtStation<T, B>, 5>();
    steps::<T, LinearSystem<T, M, 9>, AttachedBearing<T, B, 9>, 9>();
}

fn solved<T: Scalar, M: Math<T>, I: Inertia<T>, F: Film<T>>() {
    type Features<T> = [Feature<T>; 2];
    in_cage::<T, QuasiStatic<T, M, ElementPositions<T, 9>, I, F>>();
    in_cage::<T, QuasiStatic<T, M, &'static [ElementPosition<T>], I, F, SurfaceDeviation<M, Features<T>>>>();
    let bearing: QuasiStatic<T, M, ElementPositions<T, 9>, I, F> = given();
    let (u, at): (Displacement<T>, BearingKinematicState<T>) = given();
    black_box(bearing.ring_reactions(&u, &given(), &at));
    black_box(bearing.condensed_stiffness(&u, &at));
    bearing.ball_states(&u, &at, given::<&mut [BallState<T>]>());
    bearing.initial_ball_positions(&u, &at, given::<&mut [BallPosition<T>]>());
    black_box(bearing.warm_started_reaction(&u, &at, given::<&mut [BallPosition<T>]>()));
}

fn looked_up<T: Scalar, M: Math<T>, const F: usize>() {
    in_cage::<T, Tabulated<T, M, ElementPositions<T, 9>, &'static [Node<T, F>], F>>();
    in_cage::<T, Tabulated<T, M, OpposedPairs<T, 4>, &'static [Node<T, F>], F, SurfaceDeviation<M, [Feature<T>; 2]>>>();
}

fn functions<T: Scalar, M: Math<T>>() {
    black_box((M::sqrt(given()), M::powf(given(), given()), M::ninth_root(given()), M::sin_cos(given())));
    black_box((M::sqrt_each::<9>(given()), M::three_halves::<9>(given())));
    let (u, f, k): (Displacement<T>, Wrench<T>, Stiffness<T>) = given();
    black_box((u.mirrored(), u.at_station(given()), u.is_finite(), Displacement::<T>::from_hajzman(given())));
    black_box((f.mirrored(), f.from_station(given()), f.is_finite(), f.to_hajzman(), f + given()));
    black_box((mirrored_stiffness(&k), stiffness_from_station(&k, given())));
    black_box((PhaseDelta::from_radians(given::<T>()), given::<PhaseDelta>().radians::<T>()));
}

fn twin<T: Scalar, M: Math<T>>() {
    type SampleReadings<T, M> = BearingAtStation<T, Angular<T, M, ElementPositions<T, 9>>>;
    type Gains<T> = &'static [SpeedGain<T, 5, 5>];
    type OfFive<T, M> = Observer<T, RigidRotor<T, M>, SampleReadings<T, M>, Verlet<T>, Gains<T>, 5, 2, 5>;
    let observer: OfFive<T, M> = given();
    let mut state: ObserverState<T, 5, 2> = given();
    black_box(observer.sample::<M>(&mut state, &given(), &given()));
    black_box(ObserverState::<T, 5, 2>::new(given()));
    let (mut orders, mut figures, mut envelope, mut life): (OrderTracker<T, 4>, Statistics<T>, Envelope<T>, Life<T>) =
        given();
    black_box((orders.add::<M>(given(), given(), &given()), figures.add::<M>(given()), envelope.add::<M>(given())));
    let mut force_orders: ForceOrderTracker<T, 4> = given();
    black_box(force_orders.add::<M>(given(), &given()));
    for line in force_orders.close().inner {
        black_box((line.polarisation(), line.double_direction()));
    }
    let detector: &mut DamageDetector<T> = given();
    black_box((detector.add(given(), given()), detector.close::<M>(&given())));
    life.add::<M>(given::<&[T]>());
    black_box((life.close::<M>(given()), life.used(), figures.close::<M>(), orders));
}

/// Blocks of any model, of readings of every kind, and of some models by themselves.
fn blocks<T: Scalar, M: Math<T>>() {
    block::<T, u16, Probe<T>, &'static dyn Bearing<T>>();
    block::<T, i16, Probe<T>, &'static dyn Bearing<T>>();
    block::<T, T, Metres, &'static dyn Bearing<T>>();
    block::<T, u16, Probe<T>, Linear<T>>();
    block::<T, u16, Probe<T>, Radial<T, M, PointContactLaw<T>, ElementPositions<T, 9>>>();
    block::<T, u16, Probe<T>, Angular<T, M, ElementPositions<T, 9>>>();
    block::<T, u16, Probe<T>, Tabulated<T, M, ElementPositions<T, 9>, &'static [Node<T, 2>], 2>>();
}

fn all<T: Scalar, M: Math<T>>() {
    blocks::<T, M>();
    functions::<T, M>();
    twin::<T, M>();
    bearing::<T, Linear<T>>();
    lumped::<T, M, PointContactLaw<T>>();
    lumped::<T, M, LineContactLaw<T>>();
    lumped::<T, M, PowerLaw<T>>();
    in_cage::<T, Angular<T, M, ElementPositions<T, 9>>>();
    in_cage::<T, Angular<T, M, &'static [ElementPosition<T>], SurfaceDeviation<M, &'static [Feature<T>]>>>();
    in_cage::<T, Angular<T, M, OpposedPairs<T, 4>>>();
    solved::<T, M, Massless, Dry>();
    solved::<T, M, Centrifugal<T>, HamrockDowson<T>>();
    solved::<T, M, OuterControlled<T>, Dry>();
    solved::<T, M, Gyroscopic<T>, HamrockDowson<T>>();
    looked_up::<T, M, 2>();
    looked_up::<T, M, 3>();
    rotor::<T, M, Angular<T, M, ElementPositions<T, 9>>>();
    rotor::<T, M, Linear<T>>();
    steps::<T, LinearSystem<T, M, 14>, MovingBalls<T, M, ElementPositions<T, 9>, 14>, 14>();
}

fn blob_model<B: Bearing<f32> + FromBlob<'static>>() {
    let record: BlobBearing<'static> = given();
    black_box((
        record.offset(),
        record.ratios(),
        record.station(),
        record.checksum(),
        record.table(),
        record.elements(),
    ));
    if let Ok(bearing) = record.bearing::<B>() {
        black_box(Checksum::begin(&record.checksum_range()).advance(&bearing, given()));
    }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    all::<f32, Exact>();
    all::<f32, Fast>();
    all::<f64, Exact>();
    all::<f64, Fast>();
    let (turn, arc, ratio): (Phase, PhaseDelta, SpeedRatio) = given();
    black_box((
        turn.wrapping_add(given()),
        turn.since(given()),
        turn.advanced(arc),
        turn.reversed(),
        turn.wrapping_mul(given()),
    ));
    black_box((turn.opposite(), ratio.apply(arc)));
    black_box::<[u8; 36]>(ballrace::log::frame::<7, 36>(given(), &given()));
    let range: ChecksumRange = given();
    black_box(range.checksum(&given::<Angular<f32, Exact, ElementPositions<f32, 9>>>()));
    black_box(range.checksum(&given::<Tabulated<f32, Exact, ElementPositions<f32, 9>, &'static [Node<f32, 2>], 2>>()));
    black_box(BlobCheck::default().advance(given(), given()));
    let blob: Blob<'static> = given();
    black_box(blob.bearings().map(|record| record.name()).last());
    blob_model::<Linear<f32>>();
    blob_model::<Radial<f32, Exact, PowerLaw<f32>, &'static [ElementPosition<f32>]>>();
    blob_model::<Angular<f32, Exact, &'static [ElementPosition<f32>]>>();
    blob_model::<Mirrored<Tabulated<f32, Exact, &'static [ElementPosition<f32>], &'static [Node<f32, 3>], 3>>>();
    blob_model::<LaminaRoller<f32, Exact, &'static [ElementPosition<f32>], &'static [Lamina<f32>]>>();
    loop {
        core::hint::spin_loop();
    }
}
