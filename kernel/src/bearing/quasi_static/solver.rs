//! Equilibrium of a ball by a fixed number of safeguarded Newton steps.
//!
//! With constant inertia loads the equilibrium is the minimum of a convex potential with kinks where a contact opens or
//! closes. Three safeguards make the steps converge. A gap has the slope of a deflection of the same size, so that an open
//! contact does not displace the ball across its groove. A step that overshoots (the force along it reverses to almost its
//! original size) is shortened to the zero of the secant. Where friction and race control make the matrix of Newton's
//! method nearly singular, the stiffness of the contacts replaces it.

use super::ball::{Balance, Ball, BallInput, ContactState, Matrix, Position};
use super::film::{BY_LOAD, FLOOR, Film};
use super::inertia::Inertia;
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::math::lanes::{Lanes, Mask, Plane};
use crate::scalar::Scalar;

/// Largest number of reductions of one step.
const MAX_CUTS: f64 = 3.0;
/// A step is reduced if the force along it reverses by more than this share.
const REVERSAL: f64 = -0.9;
/// Smallest determinant of the Newton matrix relative to that of the contact stiffness at which it is used.
const MIN_DETERMINANT_RATIO: f64 = 0.2;

/// Ratio of unbalanced force to largest load from which one step, with the quadratic convergence of Newton's method, reaches
/// rounding errors of `f64`.
const NEAR: f64 = 1e-6;

/// Slope of a contact that counts as 0, N/m.
const SMALLEST_SLOPE: f64 = 1e-6;

/// `1000^-0.067`: film thickness at a typical load relative to that under 1 N.
const FILM_AT_1000_N: f64 = 0.63;
/// Largest ratio of contact load to centrifugal force of a wedged ball in the initial value.
const MAX_WEDGE_RATIO: f64 = 3.0;

/// Solution for `K` balls: positions, forces, convergence.
pub struct Solution<T, const K: usize> {
    pub at: Position<Lanes<T, K>>,
    pub balance: Balance<Lanes<T, K>>,
    pub converged: Mask<K>,
}

impl<T: Scalar, const K: usize> Solution<T, K> {
    /// Returns the positions with the deflections there: the start of the next solution.
    #[inline(always)]
    pub fn position(&self) -> Position<Lanes<T, K>> {
        let Balance { outer, inner, .. } = &self.balance;
        Position { outer_deflection: outer.deflection, inner_deflection: inner.deflection, ..self.at }
    }
}

/// Start of the solution for `K` balls.
pub struct Guess<T, const K: usize> {
    pub at: Position<Lanes<T, K>>,
    /// Gap between the inner race and a ball at the bottom of the outer one, m: in a gap the ball does not roll.
    pub gap: Lanes<T, K>,
}

/// Inverse of the matrix of a Newton step of `K` balls: the adjugate divided by the determinant.
pub struct NewtonMatrix<T, const K: usize> {
    adjugate: Matrix<Lanes<T, K>>,
    inverse_determinant: Lanes<T, K>,
    /// False where the stiffness of contacts, loaded or not, replaces the derivative.
    pub is_derivative: Mask<K>,
}

impl<T: Scalar, const K: usize> NewtonMatrix<T, K> {
    pub fn zero() -> Self {
        let zero = Lanes::splat(T::ZERO);
        Self { adjugate: Matrix::zero(), inverse_determinant: zero, is_derivative: Mask([false; K]) }
    }
    /// Returns the displacement of the balls that balances `force`.
    #[inline(always)]
    pub fn solve(&self, force: Plane<Lanes<T, K>>) -> Plane<Lanes<T, K>> {
        self.adjugate.times(force).times(self.inverse_determinant)
    }
}

/// State of the Newton iteration of `K` balls.
pub struct Iteration<T, const K: usize> {
    pub at: Position<Lanes<T, K>>,
    /// Last step, of which `fraction` was made.
    direction: Plane<Lanes<T, K>>,
    fraction: Lanes<T, K>,
    /// Force along the step at its start.
    slope: Lanes<T, K>,
    /// Reductions of the step so far.
    cut_count: Lanes<T, K>,
}

impl<T: Scalar, const K: usize> From<Position<Lanes<T, K>>> for Iteration<T, K> {
    #[inline(always)]
    fn from(at: Position<Lanes<T, K>>) -> Self {
        let zero = Lanes::splat(T::ZERO);
        Self { at, direction: Plane { r: zero, z: zero }, fraction: zero, slope: zero, cut_count: zero }
    }
}

impl<T: Scalar, M: Math<T>, I: Inertia<T>, F: Film<T>> Ball<T, M, I, F> {
    /// Solves from a cold start. Never inlined: all callers share one copy.
    #[inline(never)]
    pub fn solve<const K: usize>(&self, input: &mut BallInput<T, K>, steps: u8) -> Solution<T, K> {
        let start = M::on_registers(
            #[inline(always)]
            || self.initial_guess(input),
        );
        self.iterate(input, &start.at, steps)
    }

    /// Performs `steps` Newton steps from `start`, then evaluates the forces.
    #[inline(never)]
    pub fn iterate<const K: usize>(
        &self,
        input: &BallInput<T, K>,
        start: &Position<Lanes<T, K>>,
        steps: u8,
    ) -> Solution<T, K> {
        let mut state = Iteration::from(*start);
        for _ in 0..steps {
            let near = self.step(input, &mut state);
            if M::STOPS_EARLY && near {
                let solution = self.solution(input, &state.at);
                if solution.converged.all() {
                    return solution;
                }
            }
        }
        self.solution(input, &state.at)
    }

    /// Performs one step and returns true where the one after it is not needed. On registers of its own it is a function whose state is in memory, from which the compiler sees which lanes belong
    /// together.
    #[inline(always)]
    fn step<const K: usize>(&self, input: &BallInput<T, K>, state: &mut Iteration<T, K>) -> bool {
        M::on_registers(
            #[inline(always)]
            || self.step_on_registers(input, state),
        )
    }

    #[inline(always)]
    fn step_on_registers<const K: usize>(&self, input: &BallInput<T, K>, state: &mut Iteration<T, K>) -> bool {
        let balance = self.balance(input, &state.at);
        self.advance(input, state, &balance);
        M::STOPS_EARLY && balance.is_converged(T::from_f64(NEAR)).all()
    }

    /// Performs one step with the forces at its start and returns its matrix.
    #[inline(always)]
    pub fn advance<const K: usize>(
        &self,
        input: &BallInput<T, K>,
        state: &mut Iteration<T, K>,
        balance: &Balance<Lanes<T, K>>,
    ) -> NewtonMatrix<T, K> {
        let one = Lanes::splat(T::ONE);
        let zero = Lanes::splat(T::ZERO);
        let Iteration { at, direction, fraction, slope, cut_count } = state;
        let along = balance.residual.dot(*direction);
        let over =
            along.less_than(Lanes::splat_f64(REVERSAL) * *slope).and(cut_count.less_than(Lanes::splat_f64(MAX_CUTS)));
        let shorter = (*slope / (*slope - along)).larger(Lanes::splat_f64(0.1)).smaller(Lanes::splat_f64(0.7));
        let matrix = self.newton_matrix(balance);
        let step = self.limited(matrix.solve(balance.residual));
        *direction = Plane::select(over, *direction, step);
        // Either back along the last direction to the zero of the secant, or on along the new one.
        let further = Lanes::select(over, *fraction * (shorter - one), one);
        *fraction = Lanes::select(over, *fraction * shorter, one);
        *slope = Lanes::select(over, *slope, balance.residual.dot(step));
        *cut_count = Lanes::select(over, *cut_count + one, zero);
        at.centre = at.centre.plus(direction.times(further));
        if self.inertia.effects().centrifugal {
            at.inner_closing = Lanes::select(balance.inner.deflection.less_than(zero), zero, input.rolling);
        }
        if self.film.is_present() {
            at.outer_deflection = balance.outer.deflection;
            at.inner_deflection = balance.inner.deflection;
        }
        matrix
    }

    /// Evaluates the forces at a position.
    #[inline(always)]
    fn solution<const K: usize>(&self, input: &BallInput<T, K>, at: &Position<Lanes<T, K>>) -> Solution<T, K> {
        M::on_registers(
            #[inline(always)]
            || {
                let balance = self.balance(input, at);
                let converged = balance.is_converged(T::EQUILIBRIUM_TOLERANCE);
                Solution { at: *at, balance, converged }
            },
        )
    }

    #[inline(always)]
    fn newton_matrix<const K: usize>(&self, balance: &Balance<Lanes<T, K>>) -> NewtonMatrix<T, K> {
        let contacts = balance.contact_stiffnesses();
        let contacts = contacts.outer.plus(contacts.inner);
        let mut matrix = contacts;
        let mut determinant = contacts.determinant();
        let zero = Lanes::splat(T::ZERO);
        let has_its_slope = |contact: &ContactState<Lanes<T, K>>| {
            zero.less_than(contact.deflection).or(contact.slope.less_than(Lanes::splat_f64(SMALLEST_SLOPE)))
        };
        let mut is_derivative = has_its_slope(&balance.outer).and(has_its_slope(&balance.inner));
        if self.inertia.effects().centrifugal {
            let slopes = balance.slopes(self.inertia.effects());
            let newton = slopes.outer.plus(slopes.inner);
            let full = newton.determinant();
            let sure = (Lanes::splat_f64(MIN_DETERMINANT_RATIO) * determinant).less_than(full);
            let sure = sure.and(zero.less_than(newton.trace()));
            matrix = Matrix::select(sure, newton, contacts);
            determinant = Lanes::select(sure, full, determinant);
            is_derivative = is_derivative.and(sure);
        }
        // Two open contacts on one line have no stiffness across it, and no force acts there.
        let trace = matrix.trace();
        let determinant = determinant.larger(Lanes::splat_f64(1e-12) * trace * trace);
        NewtonMatrix {
            adjugate: matrix.adjugate(),
            inverse_determinant: Lanes::splat(T::ONE) / determinant,
            is_derivative,
        }
    }

    /// Returns the step with its components limited to `max_step`.
    #[inline(always)]
    fn limited<const K: usize>(&self, step: Plane<Lanes<T, K>>) -> Plane<Lanes<T, K>> {
        let longest = Lanes::splat(self.constants.max_step);
        let within = |x: Lanes<T, K>| x.smaller(longest).larger(-longest);
        Plane { r: within(step.r), z: within(step.z) }
    }

    /// Returns the approach of balls at `at` and the inner ring, with the thickest film: above 0 they are in contact.
    #[inline(always)]
    pub fn inner_approach<const K: usize>(&self, input: &BallInput<T, K>, at: &Position<Lanes<T, K>>) -> Lanes<T, K> {
        let (inner, _, approach) = self.stretched(self.constants.inner_length, input.grooves.minus(at.centre));
        let mut room = approach + input.inner_deviation;
        if self.film.is_present() {
            let (outer, _, _) = self.stretched(self.constants.outer_length, at.centre);
            let (_, film) = self.unit_films(&input.speeds, self.orbital(&input.speeds, outer, inner), outer, inner);
            room = room + film.thickness * Lanes::splat(self.film.constants().at_floor);
        }
        room
    }

    /// Computes an initial position from two circles.
    ///
    /// The centre of the ball has the distance `L_o` plus the outer deflection from the outer groove centre, and `L_i` plus
    /// the inner deflection from the inner one. If the circles do not intersect, the rings compress the ball between them.
    /// If they do, the centrifugal force holds it outward; with both directions known, the balance of forces gives the
    /// loads and so better radii.
    #[inline(always)]
    pub fn initial_guess<const K: usize>(&self, input: &mut BallInput<T, K>) -> Guess<T, K> {
        let constants = &self.constants;
        let (zero, one) = (Lanes::splat(T::ZERO), Lanes::splat(T::ONE));
        let rest = Plane {
            r: Lanes::splat(constants.distance * constants.axis.r),
            z: Lanes::splat(constants.distance * constants.axis.z),
        };
        let line = rest.plus(input.grooves);
        let length = self.length(line);
        let direction = line.times(one / length);
        let longer = input.grooves.dot(rest.plus(line)) / (length + Lanes::splat(constants.distance));

        let speeds = input.speeds;
        let films_at = |outer: Plane<Lanes<T, K>>, inner: Plane<Lanes<T, K>>| {
            let (outer, inner) = self.unit_films(&speeds, self.orbital(&speeds, outer, inner), outer, inner);
            (outer.thickness, inner.thickness)
        };
        let bulges = longer + input.outer_deviation + input.inner_deviation;
        let (mut outer_film, mut inner_film, mut thickest) = (zero, zero, zero);
        let (outer, inner) = if self.film.is_present() { films_at(direction, direction) } else { (zero, zero) };
        let under = |load: Lanes<T, K>| (load + Lanes::splat_f64(FLOOR)).powf::<M>(T::from_f64(BY_LOAD));
        if self.film.is_present() {
            let half_loaded = self.load_between_rings(bulges + (outer + inner) * Lanes::splat_f64(FILM_AT_1000_N));
            let load = if self.inertia.effects().centrifugal {
                half_loaded + self.centrifugal_force(&speeds, direction, direction)
            } else {
                half_loaded
            };
            let by_load = under(load);
            (outer_film, inner_film) = (outer * by_load, inner * by_load);
            thickest = inner * Lanes::splat(self.film.constants().at_floor);
        }
        let outer_gap = input.outer_deviation + outer_film;
        let inner_gap = input.inner_deviation + inner_film;
        let approach = longer + outer_gap + inner_gap;
        let outer_length = Lanes::splat(constants.outer_length) - outer_gap;
        let inner_length = Lanes::splat(constants.inner_length) - inner_gap;
        let pressed = self.load_between_rings(approach);
        if !self.inertia.effects().centrifugal {
            // Compressed by both rings alike, or free in the middle of the clearance.
            let share = approach * Lanes::splat(constants.outer_share);
            let at = self.position(direction.times(outer_length + share), [share, approach - share], one);
            return Guess { at, gap: -approach };
        }

        // Without contact at the inner race the ball is at the bottom of the outer race.
        let out = Plane { r: one, z: zero };
        let inverse_outer = Lanes::splat(T::ONE / constants.outer_stiffness);
        let inverse_inner = Lanes::splat(T::ONE / constants.inner_stiffness);
        let mut alone = Plane { r: outer_length, z: zero };
        let (mut alone_deflection, mut reach_length) = (zero, length);
        for _ in 0..2 {
            let reach = line.minus(alone);
            reach_length = self.length(reach);
            let inward = reach.times(one / reach_length);
            let centrifugal = self.centrifugal_force(&speeds, out, inward);
            alone_deflection = (centrifugal * inverse_outer).approximate_two_thirds_power();
            let film = if self.film.is_present() { films_at(out, inward).0 * under(centrifugal) } else { zero };
            alone.r = Lanes::splat(constants.outer_length) - input.outer_deviation - film + alone_deflection;
        }
        let gap = Lanes::splat(constants.inner_length) - input.inner_deviation - thickest - reach_length;
        let outside_inner_reach = zero.less_than(gap);
        // No load at all: the ball is free in the middle of the clearance.
        let idle = approach.less_than(zero).and(alone_deflection.less_than(Lanes::splat(constants.min_length)));
        input.rolling = Lanes::select(outside_inner_reach.or(idle), zero, one);
        let free = direction.times(outer_length + approach * Lanes::splat(constants.outer_share));

        let (mut outer_load, mut inner_load) = (pressed, pressed);
        let mut centre = alone;
        let (mut outer_deflection, mut inner_deflection) = (zero, zero);
        for _ in 0..2 {
            outer_deflection = (outer_load * inverse_outer).approximate_two_thirds_power();
            inner_deflection = (inner_load * inverse_inner).approximate_two_thirds_power();
            let (outer, inner) = (outer_length + outer_deflection, inner_length + inner_deflection);
            let along = (length * length + outer * outer - inner * inner) * (Lanes::splat(T::HALF) / length);
            let across = (outer * outer - along * along).positive().sqrt::<M>().xor_sign(line.z);
            centre = direction.times(along).minus(direction.tangent().times(across));
            let reach = line.minus(centre);
            let o = centre.times(one / self.length(centre));
            let i = reach.times(one / self.length(reach));
            // The triangle of the two contact forces and the centrifugal force.
            let centrifugal = self.centrifugal_force(&speeds, o, i);
            let between = (i.z * o.r - i.r * o.z).xor_sign(line.z).larger(Lanes::splat_f64(1e-9));
            let force = (centrifugal + Lanes::splat_f64(1e-6) * pressed) / between;
            let most = pressed + Lanes::splat_f64(MAX_WEDGE_RATIO) * centrifugal;
            inner_load = (force * o.z.xor_sign(line.z).positive()).smaller(most);
            outer_load = (force * i.z.xor_sign(line.z).positive()).smaller(most + centrifugal);
        }
        let centre = Plane::select(outside_inner_reach, alone, Plane::select(idle, free, centre));
        let outer_deflection = Lanes::select(outside_inner_reach, alone_deflection, outer_deflection);
        Guess { at: self.position(centre, [outer_deflection, inner_deflection], input.rolling), gap }
    }

    /// Returns the load of balls that both rings compress by `approach`.
    #[inline(always)]
    fn load_between_rings<const K: usize>(&self, approach: Lanes<T, K>) -> Lanes<T, K> {
        let deflection = approach.positive();
        Lanes::splat(self.constants.series) * deflection * deflection.sqrt::<M>()
    }

    /// Returns the centrifugal force with the contacts along `outer` and `inner`.
    #[inline(always)]
    fn centrifugal_force<const K: usize>(
        &self,
        speeds: &BearingKinematicState<T>,
        outer: Plane<Lanes<T, K>>,
        inner: Plane<Lanes<T, K>>,
    ) -> Lanes<T, K> {
        let speed = self.orbital(speeds, outer, inner);
        Lanes::splat(self.inertia.constants().centrifugal) * speed * speed
    }

    /// Returns the position for a centre given relative to the outer groove centre.
    #[inline(always)]
    fn position<const K: usize>(
        &self,
        centre: Plane<Lanes<T, K>>,
        [outer_deflection, inner_deflection]: [Lanes<T, K>; 2],
        inner_closing: Lanes<T, K>,
    ) -> Position<Lanes<T, K>> {
        let constants = &self.constants;
        let rest = Plane {
            r: Lanes::splat(constants.outer_length * constants.axis.r),
            z: Lanes::splat(constants.outer_length * constants.axis.z),
        };
        Position { centre: centre.minus(rest), outer_deflection, inner_deflection, inner_closing }
    }
}

impl<T: Scalar, const K: usize> Balance<Lanes<T, K>> {
    /// Returns true for balls whose residual is below `tolerance` times the largest load.
    #[inline(always)]
    pub fn is_converged(&self, tolerance: T) -> Mask<K> {
        let allowed = Lanes::splat(tolerance) * self.largest_load() + Lanes::splat_f64(1e-12);
        self.residual.dot(self.residual).less_than(allowed * allowed)
    }
}
