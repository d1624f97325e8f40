//! Counts the instructions of every hot-path function over many inputs: one line each, `name,least,most`.
#![no_std]
#![no_main]

mod counter;
mod inputs;

use ballrace::bearing::angular::{Angular, Zero};
use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
use ballrace::bearing::linear::Linear;
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::{Bearing, HeldWrench, Places, even_places};
use ballrace::contact::law::{Law, Line, Point};
use ballrace::rotor::{
    Drive, Integrator, Machine, Mounted, Newmark, RigidRotor, RotorParams, RotorState, RungeKutta4, Unbalance,
};
use ballrace::turn::Ratio;
use ballrace::{Displacement, Exact, Fast, Math, Stiffness, Turn};
use core::fmt::Display;
use core::hint::black_box;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use counter::Counter;
use panic_semihosting as _;

/// Measures `work` over all inputs and prints its line.
fn measure(counter: &Counter, name: impl Display, mut work: impl FnMut(&Displacement<f32>, Turn)) {
    let (mut least, mut most) = (u32::MAX, 0);
    for i in 0..inputs::COUNT {
        let (u, cage) = black_box(inputs::input(i));
        let count = counter.count(|| work(&u, cage));
        (least, most) = (least.min(count), most.max(count));
    }
    hprintln!("{},{},{}", name, least, most);
}

/// What, elements, math, which of its functions.
struct Name(&'static str, usize, &'static str, &'static str);

impl Display for Name {
    fn fmt(&self, f: &mut core::fmt::Formatter) -> core::fmt::Result {
        match self.1 {
            0 => write!(f, "{}: {}", self.0, self.3),
            n => write!(f, "{}, N = {}, {}: {}", self.0, n, self.2, self.3),
        }
    }
}

fn geometry() -> Option<BallBearingGeometry> {
    BallBearingGeometry {
        ball_diameter: 7.94e-3,
        pitch_diameter: 39.04e-3,
        inner_conformity: 0.52,
        outer_conformity: 0.52,
        contact_angle: 0.0,
        ball: BEARING_STEEL,
        race: BEARING_STEEL,
    }
    .with_clearance(10e-6)
    .ok()
}

#[inline(never)]
fn evaluate<B: Bearing<f32>>(bearing: &B, u: &Displacement<f32>, cage: Turn) {
    black_box(bearing.reaction(u, cage).wrench);
}

#[inline(never)]
fn tangent<B: Bearing<f32>>(bearing: &B, u: &Displacement<f32>, cage: Turn) {
    black_box(bearing.reaction_and_stiffness(u, cage));
}

#[inline(never)]
fn sample<B: Bearing<f32>>(bearing: &B, held: &mut HeldWrench<f32>, u: &Displacement<f32>, cage: Turn) {
    black_box(bearing.sample(held, u, cage));
}

fn bearing<B: Bearing<f32>>(counter: &Counter, what: &'static str, n: usize, math: &'static str, bearing: Option<B>) {
    let Some(bearing) = bearing else { return };
    let name = |kind| Name(what, n, math, kind);
    measure(counter, name("force"), |u, cage| evaluate(black_box(&bearing), u, cage));
    let mut held = HeldWrench::new();
    measure(counter, name("force, input checked"), |u, cage| sample(black_box(&bearing), &mut held, u, cage));
    measure(counter, name("force and tangent"), |u, cage| tangent(black_box(&bearing), u, cage));
}

fn rungs<M: Math<f32>, const N: usize>(counter: &Counter, math: &'static str) {
    let places: Places<f32, N> = even_places(Turn::ZERO);
    let radial = |play: f64| Radial::<f32, M, _, _>::try_new(places, Point { stiffness: 8e9 }, play).ok();
    bearing(counter, "radial 3/2", N, math, radial(5e-6));
    let line = Radial::<f32, M, _, _>::try_new(places, Line { stiffness: 3e8 }, 5e-6).ok();
    bearing(counter, "radial 10/9", N, math, line);
    let axial = Axial::<f32, M, _, _>::try_new(places, Point { stiffness: 8e9 }, 5e-6, 0.02).ok();
    bearing(counter, "radial and axial 3/2", N, math, combined::<M, _, _>(radial(5e-6), axial));
    let angular = geometry().and_then(|g| Angular::<f32, M, _>::try_new(g, places, Zero::Centred).ok());
    bearing(counter, "angular", N, math, angular);
}

fn combined<M: Math<f32>, L: Law<f32, M>, const N: usize>(
    radial: Option<Radial<f32, M, L, Places<f32, N>>>,
    axial: Option<Axial<f32, M, L, Places<f32, N>>>,
) -> Option<Combined<Radial<f32, M, L, Places<f32, N>>, Axial<f32, M, L, Places<f32, N>>>> {
    Some(Combined(radial?, axial?))
}

type Rig = Machine<f32, Exact, Angular<f32, Exact, Places<f32, 9>>, 2>;

fn rig() -> Option<Rig> {
    let mut damping = [[0.0; 5]; 5];
    for (i, row) in damping.iter_mut().enumerate() {
        if let Some(entry) = row.get_mut(i) {
            *entry = if i < 3 { 400.0 } else { 0.4 };
        }
    }
    let params = RotorParams {
        mass: 6.0,
        diametral_inertia: 0.030,
        polar_inertia: 0.006,
        damping,
        stiffness: [0.0; 5],
        gravity: [0.0, -9.80665, 0.0],
        load: [0.0, 0.0, 60.0, 0.0, 0.0],
    };
    let rotor = RigidRotor::try_new(&params, &[Unbalance { moment: 120e-6, angle: 0.3, station: 0.02 }]).ok()?;
    let angular =
        Angular::<f32, Exact, _>::try_new(geometry()?, even_places::<f32, 9>(Turn::ZERO), Zero::Centred).ok()?;
    let at = |station| Mounted { bearing: angular, station, cage_ratio: Ratio::new(0.4) };
    Some(Machine { rotor, bearings: [at(-0.1), at(0.1)] })
}

#[inline(never)]
fn step<I: Integrator<f32>>(integrator: &I, machine: &Rig, state: &mut RotorState<f32, 2>, drive: &Drive<f32>) {
    black_box(integrator.step(machine, state, drive));
}

fn steps<I: Integrator<f32>>(counter: &Counter, name: &'static str, integrator: &I, machine: &Rig) {
    let (mut least, mut most) = (u32::MAX, 0);
    for i in 0..inputs::COUNT {
        let (u, angle) = inputs::input(i);
        let mut state = RotorState::at_rest(u, angle.times(3), [angle, angle.times(5)]);
        let speed = if i % 7 == 0 { u.u } else { u.w * 1e7 };
        let drive = black_box(Drive { angle, speed, acceleration: 0.0 });
        let count = counter.count(|| step(integrator, machine, &mut state, &drive));
        (least, most) = (least.min(count), most.max(count));
    }
    hprintln!("rotor on two angular bearings, N = 9, exact: {},{},{}", name, least, most);
}

#[inline(never)]
fn sin_cos(angle: Turn) {
    black_box(<Exact as Math<f32>>::sin_cos(angle));
}

#[entry]
fn main() -> ! {
    let Some(counter) = Counter::start() else { done() };
    measure(&counter, Name("cage angle", 0, "exact", "sine and cosine"), |_, cage| sin_cos(cage));
    bearing(&counter, "linear", 0, "exact", Some(Linear::new(Stiffness::from_element(1e7_f32))));
    rungs::<Exact, 8>(&counter, "exact");
    rungs::<Exact, 9>(&counter, "exact");
    rungs::<Fast, 8>(&counter, "fast");
    if let Some(machine) = black_box(rig()) {
        steps(&counter, "Runge-Kutta 4", &RungeKutta4 { step: 2e-5 }, &machine);
        steps(&counter, "Newmark, 3 Newton steps", &Newmark { step: 2e-5, newton_steps: 3 }, &machine);
    }
    done()
}

/// Ends the emulator's run.
fn done() -> ! {
    debug::exit(debug::EXIT_SUCCESS);
    loop {}
}
