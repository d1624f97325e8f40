//! Model `tabulated`: the quasi-static model from a table of spline coefficients.

use crate::bearing::{Bearing, Model};
use crate::model::{BlobArray, Constants};
use crate::pointer;
use ballrace::bearing::ElementPosition;
use ballrace::bearing::quasi_static::TableConstants;
use ballrace::bearing::tabulated::{Grid, Node, Table};
use ballrace::bearing::{CageFrame, Reaction};
use ballrace::{BearingKinematicState, Displacement, Exact};

/// One coordinate of the grid of a table.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Number of nodes.
    pub count: u32,
    /// Coordinate of node 0.
    pub origin: f32,
    /// Nodes per unit.
    pub density: f32,
    /// Least coordinate of the domain.
    pub least: f32,
    /// Greatest coordinate of the domain.
    pub greatest: f32,
}

/// A ball bearing with interpolated ball forces. `ballrace bake --language c` writes it.
///
/// Models: `ballrace_tabulated_model` (two numbers per node), `ballrace_tabulated_friction_model` (three numbers per node,
/// with friction at the inner race), each also `mirrored` for a bearing that carries thrust towards -Z.
///
/// A table over several speeds needs `ballrace_force_at`: `ballrace_force` evaluates it at speed 0 and reports
/// `BALLRACE_OUT_OF_TABLE`, unless the domain contains 0.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Tabulated {
    /// Head.
    pub head: Bearing,
    /// Lever of the friction couple divided by the lever arm.
    pub couple: f32,
    /// A, distance of the groove centres with the rings just touching the balls, m.
    pub distance: f32,
    /// Cosine of the angle of the line of groove centres with the rings just touching the ball.
    pub axis_cos: f32,
    /// Sine of that angle.
    pub axis_sin: f32,
    /// Radial displacement of the inner groove centres at zero displacement, m.
    pub offset: f32,
    /// R_i, lever arm, m.
    pub arm: f32,
    /// Approach up to which the nodes are close, m.
    pub scale: f32,
    /// b, rad/s.
    pub speed_scale: f32,
    /// Axis of the coordinate of the approach, `sqrt(|e| / (|e| + scale))` with the sign of `e = s (1 + s / (2 distance))`, `s` the
    /// approach; varies fastest.
    pub approach: Axis,
    /// Axis of the sine of the angle of the line of groove centres.
    pub angle: Axis,
    /// Axis of the coordinate of the speed `w`, `w (w + speed_scale)`, (rad/s)^2; varies slowest.
    pub speed: Axis,
    /// 1 if the table is over the speed of the outer ring, 0 for the inner ring.
    pub by_outer_speed: u32,
    /// Number of nodes: the product of the counts of the axes.
    pub node_count: u32,
    /// Nodes, each of two or three numbers: half of the load along the line of groove centres over `(|e| + scale)^1.5` in
    /// N/m^1.5, tangent of the angle from that line to the contact, and, in a model with friction, the friction at the inner
    /// race across that line in N.
    pub nodes: *const f32,
}

impl From<&Axis> for ballrace::bearing::tabulated::Axis<f32> {
    #[inline(always)]
    fn from(axis: &Axis) -> Self {
        let Axis { count, origin, density, least, greatest } = *axis;
        Self { count: count as usize, origin, density, range: [least, greatest] }
    }
}

/// Constants with `F` numbers per node.
#[repr(transparent)]
pub(crate) struct WithFields<const F: usize>(Tabulated);

// SAFETY: `repr(transparent)` over a `repr(C)` struct with the head first.
unsafe impl<const F: usize> Constants for WithFields<F> {
    type Bearing<'a> =
        ballrace::bearing::tabulated::Tabulated<f32, Exact, &'a [ElementPosition<f32>], &'a [Node<f32, F>], F>;

    const USES_SPEED: bool = true;

    const WORDS: u32 = 25;
    const ARRAY: Option<BlobArray> =
        Some(BlobArray { offset: core::mem::offset_of!(Tabulated, nodes), numbers: F as u32 });

    #[inline(always)]
    unsafe fn bearing(&self) -> Self::Bearing<'_> {
        let of = &self.0;
        // SAFETY: the pointers are valid by the contract of the function.
        let (positions, nodes) =
            unsafe { (of.head.positions(), pointer::slice(of.nodes.cast::<Node<f32, F>>(), of.node_count)) };
        let constants = TableConstants {
            couple: of.couple,
            distance: of.distance,
            axis: [of.axis_cos, of.axis_sin],
            offset: of.offset,
            arm: of.arm,
        };
        let grid = Grid {
            scale: of.scale,
            speed_scale: of.speed_scale,
            approach: (&of.approach).into(),
            angle: (&of.angle).into(),
            speed: (&of.speed).into(),
        };
        let by_outer = of.by_outer_speed != 0;
        ballrace::bearing::tabulated::Tabulated::new(positions, constants, Table::new(grid, nodes), by_outer)
    }

    #[inline(always)]
    fn reaction(bearing: &Self::Bearing<'_>, u: &Displacement<f32>, at: &BearingKinematicState<f32>) -> Reaction<f32> {
        bearing.reaction_inlined(u, at)
    }
}

/// The bearing of the kernel with `F` numbers per node.
pub(crate) type OfKernel<'a, const F: usize> = <WithFields<F> as Constants>::Bearing<'a>;

impl Tabulated {
    /// Returns the bearing of the kernel.
    ///
    /// # Safety
    /// The pointers are valid, and the nodes have `F` numbers.
    pub(crate) unsafe fn of_kernel<const F: usize>(&self) -> OfKernel<'_, F> {
        // SAFETY: by the contract of the function; `repr(transparent)`.
        unsafe { (*core::ptr::from_ref(self).cast::<WithFields<F>>()).bearing() }
    }
}

/// Model of `ballrace_tabulated` with two numbers per node.
#[unsafe(no_mangle)]
pub static ballrace_tabulated_model: Model = Model::of::<WithFields<2>>();

/// As `ballrace_tabulated_model` for a bearing that carries thrust towards -Z.
#[unsafe(no_mangle)]
pub static ballrace_tabulated_mirrored_model: Model = Model::mirrored::<WithFields<2>>();

/// Model of `ballrace_tabulated` with three numbers per node: with friction at the inner race.
#[unsafe(no_mangle)]
pub static ballrace_tabulated_friction_model: Model = Model::of::<WithFields<3>>();

/// As `ballrace_tabulated_friction_model` for a bearing that carries thrust towards -Z.
#[unsafe(no_mangle)]
pub static ballrace_tabulated_friction_mirrored_model: Model = Model::mirrored::<WithFields<3>>();
