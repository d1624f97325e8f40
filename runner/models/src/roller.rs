//! Rollers by laminae: both contacts in series, and each roller in equilibrium.

use crate::construction::{BuildError, facing, invalid, kinematics, named, places, uneven};
use crate::handle::BearingHandle;
use crate::model::c::{Array, CStruct, Member};
use crate::model::{self as firmware, BearingModel, Constants, FirmwareModel, LevelOptions, NotCounted, rust};
use crate::simd::OnWideRegisters;
use ballrace::bearing::lumped::Combined;
use ballrace::bearing::roller::{
    Lamina, LaminaRoller, QuasiStaticRoller, RollerBearingParams, RollerConstants, RollerInertia, RollerProfile,
    RollerState,
};
use ballrace::bearing::surface::{Feature, Smooth, Surface, SurfaceDeviation};
use ballrace::bearing::{ElementLayout, ElementPosition};
use ballrace::{BearingKinematicState, Displacement, Exact, Math, Phase, Scalar};
use ballrace_scene::{Bearing as BearingScene, Facing, Model, RollerKind, Rollers, Scene};
use std::f64::consts::PI;
use std::fmt::Write;

/// Laminae of a roller that are compared.
const COMPARED_LAMINAE: [i64; 3] = [5, 11, 21];

/// [`Model::Roller`]
pub(crate) struct RollerModel;

impl BearingModel for RollerModel {
    fn model(&self) -> Model {
        Model::Roller
    }
    /// With few laminae, then with those of the scene.
    fn levels(&self, _scene: &Scene, _effects: &[&'static str]) -> Vec<LevelOptions> {
        let with = |laminae: i64| LevelOptions {
            name: format!("{}, {laminae} laminae", Model::Roller.name()),
            laminae: Some(laminae),
            ..LevelOptions::default()
        };
        COMPARED_LAMINAE.map(with).into_iter().chain([LevelOptions::plain(self.model())]).collect()
    }
    /// Firmware has bearings with one row.
    fn firmware(&self, of: &BearingScene) -> Option<&'static dyn FirmwareModel> {
        let has_two_rows = of.rollers.as_ref().is_some_and(|rollers| rollers.kind.rows() > 1);
        if has_two_rows { None } else { Some(&Self) }
    }
    fn counted_row(&self, _of: &BearingScene) -> Result<&'static str, NotCounted> {
        Err(NotCounted::Rollers)
    }
}

impl FirmwareModel for RollerModel {
    fn constant_bytes(&self, of: &BearingScene) -> usize {
        let laminae = of.rollers.as_ref().map_or(0, |rollers| rollers.laminae);
        firmware::element_bytes(of) + size_of::<RollerConstants<f32>>() + laminae * size_of::<Lamina<f32>>()
    }

    fn write_rust(&self, out: &mut String, constants: &Constants<'_>) -> Result<(), BuildError> {
        let of = constants.of;
        let (surface, with) = rust::surface(of);
        rust::imports(out, of, "    use ballrace::bearing::roller::{Lamina, LaminaRoller, RollerConstants};")?;
        rust::position_constants(out, constants)?;
        let RollerConstants { stiffness, arm, axis, play } = self::constants(of, 1.0)?.rounded::<f32>();
        writeln!(
            out,
            "    const CONSTANTS: RollerConstants<f32> = RollerConstants {{ stiffness: {stiffness:?}, arm: {arm:?}, axis: {axis:?}, play: {play:?} }};"
        )?;
        let laminae = laminae::<f32>(of)?;
        let count = laminae.len();
        writeln!(out, "    /// Laminae of each roller.\n    pub const LAMINAE: [Lamina<f32>; {count}] = [")?;
        for Lamina { position, drop } in laminae {
            writeln!(out, "        Lamina {{ position: {position:?}, drop: {drop:?} }},")?;
        }
        writeln!(out, "    ];")?;
        rust::feature_constants(out, of)?;
        let kind = format!(
            "LaminaRoller<f32, Exact, [ElementPosition<f32>; {}], [Lamina<f32>; {count}]{surface}>",
            of.elements
        );
        let value = format!("LaminaRoller::from_constants(POSITIONS, CONSTANTS, LAMINAE){with}");
        rust::function(out, of, &kind, &value)
    }

    fn c_struct(&self, constants: &Constants<'_>) -> Result<CStruct, BuildError> {
        let of = constants.of;
        let laminae = laminae::<f32>(of)?;
        let RollerConstants { stiffness, arm, axis: [cos, sin], play } = self::constants(of, 1.0)?.rounded::<f32>();
        let members = vec![
            ("stiffness", Member::Number(stiffness)),
            ("arm", Member::Number(arm)),
            ("axis_cos", Member::Number(cos)),
            ("axis_sin", Member::Number(sin)),
            ("play", Member::Number(play)),
            ("lamina_count", Member::Integer(laminae.len() as u32)),
        ];
        Ok(CStruct::new::<InFirmware<'_>>(of, "ballrace_roller", "ballrace_roller", members).with_array(Array {
            member: "laminae",
            kind: "ballrace_lamina",
            numbers_per_entry: 2,
            numbers_per_line: 2,
            numbers: laminae.iter().flat_map(|lamina| [lamina.position, lamina.drop]).collect(),
            comment: None,
        }))
    }
}

/// The bearing as firmware has it.
type InFirmware<'a> = LaminaRoller<f32, Exact, &'a [ElementPosition<f32>], &'a [Lamina<f32>]>;

/// [`Model::QuasiStaticRoller`]
pub(crate) struct QuasiStaticRollerModel;

impl BearingModel for QuasiStaticRollerModel {
    fn model(&self) -> Model {
        Model::QuasiStaticRoller
    }
    fn firmware(&self, _of: &BearingScene) -> Option<&'static dyn FirmwareModel> {
        None
    }
    fn counted_row(&self, _of: &BearingScene) -> Result<&'static str, NotCounted> {
        Err(NotCounted::Rollers)
    }
}

/// Builds rollers with both contacts in series.
pub fn build<T: Scalar, M: Math<T>, H: BearingHandle<T>>(_: &Scene, of: &BearingScene) -> Result<H, BuildError> {
    let row = Row::<T, H::Registers<M>>::new(of, 1.0)?;
    if rollers(of)?.kind.rows() > 1 {
        let other = Row::<T, H::Registers<M>>::new(of, -1.0)?;
        return Ok(match uneven::<T, H::Registers<M>>(of).zip(uneven::<T, H::Registers<M>>(of)) {
            None => facing(of, H::dispatched(Combined(row, other))),
            Some((a, b)) => facing(of, H::dispatched(Combined(row.with_surface(a), other.with_surface(b)))),
        });
    }
    Ok(match uneven::<T, H::Registers<M>>(of) {
        None => facing(of, H::dispatched(row)),
        Some(surface) => facing(of, H::dispatched(row.with_surface(surface))),
    })
}

/// Builds rollers in equilibrium.
pub fn build_solved<T: Scalar, M: Math<T>, H: BearingHandle<T>>(
    scene: &Scene,
    of: &BearingScene,
) -> Result<H, BuildError> {
    let row = Row::<T, H::Registers<M>>::new(of, 1.0)?;
    let inertia = inertia(scene, of)?;
    let solved = |error| named(of, error);
    Ok(match uneven::<T, H::Registers<M>>(of) {
        None => facing(of, H::dispatched(QuasiStaticRoller::try_new(row, &inertia).map_err(solved)?)),
        Some(surface) => {
            let row = row.with_surface(surface);
            facing(of, H::dispatched(QuasiStaticRoller::try_new(row, &inertia).map_err(solved)?))
        }
    })
}

/// A row of rollers.
type Row<T, M, S = Smooth> = LaminaRoller<T, M, Vec<ElementPosition<T>>, Vec<Lamina<T>>, S>;

/// Constructor of a [`Row`].
trait NewRow: Sized {
    /// Creates the row whose thrust direction has the sign of `direction`.
    fn new(of: &BearingScene, direction: f64) -> Result<Self, BuildError>;
}

impl<T: Scalar, M: Math<T>> NewRow for Row<T, M> {
    fn new(of: &BearingScene, direction: f64) -> Result<Self, BuildError> {
        let constants = constants(of, direction)?.rounded();
        let laminae = laminae::<T>(of)?;
        let mut positions = places::<T>(of);
        if direction < 0.0 {
            // The rollers of the second row of a spherical bearing are between those of the first.
            let half_pitch = Phase::from_radians(PI / of.elements.max(1) as f64);
            let half_pitch = if of.facing == Facing::MinusZ { half_pitch.reversed() } else { half_pitch };
            for position in &mut positions {
                *position = ElementPosition::from_azimuth(position.azimuth().wrapping_add(half_pitch));
            }
        }
        Ok(Self::from_constants(positions, constants, laminae))
    }
}

/// Returns the rollers of a bearing.
fn rollers(of: &BearingScene) -> Result<&Rollers, BuildError> {
    let missing = || invalid(of, "model roller", "no rollers", "roller_diameter, roller_length and pitch_diameter");
    of.rollers.as_ref().ok_or_else(missing)
}

/// Returns the constants of a row.
fn constants(of: &BearingScene, direction: f64) -> Result<RollerConstants<f64>, BuildError> {
    let rollers = rollers(of)?;
    let law = of.law.and_then(|law| law.stiffness.zip(law.radial_play));
    let Some((stiffness, radial_play)) = law else {
        return Err(invalid(of, "model roller", "no stiffness or radial_play", "both"));
    };
    let params = RollerBearingParams {
        pitch_diameter: rollers.pitch_diameter,
        contact_angle: rollers.contact_angle,
        radial_play,
        stiffness,
    };
    let constants = RollerConstants::try_new(&params, rollers.laminae).map_err(|error| named(of, error))?;
    let [cos, sin] = constants.axis;
    // A spherical raceway has the centre of the bearing on every line of contact: tilt has no lever arm.
    let arm = if rollers.kind == RollerKind::Spherical { 0.0 } else { constants.arm };
    Ok(RollerConstants { axis: [cos, direction * sin], arm, ..constants })
}

/// Returns the laminae of each roller.
fn laminae<T: Scalar>(of: &BearingScene) -> Result<Vec<Lamina<T>>, BuildError> {
    let rollers = rollers(of)?;
    let profile = match &rollers.profile {
        ballrace_scene::RollerProfile::Straight => RollerProfile::Straight,
        ballrace_scene::RollerProfile::Logarithmic(coefficient) => {
            RollerProfile::Logarithmic { coefficient: *coefficient }
        }
        ballrace_scene::RollerProfile::Drops(drops) => RollerProfile::Drops(drops),
    };
    let lamina = |index| {
        let lamina = Lamina::<f64>::try_new(rollers.length, &profile, index, rollers.laminae);
        let Lamina { position, drop } = lamina.map_err(|error| named(of, error))?;
        // Spherical rollers follow the tilt of the inner ring.
        let position = if rollers.kind == RollerKind::Spherical { 0.0 } else { position };
        Ok(Lamina { position: T::from_f64(position), drop: T::from_f64(drop) })
    };
    (0..rollers.laminae).map(lamina).collect()
}

/// Returns the inertia of the rollers, none where the effect is switched off: solid cylinders in pure rolling, or with the `cage_ratio` of the scene.
fn inertia(scene: &Scene, of: &BearingScene) -> Result<RollerInertia, BuildError> {
    let &Rollers { diameter, length, pitch_diameter, density, .. } = rollers(of)?;
    let rolling = RollerInertia::of_cylinders(diameter, length, pitch_diameter, density);
    let mass = if of.effects.centrifugal { rolling.mass } else { 0.0 };
    let rolling = RollerInertia { mass, ..rolling };
    let given = of.cage_ratio.map(|_| kinematics(scene, of)).transpose()?;
    Ok(given.map_or(rolling, |given| RollerInertia { cage_speed: [given.cage_ratio, 0.0], ..rolling }))
}

/// States of rollers.
pub trait RollerStates: Send + Sync {
    /// Writes the state of each roller, up to the length of `states`.
    fn roller_states(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>, states: &mut [RollerState<f64>]);

    /// Writes the loads of the laminae of a roller at the inner race, N, in the order of +Z.
    fn lamina_loads(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>, index: usize, loads: &mut [f64]);
}

macro_rules! roller_states {
    ($kind:ident) => {
        impl<M: Math<f64>, P: ElementLayout<f64>, A: AsRef<[Lamina<f64>]> + Send + Sync, S: Surface<f64>> RollerStates
            for $kind<f64, M, P, A, S>
        {
            fn roller_states(
                &self,
                u: &Displacement<f64>,
                at: &BearingKinematicState<f64>,
                states: &mut [RollerState<f64>],
            ) {
                $kind::roller_states(self, u, at, states);
            }
            fn lamina_loads(
                &self,
                u: &Displacement<f64>,
                at: &BearingKinematicState<f64>,
                index: usize,
                loads: &mut [f64],
            ) {
                $kind::lamina_loads(self, u, at, index, loads);
            }
        }
    };
}
roller_states!(LaminaRoller);
roller_states!(QuasiStaticRoller);

/// Rollers of a bearing that faces -Z.
struct MirroredRollers(Box<dyn RollerStates>);

impl RollerStates for MirroredRollers {
    fn roller_states(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>, states: &mut [RollerState<f64>]) {
        self.0.roller_states(&u.mirrored(), &at.reversed(), states);
        for state in states {
            state.inner.moment = -state.inner.moment;
            state.outer.moment = -state.outer.moment;
            state.tilt = -state.tilt;
        }
    }
    fn lamina_loads(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>, index: usize, loads: &mut [f64]) {
        self.0.lamina_loads(&u.mirrored(), &at.reversed(), index, loads);
        loads.reverse();
    }
}

/// Two rows of rollers.
struct TwoRows([Box<dyn RollerStates>; 2], usize);

impl RollerStates for TwoRows {
    fn roller_states(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>, states: &mut [RollerState<f64>]) {
        let Self([first, second], count) = self;
        let (near, far) = states.split_at_mut((*count).min(states.len()));
        first.roller_states(u, at, near);
        second.roller_states(u, at, far);
    }
    fn lamina_loads(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>, index: usize, loads: &mut [f64]) {
        let Self([first, second], count) = self;
        match index.checked_sub(*count) {
            None => first.lamina_loads(u, at, index, loads),
            Some(index) => second.lamina_loads(u, at, index, loads),
        }
    }
}

/// Rollers of a bearing in all rows.
pub struct BearingRollers {
    /// Number of rollers.
    pub count: usize,
    /// States of the rollers.
    pub states: Box<dyn RollerStates>,
}

/// Returns the rollers of a bearing; `None` for a bearing whose model has no rollers by laminae.
///
/// # Errors
/// Returns an error if the scene lacks a value of the model or the kernel rejects one.
pub fn roller_states(scene: &Scene, of: &BearingScene) -> Result<Option<BearingRollers>, BuildError> {
    let model = of.evaluated_model();
    let Some(rollers) = of.rollers.as_ref().filter(|_| matches!(model, Model::Roller | Model::QuasiStaticRoller))
    else {
        return Ok(None);
    };
    let row = |direction| -> Result<Box<dyn RollerStates>, BuildError> {
        type Wide = OnWideRegisters<Exact>;
        let row = Row::<f64, Wide>::new(of, direction)?;
        let features: Vec<Feature<f64>> = crate::construction::features(of);
        let row = row.with_surface(SurfaceDeviation::<Wide, _>::new(features));
        if model == Model::Roller {
            return Ok(Box::new(row));
        }
        let solved = QuasiStaticRoller::try_new(row, &inertia(scene, of)?).map_err(|error| named(of, error))?;
        Ok(Box::new(solved))
    };
    let (count, states): (usize, Box<dyn RollerStates>) = if rollers.kind.rows() > 1 {
        (2 * of.elements, Box::new(TwoRows([row(1.0)?, row(-1.0)?], of.elements)))
    } else {
        (of.elements, row(1.0)?)
    };
    let states = if of.facing == Facing::MinusZ { Box::new(MirroredRollers(states)) } else { states };
    Ok(Some(BearingRollers { count, states }))
}
